// SPDX-License-Identifier: MIT OR Apache-2.0
//! Smith's separable masking and shadowing.

use super::{Bounded, Directions, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static SMITH_UNCORRELATED: Visibility = Visibility {
    name: "smith-uncorrelated",
    about: "Smith, separable: masking times shadowing, darker than `smith` at grazing angles",
    source: "Walter, Marschner, Li, Torrance 2007, Eq. 23; Heitz 2014, Eq. 98",
    file: "smith_uncorrelated",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Always,
    smith: true,
    kinks: None,
    outer: 26,
    crowd: 1,
    azimuth: 10,
    crowd_horizon: false,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with G = G1(l) G1(v), G1 = 1/(1 + Λ) (Walter et al. 2007, Eq. 23), written with sigma = n·x (1 + Λ), so that
/// n·v cancels. Domain: n_dot_l in [0, 1], sigma_x ≥ n_dot_x.
/// GLSL twin `shaders/term/visibility/smith_uncorrelated.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    d.n_dot_l / (d.sigma_l * d.sigma_v)
}
