// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cubes in DDS. Only the largest level is read.

use std::io::BufReader;

use image_dds::ImageFormat;
use image_dds::ddsfile::{Caps2, D3DFormat, Dds, DxgiFormat, MiscFlag};

use super::ktx2::check_face;
use super::packed::Packing;
use super::watched::Watched;
use super::{Color, Job};
use crate::env::CubeMap;
use crate::error::{Error, Result};

const CONVERT: &str = "write the cube as R16G16B16A16_FLOAT";

/// What a format with a header of Direct3D 10 or later means.
fn of_dxgi(format: DxgiFormat) -> Option<Packing> {
    use DxgiFormat as D;
    let bytes = |bgr: bool, color: Color| Packing::Unorm8 { components: 4, bgr, color };
    Some(match format {
        D::R32G32B32A32_Float => Packing::F32(4),
        D::R32G32B32_Float => Packing::F32(3),
        D::R32_Float => Packing::F32(1),
        D::R16G16B16A16_Float => Packing::F16(4),
        D::R16_Float => Packing::F16(1),
        D::R16G16B16A16_UNorm => Packing::Unorm16(4, Color::Linear),
        D::R11G11B10_Float => Packing::B10g11r11,
        D::R9G9B9E5_SharedExp => Packing::Rgb9e5,
        D::R8G8B8A8_UNorm => bytes(false, Color::Linear),
        D::R8G8B8A8_UNorm_sRGB => bytes(false, Color::Srgb),
        D::B8G8R8A8_UNorm | D::B8G8R8X8_UNorm => bytes(true, Color::Linear),
        D::B8G8R8A8_UNorm_sRGB | D::B8G8R8X8_UNorm_sRGB => bytes(true, Color::Srgb),
        D::BC1_UNorm => Packing::Blocks(ImageFormat::BC1RgbaUnorm, Color::Linear),
        D::BC1_UNorm_sRGB => Packing::Blocks(ImageFormat::BC1RgbaUnorm, Color::Srgb),
        D::BC2_UNorm => Packing::Blocks(ImageFormat::BC2RgbaUnorm, Color::Linear),
        D::BC2_UNorm_sRGB => Packing::Blocks(ImageFormat::BC2RgbaUnorm, Color::Srgb),
        D::BC3_UNorm => Packing::Blocks(ImageFormat::BC3RgbaUnorm, Color::Linear),
        D::BC3_UNorm_sRGB => Packing::Blocks(ImageFormat::BC3RgbaUnorm, Color::Srgb),
        D::BC6H_UF16 => Packing::Blocks(ImageFormat::BC6hRgbUfloat, Color::Linear),
        D::BC6H_SF16 => Packing::Blocks(ImageFormat::BC6hRgbSfloat, Color::Linear),
        D::BC7_UNorm => Packing::Blocks(ImageFormat::BC7RgbaUnorm, Color::Linear),
        D::BC7_UNorm_sRGB => Packing::Blocks(ImageFormat::BC7RgbaUnorm, Color::Srgb),
        _ => return None,
    })
}

/// What an older format means. Its integers say nothing of their colour: they are taken as sRGB, as in PNG and JPEG.
fn of_d3d(format: D3DFormat) -> Option<Packing> {
    use D3DFormat as D;
    let bytes = |components: usize, bgr: bool| Packing::Unorm8 { components, bgr, color: Color::Srgb };
    Some(match format {
        D::A32B32G32R32F => Packing::F32(4),
        D::R32F => Packing::F32(1),
        D::A16B16G16R16F => Packing::F16(4),
        D::R16F => Packing::F16(1),
        D::A16B16G16R16 => Packing::Unorm16(4, Color::Srgb),
        D::A8R8G8B8 | D::X8R8G8B8 => bytes(4, true),
        D::A8B8G8R8 | D::X8B8G8R8 => bytes(4, false),
        D::R8G8B8 => bytes(3, true),
        _ => return None,
    })
}

pub fn read(job: &Job<'_>, file: Watched<'_, '_>) -> Result<CubeMap> {
    let state = file.state();
    let refuse =
        |e: image_dds::ddsfile::Error| if state.is_cancelled() { Error::Cancelled } else { job.damaged("DDS", e) };
    let dds = Dds::read(BufReader::with_capacity(1 << 18, file)).map_err(refuse)?;

    // What it is.
    let (is_cube, cubes) = match &dds.header10 {
        Some(header) => (header.misc_flag.contains(MiscFlag::TEXTURECUBE), header.array_size.max(1)),
        None => (dds.header.caps2.contains(Caps2::CUBEMAP | Caps2::CUBEMAP_ALLFACES), 1),
    };
    if !is_cube || cubes > 6 || (cubes > 1 && cubes < 6) {
        let what = "it holds a DDS texture that is not a single cube with all its faces";
        return Err(Error::input(job.path, what, "give a cube, or the picture as .exr, .hdr or .png"));
    }
    let (size, mips) = (dds.header.width, dds.header.mip_map_count.unwrap_or(1).max(1));
    check_face(job, size, dds.header.height)?;
    let packing = dds.get_dxgi_format().and_then(of_dxgi).or_else(|| dds.get_d3d_format().and_then(of_d3d));
    let Some(packing) = packing else {
        let name = match (dds.get_dxgi_format(), dds.get_d3d_format()) {
            (Some(format), _) => format!("{format:?}"),
            (None, Some(format)) => format!("{format:?}"),
            (None, None) => "unknown".into(),
        };
        return Err(Error::input(job.path, format!("its format is {name}, which is not read here"), CONVERT));
    };
    let packing = packing.with_color(job)?;

    // Each face is followed by its smaller levels.
    if mips > 32 - size.leading_zeros() {
        return Err(job.damaged("DDS", format!("{mips} levels are more than {size}x{size} texels have")));
    }
    let level = |m: u32| packing.size_bytes((size >> m).max(1), (size >> m).max(1));
    let stride: usize = (0..mips).map(level).sum();
    if dds.data.len() < 6 * stride {
        let what = format!("it has {} bytes of texels instead of {}", dds.data.len(), 6 * stride);
        return Err(job.damaged("DDS", what));
    }
    let mut texels = Vec::with_capacity(6 * size as usize * size as usize);
    for face in dds.data.chunks_exact(stride).take(6) {
        packing.decode(size, size, &face[..level(0)], &mut texels).map_err(|e| job.damaged("DDS", e))?;
    }
    Ok(CubeMap { size, texels })
}
