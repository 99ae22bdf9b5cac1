// SPDX-License-Identifier: MIT OR Apache-2.0
//! Kelemen's and Szirmay-Kalos's approximation of V-cavities.

use super::{Bounded, Directions, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static KELEMEN: Visibility = Visibility {
    name: "kelemen",
    about: "Kelemen and Szirmay-Kalos: V = 1/(4 (l.h)^2), a cheap stand-in for V-cavities",
    source: "Kelemen, Szirmay-Kalos 2001, A Microfacet Based Coupled Specular-Matte BRDF Model",
    file: "kelemen",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    // n·l/(v·h) ≤ 2 n·h, and at grazing, where that is reached, half of the facets are in sight.
    bounded: Bounded::Always,
    smith: false,
    kinks: None,
    outer: 22,
    crowd: 2,
    azimuth: 12,
    crowd_horizon: true,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with V = 1/(4 (v·h)²), so n·l/(v·h)². Where v·h = 0 so is n·l: the limit is taken as 0.
/// GLSL twin `shaders/term/visibility/kelemen.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    let cos2 = d.v_dot_h * d.v_dot_h;
    if cos2 > 0.0 { d.n_dot_l / cos2 } else { 0.0 }
}
