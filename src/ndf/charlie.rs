// SPDX-License-Identifier: MIT OR Apache-2.0
//! Charlie: fibres that stand up, for cloth.

use std::f64::consts::PI;

use super::{Family, Flat, Lobe, bell};

/// Registry entry.
pub static CHARLIE: Family = Family {
    name: "charlie",
    also: &[],
    about: "Charlie: a power of sin, the sheen of cloth; facets stand upright",
    source: "Estevez, Kulla 2017, Production Friendly Microfacet Sheen BRDF, Eq. 2",
    parameters: &[],
    // `shape[0]` is p = 2 + 1/alpha: the share of facets less steep than θ is sin^p.
    lobe: |alpha, _| Lobe { alpha, peak: 0.5, shape: [2.0 + 1.0 / alpha, 0.0, 0.0] },
    d,
    sigma: None,
    flat: Flat {
        tan: |y, lobe| 1.0 / (2.0 * y * y / lobe.shape[0]).exp_m1().sqrt(),
        y: |tan, lobe| (0.5 * lobe.shape[0] * (1.0 / (tan * tan)).ln_1p()).sqrt(),
        density: |y, _, _| bell(y),
        y_max: 5.0,
        falling: true,
    },
};

/// D(h) = (2 + 1/alpha) sin^(1/alpha)/(2π) per steradian. Estevez, Kulla 2017, Eq. 2.
fn d(cos2: f64, sin2: f64, lobe: &Lobe) -> f64 {
    let p = lobe.shape[0];
    if sin2 == 0.0 {
        return 0.0;
    }
    let ln_sin2 = if cos2 < 0.5 { (-cos2).ln_1p() } else { sin2.ln() };
    p / (2.0 * PI) * (0.5 * (p - 2.0) * ln_sin2).exp()
}
