// SPDX-License-Identifier: MIT OR Apache-2.0
//! Gauss–Legendre nodes and weights. Shared with the build script, which writes them into the shaders.

/// A node in (−1, 1) and its weight; the weights of a rule sum to 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Abscissa.
    pub x: f64,
    /// Weight.
    pub weight: f64,
}

/// The `n`-point rule on [−1, 1] in ascending order, exact for polynomials of degree 2n − 1.
///
/// Roots of the Legendre polynomial Pₙ by Newton's method from Tricomi's starting values; weight 2/((1 − x²) Pₙ'(x)²)
/// (Abramowitz and Stegun 1964, Eq. 25.4.29). Good to a few ulp for n up to some hundreds.
pub fn gauss_legendre(n: usize) -> Vec<Node> {
    assert!(n > 0, "a quadrature rule needs a node");
    let mut nodes = vec![Node { x: 0.0, weight: 0.0 }; n];
    for i in 0..n.div_ceil(2) {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut derivative = 0.0;
        for _ in 0..100 {
            let (value, slope) = legendre(n, x);
            derivative = slope;
            let step = value / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        let weight = 2.0 / ((1.0 - x) * (1.0 + x) * derivative * derivative);
        nodes[i] = Node { x: -x, weight };
        nodes[n - 1 - i] = Node { x, weight };
    }
    if n % 2 == 1 {
        nodes[n / 2].x = 0.0;
    }
    nodes
}

/// Pₙ(x) and its derivative by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (previous, current) = (current, ((2.0 * k - 1.0) * x * current - (k - 1.0) * previous) / k);
    }
    let slope = n as f64 * (previous - x * current) / ((1.0 - x) * (1.0 + x));
    (current, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_is_exact_up_to_degree_2n_minus_1() {
        for n in [1, 2, 7, 16, 36] {
            let rule = gauss_legendre(n);
            for degree in 0..2 * n {
                let sum: f64 = rule.iter().map(|p| p.weight * p.x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-14, "n {n}, degree {degree}: {sum} instead of {exact}");
            }
        }
    }

    #[test]
    fn rule_is_not_exact_beyond() {
        let sum: f64 = gauss_legendre(3).iter().map(|p| p.weight * p.x.powi(6)).sum();
        assert!((sum - 2.0 / 7.0).abs() > 1e-3);
    }
}
