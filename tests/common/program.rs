// SPDX-License-Identifier: MIT OR Apache-2.0
//! Running the program itself.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use brdf_baker::format::{self, Fingerprint};

/// A command in a folder, on the processor, so that no test needs a driver.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = on_any_device(folder, arguments);
    command.args(["--device", "cpu"]);
    command
}

/// The same on the best device that there is.
pub fn on_any_device(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// Expects success; returns stdout.
pub fn succeeds(command: &mut Command) -> String {
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{command:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// A file that is there has all of its texels: those that it states the hash of.
pub fn is_whole(path: &Path) -> bool {
    let (texture, encoding) = format::for_path(path).and_then(|f| f.read(path)).expect("a sound file");
    let stated = Fingerprint::stated(&texture.meta).expect("a fingerprint");
    stated == Some(Fingerprint::of_stored(&texture, encoding).expect("texels"))
}

/// Expects an exit code and words on stderr, and no panic; returns stdout.
pub fn fails(command: &mut Command, code: i32, words: &[&str]) -> String {
    let output = command.output().expect("the program starts");
    said(&output, code, words);
    text(&output.stdout)
}

/// Checks what a command that ended has said.
pub fn said(output: &Output, code: i32, words: &[&str]) {
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
    for word in words {
        assert!(stderr.contains(word), "'{word}' is not in: {stderr}");
    }
}

/// All files below a folder, relative to it, sorted.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path.strip_prefix(folder).expect("below it").to_path_buf());
            }
        }
    }
    found.sort();
    found
}

/// A small environment that differs with `seed`: a lamp in front of a gradient.
pub fn environment(path: &Path, seed: f32) {
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
    let texel = |x: usize, y: usize| {
        let lamp = if x == 9 && y == 3 { 20.0 } else { 0.0 };
        (0.2 + x as f32 / 32.0 + lamp, 0.3 + y as f32 / 16.0, 0.5 + seed)
    };
    exr::prelude::write_rgb_file(path, 32, 16, texel).expect("writable");
}
