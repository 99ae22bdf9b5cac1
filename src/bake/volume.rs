//! Tables over the refractive index as well: a slice of the table for each index. Over n·v, roughness and index a file
//! holds a 3-D texture; averages over roughness and index are a table whose rows are the indices.
//!
//! Where the index is 1 there is no interface: a slice says that nothing is reflected and all is transmitted.

use std::fmt;

use super::{Backend, RuleChoice, TableJob, TableRequest};
use crate::axis::Points;
use crate::error::{Error, Result};
use crate::progress::{OnProgress, Progress};
use crate::term::fresnel::{Fresnel, IOR_RANGE};
use crate::texture::{Shape, Texture};
use crate::verify::table::{Extent, TableReport, check};

/// Most slices of a volume.
pub const MAX_DEPTH: u32 = 256;
/// Slices that a spot check looks at: ends and between; of averages, whose truth costs most, two between.
const SPOT_SLICES: u32 = 4;

/// Which refractive index lies at a position along the third axis. The index is that behind the surface over that before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IorMap {
    /// Evenly from one index to another, both on the same side of 1, or 1.
    Linear([f64; 2]),
    /// index = (1 + t²)/(1 − t²), so that F0 = t⁴; t is at most 0.99 (Blender Cycles).
    FromF0,
    /// One over that: the same interfaces from inside.
    InverseFromF0,
    /// From 1/2.5 to 1 in the first half, evenly in one over the index, and evenly from 1 to 2.5 in the second (OpenPBR).
    Openpbr,
}

/// Names of the maps without numbers.
const NAMES: [(&str, IorMap); 3] =
    [("ior_from_f0", IorMap::FromF0), ("inverse_ior_from_f0", IorMap::InverseFromF0), ("openpbr_ior", IorMap::Openpbr)];
const MOST_OF_F0: f64 = 0.99;
const MOST_OF_OPENPBR: f64 = 2.5;
/// What an axis evenly along the index begins with.
const LINEAR: &str = "ior=";

impl IorMap {
    /// The map that the name of an axis means; `None` for the name of another axis.
    pub fn parse(name: &str) -> Option<Result<IorMap>> {
        if let Some((_, map)) = NAMES.iter().find(|(n, _)| *n == name) {
            return Some(Ok(*map));
        }
        let ends = name.strip_prefix(LINEAR)?;
        let bad = || {
            let [least, most] = IOR_RANGE;
            Error::usage(
                format!("'{name}' is no axis of refractive indices"),
                format!("write ior=FROM/TO with two indices from {least} to {most}, both at least 1 or both at most 1"),
            )
        };
        let numbers =
            ends.split('/').map(|n| n.parse::<f64>().ok().filter(|n| (IOR_RANGE[0]..=IOR_RANGE[1]).contains(n)));
        let numbers: Option<Vec<f64>> = numbers.collect();
        Some(match numbers.as_deref() {
            Some([from, to]) if from != to && (from - 1.0) * (to - 1.0) >= 0.0 => Ok(IorMap::Linear([*from, *to])),
            _ => Err(bad()),
        })
    }

    /// The index of slice `i` of `len`.
    pub fn ior(self, i: u32, len: u32, points: Points) -> f64 {
        let position = |i: u32, len: u32| match points {
            Points::Centers => (f64::from(i) + 0.5) / f64::from(len),
            Points::Edges => f64::from(i) / f64::from(len - 1),
        };
        match self {
            IorMap::Linear([from, to]) => from + (to - from) * position(i, len),
            IorMap::FromF0 => {
                let f0_root = position(i, len).min(MOST_OF_F0).powi(2);
                (1.0 + f0_root) / (1.0 - f0_root)
            }
            IorMap::InverseFromF0 => 1.0 / IorMap::FromF0.ior(i, len, points),
            IorMap::Openpbr => {
                let half = len / 2;
                let above = |i: u32| 1.0 + (MOST_OF_OPENPBR - 1.0) * position(i, half);
                if i < half { 1.0 / above(half - 1 - i) } else { above(i - half) }
            }
        }
    }
}

/// The name of the axis, which [`IorMap::parse`] reads back.
impl fmt::Display for IorMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            IorMap::Linear([from, to]) => write!(f, "{LINEAR}{from}/{to}"),
            named => f.write_str(NAMES.iter().find(|(_, map)| map == named).map_or("", |(name, _)| name)),
        }
    }
}

/// A table over the refractive index as well.
#[derive(Clone)]
pub struct VolumeJob {
    slices: Vec<TableJob>,
    iors: Vec<f64>,
    map: IorMap,
}

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
    /// A request whose last axis is a map of the index, of `depth` slices; the request's own size is that of a slice.
    pub fn new(request: &TableRequest, map: IorMap, depth: u32) -> Result<VolumeJob> {
        if !request.table.starts_with("glass") {
            return Err(Error::usage(
                format!("{} has no axis of refractive indices", request.table),
                "bake glass or glass-average, or one table an index with --ior",
            ));
        }
        if request.rule != RuleChoice::Direct {
            return Err(Error::usage(
                "tables over the index are not expanded: their slices are small",
                "drop --rule, or bake one table an index with --ior",
            ));
        }
        if request.fresnel.is_some() {
            return Err(Error::usage("an index beside an axis of indices", "drop --ior, or the axis"));
        }
        let least = if request.points == Points::Edges { 2 } else { 1 };
        let halves = if map == IorMap::Openpbr { 2 } else { 1 };
        if !(halves * least..=MAX_DEPTH).contains(&depth) || !depth.is_multiple_of(halves) {
            return Err(Error::usage(
                format!("{depth} slices along {map} cannot be baked"),
                format!(
                    "give from {} to {MAX_DEPTH} slices{}",
                    halves * least,
                    if halves == 2 { ", an even number" } else { "" }
                ),
            ));
        }
        let iors: Vec<f64> = (0..depth).map(|i| map.ior(i, depth, request.points)).collect();
        let slice = |ior: &f64| TableRequest { fresnel: Some(Fresnel::interface(*ior)), ..request.clone() }.resolve();
        Ok(VolumeJob { slices: iors.iter().map(slice).collect::<Result<_>>()?, iors, map })
    }

    /// One job for each index.
    pub fn slices(&self) -> &[TableJob] {
        &self.slices
    }

    /// The indices of the slices.
    pub fn iors(&self) -> &[f64] {
        &self.iors
    }

    /// A 3-D texture, or a table of averages with a row for each index.
    pub fn shape(&self) -> Shape {
        match self.slices[0].axes.len() {
            1 => Shape::Table,
            _ => Shape::Volume { depth: self.slices.len() as u32 },
        }
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
        texture.meta.set("axes", format!("{axes},{}", self.map));
        let order = texture.meta.get("order").unwrap_or_default();
        texture.meta.set("order", format!("{order},ascending"));
        let (first, last) = (self.iors[0], self.iors[self.iors.len() - 1]);
        let ends = format!("the first slice is index {first:.6}, the last {last:.6}; an index of 1 is no interface");
        texture.meta.set("slices", ends);
        texture.meta.set("fresnel", "dielectric");
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
            let place = format!("slice {i}, index {:.4}: ", self.iors[*i as usize]);
            report.failures.iter_mut().for_each(|failure| failure.insert_str(0, &place));
            report.laws.iter_mut().filter(|law| !law.holds).for_each(|law| law.detail.insert_str(0, &place));
            reports.push(report);
        }
        Ok(merged(reports, &chosen))
    }

    /// The job that made a file, from what the file says; `None` where it has no axis of indices.
    pub fn from_meta(texture: &Texture) -> Result<Option<VolumeJob>> {
        let axes = texture.meta.get("axes").unwrap_or_default();
        let (rest, last) = axes.rsplit_once(',').unwrap_or(("", axes));
        let Some(map) = IorMap::parse(last).transpose()? else {
            return match texture.shape {
                Shape::Volume { .. } => Err(Error::usage(
                    "the file does not say what its third axis is",
                    "only files that brdf-baker wrote carry their model",
                )),
                _ => Ok(None),
            };
        };
        let depth = match texture.shape {
            Shape::Volume { depth } => depth,
            _ => texture.height,
        };
        let mut of_slice = Texture { shape: Shape::Table, levels: vec![], ..texture.clone() };
        if texture.shape == Shape::Table {
            of_slice.height = 1;
        }
        of_slice.meta.set("axes", rest);
        let order = of_slice.meta.get("order").unwrap_or_default().to_string();
        of_slice.meta.set("order", order.rsplit_once(',').map_or("", |(rest, _)| rest));
        let request = TableRequest { fresnel: None, ..TableRequest::from_meta(&of_slice)? };
        VolumeJob::new(&request, map, depth).map(Some)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_reach_their_ends_and_are_read_back() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} instead of {b}");
        let (edges, n) = (Points::Edges, 16);
        near(IorMap::FromF0.ior(0, n, edges), 1.0);
        // t = 10/15: F0 = t⁴.
        let ior = IorMap::FromF0.ior(10, n, edges);
        near(((ior - 1.0) / (ior + 1.0)).powi(2), (2.0f64 / 3.0).powi(4));
        near(IorMap::FromF0.ior(15, n, edges), (1.0 + 0.9801) / (1.0 - 0.9801));
        near(IorMap::InverseFromF0.ior(10, n, edges) * ior, 1.0);
        for (i, expected) in [(0, 0.4), (15, 1.0), (16, 1.0), (31, 2.5), (1, 1.0 / 2.4), (17, 1.1)] {
            near(IorMap::Openpbr.ior(i, 32, edges), expected);
        }
        let linear = IorMap::Linear([1.1, 2.1]);
        near(linear.ior(0, 4, edges), 1.1);
        near(linear.ior(0, 4, Points::Centers), 1.225);
        for map in [linear, IorMap::FromF0, IorMap::InverseFromF0, IorMap::Openpbr] {
            assert_eq!(IorMap::parse(&map.to_string()).expect("an index axis").expect("its own name"), map);
        }
        assert!(IorMap::parse("roughness").is_none());
        for bad in ["ior=", "ior=1.5", "ior=0.5/2", "ior=1.5/1.5", "ior=1.5/x", "ior=1.5/9"] {
            assert!(IorMap::parse(bad).expect("an index axis").is_err(), "{bad}");
        }
    }
}
