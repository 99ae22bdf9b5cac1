// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walter's rational approximation of Beckmann's separable Smith term.

use super::{Bounded, Directions, Kinks, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static BECKMANN_RATIONAL: Visibility = Visibility {
    name: "beckmann-rational",
    about: "Walter's rational fit of Beckmann's separable Smith term; it jumps by 6e-4 at n.x = 1.6 alpha",
    source: "Walter, Marschner, Li, Torrance 2007, Eq. 27",
    file: "beckmann_rational",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Never,
    smith: false,
    kinks: Some(Kinks {
        azimuth: kinks,
        tan_h: |theta_v, alpha| {
            let theta_l = jump(alpha).acos();
            [1.0, -1.0].map(|side| (0.5 * (theta_l + side * theta_v)).tan().abs()).to_vec()
        },
        n_dot_l: |alpha| Some(jump(alpha)),
        light_azimuth: None,
    }),
    outer: 24,
    crowd: 1,
    azimuth: 10,
    crowd_horizon: false,
    note: Some("beckmann-rational is fitted to Beckmann, within 0.35 %, and jumps by 6e-4 at n.x = 1.6 alpha sin"),
    diverges_at_grazing: false,
};

/// G/(n·v) with G = G1(l) G1(v) and Walter's rational G1, within 0.35 % of Beckmann's.
/// Domain: n_dot_x in [0, 1], alpha in (0, 1].
/// GLSL twin `shaders/term/visibility/beckmann_rational.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    d.n_dot_l * g1_over_n_dot_x(d.n_dot_l, d.alpha) * g1_over_n_dot_x(d.n_dot_v, d.alpha)
}

/// G1/(n·x) = (3.535 z + 2.181 z²)/(1 + 2.276 z + 2.577 z²)/(n·x) for z = cot θ/alpha < 1.6, else 1/(n·x) (Walter et al.
/// 2007, Eq. 27), with z/(n·x) = 1/(alpha sin θ) taken out: finite at grazing.
pub fn g1_over_n_dot_x(n_dot_x: f64, alpha: f64) -> f64 {
    // Rounding may carry a cosine past 1.
    let width = alpha * ((1.0 - n_dot_x) * (1.0 + n_dot_x)).max(0.0).sqrt();
    if n_dot_x >= 1.6 * width {
        return 1.0 / n_dot_x;
    }
    let z = n_dot_x / width;
    (3.535 + 2.181 * z) / (width * (1.0 + 2.276 * z + 2.577 * z * z))
}

/// n·x of the jump, z = 1.6.
pub fn jump(alpha: f64) -> f64 {
    1.6 * alpha / (1.0 + 2.56 * alpha * alpha).sqrt()
}

/// Where G has a kink, where n·l is at the jump: cosines of the azimuth between h and v, from t = tan θ_h and the sine of v; 1 for none.
pub fn kinks(tan_h: f64, n_dot_v: f64, sin_v: f64, alpha: f64) -> [f64; 2] {
    [(0.5 * (n_dot_v + jump(alpha)) * (1.0 + tan_h * tan_h) - n_dot_v) / (tan_h * sin_v), 1.0]
}
