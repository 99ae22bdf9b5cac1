// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a baked file says of its input, so that a check can read the same input in the same way.

use super::{Adjust, Color, Imported, Layout, Options};
use crate::env::FileAxes;
use crate::error::{Error, Result};
use crate::texture::Meta;

/// Key of the axes of the file.
const FILE_AXES: &str = "file-axes";

impl Options {
    /// Writes how `imported` was read; what was left alone is not mentioned.
    pub fn describe(&self, imported: &Imported, meta: &mut Meta) {
        let adjust = &self.adjust;
        meta.set("input.layout", imported.layout);
        if let Some(color) = self.color {
            meta.set("input.color", color.name());
        }
        if let Some(part) = &self.part {
            meta.set("input.part", part);
        }
        if let Some(negative) = imported.adjusted.negative {
            meta.set("input.negative", format!("{} texels, down to {}, count as 0", negative.count, negative.lowest));
        }
        if adjust.repair {
            meta.set("input.repaired", format!("{} texels", imported.adjusted.repaired));
        }
        if adjust.exposure_ev != 0.0 {
            meta.set("input.exposure", adjust.exposure_ev);
        }
        if adjust.scale != 1.0 {
            meta.set("input.scale", adjust.scale);
        }
        if let Some(most) = adjust.clamp {
            meta.set("input.clamp", most);
            meta.set("input.clamp.removed", format!("{:.4} % of the mean radiance", 100.0 * imported.adjusted.removed));
        }
        if self.mirror {
            meta.set("input.mirror", "x");
        }
        if self.turns_deg != [0.0; 3] {
            meta.set("input.rotate", self.turns_deg.map(|v| v.to_string()).join(","));
        }
        if self.file_axes != FileAxes::IDENTITY {
            meta.set(FILE_AXES, self.file_axes.name());
        }
    }

    /// The reverse of [`Options::describe`].
    pub fn from_meta(meta: &Meta) -> Result<Options> {
        let wrong = |key: &str, text: &str| {
            let help = "bake the environment again";
            Error::usage(format!("the file says '{key}' is '{text}', which is not understood"), help)
        };
        let number =
            |key: &str| meta.get(key).map(|text| text.parse::<f64>().map_err(|_| wrong(key, text))).transpose();
        let turns_deg = match meta.get("input.rotate") {
            None => [0.0; 3],
            Some(text) => {
                let parts: Vec<f64> = text.split(',').filter_map(|part| part.parse().ok()).collect();
                parts.try_into().map_err(|_| wrong("input.rotate", text))?
            }
        };
        Ok(Options {
            // Six files and cubes are known by themselves.
            layout: meta.get("input.layout").and_then(|name| Layout::parse(name).ok()),
            color: meta.get("input.color").map(Color::parse).transpose()?,
            part: meta.get("input.part").map(String::from),
            adjust: Adjust {
                exposure_ev: number("input.exposure")?.unwrap_or(0.0),
                scale: number("input.scale")?.unwrap_or(1.0),
                clamp: number("input.clamp")?,
                repair: meta.get("input.repaired").is_some(),
            },
            mirror: meta.get("input.mirror").is_some(),
            turns_deg,
            file_axes: meta.get(FILE_AXES).map(FileAxes::parse).transpose()?.unwrap_or_default(),
        })
    }
}
