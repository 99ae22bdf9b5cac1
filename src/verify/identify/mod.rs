//! What made this table? Tries every convention that the registries know on a picture of unknown origin: distribution,
//! geometry term, channels, axes and their warps, transposed and flipped tables, positions in a texel, rows shifted by
//! one, encodings.
//!
//! Published tables come from Monte Carlo integration, with errors up to 2e-2, so a fit is judged by what is left of it.
//! Rounding explains errors up to a step of the encoding. Noise has no direction: it changes from texel to texel, while
//! the difference of a wrong convention is smooth. And the runner-up must be clearly worse. Only then is an answer
//! *certain*; an answer that stands alone but leaves a smooth rest is *likely*.
//!
//! Not tried: distributions with free parameters, anisotropy, exact Fresnel terms.

mod content;
mod layout;
mod models;
mod search;

use rayon::prelude::*;
use serde::Serialize;

pub use content::{Quantity, Transfer};
pub use layout::{Layout, Points, Side, Warp};
pub use search::Hypothesis;

use content::Samples;
use search::{Compared, Match, compare, search};

use crate::bake::Model;
use crate::error::Result;
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
/// Where noise does: its errors are alike at neighbouring texels, so more is asked for.
const CLEAR_OF_NOISE: f64 = 1.5;
/// Share of an error's variation that is between neighbouring texels, from which on it is noise.
const NOISY: f64 = 0.3;
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
    /// Every error is within a step of the encoding.
    pub is_exact: bool,
}

impl Fit {
    /// In words, one part a fact.
    pub fn words(&self) -> Vec<(&'static str, String)> {
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
    /// What tells the first two apart.
    pub difference: Option<Difference>,
    /// Share of the first fit's error that changes from texel to texel: near 1 for noise, near 0 for a wrong convention.
    pub noisiness: f64,
    /// Texels that were compared.
    pub texels: usize,
}

/// Finds the conventions that explain a picture.
pub fn identify(picture: &Picture, on: &mut OnProgress<'_>) -> Result<Report> {
    let transfers: Vec<Transfer> = Transfer::ALL.into_iter().filter(|t| t.fits(picture)).collect();
    let constants: Vec<Vec<Option<f64>>> =
        transfers.iter().map(|t| constants(&Samples::take(picture, *t, 64))).collect();
    let of = |transfer: Transfer| {
        &constants[transfers.iter().position(|t| *t == transfer).expect("it is one of them")]
    };
    let models = models::candidates();
    let found = search(picture, &models, &transfers, &|transfer, c| of(transfer)[c].is_some(), on)?;
    let (Some(best), false) = (found.first(), constants[0].iter().all(Option::is_some)) else {
        return Ok(Report { verdict: Verdict::None, fits: vec![], difference: None, noisiness: 0.0, texels: 0 });
    };

    let samples: Vec<Samples> = found
        .iter()
        .map(|c| Samples::take(picture, c.hypothesis.transfer, search::LAST_GRID))
        .collect();
    let mut fits: Vec<Fit> = found
        .iter()
        .zip(&samples)
        .map(|(compared, samples)| fit(picture, compared, samples, of(compared.hypothesis.transfer)))
        .collect();
    // A component that the model does not explain may be another's.
    let unknown = fits[0].components.iter().any(|c| c.content == Content::Unknown);
    if unknown && fits[0].rms <= FITS_RMS {
        explain_others(&mut fits[0], &samples[0], &models);
    }

    let best_fit = &fits[0];
    let fits_at_all = best_fit.rms <= FITS_RMS && best_fit.max <= FITS_MAX;
    let noisiness = noisiness(best, &samples[0], best_fit);
    let clear = fits.get(1).is_none_or(|second| {
        let ratio = second.rms / best_fit.rms.max(f64::MIN_POSITIVE);
        match (best_fit.is_exact, second.is_exact) {
            (true, false) => ratio >= 1.0,
            (true, true) => ratio >= CLEAR_OF_ROUNDING,
            (false, _) => ratio >= CLEAR_OF_NOISE && noisiness >= NOISY,
        }
    });
    let verdict = match (fits_at_all, clear) {
        (false, _) => Verdict::None,
        (true, true) => Verdict::Certain,
        (true, false) => Verdict::Likely,
    };
    let difference = (found.len() > 1).then(|| difference(&fits, &found, &samples));
    let texels = samples[0].texels.len();
    fits.truncate(REPORTED);
    Ok(Report { verdict, fits, difference, noisiness, texels })
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

/// Errors over the components that the model explains; all of them where it explains none.
fn fit(picture: &Picture, compared: &Compared, samples: &Samples, constants: &[Option<f64>]) -> Fit {
    let names = compared.hypothesis.transfer.names(picture);
    let explains = |m: &Match| m.mean_square.sqrt() <= FITS_RMS;
    let any = compared.matches.iter().zip(constants).any(|(m, constant)| constant.is_none() && explains(m));
    let content = |(m, constant): (&Match, &Option<f64>)| match constant {
        Some(value) => Content::Constant(*value),
        None if explains(m) || !any => Content::Of(m.quantity),
        None => Content::Unknown,
    };
    let contents = compared.matches.iter().zip(constants).map(content);
    let components: Vec<Component> =
        names.into_iter().zip(contents).map(|(name, content)| Component { name, content }).collect();
    let mut fit = Fit {
        hypothesis: compared.hypothesis,
        components,
        max: 0.0,
        worst_texel: [0; 2],
        rms: 0.0,
        is_exact: true,
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
            if let Some([e, b, t]) = expected {
                let wanted = quantity.of([*e, *b, *t, 0.0]);
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
fn explain_others(fit: &mut Fit, samples: &Samples, models: &[Model]) {
    let coarse: Vec<usize> = (0..samples.texels.len()).step_by(7).collect();
    let some = Samples {
        texels: coarse.iter().map(|i| samples.texels[*i]).collect(),
        size: samples.size,
        columns: coarse.len(),
        values: samples.values.iter().map(|v| coarse.iter().map(|i| v[*i]).collect()).collect(),
    };
    let hypothesis = fit.hypothesis;
    let all: Vec<Compared> = models
        .par_iter()
        .map(|model| compare(&Hypothesis { model: *model, ..hypothesis }, &some, &[]))
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

/// Facts and the texel that tell the first two fits apart.
fn difference(fits: &[Fit], found: &[Compared], samples: &[Samples]) -> Difference {
    let (first, second) = (fits[0].words(), fits[1].words());
    let value = |words: &[(&'static str, String)], name: &str| {
        words.iter().find(|(n, _)| *n == name).map_or("none".to_string(), |(_, v)| v.clone())
    };
    let mut names: Vec<&'static str> = first.iter().chain(&second).map(|(name, _)| *name).collect();
    let mut seen = vec![];
    names.retain(|name| !seen.contains(name) && { seen.push(*name); true });
    let facts: Vec<_> = names
        .into_iter()
        .map(|name| (name, value(&first, name), value(&second, name)))
        .filter(|(_, a, b)| a != b)
        .collect();

    // Where the two say the most different things of a number of the file.
    let says = |fit: usize, component: usize, texel: usize| -> Option<f64> {
        let Content::Of(quantity) = fits[fit].components.get(component)?.content else { return None };
        let [e, b, t] = found[fit].expected[texel]?;
        Some(quantity.of([e, b, t, 0.0]))
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
