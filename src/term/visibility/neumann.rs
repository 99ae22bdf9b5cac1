// SPDX-License-Identifier: MIT OR Apache-2.0
//! Neumann's geometry term.

use super::{Bounded, Directions, Kinks, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static NEUMANN: Visibility = Visibility {
    name: "neumann",
    about: "Neumann: G = (n.l)(n.v)/max(n.l, n.v)",
    source: "Neumann, Neumann, Szirmay-Kalos 1999, Compact Metallic Reflectance Models",
    file: "neumann",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Unless(&["charlie"]),
    smith: false,
    kinks: Some(Kinks {
        azimuth: kinks,
        tan_h: |theta_v, _| vec![theta_v.tan()],
        n_dot_l: |_| None,
        light_azimuth: None,
    }),
    outer: 18,
    crowd: 1,
    azimuth: 8,
    crowd_horizon: false,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with G = (n·l)(n·v)/max(n·l, n·v); it is 1 at n·v = 0.
/// GLSL twin `shaders/term/visibility/neumann.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    d.n_dot_l / d.n_dot_l.max(d.n_dot_v)
}

/// Where G has a kink, n·l = n·v: cosines of the azimuth between h and v, from t = tan θ_h and the sine of v; 1 for none.
pub fn kinks(tan_h: f64, n_dot_v: f64, sin_v: f64, _alpha: f64) -> [f64; 2] {
    [n_dot_v * tan_h / sin_v, 1.0]
}
