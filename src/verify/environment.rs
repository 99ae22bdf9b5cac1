//! The independent truth of a filtered environment: a sum over the texels of the source, in f64.
//!
//! Every texel is a constant over its solid angle. It is cut into parts by its distance from the lobe's axis, and the
//! kernel is integrated over each part by 2 × 2 Gauss points in (θ, φ). No tree, no moments, no smoothing at the horizon:
//! nothing is shared with what is checked but the source and the kernel.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::bake::specular::SpecularJob;
use crate::env::{Equirect, orientation};
use crate::error::Result;
use crate::progress::{OnProgress, tick};
use crate::texture::Texture;

/// What no checked texel may be off by, relative to its value.
pub const WORST: f64 = 1e-2;

/// How many texels of every mip are compared with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Chosen at random, always the same ones.
    pub random: u32,
    /// The ones nearest to the brightest texel of the source, where errors are worst.
    pub bright: u32,
}

impl Extent {
    /// A look after every bake.
    pub const SPOT: Extent = Extent { random: 3, bright: 1 };
    /// For tests and `verify`.
    pub const THOROUGH: Extent = Extent { random: 100, bright: 24 };
}

/// Errors of one mip relative to the truth, over the channels of the checked texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MipError {
    /// Which mip, from 1.
    pub mip: u32,
    /// Root of the mean square.
    pub rms: f64,
    /// Largest.
    pub max: f64,
    /// Texels compared.
    pub texels: u32,
}

/// Compares filtered mips with the truth. `cube` holds RGB (or RGBA) texels; mip 0 is not looked at.
pub fn check(
    job: &SpecularJob,
    source: &Equirect,
    cube: &Texture,
    extent: Extent,
    on: &mut OnProgress<'_>,
) -> Result<Vec<MipError>> {
    let truth = Truth::new(source);
    let brightest = brightest(source);
    // A channel that is black in the source compares with this instead of 0.
    let floor = 1e-9 * source.mean().iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mut found = vec![];
    for mip in 1..job.mips {
        tick(on, "checking against the truth", f64::from(mip - 1) / f64::from(job.mips - 1))?;
        let alpha = job.alpha(mip);
        let texels = chosen(job.level_size(mip), mip, brightest, extent);
        let norm = (job.kernel.norm)(alpha);
        let axes: Vec<_> = texels.iter().map(|[face, x, y]| job.axis(mip, *face, *x, *y)).collect();
        let exact = truth.integrals(&axes, 2.0 * alpha, |h| (job.kernel.value)(h, alpha));
        let (mut squares, mut max) = (0.0, 0.0f64);
        for ([face, x, y], exact) in texels.iter().zip(&exact) {
            for (k, exact) in exact.iter().enumerate() {
                let got = f64::from(cube.texel(mip as usize, *face, *x, *y)[k]);
                let error = (got - exact / norm).abs() / (exact / norm).max(floor);
                squares += error * error;
                // A NaN must not get lost in max().
                max = if error > max || error.is_nan() { error } else { max };
            }
        }
        let rms = (squares / (3 * texels.len()) as f64).sqrt();
        found.push(MipError { mip, rms, max, texels: texels.len() as u32 });
    }
    tick(on, "checking against the truth", 1.0)?;
    Ok(found)
}

/// The direction of the brightest texel.
fn brightest(source: &Equirect) -> [f64; 3] {
    let sum = |t: &[f32; 3]| t[0] + t[1] + t[2];
    let by_sum = |a: &usize, b: &usize| sum(&source.texels[*a]).total_cmp(&sum(&source.texels[*b])).then(b.cmp(a));
    let at = (0..source.texels.len()).max_by(by_sum).expect("a picture has texels");
    let (x, y) = (at % source.width as usize, at / source.width as usize);
    let centre = |i: usize, n: u32| (i as f64 + 0.5) / f64::from(n);
    Equirect::direction(centre(x, source.width), centre(y, source.height))
}

/// Face, column and row of the texels to compare: all where there are few.
fn chosen(size: u32, mip: u32, brightest: [f64; 3], extent: Extent) -> Vec<[u32; 3]> {
    let count = 6 * size * size;
    let texel = |i: u32| [i / (size * size), i % size, i / size % size];
    if count <= extent.random + extent.bright {
        return (0..count).map(texel).collect();
    }
    // SplitMix64 (Steele et al. 2014): any seed is as good as another.
    let mut state = u64::from(mip);
    let mut random = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((u128::from(z ^ (z >> 31)) * u128::from(count)) >> 64) as u32
    };
    let mut texels: Vec<_> = (0..extent.random).map(|_| texel(random())).collect();
    let (face, s, t) = orientation::locate(brightest);
    let at = |x: f64| (((x + 1.0) / 2.0 * f64::from(size)) as i64).clamp(0, i64::from(size) - 1);
    let (x0, y0) = (at(s), at(t));
    let mut near: Vec<(i64, i64)> = (-4..=4).flat_map(|y| (-4..=4).map(move |x| (x, y))).collect();
    near.sort_by_key(|(x, y)| x * x + y * y);
    let inside = |v: i64| (0..i64::from(size)).contains(&v);
    let near = near.iter().map(|(x, y)| (x0 + x, y0 + y)).filter(|(x, y)| inside(*x) && inside(*y));
    texels.extend(near.take(extent.bright as usize).map(|(x, y)| [face, x as u32, y as u32]));
    texels
}

/// A source, with the tables that every direction needs.
pub struct Truth<'a> {
    source: &'a Equirect,
    d_theta: f64,
    d_phi: f64,
    /// Cosine and sine of φ at the two Gauss points of every column.
    columns: [Vec<[f64; 2]>; 2],
    /// The same at the columns' centres.
    centres: Vec<[f64; 2]>,
}

/// Half the distance between Gauss points, in units of the interval.
const GAUSS: f64 = 0.288_675_134_594_812_9;
/// Beyond this many texel sides, one point a texel errs by less than 1e-4 of the texel's own part.
const FAR: f64 = 90.0;
/// Within this many texel sides, texels are cut; parts are at most 1/NEAR of their distance.
const NEAR: f64 = 8.0;

impl<'a> Truth<'a> {
    /// Prepares a source.
    pub fn new(source: &'a Equirect) -> Self {
        let (d_theta, d_phi) = (PI / f64::from(source.height), TAU / f64::from(source.width));
        let at = |offset: f64| {
            let phi = move |j: u32| (f64::from(j) + 0.5 + offset) * d_phi - PI;
            (0..source.width).map(|j| [phi(j).cos(), phi(j).sin()]).collect::<Vec<_>>()
        };
        Self { source, d_theta, d_phi, columns: [at(-GAUSS), at(GAUSS)], centres: at(0.0) }
    }

    /// ∫ kernel(h) L dω around `n`, a unit vector, with h = (1 − n·ω)/2; directions with n·ω ≤ 0 count nothing.
    /// `width_rad` is the scale on which the kernel varies at its peak.
    pub fn integral(&self, n: [f64; 3], width_rad: f64, kernel: impl Fn(f64) -> f64 + Sync) -> [f64; 3] {
        let (width, side) = (self.source.width as usize, self.d_theta.max(self.d_phi));
        let of_mu = |mu: f64| if mu > 0.0 { kernel(0.5 * (1.0 - mu)) } else { 0.0 };
        let fine = NEAR * side;
        let fine2 = if width_rad > 4.0 * side { 0.0 } else { fine * fine };
        let far2 = (FAR * side).powi(2);
        // Cosine between the lobe's axis and a direction: n_y cos θ + sin θ (n_x cos φ + n_z sin φ).
        let along = |table: &[[f64; 2]]| table.iter().map(|[c, s]| n[0] * c + n[2] * s).collect::<Vec<f64>>();
        let (centres, gauss) = (along(&self.centres), [along(&self.columns[0]), along(&self.columns[1])]);
        let row_sum = |y: u32| {
            let row = self.source.row(y);
            let theta = (f64::from(y) + 0.5) * self.d_theta;
            let (sin, cos) = theta.sin_cos();
            let points = [-GAUSS, GAUSS].map(|o| (theta + o * self.d_theta).sin_cos());
            let mut sum = [0.0; 3];
            for x in 0..width {
                let mu = n[1] * cos + sin * centres[x];
                if mu < -1.5 * side {
                    continue;
                }
                let distance2 = 2.0 - 2.0 * mu;
                // The mean of kernel · sin θ over the texel.
                let mean = if distance2 < fine2 || mu.abs() < 1.5 * side {
                    self.by_parts(n, y, x, distance2.max(0.0).sqrt(), width_rad, &of_mu)
                } else if distance2 < far2 {
                    let at = |g: usize, (sin, cos): (f64, f64)| sin * of_mu(n[1] * cos + sin * gauss[g][x]);
                    0.25 * (at(0, points[0]) + at(1, points[0]) + at(0, points[1]) + at(1, points[1]))
                } else {
                    sin * of_mu(mu)
                };
                (0..3).for_each(|k| sum[k] += mean * f64::from(row[x][k]));
            }
            sum
        };
        let mut total = [0.0; 3];
        for y in 0..self.source.height {
            let sum = row_sum(y);
            (0..3).for_each(|k| total[k] += sum[k] * self.d_theta * self.d_phi);
        }
        total
    }

    fn by_parts(
        &self,
        n: [f64; 3],
        y: u32,
        x: usize,
        distance: f64,
        width_rad: f64,
        of_mu: &impl Fn(f64) -> f64,
    ) -> f64 {
        let side = self.d_theta.max(self.d_phi);
        let size = ((distance - side) / NEAR).max(0.25 * width_rad);
        let theta = (f64::from(y) + 0.5) * self.d_theta;
        let parts = |side: f64| ((side / size).ceil() as usize).clamp(4, 256);
        let (rows, columns) = (parts(self.d_theta), parts(self.d_phi * (theta.sin() + 0.5 * self.d_theta).min(1.0)));
        let offsets = |parts: usize| {
            (0..2 * parts).map(move |i| ((i / 2) as f64 + 0.5 + if i % 2 == 0 { -GAUSS } else { GAUSS }) / parts as f64)
        };
        let along: Vec<f64> = offsets(columns)
            .map(|o| {
                let (sin, cos) = ((x as f64 + o) * self.d_phi - PI).sin_cos();
                n[0] * cos + n[2] * sin
            })
            .collect();
        let mut sum = 0.0;
        for o in offsets(rows) {
            let (sin, cos) = ((f64::from(y) + o) * self.d_theta).sin_cos();
            sum += sin * along.iter().map(|a| of_mu(n[1] * cos + sin * a)).sum::<f64>();
        }
        sum / (4 * rows * columns) as f64
    }

    /// [`Truth::integral`] for many directions.
    pub fn integrals(
        &self,
        directions: &[[f64; 3]],
        width_rad: f64,
        kernel: impl Fn(f64) -> f64 + Sync,
    ) -> Vec<[f64; 3]> {
        directions.par_iter().map(|n| self.integral(*n, width_rad, &kernel)).collect()
    }
}
