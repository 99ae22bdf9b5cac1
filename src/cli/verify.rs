//! `brdf-baker verify`

use std::path::PathBuf;

use brdf_baker::bake::TableJob;
use brdf_baker::format;
use brdf_baker::texture::Shape;
use brdf_baker::verify::table::{Extent, TableReport, check};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::console::Console;
use super::foreign::{self, ModelArgs};

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
    /// Of a table that others made, the largest error that is right [default: a step of its encoding]
    #[arg(long, value_name = "E")]
    max_error: Option<f64>,
    #[command(flatten)]
    model: ModelArgs,
}

impl VerifyArgs {
    pub fn run(self, console: &mut Console) -> Result<()> {
        if let Some(picture) = foreign::picture(&self.file)? {
            return foreign::verify(&self.file, &picture, &self.model, self.max_error, self.full, console);
        }
        self.model.refuse(&self.file)?;
        if self.max_error.is_some() {
            let what = format!(
                "--max-error is for tables that others made, and '{}' states its own bound",
                self.file.display()
            );
            return Err(Error::usage(what, "drop --max-error"));
        }
        let (texture, encoding) = format::for_path(&self.file)?.read(&self.file)?;
        let extent = if self.full { Extent::Full } else { Extent::Spot };
        if texture.shape != Shape::Table {
            return super::env::verify(&self.file, self.source.as_deref(), &texture, encoding, extent, console);
        }
        let job =
            TableJob::from_meta(&texture).map_err(|e| Error::input(&self.file, e.to_string(), e.help().to_string()))?;
        let report = check(&job, &texture, Some(encoding), extent, &mut |p| console.progress(p))?;
        console.result(
            &text(&self.file.display().to_string(), &job, encoding.name, &report),
            &json!({
                "path": self.file,
                "table": job.table.facts().name,
                "ndf": job.model.ndf.to_string(),
                "visibility": job.model.visibility.name,
                "encoding": encoding.name,
                "passed": report.failures.is_empty(),
                "report": report,
            }),
        )?;
        match report.failures.first() {
            None => Ok(()),
            Some(failure) => Err(Error::Verify { what: format!("'{}' is wrong: {failure}", self.file.display()) }),
        }
    }
}

fn text(path: &str, job: &TableJob, encoding: &str, report: &TableReport) -> String {
    let verdict = if report.failures.is_empty() { "right" } else { "WRONG" };
    let mut text = format!(
        "{path}  {} {} {} {encoding}: {verdict}",
        job.table.facts().name,
        job.model.ndf,
        job.model.visibility.name
    );
    for c in &report.channels {
        text.push_str(&format!(
            "\n  {:10} max error {:.2e} at texel ({}, {}), rms {:.2e}, median {:.2e}, correctly rounded {:.2} %",
            c.name,
            c.worst,
            c.worst_texel[0],
            c.worst_texel[1],
            c.rms,
            c.median,
            100.0 * c.correctly_rounded
        ));
    }
    text.push_str(&format!(
        "\n  truth      {} texels by adaptive f64 integration, itself within {:.0e}",
        report.truth_texels, report.truth_error
    ));
    text.push_str(&format!(
        "\n  twin       {} texels by the same rule in f64, max difference {:.2e}",
        report.twin_texels, report.twin_worst
    ));
    text
}
