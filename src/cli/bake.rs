// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker bake`

use std::path::{Path, PathBuf};
use std::time::Instant;

use brdf_baker::axis::Points;
use brdf_baker::bake::layers::JOINT;
use brdf_baker::bake::volume::Stacking;
use brdf_baker::bake::{self, Backend, LayersJob, RuleChoice, SliceAxis, TableJob, TableRequest, VolumeJob};
use brdf_baker::format::{self, Encoding, Format, Output, Repr, Storage};
use brdf_baker::material;
use brdf_baker::progress::OnProgress;
use brdf_baker::recipe::Origin;
use brdf_baker::target::{self, Choice, OF_SET, SET};
use brdf_baker::term::fresnel::Fresnel;
use brdf_baker::texture::{Shape, Texture};
use brdf_baker::verify::table::{Extent, TableReport, check};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::console::Console;
use super::device::Device;
use super::given::Given;
use super::own::{OwnArgs, Wanted};
use super::storage::{self, StorageArgs};

#[derive(clap::Args, Clone)]
pub struct BakeArgs {
    /// split-sum, albedo, average-albedo, glass, ltc, skin, ...: see `brdf-baker list tables`; several joined by + for the
    /// layers of an array texture, e.g. ltc+ltc-magnitude; set for all that the engine of --for takes, by its own names
    table: String,
    /// File to write, of a set the folder; its extension chooses the container, see `brdf-baker list formats` [default: the target's]
    #[arg(short, long, value_name = "FILE", required_unless_present = "target")]
    output: Option<PathBuf>,
    /// Engine that loads the file: sets all that follows and is not given; see `brdf-baker list targets`
    #[arg(long = "for", value_name = "ENGINE")]
    target: Option<String>,
    /// average-albedo: the average of what a shader reads from this albedo table, row by row, instead of the true one;
    /// compensation then returns all light [default encoding: single float]
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = [
            "target", "size", "ndf", "visibility", "fresnel", "roughness", "axes", "points", "flip_v", "channels", "rule"
        ]
    )]
    of: Option<PathBuf>,
    /// Texels: 256, or 128x32 for width x height, or 16x16x16 where a third axis runs over slices [default: 256, over three
    /// axes 32]
    #[arg(long, value_name = "N|WxH|WxHxD", value_parser = parse_sizes)]
    size: Option<Sizes>,
    /// Normal distribution function [default: ggx]
    #[arg(long, value_name = "NAME[:PARAMETER=VALUE,...]")]
    ndf: Option<String>,
    /// Geometry term [default: smith]
    #[arg(long, value_name = "NAME")]
    visibility: Option<String>,
    /// Exact Fresnel of a dielectric of this refractive index over the medium's that light comes from; below 1 from inside
    #[arg(long, value_name = "N", group = "fresnel")]
    ior: Option<f64>,
    /// Exact Fresnel of a conductor: eta and k, or eta of red, green, blue and then k of red, green, blue
    #[arg(long, value_name = "ETA,K|R,G,B,R,G,B", group = "fresnel", value_delimiter = ',')]
    eta_k: Option<Vec<f64>>,
    /// schlick-weight: power of 1 - v.h that F90 is weighted with [default: 5]
    #[arg(long, value_name = "P", group = "fresnel")]
    exponent: Option<f64>,
    /// kulla-conty and turquin: Schlick's reflectance at normal incidence [default: 0.04]
    #[arg(long, value_name = "F0", group = "fresnel")]
    f0: Option<f64>,
    /// A thin film of this refractive index and thickness in nm on that dielectric or metal; without a thickness where the
    /// axis film_nm has it. A bubble has --ior 1
    #[arg(long, value_name = "INDEX[,NM]", value_delimiter = ',', requires = "fresnel")]
    film: Option<Vec<f64>>,
    /// The same roughness for all texels, in place of that axis
    #[arg(long, value_name = "R")]
    roughness: Option<f64>,
    /// Exact Fresnel of a named material, see `brdf-baker materials`
    #[arg(long, value_name = "NAME", group = "fresnel")]
    material: Option<String>,
    /// What runs along x and y: n_dot_v, sqrt_n_dot_v, sqrt_one_minus_n_dot_v or angle; roughness or alpha; last of
    /// all, for a slice each, of glass and schlick-weight ior=FROM/TO, ior_from_f0 (Cycles), inverse_ior_from_f0 or
    /// openpbr_ior, of schlick-weight cycles_exponent, of albedos with a film film_nm=FROM/TO,
    /// of kulla-conty and turquin f0=FROM/TO, of albedo of an anisotropic lobe azimuth=FROM/TO [default:
    /// n_dot_v,roughness]
    #[arg(long, value_name = "X,Y[,Z]", value_delimiter = ',')]
    axes: Option<Vec<String>>,
    /// How a third axis is stored: volume, a 3-D texture, or array, a layer for each slice, for engines that have no 3-D
    /// textures; the file lists where its slices lie [default: volume]
    #[arg(long, value_name = "volume|array")]
    slices: Option<String>,
    /// Where in its texel a value is taken: centers, (i + 1/2)/N, or edges, i/(N - 1) [default: centers]
    #[arg(long, value_name = "centers|edges")]
    points: Option<String>,
    /// Put the largest y coordinate into row 0 instead of the smallest
    #[arg(
        long,
        value_name = "true|false",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "true"
    )]
    flip_v: Option<bool>,
    /// Take every row where it belongs, for a target whose own tables have them one texel high
    #[arg(long, requires = "target")]
    exact_rows: bool,
    /// What the channels hold, in order; of layers A,B+C,D [default: scale,bias for split-sum]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    channels: Option<Vec<String>>,
    /// How texels are computed: direct, by quadrature at each; expansion, by a series through the quadrature at some
    /// thousand points, refused where the table is not smooth enough; or auto, whichever of both is right and costs less
    /// [default: direct]
    #[arg(long, value_name = "direct|expansion|auto")]
    rule: Option<String>,
    /// How texels are stored [default: half float where the container has it, single in source code]
    #[arg(long, value_name = "NAME")]
    encoding: Option<String>,
    #[command(flatten)]
    own: OwnArgs,
    #[command(flatten)]
    storage: StorageArgs,
}

/// What was asked for, with what the target sets, before it is known to be possible.
struct Asked {
    start: Instant,
    request: TableRequest,
    /// Of the tables in the layers behind it.
    behind: Vec<TableRequest>,
    map: Option<SliceAxis>,
    depth: u32,
    stacking: Option<Stacking>,
    albedo: Option<(PathBuf, Texture, Encoding)>,
    material: Option<String>,
    path: PathBuf,
    encoding: Option<Encoding>,
    /// Of the target: its encoding and its container's extension.
    preset: Option<(Encoding, &'static str)>,
    /// The target wants a plane for each channel.
    planes: bool,
    storage: StorageArgs,
    choice: Choice,
    own: OwnArgs,
}

/// A table to bake, checked before any work.
pub struct BakePlan {
    start: Instant,
    job: Job,
    albedo: Option<(PathBuf, Texture, Encoding)>,
    material: Option<String>,
    path: PathBuf,
    format: &'static dyn Format,
    storage: Storage,
    planes: bool,
    choice: Choice,
}

/// Carries out what was asked for.
pub fn run(bake: Given<BakeArgs>, device: &Device<'_>, console: &mut Console) -> Result<()> {
    let Given { arguments, names } = bake;
    if arguments.table == SET {
        return arguments.run_set(&names, device, console);
    }
    let asked = arguments.asked(Path::new(""))?;
    if !asked.own.given() {
        return asked.plan()?.run(device, None, console);
    }
    if !asked.behind.is_empty() {
        return Err(Error::usage("a BRDF of one's own has no layers", "bake one table after the other"));
    }
    if let Some(map) = asked.map {
        let what = format!("a BRDF of one's own has no axis {map} over slices");
        return Err(Error::usage(what, "leave it out of --axes"));
    }
    if asked.stacking.is_some() {
        return Err(Error::usage("a BRDF of one's own has no slices", "drop --slices"));
    }
    let Asked { request, choice, path, encoding, preset, storage, own, .. } = asked;
    own.bake(Wanted { request, choice, path, encoding, preset, storage }, device, console)
}

impl BakeArgs {
    /// Bakes every table of an engine, one file after the other: each appears whole or not at all.
    /// `given` names the arguments that the user gave.
    fn run_set(self, given: &[String], device: &Device<'_>, console: &mut Console) -> Result<()> {
        let Some(target) = self.target.as_deref().map(target::parse).transpose()? else {
            return Err(Error::usage("a set is that of an engine", "name it, e.g. bake set --for blender -o FOLDER"));
        };
        if let Some(name) = given.iter().find(|name| !OF_SET.contains(&name.as_str())) {
            return Err(Error::usage(
                format!("--{name} does not go with a set, whose tables are as {} takes them", target.name),
                "bake the table that should differ by its own name",
            ));
        }
        let folder = self.output.clone().unwrap_or_else(|| ".".into());
        std::fs::create_dir_all(&folder).map_err(|e| Error::io("create", &folder, e))?;
        for preset in target.tables {
            let output = Some(folder.join(preset.stem).with_extension(preset.extension));
            let one = BakeArgs { table: preset.stem.into(), output, ..self.clone() };
            one.plan(Path::new(""))?.run(device, None, console)?;
        }
        Ok(())
    }

    /// Refuses everything that can be refused before any work. `folder` is where a file goes that the target names.
    pub fn plan(self, folder: &Path) -> Result<BakePlan> {
        if self.own.given() {
            return Err(Error::usage("a BRDF of one's own is not baked from a recipe", "use `brdf-baker bake --glsl`"));
        }
        self.asked(folder)?.plan()
    }

    fn asked(self, folder: &Path) -> Result<Asked> {
        let start = Instant::now();
        let mut fresnel = match (self.exponent, self.f0, self.ior) {
            (Some(exponent), ..) => Some(Fresnel::power(exponent)?),
            (_, Some(f0), _) => Some(Fresnel::schlick(f0)?),
            // A film has air below it as well.
            (.., Some(1.0)) if self.film.is_some() => Some(Fresnel::interface(1.0)),
            _ => fresnel(self.ior, self.eta_k.as_deref(), self.material.as_deref())?,
        };
        let target = self.target.as_deref().map(target::parse).transpose()?;
        let preset = target.map(|t| t.table(&self.table)).transpose()?;
        let mut choice = Choice::of(target);
        let owned = |list: &[&str]| list.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let albedo = self.of.map(|path| read_albedo(path, &self.table)).transpose()?;
        let points = self.points.as_deref().map(Points::parse).transpose()?;
        let rule = self.rule.as_deref().map(RuleChoice::parse).transpose()?.unwrap_or_default();
        let stacking = self.slices.as_deref().map(Stacking::parse).transpose()?;
        let tables = preset.map_or(self.table, |p| p.table_name());
        let mut tables = tables.split(JOINT).map(String::from);
        let table = tables.next().unwrap_or_default();
        let behind: Vec<String> = tables.collect();
        let layers = 1 + behind.len();
        let channels = self.channels.map(|list| channels_of_layers(&list, layers)).transpose()?;
        let channels = choice.pick(
            "channels",
            channels.map(Some),
            // An exact Fresnel term has channels of its own.
            preset.filter(|_| fresnel.is_none()).map(|p| Some(p.layers().map(|p| owned(p.channels)).collect())),
            None,
        );
        let mut channels = (0..layers).map(|i| channels.as_ref().map(|list| list[i].clone()));
        let (own_axes, usual_request) = (bake::table(&table)?.facts().axes, TableRequest::new(&table));
        let of_preset = preset.map(|p| Some(p.axis_names()));
        let (axes, map) = split_axes(choice.pick("axes", self.axes.map(Some), of_preset, usual_request.axes))?;
        if let (Some(base), Some(film)) = (fresnel, &self.film) {
            fresnel = Some(on_base(base, film, map)?);
        }
        let one_axis = own_axes.len() == 1 || self.roughness.is_some();
        let given = self.size.map(|sizes| sizes.of(one_axis, map.is_some())).transpose()?;
        let usual = match map {
            None => (usual_request.size, 1),
            Some(_) => ((32, if one_axis { 1 } else { 32 }), 32),
        };
        let of_preset = preset.map(|p| (p.size, p.slices.map_or(1, |(_, depth)| depth)));
        let (size, depth) = choice.pick("size", given, of_preset, usual);
        let request = match &albedo {
            Some((path, texture, encoding)) => TableRequest::average_of(texture, *encoding)
                .map_err(|e| Error::input(path, e.to_string(), e.help().to_string()))?,
            None => TableRequest {
                size,
                ndf: choice.pick("ndf", self.ndf, preset.map(|p| p.ndf.into()), usual_request.ndf),
                visibility: choice.pick(
                    "visibility",
                    self.visibility,
                    preset.map(|p| p.visibility.into()),
                    usual_request.visibility,
                ),
                axes,
                roughness: self.roughness,
                points: choice.pick("points", points, preset.map(|p| p.points), usual_request.points),
                flip_v: choice.pick("flip-v", self.flip_v, preset.map(|p| p.flip_v), false),
                row_shift: choice.pick("exact-rows", self.exact_rows.then_some(0), preset.map(|p| p.row_shift), 0),
                channels: channels.next().flatten(),
                table,
                fresnel,
                of: None,
                rule,
            },
        };
        let of_layer = |(table, channels)| TableRequest { table, channels, ..request.clone() };
        let behind = behind.into_iter().zip(channels).map(of_layer).collect();
        let path = match (self.output, preset) {
            (Some(path), _) => path,
            (None, Some(preset)) => folder.join(format!("{}.{}", preset.stem, preset.extension)),
            (None, None) => unreachable!("the command line asks for either"),
        };
        let given = self.encoding.as_deref().map(Encoding::parse).transpose()?;
        let of_preset = preset.map(|p| Encoding::parse(p.encoding)).transpose()?;
        let planes = preset.is_some_and(|p| p.planes);
        let preset = of_preset.zip(preset.map(|p| p.extension));
        let (material, storage, own) = (self.material, self.storage, self.own);
        Ok(Asked {
            start,
            request,
            behind,
            map,
            depth,
            stacking,
            albedo,
            material,
            path,
            encoding: given,
            preset,
            planes,
            storage,
            choice,
            own,
        })
    }
}

impl Asked {
    fn plan(self) -> Result<BakePlan> {
        let (job, planes) = (self.job()?, self.planes);
        let Asked { start, albedo, material, path, encoding: given, preset, storage, choice, .. } = self;
        let shape = job.shape();
        let format = format::for_path(&path)?;
        let channels = job.tables()[0].channels.len();
        // Halves would round away what the average of stored texels is for, and what some tables hold.
        let single = Encoding::fitting(Repr::F32, channels).filter(|e| format.encodings(Shape::Table).contains(e));
        let is_fine = job.tables().iter().any(|table| table.table.usual().single);
        let needs_single = albedo.is_some() || (is_fine && preset.is_none());
        let given = given.or(single.filter(|_| needs_single));
        let mut choice = choice;
        let encoding = choice.encoding(format, shape, channels, given, preset.map(|(encoding, _)| encoding))?;
        let storage = storage.of(format, encoding)?;
        if let Some((_, extension)) = preset {
            choice.container(format, extension);
        }
        for table in job.tables() {
            for (i, channel) in table.channel_facts().enumerate() {
                let [low, high] = table.range(i);
                format::check_range(&path, format, encoding, channel.name, &(low..=high))?;
            }
        }
        let planes = planes && shape == Shape::Table && format.holds_planes();
        Ok(BakePlan { start, job, albedo, material, path, format, storage, planes, choice })
    }

    fn job(&self) -> Result<Job> {
        match self.map {
            Some(map) if self.behind.is_empty() => {
                let volume = VolumeJob::new(&self.request, map, self.depth)?;
                Ok(Job::Volume(volume.stacked(self.stacking.unwrap_or_default())?))
            }
            Some(map) => {
                Err(Error::usage(format!("tables over slices along {map} are no layers"), "bake one after the other"))
            }
            None if self.stacking.is_some() => {
                Err(Error::usage("the table has no axis over slices", "drop --slices, or name a third one in --axes"))
            }
            None if self.behind.is_empty() => Ok(Job::Flat(Box::new(self.request.resolve()?))),
            None => {
                let requests: Vec<TableRequest> = [&self.request].into_iter().chain(&self.behind).cloned().collect();
                Ok(Job::Layers(LayersJob::new(&requests)?))
            }
        }
    }
}

impl BakePlan {
    /// The file that is written.
    pub fn outputs(&self) -> Vec<&Path> {
        vec![&self.path]
    }

    /// Bakes, checks and writes; the file states its `origin` where it has one.
    pub fn run(self, device: &Device<'_>, origin: Option<&Origin>, console: &mut Console) -> Result<()> {
        let BakePlan { start, job, albedo, material, path, format, storage, planes, choice } = self;
        let (facts, shape, encoding) = (&job.tables()[0], job.shape(), storage.encoding);
        console.overrides(&choice);
        let output = Output::prepare(&path)?;

        // A weighted sum of texels is no work for a device, and some tables have no kernel.
        let backend = |table: &TableJob| match &albedo {
            Some(_) => Ok(&Backend::Cpu),
            None if table.table.usual().on_processor => device.processor(table.table.facts().name),
            None => device.backend(),
        };
        let backends: Vec<&Backend> = job.tables().iter().map(backend).collect::<Result<_>>()?;
        let mut texture = match &albedo {
            Some((_, albedo, encoding)) => facts.average(albedo, *encoding)?,
            None => job.run(&backends, &mut |p| console.progress(p))?,
        };
        let report = job.check(&texture, &mut |p| console.progress(p))?;
        if let Some(failure) = report.failures.first() {
            return Err(Error::Verify { what: format!("'{}' was not written: {failure}", path.display()) });
        }
        backends.iter().try_for_each(|backend| backend.check_messages())?;
        if let Some(name) = material.as_deref().or(albedo.as_ref().and_then(|(_, t, _)| t.meta.get("material"))) {
            texture.meta.set("material", name);
        }
        choice.describe(&mut texture.meta);
        if planes {
            texture.meta.set(format::PLANES, texture.channels.join(","));
        }
        report.state(job.bound(), &mut texture.meta);
        if let Some(origin) = origin {
            origin.state(&mut texture.meta);
        }
        let stored = format::certify(&mut texture, storage)?;
        if let Some(note) = texture.meta.get("rule.note") {
            console.warn(&format!("--rule auto: {note}"));
        }
        let written = output.commit(format, &texture, stored)?;
        storage::warn_of_lost_meta(format, &path, console);

        let seconds = start.elapsed().as_secs_f64();
        let (width, height) = (texture.width, texture.height);
        let slices = job.slices();
        let size = match shape.slices() {
            Some(slices) => format!("{width}x{height}x{slices}"),
            None => format!("{width}x{height}"),
        };
        let mut devices: Vec<&str> = backends.iter().map(|backend| backend.name()).collect();
        devices.dedup();
        let device = devices.join(", ");
        let longest = backends.iter().filter_map(|backend| backend.longest_dispatch_ms()).max_by(f64::total_cmp);
        let (worst, rounding) = (report.worst() + report.truth_error, written.rounding.most.max_abs);
        console.result(
            &format!(
                "{}  {size} {}  max error {worst:.1e} (+ {rounding:.1e} rounding)  {seconds:.2} s  {device}",
                path.display(),
                encoding.name,
            ),
            &json!({
                "path": path,
                "table": texture.meta.get("table"),
                "width": width,
                "height": height,
                "slices": slices,
                "layers": job.layers(),
                "encoding": encoding.name,
                "bytes": written.bytes,
                "max_error": worst,
                "median_error": report.median(),
                "rounding": rounding,
                "rounding_rms": written.rounding.most.rms,
                "checked_texels": report.truth_texels,
                "rule": texture.meta.get("rule"),
                "rule_note": texture.meta.get("rule.note"),
                "output_texels": texture.levels[0].len() / texture.channels.len(),
                "longest_dispatch_ms": longest,
                "seconds": seconds,
                "device": device,
            }),
        )
    }
}

/// A table, one over slices, or several in layers.
enum Job {
    Flat(Box<TableJob>),
    Volume(VolumeJob),
    Layers(LayersJob),
}

impl Job {
    /// The table, or the tables of the layers; over slices the first, whose channels and axes all share.
    fn tables(&self) -> &[TableJob] {
        match self {
            Job::Flat(job) => std::slice::from_ref(job),
            Job::Volume(volume) => &volume.slices()[..1],
            Job::Layers(layers) => layers.layers(),
        }
    }

    fn slices(&self) -> Option<usize> {
        match self {
            Job::Flat(_) | Job::Layers(_) => None,
            Job::Volume(volume) => Some(volume.slices().len()),
        }
    }

    fn layers(&self) -> Option<usize> {
        match self {
            Job::Flat(_) | Job::Volume(_) => None,
            Job::Layers(layers) => Some(layers.layers().len()),
        }
    }

    fn shape(&self) -> Shape {
        match self {
            Job::Flat(_) => Shape::Table,
            Job::Volume(volume) => volume.shape(),
            Job::Layers(layers) => layers.shape(),
        }
    }

    /// What the loosest texel keeps, before rounding.
    fn bound(&self) -> f64 {
        let tables = match self {
            Job::Flat(_) | Job::Layers(_) => self.tables(),
            Job::Volume(volume) => volume.slices(),
        };
        tables.iter().map(|job| job.loosest().worst).fold(0.0, f64::max)
    }

    /// Bakes where `backends` says, of each of [`Job::tables`].
    fn run(&self, backends: &[&Backend], on: &mut OnProgress<'_>) -> Result<Texture> {
        match self {
            Job::Flat(job) => job.run(backends[0], on),
            Job::Volume(volume) => volume.run(backends[0], on),
            Job::Layers(layers) => layers.run(backends, on),
        }
    }

    /// A spot check of what was baked.
    fn check(&self, texture: &Texture, on: &mut OnProgress<'_>) -> Result<TableReport> {
        match self {
            Job::Flat(job) => check(job, texture, None, Extent::Spot, on),
            Job::Volume(volume) => Ok(volume.check(texture, None, Extent::Spot, on)?.all),
            Job::Layers(layers) => Ok(layers.check(texture, None, Extent::Spot, on)?.all),
        }
    }
}

/// An axis over slices apart from the others, which it follows.
fn split_axes(axes: Option<Vec<String>>) -> Result<(Option<Vec<String>>, Option<SliceAxis>)> {
    let Some(mut axes) = axes else { return Ok((None, None)) };
    match axes.last().and_then(|last| SliceAxis::parse(last)).transpose()? {
        None => Ok((Some(axes), None)),
        Some(map) => {
            axes.pop();
            Ok((Some(axes), Some(map)))
        }
    }
}

/// The names of the channels of each layer: `a`, `b+c`, `d` are a and b of the first and c and d of the second.
fn channels_of_layers(names: &[String], layers: usize) -> Result<Vec<Vec<String>>> {
    let joined = names.join(",");
    let list: Vec<Vec<String>> =
        joined.split(JOINT).map(|layer| layer.split(',').map(String::from).collect()).collect();
    if list.len() == layers {
        return Ok(list);
    }
    let what = format!("--channels names those of {} tables, but there are {layers}", list.len());
    Err(Error::usage(what, format!("join the lists by {JOINT}, one for each table")))
}

/// One to three numbers of texels.
#[derive(Clone, Debug, PartialEq)]
struct Sizes(Vec<u32>);

impl Sizes {
    /// The size of a slice and the number of slices, of a table that has one axis or two without that over the slices.
    fn of(&self, one_axis: bool, sliced: bool) -> Result<((u32, u32), u32)> {
        match (self.0.as_slice(), sliced) {
            ([n], false) => Ok(((*n, *n), 1)),
            ([w, h], false) => Ok(((*w, *h), 1)),
            ([n], true) => Ok(((*n, if one_axis { 1 } else { *n }), *n)),
            ([w, d], true) if one_axis => Ok(((*w, 1), *d)),
            ([w, h, d], true) if !one_axis => Ok(((*w, *h), *d)),
            (numbers, _) => {
                let axes = usize::from(!one_axis) + usize::from(sliced) + 1;
                let sizes = numbers.iter().map(u32::to_string).collect::<Vec<_>>().join("x");
                let what = format!("--size {sizes} has {} numbers, but the table has {axes} axes", numbers.len());
                Err(Error::usage(what, "give one number, or one for each axis; `list tables` has the axes"))
            }
        }
    }
}

/// `N`, `WxH` or `WxHxD`.
fn parse_sizes(text: &str) -> Result<Sizes, String> {
    let number = |s: &str| s.parse::<u32>().map_err(|_| format!("'{s}' is not a number of texels"));
    let numbers = text.split('x').map(number).collect::<Result<Vec<_>, _>>()?;
    if numbers.len() > 3 { Err("more than three numbers".into()) } else { Ok(Sizes(numbers)) }
}

/// The albedo table that `--of` names, with its path.
fn read_albedo(path: PathBuf, table: &str) -> Result<(PathBuf, Texture, Encoding)> {
    if table != "average-albedo" {
        let what = format!("--of takes the average of an albedo table, which {table} is not");
        return Err(Error::usage(what, "bake average-albedo --of FILE"));
    }
    let (texture, encoding) = format::for_path(&path)?.read(&path)?;
    Ok((path, texture, encoding))
}

/// The Fresnel term that was asked for; `None` for the table's own.
fn fresnel(ior: Option<f64>, eta_k: Option<&[f64]>, material: Option<&str>) -> Result<Option<Fresnel>> {
    let term = match (ior, eta_k, material) {
        (Some(ior), ..) => Fresnel::dielectric(ior)?,
        (_, Some([eta, k]), _) => Fresnel::conductor([*eta; 3], [*k; 3])?,
        (_, Some([er, eg, eb, kr, kg, kb]), _) => Fresnel::conductor([*er, *eg, *eb], [*kr, *kg, *kb])?,
        (_, Some(other), _) => {
            return Err(Error::usage(
                format!("--eta-k got {} numbers", other.len()),
                "give 2, eta and k, or 6, eta of red, green and blue and then k of red, green and blue",
            ));
        }
        (.., Some(name)) => material::parse(name)?.fresnel()?,
        (None, None, None) => return Ok(None),
    };
    Ok(Some(term))
}

/// A film on a base: index and thickness, which an axis may have.
fn on_base(base: Fresnel, film: &[f64], axis: Option<SliceAxis>) -> Result<Fresnel> {
    match (film, axis) {
        ([ior], Some(SliceAxis::FilmNm(_))) => Fresnel::film(base, *ior, 0.0),
        ([ior, nm], None) => Fresnel::film(base, *ior, *nm),
        _ => Err(Error::usage(
            format!("--film got {} numbers", film.len()),
            "give index and thickness in nm, or the index alone with a last axis of thicknesses, film_nm=FROM/TO",
        )),
    }
}

/// `N` or `WxH`.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let number = |s: &str| s.parse::<u32>().map_err(|_| format!("'{s}' is not a number of texels"));
    match text.split_once('x') {
        None => number(text).map(|n| (n, n)),
        Some((width, height)) => Ok((number(width)?, number(height)?)),
    }
}

#[cfg(test)]
mod tests {
    use super::{Sizes, parse_size, parse_sizes};

    #[test]
    fn size_is_one_or_two_numbers() {
        assert_eq!(parse_size("256"), Ok((256, 256)));
        assert_eq!(parse_size("128x32"), Ok((128, 32)));
        let sizes = |text| parse_sizes(text).map(|sizes: Sizes| sizes.0);
        assert_eq!((sizes("16"), sizes("8x4"), sizes("16x8x4")), (Ok(vec![16]), Ok(vec![8, 4]), Ok(vec![16, 8, 4])));
        assert!(sizes("1x2x3x4").is_err() && sizes("8xx").is_err());
        assert!(parse_size("128x").is_err() && parse_size("-1").is_err() && parse_size("big").is_err());
    }
}
