//! Smith's height-correlated masking and shadowing.

use super::Visibility;
use crate::rule::cone::cone;

/// Registry entry.
pub static SMITH: Visibility = Visibility {
    name: "smith",
    about: "Smith, height-correlated: masking and shadowing know that both see the same height",
    source: "Heitz 2014, Eq. 99",
    file: "smith",
    cone: |n_dot_v, alpha| cone(n_dot_v, alpha, g_over_n_dot_v),
    g_over_n_dot_v: |d| g_over_n_dot_v(d.n_dot_l, d.n_dot_v, d.sigma_l, d.sigma_v),
};

/// G/(n·v) with G = 1/(1 + Λ(l) + Λ(v)) (Heitz 2014, Eq. 99) written with sigma = n·x (1 + Λ), which stays finite at
/// grazing. Domain: n_dot_l, n_dot_v in [0, 1], sigma_x ≥ n_dot_x. GLSL twin `shaders/term/visibility/smith.glsl`.
pub fn g_over_n_dot_v(n_dot_l: f64, n_dot_v: f64, sigma_l: f64, sigma_v: f64) -> f64 {
    n_dot_l / (sigma_l * n_dot_v + (sigma_v - n_dot_v) * n_dot_l)
}
