// SPDX-License-Identifier: MIT OR Apache-2.0
// Smith's separable masking and shadowing. Rust twin: src/term/visibility/smith_uncorrelated.rs.

#include "lib/directions.glsl"
#define KINKS 0
#define AZIMUTH_NODES NODES_10

// G / n_dot_v with G = G1(l) G1(v), Walter et al. 2007, Eq. 23; sigma_x = n_dot_x (1 + Lambda(x)). n_dot_v cancels.
float g_over_n_dot_v(Directions d) {
    return d.n_dot_l / (d.sigma_l * d.sigma_v);
}
