// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lambert: max(n·ω, 0), so that a filtered environment is the irradiance over π. GLSL twin:
//! `shaders/term/zonal/lambert.glsl`.
//!
//! g = 1. The mean over a node is exact, however large, unless the horizon runs through it.

use std::f64::consts::PI;

use super::{BEYOND, Peak, Zonal};

/// See the module.
pub static LAMBERT: Zonal = Zonal {
    name: "lambert",
    about: "cosine lobe: irradiance / pi, for diffuse light; one level, no roughness",
    source: "Ramamoorthi, Hanrahan 2001, An Efficient Representation for Irradiance Environment Maps, Eq. 1",
    value: |h, _| 1.0 - 2.0 * h,
    values: |h, _| h.iter_mut().for_each(|h| *h = 1.0 - 2.0 * *h),
    over_node,
    norm: |_| PI,
    room,
    least_room: |_| AT_HORIZON,
    scale: |_| 1.0,
    peak: Peak::Axis,
    sharp_horizon: true,
    beyond: BEYOND,
    brightness: 1.0,
    has_tail: false,
    least_alpha: None,
};

/// Room where the horizon runs through a node.
const AT_HORIZON: f64 = 0.22;

/// Mean over a node and slope: g′ = g″ = 0 in the formulas of [`super`]; neither h, v nor alpha matters.
/// Domain: mu ≥ 0, f ∈ [0, 1].
pub fn over_node(_h: f64, mu: f64, f: f64, _v: f64, _alpha: f64) -> [f64; 2] {
    [mu, f]
}

/// The room of a node ([`super`]): the whole sphere, unless the horizon of an axis may run through it.
pub fn room(away2: f64, reach: f64, extent: f64, _alpha: f64) -> f64 {
    if (1.0 - 0.5 * away2).abs() > reach + 2.0 * extent { 1e3 } else { AT_HORIZON }
}
