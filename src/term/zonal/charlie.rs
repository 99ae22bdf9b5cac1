//! Charlie (Estevez, Kulla 2017, Eq. 2) with the weight n·ω: D(θ_h) · max(n·ω, 0) without its constant. GLSL twin:
//! `shaders/term/zonal/charlie.glsl`.
//!
//! D is a power 1/alpha of sin θ_h, and sin²θ_h = h: g(h) = (2h)^p with p = 1/(2 alpha), so that g is 1 at the horizon.
//! K is a ring above the horizon: greatest at n·ω = 1/(p + 1), about 2 alpha, and as wide.

use std::f64::consts::PI;

use super::{Peak, Zonal};
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
    brightness: 2.5,
    least_alpha: Some(0.01),
};

#[inline]
fn value(h: f64, alpha: f64) -> f64 {
    (2.0 * h).powf(0.5 / alpha) * (1.0 - 2.0 * h)
}

/// Mean over a node and slope: g′ = p g/h, g″ = p (p − 1) g/h² in the formulas of [`super`]. Under the horizon g is 1.
/// Domain: h ∈ (0, 1], mu ≥ 0, f ∈ [0, 1], v ≥ 0, alpha ∈ (0, 1].
pub fn over_node(h: f64, mu: f64, f: f64, v: f64, alpha: f64) -> [f64; 2] {
    let p = 0.5 / alpha;
    let h = h.clamp(1e-9, 0.5);
    let g = (p * (2.0 * h).ln()).exp();
    let first = p / h;
    [g * (mu + v * first * ((p - 1.0) / h * mu - 4.0 * f)), g * (f - 0.5 * first * mu)]
}

/// The room of a node ([`super`]), at the place of the node that is nearest to the ring: three times the ring's width at
/// the horizon, less towards the axis, where (1 − μ)^p changes over (1 − μ)/(p sin θ); and only the ring's width, at most
/// 0.12, where an axis's horizon may run through the node, as K has a kink there.
pub fn room(away2: f64, reach: f64, extent: f64, alpha: f64) -> f64 {
    let p = 0.5 / alpha;
    let ring = 1.0 / (p + 1.0);
    let (mu, margin) = (1.0 - 0.5 * away2, reach + extent);
    // From the ring up; under it K only falls to 0.
    let x = 1.0 - (mu - margin).clamp(ring, 1.0 - 1e-4);
    let sine_over = (x / (2.0 - x)).sqrt().max(0.1);
    let room = (3.0 * ring * sine_over * fainter(-p * x.ln() - 1.0)).min(0.3);
    if mu.abs() <= margin + extent { room.min(ring.min(HORIZON)) } else { room }
}

/// Room at the horizon of wide lobes.
const HORIZON: f64 = 0.12;

fn least_room(alpha: f64) -> f64 {
    (1.0 / (0.5 / alpha + 1.0)).min(HORIZON)
}

/// 2π/((p + 1)(p + 2)).
fn norm(alpha: f64) -> f64 {
    let p = 0.5 / alpha;
    2.0 * PI / ((p + 1.0) * (p + 2.0))
}
