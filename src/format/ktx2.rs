//! KTX2 (Khronos Texture 2.0): tables, maps of the sphere and cubes as half or single floats, mips and all, ready for a GPU.
//!
//! Written here after the KTX 2.0 specification and the Khronos Data Format Specification 1.3; read with the `ktx2`
//! crate, so that a mistake of ours does not cancel itself out. A table or map has rows from the top (`KTXorientation` `rd`,
//! as a cube's faces must have); a one-dimensional table is a 2-D texture of height 1.

use std::path::Path;

use ::ktx2 as reader;

use super::encoding::{decode, encode};
use super::{Encoding, Format, Repr, WRITER, check, from_pairs, is_map, pairs};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Khronos Texture 2.0.
#[derive(Debug)]
pub struct Ktx2;

/// VkFormat of each encoding.
const VK_FORMATS: &[(&str, u32)] =
    &[("r16f", 76), ("rg16f", 83), ("rgba16f", 97), ("r32f", 100), ("rg32f", 103), ("rgba32f", 109)];

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

    fn encodings(&self, _: Shape) -> Vec<Encoding> {
        known().map(|(encoding, _)| encoding).collect()
    }

    fn default_encoding(&self, _: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::F16, channels)
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, encoding: Encoding) -> Result<Vec<u8>> {
        check(path, self, texture, encoding)?;
        let vk_format =
            known().find(|(e, _)| *e == encoding).map(|(_, vk)| vk).expect("check() refuses other encodings");
        let levels: Vec<Vec<u8>> = texture
            .levels
            .iter()
            .map(|level| encode(level, texture.channels.len(), encoding))
            .collect::<Result<_>>()?;
        let dfd = data_format_descriptor(encoding);
        let kvd = key_value_data(texture);

        // Where everything lies. Levels follow smallest first, each aligned for a copy to the GPU.
        let dfd_offset = HEADER_BYTES + LEVEL_INDEX_BYTES * levels.len();
        let kvd_offset = dfd_offset + dfd.len();
        let alignment = lcm4(encoding.texel_bytes());
        let mut end = kvd_offset + kvd.len();
        let mut offsets = vec![0; levels.len()];
        for (offset, level) in offsets.iter_mut().zip(&levels).rev() {
            *offset = end.next_multiple_of(alignment);
            end = *offset + level.len();
        }

        // Header, index, level index.
        let mut out = Vec::with_capacity(end);
        out.extend([0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n']);
        let type_size = if encoding.repr == Repr::F16 { 2 } else { 4 };
        let (pixel_depth, layer_count, supercompression) = (0, 0, 0);
        for field in [
            vk_format,
            type_size,
            texture.width,
            texture.height,
            pixel_depth,
            layer_count,
            texture.faces(),
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
        for (offset, level) in offsets.iter().zip(&levels) {
            let (length, uncompressed_length) = (level.len() as u64, level.len() as u64);
            for field in [*offset as u64, length, uncompressed_length] {
                out.extend(field.to_le_bytes());
            }
        }

        // Descriptor, pairs, levels.
        out.extend(dfd);
        out.extend(kvd);
        for (offset, level) in offsets.iter().zip(&levels).rev() {
            out.resize(*offset, 0);
            out.extend(level);
        }
        Ok(out)
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let wrong = |what: String| Error::input(path, what, "");
        let unsound = |e: reader::ParseError| wrong(format!("it is not a sound KTX2 file: {e}"));
        let header = bytes.first_chunk().ok_or(reader::ParseError::UnexpectedEnd).map_err(unsound)?;
        let header = reader::Header::from_bytes(header).map_err(unsound)?;

        // What kind of texture it is, if one that we know.
        let vk_format = header.format.map_or(0, |f| f.value());
        let Some((encoding, _)) = known().find(|(_, vk)| *vk == vk_format) else {
            let names: Vec<&str> = known().map(|(e, _)| e.name).collect();
            let help = format!("known are: {}", names.join(", "));
            return Err(Error::input(path, format!("its texels have VkFormat {vk_format}"), help));
        };
        if header.supercompression_scheme.is_some() {
            return Err(Error::input(path, "its levels are compressed", "write it without supercompression"));
        }
        let (width, height) = (header.pixel_width, header.pixel_height.max(1));
        let shape = match (header.face_count, header.pixel_depth, header.layer_count) {
            (1, 0, 0) => Shape::Table,
            (6, 0, 0) if width == height => Shape::Cube,
            _ => return Err(wrong("it is neither a plain 2-D texture nor a plain cube".into())),
        };

        // The crate's parser panics on a texel block of 256 texels (ktx2 0.5.0), so the descriptor is looked at first:
        // all our formats have one block of known size, for 1 × 1 × 1 × 1 texels, stored less one.
        let ours = data_format_descriptor(encoding);
        let theirs = bytes.get(header.index.dfd_byte_offset as usize..).unwrap_or_default();
        let is_same = |part: std::ops::Range<usize>| theirs.get(part.clone()) == Some(&ours[part]);
        if header.index.dfd_byte_length as usize != ours.len() || !is_same(4..8) || !is_same(10..12) || !is_same(16..20)
        {
            return Err(wrong("its data format descriptor does not match its VkFormat".into()));
        }
        let file = reader::Reader::new(bytes).map_err(unsound)?;

        let strings = file.key_value_data().filter_map(|(key, value)| {
            let text = std::str::from_utf8(value).ok()?;
            Some((key, text.strip_suffix('\0').unwrap_or(text)))
        });
        let default = &["r", "g", "b", "a"][..encoding.components];
        let (channels, meta) = from_pairs(path, strings, default, encoding.components)?;
        let shape = if shape == Shape::Table && is_map(&meta) { Shape::Map } else { shape };

        // Levels. A table's mips, in a file of others, are blurred values: only level 0 is data.
        let mut texture = Texture { shape, width, height, channels, levels: vec![], meta };
        let wanted = if shape == Shape::Table { 1 } else { 32 - width.max(height).leading_zeros() as usize };
        if file.levels().len() > wanted && shape != Shape::Table {
            return Err(wrong("it has more levels than its size allows".into()));
        }
        for (i, level) in file.levels().enumerate().take(wanted) {
            let (w, h) = texture.level_size(i);
            let texels = u64::from(w).checked_mul(u64::from(h)).and_then(|n| n.checked_mul(u64::from(texture.faces())));
            if texels.and_then(|n| n.checked_mul(encoding.texel_bytes() as u64)) != Some(level.data.len() as u64) {
                return Err(wrong(format!("level {i} has {} bytes, which is not its size", level.data.len())));
            }
            texture.levels.push(decode(level.data, texture.channels.len(), encoding));
        }
        Ok((texture, encoding))
    }
}

const HEADER_BYTES: usize = 80;
const LEVEL_INDEX_BYTES: usize = 24;

/// Least common multiple with 4 of a texel's size.
fn lcm4(texel_bytes: usize) -> usize {
    match texel_bytes % 4 {
        0 => texel_bytes,
        2 => texel_bytes * 2,
        _ => texel_bytes * 4,
    }
}

/// A total size and one basic descriptor block (Data Format Specification 1.3, chapter 5) with a sample a component.
fn data_format_descriptor(encoding: Encoding) -> Vec<u8> {
    const MODEL_RGBSDA: u32 = 1;
    const PRIMARIES_BT709: u32 = 1;
    const TRANSFER_LINEAR: u32 = 1;
    const VERSION: u32 = 2;
    const SIGNED: u32 = 0x40;
    const FLOAT: u32 = 0x80;
    const CHANNEL_IDS: [u32; 4] = [0, 1, 2, 15];

    let bits = 8 * (encoding.texel_bytes() / encoding.components) as u32;
    let block_bytes = 24 + 16 * encoding.components as u32;
    let vendor_and_type = 0;
    let texel_block_dimensions = 0;
    let planes_4_to_7 = 0;
    let mut words = vec![
        4 + block_bytes,
        vendor_and_type,
        VERSION | (block_bytes << 16),
        MODEL_RGBSDA | (PRIMARIES_BT709 << 8) | (TRANSFER_LINEAR << 16),
        texel_block_dimensions,
        encoding.texel_bytes() as u32,
        planes_4_to_7,
    ];
    for (i, id) in CHANNEL_IDS.iter().enumerate().take(encoding.components) {
        let sample_position = 0;
        // The bounds of a float sample are single floats, for halves too.
        let (lower, upper) = ((-1.0_f32).to_bits(), 1.0_f32.to_bits());
        words.extend([
            (i as u32 * bits) | ((bits - 1) << 16) | ((id | FLOAT | SIGNED) << 24),
            sample_position,
            lower,
            upper,
        ]);
    }
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Pairs sorted by key, each with its length, NUL after key and value, padded to 4 bytes.
fn key_value_data(texture: &Texture) -> Vec<u8> {
    let mut pairs = pairs(texture);
    pairs.push(("KTXwriter".into(), WRITER.into()));
    // A cube's orientation is `rd` by definition; stating it is left to the specification.
    if texture.shape != Shape::Cube {
        pairs.push(("KTXorientation".into(), "rd".into()));
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
