// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker env`

use std::path::{Path, PathBuf};
use std::time::Instant;

use brdf_baker::bake::Backend;
use brdf_baker::bake::atlas::{self, Atlas};
use brdf_baker::bake::specular::{CLAMPED, SpecularJob, SpecularRequest};
use brdf_baker::env::FileAxes;
use brdf_baker::env::import::{self, Imported, Options};
use brdf_baker::env::projection::Projection;
use brdf_baker::env::sh::{self, Window};
use brdf_baker::format::{self, Encoding, Format, Loss, Output, Repr, Rounding, Storage, harmonics};
use brdf_baker::progress::Progress;
use brdf_baker::recipe::Origin;
use brdf_baker::target::{self, Choice, EnvironmentPreset, Target};
use brdf_baker::term::zonal::{self, ZONALS};
use brdf_baker::texture::Texture;
use brdf_baker::verify::environment::{self, Summary};
use brdf_baker::{Error, Result};
use serde_json::{Value, json};

use super::console::Console;
use super::device::Device;
use super::source::{self, SourceArgs};
use super::storage::{self, StorageArgs};

/// Texels along an edge of the irradiance unless told otherwise.
const DIFFUSE_SIZE: u32 = 64;
/// Texels along an edge in blocks of bc6h, unless told otherwise: half the bytes of 512 in half floats, and photographs keep
/// to [`MUCH`], the first mip included.
const SIZE_IN_BLOCKS: u32 = 1024;
/// A root mean square of relative losses that blocks should not exceed.
const MUCH: f64 = 0.01;

#[derive(clap::Args)]
pub struct EnvArgs {
    /// Environment: a file, a folder of six faces, a path with {face} in it, or six paths joined by commas
    input: PathBuf,
    /// File to write: .ktx2 .exr .dds .ktx .env; a map of one level .hdr .png too [default: the input's name and the target's
    /// ending]
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["irradiance", "sh", "target"])]
    output: Option<PathBuf>,
    /// Engine that loads the files: sets all that follows and is not given, and what is written beside the map; see
    /// `brdf-baker list targets`
    #[arg(long = "for", value_name = "ENGINE")]
    target: Option<String>,
    /// Filter kernel; `brdf-baker list kernels` says more [default: ggx]
    #[arg(long, value_name = "NAME")]
    kernel: Option<String>,
    /// Layout: six faces, a picture twice as wide as high, or an octahedral square with +Y in the middle [default: cube]
    #[arg(long, value_name = "cube|equirect|octahedral|playcanvas-atlas")]
    shape: Option<String>,
    /// Texels along an edge of mip 0; the height of an equirect [default: 256, 1024 with bc6h, 64 for lambert]
    #[arg(long, value_name = "N")]
    size: Option<u32>,
    /// Number of mips, mip 0 included [default: down to one texel]
    #[arg(long, value_name = "N")]
    mips: Option<u32>,
    /// Roughness of mip m of M + 1: linear, m/M, quadratic, 1 - sqrt(1 - m/M), or that of an engine; see `brdf-baker list
    /// laws` [default: linear]
    #[arg(long, value_name = "NAME")]
    roughness_law: Option<String>,
    /// What of the environment the file's (x, y, z) shows, for engines that turn directions round: x,y,-z shows at +Z what
    /// lies at -Z [default: x,y,z]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    file_axes: Option<String>,
    /// Error against time: of every mip 1e-2, 1e-3 or 2.5e-4 rms
    #[arg(long, default_value = "standard", value_name = "draft|standard|reference")]
    quality: String,
    /// How texels are stored [default: half floats where the format has them]
    #[arg(long, value_name = "NAME")]
    encoding: Option<String>,
    #[command(flatten)]
    storage: StorageArgs,
    /// Also write the irradiance over pi, one level of the same shape
    #[arg(long, value_name = "FILE")]
    irradiance: Option<PathBuf>,
    /// Texels along an edge of the irradiance [default: 64]
    #[arg(long, value_name = "N")]
    irradiance_size: Option<u32>,
    /// Also write spherical harmonics of radiance and irradiance, as JSON
    #[arg(long, value_name = "FILE")]
    sh: Option<PathBuf>,
    /// Highest band of --sh: 2 (9 coefficients), 3 (16) or 4 (25)
    #[arg(long, default_value_t = 2, value_name = "L", requires = "sh")]
    sh_order: u32,
    /// What the bands of --sh are multiplied with, against ringing
    #[arg(long, default_value = "none", value_name = "none|hanning|lanczos", requires = "sh")]
    sh_window: String,
    #[command(flatten)]
    source: SourceArgs,
}

/// A map to write, checked before any work.
struct Wanted {
    path: PathBuf,
    job: SpecularJob,
    format: &'static dyn Format,
    storage: Storage,
    choice: Choice,
    /// The tiles are packed into one picture; `job` is their chain.
    atlas: Option<Atlas>,
}

/// How a map is stored, as the user and the target word it.
#[derive(Clone, Copy)]
struct Stored<'a> {
    given: Option<Encoding>,
    preset: Option<&'static EnvironmentPreset>,
    args: &'a StorageArgs,
}

impl Wanted {
    fn new(path: PathBuf, request: &SpecularRequest, stored: Stored<'_>, mut choice: Choice) -> Result<Wanted> {
        let atlas = atlas_of(request)?;
        let job = atlas.as_ref().map_or_else(|| request.resolve(), |atlas| Ok(atlas.specular.clone()))?;
        let levels = if atlas.is_some() { 1 } else { job.mips };
        let format = format::for_path(&path)?;
        let of_preset = stored.preset.map(|p| Encoding::parse(p.encoding)).transpose()?;
        let encoding = choice.encoding(format, job.shape(), 3, stored.given, of_preset)?;
        let storage = stored.args.of(format, encoding)?;
        if let Some(preset) = stored.preset {
            choice.container(format, preset.extension);
        }
        if levels > 1 && !format.holds_mips() {
            let what = format!("{} holds one level, not the {levels} of '{}'", format.name(), path.display());
            return Err(Error::usage(what, "use --mips 1, or write a .ktx2 or .exr file"));
        }
        format.accepts(job.size, levels)?;
        Ok(Wanted { path, job, format, storage, choice, atlas })
    }

    /// Bakes, and refuses to go on with a result that its own check finds wrong.
    fn bake(
        &self,
        source: &Source<'_>,
        irradiance: &harmonics::Irradiance,
        backend: &Backend,
        console: &mut Console,
    ) -> Result<Baked> {
        let environment = &source.imported.environment;
        let on = &mut |p: Progress<'_>| console.progress(p);
        let spot = environment::Extent::after_baking(self.job.quality, environment);
        let mut texture = self.job.run(environment, backend, on)?;
        let mut errors = environment::check(&self.job, environment, &texture, spot, on)?;
        let mut filtered = self.job.filtered().len();
        if let Some(atlas) = &self.atlas {
            let ambient = atlas.ambient.run(environment, backend, on)?;
            errors.extend(environment::check(&atlas.ambient, environment, &ambient, spot, on)?);
            filtered += 1;
            texture = atlas.pack(environment, &texture, &ambient, on)?;
        }
        let summary = Summary::of(&errors);
        let Summary { rms, worst, texels } = summary;
        let bound = self.job.quality.worst_bound;
        // Written so that NaN is refused.
        if !(worst <= bound && errors.len() == filtered) {
            let what = format!(
                "'{}' was not written: a texel is off by {worst:.1e} of its value, more than {bound:.1e}",
                self.path.display(),
            );
            return Err(Error::Verify { what });
        }
        texture.meta.set("input", &source.name);
        source.options.describe(source.imported, &mut texture.meta);
        self.choice.describe(&mut texture.meta);
        summary.state(self.job.quality, &mut texture.meta);
        if let Some(origin) = source.origin {
            origin.state(&mut texture.meta);
        }
        let most = *self.storage.encoding.repr.range().end();
        if texture.levels.iter().flatten().any(|v| *v > most) {
            texture.meta.set(CLAMPED, most);
        }
        harmonics::state(irradiance, &mut texture.meta);
        let stored = format::certify(&mut texture, self.storage)?;
        Ok(Baked { texture, stored, rms, worst, texels })
    }

    /// Writes what was baked, and says so.
    fn write(
        self,
        output: Output,
        baked: Baked,
        source: &Source<'_>,
        start: Instant,
        backend: &Backend,
        console: &mut Console,
    ) -> Result<()> {
        let Wanted { path, job, format, storage, choice, atlas } = self;
        let encoding = storage.encoding;
        let Baked { texture, stored, rms, worst, texels } = baked;
        let written = output.commit(format, &texture, stored)?;
        storage::warn_of_lost_meta(format, &path, console);
        if written.rounding.clamped > 0 {
            console.warn(&format!(
                "{} values of '{}' exceed {}, the most that {} holds, and were clamped; --encoding rgba32f in a .ktx2 or .exr \
                 file keeps them, a lower --exposure too",
                written.rounding.clamped,
                path.display(),
                encoding.repr.range().end(),
                encoding.name
            ));
        }
        let seconds = start.elapsed().as_secs_f64();
        let shape = if atlas.is_some() { atlas::NAME } else { job.projection.name() };
        let faces = if job.projection == Projection::Cube { "6x" } else { "" };
        let levels = if texture.levels.len() == 1 { "1 level".into() } else { format!("{} mips", job.mips) };
        let rounding = &written.rounding;
        let found = match texels {
            0 => "resampled, not filtered".into(),
            _ => format!("max error {worst:.1e} relative, rms {rms:.1e} of {texels} texels"),
        };
        let losses = if encoding.repr.is_blocks() { losses(encoding.name, rounding) } else { String::new() };
        console.result(
            &format!(
                "{}  {faces}{}x{}, {levels} {}  {found} (+ {:.1e} rounding)  {seconds:.2} s  {}{losses}",
                path.display(),
                texture.width,
                texture.height,
                encoding.name,
                rounding.most.max_rel,
                backend.name()
            ),
            &json!({
                "path": path,
                "source": source.path,
                "layout": source.imported.layout,
                "negative_texels": source.imported.adjusted.negative.map_or(0, |n| n.count),
                "repaired_texels": source.imported.adjusted.repaired,
                "dimmed_texels": source.imported.adjusted.clamped,
                "removed_energy": source.imported.adjusted.removed,
                "kernel": job.kernel.name,
                "shape": shape,
                "size": job.size,
                "mips": job.mips,
                "quality": job.quality.name,
                "target": choice.target(),
                "encoding": encoding.name,
                "bytes": written.bytes,
                "max_error": worst,
                "rms_error": rms,
                "rounding": rounding.most.max_rel,
                "rounding_relative_rms": rounding.most.rms_rel,
                "rounding_rms": rounding.most.rms,
                "rounding_mips": rounding.levels.iter().map(loss_json).collect::<Vec<_>>(),
                "rounding_whole": loss_json(&rounding.whole),
                "rounding_filtered": rounding.filtered.as_ref().map(loss_json),
                "clamped": rounding.clamped,
                "checked_texels": texels,
                "output_texels": texture.levels.iter().map(|l| l.len() / texture.channels.len()).sum::<usize>(),
                "source_texels": source.imported.environment.picture.texels().len(),
                "longest_dispatch_ms": backend.longest_dispatch_ms(),
                "seconds": seconds,
                "peak_memory_bytes": peak_memory_bytes(),
                "device": backend.name(),
            }),
        )
    }
}

/// The input of a run.
struct Source<'a> {
    path: &'a Path,
    /// The file's or folder's own name.
    name: String,
    options: &'a Options,
    imported: &'a Imported,
    origin: Option<&'a Origin>,
}

/// A baked map and what its own check found.
struct Baked {
    texture: Texture,
    stored: format::Stored,
    rms: f64,
    worst: f64,
    texels: u32,
}

/// The maps of an environment, checked before any work.
pub struct EnvPlan {
    start: Instant,
    input: PathBuf,
    /// The input's own name.
    name: String,
    options: Options,
    wanted: Vec<Wanted>,
    harmonics: Option<Harmonics>,
}

/// The spherical harmonics to write.
struct Harmonics {
    path: PathBuf,
    order: u32,
    window: Window,
}

impl EnvArgs {
    pub fn run(self, device: &Device<'_>, console: &mut Console) -> Result<()> {
        self.plan(Path::new(""))?.run(device, None, console)
    }

    /// Refuses everything that can be refused before any work. `folder` is where files go that the target names.
    pub fn plan(self, folder: &Path) -> Result<EnvPlan> {
        let start = Instant::now();
        let target = self.target.as_deref().map(target::parse).transpose()?;
        let preset = target.map(Target::environment).transpose()?;
        let stored =
            Stored { given: self.encoding.as_deref().map(Encoding::parse).transpose()?, preset, args: &self.storage };
        let mut choice = Choice::of(target);
        let shape = choice.pick("shape", self.shape, preset.map(|p| p.shape.into()), "cube".into());
        let kernel = choice.pick("kernel", self.kernel, preset.map(|_| "ggx".into()), "ggx".into());
        let is_in_blocks = stored.given.is_some_and(|e| e.repr == Repr::Bc6h) && shape != atlas::NAME;
        let has_width = zonal::parse(&kernel).is_ok_and(|kernel| kernel.least_alpha.is_some());
        let default = (is_in_blocks && has_width).then_some(SIZE_IN_BLOCKS);
        let size = choice.pick("size", self.size.map(Some), preset.map(|p| Some(p.size)), default);
        let request = SpecularRequest {
            kernel,
            mips: choice.pick("mips", self.mips.map(Some), preset.zip(size).map(|(p, n)| Some(p.mips.of(n))), None),
            roughness_law: choice.pick(
                "roughness-law",
                self.roughness_law,
                preset.map(|p| p.law.name().into()),
                "linear".into(),
            ),
            shape,
            size,
            quality: self.quality,
            gutter: 0,
        };
        let file_axes = choice.pick(
            "file-axes",
            self.file_axes.as_deref().map(FileAxes::parse).transpose()?,
            preset.map(|p| FileAxes::parse(p.file_axes)).transpose()?,
            FileAxes::IDENTITY,
        );
        let name = self.input.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let path = self.output.or_else(|| preset.map(|p| folder.join(default_path(&name, p))));
        let mut wanted = vec![];
        let mut irradiance = self.irradiance;
        let mut irradiance_size = self.irradiance_size;
        if let Some(path) = path {
            let file = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            for (preset, beside) in preset.iter().flat_map(|p| p.beside.iter().map(move |beside| (*p, beside))) {
                let path = path.with_file_name(target::beside_name(&file, preset, beside));
                match beside.content {
                    target::Content::Diffuse => {
                        irradiance = irradiance.or(Some(path));
                        irradiance_size = irradiance_size.or(beside.size);
                    }
                    target::Content::Skybox => {
                        let request = SpecularRequest { size: beside.size.or(size), mips: Some(1), ..request.clone() };
                        wanted.push(Wanted::new(path, &request, stored, Choice::of(target))?);
                    }
                }
            }
            let map = Wanted::new(path, &request, stored, choice)?;
            wanted.insert(0, map);
        }
        if let Some(path) = irradiance {
            let size = Some(irradiance_size.unwrap_or(DIFFUSE_SIZE));
            let request = SpecularRequest { kernel: "lambert".into(), size, mips: None, ..request };
            wanted.push(Wanted::new(path, &request, stored, Choice::of(target))?);
        }
        sh::check_order(self.sh_order)?;
        let window = Window::parse(&self.sh_window)?;
        let harmonics = self.sh.map(|path| Harmonics { path, order: self.sh_order, window });
        let options = self.source.options(file_axes)?;
        Ok(EnvPlan { start, input: self.input, name, options, wanted, harmonics })
    }
}

impl EnvPlan {
    /// The files that are written.
    pub fn outputs(&self) -> Vec<&Path> {
        let maps = self.wanted.iter().map(|wanted| wanted.path.as_path());
        maps.chain(self.harmonics.iter().map(|harmonics| harmonics.path.as_path())).collect()
    }

    /// Bakes, checks and writes; the files state their `origin` where they have one.
    pub fn run(self, device: &Device<'_>, origin: Option<&Origin>, console: &mut Console) -> Result<()> {
        let EnvPlan { start, input, name, options, wanted, harmonics } = self;
        if let Some(map) = wanted.first() {
            console.overrides(&map.choice);
        }
        let outputs: Vec<Output> = wanted.iter().map(|wanted| Output::prepare(&wanted.path)).collect::<Result<_>>()?;
        let harmonics = harmonics.map(|h| Ok((Output::prepare(&h.path)?, h))).transpose()?;
        let imported = import::read(&input, &options, &mut |p| console.progress(p))?;
        source::warn(&input, &options, &imported, console);
        origin.map_or(Ok(()), Origin::check)?;
        let source = Source { path: &input, name, options: &options, imported: &imported, origin };

        // All results before the first file.
        let coefficients = harmonics.as_ref().map(|(_, h)| sh::project(&imported.environment, h.order));
        if !wanted.is_empty() {
            let backend = device.backend()?;
            let irradiance = harmonics::irradiance(&imported.environment);
            let bake = |wanted: &Wanted| wanted.bake(&source, &irradiance, backend, console);
            let baked: Vec<Baked> = wanted.iter().map(bake).collect::<Result<_>>()?;
            backend.check_messages()?;
            for ((wanted, output), baked) in wanted.into_iter().zip(outputs).zip(baked) {
                wanted.write(output, baked, &source, start, backend, console)?;
            }
        }
        if let (Some((output, Harmonics { path, order, window })), Some(coefficients)) = (harmonics, coefficients) {
            let mut content = format::sh_json(&coefficients, order, window, &source.name);
            if let Some(origin) = origin {
                origin.state_in_json(&mut content);
            }
            let bytes = output.commit_bytes(format!("{content:#}\n").as_bytes())?;
            let seconds = start.elapsed().as_secs_f64();
            let count = coefficients.len();
            console.result(
                &format!("{}  {count} coefficients, l <= {order}  exact  {seconds:.2} s", path.display()),
                &json!({
                    "path": path,
                    "source": input,
                    "order": order,
                    "window": window.name(),
                    "coefficients": count,
                    "bytes": bytes,
                    "seconds": seconds,
                    "peak_memory_bytes": peak_memory_bytes(),
                }),
            )?;
        }
        Ok(())
    }
}

/// A line a mip on what an encoding whose loss depends on the texels did to them, one on the filtered mips together and one on
/// all, with the way out where they lose much.
fn losses(encoding: &str, rounding: &Rounding) -> String {
    let line = |name: String, loss: &Loss| {
        format!(
            "\n  {name:10} {encoding} loses {:.2} % of each value (relative rms), {:.2} % of the rms, {:.1} % of a value at most",
            100.0 * loss.rms_rel,
            100.0 * loss.rms,
            100.0 * loss.max_rel
        )
    };
    let mips = rounding.levels.iter().enumerate().map(|(i, loss)| line(format!("mip {i}"), loss));
    let together = rounding.filtered.iter().flat_map(|filtered| {
        let last = rounding.levels.len() - 1;
        [line(format!("mips 1-{last}"), filtered), line("all mips".into(), &rounding.whole)]
    });
    let is_much = [Some(rounding.whole), rounding.filtered].into_iter().flatten().any(|loss| loss.rms_rel > MUCH);
    let help = is_much.then(|| "\n  a larger --size loses less: twice the size about half".to_string());
    mips.chain(together).chain(help).collect()
}

fn loss_json(loss: &Loss) -> Value {
    json!({ "relative_rms": loss.rms_rel, "rms": loss.rms, "relative": loss.max_rel, "absolute": loss.max_abs })
}

/// The atlas that a request asks for.
fn atlas_of(request: &SpecularRequest) -> Result<Option<Atlas>> {
    if request.shape != atlas::NAME {
        return Ok(None);
    }
    let atlas = Atlas::new(request.size.unwrap_or(atlas::SIDE), &request.quality)?;
    let job = &atlas.specular;
    let own = request.kernel == job.kernel.name
        && request.roughness_law == job.law.name()
        && request.mips.is_none_or(|mips| mips == job.mips);
    if own {
        return Ok(Some(atlas));
    }
    let what = format!("an atlas has {} mips of {} by the law {}", job.mips, job.kernel.name, job.law.name());
    Err(Error::usage(what, "leave --kernel, --mips and --roughness-law to --for playcanvas"))
}

/// Where a target's map goes that the user gave no name: into the working folder.
fn default_path(input: &str, preset: &EnvironmentPreset) -> PathBuf {
    let stem = import::stem(Path::new(input));
    format!("{stem}{}.{}", preset.suffix, preset.extension).into()
}

/// The most memory that the process has held, where the system says so.
fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// Name, one line and source of every kernel, for lists.
pub fn kernels() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    ZONALS.iter().map(|k| (k.name, k.about, k.source))
}
