// SPDX-License-Identifier: MIT OR Apache-2.0
//! What holds of the sources as text.

use std::path::{Path, PathBuf};

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.expect("a readable folder").path();
        let name = path.file_name().expect("a name").to_string_lossy();
        if path.is_dir() && !["target", "node_modules"].contains(&&*name) && !name.starts_with('.') {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Lines of code, numbered, that hold the keyword or allow it.
fn unsafe_lines(text: &str) -> Vec<usize> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let hits = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        let keyword = code.split(|c| !is_word(c)).any(|word| word == concat!("un", "safe"));
        keyword || (code.contains(concat!("un", "safe_code")) && code.contains("allow"))
    };
    text.lines().enumerate().filter(|(_, line)| hits(line)).map(|(i, _)| i + 1).collect()
}

/// The lint denies it to this crate, but an `allow` could lift that anywhere, and other crates of the checkout have lints of
/// their own.
#[test]
fn no_code_outside_the_gpu_folder_is_unsafe() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = vec![];
    rust_files(root, &mut files);
    let gpu = root.join("src/gpu");
    let (inside, outside): (Vec<_>, Vec<_>) = files.iter().partition(|path| path.starts_with(&gpu));
    let lines = |path: &Path| unsafe_lines(&std::fs::read_to_string(path).expect("readable"));
    let wrong: Vec<String> = outside
        .iter()
        .flat_map(|path| lines(path).into_iter().map(move |line| format!("{}:{line}", path.display())))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(outside.len() > 100, "only {} files were looked at", outside.len());
    assert!(inside.iter().map(|path| lines(path).len()).sum::<usize>() > 10, "the look sees nothing");
}

#[test]
fn the_look_for_unsafe_sees_it() {
    let keyword = concat!("un", "safe");
    assert_eq!(unsafe_lines(&format!("fn a() {{}}\n{keyword} fn b() {{}}\n// {keyword}\nlet not_{keyword} = 1;")), [2]);
    assert_eq!(unsafe_lines(&format!("#![allow({keyword}_code)]\n#![deny({keyword}_code)]")), [1]);
}
