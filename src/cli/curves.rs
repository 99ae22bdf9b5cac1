// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker curves`

use std::path::PathBuf;
use std::time::Instant;

use brdf_baker::format::{self, Output};
use brdf_baker::plot::{Canvas, Curve, Kind, Plot, draw_table};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::bake::parse_size;
use super::console::Console;

#[derive(clap::Args)]
pub struct CurvesArgs {
    /// A table to draw in false colour instead of curves
    table: Option<PathBuf>,
    /// Picture to write: .svg or .png
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// What to plot: d, g, f, or the whole lobe f (n.l), as a chart or polar
    #[arg(long, default_value = "lobe", value_name = "d|g|f|lobe|polar", conflicts_with = "table")]
    plot: String,
    /// A curve in words, e.g. 'beckmann alpha=0.3 smith copper'; may be given several times [default: some that show what
    /// the plot is about]
    #[arg(long = "curve", value_name = "WORDS", conflicts_with = "table")]
    curves: Vec<String>,
    /// Angle between normal and viewer of lobes, in degrees
    #[arg(long, default_value_t = 45.0, value_name = "DEGREES", allow_hyphen_values = true, conflicts_with = "table")]
    view: f64,
    /// Divide each curve by its largest value
    #[arg(long, conflicts_with = "table")]
    relative: bool,
    /// Pixels [default: 800x500, 380x338 a channel of a table]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
}

impl CurvesArgs {
    pub fn run(self, console: &mut Console) -> Result<()> {
        let start = Instant::now();
        let extension = self.output.extension().map(|e| e.to_string_lossy().to_lowercase());
        let vector = match extension.as_deref() {
            Some("svg") => true,
            Some("png") => false,
            _ => {
                let what = format!("'{}' is not named like a picture of curves", self.output.display());
                return Err(Error::usage(what, "write a .svg or .png file"));
            }
        };
        let canvas = |channels| match self.size {
            Some((width, height)) => Canvas { width, height, vector },
            None => Canvas::usual(channels, vector),
        };
        canvas(None).check()?;
        let kind = Kind::parse(&self.plot)?;
        let words: Vec<&str> = match self.curves[..] {
            [] => kind.examples().to_vec(),
            _ => self.curves.iter().map(String::as_str).collect(),
        };
        let curves: Vec<Curve> = words.iter().map(|w| Curve::parse(w)).collect::<Result<_>>()?;
        let output = Output::prepare(&self.output)?;
        let (bytes, canvas, of) = match &self.table {
            Some(table) => {
                let (texture, _) = format::for_path(table)?.read(table)?;
                let canvas = canvas(Some(texture.channels.len()));
                let drawn = draw_table(&texture, canvas)
                    .map_err(|e| Error::input(table, e.to_string(), e.help().to_string()))?;
                (drawn, canvas, format!("{} in false colour", texture.channels.join(", ")))
            }
            None => {
                let (count, canvas) = (curves.len(), canvas(None));
                let plot = Plot { kind, curves, view_deg: self.view, relative: self.relative };
                (plot.draw(canvas)?, canvas, format!("{count} curves of {}", kind.name()))
            }
        };
        let size = output.commit_bytes(&bytes)?;
        let seconds = start.elapsed().as_secs_f64();
        let (path, kind) = (self.output.display(), self.table.is_none().then(|| kind.name()));
        console.result(
            &format!("{path}  {}x{}  {of}  {seconds:.2} s", canvas.width, canvas.height),
            &json!({
                "path": self.output,
                "width": canvas.width,
                "height": canvas.height,
                "table": self.table,
                "plot": kind,
                "curves": if self.table.is_none() { words } else { vec![] },
                "bytes": size,
                "seconds": seconds,
            }),
        )
    }
}
