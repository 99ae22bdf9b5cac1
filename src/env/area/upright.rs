// SPDX-License-Identifier: MIT OR Apache-2.0
//! Equirectangular pictures that are turned about the vertical only, if at all.
//!
//! The picture is piecewise constant between circles of latitude and meridians; a cube texel is bounded by great
//! circles. By Green's theorem, the integral of the radiance L over a texel T is a sum along T's boundary,
//!
//! ```text
//! ∬_T L sin θ dθ dφ = ∮_∂T G(θ, φ) dφ,    G(θ, φ) = ∫_0^θ L(θ', φ) sin θ' dθ'
//! ```
//!
//! and inside one source texel G = S + L·(cos θ_i − cos θ) with S the column's sum over the rows above. Cut where it
//! crosses rows and columns of the picture, each edge thus needs only ∫ dφ and ∫ cos θ dφ along great circles, and both
//! are closed:
//!
//! - **Side faces.** With φ measured from the face's centre, the line of constant t is tan(latitude) = −t cos φ, and
//!   ∫ cos θ dφ = −asin(t sin φ / √(1 + t²)). Lines of constant s are meridians: they cost nothing.
//! - **Top and bottom faces.** On the line of constant s, φ = atan2(t, s) and, with y = 1 towards the face,
//!   ∫ cos θ dφ = atan(t / (s √(1 + s² + t²))); lines of constant t alike. Here the columns are summed from the pole
//!   inside the face, where G = 0, so that a texel which holds the pole needs no special case.
//!
//! Neighbouring texels share their edge's integral, so the sum over all texels is the source's energy to rounding.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::{Rgb, STAGE, finish};
use crate::env::Equirect;
use crate::error::Result;
use crate::progress::{OnProgress, Watch, watched};

/// Mean radiance of every texel of a cube. `azimuth_rad` is added to the output's azimuth to get the picture's.
pub fn cube(source: &Equirect, azimuth_rad: f64, size: u32, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
    let n = size as usize;
    let mut texels = vec![0f32; 6 * n * n * 3];
    let grid = Grid::new(source, azimuth_rad, n);
    // A face's lines are its parts.
    watched(on, STAGE, 4 * n + 4 * (n + 1), |watch| {
        texels.par_chunks_mut(n * n * 3).enumerate().for_each(|(face, out)| match face {
            2 | 3 => grid.polar_face(face == 2, out, watch),
            _ => grid.side_face([0.0, PI, 0.0, 0.0, PI / 2.0, -PI / 2.0][face], out, watch),
        });
    })?;
    Ok(texels)
}

/// The picture's and the cube's lines.
struct Grid<'a> {
    source: &'a Equirect,
    azimuth_rad: f64,
    width: usize,
    height: usize,
    /// Texels along a side of a face.
    size: usize,
    /// The face's lines: `size + 1` values of s (or t) from −1 to 1.
    lines: Vec<f64>,
}

impl<'a> Grid<'a> {
    fn new(source: &'a Equirect, azimuth_rad: f64, size: usize) -> Self {
        let lines = (0..=size).map(|k| 2.0 * k as f64 / size as f64 - 1.0).collect();
        Self { source, azimuth_rad, width: source.width as usize, height: source.height as usize, size, lines }
    }

    /// Polar angle of the picture's line above row `i`.
    fn theta(&self, i: usize) -> f64 {
        PI * i as f64 / self.height as f64
    }

    /// Azimuth, in the output, of the picture's line left of column `j`; columns may lie beyond either end.
    fn phi(&self, j: isize) -> f64 {
        TAU * (j as f64 / self.width as f64 - 0.5) - self.azimuth_rad
    }

    /// The column that holds an azimuth of the output; it may lie beyond either end.
    fn column(&self, phi: f64) -> isize {
        (((phi + self.azimuth_rad) / TAU + 0.5) * self.width as f64).floor() as isize
    }

    /// A face around the horizon whose centre has azimuth `centre`.
    fn side_face(&self, centre: f64, out: &mut [f32], watch: &Watch) {
        let n = self.size;
        // Azimuth from the face's centre runs against s: −atan s. Face columns are taken from the right, so that it grows.
        let edges: Vec<f64> = self.lines.iter().rev().map(|s| -s.atan()).collect();
        let first_column = self.column(centre + edges[0]);

        // Only these rows are met: |latitude| ≤ 45°. cot(θ) stands for θ: it falls as rows go down.
        let row0 = (self.height / 4).saturating_sub(1);
        let row1 = (self.height * 3).div_ceil(4).min(self.height - 1) + 1;
        let cot: Vec<f64> = (row0..=row1).map(|i| 1.0 / self.theta(i).tan()).collect();
        let cos: Vec<f64> = (row0..=row1).map(|i| self.theta(i).cos()).collect();
        let rows = row1 - row0;

        // `below[row]` = S + L cos θ_i and L of the column at hand, so that G = below.0 − below.1 · cos θ.
        let mut below: Vec<(Rgb, Rgb)> = vec![([0.0; 3], [0.0; 3]); rows];
        let mut integrals = vec![[0f64; 3]; n * n];
        let mut left: Vec<Point> = vec![Point::default(); n + 1];
        let at_azimuth = |psi: f64, points: &mut [Point]| {
            let (sin, cos_psi) = psi.sin_cos();
            let mut row = 0;
            for (point, t) in points.iter_mut().zip(&self.lines) {
                let cot_theta = -t * cos_psi;
                while row + 1 < rows && cot_theta < cot[row + 1] {
                    row += 1;
                }
                *point = Point { row, w: t * sin / (1.0 + cot_theta * cot_theta).sqrt() };
            }
        };
        let mut right = left.clone();
        at_azimuth(edges[0], &mut left);

        let (mut psi, mut face_column, mut column) = (edges[0], 0, first_column);
        let mut loaded = isize::MIN;
        while face_column < n {
            // The strip reaches to the next line: of the face, of the picture, or the middle (latitude turns there).
            let picture = self.phi(column + 1) - centre;
            let mut next = edges[face_column + 1].min(picture).max(psi);
            if psi < 0.0 && next > 0.0 {
                next = 0.0;
            }
            if next > psi {
                if loaded != column {
                    self.load_column(column.rem_euclid(self.width as isize) as usize, row0, &cos, &mut below);
                    loaded = column;
                }
                at_azimuth(next, &mut right);
                let mut above = [0.0; 3];
                for k in 0..=n {
                    let here = self.along_latitude(self.lines[k], (psi, left[k]), (next, right[k]), &cot, &below);
                    if k > 0 {
                        let sum = &mut integrals[(k - 1) * n + n - 1 - face_column];
                        (0..3).for_each(|c| sum[c] += here[c] - above[c]);
                    }
                    above = here;
                }
                std::mem::swap(&mut left, &mut right);
            }
            psi = next;
            column += isize::from(picture <= next);
            if edges[face_column + 1] <= next {
                if watch.cancelled() {
                    return;
                }
                face_column += 1;
            }
        }
        finish(n, out, |x, y| integrals[y * n + x]);
    }

    /// Sums a column of the picture downwards from `row0`. Where the sum starts does not matter: it cancels between
    /// a texel's upper and lower edge.
    fn load_column(&self, column: usize, row0: usize, cos: &[f64], below: &mut [(Rgb, Rgb)]) {
        let mut sum = [0.0; 3];
        for (i, out) in below.iter_mut().enumerate() {
            let radiance = self.source.texels[(row0 + i) * self.width + column].map(f64::from);
            *out = (std::array::from_fn(|c| sum[c] + radiance[c] * cos[i]), radiance);
            (0..3).for_each(|c| sum[c] += radiance[c] * (cos[i] - cos[i + 1]));
        }
    }

    /// ∫ G dφ along the face's line `t` between two azimuths on one side of the middle and inside one column.
    fn along_latitude(&self, t: f64, from: (f64, Point), to: (f64, Point), cot: &[f64], below: &[(Rgb, Rgb)]) -> Rgb {
        let ((mut psi, mut point), (end, last)) = (from, to);
        let mut sum = [0.0; 3];
        loop {
            let (next, there) = if point.row == last.row {
                (end, Point { row: last.row, w: last.w })
            } else {
                // Cross into the neighbouring row where −t cos ψ = cot θ.
                let down = point.row < last.row;
                let line = if down { point.row + 1 } else { point.row };
                let cos_psi = (-cot[line] / t).clamp(0.0, 1.0);
                let next = cos_psi.acos().copysign(psi + end).clamp(psi, end);
                let w = t * next.sin() / (1.0 + cot[line] * cot[line]).sqrt();
                (next, Point { row: if down { line } else { line - 1 }, w })
            };
            let d_phi = next - psi;
            let d_cos = -arc(point.w, there.w);
            let (p, radiance) = &below[point.row];
            (0..3).for_each(|c| sum[c] += p[c] * d_phi - radiance[c] * d_cos);
            if point.row == last.row {
                return sum;
            }
            (psi, point) = (next, there);
        }
    }

    /// Row `i` of the picture, counted from a pole.
    fn row_from_pole(&self, north: bool, i: usize) -> &[[f32; 3]] {
        self.source.row(if north { i } else { self.height - 1 - i } as u32)
    }

    /// The face around a pole.
    fn polar_face(&self, north: bool, out: &mut [f32], watch: &Watch) {
        let (n, width) = (self.size, self.width);
        // Rows are counted from the pole. The corner of a face is at θ = acos(1/√3) = 0.304 π.
        let rows = ((self.height as f64 * 0.305).ceil() as usize + 1).min(self.height);
        let cos: Vec<f64> = (0..=rows).map(|i| self.theta(i).cos()).collect();
        let tan_squared: Vec<f64> =
            (0..=rows).map(|i| if 2 * i < self.height { self.theta(i).tan().powi(2) } else { f64::INFINITY }).collect();
        let mut below: Vec<Rgb> = Vec::with_capacity(rows * width);
        let mut sums = vec![[0f64; 3]; width];
        for i in 0..rows {
            below.extend(self.row_from_pole(north, i).iter().zip(&mut sums).map(|(texel, sum)| {
                let radiance = texel.map(f64::from);
                let p = std::array::from_fn(|c| sum[c] + radiance[c] * cos[i]);
                (0..3).for_each(|c| sum[c] += radiance[c] * (cos[i] - cos[i + 1]));
                p
            }));
        }
        let ratio = |along: f64, across: f64| if across.abs() > 1e-12 { along / across } else { f64::NAN };
        let meridians = (0..=width as isize)
            .map(|j| {
                let (sin, cos) = self.phi(j).sin_cos();
                let [along_x, along_z] = [ratio(sin, cos), ratio(cos, sin)];
                // Where it is not met, infinity of the sign that g times it is +∞.
                let met = |side: bool, ratio: f64, infinity: f64| if side { ratio } else { infinity };
                [
                    [met(cos < -1e-12, along_x, f64::NEG_INFINITY), met(cos > 1e-12, along_x, f64::INFINITY)],
                    [met(sin < -1e-12, along_z, f64::NEG_INFINITY), met(sin > 1e-12, along_z, f64::INFINITY)],
                ]
            })
            .collect();
        let field = Polar { grid: self, north, below, tan_squared, meridians };

        // Lines of constant x come first, then those of constant z; each gives its integral over every texel's edge.
        let lines: Vec<Vec<Rgb>> = (0..2 * (n + 1))
            .into_par_iter()
            .map(|i| match i {
                _ if watch.cancelled() => vec![],
                _ if i <= n => field.along(self.lines[i], true),
                _ => field.along(self.lines[i - n - 1], false),
            })
            .collect();
        if lines.iter().any(Vec::is_empty) {
            return;
        }
        let (constant_x, constant_z) = lines.split_at(n + 1);
        finish(n, out, |x, y| {
            // t follows +z on the upper face and −z on the lower one.
            let z = if north { y } else { n - 1 - y };
            std::array::from_fn(|c| {
                constant_z[z][x][c] - constant_z[z + 1][x][c] + constant_x[x + 1][z][c] - constant_x[x][z][c]
            })
        });
    }
}

/// A point on a face's line of constant t: its row, and w with ∫ cos θ dφ = −atan w.
#[derive(Clone, Copy, Default)]
struct Point {
    row: usize,
    w: f64,
}

/// atan(b) − atan(a) for values less than half a turn apart, without cancellation where they are close.
pub(super) fn arc(a: f64, b: f64) -> f64 {
    let x = (b - a) / (1.0 + a * b);
    if x.abs() < 0.03 && a * b > -1.0 {
        let y = x * x;
        x * (1.0 - y * (1.0 / 3.0 - y * (1.0 / 5.0 - y * (1.0 / 7.0 - y / 9.0))))
    } else {
        let d = b.atan() - a.atan();
        debug_assert!(d.abs() < PI);
        d
    }
}

/// The picture around a pole, summed outwards from it.
struct Polar<'a> {
    grid: &'a Grid<'a>,
    north: bool,
    /// S + L cos θ_i, by row from the pole, then column.
    below: Vec<Rgb>,
    /// tan² θ of the line on the pole's side of each row.
    tan_squared: Vec<f64>,
    /// u/g where the meridian left of each column meets the line x = g, and the line z = g: for g < 0, for g > 0.
    meridians: Vec<[[f64; 2]; 2]>,
}

impl Polar<'_> {
    /// ∫ G dφ over every texel's edge on the line x = g (z growing) or z = g (x growing).
    fn along(&self, g: f64, constant_x: bool) -> Vec<Rgb> {
        let (n, width) = (self.grid.size, self.grid.width);
        let mut edges = vec![[0f64; 3]; n];
        if g == 0.0 {
            return edges;
        }
        // On x = g, φ = atan2(u, g) grows with u where g > 0; on z = g, φ = atan2(g, u) falls.
        let forward = (g > 0.0) == constant_x;
        let sign = if constant_x { 1.0 } else { -1.0 };
        let start = if constant_x { (-1f64).atan2(g) } else { g.atan2(-1.0) };
        let mut column = self.grid.column(start).rem_euclid(width as isize) as usize;
        let g2 = g * g;
        let mut row = 0;
        while row + 1 < self.tan_squared.len() - 1 && self.tan_squared[row + 1] <= g2 + 1.0 {
            row += 1;
        }
        // Where the line meets the meridian at the far side of `column`, and the next row.
        let (line, positive) = (usize::from(!constant_x), usize::from(g > 0.0));
        let meridian = |column: usize| g * self.meridians[column + usize::from(forward)][line][positive];
        let crossing = |row: usize, u: f64| {
            let inner = self.tan_squared[row] - g2;
            let outer = self.tan_squared[row + 1] - g2;
            if u < 0.0 && inner > 0.0 { (-inner.sqrt(), false) } else { (outer.sqrt(), true) }
        };
        let w = |u: f64| u / (g * (1.0 + g2 + u * u).sqrt());

        let mut u = -1.0;
        let mut w_here = w(u);
        let mut next_meridian = meridian(column);
        let (mut next_row, mut outwards) = crossing(row, u);
        let mut texel = 0;
        while texel < n {
            let edge = self.grid.lines[texel + 1];
            let next = edge.min(next_meridian).min(next_row).max(u);
            let w_next = w(next);
            let turned = g * (next - u) / (g2 + u * next);
            let d_phi = sign
                * if turned.abs() < 0.03 && g2 + u * next > 0.0 {
                    arc(0.0, turned)
                } else {
                    (next / g).atan() - (u / g).atan()
                };
            let d_cos = sign * arc(w_here, w_next);
            let p = &self.below[row * width + column];
            let radiance = self.grid.row_from_pole(self.north, row)[column].map(f64::from);
            (0..3).for_each(|c| edges[texel][c] += p[c] * d_phi - radiance[c] * d_cos);
            (u, w_here) = (next, w_next);
            if next_meridian <= u {
                column = if forward { (column + 1) % width } else { (column + width - 1) % width };
                next_meridian = meridian(column);
            }
            if next_row <= u {
                row = if outwards { row + 1 } else { row - 1 };
                // A line that was crossed inwards just now must not be crossed again at the same place.
                (next_row, outwards) = crossing(row, u);
            }
            texel += usize::from(edge <= u);
        }
        edges
    }
}
