// SPDX-License-Identifier: MIT OR Apache-2.0
//! The independent truth of a filtered environment: a sum over the texels of the source, in f64.
//!
//! Every texel is a constant over its solid angle. Here those of an equirectangular source are summed; a cube's are in
//! [`super::cube_truth`]. A texel is cut into parts by its distance from the lobe's axis, and the
//! kernel is integrated over each part by 2 × 2 Gauss points in (θ, φ). No tree, no moments, no smoothing at the horizon:
//! nothing is shared with what is checked but the source and the kernel.

use std::f64::consts::{PI, TAU};

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::cube_truth::CubeTruth;
use crate::bake::quality::Quality;
use crate::bake::specular::SpecularJob;
use crate::env::{Environment, Equirect, Frame, Picture, Survey};
use crate::error::Result;
use crate::progress::{OnProgress, watched};
use crate::term::zonal::{Peak, Zonal};
use crate::texture::{Meta, Texture};

/// Texels of a source from which on a look after a bake is at no more texels than the quality asks for: 2048 x 1024.
const LARGE: usize = 1 << 21;
/// Random texels of a mip that are enough after a bake: with these the sums stay a tenth of the time.
const ENOUGH: u32 = 15;

/// How many texels of every mip are compared with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Chosen at random, always the same ones.
    pub random: u32,
    /// The ones nearest to the brightest texel of the source, where errors are worst.
    pub bright: u32,
}

impl Extent {
    /// A look after every bake: at more texels of a smaller source, whose sums are shorter.
    pub fn after_baking<'a>(quality: &Quality, source: impl Into<Environment<'a>>) -> Extent {
        let shorter = (LARGE / source.into().picture.texels().len().max(1)).max(1) as u32;
        let random = (1 + quality.spot_texels).saturating_mul(shorter) - 1;
        Extent { random: random.min(ENOUGH), bright: 1 }
    }

    /// A look at a file.
    pub const SPOT: Extent = Extent { random: 3, bright: 1 };
    /// For tests and `verify`.
    pub const THOROUGH: Extent = Extent { random: 100, bright: 24 };
}

/// Errors of one mip relative to the truth, over the channels of the checked texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MipError {
    /// Which mip.
    pub mip: u32,
    /// Root of the mean square.
    pub rms: f64,
    /// Largest.
    pub max: f64,
    /// Of the sum over the checked texels: energy that was gained, negative where lost.
    pub bias: f64,
    /// Texels compared.
    pub texels: u32,
}

/// The errors of all mips together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Largest rms of any mip.
    pub rms: f64,
    /// Largest error; NaN where any is.
    pub worst: f64,
    /// Texels compared.
    pub texels: u32,
}

impl Summary {
    /// Of what [`check`] found.
    pub fn of(errors: &[MipError]) -> Summary {
        let max = |of: fn(&MipError) -> f64| {
            errors.iter().map(of).fold(0.0, |a: f64, b| if a.is_nan() || b <= a { a } else { b })
        };
        Summary { rms: max(|e| e.rms), worst: max(|e| e.max), texels: errors.iter().map(|e| e.texels).sum() }
    }

    /// States them in a file's meta, with the bounds of the quality.
    pub fn state(&self, quality: &Quality, meta: &mut Meta) {
        meta.set("error.relative.rms", format!("{:.1e}", self.rms));
        meta.set("error.relative.worst", format!("{:.1e}", self.worst));
        meta.set("error.bound", format!("{:.1e} rms, {:.1e} worst", quality.rms_bound, quality.worst_bound));
        meta.set("error.checked", format!("{} texels against a brute-force f64 sum over the input", self.texels));
    }
}

/// Compares filtered mips with the truth. `cube` holds RGB (or RGBA) texels; what is not filtered is not looked at.
pub fn check<'a>(
    job: &SpecularJob,
    source: impl Into<Environment<'a>>,
    cube: &Texture,
    extent: Extent,
    on: &mut OnProgress<'_>,
) -> Result<Vec<MipError>> {
    let Environment { picture, frame } = source.into();
    let Survey { mean, brightest, .. } = Survey::of(&picture);
    let brightest = frame.from_picture(picture.direction(brightest));
    let truth = AnyTruth::new(&picture);
    // A channel that is black in the source compares with this instead of 0.
    let floor = 1e-9 * mean.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    // All mips at once: each has but a few texels for all threads.
    let chosen: Vec<_> = job.filtered().map(|mip| (mip, chosen(job, mip, brightest, extent))).collect();
    let all: Vec<_> = chosen.iter().flat_map(|(mip, texels)| texels.iter().map(move |t| (*mip, *t))).collect();
    let exact = watched(on, "checking against the truth", all.len() * truth.rows(), |watch| {
        truth.texels(job, &frame, &all, &|| !watch.cancelled())
    })?;
    let mut exact = exact.as_slice();
    let mut found = vec![];
    for (mip, texels) in chosen {
        let of_mip = exact.split_off(..texels.len()).expect("one a texel");
        let (mut squares, mut max) = (0.0, 0.0f64);
        let (mut gained, mut whole) = (0.0, 0.0);
        for ([face, x, y], exact) in texels.iter().zip(of_mip) {
            for (k, exact) in exact.iter().map(|v| v.min(job.clamped_to)).enumerate() {
                let got = f64::from(cube.texel(mip as usize, *face, *x, *y)[k]);
                let error = (got - exact).abs() / exact.max(floor);
                squares += error * error;
                gained += got - exact;
                whole += exact;
                // A NaN must not get lost in max().
                max = if error > max || error.is_nan() { error } else { max };
            }
        }
        let rms = (squares / (3 * texels.len()) as f64).sqrt();
        found.push(MipError { mip, rms, max, bias: gained / whole.max(floor), texels: texels.len() as u32 });
    }
    Ok(found)
}

/// What texels (face, column, row) of a filtered mip should hold.
pub fn expected(job: &SpecularJob, source: &Environment<'_>, mip: u32, texels: &[[u32; 3]]) -> Vec<[f64; 3]> {
    let texels: Vec<_> = texels.iter().map(|texel| (mip, *texel)).collect();
    AnyTruth::new(&source.picture).texels(job, &source.frame, &texels, &|| true)
}

/// The truth of either kind of picture.
enum AnyTruth<'a> {
    Equirect(Truth<'a>),
    Cube(CubeTruth<'a>),
}

impl<'a> AnyTruth<'a> {
    fn new(picture: &'a Picture<'_>) -> Self {
        match picture {
            Picture::Equirect(picture) => AnyTruth::Equirect(Truth::new(picture)),
            Picture::Cube(picture) => AnyTruth::Cube(CubeTruth::new(picture)),
        }
    }

    /// Rows that [`GoOn`] is asked before, for one direction.
    fn rows(&self) -> usize {
        match self {
            AnyTruth::Equirect(truth) => truth.source.height as usize,
            AnyTruth::Cube(truth) => truth.rows(),
        }
    }

    /// Radiance at the axes of texels: mip, and face, column and row.
    fn texels(&self, job: &SpecularJob, frame: &Frame, texels: &[(u32, [u32; 3])], go_on: GoOn<'_>) -> Vec<[f64; 3]> {
        let texel = |(mip, [face, x, y]): &(u32, [u32; 3])| {
            let alpha = job.alpha(*mip);
            let norm = (job.kernel.norm)(alpha);
            let (axis, scale) = (frame.to_picture(job.axis(*mip, *face, *x, *y)), Scale::of(job.kernel, alpha));
            let kernel = |h: &mut [f64]| (job.kernel.values)(h, alpha);
            let found = match self {
                AnyTruth::Equirect(truth) => truth.integral_while(axis, scale, kernel, go_on),
                AnyTruth::Cube(truth) => truth.integral_while(axis, scale, kernel, go_on),
            };
            found.map(|v| v / norm)
        };
        // One after the other to whoever is free: they cost unlike amounts.
        texels.par_iter().with_max_len(1).map(texel).collect()
    }
}

/// Asked before every row of a source: when it says no, the result is not wanted any more.
pub(super) type GoOn<'a> = &'a (dyn Fn() -> bool + Sync);

/// Face, column and row of the texels to compare: all where there are few.
pub(super) fn chosen(job: &SpecularJob, mip: u32, brightest: [f64; 3], extent: Extent) -> Vec<[u32; 3]> {
    let (width, height) = job.inner_size(mip);
    let count = job.projection.faces() * width * height;
    let gutter = job.gutter;
    let texel = |i: u32| [i / (width * height), gutter + i % width, gutter + i / width % height];
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
    let (face, s, t) = job.projection.locate(brightest);
    let at = |x: f64, n: u32| (((x + 1.0) / 2.0 * f64::from(n)) as i64).clamp(0, i64::from(n) - 1);
    let (x0, y0) = (at(s, width), at(t, height));
    let mut near: Vec<(i64, i64)> = (-4..=4).flat_map(|y| (-4..=4).map(move |x| (x, y))).collect();
    near.sort_by_key(|(x, y)| x * x + y * y);
    let inside = |v: i64, n: u32| (0..i64::from(n)).contains(&v);
    let near = near.iter().map(|(x, y)| (x0 + x, y0 + y)).filter(|(x, y)| inside(*x, width) && inside(*y, height));
    texels.extend(near.take(extent.bright as usize).map(|(x, y)| [face, gutter + x as u32, gutter + y as u32]));
    texels
}

/// On what angle a kernel varies, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The angle, in radians.
    pub width_rad: f64,
    /// Where it is that narrow.
    pub peak: Peak,
}

impl Scale {
    /// The scale of a registered kernel.
    pub fn of(kernel: &Zonal, alpha: f64) -> Self {
        Self { width_rad: (kernel.scale)(alpha), peak: kernel.peak }
    }
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
/// But where sides are longer than this, there are so few texels that such errors do not cancel: a photograph of 512 x 256 with
/// lamps at the horizon was off by 4e-5, four times what the finest walk errs there. There every texel has 2 x 2 points.
const FINE_RAD: f64 = 0.004;
/// Within this many texel sides, texels are cut; parts are at most 1/NEAR of their distance.
const NEAR: f64 = 8.0;
/// A ring at the horizon is cut this many times its width above it, if it is not [`COARSE`] texel sides wide.
const RING: f64 = 14.0;
const COARSE: f64 = 3.0;

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
    /// `kernel` replaces every h by the kernel's value.
    pub fn integral(&self, n: [f64; 3], scale: Scale, kernel: impl Fn(&mut [f64])) -> [f64; 3] {
        self.integral_while(n, scale, kernel, &|| true)
    }

    fn integral_while(&self, n: [f64; 3], scale: Scale, kernel: impl Fn(&mut [f64]), go_on: GoOn<'_>) -> [f64; 3] {
        let (width, side) = (i64::from(self.source.width), self.d_theta.max(self.d_phi));
        // n·ω on each row is A + B cos(φ − φ_n): what is nearer than a distance lies between two columns.
        let along = |table: &[[f64; 2]]| table.iter().map(|[c, s]| n[0] * c + n[2] * s).collect::<Vec<f64>>();
        let (centres, gauss) = (along(&self.centres), [along(&self.columns[0]), along(&self.columns[1])]);
        let middle = (n[2].atan2(n[0]) + PI) / self.d_phi - 0.5;
        let within = |distance: f64| 1.0 - 0.5 * distance * distance;
        // From the outside in: what is not wholly below the horizon, what is wholly above it, near, very near.
        let below = 1.1 * side;
        let one_point = if side > FINE_RAD { below } else { within(FAR * side) };
        let (edge, far, nearest) = match scale.peak {
            Peak::Axis if scale.width_rad > 4.0 * side => (below, one_point, 2.0),
            Peak::Axis => (below, one_point, within(NEAR * side)),
            // Beside the ring, K is steep everywhere.
            Peak::Horizon if scale.width_rad > COARSE * side => (below, below, within(NEAR * side)),
            Peak::Horizon => {
                let edge = below.max((RING * scale.width_rad).min(0.7));
                (edge, edge, within(NEAR * side).max(edge))
            }
        };
        let bounds = [-below, edge, far, nearest];

        let arch = Arch::new();
        let mut total = [0.0; 3];
        let mut h = Vec::with_capacity(self.source.width as usize);
        let mut parts = Parts::default();
        for y in 0..self.source.height {
            if !go_on() {
                break;
            }
            let theta = (f64::from(y) + 0.5) * self.d_theta;
            let (sin, cos) = theta.sin_cos();
            let (a, b) = (n[1] * cos, sin * n[0].hypot(n[2]));
            // Half-open ranges of columns, each inside the one before; they may run over the picture's ends.
            let mut ranges = [[0i64; 2]; 4];
            let mut outer = [i64::MIN, i64::MAX];
            for (range, mu) in ranges.iter_mut().zip(bounds) {
                let reach = if a - b >= mu {
                    0.5 * width as f64
                } else if a + b > mu {
                    ((mu - a) / b).acos() / self.d_phi
                } else {
                    -1.0
                };
                let low = ((middle - reach).ceil() as i64).max(outer[0]);
                let high = ((middle + reach).floor() as i64 + 1).min(outer[1]).min(low + width);
                let empty = (middle.ceil() as i64).clamp(outer[0], outer[1]);
                *range = if low < high { [low, high] } else { [empty, empty] };
                outer = *range;
            }

            let points = [-GAUSS, GAUSS].map(|o| (theta + o * self.d_theta).sin_cos());
            let row = self.source.row(y);
            let mut sum = [0.0; 3];
            // The part of a range that lies in the picture, piece by piece.
            let pieces = |from: i64, to: i64, piece: &mut dyn FnMut(usize, usize)| {
                let mut from = from;
                while from < to {
                    let x = from.rem_euclid(width);
                    let count = (to - from).min(width - x);
                    piece(x as usize, (x + count) as usize);
                    from += count;
                }
            };
            let mut add = |at: &[f64], (sin, cos): (f64, f64), share: f64, texels: &[[f32; 3]]| {
                h.clear();
                let (shift, slope) = (0.5 - 0.5 * n[1] * cos, -0.5 * sin);
                // With the widest vectors that the processor has; the same bits on all.
                arch.dispatch(|| h.extend(at.iter().map(|along| shift + slope * along)));
                kernel(&mut h);
                let part = arch.dispatch(Weighted { weights: &h, texels });
                (0..3).for_each(|c| sum[c] += share * sin * part[c]);
            };
            let [all, lit, near, nearest] = ranges;
            for [from, to] in [[lit[0], near[0]], [near[1], lit[1]]] {
                pieces(from, to, &mut |x0, x1| add(&centres[x0..x1], (sin, cos), 1.0, &row[x0..x1]));
            }
            for [from, to] in [[near[0], nearest[0]], [nearest[1], near[1]]] {
                for (columns, point) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let at = &gauss[columns];
                    pieces(from, to, &mut |x0, x1| add(&at[x0..x1], points[point], 0.25, &row[x0..x1]));
                }
            }
            for [from, to] in [[all[0], lit[0]], nearest, [lit[1], all[1]]] {
                pieces(from, to, &mut |x0, x1| {
                    for x in x0..x1 {
                        let distance = (2.0 - 2.0 * (n[1] * cos + sin * centres[x])).max(0.0).sqrt();
                        let mean = self.by_parts(n, (y, x), distance, scale, &kernel, &mut parts);
                        (0..3).for_each(|c| sum[c] += mean * f64::from(row[x][c]));
                    }
                });
            }
            (0..3).for_each(|c| total[c] += sum[c] * self.d_theta * self.d_phi);
        }
        total
    }

    /// The mean of kernel · sin θ over a texel.
    fn by_parts(
        &self,
        n: [f64; 3],
        (y, x): (u32, usize),
        distance: f64,
        scale: Scale,
        kernel: &impl Fn(&mut [f64]),
        parts: &mut Parts,
    ) -> f64 {
        let side = self.d_theta.max(self.d_phi);
        let size = match scale.peak {
            Peak::Axis => ((distance - side) / NEAR).max(0.25 * scale.width_rad),
            Peak::Horizon => ((distance - side) / NEAR).max(0.01 * side).min(0.25 * scale.width_rad),
        };
        // A kernel that rises steeply from the horizon shows where it cuts a bright texel.
        let is_cut = (1.0 - 0.5 * distance * distance).abs() < 1.1 * side;
        let least = match scale.peak {
            Peak::Axis => 4,
            Peak::Horizon if is_cut => 10,
            Peak::Horizon => 1,
        };
        let count = |side: f64| ((side / size).ceil() as usize).clamp(least, 256);
        let sin_theta = ((f64::from(y) + 0.5) * self.d_theta).sin();
        let (rows, columns) = (count(self.d_theta), count(self.d_phi * (sin_theta + 0.5 * self.d_theta).min(1.0)));
        parts.prepare([columns, rows], [self.d_phi, self.d_theta], y);
        let Parts { across, down, along, h, lit, .. } = parts;
        // From the texel's middle, by the angle-sum formula.
        let [cos_x, sin_x] = self.centres[x];
        let (here, turned) = (n[0] * cos_x + n[2] * sin_x, n[2] * cos_x - n[0] * sin_x);
        along.clear();
        along.extend(across.iter().map(|(sin, cos)| here * cos + turned * sin));
        h.clear();
        for (sin, cos) in &*down {
            let (shift, slope) = (0.5 - 0.5 * n[1] * cos, -0.5 * sin);
            h.extend(along.iter().map(|a| shift + slope * a));
        }
        lit.clear();
        lit.extend(h.iter().map(|h| *h < 0.5));
        kernel(h);
        let of_rows = h.chunks_exact(along.len()).zip(lit.chunks_exact(along.len())).zip(down);
        let sum: f64 = of_rows
            .map(|((k, lit), (sin, _))| {
                *sin * k.iter().zip(lit).map(|(k, lit)| if *lit { *k } else { 0.0 }).sum::<f64>()
            })
            .sum();
        sum / (4 * rows * columns) as f64
    }
}

/// Σ weight · texel, as four sums that do not wait for each other.
struct Weighted<'a> {
    weights: &'a [f64],
    texels: &'a [[f32; 3]],
}

impl WithSimd for Weighted<'_> {
    type Output = [f64; 3];

    // Compilers leave a closure of this size outside of the function that asks for wide vectors.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        let mut sums = [0.0; 12];
        let (weights, last_weights) = self.weights.as_chunks::<4>();
        let (texels, last_texels) = self.texels.as_chunks::<4>();
        for (weights, texels) in weights.iter().zip(texels) {
            let values = texels.as_flattened();
            for i in 0..12 {
                sums[i] += weights[i / 3] * f64::from(values[i]);
            }
        }
        for (weight, texel) in last_weights.iter().zip(last_texels) {
            for c in 0..3 {
                sums[c] += weight * f64::from(texel[c]);
            }
        }
        std::array::from_fn(|c| sums[c] + sums[3 + c] + (sums[6 + c] + sums[9 + c]))
    }
}

/// What texels that are cut alike have in common, and memory that is used again.
#[derive(Default)]
struct Parts {
    /// Columns, rows and the row of the picture that the tables are for.
    key: Option<([usize; 2], u32)>,
    /// Sine and cosine of the Gauss points' φ, from the texel's middle.
    across: Vec<(f64, f64)>,
    /// Of their θ.
    down: Vec<(f64, f64)>,
    along: Vec<f64>,
    h: Vec<f64>,
    lit: Vec<bool>,
}

impl Parts {
    /// Fills the tables for texels of row `y`, cut into so many columns and rows; sides of a texel in φ and θ.
    fn prepare(&mut self, [columns, rows]: [usize; 2], [d_phi, d_theta]: [f64; 2], y: u32) {
        if self.key == Some(([columns, rows], y)) {
            return;
        }
        let offsets = |parts: usize| {
            (0..2 * parts).map(move |i| ((i / 2) as f64 + 0.5 + if i % 2 == 0 { -GAUSS } else { GAUSS }) / parts as f64)
        };
        if self.key.is_none_or(|([before, _], _)| before != columns) {
            self.across.clear();
            self.across.extend(offsets(columns).map(|offset| ((offset - 0.5) * d_phi).sin_cos()));
        }
        self.down.clear();
        self.down.extend(offsets(rows).map(|offset| ((f64::from(y) + offset) * d_theta).sin_cos()));
        self.key = Some(([columns, rows], y));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_source_is_the_same_function_as_its_repetition() {
        // A lamp on the horizon over faint light: few texels have all.
        let lamp = |u: f64, v: f64| (u - 0.3).abs() < 0.004 && (v - 0.5).abs() < 0.008;
        let coarse = Equirect::from_fn(256, |u, v| [if lamp(u, v) { 1e4 } else { 0.1 }; 3]);
        let fine = coarse.repeated(4);
        let (coarse, fine) = (Truth::new(&coarse), Truth::new(&fine));
        let ggx = crate::term::zonal::parse("ggx").expect("it is registered");
        let mut worst = 0.0f64;
        for (u, v) in [(0.4, 0.3), (0.1, 0.45), (0.5, 0.2), (0.2, 0.7)] {
            let (n, alpha) = (Equirect::direction(u, v), 0.25);
            let [a, b] =
                [&coarse, &fine].map(|truth| truth.integral(n, Scale::of(ggx, alpha), |h| (ggx.values)(h, alpha))[0]);
            worst = worst.max((a / b - 1.0).abs());
        }
        println!("worst {worst:.1e}");
        assert!(worst < 2e-5, "{worst:e}");
    }

    #[test]
    fn a_look_after_a_bake_is_at_more_texels_of_a_smaller_source() {
        let random = |height: u32, quality: &str| {
            let quality = crate::bake::quality::parse(quality).expect("a quality");
            Extent::after_baking(quality, &Equirect::from_fn(height, |_, _| [1.0; 3])).random
        };
        let of_draft = [1024, 512, 256, 8].map(|height| random(height, "draft"));
        assert_eq!(of_draft, [0, 3, 15, 15]);
        assert_eq!([1024, 512, 8].map(|height| random(height, "standard")), [4, 15, 15]);
    }

    #[test]
    fn one_error_that_is_no_number_spoils_the_summary() {
        let error = |max: f64| MipError { mip: 1, rms: 0.5 * max, max, bias: 0.0, texels: 2 };
        let summary = Summary::of(&[error(1.0), error(3.0), error(2.0)]);
        assert_eq!(summary, Summary { rms: 1.5, worst: 3.0, texels: 6 });
        for place in 0..3 {
            let mut errors = [error(1.0), error(3.0), error(2.0)];
            errors[place] = error(f64::NAN);
            let summary = Summary::of(&errors);
            assert!(summary.worst.is_nan() && summary.rms.is_nan(), "{place}: {summary:?}");
        }
    }
}
