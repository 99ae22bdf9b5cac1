// SPDX-License-Identifier: MIT OR Apache-2.0
//! The error of every component of a picture under a hypothesis that is known or was found.

use rayon::prelude::*;

use super::content::Samples;
use super::models::rule;
use super::search::Hypothesis;
use super::{Content, RULE_ERROR};
use crate::format::picture::Picture;
use crate::verify::table::ChannelError;

/// Errors of the components of a picture that hold a quantity of the model.
pub struct Measured {
    /// Component by component: absolute up to 1, relative to the value beyond.
    pub channels: Vec<ChannelError>,
    /// Texels that were compared.
    pub texels: usize,
    /// Every error is within a step of the encoding.
    pub is_exact: bool,
}

/// Compares up to `n` × `n` texels with the rule; `contents` says what each component holds.
///
/// The rule is itself within 1e-6 of adaptive integration, 2e-5 for rare pairs of distribution and geometry term.
pub fn measure(picture: &Picture, hypothesis: &Hypothesis, contents: &[Content], n: u32) -> Measured {
    let samples = Samples::take(picture, hypothesis.transfer, n);
    let expected: Vec<_> = samples
        .texels
        .par_iter()
        .map(|texel| {
            let (n_dot_v, roughness) = hypothesis.layout.at(*texel, samples.size)?;
            Some(rule(&hypothesis.model, n_dot_v, roughness))
        })
        .collect();
    let names = hypothesis.transfer.names(picture);
    let mut measured = Measured { channels: vec![], texels: expected.iter().flatten().count(), is_exact: true };
    for ((values, content), name) in samples.values.iter().zip(contents).zip(names) {
        let Content::Of(quantity) = content else { continue };
        let mut errors = vec![];
        let (mut rounded, mut worst, mut worst_texel) = (0, -1.0f64, [0; 2]);
        for ((value, expected), texel) in values.iter().zip(&expected).zip(&samples.texels) {
            let Some(expected) = expected else { continue };
            let wanted = samples.expected(*quantity, *expected);
            let off = (value.value - wanted).abs();
            rounded += usize::from(off <= value.half_step);
            measured.is_exact &= off <= 2.001 * value.half_step + RULE_ERROR * wanted.abs().max(1.0);
            let error = off / wanted.abs().max(1.0);
            // NaN is the worst of all.
            if error.total_cmp(&worst).is_gt() {
                (worst, worst_texel) = (error, *texel);
            }
            errors.push(error);
        }
        errors.sort_by(f64::total_cmp);
        let n = errors.len() as f64;
        measured.channels.push(ChannelError {
            name: format!("{name}={}", quantity.name()),
            worst,
            worst_texel,
            rms: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            median: errors[errors.len() / 2],
            correctly_rounded: rounded as f64 / n,
        });
    }
    measured
}
