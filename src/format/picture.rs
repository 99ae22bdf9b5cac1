// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures that anyone may have written: the plain numbers of level 0, component by component, and how finely each is
//! stored. Nothing that the file says about colour is applied.
//!
//! The first bytes tell the container: KTX2 (plain, Zstandard or zlib), KTX, DDS, OpenEXR, Radiance HDR, PNG, NumPy. Bare
//! texels need a size and an encoding.

use std::io::{Cursor, Read};
use std::path::Path;

use ::exr::prelude as e;
use ::exr::prelude::{ReadChannels, ReadLayers};
use ::ktx2::{Header, LevelIndex, SupercompressionScheme};
use ::png::{BitDepth, ColorType, Decoder, Transformations};
use half::f16;
use image_dds::ddsfile::{Caps2, D3DFormat, Dds, DxgiFormat, MiscFlag};
use image_dds::{ImageFormat, Surface};

use super::{
    DEFLATE_RATIO, Encoding, Format, Hdr, Ktx1, Npy, Pictures, Repr, ZSTD_RATIO, decode, exp2i, plausible,
    torn_palette, unzstd,
};
use crate::bake::MAX_SIZE;
use crate::error::{Error, Result};
use crate::texture::Shape;

/// How finely a component is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// A float with this many significant bits, the leading one included; even below 2^`least_exponent`.
    Float {
        /// Significant bits.
        bits: i32,
        /// Exponent of the smallest normal number.
        least_exponent: i32,
    },
    /// An integer over [0, 1] with this largest number.
    Integer(u32),
    /// Mantissas of this many bits that share the exponent of the texel's largest component.
    Shared(i32),
    /// Bytes that a formula makes values of.
    Scaled(Repr),
    /// Blocks of 4 × 4 texels, compressed with loss.
    Blocks,
}

const HALF: Precision = Precision::Float { bits: 11, least_exponent: -14 };
const SINGLE: Precision = Precision::Float { bits: 24, least_exponent: -126 };

impl Precision {
    /// The largest integer, for integers.
    pub fn steps(self) -> Option<u32> {
        if let Precision::Integer(steps) = self { Some(steps) } else { None }
    }

    /// Half the distance between the numbers that can be stored near `value`; `largest` is the texel's largest component.
    pub fn half_step(self, value: f64, largest: f64) -> f64 {
        let exponent = |v: f64| v.abs().max(f64::MIN_POSITIVE).log2().floor() as i32;
        match self {
            Precision::Float { bits, least_exponent } => f64::from(exponent(value).max(least_exponent) - bits).exp2(),
            Precision::Integer(steps) => 0.5 / f64::from(steps),
            Precision::Shared(bits) => f64::from(exponent(largest) - bits).exp2(),
            Precision::Scaled(repr) => Encoding::fitting(repr, 3).map_or(f64::NAN, |e| e.half_ulp_at(value, largest)),
            // Ends of 5 or 6 bits, and two steps between them.
            Precision::Blocks => 0.5 / 64.0,
        }
    }
}

/// A number of a file.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    /// The number.
    pub value: f64,
    /// Half the distance to its neighbours.
    pub half_step: f64,
}

/// What is known of a component.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// Its name in the file, R, G, B and A where it has none.
    pub name: String,
    /// How finely it is stored.
    pub precision: Precision,
}

/// A picture of one level.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Texels from left to right.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What each texel has.
    pub components: Vec<Component>,
    /// How it is stored, for people.
    pub stored: String,
    /// Rows from the top, texels from the left, components interleaved.
    pub values: Vec<f32>,
}

impl Picture {
    /// The numbers of a texel.
    pub fn texel(&self, x: u32, y: u32) -> Vec<Value> {
        let n = self.components.len();
        let first = (y as usize * self.width as usize + x as usize) * n;
        let texel = &self.values[first..first + n];
        let largest = f64::from(texel.iter().fold(0.0f32, |a, b| a.max(b.abs())));
        let value = |(v, c): (&f32, &Component)| {
            let value = f64::from(*v);
            Value { value, half_step: c.precision.half_step(value, largest) }
        };
        texel.iter().zip(&self.components).map(value).collect()
    }

    /// Reads a file of one table, whose container its first bytes tell. Numbers that are not finite are refused.
    pub fn read(path: &Path) -> Result<Picture> {
        Self::read_layer(path, None)
    }

    /// The same of a file that may hold several, of which one is named: a layer of an array, a part of an OpenEXR file, or a
    /// slice of a NumPy array.
    pub fn read_layer(path: &Path, layer: Option<u32>) -> Result<Picture> {
        let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
        Self::parse(path, &bytes, layer)
    }

    /// [`Picture::read_layer`] of a file's content; `path` only names it in an error.
    pub fn parse(path: &Path, bytes: &[u8], layer: Option<u32>) -> Result<Picture> {
        let picture = match bytes.get(..4).unwrap_or_default() {
            [0xab, b'K', b'T', b'X'] if bytes.get(5) == Some(&b'1') => ours(&Ktx1, path, bytes, layer),
            [0xab, b'K', b'T', b'X'] => ktx2(path, bytes, layer),
            [0x93, b'N', b'U', b'M'] => ours(&Npy, path, bytes, layer),
            b"DDS " => dds(path, bytes, layer),
            [0x76, 0x2f, 0x31, 0x01] => exr(path, bytes, layer),
            [b'#', b'?', ..] => ours(&Hdr, path, bytes, layer),
            [0x89, b'P', b'N', b'G'] => chosen(path, 1, layer).and_then(|_| png(path, bytes)),
            _ => Err(Error::input(
                path,
                "its first bytes are those of no container that is read here",
                "give a .ktx2, .ktx, .dds, .exr, .hdr, .png or .npy file; for bare texels say --size WxH --encoding NAME",
            )),
        }?;
        picture.checked(path)
    }

    /// Reads bare texels, rows from the top.
    pub fn read_raw(path: &Path, (width, height): (u32, u32), encoding: Encoding) -> Result<Picture> {
        accept(path, width, height)?;
        let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
        let pictures = Pictures { width, height, count: 1 };
        let wanted = encoding.level_bytes(pictures).unwrap_or(u64::MAX);
        if bytes.len() as u64 != wanted {
            let what =
                format!("it has {} bytes, but {width}x{height} texels as {} have {wanted}", bytes.len(), encoding.name);
            return Err(Error::input(path, what, "check --size and --encoding; bare texels have no header"));
        }
        let values = decode(&bytes, encoding.components, pictures, encoding);
        let components = components(encoding.components, encoding.repr);
        Picture { width, height, components, stored: encoding.name.into(), values }.checked(path)
    }

    fn checked(self, path: &Path) -> Result<Picture> {
        if let Some(bad) = self.values.iter().position(|v| !v.is_finite()) {
            let texel = bad / self.components.len();
            let (x, y) = (texel % self.width as usize, texel / self.width as usize);
            let what = format!("texel ({x}, {y}) holds {}", self.values[bad]);
            return Err(Error::input(path, what, "a lookup table holds finite numbers: write it again"));
        }
        Ok(self)
    }
}

/// Components that are stored like this, without names of their own.
fn components(n: usize, repr: Repr) -> Vec<Component> {
    match repr {
        Repr::F16 => named(n, HALF),
        Repr::F32 => named(n, SINGLE),
        Repr::Unorm8 => named(n, Precision::Integer(255)),
        Repr::Unorm16 => named(n, Precision::Integer(65535)),
        Repr::Unorm10 => named(n, Precision::Integer(1023)),
        Repr::Rgbe8 => named(n, Precision::Shared(8)),
        Repr::Rgb9e5 => named(n, Precision::Shared(9)),
        Repr::B10g11r11 => Packing::B10g11r11.components(),
        Repr::Rgbd8 | Repr::Rgbm8 | Repr::Rgbp8 => named(n, Precision::Scaled(repr)),
        Repr::Bc4 | Repr::Bc5 | Repr::Bc6h => named(n, Precision::Blocks),
    }
}

/// Components without names of their own.
fn named(n: usize, precision: Precision) -> Vec<Component> {
    ["R", "G", "B", "A"][..n].iter().map(|name| Component { name: (*name).into(), precision }).collect()
}

/// Refuses what cannot be a table.
fn accept(path: &Path, width: u32, height: u32) -> Result<()> {
    if (1..=MAX_SIZE).contains(&width) && (1..=MAX_SIZE).contains(&height) {
        return Ok(());
    }
    let what = format!("it has {width}x{height} texels");
    Err(Error::input(path, what, format!("a table has 1 to {MAX_SIZE} texels a side")))
}

/// How a GPU stores a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Packing {
    /// Floats of this many bytes.
    Floats(usize, usize),
    /// Integers of this many bytes; how many; blue comes first.
    Integers(usize, usize, bool),
    /// 10 bits a component and 2 of alpha; red lowest, or blue.
    Ten { blue_lowest: bool },
    /// Floats without sign of 11, 11 and 10 bits, red lowest.
    B10g11r11,
    /// Three mantissas of 9 bits and an exponent, red lowest.
    Rgb9e5,
    /// Blocks, of which this many components count.
    Blocks(ImageFormat, usize),
}

impl Packing {
    fn components(self) -> Vec<Component> {
        match self {
            Packing::Floats(bytes, n) => named(n, if bytes == 2 { HALF } else { SINGLE }),
            Packing::Integers(bytes, n, _) => named(n, Precision::Integer(if bytes == 1 { 255 } else { 65535 })),
            Packing::Ten { .. } => {
                let mut list = named(4, Precision::Integer(1023));
                list[3].precision = Precision::Integer(3);
                list
            }
            Packing::B10g11r11 => {
                let mut list = named(3, Precision::Float { bits: 7, least_exponent: -14 });
                list[2].precision = Precision::Float { bits: 6, least_exponent: -14 };
                list
            }
            Packing::Rgb9e5 => named(3, Precision::Shared(9)),
            Packing::Blocks(_, n) => named(n, Precision::Blocks),
        }
    }

    fn bytes(self, width: u32, height: u32) -> usize {
        let texel = match self {
            Packing::Floats(bytes, n) | Packing::Integers(bytes, n, _) => bytes * n,
            Packing::Ten { .. } | Packing::B10g11r11 | Packing::Rgb9e5 => 4,
            Packing::Blocks(format, _) => {
                let small = matches!(format, ImageFormat::BC1RgbaUnorm | ImageFormat::BC4RUnorm);
                return width.div_ceil(4) as usize * height.div_ceil(4) as usize * if small { 8 } else { 16 };
            }
        };
        width as usize * height as usize * texel
    }

    /// The numbers of `bytes`, which has [`Packing::bytes`]; an error says why they cannot be decoded.
    fn decode(self, width: u32, height: u32, bytes: &[u8]) -> std::result::Result<Vec<f32>, String> {
        let words = || bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
        Ok(match self {
            Packing::Floats(2, _) => bytes.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect(),
            Packing::Floats(..) => bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
            Packing::Integers(size, n, blue_first) => {
                let mut values: Vec<f32> = match size {
                    1 => bytes.iter().map(|b| f32::from(*b) / 255.0).collect(),
                    _ => bytes.as_chunks().0.iter().map(|b| f32::from(u16::from_le_bytes(*b)) / 65535.0).collect(),
                };
                if blue_first {
                    values.chunks_exact_mut(n).for_each(|texel| texel.swap(0, 2));
                }
                values
            }
            Packing::Ten { blue_lowest } => words()
                .flat_map(|w| {
                    let c = [0, 10, 20].map(|shift| (w >> shift & 0x3ff) as f32 / 1023.0);
                    let [r, g, b] = if blue_lowest { [c[2], c[1], c[0]] } else { c };
                    [r, g, b, (w >> 30) as f32 / 3.0]
                })
                .collect(),
            Packing::B10g11r11 => words()
                .flat_map(|w| {
                    // A half float without its sign and its last bits.
                    [(w & 0x7ff) << 4, (w >> 11 & 0x7ff) << 4, w >> 22 << 5].map(|h| f16::from_bits(h as u16).to_f32())
                })
                .collect(),
            Packing::Rgb9e5 => words()
                .flat_map(|w| {
                    let scale = exp2i((w >> 27) as i32 - 24) as f32;
                    [0, 9, 18].map(|shift| (w >> shift & 0x1ff) as f32 * scale)
                })
                .collect(),
            Packing::Blocks(image_format, n) => {
                let surface = Surface { width, height, depth: 1, layers: 1, mipmaps: 1, image_format, data: bytes };
                let decoded = surface.decode_rgbaf32().map_err(|e| e.to_string())?;
                decoded.data.chunks_exact(4).flat_map(|texel| texel[..n].to_vec()).collect()
            }
        })
    }
}

/// VkFormat and what it means.
const VK_FORMATS: &[(u32, Packing)] = &[
    (9, Packing::Integers(1, 1, false)),
    (16, Packing::Integers(1, 2, false)),
    (23, Packing::Integers(1, 3, false)),
    (29, Packing::Integers(1, 3, false)),
    (30, Packing::Integers(1, 3, true)),
    (37, Packing::Integers(1, 4, false)),
    (43, Packing::Integers(1, 4, false)),
    (44, Packing::Integers(1, 4, true)),
    (50, Packing::Integers(1, 4, true)),
    (58, Packing::Ten { blue_lowest: true }),
    (64, Packing::Ten { blue_lowest: false }),
    (70, Packing::Integers(2, 1, false)),
    (76, Packing::Floats(2, 1)),
    (77, Packing::Integers(2, 2, false)),
    (83, Packing::Floats(2, 2)),
    (84, Packing::Integers(2, 3, false)),
    (90, Packing::Floats(2, 3)),
    (91, Packing::Integers(2, 4, false)),
    (97, Packing::Floats(2, 4)),
    (100, Packing::Floats(4, 1)),
    (103, Packing::Floats(4, 2)),
    (106, Packing::Floats(4, 3)),
    (109, Packing::Floats(4, 4)),
    (122, Packing::B10g11r11),
    (123, Packing::Rgb9e5),
    (131, Packing::Blocks(ImageFormat::BC1RgbaUnorm, 3)),
    (137, Packing::Blocks(ImageFormat::BC3RgbaUnorm, 4)),
    (139, Packing::Blocks(ImageFormat::BC4RUnorm, 1)),
    (141, Packing::Blocks(ImageFormat::BC5RgUnorm, 2)),
    (143, Packing::Blocks(ImageFormat::BC6hRgbUfloat, 3)),
    (145, Packing::Blocks(ImageFormat::BC7RgbaUnorm, 4)),
];

const CONVERT: &str = "write it as half floats, e.g. VK_FORMAT_R16G16_SFLOAT or R16G16_FLOAT";

fn ktx2(path: &Path, bytes: &[u8], layer: Option<u32>) -> Result<Picture> {
    let unsound = |e: &dyn std::fmt::Display| Error::input(path, format!("it is not a sound KTX2 file: {e}"), "");
    let cut = || unsound(&"it ends too early");
    let header = bytes.first_chunk().ok_or_else(cut)?;
    let header = Header::from_bytes(header).map_err(|e| unsound(&e))?;
    if header.face_count != 1 || header.pixel_depth > 1 {
        return Err(not_flat(path));
    }
    let layers = header.layer_count.max(1);
    let layer = chosen(path, layers, layer)? as usize;
    let (width, height) = (header.pixel_width, header.pixel_height.max(1));
    accept(path, width, height)?;
    let vk = header.format.map_or(0, |f| f.value());
    let stored_as = header.format.map_or(String::new(), |f| format!("{f:?}"));
    let Some((_, packing)) = VK_FORMATS.iter().find(|(known, _)| *known == vk) else {
        return Err(Error::input(path, format!("its texels have VkFormat {vk}, which is not read here"), CONVERT));
    };

    let index = bytes.get(Header::LENGTH..).and_then(|rest| rest.first_chunk()).ok_or_else(cut)?;
    let level = LevelIndex::from_bytes(index);
    let range = |from: u64, len: u64| Some(usize::try_from(from).ok()?..usize::try_from(from.checked_add(len)?).ok()?);
    let stored = range(level.byte_offset, level.byte_length).and_then(|r| bytes.get(r)).ok_or_else(cut)?;
    let wanted = packing.bytes(width, height);
    let all = (wanted as u64).checked_mul(layers.into()).ok_or_else(cut)?;
    let plain = match header.supercompression_scheme {
        None => stored.to_vec(),
        Some(SupercompressionScheme::Zstandard) => {
            plausible(path, Some(all), stored.len() as u64, ZSTD_RATIO)?;
            unzstd(stored, all).map_err(|e| unsound(&e))?
        }
        Some(SupercompressionScheme::ZLIB) => {
            // One byte more than there should be is enough to refuse the rest.
            let mut out = vec![];
            let decoder = flate2::read::ZlibDecoder::new(stored);
            decoder.take(all.saturating_add(1)).read_to_end(&mut out).map_err(|e| unsound(&e))?;
            out
        }
        Some(other) => {
            return Err(Error::input(path, format!("its levels are supercompressed by {other:?}"), CONVERT));
        }
    };
    if plain.len() as u64 != all {
        return Err(unsound(&format!("its first level has {} bytes instead of {all}", plain.len())));
    }
    let values = packing.decode(width, height, &plain[layer * wanted..][..wanted]).map_err(|e| unsound(&e))?;
    Ok(Picture { width, height, components: packing.components(), stored: stored_as, values })
}

fn of_dxgi(format: DxgiFormat) -> Option<Packing> {
    use DxgiFormat as D;
    Some(match format {
        D::R8_UNorm => Packing::Integers(1, 1, false),
        D::R8G8_UNorm => Packing::Integers(1, 2, false),
        D::R8G8B8A8_UNorm | D::R8G8B8A8_UNorm_sRGB => Packing::Integers(1, 4, false),
        D::B8G8R8A8_UNorm | D::B8G8R8A8_UNorm_sRGB => Packing::Integers(1, 4, true),
        D::R10G10B10A2_UNorm => Packing::Ten { blue_lowest: false },
        D::R16_UNorm => Packing::Integers(2, 1, false),
        D::R16G16_UNorm => Packing::Integers(2, 2, false),
        D::R16G16B16A16_UNorm => Packing::Integers(2, 4, false),
        D::R16_Float => Packing::Floats(2, 1),
        D::R16G16_Float => Packing::Floats(2, 2),
        D::R16G16B16A16_Float => Packing::Floats(2, 4),
        D::R32_Float => Packing::Floats(4, 1),
        D::R32G32_Float => Packing::Floats(4, 2),
        D::R32G32B32_Float => Packing::Floats(4, 3),
        D::R32G32B32A32_Float => Packing::Floats(4, 4),
        D::R11G11B10_Float => Packing::B10g11r11,
        D::R9G9B9E5_SharedExp => Packing::Rgb9e5,
        D::BC1_UNorm | D::BC1_UNorm_sRGB => Packing::Blocks(ImageFormat::BC1RgbaUnorm, 3),
        D::BC3_UNorm | D::BC3_UNorm_sRGB => Packing::Blocks(ImageFormat::BC3RgbaUnorm, 4),
        D::BC4_UNorm => Packing::Blocks(ImageFormat::BC4RUnorm, 1),
        D::BC5_UNorm => Packing::Blocks(ImageFormat::BC5RgUnorm, 2),
        D::BC6H_UF16 => Packing::Blocks(ImageFormat::BC6hRgbUfloat, 3),
        D::BC7_UNorm | D::BC7_UNorm_sRGB => Packing::Blocks(ImageFormat::BC7RgbaUnorm, 4),
        _ => return None,
    })
}

fn of_d3d(format: D3DFormat) -> Option<Packing> {
    use D3DFormat as D;
    Some(match format {
        D::L8 => Packing::Integers(1, 1, false),
        D::A8B8G8R8 | D::X8B8G8R8 => Packing::Integers(1, 4, false),
        D::A8R8G8B8 | D::X8R8G8B8 => Packing::Integers(1, 4, true),
        D::R8G8B8 => Packing::Integers(1, 3, true),
        D::L16 => Packing::Integers(2, 1, false),
        D::G16R16 => Packing::Integers(2, 2, false),
        D::A16B16G16R16 => Packing::Integers(2, 4, false),
        D::R16F => Packing::Floats(2, 1),
        D::G16R16F => Packing::Floats(2, 2),
        D::A16B16G16R16F => Packing::Floats(2, 4),
        D::R32F => Packing::Floats(4, 1),
        D::G32R32F => Packing::Floats(4, 2),
        D::A32B32G32R32F => Packing::Floats(4, 4),
        _ => return None,
    })
}

fn dds(path: &Path, bytes: &[u8], layer: Option<u32>) -> Result<Picture> {
    let unsound = |e: &dyn std::fmt::Display| Error::input(path, format!("it is not a sound DDS file: {e}"), "");
    let dds = Dds::read(bytes).map_err(|e| unsound(&e))?;
    let (width, height) = (dds.header.width, dds.header.height);
    let cube = dds.header.caps2.contains(Caps2::CUBEMAP);
    let cube = cube || dds.header10.as_ref().is_some_and(|h| h.misc_flag.contains(MiscFlag::TEXTURECUBE));
    if cube || dds.header.depth.unwrap_or(1) > 1 {
        return Err(not_flat(path));
    }
    let layers = dds.header10.as_ref().map_or(1, |h| h.array_size.max(1));
    let layer = chosen(path, layers, layer)? as usize;
    accept(path, width, height)?;
    let (dxgi, d3d) = (dds.get_dxgi_format(), dds.get_d3d_format());
    let name = dxgi.map(|f| format!("{f:?}")).or(d3d.map(|f| format!("{f:?}"))).unwrap_or("unknown".into());
    let Some(packing) = dxgi.and_then(of_dxgi).or_else(|| d3d.and_then(of_d3d)) else {
        return Err(Error::input(path, format!("its format is {name}, which is not read here"), CONVERT));
    };
    let wanted = packing.bytes(width, height);
    // Each layer with all its mips.
    let layer = dds.data.chunks((dds.data.len() / layers as usize).max(1)).nth(layer).unwrap_or_default();
    let level = layer.get(..wanted).ok_or_else(|| unsound(&format!("it has fewer than {wanted} bytes of texels")))?;
    let values = packing.decode(width, height, level).map_err(|e| unsound(&e))?;
    Ok(Picture { width, height, components: packing.components(), stored: name, values })
}

fn exr(path: &Path, bytes: &[u8], layer: Option<u32>) -> Result<Picture> {
    let unsound = |e: e::Error| Error::input(path, format!("it is not a sound OpenEXR file: {e}"), "");

    // The header's numbers first: the reader would take memory for as many texels as they claim.
    let headers = e::MetaData::read_from_buffered(bytes, false).map_err(unsound)?.headers;
    let mut size = Some(0_u64);
    for header in &headers {
        let texels = (header.layer_size.width() as u64).checked_mul(header.layer_size.height() as u64);
        let values = texels.and_then(|n| n.checked_mul(4 * header.channels.list.len() as u64));
        size = size.and_then(|sum| sum.checked_add(values?));
    }
    plausible(path, size, bytes.len() as u64, DEFLATE_RATIO)?;
    let part = chosen(path, u32::try_from(headers.len()).unwrap_or(u32::MAX), layer)?;
    let image = e::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(unsound)?;
    let layer = image.layer_data.into_iter().nth(part as usize);
    let layer = layer.ok_or_else(|| Error::input(path, "it has no picture", "only flat pictures are known"))?;
    let limited = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
    let (width, height) = (limited(layer.size.width()), limited(layer.size.height()));
    accept(path, width, height)?;

    // Channels come sorted by name; R, G, B and A have an order of their own.
    let mut list: Vec<_> = layer.channel_data.list.iter().collect();
    let rank = |name: &str| ["R", "G", "B", "A"].iter().position(|n| *n == name).unwrap_or(4);
    list.sort_by_key(|c| rank(&c.name.to_string()));
    if !(1..=4).contains(&list.len()) || list.iter().any(|c| c.sampling != e::Vec2(1, 1)) {
        let names: Vec<String> = list.iter().map(|c| c.name.to_string()).collect();
        let what = format!("its channels are {}", names.join(", "));
        return Err(Error::input(path, what, "give one to four channels with a value for every texel"));
    }
    let precision = |c: &&e::AnyChannel<e::FlatSamples>| match c.sample_data {
        e::FlatSamples::F16(_) => HALF,
        _ => SINGLE,
    };
    let components: Vec<Component> =
        list.iter().map(|c| Component { name: c.name.to_string(), precision: precision(c) }).collect();
    let n = components.len();
    let mut values = vec![0.0; n * width as usize * height as usize];
    for (c, channel) in list.iter().enumerate() {
        let texels = values.iter_mut().skip(c).step_by(n);
        match &channel.sample_data {
            e::FlatSamples::F16(samples) => texels.zip(samples).for_each(|(to, v)| *to = v.to_f32()),
            e::FlatSamples::F32(samples) => texels.zip(samples).for_each(|(to, v)| *to = *v),
            e::FlatSamples::U32(samples) => texels.zip(samples).for_each(|(to, v)| *to = *v as f32),
        }
    }
    let kind = if components[0].precision == HALF { "half" } else { "float" };
    Ok(Picture { width, height, stored: format!("OpenEXR {kind}"), components, values })
}

/// Which of a file's tables is meant: the one that was named, or the only one.
fn chosen(path: &Path, layers: u32, layer: Option<u32>) -> Result<u32> {
    match layer {
        Some(layer) if layer < layers => Ok(layer),
        None if layers == 1 => Ok(0),
        Some(layer) => Err(Error::input(path, format!("it has no layer {layer}"), format!("it has {layers}, from 0"))),
        None => Err(Error::input(
            path,
            format!("it holds {layers} tables"),
            format!("name one of them with --layer, from 0 to {}", layers - 1),
        )),
    }
}

fn not_flat(path: &Path) -> Error {
    Error::input(path, "it is neither a 2-D texture nor an array of such", "only tables of two dimensions are known")
}

/// A format of which others' files are read as ours are.
fn ours(format: &dyn Format, path: &Path, bytes: &[u8], layer: Option<u32>) -> Result<Picture> {
    let (texture, encoding) = format.parse(path, bytes)?;
    if texture.shape == Shape::Cube {
        return Err(not_flat(path));
    }
    let layer = chosen(path, texture.faces(), layer)? as usize;
    accept(path, texture.width, texture.height)?;
    let components = components(texture.channels.len(), encoding.repr);
    let len = texture.width as usize * texture.height as usize * components.len();
    let values = texture.levels[0][layer * len..][..len].to_vec();
    let stored = format!("{} {}", format.name(), encoding.name);
    Ok(Picture { width: texture.width, height: texture.height, components, stored, values })
}

fn png(path: &Path, bytes: &[u8]) -> Result<Picture> {
    let unsound = |e: ::png::DecodingError| Error::input(path, format!("it is not a sound PNG file: {e}"), "");
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND);
    let mut file = decoder.read_info().map_err(unsound)?;
    if let Some(what) = torn_palette(file.info()) {
        return Err(Error::input(path, what, ""));
    }
    let (width, height) = (file.info().width, file.info().height);
    accept(path, width, height)?;
    let (color, depth) = file.output_color_type();
    let bytes_each = if depth == BitDepth::Sixteen { 2 } else { 1 };
    let names: &[&str] = match color {
        ColorType::Grayscale => &["R"],
        ColorType::GrayscaleAlpha => &["R", "A"],
        ColorType::Rgb | ColorType::Indexed => &["R", "G", "B"],
        ColorType::Rgba => &["R", "G", "B", "A"],
    };
    let size = u64::from(width) * u64::from(height) * (bytes_each * names.len()) as u64;
    plausible(path, Some(size), bytes.len() as u64, DEFLATE_RATIO)?;
    let mut texels = vec![0; size as usize];
    file.next_frame(&mut texels).map_err(unsound)?;
    file.finish().map_err(unsound)?;
    let (values, steps) = match bytes_each {
        1 => (texels.iter().map(|b| f32::from(*b) / 255.0).collect(), 255),
        // The high byte first.
        _ => (texels.as_chunks().0.iter().map(|b| f32::from(u16::from_be_bytes(*b)) / 65535.0).collect(), 65535),
    };
    let component = |name: &&str| Component { name: (*name).into(), precision: Precision::Integer(steps) };
    let components: Vec<Component> = names.iter().map(component).collect();
    let stored = format!("PNG {} x {} bits", names.len(), 8 * bytes_each);
    Ok(Picture { width, height, components, stored, values })
}
