// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ring rule: GGX lobes with any function of v·h in place of Fresnel's F, however many kinks or steps it has.
//!
//! Half vectors at the angle ϑ from v form a ring around v on which F is constant. So the outer integral runs over ϑ, the
//! inner one, over the azimuth χ about v counted from the normal's side, does not know F, and a kernel need not either:
//!
//! E = ∫ F(cos ϑ) cos ϑ sin ϑ dϑ · 2 ∫₀^end D(h) [G/(n·v)] dχ.
//!
//! With b² = 1 − alpha², n·h = cos(θ_v − ϑ) − sin θ_v sin ϑ (1 − cos χ), D = alpha²/(π (1 − b n·h)² (1 + b n·h)²), and
//! 1 − b n·h is p − q cos χ, which has a peak at χ = 0. As from the true to the eccentric anomaly of an ellipse,
//!
//! 1 − cos χ = (p − q)(1 − cos ψ)/(p + q cos ψ),   dχ/(p − q cos χ)² = (p + q cos ψ) dψ/(p² − q²)^(3/2)
//!
//! flattens it exactly. The mirror direction is above the surface, n·l = cos(θ_v − 2ϑ) − sin θ_v sin 2ϑ (1 − cos χ) > 0, up
//! to an azimuth in closed form: a whole ring up to ϑ = π/4 − θ_v/2, nothing from ϑ = π/4 + θ_v/2 on. Rings are placed by
//! ϑ = θ_v + alpha sinh y, because the lobe's peak lies on the ring ϑ = θ_v, in panels that end there and at the kinks of F.
//!
//! f64 error against adaptive integration over n·v and roughness in [1/512, 1]: 1e-6.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::h_split::{AZIMUTH, LEAST_COSINE, RULES, sine};
use crate::ndf::ggx;
use crate::quadrature::gauss_legendre::Node;
use crate::term::fresnel::{Fresnel, WEIGHTS, Weights};

/// Rings a panel.
pub const OUTER: usize = 24;
/// Azimuth nodes a ring, crowded at the horizon.
pub const AZIMUTH_NODES: usize = 16;
/// Widest panel in y.
const PANEL: f64 = 3.5;
/// Numbers that describe a ring to a kernel.
pub const RING_LEN: usize = 8 + WEIGHTS;

/// A ring of half vectors around v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Cosine of the ring's angle: v·h.
    pub v_dot_h: f64,
    /// p − q, 1 − b n·h where the ring is nearest to the normal.
    near: f64,
    /// p + q, where it is farthest.
    far: f64,
    /// n·h at χ = 0, and how far it falls for 1 − cos χ = 1.
    n_dot_h: [f64; 2],
    /// The same of n·l.
    n_dot_l: [f64; 2],
    /// A right angle less half of ψ at the horizon; 0 for a whole ring. A narrow lobe leaves little of it, all of which counts.
    rest: f64,
    /// Everything that does not depend on the azimuth, F left out.
    weight: f64,
}

impl Ring {
    /// The ring as `shaders/rule/rings.glsl` reads it.
    pub fn packed(&self, fresnel: &Fresnel) -> [f32; RING_LEN] {
        let [h, h_falls] = self.n_dot_h;
        let [l, l_falls] = self.n_dot_l;
        let [a, b, c, d] = fresnel.weights(self.v_dot_h);
        [self.near, self.far, h, h_falls, l, l_falls, self.rest, self.weight, a, b, c, d].map(|x| x as f32)
    }
}

/// Nodes in words.
pub fn rule_name() -> String {
    format!("rings {OUTER}x{AZIMUTH_NODES} a panel")
}

/// The rings of a texel, appended to `rings`. Domain: n_dot_v in [0, 1], alpha in (0, 1].
pub fn outer(alpha: f64, n_dot_v: f64, fresnel: &Fresnel, rings: &mut Vec<Ring>) {
    let sv = sine(n_dot_v);
    let theta_v = sv.atan2(n_dot_v);
    let (whole, last) = ((FRAC_PI_4 - 0.5 * theta_v).max(0.0), FRAC_PI_4 + 0.5 * theta_v);
    let y = |theta: f64| ((theta - theta_v) / alpha).asinh();

    let mut breaks = vec![0.0, whole, theta_v, last];
    breaks.extend(fresnel.breaks().into_iter().map(f64::acos));
    breaks.retain(|theta| (0.0..=last).contains(theta));
    breaks.sort_by(f64::total_cmp);
    for ends in breaks.windows(2) {
        let (from, span) = (y(ends[0]), y(ends[1]) - y(ends[0]));
        if span < 1e-9 {
            continue;
        }
        let panels = (span / PANEL).ceil();
        for i in 0..panels as usize {
            // At v itself F may be a fractional power of the angle; where the horizon starts and stops cutting rings, the
            // azimuth does so like a root.
            let low = if i > 0 {
                1
            } else if ends[0] == 0.0 {
                3
            } else {
                1 + usize::from(ends[0] == whole)
            };
            let high = i + 1 == panels as usize && (ends[1] == whole || ends[1] == last);
            for node in &RULES[OUTER] {
                let node = crowd(*node, low, high);
                let at = from + span * (i as f64 + node.x) / panels;
                let slope = node.weight * span / panels * alpha * at.cosh();
                rings.push(ring(alpha, sv, theta_v, alpha * at.sinh(), slope));
            }
        }
    }
}

/// Crowds a node on [0, 1]: by a power at 0 and, if `high`, by a square at 1.
fn crowd(node: Node, low: usize, high: bool) -> Node {
    let Node { x, weight } = node;
    let rest = 1.0 - x;
    let (x, slope) = match (low, high) {
        (1, false) => (x, 1.0),
        (1, true) => (1.0 - rest * rest, 2.0 * rest),
        (2, false) => (x * x, 2.0 * x),
        (2, true) => (x * x * (3.0 - 2.0 * x), 6.0 * x * rest),
        (_, false) => (x * x * x, 3.0 * x * x),
        // x³ (4 − 3x), a square at 1.
        (_, true) => (x * x * x * (4.0 - 3.0 * x), 12.0 * x * x * rest),
    };
    Node { x, weight: weight * slope }
}

/// The ring at θ_v + `offset`, of `width` in ϑ.
fn ring(alpha: f64, sv: f64, theta_v: f64, offset: f64, width: f64) -> Ring {
    let theta = (theta_v + offset).max(0.0);
    let (sin, cos) = theta.sin_cos();
    let b = ((1.0 - alpha) * (1.0 + alpha)).sqrt();
    let least = alpha * alpha / (1.0 + b);
    let of_half = |angle: f64| least + 2.0 * b * (0.5 * angle).sin().powi(2);
    let (near, far) = (of_half(offset), of_half(theta_v + theta));
    let falls = sv * (2.0 * theta).sin();
    // cos χ at the horizon.
    let horizon = (1.0 - (theta_v - 2.0 * theta).cos() / falls.max(1e-300)).clamp(-1.0, 1.0);
    // tan²(ψ/2) = (p + q)/(p − q) tan²(χ/2): the rest of a right angle without cancellation.
    let rest = (near * (1.0 + horizon)).sqrt().atan2((far * (1.0 - horizon)).sqrt());
    Ring {
        v_dot_h: cos,
        near,
        far,
        n_dot_h: [offset.cos(), sv * sin],
        n_dot_l: [(theta_v - 2.0 * theta).cos(), falls],
        rest,
        // Both halves of the azimuth.
        weight: 4.0 * (FRAC_PI_2 - rest) * alpha * alpha / (PI * (near * far).powf(1.5)) * sin * cos * width,
    }
}

/// Directional albedo with F replaced by each weight of the Fresnel term, from a texel's rings.
///
/// The geometry term is height-correlated Smith's if `shadowed`, else masking alone: G = G1(v). Domain: n_dot_v in [0, 1],
/// alpha in (0, 1]. The GLSL twin is `shaders/rule/rings.glsl`.
pub fn rings(shadowed: bool, alpha: f64, n_dot_v: f64, fresnel: &Fresnel, rings: &[Ring]) -> Weights {
    let mu = n_dot_v;
    let b = ((1.0 - alpha) * (1.0 + alpha)).sqrt();
    let sigma_v = ggx::sigma(mu, alpha);
    let mut sum = [0.0; WEIGHTS];
    for ring in rings {
        let mut around = 0.0;
        for inner in &AZIMUTH[1][AZIMUTH_NODES] {
            // The cosine by what is left of a right angle.
            let half_end = FRAC_PI_2 - ring.rest;
            let s = (half_end * inner.x).sin();
            let c = (ring.rest + half_end * (1.0 - inner.x)).sin();
            let s2 = s * s;
            let den = ring.far * c * c + ring.near * s2;
            let fall = 2.0 * ring.near * s2 / den;
            let n_dot_h = ring.n_dot_h[0] - ring.n_dot_h[1] * fall;
            // Rounding may carry it past either end, and at grazing G would be a quotient of zeros.
            let n_dot_l = (ring.n_dot_l[0] - ring.n_dot_l[1] * fall).clamp(LEAST_COSINE, 1.0);
            let g_over_n_dot_v = match shadowed {
                true => n_dot_l / (ggx::sigma(n_dot_l, alpha) * mu + (sigma_v - mu) * n_dot_l),
                false => 1.0 / sigma_v,
            };
            let other = 1.0 + b * n_dot_h;
            around += inner.weight * den * g_over_n_dot_v / (other * other);
        }
        let weights = fresnel.weights(ring.v_dot_h);
        sum.iter_mut().zip(weights).for_each(|(s, w)| *s += ring.weight * around * w);
    }
    sum
}
