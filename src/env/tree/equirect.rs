// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rectangles of an equirectangular picture. All integrals over them are closed: rows and columns separate.

use std::f64::consts::{PI, TAU};

use super::{FINE, Light, Rect, Sums};
use crate::env::Equirect;

/// Integrals over the θ extent of a row: ∫ f(θ) sin θ dθ for f = 1, sin, cos, sin², sin·cos, cos².
#[derive(Clone, Copy)]
struct RowTerms {
    one: f64,
    s: f64,
    c: f64,
    ss: f64,
    sc: f64,
    cc: f64,
}

/// Integrals over the φ extent of a column.
#[derive(Clone, Copy)]
struct ColumnTerms {
    c: f64,
    s: f64,
    cc: f64,
    sc: f64,
}

pub(super) struct Chart<'a> {
    source: &'a Equirect,
    rows: Vec<RowTerms>,
    columns: Vec<ColumnTerms>,
    /// Sine and cosine of θ at the upper edge of every unit of rows, and at the last one's lower edge.
    edges: Vec<(f64, f64)>,
    d_theta: f64,
    d_phi: f64,
}

/// For a row from θ − a to θ + a. Products of the middle's and the half width's sines and cosines: nothing cancels in
/// narrow rows.
fn row_terms(theta: f64, a: f64) -> RowTerms {
    let (sin, cos) = theta.sin_cos();
    let (sin_a, sin_2a) = (a.sin(), (2.0 * a).sin());
    let one = 2.0 * sin * sin_a;
    // ∫ cos³ and ∫ sin³ come from sin 3θ and cos 3θ.
    let third = 2.0 * (3.0 * theta).sin() * (3.0 * a).sin() / 3.0;
    let third_c = 2.0 * (3.0 * theta).cos() * (3.0 * a).sin() / 3.0;
    let ss = (3.0 * one - third) / 4.0;
    let sc = (2.0 * cos * sin_a - third_c) / 4.0;
    let s = a - (2.0 * theta).cos() * sin_2a / 2.0;
    let c = sin * cos * sin_2a;
    RowTerms { one, s, c, ss, sc, cc: one - ss }
}

/// For a column from φ − b to φ + b.
fn column_terms(phi: f64, b: f64) -> ColumnTerms {
    let (sin, cos) = phi.sin_cos();
    let sin_2b = (2.0 * b).sin();
    ColumnTerms {
        c: 2.0 * cos * b.sin(),
        s: 2.0 * sin * b.sin(),
        cc: b + (2.0 * phi).cos() * sin_2b / 2.0,
        sc: sin * cos * sin_2b,
    }
}

impl<'a> Chart<'a> {
    pub(super) fn new(source: &'a Equirect) -> Self {
        let (width, height) = (source.width, source.height);
        let (d_theta, d_phi) = (PI / f64::from(height), TAU / f64::from(width));
        Self {
            source,
            rows: (0..height).map(|i| row_terms(d_theta * (f64::from(i) + 0.5), 0.5 * d_theta)).collect(),
            columns: (0..width).map(|j| column_terms(d_phi * (f64::from(j) + 0.5) - PI, 0.5 * d_phi)).collect(),
            edges: (0..=FINE * height).map(|i| (f64::from(i) * d_theta / f64::from(FINE)).sin_cos()).collect(),
            d_theta,
            d_phi,
        }
    }

    /// Extent in φ.
    fn turn(&self, r: Rect) -> f64 {
        f64::from(r.c1 - r.c0) * self.d_phi / f64::from(FINE)
    }

    /// Adds texels of one row whose columns are `turn` wide.
    fn add_row(
        &self,
        sums: &mut Sums,
        light: &Light,
        row: &RowTerms,
        columns: &[ColumnTerms],
        texels: &[[f32; 3]],
        turn: f64,
    ) {
        let (mut one, mut c, mut s) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let (mut w_one, mut w_cc, mut w_sc) = (0.0, 0.0, 0.0);
        for (texel, column) in texels.iter().zip(columns) {
            let mut w = 0.0;
            for k in 0..3 {
                let radiance = f64::from(texel[k] - light.base[k]);
                one[k] += radiance;
                c[k] += radiance * column.c;
                s[k] += radiance * column.s;
                w += radiance * light.inverse_mean[k];
            }
            w_one += w;
            w_cc += w * column.cc;
            w_sc += w * column.sc;
        }
        for k in 0..3 {
            let plain = one[k] * turn;
            sums.e[k] += row.one * plain;
            sums.first[k][0] += row.s * c[k];
            sums.first[k][1] += row.c * plain;
            sums.first[k][2] += row.s * s[k];
        }
        let w_c: f64 = (0..3).map(|k| c[k] * light.inverse_mean[k]).sum();
        let w_s: f64 = (0..3).map(|k| s[k] * light.inverse_mean[k]).sum();
        let w_plain = w_one * turn;
        let second =
            [row.ss * w_cc, row.cc * w_plain, row.ss * (w_plain - w_cc), row.sc * w_c, row.ss * w_sc, row.sc * w_s];
        (0..6).for_each(|i| sums.second[i] += second[i]);
    }
}

impl super::Chart for Chart<'_> {
    fn size(&self) -> (u32, u32) {
        (FINE * self.source.height, FINE * self.source.width)
    }

    fn sides(&self, r: Rect) -> (f64, f64) {
        let equator = FINE * self.source.height / 2;
        let widest = if r.r0 <= equator && r.r1 >= equator {
            1.0
        } else {
            self.edges[r.r0 as usize].0.max(self.edges[r.r1 as usize].0)
        };
        (f64::from(r.r1 - r.r0) * self.d_theta / f64::from(FINE), self.turn(r) * widest)
    }

    fn half_diagonal(&self, r: Rect) -> f64 {
        let (height, width) = self.sides(r);
        0.5 * (height * height + width * width).sqrt()
    }

    fn solid_angle_sr(&self, r: Rect) -> f64 {
        (self.edges[r.r0 as usize].1 - self.edges[r.r1 as usize].1) * self.turn(r)
    }

    fn seam(&self, _: Rect) -> Option<u32> {
        None
    }

    fn sums(&self, r: Rect, light: &Light) -> Sums {
        let (y0, x0) = (r.r0 / FINE, r.c0 / FINE);
        let mut sums = Sums::default();
        if super::texel_count(r) == 0 {
            let half = 0.5 / f64::from(FINE);
            let (theta, phi) =
                (f64::from(r.r0 + r.r1) * half * self.d_theta, f64::from(r.c0 + r.c1) * half * self.d_phi);
            let row = row_terms(theta, f64::from(r.r1 - r.r0) * half * self.d_theta);
            let column = column_terms(phi - PI, 0.5 * self.turn(r));
            self.add_row(&mut sums, light, &row, &[column], &[self.source.row(y0)[x0 as usize]], self.turn(r));
            return sums;
        }
        let (y1, x1) = (r.r1 / FINE, r.c1 / FINE);
        for y in y0..y1 {
            let texels = &self.source.row(y)[x0 as usize..x1 as usize];
            let columns = &self.columns[x0 as usize..x1 as usize];
            self.add_row(&mut sums, light, &self.rows[y as usize], columns, texels, self.d_phi);
        }
        sums
    }

    fn place(&self, r: Rect) -> [[u16; 2]; 2] {
        // The root's columns may be 65,536; only leaves' are read.
        let side = |from: u32, to: u32| [from as u16, (to - from).min(u32::from(u16::MAX)) as u16];
        [side(r.r0, r.r1), side(r.c0, r.c1)]
    }
}
