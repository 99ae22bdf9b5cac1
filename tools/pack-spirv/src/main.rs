// SPDX-License-Identifier: MIT OR Apache-2.0
//! Writes the shaders that this build compiled to a folder, or compares a folder with them.
//!
//! ```text
//! pack-spirv write spirv
//! pack-spirv check spirv
//! ```
//! `SOURCES` in the folder is the fingerprint of what they were compiled from.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use brdf_baker::shaders::{SHADERS, SOURCES};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words[..] {
        ["write", folder] => write(Path::new(folder)),
        ["check", folder] => check(Path::new(folder)),
        _ => Err("usage: pack-spirv write|check FOLDER".into()),
    };
    match done {
        Ok(said) => {
            println!("{said}");
            ExitCode::SUCCESS
        }
        Err(what) => {
            eprintln!("error: {what}");
            ExitCode::FAILURE
        }
    }
}

/// What the folder must hold.
fn wanted(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let shaders = SHADERS.iter().map(|(name, bytes)| (folder.join(format!("{name}.spv")), bytes.to_vec()));
    shaders.chain([(folder.join("SOURCES"), format!("{SOURCES}\n").into_bytes())]).collect()
}

fn write(folder: &Path) -> Result<String, String> {
    let say = |path: &Path, e| format!("cannot write '{}': {e}", path.display());
    if folder.exists() {
        // Only a folder that was written before is replaced.
        if !folder.join("SOURCES").is_file() {
            return Err(format!("'{}' is not a folder of compiled shaders: name another", folder.display()));
        }
        fs::remove_dir_all(folder).map_err(|e| say(folder, e))?;
    }
    let files = wanted(folder);
    for (path, bytes) in &files {
        let parent = path.parent().expect("below the folder");
        fs::create_dir_all(parent).map_err(|e| say(parent, e))?;
        fs::write(path, bytes).map_err(|e| say(path, e))?;
    }
    let size: usize = files.values().map(Vec::len).sum();
    Ok(format!("{}: {} shaders, {size} bytes, of sources {SOURCES}", folder.display(), SHADERS.len()))
}

fn check(folder: &Path) -> Result<String, String> {
    let mut found = BTreeMap::new();
    read(folder, &mut found)?;
    let wanted = wanted(folder);
    let all: BTreeSet<&PathBuf> = wanted.keys().chain(found.keys()).collect();
    let wrong: Vec<&PathBuf> = all.into_iter().filter(|path| found.get(*path) != wanted.get(*path)).collect();
    match wrong.first() {
        None => Ok(format!("{}: {} shaders, as compiled here", folder.display(), SHADERS.len())),
        Some(first) => Err(format!("{} files are not as compiled here, such as '{}'", wrong.len(), first.display())),
    }
}

fn read(folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) -> Result<(), String> {
    let say = |path: &Path, e| format!("cannot read '{}': {e}", path.display());
    for entry in fs::read_dir(folder).map_err(|e| say(folder, e))? {
        let path = entry.map_err(|e| say(folder, e))?.path();
        if path.is_dir() {
            read(&path, found)?;
        } else {
            let bytes = fs::read(&path).map_err(|e| say(&path, e))?;
            found.insert(path, bytes);
        }
    }
    Ok(())
}
