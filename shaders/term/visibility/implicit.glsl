// SPDX-License-Identifier: MIT OR Apache-2.0
// The implicit geometry term. Rust twin: src/term/visibility/implicit.rs.

#include "lib/directions.glsl"
#define KINKS 0
#define AZIMUTH_NODES NODES_8

// G / n_dot_v with G = n_dot_l n_dot_v.
float g_over_n_dot_v(Directions d) {
    return d.n_dot_l;
}
