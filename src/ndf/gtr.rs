// SPDX-License-Identifier: MIT OR Apache-2.0
//! Generalised Trowbridge–Reitz: GGX with a free tail.

use std::f64::consts::PI;

use super::{Family, Flat, Lobe, Parameter, bell};

/// Registry entry.
pub static GTR: Family = Family {
    name: "gtr",
    also: &[],
    about: "generalised Trowbridge-Reitz: gamma sets the tail; 2 is ggx, 1 is Berry",
    source: "Burley 2012, Physically-Based Shading at Disney, appendix B, Eq. 1, 2 and 4",
    parameters: &[Parameter { name: "gamma", about: "power of the tail", range: [0.5, 10.0], required: true }],
    // `shape` is gamma, L = −2 ln alpha and K.
    lobe: |alpha, given| {
        let (gamma, l) = (given[0].unwrap_or(2.0), -2.0 * alpha.ln());
        let k = if l < FLAT { 1.0 / PI } else { -(-l).exp_m1() / (PI * norm(gamma, l)) };
        Lobe { alpha, peak: alpha, shape: [gamma, l, k] }
    },
    d,
    sigma: None,
    flat: Flat { tan, y, density: |y, _, _| bell(y), y_max: 6.0, falling: false },
};

/// Below this alpha is 1 as far as the formulas can tell: D = 1/π for every gamma.
const FLAT: f64 = 1e-9;

/// ∫ w^(−gamma) dw from alpha² to 1, the norm of w^(−gamma): ((1/alpha²)^(gamma − 1) − 1)/(gamma − 1), or L for gamma 1.
fn norm(gamma: f64, l: f64) -> f64 {
    if gamma == 1.0 { l } else { ((gamma - 1.0) * l).exp_m1() / (gamma - 1.0) }
}

/// D(h) = K/w^gamma per steradian, w = sin² + alpha² cos². Burley 2012, appendix B, Eq. 1; K from ∫ D n_dot_h dh = 1.
fn d(cos2: f64, sin2: f64, lobe: &Lobe) -> f64 {
    let [gamma, _, k] = lobe.shape;
    k * (sin2 + lobe.alpha * lobe.alpha * cos2).powf(-gamma)
}

/// tan² = (w − alpha²)/(1 − w), where the share of steeper facets is V = ∫_w^1/∫_(alpha²)^1 w^(−gamma) dw.
fn tan(y: f64, lobe: &Lobe) -> f64 {
    let [gamma, l, _] = lobe.shape;
    let u = -(-y * y).exp_m1();
    let v = (-y * y).exp();
    if l < FLAT {
        return (y * y).exp_m1().sqrt();
    }
    // ln w and ln(w/alpha²), each from the end that it is near to.
    let (ln_w, ln_ratio) = if gamma == 1.0 {
        (-l * v, l * u)
    } else {
        let x = ((gamma - 1.0) * l).exp_m1();
        let near_horizon = (v * x).ln_1p() / (1.0 - gamma);
        let ratio = if v < 0.5 { near_horizon + l } else { (-u * x / (1.0 + x)).ln_1p() / (1.0 - gamma) };
        (near_horizon, ratio)
    };
    ((-l).exp() * ln_ratio.exp_m1() / -ln_w.exp_m1()).sqrt()
}

/// The inverse of [`tan`].
fn y(tan: f64, lobe: &Lobe) -> f64 {
    let [gamma, l, _] = lobe.shape;
    let t2 = tan * tan;
    if l < FLAT {
        return t2.ln_1p().sqrt();
    }
    let (a2, b2) = ((-l).exp(), -(-l).exp_m1());
    let cos2 = 1.0 / (1.0 + t2);
    // 1 − w = b² cos², w/alpha² = 1 + b² sin²/alpha².
    let ln_w = (-b2 * cos2).ln_1p();
    let ln_ratio = (b2 * t2 * cos2 / a2).ln_1p();
    let (v, u) = if gamma == 1.0 {
        (-ln_w / l, ln_ratio / l)
    } else {
        let x = ((gamma - 1.0) * l).exp_m1();
        (((1.0 - gamma) * ln_w).exp_m1() / x, -((1.0 - gamma) * ln_ratio).exp_m1() * (1.0 + x) / x)
    };
    if u < 0.5 { (-(-u).ln_1p()).max(0.0).sqrt() } else { (-v.max(1e-300).ln()).max(0.0).sqrt() }
}
