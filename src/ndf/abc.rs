// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ABC distribution of optical surfaces, as a distribution of facets.

use std::f64::consts::PI;

use super::{Family, Flat, Lobe, Parameter, bell};

/// Registry entry.
pub static ABC: Family = Family {
    name: "abc",
    also: &[],
    about: "ABC: 1/(1 + a1 (1 - n.h))^a2, as measured on optical surfaces",
    source: "Church, Takacs, Leonard 1990; Low, Kronander, Ynnerman, Unger 2012 (norm: this program's)",
    parameters: &[
        Parameter {
            name: "a1",
            about: "inverse width; 2/alpha^2 unless given, and the roughness axis is then without effect",
            range: [1e-3, 1e9],
            required: false,
        },
        Parameter { name: "a2", about: "power of the tail; 2 is close to ggx", range: [0.25, 10.0], required: true },
    ],
    // `shape` is a1, a2 and K. The alpha of a lobe with the same curvature at its peak is √(2/a1).
    lobe: |alpha, given| {
        let a1 = given[0].unwrap_or(2.0 / (alpha * alpha));
        let alpha = (2.0 / a1).sqrt().min(1.0);
        let a2 = given[1].unwrap_or(2.0);
        Lobe { alpha, peak: alpha, shape: [a1, a2, norm(a1, a2)] }
    },
    d: |cos2, sin2, lobe| {
        let one_minus_cos = sin2 / (1.0 + cos2.sqrt());
        let [a1, a2, k] = lobe.shape;
        k * (-a2 * (a1 * one_minus_cos).ln_1p()).exp()
    },
    sigma: None,
    flat: Flat { tan, y, density, y_max: 6.0, falling: false },
};

/// ∫ q^(−power) dq from 1 to 1 + a1.
fn integral(power: f64, a1: f64) -> f64 {
    let l = a1.ln_1p();
    if power == 1.0 { l } else { ((1.0 - power) * l).exp_m1() / (1.0 - power) }
}

/// K of D = K/(1 + a1 (1 − c))^a2 from ∫ D n_dot_h dh = 1, with q = 1 + a1 (1 − c):
/// 2πK/a1 ∫ [(1 + 1/a1) q^(−a2) − q^(1 − a2)/a1] dq = 1.
fn norm(a1: f64, a2: f64) -> f64 {
    a1 / (2.0 * PI * ((1.0 + 1.0 / a1) * integral(a2, a1) - integral(a2 - 1.0, a1) / a1))
}

/// y counts ∫ D sin θ dθ, without the cosine, because that integral inverts: 1 − exp(−y²) is its share below θ.
fn tan(y: f64, lobe: &Lobe) -> f64 {
    let [a1, a2, _] = lobe.shape;
    let u = -(-y * y).exp_m1();
    let l = a1.ln_1p();
    let one_minus_cos = if a2 == 1.0 {
        (u * l).exp_m1() / a1
    } else {
        // ln q^(1 − a2), counted from the end that it is near to.
        let x = ((1.0 - a2) * l).exp_m1();
        let power = if u < 0.5 { (u * x).ln_1p() } else { (((1.0 - a2) * l).exp() - (-y * y).exp() * x).ln() };
        (power / (1.0 - a2)).exp_m1() / a1
    };
    let cos = (1.0 - one_minus_cos).max(1e-12);
    (one_minus_cos * (1.0 + cos)).sqrt() / cos
}

/// The inverse of [`tan`].
fn y(tan: f64, lobe: &Lobe) -> f64 {
    let [a1, a2, _] = lobe.shape;
    let length = (1.0 + tan * tan).sqrt();
    let (cos, one_minus_cos) = (1.0 / length, tan * tan / (length * (1.0 + length)));
    let share = |x: f64| {
        let (q, l) = ((a1 * x).ln_1p(), a1.ln_1p());
        if a2 == 1.0 { q / l } else { ((1.0 - a2) * q).exp_m1() / ((1.0 - a2) * l).exp_m1() }
    };
    let u = share(one_minus_cos);
    if u < 0.5 {
        return (-(-u).ln_1p()).sqrt();
    }
    // The share above θ without the difference 1 − u: ∫ from 1 + a1 (1 − c) to 1 + a1 of q^(−a2) dq.
    let rest = -(-a1 * cos / (1.0 + a1)).ln_1p();
    let l = a1.ln_1p();
    let v = if a2 == 1.0 {
        rest / l
    } else {
        ((1.0 - a2) * l).exp() * -((a2 - 1.0) * rest).exp_m1() / ((1.0 - a2) * l).exp_m1()
    };
    (-v.max(1e-300).ln()).max(0.0).sqrt()
}

/// The cosine that y leaves out, and the ratio of the two norms.
fn density(y: f64, tan: f64, lobe: &Lobe) -> f64 {
    let [a1, a2, k] = lobe.shape;
    bell(y) * 2.0 * PI * k * integral(a2, a1) / (a1 * (1.0 + tan * tan).sqrt())
}
