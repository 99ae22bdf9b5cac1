// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pair of rules of Gauss with 7 and Kronrod with 15 nodes, which share 7: two answers for the price of one, and their
//! difference says how far the poorer one is off.
//!
//! Abscissas and weights as in Piessens, de Doncker-Kapenga, Überhuber, Kahaner 1983, *QUADPACK*, routine QK15; the test
//! computes both rules' degrees.

/// Nodes of Kronrod's rule.
pub const NODES: usize = 15;

/// A node of both rules.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairNode {
    /// Abscissa.
    pub x: f64,
    /// Kronrod's weight.
    pub kronrod: f64,
    /// Gauss's weight; 0 where Gauss has no node.
    pub gauss: f64,
}

/// (abscissa, Kronrod's weight, Gauss's weight) of the nodes that are not negative, on [−1, 1].
const HALF: [(f64, f64, f64); 8] = [
    (0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4),
    (0.207_784_955_007_898_48, 0.204_432_940_075_298_89, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_42, 0.381_830_050_505_118_9),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.741_531_185_599_394_5, 0.140_653_259_715_525_92, 0.279_705_391_489_276_64),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_19, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_56, 0.129_484_966_168_869_7),
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
];

/// The nodes on [0, 1] in ascending order; the weights of each rule sum to 1.
pub fn on_unit_interval() -> [PairNode; NODES] {
    std::array::from_fn(|i| {
        let (x, kronrod, gauss) = HALF[i.abs_diff(NODES / 2)];
        let x = if i < NODES / 2 { -x } else { x };
        PairNode { x: 0.5 * (1.0 + x), kronrod: 0.5 * kronrod, gauss: 0.5 * gauss }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_rules_are_exact_to_their_degree_and_no_further() {
        let sum = |degree: i32, weight: fn(&PairNode) -> f64| {
            on_unit_interval().iter().map(|n| weight(n) * n.x.powi(degree)).sum::<f64>()
        };
        let exact = |degree: i32| 1.0 / (f64::from(degree) + 1.0);
        let (gauss, kronrod) = (|d| sum(d, |n| n.gauss) - exact(d), |d| sum(d, |n| n.kronrod) - exact(d));
        assert!((0..=13).all(|d| gauss(d).abs() < 2e-16) && gauss(14).abs() > 1e-9);
        // Behind its degree Kronrod's error grows out of rounding slowly.
        assert!((0..=23).all(|d| kronrod(d).abs() < 2e-16) && kronrod(28).abs() > 1e-13);
    }
}
