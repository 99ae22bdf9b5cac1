// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of an asset pipeline: filters every environment of a folder that is newer than its cube, and bakes the table that
//! an engine's own BRDF needs.
//!
//! ```text
//! cargo run --release --example asset_pipeline -- ASSETS OUT
//! ```

use std::fs;
use std::path::Path;
use std::process::ExitCode;

use brdf_baker::asset::Baker;
use brdf_baker::bake::TableRequest;
use brdf_baker::bake::specular::SpecularRequest;
use brdf_baker::{Error, Result};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [assets, out] = arguments.as_slice() else {
        eprintln!("usage: asset_pipeline ASSETS OUT");
        return ExitCode::from(2);
    };
    match run(Path::new(assets), Path::new(out)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}\n  help: {}", error.help());
            ExitCode::from(error.exit_code())
        }
    }
}

fn run(assets: &Path, out: &Path) -> Result<()> {
    let baker = Baker::open("auto")?;
    println!("on {}", baker.backend.name());

    // The BRDF of the engine's shaders, spelled as `brdf-baker list` does.
    let request = TableRequest { visibility: "schlick-ggx".into(), size: (128, 32), ..TableRequest::new("split-sum") };
    let written = baker.table(&request, out.join("dfg.ktx2"))?;
    println!("dfg.ktx2: {} bytes, off by {:.1e} at most from rounding", written.bytes, written.rounding.most.max_abs);

    // Environments, where something changed.
    let request = SpecularRequest { size: Some(128), ..SpecularRequest::default() };
    for entry in fs::read_dir(assets).map_err(|e| Error::io("read", assets, e))? {
        let source = entry.map_err(|e| Error::io("read", assets, e))?.path();
        let is_environment = source.extension().is_some_and(|e| e == "hdr" || e == "exr");
        let cube = out.join(source.file_stem().unwrap_or_default()).with_extension("ktx2");
        if !is_environment || is_newer(&cube, &source) {
            continue;
        }
        let written = baker.environment(&source, &request, &cube)?;
        println!("{}: {} bytes", cube.display(), written.bytes);
    }
    Ok(())
}

/// Is `file` there, and changed after `source`?
fn is_newer(file: &Path, source: &Path) -> bool {
    let changed = |path: &Path| fs::metadata(path).and_then(|meta| meta.modified()).ok();
    changed(file).zip(changed(source)).is_some_and(|(file, source)| file > source)
}
