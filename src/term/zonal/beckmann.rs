// SPDX-License-Identifier: MIT OR Apache-2.0
//! Beckmann (Walter et al. 2007, Eq. 25) with the weight n·ω: D(θ_h) · max(n·ω, 0) without its constant. GLSL twin:
//! `shaders/term/zonal/beckmann.glsl`.
//!
//! tan²θ_h = h/(1 − h), cos⁴θ_h = (1 − h)²: with i = 1/(1 − h), g(h) = i² exp(−h i/alpha²).

use std::f64::consts::PI;

use super::{BEYOND, Peak, Zonal};
use crate::quadrature::gauss_legendre::gauss_legendre;
use crate::term::fainter::fainter;

/// See the module.
pub static BECKMANN: Zonal = Zonal {
    name: "beckmann",
    about: "Beckmann lobe",
    source: "Walter, Marschner, Li, Torrance 2007, Eq. 25; n = v = r as in Karis 2013",
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
    let i = 1.0 / (1.0 - h);
    i * i * (-h * i / (alpha * alpha)).exp() * (1.0 - 2.0 * h)
}

/// Mean over a node and slope: g′ = g (2i − i²/a²), g″ = g ((2i − i²/a²)² + 2i² − 2i³/a²) in the formulas of [`super`].
/// Domain: h ∈ [0, ¾], mu ≥ 0, f ∈ [0, 1], v ≥ 0, alpha ∈ (0, 1].
pub fn over_node(h: f64, mu: f64, f: f64, v: f64, alpha: f64) -> [f64; 2] {
    let i = 1.0 / (1.0 - h.min(0.75));
    let steep = i / (alpha * alpha);
    let g = i * i * (-h.min(0.75) * steep).exp();
    let first = i * (2.0 - steep);
    let second = first * first + 2.0 * i * i * (1.0 - steep);
    [g * (mu + v * (second * mu - 4.0 * first * f)), g * (f - 0.5 * first * mu)]
}

/// The room of a node ([`super`]): 1.5 alpha at the axis, 2.4 over the relative slope beside it.
pub fn room(away2: f64, reach: f64, extent: f64, alpha: f64) -> f64 {
    let d = (away2.sqrt() - reach - extent).clamp(0.0, 1.5);
    let i = 1.0 / (1.0 - 0.25 * d * d);
    let steep = i / (alpha * alpha);
    let slope = d * i * (steep - 2.0) / 4.8;
    let near = 1.0 / (1.5 * alpha);
    (fainter(0.25 * d * d * steep) / (near * near + slope * slope).sqrt()).min(0.3)
}

/// 4π ∫ exp(−t/a²) (1 − t)/(1 + t) dt over t = tan²θ_h from 0 to 1, by quadrature in t/a²; to 1e-13.
fn norm(alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let half = 0.5 * (1.0 / a2).min(40.0);
    let sum: f64 = gauss_legendre(64)
        .iter()
        .map(|node| {
            let x = half * (node.x + 1.0);
            node.weight * (-x).exp() * (1.0 - a2 * x) / (1.0 + a2 * x)
        })
        .sum();
    4.0 * PI * a2 * half * sum
}
