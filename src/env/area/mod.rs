// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact resampling to a cube: every cube texel gets the mean radiance over its exact solid angle. Energy is kept,
//! nothing aliases, and no filter width is guessed.
//!
//! Three ways, all exact for piecewise constant radiance: `upright` for equirectangular pictures that are at most
//! turned about the vertical, with a short cut in `quarters`, `turned` for others, and `faces` for cubes.

mod faces;
mod polygon;
mod quarters;
mod turned;
mod upright;

pub use polygon::Means;

use super::{Environment, Picture, orientation};
use crate::error::Result;
use crate::progress::{OnProgress, tick};
use crate::term::cube::direction;

type Rgb = [f64; 3];

const STAGE: &str = "averaging mip 0";

/// Mean radiance of every texel of a cube with `size` × `size` texels a face: faces in order, rows from the top, RGB
/// interleaved.
pub fn cube<'a>(environment: impl Into<Environment<'a>>, size: u32, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
    let Environment { picture, frame } = environment.into();
    tick(on, STAGE, 0.0)?;
    match &picture {
        Picture::Equirect(picture) => match frame.azimuth_rad() {
            Some(azimuth_rad) => match quarters::Quarters::new(picture, azimuth_rad, size) {
                Some(quarters) => quarters.cube(on),
                None => upright::cube(picture, azimuth_rad, size, on),
            },
            None => turned::cube(picture, &frame, size, on),
        },
        Picture::Cube(picture) => faces::cube(picture, &frame, size, on),
    }
}

/// A face's lines: `size + 1` values of s (or t) from −1 to 1.
fn lines(size: usize) -> Vec<f64> {
    (0..=size).map(|k| 2.0 * k as f64 / size as f64 - 1.0).collect()
}

/// Centre, s axis and t axis of a face.
fn axes(face: u32) -> [[f64; 3]; 3] {
    let centre = direction(face, 0.0, 0.0);
    let from_centre = |d: [f64; 3]| [d[0] - centre[0], d[1] - centre[1], d[2] - centre[2]];
    [centre, from_centre(direction(face, 1.0, 0.0)), from_centre(direction(face, 0.0, 1.0))]
}

/// Divides integrals over the texels of a face by their solid angles. `integral(x, y)` is the integral over a texel.
fn finish(size: usize, out: &mut [f32], integral: impl Fn(usize, usize) -> Rgb) {
    let lines = lines(size);
    let lines = &lines;
    let corner = |x: usize, y: usize| orientation::solid_angle(lines[x], lines[y]);
    let corners: Vec<f64> = (0..=size).flat_map(|y| (0..=size).map(move |x| corner(x, y))).collect();
    let stride = size + 1;
    for (index, texel) in out.chunks_exact_mut(3).enumerate() {
        let (x, y) = (index % size, index / size);
        let at = y * stride + x;
        let solid_angle = corners[at + stride + 1] - corners[at + stride] - corners[at + 1] + corners[at];
        let value = integral(x, y);
        // Radiance is not negative; rounding may leave −1e−17 beside a sun.
        texel.iter_mut().zip(value).for_each(|(t, v)| *t = (v / solid_angle).max(0.0) as f32);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::env::{CubeMap, Equirect, Frame, speckle};
    use crate::progress::ignore;

    fn resampled<'a>(environment: impl Into<Environment<'a>>, size: u32) -> Vec<f32> {
        cube(environment, size, &mut ignore).expect("nobody cancels")
    }

    /// Uneven radiance on a cube.
    fn speckled_cube(size: u32) -> CubeMap {
        let texels = speckle(2 * size).texels;
        CubeMap { size, texels: texels[..6 * (size * size) as usize].to_vec() }
    }

    /// Plain ways to turn, and one that mirrors.
    fn frames() -> [Frame; 5] {
        [
            Frame::IDENTITY,
            Frame::new(false, [0.0, 37.0, 0.0]),
            Frame::new(false, [33.0, 10.0, -71.0]),
            Frame::new(false, [90.0, 0.0, 0.0]),
            Frame::new(true, [0.0, 90.0, 20.0]),
        ]
    }

    /// The mean over a texel by a fine grid of points.
    fn sampled(environment: &Environment<'_>, size: u32, face: u32, x: u32, y: u32) -> [f64; 3] {
        const POINTS: u32 = 200;
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for j in 0..POINTS {
            for i in 0..POINTS {
                let at = |texel: u32, i: u32| {
                    2.0 * (f64::from(texel) + (f64::from(i) + 0.5) / f64::from(POINTS)) / f64::from(size) - 1.0
                };
                let (s, t) = (at(x, i), at(y, j));
                let value = environment.picture.radiance(environment.frame.to_picture(direction(face, s, t)));
                let weight = (1.0 + s * s + t * t).powf(-1.5);
                weights += weight;
                (0..3).for_each(|c| sum[c] += weight * f64::from(value[c]));
            }
        }
        sum.map(|v| v / weights)
    }

    fn check_means(environment: &Environment<'_>, size: u32, what: &str) {
        let texels = resampled(environment, size);
        for (index, texel) in texels.chunks_exact(3).enumerate() {
            let index = index as u32;
            let (face, y, x) = (index / (size * size), index / size % size, index % size);
            let expected = sampled(environment, size, face, x, y);
            for c in 0..3 {
                let (got, expected) = (f64::from(texel[c]), expected[c]);
                assert!(
                    (got - expected).abs() < 1e-2 * (expected + 1.0),
                    "{what}, size {size}, face {face}, ({x}, {y}): {texel:?}, sampled {expected:?}"
                );
            }
        }
    }

    #[test]
    fn every_texel_is_the_mean_over_its_solid_angle() {
        for (height, size) in [(8, 4), (8, 5), (6, 3), (1, 2), (2, 1), (30, 4), (7, 6), (64, 2)] {
            let source = speckle(height);
            check_means(&Environment::from(&source), size, &format!("height {height}"));
        }
    }

    #[test]
    fn every_texel_is_the_mean_however_the_picture_is_turned() {
        for frame in frames() {
            for (height, size) in [(8, 4), (6, 3), (1, 1), (17, 3), (30, 2)] {
                let source = speckle(height);
                let turned = Environment { frame, ..Environment::from(&source) };
                check_means(&turned, size, &format!("height {height}, {frame:?}"));
            }
            for (faces, size) in [(1, 2), (4, 3), (5, 5), (12, 2), (3, 1)] {
                let source = speckled_cube(faces);
                let turned = Environment { frame, ..Environment::from(&source) };
                check_means(&turned, size, &format!("faces of {faces}, {frame:?}"));
            }
        }
    }

    #[test]
    fn a_cube_is_itself() {
        let source = speckled_cube(7);
        assert_eq!(resampled(&source, 7), source.texels.as_flattened());
        // Through the clipping, too: a face at a time, by quarter turns that end where they began.
        let quarter = Frame::new(false, [0.0, 90.0, 0.0]);
        let mut turned = source.clone();
        for _ in 0..4 {
            let texels = resampled(&Environment { frame: quarter, ..Environment::from(&turned) }, 7);
            turned.texels = texels.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        }
        for (a, b) in turned.texels.iter().flatten().zip(source.texels.iter().flatten()) {
            assert!((a - b).abs() <= 1e-6 * (b + 1.0), "{a} instead of {b}");
        }
    }

    #[test]
    fn the_general_way_agrees_with_the_upright_one() {
        let source = speckle(40);
        for degrees in [0.0, 90.0, 13.0] {
            let frame = Frame::new(false, [0.0, degrees, 0.0]);
            let upright =
                upright::cube(&source, frame.azimuth_rad().expect("upright"), 11, &mut ignore).expect("nobody cancels");
            let general = turned::cube(&source, &frame, 11, &mut ignore).expect("nobody cancels");
            for (a, b) in upright.iter().zip(&general) {
                assert!((a - b).abs() <= 1e-6 * (b + 1.0), "turned by {degrees}: {a} and {b}");
            }
        }
    }

    #[test]
    fn the_short_cut_agrees_with_the_long_way() {
        for (height, size) in [(40, 12), (2, 2), (64, 16), (12, 24), (6, 4), (22, 50)] {
            let source = speckle(height);
            for degrees in [0.0, 90.0, 180.0, -90.0] {
                let frame = Frame::new(false, [0.0, degrees, 0.0]);
                let azimuth_rad = frame.azimuth_rad().expect("upright");
                let quarters = quarters::Quarters::new(&source, azimuth_rad, size).expect("the quarters are alike");
                let short = quarters.cube(&mut ignore).expect("nobody cancels");
                let long = upright::cube(&source, azimuth_rad, size, &mut ignore).expect("nobody cancels");
                for (a, b) in short.iter().zip(&long) {
                    assert!((a - b).abs() <= 1e-6 * (b + 1.0), "{size} from {height} by {degrees}: {a} and {b}");
                }
            }
        }
        let source = speckle(40);
        assert!(quarters::Quarters::new(&source, 0.0, 11).is_none(), "a middle line of texels");
        assert!(quarters::Quarters::new(&source, 0.01, 12).is_none(), "turned by a part of a column");
        assert!(quarters::Quarters::new(&speckle(5), 0.0, 12).is_none(), "a middle line of rows");
    }

    fn energy(texels: &[f32], size: usize) -> [f64; 3] {
        let line = |k: usize| 2.0 * k as f64 / size as f64 - 1.0;
        let mut sum = [0.0; 3];
        for (index, texel) in texels.chunks_exact(3).enumerate() {
            let (x, y) = (index % size, index / size % size);
            let corner = |dx, dy| orientation::solid_angle(line(x + dx), line(y + dy));
            let solid_angle = corner(1, 1) - corner(0, 1) - corner(1, 0) + corner(0, 0);
            (0..3).for_each(|c| sum[c] += solid_angle * f64::from(texel[c]));
        }
        sum.map(|s| s / (4.0 * PI))
    }

    #[test]
    fn energy_is_kept() {
        for (height, size) in [(64, 16), (64, 33), (128, 20), (45, 64), (16, 128)] {
            let source = speckle(height);
            let cube = speckled_cube(height);
            for frame in frames() {
                for environment in [Environment::from(&source), Environment::from(&cube)] {
                    let environment = Environment { frame, ..environment };
                    let mean = environment.picture.mean();
                    let got = energy(&resampled(&environment, size), size as usize);
                    for c in 0..3 {
                        let off = (got[c] / mean[c] - 1.0).abs();
                        assert!(off < 1e-7, "height {height}, size {size}, {frame:?}: {got:?}, source {mean:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn white_stays_white() {
        let white = Equirect::from_fn(50, |_, _| [1.0; 3]);
        let white_cube = CubeMap::from_fn(50, |_| [1.0; 3]);
        for frame in frames() {
            for environment in [Environment::from(&white), Environment::from(&white_cube)] {
                let texels = resampled(&Environment { frame, ..environment }, 37);
                assert!(texels.iter().all(|v| (v - 1.0).abs() <= 1.2e-7), "a texel differs, {frame:?}");
            }
        }
    }

    #[test]
    fn what_is_black_stays_black_beside_a_sun() {
        // Four texels of the source in one row, above the horizon on the +X face; a 4 × 4 face has texels far from it.
        let mut source = Equirect::from_fn(128, |_, _| [0.0; 3]);
        source.texels[50 * 256 + 128] = [1e6; 3];
        let texels = resampled(&source, 64);
        let lit = texels.chunks_exact(3).filter(|t| t[0] > 1e-6).count();
        assert!((1..=4).contains(&lit), "{lit} texels are lit");
    }
}
