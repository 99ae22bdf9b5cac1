// SPDX-License-Identifier: MIT OR Apache-2.0
//! The linearly transformed cosine of a sheen (Zeltner, Burley, Chiang 2022): two numbers bend a cosine that never reaches
//! below the horizon.
//!
//! With w = (A x + B z, A y, z) the density is D(l) = A² z/(π |w|⁴); x points along the view. Fitted is
//! ∫ (f (n·l) − R D)² dω, R being the albedo: the square, as Zeltner et al. have it, but over solid angle, and R is not
//! fitted but right. The error is stated as the root of the integral over that of ∫ (f (n·l))² dω.

use std::f64::consts::PI;

use super::lobe_nodes::{Fineness, LobeNodes};
use crate::quadrature::newton::{Local, newton};

/// Nodes of a fit.
pub const FIT: Fineness = Fineness { polar: 10, azimuth: 14, panel: 1.0 };

/// A fitted lobe.
#[derive(Clone, Copy, Debug)]
pub struct SheenFit {
    /// A and B.
    pub entries: [f64; 2],
    /// ∫ (f (n·l) − R D)² dω over ∫ (f (n·l))² dω, and what the nodes miss.
    pub squared: f64,
}

/// The density of a unit vector, per steradian; 0 below the horizon.
pub fn density([a, b]: [f64; 2], [x, y, z]: [f64; 3]) -> f64 {
    let (x, y) = (a * x + b * z, a * y);
    let q = x * x + y * y + z * z;
    a * a * z.max(0.0) / (PI * q * q)
}

/// ∫ (f (n·l) − R D)² dω over ∫ (f (n·l))² dω.
pub fn squared_error(nodes: &LobeNodes, albedo: f64, entries: [f64; 2]) -> f64 {
    let (mut error, mut norm) = (0.0, 0.0);
    for ((l, f), w) in nodes.light.iter().zip(&nodes.value).zip(&nodes.solid_angle_sr) {
        error += w * (f - albedo * density(entries, *l)).powi(2);
        norm += w * f * f;
    }
    error / norm
}

/// The fit of A and B to a lobe of this albedo.
pub fn fit(nodes: &LobeNodes, albedo: f64) -> SheenFit {
    let norm: f64 = nodes.value.iter().zip(&nodes.solid_angle_sr).map(|(f, w)| w * f * f).sum();
    let missed = |a: f64, b: f64| {
        let seen = |(l, w): (&[f64; 3], &f64)| w * density([a, b], *l);
        1.0 - nodes.light.iter().zip(&nodes.solid_angle_sr).map(seen).sum::<f64>()
    };
    let value = |p: &[f64; 2]| {
        let entries = [p[0].exp(), p[1]];
        squared_error(nodes, albedo, entries) + missed(entries[0], entries[1]).powi(2)
    };
    let local = |p: &[f64; 2]| {
        let (a, b) = (p[0].exp(), p[1]);
        let (mut value, mut gradient, mut hessian) = (0.0, [0.0; 2], [[0.0; 2]; 2]);
        let (mut seen, mut seen_gradient) = (0.0, [0.0; 2]);
        for ((l, f), w) in nodes.light.iter().zip(&nodes.value).zip(&nodes.solid_angle_sr) {
            let (ax, z) = (a * l[0], l[2].max(0.0));
            let (x, y) = (ax + b * z, a * l[1]);
            let q = x * x + y * y + z * z;
            let d = a * a * z / (PI * q * q);
            let off = albedo * d - f;
            value += w * off * off;
            seen += w * d;
            let log_q = [2.0 * (x * ax + y * y) / q, 2.0 * x * z / q];
            let log_d = [2.0 - 2.0 * log_q[0], -2.0 * log_q[1]];
            let log_qq = [2.0 * (ax * ax + x * ax + 2.0 * y * y) / q, 2.0 * ax * z / q, 2.0 * z * z / q];
            for i in 0..2 {
                gradient[i] += 2.0 * w * off * albedo * d * log_d[i];
                seen_gradient[i] += w * d * log_d[i];
                for j in 0..=i {
                    let bent = -2.0 * (log_qq[i + j] - log_q[i] * log_q[j]);
                    let dd = d * (log_d[i] * log_d[j] + bent);
                    hessian[i][j] += 2.0 * w * albedo * (albedo * d * d * log_d[i] * log_d[j] + off * dd);
                }
            }
        }
        let missed = 1.0 - seen;
        Local {
            value: value / norm + missed * missed,
            gradient: std::array::from_fn(|i| gradient[i] / norm - 2.0 * missed * seen_gradient[i]),
            hessian: std::array::from_fn(|i| {
                std::array::from_fn(|j| hessian[i][j] / norm + 2.0 * seen_gradient[i] * seen_gradient[j])
            }),
        }
    };
    // A sheen leans towards the horizon before or behind the viewer, or hugs it as closely as its mean cosine says.
    let moments = nodes.light.iter().zip(&nodes.value).zip(&nodes.solid_angle_sr);
    let (all, cosine) = moments.fold((0.0, 0.0), |(all, sum), ((l, f), w)| (all + w * f, sum + w * f * l[2].max(0.0)));
    let mean = (cosine / all).clamp(1e-4, 1.0);
    let ends = [[0.5f64, -0.2], [0.5, 0.2], [mean, -0.5 * mean]]
        .map(|[a, b]| newton([a.ln(), b], value, local, |p| [0.5, 0.2 * p[0].exp() + 0.2 * p[1].abs()]));
    let best = ends.into_iter().min_by(|x, y| x.value.total_cmp(&y.value)).expect("three ends");
    SheenFit { entries: [best.at[0].exp(), best.at[1]], squared: best.value }
}
