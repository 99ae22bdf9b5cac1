// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker verify` for tables that others made: the model comes from flags or from `identify`.

use std::path::Path;

use brdf_baker::axis::{self, Axis};
use brdf_baker::bake::{MAX_SIZE, TableRequest};
use brdf_baker::format::{self, Encoding, picture::Picture};
use brdf_baker::texture::{Shape, Texture};
use brdf_baker::verify::identify::{
    Content, Hypothesis, Layout, Points, Quantity, Side, Transfer, Verdict, identify, measure,
};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::console::Console;

/// What a table holds, for a file that does not say it.
#[derive(clap::Args)]
pub struct ModelArgs {
    /// Of a file that does not say it, the normal distribution [default: what `identify` finds]
    #[arg(long, value_name = "NAME[:PARAMETER=VALUE,...]", requires = "visibility")]
    ndf: Option<String>,
    /// Its geometry term
    #[arg(long, value_name = "NAME", requires = "ndf")]
    visibility: Option<String>,
    /// Its axes [default: n_dot_v,roughness]
    #[arg(long, value_name = "X,Y", value_delimiter = ',', requires = "ndf")]
    axes: Option<Vec<String>>,
    /// Its positions in a texel
    #[arg(long, default_value = "centers", value_name = "centers|edges", requires = "ndf")]
    points: String,
    /// Its row 0 holds the largest y coordinate
    #[arg(long, requires = "ndf")]
    flip_v: bool,
    /// Its channels, in order [default: scale,bias]
    #[arg(long, value_name = "LIST", value_delimiter = ',', requires = "ndf")]
    channels: Option<Vec<String>>,
}

impl ModelArgs {
    /// Refuses to be ignored: a file that says what it holds is checked as that.
    pub fn refuse(&self, path: &Path) -> Result<()> {
        if self.ndf.is_none() {
            return Ok(());
        }
        let what = format!("'{}' says itself what it holds", path.display());
        Err(Error::usage(what, "drop --ndf and what describes the table; `brdf-baker info` prints what it says"))
    }
}

/// Texels a side that a check looks at unless all are asked for.
const SPOT: u32 = 64;

/// A file, read.
pub enum File {
    /// It says what it holds.
    Own(Texture, Encoding),
    /// It does not.
    Others(Picture),
}

/// Reads a file of either kind, of others' arrays one layer.
pub fn read(path: &Path, layer: Option<u32>) -> Result<File> {
    let may_be_others = |shape| matches!(shape, Shape::Table | Shape::Array { .. });
    match format::for_path(path).and_then(|format| format.read(path)) {
        Ok((texture, encoding)) if !may_be_others(texture.shape) || texture.meta.get("table").is_some() => {
            Ok(File::Own(texture, encoding))
        }
        Ok(_) => Picture::read_layer(path, layer).map(File::Others),
        // Others' files may hold what ours do not. What nobody can read is told as of a file of ours.
        Err(own) => Picture::read_layer(path, layer).map(File::Others).map_err(|_| own),
    }
}

/// Checks such a file; `max_error` is the bound, by default what rounding explains.
pub fn verify(
    path: &Path,
    picture: &Picture,
    model: &ModelArgs,
    max_error: Option<f64>,
    full: bool,
    console: &mut Console,
) -> Result<()> {
    let name = path.display().to_string();
    let (hypothesis, contents, from) = match &model.ndf {
        Some(ndf) => {
            let (hypothesis, contents) = stated(ndf, model, picture)?;
            (hypothesis, contents, "stated".to_string())
        }
        None => {
            let report = identify(picture, &mut |p| console.progress(p))?;
            let Some(fit) = report.fits.into_iter().next().filter(|_| report.verdict != Verdict::None) else {
                let what = format!("'{name}' does not say what it holds, and no convention that is known explains it");
                return Err(Error::Verify { what });
            };
            let open = match report.open.as_slice() {
                [] => String::new(),
                open => format!(", open: {}", open.join(", ")),
            };
            let sure = if report.verdict == Verdict::Certain { "certain" } else { "likely" };
            (
                fit.hypothesis,
                fit.components.into_iter().map(|c| c.content).collect(),
                format!("identified, {sure}{open}"),
            )
        }
    };

    let measured = measure(picture, &hypothesis, &contents, if full { MAX_SIZE } else { SPOT });
    let worst = measured.channels.iter().map(|c| c.worst).max_by(f64::total_cmp).unwrap_or(f64::NAN);
    let failure = match max_error {
        _ if measured.channels.is_empty() => Some("no component was compared".to_string()),
        Some(bound) => {
            // NaN is not within any bound.
            let within = worst <= bound;
            (!within).then(|| format!("a texel is off by {worst:.2e}, more than {bound:.2e}"))
        }
        None => (!measured.is_exact)
            .then(|| format!("a texel is off by {worst:.2e}, more than a step of its encoding (see --max-error)")),
    };
    let Hypothesis { model, layout, .. } = &hypothesis;
    let verdict = if failure.is_none() { "right" } else { "WRONG" };
    let mut text = format!(
        "{name}  {} {} {}, x = {}, y = {} ({from}): {verdict}",
        model.ndf,
        model.visibility.name,
        picture.stored,
        layout.x.words(),
        layout.y.words()
    );
    for c in &measured.channels {
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
    let shift = layout.shift_words();
    if let Some(shift) = &shift {
        text.push_str(&format!("\n  note       {shift}"));
    }
    text.push_str(&format!("\n  reference  {} texels by the rule in f64", measured.texels));
    console.result(
        &text,
        &json!({
            "path": path,
            "ndf": model.ndf.to_string(),
            "visibility": model.visibility.name,
            "x": layout.x.words(),
            "y": layout.y.words(),
            "shift": shift,
            "model_from": from,
            "stored": picture.stored,
            "passed": failure.is_none(),
            "max_error": worst,
            "bound": max_error,
            "channels": measured.channels,
            "texels": measured.texels,
        }),
    )?;
    match failure {
        None => Ok(()),
        Some(failure) => Err(Error::Verify { what: format!("'{name}' is wrong: {failure}") }),
    }
}

/// What the flags say.
fn stated(ndf: &str, model: &ModelArgs, picture: &Picture) -> Result<(Hypothesis, Vec<Content>)> {
    let request = TableRequest {
        size: (picture.width, picture.height),
        ndf: ndf.into(),
        visibility: model.visibility.clone().unwrap_or_default(),
        axes: model.axes.clone(),
        points: axis::Points::parse(&model.points)?,
        flip_v: model.flip_v,
        channels: model.channels.clone(),
        ..TableRequest::new("split-sum")
    };
    let job = request.resolve()?;
    if job.channels.len() > picture.components.len() {
        return Err(Error::usage(
            format!("{} channels are named, but the file has {}", job.channels.len(), picture.components.len()),
            "name what its channels hold, in order, e.g. --channels scale,bias",
        ));
    }
    let side = |axis: &Axis| Side {
        warp: axis.warp,
        points: match axis.points {
            axis::Points::Centers => Points::Centers,
            axis::Points::Edges => Points::Edges,
        },
        reversed: axis.reversed,
        shift: 0,
    };
    let content = |name: &str| {
        let quantity = Quantity::ALL.into_iter().find(|q| q.name() == name);
        Content::Of(quantity.expect("the channels of the split-sum table are quantities"))
    };
    let mut contents: Vec<Content> = job.channel_facts().map(|c| content(c.name)).collect();
    contents.resize(picture.components.len(), Content::Unknown);
    let layout = Layout { x: side(&job.axes[0]), y: side(&job.axes[1]) };
    Ok((Hypothesis { model: job.model, layout, transfer: Transfer::Linear }, contents))
}
