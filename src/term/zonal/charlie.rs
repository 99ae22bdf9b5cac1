// SPDX-License-Identifier: MIT OR Apache-2.0
//! Charlie (Estevez, Kulla 2017, Eq. 2) with the weight n·ω: D(θ_h) · max(n·ω, 0) without its constant. GLSL twin:
//! `shaders/term/zonal/charlie.glsl`.
//!
//! D is a power 1/alpha of sin θ_h, and sin²θ_h = h: g(h) = (2h)^p with p = 1/(2 alpha), so that g is 1 at the horizon.
//! K is a ring above the horizon: greatest at n·ω = 1/(p + 1), about 2 alpha, and as wide.

use std::f64::consts::PI;

use super::{BEYOND, Peak, Zonal};
use crate::term::fainter::fainter;

/// See the module.
pub static CHARLIE: Zonal = Zonal {
    name: "charlie",
    about: "Charlie lobe, a ring at the horizon: the sheen of cloth",
    source: "Estevez, Kulla 2017, Production Friendly Microfacet Sheen BRDF, Eq. 2; n = v = r as in Karis 2013",
    value,
    values: |h, alpha| h.iter_mut().for_each(|h| *h = value(*h, alpha)),
    over_node,
    norm,
    room,
    least_room,
    scale: |alpha| 1.0 / (0.5 / alpha + 1.0),
    peak: Peak::Horizon,
    sharp_horizon: true,
    beyond: BEYOND,
    brightness: 4.0,
    has_tail: false,
    least_alpha: Some(0.004),
};

#[inline]
fn value(h: f64, alpha: f64) -> f64 {
    // Half the time of powf, whose last digits nobody needs.
    ((2.0 * h).ln() * 0.5 / alpha).exp() * (1.0 - 2.0 * h)
}

/// Mean over a node and slope. Above the horizon g′ = p g/h, g″ = p (p − 1) g/h² in the formulas of [`super`], and in the
/// mean the fourth order too, as K is a high power: a node's energy is taken for as flat as a rectangle's, whose fourth
/// moment is `FLATNESS` times its squared variance.
///
/// A node that the horizon runs through (f < 1) counts as even in μ up to μ₁ = 2 μ̄/f, over a length of 2 μ̄/f²: there
/// g = (1 − μ)^p falls by much, and the integrals are closed,
///
/// ```text
/// ∫ (1 − μ)^p μ dμ = 1/((p + 1)(p + 2)) − x^(p+1) (1/(p + 1) − x/(p + 2))    over [0, μ₁], x = 1 − μ₁
/// ```
///
/// Domain: h ∈ (0, 1], mu ≥ 0, f ∈ [0, 1], v ≥ 0, alpha ∈ (0, 1].
pub fn over_node(h: f64, mu: f64, f: f64, v: f64, alpha: f64) -> [f64; 2] {
    let p = 0.5 / alpha;
    let h = h.clamp(1e-9, 0.5);
    let crosses = f < 1.0;
    let x = if crosses { 1.0 - (2.0 * mu / f.max(1e-9)).min(1.0) } else { 2.0 * h };
    let g = (p * x.max(1e-9).ln()).exp();
    if crosses {
        let (a, b) = (1.0 / (p + 1.0), 1.0 / (p + 2.0));
        return [0.5 * f * f / mu.max(1e-12) * (a * b - x * g * (a - x * b)), g * f];
    }
    let first = p / h;
    let (second, third, fourth) = ((p - 1.0) / h, (p - 2.0) / h, (p - 3.0) / h);
    let order_2 = v * first * (second * mu - 4.0);
    // (2v)² · FLATNESS/24 · K⁗
    let order_4 = FLATNESS / 6.0 * v * v * first * second * third * (fourth * mu - 8.0);
    [g * (mu + order_2 + order_4), g * (1.0 - 0.5 * first * mu)]
}

/// Between that of a side of a rectangle, 1.8, and of a diagonal, 2.4.
const FLATNESS: f64 = 2.1;

/// The room of a node ([`super`]), at the place of the node that is nearest to the ring: `ABOVE` times the ring's width at
/// the horizon, less towards the axis, where (1 − μ)^p changes over (1 − μ)/(p sin θ); and only `ACROSS` times its width,
/// at most 0.12, where an axis's horizon may run through the node. Thin rings are followed to the fourth order and in
/// closed form across the kink, so that nodes may be wider than they are; wide ones are bound by the lights in a node.
pub fn room(away2: f64, reach: f64, extent: f64, alpha: f64) -> f64 {
    let p = 0.5 / alpha;
    let ring = 1.0 / (p + 1.0);
    let (mu, margin) = (1.0 - 0.5 * away2, reach + extent);
    // From the ring up; under it K only falls to 0.
    let x = 1.0 - (mu - margin).clamp(ring, 1.0 - 1e-4);
    let sine_over = (x / (2.0 - x)).sqrt().max(0.1);
    let room = (ABOVE * ring * sine_over * fainter(-p * x.ln() - 1.0)).min(0.3);
    if mu.abs() <= margin + extent { room.min((ACROSS * ring).min(HORIZON)) } else { room }
}

/// Room above the horizon over the ring's width.
const ABOVE: f64 = 3.6;
/// Room at the horizon over the ring's width.
const ACROSS: f64 = 1.2;
/// Room at the horizon of wide lobes.
const HORIZON: f64 = 0.12;

fn least_room(alpha: f64) -> f64 {
    (ACROSS / (0.5 / alpha + 1.0)).min(HORIZON)
}

/// 2π/((p + 1)(p + 2)).
fn norm(alpha: f64) -> f64 {
    let p = 0.5 / alpha;
    2.0 * PI / ((p + 1.0) * (p + 2.0))
}
