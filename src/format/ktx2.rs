// SPDX-License-Identifier: MIT OR Apache-2.0
//! KTX2 (Khronos Texture 2.0): tables over two axes or three, arrays of tables, maps of the sphere and cubes in every
//! encoding that GPUs read, mips and all, plain or with each level compressed by Zstandard.
//!
//! Written here after the KTX 2.0 specification and the Khronos Data Format Specification 1.3; read with the `ktx2`
//! crate, so that a mistake of ours does not cancel itself out. A table or map has rows from the top (`KTXorientation` `rd`,
//! as a cube's faces must have); a one-dimensional table is a 2-D texture of height 1. Bytes that need a formula (`rgbd8`
//! and its like) are R8G8B8A8_UNORM; their pair `encoding` says which.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use ::ktx2 as reader;

use super::encoding::{Pictures, decode, encoded};
use super::{
    Compression, Encoding, Format, Repr, Storage, WRITER, ZSTD_RATIO, check, from_pairs, is_map, pairs, plausible,
    stated_encoding,
};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Khronos Texture 2.0.
#[derive(Debug)]
pub struct Ktx2;

/// VkFormat of each encoding. The first of those that share one is what the container says by itself.
const VK_FORMATS: &[(&str, u32)] = &[
    ("r16f", 76),
    ("rg16f", 83),
    ("rgba16f", 97),
    ("r32f", 100),
    ("rg32f", 103),
    ("rgba32f", 109),
    ("r8unorm", 9),
    ("rg8unorm", 16),
    ("rgba8unorm", 37),
    ("r16unorm", 70),
    ("rg16unorm", 77),
    ("rgba16unorm", 91),
    ("a2b10g10r10", 64),
    ("b10g11r11", 122),
    ("rgb9e5", 123),
    ("rgbd8", 37),
    ("rgbm8", 37),
    ("rgbp8", 37),
    ("bc4", 139),
    ("bc5", 141),
    ("bc6h", 143),
];

/// Zstandard's level: slow to write, and read as fast as any.
const ZSTD_LEVEL: i32 = 19;

fn known() -> impl Iterator<Item = (Encoding, u32)> {
    VK_FORMATS.iter().map(|&(name, vk)| (Encoding::parse(name).expect("each name is in ENCODINGS"), vk))
}

impl Format for Ktx2 {
    fn name(&self) -> &'static str {
        "KTX2"
    }

    fn extension(&self) -> &'static str {
        "ktx2"
    }

    fn holds_mips(&self) -> bool {
        true
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        known().map(|(encoding, _)| encoding).filter(|e| e.holds(shape)).collect()
    }

    fn compressions(&self) -> &'static [Compression] {
        &Compression::ALL
    }

    fn default_encoding(&self, _: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::F16, channels)
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
        let unsound = |e: reader::ParseError| wrong(format!("it is not a sound KTX2 file: {e}"));
        let header = bytes.first_chunk().ok_or(reader::ParseError::UnexpectedEnd).map_err(unsound)?;
        let header = reader::Header::from_bytes(header).map_err(unsound)?;

        // What kind of texture it is, if one that we know.
        let vk_format = header.format.map_or(0, |f| f.value());
        let Some((container, _)) = known().find(|(_, vk)| *vk == vk_format) else {
            let names: Vec<&str> = known().map(|(e, _)| e.name).collect();
            let help = format!("known are: {}", names.join(", "));
            return Err(Error::input(path, format!("its texels have VkFormat {vk_format}"), help));
        };
        let compression = match header.supercompression_scheme {
            None => Compression::Plain,
            Some(reader::SupercompressionScheme::Zstandard) => Compression::Zstd,
            Some(other) => {
                let what = format!("its levels are compressed by {other:?}");
                return Err(Error::input(path, what, "write it plain or with Zstandard"));
            }
        };
        let (width, height) = (header.pixel_width, header.pixel_height.max(1));
        let shape = match (header.face_count, header.pixel_depth, header.layer_count) {
            // An array of one layer holds what a table holds.
            (1, 0, 0 | 1) => Shape::Table,
            (1, 0, layers) => Shape::Array { layers },
            (1, depth, 0) if header.pixel_height > 0 => Shape::Volume { depth },
            (6, 0, 0) if width == height => Shape::Cube,
            _ => {
                return Err(wrong(
                    "it is neither a 2-D texture, an array of such or a 3-D texture, nor a plain cube".into(),
                ));
            }
        };

        // The crate's parser panics on a texel block of 256 texels (ktx2 0.5.0), so the descriptor is looked at first.
        // Others may state another version of it, another transfer, or no bytes of a plane that is compressed.
        let ours = data_format_descriptor(container, Compression::Plain);
        let theirs = bytes.get(header.index.dfd_byte_offset as usize..).unwrap_or_default();
        let is_same = |part: std::ops::Range<usize>| theirs.get(part.clone()) == Some(&ours[part]);
        let is_same_plane = is_same(20..21) || (compression == Compression::Zstd && theirs.get(20) == Some(&0));
        let is_ours = is_same(4..8) && is_same(10..12) && is_same(16..20) && is_same_plane;
        if header.index.dfd_byte_length as usize != ours.len() || !is_ours {
            return Err(wrong("its data format descriptor does not match its VkFormat".into()));
        }
        let file = reader::Reader::new(bytes).map_err(unsound)?;

        let strings: Vec<(&str, &str)> = file
            .key_value_data()
            .filter_map(|(key, value)| {
                let text = std::str::from_utf8(value).ok()?;
                Some((key, text.strip_suffix('\0').unwrap_or(text)))
            })
            .collect();
        let encoding = stated_encoding(path, container, strings.iter().copied())?;
        let default = &["r", "g", "b", "a"][..encoding.components];
        let (channels, meta) = from_pairs(path, strings, default, encoding.components)?;
        let shape = if shape == Shape::Table && is_map(&meta) { Shape::Map } else { shape };

        // Levels. A table's mips, in a file of others, are blurred values: only level 0 is data.
        let mut texture = Texture { shape, width, height, channels, levels: vec![], meta };
        let is_table = shape.is_table();
        let wanted = if is_table { 1 } else { 32 - width.max(height).leading_zeros() as usize };
        if file.levels().len() > wanted && !is_table {
            return Err(wrong("it has more levels than its size allows".into()));
        }
        for (i, level) in file.levels().enumerate().take(wanted) {
            let pictures = Pictures::of(&texture, i);
            let size = encoding.level_bytes(pictures);
            let data = match compression {
                Compression::Plain => Cow::Borrowed(level.data),
                Compression::Zstd => {
                    plausible(path, size, level.data.len() as u64, ZSTD_RATIO)?;
                    Cow::Owned(
                        decompress(level.data, size.unwrap_or(0))
                            .map_err(|e| wrong(format!("its level {i} is not sound Zstandard data: {e}")))?,
                    )
                }
            };
            if size != Some(data.len() as u64) {
                return Err(wrong(format!("level {i} has {} bytes, which is not its size", data.len())));
            }
            texture.levels.push(decode(&data, texture.channels.len(), pictures, encoding));
        }
        Ok((texture, encoding))
    }
}

/// The file, of levels as it holds them before any compression.
fn file(path: &Path, texture: &Texture, storage: Storage, plain: Vec<Vec<u8>>) -> Result<Vec<u8>> {
    let encoding = storage.encoding;
    let vk_format = known().find(|(e, _)| *e == encoding).map(|(_, vk)| vk).expect("check() refuses other encodings");
    let compressed = |level: &Vec<u8>| {
        zstd::bulk::compress(level, ZSTD_LEVEL).map(Cow::Owned).map_err(|e| Error::io("write", path, e))
    };
    let levels: Vec<Cow<'_, [u8]>> = match storage.compression {
        Compression::Plain => plain.iter().map(|level| Cow::Borrowed(&level[..])).collect(),
        Compression::Zstd => plain.iter().map(compressed).collect::<Result<_>>()?,
    };
    let dfd = data_format_descriptor(encoding, storage.compression);
    let kvd = key_value_data(texture, encoding);

    // Where everything lies. Levels follow smallest first, each aligned for a copy to the GPU unless it must be
    // decompressed first.
    let dfd_offset = HEADER_BYTES + LEVEL_INDEX_BYTES * levels.len();
    let kvd_offset = dfd_offset + dfd.len();
    let alignment = if storage.compression == Compression::Plain { lcm4(encoding.unit_bytes()) } else { 1 };
    let mut end = kvd_offset + kvd.len();
    let mut offsets = vec![0; levels.len()];
    for (offset, level) in offsets.iter_mut().zip(&levels).rev() {
        *offset = end.next_multiple_of(alignment);
        end = *offset + level.len();
    }

    // Header, index, level index.
    let mut out = Vec::with_capacity(end);
    out.extend([0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n']);
    let type_size = match encoding.repr {
        Repr::F16 | Repr::Unorm16 => 2,
        Repr::F32 | Repr::Unorm10 | Repr::B10g11r11 | Repr::Rgb9e5 => 4,
        _ => 1,
    };
    let (pixel_depth, layer_count, faces) = match texture.shape {
        Shape::Volume { depth } => (depth, 0, 1),
        Shape::Array { layers } => (0, layers, 1),
        Shape::Table | Shape::Map | Shape::Cube => (0, 0, texture.faces()),
    };
    let supercompression = if storage.compression == Compression::Zstd { 2 } else { 0 };
    for field in [
        vk_format,
        type_size,
        texture.width,
        texture.height,
        pixel_depth,
        layer_count,
        faces,
        levels.len() as u32,
        supercompression,
        dfd_offset as u32,
        dfd.len() as u32,
        kvd_offset as u32,
        kvd.len() as u32,
    ] {
        out.extend(field.to_le_bytes());
    }
    let (sgd_offset, sgd_length) = (0_u64, 0_u64);
    out.extend(sgd_offset.to_le_bytes());
    out.extend(sgd_length.to_le_bytes());
    for ((offset, level), plain) in offsets.iter().zip(&levels).zip(&plain) {
        for field in [*offset, level.len(), plain.len()] {
            out.extend((field as u64).to_le_bytes());
        }
    }

    // Descriptor, pairs, levels.
    out.extend(dfd);
    out.extend(kvd);
    for (offset, level) in offsets.iter().zip(&levels).rev() {
        out.resize(*offset, 0);
        out.extend_from_slice(level);
    }
    Ok(out)
}

/// At most `size` bytes and one more, which is enough to refuse the rest.
fn decompress(data: &[u8], size: u64) -> std::io::Result<Vec<u8>> {
    let mut out = vec![];
    zstd::Decoder::new(data)?.take(size.saturating_add(1)).read_to_end(&mut out)?;
    Ok(out)
}

const HEADER_BYTES: usize = 80;
const LEVEL_INDEX_BYTES: usize = 24;

/// Least common multiple with 4 of the size of a texel or block.
fn lcm4(unit_bytes: usize) -> usize {
    match unit_bytes % 4 {
        0 => unit_bytes,
        2 => unit_bytes * 2,
        _ => unit_bytes * 4,
    }
}

/// One sample of a descriptor: bits, what they are, and what the bounds of their values are.
struct Sample {
    offset: u32,
    bits: u32,
    /// Channel and qualifiers.
    kind: u32,
    lower: u32,
    upper: u32,
}

const EXPONENT: u32 = 0x20;
const SIGNED: u32 = 0x40;
const FLOAT: u32 = 0x80;
/// Channels of the colour models RGBSDA, BC4, BC5 and BC6H: red, green, blue, alpha.
const CHANNEL_IDS: [u32; 4] = [0, 1, 2, 15];

/// The samples of an encoding, as the specification's tables of formats list them.
fn samples(encoding: Encoding) -> Vec<Sample> {
    let single = |v: f32| v.to_bits();
    let plain = |bits: u32, kind: u32, lower: u32, upper: u32, count: usize| {
        let sample = |i: usize| Sample { offset: i as u32 * bits, bits, kind: CHANNEL_IDS[i] | kind, lower, upper };
        (0..count).map(sample).collect::<Vec<_>>()
    };
    match encoding.repr {
        // The bounds of a float sample are single floats, for halves too.
        Repr::F16 => plain(16, FLOAT | SIGNED, single(-1.0), single(1.0), encoding.components),
        Repr::F32 => plain(32, FLOAT | SIGNED, single(-1.0), single(1.0), encoding.components),
        Repr::Unorm8 => plain(8, 0, 0, 255, encoding.components),
        Repr::Rgbd8 | Repr::Rgbm8 | Repr::Rgbp8 | Repr::Rgbe8 => plain(8, 0, 0, 255, 4),
        Repr::Unorm16 => plain(16, 0, 0, 65535, encoding.components),
        Repr::Unorm10 => {
            let mut list = plain(10, 0, 0, 1023, 3);
            list.push(Sample { offset: 30, bits: 2, kind: CHANNEL_IDS[3], lower: 0, upper: 3 });
            list
        }
        Repr::B10g11r11 => [(0, 11), (11, 11), (22, 10)]
            .iter()
            .zip(CHANNEL_IDS)
            .map(|(&(offset, bits), id)| Sample { offset, bits, kind: id | FLOAT, lower: 0, upper: single(1.0) })
            .collect(),
        // Each mantissa, reaching 2 at the bias of 15 with the exponent of 5 bits that all share.
        Repr::Rgb9e5 => [0, 9, 18]
            .iter()
            .zip(CHANNEL_IDS)
            .flat_map(|(&offset, id)| {
                [
                    Sample { offset, bits: 9, kind: id, lower: 0, upper: 8448 },
                    Sample { offset: 27, bits: 5, kind: id | EXPONENT, lower: 15, upper: 31 },
                ]
            })
            .collect(),
        Repr::Bc4 => plain(64, 0, 0, u32::MAX, 1),
        Repr::Bc5 => plain(64, 0, 0, u32::MAX, 2),
        Repr::Bc6h => plain(128, FLOAT, 0, single(1.0), 1),
    }
}

/// A total size and one basic descriptor block (Data Format Specification 1.3, chapter 5). Of compressed levels it states
/// no bytes of a plane, as KTX 2.0 asks for.
fn data_format_descriptor(encoding: Encoding, compression: Compression) -> Vec<u8> {
    const PRIMARIES_BT709: u32 = 1;
    const TRANSFER_LINEAR: u32 = 1;
    const VERSION: u32 = 2;
    let model = match encoding.repr {
        Repr::Bc4 => 131,
        Repr::Bc5 => 132,
        Repr::Bc6h => 133,
        _ => 1,
    };
    let samples = samples(encoding);
    let block_bytes = 24 + 16 * samples.len() as u32;
    let vendor_and_type = 0;
    // Stored less one.
    let side = encoding.unit_side() - 1;
    let planes_4_to_7 = 0;
    let mut words = vec![
        4 + block_bytes,
        vendor_and_type,
        VERSION | (block_bytes << 16),
        model | (PRIMARIES_BT709 << 8) | (TRANSFER_LINEAR << 16),
        side | side << 8,
        if compression == Compression::Plain { encoding.unit_bytes() as u32 } else { 0 },
        planes_4_to_7,
    ];
    for Sample { offset, bits, kind, lower, upper } in samples {
        let sample_position = 0;
        words.extend([offset | (bits - 1) << 16 | kind << 24, sample_position, lower, upper]);
    }
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Pairs sorted by key, each with its length, NUL after key and value, padded to 4 bytes.
fn key_value_data(texture: &Texture, encoding: Encoding) -> Vec<u8> {
    let mut pairs = pairs(texture, encoding);
    pairs.push(("KTXwriter".into(), WRITER.into()));
    // A cube's orientation is `rd` by definition; stating it is left to the specification.
    match texture.shape {
        Shape::Cube => {}
        // Slices go into the texture.
        Shape::Volume { .. } => pairs.push(("KTXorientation".into(), "rdi".into())),
        Shape::Table | Shape::Array { .. } | Shape::Map => pairs.push(("KTXorientation".into(), "rd".into())),
    }
    // Byte order of UTF-8 is code point order.
    pairs.sort();
    let mut out = Vec::new();
    for (key, value) in pairs {
        out.extend((key.len() as u32 + 1 + value.len() as u32 + 1).to_le_bytes());
        out.extend(key.bytes().chain([0]).chain(value.bytes()).chain([0]));
        out.resize(out.len().next_multiple_of(4), 0);
    }
    out
}
