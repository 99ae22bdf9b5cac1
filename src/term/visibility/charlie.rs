// SPDX-License-Identifier: MIT OR Apache-2.0
//! The fitted Smith term of Charlie.

use std::f64::consts::FRAC_PI_3;

use super::{Bounded, Directions, Kinks, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static CHARLIE: Visibility = Visibility {
    name: "charlie",
    about: "Smith's term of Charlie, fitted: for the distribution of that name",
    source: "Estevez, Kulla 2017, Production Friendly Microfacet Sheen BRDF",
    file: "charlie",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Never,
    smith: false,
    kinks: Some(Kinks {
        azimuth: kinks,
        // n·l = 1/2 in the plane of incidence.
        tan_h: |theta_v, _| [1.0, -1.0].map(|side| (0.5 * (FRAC_PI_3 + side * theta_v)).tan().abs()).to_vec(),
        n_dot_l: |_| Some(0.5),
        light_azimuth: None,
    }),
    outer: 18,
    crowd: 1,
    azimuth: 12,
    crowd_horizon: false,
    note: Some(
        "charlie as a geometry term is fitted to the distribution of that name and grows like 1/(n.v) at grazing angles",
    ),
    diverges_at_grazing: true,
};

/// G/(n·v) with G = 1/(1 + Λ(l) + Λ(v)) and Estevez's and Kulla's fit of Λ. Unlike Smith's own, this Λ stays finite at
/// grazing, so the BRDF grows like 1/(n·v). Domain: n_dot_v in (0, 1], alpha in [0, 1].
/// GLSL twin `shaders/term/visibility/charlie.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    1.0 / (d.n_dot_v * (1.0 + lambda(d.n_dot_v, d.alpha) + lambda(d.n_dot_l, d.alpha)))
}

/// Λ fitted: exp(L(x)) below x = n·x = 1/2 and exp(2 L(1/2) − L(1 − x)) above, L(x) = a/(1 + b x^c) + d x + e.
/// Estevez, Kulla 2017, whose table holds a to e at both ends of the range, weighted by (1 − alpha)².
pub fn lambda(n_dot_x: f64, alpha: f64) -> f64 {
    if n_dot_x < 0.5 {
        exponent(n_dot_x, alpha).exp()
    } else {
        (2.0 * exponent(0.5, alpha) - exponent(1.0 - n_dot_x, alpha)).exp()
    }
}

/// L(x) of [`lambda`].
pub fn exponent(x: f64, alpha: f64) -> f64 {
    let smooth = (1.0 - alpha) * (1.0 - alpha);
    let mix = |rough: f64, sharp: f64| rough + (sharp - rough) * smooth;
    let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
    let (d, e) = (mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    a / (1.0 + b * x.powf(c)) + d * x + e
}

/// Where G has a kink, n·l = 1/2: cosines of the azimuth between h and v, from t = tan θ_h and the sine of v; 1 for none.
pub fn kinks(tan_h: f64, n_dot_v: f64, sin_v: f64, _alpha: f64) -> [f64; 2] {
    [(0.5 * (n_dot_v + 0.5) * (1.0 + tan_h * tan_h) - n_dot_v) / (tan_h * sin_v), 1.0]
}
