// SPDX-License-Identifier: MIT OR Apache-2.0
//! How `brdf-baker env` is told to read an environment.

use std::path::Path;

use brdf_baker::env::FileAxes;
use brdf_baker::env::import::{Adjust, Color, Imported, Layout, Options};
use brdf_baker::{Error, Result};

use super::console::Console;

#[derive(clap::Args)]
#[command(next_help_heading = "Input")]
pub struct SourceArgs {
    /// What lies where in a picture: equirect, strip, vertical-strip, cross, vertical-cross [default: by its aspect
    /// ratio]
    #[arg(long, value_name = "NAME")]
    layout: Option<String>,
    /// What integers mean: srgb or linear [default: as the file says, PNG and JPEG srgb]
    #[arg(long, value_name = "srgb|linear")]
    color: Option<String>,
    /// Part or layer of an OpenEXR file [default: the first with colour]
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
    /// Turn the environment about the vertical, counter-clockwise seen from above: by 90, what was at +Z comes to +X
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    rotate: Option<f64>,
    /// Turn it about the X, the Y and the Z axis, in this order
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "rotate")]
    rotate_xyz: Option<String>,
    /// Mirror it before it is turned: +X and -X change places
    #[arg(long)]
    mirror: bool,
    /// Multiply radiance by 2 to this power
    #[arg(long, value_name = "EV", allow_hyphen_values = true, default_value_t = 0.0, hide_default_value = true)]
    exposure: f64,
    /// Multiply radiance by this
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true, default_value_t = 1.0, hide_default_value = true)]
    scale: f64,
    /// Dim texels whose largest channel exceeds this, after exposure and scale; the energy removed is reported
    #[arg(long, value_name = "MAX", allow_hyphen_values = true)]
    clamp: Option<f64>,
    /// Replace texels that are infinite or not a number instead of refusing them
    #[arg(long)]
    repair: bool,
}

impl SourceArgs {
    /// The same as values.
    pub fn options(self, file_axes: FileAxes) -> Result<Options> {
        let turns_deg = match (self.rotate, &self.rotate_xyz) {
            (Some(degrees), _) => [0.0, degrees, 0.0],
            (None, Some(text)) => angles(text)?,
            (None, None) => [0.0; 3],
        };
        if let Some(bad) = turns_deg.iter().find(|v| !v.is_finite()) {
            return Err(Error::usage(format!("an environment cannot be turned by {bad} degrees"), "give a number"));
        }
        let adjust = Adjust { exposure_ev: self.exposure, scale: self.scale, clamp: self.clamp, repair: self.repair };
        adjust.check()?;
        Ok(Options {
            layout: self.layout.as_deref().map(Layout::parse).transpose()?,
            color: self.color.as_deref().map(Color::parse).transpose()?,
            part: self.part,
            adjust,
            mirror: self.mirror,
            turns_deg,
            file_axes,
        })
    }
}

fn angles(text: &str) -> Result<[f64; 3]> {
    let parts: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    let count = text.split(',').count();
    parts.try_into().ok().filter(|_| count == 3).ok_or_else(|| {
        Error::usage(format!("--rotate-xyz '{text}' is not three angles"), "give degrees as X,Y,Z, e.g. 0,90,0")
    })
}

/// Says what was done to an input.
pub fn warn(input: &Path, options: &Options, imported: &Imported, console: &Console) {
    let name = input.display();
    let adjusted = &imported.adjusted;
    imported.notes.iter().for_each(|note| console.warn(note));
    if adjusted.repaired > 0 {
        console
            .warn(&format!("{} texels of '{name}' were infinite or not a number and were replaced", adjusted.repaired));
    }
    if let Some(negative) = adjusted.negative {
        console.warn(&format!(
            "'{name}' holds {} negative texels, down to {}; they count as 0",
            negative.count, negative.lowest
        ));
    }
    if let Some(most) = options.adjust.clamp {
        console.warn(&format!(
            "{} texels of '{name}' were dimmed to {most}, which removed {:.4} % of its mean radiance",
            adjusted.clamped,
            100.0 * adjusted.removed
        ));
    }
}
