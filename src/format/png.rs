// SPDX-License-Identifier: MIT OR Apache-2.0
//! PNG: tables as 8- or 16-bit integers over [0, 1], for engines and tools that read nothing else; tables and maps of the
//! sphere of one level as bytes with a formula (`rgbd8`, `rgbm8`, `rgbp8`).
//!
//! The values are linear and the file says so (gAMA 1.0, no sRGB chunk): a reader that honours neither still gets the
//! stored numbers. One channel is grey; two and three are RGB, blue 0 where it is not used; four, and formulas, are RGBA
//! with an alpha that must not be multiplied in.

use std::io::Cursor;
use std::path::Path;

use ::png::{BitDepth, ColorType, Decoder, Encoder, ScaledFloat};

use super::encoding::{Pictures, decode, encode};
use super::{
    DEFLATE_RATIO, Encoding, Format, Repr, Storage, WRITER, check, from_pairs, is_map, pairs, plausible,
    stated_encoding,
};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Portable Network Graphics.
#[derive(Debug)]
pub struct Png;

impl Format for Png {
    fn name(&self) -> &'static str {
        "PNG"
    }

    fn extension(&self) -> &'static str {
        "png"
    }

    fn holds_mips(&self) -> bool {
        false
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        let of = |names: &[&str]| -> Vec<Encoding> {
            names.iter().map(|name| Encoding::parse(name).expect("each name is in ENCODINGS")).collect()
        };
        match shape {
            Shape::Table => of(&[
                "r8unorm",
                "rgb8unorm",
                "rgba8unorm",
                "r16unorm",
                "rgb16unorm",
                "rgba16unorm",
                "rgbd8",
                "rgbm8",
                "rgbp8",
            ]),
            Shape::Map => of(&["rgbd8", "rgbm8", "rgbp8"]),
            Shape::Cube | Shape::Volume { .. } | Shape::Array { .. } => vec![],
        }
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        match shape {
            Shape::Table => {
                self.encodings(shape).into_iter().find(|e| e.repr == Repr::Unorm16 && e.components >= channels)
            }
            Shape::Map => Encoding::fitting(Repr::Rgbd8, channels),
            Shape::Cube | Shape::Volume { .. } | Shape::Array { .. } => None,
        }
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let mut out = Vec::new();
        let texels = encode(&texture.levels[0], texture.channels.len(), Pictures::of(texture, 0), storage)?;
        write(&mut out, texture, storage.encoding, texels).map_err(|e| Error::io("write", path, e.into()))?;
        Ok(out)
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let unsound = |e: ::png::DecodingError| Error::input(path, format!("it is not a sound PNG file: {e}"), "");
        let mut file = Decoder::new(Cursor::new(bytes)).read_info().map_err(unsound)?;
        let info = file.info();
        let (width, height) = (info.width, info.height);
        let container = match (info.color_type, info.bit_depth) {
            (ColorType::Grayscale, BitDepth::Eight) => "r8unorm",
            (ColorType::Rgb, BitDepth::Eight) => "rgb8unorm",
            (ColorType::Rgba, BitDepth::Eight) => "rgba8unorm",
            (ColorType::Grayscale, BitDepth::Sixteen) => "r16unorm",
            (ColorType::Rgb, BitDepth::Sixteen) => "rgb16unorm",
            (ColorType::Rgba, BitDepth::Sixteen) => "rgba16unorm",
            (color, depth) => {
                let what = format!("its texels are {color:?} of {} bits", depth as u8);
                return Err(Error::input(
                    path,
                    what,
                    "save it as grey, RGB or RGBA with 8 or 16 bits, without a palette",
                ));
            }
        };
        let container = Encoding::parse(container).expect("each name is in ENCODINGS");

        // Texels, and what follows them: the checks of the last chunks catch a file that was cut short.
        let pictures = Pictures { width, height, count: 1 };
        plausible(path, container.level_bytes(pictures), bytes.len() as u64, DEFLATE_RATIO)?;
        let mut texels = vec![0; file.output_buffer_size().unwrap_or(0)];
        file.next_frame(&mut texels).map_err(unsound)?;
        file.finish().map_err(unsound)?;
        swap_16(&mut texels, container);

        let info = file.info();
        let mut texts: Vec<(String, String)> =
            info.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone())).collect();
        for text in &info.utf8_text {
            texts.push((text.keyword.clone(), text.get_text().map_err(unsound)?));
        }
        let texts = || texts.iter().map(|(k, v)| (k.as_str(), v.as_str()));
        let encoding = stated_encoding(path, container, texts())?;
        let default = &["r", "g", "b", "a"][..encoding.components];
        let (channels, meta) = from_pairs(path, texts(), default, encoding.components)?;
        let levels = vec![decode(&texels, channels.len(), pictures, encoding)];
        let shape = if is_map(&meta) { Shape::Map } else { Shape::Table };
        Ok((Texture { shape, width, height, channels, levels, meta }, encoding))
    }
}

fn write(
    out: &mut Vec<u8>,
    texture: &Texture,
    encoding: Encoding,
    mut texels: Vec<u8>,
) -> std::result::Result<(), ::png::EncodingError> {
    let mut file = Encoder::new(out, texture.width, texture.height);
    file.set_color(match (encoding.formula(), encoding.components) {
        (Some(_), _) | (None, 4) => ColorType::Rgba,
        (None, 1) => ColorType::Grayscale,
        (None, _) => ColorType::Rgb,
    });
    file.set_depth(if encoding.repr == Repr::Unorm16 { BitDepth::Sixteen } else { BitDepth::Eight });
    file.set_source_gamma(ScaledFloat::new(1.0));
    file.add_text_chunk("Software".into(), WRITER.into())?;
    for (key, value) in pairs(texture, encoding) {
        // tEXt holds Latin-1, iTXt UTF-8; the first is more widely shown.
        if value.is_ascii() { file.add_text_chunk(key, value)? } else { file.add_itxt_chunk(key, value)? }
    }
    let mut file = file.write_header()?;
    swap_16(&mut texels, encoding);
    file.write_image_data(&texels)?;
    file.finish()
}

/// PNG stores 16 bits with the high byte first.
fn swap_16(texels: &mut [u8], encoding: Encoding) {
    if encoding.repr == Repr::Unorm16 {
        texels.as_chunks_mut::<2>().0.iter_mut().for_each(|pair| pair.swap(0, 1));
    }
}
/// What is wrong with a picture's palette, if anything is. The decoder takes for granted that the colours in it are whole, and
/// panics otherwise (png 0.18.1).
pub fn torn_palette(info: &::png::Info<'_>) -> Option<String> {
    let bytes = info.palette.as_ref().map_or(0, |palette| palette.len());
    (!bytes.is_multiple_of(3)).then(|| format!("its palette of {bytes} bytes ends in the middle of a colour"))
}
