//! Smith's separable masking and shadowing.

use super::Visibility;
use crate::rule::cone::cone;

/// Registry entry.
pub static SMITH_UNCORRELATED: Visibility = Visibility {
    name: "smith-uncorrelated",
    about: "Smith, separable: masking times shadowing, darker than `smith` at grazing angles",
    source: "Walter, Marschner, Li, Torrance 2007, Eq. 23; Heitz 2014, Eq. 98",
    file: "smith_uncorrelated",
    cone: |n_dot_v, alpha| cone(n_dot_v, alpha, g_over_n_dot_v),
    g_over_n_dot_v: |d| g_over_n_dot_v(d.n_dot_l, d.n_dot_v, d.sigma_l, d.sigma_v),
};

/// G/(n·v) with G = G1(l) G1(v), G1 = 1/(1 + Λ) (Walter et al. 2007, Eq. 23), written with sigma = n·x (1 + Λ).
/// Domain: n_dot_l, n_dot_v in [0, 1], sigma_x ≥ n_dot_x. `_n_dot_v` cancels; it stays so that all geometry terms share
/// a signature. GLSL twin `shaders/term/visibility/smith_uncorrelated.glsl`.
pub fn g_over_n_dot_v(n_dot_l: f64, _n_dot_v: f64, sigma_l: f64, sigma_v: f64) -> f64 {
    n_dot_l / (sigma_l * sigma_v)
}
