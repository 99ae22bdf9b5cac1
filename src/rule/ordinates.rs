// SPDX-License-Identifier: MIT OR Apache-2.0
//! Polar angles between which light scatters, and the weights with which upright fibres join them.
//!
//! Fibres scatter along a ridge: light keeps its angle to them but for about their cross section sigma. Between nodes lies a
//! polynomial, and the product of the ridge and each node's polynomial is integrated by itself (product integration), so that
//! a ridge of any width sends on all that it gets, no matter how far apart the nodes are.
//!
//! Cosines are scale · sinh t, with nodes of Gauss and Legendre in panels of t: as fine as the flakes around the horizon, where
//! light is turned back, and in proportion to the cosine beyond.

use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::quadrature::lagrange::Lagrange;
use crate::rule::flake_modes::flake_modes;

/// Nodes of a panel over which the ridge is integrated, and its longest length in units of the coordinate that resolves it.
const RIDGE_NODES: usize = 10;
const RIDGE_PANEL: f64 = 1.5;
/// Width of that coordinate's even part over the ridge's.
const RIDGE: f64 = 0.3;

/// Cosines of one half of all directions; the other half mirrors them.
pub struct Ordinates {
    sigma: f64,
    /// Cosine = scale · sinh t.
    scale: f64,
    /// Length of a panel in t.
    panel: f64,
    panels: usize,
    /// Cosines in (0, 1), ascending.
    pub cos: Vec<f64>,
    /// ∫ dcos that each stands for.
    pub weight: Vec<f64>,
    basis: Lagrange,
    ridge: Vec<Node>,
}

impl Ordinates {
    /// Panels of `nodes` that are at most `longest` long.
    pub fn new(sigma: f64, scale: f64, nodes: usize, longest: f64) -> Ordinates {
        let last = (1.0 / scale).asinh();
        let panels = (last / longest).ceil() as usize;
        let panel = last / panels as f64;
        let rule = gauss_legendre(nodes);
        let (mut cos, mut weight) = (vec![], vec![]);
        for i in 0..panels {
            for node in &rule {
                let t = panel * (i as f64 + 0.5 + 0.5 * node.x);
                cos.push(scale * t.sinh());
                weight.push(0.5 * node.weight * panel * scale * t.cosh());
            }
        }
        let basis = Lagrange::new(rule.iter().map(|node| node.x).collect());
        Ordinates { sigma, scale, panel, panels, cos, weight, basis, ridge: gauss_legendre(RIDGE_NODES) }
    }

    /// How many there are of each half.
    pub fn count(&self) -> usize {
        self.cos.len()
    }

    /// ∫ of each mode of the rate from light at `cos`, times what is known at the ordinates, over the cosines of the same half
    /// of all directions and of the other half: the weights of the ordinates, mode by mode.
    ///
    /// Domain: `cos` in (0, 1].
    pub fn joined(&self, cos: f64, modes: usize) -> Vec<[Vec<f64>; 2]> {
        let mut joined = vec![[(); 2].map(|()| vec![0.0; self.count()]); modes];
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let width = RIDGE * self.sigma * sin.max(self.sigma);
        let nodes = self.count() / self.panels;
        let mut rates = vec![0.0; modes];
        let mut at_nodes = vec![0.0; nodes];
        for (half, side) in [1.0, -1.0].into_iter().enumerate() {
            for panel in 0..self.panels {
                let end = |i: usize| if i == self.panels { 1.0 } else { self.scale * (self.panel * i as f64).sinh() };
                let [low, high] = [end(panel), end(panel + 1)];
                let inside = side > 0.0 && low < cos && cos < high;
                let ends = if inside { vec![low, cos, high] } else { vec![low, high] };
                for pair in ends.windows(2) {
                    let [from, to] = [pair[0], pair[1]].map(|end| ((side * end - cos) / width).asinh());
                    let parts = ((to - from).abs() / RIDGE_PANEL).ceil();
                    let step = (to - from) / parts;
                    for part in 0..parts as usize {
                        for node in &self.ridge {
                            let y = from + step * (part as f64 + 0.5 + 0.5 * node.x);
                            let other = (cos + width * y.sinh()).clamp(-1.0, 1.0);
                            let weight = 0.5 * node.weight * step.abs() * width * y.cosh();
                            flake_modes(self.sigma, cos, other, &mut rates);
                            let t = (other.abs() / self.scale).asinh() / self.panel - panel as f64;
                            at_nodes.fill(0.0);
                            self.basis.add(2.0 * t - 1.0, weight, &mut at_nodes);
                            for (mode, rate) in joined.iter_mut().zip(&rates) {
                                let sums = &mut mode[half][panel * nodes..(panel + 1) * nodes];
                                sums.iter_mut().zip(&at_nodes).for_each(|(sum, weight)| *sum += rate * weight);
                            }
                        }
                    }
                }
            }
        }
        joined
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fibres_absorb_nothing() {
        for sigma in [1e-4, 0.01, 0.3, 1.0] {
            let ordinates = Ordinates::new(sigma, 0.1 * sigma, 8, 1.2);
            for cos in [0.01, 0.4, ordinates.cos[9], 0.999, 1.0] {
                let [same, opposite] = &ordinates.joined(cos, 1)[0];
                let sum: f64 = same.iter().chain(opposite).sum();
                let area = (1.0 - cos * cos + sigma * sigma * cos * cos).sqrt();
                assert!((sum - area).abs() < 1e-9, "{sigma} {cos}: {sum} instead of {area}");
            }
        }
    }
}
