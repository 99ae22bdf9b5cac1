// SPDX-License-Identifier: MIT OR Apache-2.0
//! Zonal kernels: what an environment is filtered with. The GLSL twin of `term/zonal/x.rs` is `shaders/term/zonal/x.glsl`.
//!
//! With view, normal and reflection equal (Karis 2013), a lobe around n depends on the direction ω only through
//!
//! ```text
//! h = (1 − n·ω)/2 ∈ [0, 1]    the squared sine of half the angle between n and ω,
//! ```
//!
//! which is the squared sine of the angle between n and the half vector: a distribution D(θ_h) is a function of h.
//! Kernels are written K(h) = g(h) · max(μ, 0) with μ = 1 − 2h = n·ω.
//!
//! **Mean over a node.** A node's directions have mean h̄, half variance v = ½ Var h and, near the horizon, a share f
//! above it and a mean μ̄ of max(μ, 0). To second order, the mean of K over the node and the factor of a first moment D
//! (so that a node adds `mean · e + slope · n·D`) are
//!
//! ```text
//! mean  = g μ̄ + v (g″ μ̄ − 4 g′ f)        slope = −K′/2 = g f − g′ μ̄/2
//! ```
//!
//! f multiplies g′, so that nodes under the horizon add nothing.
//!
//! **Room.** Beyond the second order, a node of half diagonal s is wrong by about (λ s)³ of what it adds, λ = |d ln K/dω|:
//! its room is about 2/λ, and never much more than the lobe's width at the peak. Where K is low, a light must be bright
//! to be seen beside what is at the peak, so the room of lobes that fall exponentially also grows: [`super::fainter`].

pub mod beckmann;
pub mod blinn_phong;
pub mod charlie;
pub mod ggx;
pub mod lambert;

use crate::error::{Error, Result, nearest};

/// A kernel to filter with.
pub struct Zonal {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// Paper and equation.
    pub source: &'static str,
    /// K(h) for h in [0, ½], width alpha.
    pub value: fn(h: f64, alpha: f64) -> f64,
    /// The same for many h at once, in place.
    pub values: fn(h: &mut [f64], alpha: f64),
    /// `[mean, slope]` over a node from (h̄, μ̄, f, v, alpha).
    pub over_node: fn(h: f64, mu: f64, f: f64, v: f64, alpha: f64) -> [f64; 2],
    /// ∫ K dω = 4π ∫ K dh over [0, ½], which a filtered environment is divided by.
    pub norm: fn(alpha: f64) -> f64,
    /// The half diagonal, in radians, of a node that `over_node` errs little for: to be multiplied with a precision. The
    /// node's centroid is √away2 from the middle of axes that are up to `reach` from it; the node is at most `extent`
    /// wide to any side.
    pub room: fn(away2: f64, reach: f64, extent: f64, alpha: f64) -> f64,
    /// The least that `room` gives.
    pub least_room: fn(alpha: f64) -> f64,
    /// The angle, in radians, on which K varies at its peak.
    pub scale: fn(alpha: f64) -> f64,
    /// Where K is greatest.
    pub peak: Peak,
    /// K falls so steeply to the horizon that a node there must know its own reach in the axis's direction; a mean over
    /// directions serves the others. The GLSL file's `SHARP_HORIZON`.
    pub sharp_horizon: bool,
    /// What a node adds to v for its spread alone, over the square of it. 1/80 is the spread's own part of ½ Var h in an
    /// evenly lit square; more stands for orders that `over_node` leaves out. The GLSL file's `BEYOND`.
    pub beyond: f64,
    /// How much further than for others bright nodes are cut: a light at a kink shows more of the error.
    pub brightness: f64,
    /// Does K fall like a power far from its peak, so evenly that groups of texels may share what is far?
    pub has_tail: bool,
    /// Least alpha that is filtered within the stated error; `None` where K does not depend on alpha.
    pub least_alpha: Option<f64>,
}

/// [`Zonal::beyond`] of kernels whose mean over a node ends with the second order.
const BEYOND: f64 = 1.0 / 16.0;

impl Zonal {
    /// Stem of the GLSL file.
    pub fn file(&self) -> String {
        self.name.replace('-', "_")
    }
}

/// Where a kernel is greatest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Peak {
    /// At the axis.
    Axis,
    /// On a ring just above the horizon.
    Horizon,
}

/// Every kernel, in the order of their documentation.
pub static ZONALS: &[&Zonal] =
    &[&ggx::GGX, &charlie::CHARLIE, &lambert::LAMBERT, &beckmann::BECKMANN, &blinn_phong::BLINN_PHONG];

/// The kernel with this name.
pub fn parse(name: &str) -> Result<&'static Zonal> {
    let names = ZONALS.iter().map(|z| z.name);
    ZONALS
        .iter()
        .copied()
        .find(|z| z.name == name)
        .ok_or_else(|| Error::usage(format!("unknown kernel '{name}'"), nearest(name, names)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre::gauss_legendre;

    /// 4π ∫ K dh in x = ln(h + alpha²/4), or in the eighth root of h, where K starts with a fractional power.
    fn norm_by_quadrature(zonal: &Zonal, alpha: f64) -> f64 {
        let nodes = gauss_legendre(200);
        let k = |h: f64| (zonal.value)(h, alpha);
        let sum: f64 = if zonal.peak == Peak::Horizon {
            let of = |t: f64| 0.5 * 8.0 * t.powi(7) * k(0.5 * t.powi(8));
            nodes.iter().map(|n| 0.5 * n.weight * of(0.5 * (n.x + 1.0))).sum()
        } else {
            let shift = alpha * alpha / 4.0;
            let (low, high) = (shift.ln(), (0.5 + shift).ln());
            let half = (high - low) / 2.0;
            let of = |x: f64| x.exp() * k((x.exp() - shift).max(0.0));
            nodes.iter().map(|n| n.weight * half * of(low + half * (n.x + 1.0))).sum()
        };
        4.0 * std::f64::consts::PI * sum
    }

    #[test]
    fn norm_is_the_integral() {
        for zonal in ZONALS {
            for alpha in [1.0 / 300.0, 1.0 / 64.0, 0.1, 0.5, 0.9, 0.99, 0.9999, 1.0] {
                let (closed, numeric) = ((zonal.norm)(alpha), norm_by_quadrature(zonal, alpha));
                assert!(
                    (closed / numeric - 1.0).abs() < 1e-9,
                    "{} at {alpha}: {closed}, by quadrature {numeric}",
                    zonal.name
                );
            }
        }
    }

    #[test]
    fn mean_and_slope_are_the_derivatives() {
        for zonal in ZONALS {
            for alpha in [1.0 / 64.0, 0.2, 0.8, 1.0] {
                for h in [1e-4, 0.003, 0.05, 0.3, 0.45] {
                    let k = |h: f64| (zonal.value)(h, alpha);
                    if k(h) < 1e-200 {
                        continue;
                    }
                    // The length over which K changes.
                    let slope = (k(h * 1.000_001) / k(h)).ln() / (1e-6 * h);
                    let length = 1.0 / (1.0 / (h + alpha * alpha) + slope.abs());
                    let d = (1e-3 * length).min(0.5 * h);
                    let first = (k(h + d) - k(h - d)) / (2.0 * d);
                    let second = (k(h + d) - 2.0 * k(h) + k(h - d)) / (d * d);
                    // So small that orders beyond the second do not show.
                    let v = 1e-6 * length * length;
                    let [mean, slope] = (zonal.over_node)(h, 1.0 - 2.0 * h, 1.0, v, alpha);
                    let [plain, _] = (zonal.over_node)(h, 1.0 - 2.0 * h, 1.0, 0.0, alpha);
                    let scale = k(h) / length;
                    let place = format!("{} at h = {h}, alpha = {alpha}", zonal.name);
                    assert!((plain / k(h) - 1.0).abs() < 1e-12, "{place}: {plain}, value {}", k(h));
                    assert!((slope + first / 2.0).abs() < 1e-4 * scale, "{place}: slope {slope}, {}", -first / 2.0);
                    let got = (mean - plain) / v;
                    assert!((got - second).abs() < 1e-3 * scale / length, "{place}: K'' {got}, differences {second}");
                }
            }
        }
    }

    #[test]
    fn no_node_has_less_room_than_the_least() {
        for zonal in ZONALS {
            for alpha in [0.004, 1.0 / 64.0, 0.14, 0.5, 1.0] {
                let rooms = (0..=400).flat_map(|i| {
                    [(0.0, 0.0), (0.03, 0.01), (0.1, 0.3)]
                        .map(|(reach, extent)| (zonal.room)(f64::from(i) * 0.01, reach, extent, alpha))
                });
                let least = rooms.fold(f64::MAX, f64::min);
                let stated = (zonal.least_room)(alpha);
                assert!(
                    least > 0.3 * stated && least < 2.0 * stated,
                    "{} at {alpha}: {least}, stated {stated}",
                    zonal.name
                );
            }
        }
    }

    #[test]
    fn many_values_are_the_single_ones() {
        for zonal in ZONALS {
            let mut h = [0.0, 0.001, 0.2, 0.5];
            (zonal.values)(&mut h, 0.3);
            assert_eq!(h, [0.0, 0.001, 0.2, 0.5].map(|h| (zonal.value)(h, 0.3)), "{}", zonal.name);
        }
    }

    #[test]
    fn under_the_horizon_is_nothing() {
        for zonal in ZONALS {
            assert_eq!((zonal.over_node)(0.7, 0.0, 0.0, 0.01, 0.3), [0.0; 2]);
        }
    }
}
