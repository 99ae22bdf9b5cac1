// SPDX-License-Identifier: MIT OR Apache-2.0
// Smith's height-correlated masking and shadowing. Rust twin: src/term/visibility/smith.rs.

#include "lib/directions.glsl"
#define KINKS 0
#define AZIMUTH_NODES NODES_10

// G / n_dot_v with G = 1 / (1 + Lambda(l) + Lambda(v)), Heitz 2014, Eq. 99; sigma_x = n_dot_x (1 + Lambda(x)).
float g_over_n_dot_v(Directions d) {
    return d.n_dot_l / (d.sigma_l * d.n_dot_v + (d.sigma_v - d.n_dot_v) * d.n_dot_l);
}
