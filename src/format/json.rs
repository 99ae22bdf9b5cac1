// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables as JSON: one object with sizes, channels, everything that the meta says, and the values as numbers, slices or
//! layers in order, rows from the top, texels from the left, channels interleaved. A single float is written so that it reads as itself again.

use std::path::Path;

use half::f16;
use serde_json::{Map, Value};

use super::{Encoding, Format, PREFIX, Repr, Storage, WRITER, check, floats, from_pairs, is_map, pairs};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// The key of the number of slices of a volume.
const SLICES: &str = "slices";
/// The key of the number of layers of an array.
const LAYERS: &str = "layers";

/// JavaScript Object Notation.
#[derive(Debug)]
pub struct Json;

impl Format for Json {
    fn name(&self) -> &'static str {
        "JSON"
    }

    fn extension(&self) -> &'static str {
        "json"
    }

    fn holds_mips(&self) -> bool {
        false
    }

    fn encodings(&self, shape: Shape) -> Vec<Encoding> {
        if shape == Shape::Cube { vec![] } else { floats() }
    }

    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding> {
        Encoding::fitting(Repr::F32, channels).filter(|_| shape != Shape::Cube)
    }

    fn to_bytes(&self, path: &Path, texture: &Texture, storage: Storage) -> Result<Vec<u8>> {
        check(path, self, texture, storage)?;
        let string = |text: &str| Value::from(text).to_string();
        let facts: Vec<String> = pairs(texture, storage.encoding)
            .iter()
            .map(|(key, value)| format!("    {}: {}", string(key), string(value)))
            .collect();
        let limit = *Repr::F16.range().end();
        let number = |v: &f32| match storage.encoding.repr {
            Repr::F16 => format!("{:?}", f16::from_f32(v.clamp(-limit, limit)).to_f32()),
            _ => format!("{v:?}"),
        };
        // A texel row a line.
        let row = |values: &[f32]| values.iter().map(number).collect::<Vec<_>>().join(", ");
        let rows = texture.levels[0].chunks(texture.width as usize * texture.channels.len());
        let rows: Vec<String> = rows.map(|values| format!("    {}", row(values))).collect();
        let slices = match texture.shape {
            Shape::Volume { depth } => format!("  \"{SLICES}\": {depth},\n"),
            Shape::Array { layers } => format!("  \"{LAYERS}\": {layers},\n"),
            Shape::Table | Shape::Map | Shape::Cube => String::new(),
        };
        // No line break at the end: whatever is missing then shows.
        let text = format!(
            "{{\n  \"writer\": {},\n  \"width\": {},\n  \"height\": {},\n{slices}  \"encoding\": {},\n  \"facts\": {{\n{}\n  }},\n  \
             \"values\": [\n{}\n  ]\n}}",
            string(WRITER),
            texture.width,
            texture.height,
            string(storage.encoding.name),
            facts.join(",\n"),
            rows.join(",\n")
        );
        Ok(text.into_bytes())
    }

    fn parse(&self, path: &Path, bytes: &[u8]) -> Result<(Texture, Encoding)> {
        let help = "give a file as brdf-baker writes it, or bake the table again";
        let wrong = |what: &str| Error::input(path, what, help);
        let file: Value = serde_json::from_slice(bytes).map_err(|e| wrong(&format!("it is not sound JSON: {e}")))?;
        let size = |key: &str| file[key].as_u64().and_then(|n| u32::try_from(n).ok()).filter(|n| *n > 0);
        let name = file["encoding"].as_str().unwrap_or_default();
        let encoding = floats().into_iter().find(|e| e.name == name);
        let (Some(width), Some(height), Some(encoding)) = (size("width"), size("height"), encoding) else {
            return Err(wrong("it does not say its width, height and encoding"));
        };
        let several = |key: &str| if file[key].is_null() { Some(None) } else { size(key).map(Some) };
        let shape = match (several(SLICES), several(LAYERS)) {
            (Some(None), Some(None)) => Shape::Table,
            (Some(Some(depth)), Some(None)) => Shape::Volume { depth },
            (Some(None), Some(Some(layers @ 2..))) => Shape::Array { layers },
            _ => return Err(wrong("it does not say how many slices or layers it has")),
        };
        let empty = Map::new();
        let facts = file["facts"].as_object().unwrap_or(&empty);
        let facts = facts.iter().filter_map(|(key, value)| Some((key.as_str(), value.as_str()?)));
        let default = &["r", "g", "b", "a"][..encoding.components];
        let (channels, meta) =
            from_pairs(path, facts.filter(|(k, _)| k.starts_with(PREFIX)), default, encoding.components)?;
        let values: Option<Vec<f32>> =
            file["values"].as_array().and_then(|list| list.iter().map(|v| v.as_f64().map(|v| v as f32)).collect());
        let values = values.ok_or_else(|| wrong("its values are not all numbers"))?;
        let rows = u64::from(height).checked_mul(shape.slices().unwrap_or(1).into());
        let texels = rows.and_then(|rows| rows.checked_mul(width.into()));
        let wanted = texels.and_then(|n| n.checked_mul(channels.len() as u64));
        if wanted != Some(values.len() as u64) {
            return Err(wrong(&format!("it has {} values, which is not its size", values.len())));
        }
        let shape = if shape == Shape::Table && is_map(&meta) { Shape::Map } else { shape };
        let encoding = Encoding::fitting(encoding.repr, channels.len()).expect("float encodings hold up to four");
        Ok((Texture { shape, width, height, channels, levels: vec![values], meta }, encoding))
    }
}
