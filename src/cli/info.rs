// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker info`

use std::path::Path;

use brdf_baker::Result;
use brdf_baker::format;
use brdf_baker::target;
use brdf_baker::texture::Shape;
use serde_json::{Map, Value, json};

use super::console::Console;

pub fn run(file: &Path, console: &mut Console) -> Result<()> {
    let (texture, encoding) = format::for_path(file)?.read(file)?;
    let shape = match texture.shape {
        Shape::Table => "table",
        Shape::Map => "map",
        Shape::Cube => "cube",
        Shape::Volume { .. } => "volume",
        Shape::Array { .. } => "array",
    };
    let depth = texture.shape.slices();
    let slices = depth.map_or(String::new(), |depth| format!("x{depth}"));
    let size = format!("{}x{}{slices}", texture.width, texture.height);
    let mut text = format!("{}\n", file.display());
    let mut line = |key: &str, value: &str| text.push_str(&format!("  {key:16} {value}\n"));
    line("shape", shape);
    line("size", &size);
    line("levels", &texture.levels.len().to_string());
    line("encoding", encoding.name);
    if let Some(formula) = encoding.formula() {
        line("decode", formula);
    }
    line("channels", &texture.channels.join(","));
    for (key, value) in texture.meta.iter() {
        line(key, value);
    }
    if texture.meta.is_empty() {
        line("note", "the file does not say what it holds: brdf-baker did not write it, or its metadata was stripped");
    }
    let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let snippet = target::snippet(&texture.meta, &name);
    if let (Some(snippet), Some(target)) = (&snippet, texture.meta.get("target")) {
        text.push_str(&format!("\nIn {target}:\n"));
        snippet.lines().for_each(|line| text.push_str(&format!("    {line}\n")));
    }
    let meta: Map<String, Value> = texture.meta.iter().map(|(k, v)| (k.to_string(), json!(v))).collect();
    console.result(
        text.trim_end(),
        &json!({
            "path": file,
            "shape": shape,
            "width": texture.width,
            "height": texture.height,
            "depth": depth,
            "levels": texture.levels.len(),
            "encoding": encoding.name,
            "decode": encoding.formula(),
            "channels": texture.channels,
            "meta": meta,
            "snippet": snippet,
        }),
    )
}
