// SPDX-License-Identifier: MIT OR Apache-2.0
//! V-cavities.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::{Bounded, Directions, Kinks, Visibility};
use crate::rule::cone::cone;

/// Registry entry.
pub static COOK_TORRANCE: Visibility = Visibility {
    name: "cook-torrance",
    about: "V-cavities: every facet is half of a symmetric groove",
    source: "Cook, Torrance 1982, Eq. 4; Torrance, Sparrow 1967",
    file: "cook_torrance",
    cone: |n_dot_v, alpha, fresnel| cone(n_dot_v, alpha, g_over_n_dot_v, fresnel),
    g_over_n_dot_v,
    bounded: Bounded::Always,
    smith: false,
    kinks: Some(Kinks {
        azimuth: kinks,
        tan_h: |theta_v, _| {
            let third = |x: f64| ((FRAC_PI_2 + x) / 3.0).tan();
            // Up to 45 degrees only the gentle facets' lines leave the range, beyond it masking begins, too.
            if theta_v < FRAC_PI_4 {
                vec![1.0, third(theta_v), third(-theta_v)]
            } else {
                vec![1.0, third(-theta_v), 1.0 / theta_v.tan(), theta_v.tan()]
            }
        },
        n_dot_l: |_| None,
        light_azimuth: Some(|n_dot_l, n_dot_v| {
            // |l + v|² = 4 (n·l + n·v) min(n·l, n·v)
            let sines = ((1.0 - n_dot_l * n_dot_l) * (1.0 - n_dot_v * n_dot_v)).sqrt();
            (2.0 * (n_dot_l + n_dot_v) * n_dot_l.min(n_dot_v) - 1.0 - n_dot_l * n_dot_v) / sines
        }),
    }),
    outer: 16,
    crowd: 2,
    azimuth: 7,
    crowd_horizon: false,
    note: None,
    diverges_at_grazing: false,
};

/// G/(n·v) with G = min(1, 2 (n·h)(n·v)/(v·h), 2 (n·h)(n·l)/(v·h)) (Cook, Torrance 1982, Eq. 4), finite at n·v = 0.
/// GLSL twin `shaders/term/visibility/cook_torrance.glsl`.
pub fn g_over_n_dot_v(d: &Directions) -> f64 {
    let narrow = d.n_dot_l / d.n_dot_l.max(d.n_dot_v);
    (1.0 / d.n_dot_v).min(2.0 * d.n_dot_h * narrow / d.v_dot_h)
}

/// Where G has a kink: cosines of the azimuth between h and v, from t = tan θ_h and the sine of v; 1 for none.
///
/// On gentle facets, t < 1: where the groove begins to mask, v·h = 2 (n·h)(n·v), and to shadow, v·h = 2 (n·h)(n·l). On
/// steep ones one of the two always holds, and they change places where n·l = n·v.
pub fn kinks(tan_h: f64, n_dot_v: f64, sin_v: f64, _alpha: f64) -> [f64; 2] {
    let t2 = tan_h * tan_h;
    let scale = n_dot_v / (tan_h * sin_v);
    if t2 < 1.0 { [scale, scale * (3.0 * t2 - 1.0) / (3.0 - t2)] } else { [scale * t2, 1.0] }
}
