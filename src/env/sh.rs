// SPDX-License-Identifier: MIT OR Apache-2.0
//! Real spherical harmonics of an environment, up to l = 4.
//!
//! **Basis.** Orthonormal on the sphere, as polynomials of the unit direction (x, y, z) without the Condon–Shortley phase
//! ([`BASIS`]; Ramamoorthi, Hanrahan 2001, Eq. 3; Sloan 2008, appendix A2). The coefficient of (l, m) is at index l² + l + m. A coefficient is
//!
//! ```text
//! L_lm = ∫ L(ω) Y_lm(ω) dω,    L(ω) ≈ Σ L_lm Y_lm(ω),    E(n) = Σ A_l L_lm Y_lm(n)
//! ```
//!
//! with A_l = π, 2π/3, π/4, 0, −π/24 (Ramamoorthi, Hanrahan 2001, Eqs. 8 and 9).
//!
//! **Integration.** Exact for the piecewise constant picture, to f64 rounding: in harmonics about the picture's axis, a
//! texel's integral is a product of ∫ cos mφ dφ (closed) and ∫ Θ_lm(θ) sin θ dθ (Gauss–Legendre, far below 1e-14 over a
//! row). The change to harmonics about +Z is a linear map within each l, found by a quadrature that is exact for it.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::{CubeMap, Environment, Equirect, Frame, Picture, orientation};
use crate::error::{Error, Result, nearest};
use crate::quadrature::gauss_legendre::gauss_legendre;
use crate::term::cube::direction;

/// Highest l.
pub const MAX_ORDER: u32 = 4;
/// Functions up to [`MAX_ORDER`].
const COUNT: usize = 25;

/// Every basis function: l, m, and its formula for people.
pub const BASIS: [(u32, i32, &str); COUNT] = [
    (0, 0, "sqrt(1/(4 pi))"),
    (1, -1, "sqrt(3/(4 pi)) y"),
    (1, 0, "sqrt(3/(4 pi)) z"),
    (1, 1, "sqrt(3/(4 pi)) x"),
    (2, -2, "sqrt(15/(4 pi)) x y"),
    (2, -1, "sqrt(15/(4 pi)) y z"),
    (2, 0, "sqrt(5/(16 pi)) (3 z^2 - 1)"),
    (2, 1, "sqrt(15/(4 pi)) x z"),
    (2, 2, "sqrt(15/(16 pi)) (x^2 - y^2)"),
    (3, -3, "sqrt(35/(32 pi)) y (3 x^2 - y^2)"),
    (3, -2, "sqrt(105/(4 pi)) x y z"),
    (3, -1, "sqrt(21/(32 pi)) y (5 z^2 - 1)"),
    (3, 0, "sqrt(7/(16 pi)) z (5 z^2 - 3)"),
    (3, 1, "sqrt(21/(32 pi)) x (5 z^2 - 1)"),
    (3, 2, "sqrt(105/(16 pi)) z (x^2 - y^2)"),
    (3, 3, "sqrt(35/(32 pi)) x (x^2 - 3 y^2)"),
    (4, -4, "sqrt(315/(16 pi)) x y (x^2 - y^2)"),
    (4, -3, "sqrt(315/(32 pi)) y z (3 x^2 - y^2)"),
    (4, -2, "sqrt(45/(16 pi)) x y (7 z^2 - 1)"),
    (4, -1, "sqrt(45/(32 pi)) y z (7 z^2 - 3)"),
    (4, 0, "sqrt(9/(256 pi)) (35 z^4 - 30 z^2 + 3)"),
    (4, 1, "sqrt(45/(32 pi)) x z (7 z^2 - 3)"),
    (4, 2, "sqrt(45/(64 pi)) (x^2 - y^2) (7 z^2 - 1)"),
    (4, 3, "sqrt(315/(32 pi)) x z (x^2 - 3 y^2)"),
    (4, 4, "sqrt(315/(256 pi)) (x^4 - 6 x^2 y^2 + y^4)"),
];

/// The basis functions at a unit direction, in the order of [`BASIS`].
pub fn basis([x, y, z]: [f64; 3]) -> [f64; COUNT] {
    let n = |numerator: f64, denominator: f64| (numerator / (denominator * PI)).sqrt();
    let (x2, y2, z2) = (x * x, y * y, z * z);
    [
        n(1.0, 4.0),
        n(3.0, 4.0) * y,
        n(3.0, 4.0) * z,
        n(3.0, 4.0) * x,
        n(15.0, 4.0) * x * y,
        n(15.0, 4.0) * y * z,
        n(5.0, 16.0) * (3.0 * z2 - 1.0),
        n(15.0, 4.0) * x * z,
        n(15.0, 16.0) * (x2 - y2),
        n(35.0, 32.0) * y * (3.0 * x2 - y2),
        n(105.0, 4.0) * x * y * z,
        n(21.0, 32.0) * y * (5.0 * z2 - 1.0),
        n(7.0, 16.0) * z * (5.0 * z2 - 3.0),
        n(21.0, 32.0) * x * (5.0 * z2 - 1.0),
        n(105.0, 16.0) * z * (x2 - y2),
        n(35.0, 32.0) * x * (x2 - 3.0 * y2),
        n(315.0, 16.0) * x * y * (x2 - y2),
        n(315.0, 32.0) * y * z * (3.0 * x2 - y2),
        n(45.0, 16.0) * x * y * (7.0 * z2 - 1.0),
        n(45.0, 32.0) * y * z * (7.0 * z2 - 3.0),
        n(9.0, 256.0) * (35.0 * z2 * z2 - 30.0 * z2 + 3.0),
        n(45.0, 32.0) * x * z * (7.0 * z2 - 3.0),
        n(45.0, 64.0) * (x2 - y2) * (7.0 * z2 - 1.0),
        n(315.0, 32.0) * x * z * (x2 - 3.0 * y2),
        n(315.0, 256.0) * (x2 * x2 - 6.0 * x2 * y2 + y2 * y2),
    ]
}

/// What the bands are multiplied with, against ringing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// 1.
    None,
    /// (1 + cos(π l/(L + 1)))/2, L the highest l.
    Hanning,
    /// sin(x)/x with x = π l/(L + 1).
    Lanczos,
}

impl Window {
    /// All windows, in the order of their documentation.
    pub const ALL: [Window; 3] = [Window::None, Window::Hanning, Window::Lanczos];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Window::None => "none",
            Window::Hanning => "hanning",
            Window::Lanczos => "lanczos",
        }
    }

    /// The window with this name.
    pub fn parse(name: &str) -> Result<Self> {
        let known = || Self::ALL.iter().map(|w| w.name());
        Self::ALL
            .into_iter()
            .find(|w| w.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown window '{name}'"), nearest(name, known())))
    }

    /// The factor of band `l` of `order`.
    pub fn factor(self, l: u32, order: u32) -> f64 {
        let x = PI * f64::from(l) / f64::from(order + 1);
        match self {
            Window::None => 1.0,
            Window::Hanning => 0.5 + 0.5 * x.cos(),
            Window::Lanczos if l == 0 => 1.0,
            Window::Lanczos => x.sin() / x,
        }
    }
}

/// A_l: what a clamped cosine multiplies band `l` with. Domain: l ≤ [`MAX_ORDER`].
pub fn cosine_factor(l: u32) -> f64 {
    [PI, 2.0 * PI / 3.0, PI / 4.0, 0.0, -PI / 24.0][l as usize]
}

/// Refuses an order that is not stored.
pub fn check_order(order: u32) -> Result<()> {
    if (2..=MAX_ORDER).contains(&order) {
        return Ok(());
    }
    let what = format!("spherical harmonics of order {order} are not computed");
    Err(Error::usage(what, format!("use --sh-order from 2 (9 coefficients) to {MAX_ORDER} ({COUNT})")))
}

/// L_lm of a picture for l ≤ `order`, per channel, in the order of [`BASIS`]. Exact to about 1e-13 of the mean radiance.
pub fn project<'a>(environment: impl Into<Environment<'a>>, order: u32) -> Vec<[f64; 3]> {
    let Environment { picture, frame } = environment.into();
    let sums = match &picture {
        Picture::Equirect(picture) => of_equirect(picture, order),
        Picture::Cube(picture) => of_cube(picture),
    };
    let change = change_of_basis(&frame);
    let count = ((order + 1) * (order + 1)) as usize;
    (0..count).map(|i| std::array::from_fn(|c| (0..COUNT).map(|j| change[i][j] * sums[j][c]).sum())).collect()
}

/// In harmonics about the picture's axis: at 2 × 2 Gauss points of (s, t) a texel, or of a part of it, which for faces of
/// 128 texels and more leaves a relative error below 1e-8.
fn of_cube(source: &CubeMap) -> [[f64; 3]; COUNT] {
    const LEAST_FACE: u32 = 128;
    const GAUSS: f64 = 0.288_675_134_594_812_9;
    if source.size < LEAST_FACE {
        return of_cube(&source.repeated(LEAST_FACE.div_ceil(source.size)));
    }
    let size = source.size;
    let of_rows: Vec<[[f64; 3]; COUNT]> = (0..6 * size)
        .into_par_iter()
        .map(|row| {
            let (face, y) = (row / size, row % size);
            let mut sums = [[0.0; 3]; COUNT];
            for x in 0..size {
                let texel = source.texel(face, x, y);
                for (i, j) in [(-GAUSS, -GAUSS), (GAUSS, -GAUSS), (-GAUSS, GAUSS), (GAUSS, GAUSS)] {
                    let at = |k: u32, offset: f64| 2.0 * (f64::from(k) + 0.5 + offset) / f64::from(size) - 1.0;
                    let (s, t) = (at(x, i), at(y, j));
                    let share = (1.0 + s * s + t * t).powf(-1.5) / f64::from(size * size);
                    let values = about_picture_axis(orientation::normalized(direction(face, s, t)));
                    for (sum, value) in sums.iter_mut().zip(values) {
                        (0..3).for_each(|c| sum[c] += share * value * f64::from(texel[c]));
                    }
                }
            }
            sums
        })
        .collect();
    total(&of_rows)
}

/// In harmonics about the picture's axis; those of bands above `order` are 0 where it saves time.
fn of_equirect(source: &Equirect, order: u32) -> [[f64; 3]; COUNT] {
    let d_phi = TAU / f64::from(source.width);
    let d_theta = PI / f64::from(source.height);
    // ∫ cos mφ dφ and ∫ sin mφ dφ over every column, m = 0..=4: at index 4 ± m.
    let columns: Vec<[f64; 9]> = (0..source.width)
        .map(|j| {
            let phi = (f64::from(j) + 0.5) * d_phi - PI;
            std::array::from_fn(|i| {
                let m = i as f64 - 4.0;
                let width = if m == 0.0 { d_phi } else { 2.0 * (0.5 * m * d_phi).sin() / m };
                width * if m < 0.0 { (-m * phi).sin() } else { (m * phi).cos() }
            })
        })
        .collect();
    let nodes = gauss_legendre(8);
    let about_axis: Vec<[[f64; 3]; COUNT]> = (0..source.height)
        .into_par_iter()
        .map(|y| {
            let of_row = match order {
                0..=2 => of_azimuth::<5>(source.row(y), &columns),
                _ => of_azimuth::<9>(source.row(y), &columns),
            };
            let mut theta_part = [0.0; COUNT];
            for node in &nodes {
                let theta = (f64::from(y) + 0.5 + 0.5 * node.x) * d_theta;
                let weight = 0.5 * d_theta * node.weight * theta.sin();
                for (part, value) in theta_part.iter_mut().zip(polar_parts(theta)) {
                    *part += weight * value;
                }
            }
            std::array::from_fn(|i| of_row[(4 + BASIS[i].1) as usize].map(|f| f * theta_part[i]))
        })
        .collect();
    total(&about_axis)
}

/// The sums over a row with the middle `M` factors of every column.
fn of_azimuth<const M: usize>(row: &[[f32; 3]], columns: &[[f64; 9]]) -> [[f64; 3]; 9] {
    let first = (9 - M) / 2;
    let mut sums = [[0.0; 3]; M];
    // Half a turn on, factors of even m are the same and those of odd m the opposite.
    let (near, far) = row.split_at(row.len() / 2);
    for ((near, far), column) in near.iter().zip(far).zip(columns) {
        let pair = |sign: f64| -> [f64; 3] { std::array::from_fn(|c| f64::from(near[c]) + sign * f64::from(far[c])) };
        let parts = [pair(1.0), pair(-1.0)];
        for (m, sum) in sums.iter_mut().enumerate() {
            (0..3).for_each(|c| sum[c] += column[first + m] * parts[(first + m) % 2][c]);
        }
    }
    let mut all = [[0.0; 3]; 9];
    all[first..first + M].copy_from_slice(&sums);
    all
}

fn total(rows: &[[[f64; 3]; COUNT]]) -> [[f64; 3]; COUNT] {
    let mut sums = [[0.0; 3]; COUNT];
    for row in rows {
        sums.iter_mut().zip(row).for_each(|(s, r)| (0..3).for_each(|c| s[c] += r[c]));
    }
    sums
}

/// The basis about the picture's axis: +Y in place of +Z, +Z in place of +Y. Its azimuth is the picture's φ.
fn about_picture_axis([x, y, z]: [f64; 3]) -> [f64; COUNT] {
    basis([x, z, y])
}

/// Θ_lm(θ): [`about_picture_axis`] over cos mφ or sin |m|φ.
fn polar_parts(theta: f64) -> [f64; COUNT] {
    // For each m a φ where cos mφ or sin |m|φ is 1.
    let at: [[f64; COUNT]; 9] = std::array::from_fn(|i| {
        let m = i as i32 - 4;
        let phi = if m < 0 { PI / (2.0 * f64::from(-m)) } else { 0.0 };
        about_picture_axis([phi.cos() * theta.sin(), theta.cos(), phi.sin() * theta.sin()])
    });
    std::array::from_fn(|i| at[(4 + BASIS[i].1) as usize][i])
}

/// ∫ Y_i Y'_j dω with Y' of [`about_picture_axis`], by a rule that is exact for polynomials of degree 8.
fn change_of_basis(frame: &Frame) -> [[f64; COUNT]; COUNT] {
    const AZIMUTHS: usize = 12;
    let mut change = [[0.0; COUNT]; COUNT];
    for node in gauss_legendre(8) {
        let radius = (1.0 - node.x * node.x).sqrt();
        for k in 0..AZIMUTHS {
            let (sin, cos) = (TAU * k as f64 / AZIMUTHS as f64).sin_cos();
            let d = [radius * cos, radius * sin, node.x];
            let (to, from) = (basis(d), about_picture_axis(frame.to_picture(d)));
            let weight = node.weight * TAU / AZIMUTHS as f64;
            for i in 0..COUNT {
                (0..COUNT).for_each(|j| change[i][j] += weight * to[i] * from[j]);
            }
        }
    }
    change
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn basis_is_orthonormal() {
        let mut products = [[0.0; COUNT]; COUNT];
        for node in gauss_legendre(8) {
            let radius = (1.0 - node.x * node.x).sqrt();
            for k in 0..12 {
                let (sin, cos) = (TAU * k as f64 / 12.0).sin_cos();
                let y = basis([radius * cos, radius * sin, node.x]);
                for i in 0..COUNT {
                    (0..COUNT).for_each(|j| products[i][j] += node.weight * TAU / 12.0 * y[i] * y[j]);
                }
            }
        }
        for (i, row) in products.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-13, "{i} {j}: {product}");
            }
        }
    }

    /// Σ over fine points of every texel: 4 × 4 Gauss points.
    fn by_points(source: &Equirect) -> [[f64; 3]; COUNT] {
        let nodes = gauss_legendre(4);
        let (d_theta, d_phi) = (PI / f64::from(source.height), TAU / f64::from(source.width));
        let mut sums = [[0.0; 3]; COUNT];
        for y in 0..source.height {
            for (x, texel) in source.row(y).iter().enumerate() {
                for a in &nodes {
                    for b in &nodes {
                        let v = (f64::from(y) + 0.5 + 0.5 * a.x) / f64::from(source.height);
                        let u = (x as f64 + 0.5 + 0.5 * b.x) / f64::from(source.width);
                        let weight = 0.25 * a.weight * b.weight * d_theta * d_phi * (PI * v).sin();
                        for (sum, value) in sums.iter_mut().zip(basis(Equirect::direction(u, v))) {
                            (0..3).for_each(|c| sum[c] += weight * value * f64::from(texel[c]));
                        }
                    }
                }
            }
        }
        sums
    }

    #[test]
    fn projection_is_the_integral() {
        let mut state = 1u32;
        let mut source = Equirect::from_fn(24, |_, _| {
            std::array::from_fn(|_| {
                state = state.wrapping_mul(1664525).wrapping_add(1013904223);
                (state >> 16) as f32 / 65536.0
            })
        });
        source.texels[7] = [3000.0, 1000.0, 10.0];
        let expected = by_points(&source);
        let found = project(&source, MAX_ORDER);
        let scale = expected[0];
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            for c in 0..3 {
                assert!((found[c] - expected[c]).abs() < 1e-10 * scale[c], "{i}: {found:?} {expected:?}");
            }
        }
    }

    /// Texels of a cube that have nothing in common.
    fn speckled_cube(size: u32) -> CubeMap {
        let texels = crate::env::speckle(2 * size).texels;
        CubeMap { size, texels: texels[..6 * (size * size) as usize].to_vec() }
    }

    /// Σ over 8 × 8 Gauss points of every texel of a cube, in the output's axes.
    fn by_points_of_cube(source: &CubeMap, frame: &Frame) -> [[f64; 3]; COUNT] {
        let nodes = gauss_legendre(8);
        let size = source.size;
        let mut sums = [[0.0; 3]; COUNT];
        for index in 0..6 * size * size {
            let (face, y, x) = (index / (size * size), index / size % size, index % size);
            let texel = source.texel(face, x, y);
            for a in &nodes {
                for b in &nodes {
                    let at = |k: u32, node: f64| 2.0 * (f64::from(k) + 0.5 + 0.5 * node) / f64::from(size) - 1.0;
                    let (s, t) = (at(x, a.x), at(y, b.x));
                    let weight = a.weight * b.weight * (1.0 + s * s + t * t).powf(-1.5) / f64::from(size * size);
                    let d = frame.from_picture(orientation::normalized(direction(face, s, t)));
                    for (sum, value) in sums.iter_mut().zip(basis(d)) {
                        (0..3).for_each(|c| sum[c] += weight * value * f64::from(texel[c]));
                    }
                }
            }
        }
        sums
    }

    #[test]
    fn projection_of_a_cube_is_the_integral_however_it_is_turned() {
        for size in [3, 5, 12] {
            let source = speckled_cube(size);
            for frame in [Frame::IDENTITY, Frame::new(false, [33.0, 10.0, -71.0]), Frame::new(true, [0.0, 90.0, 20.0])]
            {
                let expected = by_points_of_cube(&source, &frame);
                let found = project(&Environment { frame, ..Environment::from(&source) }, MAX_ORDER);
                for (i, (found, expected_i)) in found.iter().zip(&expected).enumerate() {
                    for c in 0..3 {
                        let off = (found[c] - expected_i[c]).abs();
                        assert!(off < 1e-7 * expected[0][c], "{size}, {frame:?}, {i}: {found:?} {expected_i:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_turned_picture_is_turned_in_every_band() {
        let source = crate::env::speckle(24);
        for frame in [Frame::new(false, [33.0, 10.0, -71.0]), Frame::new(true, [0.0, 90.0, 20.0])] {
            let found = project(&Environment { frame, ..Environment::from(&source) }, MAX_ORDER);
            // At any direction, each band of the turned picture has the value that the plain one has where that looks.
            let plain = project(&source, MAX_ORDER);
            for d in [[0.6, 0.64, 0.48], [-0.8, 0.0, 0.6], [0.0, -1.0, 0.0]] {
                let (here, there) = (basis(d), basis(frame.to_picture(d)));
                for l in 0..=MAX_ORDER {
                    let band = (l * l) as usize..((l + 1) * (l + 1)) as usize;
                    let value = |y: &[f64; COUNT], of: &[[f64; 3]]| band.clone().map(|i| y[i] * of[i][1]).sum::<f64>();
                    let (a, b) = (value(&here, &found), value(&there, &plain));
                    assert!((a - b).abs() < 1e-10 * plain[0][1], "{frame:?}, l = {l}: {a} instead of {b}");
                }
            }
        }
    }

    #[test]
    fn the_mean_is_the_first_coefficient() {
        let source = Equirect::from_fn(32, |u, v| Equirect::direction(u, v).map(|c| 1.0 + c as f32));
        let first = project(&source, 2)[0];
        for (first, mean) in first.iter().zip(source.mean()) {
            assert!((first / (4.0 * PI).sqrt() - mean).abs() < 1e-14, "{first} {mean}");
        }
    }

    #[test]
    fn cosine_factors_are_the_integrals() {
        // A_l = 2π ∫ P_l(x) x dx over [0, 1], with P_l from the zonal functions.
        for l in 0..=MAX_ORDER {
            let zonal = (l * l + l) as usize;
            let scale = (4.0 * PI / f64::from(2 * l + 1)).sqrt();
            let sum: f64 = gauss_legendre(8)
                .iter()
                .map(|n| {
                    let x = 0.5 * (1.0 + n.x);
                    0.5 * n.weight * x * scale * basis([(1.0 - x * x).sqrt(), 0.0, x])[zonal]
                })
                .sum();
            assert!((TAU * sum - cosine_factor(l)).abs() < 1e-14, "{l}: {}", TAU * sum);
        }
    }
}
