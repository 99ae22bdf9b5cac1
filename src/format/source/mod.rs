// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables as source code: an array with its sizes, everything that the meta says as comments, and, for single floats, a
//! function that looks a value up between texels. Halves are written as their bits, to be handed to a GPU, and integers as they are stored.
//!
//! The array holds the texture's channels and no others, slices or layers in order, rows from the top, texels from the left;
//! channel by channel where the meta names `planes`. Several tables, and one in planes, come without the function. Its name is
//! the file's.
//! What this tool wrote it reads again: numbers and facts only, not code that was changed around them.

mod language;

use std::path::Path;

use half::f16;

pub use self::language::{C, C_HEADER, JAVASCRIPT, Language, PYTHON, RUST, TYPESCRIPT};
use super::{
    ENCODINGS, Encoding, Format, PLANES, PREFIX, Repr, Storage, TEXELS, WRITER, check, floats, from_pairs, is_map,
    pairs,
};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// What the last line says: a file without it was cut short.
const END: &str = "the end";
/// Lines are about as long as people's.
const LINE: usize = 100;
/// What numbers are indented by, and nothing else that begins with a digit.
const INDENT: &str = "    ";

/// What stands behind the number of layers of an array, where a volume has nothing.
const LAYERS: &str = "layers";

/// What tables that follow each other are called.
#[derive(Clone, Copy)]
struct Stack {
    /// The end of the constant that has their number.
    constant: &'static str,
    /// As a word.
    word: &'static str,
}

const VOLUME: Stack = Stack { constant: "DEPTH", word: "slices" };
const ARRAY: Stack = Stack { constant: "LAYERS", word: "layers" };

/// What the code of a language is made of.
struct Facts {
    /// In capitals, and in small letters.
    name: String,
    small_name: String,
    width: u32,
    height: u32,
    /// Slices of a volume, or layers of an array, with what they are called.
    slices: Option<(u32, Stack)>,
    channels: usize,
    /// A plane for each channel, one after the other.
    planes: bool,
    /// What numbers are that are not floats: 16-bit words of this.
    words: Option<&'static str>,
    /// Values lie at the ends of the axes, not in the middle of texels.
    edges: bool,
    /// What the axes are, for people.
    axes: String,
}

impl Facts {
    fn len(&self) -> usize {
        self.width as usize * self.height as usize * self.slices.map_or(1, |(n, _)| n as usize) * self.channels
    }

    /// Is there a function that looks values up?
    fn samples(&self) -> bool {
        self.words.is_none() && self.slices.is_none() && !self.planes
    }
}

impl Format for Language {
    fn name(&self) -> &'static str {
        self.name
    }

    fn extension(&self) -> &'static str {
        self.extension
    }

    fn holds_mips(&self) -> bool {
        false
    }

    fn holds_planes(&self) -> bool {
        true
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        if shape == Shape::Cube { vec![] } else { numbers() }
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::F32, channels).filter(|_| shape != Shape::Cube)
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let encoding = storage.encoding;
        let facts = facts(path, texture, encoding);
        let (before, after) = (self.code)(&facts);

        let comment = self.comment;
        let mut text = format!("{comment} Written by {WRITER}. What it says of itself, as JSON strings:\n");
        let several = match texture.shape {
            Shape::Volume { depth } => format!(" {depth}"),
            Shape::Array { layers } => format!(" {layers} {LAYERS}"),
            Shape::Table | Shape::Map | Shape::Cube => String::new(),
        };
        let sizes = format!("{} {}{several} {}", texture.width, texture.height, encoding.name);
        let sizes = std::iter::once((format!("{PREFIX}{TEXELS}"), sizes));
        for (key, value) in sizes.chain(pairs(texture, encoding)) {
            text += &format!("{comment} {key} = {}\n", json_string(&value));
        }
        text += &before;
        let limit = *Repr::F16.range().end();
        let number = |v: &f32| match encoding.repr {
            Repr::F16 => format!("{:#06x}", f16::from_f32(v.clamp(-limit, limit)).to_bits()),
            Repr::Unorm16 => ((f64::from(*v) * 65535.0).round_ties_even() as u16).to_string(),
            _ => format!("{v:?}{}", self.float_suffix),
        };
        let mut line = INDENT.to_string();
        let (values, count) = (&texture.levels[0], texture.channels.len());
        let planes = || (0..count).flat_map(|c| values.iter().skip(c).step_by(count)).copied().collect();
        let values: Vec<f32> = if facts.planes { planes() } else { values.clone() };
        for value in &values {
            let number = number(value);
            if line.len() + number.len() + 2 > LINE {
                text += line.trim_end();
                text.push('\n');
                line.truncate(INDENT.len());
            }
            line += &number;
            line += ", ";
        }
        text += line.trim_end();
        text.push('\n');
        text += &after;
        text += &format!("{comment} {END}\n");
        Ok(text.into_bytes())
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let help = "give a file as brdf-baker writes it, or bake the table again";
        let wrong = |what: &str| Error::input(path, what, help);
        let text = std::str::from_utf8(bytes).map_err(|_| wrong("it is not text"))?;
        let comment = self.comment;
        if !text.ends_with(&format!("\n{comment} {END}\n")) {
            return Err(wrong("its last line is not that of a table"));
        }

        let mut strings = vec![];
        for line in text.lines() {
            let fact = line.strip_prefix(comment).and_then(|l| l.strip_prefix(' ')).and_then(|l| l.split_once(" = "));
            if let Some((key, value)) = fact.filter(|(key, _)| key.starts_with(PREFIX)) {
                let value: String = serde_json::from_str(value).map_err(|_| wrong(&format!("its {key} is damaged")))?;
                strings.push((key, value));
            }
        }
        let stated = |key: &str| strings.iter().find(|(k, _)| k.strip_prefix(PREFIX) == Some(key)).map(|(_, v)| v);
        let sizes = stated(TEXELS).ok_or_else(|| wrong("it does not say how many texels it has"))?;
        let parsed = match sizes.split(' ').collect::<Vec<_>>()[..] {
            [width, height, ref several @ .., name] => {
                let size = |text: &str| text.parse::<u32>().ok().filter(|n| *n > 0);
                let shape = match several {
                    [] => Some(Shape::Table),
                    [depth] => size(depth).map(|depth| Shape::Volume { depth }),
                    [layers, LAYERS] => size(layers).filter(|n| *n > 1).map(|layers| Shape::Array { layers }),
                    _ => None,
                };
                let sizes = size(width).zip(size(height)).zip(shape);
                sizes.zip(numbers().into_iter().find(|e| e.name == name))
            }
            _ => None,
        };
        let (((width, height), shape), encoding) =
            parsed.ok_or_else(|| wrong(&format!("its size is stated as '{sizes}'")))?;
        let default = &["r", "g", "b", "a"][..encoding.components];
        let facts = strings.iter().map(|(k, v)| (*k, v.as_str()));
        let (channels, meta) = from_pairs(path, facts, default, encoding.components)?;

        let mut values = vec![];
        for line in text.lines() {
            let Some(numbers) =
                line.strip_prefix(INDENT).filter(|l| l.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
            else {
                continue;
            };
            for number in numbers.split_terminator(',') {
                let number = number.trim();
                let value = match encoding.repr {
                    Repr::F16 => number
                        .strip_prefix("0x")
                        .and_then(|bits| u16::from_str_radix(bits, 16).ok())
                        .map(|bits| f16::from_bits(bits).to_f32()),
                    Repr::Unorm16 => number.parse::<u16>().ok().map(|n| f32::from(n) / 65535.0),
                    _ => number.strip_suffix(self.float_suffix).and_then(|n| n.parse().ok()),
                };
                values.push(value.ok_or_else(|| wrong(&format!("'{}' is no number", number.escape_debug())))?);
            }
        }
        let rows = u64::from(height).checked_mul(shape.slices().unwrap_or(1).into());
        let texels = rows.and_then(|rows| rows.checked_mul(width.into()));
        let wanted = texels.and_then(|n| n.checked_mul(channels.len() as u64));
        if wanted != Some(values.len() as u64) {
            return Err(wrong(&format!("it has {} numbers, which is not its size", values.len())));
        }
        if meta.get(PLANES).is_some() {
            let texels = values.len() / channels.len();
            values = (0..values.len()).map(|i| values[i % channels.len() * texels + i / channels.len()]).collect();
        }
        let shape = if shape == Shape::Table && is_map(&meta) { Shape::Map } else { shape };
        let encoding = Encoding::fitting(encoding.repr, channels.len()).expect("these encodings hold up to four");
        Ok((Texture { shape, width, height, channels, levels: vec![values], meta }, encoding))
    }
}

/// What numbers can be: floats, and words of 16 bits.
fn numbers() -> Vec<Encoding> {
    let words = ENCODINGS.iter().filter(|e| e.repr == Repr::Unorm16).copied();
    floats().into_iter().chain(words).collect()
}

fn facts(path: &Path, texture: &Texture, encoding: Encoding) -> Facts {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name.insert_str(0, "LUT_");
    }
    let meta = |key: &str| texture.meta.get(key).unwrap_or("not stated");
    // Facts of ours hold no line breaks; these go into comments, which must not end early either.
    let axes = match texture.meta.get("axes") {
        Some(axes) if axes.is_ascii() => format!("{axes}, {}, {}", meta("order"), meta("points")),
        _ => "x,y".into(),
    };
    Facts {
        small_name: name.to_ascii_lowercase(),
        name: name.to_ascii_uppercase(),
        width: texture.width,
        height: texture.height,
        slices: match texture.shape {
            Shape::Volume { depth } => Some((depth, VOLUME)),
            Shape::Array { layers } => Some((layers, ARRAY)),
            Shape::Table | Shape::Map | Shape::Cube => None,
        },
        channels: texture.channels.len(),
        planes: texture.meta.get(PLANES).is_some(),
        words: match encoding.repr {
            Repr::F16 => Some("the bits of a half float"),
            Repr::Unorm16 => Some("a share of 65535"),
            _ => None,
        },
        edges: texture.meta.get("points") == Some("edges"),
        axes,
    }
}

/// In ASCII: no compiler stumbles over letters of other scripts, or over what turns their direction.
fn json_string(text: &str) -> String {
    super::ascii(&serde_json::Value::from(text).to_string())
}
