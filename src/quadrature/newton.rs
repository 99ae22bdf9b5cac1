// SPDX-License-Identifier: MIT OR Apache-2.0
//! A minimum of a smooth function of a few variables by Newton's method, damped where the function is not convex.

/// A function at a place.
#[derive(Clone, Copy, Debug)]
pub struct Local<const N: usize> {
    /// Its value.
    pub value: f64,
    /// Its first derivatives.
    pub gradient: [f64; N],
    /// Its second derivatives, of which the lower triangle is read.
    pub hessian: [[f64; N]; N],
}

/// A place that Newton's method found.
#[derive(Clone, Copy, Debug)]
pub struct Minimum<const N: usize> {
    /// Where.
    pub at: [f64; N],
    /// The value there.
    pub value: f64,
    /// No step made it smaller: `false` where the steps ran out.
    pub converged: bool,
}

/// More steps than a fit takes that goes anywhere.
const STEPS: usize = 200;
/// A step that moves no variable by more than this share of the largest one that is allowed ends the search.
const SMALL: f64 = 1e-8;
/// Damping at the start, against a diagonal of 1.
const DAMPING: f64 = 1e-3;
/// With so much damping a step is too small to move anything.
const MOST_DAMPING: f64 = 1e12;

/// Goes down from `start`. `value` is the function, `local` the same with its derivatives, `longest` the largest change of
/// each variable in one step.
///
/// The step solves (H + damping) s = −g with H scaled to a diagonal of ±1; where that matrix is not positive definite, the
/// step is too long or the function does not fall, there is more damping (Levenberg 1944, Marquardt 1963).
pub fn newton<const N: usize>(
    start: [f64; N],
    value: impl Fn(&[f64; N]) -> f64,
    local: impl Fn(&[f64; N]) -> Local<N>,
    longest: impl Fn(&[f64; N]) -> [f64; N],
) -> Minimum<N> {
    let mut at = start;
    let mut here = local(&at);
    let mut damping = DAMPING;
    for _ in 0..STEPS {
        let limits = longest(&at);
        let mut too_long = false;
        loop {
            if damping > MOST_DAMPING {
                return Minimum { at, value: here.value, converged: !too_long };
            }
            let step = step(&here, damping).filter(|s| s.iter().zip(limits).all(|(s, limit)| s.abs() <= limit));
            let Some(step) = step else {
                damping = (4.0 * damping).max(DAMPING);
                too_long = true;
                continue;
            };
            too_long = false;
            let next: [f64; N] = std::array::from_fn(|i| at[i] + step[i]);
            let small = step.iter().zip(limits).all(|(s, limit)| s.abs() <= SMALL * limit);
            let falls = value(&next) <= here.value;
            if falls {
                at = next;
                here = local(&at);
                damping *= 0.1;
            }
            if small {
                return Minimum { at, value: here.value, converged: true };
            }
            if falls {
                break;
            }
            damping = (8.0 * damping).max(1e-6);
        }
    }
    Minimum { at, value: here.value, converged: false }
}

/// The damped step by Cholesky's decomposition; `None` where the damped matrix is not positive definite.
fn step<const N: usize>(here: &Local<N>, damping: f64) -> Option<[f64; N]> {
    let scale: [f64; N] = std::array::from_fn(|i| here.hessian[i][i].abs().max(f64::MIN_POSITIVE).sqrt());
    let mut lower = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let mut sum = here.hessian[i][j] / (scale[i] * scale[j]);
            if i == j {
                sum += damping;
            }
            sum -= (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            if i == j && (sum.is_nan() || sum <= 1e-14) {
                return None;
            }
            lower[i][j] = if i == j { sum.sqrt() } else { sum / lower[j][j] };
        }
    }
    let mut x = [0.0; N];
    for i in 0..N {
        x[i] = (-here.gradient[i] / scale[i] - (0..i).map(|k| lower[i][k] * x[k]).sum::<f64>()) / lower[i][i];
    }
    for i in (0..N).rev() {
        x[i] = (x[i] - (i + 1..N).map(|k| lower[k][i] * x[k]).sum::<f64>()) / lower[i][i];
    }
    Some(std::array::from_fn(|i| x[i] / scale[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley: curved, and not convex everywhere. Its minimum is 0 at (1, 1).
    fn valley([x, y]: &[f64; 2]) -> Local<2> {
        let (a, b) = (1.0 - x, y - x * x);
        Local {
            value: a * a + 100.0 * b * b,
            gradient: [-2.0 * a - 400.0 * x * b, 200.0 * b],
            hessian: [[2.0 - 400.0 * (b - 2.0 * x * x), -400.0 * x], [-400.0 * x, 200.0]],
        }
    }

    #[test]
    fn the_bottom_of_a_curved_valley_is_found() {
        for start in [[-1.2, 1.0], [0.0, 3.0], [2.0, -1.0]] {
            let found = newton(start, |p| valley(p).value, valley, |_| [0.5; 2]);
            assert!(found.converged && found.at.iter().all(|x| (x - 1.0).abs() < 1e-7), "{start:?}: {found:?}");
        }
    }

    #[test]
    fn a_function_without_a_minimum_does_not_converge() {
        let slope = |p: &[f64; 1]| Local { value: -p[0], gradient: [-1.0], hessian: [[0.0]] };
        assert!(!newton([0.0], |p| -p[0], slope, |_| [1.0]).converged);
    }
}
