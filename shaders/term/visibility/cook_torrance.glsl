// SPDX-License-Identifier: MIT OR Apache-2.0
// V-cavities. Rust twin: src/term/visibility/cook_torrance.rs.

#include "lib/directions.glsl"
#define KINKS 2
#define AZIMUTH_NODES NODES_7

// G / n_dot_v with G = min(1, 2 n_dot_h n_dot_v / v_dot_h, 2 n_dot_h n_dot_l / v_dot_h), Cook, Torrance 1982, Eq. 4.
float g_over_n_dot_v(Directions d) {
    float narrow = d.n_dot_l / max(d.n_dot_l, d.n_dot_v);
    return min(1.0 / max(d.n_dot_v, 1e-30), 2.0 * d.n_dot_h * narrow / max(d.v_dot_h, 1e-30));
}

// Cosines of the azimuth between h and v where G has a kink; 1 for none.
vec2 kinks(float tan_h, float n_dot_v, float sin_v, float alpha) {
    float t2 = tan_h * tan_h;
    float scale = n_dot_v / (tan_h * sin_v);
    return t2 < 1.0 ? vec2(scale, scale * (3.0 * t2 - 1.0) / (3.0 - t2)) : vec2(scale * t2, 1.0);
}
