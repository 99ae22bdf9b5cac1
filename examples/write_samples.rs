//! Writes one file of each format with known values, and `values.json` beside them: what a reader must find.
//!
//! ```text
//! cargo run --example write_samples -- FOLDER
//! ```
//! `tests/readers` reads them with libraries that are not ours.

use std::path::Path;
use std::process::ExitCode;

use brdf_baker::format::{Encoding, Output, Repr, for_path};
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::{Error, Result};
use serde_json::{Value, json};

/// File, encoding, shape, width, height, channels.
const SAMPLES: &[(&str, &str, Shape, u32, u32, usize)] = &[
    ("table_r16f.ktx2", "r16f", Shape::Table, 9, 5, 1),
    ("table_rg16f.ktx2", "rg16f", Shape::Table, 16, 8, 2),
    ("table_rgba16f_3.ktx2", "rgba16f", Shape::Table, 5, 7, 3),
    ("table_r32f.ktx2", "r32f", Shape::Table, 33, 1, 1),
    ("table_rg32f.ktx2", "rg32f", Shape::Table, 3, 3, 2),
    ("table_rgba32f.ktx2", "rgba32f", Shape::Table, 4, 6, 4),
    ("cube_rgba16f.ktx2", "rgba16f", Shape::Cube, 8, 8, 3),
    ("cube_rg32f.ktx2", "rg32f", Shape::Cube, 5, 5, 2),
    ("table_rg16f.exr", "rg16f", Shape::Table, 16, 40, 2),
    ("table_r32f.exr", "r32f", Shape::Table, 33, 1, 1),
    ("table_rgba32f.exr", "rgba32f", Shape::Table, 4, 6, 4),
    ("cube_rgba16f_3.exr", "rgba16f", Shape::Cube, 8, 8, 3),
    ("cube_r32f.exr", "r32f", Shape::Cube, 1, 1, 1),
    ("table.hdr", "rgbe8", Shape::Table, 16, 8, 3),
    ("table_narrow.hdr", "rgbe8", Shape::Table, 5, 3, 2),
    ("table_r8.png", "r8unorm", Shape::Table, 16, 8, 1),
    ("table_rgb8.png", "rgb8unorm", Shape::Table, 5, 3, 3),
    ("table_r16.png", "r16unorm", Shape::Table, 9, 4, 1),
    ("table_rgb16.png", "rgb16unorm", Shape::Table, 16, 8, 2),
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
    for &(file, encoding, shape, width, height, channels) in SAMPLES {
        let encoding = Encoding::parse(encoding)?;
        let texture = texture(shape, width, height, channels, encoding.repr);
        let path = folder.join(file);
        Output::prepare(&path)?.commit(for_path(&path)?, &texture, encoding)?;
        entries.push(entry(file, encoding, &texture));
    }
    let path = folder.join("values.json");
    let text = serde_json::to_string_pretty(&entries).expect("plain values always serialise");
    std::fs::write(&path, text + "\n").map_err(|e| Error::io("write", &path, e))
}

fn texture(shape: Shape, width: u32, height: u32, channels: usize, repr: Repr) -> Texture {
    let channels = ["scale", "bias", "third", "fourth"][..channels].iter().map(|s| s.to_string()).collect();
    let mut meta = Meta::default();
    meta.set("table", "sample");
    meta.set("note", "α² = \"width\" → é 漢字 🙂");
    let mut texture = Texture { shape, width, height, channels, levels: vec![], meta };
    let levels = if shape == Shape::Cube { width.ilog2() + 1 } else { 1 };
    for level in 0..levels {
        let (w, h) = texture.level_size(level as usize);
        let mut values = Vec::new();
        for (face, y, x) in (0..texture.faces()).flat_map(|f| (0..h).flat_map(move |y| (0..w).map(move |x| (f, y, x))))
        {
            for c in 0..texture.channels.len() as u32 {
                values.push(value([level, face, x, y, c], repr));
            }
        }
        texture.levels.push(values);
    }
    texture
}

/// Differs between neighbours, faces, levels and channels, and is stored exactly.
fn value([level, face, x, y, c]: [u32; 5], repr: Repr) -> f32 {
    let n = x * 37 + y * 101 + face * 331 + level * 577 + c * 1009;
    match repr {
        Repr::F16 => ((n % 2048) as f32 - 700.0) / 256.0,
        Repr::F32 => (n as f32 - 2000.0) * 1.000_123,
        Repr::Unorm8 => (n % 256) as f32 / 255.0,
        Repr::Unorm16 => (n * 21 % 65536) as f32 / 65535.0,
        // The first channel has the full mantissa, so that the others share its exponent.
        Repr::Rgbe8 if c == 0 => (128 + n % 128) as f32 / 64.0,
        Repr::Rgbe8 => (n % 256) as f32 / 64.0,
    }
}

fn entry(file: &str, encoding: Encoding, texture: &Texture) -> Value {
    let levels: Vec<Value> = (0..texture.levels.len())
        .map(|level| {
            let (width, height) = texture.level_size(level);
            // Corners and a point inside, of every face.
            let spots = [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1), (width / 2, height / 3)];
            let probes: Vec<Value> = (0..texture.faces())
                .flat_map(|face| spots.map(|(x, y)| (face, x, y)))
                .map(|(face, x, y)| json!({"face": face, "x": x, "y": y, "values": texture.texel(level, face, x, y)}))
                .collect();
            json!({"width": width, "height": height, "probes": probes})
        })
        .collect();
    let meta: serde_json::Map<String, Value> = texture.meta.iter().map(|(k, v)| (k.into(), v.into())).collect();
    json!({
        "file": file,
        "encoding": encoding.name,
        "components": encoding.components,
        "faces": texture.faces(),
        "channels": texture.channels,
        "meta": meta,
        "levels": levels,
    })
}
