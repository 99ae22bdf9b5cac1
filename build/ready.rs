// SPDX-License-Identifier: MIT OR Apache-2.0
//! SPIR-V that was compiled before.

use std::path::Path;

use crate::sources::collect;

const FOLDER: &str = "spirv";

/// The name and the words of every shader, sorted by name. Ends the build where there are none, or where they were compiled
/// from other sources than `sources`.
pub fn shaders(sources: &str) -> Vec<(String, Vec<u8>)> {
    println!("cargo::rerun-if-changed={FOLDER}");
    let help = "in a checkout build with `--features compile-shaders`, or run `make spirv`";
    let stated = std::fs::read_to_string(Path::new(FOLDER).join("SOURCES"));
    match stated.as_deref().map(str::trim) {
        Ok(stated) if stated == sources => {}
        Ok(stated) => fail(&format!("{FOLDER}/ was compiled from other shaders ({stated}, here is {sources}): {help}")),
        Err(e) => fail(&format!("no compiled shaders: {FOLDER}/SOURCES: {e}: {help}")),
    }
    let mut files = vec![];
    collect(Path::new(FOLDER), &mut files);
    let shaders = files.iter().filter(|file| file.extension().is_some_and(|e| e == "spv"));
    let mut shaders: Vec<(String, Vec<u8>)> = shaders.map(|file| (name(file), read(file))).collect();
    shaders.sort();
    shaders
}

fn name(file: &Path) -> String {
    let name = file.strip_prefix(FOLDER).expect("below the folder").with_extension("");
    name.to_string_lossy().replace('\\', "/")
}

fn read(file: &Path) -> Vec<u8> {
    std::fs::read(file).unwrap_or_else(|e| fail(&format!("cannot read {}: {e}", file.display())))
}

fn fail(what: &str) -> ! {
    println!("cargo::error={what}");
    std::process::exit(1);
}
