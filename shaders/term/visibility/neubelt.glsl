// SPDX-License-Identifier: MIT OR Apache-2.0
// Neubelt's and Pettineo's denominator. Rust twin: src/term/visibility/neubelt.rs.

#include "lib/directions.glsl"
#define KINKS 0
#define AZIMUTH_NODES NODES_10

// G / n_dot_v with V = 1 / (4 (n_dot_l + n_dot_v - n_dot_l n_dot_v)).
float g_over_n_dot_v(Directions d) {
    return d.n_dot_l / (d.n_dot_l + d.n_dot_v - d.n_dot_l * d.n_dot_v);
}
