// SPDX-License-Identifier: MIT OR Apache-2.0
//! A BRDF of one's own: GLSL that is compiled at run time and integrated adaptively on the device, with an estimate of the
//! error of every texel.
//!
//! The text defines `vec3 brdf(vec3 l, vec3 v, float alpha)` without its cosine, or `float D(float n_dot_h, float alpha)` and
//! `float V(float n_dot_v, float n_dot_l, float alpha)`, whose product it is. The normal is +Z. There is no truth in other
//! code to compare with: the estimate of the rule is checked by a finer rule with other nodes
//! ([`crate::verify::own`]).

mod cells;
mod probe;
mod program;
mod source;

pub use probe::{Laws, ROUNDING};
pub use program::Precision;
pub use source::OwnSource;

use std::collections::BTreeMap;

use self::cells::{Effort, Integral, Place, integrate};
use self::program::Program;
use super::{At, Backend, MAX_CHANNELS, RuleChoice, Source, TableJob, TableRequest, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::ndf::alpha_of;
use crate::progress::OnProgress;
use crate::quadrature::gauss_kronrod::{NODES, on_unit_interval};
use crate::term::fresnel::Fresnel;
use crate::texture::{Meta, Shape, Texture};

/// How a BRDF of one's own is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnOptions {
    /// Rows of a smaller roughness hold the values of this one, as in a shader that clamps there.
    pub least_roughness: f64,
    /// Largest estimate of a texel's error: absolute up to 1, relative beyond.
    pub most: f64,
    /// Of the evaluation.
    pub precision: Precision,
}

/// The largest estimate that is accepted unless something else is asked for.
///
/// In double precision GGX keeps it down to alpha 4e-6, the first of 256 rows, in single down to alpha 0.03.
pub fn usual_most(precision: Precision) -> f64 {
    match precision {
        Precision::Double => 2e-5,
        Precision::Single => 2e-4,
    }
}

/// What the rule aims at, beyond what rounding leaves, as a share of the largest estimate.
const AIM: f64 = 0.05;
/// n·v = 0 is taken here: a BRDF in code has no limit at grazing that could be found.
const LEAST_N_DOT_V: f64 = 1e-4;
/// Panels of √(n·v) of an average albedo after which it is given up.
const MOST_PANELS: usize = 64;
/// The key of the source's hash, by which a file is known to hold a BRDF of one's own.
pub const SOURCE_SHA256: &str = "brdf.sha256";

/// A table of a BRDF of one's own, compiled and ready to bake.
pub struct OwnJob<'a> {
    /// Table, axes and channels; its model is a placeholder.
    base: TableJob,
    source: OwnSource,
    options: OwnOptions,
    backend: &'a Backend,
    gpu: &'a Gpu,
    program: Program,
    laws: Laws,
    /// The scales of the lobes around the mirror direction and back to the viewer, by the bits of alpha.
    widths: BTreeMap<u64, [f64; 2]>,
}

/// A texel's values, and how far they can be off.
#[derive(Clone, Copy, Debug, Default)]
pub struct Estimated {
    /// Of the table's channels.
    pub value: Values,
    /// Of the worst of them.
    pub error: f64,
    least: f64,
}

/// A baked table, its estimates, and what the BRDF was found to be.
pub struct OwnTable {
    /// The table; its meta says everything but what a check measures.
    pub texture: Texture,
    /// The estimate of each texel, one channel, in the order of the file.
    pub estimates: Texture,
    /// Sentences about laws that the BRDF does not obey.
    pub warnings: Vec<String>,
}

impl<'a> OwnJob<'a> {
    /// Compiles the source and looks at what it is. The request's model is not used.
    pub fn new(
        request: &TableRequest,
        source: OwnSource,
        options: OwnOptions,
        backend: &'a Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<OwnJob<'a>> {
        if request.table.starts_with("glass") || request.of.is_some() {
            return Err(Error::usage(
                format!("{} is not baked of a BRDF of one's own", request.table),
                "bake split-sum, albedo or average-albedo",
            ));
        }
        if request.rule != RuleChoice::Direct {
            return Err(Error::usage("a BRDF of one's own has a rule of its own", "drop --rule"));
        }
        let Backend::Gpu(gpu) = backend else {
            return Err(Error::usage(
                "a BRDF in GLSL runs on a Vulkan device, and this is the processor",
                "drop --device cpu; software Vulkan will do (Mesa's lavapipe, `make setup`)",
            ));
        };
        let program = Program::new(gpu, &source, options.precision)?;
        let plain = TableRequest { ndf: "ggx".into(), visibility: "smith".into(), fresnel: None, ..request.clone() };
        // Which channels there are depends on its colours; its sizes do not.
        let sized = TableRequest { channels: None, ..plain.clone() }.resolve()?;
        let lobes = lobes(&sized, &options)?;
        let found = probe::widths(gpu, &program, &lobes, on)?;
        let pairs: Vec<(f64, f64)> = lobes.iter().copied().zip(found.iter().copied()).collect();
        let laws = probe::laws(gpu, &program, &pairs, on)?;
        let retro = probe::retro_widths(gpu, &program, &lobes, on)?;
        if laws.colored && request.table == "split-sum" {
            return Err(Error::usage(
                "the BRDF is coloured: split-sum holds one without its Fresnel term",
                "leave F out of the BRDF, or bake albedo, which has channels red, green and blue",
            ));
        }
        let fresnel = if laws.colored { Some(Fresnel::conductor([1.0; 3], [1.0; 3])?) } else { None };
        let base = TableRequest { fresnel, ..plain }.resolve()?;
        if let Some(other) = base.channels.iter().position(|c| matches!(c, Source::Companion(_))) {
            let name = base.channel_facts().nth(other).map_or("", |c| c.name);
            return Err(Error::usage(
                format!("channel '{name}' belongs to another BRDF than one's own"),
                "choose channels of the table with --channels, e.g. scale,bias",
            ));
        }
        let widths =
            pairs.iter().zip(retro).map(|((alpha, width), retro)| (alpha.to_bits(), [*width, retro])).collect();
        Ok(OwnJob { base, source, options, backend, gpu, program, laws, widths })
    }

    /// The table's axes and channels; its model is a placeholder.
    pub fn table(&self) -> &TableJob {
        &self.base
    }

    /// The source.
    pub fn source(&self) -> &OwnSource {
        &self.source
    }

    /// What was asked for.
    pub fn options(&self) -> &OwnOptions {
        &self.options
    }

    /// What was found at sampled pairs.
    pub fn laws(&self) -> &Laws {
        &self.laws
    }

    /// The rule, in words.
    pub fn rule_name(&self) -> String {
        let mean = if self.base.axes.len() == 1 { "adaptive Gauss-Kronrod 15 of sqrt(n_dot_v) x " } else { "" };
        format!("{mean}adaptive Gauss-Kronrod {NODES}x{NODES} of half vectors in {}", self.options.precision.name())
    }

    /// What the rule of a bake may be off, beyond what rounding leaves.
    pub fn goal(&self) -> f64 {
        AIM * self.options.most * self.integrals_a_channel()
    }

    /// A difference of two integrals has the errors of both.
    fn integrals_a_channel(&self) -> f64 {
        if self.base.table.facts().name == "split-sum" { 2.0 } else { 1.0 }
    }

    /// The channels of places in the table, each with its estimate; `finer` to an eighth of the rule's error at
    /// other nodes.
    pub fn values(&self, places: &[At], finer: bool, on: &mut OnProgress<'_>) -> Result<Vec<Estimated>> {
        let most = self.options.most;
        let effort = match finer {
            false => Effort { tolerance: AIM * most, most, fineness: 0 },
            true => Effort { tolerance: 0.125 * AIM * most, most, fineness: 1 },
        };
        if self.base.axes.len() == 1 {
            return self.averages(places, effort, on);
        }
        let integrals = self.integrals(places.iter().map(|at| (at.n_dot_v, at.roughness)), effort, on)?;
        Ok(integrals.iter().map(|i| self.channels(i)).collect())
    }

    fn integrals(
        &self,
        places: impl Iterator<Item = (f64, f64)>,
        effort: Effort,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<Integral>> {
        let place = |(n_dot_v, roughness): (f64, f64)| {
            let alpha = alpha_of(roughness.max(self.options.least_roughness));
            let [width, retro] = self.widths.get(&alpha.to_bits()).copied().unwrap_or([alpha, f64::INFINITY]);
            Place { n_dot_v: if n_dot_v == 0.0 { LEAST_N_DOT_V } else { n_dot_v }, alpha, width, retro }
        };
        let places: Vec<Place> = places.map(place).collect();
        integrate(self.gpu, &self.program, &places, self.laws.colored, effort, on)
    }

    /// The table's values from the integrals.
    fn channels(&self, integral: &Integral) -> Estimated {
        let [a, b, c] = integral.value;
        let value = match (self.base.table.facts().name, self.laws.colored) {
            ("split-sum", _) => [a - b, b, a, c],
            (_, true) => [(a + b + c) / 3.0, a, b, c],
            (_, false) => [a, 0.0, 0.0, 0.0],
        };
        Estimated { value, error: self.integrals_a_channel() * integral.error, least: integral.least }
    }

    /// 2 ∫ E mu dmu = ∫ E 4 x³ dx with mu = x², adaptively for each roughness.
    fn averages(&self, places: &[At], effort: Effort, on: &mut OnProgress<'_>) -> Result<Vec<Estimated>> {
        struct Panel {
            row: usize,
            from: f64,
            width: f64,
            value: [f64; MAX_CHANNELS],
            /// Between the two rules.
            differ: f64,
            /// Of what was averaged.
            error: f64,
            least: f64,
        }
        let inner = Effort { tolerance: 0.25 * effort.tolerance, ..effort };
        let parts = 2 << effort.fineness;
        let width = 1.0 / f64::from(parts);
        let fresh = |row: usize, from: f64, width: f64| Panel {
            row,
            from,
            width,
            value: [0.0; MAX_CHANNELS],
            differ: 0.0,
            error: 0.0,
            least: 0.0,
        };
        let mut pending: Vec<Panel> = (0..places.len())
            .flat_map(|row| (0..parts).map(move |i| fresh(row, f64::from(i) * width, width)))
            .collect();
        let mut done: Vec<Vec<Panel>> = places.iter().map(|_| vec![]).collect();
        let nodes = on_unit_interval();
        while !pending.is_empty() {
            let at = |panel: &Panel| {
                let (from, width, roughness) = (panel.from, panel.width, places[panel.row].roughness);
                nodes.map(|n| ((from + width * n.x).powi(2), roughness))
            };
            let integrals = self.integrals(pending.iter().flat_map(at), inner, on)?;
            for (mut panel, integrals) in pending.drain(..).zip(integrals.as_chunks::<NODES>().0) {
                let (mut kronrod, mut gauss, mut error) = ([0.0; MAX_CHANNELS], [0.0; MAX_CHANNELS], 0.0);
                panel.least = f64::INFINITY;
                for (node, integral) in nodes.iter().zip(integrals) {
                    let e = self.channels(integral);
                    let weight = panel.width * 4.0 * (panel.from + panel.width * node.x).powi(3);
                    for c in 0..MAX_CHANNELS {
                        kronrod[c] += weight * node.kronrod * e.value[c];
                        gauss[c] += weight * node.gauss * e.value[c];
                    }
                    error += weight * node.kronrod * e.error;
                    panel.least = panel.least.min(e.least);
                }
                let differ = kronrod.iter().zip(gauss).map(|(k, g)| (k - g).abs()).fold(0.0, f64::max);
                (panel.value, panel.differ, panel.error) = (kronrod, differ, error);
                done[panel.row].push(panel);
            }
            for panels in &mut done {
                let allowed = effort.tolerance * panels.iter().map(|p| p.value[0]).sum::<f64>().max(1.0);
                if panels.iter().map(|p| p.differ).sum::<f64>() <= allowed {
                    continue;
                }
                // What is wider than its share of the error stays no longer.
                let (bad, good): (Vec<Panel>, Vec<Panel>) =
                    panels.drain(..).partition(|p| p.differ > 0.5 * allowed * p.width);
                if good.len() + 2 * bad.len() > MOST_PANELS {
                    let roughness = places[bad[0].row].roughness;
                    let what = format!("the average albedo at roughness {roughness:.6} is not known to {allowed:.1e}");
                    return Err(Error::Verify { what: format!("{what} after {MOST_PANELS} panels (--max-estimate)") });
                }
                *panels = good;
                for Panel { row, from, width, .. } in bad {
                    let width = 0.5 * width;
                    pending.extend([fresh(row, from, width), fresh(row, from + width, width)]);
                }
            }
        }
        let sum = |panels: &Vec<Panel>| {
            let mut total = Estimated { least: f64::INFINITY, ..Estimated::default() };
            for panel in panels {
                total.value.iter_mut().zip(panel.value).for_each(|(sum, v)| *sum += v);
                total.error += panel.differ + panel.error;
                total.least = total.least.min(panel.least);
            }
            total
        };
        Ok(done.iter().map(sum).collect())
    }

    /// The chosen channels of a texel. What its estimate carries beyond the share of light that there is ends there.
    pub fn chosen(&self, estimated: &Estimated) -> Vec<f64> {
        let near = |value: f64| {
            let inside = value.clamp(0.0, 1.0);
            if (value - inside).abs() <= estimated.error { inside } else { value }
        };
        let value = |source: &Source| match source {
            Source::Table(c) => estimated.value[*c],
            Source::Complement(_) => 1.0 - estimated.value[0],
            Source::Derived(_) | Source::Companion(_) => unreachable!("OwnJob::new refuses both"),
        };
        self.base.channels.iter().map(value).map(near).collect()
    }

    /// Bakes the table.
    pub fn run(&self, on: &mut OnProgress<'_>) -> Result<OwnTable> {
        let (width, height) = self.base.size();
        let places: Vec<At> =
            (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).map(|[x, y]| self.base.at(x, y)).collect();
        let all = self.values(&places, false, on)?;
        let texels = all.iter().flat_map(|e| self.chosen(e)).map(|v| v as f32).collect();
        let errors: Vec<f32> = all.iter().map(|e| e.error as f32).collect();

        let mut sorted = errors.clone();
        sorted.sort_by(f32::total_cmp);
        let (worst, median) = (sorted[sorted.len() - 1], sorted[sorted.len() / 2]);
        let worst_at = places[errors.iter().position(|e| *e == worst).unwrap_or(0)];
        let albedo = match (self.base.table.facts().name, self.laws.colored) {
            ("split-sum", _) => 2..3,
            (_, true) => 1..4,
            (_, false) => 0..1,
        };
        let largest = |e: &Estimated| e.value[albedo.clone()].iter().copied().fold(0.0, f64::max);
        let brightest = (0..all.len()).max_by(|a, b| largest(&all[*a]).total_cmp(&largest(&all[*b]))).unwrap_or(0);
        let least = all.iter().map(|e| e.least).fold(f64::INFINITY, f64::min);

        let mut meta = self.meta();
        let place = |at: At| format!("n_dot_v {:.6} roughness {:.6}", at.n_dot_v, at.roughness);
        let worst_at = place(worst_at);
        meta.set("error.estimate", format!("{worst:.1e} at most, at {worst_at}; median {median:.1e}"));
        let mut warnings = vec![];
        let mut law = |key: &str, holds: bool, found: String| {
            meta.set(key, format!("{}: {found}", if holds { "holds" } else { "BROKEN" }));
            if !holds {
                warnings.push(format!("{key} does not hold: {found}"));
            }
        };
        let Laws { pairs, reciprocity, .. } = self.laws;
        law(
            "brdf.reciprocity",
            reciprocity <= ROUNDING,
            format!("f(l, v) and f(v, l) differ by {reciprocity:.1e} at most, of {pairs} pairs"),
        );
        let (e, bright) = (largest(&all[brightest]), all[brightest]);
        law(
            "brdf.energy",
            e <= 1.0 + bright.error + 1e-7,
            format!("the largest albedo is {e:.6}, at {}", place(places[brightest])),
        );
        law("brdf.positivity", least >= 0.0, format!("the least value of the BRDF at a node is {least:.3e}"));

        let shape = Shape::Table;
        let channels = self.base.channel_facts().map(|c| c.name.to_string()).collect();
        let estimates = Texture {
            shape,
            width,
            height,
            channels: vec!["estimate".into()],
            levels: vec![errors],
            meta: Meta::default(),
        };
        let texture = Texture { shape, width, height, channels, levels: vec![texels], meta };
        Ok(OwnTable { texture, estimates, warnings })
    }

    /// What the file says of itself.
    fn meta(&self) -> Meta {
        let facts = self.base.table.facts();
        let mut meta =
            self.base.meta(self.backend).without(&["ndf", "visibility", "fresnel", "source", "rule", "usage", "note"]);
        meta.set("usage", facts.usage);
        meta.set("brdf", self.source.name());
        meta.set("brdf.form", self.source.form());
        meta.set(SOURCE_SHA256, self.source.sha256());
        meta.set("precision", self.options.precision.name());
        meta.set("roughness.least", self.options.least_roughness);
        if self.base.axes.iter().any(|a| a.warp.coordinate() == Coordinate::NDotV && a.coordinates().contains(&0.0)) {
            meta.set("n_dot_v.least", format!("n_dot_v 0 is taken at {LEAST_N_DOT_V}"));
        }
        meta.set("rule", self.rule_name());
        meta.set("error.bound", format!("{:e}", self.options.most));
        meta
    }

    /// The job that made a file, from what the file says and from the source; refuses another source than the file's.
    pub fn from_meta(
        texture: &Texture,
        source: OwnSource,
        backend: &'a Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<OwnJob<'a>> {
        let get = |key: &str| {
            let missing = || Error::usage(format!("the file does not say its '{key}'"), "bake it again");
            texture.meta.get(key).ok_or_else(missing)
        };
        let stated = get(SOURCE_SHA256)?;
        if stated != source.sha256() {
            return Err(Error::usage(
                format!(
                    "'{}' is not the BRDF that was baked: its SHA-256 is {}, the file's {stated}",
                    source.path().display(),
                    source.sha256()
                ),
                format!("give the text that was called {}, unchanged", get("brdf")?),
            ));
        }
        let number = |key: &str| {
            let bad = || Error::usage(format!("the file's '{key}' is no number"), "bake it again");
            get(key)?.parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0).ok_or_else(bad)
        };
        let options = OwnOptions {
            least_roughness: number("roughness.least")?,
            most: number("error.bound")?,
            precision: Precision::parse(get("precision")?)?,
        };
        let mut named = texture.clone();
        named.meta = named.meta.without(&[SOURCE_SHA256, "fresnel"]);
        named.meta.set("ndf", "ggx");
        named.meta.set("visibility", "smith");
        let job = OwnJob::new(&TableRequest::from_meta(&named)?, source, options, backend, on)?;
        if job.base.channel_facts().map(|c| c.name).ne(texture.channels.iter().map(String::as_str)) {
            return Err(Error::usage("the file's channels are not those of the BRDF", "bake it again"));
        }
        Ok(job)
    }
}

/// The widths of a table's rows, each once.
fn lobes(job: &TableJob, options: &OwnOptions) -> Result<Vec<f64>> {
    let axis = job.axes.iter().find(|a| a.warp.coordinate() == Coordinate::Roughness);
    let roughness = axis.map_or(vec![1.0], |axis| axis.coordinates());
    let mut alphas: Vec<f64> = roughness.iter().map(|r| alpha_of(r.max(options.least_roughness))).collect();
    alphas.sort_by(f64::total_cmp);
    alphas.dedup();
    if alphas[0] == 0.0 {
        return Err(Error::usage(
            "at roughness 0 a lobe is a mirror, whose limit a BRDF in code does not state",
            "use --points centers, or --min-roughness 0.045 as a shader clamps it",
        ));
    }
    Ok(alphas)
}
