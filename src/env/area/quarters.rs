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
struct Piece {
    /// Rows from the pole or from the equator.
    row: u16,
    /// Columns from the middle of a side face, or from the axis that a polar line crosses.
    column: u16,
    /// Which texel's edge, along the line.
    texel: u16,
    d_phi: f64,
    /// ∫ c dφ
    d_c: f64,
}

/// The pieces of the lines 1, 2, … of a quarter, and c at the picture's rows.
struct Geometry {
    lines: Vec<Vec<Piece>>,
    c: Vec<f64>,
}

/// A quarter's part of the picture.
#[derive(Default)]
struct Field {
    columns: usize,
    cells: Vec<Cell>,
}

/// What a thread works in, quarter after quarter: memory that was touched once is used again.
#[derive(Default)]
struct Scratch {
    field: Field,
    /// Of the texels of the quarter, and of those of the mirror image of a polar one.
    integrals: [Vec<Rgb>; 2],
}

/// A texel of the picture.
struct Cell {
    /// S + L c_row
    below: Rgb,
    light: [f32; 3],
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
        // A quarter's lines are its parts.
        watched(on, STAGE, 24 * self.side, |watch| {
            let (around, polar) = rayon::join(|| self.around(), || self.polar());
            let solid_angles_sr = self.solid_angles_sr();
            // Half of the faces, one of them polar, for each of two threads.
            let faces =
                texels.par_chunks_mut(n * n * 3).enumerate().with_min_len(6 / rayon::current_num_threads().min(6));
            faces.for_each_init(Scratch::default, |scratch, (face, out)| {
                for quarter in 0..4 {
                    let done = match face {
                        2 | 3 => self.of_polar_quarter(scratch, &polar, face == 2, quarter, watch),
                        _ => self.of_side_quarter(scratch, &around, [0, 2, 0, 0, 1, 3][face], quarter, watch),
                    };
                    if !done {
                        return;
                    }
                    for (index, (integral, solid_angle)) in
                        scratch.integrals[0].iter().zip(&solid_angles_sr).enumerate()
                    {
                        let (x, y) = self.place(face, quarter, index / self.side, index % self.side);
                        let texel = &mut out[3 * (y * n + x)..][..3];
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
        let rows = (self.source.height as usize).div_ceil(4);
        let last_column = self.eighth() - 1;
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
                    let (d_phi, d_c) = (next - psi, -arc(w_here, w_next));
                    // The face's border may be a column's, to rounding.
                    let column = last_column.min(column) as u16;
                    pieces.push(Piece { row: row as u16, column, texel: texel as u16, d_phi, d_c });
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
        let lines = (1..=side).into_par_iter().map(line).collect();
        Geometry { lines, c: (0..=rows).map(|i| -self.angle(i).sin()).collect() }
    }

    /// The lines x = g on a quarter of a polar face, z from 0 to 1.
    fn polar(&self) -> Geometry {
        let (side, quarter) = (self.side, self.source.width as usize / 4);
        // The corner of a face is at θ = acos(1/√3) = 0.304 π.
        let height = self.source.height as usize;
        let rows = ((height as f64 * 0.305).ceil() as usize + 1).min(height);
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
                    let d_c = arc(w_here, w_next);
                    pieces.push(Piece { row: row as u16, column: column as u16, texel: texel as u16, d_phi, d_c });
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
        let lines = (1..=side).into_par_iter().map(line).collect();
        Geometry { lines, c: (0..=rows).map(|i| self.angle(i).cos()).collect() }
    }

    /// Integrals over the texels of a quarter of a side face, whose centre is `turn` quarters from azimuth 0: first by i from
    /// the equator, then by j from the middle. Bit 0 of `quarter`: azimuth falls; bit 1: below the equator. `false` where the
    /// work was cancelled.
    fn of_side_quarter(
        &self,
        Scratch { field, integrals: [integrals, _] }: &mut Scratch,
        geometry: &Geometry,
        turn: usize,
        quarter: usize,
        watch: &Watch,
    ) -> bool {
        let (width, equator) = (self.source.width as usize, self.source.height as usize / 2);
        let middle = self.first_column + turn * width / 4;
        let column = |j: usize| if quarter & 1 == 0 { middle + j } else { middle + width - 1 - j };
        let row = |i: usize| if quarter & 2 == 0 { equator - 1 - i } else { equator + i };
        let columns: Vec<usize> = (0..self.eighth()).map(|j| column(j) % width).collect();
        field.load(self.source, &geometry.c, row, &columns);
        let n = self.side;
        zero(integrals, n * n);
        for (i, line) in geometry.lines.iter().enumerate() {
            if watch.cancelled() {
                return false;
            }
            field.along(line, false, |j, edge| add_edge(integrals, n, i, j, edge));
        }
        true
    }

    /// The same of a polar face: first by i along the axis where `quarter` starts, then by j along the one where it ends.
    fn of_polar_quarter(
        &self,
        Scratch { field, integrals: [integrals, of_mirrored] }: &mut Scratch,
        geometry: &Geometry,
        north: bool,
        quarter: usize,
        watch: &Watch,
    ) -> bool {
        let (width, height) = (self.source.width as usize, self.source.height as usize);
        let first = self.first_column + quarter * width / 4;
        let columns: Vec<usize> = (0..width / 4).map(|j| (first + j) % width).collect();
        let row = |i: usize| if north { i } else { height - 1 - i };
        field.load(self.source, &geometry.c, row, &columns);
        let n = self.side;
        zero(integrals, n * n);
        zero(of_mirrored, n * n);
        for (i, line) in geometry.lines.iter().enumerate() {
            if watch.cancelled() {
                return false;
            }
            for (mirrored, sums) in [(false, &mut *integrals), (true, &mut *of_mirrored)] {
                field.along(line, mirrored, |j, edge| add_edge(sums, n, i, j, edge));
            }
        }
        for (index, sum) in integrals.iter_mut().enumerate() {
            let mirrored = of_mirrored[index % n * n + index / n];
            (0..3).for_each(|k| sum[k] += mirrored[k]);
        }
        true
    }
}

impl Field {
    /// The rows are those between the values of `c`.
    fn load(&mut self, source: &Equirect, c: &[f64], row: impl Fn(usize) -> usize, columns: &[usize]) {
        self.columns = columns.len();
        self.cells.clear();
        self.cells.reserve((c.len() - 1) * columns.len());
        let mut sums = vec![[0f64; 3]; columns.len()];
        for (i, c) in c.windows(2).enumerate() {
            let texels = source.row(row(i) as u32);
            self.cells.extend(sums.iter_mut().zip(columns).map(|(sum, column)| {
                let light = texels[*column];
                let below = std::array::from_fn(|k| sum[k] + f64::from(light[k]) * c[0]);
                (0..3).for_each(|k| sum[k] += f64::from(light[k]) * (c[0] - c[1]));
                Cell { below, light }
            }));
        }
    }

    /// Calls `put` with the number of every texel along a line and ∫ G dφ over its edge; `mirrored` counts columns from the
    /// other end.
    fn along(&self, line: &[Piece], mirrored: bool, mut put: impl FnMut(usize, Rgb)) {
        for pieces in line.chunk_by(|a, b| a.texel == b.texel) {
            let mut edge = [0f64; 3];
            for piece in pieces {
                let column = usize::from(piece.column);
                let column = if mirrored { self.columns - 1 - column } else { column };
                let Cell { below, light } = &self.cells[usize::from(piece.row) * self.columns + column];
                (0..3).for_each(|k| edge[k] += below[k] * piece.d_phi - f64::from(light[k]) * piece.d_c);
            }
            put(usize::from(pieces[0].texel), edge);
        }
    }
}

/// As many zeros.
fn zero(integrals: &mut Vec<Rgb>, count: usize) {
    integrals.clear();
    integrals.resize(count, [0.0; 3]);
}

/// Adds the integral along an edge on line `i` to the texel before the line, and takes it from the one behind.
fn add_edge(integrals: &mut [Rgb], n: usize, i: usize, j: usize, edge: Rgb) {
    (0..3).for_each(|k| integrals[i * n + j][k] += edge[k]);
    if i + 1 < n {
        (0..3).for_each(|k| integrals[(i + 1) * n + j][k] -= edge[k]);
    }
}
