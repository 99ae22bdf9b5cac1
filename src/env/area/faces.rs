// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cubes, turned or not.
//!
//! All edges are great circles, which a face shows as straight lines. A texel of the output is carried into the picture,
//! cut to each face that it touches and there to each source texel; what is left are convex polygons whose solid angles
//! are closed, so that the mean is exact.

use rayon::prelude::*;

use super::{Rgb, STAGE, axes, lines};
use crate::env::{CubeMap, Frame};
use crate::error::Result;
use crate::progress::{OnProgress, tick};

/// Rows of texels between two looks at the progress listener.
const ROWS: usize = 64;

/// Mean radiance of every texel of a cube whose directions `frame` carries into the picture.
pub fn cube(source: &CubeMap, frame: &Frame, size: u32, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
    let n = size as usize;
    if *frame == Frame::IDENTITY && size == source.size {
        return Ok(source.texels.as_flattened().to_vec());
    }
    let grid = Grid::new(source);
    let lines = lines(n);
    let mut texels = vec![0f32; 6 * n * n * 3];
    for (face, out) in texels.chunks_exact_mut(n * n * 3).enumerate() {
        let [centre, s_axis, t_axis] = axes(face as u32).map(|d| frame.to_picture(d));
        let corner = |x: usize, y: usize| -> [f64; 3] {
            std::array::from_fn(|i| centre[i] + lines[x] * s_axis[i] + lines[y] * t_axis[i])
        };
        for (band, out) in out.chunks_mut(ROWS * n * 3).enumerate() {
            tick(on, STAGE, (face as f64 + (band * ROWS) as f64 / n as f64) / 6.0)?;
            out.par_chunks_exact_mut(n * 3).enumerate().for_each(|(row, out)| {
                let y = band * ROWS + row;
                for (x, texel) in out.chunks_exact_mut(3).enumerate() {
                    let mean = grid.mean(&[corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)]);
                    texel.copy_from_slice(&mean.map(|v| v as f32));
                }
            });
        }
    }
    Ok(texels)
}

/// The source and its lines.
pub(super) struct Grid<'a> {
    source: &'a CubeMap,
    /// Centre, s axis and t axis of every face.
    axes: [[[f64; 3]; 3]; 6],
    lines: Vec<f64>,
    /// Of the texels of a face.
    solid_angles_sr: Vec<f64>,
}

impl<'a> Grid<'a> {
    pub(super) fn new(source: &'a CubeMap) -> Self {
        Self {
            source,
            axes: std::array::from_fn(|face| axes(face as u32)),
            lines: lines(source.size as usize),
            solid_angles_sr: CubeMap::solid_angles_sr(source.size),
        }
    }

    /// Mean radiance over a convex polygon of great circles smaller than a hemisphere.
    pub(super) fn mean(&self, corners: &[[f64; 3]]) -> Rgb {
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        for (face, axes) in self.axes.iter().enumerate() {
            // As (distance from the eye, s, t), cut to the pyramid of the face.
            let mut polygon = Polygon::new(corners.iter().map(|p| axes.map(|axis| dot(*p, axis))));
            for (axis, sign) in [(1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
                polygon = polygon.cut(|p| p[0] - sign * p[axis]);
            }
            if polygon.points().len() >= 3 {
                let flat = Polygon::new(polygon.points().iter().map(|p| [1.0, p[1] / p[0], p[2] / p[0]]));
                self.add(face, &flat, &mut sum, &mut weight);
            }
        }
        sum.map(|v| v / weight)
    }

    /// Adds the part of one face under a polygon.
    fn add(&self, face: usize, polygon: &Polygon, sum: &mut Rgb, weight: &mut f64) {
        let n = self.source.size as usize;
        let cells = |axis: usize, polygon: &Polygon| {
            let (low, high) = polygon.extent(axis);
            let cell = |v: f64| ((0.5 * (v + 1.0) * n as f64) as usize).min(n - 1);
            cell(low)..=cell(high)
        };
        let between = |polygon: &Polygon, axis: usize, k: usize| {
            let (low, high) = (self.lines[k], self.lines[k + 1]);
            polygon.cut(|p| p[axis] - low).cut(|p| high - p[axis])
        };
        for y in cells(2, polygon) {
            let strip = between(polygon, 2, y);
            if strip.points().len() < 3 {
                continue;
            }
            for x in cells(1, &strip) {
                let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
                let share = if corners.iter().all(|(x, y)| polygon.holds(self.lines[*x], self.lines[*y])) {
                    self.solid_angles_sr[y * n + x]
                } else {
                    between(&strip, 1, x).solid_angle_sr()
                };
                let texel = self.source.texels[(face * n + y) * n + x];
                (0..3).for_each(|c| sum[c] += share * f64::from(texel[c]));
                *weight += share;
            }
        }
    }
}

/// Most corners: eight, and one more for each of four planes, two rows and two columns.
const CORNERS: usize = 16;

/// A convex polygon of points (distance, s, t).
#[derive(Clone, Copy)]
struct Polygon {
    points: [[f64; 3]; CORNERS],
    count: usize,
}

impl Polygon {
    const EMPTY: Polygon = Polygon { points: [[0.0; 3]; CORNERS], count: 0 };

    fn new(points: impl IntoIterator<Item = [f64; 3]>) -> Self {
        let mut polygon = Self::EMPTY;
        points.into_iter().for_each(|p| polygon.push(p));
        polygon
    }

    fn push(&mut self, point: [f64; 3]) {
        // Rounding may give a corner too many; it lies on an edge.
        if self.count < CORNERS {
            self.points[self.count] = point;
            self.count += 1;
        }
    }

    fn points(&self) -> &[[f64; 3]] {
        &self.points[..self.count]
    }

    /// The part where `side`, a linear function, is not negative (Sutherland and Hodgman 1974).
    fn cut(&self, side: impl Fn(&[f64; 3]) -> f64) -> Polygon {
        let mut out = Self::EMPTY;
        let Some(mut from) = self.points().last() else { return out };
        let mut at_from = side(from);
        for to in self.points() {
            let at_to = side(to);
            if (at_from < 0.0) != (at_to < 0.0) {
                let share = at_from / (at_from - at_to);
                out.push(std::array::from_fn(|i| from[i] + share * (to[i] - from[i])));
            }
            if at_to >= 0.0 {
                out.push(*to);
            }
            (from, at_from) = (to, at_to);
        }
        out
    }

    /// Lowest and highest value of one coordinate.
    fn extent(&self, axis: usize) -> (f64, f64) {
        let values = self.points().iter().map(|p| p[axis]);
        values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
    }

    /// Is a point (s, t) of the plane inside, edges included?
    fn holds(&self, s: f64, t: f64) -> bool {
        let (mut left, mut right) = (false, false);
        let mut from = self.points[self.count - 1];
        for to in self.points() {
            let side = (to[1] - from[1]) * (t - from[2]) - (to[2] - from[2]) * (s - from[1]);
            left |= side > 0.0;
            right |= side < 0.0;
            from = *to;
        }
        !(left && right)
    }

    /// Solid angle of a polygon in the plane at distance 1, by triangles (Van Oosterom and Strackee 1983).
    fn solid_angle_sr(&self) -> f64 {
        let points = self.points();
        let mut sum = 0.0;
        for i in 2..points.len() {
            let [a, b, c] = [points[0], points[i - 1], points[i]];
            let twice_area = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
            let dot = |a: [f64; 3], b: [f64; 3]| 1.0 + a[1] * b[1] + a[2] * b[2];
            let [la, lb, lc] = [a, b, c].map(|p| dot(p, p).sqrt());
            sum += 2.0 * twice_area.atan2(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
        }
        sum.abs()
    }
}
