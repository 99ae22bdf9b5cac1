// SPDX-License-Identifier: MIT OR Apache-2.0
//! Adaptive integration with an error estimate: the "other method" that checks the fixed rules.
//!
//! Every panel is integrated by one Gauss–Legendre rule and by the same rule on its two halves. The difference is the
//! estimate of the error of the *coarser* value while the finer one is kept, so the sum of the estimates is an upper
//! bound in practice, usually by orders of magnitude. The panel with the largest estimate is halved until the sum is
//! below the tolerance. The first two moments of the integrand are compared as well: two rules that miss the same peak can
//! agree on the integral by accident, but hardly on all three.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::LazyLock;

use super::gauss_legendre::{Node, gauss_legendre};

/// An integral, and how far it can be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<const N: usize> {
    /// The integrals of the N components of the integrand.
    pub value: [f64; N],
    /// Bound of the absolute error of the worst component.
    pub error: f64,
}

/// Nodes a panel half; 8 gives degree 15, enough that smooth panels converge at once.
static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| gauss_legendre(8));

/// One application of the rule: ∫ f, and ∫ f ξ and ∫ f ξ² with ξ running from −1 to 1 over the panel.
#[derive(Clone, Copy)]
struct Applied<const N: usize> {
    moments: [[f64; N]; 3],
    /// The integral of the integrand's own error bound.
    error: f64,
}

struct Panel<const N: usize> {
    from: f64,
    to: f64,
    halves: [Applied<N>; 2],
    error: f64,
}

impl<const N: usize> PartialEq for Panel<N> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl<const N: usize> Eq for Panel<N> {}
impl<const N: usize> PartialOrd for Panel<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl<const N: usize> Ord for Panel<N> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

/// Integrates `f` over the panels between consecutive `breaks` (ascending) to an absolute `tolerance`.
///
/// The integrand may return an error bound of its own with each value (a nested integral has one); it is integrated
/// along and added. After `max_panels` panels the best value is returned with its honest, larger error.
pub fn integrate<const N: usize>(
    breaks: &[f64],
    tolerance: f64,
    max_panels: usize,
    mut f: impl FnMut(f64) -> Estimate<N>,
) -> Estimate<N> {
    let mut rule = |from: f64, to: f64| {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut applied = Applied { moments: [[0.0; N]; 3], error: 0.0 };
        for node in RULE.iter() {
            let sample = f(middle + half * node.x);
            let weight = node.weight * half;
            for (i, v) in sample.value.into_iter().enumerate() {
                applied.moments[0][i] += weight * v;
                applied.moments[1][i] += weight * v * node.x;
                applied.moments[2][i] += weight * v * node.x * node.x;
            }
            applied.error += weight * sample.error;
        }
        applied
    };

    let mut heap = BinaryHeap::new();
    for ends in breaks.windows(2) {
        if ends[1] > ends[0] {
            let whole = rule(ends[0], ends[1]);
            heap.push(split(&mut rule, ends[0], ends[1], whole));
        }
    }
    let mut error: f64 = heap.iter().map(|p| p.error).sum();
    while error > tolerance && heap.len() < max_panels {
        let Some(worst) = heap.pop() else { break };
        let middle = 0.5 * (worst.from + worst.to);
        if middle <= worst.from || middle >= worst.to {
            heap.push(worst);
            break;
        }
        let children = [
            split(&mut rule, worst.from, middle, worst.halves[0]),
            split(&mut rule, middle, worst.to, worst.halves[1]),
        ];
        error += children[0].error + children[1].error - worst.error;
        heap.extend(children);
    }

    let mut value = [0.0; N];
    let mut error = 0.0;
    for panel in &heap {
        for (i, v) in value.iter_mut().enumerate() {
            *v += panel.halves[0].moments[0][i] + panel.halves[1].moments[0][i];
        }
        error += panel.error + panel.halves[0].error + panel.halves[1].error;
    }
    Estimate { value, error }
}

/// Halves a panel to which the rule was applied as a `whole`.
fn split<const N: usize>(
    rule: &mut impl FnMut(f64, f64) -> Applied<N>,
    from: f64,
    to: f64,
    whole: Applied<N>,
) -> Panel<N> {
    let middle = 0.5 * (from + to);
    let halves = [rule(from, middle), rule(middle, to)];
    let mut error = 0.0;
    for i in 0..N {
        // The halves' moments in the whole's ξ: a half's own ξ is 2ξ ± 1.
        let [left, right] = [0, 1].map(|h| halves[h].moments.map(|m| m[i]));
        let fine = [
            left[0] + right[0],
            0.5 * (left[1] - left[0] + right[1] + right[0]),
            0.25 * (left[2] - 2.0 * left[1] + left[0] + right[2] + 2.0 * right[1] + right[0]),
        ];
        for (moment, fine) in fine.into_iter().enumerate() {
            error = f64::max(error, (whole.moments[moment][i] - fine).abs());
        }
    }
    Panel { from, to, halves, error }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(v: f64) -> Estimate<1> {
        Estimate { value: [v], error: 0.0 }
    }

    #[test]
    fn smooth_integral_is_exact() {
        let e = integrate(&[0.0, 1.0], 1e-12, 1000, |x| plain(x.exp()));
        assert!((e.value[0] - (1f64.exp() - 1.0)).abs() < 1e-14 && e.error < 1e-12);
    }

    #[test]
    fn kink_is_found_and_bounded() {
        let e = integrate(&[0.0, 1.0], 1e-10, 1000, |x| plain((x - 0.3).abs()));
        let truth = 0.5 * (0.3 * 0.3 + 0.7 * 0.7);
        assert!((e.value[0] - truth).abs() <= e.error && e.error <= 1e-10, "{e:?}");
    }

    #[test]
    fn too_few_panels_give_a_large_error_not_a_wrong_claim() {
        let e = integrate(&[0.0, 1.0], 1e-12, 4, |x| plain(1.0 / (1e-6 + x * x)));
        let truth = 1e3 * (1e3f64).atan();
        assert!(e.error > 1.0 && (e.value[0] - truth).abs() <= e.error);
    }
}
