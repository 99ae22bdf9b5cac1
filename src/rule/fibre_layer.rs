// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sheen of a thin layer of upright fibres, as Zeltner, Burley and Chiang approximate it (2022, Practical
//! Multiple-Scattering Sheen Using Linearly Transformed Cosines; formulas and fitted numbers: `sheen_approx.h` of
//! github.com/tizian/ltc-sheen, Apache-2.0). The lobe that it approximates is in [`super::fibre_walk`].
//!
//! Fibres are SGGX microflakes (Heitz, Dupuy, Crassin, Dachsbacher 2015) of cross section sigma = alpha² about the normal,
//! in a layer of density and thickness 1. With the flakes' projected area a(w) = √(sin² + sigma² cos²) and the optical
//! depth t(w) = a(w)/cos, light that scatters once leaves as
//!
//! f (n·l) = D(h)/4 (1 − exp(−t(v) − t(l)))/((n·v)(t(v) + t(l))),   D = sigma³/(π (sigma² sin² + cos²)²),
//!
//! and light that scatters more often as (n·l) exp(b − m √((n·l)² + (n·v)²)) F(n·l) F(n·v), fitted by them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::lobe_nodes::{Fineness, LobeNodes, Polar, nodes_between};
use crate::bake::At;
use crate::ndf::alpha_of;
use crate::quadrature::gauss_legendre::gauss_legendre;

/// m and b of the fitted term at sigma 0, 0.1, … 1.
const FITTED: [[f64; 2]; 11] = [
    [20.0, 3.7],
    [10.2, 2.23],
    [6.14, 1.06],
    [4.30, 0.293],
    [3.30, -0.212],
    [2.55, -0.641],
    [2.02, -0.952],
    [1.63, -1.2],
    [1.33, -1.4],
    [1.1, -1.55],
    [0.95, -1.65],
];
/// No peak is so narrow that azimuths have to crowd for it.
const PEAK_RAD: f64 = 0.5;

/// The cross section of the fibres of a texel.
pub fn sigma_of(at: At) -> f64 {
    let alpha = alpha_of(at.roughness);
    alpha * alpha
}

/// The layer at one width, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct FibreLayer {
    sigma: f64,
    n_dot_v: f64,
    /// m and b at this width.
    fitted: [f64; 2],
}

impl FibreLayer {
    /// Domain: n_dot_v in (0, 1], roughness in (0, 1].
    pub fn new(at: At) -> FibreLayer {
        FibreLayer::of(sigma_of(at), at.n_dot_v)
    }

    /// Of fibres of this cross section. Domain: both in (0, 1].
    pub fn of(sigma: f64, n_dot_v: f64) -> FibreLayer {
        FibreLayer { sigma, n_dot_v, fitted: [0, 1].map(|i| between(sigma, i)) }
    }

    /// D per steradian.
    fn d(&self, sin2: f64, cos2: f64) -> f64 {
        let w = self.sigma * self.sigma * sin2 + cos2;
        self.sigma.powi(3) / (PI * w * w)
    }

    fn depth(&self, cos: f64) -> f64 {
        ((1.0 - cos) * (1.0 + cos) + self.sigma * self.sigma * cos * cos).sqrt() / cos
    }

    fn faded(&self, cos: f64) -> f64 {
        let base = (0.44 + 0.42 * self.sigma).max(0.55);
        base + (1.0 - base) * (1.0 - (1.0 - cos).powi(12))
    }

    /// f (n·l) of light that is scattered once, per steradian of light. Domain: n_dot_l in (0, 1].
    pub fn once(&self, sin_h: f64, n_dot_h: f64, n_dot_l: f64) -> f64 {
        let depth = self.depth(self.n_dot_v) + self.depth(n_dot_l);
        0.25 * self.d(sin_h * sin_h, n_dot_h * n_dot_h) * -(-depth).exp_m1() / (self.n_dot_v * depth)
    }

    /// f (n·l), per steradian of light. Domain: n_dot_l in (0, 1].
    pub fn reflected(&self, sin_h: f64, n_dot_h: f64, n_dot_l: f64) -> f64 {
        let mu = self.n_dot_v;
        let [m, b] = self.fitted;
        let often = (b - m * mu.hypot(n_dot_l)).exp() * self.faded(mu) * self.faded(n_dot_l);
        self.once(sin_h, n_dot_h, n_dot_l) + n_dot_l * often
    }

    /// Nodes over the lobe, above the horizon. cos θ_h = sigma sinh t resolves the flakes, which lie within sigma of the
    /// horizon, and the light that scatters more often, which does not.
    pub fn nodes(&self, fineness: Fineness) -> LobeNodes {
        let rule = gauss_legendre(fineness.polar);
        let theta_v = self.n_dot_v.acos();
        let t = |theta: f64| (theta.cos() / self.sigma).asinh();
        let ends = [FRAC_PI_4 - 0.5 * theta_v, FRAC_PI_4 + 0.5 * theta_v, FRAC_PI_2 - theta_v].into_iter();
        let polar: Vec<Polar> = nodes_between(0.0, t(0.0), ends.map(t), fineness.panel, &rule)
            .into_iter()
            .map(|(t, dt)| {
                let cos = (self.sigma * t.sinh()).min(1.0);
                let weight = self.sigma * t.cosh() * dt;
                Polar { sin: ((1.0 - cos) * (1.0 + cos)).sqrt(), cos, weight }
            })
            .collect();
        LobeNodes::over(&polar, self.n_dot_v, fineness.azimuth, PEAK_RAD, |sin_h, n_dot_h, _, n_dot_l| {
            self.reflected(sin_h, n_dot_h, n_dot_l)
        })
    }
}

/// A fitted number between two of those above: a Catmull–Rom spline, which goes on straight before the first and after
/// the last.
fn between(sigma: f64, i: usize) -> f64 {
    let last = FITTED.len() - 1;
    let at = |k: isize| match usize::try_from(k) {
        Err(_) => 2.0 * FITTED[0][i] - FITTED[1][i],
        Ok(k) if k > last => 2.0 * FITTED[last][i] - FITTED[last - 1][i],
        Ok(k) => FITTED[k][i],
    };
    let place = sigma * last as f64;
    let k = place.floor().min(last as f64 - 1.0);
    let (y, k) = (place - k, k as isize);
    let [p0, p1, p2, p3] = [-1, 0, 1, 2].map(|step| at(k + step));
    p1 + 0.5 * y * (p2 - p0 + y * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3 + y * (3.0 * (p1 - p2) + p3 - p0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fitted_numbers_are_met_and_joined_smoothly() {
        for (k, pair) in FITTED.iter().enumerate() {
            for (i, fitted) in pair.iter().enumerate() {
                let (before, after) = (between(0.1 * k as f64 - 1e-9, i), between(0.1 * k as f64 + 1e-9, i));
                assert!((before - fitted).abs() < 1e-6 && (after - fitted).abs() < 1e-6, "{k} {i}");
            }
        }
    }

    #[test]
    fn nodes_hold_the_flakes() {
        // Over all directions of half vectors D is normalised by its projected area seen along the normal, sigma.
        for alpha in [0.2f64, 0.6, 1.0] {
            let layer = FibreLayer::new(At { n_dot_v: 1.0, roughness: alpha.sqrt() });
            let sigma = alpha * alpha;
            let sum: f64 = gauss_legendre(200)
                .iter()
                .map(|node| {
                    let cos = 0.5 + 0.5 * node.x;
                    2.0 * PI * 0.5 * node.weight * cos * layer.d(1.0 - cos * cos, cos * cos)
                })
                .sum();
            assert!((sum - sigma).abs() < 1e-6, "{alpha}: {sum}");
        }
    }
}
