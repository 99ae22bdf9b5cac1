// SPDX-License-Identifier: MIT OR Apache-2.0
// Walter's rational approximation of Beckmann's separable Smith term. Rust twin: src/term/visibility/beckmann_rational.rs.

#include "lib/directions.glsl"
#define KINKS 1
#define AZIMUTH_NODES NODES_10

// G1 / n_dot_x, Walter et al. 2007, Eq. 27, with z = cot / alpha.
float g1_over_n_dot_x(float n_dot_x, float alpha) {
    float width = alpha * sqrt(max((1.0 - n_dot_x) * (1.0 + n_dot_x), 0.0));
    float z = n_dot_x / max(width, 1e-30);
    float fit = (3.535 + 2.181 * z) / (max(width, 1e-30) * (1.0 + 2.276 * z + 2.577 * z * z));
    return n_dot_x >= 1.6 * width ? 1.0 / n_dot_x : fit;
}

// n_dot_x of the jump, z = 1.6.
float jump(float alpha) {
    return 1.6 * alpha * inversesqrt(1.0 + 2.56 * alpha * alpha);
}

// G / n_dot_v with G = G1(l) G1(v).
float g_over_n_dot_v(Directions d) {
    return d.n_dot_l * g1_over_n_dot_x(d.n_dot_l, d.alpha) * g1_over_n_dot_x(d.n_dot_v, d.alpha);
}

// Cosines of the azimuth between h and v where n_dot_l is at the jump; 1 for none.
vec2 kinks(float tan_h, float n_dot_v, float sin_v, float alpha) {
    return vec2((0.5 * (n_dot_v + jump(alpha)) * (1.0 + tan_h * tan_h) - n_dot_v) / (tan_h * sin_v), 1.0);
}
