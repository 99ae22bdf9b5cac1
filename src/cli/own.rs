// SPDX-License-Identifier: MIT OR Apache-2.0
//! `bake --glsl` and `verify --glsl`: a BRDF of one's own.

use std::path::{Path, PathBuf};
use std::time::Instant;

use brdf_baker::bake::own::{OwnJob, OwnOptions, OwnSource, Precision, usual_most};
use brdf_baker::bake::{Backend, TableRequest};
use brdf_baker::format::{self, Encoding, Output, Steps};
use brdf_baker::progress::Progress;
use brdf_baker::target::Choice;
use brdf_baker::texture::{Shape, Texture};
use brdf_baker::verify::certificate::Certificate;
use brdf_baker::verify::own::check;
use brdf_baker::verify::table::Extent;
use brdf_baker::{Error, Result, glsl};
use serde_json::json;

use super::Global;
use super::console::Console;
use super::device::Device;
use super::storage::{self, StorageArgs};
use super::verify::{Checked, exceeds};

#[derive(clap::Args, Clone)]
pub struct OwnArgs {
    /// Bake this BRDF of your own: GLSL with `vec3 brdf(vec3 l, vec3 v, float alpha)`, or D and V; see docs/own-brdf.md
    #[arg(long, value_name = "FILE.glsl", conflicts_with_all = ["ndf", "visibility", "fresnel", "of", "rule"])]
    glsl: Option<PathBuf>,
    /// With --glsl: rows of a smaller roughness hold the values of this one, as in a shader that clamps there [default: 0]
    #[arg(long, value_name = "R", requires = "glsl")]
    min_roughness: Option<f64>,
    /// With --glsl: evaluate in double precision, where `float` means double, or in single [default: double where the
    /// device can]
    #[arg(long, value_name = "double|single", requires = "glsl")]
    precision: Option<String>,
    /// With --glsl: largest estimate of a texel's error that is accepted [default: 2e-5, in single precision 2e-4]
    #[arg(long, value_name = "X", requires = "glsl", allow_hyphen_values = true)]
    max_estimate: Option<f64>,
    /// With --glsl: also write the estimate of every texel's error, as a table of single floats
    #[arg(long, value_name = "FILE", requires = "glsl")]
    estimates: Option<PathBuf>,
}

/// What `bake` was told beside.
pub struct Wanted {
    pub request: TableRequest,
    pub choice: Choice,
    pub path: PathBuf,
    pub encoding: Option<Encoding>,
    /// Of the target: its encoding and its container's extension.
    pub preset: Option<(Encoding, &'static str)>,
    pub storage: StorageArgs,
}

impl OwnArgs {
    /// Is there a BRDF of one's own?
    pub fn given(&self) -> bool {
        self.glsl.is_some()
    }

    /// `bake --glsl`
    pub fn bake(self, mut wanted: Wanted, device: &Device<'_>, console: &mut Console) -> Result<()> {
        let start = Instant::now();
        let source = read(self.glsl.as_deref().unwrap_or(Path::new("")))?;
        let format = format::for_path(&wanted.path)?;
        let least_roughness = in_range("--min-roughness", self.min_roughness, 0.0, 1.0)?.unwrap_or(0.0);
        let most = in_range("--max-estimate", self.max_estimate, 1e-8, 1.0)?;
        let precision = self.precision.as_deref().map(Precision::parse).transpose()?;
        let estimates = self.estimates.as_deref().map(|path| prepare_estimates(path, &wanted.path)).transpose()?;
        let output = Output::prepare(&wanted.path)?;

        let backend = device.backend()?;
        let double = matches!(backend, Backend::Gpu(gpu) if gpu.info().float64);
        if !double && precision.is_none() && matches!(backend, Backend::Gpu(_)) {
            console.warn(&format!("{} does not compute in double precision: single is used", backend.name()));
        }
        let precision = precision.unwrap_or(if double { Precision::Double } else { Precision::Single });
        let most = most.unwrap_or(usual_most(precision));
        let options = OwnOptions { least_roughness, most, precision };
        let on = &mut |p: Progress<'_>| console.progress(p);
        let job = OwnJob::new(&wanted.request, source, options, backend, on)?;
        let channels = job.table().channels.len();
        let of_preset = wanted.preset.map(|(encoding, _)| encoding);
        let encoding = wanted.choice.encoding(format, Shape::Table, channels, wanted.encoding, of_preset)?;
        let storage = wanted.storage.of(format, encoding)?;
        if let Some((_, extension)) = wanted.preset {
            wanted.choice.container(format, extension);
        }
        console.overrides(&wanted.choice);

        let on = &mut |p: Progress<'_>| console.progress(p);
        let mut baked = job.run(on)?;
        let report = check(&job, &baked.texture, None, Extent::Spot, on)?;
        let name = wanted.path.display().to_string();
        if let Some(failure) = report.failures.first() {
            return Err(Error::Verify { what: format!("'{name}' was not written: {failure}") });
        }
        backend.check_messages()?;
        let texture = &mut baked.texture;
        for (c, channel) in texture.channels.iter().enumerate() {
            let values = || texture.levels[0].iter().skip(c).step_by(channels).copied();
            let range = values().fold(f32::INFINITY, f32::min)..=values().fold(f32::NEG_INFINITY, f32::max);
            format::check_range(&wanted.path, format, encoding, channel, &range)?;
        }
        wanted.choice.describe(&mut texture.meta);
        let worst = report.worst() + report.reference_error;
        texture.meta.set("error.worst", format!("{worst:.2e}"));
        texture.meta.set("error.median", format!("{:.2e}", report.median()));
        texture.meta.set("error.checked", format!("{} texels against a finer adaptive rule", report.texels));
        let stored = format::certify(texture, storage)?;
        let estimate = baked.estimates.levels[0].iter().copied().fold(0.0, f32::max);
        let written = output.commit(format, texture, stored)?;
        storage::warn_of_lost_meta(format, &wanted.path, console);
        if let Some((output, format, encoding)) = estimates {
            for (key, value) in [("table", "estimates"), ("estimates.of", name.as_str())] {
                baked.estimates.meta.set(key, value);
            }
            output.commit(format, &baked.estimates, encoding)?;
        }
        for warning in &baked.warnings {
            console.warn(warning);
        }

        let (width, height) = (texture.width, texture.height);
        let seconds = start.elapsed().as_secs_f64();
        console.result(
            &format!(
                "{name}  {width}x{height} {}  error estimate {estimate:.1e}, {:.1e} against a finer rule (+ {:.1e} rounding)  \
                 {seconds:.2} s  {}, {}",
                encoding.name,
                report.worst(),
                written.rounding.most.max_abs,
                backend.name(),
                precision.name()
            ),
            &json!({
                "path": wanted.path,
                "table": job.table().table.facts().name,
                "brdf": job.source().name(),
                "width": width,
                "height": height,
                "encoding": encoding.name,
                "bytes": written.bytes,
                "estimate": estimate,
                "max_error": worst,
                "median_error": report.median(),
                "rounding": written.rounding.most.max_abs,
                "rounding_rms": written.rounding.most.rms,
                "checked_texels": report.texels,
                "rule": job.rule_name(),
                "precision": precision.name(),
                "reciprocity": job.laws().reciprocity,
                "warnings": baked.warnings,
                "output_texels": texture.levels[0].len() / channels,
                "longest_dispatch_ms": backend.longest_dispatch_ms(),
                "seconds": seconds,
                "device": backend.name(),
            }),
        )
    }
}

/// `verify --glsl`
pub fn verify(
    checked: Checked,
    source: &Path,
    texture: &Texture,
    encoding: Encoding,
    certificate: Certificate,
    global: &Global,
    console: &mut Console,
) -> Result<()> {
    if checked.page.is_some() {
        return Err(Error::usage("--report has no page for a BRDF of one's own", "drop it; --json has the figures"));
    }
    let source = read(source)?;
    let named = |e: Error| match e {
        Error::Usage { what, help } => Error::input(&checked.file, what, help),
        other => other,
    };
    let steps = Steps::of(encoding, &texture.meta).map_err(named)?;
    let backend = Backend::open(&global.device, global.validate)?;
    let on = &mut |p: Progress<'_>| console.progress(p);
    let job = OwnJob::from_meta(texture, source, &backend, on).map_err(named)?;
    let report = check(&job, texture, Some(steps), checked.extent, on)?;
    backend.check_messages()?;
    let (worst, median) = (report.certified_worst, report.certified_median);
    let certificate = certificate.measured(job.rule_name(), &texture.meta, worst, median);
    let mut failures = [report.failures.clone(), certificate.failures.clone()].concat();
    if let Some(most) = checked.max_error {
        failures.extend(exceeds(report.worst(), most, "of a checked texel"));
    }
    let verdict = if failures.is_empty() { "right" } else { "WRONG" };
    let table = job.table().table.facts().name;
    let mut text = format!("{}  {table} {} {}: {verdict}", checked.file.display(), job.source().name(), encoding.name);
    for c in &report.channels {
        let [x, y] = c.worst_texel;
        text.push_str(&format!(
            "\n  {:10} max difference {:.2e} at texel ({x}, {y}), rms {:.2e}, median {:.2e}",
            c.name, c.worst, c.rms, c.median
        ));
    }
    text.push_str(&format!(
        "\n  finer      {} texels by the same adaptive rule at other nodes, estimated within {:.0e}",
        report.texels, report.reference_error
    ));
    text.push_str(&format!("\n  bound      {:.0e} beyond what rounding leaves", report.bound));
    for key in ["brdf.reciprocity", "brdf.energy", "brdf.positivity"] {
        if let Some(found) = texture.meta.get(key) {
            text.push_str(&format!("\n  stated     {key} {found}"));
        }
    }
    let result = json!({
        "path": checked.file,
        "table": table,
        "brdf": job.source().name(),
        "encoding": encoding.name,
        "passed": failures.is_empty(),
        "max_error": checked.max_error,
        "failures": failures,
        "report": report,
        "certificate": certificate,
    });
    checked.conclude(text, &result, &certificate, &failures, None, console)
}

/// The source, if this build can compile it.
fn read(path: &Path) -> Result<OwnSource> {
    if !glsl::AVAILABLE {
        glsl::compile("", "", path)?;
    }
    OwnSource::read(path)
}

/// A place for the estimates, known to be writable and to hold single floats.
fn prepare_estimates(path: &Path, table: &Path) -> Result<(Output, &'static dyn format::Format, Encoding)> {
    if path == table {
        return Err(Error::usage("--estimates names the table's own file", "give it another name"));
    }
    let format = format::for_path(path)?;
    let encoding = format::choose(format, Shape::Table, 1, Some(Encoding::parse("r32f")?))?;
    Ok((Output::prepare(path)?, format, encoding))
}

fn in_range(flag: &str, value: Option<f64>, low: f64, high: f64) -> Result<Option<f64>> {
    match value {
        Some(x) if !(low..=high).contains(&x) => {
            Err(Error::usage(format!("{flag} {x} is out of range"), format!("give a number from {low} to {high}")))
        }
        other => Ok(other),
    }
}
