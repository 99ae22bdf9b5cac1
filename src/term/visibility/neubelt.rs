// SPDX-License-Identifier: MIT OR Apache-2.0
//! Neubelt's and Pettineo's denominator.

use super::{Bounded, Directions, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static NEUBELT: Visibility = Visibility {
    name: "neubelt",
    about: "Neubelt and Pettineo: soft denominator for cloth",
    source: "Neubelt, Pettineo 2013, Crafting a Next-Gen Material Pipeline for The Order: 1886",
    file: "neubelt",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Never,
    smith: false,
    kinks: None,
    outer: 22,
    crowd: 1,
    azimuth: 10,
    crowd_horizon: false,
    note: Some("neubelt does not conserve energy: its albedo exceeds 1 where facets stand upright"),
    diverges_at_grazing: false,
};

/// G/(n·v) with V = 1/(4 (n·l + n·v − n·l n·v)).
/// GLSL twin `shaders/term/visibility/neubelt.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    d.n_dot_l / (d.n_dot_l + d.n_dot_v - d.n_dot_l * d.n_dot_v)
}
