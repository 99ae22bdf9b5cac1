// SPDX-License-Identifier: MIT OR Apache-2.0
//! DDS (DirectDraw Surface) with the header of Direct3D 10: tables over two axes or three, arrays of tables, and cubes with
//! their mips, in every encoding that has a DXGI_FORMAT.
//!
//! Header and order of faces, layers and mips (each face with all its mips) after Microsoft's reference of the format, by the
//! `ddsfile` crate. The format has no place for metadata: what was baked, its axes and its certificate are not in the
//! file. `identify` finds a table's model again; who must be able to verify keeps a .ktx2 beside it.

use std::path::Path;

use image_dds::ddsfile::{
    AlphaMode, Caps2, D3D10ResourceDimension, Dds as File, DxgiFormat, MiscFlag, NewDxgiParams, PixelFormat,
    PixelFormatFlags,
};

use super::encoding::{Pictures, decode, encoded};
use super::{Encoding, Format, Repr, Storage, check};
use crate::error::{Error, Result};
use crate::texture::{Meta, Shape, Texture};

/// DirectDraw Surface.
#[derive(Debug)]
pub struct Dds;

/// DXGI_FORMAT of each encoding.
const DXGI_FORMATS: &[(&str, DxgiFormat)] = &[
    ("r16f", DxgiFormat::R16_Float),
    ("rg16f", DxgiFormat::R16G16_Float),
    ("rgba16f", DxgiFormat::R16G16B16A16_Float),
    ("r32f", DxgiFormat::R32_Float),
    ("rg32f", DxgiFormat::R32G32_Float),
    ("rgba32f", DxgiFormat::R32G32B32A32_Float),
    ("r8unorm", DxgiFormat::R8_UNorm),
    ("rg8unorm", DxgiFormat::R8G8_UNorm),
    ("rgba8unorm", DxgiFormat::R8G8B8A8_UNorm),
    ("r16unorm", DxgiFormat::R16_UNorm),
    ("rg16unorm", DxgiFormat::R16G16_UNorm),
    ("rgba16unorm", DxgiFormat::R16G16B16A16_UNorm),
    ("a2b10g10r10", DxgiFormat::R10G10B10A2_UNorm),
    ("b10g11r11", DxgiFormat::R11G11B10_Float),
    ("rgb9e5", DxgiFormat::R9G9B9E5_SharedExp),
    ("bc4", DxgiFormat::BC4_UNorm),
    ("bc5", DxgiFormat::BC5_UNorm),
    ("bc6h", DxgiFormat::BC6H_UF16),
];

fn known() -> impl Iterator<Item = (Encoding, DxgiFormat)> {
    DXGI_FORMATS.iter().map(|&(name, dxgi)| (Encoding::parse(name).expect("each name is in ENCODINGS"), dxgi))
}

impl Format for Dds {
    fn name(&self) -> &'static str {
        "DDS"
    }

    fn extension(&self) -> &'static str {
        "dds"
    }

    fn holds_mips(&self) -> bool {
        true
    }

    fn holds_meta(&self) -> bool {
        false
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        // Nothing in the file could say how a map lies on the sphere.
        known().map(|(encoding, _)| encoding).filter(|e| shape != Shape::Map && e.holds(shape)).collect()
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::F16, channels).filter(|_| shape != Shape::Map)
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        file(path, texture, storage, encoded(texture, storage)?)
    }

    fn to_bytes_of_levels(
        &self,
        path: &Path,
        texture: &Texture,
        storage: Storage,
        levels: Vec<Vec<u8>>,
    ) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        file(path, texture, storage, levels)
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let wrong = |what: String| Error::input(path, what, "");
        let file = File::read(bytes).map_err(|e| wrong(format!("it is not a sound DDS file: {e}")))?;
        let Some(header) = &file.header10 else {
            return Err(Error::input(path, "its header is older than Direct3D 10", "write it with a DX10 header"));
        };
        let Some((encoding, _)) = known().find(|(_, dxgi)| *dxgi == header.dxgi_format) else {
            let names: Vec<&str> = known().map(|(e, _)| e.name).collect();
            let what = format!("its texels are {:?}", header.dxgi_format);
            return Err(Error::input(path, what, format!("known are: {}", names.join(", "))));
        };
        let (width, height) = (file.header.width, file.header.height);
        let is_cube = header.misc_flag.contains(MiscFlag::TEXTURECUBE);
        let is_flat = header.resource_dimension == D3D10ResourceDimension::Texture2D;
        let is_deep = header.resource_dimension == D3D10ResourceDimension::Texture3D && header.array_size == 1;
        let depth = file.header.depth.filter(|depth| is_deep && *depth > 0);
        let shape = match is_cube {
            false if depth.is_some() && width > 0 && height > 0 => depth.map(|depth| Shape::Volume { depth }),
            _ if !is_flat || width == 0 || height == 0 => None,
            true => (width == height && header.array_size == 1).then_some(Shape::Cube),
            false => match header.array_size {
                0 => None,
                1 => Some(Shape::Table),
                layers => Some(Shape::Array { layers }),
            },
        };
        let what = "it is neither a 2-D texture, an array of such or a 3-D texture, nor a plain cube";
        let shape = shape.ok_or_else(|| wrong(what.into()))?;
        let mips = file.header.mip_map_count.unwrap_or(1).max(1);
        if mips > 32 - width.max(height).leading_zeros() || (depth.is_some() && mips > 1) {
            return Err(wrong("it has more levels than its size allows".into()));
        }

        let channels = ["r", "g", "b", "a"][..encoding.components].iter().map(|c| c.to_string()).collect();
        let mut texture = Texture { shape, width, height, channels, levels: vec![], meta: Meta::default() };
        let faces = u64::from(texture.faces());
        let sizes: Option<Vec<u64>> =
            (0..mips as usize).map(|i| Some(encoding.level_bytes(Pictures::of(&texture, i))? / faces)).collect();
        let stride = sizes.as_ref().and_then(|s| s.iter().try_fold(0_u64, |sum, n| sum.checked_add(*n)));
        let (Some(sizes), Some(stride)) =
            (sizes, stride.filter(|s| s.checked_mul(faces) == Some(file.data.len() as u64)))
        else {
            return Err(wrong(format!("it has {} bytes of texels, which is not its size", file.data.len())));
        };
        // A table's mips, in a file of others, are blurred values: only level 0 is data.
        let mut start = 0;
        for (i, size) in sizes.into_iter().enumerate().take(if is_cube { 32 } else { 1 }) {
            let pictures = Pictures { count: 1, ..Pictures::of(&texture, i) };
            let of_face = |face: u64| {
                let from = (face * stride + start) as usize;
                decode(&file.data[from..from + size as usize], encoding.components, pictures, encoding)
            };
            texture.levels.push((0..faces).flat_map(of_face).collect());
            start += size;
        }
        Ok((texture, encoding))
    }
}

/// The file, of levels as it holds them before any compression.
fn file(path: &Path, texture: &Texture, storage: Storage, levels: Vec<Vec<u8>>) -> Result<Vec<u8>> {
    let cannot = |e: image_dds::ddsfile::Error| Error::io("write", path, std::io::Error::other(e));
    let encoding = storage.encoding;
    let is_cube = texture.shape == Shape::Cube;
    let depth = match texture.shape {
        Shape::Volume { depth } => Some(depth),
        _ => None,
    };
    let mut file = File::new_dxgi(NewDxgiParams {
        height: texture.height,
        width: texture.width,
        depth,
        format: known().find(|(e, _)| *e == encoding).map(|(_, d)| d).expect("check() refuses other encodings"),
        mipmap_levels: Some(texture.levels.len() as u32),
        array_layers: match texture.shape {
            Shape::Cube => Some(6),
            Shape::Array { layers } => Some(layers),
            Shape::Table | Shape::Map | Shape::Volume { .. } => None,
        },
        caps2: match depth {
            Some(_) => Some(Caps2::VOLUME),
            None => is_cube.then_some(Caps2::CUBEMAP | Caps2::CUBEMAP_ALLFACES),
        },
        is_cubemap: is_cube,
        resource_dimension: match depth {
            Some(_) => D3D10ResourceDimension::Texture3D,
            None => D3D10ResourceDimension::Texture2D,
        },
        alpha_mode: if texture.channels.len() == 4 { AlphaMode::Custom } else { AlphaMode::Opaque },
    })
    .map_err(cannot)?;
    // The format is in the newer header. The crate adds what older readers would look for, and then mistake it.
    let fourcc = file.header.spf.fourcc.clone();
    file.header.spf = PixelFormat { flags: PixelFormatFlags::FOURCC, fourcc, ..PixelFormat::default() };
    let faces = texture.faces() as usize;
    let of_face =
        |face: usize| levels.iter().flat_map(move |l| &l[l.len() / faces * face..l.len() / faces * (face + 1)]);
    file.data = (0..faces).flat_map(of_face).copied().collect();
    let mut out = vec![];
    file.write(&mut out).map_err(cannot)?;
    Ok(out)
}
