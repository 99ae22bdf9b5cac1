// Smith's separable masking and shadowing. Rust twin: src/term/visibility/smith_uncorrelated.rs.

// G / n_dot_v with G = G1(l) G1(v), Walter et al. 2007, Eq. 23; sigma_x = n_dot_x (1 + Lambda(x)). n_dot_v cancels.
float g_over_n_dot_v(float n_dot_l, float n_dot_v, float sigma_l, float sigma_v) {
    return n_dot_l / (sigma_l * sigma_v);
}
