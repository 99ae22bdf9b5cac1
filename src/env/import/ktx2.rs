// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cubes in KTX2, plain or supercompressed with Zstandard or zlib. Only the largest level is read.

use std::io::{Read, Seek, SeekFrom};

use ::ktx2::{Header, LevelIndex, SupercompressionScheme};
use image_dds::ImageFormat;

use super::packed::Packing;
use super::watched::Watched;
use super::{Color, Job};
use crate::env::CubeMap;
use crate::error::{Error, Result};
use crate::format::{DEFLATE_RATIO, ZSTD_RATIO, unzstd};

const CONVERT: &str = "write the cube as rgba16f, e.g. VK_FORMAT_R16G16B16A16_SFLOAT";

/// VkFormat and what it means.
const FORMATS: &[(u32, Packing)] = &[
    (23, Packing::Unorm8 { components: 3, bgr: false, color: Color::Linear }),
    (29, Packing::Unorm8 { components: 3, bgr: false, color: Color::Srgb }),
    (30, Packing::Unorm8 { components: 3, bgr: true, color: Color::Linear }),
    (36, Packing::Unorm8 { components: 3, bgr: true, color: Color::Srgb }),
    (37, Packing::Unorm8 { components: 4, bgr: false, color: Color::Linear }),
    (43, Packing::Unorm8 { components: 4, bgr: false, color: Color::Srgb }),
    (44, Packing::Unorm8 { components: 4, bgr: true, color: Color::Linear }),
    (50, Packing::Unorm8 { components: 4, bgr: true, color: Color::Srgb }),
    (76, Packing::F16(1)),
    (84, Packing::Unorm16(3, Color::Linear)),
    (90, Packing::F16(3)),
    (91, Packing::Unorm16(4, Color::Linear)),
    (97, Packing::F16(4)),
    (100, Packing::F32(1)),
    (106, Packing::F32(3)),
    (109, Packing::F32(4)),
    (122, Packing::B10g11r11),
    (123, Packing::Rgb9e5),
    (143, Packing::Blocks(ImageFormat::BC6hRgbUfloat, Color::Linear)),
    (144, Packing::Blocks(ImageFormat::BC6hRgbSfloat, Color::Linear)),
    (145, Packing::Blocks(ImageFormat::BC7RgbaUnorm, Color::Linear)),
    (146, Packing::Blocks(ImageFormat::BC7RgbaUnorm, Color::Srgb)),
];

pub fn read(job: &Job<'_>, mut file: Watched<'_, '_>) -> Result<CubeMap> {
    let state = file.state();
    let io = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => job.damaged("KTX2", "it ends too early"),
        _ => state.explain(job.path, e),
    };
    let mut header = [0; Header::LENGTH];
    file.read_exact(&mut header).map_err(io)?;
    let header = Header::from_bytes(&header).map_err(|e| job.damaged("KTX2", e))?;

    // What it is.
    let size = header.pixel_width;
    if header.face_count != 6 || header.pixel_depth != 0 || header.layer_count > 1 {
        let what = "it holds a KTX2 texture that is not a single cube";
        return Err(Error::input(job.path, what, "give a cube, or the picture as .exr, .hdr or .png"));
    }
    check_face(job, size, header.pixel_height)?;
    let vk_format = header.format.map_or(0, |f| f.value());
    let Some((_, packing)) = FORMATS.iter().find(|(vk, _)| *vk == vk_format) else {
        let what = match vk_format {
            0 => "its texels are supercompressed for transcoding (Basis Universal)".into(),
            vk => format!("its texels have VkFormat {vk}, which is not read here"),
        };
        return Err(Error::input(job.path, what, CONVERT));
    };
    let packing = packing.with_color(job)?;

    // The largest level.
    let mut index = [0; LevelIndex::LENGTH];
    file.read_exact(&mut index).map_err(io)?;
    let level = LevelIndex::from_bytes(&index);
    let face_bytes = packing.size_bytes(size, size);
    let wanted = 6 * face_bytes;
    let stored = usize::try_from(level.byte_length).ok().filter(|n| *n as u64 <= file.length());
    let stored = stored.ok_or_else(|| job.damaged("KTX2", "its first level is longer than the file"))?;
    file.seek(SeekFrom::Start(level.byte_offset)).map_err(io)?;
    let level = file.take(stored as u64);
    let ratio = match header.supercompression_scheme {
        None => 1,
        Some(SupercompressionScheme::Zstandard) => ZSTD_RATIO,
        Some(_) => DEFLATE_RATIO,
    };
    job.plausible(wanted as u64, stored as u64, ratio)?;
    let bytes = match header.supercompression_scheme {
        None => collect(level, wanted),
        Some(SupercompressionScheme::Zstandard) => unzstd(level, wanted as u64),
        Some(SupercompressionScheme::ZLIB) => collect(flate2::read::ZlibDecoder::new(level), wanted),
        Some(other) => {
            return Err(Error::input(job.path, format!("its levels are supercompressed by {other:?}"), CONVERT));
        }
    };
    let bytes = bytes.map_err(|e| if state.is_cancelled() { Error::Cancelled } else { job.damaged("KTX2", e) })?;
    if bytes.len() != wanted {
        return Err(job.damaged("KTX2", format!("its first level has {} bytes instead of {wanted}", bytes.len())));
    }
    let mut texels = Vec::with_capacity(6 * size as usize * size as usize);
    for face in bytes.chunks_exact(face_bytes) {
        packing.decode(size, size, face, &mut texels).map_err(|e| job.damaged("KTX2", e))?;
    }
    Ok(CubeMap { size, texels })
}

/// At most `wanted` bytes, and one more where there are more.
fn collect(from: impl Read, wanted: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(wanted);
    from.take(wanted as u64 + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// Refuses faces that are not square, or too large.
pub fn check_face(job: &Job<'_>, width: u32, height: u32) -> Result<()> {
    let most = super::MAX_FACE;
    if width == 0 || width != height || width > most {
        let what = format!("its faces are {width}x{height}");
        return Err(Error::input(job.path, what, format!("give square faces of at most {most}x{most}")));
    }
    Ok(())
}
