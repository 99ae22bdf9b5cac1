// SPDX-License-Identifier: MIT OR Apache-2.0
//! Checks a filtered environment: what any correct one obeys, and each mip against a brute-force convolution of the
//! source, or of the file's own mip 0 where the source is not at hand.
//!
//! **Laws.** Radiance is finite and not negative; no mip is brighter than the source or mip 0; a wider lobe leaves less
//! variance; faces have no rings at their seams ([`super::seams`]).
//!
//! **Mip 0 as a source.** A cube's mip 0 is taken as piecewise constant over its texels. The source was sharper than
//! that, so the expected difference grows as lobes get narrower: a box of angular size s widens a lobe of width alpha by
//! a relative s²/(12 alpha²), which the bound of each mip allows for, beside the rounding of the encoding.

use rayon::prelude::*;
use serde::Serialize;

use super::averages;
use super::environment::{self, Scale};
use super::law::Law;
use super::seams::{self, Seams};
use super::table::Extent;
use crate::bake::specular::SpecularJob;
use crate::env::Environment;
use crate::env::orientation::{centre, normalized};
use crate::env::projection::Projection;
use crate::error::Result;
use crate::format::Steps;
use crate::progress::{OnProgress, tick};
use crate::quadrature::gauss_legendre::gauss_legendre;
use crate::term::cube;
use crate::term::zonal::{Peak, Zonal};
use crate::texture::Texture;

/// Texels a mip of a spot check; a full check looks at this many times more.
const SPOT_TEXELS: usize = 12;
const FULL_FACTOR: usize = 16;
/// A cell of the brute-force sum spans at most this share of the lobe, or of the distance to its centre.
const CELL_SHARE: f64 = 0.35;

/// A mip that mip 0's texels blur by more than this says nothing without the source.
const MOST_BLUR: f64 = 0.05;

/// One mip beside its convolution.
#[derive(Clone, Debug, Serialize)]
pub struct MipReport {
    /// Which mip.
    pub mip: usize,
    /// Width of the lobe.
    pub alpha: f64,
    /// Texels compared.
    pub texels: usize,
    /// Root mean square of the relative differences.
    pub rms: f64,
    /// Largest relative difference.
    pub worst: f64,
    /// Relative difference of the sum over the texels; only against the source.
    pub bias: Option<f64>,
    /// What `rms` may be.
    pub bound: f64,
}

/// What a level is like, whatever its source.
#[derive(Clone, Debug, Serialize)]
pub struct LevelReport {
    /// Which mip.
    pub mip: usize,
    /// Mean radiance over the sphere, per channel.
    pub mean: [f64; 3],
    /// Variance over the sphere, relative to the square of the mean, summed over the channels.
    pub variance: f64,
    /// Its greatest value.
    pub peak: f64,
    /// Rings at its seams, where faces are large enough.
    pub seams: Option<Seams>,
}

/// What a check found.
#[derive(Clone, Debug, Serialize)]
pub struct CubeReport {
    /// Mip by mip, those that were compared.
    pub mips: Vec<MipReport>,
    /// Mips whose lobes are too narrow beside mip 0's texels to be checked without the source.
    pub skipped: Vec<usize>,
    /// Mip by mip.
    pub levels: Vec<LevelReport>,
    /// Mean radiance of mip 0, per channel.
    pub mean: [f64; 3],
    /// Mip 0, where it is not filtered, beside the means of the source over its texels; only against the source.
    pub mip_0: Option<MipReport>,
    /// Greatest root mean square of any mip at the texels of a bake's own check; only against the source.
    pub certified_rms: Option<f64>,
    /// Largest relative difference of the same.
    pub certified_worst: Option<f64>,
    /// What must hold, and whether it does.
    pub laws: Vec<Law>,
    /// What is wrong, in sentences; empty when everything holds.
    pub failures: Vec<String>,
}

impl CubeReport {
    /// Largest relative difference of any mip; `None` where none was compared.
    pub fn worst(&self) -> Option<f64> {
        self.mips.iter().map(|m| m.worst).reduce(worse)
    }
}

/// The greater one; NaN is the greatest.
fn worse(a: f64, b: f64) -> f64 {
    if a.total_cmp(&b).is_ge() { a } else { b }
}

/// Texel of mip 0: direction of its centre, radiance, and its place on a face.
struct Cell {
    face: u32,
    s: f64,
    t: f64,
    direction: [f64; 3],
    radiance: [f64; 3],
}

/// Checks an environment that `job` describes, by itself.
pub fn check(
    job: &SpecularJob,
    texture: &Texture,
    steps: impl Into<Steps>,
    extent: Extent,
    on: &mut OnProgress<'_>,
) -> Result<CubeReport> {
    let steps = steps.into();
    let mut failures = vec![];
    let (levels, mut obeyed) = laws(job, texture, &steps, &mut failures);
    let mean = mean(job, texture, 0);
    if !failures.is_empty() || job.projection != Projection::Cube || job.filtered().start == 0 {
        return Ok(CubeReport {
            mips: vec![],
            skipped: job.filtered().map(|m| m as usize).collect(),
            levels,
            mean,
            mip_0: None,
            certified_rms: None,
            certified_worst: None,
            laws: obeyed,
            failures,
        });
    }
    let before = failures.len();

    let cells = cells(texture);
    let texel_rad = 2.0 / f64::from(texture.width);
    let (mut mips, mut skipped) = (vec![], vec![]);
    for m in job.filtered() {
        tick(on, "verify: mips", f64::from(m) / f64::from(job.mips))?;
        let (mip, alpha) = (m as usize, job.alpha(m));
        let blur = (2.0 * texel_rad / (job.kernel.scale)(alpha)).powi(2) / 12.0;
        if blur > MOST_BLUR {
            skipped.push(mip);
            continue;
        }
        let wanted = if extent == Extent::Full { SPOT_TEXELS * FULL_FACTOR } else { SPOT_TEXELS };
        let chosen = spread(texture, mip, wanted);
        let errors: Vec<f64> = chosen
            .par_iter()
            .flat_map_iter(|(face, x, y)| {
                let n = job.axis(m, *face, *x, *y);
                let expected = convolve(&cells, texel_rad, n, job.kernel, alpha);
                let found = texture.texel(mip, *face, *x, *y);
                (0..3).map(|c| relative(f64::from(found[c]), expected[c])).collect::<Vec<_>>()
            })
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        let step = 2.0 * steps.relative_rms();
        let report = MipReport {
            mip,
            alpha,
            texels: chosen.len(),
            rms,
            worst: errors.iter().copied().fold(0.0, f64::max),
            bias: None,
            bound: 1e-3 + job.quality.rms_bound + step + blur,
        };
        if errors.is_empty() || rms.is_nan() || rms > report.bound {
            failures.push(format!(
                "mip {mip} (alpha {alpha:.5}) differs from the convolution of mip 0 by {rms:.1e} rms, more than {:.1e}",
                report.bound
            ));
        }
        mips.push(report);
    }
    obeyed.push(Law::new("every compared mip is the convolution of mip 0, within its bound", &failures[before..]));
    let (certified_rms, certified_worst) = (None, None);
    let mip_0 = None;
    Ok(CubeReport { mips, skipped, levels, mean, mip_0, certified_rms, certified_worst, laws: obeyed, failures })
}

/// What texels (face, column, row) of a filtered mip of a cube should hold, if mip 0 were the source.
pub fn expected(job: &SpecularJob, texture: &Texture, mip: u32, texels: &[[u32; 3]]) -> Vec<[f64; 3]> {
    let (cells, texel_rad) = (cells(texture), 2.0 / f64::from(texture.width));
    let at =
        |[face, x, y]: &[u32; 3]| convolve(&cells, texel_rad, job.axis(mip, *face, *x, *y), job.kernel, job.alpha(mip));
    texels.par_iter().map(at).collect()
}

/// The mean radiance of mip 0 may differ from the source's by this share.
const MEAN_BOUND: f64 = 1e-4;

/// Root mean square of the relative errors of mip 0's texels; ten times that for each.
const TEXEL_BOUND: f64 = 5e-4;

/// Checks an environment that `job` describes against the one that it was baked from.
pub fn check_with_source<'a>(
    job: &SpecularJob,
    texture: &Texture,
    source: impl Into<Environment<'a>>,
    steps: impl Into<Steps>,
    extent: Extent,
    on: &mut OnProgress<'_>,
) -> Result<CubeReport> {
    let extent = match extent {
        Extent::Spot | Extent::Twin => environment::Extent { random: 24, bright: 8 },
        Extent::Full => environment::Extent::THOROUGH,
    };
    let steps = steps.into();
    let step = steps.relative();
    let noise = steps.relative_rms();
    let (rms_bound, worst_bound) = (job.quality.rms_bound + noise, job.quality.worst_bound + step);
    let mut failures = vec![];
    let (levels, mut obeyed) = laws(job, texture, &steps, &mut failures);
    let mean = mean(job, texture, 0);
    let source = source.into();
    let expected = source.picture.mean();
    let before = failures.len();
    // Clamped texels lack radiance; that they do is stated.
    let keeps_mean = job.filtered().start > 0 && job.clamped_to == f64::INFINITY;
    for c in (0..3).filter(|_| keeps_mean) {
        let off = relative(mean[c], expected[c]);
        // All texels of a constant channel may be rounded alike.
        if off.is_nan() || off > MEAN_BOUND + noise {
            let name = &texture.channels[c];
            failures.push(format!("the mean of mip 0, channel {name}, is {} instead of {}", mean[c], expected[c]));
        }
    }
    if keeps_mean {
        obeyed.push(Law::new("mip 0 has the mean radiance of the source", &failures[before..]));
    }
    let report = |e: environment::MipError, bound: f64| MipReport {
        mip: e.mip as usize,
        alpha: job.alpha(e.mip),
        texels: e.texels as usize,
        rms: e.rms,
        worst: e.max,
        bias: Some(e.bias),
        bound,
    };
    let before = failures.len();
    let mut mip_0 = None;
    if job.filtered().start > 0 {
        let found = averages::check(job, &source, texture, extent, on)?;
        let (rms_bound, worst_bound) = (TEXEL_BOUND + step, 10.0 * TEXEL_BOUND + step);
        if !(found.rms <= rms_bound && found.max <= worst_bound) {
            failures.push(format!(
                "mip 0 is off by {:.1e} rms and {:.1e} at most, more than {rms_bound:.1e} and {worst_bound:.1e}",
                found.rms, found.max
            ));
        }
        mip_0 = Some(report(found, rms_bound));
        obeyed.push(Law::new("mip 0 holds the means of the source over its texels", &failures[before..]));
    }
    let before = failures.len();
    let brightest = f64::from(source.picture.texels().iter().flatten().copied().fold(0.0, f32::max));
    for level in levels.iter().filter(|l| l.peak > brightest * (1.0 + 1e-6 + step)) {
        failures.push(format!("mip {} reaches {}, more than the source's {brightest}", level.mip, level.peak));
    }
    obeyed.push(Law::new("no texel is brighter than the source's brightest", &failures[before..]));
    let before = failures.len();
    let found = environment::check(job, &source, texture, extent, on)?;
    for e in &found {
        let holds = e.rms <= rms_bound && e.max <= worst_bound;
        if !holds {
            failures.push(format!(
                "mip {} is off by {:.1e} rms and {:.1e} at most, more than {rms_bound:.1e} and {worst_bound:.1e}",
                e.mip, e.rms, e.max
            ));
        }
    }
    obeyed.push(Law::new("every mip is the convolution of the source, within its bound", &failures[before..]));
    let mips = found.into_iter().map(|e| report(e, rms_bound)).collect();
    let after_baking = environment::Extent::after_baking(job.quality, &source);
    let own = environment::check(job, &source, texture, after_baking, on)?;
    let certified_rms = own.iter().map(|e| e.rms).reduce(worse);
    let certified_worst = own.iter().map(|e| e.max).reduce(worse);
    Ok(CubeReport {
        mips,
        skipped: vec![],
        levels,
        mean,
        mip_0,
        certified_rms,
        certified_worst,
        laws: obeyed,
        failures,
    })
}

/// What every filtered environment obeys.
fn laws(
    job: &SpecularJob,
    texture: &Texture,
    steps: &Steps,
    failures: &mut Vec<String>,
) -> (Vec<LevelReport>, Vec<Law>) {
    for (mip, level) in texture.levels.iter().enumerate() {
        if let Some(bad) = level.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            failures.push(format!("mip {mip} holds {} at value {bad}", level[bad]));
        }
    }
    let mut obeyed = vec![Law::new("radiance is finite and not negative", failures)];
    if !failures.is_empty() {
        return (vec![], obeyed);
    }
    let rounding = steps.relative_rms();
    let levels: Vec<LevelReport> = (0..texture.levels.len())
        .map(|mip| {
            let mean = mean(job, texture, mip);
            LevelReport {
                mip,
                mean,
                variance: variance(job, texture, mip, mean),
                peak: f64::from(texture.levels[mip].iter().copied().fold(0.0, f32::max)),
                // In a gutter the edges are repeated; there is nothing across them.
                seams: seams::measure(texture, job.projection, mip)
                    .filter(|_| job.filtered().contains(&(mip as u32)) && job.gutter == 0),
            }
        })
        .collect();
    let texel_rad = job.projection.texel_rad(texture.height);
    let (mut brighter, mut livelier, mut ringing) = (vec![], vec![], vec![]);
    for pair in levels.windows(2) {
        let [above, level] = pair else { continue };
        // The point sample of a sharp lobe may exceed a box average; beyond mip 0's texels it may not.
        let blur = (2.0 * texel_rad / (job.kernel.scale)(job.alpha(level.mip as u32))).powi(2) / 12.0;
        if level.peak > levels[0].peak * (1.0 + blur + 1e-3) {
            brighter.push(format!("mip {} reaches {}, more than mip 0's {}", level.mip, level.peak, levels[0].peak));
        }
        // Lobes with a peak at their axis blur more as they get wider. A few texels make a poor mean of squares, and fewer
        // than 4 x 4 none.
        let size = job.level_size(level.mip as u32).1;
        let tolerance = if size >= 16 { 0.03 } else { 0.5 } + blur.min(1.0);
        let before = if job.kernel.peak == Peak::Axis { above.variance } else { levels[0].variance };
        if size >= 4 && level.variance > before * (1.0 + tolerance) + 1e-5 {
            let name = if job.kernel.peak == Peak::Axis { above.mip } else { 0 };
            let (after, mip) = (level.variance, level.mip);
            livelier.push(format!("mip {mip} has more variance than mip {name}: {after:.3e} after {before:.3e}"));
        }
    }
    for level in &levels {
        if let Some(seams) = level.seams.filter(|s| !s.are_clean(rounding)) {
            ringing.push(format!(
                "mip {} has rings at its seams: steps across are off by {:.1e}, at the edge by {:.1e}, inside by {:.1e}",
                level.mip, seams.across, seams.edge, seams.within
            ));
        }
    }
    for (statement, found) in [
        ("no mip is brighter than mip 0", brighter),
        ("a wider lobe leaves less variance", livelier),
        ("faces meet without rings at their seams", ringing),
    ] {
        obeyed.push(Law::new(statement, &found));
        failures.extend(found);
    }
    (levels, obeyed)
}

/// Mean radiance over the sphere of a level.
pub fn mean(job: &SpecularJob, texture: &Texture, mip: usize) -> [f64; 3] {
    over_sphere(job, texture, mip, |texel| [0, 1, 2].map(|c| f64::from(texel[c])))
}

fn variance(job: &SpecularJob, texture: &Texture, mip: usize, mean: [f64; 3]) -> f64 {
    let squares = over_sphere(job, texture, mip, |texel| {
        [0, 1, 2].map(|c| ((f64::from(texel[c]) - mean[c]) / mean[c].max(f64::MIN_POSITIVE)).powi(2))
    });
    squares.iter().sum()
}

/// Means over the sphere, by solid angle.
fn over_sphere(job: &SpecularJob, texture: &Texture, mip: usize, of: impl Fn(&[f32]) -> [f64; 3]) -> [f64; 3] {
    let (width, height) = job.inner_size(mip as u32);
    let (projection, gutter) = (job.projection, job.gutter);
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for y in 0..height {
        for x in 0..width {
            let solid_angle_sr = projection.solid_angle_sr(x, y, width, height);
            for face in 0..projection.faces() {
                let value = of(texture.texel(mip, face, gutter + x, gutter + y));
                sum.iter_mut().zip(value).for_each(|(s, v)| *s += solid_angle_sr * v);
                total += solid_angle_sr;
            }
        }
    }
    sum.map(|s| s / total)
}

fn relative(found: f64, expected: f64) -> f64 {
    (found - expected).abs() / expected.abs().max(1e-6)
}

fn cells(texture: &Texture) -> Vec<Cell> {
    let size = texture.width;
    let mut cells = Vec::with_capacity(6 * (size * size) as usize);
    for face in 0..6 {
        for y in 0..size {
            for x in 0..size {
                let (s, t) = centre(x, y, size);
                let texel = texture.texel(0, face, x, y);
                let radiance = [texel[0], texel[1], texel[2]].map(f64::from);
                cells.push(Cell { face, s, t, direction: normalized(cube::direction(face, s, t)), radiance });
            }
        }
    }
    cells
}

/// ∫ K L dω / ∫ K dω around `n`, L constant over the cells: each cell is cut until it is small beside the lobe or beside
/// its distance from the lobe's centre.
fn convolve(cells: &[Cell], size: f64, n: [f64; 3], kernel: &Zonal, alpha: f64) -> [f64; 3] {
    let rule = gauss_legendre(2);
    let scale = Scale::of(kernel, alpha);
    let (mut sum, mut norm) = ([0.0; 3], 0.0);
    for cell in cells {
        let cos = cell.direction.iter().zip(n).map(|(a, b)| a * b).sum::<f64>();
        if cos < -size {
            continue;
        }
        let away = (2.0 - 2.0 * cos).max(0.0).sqrt() - size;
        let length = if scale.peak == Peak::Axis { away.max(0.5 * scale.width_rad) } else { scale.width_rad };
        let parts = (size / (CELL_SHARE * length)).ceil().clamp(1.0, 64.0) as u32;
        let step = size / f64::from(parts);
        let mut weight = 0.0;
        for i in 0..parts {
            for j in 0..parts {
                let (s0, t0) = (
                    cell.s + (f64::from(i) + 0.5) * step - 0.5 * size,
                    cell.t + (f64::from(j) + 0.5) * step - 0.5 * size,
                );
                for a in &rule {
                    for b in &rule {
                        let (s, t) = (s0 + 0.5 * step * a.x, t0 + 0.5 * step * b.x);
                        let length2 = 1.0 + s * s + t * t;
                        let l = cube::direction(cell.face, s, t);
                        let mu = l.iter().zip(n).map(|(a, b)| a * b).sum::<f64>() / length2.sqrt();
                        if mu > 0.0 {
                            let k = (kernel.value)(0.5 - 0.5 * mu, alpha);
                            weight += 0.25 * step * step * k / (length2 * length2.sqrt());
                        }
                    }
                }
            }
        }
        sum.iter_mut().zip(cell.radiance).for_each(|(s, r)| *s += weight * r);
        norm += weight;
    }
    sum.map(|s| s / norm)
}

/// About `count` texels of a mip, spread over the faces by the golden ratio, with the brightest one among them.
fn spread(texture: &Texture, mip: usize, count: usize) -> Vec<(u32, u32, u32)> {
    let (size, _) = texture.level_size(mip);
    let total = 6 * size as usize * size as usize;
    let texel = |i: usize| {
        let (face, rest) = (i / (size * size) as usize, i % (size * size) as usize);
        (face as u32, rest as u32 % size, rest as u32 / size)
    };
    let channels = texture.channels.len();
    let level = &texture.levels[mip];
    let brightness = |i: &usize| level[i * channels..i * channels + 3].iter().sum::<f32>();
    let brightest = (0..total).max_by(|a, b| brightness(a).total_cmp(&brightness(b))).unwrap_or(0);
    let mut list: Vec<usize> = if total <= count {
        (0..total).collect()
    } else {
        (0..count).map(|i| ((i as f64 + 0.5) * 0.618_033_988_749_894_9 % 1.0 * total as f64) as usize).collect()
    };
    list.push(brightest);
    list.sort();
    list.dedup();
    list.into_iter().map(texel).collect()
}
