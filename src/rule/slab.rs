// SPDX-License-Identifier: MIT OR Apache-2.0
//! Depth in a layer of thickness 1: where in it something is known, and what flies through it.
//!
//! Nodes are those of Gauss and Legendre in x, with the depth z = x² (3 − 2x): what scatters in a layer is smooth within it,
//! but has a slope like log z at its surfaces, for the sake of light that flies along them.

use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::quadrature::lagrange::Lagrange;

/// A depth fades by e^−38 before it is forgotten; ends of panels in units of 1/extinction.
const FADED: [f64; 4] = [2.0, 6.0, 14.0, 38.0];
/// Nodes of such a panel.
const PANEL: usize = 16;

/// The nodes of a layer.
pub struct Slab {
    /// Depths from one surface, in (0, 1), ascending; what is known at them lies the same from the other surface.
    pub depth: Vec<f64>,
    /// ∫ dz that each stands for.
    pub weight: Vec<f64>,
    basis: Lagrange,
    panel: Vec<Node>,
}

fn depth(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}

/// The other way.
fn place(depth: f64) -> f64 {
    0.5 - ((1.0 - 2.0 * depth).clamp(-1.0, 1.0).asin() / 3.0).sin()
}

impl Slab {
    /// With so many nodes.
    pub fn new(count: usize) -> Slab {
        let x = gauss_legendre(count).into_iter().map(|node| (0.5 + 0.5 * node.x, 0.5 * node.weight));
        let (x, weight): (Vec<f64>, Vec<f64>) = x.map(|(x, w)| (x, w * 6.0 * x * (1.0 - x))).unzip();
        let depths = x.iter().map(|x| depth(*x)).collect();
        Slab { depth: depths, weight, basis: Lagrange::new(x), panel: gauss_legendre(PANEL) }
    }

    /// How many nodes.
    pub fn count(&self) -> usize {
        self.depth.len()
    }

    /// ∫ f(z') exp(−extinction (z − z')) dz' from 0 to z: the weights of f at the nodes.
    pub fn arriving(&self, extinction: f64, z: f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.count()];
        let mut from = z;
        for faded in FADED {
            let to = (z - faded / extinction).max(0.0);
            let [low, high] = [place(to), place(from)];
            for node in &self.panel {
                let x = low + (high - low) * 0.5 * (1.0 + node.x);
                let weight = 0.5 * node.weight * (high - low) * 6.0 * x * (1.0 - x);
                self.basis.add(x, weight * (-extinction * (z - depth(x))).exp(), &mut weights);
            }
            if to == 0.0 {
                break;
            }
            from = to;
        }
        weights
    }

    /// ∫ f(z) exp(−extinction z) dz over the layer: the same of what leaves it.
    pub fn leaving(&self, extinction: f64) -> Vec<f64> {
        let mut weights = self.arriving(extinction, 1.0);
        weights.reverse();
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_light_arrives_as_its_integral_says() {
        // f = exp(−p z): (exp(−p z) − exp(−t z))/(t − p).
        let slab = Slab::new(20);
        for (extinction, p) in [(0.01, 0.5), (1.0, 3.0), (30.0, 2.0), (1e4, 1.0)] {
            for z in [1e-5, 0.01, 0.3, 0.99, 1.0] {
                let arriving = slab.arriving(extinction, z);
                let found: f64 = arriving.iter().zip(&slab.depth).map(|(w, z)| w * (-p * z).exp()).sum();
                let (light, dark): (f64, f64) = ((-p * z).exp(), (-extinction * z).exp());
                let expected = (light - dark) / (extinction - p);
                assert!(
                    (found - expected).abs() < 1e-11 * (1.0 + 1.0 / extinction),
                    "{extinction} {z}: {found} {expected}"
                );
            }
        }
        let found: f64 = slab.leaving(30.0).iter().zip(&slab.depth).map(|(w, z)| w * (-2.0 * z).exp()).sum();
        assert!((found - (1.0 - (-32.0f64).exp()) / 32.0).abs() < 1e-12, "{found}");
    }

    #[test]
    fn slopes_like_a_logarithm_are_held() {
        let slab = Slab::new(20);
        let found: f64 = slab.weight.iter().zip(&slab.depth).map(|(w, z)| w * z * z.ln()).sum();
        assert!((found + 0.25).abs() < 3e-9, "{found}");
        let arriving = slab.arriving(2.0, 0.5);
        let found: f64 = arriving.iter().zip(&slab.depth).map(|(w, z)| w * z * z.ln()).sum();
        // ∫ z ln z exp(2z − 1) dz from 0 to 1/2, by its series.
        let term = |k: i32| {
            let (n, half) = (f64::from(k + 2), 0.5f64);
            let factorial: f64 = (1..=k).map(f64::from).product();
            2f64.powi(k) / factorial * half.powf(n) * (half.ln() / n - 1.0 / (n * n))
        };
        let expected = (-1.0f64).exp() * (0..30).map(term).sum::<f64>();
        assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
    }
}
