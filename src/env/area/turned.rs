// SPDX-License-Identifier: MIT OR Apache-2.0
//! Equirectangular pictures that are turned about any axis, or mirrored.
//!
//! Green's theorem as in [`super::upright`]: the integral over a texel is ∮ G dφ along its boundary. Here every line of a
//! face is a great circle in general position. It is cut where it crosses the picture's parallels and meridians and the
//! face's own lines; inside one source texel
//!
//! ```text
//! ∫ G dφ = (S + L cos θ_i) Δφ − L ∫ cos θ dφ,    ∫ cos θ dφ = Δφ − Ω
//! ```
//!
//! with Ω the solid angle between the pole and the arc, which is closed (Van Oosterom and Strackee 1983). Beyond the
//! equator the same is taken from the other pole, where it does not cancel.
//!
//! G is 0 at the pole from which it is summed, so a texel that holds a pole needs no special case when it is summed from
//! there. Both sums are kept: a texel whose middle is on the upper half of the picture takes the one from the top.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::{Rgb, STAGE, axes, finish, lines};
use crate::env::{Equirect, Frame};
use crate::error::Result;
use crate::progress::{OnProgress, tick};

/// Column sums are kept for every so many rows.
const STRIDE: usize = 8;
/// Lines that are integrated between two looks at the progress listener.
const LINES: usize = 64;

/// ∫ G dφ along one edge of a texel, G summed from the top of the picture and from its bottom.
type Edge = [Rgb; 2];

/// Mean radiance of every texel of a cube whose directions `frame` carries into the picture.
pub fn cube(source: &Equirect, frame: &Frame, size: u32, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
    let n = size as usize;
    let field = Field::new(source);
    let lines = lines(n);
    // s × t points inwards on every face, and a mirror turns that round.
    let sign = if frame.mirrors() { -1.0 } else { 1.0 };
    let mut texels = vec![0f32; 6 * n * n * 3];
    for (face, out) in texels.chunks_exact_mut(n * n * 3).enumerate() {
        let [centre, s_axis, t_axis] = axes(face as u32).map(|d| frame.to_picture(d));
        let upper: Vec<bool> = (0..n * n)
            .map(|i| {
                let middle = |k: usize| 0.5 * (lines[k] + lines[k + 1]);
                centre[1] + middle(i % n) * s_axis[1] + middle(i / n) * t_axis[1] >= 0.0
            })
            .collect();
        let mut integrals = vec![[0f64; 3]; n * n];
        // Lines of constant t, each once as the upper and once as the lower edge of texels; then those of constant s.
        for (fixed, along) in [(t_axis, s_axis), (s_axis, t_axis)] {
            let rows = fixed == t_axis;
            for first in (0..=n).step_by(LINES) {
                let done = first as f64 / (2 * (n + 1)) as f64 + if rows { 0.0 } else { 0.5 };
                tick(on, STAGE, (face as f64 + done) / 6.0)?;
                let last = (first + LINES).min(n + 1);
                let edges: Vec<Vec<Edge>> = lines[first..last]
                    .par_iter()
                    .map(|k| field.along(std::array::from_fn(|i| centre[i] + k * fixed[i]), along, &lines))
                    .collect();
                for (k, edges) in (first..last).zip(edges) {
                    for (i, edge) in edges.into_iter().enumerate() {
                        let mut add = |texel: usize, sign: f64| {
                            let edge = &edge[usize::from(!upper[texel])];
                            (0..3).for_each(|c| integrals[texel][c] += sign * edge[c]);
                        };
                        // Upper edges and right ones are followed forwards, the others back.
                        if k < n {
                            if rows { add(k * n + i, sign) } else { add(i * n + k, -sign) }
                        }
                        if k > 0 {
                            if rows { add((k - 1) * n + i, -sign) } else { add(i * n + k - 1, sign) }
                        }
                    }
                }
            }
        }
        finish(n, out, |x, y| integrals[y * n + x]);
    }
    Ok(texels)
}

/// A picture with its column sums.
pub(super) struct Field<'a> {
    source: &'a Equirect,
    width: usize,
    height: usize,
    /// Cosine of θ on every line between rows.
    cos: Vec<f64>,
    /// Sine and cosine of φ on the lines left of the first half of the columns; the others lie on the same circles.
    meridians: Vec<(f64, f64)>,
    /// Σ L (cos θ_k − cos θ_k+1) over the rows above every [`STRIDE`]th one, by column.
    sums: Vec<Rgb>,
    /// The same over all rows.
    totals: Vec<Rgb>,
}

impl<'a> Field<'a> {
    pub(super) fn new(source: &'a Equirect) -> Self {
        let (width, height) = (source.width as usize, source.height as usize);
        let cos: Vec<f64> = (0..=height).map(|i| (PI * i as f64 / height as f64).cos()).collect();
        let mut sums = Vec::with_capacity(height.div_ceil(STRIDE) * width);
        let mut totals = vec![[0f64; 3]; width];
        for i in 0..height {
            if i % STRIDE == 0 {
                sums.extend_from_slice(&totals);
            }
            let share = cos[i] - cos[i + 1];
            for (total, texel) in totals.iter_mut().zip(source.row(i as u32)) {
                (0..3).for_each(|c| total[c] += f64::from(texel[c]) * share);
            }
        }
        let meridians = (0..width.div_ceil(2)).map(|j| (TAU * (j as f64 / width as f64 - 0.5)).sin_cos()).collect();
        Self { source, width, height, cos, meridians, sums, totals }
    }

    /// Mean radiance over a convex polygon of great circles smaller than a hemisphere.
    pub(super) fn mean(&self, corners: &[[f64; 3]]) -> Rgb {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let unit = |v: [f64; 3]| v.map(|c| c / dot(v, v).sqrt());
        let (mut sum, mut solid_angle) = ([0.0; 3], 0.0);
        let from_bottom = usize::from(corners.iter().map(|c| unit(*c)[1]).sum::<f64>() < 0.0);
        let first = unit(corners[0]);
        for i in 0..corners.len() {
            let (a, b) = (unit(corners[i]), unit(corners[(i + 1) % corners.len()]));
            let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
            let half = std::array::from_fn(|k| 0.5 * (b[k] - a[k]));
            let [edge] = self.along(middle, half, &[-1.0, 1.0])[..] else { unreachable!("one interval, one edge") };
            (0..3).for_each(|c| sum[c] += edge[from_bottom][c]);
            // The triangle with the first corner (Van Oosterom and Strackee 1983).
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let below = 1.0 + dot(first, a) + dot(a, b) + dot(b, first);
            solid_angle += 2.0 * dot(first, cross).atan2(below);
        }
        // Seen from outside, azimuths grow clockwise about the pole.
        sum.map(|v| -v / solid_angle)
    }

    /// ∫ G dφ on the line `start` + u `along`, −1 ≤ u ≤ 1, over the edges between `lines`; the two are orthogonal.
    fn along(&self, start: [f64; 3], along: [f64; 3], lines: &[f64]) -> Vec<Edge> {
        let n = lines.len() - 1;
        let mut cuts = lines.to_vec();
        let inside = |u: &f64| *u > -1.0 && *u < 1.0;
        let cross = |(sin, cos): &(f64, f64)| -(start[0] * sin - start[2] * cos) / (along[0] * sin - along[2] * cos);
        self.each_meridian(start, along, |meridian| cuts.extend(Some(cross(meridian)).filter(inside)));
        // A parallel and its mirror image below the equator are one cone: y² = cos² θ |p|².
        let square = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>();
        let (length2, along2) = (square(start), square(along));
        for cos in self.parallels(start, along, length2, along2) {
            let a = cos * cos * along2 - along[1] * along[1];
            let b = -start[1] * along[1];
            let c = cos * cos * length2 - start[1] * start[1];
            let q = -(b + (b * b - a * c).sqrt().copysign(b));
            cuts.extend([q / a, c / q].into_iter().filter(inside));
        }
        // The equator, where the other pole takes over.
        cuts.extend(Some(-start[1] / along[1]).filter(inside));
        cuts.sort_unstable_by(f64::total_cmp);

        let at = |u: f64| -> [f64; 3] {
            let p: [f64; 3] = std::array::from_fn(|i| start[i] + u * along[i]);
            let inverse = 1.0 / (length2 + u * u * along2).sqrt();
            p.map(|v| v * inverse)
        };
        let mut edges = vec![[[0f64; 3]; 2]; n];
        let (mut u, mut here) = (-1.0, at(-1.0));
        for next in cuts.into_iter().skip(1) {
            if next <= u {
                continue;
            }
            let there = at(next);
            let middle = 0.5 * (u + next);
            let texel = ((0.5 * (middle + 1.0) * n as f64) as usize).min(n - 1);
            let (from_top, from_bottom) = self.piece(here, there, at(middle));
            (0..3).for_each(|c| {
                edges[texel][0][c] += from_top[c];
                edges[texel][1][c] += from_bottom[c];
            });
            (u, here) = (next, there);
        }
        edges
    }

    /// Calls `cross` for the meridians that a line may cross.
    fn each_meridian(&self, start: [f64; 3], along: [f64; 3], mut cross: impl FnMut(&(f64, f64))) {
        let [a, b] = [-1.0, 1.0].map(|u| [start[0] + u * along[0], start[2] + u * along[2]]);
        let turn = (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
        let count = self.meridians.len() as i64;
        let at = |phi: f64| (phi / TAU + 0.5) * self.width as f64;
        let (from, to) = (at(a[1].atan2(a[0])), at(a[1].atan2(a[0]) + turn));
        // Near a pole the turn is not well known.
        if turn.abs() > 3.0 || !self.width.is_multiple_of(2) {
            self.meridians.iter().for_each(cross);
        } else {
            let (first, last) = (from.min(to).floor() as i64, from.max(to).ceil() as i64);
            (first..=last.min(first + count)).for_each(|j| cross(&self.meridians[j.rem_euclid(count) as usize]));
        }
    }

    /// Cosines of the parallels of the upper half that a line, or its mirror image, may cross.
    fn parallels(&self, start: [f64; 3], along: [f64; 3], length2: f64, along2: f64) -> &[f64] {
        let height = |u: f64| (start[1] + u * along[1]) / (length2 + u * u * along2).sqrt();
        let (a, b) = (height(-1.0), height(1.0));
        // The highest or lowest place of the circle.
        let turning = along[1] * length2 / (start[1] * along2);
        let top = if turning.abs() < 1.0 { height(turning) } else { a };
        let most = a.abs().max(b.abs()).max(top.abs()) + 1e-12;
        let least = if a * b <= 0.0 { 0.0 } else { a.abs().min(b.abs()).min(top.abs()) - 1e-12 };
        let upper = &self.cos[1..=self.height / 2];
        &upper[upper.partition_point(|c| *c > most)..upper.partition_point(|c| *c >= least)]
    }

    /// ∫ G dφ from `a` to `b`, unit vectors, inside the source texel that holds `middle`; summed from the top, and from
    /// the bottom.
    fn piece(&self, a: [f64; 3], b: [f64; 3], middle: [f64; 3]) -> (Rgb, Rgb) {
        let [u, v] = Equirect::locate(middle);
        let column = ((u * self.width as f64) as usize).min(self.width - 1);
        let row = ((v * self.height as f64) as usize).min(self.height - 1);
        let mut sum = self.sums[row / STRIDE * self.width + column];
        for i in row / STRIDE * STRIDE..row {
            let texel = self.source.row(i as u32)[column];
            (0..3).for_each(|c| sum[c] += f64::from(texel[c]) * (self.cos[i] - self.cos[i + 1]));
        }
        let radiance = self.source.row(row as u32)[column].map(f64::from);

        let across = a[0] * b[2] - a[2] * b[0];
        let d_phi = across.atan2(a[0] * b[0] + a[2] * b[2]);
        let dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let upper = middle[1] >= 0.0;
        let to_pole = if upper { a[1] + b[1] } else { -a[1] - b[1] };
        let solid_angle = 2.0 * across.atan2(1.0 + dot + to_pole);
        // cos θ_i Δφ − ∫ cos θ dφ
        let own = if upper {
            (self.cos[row] - 1.0) * d_phi + solid_angle
        } else {
            (self.cos[row] + 1.0) * d_phi - solid_angle
        };
        let from_top: Rgb = std::array::from_fn(|c| sum[c] * d_phi + radiance[c] * own);
        let total = &self.totals[column];
        let from_bottom = std::array::from_fn(|c| (sum[c] - total[c]) * d_phi + radiance[c] * own);
        (from_top, from_bottom)
    }
}
