//! What is baked: one file per table or filter, their registry, and the way from a request to texels.

mod albedo;
pub mod atlas;
mod average_albedo;
pub mod backend;
pub mod companion;
mod expanded;
mod glass;
mod glass_average;
pub mod grid;
pub mod model;
pub mod own;
pub mod quality;
pub mod roughness_law;
pub(crate) mod slices;
pub mod specular;
mod split_sum;
mod stored;
pub mod volume;

pub use backend::Backend;
pub use expanded::RuleChoice;
pub use model::Model;
pub use roughness_law::RoughnessLaw;
pub use stored::Stored;
pub use volume::{IorMap, VolumeJob};

use self::companion::{COMPANIONS, Companion};
use self::expanded::Settled;
use crate::axis::{Axis, Coordinate, Points, Warp};
use crate::error::{Error, Result, nearest};
use crate::format::{Encoding, Fingerprint, Steps};
use crate::progress::OnProgress;
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
    /// Cosine between normal and viewer, in [0, 1].
    pub n_dot_v: f64,
    /// Perceptual roughness, in [0, 1].
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
    /// The rule and its number of nodes, for the file's certificate.
    pub rule: fn(&Model) -> String,
    /// Bounds of its error.
    pub tolerance: Tolerance,
}

/// A table that can be baked.
pub trait Table: Sync {
    /// What it is.
    fn facts(&self) -> &'static Facts;
    /// The deterministic rule in f64: what the CPU backend bakes, and the twin of the kernel.
    fn rule(&self, model: &Model, at: At) -> Values;
    /// Refuses a model that the table cannot hold.
    fn check(&self, _model: &Model) -> Result<()> {
        Ok(())
    }
    /// Independent adaptive integration, to about `tolerance`.
    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS>;
    /// [`MAX_CHANNELS`] values as `f32` for every roughness (rows) and every n·v (columns; one column if the table has no
    /// such axis).
    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>>;
}

/// Every table, in the order of their documentation.
pub static TABLES: &[&dyn Table] = &[
    &split_sum::SplitSum,
    &albedo::Albedo,
    &average_albedo::AverageAlbedo,
    &glass::Glass,
    &glass_average::GlassAverage,
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
    /// Another quantity over the same coordinates.
    Companion(&'static Companion),
}

impl Source {
    /// Does it need the table's values?
    fn is_of_table(&self) -> bool {
        self.value().is_some()
    }

    /// Which of the table's values it needs.
    fn value(&self) -> Option<usize> {
        match self {
            Source::Table(c) => Some(*c),
            Source::Complement(_) => Some(0),
            Source::Companion(_) => None,
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
    /// The default request for a table: 256 × 256 texels, centers, GGX with height-correlated Smith.
    pub fn new(table: &str) -> TableRequest {
        TableRequest {
            table: table.into(),
            size: (256, 256),
            ndf: "ggx".into(),
            visibility: "smith".into(),
            fresnel: None,
            axes: None,
            points: Points::Centers,
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
        let model = Model::parse(&self.ndf, &self.visibility)?.with(self.fresnel.unwrap_or(facts.fresnel));
        model.check()?;
        table.check(&model)?;
        self.rule.check(facts.axes, facts.name)?;
        if self.of.is_some() && facts.name != "average-albedo" {
            return Err(Error::usage(format!("{} is not the average of a stored table", facts.name), ""));
        }
        let warps: Vec<Warp> = match &self.axes {
            None => facts.axes.iter().map(|a| a.plain()).collect(),
            Some(names) => names.iter().map(|n| Warp::parse(n)).collect::<Result<_>>()?,
        };
        let same_set = facts.axes.iter().all(|a| warps.iter().any(|w| w.coordinate() == *a));
        if !same_set || warps.len() != facts.axes.len() {
            let names: Vec<_> = facts.axes.iter().map(|a| a.name()).collect();
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
        let companions = || COMPANIONS.iter().filter(|_| facts.axes.len() == 2);
        let known = || {
            let beside = facts.complement.iter().map(|c| c.name).chain(companions().map(|c| c.channel.name));
            own.iter().map(|c| c.name).chain(beside)
        };
        let wanted: Vec<&str> = match &self.channels {
            None => (facts.default_channels)(&model.fresnel).to_vec(),
            Some(names) => names.iter().map(String::as_str).collect(),
        };
        let channel = |name: &&str| {
            let of_table = own.iter().position(|c| c.name == *name).map(Source::Table);
            let of_complement = || facts.complement.filter(|c| c.name == *name).map(Source::Complement);
            let of_companion = || companions().find(|c| c.channel.name == *name).map(Source::Companion);
            of_table
                .or_else(of_complement)
                .or_else(of_companion)
                .ok_or_else(|| Error::usage(format!("{} has no channel '{name}'", facts.name), nearest(name, known())))
        };
        let channels: Vec<Source> = wanted.iter().map(channel).collect::<Result<_>>()?;
        let edges = |c| self.points == Points::Edges && facts.axes.contains(&c);
        let (at_grazing, at_mirror) = (edges(Coordinate::NDotV), edges(Coordinate::Roughness));
        if channels.iter().any(Source::is_of_table) {
            model.check_limits(at_grazing, at_mirror)?;
        }
        for channel in &channels {
            if let Source::Companion(companion) = channel {
                companion.check_limits(at_grazing, at_mirror)?;
            }
        }
        if channels.is_empty() || channels.len() > 4 {
            return Err(Error::usage(format!("{} channels chosen", channels.len()), "choose one to four channels"));
        }
        Ok(TableJob { table, model, axes, channels, of: self.of, rule: self.rule })
    }
}

impl TableJob {
    /// Width and height in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.axes[0].len, self.axes.get(1).map_or(1, |a| a.len))
    }

    /// The coordinates of texel (x, y). A table without n·v has n·v = 1 everywhere.
    pub fn at(&self, x: u32, y: u32) -> At {
        let mut at = At { n_dot_v: 1.0, roughness: 1.0 };
        for (axis, i) in self.axes.iter().zip([x, y]) {
            match axis.warp.coordinate() {
                Coordinate::NDotV => at.n_dot_v = axis.at(i),
                Coordinate::Roughness => at.roughness = axis.at(i),
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
            Source::Companion(companion) => &companion.channel,
        })
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
                Source::Companion(_) => unreachable!("TableRequest::average_of refuses companions"),
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
        let tolerance = share * self.model.tolerance(&self.table.facts().tolerance).worst;
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
            Source::Table(_) | Source::Complement(_) => None,
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
        let mut texels = Vec::with_capacity(self.axes[0].len as usize * n);
        for row in 0..self.axes[0].len {
            let mut sums = vec![0.0; n];
            for (column, weight) in (0..).zip(&weights) {
                let (x, y) = if across { (column, row) } else { (row, column) };
                let texel = albedo.texel(0, 0, x, y);
                sums.iter_mut().zip(texel).for_each(|(sum, v)| *sum += weight * f64::from(*v));
            }
            texels.extend(sums.iter().enumerate().map(|(c, sum)| self.within_range(c, *sum as f32)));
        }
        let mut meta = self.meta(&Backend::Cpu);
        meta.set("of.sha256", Fingerprint::of_stored(albedo, encoding)?.sha256);
        let channels = self.channel_facts().map(|c| c.name.to_string()).collect();
        Ok(Texture { shape: Shape::Table, width: self.axes[0].len, height: 1, channels, levels: vec![texels], meta })
    }

    /// Bakes the table; its meta says everything but the measured error.
    pub fn run(&self, backend: &Backend, on: &mut OnProgress<'_>) -> Result<Texture> {
        let of = |wanted| {
            let found = self.axes.iter().position(|a| a.warp.coordinate() == wanted);
            (found, found.map_or(vec![1.0], |i| self.axes[i].coordinates()))
        };
        let ((x_of, n_dot_v), (_, roughness)) = (of(Coordinate::NDotV), of(Coordinate::Roughness));
        let (all, settled) = match self.has_own() {
            true => expanded::bake(self, &n_dot_v, &roughness, backend, on)?,
            false => (vec![], Settled::DIRECT),
        };
        // Every channel as [roughness][n·v].
        let mut planes = Vec::with_capacity(self.channels.len());
        for (source, facts) in self.channels.iter().zip(self.channel_facts()) {
            let plane = match source {
                Source::Table(c) => all.iter().skip(*c).step_by(MAX_CHANNELS).copied().collect(),
                Source::Complement(_) => all.iter().step_by(MAX_CHANNELS).map(|v| 1.0 - v).collect(),
                Source::Companion(companion) => companion.bake(&n_dot_v, &roughness, backend, on)?,
            };
            if let Some(bad) = plane.iter().position(|v: &f32| !v.is_finite()) {
                let detail = format!("value {bad} of {} of channel {} is {}", plane.len(), facts.name, plane[bad]);
                return Err(Error::Gpu { op: format!("bake {}", self.table.facts().name), detail });
            }
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
                texels.extend(planes.iter().enumerate().map(|(c, plane)| self.within_range(c, plane[texel])));
            }
        }
        let channels = self.channel_facts().map(|c| c.name.to_string()).collect();
        let mut meta = TableJob { rule: settled.rule, ..self.clone() }.meta(backend);
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
            Source::Table(_) | Source::Complement(_) => self.model.tolerance(&self.table.facts().tolerance),
            Source::Companion(companion) => companion.tolerance(),
        }
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
            Source::Companion(companion) => {
                let roughness = self.axes.iter().filter(|a| a.warp.coordinate() == Coordinate::Roughness);
                companion.range(roughness.flat_map(Axis::coordinates).fold(1.0, f64::min))
            }
        }
    }

    /// Moves a value that rounding carried over the end of its channel's range back to it. A value further out than
    /// the tolerance stays as it is, for the checks to find.
    fn within_range(&self, channel: usize, value: f32) -> f32 {
        let [low, high] = self.range(channel);
        let inside = value.clamp(low, high);
        if f64::from((value - inside).abs()) <= self.tolerance(channel).worst { inside } else { value }
    }

    /// What the file says of itself.
    fn meta(&self, backend: &Backend) -> Meta {
        let facts = self.table.facts();
        let names = |list: Vec<&str>| list.join(",");
        let mut meta = Meta::default();
        meta.set("table", facts.name);
        meta.set("ndf", self.model.ndf.to_string());
        meta.set("visibility", self.model.visibility.name);
        meta.set("fresnel", self.model.fresnel.to_string());
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
        meta.set("alpha", "roughness^2");
        let exact = "share of white light that the material reflects by single scattering";
        let of_a_share = self.model.fresnel.is_exact() && !facts.fresnel.is_exact();
        meta.set("usage", if of_a_share { exact } else { facts.usage });
        meta.set("source", facts.source);
        if let Some(stored) = &self.of {
            meta.set("of", stored);
        }
        meta.set("rule", self.rule_name());
        if let Some(note) = self.model.note() {
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
        Ok(TableRequest {
            table: get("table")?.into(),
            size: (texture.width, texture.height),
            ndf: get("ndf")?.into(),
            visibility: get("visibility")?.into(),
            // Files of version 0.1 did not state it: they hold the table's own. With an axis of indices it has none.
            fresnel: match texture.meta.get("fresnel") {
                None | Some("dielectric") => None,
                Some(text) => Some(Fresnel::parse(text)?),
            },
            axes: Some(list("axes")?),
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
