// SPDX-License-Identifier: MIT OR Apache-2.0
//! The Chebyshev expansion: a whole table from the values at a few thousand points.
//!
//! Over ln(n·v) and ln(roughness) the tables of smooth lobes are smooth, so that a product of two Chebyshev series
//! Σ c_ij T_i(x) T_j(y) through the values at the n × m Chebyshev points of a rectangle converges geometrically (Trefethen
//! 2019, *Approximation Theory and Approximation Practice*, theorem 8.2). A quadrature rule then runs at n·m points, 2,048 to
//! 3,200 for GGX, whatever the size of the table, and each texel costs one sum along n·v and a share of the row's sum along
//! roughness. √(n·v), or n·v over alpha, converge far worse.
//!
//! The coefficients say themselves whether that works: a table with a kink has coefficients that fall like a power only.
//! [`Expansion::tail`] continues their decay beyond the last ones. Measured for GGX with height-correlated Smith, f64, both
//! coordinates from 1/1024: 32 × 64 terms 4e-7, 40 × 80 1.0e-7, 48 × 96 2e-8.

use std::f64::consts::PI;

use crate::term::fresnel::{WEIGHTS, Weights};

/// Numbers of terms along n·v and roughness that are tried in turn.
pub const TERMS: [[usize; 2]; 4] = [[32, 64], [40, 80], [48, 96], [72, 128]];

/// Sums of coefficients below this are rounding of the values and decay no further.
const FLOOR: f64 = 1e-9;

/// A positive range over which a series runs evenly in the logarithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Least coordinate, above 0.
    pub low: f64,
    /// Greatest coordinate, above `low`.
    pub high: f64,
}

impl Domain {
    /// The position of a coordinate in [−1, 1].
    pub fn position(&self, coordinate: f64) -> f64 {
        2.0 * (coordinate / self.low).ln() / (self.high / self.low).ln() - 1.0
    }

    /// The coordinate at a share in [0, 1] of the way from the least to the greatest.
    pub fn at(&self, share: f64) -> f64 {
        (self.low * (share * (self.high / self.low).ln()).exp()).clamp(self.low, self.high)
    }

    /// The coordinates of the `n` Chebyshev points x_j = cos((j + ½) π/n).
    pub fn points(&self, n: usize) -> Vec<f64> {
        (0..n).map(|j| self.at(0.5 * (1.0 + ((j as f64 + 0.5) * PI / n as f64).cos()))).collect()
    }
}

/// A product of two Chebyshev series for each of [`WEIGHTS`] values.
#[derive(Clone, Debug)]
pub struct Expansion {
    /// Terms along n·v and roughness.
    pub terms: [usize; 2],
    /// The coefficient of T_i(n·v) T_j(roughness) at `i * terms[1] + j`.
    pub coefficients: Vec<Weights>,
}

impl Expansion {
    /// The expansion through values at Chebyshev points: point i along n·v and j along
    /// roughness at `i * terms[1] + j`.
    pub fn through(values: &[Weights], terms: [usize; 2]) -> Expansion {
        let [n, m] = terms;
        assert_eq!(values.len(), n * m, "a value for each point");
        let (along_n_dot_v, along_roughness) = (transform(n), transform(m));
        let weighed = |row: &[f64], at: &dyn Fn(usize) -> Weights| {
            let mut sum = [0.0; WEIGHTS];
            for (k, t) in row.iter().enumerate() {
                sum.iter_mut().zip(at(k)).for_each(|(s, v)| *s += t * v);
            }
            sum
        };
        let mut half = Vec::with_capacity(n * m);
        for i in 0..n {
            half.extend((0..m).map(|j| weighed(&along_roughness[j], &|k| values[i * m + k])));
        }
        let mut coefficients = Vec::with_capacity(n * m);
        for weights in &along_n_dot_v {
            coefficients.extend((0..m).map(|j| weighed(weights, &|k| half[k * m + j])));
        }
        Expansion { terms, coefficients }
    }

    /// The series along n·v at a position in [−1, 1] along roughness.
    pub fn row(&self, roughness: f64) -> Vec<Weights> {
        self.coefficients.chunks_exact(self.terms[1]).map(|row| sum(row, roughness)).collect()
    }

    /// The value at a position in [−1, 1]².
    pub fn at(&self, n_dot_v: f64, roughness: f64) -> Weights {
        sum(&self.row(roughness), n_dot_v)
    }

    /// What the terms beyond the last ones add to the chosen values at most, if the coefficients go on decaying as they do:
    /// along each axis from the third to the last quarter by a factor q, the last quarter's sum times q/(1 − q). Infinite
    /// where they do not decay.
    pub fn tail(&self, chosen: &[usize]) -> f64 {
        let [n, m] = self.terms;
        let along = |len: usize, sum: &dyn Fn(usize, usize) -> f64| {
            let quarter =
                |k: usize, weight: usize| (k * len / 4..(k + 1) * len / 4).map(|i| sum(i, weight)).sum::<f64>();
            let of = |weight: usize| {
                let (third, last) = (quarter(2, weight), quarter(3, weight));
                let q = last / third.max(f64::MIN_POSITIVE);
                if last < FLOOR {
                    last
                } else if q < 1.0 {
                    last * q / (1.0 - q)
                } else {
                    f64::INFINITY
                }
            };
            // NaN is the greatest.
            chosen.iter().copied().map(of).max_by(f64::total_cmp).unwrap_or(f64::NAN)
        };
        let c = |i: usize, j: usize, weight: usize| self.coefficients[i * m + j][weight].abs();
        along(n, &|i, weight| (0..m).map(|j| c(i, j, weight)).sum())
            + along(m, &|j, weight| (0..n).map(|i| c(i, j, weight)).sum())
    }
}

/// Row k: what each of the n values at Chebyshev points contributes to coefficient k.
fn transform(n: usize) -> Vec<Vec<f64>> {
    let scale = |k: usize| if k == 0 { 1.0 } else { 2.0 } / n as f64;
    let entry = |k: usize, j: usize| scale(k) * (k as f64 * (j as f64 + 0.5) * PI / n as f64).cos();
    (0..n).map(|k| (0..n).map(|j| entry(k, j)).collect()).collect()
}

/// Σ c_k T_k(x) by the recurrence T_(k+1) = 2 x T_k − T_(k−1). The f64 twin of `shaders/bake/expansion.comp`.
pub fn sum(coefficients: &[Weights], x: f64) -> Weights {
    let (mut now, mut next) = (1.0, x);
    let mut sum = [0.0; WEIGHTS];
    for c in coefficients {
        sum.iter_mut().zip(c).for_each(|(s, c)| *s += now * c);
        (now, next) = (next, 2.0 * x * next - now);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOMAIN: Domain = Domain { low: 1.0 / 1024.0, high: 1.0 };

    fn expand(terms: [usize; 2], f: impl Fn(f64, f64) -> f64) -> Expansion {
        let [xs, ys] = terms.map(|n| DOMAIN.points(n));
        let values: Vec<Weights> = xs.iter().flat_map(|x| ys.iter().map(|y| [f(*x, *y), 0.0, 0.0, 0.0])).collect();
        Expansion::through(&values, terms)
    }

    fn worst(expansion: &Expansion, f: impl Fn(f64, f64) -> f64) -> f64 {
        let at = |i: u32| DOMAIN.low.powf(f64::from(i) / 40.0);
        let pairs = (0..=40).flat_map(|i| (0..=40).map(move |j| (at(i), at(j))));
        pairs
            .map(|(x, y)| (expansion.at(DOMAIN.position(x), DOMAIN.position(y))[0] - f(x, y)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn smooth_function_is_met_within_its_tail() {
        let f = |x: f64, y: f64| x / (x + y);
        for terms in [[16, 16], [24, 24], [32, 64]] {
            let expansion = expand(terms, f);
            let (worst, tail) = (worst(&expansion, f), expansion.tail(&[0]));
            assert!(worst <= tail.max(1e-12) && tail < 1.0, "{terms:?}: {worst:e}, tail {tail:e}");
        }
        assert!(expand([32, 64], f).tail(&[0]) < 1e-6);
    }

    #[test]
    fn kink_is_seen_in_the_tail() {
        let f = |x: f64, y: f64| (x - y).abs().max((0.1 - x).max(0.0));
        let expansion = expand([72, 96], f);
        let (worst, tail) = (worst(&expansion, f), expansion.tail(&[0]));
        assert!(tail > 1e-4 && worst <= tail, "{worst:e}, tail {tail:e}");
    }

    #[test]
    fn one_value_that_is_no_number_is_seen() {
        let expansion = expand([16, 16], |x, y| if x > 0.9 && y > 0.9 { f64::NAN } else { x });
        assert!(!expansion.tail(&[0]).is_finite());
    }
}
