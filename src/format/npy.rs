// SPDX-License-Identifier: MIT OR Apache-2.0
//! NumPy's `.npy`: one level as an array of halves or singles, rows × columns × channels, of a cube faces
//! first, of a volume slices first, of an array layers first. A volume of six square slices has a leading axis of length 1,
//! or it would read back as a cube.
//!
//! The format has no place for metadata: what was baked, its axes and its certificate are not in the file, and an array reads
//! back as a volume.

use std::io::Cursor;
use std::path::Path;

use half::f16;
use npyz::{NpyFile, Order, WriteOptions, WriterBuilder};

use super::{Encoding, Format, Pictures, Repr, Storage, check};
use crate::error::{Error, Result};
use crate::texture::{Meta, Shape, Texture};

/// What tells a cube's axis of faces.
const CUBE_FACES: u32 = 6;

/// NumPy's array format.
#[derive(Debug)]
pub struct Npy;

impl Format for Npy {
    fn name(&self) -> &'static str {
        "NumPy"
    }

    fn extension(&self) -> &'static str {
        "npy"
    }

    fn holds_mips(&self) -> bool {
        false
    }

    fn holds_meta(&self) -> bool {
        false
    }

    fn encodings(&self, _: Shape) -> Vec<Encoding> {
        super::floats()
    }

    fn default_encoding(&self, _: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::F32, channels)
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let values = texture.levels[0].iter().copied();
        let [width, height, channels] = [texture.width, texture.height, texture.channels.len() as u32].map(u64::from);
        let shape = match texture.shape {
            Shape::Cube => vec![6, height, width, channels],
            Shape::Volume { depth: slices } | Shape::Array { layers: slices } => match slices {
                CUBE_FACES if width == height => vec![1, 6, height, width, channels],
                _ => vec![slices.into(), height, width, channels],
            },
            Shape::Table | Shape::Map => vec![height, width, channels],
        };
        let mut out = vec![];
        let written = match storage.encoding.repr {
            Repr::F16 => {
                let held = Repr::F16.range();
                let halves = values.map(|v| f16::from_f32(v.clamp(*held.start(), *held.end())));
                write(&mut out, &shape, halves)
            }
            _ => write(&mut out, &shape, values),
        };
        written.map_err(|e| Error::io("write", path, e))?;
        Ok(out)
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let unsound = |e: std::io::Error| Error::input(path, format!("it is not a sound .npy file: {e}"), "");
        let wrong = |what: String| Error::input(path, what, "save it as float16 or float32, rows x columns x channels");
        check_header(bytes).map_err(|what| Error::input(path, format!("it is not a sound .npy file: {what}"), ""))?;
        let file = NpyFile::new(Cursor::new(bytes)).map_err(unsound)?;
        let (order, sizes, dtype) = (file.order(), file.shape().to_vec(), file.dtype().descr());
        if order != Order::C {
            return Err(wrong("its columns lie together, not its rows".into()));
        }
        let small = |n: u64| u32::try_from(n).ok().filter(|n| *n > 0);
        let found = match sizes[..] {
            [height, width] => Some((1, height, width, 1)),
            [height, width, channels] => Some((1, height, width, channels)),
            [count, height, width, channels] | [1, count, height, width, channels] => {
                small(count).map(|count| (count, height, width, channels))
            }
            _ => None,
        };
        let Some((count, Some(height), Some(width), channels @ 1..=4)) =
            found.map(|(f, h, w, c)| (f, small(h), small(w), c))
        else {
            return Err(wrong(format!("its shape is {sizes:?}")));
        };
        let (repr, bytes_each) = match dtype.as_str() {
            "'<f2'" => (Repr::F16, 2),
            "'<f4'" => (Repr::F32, 4),
            other => return Err(wrong(format!("its numbers are {other}"))),
        };
        let cursor = file.into_inner();
        let data = &bytes[(cursor.position() as usize).min(bytes.len())..];
        let pictures = Pictures { width, height, count };
        let channels = channels as usize;
        let plain = Encoding { name: "", components: channels, repr };
        debug_assert_eq!(plain.unit_bytes(), channels * bytes_each);
        if plain.level_bytes(pictures) != Some(data.len() as u64) {
            return Err(wrong(format!("it has {} bytes of numbers, which is not its size", data.len())));
        }
        let levels = vec![super::decode(data, channels, pictures, plain)];
        let names = ["r", "g", "b", "a"][..channels].iter().map(|c| c.to_string()).collect();
        let shape = match sizes.len() {
            4 if count == CUBE_FACES && width == height => Shape::Cube,
            4 | 5 => Shape::Volume { depth: count },
            _ => Shape::Table,
        };
        let encoding = Encoding::fitting(repr, channels).expect("float encodings hold up to four components");
        Ok((Texture { shape, width, height, channels: names, levels, meta: Meta::default() }, encoding))
    }
}

/// The longest description of an array that is read. Plain arrays have 118 bytes.
const MAX_HEADER_BYTES: usize = 4096;

/// Refuses a description that is longer than the file, nested deeper than an array's, or of more numbers than can be counted:
/// the crate would take the memory, go as deep as the brackets do, and multiply beyond 64 bits.
fn check_header(bytes: &[u8]) -> Result<(), &'static str> {
    let cut = "it ends too early";
    let (start, length) = match bytes.get(6).ok_or(cut)? {
        1 => (10, bytes.get(8..10).ok_or(cut)?.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b))),
        _ => (12, bytes.get(8..12).ok_or(cut)?.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b))),
    };
    if length > MAX_HEADER_BYTES {
        return Err("its description is too long for an array of numbers");
    }
    let header = bytes.get(start..start + length).ok_or(cut)?;
    // The dictionary and the tuple of sizes.
    if header.iter().filter(|b| b"([{".contains(b)).count() > 2 {
        return Err("its description is none of an array of numbers");
    }
    let sizes = header.split(|b| b"([".contains(b)).nth(1).and_then(|rest| rest.split(|b| b")]".contains(b)).next());
    let sizes = std::str::from_utf8(sizes.unwrap_or_default()).map_err(|_| "its description is not text")?;
    let mut count = 1_u64;
    for size in sizes.split(',').map(str::trim).filter(|size| !size.is_empty()) {
        let size: u64 = size.parse().map_err(|_| "its sizes are no numbers of 64 bits")?;
        count = count.checked_mul(size.max(1)).ok_or("its sizes are too large")?;
    }
    Ok(())
}

/// An array of little-endian numbers, the last axis fastest.
fn write<T: npyz::AutoSerialize>(
    out: &mut Vec<u8>,
    shape: &[u64],
    values: impl Iterator<Item = T>,
) -> std::io::Result<()> {
    let mut writer = WriteOptions::new().default_dtype().shape(shape).writer(out).begin_nd()?;
    writer.extend(values)?;
    writer.finish()
}
