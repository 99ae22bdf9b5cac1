// SPDX-License-Identifier: MIT OR Apache-2.0
//! Radiance HDR: tables and pictures of one level as RGB with 8-bit mantissas and one exponent a texel. About two decimal digits, no sign.
//!
//! The file is written with the `image` crate's encoder, fed with values that are already rounded to the nearest RGBE
//! (it would truncate). Meta goes into the header as comment lines, `# brdf-baker.key=value`. Reading is done here:
//! the format is small, and a damaged file must end in an error.

use std::path::Path;

use image::Rgb;
use image::codecs::hdr::HdrEncoder;

use super::encoding::{Pictures, decode, encode};
use super::{Encoding, Format, Repr, Storage, WRITER, check, from_pairs, is_map, pairs, plausible};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Radiance HDR (RGBE).
#[derive(Debug)]
pub struct Hdr;

/// A run of 127 texels in 8 bytes; the older scheme, which packs more, is not read.
const BEST_RATIO: u64 = 16;

impl Format for Hdr {
    fn name(&self) -> &'static str {
        "Radiance HDR"
    }

    fn extension(&self) -> &'static str {
        "hdr"
    }

    fn holds_mips(&self) -> bool {
        false
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        self.default_encoding(shape, 3).into_iter().collect()
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::Rgbe8, channels).filter(|_| matches!(shape, Shape::Table | Shape::Map))
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let (encoding, pictures) = (storage.encoding, Pictures::of(texture, 0));
        let bytes = encode(&texture.levels[0], texture.channels.len(), pictures, storage)?;
        let rounded = decode(&bytes, 3, pictures, encoding);
        let rgb: Vec<Rgb<f32>> = rounded.as_chunks().0.iter().map(|texel| Rgb(*texel)).collect();
        let mut plain = Vec::new();
        HdrEncoder::new(&mut plain)
            .encode(&rgb, texture.width as usize, texture.height as usize)
            .map_err(|e| Error::io("write", path, std::io::Error::other(e)))?;

        // The comments come right behind the first line, the signature. Godot warns of any other line of a header.
        let first_line = plain.iter().position(|b| *b == b'\n').map_or(0, |i| i + 1);
        let (signature, rest) = plain.split_at(first_line);
        let mut comments = format!("# {WRITER}\n");
        for (key, value) in pairs(texture, encoding) {
            comments += &format!("# {key}={value}\n");
        }
        Ok([signature, comments.as_bytes(), rest].concat())
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let encoding = Encoding::fitting(Repr::Rgbe8, 3).expect("rgbe8 is in ENCODINGS");
        let wrong = |what: &str| Error::input(path, format!("it is not a sound Radiance HDR file: {what}"), "");
        let mut rest = bytes;
        let mut line = || {
            let end = rest.iter().position(|b| *b == b'\n').ok_or_else(|| wrong("its header is cut short"))?;
            let line = std::str::from_utf8(&rest[..end]).map_err(|_| wrong("its header is not text"))?;
            rest = &rest[end + 1..];
            Ok::<&str, Error>(line)
        };

        // Header: signature, lines up to an empty one, size.
        if !matches!(line()?, "#?RADIANCE" | "#?RGBE") {
            return Err(wrong("it lacks the signature"));
        }
        let mut comments = Vec::new();
        loop {
            match line()? {
                "" => break,
                "FORMAT=32-bit_rle_xyze" => return Err(wrong("its texels are CIE XYZ, not RGB")),
                text => comments.extend(text.strip_prefix("# ").and_then(|text| text.split_once('='))),
            }
        }
        let size = line()?;
        let (width, height) = match size.split(' ').collect::<Vec<_>>()[..] {
            ["-Y", height, "+X", width] => (width.parse::<u32>().ok(), height.parse::<u32>().ok()),
            _ => return Err(wrong("its rows do not run from left to right and from the top")),
        };
        let (Some(width @ 1..), Some(height @ 1..)) = (width, height) else {
            return Err(wrong("its size is not a number"));
        };
        plausible(path, u64::from(width).checked_mul(u64::from(height)), bytes.len() as u64, BEST_RATIO)?;
        let (channels, meta) = from_pairs(path, comments, &["r", "g", "b"], 3)?;

        let texels = scanlines(rest, width as usize, height as usize).ok_or_else(|| wrong("its texels are damaged"))?;
        let levels =
            vec![decode(texels.as_flattened(), channels.len(), Pictures { width, height, count: 1 }, encoding)];
        let shape = if is_map(&meta) { Shape::Map } else { Shape::Table };
        Ok((Texture { shape, width, height, channels, levels, meta }, encoding))
    }
}

/// RGBE texels, row by row: runs of each component, or plain texels. `None` when the bytes are not what they should be.
fn scanlines(mut bytes: &[u8], width: usize, height: usize) -> Option<Vec<[u8; 4]>> {
    let mut texels = Vec::with_capacity(width * height);
    for _ in 0..height {
        let first = *bytes.first_chunk::<4>()?;
        // Two bytes of 2 cannot open a plain texel, whose largest mantissa is at least 128.
        if first[0] == 2 && first[1] == 2 && first[2] < 128 {
            if usize::from(u16::from_be_bytes([first[2], first[3]])) != width {
                return None;
            }
            bytes = &bytes[4..];
            let start = texels.len();
            texels.resize(start + width, [0; 4]);
            for component in 0..4 {
                let mut row = texels[start..].iter_mut().map(|texel| &mut texel[component]);
                while row.len() > 0 {
                    let (&count, tail) = bytes.split_first()?;
                    let run = count > 128;
                    let count = usize::from(if run { count - 128 } else { count });
                    let source = tail.get(..if run { 1 } else { count })?;
                    bytes = &tail[source.len()..];
                    if count == 0 || count > row.len() {
                        return None;
                    }
                    for (i, to) in row.by_ref().take(count).enumerate() {
                        *to = source[if run { 0 } else { i }];
                    }
                }
            }
        } else {
            let (row, tail) = bytes.split_at_checked(4 * width)?;
            let row = row.as_chunks::<4>().0;
            // A texel of ones is a run in the scheme of 1991: what follows would be read as texels.
            if row.iter().any(|texel| texel[..3] == [1, 1, 1]) {
                return None;
            }
            texels.extend(row);
            bytes = tail;
        }
    }
    Some(texels)
}
