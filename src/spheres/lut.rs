// SPDX-License-Identifier: MIT OR Apache-2.0
//! A table of the split sum as a shader reads it, whatever its axes, its rows and its channels.

use super::parts::Parts;
use crate::axis::{self, Axis, Warp};
use crate::bake::TableJob;
use crate::error::{Error, Result};
use crate::format::picture::Picture;
use crate::texture::Texture;
use crate::verify::identify::{Content, Fit, Points, Side};

/// Scale, bias and the tint of F82, and where they are.
#[derive(Clone, Debug)]
pub struct Lut {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// What runs along x and along y: one is n·v, the other the roughness.
    pub warps: [Warp; 2],
    /// Texel = position · scale + shift, along x and along y; what lies beyond the ends is taken there.
    pub place: [(f64, f64); 2],
    /// Scale, bias, tint and nothing; rows from the top.
    pub texels: Vec<[f32; 4]>,
    /// The table has the tint; where it has not, it is 0.
    pub tinted: bool,
}

impl Lut {
    /// A table that says what it holds.
    pub fn new(table: &Texture) -> Result<Lut> {
        let job = TableJob::from_meta(table)?;
        let name = job.table.facts().name;
        let parts = Parts::of(&table.channels).filter(|_| name == "split-sum");
        let (Some(parts), [x, y]) = (parts, &job.axes[..]) else {
            let what = format!("the spheres cannot be shaded with {} of {name}", table.channels.join(", "));
            return Err(Error::usage(what, "give a table of scale and bias: `brdf-baker bake split-sum`"));
        };
        let texels = table.levels[0].chunks_exact(table.channels.len()).map(|texel| parts.of_texel(texel));
        Ok(Lut {
            width: table.width,
            height: table.height,
            warps: [x.warp, y.warp],
            place: [place_of(x), place_of(y)],
            texels: texels.map(padded).collect(),
            tinted: parts.tinted(),
        })
    }

    /// A table that others made, as it was understood.
    pub fn understood(picture: &Picture, fit: &Fit) -> Result<Lut> {
        let names: Vec<&str> = fit
            .components
            .iter()
            .map(|c| match c.content {
                Content::Of(quantity) => quantity.name(),
                _ => "",
            })
            .collect();
        let parts = Parts::of(&names).ok_or_else(|| {
            Error::usage(
                format!("the spheres cannot be shaded with {}", fit.words()[0].1),
                "give a table of scale and bias: `brdf-baker bake split-sum`",
            )
        })?;
        let layout = fit.hypothesis.layout;
        let texel = |i: u32| {
            let stored = picture.texel(i % picture.width, i / picture.width);
            let values: Vec<f32> =
                fit.hypothesis.transfer.values(&stored).into_iter().map(|value| value as f32).collect();
            padded(parts.of_texel(&values))
        };
        Ok(Lut {
            width: picture.width,
            height: picture.height,
            warps: [layout.x.warp, layout.y.warp],
            place: [place_of_side(&layout.x, picture.width), place_of_side(&layout.y, picture.height)],
            texels: (0..picture.width * picture.height).map(texel).collect(),
            tinted: parts.tinted(),
        })
    }
}

fn padded([scale, bias, f82]: [f32; 3]) -> [f32; 4] {
    [scale, bias, f82, 0.0]
}

/// Scale and shift of an axis of ours: mirrored after it is shifted.
fn place_of(axis: &Axis) -> (f64, f64) {
    let n = f64::from(axis.len);
    let (scale, shift) = match axis.points {
        axis::Points::Centers => (n, -0.5),
        axis::Points::Edges => (n - 1.0, 0.0),
    };
    let shift = shift - f64::from(axis.shift);
    if axis.reversed { (-scale, n - 1.0 - shift) } else { (scale, shift) }
}

/// The same of a side of others: shifted after it is mirrored.
fn place_of_side(side: &Side, len: u32) -> (f64, f64) {
    let n = f64::from(len);
    let (scale, shift) = match side.points {
        Points::Centers => (n, -0.5),
        Points::Edges => (n - 1.0, 0.0),
        Points::Starts => (n, 0.0),
        Points::Ends => (n, -1.0),
    };
    let (scale, shift) = if side.reversed { (-scale, n - 1.0 - shift) } else { (scale, shift) };
    (scale, shift - f64::from(side.shift))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_texel_is_found_at_its_own_position() {
        for points in [axis::Points::Centers, axis::Points::Edges] {
            for (reversed, shift) in [(false, 0), (true, 0), (false, 1), (true, 1)] {
                let axis = Axis { warp: Warp::Roughness, points, len: 8, reversed, shift };
                let (scale, offset) = place_of(&axis);
                // The last one stands for what lies beyond.
                let own = if reversed { 1..8 } else { 0..7 };
                for i in own {
                    let found = axis.position(i) * scale + offset;
                    assert!((found - f64::from(i)).abs() < 1e-12, "{axis:?}: texel {i} is found at {found}");
                }
            }
        }
        for points in [Points::Centers, Points::Edges, Points::Starts, Points::Ends] {
            for (reversed, shift) in [(false, 0), (true, 0), (false, 1), (true, -1)] {
                let side = Side { warp: Warp::Roughness, points, reversed, shift };
                let (scale, offset) = place_of_side(&side, 8);
                for (i, t) in (0..8).filter_map(|i| Some((i, side.at(i, 8)?))) {
                    let found = t * scale + offset;
                    assert!((found - f64::from(i)).abs() < 1e-12, "{side:?}: texel {i} is found at {found}");
                }
            }
        }
    }
}
