// SPDX-License-Identifier: MIT OR Apache-2.0
//! One complex index a channel that stands for a whole spectrum.

use crate::quadrature::gauss_legendre::gauss_legendre;
use crate::term::fresnel::conductor::conductor;

/// The largest normal reflectance that is fitted; a channel above it (the red of gold) is clipped to it. At 1 no finite k
/// would do.
pub const LARGEST_F0: f64 = 0.9999;

/// Nodes of the integral over the cosine; steps of the first search.
const COSINES: usize = 32;
const STEPS: usize = 96;

/// The index of one channel, relative to air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Real part.
    pub eta: f64,
    /// Imaginary part, positive.
    pub k: f64,
    /// Its normal reflectance: the spectrum's, unless clipped.
    pub f0: f64,
    /// The spectrum's normal reflectance lay outside what a conductor can have, and was clipped to [`LARGEST_F0`].
    pub clipped: bool,
    /// Largest difference from the spectrum's curve over all angles.
    pub worst: f64,
}

/// The best pair for each channel of a curve of reflectance against the cosine.
///
/// With the normal reflectance R given, eta runs from (1 − √R)/(1 + √R) to its inverse and
/// k² = (R (eta + 1)² − (eta − 1)²)/(1 − R) follows (Gulbrandsen 2014, Artist friendly metallic Fresnel, JCGT 3): one
/// unknown is left. It is searched on a logarithmic grid, because there may be two minima, then by golden section.
pub(super) fn channels(curve: impl Fn(f64) -> [f64; 3]) -> [Channel; 3] {
    let nodes: Vec<(f64, f64)> = gauss_legendre(COSINES).iter().map(|n| (0.5 * (1.0 + n.x), 0.5 * n.weight)).collect();
    let targets: Vec<[f64; 3]> = nodes.iter().map(|(cos, _)| curve(*cos)).collect();
    let normal = curve(1.0);
    std::array::from_fn(|channel| {
        let f0 = normal[channel].clamp(0.0, LARGEST_F0);
        let low = (1.0 - f0.sqrt()) / (1.0 + f0.sqrt());
        let squares = |log_eta: f64| -> f64 {
            let eta = log_eta.exp();
            let k = k_of(f0, eta);
            nodes
                .iter()
                .zip(&targets)
                .map(|((cos, weight), target)| weight * (conductor(*cos, eta, k) - target[channel]).powi(2))
                .sum()
        };
        let at = |i: usize| low.ln() * (1.0 - 2.0 * i as f64 / STEPS as f64);
        let best = (0..=STEPS).min_by(|a, b| squares(at(*a)).total_cmp(&squares(at(*b)))).expect("the grid has nodes");
        let eta = golden_section(squares, at(best.saturating_sub(1)), at((best + 1).min(STEPS))).exp();
        let k = k_of(f0, eta);
        let worst = (0..=1000)
            .map(|i| {
                let cos = f64::from(i) / 1000.0;
                (conductor(cos, eta, k) - curve(cos)[channel]).abs()
            })
            .fold(0.0, f64::max);
        Channel { eta, k, f0, clipped: f0 != normal[channel], worst }
    })
}

/// The k that gives the normal reflectance f0 with eta.
fn k_of(f0: f64, eta: f64) -> f64 {
    ((f0 * (eta + 1.0).powi(2) - (eta - 1.0).powi(2)) / (1.0 - f0)).max(0.0).sqrt()
}

/// Where `f` is least between `low` and `high`, if it has one minimum there.
fn golden_section(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..40 {
        if fa < fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = f(b);
        }
    }
    0.5 * (low + high)
}
