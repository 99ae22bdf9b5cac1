// SPDX-License-Identifier: MIT OR Apache-2.0
//! Beckmann: a surface whose slopes are normally distributed.

use std::f64::consts::PI;

use super::{Family, Flat, Lobe, bell};

/// Registry entry.
pub static BECKMANN: Family = Family {
    name: "beckmann",
    also: &[],
    about: "Beckmann: normally distributed slopes, alpha is their root mean square",
    source: "Walter, Marschner, Li, Torrance 2007, Eq. 25 and 26; Beckmann, Spizzichino 1963",
    parameters: &[],
    lobe: |alpha, _| Lobe { alpha, peak: alpha, shape: [0.0; 3] },
    d,
    sigma: Some(sigma),
    flat: Flat {
        tan: |y, lobe| lobe.alpha * y,
        y: |tan, lobe| tan / lobe.alpha,
        density: |y, _, _| bell(y),
        y_max: 5.0,
        falling: false,
    },
};

/// D(h) = exp(−tan²/alpha²)/(π alpha² cos⁴) per steradian. Walter et al. 2007, Eq. 25.
fn d(cos2: f64, sin2: f64, lobe: &Lobe) -> f64 {
    if cos2 == 0.0 {
        return 0.0;
    }
    let a2 = lobe.alpha * lobe.alpha;
    (-sin2 / (a2 * cos2)).exp() / (PI * a2 * cos2 * cos2)
}

/// Smith's projected area n·x (1 + Λ), Λ = exp(−z²)/(2z√π) − erfc(z)/2, z = cot θ/alpha (Heitz 2014, Eq. 72; Walter
/// et al. 2007, Eq. 26), with n·x/z = alpha sin θ taken together: finite at grazing.
fn sigma(n_dot_x: f64, lobe: &Lobe) -> f64 {
    let sin = ((1.0 - n_dot_x) * (1.0 + n_dot_x)).sqrt();
    let z = n_dot_x / (lobe.alpha * sin);
    if z > 6.0 {
        return n_dot_x;
    }
    n_dot_x + 0.5 * (lobe.alpha * sin * (-z * z).exp() / PI.sqrt() - n_dot_x * erfc(z))
}

/// The complementary error function. Domain: x in [0, 6]. Abramowitz, Stegun 1964: the series 7.1.6, all of whose terms
/// are positive, up to 2.5; beyond, the continued fraction 7.1.14. Within 4e-16.
fn erfc(x: f64) -> f64 {
    let gauss = (-x * x).exp() / PI.sqrt();
    if x < 2.5 {
        let (mut term, mut sum, mut n) = (x, x, 0.0);
        while term > 1e-17 * sum {
            n += 1.0;
            term *= 2.0 * x * x / (2.0 * n + 1.0);
            sum += term;
        }
        1.0 - 2.0 * gauss * sum
    } else {
        let tail = (1..=40).rev().fold(x, |tail, n| x + 0.5 * f64::from(n) / tail);
        gauss / tail
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erfc_has_its_published_values() {
        // Abramowitz, Stegun 1964, table 7.1 and 7.3.
        for (x, value) in [(0.0, 1.0), (0.5, 0.479_500_122_2), (1.0, 0.157_299_207_1), (2.0, 0.004_677_734_981_05)] {
            assert!((erfc(x) - value).abs() < 1e-10, "{x}: {}", erfc(x));
        }
        assert!((erfc(2.5 - 1e-12) / erfc(2.5) - 1.0).abs() < 1e-10, "the two branches meet");
    }

    #[test]
    fn closed_form_agrees_with_the_integral() {
        for alpha in [1e-3, 0.1, 1.0] {
            let lobe = (BECKMANN.lobe)(alpha, &[None; 2]);
            for x in [1e-4, 0.01, 0.2, 0.7, 1.0] {
                let integral = x + super::super::smith_excess(x, &BECKMANN.flat, &lobe);
                assert!((sigma(x, &lobe) - integral).abs() < 1e-11 * alpha.max(x), "{alpha} {x}");
            }
        }
    }
}
