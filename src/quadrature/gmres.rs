// SPDX-License-Identifier: MIT OR Apache-2.0
//! A linear system that is known by what it does to a vector.

/// More steps than a system takes that is worth solving so.
const STEPS: usize = 600;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// x with x = source + map(x), until what is left of that is `tolerance` of the source, by the generalised minimal residual
/// method (Saad, Schultz 1986) without restarts.
pub fn fixed_point(source: &[f64], map: impl Fn(&[f64]) -> Vec<f64>, tolerance: f64) -> Vec<f64> {
    let norm = dot(source, source).sqrt();
    if norm == 0.0 {
        return source.to_vec();
    }
    // An orthonormal basis, and the map in it: a Hessenberg matrix by columns, made triangular by rotations.
    let mut basis = vec![source.iter().map(|x| x / norm).collect::<Vec<f64>>()];
    let mut columns: Vec<Vec<f64>> = vec![];
    let mut rotations: Vec<[f64; 2]> = vec![];
    let mut residual = vec![norm];
    while columns.len() < STEPS && residual[columns.len()].abs() > tolerance * norm {
        let last = &basis[columns.len()];
        let mut next: Vec<f64> = last.iter().zip(map(last)).map(|(x, y)| x - y).collect();
        let mut column = Vec::with_capacity(basis.len() + 1);
        for axis in &basis {
            let along = dot(axis, &next);
            next.iter_mut().zip(axis).for_each(|(x, a)| *x -= along * a);
            column.push(along);
        }
        let length = dot(&next, &next).sqrt();
        for (i, [cos, sin]) in rotations.iter().enumerate() {
            let [above, below] = [column[i], column[i + 1]];
            (column[i], column[i + 1]) = (cos * above + sin * below, cos * below - sin * above);
        }
        let k = column.len() - 1;
        let size = column[k].hypot(length);
        let [cos, sin] = [column[k] / size, length / size];
        column[k] = size;
        rotations.push([cos, sin]);
        residual.push(-sin * residual[k]);
        residual[k] *= cos;
        columns.push(column);
        basis.push(next.iter().map(|x| x / length.max(f64::MIN_POSITIVE)).collect());
    }
    // Back substitution, then the sum over the basis.
    let mut shares = residual;
    shares.truncate(columns.len());
    for i in (0..columns.len()).rev() {
        shares[i] /= columns[i][i];
        for j in 0..i {
            shares[j] -= columns[i][j] * shares[i];
        }
    }
    let mut x = vec![0.0; source.len()];
    for (share, axis) in shares.iter().zip(&basis) {
        x.iter_mut().zip(axis).for_each(|(x, a)| *x += share * a);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_points_of_linear_maps_are_found() {
        // Neighbours share 0.999 of what they have: plain iteration takes thousands of steps.
        let n = 40usize;
        let map = |x: &[f64]| -> Vec<f64> {
            let at = |i: usize| x.get(i).copied().unwrap_or(0.0);
            (0..n).map(|i| 0.3 * at(i.wrapping_sub(1)) + 0.699 * at(i + 1)).collect()
        };
        let source: Vec<f64> = (0..n).map(|i| f64::from(i as u32).sin()).collect();
        let x = fixed_point(&source, map, 1e-12);
        let left = source.iter().zip(map(&x)).zip(&x).map(|((s, m), x)| (s + m - x).abs()).fold(0.0, f64::max);
        assert!(left < 1e-10, "{left}");
        assert_eq!(fixed_point(&[0.0; 3], |x| x.to_vec(), 1e-12), [0.0; 3]);
    }
}
