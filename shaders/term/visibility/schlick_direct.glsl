// SPDX-License-Identifier: MIT OR Apache-2.0
// Schlick's approximation of Smith's separable term, k = (roughness + 1)^2/8. Rust twin: src/term/visibility/schlick_direct.rs.

#include "lib/directions.glsl"
#define KINKS 0
#define AZIMUTH_NODES NODES_10

// G / n_dot_v with G = G1(l) G1(v), Schlick 1994, Eq. 19, k = (roughness + 1)^2/8. n_dot_v cancels.
float g_over_n_dot_v(Directions d) {
    float k = 0.125 * (sqrt(d.alpha) + 1.0) * (sqrt(d.alpha) + 1.0);
    return d.n_dot_l / ((d.n_dot_v * (1.0 - k) + k) * (d.n_dot_l * (1.0 - k) + k));
}
