// SPDX-License-Identifier: MIT OR Apache-2.0
//! Smith's height-correlated masking and shadowing.

use super::{Bounded, Directions, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static SMITH: Visibility = Visibility {
    name: "smith",
    about: "Smith, height-correlated: masking and shadowing know that both see the same height",
    source: "Heitz 2014, Eq. 99",
    file: "smith",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Always,
    smith: true,
    kinks: None,
    outer: 22,
    crowd: 1,
    azimuth: 10,
    crowd_horizon: false,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with G = 1/(1 + Λ(l) + Λ(v)) (Heitz 2014, Eq. 99) written with sigma = n·x (1 + Λ), which stays finite at
/// grazing. Domain: n_dot_l, n_dot_v in [0, 1], sigma_x ≥ n_dot_x.
/// GLSL twin `shaders/term/visibility/smith.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    d.n_dot_l / (d.sigma_l * d.n_dot_v + (d.sigma_v - d.n_dot_v) * d.n_dot_l)
}
