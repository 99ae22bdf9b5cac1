// SPDX-License-Identifier: MIT OR Apache-2.0
//! Schlick's approximation, split into what F0, F90 and an edge tint are multiplied with.

use super::{Optics, Term, Weights};

/// Registry entry.
pub static SCHLICK: Term = Term {
    name: "schlick",
    about: "Schlick's split, F0 (1 - w) + F90 w with w = (1 - v.h)^5, and the F82 tint's v.h (1 - v.h)^6",
    source: "Schlick 1994, Eq. 15; Kutz, Hasan, Edmondson 2021, Novel Aspects of the Adobe Standard Material",
    file: Some("schlick"),
    weights,
    kink: None,
    azimuth: None,
    breaks: None,
};

/// 1, the weight of F90 and the weight of the tint, c (1 − c)⁶. GLSL twin `shaders/term/fresnel/schlick.glsl`.
///
/// F82 tint: F(c) = F0 + (1 − F0)(1 − c)⁵ − b c (1 − c)⁶. The last term is largest at c = 1/7, about 82°, where the
/// reflectance is to be `tint` times Schlick's; so b = (1 − tint) (F0 + (1 − F0) (6/7)⁵)/((1/7) (6/7)⁶).
pub fn weights(v_dot_h: f64, _optics: &Optics) -> Weights {
    let m = 1.0 - v_dot_h;
    let schlick = schlick_weight(m);
    [1.0, schlick, v_dot_h * m * schlick, 0.0]
}

/// The cosine at which the F82 tint is largest.
pub const F82_COS: f64 = 1.0 / 7.0;

/// Schlick's weight (1 − v·h)⁵ from m = 1 − v·h. Schlick 1994, Eq. 15: F = F0 + (F90 − F0)·weight.
/// Domain: m in [0, 1]. GLSL twin `shaders/term/fresnel/schlick.glsl`.
pub fn schlick_weight(m: f64) -> f64 {
    let m2 = m * m;
    m2 * m2 * m
}
