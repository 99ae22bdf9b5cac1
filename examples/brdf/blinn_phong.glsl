// SPDX-License-Identifier: MIT OR Apache-2.0
// Blinn-Phong with the implicit geometry term, V = 1/4. The exponent that has GGX's width is 2 / alpha^2 - 2 (Walter et al.
// 2007, section 5.2).

float D(float n_dot_h, float alpha) {
    float a2 = alpha * alpha;
    return pow(n_dot_h, 2.0 / a2 - 2.0) / (3.14159265358979 * a2);
}

float V(float n_dot_v, float n_dot_l, float alpha) {
    return 0.25;
}
