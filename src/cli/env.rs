//! `brdf-baker env`

use std::path::{Path, PathBuf};
use std::time::Instant;

use brdf_baker::bake::Backend;
use brdf_baker::bake::specular::{SpecularJob, SpecularRequest};
use brdf_baker::env::import::{self, Options};
use brdf_baker::format::{self, Encoding, Output};
use brdf_baker::progress::Progress;
use brdf_baker::term::zonal::ZONALS;
use brdf_baker::texture::{Shape, Texture};
use brdf_baker::verify::cube::{self, CubeReport};
use brdf_baker::verify::environment::{self, MipError};
use brdf_baker::verify::table::Extent;
use brdf_baker::{Error, Result};
use serde_json::json;

use super::Global;
use super::console::Console;
use super::source::{self, SourceArgs};

#[derive(clap::Args)]
pub struct EnvArgs {
    /// Environment: a file, a folder of six faces, a path with {face} in it, or six paths joined by commas
    input: PathBuf,
    /// File to write: .ktx2 or .exr
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Filter kernel
    #[arg(long, default_value = "ggx", value_name = "NAME")]
    kernel: String,
    /// Texels along an edge of mip 0
    #[arg(long, default_value_t = 256, value_name = "N")]
    size: u32,
    /// Number of mips, mip 0 included [default: down to 1x1]
    #[arg(long, value_name = "N")]
    mips: Option<u32>,
    /// Roughness of mip m of M + 1: linear, m/M, or quadratic, 1 - sqrt(1 - m/M)
    #[arg(long, default_value = "linear", value_name = "linear|quadratic")]
    roughness_law: String,
    /// How texels are stored
    #[arg(long, default_value = "rgba16f", value_name = "NAME")]
    encoding: String,
    #[command(flatten)]
    source: SourceArgs,
}

impl EnvArgs {
    pub fn run(self, global: &Global, console: &mut Console) -> Result<()> {
        let start = Instant::now();

        // Everything that can be refused is refused before any work.
        let request = SpecularRequest {
            kernel: self.kernel,
            size: self.size,
            mips: self.mips,
            roughness_law: self.roughness_law,
        };
        let job = request.resolve()?;
        let format = format::for_path(&self.output)?;
        let encoding = format::choose(format, Shape::Cube, 3, Some(Encoding::parse(&self.encoding)?))?;
        let options = self.source.options()?;
        let output = Output::prepare(&self.output)?;
        let imported = import::read(&self.input, &options, &mut |p| console.progress(p))?;
        source::warn(&self.input, &options, &imported, console);
        let environment = &imported.environment;
        let backend = Backend::open(&global.device, global.validate)?;

        let mut texture = job.run(environment, &backend, &mut |p| console.progress(p))?;
        let spot = environment::Extent::SPOT;
        let errors = environment::check(&job, environment, &texture, spot, &mut |p| console.progress(p))?;
        let (rms, worst, texels) = summary(&errors);
        // Written so that NaN is refused.
        if !(worst <= environment::WORST && errors.len() + 1 == texture.levels.len()) {
            let what = format!(
                "'{}' was not written: a texel is off by {worst:.1e} of its value, more than {:.0e}",
                self.output.display(),
                environment::WORST
            );
            return Err(Error::Verify { what });
        }
        backend.check_messages()?;
        let name = self.input.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        texture.meta.set("input", name);
        options.describe(&imported, &mut texture.meta);
        texture.meta.set("error.relative.rms", format!("{rms:.1e}"));
        texture.meta.set("error.relative.worst", format!("{worst:.1e}"));
        texture.meta.set("error.bound", format!("{:.0e} worst", environment::WORST));
        texture.meta.set("error.checked", format!("{texels} texels against a brute-force f64 sum over the input"));
        let written = output.commit(format, &texture, encoding)?;
        if written.rounding.clamped > 0 {
            console.warn(&format!(
                "{} values exceed what {} holds and were clamped; --encoding rgba32f keeps them",
                written.rounding.clamped, encoding.name
            ));
        }

        let seconds = start.elapsed().as_secs_f64();
        let path = self.output.display();
        console.result(
            &format!(
                "{path}  6x{0}x{0}, {1} mips {2}  max error {3:.1e} relative, rms {4:.1e} (+ {5:.1e} rounding)  \
                 {seconds:.2} s  {6}",
                texture.width,
                texture.levels.len(),
                encoding.name,
                worst,
                rms,
                written.rounding.max_rel,
                backend.name()
            ),
            &json!({
                "path": self.output,
                "source": self.input,
                "layout": imported.layout,
                "negative_texels": imported.adjusted.negative.map_or(0, |n| n.count),
                "repaired_texels": imported.adjusted.repaired,
                "dimmed_texels": imported.adjusted.clamped,
                "removed_energy": imported.adjusted.removed,
                "kernel": job.kernel.name,
                "size": texture.width,
                "mips": texture.levels.len(),
                "encoding": encoding.name,
                "bytes": written.bytes,
                "max_error": worst,
                "rms_error": rms,
                "rounding": written.rounding.max_rel,
                "clamped": written.rounding.clamped,
                "checked_texels": texels,
                "seconds": seconds,
                "device": backend.name(),
            }),
        )
    }
}

/// Largest rms and worst error of any mip, and the number of texels compared.
fn summary(errors: &[MipError]) -> (f64, f64, u32) {
    let max = |of: fn(&MipError) -> f64| errors.iter().map(of).fold(0.0, |a: f64, b| if b <= a { a } else { b });
    (max(|e| e.rms), max(|e| e.max), errors.iter().map(|e| e.texels).sum())
}

/// `brdf-baker verify` of a cube.
pub fn verify(
    file: &Path,
    source: Option<&Path>,
    texture: &Texture,
    encoding: Encoding,
    extent: Extent,
    console: &mut Console,
) -> Result<()> {
    let job = SpecularJob::from_meta(texture).map_err(|e| Error::input(file, e.to_string(), e.help().to_string()))?;
    let on = &mut |p: Progress<'_>| console.progress(p);
    let report = match source {
        Some(source) => {
            let options = Options::from_meta(&texture.meta)?;
            let imported = import::read(source, &options, on)?;
            cube::check_with_source(&job, texture, &imported.environment, encoding, extent, on)?
        }
        None => {
            let alpha: Vec<f64> = (0..job.mips).map(|m| job.alpha(m)).collect();
            cube::check(texture, &alpha, encoding, extent, on)?
        }
    };
    let against = if source.is_some() { "the convolution of the source" } else { "the convolution of mip 0" };
    console.result(
        &text(&file.display().to_string(), encoding.name, against, &report),
        &json!({
            "path": file,
            "encoding": encoding.name,
            "against": against,
            "passed": report.failures.is_empty(),
            "report": report,
        }),
    )?;
    match report.failures.first() {
        None => Ok(()),
        Some(failure) => Err(Error::Verify { what: format!("'{}' is wrong: {failure}", file.display()) }),
    }
}

fn text(path: &str, encoding: &str, against: &str, report: &CubeReport) -> String {
    let verdict = if report.failures.is_empty() { "right" } else { "WRONG" };
    let [r, g, b] = report.mean;
    let mut text = format!("{path}  cube {encoding}: {verdict}\n  mip 0      mean radiance {r:.5} {g:.5} {b:.5}");
    for mip in &report.skipped {
        text.push_str(&format!(
            "\n  mip {mip:<2}     not checked: narrower than mip 0's texels; give the environment with --source"
        ));
    }
    for m in &report.mips {
        text.push_str(&format!(
            "\n  mip {:<2}     alpha {:.5}: rms {:.1e}, max {:.1e} of {} texels, against {against} \
             (bound {:.1e} rms)",
            m.mip, m.alpha, m.rms, m.worst, m.texels, m.bound
        ));
    }
    text
}

/// Name, one line and source of every kernel, for lists.
pub fn kernels() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    ZONALS.iter().map(|k| (k.name, k.about, k.source))
}
