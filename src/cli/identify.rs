// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker identify`

use std::path::{Path, PathBuf};

use brdf_baker::bake::LayersJob;
use brdf_baker::format::picture::Picture;
use brdf_baker::format::{self, Encoding};
use brdf_baker::verify::identify::{Difference, Fit, NOISY, Report, Verdict, identify};
use brdf_baker::{Error, Result};
use serde_json::{Map, Value, json};

use super::bake::parse_size;
use super::console::Console;

#[derive(clap::Args)]
pub struct IdentifyArgs {
    /// A table that anyone made: .ktx2 .dds .exr .hdr .png, or bare texels
    file: PathBuf,
    /// Texels of a file of bare texels: 64, or 128x32 for width x height
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, requires = "encoding")]
    size: Option<(u32, u32)>,
    /// How bare texels are stored; `brdf-baker list encodings` shows the names
    #[arg(long, value_name = "NAME", requires = "size")]
    encoding: Option<String>,
    /// Which one of a file that holds several: a layer of an array, a part of an OpenEXR file, counted from 0
    #[arg(long, value_name = "N", conflicts_with = "encoding")]
    layer: Option<u32>,
}

impl IdentifyArgs {
    pub fn run(self, console: &mut Console) -> Result<()> {
        let encoding = self.encoding.as_deref().map(Encoding::parse).transpose()?;
        let picture = match (self.size, encoding) {
            (Some(size), Some(encoding)) => Picture::read_raw(&self.file, size, encoding)?,
            _ => Picture::read_layer(&self.file, self.layer)?,
        };
        let report = identify(&picture, &mut |p| console.progress(p))?;
        let path = self.file.display().to_string();
        let stated = stated(&self.file, self.layer);
        let stated = stated.as_deref();
        console.result(&text(&path, &picture, &report, stated), &value(&path, &picture, &report, stated))?;
        match report.verdict {
            Verdict::None => Err(Error::Verify { what: format!("'{path}' is no table that is known") }),
            _ => Ok(()),
        }
    }
}

/// What a file of ours says that it is: its texels may be of a kind that is not tried.
fn stated(path: &Path, layer: Option<u32>) -> Option<String> {
    let (mut texture, _) = format::for_path(path).ok()?.read(path).ok()?;
    if let (Some(i), Ok(Some(layers))) = (layer, LayersJob::from_meta(&texture)) {
        texture = (i < texture.faces()).then(|| layers.layer(&texture, i as usize))?;
    }
    texture.meta.get("table")?;
    let keys = ["table", "ndf", "visibility", "fresnel", "axes", "points", "order"];
    let said = keys.into_iter().filter_map(|key| texture.meta.get(key)).collect::<Vec<_>>().join(" ");
    Some(format!("{} of {said}", texture.channels.join(",")))
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Certain => "certain",
        Verdict::Likely => "likely",
        Verdict::None => "none",
    }
}

fn text(path: &str, picture: &Picture, report: &Report, stated: Option<&str>) -> String {
    let mut text =
        format!("{path}  {}x{} {}: {}", picture.width, picture.height, picture.stored, verdict(report.verdict));
    if report.verdict == Verdict::Likely && !report.open.is_empty() {
        text.push_str(&format!(", open: {}", report.open.join(", ")));
    }
    if report.fits.is_empty() {
        text.push_str("\n  every texel is the same");
    }
    // Where nothing fits, the nearest one is enough.
    let shown = if report.verdict == Verdict::None { 1 } else { report.fits.len() };
    for (i, fit) in report.fits.iter().take(shown).enumerate() {
        let nearest = if report.verdict == Verdict::None { "nearest, does not fit: " } else { "" };
        text.push_str(&format!("\n  {}  {nearest}max error {:.1e}, rms {:.1e}", i + 1, fit.max, fit.rms));
        if fit.is_exact {
            text.push_str(if fit.is_rounded { ", rounding explains it" } else { ", digits cut off explain it" });
        }
        for (name, words) in fit.words() {
            text.push_str(&format!("\n     {name:12} {words}"));
        }
    }
    if let Some(stated) = stated {
        text.push_str(&format!("\n  the file says of itself: {stated}"));
    }
    if report.verdict == Verdict::None {
        return text;
    }
    if let Some(difference) = &report.difference {
        text.push_str(&difference_text(difference));
    }
    if let [first, rest @ ..] = report.fits.as_slice() {
        let kind = match first.is_exact {
            true => "rounding",
            false if report.noisiness >= NOISY => "noise from texel to texel",
            false => "smooth: samples that all texels share, or a convention that is not known",
        };
        text.push_str(&format!("\n  what is left of 1 is {kind}"));
        if let Some(second) = rest.first() {
            text.push_str(&format!("; 2 is {:.1} times worse", second.rms / first.rms.max(f64::MIN_POSITIVE)));
        }
    }
    text
}

fn difference_text(difference: &Difference) -> String {
    let facts: Vec<String> = difference.facts.iter().map(|(name, a, b)| format!("{name} {a}, not {b}")).collect();
    let [x, y] = difference.texel;
    format!(
        "\n  1 differs from 2 by: {}\n  most at texel ({x}, {y}): {} is {:.5}, 1 says {:.5}, 2 says {:.5}",
        facts.join("; "),
        difference.component,
        difference.found,
        difference.best,
        difference.runner_up
    )
}

fn value(path: &str, picture: &Picture, report: &Report, stated: Option<&str>) -> Value {
    let fit = |fit: &Fit| {
        let mut map = Map::new();
        for (name, words) in fit.words() {
            map.insert(name.into(), json!(words));
        }
        map.insert("max_error".into(), json!(fit.max));
        map.insert("rms_error".into(), json!(fit.rms));
        map.insert("worst_texel".into(), json!(fit.worst_texel));
        map.insert("exact".into(), json!(fit.is_exact));
        map.insert("rounded".into(), json!(fit.is_rounded));
        Value::Object(map)
    };
    json!({
        "path": path,
        "width": picture.width,
        "height": picture.height,
        "stored": picture.stored,
        "verdict": report.verdict,
        "fits": report.fits.iter().map(fit).collect::<Vec<_>>(),
        "open": report.open,
        "stated": stated,
        "difference": report.difference,
        "noisiness": report.noisiness,
        "texels": report.texels,
    })
}
