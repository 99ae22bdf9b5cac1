// SPDX-License-Identifier: MIT OR Apache-2.0
//! What upright fibres send from one polar angle to another, in Fourier modes of the azimuth between.
//!
//! A specular SGGX microflake scatters light that flies along w' into w at the rate D(h)/4 per unit of length and steradian,
//! h being along w − w' (Heitz, Dupuy, Crassin, Dachsbacher 2015, The SGGX Microflake Distribution, Eq. 17 times the projected
//! area). With u = cos θ, s = sin θ, q = |w − w'|² = A − B cos φ, A = 2 − 2uu', B = 2ss', and e = (1/sigma² − 1)(u − u')²
//! fibres about the normal make that
//!
//! D/4 = (q/(q + e))²/(4π sigma),
//!
//! a rational function of cos φ, whose modes ∫ … cos(mφ) dφ over a turn are powers of t = B/(P + r), P = A + e,
//! r = √(P² − B²), times factors that are written without cancellation here. Mode 0 integrates over u' from −1 to 1 to the
//! projected area √(s² + sigma² u²): fibres absorb nothing.

/// ∫ D(h)/4 cos(mφ) dφ over a turn for m = 0, 1, …, one value of `modes` each.
///
/// Domain: sigma in (0, 1], cosines `u` ≠ `other` of directions of flight in [−1, 1].
pub fn flake_modes(sigma: f64, u: f64, other: f64, modes: &mut [f64]) {
    let [s, t] = [u, other].map(|x: f64| ((1.0 - x) * (1.0 + x)).max(0.0).sqrt());
    let step = u - other;
    // s − t without cancellation.
    let apart = step * (u + other) / (s + t).max(1e-300);
    let e = (1.0 - sigma) * (1.0 + sigma) / (sigma * sigma) * step * step;
    let b = 2.0 * s * t;
    let near = step * step + apart * apart;
    let (a, p) = (near + b, near + b + e);
    let r = ((near + e) * (near + 2.0 * b + e)).sqrt();
    // r − e and A less that.
    let rho = (near * (a + b) + 2.0 * a * e) / (r + e);
    let delta = b * b / (r + p);
    let scale = 0.5 / (sigma * r * r * r);
    let ratio = b / (p + r);
    let base = e * (delta - 2.0 * rho) - 2.0 * rho * rho;
    let mut power = scale * e;
    for (m, mode) in modes.iter_mut().enumerate() {
        *mode = match m {
            0 => scale * (rho * rho * (rho + e) + e * e * delta),
            _ => {
                power *= ratio;
                power * ((m - 1) as f64 * e * r + base)
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// D/4 by its definition.
    fn rate(sigma: f64, u: f64, other: f64, phi: f64) -> f64 {
        let [s, t] = [u, other].map(|x: f64| (1.0 - x * x).sqrt());
        let h = [s - t * phi.cos(), t * phi.sin(), u - other];
        let length2 = h.iter().map(|c| c * c).sum::<f64>();
        let cos2 = h[2] * h[2] / length2;
        let w = sigma * sigma * (1.0 - cos2) + cos2;
        0.25 * sigma.powi(3) / (PI * w * w)
    }

    #[test]
    fn modes_are_integrals_over_the_azimuth() {
        for (sigma, u, other) in
            [(1.0, 0.3, -0.4), (0.5, 0.9, 0.2), (0.1, 0.05, -0.05), (0.02, 0.3, 0.31), (0.1, 1.0, 0.98)]
        {
            let mut modes = [0.0; 6];
            flake_modes(sigma, u, other, &mut modes);
            for (m, mode) in modes.iter().enumerate() {
                // The trapezoid rule over a turn of a smooth function.
                let n = 20_000;
                let phi = |i: usize| TAU * i as f64 / f64::from(n);
                let term = |i: usize| rate(sigma, u, other, phi(i)) * (m as f64 * phi(i)).cos();
                let sum = TAU / f64::from(n) * (0..n as usize).map(term).sum::<f64>();
                assert!((mode - sum).abs() < 1e-9 / sigma, "{sigma} {u} {other} {m}: {mode} instead of {sum}");
            }
        }
    }

    #[test]
    fn modes_far_from_the_ridge_keep_their_digits() {
        // There D/4 is q²/(4π sigma e²) but for terms of sigma²: modes of (A − B cos φ)².
        let (sigma, u, other) = (1e-4, 0.5, -0.4);
        let mut modes = [0.0; 4];
        flake_modes(sigma, u, other, &mut modes);
        let e = 0.81 / (sigma * sigma);
        let (a, b) = (2.0 - 2.0 * u * other, 2.0 * f64::sqrt((1.0 - u * u) * (1.0 - other * other)));
        let scale = 0.5 / (sigma * e * e);
        for (mode, expected) in modes.iter().zip([a * a + 0.5 * b * b, -a * b, 0.25 * b * b, 0.0]) {
            assert!((mode - scale * expected).abs() < 1e-6 * scale, "{mode} instead of {}", scale * expected);
        }
    }
}
