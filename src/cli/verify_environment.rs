// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker verify` of an environment: a cube, a map or an atlas.

use std::path::Path;

use brdf_baker::bake::atlas::{self, Atlas};
use brdf_baker::bake::specular::SpecularJob;
use brdf_baker::env::import::{self, Options};
use brdf_baker::format::{Encoding, Steps};
use brdf_baker::progress::Progress;
use brdf_baker::texture::Texture;
use brdf_baker::verify::certificate::Certificate;
use brdf_baker::verify::cube::{self, CubeReport};
use brdf_baker::verify::environment;
use brdf_baker::{Error, Result, report};
use serde_json::json;

use super::console::Console;
use super::verify::{Checked, exceeds};

/// `brdf-baker verify` of an environment.
pub fn run(
    checked: Checked,
    source: Option<&Path>,
    texture: &Texture,
    encoding: Encoding,
    certificate: Certificate,
    console: &mut Console,
) -> Result<()> {
    let file = checked.file.as_path();
    let named = |e: Error| Error::input(file, e.to_string(), e.help().to_string());
    let atlas = Atlas::from_meta(texture).map_err(named)?;
    let tiles = atlas.as_ref().map(|atlas| atlas.unpack(texture));
    let texture = tiles.as_ref().map_or(texture, |[chain, _]| chain);
    let job = SpecularJob::from_meta(texture).map_err(named)?;
    let steps = Steps::of(encoding, &texture.meta)?;
    let on = &mut |p: Progress<'_>| console.progress(p);
    let imported = match source {
        Some(source) => Some(import::read(source, &Options::from_meta(&texture.meta)?, on)?),
        None => None,
    };
    let source = imported.as_ref().map(|i| &i.environment);
    let report = match source {
        Some(source) => cube::check_with_source(&job, texture, source, steps, checked.extent, on)?,
        None => cube::check(&job, texture, steps, checked.extent, on)?,
    };
    let certificate = certificate.environment(&job, &texture.meta, &report, &steps);
    let against = if source.is_some() { "the convolution of the source" } else { "the convolution of mip 0" };
    let mut failures = [report.failures.clone(), certificate.failures.clone()].concat();
    if let (Some(atlas), Some([_, ambient]), Some(source)) = (&atlas, &tiles, source) {
        let bound = job.quality.worst_bound + steps.relative();
        let errors = environment::check(&atlas.ambient, source, ambient, environment::Extent::THOROUGH, on)?;
        if let Some(bad) = errors.iter().find(|e| e.max.is_nan() || e.max > bound) {
            failures.push(format!("the ambient tile is off by {:.1e}, more than {bound:.1e}", bad.max));
        }
    }
    if let Some(most) = checked.max_error {
        let worst = report.worst().ok_or_else(|| {
            Error::usage("no mip was compared, so --max-error has nothing to say", "give the environment with --source")
        })?;
        failures.extend(exceeds(worst, most, "relative, of a checked texel"));
    }
    let picture = match &checked.page {
        Some(_) => Some(report::cube::picture(&job, texture, source, &report, on)?),
        None => None,
    };
    let shape = if atlas.is_some() { atlas::NAME } else { job.projection.name() };
    let text =
        text(&format!("{}  {shape}", file.display()), &job, encoding.name, against, &report, failures.is_empty());
    let result = json!({
        "path": file,
        "encoding": encoding.name,
        "projection": shape,
        "kernel": job.kernel.name,
        "against": against,
        "passed": failures.is_empty(),
        "max_error": checked.max_error,
        "failures": failures,
        "report": report,
        "certificate": certificate,
    });
    checked.conclude(text, &result, &certificate, &failures, picture, console)
}

/// `what` is the path and the shape.
fn text(what: &str, job: &SpecularJob, encoding: &str, against: &str, report: &CubeReport, right: bool) -> String {
    let verdict = if right { "right" } else { "WRONG" };
    let [r, g, b] = report.mean;
    let mut text =
        format!("{what} {} {encoding}: {verdict}\n  mip 0      mean radiance {r:.5} {g:.5} {b:.5}", job.kernel.name);
    if let Some(m) = &report.mip_0 {
        let (rms, max, bound) = (m.rms, m.worst, m.bound);
        text.push_str(&format!(
            "; rms {rms:.1e}, max {max:.1e} of {} texels, against the source (bound {bound:.1e} rms)",
            m.texels
        ));
    }
    for mip in &report.skipped {
        text.push_str(&format!("\n  mip {mip:<2}     not compared: give the environment with --source"));
    }
    for m in &report.mips {
        let bias = m.bias.map_or(String::new(), |bias| format!(", energy {bias:+.0e}"));
        text.push_str(&format!(
            "\n  mip {:<2}     alpha {:.5}: rms {:.1e}, max {:.1e}{bias} of {} texels, against {against} \
             (bound {:.1e} rms)",
            m.mip, m.alpha, m.rms, m.worst, m.texels, m.bound
        ));
    }
    let holds = |law: bool| if law { "holds" } else { "see below" };
    let seams = report.levels.iter().filter(|l| l.seams.is_some()).count();
    text.push_str(&format!(
        "\n  laws       finite, not negative, no brighter than mip 0, less variance in wider lobes, no rings at the seams of \
         {seams} mips: {}",
        holds(report.failures.is_empty())
    ));
    text
}
