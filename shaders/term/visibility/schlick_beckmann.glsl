// SPDX-License-Identifier: MIT OR Apache-2.0
// Schlick's approximation of Smith's separable term, k = alpha sqrt(2/pi). Rust twin: src/term/visibility/schlick_beckmann.rs.

#include "lib/directions.glsl"
#define KINKS 0
#define AZIMUTH_NODES NODES_14_FAR

// G / n_dot_v with G = G1(l) G1(v), Schlick 1994, Eq. 19, k = alpha sqrt(2/pi). n_dot_v cancels.
float g_over_n_dot_v(Directions d) {
    float k = d.alpha * 0.797884560802865;
    return d.n_dot_l / ((d.n_dot_v * (1.0 - k) + k) * (d.n_dot_l * (1.0 - k) + k));
}
