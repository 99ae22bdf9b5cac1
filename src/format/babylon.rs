// SPDX-License-Identifier: MIT OR Apache-2.0
//! Babylon.js' `.env`, version 2: a cube with all its mips as RGBD pictures in PNG, and its irradiance as a polynomial.
//!
//! Eight bytes, a JSON object, a NUL, then the pictures: mip by mip, face by face in the order +X −X +Y −Y +Z −Z, rows from
//! the top (Babylon.js: `Misc/environmentTextureTools`). Babylon.js takes cubes of a power of two, with mips down to one
//! texel. It has an image of the reflection vector in left-handed world coordinates; the cube, and the polynomial beside
//! it, are looked up by that vector with the faces where every GPU has them, so a file needs no mirroring of its own.
//!
//! `lodGenerationScale` is written as 0.8, for which mip m of a cube w texels wide is read for the width alpha =
//! 2^(m/0.8)/w. Our pairs are under `brdf-baker` in the JSON object, which Babylon.js passes over.

use std::path::Path;

use ::png::{BitDepth, ColorType, Compression, Encoder};
use serde_json::{Map, Value, json};

use super::encoding::{Pictures, decode, encode};
use super::{DEFLATE_RATIO, Encoding, Format, Repr, Storage, ascii, check, from_pairs, harmonics, pairs, plausible};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Babylon.js' environments.
#[derive(Debug)]
pub struct BabylonEnv;

const MAGIC: [u8; 8] = [0x86, 0x16, 0x87, 0x96, 0xf6, 0xd6, 0x96, 0x36];
const FACES: usize = 6;
impl Format for BabylonEnv {
    fn name(&self) -> &'static str {
        "Babylon.js environment"
    }

    fn extension(&self) -> &'static str {
        "env"
    }

    fn holds_mips(&self) -> bool {
        true
    }

    fn accepts(&self, size: u32, levels: u32) -> Result<()> {
        if size.is_power_of_two() && levels == size.ilog2() + 1 {
            return Ok(());
        }
        let what = format!("Babylon.js reads no cube of {size} texels an edge with {levels} mips");
        Err(Error::usage(what, "give a power of two as --size, and no --mips: it wants them down to one texel"))
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        self.default_encoding(shape, 3).into_iter().collect()
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::Rgbd8, channels).filter(|_| shape == Shape::Cube)
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let named = |e: Error| Error::input(path, e.to_string(), e.help());
        let Some(irradiance) = harmonics::stated(&texture.meta).map_err(named)? else {
            let what = format!("cannot write '{}': its irradiance is not known", path.display());
            return Err(Error::usage(what, "bake it from an environment with `brdf-baker env`"));
        };
        let (mut pictures, mut places) = (vec![], vec![]);
        for (i, level) in texture.levels.iter().enumerate() {
            let bytes = encode(level, texture.channels.len(), Pictures::of(texture, i), storage)?;
            for face in bytes.chunks_exact(bytes.len() / FACES) {
                let start = pictures.len();
                write_png(&mut pictures, texture.level_size(i).0, face)
                    .map_err(|e| Error::io("write", path, e.into()))?;
                places.push(json!({ "length": pictures.len() - start, "position": start }));
            }
        }
        let polynomial = harmonics::POLYNOMIAL.iter().zip(harmonics::polynomial(&irradiance));
        let polynomial: Map<String, Value> = polynomial.map(|(name, rgb)| (name.to_string(), json!(rgb))).collect();
        let ours: Map<String, Value> =
            pairs(texture, storage.encoding).into_iter().map(|(key, value)| (key, value.into())).collect();
        let manifest = json!({
            "version": 2,
            "width": texture.width,
            "imageType": "image/png",
            "irradiance": polynomial,
            "specular": { "mipmaps": places, "lodGenerationScale": 0.8 },
            "brdf-baker": ours,
        });
        // Read byte by byte as Latin-1 there.
        Ok([&MAGIC[..], ascii(&manifest.to_string()).as_bytes(), &[0], &pictures].concat())
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let wrong = |what: &str| Error::input(path, format!("it is not a sound environment of Babylon.js: {what}"), "");
        let rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| wrong("its first bytes are others"))?;
        let end = rest.iter().position(|b| *b == 0).ok_or_else(|| wrong("its description does not end"))?;
        let (text, pictures) = (&rest[..end], &rest[end + 1..]);
        let manifest: Value = serde_json::from_slice(text).map_err(|e| wrong(&format!("its description: {e}")))?;
        if manifest["version"] != 2 || manifest["imageType"] != "image/png" {
            return Err(wrong("only version 2 with PNG pictures is read"));
        }
        let width = manifest["width"].as_u64().and_then(|w| u32::try_from(w).ok()).filter(|w| w.is_power_of_two());
        let width = width.ok_or_else(|| wrong("its width is no power of two"))?;
        let places = manifest["specular"]["mipmaps"].as_array().map_or(&[][..], Vec::as_slice);
        let levels = width.ilog2() as usize + 1;
        if places.len() != FACES * levels {
            return Err(wrong("it has not the pictures of all mips"));
        }
        let encoding = Encoding::fitting(Repr::Rgbd8, 3).expect("rgbd8 is in ENCODINGS");
        let empty = Map::new();
        let ours = manifest["brdf-baker"].as_object().unwrap_or(&empty);
        let ours = ours.iter().filter_map(|(key, value)| Some((key.as_str(), value.as_str()?)));
        let (channels, meta) = from_pairs(path, ours, &["r", "g", "b"], 3)?;
        let mut texture = Texture { shape: Shape::Cube, width, height: width, channels, levels: vec![], meta };
        let mut read = 0;
        for (i, faces) in places.chunks_exact(FACES).enumerate() {
            let size = texture.level_size(i).0;
            let picture = Pictures { width: size, height: size, count: 1 };
            let mut level = vec![];
            for place in faces {
                let number = |key: &str| place[key].as_u64().and_then(|n| usize::try_from(n).ok());
                let range = number("position").zip(number("length")).and_then(|(at, n)| Some(at..at.checked_add(n)?));
                let png =
                    range.and_then(|r| pictures.get(r)).ok_or_else(|| wrong("a picture lies outside the file"))?;
                // Before memory is taken: a picture that stands for several mips would be read as often.
                read += png.len();
                if read > pictures.len() {
                    return Err(wrong("its pictures overlap"));
                }
                let texels = read_png(png, size).ok_or_else(|| wrong("a picture is not what it should be"))?;
                level.extend(decode(&texels, texture.channels.len(), picture, encoding));
            }
            texture.levels.push(level);
        }
        if read != pictures.len() {
            return Err(wrong("it has bytes beside its pictures"));
        }
        Ok((texture, encoding))
    }
}

/// Appends a picture of RGBA bytes.
fn write_png(out: &mut Vec<u8>, size: u32, texels: &[u8]) -> std::result::Result<(), ::png::EncodingError> {
    let mut file = Encoder::new(out, size, size);
    file.set_color(ColorType::Rgba);
    file.set_depth(BitDepth::Eight);
    file.set_compression(Compression::High);
    let mut file = file.write_header()?;
    file.write_image_data(texels)?;
    file.finish()
}

/// `None` where it is not a picture of RGBA bytes of this size.
fn read_png(bytes: &[u8], size: u32) -> Option<Vec<u8>> {
    let mut file = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().ok()?;
    let info = file.info();
    let is_rgba = info.color_type == ColorType::Rgba && info.bit_depth == BitDepth::Eight;
    if (info.width, info.height) != (size, size) || !is_rgba {
        return None;
    }
    plausible(Path::new(""), Some(4 * u64::from(size) * u64::from(size)), bytes.len() as u64, DEFLATE_RATIO).ok()?;
    let mut texels = vec![0; file.output_buffer_size()?];
    file.next_frame(&mut texels).ok()?;
    file.finish().ok()?;
    Some(texels)
}
