// SPDX-License-Identifier: MIT OR Apache-2.0
//! Writes a file of each format, shape and encoding with known values, and `values.json` beside them: what a reader must
//! find.
//!
//! ```text
//! cargo run --example write_samples -- FOLDER
//! ```
//! `tests/readers` reads them with libraries that are not ours.

use std::path::Path;
use std::process::ExitCode;

use brdf_baker::format::{Compression, Encoding, Format, Output, Repr, Storage, formats, harmonics};
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::{Error, Result};
use serde_json::{Value, json};

/// Width and height, those of which the first fit a format are taken: odd ones where they can be.
const SIZES: &[(Shape, &[(u32, u32)])] = &[
    (Shape::Table, &[(9, 5)]),
    (Shape::Array { layers: 3 }, &[(9, 5)]),
    (Shape::Map, &[(12, 6)]),
    (Shape::Cube, &[(10, 10), (8, 8)]),
];

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1) else {
        eprintln!("usage: write_samples FOLDER");
        return ExitCode::from(2);
    };
    match write_all(Path::new(&folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}\n  help: {}", e.help());
            ExitCode::from(e.exit_code())
        }
    }
}

fn write_all(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    let mut entries = Vec::new();
    for &format in formats() {
        for (shape, sizes) in SIZES {
            for encoding in format.encodings(*shape) {
                for &compression in format.compressions() {
                    let storage = Storage { compression, ..encoding.into() };
                    entries.push(sample(folder, format, *shape, sizes, storage)?);
                }
            }
        }
    }
    let path = folder.join("values.json");
    let text = serde_json::to_string_pretty(&entries).expect("plain values always serialise");
    std::fs::write(&path, text + "\n").map_err(|e| Error::io("write", &path, e))
}

/// Writes one file.
fn sample(folder: &Path, format: &dyn Format, shape: Shape, sizes: &[(u32, u32)], storage: Storage) -> Result<Value> {
    let encoding = storage.encoding;
    let levels = |(width, height): (u32, u32)| match shape {
        _ if shape.is_table() || !format.holds_mips() => 1,
        _ => width.max(height).ilog2() + 1,
    };
    let fits = |size: &&(u32, u32)| format.accepts(size.0, levels(**size)).is_ok();
    let size = sizes.iter().find(fits).copied().expect("a size fits every format");
    let texture = texture(shape, size, levels(size), encoding);
    let packed = if storage.compression == Compression::Plain { "" } else { "_zstd" };
    let kind = kind(shape);
    let file = format!("{kind}_{}{packed}.{}", encoding.name, format.extension());
    let path = folder.join(&file);
    Output::prepare(&path)?.commit(format, &texture, storage)?;
    // What the encoding made of the values.
    let (read, _) = format.read(&path)?;
    Ok(entry(&file, format, storage, &texture, &read))
}

/// What a shape is called.
fn kind(shape: Shape) -> &'static str {
    match shape {
        Shape::Table => "table",
        Shape::Map => "map",
        Shape::Volume { .. } => "volume",
        Shape::Array { .. } => "array",
        Shape::Cube => "cube",
    }
}

fn texture(shape: Shape, (width, height): (u32, u32), levels: u32, encoding: Encoding) -> Texture {
    // Three of four components, so that what fills a texel up is looked at as well.
    let count = encoding.components.min(3);
    let channels = ["scale", "bias", "third"][..count].iter().map(|s| s.to_string()).collect();
    let mut meta = Meta::default();
    meta.set("table", "sample");
    meta.set("note", "α² = \"width\" → é 漢字 🙂");
    if shape == Shape::Map {
        meta.set("projection", "equirect");
    }
    if shape == Shape::Cube {
        harmonics::state(&std::array::from_fn(|i| [1.0, 0.5, 0.25].map(|v| v / (1 + i) as f64)), &mut meta);
    }
    let mut texture = Texture { shape, width, height, channels, levels: vec![], meta };
    for level in 0..levels {
        let (w, h) = texture.level_size(level as usize);
        let mut values = Vec::new();
        for (face, y, x) in (0..texture.faces()).flat_map(|f| (0..h).flat_map(move |y| (0..w).map(move |x| (f, y, x))))
        {
            for c in 0..texture.channels.len() as u32 {
                values.push(value([level, face, x, y, c], encoding.repr));
            }
        }
        texture.levels.push(values);
    }
    texture
}

/// Differs between neighbours, faces, levels and channels. Where each value is stored by itself, it is stored exactly.
fn value([level, face, x, y, c]: [u32; 5], repr: Repr) -> f32 {
    let n = x * 37 + y * 101 + face * 331 + level * 577 + c * 1009;
    match repr {
        Repr::Unorm10 => (n % 1024) as f32 / 1023.0,
        Repr::B10g11r11 => (32 + n % 32) as f32 / 8.0,
        Repr::Rgb9e5 if c == 0 => (256 + n % 256) as f32 / 64.0,
        Repr::Rgb9e5 => (n % 512) as f32 / 64.0,
        Repr::Rgbd8 | Repr::Rgbm8 | Repr::Rgbp8 => (n % 97) as f32 / 12.0,
        // Smooth, for blocks.
        Repr::Bc4 | Repr::Bc5 | Repr::Bc6h => 0.1 + 0.8 * ((x + 2 * y + 3 * c + 5 * face) as f32 / 40.0).sin().abs(),
        Repr::F16 => ((n % 2048) as f32 - 700.0) / 256.0,
        Repr::F32 => (n as f32 - 2000.0) * 1.000_123,
        Repr::Unorm8 => (n % 256) as f32 / 255.0,
        Repr::Unorm16 => (n * 21 % 65536) as f32 / 65535.0,
        // The first channel has the full mantissa, so that the others share its exponent.
        Repr::Rgbe8 if c == 0 => (128 + n % 128) as f32 / 64.0,
        Repr::Rgbe8 => (n % 256) as f32 / 64.0,
    }
}

/// `read` has the values, `texture` the names and facts that were handed over.
fn entry(file: &str, format: &dyn Format, storage: Storage, texture: &Texture, read: &Texture) -> Value {
    let channels = texture.channels.len();
    let levels: Vec<Value> = (0..read.levels.len())
        .map(|level| {
            let (width, height) = read.level_size(level);
            // Corners, edges and inside, of every face.
            let along = |size: u32| [0, size / 2, size - 1];
            let spots = || along(height).into_iter().flat_map(move |y| along(width).map(move |x| (x, y)));
            let probes: Vec<Value> = (0..read.faces())
                .flat_map(|face| spots().map(move |(x, y)| (face, x, y)))
                .map(|(face, x, y)| {
                    let values = &read.texel(level, face, x, y)[..channels];
                    json!({"face": face, "x": x, "y": y, "values": values})
                })
                .collect();
            json!({"width": width, "height": height, "probes": probes})
        })
        .collect();
    let meta: serde_json::Map<String, Value> = texture.meta.iter().map(|(k, v)| (k.into(), v.into())).collect();
    json!({
        "file": file,
        "shape": kind(texture.shape),
        "encoding": storage.encoding.name,
        "decode": storage.encoding.formula(),
        "compression": storage.compression.name(),
        "components": storage.encoding.components,
        "faces": texture.faces(),
        "layers": texture.shape.slices().unwrap_or(0),
        "channels": texture.channels,
        "meta": if format.holds_meta() { meta.into() } else { Value::Null },
        "levels": levels,
    })
}
