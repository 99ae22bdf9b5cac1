// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the shaders are compiled from.

use std::path::{Path, PathBuf};

/// Files and folders whose content decides on the SPIR-V.
const SOURCES: [&str; 5] = [
    "shaders",
    "build/compile.rs",
    "src/quadrature/gauss_legendre.rs",
    "src/rule/azimuth_nodes.rs",
    "src/rule/cone_nodes.rs",
];

/// A hash of the names and contents of all sources: FNV-1a of 64 bits, which tells versions apart and is no protection
/// against anyone. Ends of lines do not count, as git changes them on Windows. Cargo runs the build script again when one
/// of the sources changes.
pub fn fingerprint() -> String {
    let mut files = vec![];
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        collect(Path::new(source), &mut files);
    }
    files.sort();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |bytes: &[u8]| {
        for byte in bytes.iter().filter(|byte| **byte != b'\r').chain(&[0]) {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for file in files {
        add(file.to_string_lossy().replace('\\', "/").as_bytes());
        add(&std::fs::read(&file).unwrap_or_else(|e| panic!("cannot read {}: {e}", file.display())));
    }
    format!("{hash:016x}")
}

/// The files at or below `path`, in any order.
pub fn collect(path: &Path, found: &mut Vec<PathBuf>) {
    if !path.is_dir() {
        found.push(path.into());
        return;
    }
    let entries = std::fs::read_dir(path).unwrap_or_else(|e| panic!("cannot read {}: {e}", path.display()));
    for entry in entries {
        collect(&entry.expect("a readable folder entry").path(), found);
    }
}
