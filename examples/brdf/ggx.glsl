// SPDX-License-Identifier: MIT OR Apache-2.0
// GGX with height-correlated Smith masking (Walter et al. 2007, Heitz 2014), as a distribution and a visibility: the
// BRDF is D V.

const float PI = 3.14159265358979;

// Trowbridge-Reitz, per steradian.
float D(float n_dot_h, float alpha) {
    float a2 = alpha * alpha;
    float f = (n_dot_h * a2 - n_dot_h) * n_dot_h + 1.0;
    return a2 / (PI * f * f);
}

// G / (4 n_dot_v n_dot_l).
float V(float n_dot_v, float n_dot_l, float alpha) {
    float a2 = alpha * alpha;
    float lambda_v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    float lambda_l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    return 0.5 / (lambda_v + lambda_l);
}
