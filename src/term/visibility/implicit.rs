// SPDX-License-Identifier: MIT OR Apache-2.0
//! The implicit geometry term.

use super::{Bounded, Directions, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static IMPLICIT: Visibility = Visibility {
    name: "implicit",
    about: "G = (n.l)(n.v), which cancels the denominator of the BRDF",
    source: "Hoffman 2013, Background: Physics and Math of Shading; Karis 2013, Specular BRDF Reference",
    file: "implicit",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Unless(&["charlie"]),
    smith: false,
    kinks: None,
    outer: 18,
    crowd: 1,
    azimuth: 8,
    crowd_horizon: false,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with G = (n·l)(n·v).
/// GLSL twin `shaders/term/visibility/implicit.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    d.n_dot_l
}
