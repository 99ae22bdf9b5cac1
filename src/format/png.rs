//! PNG: tables as 8- or 16-bit integers over [0, 1], for engines and tools that read nothing else.
//!
//! The values are linear and the file says so (gAMA 1.0, no sRGB chunk): a reader that honours neither still gets the
//! stored numbers. One channel is grey; two and three are RGB, blue 0 where it is not used.

use std::io::Cursor;
use std::path::Path;

use ::png::{BitDepth, ColorType, Decoder, Encoder, ScaledFloat};

use super::encoding::{decode, encode};
use super::{Encoding, Format, Repr, WRITER, check, from_pairs, pairs, plausible};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Portable Network Graphics.
#[derive(Debug)]
pub struct Png;

/// Deflate's best: a run of 258 bytes in two bits.
const BEST_RATIO: u64 = 1032;

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
        let names: &[&str] = match shape {
            Shape::Table => &["r8unorm", "rgb8unorm", "r16unorm", "rgb16unorm"],
            Shape::Map | Shape::Cube => &[],
        };
        names.iter().map(|name| Encoding::parse(name).expect("each name is in ENCODINGS")).collect()
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        if shape == Shape::Table { Encoding::fitting(Repr::Unorm16, channels) } else { None }
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, encoding: Encoding) -> Result<Vec<u8>> {
        check(path, self, texture, encoding)?;
        let mut out = Vec::new();
        write(&mut out, texture, encoding, encode(&texture.levels[0], texture.channels.len(), encoding)?)
            .map_err(|e| Error::io("write", path, e.into()))?;
        Ok(out)
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let unsound = |e: ::png::DecodingError| Error::input(path, format!("it is not a sound PNG file: {e}"), "");
        let mut file = Decoder::new(Cursor::new(bytes)).read_info().map_err(unsound)?;
        let info = file.info();
        let (width, height) = (info.width, info.height);
        let encoding = match (info.color_type, info.bit_depth) {
            (ColorType::Grayscale, BitDepth::Eight) => "r8unorm",
            (ColorType::Rgb, BitDepth::Eight) => "rgb8unorm",
            (ColorType::Grayscale, BitDepth::Sixteen) => "r16unorm",
            (ColorType::Rgb, BitDepth::Sixteen) => "rgb16unorm",
            (color, depth) => {
                let what = format!("its texels are {color:?} of {} bits", depth as u8);
                return Err(Error::input(path, what, "save it as grey or RGB with 8 or 16 bits, without a palette"));
            }
        };
        let encoding = Encoding::parse(encoding).expect("each name is in ENCODINGS");

        // Texels, and what follows them: the checks of the last chunks catch a file that was cut short.
        let size = u64::from(width).checked_mul(u64::from(height));
        let size = size.and_then(|n| n.checked_mul(encoding.texel_bytes() as u64));
        plausible(path, size, bytes.len(), BEST_RATIO)?;
        let mut texels = vec![0; file.output_buffer_size().unwrap_or(0)];
        file.next_frame(&mut texels).map_err(unsound)?;
        file.finish().map_err(unsound)?;
        swap_16(&mut texels, encoding);

        let info = file.info();
        let mut texts: Vec<(String, String)> =
            info.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone())).collect();
        for text in &info.utf8_text {
            texts.push((text.keyword.clone(), text.get_text().map_err(unsound)?));
        }
        let texts = texts.iter().map(|(k, v)| (k.as_str(), v.as_str()));
        let (channels, meta) = from_pairs(path, texts, &["r", "g", "b"][..encoding.components], encoding.components)?;
        let levels = vec![decode(&texels, channels.len(), encoding)];
        Ok((Texture { shape: Shape::Table, width, height, channels, levels, meta }, encoding))
    }
}

fn write(
    out: &mut Vec<u8>,
    texture: &Texture,
    encoding: Encoding,
    mut texels: Vec<u8>,
) -> std::result::Result<(), ::png::EncodingError> {
    let mut file = Encoder::new(out, texture.width, texture.height);
    file.set_color(if encoding.components == 1 { ColorType::Grayscale } else { ColorType::Rgb });
    file.set_depth(if encoding.repr == Repr::Unorm8 { BitDepth::Eight } else { BitDepth::Sixteen });
    file.set_source_gamma(ScaledFloat::new(1.0));
    file.add_text_chunk("Software".into(), WRITER.into())?;
    for (key, value) in pairs(texture) {
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
