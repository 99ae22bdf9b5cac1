// SPDX-License-Identifier: MIT OR Apache-2.0
//! What F90 is multiplied with in a generalised Schlick term.

use super::{Optics, Term, Weights};

/// Registry entry.
pub static POWER: Term = Term {
    name: "power",
    about: "weight of F90 in F0 (1 - w) + F90 w of a generalised Schlick term, w = (1 - v.h)^exponent (--exponent)",
    source: "Blender Cycles, kernel/closure/bsdf_microfacet.h (generalized Schlick); MaterialX generalized_schlick_bsdf",
    file: None,
    weights,
    kink: None,
    azimuth: None,
    breaks: Some(breaks),
};

/// 1 and (1 − v·h) to the exponent; of an infinite one 0, and 1 where v·h is 0. Host only.
pub fn weights(v_dot_h: f64, optics: &Optics) -> Weights {
    [1.0, (1.0 - v_dot_h).max(0.0).powf(optics.given[0]), 0.0, 0.0]
}

/// A large exponent leaves little but a layer of v·h below its inverse.
fn breaks(optics: &Optics) -> Vec<f64> {
    let exponent = optics.given[0];
    if exponent > 8.0 { vec![2.0 / exponent, 8.0 / exponent] } else { vec![] }
}
