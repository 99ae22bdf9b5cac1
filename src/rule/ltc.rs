// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linearly transformed cosines (Heitz, Dupuy, Hill, Neubelt 2016): a clamped cosine, bent by a matrix until it looks like
//! the lobe of a BRDF. A shader bends the light's polygon back and integrates the cosine in closed form.
//!
//! With w = M⁻¹ l the density is D(l) = |M⁻¹| max(0, w_z)/(π |w|⁴), whatever M⁻¹ is scaled by; ∫ D dω = 1. The lobe of an
//! isotropic BRDF seen in the plane of incidence leaves four entries of M⁻¹ beside the middle one, which is 1. v lies at
//! positive x.
//!
//! **What is fitted.** Heitz et al. minimise ∫ |f (n·l) − E D|³ dω over all directions with E the albedo, from 32 × 32
//! random pairs, over three numbers: the frame of M is turned to the lobe's mean direction. Here the same integral is a sum
//! over fixed nodes ([`super::lobe_nodes`]), smooth in what is fitted, and Newton's method finds its minimum to eight
//! digits. The frame's direction is fitted as a fourth number: mean directions out of random samples happen to fit up to
//! 10 % better than the true one, and the best one is better than both, to a half of the error.
//!
//! **Variables.** w = (x/b₁, y/b₂, p + tilt·x) with p and x the components of l along the peak's direction and across it
//! in the plane of incidence. The widths b₁ and b₂, the peak's angle χ from the normal, and the tilt of the plane beyond
//! which D is 0 hardly depend on each other, however narrow the lobe.
//!
//! A ridge that falls between the nodes would cost nothing, so the share of D that the nodes miss is squared and added; it
//! is far below the error wherever they see the lobe.
//!
//! The error is stated as the cube root of the integral over that of ∫ (f (n·l))³ dω: 0 is perfect, 1 is no lobe at all.

use std::f64::consts::PI;

use super::lobe_nodes::{Fineness, LobeNodes};
use crate::quadrature::newton::{Local, Minimum, newton};

/// Nodes of a fit.
pub const FIT: Fineness = Fineness { polar: 10, azimuth: 14, panel: 1.3 };

/// Above this the cubed difference is that of a lobe that lies elsewhere.
const LOST: f64 = 0.25;

/// M⁻¹ with a middle of 1, in the order of published textures: rows and columns 00, 20, 02, 22.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverse(pub [f64; 4]);

/// A fitted lobe.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// Its matrix.
    pub inverse: Inverse,
    /// ∫ |f (n·l) − E D|³ dω over ∫ (f (n·l))³ dω, and what the nodes miss.
    pub cubed: f64,
    /// Newton's method came to an end.
    pub converged: bool,
}

impl Fit {
    /// The error as it is stated.
    pub fn error(&self) -> f64 {
        self.cubed.cbrt()
    }
}

impl Inverse {
    /// M⁻¹ l.
    pub fn apply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [m00, m20, m02, m22] = self.0;
        [m00 * x + m02 * z, y, m20 * x + m22 * z]
    }

    /// The density of a unit vector, per steradian.
    pub fn density(&self, l: [f64; 3]) -> f64 {
        let [m00, m20, m02, m22] = self.0;
        let w = self.apply(l);
        let length2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        (m00 * m22 - m20 * m02).abs() * w[2].max(0.0) / (PI * length2 * length2)
    }

    /// [`Fit::cubed`] of this matrix, whatever it was fitted to.
    pub fn cubed_error(&self, nodes: &LobeNodes) -> f64 {
        let albedo = nodes.albedo();
        let (mut error, mut norm) = (0.0, 0.0);
        for ((l, f), w) in nodes.light.iter().zip(&nodes.value).zip(&nodes.solid_angle_sr) {
            error += w * (f - albedo * self.density(*l)).abs().powi(3);
            norm += w * f.powi(3);
        }
        error / norm
    }

    /// The cube root of ∫ |E D − E D'|³ dω over ∫ (f (n·l))³ dω, D' being the density of another matrix.
    pub fn distance(&self, other: &Inverse, nodes: &LobeNodes) -> f64 {
        let albedo = nodes.albedo();
        let (mut sum, mut norm) = (0.0, 0.0);
        for ((l, f), w) in nodes.light.iter().zip(&nodes.value).zip(&nodes.solid_angle_sr) {
            sum += w * (albedo * (self.density(*l) - other.density(*l))).abs().powi(3);
            norm += w * f.powi(3);
        }
        (sum / norm).cbrt()
    }
}

/// What is fitted, over the light's components in the lobe's frame.
struct Objective<'a> {
    nodes: &'a LobeNodes,
    albedo: f64,
    /// 1/∫ (f (n·l))³ dω.
    inverse_norm: f64,
    /// The mirror direction's angle, from which χ counts in units of `scale_rad`.
    theta_v: f64,
    scale_rad: f64,
}

/// ln b₁, ln b₂, (χ − θ_v)/scale, tilt.
type Variables = [f64; 4];

impl Objective<'_> {
    fn chi(&self, p: &Variables) -> f64 {
        self.theta_v + self.scale_rad * p[2]
    }

    fn inverse(&self, p: &Variables) -> Inverse {
        let (sin, cos) = self.chi(p).sin_cos();
        let (b1, b2) = (p[0].exp(), p[1].exp());
        Inverse([b2 * cos / b1, b2 * (p[3] * cos - sin), b2 * sin / b1, b2 * (p[3] * sin + cos)])
    }

    /// The integral's share of ∫ (f (n·l))³ dω, and the square of the share of E that the nodes miss.
    fn value(&self, p: &Variables) -> f64 {
        let (sin, cos) = self.chi(p).sin_cos();
        let (wide, high) = ((-p[0]).exp(), (-p[1]).exp());
        let peak = self.albedo * wide * high / PI;
        let (mut sum, mut seen) = (0.0, 0.0);
        for ((l, f), w) in self.nodes.light.iter().zip(&self.nodes.value).zip(&self.nodes.solid_angle_sr) {
            let (along, across) = (cos * l[2] - sin * l[0], cos * l[0] + sin * l[2]);
            let c = (along + p[3] * across).max(0.0);
            let (x, y) = (across * wide, l[1] * high);
            let q = x * x + y * y + c * c;
            let d = peak * c / (q * q);
            let off = (d - f).abs();
            sum += w * off * off * off;
            seen += w * d;
        }
        sum * self.inverse_norm + (1.0 - seen / self.albedo).powi(2)
    }

    /// The same with its derivatives. With D = k c/q², q = x² + y² + c² of w = (x, y, c), the derivatives of w by the
    /// variables follow from those of x and p by χ, which are p and −x.
    fn local(&self, p: &Variables) -> Local<4> {
        let (sin, cos) = self.chi(p).sin_cos();
        let (wide, high, tilt, scale) = ((-p[0]).exp(), (-p[1]).exp(), p[3], self.scale_rad);
        let peak = self.albedo * wide * high / PI;
        let (mut value, mut gradient, mut hessian) = (0.0, [0.0; 4], [[0.0; 4]; 4]);
        let (mut seen, mut seen_gradient) = (0.0, [0.0; 4]);
        for ((l, f), w) in self.nodes.light.iter().zip(&self.nodes.value).zip(&self.nodes.solid_angle_sr) {
            let (along, across) = (cos * l[2] - sin * l[0], cos * l[0] + sin * l[2]);
            let c = along + tilt * across;
            if c <= 0.0 {
                value += w * f * f * f;
                continue;
            }
            let (x, y) = (across * wide, l[1] * high);
            let q = x * x + y * y + c * c;
            let k = peak / (q * q);
            let d = k * c;
            seen += w * d;
            let (off, size) = (d - f, (d - f).abs());
            value += w * size * size * size;

            // First derivatives of x, y and c, and the second ones that are not 0.
            let dx = [-x, 0.0, scale * along * wide, 0.0];
            let dy = [0.0, -y, 0.0, 0.0];
            let dc = [0.0, 0.0, scale * (tilt * along - across), across];
            let mut dxx = [[0.0; 4]; 4];
            dxx[0][0] = x;
            dxx[2][0] = -dx[2];
            dxx[2][2] = -scale * scale * x;
            let mut dcc = [[0.0; 4]; 4];
            dcc[2][2] = -scale * scale * c;
            dcc[3][2] = scale * along;

            // ln k falls with both widths and with 2 ln q.
            let log_q: [f64; 4] = std::array::from_fn(|i| 2.0 * (x * dx[i] + y * dy[i] + c * dc[i]) / q);
            let log_k: [f64; 4] = std::array::from_fn(|i| if i < 2 { -1.0 } else { 0.0 } - 2.0 * log_q[i]);
            let dd: [f64; 4] = std::array::from_fn(|i| d * log_k[i] + k * dc[i]);
            let (first, second) = (3.0 * w * off * size, 6.0 * w * size);
            for i in 0..4 {
                gradient[i] += first * dd[i];
                seen_gradient[i] += w * dd[i];
                for j in 0..=i {
                    let yy = if i == 1 && j == 1 { y * y } else { 0.0 };
                    let bent = x * dxx[i][j] + c * dcc[i][j] + yy;
                    let log_qq = 2.0 * (dx[i] * dx[j] + dy[i] * dy[j] + dc[i] * dc[j] + bent) / q;
                    let ddd = d * (log_k[i] * log_k[j] - 2.0 * (log_qq - log_q[i] * log_q[j]))
                        + k * (dc[i] * log_k[j] + dc[j] * log_k[i] + dcc[i][j]);
                    hessian[i][j] += second * dd[i] * dd[j] + first * ddd;
                }
            }
        }
        let n = self.inverse_norm;
        let (missed, slope) = (1.0 - seen / self.albedo, seen_gradient.map(|g| -g / self.albedo));
        Local {
            value: value * n + missed * missed,
            gradient: std::array::from_fn(|i| gradient[i] * n + 2.0 * missed * slope[i]),
            // Of the second derivatives of a square that is nearly 0, these are what counts.
            hessian: std::array::from_fn(|i| std::array::from_fn(|j| hessian[i][j] * n + 2.0 * slope[i] * slope[j])),
        }
    }
}

/// The transformed cosine that fits a lobe best, seen at `n_dot_v` in (0, 1]. `width_rad` is the angular size of the lobe's
/// peak.
///
/// Newton's method starts with the peak's height at the lobe's mean direction, and half-way between that and the mirror
/// direction; the better end wins. Where both are lost, as may be where a long tail draws the mean away, it starts at the
/// mirror direction too. Seen along the normal the lobe is round, which leaves one number.
pub fn fit(nodes: &LobeNodes, n_dot_v: f64, width_rad: f64) -> Fit {
    let (mut mean, mut v_dot_h, mut largest, mut norm) = ([0.0; 2], 0.0, 0.0f64, 0.0);
    let sin_v = ((1.0 - n_dot_v) * (1.0 + n_dot_v)).sqrt();
    for ((l, f), w) in nodes.light.iter().zip(&nodes.value).zip(&nodes.solid_angle_sr) {
        mean[0] -= w * f * l[0];
        mean[1] += w * f * l[2];
        v_dot_h += w * f * (0.5 * (1.0 + sin_v * l[0] + n_dot_v * l[2])).max(0.0).sqrt();
        largest = largest.max(*f);
        norm += w * f.powi(3);
    }
    let albedo = nodes.albedo();
    let theta_v = sin_v.atan2(n_dot_v);
    let objective = Objective { nodes, albedo, inverse_norm: 1.0 / norm, theta_v, scale_rad: width_rad.min(1.0) };

    // A peak of albedo/(π b₁ b₂), and a lobe squeezed across the plane of incidence by v·h.
    let squeezed = (v_dot_h / albedo).clamp(1e-6, 1.0);
    let wide = 0.5 * (albedo / (PI * largest * squeezed)).ln();
    if sin_v == 0.0 {
        return round(&objective, wide);
    }
    let chi = mean[0].atan2(mean[1]).min(theta_v);
    // The tilt that fits a narrow lobe.
    let tilt = 0.5 * chi.tan() * chi.sin() * chi.sin();
    let from = |share: f64| {
        let start = [wide, wide + squeezed.ln(), share * (chi - theta_v) / objective.scale_rad, tilt];
        newton(
            start,
            |p| objective.value(p),
            |p| objective.local(p),
            |p| [0.5, 0.5, 0.5 * (1.0 + p[2].abs()), 0.5 * (1.0 + p[3].abs())],
        )
    };
    let better = |a: Minimum<4>, b: Minimum<4>| if b.value < a.value { b } else { a };
    let mut best = better(from(1.0), from(0.5));
    if best.value > LOST {
        best = better(best, from(0.0));
    }
    Fit { inverse: objective.inverse(&best.at), cubed: best.value, converged: best.converged }
}

/// The fit of a lobe that is round about the normal.
fn round(objective: &Objective<'_>, wide: f64) -> Fit {
    let all = |p: &[f64; 1]| [p[0], p[0], 0.0, 0.0];
    let local = |p: &[f64; 1]| {
        let Local { value, gradient: g, hessian: h } = objective.local(&all(p));
        Local { value, gradient: [g[0] + g[1]], hessian: [[h[0][0] + h[1][1] + 2.0 * h[1][0]]] }
    };
    // A ring of light, as upright facets send back along the normal, may have two widths that fit.
    let ends = [wide, 0.0, 0.7, 1.4].map(|start| newton([start], |p| objective.value(&all(p)), local, |_| [0.5]));
    let found = ends.into_iter().min_by(|a, b| a.value.total_cmp(&b.value)).expect("four ends");
    Fit { inverse: objective.inverse(&all(&found.at)), cubed: found.value, converged: found.converged }
}
