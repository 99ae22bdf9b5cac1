// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rectangles of a cube's faces, which lie below each other in rows of their own.
//!
//! Integrals over a texel are taken at 2 × 2 Gauss points of (s, t), which for faces of 128 texels and more leaves a
//! relative error below 1e-8: they are summed in the face's own axes and then carried to the world's.

use super::{FINE, Light, Node, Rect, Sums};
use crate::env::{CubeMap, orientation};
use crate::term::cube::direction;

/// Largest side of a face in texels: a row and half a face's number share 16 bits.
pub const MAX_SIZE: u32 = 4096;

/// Bits of a row or column inside a face.
const CORNER_BITS: u32 = 14;

/// Half the distance between two Gauss points, in units of the interval.
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// The face of a leaf of a cube, and its first column and row there, in units of a texel / [`FINE`].
pub fn face_and_corner(node: &Node) -> (u32, [u32; 2]) {
    let [row, column] = [node.rows[0], node.columns[0]].map(u32::from);
    let inside = (1 << CORNER_BITS) - 1;
    (row >> CORNER_BITS | column >> CORNER_BITS << 2, [column & inside, row & inside])
}

pub(super) struct Chart<'a> {
    source: &'a CubeMap,
    /// Units along a side of a face.
    side: u32,
}

impl<'a> Chart<'a> {
    pub(super) fn new(source: &'a CubeMap) -> Self {
        assert!(source.size <= MAX_SIZE, "the reader refuses larger faces");
        Self { source, side: FINE * source.size }
    }

    fn faces(&self, r: Rect) -> u32 {
        (r.r1 - r.r0).div_ceil(self.side)
    }

    /// From s0 to s1 and from t0 to t1.
    fn bounds(&self, r: Rect) -> [[f64; 2]; 2] {
        let at = |unit: u32| 2.0 * f64::from(unit) / f64::from(self.side) - 1.0;
        let top = r.r0 / self.side * self.side;
        [[at(r.c0), at(r.c1)], [at(r.r0 - top), at(r.r1 - top)]]
    }
}

impl super::Chart for Chart<'_> {
    fn size(&self) -> (u32, u32) {
        (6 * self.side, self.side)
    }

    fn sides(&self, r: Rect) -> (f64, f64) {
        let [s, t] = self.bounds(r);
        // A step along s is longest where s and t are nearest to 0.
        let least = |v: [f64; 2]| if v[0] * v[1] <= 0.0 { 0.0 } else { v[0].abs().min(v[1].abs()) };
        let (s2, t2) = (least(s).powi(2), least(t).powi(2));
        let length2 = 1.0 + s2 + t2;
        ((t[1] - t[0]) * (1.0 + s2).sqrt() / length2, (s[1] - s[0]) * (1.0 + t2).sqrt() / length2)
    }

    fn half_diagonal(&self, r: Rect) -> f64 {
        if self.faces(r) > 1 {
            return 2.0;
        }
        let (height, width) = self.sides(r);
        // The axes are not at right angles away from the face's middle lines.
        let [s2, t2] = self.bounds(r).map(|v| v[0].abs().max(v[1].abs()).powi(2));
        let skew = (s2 * t2 / ((1.0 + s2) * (1.0 + t2))).sqrt();
        0.5 * (height * height + width * width + 2.0 * skew * height * width).sqrt()
    }

    fn solid_angle_sr(&self, r: Rect) -> f64 {
        if self.faces(r) > 1 {
            return f64::from(self.faces(r)) * 4.0 * std::f64::consts::PI / 6.0;
        }
        let [[s0, s1], [t0, t1]] = self.bounds(r);
        let corner = orientation::solid_angle;
        corner(s1, t1) - corner(s0, t1) - corner(s1, t0) + corner(s0, t0)
    }

    fn seam(&self, r: Rect) -> Option<u32> {
        let faces = self.faces(r);
        (faces > 1).then(|| r.r0 + faces / 2 * self.side)
    }

    fn sums(&self, r: Rect, light: &Light) -> Sums {
        let face = r.r0 / self.side;
        let (first_row, first_column) = ((r.r0 - face * self.side) / FINE, r.c0 / FINE);
        let (rows, columns) = (((r.r1 - r.r0) / FINE).max(1), ((r.c1 - r.c0) / FINE).max(1));
        let [[s0, s1], [t0, t1]] = self.bounds(r);
        // Of a texel, or of the part.
        let (ds, dt) = ((s1 - s0) / f64::from(columns), (t1 - t0) / f64::from(rows));

        // In the face's axes s, t and outwards.
        let mut local = Sums::default();
        for y in 0..rows {
            for x in 0..columns {
                let texel = self.source.texel(face, first_column + x, first_row + y);
                let radiance: [f64; 3] = std::array::from_fn(|k| f64::from(texel[k] - light.base[k]));
                let w = (0..3).map(|k| radiance[k] * light.inverse_mean[k]).sum::<f64>();
                let (mut one, mut first, mut second) = (0.0, [0.0; 3], [0.0; 6]);
                for (i, j) in [(-GAUSS, -GAUSS), (GAUSS, -GAUSS), (-GAUSS, GAUSS), (GAUSS, GAUSS)] {
                    let (s, t) = (s0 + (f64::from(x) + 0.5 + i) * ds, t0 + (f64::from(y) + 0.5 + j) * dt);
                    let inverse2 = 1.0 / (1.0 + s * s + t * t);
                    let inverse = inverse2.sqrt();
                    let share = 0.25 * ds * dt * inverse2 * inverse;
                    let (along, twice) = (share * inverse, share * inverse2);
                    one += share;
                    (0..3).for_each(|i| first[i] += along * [s, t, 1.0][i]);
                    (0..6).for_each(|i| second[i] += twice * [s * s, t * t, 1.0, s * t, s, t][i]);
                }
                for (k, radiance) in radiance.into_iter().enumerate() {
                    local.e[k] += radiance * one;
                    (0..3).for_each(|i| local.first[k][i] += radiance * first[i]);
                }
                (0..6).for_each(|i| local.second[i] += w * second[i]);
            }
        }

        // Every axis of the face is an axis of the world, or its opposite.
        let centre = direction(face, 0.0, 0.0);
        let from_centre = |d: [f64; 3]| [0, 1, 2].map(|i| d[i] - centre[i]);
        let axes = [from_centre(direction(face, 1.0, 0.0)), from_centre(direction(face, 0.0, 1.0)), centre];
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let mut sums = Sums { e: local.e, ..Sums::default() };
        for k in 0..3 {
            sums.first[k] = std::array::from_fn(|x| (0..3).map(|i| axes[i][x] * local.first[k][i]).sum());
        }
        sums.second = pairs.map(|(x, y)| {
            let term = |(n, (i, j)): (usize, &(usize, usize))| {
                let (i, j) = (*i, *j);
                let both =
                    if i == j { axes[i][x] * axes[i][y] } else { axes[i][x] * axes[j][y] + axes[j][x] * axes[i][y] };
                both * local.second[n]
            };
            pairs.iter().enumerate().map(term).sum()
        });
        sums
    }

    fn place(&self, r: Rect) -> [[u16; 2]; 2] {
        let face = r.r0 / self.side;
        let side = |from: u32, to: u32, bits: u32| [(from | bits << CORNER_BITS) as u16, (to - from) as u16];
        let top = face * self.side;
        if self.faces(r) > 1 {
            return [[0; 2]; 2];
        }
        [side(r.r0 - top, r.r1 - top, face & 3), side(r.c0, r.c1, face >> 2)]
    }
}
