// SPDX-License-Identifier: MIT OR Apache-2.0
// Neumann's geometry term. Rust twin: src/term/visibility/neumann.rs.

#include "lib/directions.glsl"
#define KINKS 1
#define AZIMUTH_NODES NODES_8

// G / n_dot_v with G = n_dot_l n_dot_v / max(n_dot_l, n_dot_v).
float g_over_n_dot_v(Directions d) {
    return d.n_dot_l / max(d.n_dot_l, d.n_dot_v);
}

// Cosines of the azimuth between h and v where n_dot_l = n_dot_v; 1 for none.
vec2 kinks(float tan_h, float n_dot_v, float sin_v, float alpha) {
    return vec2(n_dot_v * tan_h / sin_v, 1.0);
}
