// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact resampling to an equirectangular picture and to an octahedral map: the mean radiance over every texel's exact
//! solid angle, as [`super::area`] has it for cubes.
//!
//! What is turned, and what comes from a cube, is averaged over spherical polygons ([`super::area::Means`]); parallels
//! are then made of chords, at least [`CHORDS`] a texel, which a texel's neighbour shares. The rest is about
//! equirectangular pictures as they are.
//!
//! **Equirectangular.** Rows overlap in cos θ, columns in φ, so the weights separate.
//!
//! **Octahedral.** A texel is bounded by great circles. With the column sums G of [`super::area`], its integral is ∮ G dφ;
//! a great circle with the normal m has cot θ = k cos(φ − φ₀), k cos φ₀ = −m_x/m_y and k sin φ₀ = −m_z/m_y, so it meets
//! meridians and parallels at closed places, and between them
//!
//! ```text
//! ∫ cos θ dφ = asin(k sin(φ − φ₀)/√(1 + k²))
//! ```
//!
//! At −Y, where the sums end with the whole column, a corner of a texel turns about the pole: ∫ G(π, φ) dφ belongs to it.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::area::Means;
use super::orientation::normalized;
use super::projection::{Projection, octahedral_parts, triangle_sr};
use super::{Environment, Equirect, Frame, Picture};
use crate::error::Result;
use crate::progress::{OnProgress, tick};

type Rgb = [f64; 3];

/// Wider pictures are halved before they are summed for an octahedral map, so that the sums stay within 200 MB. Energy is
/// kept; a source texel that a map's texel divides is then only divided to a part of its own size.
const MOST_COLUMNS: u32 = 4096;

/// Chords along the upper and the lower edge of a texel of an equirectangular picture.
pub const CHORDS: u32 = 4;
/// No chord spans more than this in φ: a cap's area misses a sixth of its square, 5e-5.
const CHORD_RAD: f64 = 0.017;
/// No part of a texel is higher than this.
const MOST_RAD: f64 = 0.05;
/// Rows between two looks at the progress listener.
const ROWS: u32 = 16;

/// An equirectangular picture of `width` × `height` texels: RGB interleaved.
pub fn equirect<'a>(
    environment: impl Into<Environment<'a>>,
    (width, height): (u32, u32),
    on: &mut OnProgress<'_>,
) -> Result<Vec<f32>> {
    let environment = environment.into();
    if let (Picture::Equirect(picture), Frame::IDENTITY) = (&environment.picture, environment.frame) {
        tick(on, STAGE, 0.0)?;
        return Ok(plain_equirect(picture, (width, height)));
    }
    let side_rad = PI / f64::from(height);
    let across = CHORDS.max((side_rad / CHORD_RAD).ceil() as u32);
    let down = (side_rad / MOST_RAD).ceil() as u32;
    by_rows(&environment, width, height, on, |means, x, y| {
        let corner = |i: u32, j: u32| {
            let at =
                |k: u32, i: u32, parts: u32, n: u32| (f64::from(k) + f64::from(i) / f64::from(parts)) / f64::from(n);
            Equirect::direction(at(x, i, across, width), at(y, j, down, height))
        };
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for j in 0..down {
            let line = |j: u32| (PI * (f64::from(y) + f64::from(j) / f64::from(down)) / f64::from(height)).cos();
            let share = line(j) - line(j + 1);
            for i in 0..across {
                let mean = means.mean(&[corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
                (0..3).for_each(|c| sum[c] += share * mean[c]);
                weight += share;
            }
        }
        sum.map(|s| s / weight)
    })
}

/// An octahedral map of `size` × `size` texels, a power of two: RGB interleaved.
pub fn octahedral<'a>(environment: impl Into<Environment<'a>>, size: u32, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
    let environment = environment.into();
    if let (Picture::Equirect(picture), Frame::IDENTITY) = (&environment.picture, environment.frame) {
        tick(on, STAGE, 0.0)?;
        return Ok(plain_octahedral(picture, size));
    }
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(size) - 1.0;
    by_rows(&environment, size, size, on, |means, x, y| {
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for part in octahedral_parts(at(x), at(y), at(x + 1), at(y + 1)).iter().flatten() {
            let share = triangle_sr(part);
            let mean = means.mean(part);
            (0..3).for_each(|c| sum[c] += share * mean[c]);
            weight += share;
        }
        sum.map(|s| s / weight)
    })
}

const STAGE: &str = "averaging mip 0";

fn by_rows(
    environment: &Environment<'_>,
    width: u32,
    height: u32,
    on: &mut OnProgress<'_>,
    texel: impl Fn(&Means<'_>, u32, u32) -> Rgb + Sync,
) -> Result<Vec<f32>> {
    let means = Means::new(environment);
    let mut texels = vec![0f32; 3 * (width * height) as usize];
    for (band, out) in texels.chunks_mut((3 * width * ROWS) as usize).enumerate() {
        let first = band as u32 * ROWS;
        tick(on, STAGE, f64::from(first) / f64::from(height))?;
        out.par_chunks_exact_mut(3).enumerate().for_each(|(i, out)| {
            out.copy_from_slice(&texel(&means, i as u32 % width, first + i as u32 / width).map(|v| v as f32));
        });
    }
    Ok(texels)
}

fn plain_equirect(source: &Equirect, (width, height): (u32, u32)) -> Vec<f32> {
    let (width, height) = (width as usize, height as usize);
    let (rows, columns) = (source.height as usize, source.width as usize);
    let row_parts = overlaps(rows, height, |x| (PI * x).cos());
    let column_parts = overlaps(columns, width, |x| x);
    let mut texels = vec![0f32; 3 * width * height];
    texels.par_chunks_mut(3 * width).zip(&row_parts).for_each(|(out, parts)| {
        let mut sums = vec![[0f64; 3]; columns];
        for (row, weight) in parts {
            for (sum, texel) in sums.iter_mut().zip(source.row(*row as u32)) {
                (0..3).for_each(|c| sum[c] += weight * f64::from(texel[c]));
            }
        }
        let row_weight: f64 = parts.iter().map(|(_, weight)| weight).sum();
        for (texel, parts) in out.chunks_exact_mut(3).zip(&column_parts) {
            let whole = row_weight * parts.iter().map(|(_, weight)| weight).sum::<f64>();
            for (c, value) in texel.iter_mut().enumerate() {
                *value = (parts.iter().map(|(column, weight)| weight * sums[*column][c]).sum::<f64>() / whole) as f32;
            }
        }
    });
    texels
}

/// For each of `to` equal parts of [0, 1]: which of `from` equal parts it meets, and the measure |Δ along| in common.
fn overlaps(from: usize, to: usize, along: impl Fn(f64) -> f64) -> Vec<Vec<(usize, f64)>> {
    let part = |i: usize| {
        // Borders as fractions over from · to, so that common ones are equal.
        let (start, end) = (i * from, (i + 1) * from);
        (start / to..end.div_ceil(to)).map(move |j| {
            let at = |border: usize| border as f64 / (from * to) as f64;
            (j, at(start.max(j * to)), at(end.min((j + 1) * to)))
        })
    };
    (0..to).map(|i| part(i).map(|(j, a, b)| (j, (along(a) - along(b)).abs())).collect()).collect()
}

fn plain_octahedral(source: &Equirect, size: u32) -> Vec<f32> {
    let mut halved;
    let mut source = source;
    while source.width > MOST_COLUMNS {
        let height = source.height / 2;
        let texels = plain_equirect(source, (2 * height, height)).as_chunks().0.to_vec();
        halved = Equirect { width: 2 * height, height, texels };
        source = &halved;
    }
    let sums = ColumnSums::new(source);
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(size) - 1.0;
    let mut texels = vec![0f32; 3 * (size * size) as usize];
    texels.par_chunks_exact_mut(3).enumerate().for_each(|(index, texel)| {
        let (x, y) = (index as u32 % size, index as u32 / size);
        let mut integral = [0.0; 3];
        for part in octahedral_parts(at(x), at(y), at(x + 1), at(y + 1)).iter().flatten() {
            sums.add_triangle(&part.map(normalized), &mut integral);
        }
        let solid_angle_sr = Projection::Octahedral.solid_angle_sr(x, y, size, size);
        texel.iter_mut().zip(integral).for_each(|(t, v)| *t = (v / solid_angle_sr).max(0.0) as f32);
    });
    texels
}

/// ∫ L sin θ dθ from the top of the picture down to each line between rows.
struct ColumnSums<'a> {
    source: &'a Equirect,
    /// Row by row, the line above the first row included.
    sums: Vec<Rgb>,
    /// cos θ at the lines, and cot θ.
    cos: Vec<f64>,
    cot: Vec<f64>,
}

impl<'a> ColumnSums<'a> {
    fn new(source: &'a Equirect) -> Self {
        let (width, height) = (source.width as usize, source.height as usize);
        let theta = |i: usize| PI * i as f64 / height as f64;
        let cos: Vec<f64> = (0..=height).map(|i| theta(i).cos()).collect();
        let cot = (0..=height).map(|i| cos[i] / theta(i).sin()).collect();
        let mut sums = vec![[0.0; 3]; width * (height + 1)];
        for row in 0..height {
            let solid = cos[row] - cos[row + 1];
            let (above, below) = sums[row * width..].split_at_mut(width);
            for ((below, above), texel) in below.iter_mut().zip(above).zip(source.row(row as u32)) {
                (0..3).for_each(|c| below[c] = above[c] + solid * f64::from(texel[c]));
            }
        }
        Self { source, sums, cos, cot }
    }

    /// Adds the integral over a spherical triangle.
    fn add_triangle(&self, corners: &[[f64; 3]; 3], to: &mut Rgb) {
        let is_pole = |v: [f64; 3]| v[0].hypot(v[2]) < 1e-12;
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            if is_pole(a) && a[1] < 0.0 {
                let before = corners[(i + 2) % 3];
                self.add_pole(before[2].atan2(before[0]), b[2].atan2(b[0]), to);
            }
            if !is_pole(a) && !is_pole(b) {
                self.add_arc(a, b, to);
            }
        }
    }

    /// The column that an azimuth lies in.
    fn column(&self, phi: f64) -> usize {
        let width = i64::from(self.source.width);
        (((phi / TAU + 0.5) * width as f64).floor() as i64).rem_euclid(width) as usize
    }

    /// ∫ G(π, φ) dφ, the shorter way round.
    fn add_pole(&self, from: f64, to_phi: f64, to: &mut Rgb) {
        let turn = wrapped(to_phi - from);
        let last = self.source.height as usize * self.source.width as usize;
        self.between_meridians(from, turn, &mut vec![], |a, b| {
            let sum = &self.sums[last + self.column(0.5 * (a + b))];
            (0..3).for_each(|c| to[c] += sum[c] * (b - a));
        });
    }

    /// Calls `piece` for the parts of a turn from `from` between meridians of the picture and the places in `cuts`.
    fn between_meridians(&self, from: f64, turn: f64, cuts: &mut Vec<f64>, mut piece: impl FnMut(f64, f64)) {
        let d_phi = TAU / f64::from(self.source.width);
        let (low, high) = if turn < 0.0 { (from + turn, from) } else { (from, from + turn) };
        cuts.retain(|phi| *phi > low && *phi < high);
        cuts.extend(((low / d_phi).floor() as i64 + 1..(high / d_phi).ceil() as i64).map(|j| j as f64 * d_phi));
        cuts.push(high);
        cuts.sort_unstable_by(f64::total_cmp);
        let mut start = low;
        for &end in cuts.iter() {
            if turn < 0.0 {
                piece(end, start)
            } else {
                piece(start, end)
            }
            start = end;
        }
    }

    /// ∫ G dφ along the great circle from `a` to `b`, less than half of it.
    fn add_arc(&self, a: [f64; 3], b: [f64; 3], to: &mut Rgb) {
        let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let from = a[2].atan2(a[0]);
        let turn = wrapped(b[2].atan2(b[0]) - from);
        if turn.abs() < 1e-15 {
            return;
        }
        // cot θ = k cos(φ − φ₀)
        let (kx, kz) = (-normal[0] / normal[1], -normal[2] / normal[1]);
        let (k, phi0) = (kx.hypot(kz), kz.atan2(kx));
        let cot = |phi: f64| k * (phi - phi0).cos();

        // The parallels that are met, by their highest and lowest place.
        let (low, high) = if turn < 0.0 { (from + turn, from) } else { (from, from + turn) };
        let turns_at = |phi: f64| phi + TAU * ((0.5 * (low + high) - phi) / TAU).round();
        let mut range = [cot(low).min(cot(high)), cot(low).max(cot(high))];
        for (top, at) in [(1, turns_at(phi0)), (0, turns_at(phi0 + PI))] {
            if at > low && at < high {
                range[top] = if top == 1 { k } else { -k };
            }
        }
        // cot θ falls from row to row.
        let first = self.cot.partition_point(|c| *c >= range[1]);
        let last = self.cot.partition_point(|c| *c > range[0]);
        let mut cuts = Vec::with_capacity(8);
        for c in &self.cot[first..last] {
            let away = (c / k).clamp(-1.0, 1.0).acos();
            cuts.extend([turns_at(phi0 + away), turns_at(phi0 - away)]);
        }

        // asin(x) as atan2(x, √(1 − x²)), which loses nothing where x is near 1.
        let along = |phi: f64| (k * (phi - phi0).sin()).atan2(cot(phi).hypot(1.0));
        let width = self.source.width as usize;
        self.between_meridians(from, turn, &mut cuts, |start, end| {
            let middle = 0.5 * (start + end);
            let row = (self.cot.partition_point(|c| *c > cot(middle)).max(1) - 1).min(self.source.height as usize - 1);
            let column = self.column(middle);
            let (sum, texel) = (&self.sums[row * width + column], &self.source.row(row as u32)[column]);
            let d_phi = end - start;
            let d_cos = along(end) - along(start);
            for c in 0..3 {
                let radiance = f64::from(texel[c]);
                to[c] += (sum[c] + radiance * self.cos[row]) * d_phi - radiance * d_cos;
            }
        });
    }
}

/// An angle within half a turn.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::speckle;

    /// The mean over a texel by a fine grid of points, weighted by how far apart they are.
    fn sampled(source: &Equirect, projection: Projection, size: u32, x: u32, y: u32) -> [f64; 3] {
        const POINTS: u32 = 96;
        let (width, height) = projection.level_size(size);
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for j in 0..POINTS {
            for i in 0..POINTS {
                let weight = projection.solid_angle_sr(x * POINTS + i, y * POINTS + j, width * POINTS, height * POINTS);
                let at = |texel: u32, i: u32, n: u32| {
                    2.0 * (f64::from(texel * POINTS + i) + 0.5) / f64::from(n * POINTS) - 1.0
                };
                let [u, v] = Equirect::locate(projection.direction(0, at(x, i, width), at(y, j, height)));
                let column = ((u * f64::from(source.width)) as usize).min(source.width as usize - 1);
                let row = ((v * f64::from(source.height)) as u32).min(source.height - 1);
                weights += weight;
                (0..3).for_each(|c| sum[c] += weight * f64::from(source.row(row)[column][c]));
            }
        }
        sum.map(|v| v / weights)
    }

    fn resampled(source: &Equirect, projection: Projection, size: u32) -> Vec<f32> {
        if projection == Projection::Equirect {
            plain_equirect(source, (2 * size, size))
        } else {
            plain_octahedral(source, size)
        }
    }

    #[test]
    fn every_texel_is_the_mean_over_its_solid_angle() {
        let of_both = [
            (Projection::Equirect, vec![(8, 3), (5, 8), (30, 7), (1, 2)]),
            (Projection::Octahedral, vec![(8, 4), (6, 8), (1, 2), (2, 1), (30, 4), (3, 16)]),
        ];
        for (projection, cases) in of_both {
            for (height, size) in cases {
                let source = speckle(height);
                let width = projection.level_size(size).0;
                for (index, texel) in resampled(&source, projection, size).chunks_exact(3).enumerate() {
                    let (x, y) = (index as u32 % width, index as u32 / width);
                    let expected = sampled(&source, projection, size, x, y);
                    for c in 0..3 {
                        assert!(
                            (f64::from(texel[c]) - expected[c]).abs() < 2e-2 * (expected[c] + 1.0),
                            "{projection:?} {size} from {height}, ({x}, {y}): {texel:?}, sampled {expected:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn energy_is_kept() {
        for projection in [Projection::Equirect, Projection::Octahedral] {
            for (height, size) in [(64, 16), (64, 32), (45, 64), (16, 128), (256, 8)] {
                let source = speckle(height);
                let (width, rows) = projection.level_size(size);
                let mut sum = [0.0; 3];
                for (index, texel) in resampled(&source, projection, size).chunks_exact(3).enumerate() {
                    let (x, y) = (index as u32 % width, index as u32 / width);
                    let weight = projection.solid_angle_sr(x, y, width, rows) / (4.0 * PI);
                    (0..3).for_each(|c| sum[c] += weight * f64::from(texel[c]));
                }
                let mean = source.mean();
                assert!(
                    (0..3).all(|c| (sum[c] / mean[c] - 1.0).abs() < 1e-7),
                    "{projection:?} {size} from {height}: {sum:?}, source {mean:?}"
                );
            }
        }
    }

    #[test]
    fn white_stays_white() {
        let white = Equirect::from_fn(50, |_, _| [1.0; 3]);
        for projection in [Projection::Equirect, Projection::Octahedral] {
            let worst = resampled(&white, projection, 32).iter().map(|v| (v - 1.0).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-6, "{projection:?}: {worst}");
        }
    }

    #[test]
    fn polygons_agree_with_the_direct_ways() {
        use crate::env::CubeMap;
        use crate::progress::ignore;
        let source = speckle(24);
        // A turn, and the picture turned back by as many columns: the same environment, taken through polygons.
        let frame = Frame::new(false, [0.0, 90.0, 0.0]);
        let texels = (0..24).flat_map(|y| (0..48).map(move |x| (x, y)));
        let rolled = texels.map(|(x, y)| source.row(y)[(x + 36) % 48]).collect();
        let rolled = Equirect { texels: rolled, ..source.clone() };
        let turned = Environment { frame, ..Environment::from(&rolled) };
        for (projection, sizes) in [(Projection::Equirect, [1, 7, 16]), (Projection::Octahedral, [1, 4, 16])] {
            for size in sizes {
                let found = match projection {
                    Projection::Equirect => equirect(&turned, (2 * size, size), &mut ignore),
                    _ => octahedral(&turned, size, &mut ignore),
                };
                let expected = resampled(&source, projection, size);
                for (a, b) in found.expect("nobody cancels").iter().zip(&expected) {
                    assert!((a - b).abs() <= 2e-3 * (b + 1.0), "{projection:?} {size}: {a} instead of {b}");
                }
            }
        }
        // A cube of one colour a face, in the middle of each.
        let cube = CubeMap::from_fn(6, |d| d.map(|v| if v.abs() == 1.0 { 2.0 + v as f32 } else { 0.0 }));
        let map = octahedral(&cube, 16, &mut ignore).expect("nobody cancels");
        let middle = &map[3 * (7 * 16 + 7)..][..3];
        assert!((middle[1] - 3.0).abs() < 1e-6 && middle[0] == 0.0, "{middle:?} looks along +Y");
        let right = &map[3 * (7 * 16 + 11)..][..3];
        assert!(right[0] > 0.0, "{right:?} looks towards +X");
    }

    #[test]
    fn a_turn_keeps_the_mean() {
        use crate::progress::ignore;
        // All the light in one texel at the pole; chords of parallels miss most there.
        let source = Equirect::from_fn(64, |u, v| [if v < 1.0 / 64.0 && u < 1.0 / 128.0 { 1e4 } else { 0.0 }; 3]);
        for turn in [[0.0, 0.3, 0.0], [40.0, 25.0, 10.0], [90.0, 0.0, 0.0]] {
            for height in [1, 2, 7, 16, 32] {
                let turned = Environment { frame: Frame::new(false, turn), ..Environment::from(&source) };
                let map = equirect(&turned, (2 * height, height), &mut ignore).expect("nobody cancels");
                let solid_angle =
                    |i: usize| Projection::Equirect.solid_angle_sr(0, i as u32 / (2 * height), 2 * height, height);
                let sum: f64 =
                    map.as_chunks::<3>().0.iter().enumerate().map(|(i, t)| solid_angle(i) * f64::from(t[0])).sum();
                let error = sum / (4.0 * PI) / source.mean()[0] - 1.0;
                assert!(error.abs() < 5e-5, "height {height}, turned by {turn:?}: {error:e}");
            }
        }
    }

    #[test]
    fn an_equal_size_is_the_same_picture() {
        let source = speckle(16);
        let same = plain_equirect(&source, (32, 16));
        assert!(same.as_chunks().0.iter().zip(&source.texels).all(|(a, b): (&[f32; 3], _)| a == b));
    }
}
