// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reads the environments that tests/readers/write.py wrote with other programs' libraries, and compares texels.
//!
//! Usage: read_inputs FOLDER

use std::path::Path;
use std::process::ExitCode;

use brdf_baker::env::Picture;
use brdf_baker::env::import::{Options, read};
use brdf_baker::progress::ignore;
use serde_json::Value;

fn main() -> ExitCode {
    let Some(folder) = std::env::args().nth(1) else {
        eprintln!("usage: read_inputs FOLDER");
        return ExitCode::from(2);
    };
    match check(Path::new(&folder)) {
        Ok(count) if count > 0 => {
            println!("inputs: {count} files of other programs read");
            ExitCode::SUCCESS
        }
        Ok(_) => {
            eprintln!("inputs: nothing was compared");
            ExitCode::FAILURE
        }
        Err(what) => {
            eprintln!("inputs: {what}");
            ExitCode::FAILURE
        }
    }
}

fn check(folder: &Path) -> Result<usize, String> {
    let list = std::fs::read_to_string(folder.join("inputs.json")).map_err(|e| e.to_string())?;
    let entries: Vec<Value> = serde_json::from_str(&list).map_err(|e| e.to_string())?;
    for entry in &entries {
        let name = entry["file"].as_str().ok_or("an entry has no file")?;
        let options = Options { part: entry["part"].as_str().map(String::from), ..Options::default() };
        let imported = read(&folder.join(name), &options, &mut ignore).map_err(|e| format!("{e}; {}", e.help()))?;
        if Some(imported.notes.len() as u64) != entry["notes"].as_u64() {
            return Err(format!("{name}: unexpected notes {:?}", imported.notes));
        }
        let Picture::Equirect(picture) = &imported.environment.picture else {
            return Err(format!("{name} is no panorama"));
        };
        let tolerance = entry["tolerance"].as_f64().ok_or("an entry has no tolerance")?;
        let probes = entry["probes"].as_array().filter(|p| !p.is_empty()).ok_or("an entry has no probes")?;
        for probe in probes {
            let [x, y] = ["x", "y"].map(|key| probe[key].as_u64().map_or(usize::MAX, |v| v as usize));
            let found = picture.row(y as u32)[x];
            for (c, value) in found.iter().enumerate() {
                let expected = probe["rgb"][c].as_f64().ok_or("a probe has no colour")?;
                let off = (f64::from(*value) - expected).abs();
                if off.is_nan() || off > tolerance * expected + 1e-7 {
                    return Err(format!("{name} at ({x}, {y}): {found:?}, expected {}", probe["rgb"]));
                }
            }
        }
    }
    Ok(entries.len())
}
