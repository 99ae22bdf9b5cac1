// SPDX-License-Identifier: MIT OR Apache-2.0
//! Compares the texels of a table with the twin and the truth, and with the laws that they must obey.

use std::collections::HashSet;

use rayon::prelude::*;
use serde::Serialize;

use super::law::Law;
use crate::bake::{At, TableJob, TexelLaw, Values};
use crate::error::Result;
use crate::format::{Encoding, Repr, Steps};
use crate::progress::{OnProgress, tick};
use crate::texture::{Meta, Texture};

/// Accuracy that is asked of the truth: this share of the bound that is checked against it.
const TRUTH_SHARE: f64 = 0.1;

/// What a texel is before it is stored.
const SINGLE: Encoding = Encoding { name: "r32f", components: 1, repr: Repr::F32 };

/// How many texels a check looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Corners, edges and a coarse grid: milliseconds.
    Spot,
    /// Every texel against the twin, as few as that against the truth: for a file that is known to have been changed.
    Twin,
    /// Every texel.
    Full,
}

/// The error of one channel against the truth: absolute up to 1, relative to the value beyond.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelError {
    /// What it holds.
    pub name: String,
    /// Largest absolute error.
    pub worst: f64,
    /// Texel (x, y) of the largest error.
    pub worst_texel: [u32; 2],
    /// Root mean square of the errors.
    pub rms: f64,
    /// Median of the absolute errors.
    pub median: f64,
    /// Share of texels that are the truth rounded to the stored encoding.
    pub correctly_rounded: f64,
}

/// What a check found.
#[derive(Clone, Debug, Serialize)]
pub struct TableReport {
    /// Errors against the truth, channel by channel.
    pub channels: Vec<ChannelError>,
    /// Texels compared with the truth.
    pub truth_texels: usize,
    /// Largest error bound of the truth itself.
    pub truth_error: f64,
    /// Texels compared with the twin, the same rule in f64.
    pub twin_texels: usize,
    /// Largest absolute difference from the twin.
    pub twin_worst: f64,
    /// Median absolute difference from the twin.
    pub twin_median: f64,
    /// The least bound that a checked texel had to keep, rounding included.
    pub bound: f64,
    /// Largest error, less what rounding to the stored encoding explains, at the texels of a spot check: what a bake
    /// states of itself.
    pub certified_worst: f64,
    /// Largest median of any channel of the same.
    pub certified_median: f64,
    /// What must hold, and whether it does.
    pub laws: Vec<Law>,
    /// What is wrong, in sentences; empty when everything holds.
    pub failures: Vec<String>,
}

impl TableReport {
    /// Largest error of any channel.
    pub fn worst(&self) -> f64 {
        self.channels.iter().map(|c| c.worst).fold(0.0, f64::max)
    }

    /// Largest median of any channel.
    pub fn median(&self) -> f64 {
        self.channels.iter().map(|c| c.median).fold(0.0, f64::max)
    }

    /// States in a file's meta what a spot check of the table found; `bound` is that of its loosest texel.
    pub fn state(&self, bound: f64, meta: &mut Meta) {
        meta.set("error.worst", format!("{:.2e}", self.worst() + self.truth_error));
        meta.set("error.median", format!("{:.2e}", self.median()));
        meta.set("error.bound", format!("{bound:.0e}"));
        meta.set("error.checked", format!("{} texels against adaptive f64 integration", self.truth_texels));
    }
}

/// One texel beside a reference.
struct Compared {
    texel: [u32; 2],
    at: At,
    found: Vec<f64>,
    expected: Vec<f64>,
    /// How far each expected value may be off.
    reference_error: Vec<f64>,
}

/// Checks the texels of `texture`, which `job` describes; `stored` is what they went through, if anything.
pub fn check(
    job: &TableJob,
    texture: &Texture,
    stored: Option<Steps>,
    extent: Extent,
    on: &mut OnProgress<'_>,
) -> Result<TableReport> {
    let (width, height) = job.size();
    let compare = |texels: &[[u32; 2]], reference: &(dyn Fn(At) -> (Vec<f64>, Vec<f64>) + Sync)| -> Vec<Compared> {
        texels
            .par_iter()
            .map(|&texel| {
                let at = job.at(texel[0], texel[1]);
                let found = texture.texel(0, 0, texel[0], texel[1]).iter().map(|v| f64::from(*v)).collect();
                let (expected, reference_error) = reference(at);
                Compared { texel, at, found, expected, reference_error }
            })
            .collect()
    };
    let sampled = |n: u32| grid(samples(width, n), &samples(height, n));
    let all = || grid((0..width).collect(), &(0..height).collect::<Vec<_>>());

    let twin_texels = if extent == Extent::Spot { sampled(24) } else { all() };
    tick(on, "verify: twin", 0.0)?;
    let twin = compare(&twin_texels, &|at| (job.rule(at), job.source_rounding(at)));
    let truth_texels = if extent == Extent::Full { all() } else { sampled(4) };
    let mut truth = Vec::with_capacity(truth_texels.len());
    for chunk in truth_texels.chunks(512) {
        tick(on, "verify: truth", truth.len() as f64 / truth_texels.len() as f64)?;
        truth.extend(compare(chunk, &|at| expected(job, at)));
    }
    tick(on, "verify: truth", 1.0)?;

    let (mut failures, mut obeyed) = (vec![], vec![]);
    let mut bound = f64::INFINITY;
    for (kind, by, list) in [("twin", "the same rule in f64", &twin), ("truth", job.table.truth_name(), &truth)] {
        let before = failures.len();
        if list.is_empty() {
            failures.push(format!("no texel was compared with the {kind}"));
        }
        let mut bad_texels = 0;
        let mut worst: Option<(&Compared, usize, f64)> = None;
        for compared in list {
            let largest = compared.found.iter().copied().fold(0.0, f64::max);
            let mut bad = false;
            for (channel, (found, expected)) in compared.found.iter().zip(&compared.expected).enumerate() {
                let rounding = stored.map_or(0.0, |e| e.half_ulp_at(*expected, largest));
                let scale = expected.abs().max(1.0);
                let allowed =
                    job.tolerance(channel).at(compared.at) * scale + rounding + compared.reference_error[channel];
                bound = bound.min(allowed);
                let error = (found - expected).abs();
                // NaN is not within any bound.
                if error <= allowed {
                    continue;
                }
                bad = true;
                // NaN is the worst of all: `max` by total order keeps it.
                let excess = error - allowed;
                if worst.is_none_or(|(.., before)| excess.total_cmp(&before).is_gt()) {
                    worst = Some((compared, channel, excess));
                }
            }
            bad_texels += usize::from(bad);
        }
        if let Some((c, channel, _)) = worst {
            failures.push(format!(
                "{bad_texels} of {} texels are off against the {kind}; worst: {} at texel ({}, {}), n_dot_v {:.6}, \
                 roughness {:.6}, is {:.8} instead of {:.8}",
                list.len(),
                texture.channels[channel],
                c.texel[0],
                c.texel[1],
                c.at.n_dot_v,
                c.at.roughness,
                c.found[channel],
                c.expected[channel]
            ));
        }
        let statement = format!("{} texels agree with the {kind} ({by}) within their bounds", list.len());
        obeyed.push(Law::new(statement, &failures[before..]));
    }
    if let Some(law) = job.table.law().filter(|_| job.own_channels().is_some()) {
        tick(on, "verify: texels", 0.0)?;
        let failure = broken(job, law, &sampled(4), texture, stored);
        obeyed.push(Law::new(format!("each of {} texels {}", sampled(4).len(), law.statement), failure.as_slice()));
        failures.extend(failure);
    }
    for (statement, failure) in laws(job, texture, stored) {
        obeyed.push(Law::new(statement, failure.as_slice()));
        failures.extend(failure);
    }

    let twin_errors = || twin.iter().flat_map(|c| c.found.iter().zip(&c.expected).map(|(f, e)| (f - e).abs()));
    let twin_median = median(twin_errors().collect());
    let median_bound = job.loosest().median;
    if stored.is_none() && twin.len() >= 64 && twin_median > median_bound {
        failures
            .push(format!("the median difference from the twin is {twin_median:.1e}, more than {median_bound:.1e}"));
    }
    let spot: HashSet<[u32; 2]> = sampled(4).into_iter().collect();
    let spot: Vec<&Compared> = truth.iter().filter(|c| spot.contains(&c.texel)).collect();
    let beyond = |channel: usize| -> Vec<f64> { spot.iter().map(|c| beyond_rounding(c, channel, stored)).collect() };
    let beyond: Vec<Vec<f64>> = (0..texture.channels.len()).map(beyond).collect();
    Ok(TableReport {
        certified_worst: beyond.iter().flatten().copied().fold(0.0, worse),
        certified_median: beyond.into_iter().map(median).fold(0.0, worse),
        laws: obeyed,
        channels: (0..texture.channels.len()).map(|i| channel_error(&texture.channels[i], i, &truth, stored)).collect(),
        truth_texels: truth.len(),
        truth_error: truth
            .iter()
            .flat_map(|c| c.reference_error.iter().zip(&c.expected).map(|(error, v)| error / v.abs().max(1.0)))
            .fold(0.0, f64::max),
        twin_texels: twin.len(),
        twin_worst: twin_errors().fold(0.0, f64::max),
        twin_median,
        bound,
        failures,
    })
}

/// The truth of the chosen channels at a place, and how far each may be off.
pub fn expected(job: &TableJob, at: At) -> (Vec<f64>, Vec<f64>) {
    job.truth(at, TRUTH_SHARE).into_iter().map(|truth| (truth.value[0], truth.error)).unzip()
}

/// The greater one; NaN is the greatest.
fn worse(a: f64, b: f64) -> f64 {
    if a.total_cmp(&b).is_ge() { a } else { b }
}

/// The error of a channel that rounding to the stored encoding does not explain.
fn beyond_rounding(c: &Compared, channel: usize, stored: Option<Steps>) -> f64 {
    let (found, expected) = (c.found[channel], c.expected[channel]);
    let largest = c.found.iter().copied().fold(0.0, f64::max);
    let rounding = stored.map_or(0.0, |e| e.half_ulp_at(expected, largest));
    let beyond = ((found - expected).abs() - rounding) / expected.abs().max(1.0);
    if beyond < 0.0 { 0.0 } else { beyond }
}

fn channel_error(name: &str, channel: usize, truth: &[Compared], stored: Option<Steps>) -> ChannelError {
    let scale = |c: &Compared| c.expected[channel].abs().max(1.0);
    let errors: Vec<f64> = truth.iter().map(|c| (c.found[channel] - c.expected[channel]).abs() / scale(c)).collect();
    let worst = (0..errors.len()).max_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap_or(0);
    // The nearest stored value is the one within half a step of the truth.
    let rounded = |(c, error): &(&Compared, &f64)| {
        let largest = c.found.iter().copied().fold(0.0, f64::max);
        let steps = stored.unwrap_or(SINGLE.into());
        **error * scale(c) <= steps.half_ulp_at(c.expected[channel], largest)
    };
    ChannelError {
        name: name.into(),
        worst: errors[worst],
        worst_texel: truth[worst].texel,
        rms: (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt(),
        median: median(errors.clone()),
        correctly_rounded: truth.iter().zip(&errors).filter(rounded).count() as f64 / truth.len() as f64,
    }
}

/// Laws over every texel, each with what is wrong: finite, within the channel's range, and scale + bias = albedo ≤ 1.
fn laws(job: &TableJob, texture: &Texture, stored: Option<Steps>) -> Vec<(String, Option<String>)> {
    let channels: Vec<_> = job.channel_facts().collect();
    let near_zero = job.loosest().near_zero;
    let slack = |v: f64| near_zero * v.abs().max(1.0) + stored.map_or(0.0, |e| e.half_ulp_at(v, v));
    let find = |name: &str| channels.iter().position(|c| c.name == name);
    let (width, height) = job.size();
    let largest = f64::from(job.model.largest());
    // Each says what is wrong with a texel, if anything is.
    type Check<'a> = Box<dyn Fn(&[f32]) -> Option<String> + 'a>;
    let mut checks: Vec<(String, Check<'_>)> = vec![];
    for (i, channel) in channels.iter().enumerate() {
        let [low, high] = job.range(i).map(f64::from);
        let check = move |texel: &[f32]| {
            let value = f64::from(texel[i]);
            let inside = value >= low - slack(low) && value <= high + slack(high);
            (!inside).then(|| format!("{} is {value}, outside [{low}, {high}]", channel.name))
        };
        checks.push((format!("{} is finite and within [{low}, {high}]", channel.name), Box::new(check)));
    }
    if let (Some(scale), Some(bias)) = (find("scale"), find("bias")) {
        let sum = move |texel: &[f32]| f64::from(texel[scale]) + f64::from(texel[bias]);
        let check = move |texel: &[f32]| {
            let e = sum(texel);
            (e.is_nan() || e > largest + 2.0 * slack(largest))
                .then(|| format!("scale + bias is {e}, more than {largest}"))
        };
        checks.push((format!("scale + bias is at most {largest}: no light is made"), Box::new(check)));
        if let Some(albedo) = find("albedo") {
            let check = move |texel: &[f32]| {
                let (e, albedo) = (sum(texel), f64::from(texel[albedo]));
                let equal = (e - albedo).abs() <= 3.0 * slack(e);
                (!equal).then(|| format!("scale + bias is {e}, albedo is {albedo}"))
            };
            checks.push(("scale + bias is the albedo".into(), Box::new(check)));
        }
    }
    let texels = || (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let broken = |check: &Check<'_>| {
        let mut broken = texels().filter_map(|[x, y]| check(texture.texel(0, 0, x, y)).map(|what| (what, x, y)));
        let (what, x, y) = broken.next()?;
        Some(format!("{} texels break a law; the first, ({x}, {y}): {what}", 1 + broken.count()))
    };
    checks.into_iter().map(|(statement, check)| (statement, broken(&check))).collect()
}

/// What is wrong by a law of texels, if anything is.
fn broken(
    job: &TableJob,
    law: &TexelLaw,
    texels: &[[u32; 2]],
    texture: &Texture,
    stored: Option<Steps>,
) -> Option<String> {
    let places = job.own_channels()?;
    let of_texel = |&[x, y]: &[u32; 2]| {
        let texel = texture.texel(0, 0, x, y);
        let (mut found, mut rounding) = (Values::default(), Values::default());
        for (own, place) in places.iter().enumerate() {
            found[own] = f64::from(texel[*place]);
            rounding[own] = stored.unwrap_or(SINGLE.into()).half_ulp_at(found[own], found[own].abs());
        }
        (law.broken)(&job.model, job.at(x, y), &found, &rounding).map(|what| (what, x, y))
    };
    let mut wrong: Vec<_> = texels.par_iter().filter_map(of_texel).collect();
    let count = wrong.len();
    let (what, x, y) = wrong.drain(..).next()?;
    Some(format!("{count} of {} texels break a law; the first, ({x}, {y}): {what}", texels.len()))
}

/// Indices of up to `n` samples of an axis, both ends and their neighbours included.
pub(super) fn samples(len: u32, n: u32) -> Vec<u32> {
    let mut list: Vec<u32> =
        (0..n).map(|i| (f64::from(i) / f64::from(n - 1) * f64::from(len - 1)).round() as u32).collect();
    list.extend([1.min(len - 1), len.saturating_sub(2)]);
    list.sort();
    list.dedup();
    list
}

pub(super) fn grid(xs: Vec<u32>, ys: &[u32]) -> Vec<[u32; 2]> {
    ys.iter().flat_map(|y| xs.iter().map(|x| [*x, *y])).collect()
}

pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
