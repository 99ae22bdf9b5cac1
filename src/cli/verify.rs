// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker verify`

use std::path::{Path, PathBuf};

use brdf_baker::bake::own::SOURCE_SHA256;
use brdf_baker::bake::{LayersJob, TableJob, VolumeJob};
use brdf_baker::format::{Output, Steps};
use brdf_baker::progress::Progress;
use brdf_baker::texture::Texture;
use brdf_baker::verify::certificate::{Certificate, Verdict};
use brdf_baker::verify::table::{Extent, TableReport, check};
use brdf_baker::{Error, Result, report};
use serde_json::{Value, json};

use super::Global;
use super::console::Console;
use super::foreign::{self, File, ModelArgs};

#[derive(clap::Args)]
pub struct VerifyArgs {
    /// A file that brdf-baker wrote, or a table that others made
    file: PathBuf,
    /// Check every texel, not a sample
    #[arg(long)]
    full: bool,
    /// The environment that the file was baked from, named as for `env`: compares with it, read and turned as the file
    /// says, instead of with the file's own mip 0
    #[arg(long, value_name = "INPUT")]
    source: Option<PathBuf>,
    /// Largest error that passes, rounding included: of tables absolute up to 1 and relative beyond, of environments
    /// relative [default: what the bake is held to; of a table that others made, a step of its encoding]
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    max_error: Option<f64>,
    /// Also write what was found as one page: texels, errors, slices, laws, conventions
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// One layer alone of an array, counted from 0: as a table, so that --report can draw it
    #[arg(long, value_name = "N", conflicts_with_all = ["source", "glsl"])]
    layer: Option<u32>,
    /// The source of the BRDF of one's own that the file holds: computes texels again by a finer rule
    #[arg(long, value_name = "FILE.glsl")]
    glsl: Option<PathBuf>,
    #[command(flatten)]
    model: ModelArgs,
}

/// A file under test, and what is wanted beside the verdict.
pub struct Checked {
    pub file: PathBuf,
    pub extent: Extent,
    pub max_error: Option<f64>,
    /// Where the page goes.
    pub page: Option<(PathBuf, Output)>,
}

impl VerifyArgs {
    pub fn run(self, global: &Global, console: &mut Console) -> Result<()> {
        // Everything that can be refused is refused before any work.
        if let Some(bad) = self.max_error.filter(|x| !(x.is_finite() && *x >= 0.0)) {
            return Err(Error::usage(
                format!("--max-error {bad} is no bound"),
                "give a number of at least 0, e.g. 1e-3",
            ));
        }
        let (texture, encoding) = match foreign::read(&self.file, self.layer)? {
            File::Own(texture, encoding) => (texture, encoding),
            File::Others(_) if self.report.is_some() || self.source.is_some() || self.glsl.is_some() => {
                let what = format!(
                    "'{}' was made by others: --report, --source and --glsl need a file of this program",
                    self.file.display()
                );
                return Err(Error::usage(what, "drop them; --json has the figures"));
            }
            File::Others(picture) => {
                return foreign::verify(&self.file, &picture, &self.model, self.max_error, self.full, console);
            }
        };
        self.model.refuse(&self.file)?;
        let page = self.report.map(|path| Ok::<_, Error>((path.clone(), prepare_page(&path)?))).transpose()?;
        let named = |e: Error| Error::input(&self.file, e.to_string(), e.help().to_string());
        let certificate = Certificate::texels(&texture, encoding).map_err(named)?;
        let extent = match (self.full, certificate.several_changed) {
            (true, _) => Extent::Full,
            // Which of them is worst, only a look at all can say.
            (false, true) => Extent::Twin,
            (false, false) => Extent::Spot,
        };
        let checked = Checked { file: self.file.clone(), extent, max_error: self.max_error, page };
        if let Some(glsl) = &self.glsl {
            if texture.meta.get(SOURCE_SHA256).is_none() {
                let what = format!("'{}' holds no BRDF of one's own", self.file.display());
                return Err(Error::usage(what, "drop --glsl"));
            }
            return super::own::verify(checked, glsl, &texture, encoding, certificate, global, console);
        }
        if !texture.shape.is_table() {
            if self.layer.is_some() {
                let what = format!("'{}' holds no tables", self.file.display());
                return Err(Error::usage(what, "drop --layer"));
            }
            let source = self.source.as_deref();
            return super::verify_environment::run(checked, source, &texture, encoding, certificate, console);
        }

        if self.source.is_some() {
            return Err(Error::usage(
                format!("'{}' is a table, which has no source", self.file.display()),
                "drop --source",
            ));
        }
        let steps = Steps::of(encoding, &texture.meta).map_err(named)?;
        let (job, texture) = match (LayersJob::from_meta(&texture).map_err(named)?, self.layer) {
            (Some(layers), None) => return verify_layers(checked, &layers, &texture, steps, certificate, console),
            (Some(layers), Some(i)) => {
                let job = layers.layers().get(i as usize).ok_or_else(|| {
                    named(Error::usage(format!("it has no layer {i}"), format!("it has {}, from 0", texture.faces())))
                })?;
                (job.clone(), layers.layer(&texture, i as usize))
            }
            (None, Some(_)) => {
                return Err(named(Error::usage("it has no layers that are tables of their own", "drop --layer")));
            }
            (None, None) => match VolumeJob::from_meta(&texture).map_err(named)? {
                Some(volume) => return verify_volume(checked, &volume, &texture, steps, certificate, console),
                None => (TableJob::from_meta(&texture).map_err(named)?, texture),
            },
        };
        let on = &mut |p: Progress<'_>| console.progress(p);
        let report = check(&job, &texture, Some(steps), extent, on)?;
        let certificate = certificate.table(job.rule_name(), &texture.meta, &report);
        let described = job.described(&texture);
        let certificate = certificate.described(&texture.meta, &described, &steps);
        let mut failures = [report.failures.clone(), certificate.failures.clone()].concat();
        if let Some(most) = checked.max_error {
            failures.extend(exceeds(report.worst(), most, "of a checked texel"));
        }
        let picture = match &checked.page {
            Some(_) => Some(report::table::picture(&job, &texture, &steps, on)?),
            None => None,
        };
        let text = text(&self.file.display().to_string(), &job, encoding.name, &report, failures.is_empty());
        let result = json!({
            "path": self.file,
            "table": job.table.facts().name,
            "ndf": job.has_model().then(|| job.model.ndf.to_string()),
            "visibility": job.has_model().then_some(job.model.visibility.name),
            "fresnel": job.has_model().then(|| job.model.fresnel.to_string()),
            "encoding": encoding.name,
            "passed": failures.is_empty(),
            "max_error": checked.max_error,
            "failures": failures,
            "report": report,
            "certificate": certificate,
        });
        checked.conclude(text, &result, &certificate, &failures, picture, console)
    }
}

/// A table over slices: each is checked as a table.
fn verify_volume(
    checked: Checked,
    volume: &VolumeJob,
    texture: &Texture,
    steps: Steps,
    certificate: Certificate,
    console: &mut Console,
) -> Result<()> {
    if checked.page.is_some() {
        return Err(Error::usage(
            "--report draws tables of two axes",
            "bake a slice of it with --ior, or drop --report",
        ));
    }
    let found = volume.check(texture, Some(steps), checked.extent, &mut |p| console.progress(p))?;
    let certificate = certificate.table(volume.rule_name(), &texture.meta, &found.all);
    let mut failures = [found.all.failures.clone(), certificate.failures.clone()].concat();
    failures.extend(volume.misstated(texture));
    if let Some(most) = checked.max_error {
        failures.extend(exceeds(found.all.worst(), most, "of a checked texel"));
    }
    let job = &volume.slices()[0];
    let encoding = steps.encoding.name;
    let path = checked.file.display().to_string();
    let mut text = text(&path, job, encoding, &found.all, failures.is_empty());
    for (c, slice) in found.all.channels.iter().zip(&found.worst_slices) {
        let (number, value) = (volume.axis().kind().name(), volume.values()[*slice as usize]);
        text.push_str(&format!(
            "\n  slice      the largest error of {} is in slice {slice}, {number} {value:.4}",
            c.name
        ));
    }
    text.push_str(&format!("\n  slices     {} of {} were looked at", found.slices, volume.slices().len()));
    let result = json!({
        "path": checked.file,
        "table": job.table.facts().name,
        "ndf": job.model.ndf.to_string(),
        "visibility": job.model.visibility.name,
        "slice_axis": volume.axis().to_string(),
        "slice_values": volume.values(),
        "encoding": encoding,
        "passed": failures.is_empty(),
        "max_error": checked.max_error,
        "failures": failures,
        "report": found.all,
        "worst_slices": found.worst_slices,
        "checked_slices": found.slices,
        "certificate": certificate,
    });
    checked.conclude(text, &result, &certificate, &failures, None, console)
}

/// Several tables in layers: each is checked as a table.
fn verify_layers(
    checked: Checked,
    layers: &LayersJob,
    texture: &Texture,
    steps: Steps,
    certificate: Certificate,
    console: &mut Console,
) -> Result<()> {
    if checked.page.is_some() {
        let help = "name one with --layer, or drop --report";
        return Err(Error::usage("--report draws one table, not the layers of an array", help));
    }
    let found = layers.check(texture, Some(steps), checked.extent, &mut |p| console.progress(p))?;
    let mut certificate = certificate.table(layers.rule_name(), &texture.meta, &found.all);
    for (i, job) in layers.layers().iter().enumerate() {
        let layer = layers.layer(texture, i);
        certificate = certificate.described(&layer.meta, &job.described(&layer), &steps);
    }
    let mut failures = [found.all.failures.clone(), certificate.failures.clone()].concat();
    if let Some(most) = checked.max_error {
        failures.extend(exceeds(found.all.worst(), most, "of a checked texel"));
    }
    let verdict = if failures.is_empty() { "right" } else { "WRONG" };
    let encoding = steps.encoding.name;
    let mut text = format!("{}  {} {encoding}: {verdict}", checked.file.display(), layers.name());
    for (i, (job, report)) in layers.layers().iter().zip(&found.layers).enumerate() {
        text.push_str(&format!("\n  layer {i}    {}{}", job.table.facts().name, model(job)));
        text.push_str(&measured(job, report));
    }
    let of_layer = |(job, report): (&TableJob, &TableReport)| {
        json!({
            "table": job.table.facts().name,
            "ndf": job.has_model().then(|| job.model.ndf.to_string()),
            "visibility": job.has_model().then_some(job.model.visibility.name),
            "fresnel": job.has_model().then(|| job.model.fresnel.to_string()),
            "report": report,
        })
    };
    let result = json!({
        "path": checked.file,
        "table": layers.name(),
        "encoding": encoding,
        "passed": failures.is_empty(),
        "max_error": checked.max_error,
        "failures": failures,
        "report": found.all,
        "layers": layers.layers().iter().zip(&found.layers).map(of_layer).collect::<Vec<_>>(),
        "certificate": certificate,
    });
    checked.conclude(text, &result, &certificate, &failures, None, console)
}

/// A page's place, known to be writable.
pub fn prepare_page(path: &Path) -> Result<Output> {
    // Anything else could be the very file that is checked.
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html")) {
        let what = format!("'{}' is no name for a page", path.display());
        return Err(Error::usage(what, "name a file that ends in .html"));
    }
    Output::prepare(path)
}

/// A failure where `worst` is more than `--max-error`, or not a number.
pub fn exceeds(worst: f64, most: f64, of: &str) -> Option<String> {
    let within = worst <= most;
    (!within).then(|| format!("the largest error {of} is {worst:.2e}, more than --max-error {most:.2e}"))
}

impl Checked {
    /// Writes the page, prints the result, and turns the first failure into an error.
    pub fn conclude(
        self,
        mut text: String,
        result: &Value,
        certificate: &Certificate,
        failures: &[String],
        picture: Option<Value>,
        console: &mut Console,
    ) -> Result<()> {
        text.push_str(&claims(certificate));
        failures.iter().for_each(|failure| text.push_str(&format!("\n  wrong      {failure}")));
        if let (Some((path, output)), Some(picture)) = (self.page, picture) {
            let name = self.file.file_name().unwrap_or(Path::new("file").as_os_str()).to_string_lossy();
            output.commit_bytes(report::page(&format!("{name}, verified"), result, &picture).as_bytes())?;
            text.push_str(&format!("\n  report     {}", path.display()));
        }
        console.result(&text, result)?;
        match failures.first() {
            None => Ok(()),
            Some(failure) => Err(Error::Verify { what: format!("'{}' is wrong: {failure}", self.file.display()) }),
        }
    }
}

/// The certificate in one line: the keys of each verdict.
fn claims(certificate: &Certificate) -> String {
    let mut parts = vec![];
    for (verdict, word) in [
        (Verdict::Refuted, "refuted"),
        (Verdict::Confirmed, "confirmed"),
        (Verdict::Stated, "stated"),
        (Verdict::Missing, "not stated"),
    ] {
        let keys: Vec<&str> = certificate.claims.iter().filter(|c| c.verdict == verdict).map(|c| c.key).collect();
        if !keys.is_empty() {
            parts.push(format!("{word} {}", keys.join(", ")));
        }
    }
    format!("\n  claims     {}", parts.join("; "))
}

fn text(path: &str, job: &TableJob, encoding: &str, report: &TableReport, right: bool) -> String {
    let verdict = if right { "right" } else { "WRONG" };
    format!("{path}  {}{} {encoding}: {verdict}{}", job.table.facts().name, model(job), measured(job, report))
}

/// Distribution and geometry term, where it has some.
fn model(job: &TableJob) -> String {
    if job.has_model() { format!(" {} {}", job.model.ndf, job.model.visibility.name) } else { String::new() }
}

/// What a check of a table found, line by line.
fn measured(job: &TableJob, report: &TableReport) -> String {
    let mut text = String::new();
    for c in &report.channels {
        text.push_str(&format!(
            "\n  {:10} max error {:.2e} at texel ({}, {}), {}, rms {:.2e}, median {:.2e}, correctly rounded {:.2} %",
            c.name,
            c.worst,
            c.worst_texel[0],
            c.worst_texel[1],
            place(job, c.worst_texel),
            c.rms,
            c.median,
            100.0 * c.correctly_rounded
        ));
    }
    text.push_str(&format!(
        "\n  truth      {} texels by {}, itself within {:.0e}",
        report.truth_texels,
        job.table.truth_name(),
        report.truth_error
    ));
    text.push_str(&format!(
        "\n  twin       {} texels by the same rule in f64, max difference {:.2e}",
        report.twin_texels, report.twin_worst
    ));
    if let Some(law) = job.table.law()
        && let Some(found) = report.laws.iter().find(|l| l.statement.ends_with(law.statement))
    {
        text.push_str(&format!("\n  law        {}: {}", found.statement, if found.holds { "holds" } else { "BROKEN" }));
    }
    let tolerance = job.loosest();
    text.push_str(&format!(
        "\n  bound      {:.0e} before rounding, {:.0e} nearer to 0 than 1/1024",
        tolerance.worst, tolerance.near_zero
    ));
    text
}

/// The coordinates of a texel, in words.
fn place(job: &TableJob, [x, y]: [u32; 2]) -> String {
    let axes =
        job.axes.iter().zip([x, y]).map(|(axis, i)| format!("{} {:.4}", axis.warp.coordinate().name(), axis.at(i)));
    axes.collect::<Vec<_>>().join(" ")
}
