// SPDX-License-Identifier: MIT OR Apache-2.0
//! Schlick's approximation of Smith's separable term, k = (roughness + 1)^2/8.

use super::{Bounded, Directions, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static SCHLICK_DIRECT: Visibility = Visibility {
    name: "schlick-direct",
    about: "Schlick's approximation for lamps, k = (roughness + 1)^2/8",
    source: "Karis 2013, Real Shading in Unreal Engine 4, Eq. 4",
    file: "schlick_direct",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Unless(&["charlie", "gtr", "abc"]),
    smith: false,
    kinks: None,
    outer: 24,
    crowd: 1,
    azimuth: 10,
    crowd_horizon: false,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with G = G1(l) G1(v), G1(x) = n·x/(n·x (1 − k) + k) (Schlick 1994, Eq. 19), k = (roughness + 1)²/8 (Karis 2013, for
/// lamps), roughness = √alpha; n·v cancels.
/// Domain: n_dot_x in [0, 1], alpha in (0, 1].
/// GLSL twin `shaders/term/visibility/schlick_direct.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    let k = 0.125 * (d.alpha.sqrt() + 1.0).powi(2);
    d.n_dot_l / ((d.n_dot_v * (1.0 - k) + k) * (d.n_dot_l * (1.0 - k) + k))
}
