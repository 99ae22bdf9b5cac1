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
    (0.0, 0.209482141084727828012999174891714, 0.417959183673469387755102040816327),
    (0.207784955007898467600689403773245, 0.204432940075298892414161999234649, 0.0),
    (0.405845151377397166906606412076961, 0.190350578064785409913256402421014, 0.381830050505118944950369775488975),
    (0.586087235467691130294144691693013, 0.169004726639267902826583426598550, 0.0),
    (0.741531185599394439863864773280788, 0.140653259715525918745189590510238, 0.279705391489276667901467771423780),
    (0.864864423359769072789712788640926, 0.104790010322250183839876322541518, 0.0),
    (0.949107912342758524526189684047851, 0.063092092629978553290700663189204, 0.129484966168869693270611432679082),
    (0.991455371120812639206854697526329, 0.022935322010529224963732008058970, 0.0),
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
