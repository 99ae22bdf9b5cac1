// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is baked: one file per table or filter, their registry, and the way from a request to texels.

mod albedo;
pub mod atlas;
mod average_albedo;
pub mod backend;
pub mod companion;
mod diffuse;
mod expanded;
mod glass;
mod glass_average;
pub mod grid;
pub mod groups;
mod kulla_conty;
pub mod layers;
pub mod ltc;
mod ltc_magnitude;
mod ltc_sheen;
mod ltc_sheen_volume;
pub mod model;
pub mod own;
pub mod quality;
pub mod roughness_law;
mod schlick_weight;
mod skin;
pub mod slice_axis;
pub(crate) mod slices;
pub mod specular;
pub mod specular_gpu;
pub mod specular_walk;
mod split_sum;
mod stored;
mod turquin;
pub mod volume;

pub use backend::Backend;
pub use expanded::RuleChoice;
pub use layers::LayersJob;
pub use model::Model;
pub use roughness_law::RoughnessLaw;
pub use slice_axis::SliceAxis;
pub use stored::Stored;
pub use volume::VolumeJob;

use rayon::prelude::*;

use self::companion::{COMPANIONS, Companion};
use self::expanded::Settled;
use self::slice_axis::Kind;
use crate::axis::{Axis, Coordinate, Points, Warp};
use crate::error::{Error, Result, nearest};
use crate::format::{Encoding, Fingerprint, Steps};
use crate::progress::{OnProgress, watched};
use crate::quadrature::adaptive::Estimate;
use crate::term::fresnel::{Fresnel, WEIGHTS};
use crate::texture::{Meta, Shape, Texture};
use crate::verify::truth;

/// Most channels that a table can compute.
pub const MAX_CHANNELS: usize = WEIGHTS;

/// One value per channel of a table, in the order of its [`Facts::channels`]; unused ones are 0.
pub type Values = [f64; MAX_CHANNELS];

/// Most rows that a table may be shifted by.
pub const MAX_ROW_SHIFT: u32 = 1;

/// Largest side of a table in texels.
pub const MAX_SIZE: u32 = 8192;

/// Where in a table: the coordinates of one texel. A table without n·v ignores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At {
    /// Cosine between normal and viewer, in [0, 1]; of skin between normal and light, in [−1, 1].
    pub n_dot_v: f64,
    /// Perceptual roughness, in [0, 1]; of skin the curvature in 1/mm.
    pub roughness: f64,
}

/// What a channel holds.
pub struct Channel {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub meaning: &'static str,
    /// Least and greatest value.
    pub range: [f32; 2],
}

/// How far a baked `f32` may be from the truth: absolutely up to 1, relative to the value beyond.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Bound of every texel whose coordinates are at least 1/1024 (or exactly 0, the limit).
    pub worst: f64,
    /// Bound of the median over the checked texels.
    pub median: f64,
    /// Bound of texels nearer to 0 than 1/1024.
    pub near_zero: f64,
    /// The measurement that the bounds rest on.
    pub why: &'static str,
}

impl Tolerance {
    /// The bound that holds at a place in the table.
    pub fn at(&self, at: At) -> f64 {
        let near_zero = |x: f64| x > 0.0 && x < 1.0 / 1024.0;
        if near_zero(at.n_dot_v) || near_zero(at.roughness) { self.near_zero } else { self.worst }
    }
}

/// The request for a slice, from its number and the request for all.
pub type AtNumber = fn(f64, TableRequest) -> Result<TableRequest>;

/// What a table is.
pub struct Facts {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// Paper and equation.
    pub source: &'static str,
    /// How a shader uses the channels.
    pub usage: &'static str,
    /// All channels that the table can hold.
    pub channels: fn(&Fresnel) -> &'static [Channel],
    /// What 1 less its first channel is, where that means something.
    pub complement: Option<&'static Channel>,
    /// The channels that it holds unless told otherwise.
    pub default_channels: fn(&Fresnel) -> &'static [&'static str],
    /// The Fresnel term unless told otherwise.
    pub fresnel: Fresnel,
    /// Its axes, x first, unless told otherwise.
    pub axes: &'static [Coordinate],
    /// The axes over slices that it may have, and the request for a slice at a number of each.
    pub slices: &'static [(Kind, AtNumber)],
    /// The rule and its number of nodes, for the file's certificate.
    pub rule: fn(&Model) -> String,
    /// Bounds of its error.
    pub tolerance: Tolerance,
}

/// What a user means who says nothing else of a table.
#[derive(Clone, Copy, Debug)]
pub struct Usual {
    /// Width and height in texels.
    pub size: (u32, u32),
    /// What runs along its axes; `None` is each coordinate itself.
    pub axes: Option<&'static [Warp]>,
    /// Where in its texel a value is taken.
    pub points: Points,
    /// Names of the distribution and of the geometry term; `None` for a table that has its own lobe.
    pub model: Option<[&'static str; 2]>,
    /// Its texels are stored as single floats where the container has them: halves are too coarse.
    pub single: bool,
    /// No device computes it.
    pub on_processor: bool,
    /// Its values are the least of a function that is flat there: equally good fits may differ in them.
    pub is_fit: bool,
}

impl Usual {
    /// 256 × 256 texels, centers, GGX with height-correlated Smith.
    pub const TABLE: Usual = Usual {
        size: (256, 256),
        axes: None,
        points: Points::Centers,
        model: Some(["ggx", "smith"]),
        single: false,
        on_processor: false,
        is_fit: false,
    };
}

/// A channel that follows from the others of its texel.
pub struct Derived {
    /// The channel.
    pub channel: Channel,
    /// Bounds of its error.
    pub tolerance: Tolerance,
    /// Its value from those of the table.
    pub rule: fn(&Model, At, &Values) -> f64,
    /// The same by other means, where there are some.
    pub truth: fn(&Model, At, &Values) -> Estimate<1>,
}

/// What must hold of a texel as a whole.
pub struct TexelLaw {
    /// What, of a texel, as a reader would say it.
    pub statement: &'static str,
    /// What is wrong with the values of a texel, each of which may be rounded by so much; `None` where nothing is.
    pub broken: fn(&Model, At, found: &Values, rounding: &Values) -> Option<String>,
}

/// A table that can be baked.
pub trait Table: Sync {
    /// What it is.
    fn facts(&self) -> &'static Facts;
    /// The request that its name alone stands for.
    fn usual(&self) -> Usual {
        Usual::TABLE
    }
    /// Bounds of the error of one of its values for a model.
    fn tolerance(&self, model: &Model, _value: usize) -> Tolerance {
        model.tolerance(&self.facts().tolerance)
    }
    /// Refuses a limit that it does not have: at n·v = 0 if `at_grazing`, at roughness 0 if `at_mirror`.
    fn check_limits(&self, model: &Model, at_grazing: bool, at_mirror: bool) -> Result<()> {
        model.check_limits(at_grazing, at_mirror)
    }
    /// What can be had of its values beside them.
    fn derived(&self) -> &'static [Derived] {
        &[]
    }
    /// What must hold of a texel that has all of its values.
    fn law(&self) -> Option<&'static TexelLaw> {
        None
    }
    /// The same table without what none of these of its values needs; `None` where all are computed at once.
    fn narrowed(&self, _values: &[usize]) -> Option<&'static dyn Table> {
        None
    }
    /// What [`Table::truth`] is, in words.
    fn truth_name(&self) -> &'static str {
        "adaptive f64 integration"
    }
    /// What a file should say of its texels: [`MAX_CHANNELS`] values for each place.
    fn describe(&self, _model: &Model, _places: &[At], _texels: &[f32], _meta: &mut Meta) {}
    /// The deterministic rule in f64: what the CPU backend bakes, and the twin of the kernel.
    fn rule(&self, model: &Model, at: At) -> Values;
    /// The Fresnel term that it takes where this one was asked for; its own where none was.
    fn fresnel(&self, given: Option<Fresnel>) -> Result<Fresnel> {
        Ok(given.unwrap_or(self.facts().fresnel))
    }
    /// Refuses a model that the table cannot hold.
    fn check(&self, _model: &Model) -> Result<()> {
        Ok(())
    }
    /// Independent adaptive integration, to about `tolerance`.
    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS>;
    /// [`MAX_CHANNELS`] values as `f32` for every roughness (rows) and every n·v (columns; one column if the table has no
    /// such axis). Of a table without a kernel, as this is, the rule at every texel on the processor.
    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        _backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let columns = n_dot_v.len();
        let texels = watched(on, self.facts().name, columns * roughness.len(), |watch| -> Vec<Values> {
            let texel = |i: usize| {
                let at = At { n_dot_v: n_dot_v[i % columns], roughness: roughness[i / columns] };
                if watch.cancelled() { Values::default() } else { self.rule(model, at) }
            };
            (0..columns * roughness.len()).into_par_iter().map(texel).collect()
        })?;
        Ok(texels.into_iter().flatten().map(|v| v as f32).collect())
    }
}

/// Every table, in the order of their documentation.
pub static TABLES: &[&dyn Table] = &[
    &split_sum::SplitSum,
    &albedo::Albedo,
    &average_albedo::AverageAlbedo,
    &glass::GLASS,
    &glass_average::GLASS_AVERAGE,
    &schlick_weight::SchlickWeight,
    &kulla_conty::KullaConty,
    &turquin::Turquin,
    &skin::Skin,
    &ltc::Ltc,
    &ltc_magnitude::LtcMagnitude,
    &ltc_sheen::LtcSheen,
    &ltc_sheen::LtcSheenFibres,
    &ltc_sheen_volume::VOLUME,
    &ltc_sheen_volume::ENDLESS_VOLUME,
];

/// The table with this name.
pub fn table(name: &str) -> Result<&'static dyn Table> {
    let names = TABLES.iter().map(|t| t.facts().name);
    TABLES
        .iter()
        .copied()
        .find(|t| t.facts().name == name)
        .ok_or_else(|| Error::usage(format!("unknown table '{name}'"), nearest(name, names)))
}

/// A table to bake, with everything that decides its texels.
#[derive(Clone)]
pub struct TableJob {
    /// Which table.
    pub table: &'static dyn Table,
    /// Of which BRDF.
    pub model: Model,
    /// x axis, then y axis if there is one.
    pub axes: Vec<Axis>,
    /// What each channel of a texel holds.
    pub channels: Vec<Source>,
    /// The roughness of all texels, of a table without that axis.
    pub roughness: Option<f64>,
    /// The albedo table that this is the average of; `None` for the average of the albedo itself, and for other tables.
    pub of: Option<Stored>,
    /// How its texels are computed.
    pub rule: RuleChoice,
}

/// Where a channel comes from.
#[derive(Clone, Copy)]
pub enum Source {
    /// The table, by index into its [`Facts::channels`].
    Table(usize),
    /// 1 less the table's first channel: its [`Facts::complement`].
    Complement(&'static Channel),
    /// What follows from the table's values.
    Derived(&'static Derived),
    /// Another quantity over the same coordinates.
    Companion(&'static Companion),
}

impl Source {
    /// Does it need the table's values?
    fn is_of_table(&self) -> bool {
        !matches!(self, Source::Companion(_))
    }

    /// Which of the table's values it needs; `None` where it needs none or all.
    fn value(&self) -> Option<usize> {
        match self {
            Source::Table(c) => Some(*c),
            Source::Complement(_) => Some(0),
            Source::Derived(_) | Source::Companion(_) => None,
        }
    }
}

/// A table to bake as a user words it; `None` means the table's default.
#[derive(Clone)]
pub struct TableRequest {
    /// Name of the table.
    pub table: String,
    /// Width and height in texels.
    pub size: (u32, u32),
    /// Name of the distribution.
    pub ndf: String,
    /// Name of the geometry term.
    pub visibility: String,
    /// Fresnel term.
    pub fresnel: Option<Fresnel>,
    /// Names of the axes, x first.
    pub axes: Option<Vec<String>>,
    /// The roughness of all texels, in place of the axis of roughness.
    pub roughness: Option<f64>,
    /// Where in its texel a value is taken.
    pub points: Points,
    /// Row 0 holds the largest position of the y axis (of the x axis in a table with one).
    pub flip_v: bool,
    /// Every row holds what belongs this many rows further along the y axis: [`Axis::shift`].
    pub row_shift: u32,
    /// Names of the channels.
    pub channels: Option<Vec<String>>,
    /// The albedo table to average as a shader reads it: [`TableJob::of`].
    pub of: Option<Stored>,
    /// How its texels are computed.
    pub rule: RuleChoice,
}

impl TableRequest {
    /// The default request for a table: its [`Table::usual`].
    pub fn new(name: &str) -> TableRequest {
        let usual = table(name).map_or(Usual::TABLE, |table| table.usual());
        // A table with a lobe of its own is asked for the usual model, which it ignores.
        let [ndf, visibility] = usual.model.or(Usual::TABLE.model).expect("the usual table has a model");
        TableRequest {
            table: name.into(),
            size: usual.size,
            ndf: ndf.into(),
            visibility: visibility.into(),
            fresnel: None,
            axes: usual.axes.map(|axes| axes.iter().map(|warp| warp.name().into()).collect()),
            roughness: None,
            points: usual.points,
            flip_v: false,
            row_shift: 0,
            channels: None,
            of: None,
            rule: RuleChoice::Direct,
        }
    }

    /// The request for the average of a stored albedo table, channel by channel and row by row.
    pub fn average_of(albedo: &Texture, encoding: Encoding) -> Result<TableRequest> {
        let job = TableJob::from_meta(albedo)?;
        let along = |wanted| job.axes.iter().find(|a| a.warp.coordinate() == wanted);
        let (Some(n_dot_v), Some(roughness), "albedo") =
            (along(Coordinate::NDotV), along(Coordinate::Roughness), job.table.facts().name)
        else {
            return Err(Error::usage(
                format!("it holds {}, not an albedo over n.v and roughness", job.table.facts().name),
                "bake one with `brdf-baker bake albedo`",
            ));
        };
        let averaged = |name: &String| if name == "albedo" { "average".into() } else { name.clone() };
        let own = job.channels.iter().all(Source::is_of_table);
        if !own || roughness.shift != 0 {
            let what = if own { "its rows are shifted by a texel" } else { "it holds another BRDF beside the albedo" };
            return Err(Error::usage(what, "bake an albedo without --for and with channels of its own"));
        }
        Ok(TableRequest {
            size: (roughness.len, 1),
            ndf: job.model.ndf.to_string(),
            visibility: job.model.visibility.name.into(),
            fresnel: Some(job.model.fresnel),
            axes: Some(vec![roughness.warp.name().into()]),
            points: roughness.points,
            flip_v: roughness.reversed,
            channels: Some(albedo.channels.iter().map(averaged).collect()),
            of: Some(Stored::new(*n_dot_v, encoding)?),
            ..TableRequest::new("average-albedo")
        })
    }

    /// Checks every name and number.
    pub fn resolve(&self) -> Result<TableJob> {
        let table = table(&self.table)?;
        let facts = table.facts();
        let model = Model::parse(&self.ndf, &self.visibility)?.with(table.fresnel(self.fresnel)?);
        model.check()?;
        table.check(&model)?;
        if self.of.is_some() && facts.name != "average-albedo" {
            return Err(Error::usage(format!("{} is not the average of a stored table", facts.name), ""));
        }
        let roughness = self.roughness;
        if let Some(bad) = roughness.filter(|r| !(0.0..=1.0).contains(r)) {
            return Err(Error::usage(format!("a roughness of {bad} cannot be baked"), "give a number from 0 to 1"));
        }
        let own_axes: Vec<Coordinate> =
            facts.axes.iter().copied().filter(|a| roughness.is_none() || *a != Coordinate::Roughness).collect();
        if own_axes.is_empty() {
            return Err(Error::usage(format!("{} at one roughness is one number", facts.name), "drop --roughness"));
        }
        self.rule.check(table, &own_axes)?;
        let warps: Vec<Warp> = match &self.axes {
            None => own_axes.iter().map(|a| a.plain()).collect(),
            Some(names) => names.iter().map(|n| Warp::parse(n)).collect::<Result<_>>()?,
        };
        let same_set = own_axes.iter().all(|a| warps.iter().any(|w| w.coordinate() == *a));
        if !same_set || warps.len() != own_axes.len() {
            let names: Vec<_> = own_axes.iter().map(|a| a.name()).collect();
            return Err(Error::usage(
                format!("{} has the axes {}", facts.name, names.join(" and ")),
                format!("name each of them once, warped or not, e.g. --axes {}", names.join(",")),
            ));
        }
        let sizes = if warps.len() == 1 { vec![self.size.0] } else { vec![self.size.0, self.size.1] };
        if warps.len() == 1 && self.size.1 != 1 && self.size.1 != self.size.0 {
            return Err(Error::usage(
                format!("{} has one axis, so its height is 1, not {}", facts.name, self.size.1),
                format!("use --size {}", self.size.0),
            ));
        }
        let least = if self.points == Points::Edges { 2 } else { 1 };
        if let Some(bad) = sizes.iter().find(|s| !(least..=MAX_SIZE).contains(*s)) {
            return Err(Error::usage(
                format!("a table side of {bad} texels cannot be baked"),
                format!("use --size from {least} to {MAX_SIZE}"),
            ));
        }
        let last = warps.len() - 1;
        let axis = |(i, (warp, len)): (usize, (Warp, u32))| Axis {
            warp,
            points: self.points,
            len,
            reversed: self.flip_v && i == last,
            shift: if i == last { self.row_shift } else { 0 },
        };
        let axes = warps.into_iter().zip(sizes).enumerate().map(axis).collect();
        let own = (facts.channels)(&model.fresnel);
        let companions = || COMPANIONS.iter().filter(|_| own_axes == [Coordinate::NDotV, Coordinate::Roughness]);
        let known = || {
            let derived = table.derived().iter().map(|d| d.channel.name);
            let beside = facts.complement.iter().map(|c| c.name).chain(derived);
            let beside = beside.chain(companions().map(|c| c.channel.name));
            own.iter().map(|c| c.name).chain(beside)
        };
        let wanted: Vec<&str> = match &self.channels {
            None => (facts.default_channels)(&model.fresnel).to_vec(),
            Some(names) => names.iter().map(String::as_str).collect(),
        };
        let channel =
            |name: &&str| {
                let of_table = own.iter().position(|c| c.name == *name).map(Source::Table);
                let of_complement = || facts.complement.filter(|c| c.name == *name).map(Source::Complement);
                let of_derived = || table.derived().iter().find(|d| d.channel.name == *name).map(Source::Derived);
                let of_companion = || companions().find(|c| c.channel.name == *name).map(Source::Companion);
                of_table.or_else(of_complement).or_else(of_derived).or_else(of_companion).ok_or_else(|| {
                    Error::usage(format!("{} has no channel '{name}'", facts.name), nearest(name, known()))
                })
            };
        let channels: Vec<Source> = wanted.iter().map(channel).collect::<Result<_>>()?;
        let edges = |c| self.points == Points::Edges && own_axes.contains(&c);
        let (at_grazing, at_mirror) =
            (edges(Coordinate::NDotV), edges(Coordinate::Roughness) || roughness == Some(0.0));
        if channels.iter().any(Source::is_of_table) {
            table.check_limits(&model, at_grazing, at_mirror)?;
        }
        for channel in &channels {
            if let Source::Companion(companion) = channel {
                companion.check_limits(at_grazing, at_mirror)?;
            }
        }
        if channels.is_empty() || channels.len() > 4 {
            return Err(Error::usage(format!("{} channels chosen", channels.len()), "choose one to four channels"));
        }
        let values: Option<Vec<usize>> =
            channels.iter().filter(|source| source.is_of_table()).map(Source::value).collect();
        let table = values.and_then(|values| table.narrowed(&values)).unwrap_or(table);
        Ok(TableJob { table, model, axes, channels, roughness, of: self.of, rule: self.rule })
    }
}

impl TableJob {
    /// Width and height in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.axes[0].len, self.axes.get(1).map_or(1, |a| a.len))
    }

    /// The coordinates of texel (x, y). A table without n·v has n·v = 1 everywhere.
    pub fn at(&self, x: u32, y: u32) -> At {
        let mut at = At { n_dot_v: 1.0, roughness: self.roughness.unwrap_or(1.0) };
        for (axis, i) in self.axes.iter().zip([x, y]) {
            match axis.warp.coordinate() {
                Coordinate::NDotV | Coordinate::NDotL => at.n_dot_v = axis.at(i),
                Coordinate::Roughness | Coordinate::Curvature => at.roughness = axis.at(i),
            }
        }
        at
    }

    /// The chosen channels, in order.
    pub fn channel_facts(&self) -> impl Iterator<Item = &'static Channel> + '_ {
        let all = (self.table.facts().channels)(&self.model.fresnel);
        self.channels.iter().map(|source| match source {
            Source::Table(c) => &all[*c],
            Source::Complement(channel) => channel,
            Source::Derived(derived) => &derived.channel,
            Source::Companion(companion) => &companion.channel,
        })
    }

    /// Is it computed for a distribution and a geometry term?
    pub fn has_model(&self) -> bool {
        self.table.usual().model.is_some()
    }

    /// Does any channel come from the table itself?
    fn has_own(&self) -> bool {
        self.channels.iter().any(Source::is_of_table)
    }

    /// The f64 rule's values of the chosen channels.
    pub fn rule(&self, at: At) -> Vec<f64> {
        if let Some(stored) = &self.of {
            let rule = |at| Estimate { value: self.model.rule(at), error: 0.0 };
            return self.of_stored(stored, at, rule).into_iter().map(|average| average.value[0]).collect();
        }
        let all = if self.has_own() { self.table.rule(&self.model, at) } else { Values::default() };
        let value = |source: &Source| match source {
            Source::Table(c) => all[*c],
            Source::Complement(_) => 1.0 - all[0],
            Source::Derived(derived) => (derived.rule)(&self.model, at, &all),
            Source::Companion(companion) => companion.rule(at),
        };
        self.channels.iter().map(value).collect()
    }

    /// How far the channels of a right table may be from [`TableJob::rule`] because of what it was made from: the mean
    /// rounding of the texels of a stored table.
    pub fn source_rounding(&self, at: At) -> Vec<f64> {
        let Some(stored) = &self.of else { return vec![0.0; self.channels.len()] };
        let rule = |at| Estimate { value: self.model.rule(at), error: 0.0 };
        self.of_stored(stored, at, rule).into_iter().map(|average| average.error).collect()
    }

    /// Averages over the texels of a stored table, from the albedo at a place; the errors include the texels' rounding.
    fn of_stored(&self, stored: &Stored, at: At, albedo: impl Fn(At) -> Estimate<MAX_CHANNELS>) -> Vec<Estimate<1>> {
        let steps = Steps::from(stored.encoding);
        let mut sums = vec![Estimate { value: [0.0], error: 0.0 }; self.channels.len()];
        for (n_dot_v, weight) in stored.n_dot_v.coordinates().into_iter().zip(stored.weights()) {
            let e = albedo(At { n_dot_v, ..at });
            let values = self.channels.iter().map(|source| match source {
                Source::Table(c) => e.value[*c],
                Source::Complement(_) => 1.0 - e.value[0],
                Source::Derived(_) | Source::Companion(_) => {
                    unreachable!("TableRequest::average_of takes albedo tables, and refuses companions")
                }
            });
            let values: Vec<f64> = values.collect();
            let largest = values.iter().copied().fold(0.0, f64::max);
            for (sum, value) in sums.iter_mut().zip(values) {
                sum.value[0] += weight * value;
                sum.error += weight * (e.error + steps.half_ulp_at(value, largest));
            }
        }
        sums
    }

    /// The truth of the chosen channels by adaptive integration, each with its own error, to about `share` of their
    /// bounds.
    pub fn truth(&self, at: At, share: f64) -> Vec<Estimate<1>> {
        let tolerance = share * self.strictest();
        if let Some(stored) = &self.of {
            return self.of_stored(stored, at, |at| truth::albedo(&self.model, at.n_dot_v, at.roughness, tolerance));
        }
        let all = match self.has_own() {
            true => self.table.truth(&self.model, at, tolerance),
            false => Estimate { value: Values::default(), error: 0.0 },
        };
        let value = |source: &Source| match source {
            Source::Table(c) => Estimate { value: [all.value[*c]], error: all.error },
            Source::Complement(_) => Estimate { value: [1.0 - all.value[0]], error: all.error },
            Source::Derived(derived) => {
                let found = (derived.truth)(&self.model, at, &all.value);
                Estimate { value: found.value, error: found.error + all.error * found.value[0].abs().max(1.0) }
            }
            Source::Companion(companion) => companion.truth(at, share * companion.tolerance().worst),
        };
        self.channels.iter().map(value).collect()
    }

    /// The rule and its nodes, in words.
    pub fn rule_name(&self) -> String {
        if let Some(stored) = &self.of {
            return format!(
                "linear filtering of {}, integrated exactly; {}",
                stored.n_dot_v.len,
                self.model.rule_name()
            );
        }
        let own = self.has_own().then(|| self.rule.name(&(self.table.facts().rule)(&self.model)));
        let companions = self.channels.iter().filter_map(|source| match source {
            Source::Table(_) | Source::Complement(_) | Source::Derived(_) => None,
            Source::Companion(companion) => Some(format!("{} by {}", companion.channel.name, companion.rule_name())),
        });
        own.into_iter().chain(companions).collect::<Vec<_>>().join("; ")
    }

    /// The average of the stored `albedo` that [`TableRequest::average_of`] was asked for, from its texels.
    pub fn average(&self, albedo: &Texture, encoding: Encoding) -> Result<Texture> {
        let stored = self.of.as_ref().expect("a job of TableRequest::average_of");
        let source = TableJob::from_meta(albedo)?;
        let weights = stored.weights();
        let across = source.axes[0].warp.coordinate() == Coordinate::NDotV;
        let n = albedo.channels.len();
        let within_range: Vec<_> = (0..n).map(|c| self.within_range(c)).collect();
        let mut texels = Vec::with_capacity(self.axes[0].len as usize * n);
        for row in 0..self.axes[0].len {
            let mut sums = vec![0.0; n];
            for (column, weight) in (0..).zip(&weights) {
                let (x, y) = if across { (column, row) } else { (row, column) };
                let texel = albedo.texel(0, 0, x, y);
                sums.iter_mut().zip(texel).for_each(|(sum, v)| *sum += weight * f64::from(*v));
            }
            texels.extend(sums.iter().zip(&within_range).map(|(sum, within_range)| within_range(*sum as f32)));
        }
        let mut meta = self.meta(&Backend::Cpu);
        meta.set("of.sha256", Fingerprint::of_stored(albedo, encoding)?.sha256);
        let channels = self.channel_facts().map(|c| c.name.to_string()).collect();
        Ok(Texture { shape: Shape::Table, width: self.axes[0].len, height: 1, channels, levels: vec![texels], meta })
    }

    /// Bakes the table; its meta says everything but the measured error.
    pub fn run(&self, backend: &Backend, on: &mut OnProgress<'_>) -> Result<Texture> {
        let of = |wanted: [Coordinate; 2], without: f64| {
            let found = self.axes.iter().position(|a| wanted.contains(&a.warp.coordinate()));
            (found, found.map_or(vec![without], |i| self.axes[i].coordinates()))
        };
        let ((x_of, n_dot_v), (_, roughness)) = (
            of([Coordinate::NDotV, Coordinate::NDotL], 1.0),
            of([Coordinate::Roughness, Coordinate::Curvature], self.roughness.unwrap_or(1.0)),
        );
        let (all, settled) = match self.has_own() {
            true => expanded::bake(self, &n_dot_v, &roughness, backend, on)?,
            false => (vec![], Settled::DIRECT),
        };
        let places = || -> Vec<At> {
            let row = |&roughness: &f64| n_dot_v.iter().map(move |&n_dot_v| At { n_dot_v, roughness });
            roughness.iter().flat_map(row).collect()
        };
        // Every channel as [roughness][n·v].
        let mut planes = Vec::with_capacity(self.channels.len());
        for (channel, (source, facts)) in self.channels.iter().zip(self.channel_facts()).enumerate() {
            let mut plane: Vec<f32> = match source {
                Source::Table(c) => all.iter().skip(*c).step_by(MAX_CHANNELS).copied().collect(),
                Source::Complement(_) => all.iter().step_by(MAX_CHANNELS).map(|v| 1.0 - v).collect(),
                Source::Derived(derived) => {
                    let value = |(at, texel): (&At, &[f32; MAX_CHANNELS])| {
                        (derived.rule)(&self.model, *at, &texel.map(f64::from)) as f32
                    };
                    places().par_iter().zip(all.as_chunks().0).map(value).collect()
                }
                Source::Companion(companion) => companion.bake(&n_dot_v, &roughness, backend, on)?,
            };
            if let Some(bad) = plane.iter().position(|v| !v.is_finite()) {
                let detail = format!("value {bad} of {} of channel {} is {}", plane.len(), facts.name, plane[bad]);
                return Err(Error::Gpu { op: format!("bake {}", self.table.facts().name), detail });
            }
            let within_range = self.within_range(channel);
            plane.iter_mut().for_each(|v| *v = within_range(*v));
            planes.push(plane);
        }

        // To the order of the file.
        let (width, height) = self.size();
        let mut texels = Vec::with_capacity((width * height) as usize * self.channels.len());
        for y in 0..height {
            for x in 0..width {
                let (column, row) = match (x_of, self.axes.len()) {
                    (Some(0), 1) => (x, 0),
                    (Some(0), _) => (x, y),
                    (Some(_), _) => (y, x),
                    (None, _) => (0, x),
                };
                let texel = row as usize * n_dot_v.len() + column as usize;
                texels.extend(planes.iter().map(|plane| plane[texel]));
            }
        }
        let mut meta = TableJob { rule: settled.rule, ..self.clone() }.meta(backend);
        if !all.is_empty() {
            self.table.describe(&self.model, &places(), &all, &mut meta);
        }
        let channels = self.channel_facts().map(|c| c.name.to_string()).collect();
        if let Some(error) = settled.error {
            let (tail, measured) = (error.tail, error.measured);
            meta.set("rule.error", format!("series {tail:.1e} by its decay, {measured:.1e} at points between"));
        }
        if let Some(note) = settled.note {
            meta.set("rule.note", note);
        }
        Ok(Texture { shape: Shape::Table, width, height, channels, levels: vec![texels], meta })
    }

    /// The bounds that the texels of a channel keep, by its place in a texel.
    pub fn tolerance(&self, channel: usize) -> Tolerance {
        match self.channels[channel] {
            Source::Table(value) => self.table.tolerance(&self.model, value),
            Source::Complement(_) => self.table.tolerance(&self.model, 0),
            Source::Derived(derived) => derived.tolerance,
            Source::Companion(companion) => companion.tolerance(),
        }
    }

    /// The least bound that any of the table's values keeps.
    fn strictest(&self) -> f64 {
        let values = (self.table.facts().channels)(&self.model.fresnel).len();
        (0..values).map(|value| self.table.tolerance(&self.model, value).worst).fold(f64::INFINITY, f64::min)
    }

    /// The bounds of the loosest channel.
    pub fn loosest(&self) -> Tolerance {
        let bounds = (0..self.channels.len()).map(|c| self.tolerance(c));
        bounds.max_by(|a, b| a.worst.total_cmp(&b.worst)).expect("a table has channels")
    }

    /// Least and greatest value of a channel, by its place in a texel.
    pub fn range(&self, channel: usize) -> [f32; 2] {
        match self.channels[channel] {
            Source::Table(c) => {
                let [low, high] = (self.table.facts().channels)(&self.model.fresnel)[c].range;
                [low, if self.model.bounded() { high } else { self.model.largest() }]
            }
            Source::Complement(channel) => [1.0 - self.model.largest(), channel.range[1]],
            Source::Derived(derived) => derived.channel.range,
            Source::Companion(companion) => {
                let roughness = self.axes.iter().filter(|a| a.warp.coordinate() == Coordinate::Roughness);
                companion.range(roughness.flat_map(Axis::coordinates).fold(1.0, f64::min))
            }
        }
    }

    /// What moves a value of a channel that rounding carried over the end of its range back to it. A value further out
    /// than the tolerance stays as it is, for the checks to find.
    fn within_range(&self, channel: usize) -> impl Fn(f32) -> f32 {
        let ([low, high], tolerance) = (self.range(channel), self.tolerance(channel).worst);
        move |value| {
            let inside = value.clamp(low, high);
            if f64::from((value - inside).abs()) <= tolerance { inside } else { value }
        }
    }

    /// What [`Table::describe`] says of the texels of a file that holds all of the table's values.
    pub fn described(&self, texture: &Texture) -> Meta {
        let mut meta = Meta::default();
        if let Some(own) = self.own_channels() {
            let (width, height) = self.size();
            let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let places: Vec<At> = texels.clone().map(|(x, y)| self.at(x, y)).collect();
            let values = |(x, y)| {
                let texel = texture.texel(0, 0, x, y);
                let mut values = [0.0; MAX_CHANNELS];
                values.iter_mut().zip(&own).for_each(|(value, place)| *value = texel[*place]);
                values
            };
            let texels: Vec<f32> = texels.flat_map(values).collect();
            self.table.describe(&self.model, &places, &texels, &mut meta);
        }
        meta
    }

    /// Where in a texel the table's own values are; `None` where the file does not hold all of them.
    pub fn own_channels(&self) -> Option<Vec<usize>> {
        let all = (self.table.facts().channels)(&self.model.fresnel).len();
        let place = |own: usize| self.channels.iter().position(|c| matches!(c, Source::Table(value) if *value == own));
        (0..all).map(place).collect()
    }

    /// What the file says of itself.
    fn meta(&self, backend: &Backend) -> Meta {
        let facts = self.table.facts();
        let names = |list: Vec<&str>| list.join(",");
        let mut meta = Meta::default();
        meta.set("table", facts.name);
        if self.has_model() {
            meta.set("ndf", self.model.ndf.to_string());
            meta.set("visibility", self.model.visibility.name);
            meta.set("fresnel", self.model.fresnel.to_string());
        }
        meta.set("axes", names(self.axes.iter().map(|a| a.warp.name()).collect()));
        meta.set("points", self.axes[0].points.name());
        meta.set(
            "order",
            names(self.axes.iter().map(|a| if a.reversed { "descending" } else { "ascending" }).collect()),
        );
        if let [_, y] = self.axes[..] {
            let name = y.warp.coordinate().name();
            if y.shift != 0 {
                meta.set("row-shift", y.shift);
            }
            meta.set(
                "rows",
                format!("row 0 is the top and holds {name} {:.6}, the last {:.6}", y.at(0), y.at(y.len - 1)),
            );
        }
        if let Some(roughness) = self.roughness {
            meta.set("roughness", roughness);
        }
        meta.set("alpha", "roughness^2");
        let exact = "share of white light that the material reflects by single scattering";
        let of_a_share = self.model.fresnel.is_exact() && !facts.fresnel.is_exact();
        meta.set("usage", if of_a_share { exact } else { facts.usage });
        meta.set("source", facts.source);
        if let Some(stored) = &self.of {
            meta.set("of", stored);
        }
        meta.set("rule", self.rule_name());
        if let Some(note) = self.model.note().filter(|_| self.has_model()) {
            meta.set("note", note);
        }
        meta.set("device", backend.name());
        meta.set("driver", backend.driver());
        meta.set("version", env!("CARGO_PKG_VERSION"));
        meta
    }

    /// The job that made a file, from what the file says.
    pub fn from_meta(texture: &Texture) -> Result<TableJob> {
        TableRequest::from_meta(texture)?.resolve()
    }
}

impl TableRequest {
    /// The request that made a file, from what the file says.
    fn from_meta(texture: &Texture) -> Result<TableRequest> {
        if let (Some(_), name) = (texture.meta.get(own::SOURCE_SHA256), texture.meta.get("brdf")) {
            return Err(Error::usage(
                format!(
                    "the file holds a BRDF of someone's own, '{}', which is needed again",
                    name.unwrap_or_default()
                ),
                "`brdf-baker verify FILE --glsl SOURCE.glsl` checks it; other commands do not know such files",
            ));
        }
        let get = |key: &str| {
            texture.meta.get(key).ok_or_else(|| {
                Error::usage(
                    format!("the file does not say its '{key}'"),
                    "only files that brdf-baker wrote carry their model",
                )
            })
        };
        let list = |key: &str| Ok::<_, Error>(get(key)?.split(',').map(String::from).collect::<Vec<_>>());
        let name = get("table")?;
        if layers::are_stated(&texture.meta) {
            return Err(Error::usage(
                format!("the file holds the tables {name} in its layers"),
                "bake the one that is wanted by its own name",
            ));
        }
        let usual = TableRequest::new(name);
        let has_model = table(name)?.usual().model.is_some();
        Ok(TableRequest {
            table: name.into(),
            size: (texture.width, texture.height),
            ndf: if has_model { get("ndf")?.into() } else { usual.ndf },
            visibility: if has_model { get("visibility")?.into() } else { usual.visibility },
            // Files of version 0.1 did not state it: they hold the table's own. Where a number of it runs over slices it has none.
            fresnel: match texture.meta.get("fresnel") {
                None | Some("dielectric" | "power" | "f0") => None,
                Some(text) => Some(Fresnel::parse(text)?),
            },
            axes: Some(list("axes")?),
            roughness: match texture.meta.get("roughness") {
                None => None,
                Some(text) => Some(text.parse().map_err(|_| {
                    Error::usage(format!("the file says roughness '{text}'"), "a roughness is a number from 0 to 1")
                })?),
            },
            points: Points::parse(get("points")?)?,
            flip_v: list("order")?.last().is_some_and(|o| o == "descending"),
            row_shift: match texture.meta.get("row-shift") {
                None => 0,
                Some(text) => text.parse().ok().filter(|shift| *shift <= MAX_ROW_SHIFT).ok_or_else(|| {
                    Error::usage(format!("the file says row-shift '{text}'"), "rows are shifted by 0 or 1 texel")
                })?,
            },
            channels: Some(texture.channels.clone()),
            of: texture.meta.get("of").map(Stored::parse).transpose()?,
            rule: RuleChoice::of_name(texture.meta.get("rule").unwrap_or_default()),
        })
    }
}
