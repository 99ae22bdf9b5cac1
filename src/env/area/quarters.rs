// SPDX-License-Identifier: MIT OR Apache-2.0
//! Upright pictures that lie alike in every quarter of every face: where the centres of the side faces fall between two
//! columns and the equator between two rows.
//!
//! The boundary integrals are those of [`super::upright`]. Most of their cost is geometry: where an edge meets the
//! picture's lines, and ∫ dφ and ∫ cos θ dφ in between. A mirror image has the same, so here it is found once for a quarter
//! of a side face and once for a quarter of a polar one, and all 24 quarters only add up radiance with it.
//!
//! A quarter is taken from its corner in the middle of the face. c stands for cos θ on polar faces, with θ from the pole
//! in the middle, and for −sin λ on side faces, with the latitude λ from the equator; either way it falls from row to row, and
//!
//! ```text
//! ∬_T L dω = ∮_∂T G dφ,    G = S + L (c_row − c),    S = Σ L (c_row − c_next) over the rows before
//! ```
//!
//! - **Side faces.** The line t = τ has tan λ = τ cos ψ at the azimuth ψ from the middle, and ∫ c dψ = −atan w with
//!   w = τ sin ψ/√(1 + τ² cos² ψ). Lines of constant s are meridians.
//! - **Polar faces.** On the line x = g, tan² θ = g² + z², and ∫ c dφ = atan w with w = z/(g √(1 + g² + z²)). The line z = g
//!   is its mirror image in the quarter.
//!
//! A quarter is gone through row by row of the picture, so that S is wanted for one row of the picture at a time; a piece of an
//! edge adds S ∫ dφ + L ∫ (c_row − c) dφ.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::upright::arc;
use super::{Rgb, STAGE};
use crate::env::{Equirect, orientation};
use crate::error::Result;
use crate::progress::{OnProgress, Watch, watched};

/// More pieces than these, 24 bytes each, are not kept.
const MOST_PIECES: usize = 1 << 21;
/// A quarter's columns, rows and texels are counted in 16 bits.
const MOST_COLUMNS: usize = 1 << 17;

/// How a picture lies in the quarters, where it lies alike in all of them.
pub struct Quarters<'a> {
    source: &'a Equirect,
    /// Column right of the azimuth 0 of the output.
    first_column: usize,
    /// Texels along a side of a quarter.
    side: usize,
}

/// A part of an edge of a texel, inside one texel of the picture.
#[derive(Clone, Copy, Default)]
struct Piece {
    /// Rows from the pole or from the equator.
    row: u16,
    /// Columns from the middle of a side face, or from the axis that a polar line crosses.
    column: u16,
    /// Of the line, from 0 for line 1.
    line: u16,
    /// Which texel's edge, along the line.
    texel: u16,
    /// ∫ dφ
    d_phi: f64,
    /// ∫ (c_row − c) dφ
    d_c: f64,
}

/// The pieces of the lines 1, 2, … of a quarter, row by row of the picture.
struct Geometry {
    /// Texels along a line.
    side: usize,
    pieces: Vec<Piece>,
    rows: Vec<Row>,
}

struct Row {
    /// How many it has.
    pieces: usize,
    /// c at its start over c at the next one's.
    drop: f64,
}

/// A quarter that is gone through. One after the other uses the same memory.
#[derive(Default)]
struct Quarter {
    /// Which columns of the picture it has, in its order.
    columns: Vec<usize>,
    /// Their light in the row.
    lights: Vec<[f32; 3]>,
    /// S before the row.
    sums: Vec<Rgb>,
    /// ∫ G dφ over the edges of the texels, line by line.
    edges: Vec<Rgb>,
    /// The same of the mirror image of a polar quarter; empty for others.
    mirrored: Vec<Rgb>,
}

impl<'a> Quarters<'a> {
    /// `None` where the quarters differ, or where there are too many pieces to keep.
    pub fn new(source: &'a Equirect, azimuth_rad: f64, size: u32) -> Option<Self> {
        let (width, side) = (source.width as usize, size as usize / 2);
        let turned = azimuth_rad / TAU * width as f64;
        let between = width.is_multiple_of(4) && (turned - turned.round()).abs() < 1e-9;
        let few = width <= MOST_COLUMNS && (width / 4 + 3 * side) * side <= MOST_PIECES;
        (between && size.is_multiple_of(2) && few).then(|| Self {
            source,
            first_column: (turned.round() as i64 + width as i64 / 2).rem_euclid(width as i64) as usize,
            side,
        })
    }

    /// Mean radiance of every texel of the cube.
    pub fn cube(&self, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
        let n = 2 * self.side;
        let mut texels = vec![0f32; 6 * n * n * 3];
        // The picture's rows on a quarter are its parts.
        watched(on, STAGE, 16 * self.rows_around() + 8 * self.rows_polar(), |watch| {
            let (around, polar) = rayon::join(|| self.around(), || self.polar());
            let solid_angles_sr = self.solid_angles_sr();
            // Half of the faces, one of them polar, for each of two threads.
            let faces =
                texels.par_chunks_mut(n * n * 3).enumerate().with_min_len(6 / rayon::current_num_threads().min(6));
            faces.for_each_init(Quarter::default, |quarter, (face, out)| {
                for number in 0..4 {
                    let done = match face {
                        2 | 3 => self.through_polar(quarter, &polar, face == 2, number, watch),
                        _ => self.through_side(quarter, &around, [0, 2, 0, 0, 1, 3][face], number, watch),
                    };
                    if !done {
                        return;
                    }
                    for (index, solid_angle) in solid_angles_sr.iter().enumerate() {
                        let (i, j) = (index / self.side, index % self.side);
                        let (x, y) = self.place(face, number, i, j);
                        let texel = &mut out[3 * (y * n + x)..][..3];
                        let integral = quarter.integral(self.side, i, j);
                        // Radiance is not negative; rounding may leave −1e−17 beside a sun.
                        texel.iter_mut().zip(integral).for_each(|(t, v)| *t = (v / solid_angle).max(0.0) as f32);
                    }
                }
            });
        })?;
        Ok(texels)
    }

    /// Column and row of the texel of a face that is (i, j) in a quarter.
    fn place(&self, face: usize, quarter: usize, i: usize, j: usize) -> (usize, usize) {
        let (before, after) = (|k: usize| self.side - 1 - k, |k: usize| self.side + k);
        if face != 2 && face != 3 {
            // i from the equator; ψ runs against s.
            let x = if quarter & 1 == 0 { before(j) } else { after(j) };
            return (x, if quarter & 2 == 0 { before(i) } else { after(i) });
        }
        // i along the quarter's first axis: +x, +z, −x, −z.
        let (x, z) = match quarter {
            0 => (after(i), after(j)),
            1 => (before(j), after(i)),
            2 => (before(i), before(j)),
            _ => (after(j), before(i)),
        };
        // t follows +z on the upper face and −z on the lower one.
        (x, if face == 2 { z } else { 2 * self.side - 1 - z })
    }

    /// Of a quarter's texels.
    fn solid_angles_sr(&self) -> Vec<f64> {
        let stride = self.side + 1;
        let at = |k: usize| k as f64 / self.side as f64;
        let corners: Vec<f64> =
            (0..stride * stride).map(|i| orientation::solid_angle(at(i / stride), at(i % stride))).collect();
        let texel = |i: usize| {
            let at = i / self.side * stride + i % self.side;
            corners[at + stride + 1] - corners[at + stride] - corners[at + 1] + corners[at]
        };
        (0..self.side * self.side).map(texel).collect()
    }

    /// Columns between the middle of a side face and its border.
    fn eighth(&self) -> usize {
        (self.source.width as usize).div_ceil(8)
    }

    /// Rows between the equator and the corner of a side face, or a little more.
    fn rows_around(&self) -> usize {
        (self.source.height as usize).div_ceil(4)
    }

    /// Rows between a pole and the corner of its face, at θ = acos(1/√3) = 0.304 π.
    fn rows_polar(&self) -> usize {
        let height = self.source.height as usize;
        ((height as f64 * 0.305).ceil() as usize + 1).min(height)
    }

    /// Angle from the pole or the equator to the start of row `i` there.
    fn angle(&self, i: usize) -> f64 {
        PI * i as f64 / f64::from(self.source.height)
    }

    /// tan of the same; infinite from a quarter turn on.
    fn tan(&self, i: usize) -> f64 {
        if 2 * i < self.source.height as usize { self.angle(i).tan() } else { f64::INFINITY }
    }

    /// The lines of constant t on a quarter of a side face.
    fn around(&self) -> Geometry {
        let (side, d_phi) = (self.side, TAU / f64::from(self.source.width));
        let rows = self.rows_around();
        let last_column = self.eighth() - 1;
        let c: Vec<f64> = (0..=rows).map(|i| -self.angle(i).sin()).collect();
        let tan: Vec<f64> = (0..=rows).map(|i| self.tan(i)).collect();
        let edges: Vec<f64> = (0..=side).map(|j| (j as f64 / side as f64).atan()).collect();
        let line = |i: usize| {
            let tau = i as f64 / side as f64;
            let w = |psi: f64, tan: f64| tau * psi.sin() / (1.0 + tan * tan).sqrt();
            // Latitude falls along the line. Where it starts on a row's border, that row is never entered.
            let mut row = tan.partition_point(|t| *t < tau).clamp(1, rows) - 1;
            let crossing = |row: usize| if row > 0 { (tan[row] / tau).min(1.0).acos() } else { f64::INFINITY };
            let (mut psi, mut w_here, mut column, mut texel) = (0.0, 0.0, 0, 0);
            let (mut next_row, mut next_column) = (crossing(row), d_phi);
            let mut pieces = vec![];
            while texel < side {
                let next = edges[texel + 1].min(next_column).min(next_row).max(psi);
                let w_next = if next == next_row { w(next, tan[row]) } else { w(next, tau * next.cos()) };
                if next > psi {
                    let d_phi = next - psi;
                    let d_c = c[row] * d_phi + arc(w_here, w_next);
                    // The face's border may be a column's, to rounding.
                    let [row, column, line, texel] = [row, last_column.min(column), i - 1, texel].map(|v| v as u16);
                    pieces.push(Piece { row, column, line, texel, d_phi, d_c });
                }
                (psi, w_here) = (next, w_next);
                if next_row <= psi && row > 0 {
                    row -= 1;
                    next_row = crossing(row);
                }
                if next_column <= psi {
                    column += 1;
                    next_column = d_phi * (column + 1) as f64;
                }
                texel += usize::from(edges[texel + 1] <= psi);
            }
            pieces
        };
        Geometry::new(side, line, &c)
    }

    /// The lines x = g on a quarter of a polar face, z from 0 to 1.
    fn polar(&self) -> Geometry {
        let (side, quarter) = (self.side, self.source.width as usize / 4);
        let rows = self.rows_polar();
        let c: Vec<f64> = (0..=rows).map(|i| self.angle(i).cos()).collect();
        let tan_squared: Vec<f64> = (0..=rows).map(|i| self.tan(i).powi(2)).collect();
        let meridian_tan = |j: usize| {
            if j < quarter { (TAU * j as f64 / f64::from(self.source.width)).tan() } else { f64::INFINITY }
        };
        let meridians: Vec<f64> = (0..=quarter).map(meridian_tan).collect();
        let line = |i: usize| {
            let g = i as f64 / side as f64;
            let g2 = g * g;
            let w = |z: f64| z / (g * (1.0 + g2 + z * z).sqrt());
            let mut row = tan_squared.partition_point(|t| *t <= g2).clamp(1, rows) - 1;
            let crossing = |row: usize| if row + 1 < rows { (tan_squared[row + 1] - g2).sqrt() } else { f64::INFINITY };
            let (mut z, mut w_here, mut column, mut texel) = (0.0, 0.0, 0, 0);
            let (mut next_row, mut next_column) = (crossing(row), g * meridians[1]);
            let mut pieces = vec![];
            while texel < side {
                let edge = (texel + 1) as f64 / side as f64;
                let next = edge.min(next_column).min(next_row).max(z);
                let w_next = w(next);
                if next > z {
                    let d_phi = arc(0.0, g * (next - z) / (g2 + z * next));
                    let d_c = c[row] * d_phi - arc(w_here, w_next);
                    let [row, column, line, texel] = [row, column, i - 1, texel].map(|v| v as u16);
                    pieces.push(Piece { row, column, line, texel, d_phi, d_c });
                }
                (z, w_here) = (next, w_next);
                if next_row <= z {
                    row += 1;
                    next_row = crossing(row);
                }
                if next_column <= z {
                    column += 1;
                    next_column = g * meridians[column + 1];
                }
                texel += usize::from(edge <= z);
            }
            pieces
        };
        Geometry::new(side, line, &c)
    }

    /// Goes through a quarter of a side face whose centre is `turn` quarters from azimuth 0. Lines count from the equator and
    /// texels from the middle. Bit 0 of the number: azimuth falls; bit 1: below the equator. `false` where the work was
    /// cancelled.
    fn through_side(
        &self,
        quarter: &mut Quarter,
        geometry: &Geometry,
        turn: usize,
        number: usize,
        watch: &Watch,
    ) -> bool {
        let (width, equator) = (self.source.width as usize, self.source.height as usize / 2);
        let middle = self.first_column + turn * width / 4;
        let column = |j: usize| if number & 1 == 0 { middle + j } else { middle + width - 1 - j };
        let row = |i: usize| if number & 2 == 0 { equator - 1 - i } else { equator + i };
        quarter.start((0..self.eighth()).map(|j| column(j) % width), self.side, false);
        quarter.go_through(geometry, self.source, row, watch)
    }

    /// The same of a polar face. Lines lie along the axis where the quarter starts, those of its mirror image along the one
    /// where it ends.
    fn through_polar(
        &self,
        quarter: &mut Quarter,
        geometry: &Geometry,
        north: bool,
        number: usize,
        watch: &Watch,
    ) -> bool {
        let (width, height) = (self.source.width as usize, self.source.height as usize);
        let first = self.first_column + number * width / 4;
        let row = |i: usize| if north { i } else { height - 1 - i };
        quarter.start((0..width / 4).map(|j| (first + j) % width), self.side, true);
        quarter.go_through(geometry, self.source, row, watch)
    }
}

impl Geometry {
    /// `line` gives the pieces of a line, `c` has a value more than there are rows.
    fn new(side: usize, line: impl Fn(usize) -> Vec<Piece> + Send + Sync, c: &[f64]) -> Self {
        let lines: Vec<Vec<Piece>> = (1..=side).into_par_iter().map(line).collect();
        let mut rows: Vec<Row> = c.windows(2).map(|c| Row { pieces: 0, drop: c[0] - c[1] }).collect();
        // By counting: they are many and the rows few.
        lines.iter().flatten().for_each(|piece| rows[usize::from(piece.row)].pieces += 1);
        let (mut places, mut end) = (vec![], 0);
        for row in &rows {
            places.push(end);
            end += row.pieces;
        }
        let mut pieces = vec![Piece::default(); end];
        for piece in lines.iter().flatten() {
            let place = &mut places[usize::from(piece.row)];
            pieces[*place] = *piece;
            *place += 1;
        }
        Self { side, pieces, rows }
    }
}

impl Piece {
    /// Adds ∫ G dφ, from S before the row and the radiance.
    fn add(&self, sum: &Rgb, light: &[f32; 3], edge: &mut Rgb) {
        (0..3).for_each(|k| edge[k] += sum[k] * self.d_phi + f64::from(light[k]) * self.d_c);
    }
}

impl Quarter {
    /// Before its first row, with `side` texels along its sides.
    fn start(&mut self, columns: impl Iterator<Item = usize>, side: usize, has_mirror_image: bool) {
        let zero = |values: &mut Vec<Rgb>, count: usize| {
            values.clear();
            values.resize(count, [0.0; 3]);
        };
        self.columns.clear();
        self.columns.extend(columns);
        zero(&mut self.sums, self.columns.len());
        zero(&mut self.edges, side * side);
        zero(&mut self.mirrored, if has_mirror_image { side * side } else { 0 });
    }

    /// Adds up the edges' integrals over the rows that `row` finds in the source. `false` where the work was cancelled.
    fn go_through(
        &mut self,
        Geometry { side, pieces, rows }: &Geometry,
        source: &Equirect,
        row: impl Fn(usize) -> usize,
        watch: &Watch,
    ) -> bool {
        let Quarter { columns, lights, sums, edges, mirrored } = self;
        let last = columns.len() - 1;
        let mut rest = pieces.as_slice();
        for (i, Row { pieces, drop }) in rows.iter().enumerate() {
            if watch.cancelled() {
                return false;
            }
            let texels = source.row(row(i) as u32);
            lights.clear();
            lights.extend(columns.iter().map(|column| texels[*column]));
            for piece in rest.split_off(..*pieces).expect("counted") {
                let at = usize::from(piece.line) * side + usize::from(piece.texel);
                let column = usize::from(piece.column);
                piece.add(&sums[column], &lights[column], &mut edges[at]);
                if !mirrored.is_empty() {
                    piece.add(&sums[last - column], &lights[last - column], &mut mirrored[at]);
                }
            }
            for (sum, light) in sums.as_flattened_mut().iter_mut().zip(lights.as_flattened()) {
                *sum += f64::from(*light) * drop;
            }
        }
        true
    }

    /// Over texel (i, j): between lines i and i + 1, along them the j-th.
    fn integral(&self, side: usize, i: usize, j: usize) -> Rgb {
        // Line 0, the quarter's border, adds nothing: it is the equator, where S and c are 0, or a meridian, where φ stays.
        let between = |edges: &[Rgb], i: usize, j: usize| -> Rgb {
            let before = if i > 0 { edges[(i - 1) * side + j] } else { [0.0; 3] };
            std::array::from_fn(|k| edges[i * side + j][k] - before[k])
        };
        let integral = between(&self.edges, i, j);
        if self.mirrored.is_empty() {
            return integral;
        }
        let of_mirror_image = between(&self.mirrored, j, i);
        std::array::from_fn(|k| integral[k] + of_mirror_image[k])
    }
}
