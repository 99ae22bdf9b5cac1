// SPDX-License-Identifier: MIT OR Apache-2.0
//! Checks a table of a BRDF of one's own against a finer run of its adaptive rule, at nodes that the bake did not use.

use serde::Serialize;

use super::table::{Extent, grid, median, samples};
use crate::bake::At;
use crate::bake::own::OwnJob;
use crate::error::Result;
use crate::format::Steps;
use crate::progress::OnProgress;
use crate::texture::Texture;

/// The difference of one channel from the finer rule: absolute up to 1, relative to the value beyond.
#[derive(Clone, Debug, Serialize)]
pub struct OwnError {
    /// What it holds.
    pub name: String,
    /// Largest difference.
    pub worst: f64,
    /// Texel (x, y) of the largest difference.
    pub worst_texel: [u32; 2],
    /// Root mean square of the differences.
    pub rms: f64,
    /// Median of the differences.
    pub median: f64,
}

/// What a check found.
#[derive(Clone, Debug, Serialize)]
pub struct OwnReport {
    /// Differences, channel by channel, rounding included.
    pub channels: Vec<OwnError>,
    /// Texels that were computed again.
    pub texels: usize,
    /// Largest estimate of the finer rule's own error.
    pub reference_error: f64,
    /// What the rule of the bake may be off. A texel may be off by twice the finer run's estimate more: its rounding, and that
    /// of the bake.
    pub bound: f64,
    /// Largest difference less what rounding explains, and the largest median of any channel, at the texels of a spot
    /// check: what a bake states of itself.
    pub certified_worst: f64,
    /// See above.
    pub certified_median: f64,
    /// What is wrong, in sentences; empty when everything holds.
    pub failures: Vec<String>,
}

impl OwnReport {
    /// Largest difference of any channel.
    pub fn worst(&self) -> f64 {
        self.channels.iter().map(|c| c.worst).fold(0.0, f64::max)
    }

    /// Largest median of any channel.
    pub fn median(&self) -> f64 {
        self.channels.iter().map(|c| c.median).fold(0.0, f64::max)
    }
}

/// Texels a side of a spot check.
const SPOT: u32 = 5;

/// Computes texels of `texture` again; `stored` is what they went through, if anything.
pub fn check(
    job: &OwnJob<'_>,
    texture: &Texture,
    stored: Option<Steps>,
    extent: Extent,
    on: &mut OnProgress<'_>,
) -> Result<OwnReport> {
    let (width, height) = job.table().size();
    let spot = grid(samples(width, SPOT), &samples(height, SPOT));
    let texels = match extent {
        Extent::Spot => spot.clone(),
        Extent::Twin | Extent::Full => grid((0..width).collect(), &(0..height).collect::<Vec<_>>()),
    };
    let places: Vec<At> = texels.iter().map(|[x, y]| job.table().at(*x, *y)).collect();
    let finer = job.values(&places, true, on)?;

    // Of each channel the differences, and those of the spot check less rounding.
    let count = texture.channels.len();
    let (mut differences, mut beyond) = (vec![vec![]; count], vec![vec![]; count]);
    let bound = job.goal();
    let mut bad: Option<(f64, String)> = None;
    let mut bad_texels = 0;
    for ((texel, at), finer) in texels.iter().zip(&places).zip(&finer) {
        let found = texture.texel(0, 0, texel[0], texel[1]);
        let largest = found.iter().copied().fold(0.0, f32::max);
        let mut worst: Option<(f64, String)> = None;
        for (channel, (found, expected)) in found.iter().zip(job.chosen(finer)).enumerate() {
            let found = f64::from(*found);
            let scale = expected.abs().max(1.0);
            let rounding = match stored {
                Some(steps) => steps.half_ulp_at(expected, f64::from(largest)),
                None => f64::from(f32::EPSILON) * scale,
            };
            let difference = (found - expected).abs();
            differences[channel].push(difference / scale);
            if spot.contains(texel) {
                let rest = (difference - if stored.is_some() { rounding } else { 0.0 }) / scale;
                beyond[channel].push(if rest < 0.0 { 0.0 } else { rest });
            }
            let excess = difference - (bound * scale + rounding + 2.0 * finer.error);
            // NaN is not within any bound, and the worst of all.
            let within = excess <= 0.0;
            if !within && worst.as_ref().is_none_or(|(before, _)| excess.total_cmp(before).is_gt()) {
                let sentence = format!(
                    "{} at texel ({}, {}), n_dot_v {:.6}, roughness {:.6}, is {found:.8} instead of {expected:.8}",
                    texture.channels[channel], texel[0], texel[1], at.n_dot_v, at.roughness
                );
                worst = Some((excess, sentence));
            }
        }
        if let Some((excess, sentence)) = worst {
            bad_texels += 1;
            if bad.as_ref().is_none_or(|(before, _)| excess.total_cmp(before).is_gt()) {
                bad = Some((excess, sentence));
            }
        }
    }
    let channel = |c: usize| {
        let list = &differences[c];
        let worst = (0..list.len()).max_by(|a, b| list[*a].total_cmp(&list[*b])).unwrap_or(0);
        OwnError {
            name: texture.channels[c].clone(),
            worst: list[worst],
            worst_texel: texels[worst],
            rms: (list.iter().map(|d| d * d).sum::<f64>() / list.len() as f64).sqrt(),
            median: median(list.clone()),
        }
    };
    let failures = bad.map(|(_, worst)| {
        format!("{bad_texels} of {} texels are off against a finer rule; worst: {worst}", texels.len())
    });
    Ok(OwnReport {
        channels: (0..count).map(channel).collect(),
        texels: texels.len(),
        reference_error: finer.iter().map(|e| e.error).fold(0.0, f64::max),
        bound,
        certified_worst: beyond.iter().flatten().copied().max_by(f64::total_cmp).unwrap_or(f64::NAN),
        certified_median: beyond.into_iter().map(median).max_by(f64::total_cmp).unwrap_or(f64::NAN),
        failures: failures.into_iter().collect(),
    })
}
