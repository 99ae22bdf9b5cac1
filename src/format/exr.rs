// SPDX-License-Identifier: MIT OR Apache-2.0
//! OpenEXR: tables, maps of the sphere and cubes as half or single floats, compressed without loss (ZIP, 16 rows a block).
//!
//! A table is a single part with the channels R, RG, RGB or RGBA. A cube has one part a mip, named `mip0`, `mip1`, …,
//! with the faces +X −X +Y −Y +Z −Z below each other: as wide as a face and six times as high. A map of
//! the sphere has one part a mip likewise, a volume one a slice, `slice0`, `slice1`, …, and an array one a layer, `layer0`,
//! `layer1`, …: OpenEXR's own layers are groups of channels, which share a size but which few readers tell apart. The file holds the texture's channels and no others: an encoding's further components are not written, and the encoding that is read
//! back is the smallest that fits. Meta is in the attributes of the first part, as UTF-8 text.

use std::io::Cursor;
use std::path::Path;

use ::exr::prelude as e;
use ::exr::prelude::{ReadChannels, ReadLayers, WritableImage};
use half::f16;

use super::{
    DEFLATE_RATIO, Encoding, Format, Repr, Storage, WRITER, check, floats, from_pairs, is_map, pairs, plausible,
};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// OpenEXR.
#[derive(Debug)]
pub struct Exr;

/// As many as slices of the deepest volume. More is not a file of ours.
const MAX_PARTS: usize = 256;
const CHANNEL_NAMES: [&str; 4] = ["R", "G", "B", "A"];

impl Format for Exr {
    fn name(&self) -> &'static str {
        "OpenEXR"
    }

    fn extension(&self) -> &'static str {
        "exr"
    }

    fn holds_mips(&self) -> bool {
        true
    }

    fn encodings(&self, _: Shape) -> Vec<Encoding> {
        floats()
    }

    fn default_encoding(&self, _: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::F16, channels)
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let encoding = storage.encoding;
        let parts = texture.shape.slices().map_or(texture.levels.len(), |slices| slices as usize);
        if parts > MAX_PARTS {
            let what =
                format!("cannot write '{}': {parts} parts are more than the {MAX_PARTS} that are read", path.display());
            return Err(Error::usage(what, "write a .ktx2 or .dds file"));
        }
        let parts: e::Layers<_> = (0..parts).map(|i| part(texture, i, encoding)).collect();
        let count = parts.len();
        let window = e::IntegerBounds::from_dimensions(parts[0].size);
        let image = e::Image { attributes: e::ImageAttributes::new(window), layer_data: parts };
        let mut out = Cursor::new(Vec::new());
        image
            .write()
            .non_parallel()
            .to_buffered(&mut out)
            .map_err(|e| Error::io("write", path, std::io::Error::other(e)))?;
        let mut out = out.into_inner();
        sort_attributes(&mut out, count);
        Ok(out)
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let unsound = |e: e::Error| Error::input(path, format!("it is not a sound OpenEXR file: {e}"), "");
        let wrong = |what: &str| Error::input(path, what, "");

        // The header's numbers first: the reader would take memory for as many texels as they claim.
        let headers = e::MetaData::read_from_buffered(bytes, false).map_err(unsound)?.headers;
        if !(1..=MAX_PARTS).contains(&headers.len()) {
            return Err(wrong("it has no part, or too many"));
        }
        let mut size = Some(0_u64);
        for header in &headers {
            if header.deep {
                return Err(wrong("it holds deep samples"));
            }
            let texels = (header.layer_size.width() as u64).checked_mul(header.layer_size.height() as u64);
            let texels = texels.and_then(|n| n.checked_mul(4 * header.channels.list.len() as u64));
            size = size.and_then(|sum| sum.checked_add(texels?));
        }
        plausible(path, size, bytes.len() as u64, DEFLATE_RATIO)?;

        let image = e::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .non_parallel()
            .pedantic()
            .from_buffered(Cursor::new(bytes))
            .map_err(unsound)?;
        from_parts(path, &image.layer_data)
    }
}

type Part = e::Layer<e::AnyChannels<e::FlatSamples>>;

/// What a part's name begins with.
fn kind(shape: Shape) -> Option<&'static str> {
    match shape {
        Shape::Table => None,
        Shape::Volume { .. } => Some("slice"),
        Shape::Array { .. } => Some("layer"),
        Shape::Map | Shape::Cube => Some("mip"),
    }
}

/// A level, a slice of a volume, or a layer of an array.
fn part(texture: &Texture, index: usize, encoding: Encoding) -> Part {
    let is_slice = texture.shape.slices().is_some();
    let (width, height) = texture.level_size(if is_slice { 0 } else { index });
    let rows = if is_slice { height as usize } else { height as usize * texture.faces() as usize };
    let size = e::Vec2(width as usize, rows);
    let n = texture.channels.len();
    let len = width as usize * rows * n;
    let texels = if is_slice { &texture.levels[0][index * len..][..len] } else { &texture.levels[index] };
    let channels = (0..n).map(|c| {
        let values = texels.iter().skip(c).step_by(n).copied();
        let limit = *Repr::F16.range().end();
        let samples = match encoding.repr {
            Repr::F32 => e::FlatSamples::F32(values.collect()),
            _ => e::FlatSamples::F16(values.map(|v| f16::from_f32(v.clamp(-limit, limit))).collect()),
        };
        e::AnyChannel::new(CHANNEL_NAMES[c], samples)
    });
    let mut attributes = e::LayerAttributes::default();
    if let Some(kind) = kind(texture.shape) {
        attributes.layer_name = Some(format!("{kind}{index}").as_str().into());
    }
    if index == 0 {
        attributes.software_name = Some(WRITER.into());
        for (key, value) in pairs(texture, encoding) {
            let value = e::AttributeValue::Text(e::Text::from_slice_unchecked(value.as_bytes()));
            attributes.other.insert(key.as_str().into(), value);
        }
    }
    let encoding = e::Encoding {
        compression: e::Compression::ZIP16,
        blocks: e::Blocks::ScanLines,
        line_order: e::LineOrder::Increasing,
    };
    e::Layer::new(size, attributes, encoding, e::AnyChannels::sort(channels.collect()))
}

/// Sorts the attributes of each part by name. The writer takes them from a hash map, in another order at each run: the
/// same texture must give the same bytes. No offset in the file changes.
fn sort_attributes(file: &mut [u8], parts: usize) {
    let mut at = 8; // behind magic number and version
    for _ in 0..parts {
        let start = at;
        let mut attributes = Vec::new();
        // Name, NUL, type, NUL, size, value; an empty name ends the header.
        while file[at] != 0 {
            let begin = at;
            for _ in 0..2 {
                at += file[at..].iter().position(|b| *b == 0).expect("the writer ends each name") + 1;
            }
            let size = file[at..].first_chunk().expect("the writer states each size");
            at += 4 + u32::from_le_bytes(*size) as usize;
            attributes.push(file[begin..at].to_vec());
        }
        attributes.sort_unstable();
        file[start..at].copy_from_slice(&attributes.concat());
        at += 1;
    }
}

fn from_parts(path: &Path, parts: &[Part]) -> Result<(Texture, Encoding)> {
    let wrong = |what: &str| Error::input(path, what, "");
    let name = |i: usize| parts[i].attributes.layer_name.as_ref().map(|name| name.to_string());
    let first = parts.first().ok_or_else(|| wrong("it has no part"))?;
    let (width, rows) = (first.size.width(), first.size.height());
    let are = |kind: &str| (0..parts.len()).all(|i| name(i) == Some(format!("{kind}{i}")));
    let (are_mips, are_layers) = (are("mip"), are("layer"));
    let are_slices = are_layers || are("slice");

    // Channels and precision, which all parts share.
    let list = &first.channel_data.list;
    let count = list.len();
    let index = |part: &Part, c: usize| part.channel_data.list.iter().position(|ch| ch.name.eq(CHANNEL_NAMES[c]));
    if !(1..=4).contains(&count) || (0..count).any(|c| index(first, c).is_none()) {
        let names: Vec<String> = list.iter().map(|c| c.name.to_string()).collect();
        let what = format!("its channels are {}", names.join(", "));
        return Err(Error::input(path, what, "known are: R, RG, RGB and RGBA"));
    }
    let repr = match list[0].sample_data {
        e::FlatSamples::F16(_) => Repr::F16,
        _ => Repr::F32,
    };
    let encoding = Encoding::fitting(repr, count).expect("float encodings hold up to four components");

    let texts: Vec<(String, &str)> = first
        .attributes
        .other
        .iter()
        .filter_map(|(key, value)| match value {
            e::AttributeValue::Text(text) => Some((key.to_string(), std::str::from_utf8(text.bytes()).ok()?)),
            _ => None,
        })
        .collect();
    // The attributes come unordered.
    let mut texts: Vec<(&str, &str)> = texts.iter().map(|(k, v)| (k.as_str(), *v)).collect();
    texts.sort_unstable();
    let (channels, meta) = from_pairs(path, texts, &["r", "g", "b", "a"][..count], count)?;
    if channels.len() != count {
        return Err(wrong("it names more or fewer channels than it has"));
    }

    let (shape, height) = match rows == 6 * width {
        _ if are_mips && is_map(&meta) => (Shape::Map, rows),
        true if are_mips => (Shape::Cube, width),
        _ if are_layers && parts.len() == 1 => (Shape::Table, rows),
        _ if are_layers => (Shape::Array { layers: parts.len() as u32 }, rows),
        _ if are_slices => (Shape::Volume { depth: parts.len() as u32 }, rows),
        _ if parts.len() == 1 => (Shape::Table, rows),
        _ => {
            return Err(wrong(
                "it has several parts that are neither layers, slices, nor the mips of a cube or of a map of the sphere",
            ));
        }
    };

    let mut texture = Texture { shape, width: width as u32, height: height as u32, channels, levels: vec![], meta };
    for (i, part) in parts.iter().enumerate() {
        let (w, h) = texture.level_size(if are_slices { 0 } else { i });
        let expected = (w as usize, if are_slices { h as usize } else { (h * texture.faces()) as usize });
        if (part.size.width(), part.size.height()) != expected {
            return Err(wrong(&format!("its part {i} has the wrong size")));
        }
        let mut level = vec![0.0; expected.0 * expected.1 * count];
        for c in 0..count {
            let channel = index(part, c).map(|k| &part.channel_data.list[k]);
            let channel = channel.filter(|ch| part.channel_data.list.len() == count && ch.sampling == e::Vec2(1, 1));
            let channel = channel.ok_or_else(|| wrong(&format!("the channels of its part {i} do not match")))?;
            let texels = level.iter_mut().skip(c).step_by(count);
            match &channel.sample_data {
                e::FlatSamples::F16(values) => texels.zip(values).for_each(|(to, v)| *to = v.to_f32()),
                e::FlatSamples::F32(values) => texels.zip(values).for_each(|(to, v)| *to = *v),
                e::FlatSamples::U32(_) => return Err(wrong("its samples are integers")),
            }
        }
        match texture.levels.first_mut() {
            Some(all) if are_slices => all.extend(level),
            _ => texture.levels.push(level),
        }
    }
    Ok((texture, encoding))
}
