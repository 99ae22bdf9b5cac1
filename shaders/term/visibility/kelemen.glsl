// SPDX-License-Identifier: MIT OR Apache-2.0
// Kelemen's and Szirmay-Kalos's approximation of V-cavities. Rust twin: src/term/visibility/kelemen.rs.

#include "lib/directions.glsl"
#define KINKS 0
#define AZIMUTH_NODES NODES_12_FAR

// G / n_dot_v with V = 1 / (4 v_dot_h^2).
float g_over_n_dot_v(Directions d) {
    return d.n_dot_l / max(d.v_dot_h * d.v_dot_h, 1e-30);
}
