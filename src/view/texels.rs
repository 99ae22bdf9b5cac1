// SPDX-License-Identifier: MIT OR Apache-2.0
//! Texels on their way into a page: half floats as base64.

use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::report::halves;
use crate::spheres::Lut;
use crate::spheres::maps::rgb;
use crate::texture::Texture;

/// The largest half float.
const MOST: f32 = 65504.0;

/// All levels of a cube: sizes, what texels are multiplied with, and the texels, level by level, face by face.
pub fn cube(cube: &Texture) -> Result<Value> {
    let levels: Vec<Vec<[f32; 3]>> = (0..cube.levels.len()).map(|m| rgb(cube, m)).collect();
    let values = || levels.iter().flatten().flatten().copied();
    finite(values())?;
    let scale = scale_of(values().fold(0.0, f32::max));
    Ok(json!({
        "size": cube.width,
        "levels": levels.len(),
        "scale": scale,
        "texels": halves(values().map(|v| v / scale)),
    }))
}

/// Scale, bias and tint of a table, rows from the top.
pub fn table(lut: &Lut) -> Result<String> {
    let values = || lut.texels.iter().flat_map(|[scale, bias, f82, _]| [*scale, *bias, *f82]);
    finite(values())?;
    Ok(halves(values().map(|v| v.clamp(-MOST, MOST))))
}

fn finite(mut values: impl Iterator<Item = f32>) -> Result<()> {
    match values.find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(bad) => Err(Error::usage(format!("a texel holds {bad}, which cannot be shown"), "bake the file again")),
    }
}

/// The power of two that brings values up to `most` into the range of half floats.
fn scale_of(most: f32) -> f32 {
    let mut scale = 1.0;
    while most / scale > MOST {
        scale *= 2.0;
    }
    scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suns_fit() {
        assert_eq!([0.0, 1.0, 65504.0, 65505.0, 1.6e6].map(scale_of), [1.0, 1.0, 1.0, 2.0, 32.0]);
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        assert!(finite([0.0, 1.0].into_iter()).is_ok());
        assert!(finite([0.0, f32::NAN].into_iter()).is_err());
        assert!(finite([f32::INFINITY].into_iter()).is_err());
    }
}
