// SPDX-License-Identifier: MIT OR Apache-2.0
//! Irradiance as nine coefficients in a texture's meta, and in the forms that containers want them in.
//!
//! The key [`KEY`] holds e_lm for l ≤ 2, in the order and the orthonormal basis of [`crate::env::sh`]: three numbers, red,
//! green and blue, after each other for each. They are those of the irradiance over π, so that a white Lambert surface
//! with the normal n sends out
//!
//! ```text
//! E(n)/π = Σ e_lm Y_lm(n),    e_lm = A_l L_lm / π
//! ```

use std::f64::consts::PI;

use crate::env::Environment;
use crate::env::sh::{BASIS, basis, cosine_factor, project};
use crate::error::{Error, Result};
use crate::texture::Meta;

/// Where the coefficients are in the meta.
pub const KEY: &str = "sh.irradiance";
/// Functions with l ≤ 2.
pub const COUNT: usize = 9;

/// e_lm, red, green and blue.
pub type Irradiance = [[f64; 3]; COUNT];

/// Of an environment, turned as its frame says.
pub fn irradiance<'a>(environment: impl Into<Environment<'a>>) -> Irradiance {
    let radiance = project(environment, 2);
    std::array::from_fn(|i| radiance[i].map(|v| v * cosine_factor(BASIS[i].0) / PI))
}

/// States it in a texture's meta.
pub fn state(irradiance: &Irradiance, meta: &mut Meta) {
    let numbers: Vec<String> = irradiance.iter().flatten().map(|v| format!("{v:.8e}")).collect();
    meta.set(KEY, numbers.join(" "));
}

/// What a texture's meta states; `None` where it states nothing.
pub fn stated(meta: &Meta) -> Result<Option<Irradiance>> {
    let Some(text) = meta.get(KEY) else { return Ok(None) };
    let numbers: Vec<f64> = text.split(' ').filter_map(|n| n.parse().ok()).filter(|n: &f64| n.is_finite()).collect();
    let triples = numbers.as_chunks::<3>().0;
    match triples.try_into() {
        Ok(irradiance) if numbers.len() == 3 * COUNT => Ok(Some(irradiance)),
        _ => Err(Error::usage(format!("its {KEY} is not {} numbers", 3 * COUNT), "bake it again")),
    }
}

/// The factors of the basis: what stands before 1, y, z, x, xy, yz, 3z² − 1, zx and x² − y².
fn factors() -> [f64; COUNT] {
    let n = |numerator: f64, denominator: f64| (numerator / (denominator * PI)).sqrt();
    let (one, linear, product) = (n(1.0, 4.0), n(3.0, 4.0), n(15.0, 4.0));
    [one, linear, linear, linear, product, product, n(5.0, 16.0), product, n(15.0, 16.0)]
}

/// Filament's form, with the basis' factors multiplied in: E(n)/π is the sum of these nine times 1, y, z, x, xy, yz,
/// 3z² − 1, zx, x² − y² (filament: `libs/ibl/src/CubemapSH.cpp`, `shaders/src/surface_light_indirect.fs`).
pub fn prescaled(irradiance: &Irradiance) -> Irradiance {
    let factors = factors();
    std::array::from_fn(|i| irradiance[i].map(|v| v * factors[i]))
}

/// The names of [`polynomial`]'s coefficients, in its order.
pub const POLYNOMIAL: [&str; COUNT] = ["x", "y", "z", "xx", "yy", "zz", "yz", "zx", "xy"];

/// Babylon.js' `SphericalPolynomial`. Its shaders evaluate the harmonics that `SphericalHarmonics.FromPolynomial` makes of
/// it, which divides by A_l/π, so here the bands are multiplied with A_l/π once more, as its own `FromHarmonics` does. The
/// axes are those by which the cube itself is looked up: x is the middle of the face +X.
pub fn polynomial(irradiance: &Irradiance) -> Irradiance {
    let factors = factors();
    let scaled: Irradiance =
        std::array::from_fn(|i| irradiance[i].map(|v| v * factors[i] * cosine_factor(BASIS[i].0) / PI));
    let [one, y, z, x, xy, yz, z2, zx, x2] = scaled;
    let add = |parts: [(f64, [f64; 3]); 3]| -> [f64; 3] {
        std::array::from_fn(|c| parts.iter().map(|(share, part)| share * part[c]).sum())
    };
    // 1 = x² + y² + z², and 3z² − 1 = 2z² − x² − y².
    let xx = add([(1.0, one), (-1.0, z2), (1.0, x2)]);
    let yy = add([(1.0, one), (-1.0, z2), (-1.0, x2)]);
    let zz = add([(1.0, one), (2.0, z2), (0.0, x2)]);
    [x, y, z, xx, yy, zz, yz, zx, xy]
}

/// E(n)/π at a unit normal.
pub fn at(irradiance: &Irradiance, n: [f64; 3]) -> [f64; 3] {
    let basis = basis(n);
    std::array::from_fn(|c| (0..COUNT).map(|i| irradiance[i][c] * basis[i]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Equirect;

    const NORMALS: [[f64; 3]; 5] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.6, -0.64, 0.48], [-0.48, 0.6, 0.64]];

    fn sky() -> Irradiance {
        let light =
            |d: [f64; 3]| [1.0 + d[0], 2.0 + d[1] * d[2], if d[1] > 0.8 { 20.0 } else { 0.5 }].map(|v| v as f32);
        irradiance(&Equirect::from_fn(64, |u, v| light(Equirect::direction(u, v))))
    }

    #[test]
    fn irradiance_over_pi_is_the_cosine_weighted_mean() {
        // Linear light is what nine coefficients hold exactly: of 1 + x, E/π is 1 + 2x/3.
        let sky = sky();
        for n in NORMALS {
            let found = at(&sky, n);
            assert!((found[0] - (1.0 + 2.0 / 3.0 * n[0])).abs() < 1e-3, "{n:?}: {found:?}");
            assert!((found[1] - (2.0 + 0.25 * n[1] * n[2])).abs() < 1e-3, "{n:?}: {found:?}");
        }
    }

    #[test]
    fn filaments_form_has_the_same_value() {
        let sky = sky();
        for [x, y, z] in NORMALS {
            let terms = [1.0, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, z * x, x * x - y * y];
            let sh = prescaled(&sky);
            for (c, expected) in at(&sky, [x, y, z]).into_iter().enumerate() {
                let found: f64 = (0..COUNT).map(|i| sh[i][c] * terms[i]).sum();
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }

    #[test]
    fn babylons_harmonics_of_the_polynomial_have_the_same_value() {
        // SphericalHarmonics.FromPolynomial and SH3ylmBasisConstants of @babylonjs/core 9, which rounds to six digits.
        let sky = sky();
        let [x, y, z, xx, yy, zz, yz, zx, xy] = polynomial(&sky);
        for n in NORMALS {
            for (c, expected) in at(&sky, n).into_iter().enumerate() {
                let l = [
                    0.376127 * (xx[c] + yy[c]) + 0.376126 * zz[c],
                    -0.977204 * y[c],
                    0.977204 * z[c],
                    -0.977204 * x[c],
                    1.16538 * xy[c],
                    -1.16538 * yz[c],
                    1.34567 * zz[c] - 0.672834 * (xx[c] + yy[c]),
                    -1.16538 * zx[c],
                    1.16538 * (xx[c] - yy[c]),
                ];
                let signs = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
                let basis = basis(n);
                let found: f64 = (0..COUNT).map(|i| PI * l[i] * signs[i] * basis[i]).sum();
                assert!((found - expected).abs() < 1e-5 * expected.abs().max(1.0), "{found} {expected}");
            }
        }
    }

    #[test]
    fn what_is_stated_comes_back_or_is_refused() {
        let mut meta = Meta::default();
        assert_eq!(stated(&meta).unwrap(), None);
        let sky = sky();
        state(&sky, &mut meta);
        let found = stated(&meta).unwrap().unwrap();
        let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-8 * b.abs();
        assert!(found.iter().flatten().zip(sky.iter().flatten()).all(close));
        for text in ["", "1 2 3", "1 2 x", &"1 ".repeat(28), &"inf ".repeat(27)] {
            meta.set(KEY, text);
            assert!(stated(&meta).is_err(), "{text}");
        }
    }
}
