// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blinn–Phong (Walter et al. 2007, Eq. 30) with the weight n·ω: D(θ_h) · max(n·ω, 0) without its constant. GLSL twin:
//! `shaders/term/zonal/blinn_phong.glsl`.
//!
//! D is a power 2/alpha² − 2 of cos θ_h, and cos²θ_h = 1 − h: g(h) = (1 − h)^m with m = 1/alpha² − 1.

use std::f64::consts::PI;

use super::{BEYOND, Peak, Zonal};
use crate::term::fainter::fainter;

/// See the module.
pub static BLINN_PHONG: Zonal = Zonal {
    name: "blinn-phong",
    about: "Blinn-Phong lobe, (n.h)^(2/alpha^2 - 2)",
    source: "Blinn 1977; Walter, Marschner, Li, Torrance 2007, Eq. 30; n = v = r as in Karis 2013",
    value,
    values: |h, alpha| h.iter_mut().for_each(|h| *h = value(*h, alpha)),
    over_node,
    norm,
    room,
    least_room: |alpha| (LEAST_ROOM * alpha).min(0.3),
    scale: |alpha| 2.0 * alpha,
    peak: Peak::Axis,
    sharp_horizon: false,
    beyond: BEYOND,
    brightness: 1.0,
    has_tail: false,
    least_alpha: Some(0.001),
};

/// The least room in units of alpha: where the slope has grown and K is not yet faint.
const LEAST_ROOM: f64 = 1.0;

#[inline]
fn value(h: f64, alpha: f64) -> f64 {
    ((1.0 / (alpha * alpha) - 1.0) * ln_one_minus(h)).exp() * (1.0 - 2.0 * h)
}

/// ln(1 − h) without rounding h away. Domain: h ∈ [0, ¾].
pub fn ln_one_minus(h: f64) -> f64 {
    (-h).ln_1p()
}

/// Mean over a node and slope: g′ = −m g/(1 − h), g″ = m (m − 1) g/(1 − h)² in the formulas of [`super`].
/// Domain: h ∈ [0, ¾], mu ≥ 0, f ∈ [0, 1], v ≥ 0, alpha ∈ (0, 1].
pub fn over_node(h: f64, mu: f64, f: f64, v: f64, alpha: f64) -> [f64; 2] {
    let h = h.min(0.75);
    let m = 1.0 / (alpha * alpha) - 1.0;
    let i = 1.0 / (1.0 - h);
    let g = (m * ln_one_minus(h)).exp();
    let first = -m * i;
    [g * (mu + v * (first * (1.0 - m) * i * mu - 4.0 * first * f)), g * (f - 0.5 * first * mu)]
}

/// The room of a node ([`super`]): 1.5 alpha at the axis, 2.4 over the relative slope beside it.
pub fn room(away2: f64, reach: f64, extent: f64, alpha: f64) -> f64 {
    let d = (away2.sqrt() - reach - extent).clamp(0.0, 1.5);
    let m = 1.0 / (alpha * alpha) - 1.0;
    let i = 1.0 / (1.0 - 0.25 * d * d);
    let slope = d * i * m / 4.8;
    let near = 1.0 / (1.5 * alpha);
    (fainter(m * i.ln()) / (near * near + slope * slope).sqrt()).min(0.3)
}

/// 4π (2 (1 − 2^−(m+2))/(m + 2) − (1 − 2^−(m+1))/(m + 1)).
fn norm(alpha: f64) -> f64 {
    let m = 1.0 / (alpha * alpha) - 1.0;
    let part = |n: f64| (1.0 - (-n).exp2()) / n;
    4.0 * PI * (2.0 * part(m + 2.0) - part(m + 1.0))
}
