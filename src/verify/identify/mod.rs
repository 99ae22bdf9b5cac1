// SPDX-License-Identifier: MIT OR Apache-2.0
//! What made this table? Tries every convention that the registries know on a picture of unknown origin: distribution,
//! geometry term, channels, axes and their warps, transposed and flipped tables, positions in a texel, rows shifted by
//! one, encodings.
//!
//! Published tables come from Monte Carlo integration, with errors up to 2e-2, so a fit is judged by what is left of it,
//! against the runner-up. Rounding explains errors up to a step of the encoding. Noise changes from texel to texel, while
//! the difference of a wrong convention is smooth; but integrators that use one sequence of samples for all texels leave a
//! smooth rest too. There the nearest other conventions are the measure: those next to a wrong answer explain a file about
//! as well as it does, those next to the right one much worse. Only an answer that is clearly better than the runner-up is
//! *certain*; otherwise it is *likely*, and the facts that are open are named.
//!
//! Not tried: distributions with free parameters, anisotropy, exact Fresnel terms, tables of one dimension.

mod content;
mod layout;
mod measure;
mod models;
mod search;

use rayon::prelude::*;
use serde::Serialize;

pub use content::{Quantity, Transfer};
pub use layout::{Layout, Points, Side};
pub use measure::{Measured, measure};
pub use search::Hypothesis;

use content::Samples;
use search::{Compared, Match, compare, search};

use crate::error::{Error, Result};
use crate::format::picture::{Picture, Value};
use crate::progress::OnProgress;

/// An error that a rule may have, beside rounding: those of other integrators that sum up finely enough.
const RULE_ERROR: f64 = 2e-5;
/// Root mean square of the errors beyond which a component is not what it was taken for.
const FITS_RMS: f64 = 1e-2;
/// Largest error of a component that fits.
const FITS_MAX: f64 = 8e-2;
/// The runner-up is clearly worse when its root mean square is larger by this factor: where rounding explains the best
/// one.
const CLEAR_OF_ROUNDING: f64 = 1.2;
/// Where noise does that changes from texel to texel.
const CLEAR_OF_NOISE: f64 = 1.5;
/// Where something smooth is left. The published tables of Bevy and three.js have 4.1 and 4.2.
const CLEAR_OF_BIAS: f64 = 3.0;
/// Root mean square beyond which nothing is certain: twice that of a table of 16 texels with 4096 samples.
const CERTAIN_RMS: f64 = 3e-3;
/// Share of an error's variation that is between neighbouring texels, from which on it is noise.
pub const NOISY: f64 = 0.3;
/// Texels a side from which on a picture can tell something.
const LEAST_SIZE: u32 = 4;
/// Hypotheses that are reported.
const REPORTED: usize = 3;

/// How sure an answer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The first fit explains every texel within rounding or noise, and nothing else does.
    Certain,
    /// The first fit is the best one, but another is near or a smooth difference is left.
    Likely,
    /// Nothing fits.
    None,
}

/// What a component of the file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A quantity of the hypothesis' model.
    Of(Quantity),
    /// A quantity of another model at the same places: its distribution and geometry term.
    Other(Quantity, String),
    /// The same number everywhere.
    Constant(f64),
    /// Nothing that is known.
    Unknown,
}

/// A component under a hypothesis.
#[derive(Clone, Debug)]
pub struct Component {
    /// Its name in the file.
    pub name: String,
    /// What it holds.
    pub content: Content,
}

impl Component {
    fn words(&self) -> String {
        match &self.content {
            Content::Of(quantity) => format!("{} = {}", self.name, quantity.name()),
            Content::Other(quantity, model) => format!("{} = {} of {model}", self.name, quantity.name()),
            Content::Constant(value) => format!("{} = {value}", self.name),
            Content::Unknown => format!("{} = ?", self.name),
        }
    }
}

/// Facts: name and words.
pub type Words = Vec<(&'static str, String)>;

/// A hypothesis and how well it explains the file.
pub struct Fit {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// What each component holds.
    pub components: Vec<Component>,
    /// Largest error, absolute up to 1 and relative to the value beyond.
    pub max: f64,
    /// Where it is.
    pub worst_texel: [u32; 2],
    /// Root mean square of the errors.
    pub rms: f64,
    /// Every error is within a step of the encoding: rounded, or digits cut off.
    pub is_exact: bool,
    /// Every error is within half a step: each is the nearest number that can be stored.
    pub is_rounded: bool,
}

impl Fit {
    /// Which components the model explains.
    fn explained(&self) -> Vec<bool> {
        self.components.iter().map(|c| matches!(c.content, Content::Of(_))).collect()
    }

    /// In words, one part a fact.
    pub fn words(&self) -> Words {
        let Hypothesis { model, layout, transfer } = &self.hypothesis;
        let list = self.components.iter().map(Component::words).collect::<Vec<_>>();
        let mut words = vec![
            ("channels", list.join(", ")),
            ("x", layout.x.words()),
            ("y", layout.y.words()),
            ("distribution", model.ndf.to_string()),
            ("geometry", model.visibility.name.to_string()),
        ];
        if *transfer != Transfer::Linear {
            words.push(("encoding", transfer.words().to_string()));
        }
        if let Some(shift) = layout.shift_words() {
            words.push(("shift", shift));
        }
        words
    }
}

/// What tells the best fit from the runner-up.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// Facts that differ: name, of the best, of the runner-up.
    pub facts: Vec<(&'static str, String, String)>,
    /// The checked texel at which they differ most.
    pub texel: [u32; 2],
    /// Its component.
    pub component: String,
    /// What the file holds there.
    pub found: f64,
    /// What the best says.
    pub best: f64,
    /// What the runner-up says.
    pub runner_up: f64,
}

/// What was found.
pub struct Report {
    /// How sure the first fit is.
    pub verdict: Verdict,
    /// The best fits, best first; also where none is good enough. Empty for a picture that is the same everywhere.
    pub fits: Vec<Fit>,
    /// Names of the facts on which fits that are not clearly worse disagree with the first.
    pub open: Vec<&'static str>,
    /// What tells the first two apart.
    pub difference: Option<Difference>,
    /// Share of the first fit's error that changes from texel to texel: near 1 for noise, near 0 for a wrong convention.
    pub noisiness: f64,
    /// Texels that were compared.
    pub texels: usize,
}

/// Finds the conventions that explain a picture of at least 4 × 4 texels.
pub fn identify(picture: &Picture, on: &mut OnProgress<'_>) -> Result<Report> {
    if picture.width.min(picture.height) < LEAST_SIZE {
        return Err(Error::usage(
            format!("a picture of {}x{} texels is too small to identify", picture.width, picture.height),
            format!("give a table of two dimensions with at least {LEAST_SIZE} texels a side"),
        ));
    }
    let transfers: Vec<Transfer> = Transfer::ALL.into_iter().filter(|t| t.fits(picture)).collect();
    let constants: Vec<Vec<Option<f64>>> =
        transfers.iter().map(|t| constants(&Samples::take(picture, *t, 64))).collect();
    let of = |transfer: Transfer| &constants[transfers.iter().position(|t| *t == transfer).expect("it is one of them")];
    let found = search(picture, &transfers, &|transfer, c| of(transfer)[c].is_some(), on)?;
    let (Some(best), false) = (found.first(), constants[0].iter().all(Option::is_some)) else {
        let (fits, open) = (vec![], vec![]);
        return Ok(Report { verdict: Verdict::None, fits, open, difference: None, noisiness: 0.0, texels: 0 });
    };

    let samples: Vec<Samples> =
        found.iter().map(|c| Samples::take(picture, c.hypothesis.transfer, search::LAST_GRID)).collect();
    let mut fits: Vec<Fit> = vec![];
    for (compared, samples) in found.iter().zip(&samples) {
        // All are measured by the components that the first one explains.
        let explained = fits.first().map(|first| first.explained());
        fits.push(fit(picture, compared, samples, of(compared.hypothesis.transfer), explained));
    }
    let noisiness = noisiness(best, &samples[0], &fits[0]);
    let verdict_on = |second: &Fit| {
        let best = &fits[0];
        let ratio = second.rms / best.rms.max(f64::MIN_POSITIVE);
        match (best.is_exact, second.is_exact) {
            (true, false) => ratio >= 1.0,
            // Rounding explains every texel of one, and not of the other.
            (true, true) if best.is_rounded && !second.is_rounded => ratio >= 1.0,
            (true, true) => ratio >= CLEAR_OF_ROUNDING,
            (false, _) if noisiness >= NOISY => ratio >= CLEAR_OF_NOISE,
            (false, _) => ratio >= CLEAR_OF_BIAS,
        }
    };
    let near: Vec<&Fit> = fits[1..].iter().filter(|second| !verdict_on(second)).collect();
    let first = fits[0].words();
    let mut open: Vec<&'static str> = vec![];
    for name in near.iter().flat_map(|other| differing(&first, &other.words())).map(|(name, ..)| name) {
        if !open.contains(&name) {
            open.push(name);
        }
    }
    let mut verdict = if !(fits[0].rms <= FITS_RMS && fits[0].max <= FITS_MAX) {
        Verdict::None
    } else if near.is_empty() && fits[0].rms <= CERTAIN_RMS {
        Verdict::Certain
    } else {
        Verdict::Likely
    };
    let difference = (found.len() > 1).then(|| difference(&fits, &found, &samples));

    // A component that the model does not explain may be another's.
    let unknown = fits[0].components.iter().any(|c| c.content == Content::Unknown);
    if unknown && verdict != Verdict::None {
        explain_others(&mut fits[0], &samples[0]);
        // Part of a table that is not even clear about that part.
        if verdict == Verdict::Likely && fits[0].components.iter().any(|c| c.content == Content::Unknown) {
            verdict = Verdict::None;
        }
    }
    let texels = samples[0].texels.len();
    fits.truncate(REPORTED);
    Ok(Report { verdict, fits, open, difference, noisiness, texels })
}

/// The number of each component that is the same everywhere, within a step.
fn constants(samples: &Samples) -> Vec<Option<f64>> {
    let one = |values: &Vec<Value>| {
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v.value), h.max(v.value)));
        let step = 2.0 * values.iter().map(|v| v.half_step).fold(0.0, f64::max);
        (high - low <= step).then_some(0.5 * (low + high))
    };
    samples.values.iter().map(one).collect()
}

/// Errors over the components that are `explained`: by default those that the model explains, or all where it explains
/// none.
fn fit(
    picture: &Picture,
    compared: &Compared,
    samples: &Samples,
    constants: &[Option<f64>],
    explained: Option<Vec<bool>>,
) -> Fit {
    let names = compared.hypothesis.transfer.names(picture);
    let own: Vec<bool> = compared.matches.iter().map(|m| m.mean_square.sqrt() <= FITS_RMS).collect();
    let any = own.iter().zip(constants).any(|(own, constant)| constant.is_none() && *own);
    // Another encoding may have another number of components.
    let explained = explained.filter(|e| e.len() == own.len()).unwrap_or(if any { own } else { vec![true; own.len()] });
    let content = |((m, constant), explained): ((&Match, &Option<f64>), &bool)| match constant {
        Some(value) => Content::Constant(*value),
        None if *explained => Content::Of(m.quantity),
        None => Content::Unknown,
    };
    let contents = compared.matches.iter().zip(constants).zip(&explained).map(content);
    let components: Vec<Component> =
        names.into_iter().zip(contents).map(|(name, content)| Component { name, content }).collect();
    let mut fit = Fit {
        hypothesis: compared.hypothesis,
        components,
        max: 0.0,
        worst_texel: [0; 2],
        rms: 0.0,
        is_exact: true,
        is_rounded: true,
    };
    let (mut sum, mut n) = (0.0, 0.0);
    for residual in residuals(compared, samples, &fit) {
        sum += residual.error * residual.error;
        n += 1.0;
        if residual.error.abs() > fit.max {
            (fit.max, fit.worst_texel) = (residual.error.abs(), samples.texels[residual.texel]);
        }
        // A whole step: some writers cut digits off instead of rounding.
        fit.is_exact &= residual.error.abs() <= 2.001 * residual.half_step + RULE_ERROR;
        fit.is_rounded &= residual.error.abs() <= 1.001 * residual.half_step + RULE_ERROR;
    }
    fit.rms = (sum / n).sqrt();
    fit
}

/// The error of a component at a texel.
struct Residual {
    component: usize,
    texel: usize,
    error: f64,
    half_step: f64,
}

/// All errors of the components that the model explains.
fn residuals(compared: &Compared, samples: &Samples, fit: &Fit) -> Vec<Residual> {
    let mut all = vec![];
    for (component, c) in fit.components.iter().enumerate() {
        let Content::Of(quantity) = c.content else { continue };
        for (texel, expected) in compared.expected.iter().enumerate() {
            if let Some(expected) = expected {
                let wanted = samples.expected(quantity, *expected);
                let scale = wanted.abs().max(1.0);
                let value = samples.values[component][texel];
                let (error, half_step) = ((value.value - wanted) / scale, value.half_step / scale);
                all.push(Residual { component, texel, error, half_step });
            }
        }
    }
    all
}

/// Root mean square of the second differences between neighbouring samples over that of the errors, 1 for white noise.
fn noisiness(compared: &Compared, samples: &Samples, fit: &Fit) -> f64 {
    let list = residuals(compared, samples, fit);
    let (mut bent, mut bends, mut square) = (0.0, 0.0, 0.0);
    let mut grid = vec![None; samples.texels.len() * samples.values.len()];
    for r in &list {
        grid[r.component * samples.texels.len() + r.texel] = Some(r.error);
        square += r.error * r.error;
    }
    let rows = samples.texels.len() / samples.columns;
    let at = |c: usize, x: usize, y: usize| grid[c * samples.texels.len() + y * samples.columns + x];
    let mut bend = |triple: [Option<f64>; 3]| {
        if let [Some(a), Some(b), Some(c)] = triple {
            bent += (a - 2.0 * b + c).powi(2);
            bends += 1.0;
        }
    };
    for c in 0..samples.values.len() {
        for y in 0..rows {
            for x in 0..samples.columns {
                if x + 2 < samples.columns {
                    bend([at(c, x, y), at(c, x + 1, y), at(c, x + 2, y)]);
                }
                if y + 2 < rows {
                    bend([at(c, x, y), at(c, x, y + 1), at(c, x, y + 2)]);
                }
            }
        }
    }
    // The second difference of independent numbers has six times their variance.
    (bent / bends / 6.0 / (square / list.len() as f64)).sqrt()
}

/// Looks for another model behind each component that the fit's own does not explain.
fn explain_others(fit: &mut Fit, samples: &Samples) {
    let coarse: Vec<usize> = (0..samples.texels.len()).step_by(7).collect();
    let some = samples.only(&coarse);
    let hypothesis = fit.hypothesis;
    let all: Vec<Compared> = search::MODELS
        .par_iter()
        .map(|(model, _)| compare(&Hypothesis { model: *model, ..hypothesis }, &some, &[]))
        .collect();
    for (c, component) in fit.components.iter_mut().enumerate() {
        if component.content != Content::Unknown {
            continue;
        }
        let best = all.iter().min_by(|a, b| a.matches[c].mean_square.total_cmp(&b.matches[c].mean_square));
        if let Some(best) = best.filter(|best| best.matches[c].mean_square.sqrt() <= FITS_RMS) {
            let model = &best.hypothesis.model;
            let name = format!("{} {}", model.ndf, model.visibility.name);
            component.content = Content::Other(best.matches[c].quantity, name);
        }
    }
}

/// Facts that differ: name, of the first, of the second.
fn differing(first: &Words, second: &Words) -> Vec<(&'static str, String, String)> {
    let value = |words: &Words, name: &str| {
        words.iter().find(|(n, _)| *n == name).map_or("none".to_string(), |(_, v)| v.clone())
    };
    let mut names: Vec<&'static str> = first.iter().map(|(name, _)| *name).collect();
    names.extend(second.iter().map(|(name, _)| *name).filter(|name| !first.iter().any(|(n, _)| n == name)));
    let facts = names.into_iter().map(|name| (name, value(first, name), value(second, name)));
    facts.filter(|(_, a, b)| a != b).collect()
}

/// Facts and the texel that tell the first two fits apart.
fn difference(fits: &[Fit], found: &[Compared], samples: &[Samples]) -> Difference {
    let facts = differing(&fits[0].words(), &fits[1].words());

    // Where the two say the most different things of a number of the file.
    let says = |fit: usize, component: usize, texel: usize| -> Option<f64> {
        let Content::Of(quantity) = fits[fit].components.get(component)?.content else { return None };
        Some(samples[fit].expected(quantity, found[fit].expected[texel]?))
    };
    let mut worst = Difference {
        facts,
        texel: [0; 2],
        component: String::new(),
        found: f64::NAN,
        best: f64::NAN,
        runner_up: f64::NAN,
    };
    let mut largest = -1.0;
    for (component, c) in fits[0].components.iter().enumerate() {
        for texel in 0..samples[0].texels.len() {
            if let (Some(best), Some(runner_up)) = (says(0, component, texel), says(1, component, texel)) {
                let apart = (best - runner_up).abs() / best.abs().max(1.0);
                if apart > largest {
                    largest = apart;
                    let found = samples[0].values[component][texel].value;
                    let texel = samples[0].texels[texel];
                    worst = Difference { texel, component: c.name.clone(), found, best, runner_up, ..worst };
                }
            }
        }
    }
    worst
}
