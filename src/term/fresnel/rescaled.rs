// SPDX-License-Identifier: MIT OR Apache-2.0
//! A dielectric's reflectance, rescaled to run from 0 at normal incidence to 1 at grazing.

use super::dielectric::dielectric;
use super::{Optics, Term, Weights};

/// Registry entry.
pub static RESCALED: Term = Term {
    name: "rescaled",
    about: "weight of F90 in F0 (1 - w) + F90 w that follows an exact dielectric (--ior), w = (F - F(1))/(1 - F(1)), at least 0",
    source: "Blender Cycles, kernel/closure/bsdf_microfacet.h (generalized Schlick with a negative exponent)",
    file: None,
    weights,
    kink: None,
    azimuth: None,
    breaks: Some(breaks),
};

/// Above this index the reflectance dips below that at normal incidence before it rises.
const DIPS_ABOVE: f64 = 2.0 + 1.732_050_807_568_877_2;

/// 1 and (F − F(1))/(1 − F(1)), clamped to 0; F is [`dielectric`]. Without an interface it is 0. Host only.
pub fn weights(v_dot_h: f64, optics: &Optics) -> Weights {
    let eta = optics.given[0];
    if eta == 1.0 {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let normal = dielectric(1.0, eta);
    [1.0, ((dielectric(v_dot_h, eta) - normal) / (1.0 - normal)).max(0.0), 0.0, 0.0]
}

/// Where the clamp starts, and the width of the rise towards grazing, which a large index narrows to its inverse.
fn breaks(optics: &Optics) -> Vec<f64> {
    let eta = optics.given[0];
    if eta <= DIPS_ABOVE {
        return vec![];
    }
    // From 0 to just below normal incidence F falls and crosses F(1) once.
    let (mut low, mut high) = (0.0, 0.999);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if weights(middle, optics)[1] > 0.0 { low = middle } else { high = middle }
    }
    vec![low, 0.2 * low, (2.0 / eta).min(1.0), (8.0 / eta).min(1.0)]
}
