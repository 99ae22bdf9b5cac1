// SPDX-License-Identifier: MIT OR Apache-2.0
//! Schlick's approximation of Smith's separable term, k = alpha sqrt(2/pi).

use super::{Bounded, Directions, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static SCHLICK_BECKMANN: Visibility = Visibility {
    name: "schlick-beckmann",
    about: "Schlick's approximation fitted to Beckmann, k = alpha sqrt(2/pi)",
    source: "Schlick 1994, Eq. 19",
    file: "schlick_beckmann",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Unless(&["charlie", "gtr", "abc"]),
    smith: false,
    kinks: None,
    outer: 24,
    crowd: 1,
    azimuth: 14,
    crowd_horizon: true,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with G = G1(l) G1(v), G1(x) = n·x/(n·x (1 − k) + k) (Schlick 1994, Eq. 19), k = alpha √(2/π); n·v cancels.
/// Domain: n_dot_x in [0, 1], alpha in (0, 1].
/// GLSL twin `shaders/term/visibility/schlick_beckmann.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    let k = d.alpha * (2.0 / std::f64::consts::PI).sqrt();
    d.n_dot_l / ((d.n_dot_v * (1.0 - k) + k) * (d.n_dot_l * (1.0 - k) + k))
}
