// SPDX-License-Identifier: MIT OR Apache-2.0
//! GGX (Trowbridge–Reitz; Walter et al. 2007, Eq. 33) with the weight n·ω: D(θ_h) · max(n·ω, 0) without its constant.
//! GLSL twin: `shaders/term/zonal/ggx.glsl`.
//!
//! cos²θ_h (alpha² − 1) + 1 = alpha² + (1 − alpha²) h, so g(h) = r² with r = 1/(alpha² + b h), b = 1 − alpha².

use std::f64::consts::PI;

use pulp::Arch;

use super::{Peak, Zonal};
use crate::quadrature::gauss_legendre::gauss_legendre;

/// See the module.
pub static GGX: Zonal = Zonal {
    name: "ggx",
    about: "GGX (Trowbridge-Reitz) lobe, as in the split-sum approximation",
    source: "Karis 2013, Real Shading in Unreal Engine 4; Walter et al. 2007, Eq. 33",
    value,
    values,
    over_node,
    norm,
    room,
    least_room: |alpha| room(0.0, 0.0, 0.0, alpha),
    scale: |alpha| 2.0 * alpha,
    peak: Peak::Axis,
    sharp_horizon: false,
    beyond: 0.0125,
    brightness: 1.0,
    has_tail: true,
    least_alpha: Some(0.001),
};

/// Asking for the processor's vectors pays from here.
const MANY: usize = 64;

#[inline]
fn value(h: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let r = 1.0 / (a2 + (1.0 - a2) * h);
    r * r * (1.0 - 2.0 * h)
}

fn values(h: &mut [f64], alpha: f64) {
    let is_many = h.len() >= MANY;
    let mut all = || h.iter_mut().for_each(|h| *h = value(*h, alpha));
    // Where there are many, with the widest vectors that the processor has; the same bits on all.
    if is_many { Arch::new().dispatch(all) } else { all() }
}

/// Mean over a node and slope: g = r², g′ = −2 b r³, g″ = 6 b² r⁴ in the formulas of [`super`], and beyond them.
///
/// With x = 2 v (b r)², the variance of b h over its squared distance from r's pole, the mean of r² is r² (1 + 3x) to
/// second order. The tail's nodes are as large as their distance allows, so that x is about ¼ there and the series goes on
/// slowly. The mean over two points ±√(2v) has it in closed form, (1 + x)/(1 − x)² = 1 + 3x + 5x² + 7x³ + …; an evenly
/// lit square is flatter than two points, and 7 and 20 are what squares of all sizes and turns ask for on average. In the
/// same closed form the term of f has 1 + 2x.
///
/// Domain: h ∈ [0, 1], mu ≥ 0, f ∈ [0, 1], v ≥ 0, alpha ∈ (0, 1].
pub fn over_node(h: f64, mu: f64, f: f64, v: f64, alpha: f64) -> [f64; 2] {
    let a2 = alpha * alpha;
    let b = 1.0 - a2;
    let r = 1.0 / (a2 + b * h);
    let b_r = b * r;
    let x = 2.0 * v * b_r * b_r;
    let above = 1.0 + x * (3.0 + x * (7.0 + 20.0 * x));
    let across = 8.0 * v * b_r * (1.0 + 2.0 * x);
    [r * r * (mu * above + f * across), r * r * (f + b_r * mu)]
}

/// The room of a node ([`super`]): at first as far as it is, from 1.5 alpha up; d/1.75 in the tail. At most 0.3 for wide
/// lobes, whose horizon is seen; up to twice that for narrow ones.
pub fn room(away2: f64, reach: f64, extent: f64, alpha: f64) -> f64 {
    let d = (1.5 * alpha).max(away2.sqrt() - reach - extent);
    (d * (d + 10.5 * alpha) / (1.75 * d + 10.0 * alpha)).min((0.6 - 2.0 * alpha).max(0.3))
}

/// (4π/b) ((1 + 2a²/b)(1/a² − 1/u) − (2/b) ln(u/a²)) with u = (1 + a²)/2; by quadrature where b is small.
fn norm(alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let b = 1.0 - a2;
    if b < 0.02 {
        let nodes = gauss_legendre(16);
        return 4.0 * PI * nodes.iter().map(|n| 0.25 * n.weight * value(0.25 * (1.0 + n.x), alpha)).sum::<f64>();
    }
    let u = 0.5 * (1.0 + a2);
    4.0 * PI / b * ((1.0 + 2.0 * a2 / b) * (1.0 / a2 - 1.0 / u) - 2.0 / b * (u / a2).ln())
}
