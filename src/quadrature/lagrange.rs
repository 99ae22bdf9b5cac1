// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lagrange's polynomials: what a function known at a few nodes is between them.

/// The polynomials that are 1 at one of the nodes and 0 at the others, by the barycentric formula (Berrut, Trefethen 2004,
/// Barycentric Lagrange Interpolation, Eq. 4.2).
#[derive(Clone, Debug)]
pub struct Lagrange {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl Lagrange {
    /// Over these nodes, no two of which are the same. Up to some 60 of Gauss–Legendre's keep all but a few digits.
    pub fn new(nodes: Vec<f64>) -> Lagrange {
        let others = |k: usize| nodes.iter().enumerate().filter(move |(j, _)| *j != k).map(|(_, x)| *x);
        let weights = nodes.iter().enumerate().map(|(k, x)| 1.0 / others(k).map(|y| x - y).product::<f64>()).collect();
        Lagrange { nodes, weights }
    }

    /// Adds `weight` times each polynomial at `x` to `sums`: ∫ f ℓ over the terms of a quadrature rule.
    pub fn add(&self, x: f64, weight: f64, sums: &mut [f64]) {
        let mut norm = 0.0;
        for (k, (node, w)) in self.nodes.iter().zip(&self.weights).enumerate() {
            if x == *node {
                sums[k] += weight;
                return;
            }
            norm += w / (x - node);
        }
        let scale = weight / norm;
        for ((sum, node), w) in sums.iter_mut().zip(&self.nodes).zip(&self.weights) {
            *sum += scale * w / (x - node);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre::gauss_legendre;

    #[test]
    fn polynomials_are_met_between_and_at_the_nodes() {
        let nodes: Vec<f64> = gauss_legendre(24).iter().map(|node| node.x).collect();
        let f = |x: f64| 1.0 + x - 3.0 * x.powi(7) + x.powi(23);
        let basis = Lagrange::new(nodes.clone());
        for x in [-1.0, -0.3, 0.9, 1.0, nodes[5]] {
            let mut at = vec![0.0; 24];
            basis.add(x, 2.0, &mut at);
            let found: f64 = at.iter().zip(&nodes).map(|(l, node)| l * f(*node)).sum();
            assert!((found - 2.0 * f(x)).abs() < 1e-12, "{x}: {found} instead of {}", 2.0 * f(x));
        }
    }
}
