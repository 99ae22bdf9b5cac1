// SPDX-License-Identifier: MIT OR Apache-2.0
//! PlayCanvas' environment atlas: everything that its shaders read of an environment, in one square picture.
//!
//! ```text
//!    0          256        512
//!    ┌─────────────────────┐
//!    │ sharp 0: 512 × 256  │   sharp i: means over texels, half as wide and high each,
//!    │                     │            at (1 − 2⁻ⁱ)(512, 512)
//!    ├──────────┬──────────┤   rough i: GGX at roughness 2i/11, 1 at i = 6,
//! 256│ rough 1  │ sharp 1  │            at (0, (1 − 2⁻ⁱ) 512)
//!    ├────┬──┬──┼─────┬────┤   ambient: irradiance over π, 64 × 32 at (128, 384)
//! 384│ 2  │a.│  │     │ 2  │
//!    └────┴──┴──┴─────┴────┘
//! ```
//!
//! Every tile is an equirectangular picture with a gutter of one texel in 512 (PlayCanvas: `env-lighting.js`, chunk
//! `envAtlas.js`). Rough tiles and sharp tile 0 are a chain of mips of a [`SpecularJob`] with a gutter, which is how
//! [`Atlas::unpack`] hands them to the checks.

use super::RoughnessLaw;
use super::specular::{SpecularJob, SpecularRequest, with_gutter};
use crate::env::{Environment, resample};
use crate::error::{Error, Result};
use crate::progress::OnProgress;
use crate::texture::{Shape, Texture};

/// The value of the meta's `projection`, and the name on the command line.
pub const NAME: &str = "playcanvas-atlas";
/// Texels along a side unless told otherwise: what PlayCanvas' shaders count on.
pub const SIDE: u32 = 512;
/// Sides of the picture come in multiples of this.
const UNIT: u32 = SIDE;
/// Sharp tiles, tile 0 included.
const SHARP: u32 = 6;
/// Mips of the chain: sharp tile 0 and the rough ones.
const MIPS: u32 = 7;
/// Channels of a texel.
const RGB: usize = 3;

/// An atlas to bake.
#[derive(Clone)]
pub struct Atlas {
    /// Sharp tile 0 and the rough tiles.
    pub specular: SpecularJob,
    /// The ambient tile.
    pub ambient: SpecularJob,
}

/// Where a tile lies: left, top, width, height.
type Tile = [u32; 4];

impl Atlas {
    /// An atlas of `side` × `side` texels.
    pub fn new(side: u32, quality: &str) -> Result<Atlas> {
        if side == 0 || !side.is_multiple_of(UNIT) {
            let what = format!("an atlas of {side} texels along a side cannot be baked");
            return Err(Error::usage(what, format!("use --size {UNIT} or a multiple of it")));
        }
        let request = SpecularRequest {
            shape: "equirect".into(),
            size: Some(side / 2),
            mips: Some(MIPS),
            roughness_law: RoughnessLaw::Playcanvas.name().into(),
            quality: quality.into(),
            gutter: side / UNIT,
            ..SpecularRequest::default()
        };
        let ambient =
            SpecularRequest { kernel: "lambert".into(), size: Some(side / 16), mips: Some(1), ..request.clone() };
        Ok(Atlas { specular: request.resolve()?, ambient: ambient.resolve()? })
    }

    /// The atlas that a file holds, if it holds one.
    pub fn from_meta(texture: &Texture) -> Result<Option<Atlas>> {
        if texture.meta.get("projection") != Some(NAME) {
            return Ok(None);
        }
        if texture.shape != Shape::Map || texture.width != texture.height || texture.channels.len() < RGB {
            return Err(Error::usage("it says that it is an atlas and is not", "bake it again"));
        }
        Atlas::new(texture.width, texture.meta.get("quality").unwrap_or_default()).map(Some)
    }

    /// Texels along a side.
    pub fn side(&self) -> u32 {
        2 * self.specular.size
    }

    fn sharp(&self, i: u32) -> Tile {
        let side = self.side();
        [side - (side >> i), side - (side >> i), side >> i, side >> (i + 1)]
    }

    /// Mip 0 is sharp tile 0.
    fn of_mip(&self, m: u32) -> Tile {
        let [_, y, width, height] = self.sharp(m);
        [0, y, width, height]
    }

    fn ambient_tile(&self) -> Tile {
        let side = self.side();
        [side / 4, side / 4 * 3, side / 8, side / 16]
    }

    /// Puts a baked chain and a baked ambient map into one picture, with sharp tiles made from the environment. Everything
    /// else is black.
    pub fn pack<'a>(
        &self,
        environment: impl Into<Environment<'a>>,
        chain: &Texture,
        ambient: &Texture,
        on: &mut OnProgress<'_>,
    ) -> Result<Texture> {
        let (environment, side) = (environment.into(), self.side());
        let mut texels = vec![0.0; RGB * (side * side) as usize];
        let mut put = |[left, top, width, _]: Tile, tile: &[f32]| {
            for (row, from) in tile.chunks_exact(RGB * width as usize).enumerate() {
                let at = RGB * ((top + row as u32) * side + left) as usize;
                texels[at..at + from.len()].copy_from_slice(from);
            }
        };
        for (m, level) in (0..).zip(&chain.levels) {
            put(self.of_mip(m), level);
        }
        let gutter = self.specular.gutter;
        for i in 1..SHARP {
            let tile @ [_, _, width, height] = self.sharp(i);
            let inner = (width - 2 * gutter, height - 2 * gutter);
            put(tile, &with_gutter(resample::equirect(&environment, inner, on)?, inner, gutter));
        }
        put(self.ambient_tile(), &ambient.levels[0]);
        let mut meta = chain.meta.clone();
        meta.set("projection", NAME);
        meta.set("layout", "tiles of equirectangular pictures, see PlayCanvas' envAtlas.js");
        let channels = chain.channels.clone();
        Ok(Texture { shape: Shape::Map, width: side, height: side, channels, levels: vec![texels], meta })
    }

    /// The chain and the ambient map of a packed picture.
    pub fn unpack(&self, packed: &Texture) -> [Texture; 2] {
        let cut = |[left, top, width, height]: Tile| -> Vec<f32> {
            let rows = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
            rows.flat_map(|(x, y)| packed.texel(0, 0, x, y)[..RGB].to_vec()).collect()
        };
        let texture = |job: &SpecularJob, levels: Vec<Vec<f32>>| {
            let (width, height) = job.level_size(0);
            let mut meta = packed.meta.clone();
            meta.set("projection", job.projection.name());
            Texture { shape: Shape::Map, width, height, channels: packed.channels[..RGB].to_vec(), levels, meta }
        };
        [
            texture(&self.specular, (0..MIPS).map(|m| cut(self.of_mip(m))).collect()),
            texture(&self.ambient, vec![cut(self.ambient_tile())]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_lie_where_the_engine_reads_them() {
        let atlas = Atlas::new(512, "standard").expect("it can be baked");
        assert_eq!(atlas.sharp(0), [0, 0, 512, 256]);
        assert_eq!(atlas.sharp(1), [256, 256, 256, 128]);
        assert_eq!(atlas.sharp(5), [496, 496, 16, 8]);
        assert_eq!(atlas.of_mip(1), [0, 256, 256, 128]);
        assert_eq!(atlas.of_mip(6), [0, 504, 8, 4]);
        assert_eq!(atlas.ambient_tile(), [128, 384, 64, 32]);
        // No texel belongs to two tiles.
        let tiles = (0..SHARP).map(|i| atlas.sharp(i)).chain((1..MIPS).map(|m| atlas.of_mip(m)));
        let mut taken = vec![false; 512 * 512];
        for [left, top, width, height] in tiles.chain([atlas.ambient_tile()]) {
            for (x, y) in (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y))) {
                assert!(!std::mem::replace(&mut taken[(y * 512 + x) as usize], true), "({x}, {y})");
            }
        }
        assert!(Atlas::new(500, "standard").is_err());
    }
}
