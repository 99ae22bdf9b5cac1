// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables in the layers of one array texture: what a shader reads at one place of several tables, with one binding.
//!
//! All have the same size, the same axes and the same number of channels. A file states what they share once, and the rest
//! for each layer under `layer0.`, `layer1.`, …; its own channels are red, green, blue and alpha, since layers mean different
//! things by them. Its `table` joins the tables' names by `+`, which is how a user asks for them.

use std::collections::HashSet;

use super::{Backend, TableJob, TableRequest};
use crate::error::{Error, Result};
use crate::format::Steps;
use crate::progress::{OnProgress, Progress};
use crate::texture::{Meta, Shape, Texture};
use crate::verify::table::{Extent, TableReport, check};

/// What stands between the names of the tables.
pub const JOINT: char = '+';
/// Most layers: every device has as many (Vulkan's least `maxImageArrayLayers`).
const MAX_LAYERS: usize = 256;
/// What a layer is called where a file has no names of its own for the channels.
const COMPONENTS: [&str; 4] = ["r", "g", "b", "a"];
/// Keys that hold what each layer says, one after the other, beside what each says by itself.
const JOINED: [&str; 3] = ["rule", "device", "driver"];
/// The key of the channels of a layer.
const CHANNELS: &str = "channels";

/// Tables to bake into one file.
#[derive(Clone)]
pub struct LayersJob {
    layers: Vec<TableJob>,
}

/// What a check of layers found.
pub struct LayersReport {
    /// Over all layers: channels and laws one layer after the other, the worst of what is measured, sums of what is counted.
    pub all: TableReport,
    /// Of each.
    pub layers: Vec<TableReport>,
}

impl LayersJob {
    /// A layer for each request, from 2.
    pub fn new(requests: &[TableRequest]) -> Result<LayersJob> {
        LayersJob::of(requests.iter().map(TableRequest::resolve).collect::<Result<_>>()?)
    }

    fn of(layers: Vec<TableJob>) -> Result<LayersJob> {
        if !(2..=MAX_LAYERS).contains(&layers.len()) {
            return Err(Error::usage(
                format!("an array of {} tables cannot be baked", layers.len()),
                format!("join the names of 2 to {MAX_LAYERS} by {JOINT}"),
            ));
        }
        let (first, rest) = (&layers[0], &layers[1..]);
        let name = |job: &TableJob| job.table.facts().name;
        for other in rest {
            if other.axes != first.axes {
                return Err(Error::usage(
                    format!("{} and {} have different axes or sizes", name(first), name(other)),
                    "the layers of an array share them: bake two files",
                ));
            }
            let (n, m) = (first.channels.len(), other.channels.len());
            if n != m {
                return Err(Error::usage(
                    format!("{} has {n} channels and {} has {m}", name(first), name(other)),
                    format!("the layers of an array have as many: give --channels A,B{JOINT}C,D"),
                ));
            }
        }
        Ok(LayersJob { layers })
    }

    /// The tables, first layer first.
    pub fn layers(&self) -> &[TableJob] {
        &self.layers
    }

    /// An array texture.
    pub fn shape(&self) -> Shape {
        Shape::Array { layers: self.layers.len() as u32 }
    }

    /// Their names, joined.
    pub fn name(&self) -> String {
        let names: Vec<&str> = self.layers.iter().map(|job| job.table.facts().name).collect();
        names.join(&JOINT.to_string())
    }

    /// The rules of all layers, in words.
    pub fn rule_name(&self) -> String {
        joined(self.layers.iter().map(TableJob::rule_name))
    }

    /// Bakes all layers, each where `backends` says; the meta says everything but the measured error.
    pub fn run(&self, backends: &[&Backend], on: &mut OnProgress<'_>) -> Result<Texture> {
        let share = self.layers.len() as f64;
        let (mut texels, mut metas) = (vec![], vec![]);
        for (i, (job, backend)) in self.layers.iter().zip(backends).enumerate() {
            let layer = job.run(backend, &mut |p| on(Progress { done: (i as f64 + p.done) / share, ..p }))?;
            let Texture { levels, mut meta, channels, .. } = layer;
            meta.set(CHANNELS, channels.join(","));
            texels.extend(levels.into_iter().flatten());
            metas.push(meta);
        }
        let (width, height) = self.layers[0].size();
        let channels = COMPONENTS[..self.layers[0].channels.len()].iter().map(|c| c.to_string()).collect();
        let meta = self.meta(&metas);
        Ok(Texture { shape: self.shape(), width, height, channels, levels: vec![texels], meta })
    }

    /// What all layers say, and what each says.
    fn meta(&self, layers: &[Meta]) -> Meta {
        let mut meta = Meta::default();
        meta.set("table", self.name());
        let shared = |key: &str, value: &str| layers.iter().all(|layer| layer.get(key) == Some(value));
        for (key, value) in layers[0].iter().filter(|(key, value)| shared(key, value)) {
            meta.set(key, value);
        }
        for key in JOINED {
            meta.set(key, joined(layers.iter().filter_map(|layer| layer.get(key)).map(String::from)));
        }
        for (i, layer) in layers.iter().enumerate() {
            for (key, value) in layer.iter().filter(|(key, value)| !shared(key, value)) {
                meta.set(&format!("{}{key}", prefix(i)), value);
            }
        }
        meta
    }

    /// A layer as a table.
    pub fn layer(&self, texture: &Texture, i: usize) -> Texture {
        let job = &self.layers[i];
        let (width, height) = job.size();
        let len = width as usize * height as usize * job.channels.len();
        let levels = vec![texture.levels[0][i * len..][..len].to_vec()];
        let channels = job.channel_facts().map(|c| c.name.to_string()).collect();
        Texture { shape: Shape::Table, width, height, channels, levels, meta: of_layer(&texture.meta, i) }
    }

    /// Checks every layer as a table.
    pub fn check(
        &self,
        texture: &Texture,
        stored: Option<Steps>,
        extent: Extent,
        on: &mut OnProgress<'_>,
    ) -> Result<LayersReport> {
        let mut layers = vec![];
        for (i, job) in self.layers.iter().enumerate() {
            let mut report = check(job, &self.layer(texture, i), stored, extent, on)?;
            let place = format!("layer {i}, {}: ", job.table.facts().name);
            report.failures.iter_mut().for_each(|failure| failure.insert_str(0, &place));
            report.laws.iter_mut().filter(|law| !law.holds).for_each(|law| law.detail.insert_str(0, &place));
            layers.push(report);
        }
        Ok(LayersReport { all: merged(&layers), layers })
    }

    /// The jobs that made a file, from what the file says; `None` where its layers are no tables of their own.
    pub fn from_meta(texture: &Texture) -> Result<Option<LayersJob>> {
        let Some(layers) = texture.shape.slices().filter(|_| are_stated(&texture.meta)) else { return Ok(None) };
        if layers as usize > MAX_LAYERS {
            return Err(Error::usage(format!("{layers} layers are no tables"), format!("at most {MAX_LAYERS} are")));
        }
        // One after the other: together they could be 256 copies of what the file says.
        let layer = |i: usize| {
            let meta = of_layer(&texture.meta, i);
            let channels = meta.get(CHANNELS).unwrap_or_default().split(',').map(String::from).collect();
            TableJob::from_meta(&Texture { shape: Shape::Table, channels, levels: vec![], meta, ..*texture })
        };
        let job = LayersJob::of((0..layers as usize).map(layer).collect::<Result<_>>()?)?;
        if job.layers[0].channels.len() != texture.channels.len() {
            return Err(Error::usage("its layers name more or fewer channels than it has", "bake it again"));
        }
        Ok(Some(job))
    }
}

/// Does a file say what each of its layers is?
pub(super) fn are_stated(meta: &Meta) -> bool {
    meta.get(&format!("{}table", prefix(0))).is_some() || meta.get("table").is_some_and(|name| name.contains(JOINT))
}

/// What begins the keys of a layer.
fn prefix(layer: usize) -> String {
    format!("layer{layer}.")
}

/// What a file says of a layer: what all share, and what this one says.
fn of_layer(meta: &Meta, layer: usize) -> Meta {
    let is_of_some_layer = |key: &str| {
        let number = key.strip_prefix("layer").and_then(|rest| rest.split_once('.')).map(|(number, _)| number);
        number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
    };
    let prefix = prefix(layer);
    let own = || meta.iter().filter_map(|(key, value)| Some((key.strip_prefix(&prefix)?, value)));
    let names: HashSet<&str> = own().map(|(key, _)| key).collect();
    let shared = meta.iter().filter(|(key, _)| !is_of_some_layer(key) && !names.contains(key));
    Meta::of_distinct(shared.chain(own()))
}

/// Texts in order, each once where neighbours are the same.
fn joined(texts: impl Iterator<Item = String>) -> String {
    let mut texts: Vec<String> = texts.collect();
    texts.dedup();
    texts.join(", then ")
}

/// One report of many.
fn merged(reports: &[TableReport]) -> TableReport {
    let worst = |of: fn(&TableReport) -> f64| {
        // NaN is the worst of all.
        reports.iter().map(of).max_by(f64::total_cmp).expect("there is a layer")
    };
    TableReport {
        channels: reports.iter().flat_map(|r| r.channels.clone()).collect(),
        truth_texels: reports.iter().map(|r| r.truth_texels).sum(),
        truth_error: worst(|r| r.truth_error),
        twin_texels: reports.iter().map(|r| r.twin_texels).sum(),
        twin_worst: worst(|r| r.twin_worst),
        twin_median: worst(|r| r.twin_median),
        bound: reports.iter().map(|r| r.bound).fold(f64::INFINITY, f64::min),
        certified_worst: worst(|r| r.certified_worst),
        certified_median: worst(|r| r.certified_median),
        laws: reports.iter().flat_map(|r| r.laws.clone()).collect(),
        failures: reports.iter().flat_map(|r| r.failures.clone()).collect(),
    }
}
