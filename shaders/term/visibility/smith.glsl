// Smith's height-correlated masking and shadowing. Rust twin: src/term/visibility/smith.rs.

// G / n_dot_v with G = 1 / (1 + Lambda(l) + Lambda(v)), Heitz 2014, Eq. 99; sigma_x = n_dot_x (1 + Lambda(x)).
float g_over_n_dot_v(float n_dot_l, float n_dot_v, float sigma_l, float sigma_v) {
    return n_dot_l / (sigma_l * n_dot_v + (sigma_v - n_dot_v) * n_dot_l);
}
