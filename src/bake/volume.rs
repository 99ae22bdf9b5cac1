// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables over a number of the Fresnel term or of the distribution as well ([`SliceAxis`]): a slice of the table for each.
//! Over n·v, roughness and that number a file holds a 3-D texture, or for engines without them an array whose layers are the
//! slices; a table over one of the two and that number is flat, with a row for each.
//!
//! Where a refractive index is 1 there is no interface: a slice says that nothing is reflected and all is transmitted.

use super::slice_axis::{Kind, SliceAxis};
use super::{Backend, RuleChoice, TableJob, TableRequest};
use crate::axis::Points;
use crate::error::{Error, Result};
use crate::progress::{OnProgress, Progress};
use crate::texture::{Shape, Texture};
use crate::verify::table::{Extent, TableReport, check};

/// Most slices of a volume.
pub const MAX_DEPTH: u32 = 256;
/// Slices that a spot check looks at: ends and between; of averages, whose truth costs most, two between.
const SPOT_SLICES: u32 = 4;

/// How a file holds the slices of a table over three axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stacking {
    /// A 3-D texture, which a sampler filters between slices too.
    #[default]
    Volume,
    /// A 2-D array: a shader reads two layers and mixes them itself.
    Array,
}

impl Stacking {
    /// The one with this name.
    pub fn parse(name: &str) -> Result<Stacking> {
        match name {
            "volume" => Ok(Stacking::Volume),
            "array" => Ok(Stacking::Array),
            _ => Err(Error::usage(
                format!("slices are not stored as '{name}'"),
                "give volume, a 3-D texture, or array, the layers of a 2-D one",
            )),
        }
    }
}

/// A table over slices.
#[derive(Clone)]
pub struct VolumeJob {
    slices: Vec<TableJob>,
    values: Vec<f64>,
    axis: SliceAxis,
    stacking: Stacking,
}

/// The key of the numbers of all slices.
const VALUES: &str = "slices.values";

/// What a check of a volume found.
pub struct VolumeReport {
    /// Over all slices that were looked at: the worst, and means where a mean is meant; medians are the largest of any
    /// slice's.
    pub all: TableReport,
    /// For each channel the slice of its largest error.
    pub worst_slices: Vec<u32>,
    /// How many slices were looked at.
    pub slices: u32,
}

impl VolumeJob {
    /// A request whose last axis runs over `depth` slices; the request's own size is that of a slice.
    pub fn new(request: &TableRequest, axis: SliceAxis, depth: u32) -> Result<VolumeJob> {
        let facts = super::table(&request.table)?.facts();
        let Some((_, at_number)) = facts.slices.iter().find(|(kind, _)| *kind == axis.kind()) else {
            let known: Vec<&str> = facts.slices.iter().map(|(kind, _)| kind.about()).collect();
            let help = if known.is_empty() {
                "drop the axis".into()
            } else {
                format!("it has one of {}", known.join(" or of "))
            };
            return Err(Error::usage(format!("{} has no axis of {}", facts.name, axis.kind().about()), help));
        };
        if request.rule != RuleChoice::Direct {
            return Err(Error::usage(
                "tables over slices are not expanded: their slices are small",
                "drop --rule, or bake the slices one by one",
            ));
        }
        let least = if request.points == Points::Edges { 2 } else { 1 };
        let halves = if axis == SliceAxis::Openpbr { 2 } else { 1 };
        if !(halves * least..=MAX_DEPTH).contains(&depth) || !depth.is_multiple_of(halves) {
            return Err(Error::usage(
                format!("{depth} slices along {axis} cannot be baked"),
                format!(
                    "give from {} to {MAX_DEPTH} slices{}",
                    halves * least,
                    if halves == 2 { ", an even number" } else { "" }
                ),
            ));
        }
        let values: Vec<f64> = (0..depth).map(|i| axis.value(i, depth, request.points)).collect();
        let slice = |value: &f64| at_number(*value, request.clone())?.resolve();
        let slices = values.iter().map(slice).collect::<Result<_>>()?;
        Ok(VolumeJob { slices, values, axis, stacking: Stacking::Volume })
    }

    /// The same table with its slices stored in another way. A flat one has none, and an array has two layers or more.
    pub fn stacked(self, stacking: Stacking) -> Result<VolumeJob> {
        if stacking == Stacking::Array && (self.is_flat() || self.slices.len() < 2) {
            let what = match self.is_flat() {
                true => "a table of rows over an axis of slices is flat: it is no array",
                false => "an array has at least two layers, not one",
            };
            return Err(Error::usage(what, "drop --slices"));
        }
        Ok(VolumeJob { stacking, ..self })
    }

    /// One job for each slice.
    pub fn slices(&self) -> &[TableJob] {
        &self.slices
    }

    /// The numbers of the slices.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// What runs over the slices.
    pub fn axis(&self) -> SliceAxis {
        self.axis
    }

    /// A 3-D texture or an array, or a table with a row for each slice.
    pub fn shape(&self) -> Shape {
        let slices = self.slices.len() as u32;
        match self.stacking {
            _ if self.is_flat() => Shape::Table,
            Stacking::Volume => Shape::Volume { depth: slices },
            Stacking::Array => Shape::Array { layers: slices },
        }
    }

    /// Has it a row for each slice?
    fn is_flat(&self) -> bool {
        self.slices[0].axes.len() == 1
    }

    /// The numbers of all slices, as a file states them.
    fn values_text(&self) -> String {
        self.values.iter().map(|value| format!("{value:.7}")).collect::<Vec<_>>().join(" ")
    }

    /// What is wrong with the numbers that a file states of its slices, if anything is. Files of earlier versions state none.
    pub fn misstated(&self, texture: &Texture) -> Option<String> {
        let (stated, found) = (texture.meta.get(VALUES)?, self.values_text());
        (stated != found).then(|| format!("its {VALUES} are '{stated}', but those of {} are '{found}'", self.axis))
    }

    /// The rules of all slices, in words.
    pub fn rule_name(&self) -> String {
        let mut names: Vec<String> = self.slices.iter().map(TableJob::rule_name).collect();
        names.dedup();
        names.join(", then ")
    }

    /// Bakes all slices; the meta says everything but the measured error.
    pub fn run(&self, backend: &Backend, on: &mut OnProgress<'_>) -> Result<Texture> {
        let mut out: Option<Texture> = None;
        for (i, job) in self.slices.iter().enumerate() {
            let share = self.slices.len() as f64;
            let slice = job.run(backend, &mut |p| on(Progress { done: (i as f64 + p.done) / share, ..p }))?;
            match &mut out {
                None => out = Some(slice),
                Some(all) => all.levels[0].extend_from_slice(&slice.levels[0]),
            }
        }
        let mut texture = out.expect("there is a slice");
        texture.shape = self.shape();
        if texture.shape == Shape::Table {
            texture.height = self.slices.len() as u32;
        }
        let axes = texture.meta.get("axes").unwrap_or_default();
        texture.meta.set("axes", format!("{axes},{}", self.axis));
        let order = texture.meta.get("order").unwrap_or_default();
        texture.meta.set("order", format!("{order},ascending"));
        let (first, last) = (self.values[0], self.values[self.values.len() - 1]);
        let (name, note) = (self.axis.kind().name(), self.axis.kind().note());
        texture.meta.set("slices", format!("the first slice is {name} {first:.6}, the last {last:.6}{note}"));
        texture.meta.set(VALUES, self.values_text());
        texture.meta.set("fresnel", self.axis.kind().term(&self.slices[0].model.fresnel));
        if self.axis.kind() == Kind::Azimuth {
            texture.meta.set("ndf", without_azimuth(&self.slices[0].model.ndf.to_string()));
        }
        texture.meta.set("rule", self.rule_name());
        Ok(texture)
    }

    /// The texels of a slice.
    fn slice(&self, texture: &Texture, i: usize) -> Texture {
        let job = &self.slices[i];
        let (width, height) = job.size();
        let len = width as usize * height as usize * texture.channels.len();
        let levels = vec![texture.levels[0][i * len..(i + 1) * len].to_vec()];
        let (channels, meta) = (texture.channels.clone(), texture.meta.clone());
        Texture { shape: Shape::Table, width, height, channels, levels, meta }
    }

    /// Checks the slices as tables, for a spot check a few of them.
    pub fn check(
        &self,
        texture: &Texture,
        stored: Option<crate::format::Steps>,
        extent: Extent,
        on: &mut OnProgress<'_>,
    ) -> Result<VolumeReport> {
        let depth = self.slices.len() as u32;
        let chosen: Vec<u32> = match extent {
            Extent::Spot => {
                let of = SPOT_SLICES.min(depth);
                let spread = (0..of).map(|i| i * (depth - 1) / (of - 1).max(1));
                let mut list: Vec<u32> = spread.collect();
                if self.shape() == Shape::Table && list.len() > 2 {
                    list = list[1..list.len() - 1].to_vec();
                }
                list.dedup();
                list
            }
            _ => (0..depth).collect(),
        };
        let mut reports = vec![];
        for i in &chosen {
            let job = &self.slices[*i as usize];
            let mut report = check(job, &self.slice(texture, *i as usize), stored, extent, on)?;
            let place = format!("slice {i}, {} {:.4}: ", self.axis.kind().name(), self.values[*i as usize]);
            report.failures.iter_mut().for_each(|failure| failure.insert_str(0, &place));
            report.laws.iter_mut().filter(|law| !law.holds).for_each(|law| law.detail.insert_str(0, &place));
            reports.push(report);
        }
        Ok(merged(reports, &chosen))
    }

    /// The job that made a file, from what the file says; `None` where it has no axis over slices.
    pub fn from_meta(texture: &Texture) -> Result<Option<VolumeJob>> {
        let axes = texture.meta.get("axes").unwrap_or_default();
        let (rest, last) = axes.rsplit_once(',').unwrap_or(("", axes));
        let Some(axis) = SliceAxis::parse(last).transpose()? else {
            return match texture.shape.slices() {
                Some(_) => Err(Error::usage(
                    "the file does not say what its third axis is",
                    "only files that brdf-baker wrote carry their model",
                )),
                None => Ok(None),
            };
        };
        let depth = texture.shape.slices().unwrap_or(texture.height);
        let stacking = match texture.shape {
            Shape::Array { .. } => Stacking::Array,
            Shape::Table | Shape::Map | Shape::Cube | Shape::Volume { .. } => Stacking::Volume,
        };
        let mut of_slice = Texture { shape: Shape::Table, levels: vec![], ..texture.clone() };
        if texture.shape == Shape::Table {
            of_slice.height = 1;
        }
        of_slice.meta.set("axes", rest);
        let order = of_slice.meta.get("order").unwrap_or_default().to_string();
        of_slice.meta.set("order", order.rsplit_once(',').map_or("", |(rest, _)| rest));
        VolumeJob::new(&TableRequest::from_meta(&of_slice)?, axis, depth)?.stacked(stacking).map(Some)
    }
}

/// A distribution's text without the number that runs over the slices.
fn without_azimuth(ndf: &str) -> &str {
    ndf.split(",azimuth=").next().unwrap_or(ndf)
}

/// One report of many.
fn merged(reports: Vec<TableReport>, chosen: &[u32]) -> VolumeReport {
    let slices = reports.len() as u32;
    let mut reports = reports.into_iter();
    let mut all = reports.next().expect("a slice was checked");
    let mut worst_slices = vec![chosen[0]; all.channels.len()];
    let (mut squares, mut rounded): (Vec<f64>, Vec<f64>) =
        all.channels.iter().map(|c| (c.rms * c.rms, c.correctly_rounded)).unzip();
    let greater = |a: f64, b: f64| if a.total_cmp(&b).is_ge() { a } else { b };
    for (report, slice) in reports.zip(&chosen[1..]) {
        for (c, (to, from)) in all.channels.iter_mut().zip(&report.channels).enumerate() {
            squares[c] += from.rms * from.rms;
            rounded[c] += from.correctly_rounded;
            if from.worst.total_cmp(&to.worst).is_gt() {
                (to.worst, to.worst_texel, worst_slices[c]) = (from.worst, from.worst_texel, *slice);
            }
            to.median = greater(to.median, from.median);
        }
        all.truth_texels += report.truth_texels;
        all.truth_error = greater(all.truth_error, report.truth_error);
        all.twin_texels += report.twin_texels;
        all.twin_worst = greater(all.twin_worst, report.twin_worst);
        all.twin_median = greater(all.twin_median, report.twin_median);
        all.bound = all.bound.min(report.bound);
        all.certified_worst = greater(all.certified_worst, report.certified_worst);
        all.certified_median = greater(all.certified_median, report.certified_median);
        for (to, from) in all.laws.iter_mut().zip(report.laws) {
            if to.holds && !from.holds {
                *to = from;
            }
        }
        all.failures.extend(report.failures);
    }
    for (c, channel) in all.channels.iter_mut().enumerate() {
        channel.rms = (squares[c] / f64::from(slices)).sqrt();
        channel.correctly_rounded = rounded[c] / f64::from(slices);
    }
    VolumeReport { all, worst_slices, slices }
}
