// SPDX-License-Identifier: MIT OR Apache-2.0
//! KTX 1: tables and cubes with their mips, for engines that read nothing newer. Filament's tools write cubes so.
//!
//! After the KTX 1.1 specification. Rows and faces are padded to four bytes. Beside our own pairs a cube whose meta holds
//! [`super::harmonics::KEY`] gets the pair `sh`, as Filament's cmgen writes it: nine lines of red, green and blue, in
//! [`super::harmonics::prescaled`]'s form. The file's default for cubes is R11F_G11F_B10F, as there.

use std::path::Path;

use super::encoding::{Pictures, decode, encode};
use super::{Encoding, Format, Repr, Storage, WRITER, check, from_pairs, harmonics, is_map, pairs};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Khronos Texture 1.
#[derive(Debug)]
pub struct Ktx1;

/// What OpenGL calls an encoding.
struct Gl {
    encoding: &'static str,
    /// glType, its size, glFormat, glInternalFormat, glBaseInternalFormat.
    words: [u32; 5],
}

const HALF: u32 = 0x140b;
const FLOAT: u32 = 0x1406;
const BYTE: u32 = 0x1401;
const SHORT: u32 = 0x1403;
const RED: u32 = 0x1903;
const RG: u32 = 0x8227;
const RGB: u32 = 0x1907;
const RGBA: u32 = 0x1908;

/// From the OpenGL 4.6 specification's registry of names. Compressed formats have neither type nor format.
const GL_FORMATS: &[Gl] = &[
    Gl { encoding: "r16f", words: [HALF, 2, RED, 0x822d, RED] },
    Gl { encoding: "rg16f", words: [HALF, 2, RG, 0x822f, RG] },
    Gl { encoding: "rgba16f", words: [HALF, 2, RGBA, 0x881a, RGBA] },
    Gl { encoding: "r32f", words: [FLOAT, 4, RED, 0x822e, RED] },
    Gl { encoding: "rg32f", words: [FLOAT, 4, RG, 0x8230, RG] },
    Gl { encoding: "rgba32f", words: [FLOAT, 4, RGBA, 0x8814, RGBA] },
    Gl { encoding: "rgba8unorm", words: [BYTE, 1, RGBA, 0x8058, RGBA] },
    Gl { encoding: "rg16unorm", words: [SHORT, 2, RG, 0x822c, RG] },
    Gl { encoding: "rgba16unorm", words: [SHORT, 2, RGBA, 0x805b, RGBA] },
    // The type should be UNSIGNED_INT_10F_11F_11F_REV, 0x8c3b. Filament's tools write the sized format's name there, and its
    // reader (libs/ktxreader, Ktx1Reader.cpp, toPixelDataType) knows no other.
    Gl { encoding: "b10g11r11", words: [0x8c3a, 4, RGB, 0x8c3a, RGB] },
    Gl { encoding: "rgb9e5", words: [0x8c3e, 4, RGB, 0x8c3d, RGB] },
    Gl { encoding: "bc6h", words: [0, 1, 0, 0x8e8f, RGB] },
];

fn known() -> impl Iterator<Item = (Encoding, &'static Gl)> {
    GL_FORMATS.iter().map(|gl| (Encoding::parse(gl.encoding).expect("each name is in ENCODINGS"), gl))
}

const IDENTIFIER: [u8; 12] = [0xab, b'K', b'T', b'X', b' ', b'1', b'1', 0xbb, b'\r', b'\n', 0x1a, b'\n'];
/// What a reader of the same byte order finds there.
const ENDIANNESS: u32 = 0x0403_0201;
const HEADER_BYTES: usize = 64;
/// The key of Filament's irradiance.
const SH: &str = "sh";

impl Format for Ktx1 {
    fn name(&self) -> &'static str {
        "KTX 1"
    }

    fn extension(&self) -> &'static str {
        "ktx"
    }

    fn holds_mips(&self) -> bool {
        true
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        let flat = shape.slices().is_none();
        known().map(|(encoding, _)| encoding).filter(|e| flat && e.holds(shape)).collect()
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        let packed = Encoding::fitting(Repr::B10g11r11, channels).filter(|_| shape == Shape::Cube);
        packed.or(Encoding::fitting(Repr::F16, channels)).filter(|_| shape.slices().is_none())
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let encoding = storage.encoding;
        let gl = known().find(|(e, _)| *e == encoding).map(|(_, gl)| gl).expect("check() refuses other encodings");
        let stated = harmonics::stated(&texture.meta).map_err(|e| Error::input(path, e.to_string(), e.help()))?;
        let kvd = key_value_data(texture, encoding, stated.as_ref());

        let mut out = IDENTIFIER.to_vec();
        let (pixel_depth, array_elements) = (0, 0);
        let mut put = |word: u32| out.extend(word.to_le_bytes());
        put(ENDIANNESS);
        gl.words.iter().for_each(|word| put(*word));
        let sizes = [texture.width, texture.height, pixel_depth, array_elements, texture.faces()];
        sizes.iter().for_each(|word| put(*word));
        put(texture.levels.len() as u32);
        put(kvd.len() as u32);
        out.extend(kvd);
        for (i, level) in texture.levels.iter().enumerate() {
            let pictures = Pictures::of(texture, i);
            let bytes = encode(level, texture.channels.len(), pictures, storage)?;
            let row_bytes = row_bytes(encoding, pictures);
            let padded: Vec<u8> = bytes.chunks_exact(row_bytes).flat_map(|row| padded(row.to_vec())).collect();
            // Of a cube, the size of one face.
            out.extend((padded.len() as u32 / texture.faces()).to_le_bytes());
            out.extend(padded);
        }
        Ok(out)
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let unsound = |what: &str| Error::input(path, format!("it is not a sound KTX file: {what}"), "");
        let cut = || unsound("it ends too early");
        if !bytes.starts_with(&IDENTIFIER) {
            return Err(unsound("its first bytes are others"));
        }
        let header: Vec<u32> =
            bytes.get(12..HEADER_BYTES).ok_or_else(cut)?.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect();
        if header[0] != ENDIANNESS {
            return Err(unsound("its bytes are in the other order"));
        }
        // As the specification says it, too.
        let gl_type = if header[1] == 0x8c3b { 0x8c3a } else { header[1] };
        let Some((encoding, _)) = known().find(|(_, gl)| gl.words[0] == gl_type && gl.words[3] == header[4]) else {
            let names: Vec<&str> = known().map(|(e, _)| e.name).collect();
            let what = format!("its glInternalFormat is {:#06x}, its glType {:#06x}", header[4], header[1]);
            return Err(Error::input(path, what, format!("known are: {}", names.join(", "))));
        };
        let (width, height) = (header[6], header[7].max(1));
        let shape = match (header[10], header[8] <= 1, header[9]) {
            (1, true, 0) => Shape::Table,
            (6, true, 0) if width == height => Shape::Cube,
            _ => return Err(unsound("it is neither a plain 2-D texture nor a plain cube")),
        };
        let levels = header[11].max(1);
        if width == 0 || levels > 32 - width.max(height).leading_zeros() {
            return Err(unsound("it has no texels, or more levels than its size allows"));
        }

        // Pairs, each with its length and padding.
        let end = HEADER_BYTES.checked_add(header[12] as usize).ok_or_else(cut)?;
        let mut rest = bytes.get(HEADER_BYTES..end).ok_or_else(cut)?;
        let mut strings = vec![];
        while let Some((length, tail)) = rest.split_first_chunk() {
            let length = u32::from_le_bytes(*length) as usize;
            let pair = tail.get(..length).ok_or_else(cut)?;
            rest = tail.get(length.next_multiple_of(4)..).ok_or_else(cut)?;
            let mut parts = pair.splitn(2, |b| *b == 0).map(std::str::from_utf8);
            if let (Some(Ok(key)), Some(Ok(value))) = (parts.next(), parts.next()) {
                strings.push((key, value.strip_suffix('\0').unwrap_or(value)));
            }
        }
        let default = &["r", "g", "b", "a"][..encoding.components];
        let (channels, meta) = from_pairs(path, strings, default, encoding.components)?;
        let shape = if shape == Shape::Table && is_map(&meta) { Shape::Map } else { shape };

        // Levels. A table's mips, in a file of others, are blurred values: only level 0 is data.
        let mut texture = Texture { shape, width, height, channels, levels: vec![], meta };
        let mut at = end;
        for i in 0..if shape == Shape::Table { 1 } else { levels as usize } {
            let pictures = Pictures::of(&texture, i);
            let size = bytes.get(at..).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b)).ok_or_else(cut)?;
            let rows = u64::from(pictures.height.div_ceil(encoding.unit_side()));
            let row = row_bytes(encoding, pictures);
            let stored_row = row.next_multiple_of(4);
            if rows.checked_mul(stored_row as u64) != Some(size.into()) {
                return Err(unsound(&format!("level {i} has {size} bytes a face, which is not its size")));
            }
            let from = at + 4;
            let to = (size as usize).checked_mul(texture.faces() as usize).and_then(|n| n.checked_add(from));
            let stored = to.and_then(|to| bytes.get(from..to)).ok_or_else(cut)?;
            let plain: Vec<u8> = stored.chunks_exact(stored_row).flat_map(|r| &r[..row]).copied().collect();
            texture.levels.push(decode(&plain, texture.channels.len(), pictures, encoding));
            at = from + stored.len();
        }
        Ok((texture, encoding))
    }
}

/// Bytes of a row of texels or of blocks.
fn row_bytes(encoding: Encoding, pictures: Pictures) -> usize {
    pictures.width.div_ceil(encoding.unit_side()) as usize * encoding.unit_bytes()
}

fn padded(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

/// Pairs, each with its length, NUL after key and value, padded to 4 bytes.
fn key_value_data(texture: &Texture, encoding: Encoding, irradiance: Option<&harmonics::Irradiance>) -> Vec<u8> {
    let mut pairs = pairs(texture, encoding);
    pairs.push(("KTXwriter".into(), WRITER.into()));
    if texture.shape != Shape::Cube {
        // Rows from the top.
        pairs.push(("KTXorientation".into(), "S=r,T=d".into()));
    }
    if let Some(irradiance) = irradiance {
        let line = |[r, g, b]: [f64; 3]| format!("{r:.8} {g:.8} {b:.8}\n");
        pairs.push((SH.into(), harmonics::prescaled(irradiance).map(line).concat()));
    }
    pairs.sort();
    let mut out = Vec::new();
    for (key, value) in pairs {
        out.extend((key.len() as u32 + 1 + value.len() as u32 + 1).to_le_bytes());
        out.extend(padded(key.bytes().chain([0]).chain(value.bytes()).chain([0]).collect()));
    }
    out
}
