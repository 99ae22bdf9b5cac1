// SPDX-License-Identifier: MIT OR Apache-2.0
//! Total reflection.

use super::{Optics, Term, Weights};

/// Registry entry.
pub static ONE: Term = Term {
    name: "one",
    about: "F = 1: what the distribution and the geometry term alone keep",
    source: "Kulla, Conty 2017, Revisiting Physically Based Shading at Imageworks",
    file: Some("one"),
    weights,
    kink: None,
    azimuth: None,
    breaks: None,
};

/// 1 alone. GLSL twin `shaders/term/fresnel/one.glsl`.
pub fn weights(_v_dot_h: f64, _optics: &Optics) -> Weights {
    [1.0, 0.0, 0.0, 0.0]
}
