// SPDX-License-Identifier: MIT OR Apache-2.0
//! Phong's lobe about the normal, used with half vectors: Blinn–Phong.

use std::f64::consts::PI;

use super::{Family, Flat, Lobe, Parameter, bell};

/// Registry entry.
pub static BLINN_PHONG: Family = Family {
    name: "blinn-phong",
    also: &["phong"],
    about: "Blinn-Phong: a power of n.h, exponent 2/alpha^2 - 2 matches Beckmann's width",
    source: "Blinn 1977; Walter, Marschner, Li, Torrance 2007, Eq. 30",
    parameters: &[Parameter {
        name: "exponent",
        about: "the power of n.h; the roughness axis is then without effect",
        range: [0.0, 1e8],
        required: false,
    }],
    // `shape[0]` is 2/(exponent + 2): alpha², kept when the exponent is given.
    lobe: |alpha, given| {
        let a2 = given[0].map_or(alpha * alpha, |exponent| 2.0 / (exponent + 2.0));
        Lobe { alpha: a2.sqrt(), peak: a2.sqrt(), shape: [a2, 0.0, 0.0] }
    },
    d,
    sigma: None,
    // The share of steeper facets is cos^(exponent + 2).
    flat: Flat {
        tan: |y, lobe| (lobe.shape[0] * y * y).exp_m1().sqrt(),
        y: |tan, lobe| ((tan * tan).ln_1p() / lobe.shape[0]).sqrt(),
        density: |y, _, _| bell(y),
        y_max: 5.5,
        falling: false,
    },
};

/// D(h) = (n + 2)/(2π) cosⁿ per steradian, n = 2/alpha² − 2. Walter et al. 2007, Eq. 30.
fn d(cos2: f64, sin2: f64, lobe: &Lobe) -> f64 {
    let a2 = lobe.shape[0];
    // cos² near 1 is known better from sin².
    let ln_cos2 = if sin2 < 0.5 { (-sin2).ln_1p() } else { cos2.ln() };
    let half_exponent = 1.0 / a2 - 1.0;
    let power = if half_exponent == 0.0 { 1.0 } else { (half_exponent * ln_cos2).exp() };
    power / (PI * a2)
}
