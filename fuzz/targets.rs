// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is fed with bytes that nobody vouches for: every reader, and what the program does with a file before it works on it.
//!
//! cargo-fuzz drives them (`fuzz_targets/`), and `tests/hostile.rs` replays the corpus and small changes of it.

use std::path::{Path, PathBuf};

use brdf_baker::bake::atlas::Atlas;
use brdf_baker::bake::specular::SpecularJob;
use brdf_baker::bake::{LayersJob, TableJob, VolumeJob};
use brdf_baker::env::import::{self, Options};
use brdf_baker::format::picture::Picture;
use brdf_baker::format::{self, Steps, harmonics};
use brdf_baker::progress::ignore;
use brdf_baker::recipe::Recipe;
use brdf_baker::target;
use brdf_baker::verify::certificate::Certificate;

/// A name, and what takes the bytes. Nothing may panic, hang, or take memory beyond [`multiple`].
pub struct Target {
    /// Of the target and of its folder in the corpus.
    pub name: &'static str,
    /// Whether the bytes were accepted.
    pub run: fn(&[u8]) -> bool,
}

/// All of them.
pub const TARGETS: [Target; 13] = [
    Target { name: "ktx2", run: |bytes| file("ktx2", bytes) },
    Target { name: "exr", run: |bytes| file("exr", bytes) },
    Target { name: "hdr", run: |bytes| file("hdr", bytes) },
    Target { name: "png", run: |bytes| file("png", bytes) },
    Target { name: "dds", run: |bytes| file("dds", bytes) },
    Target { name: "ktx", run: |bytes| file("ktx", bytes) },
    Target { name: "env", run: |bytes| file("env", bytes) },
    Target { name: "npy", run: |bytes| file("npy", bytes) },
    Target { name: "json", run: |bytes| file("json", bytes) },
    // Six languages that differ in their comments; all see the same bytes.
    Target { name: "source", run: |bytes| ["rs", "c", "h", "js", "ts", "py"].map(|e| file(e, bytes)).contains(&true) },
    Target { name: "picture", run: picture },
    Target { name: "environment", run: environment },
    Target { name: "recipe", run: recipe },
];

/// How many bytes of memory a reader may hold for a byte of the file, on top of [`ALLOWANCE`].
///
/// Deflate makes 1032 bytes of one, Zstandard 32768, runs of RGBE 64. A byte of a texel in a file of ours becomes a float,
/// held beside it; in others' files a byte of a block stands for two texels, which become floats of red, green, blue, alpha
/// and then of red, green, blue. A number of two letters is 32 bytes as JSON.
pub fn multiple(target: &str, bytes: &[u8]) -> usize {
    let is_zstd = bytes.starts_with(b"\xabKTX 20") && bytes.get(44..48) == Some(&[2, 0, 0, 0]);
    let ratio = match target {
        _ if is_zstd => 32768,
        "dds" | "ktx" | "npy" | "source" | "json" | "ktx2" => 1,
        // A number of a list, two letters, is a value with its place, and then a text.
        "recipe" => 8,
        "hdr" => 64,
        _ => 1032,
    };
    ratio * if matches!(target, "json" | "picture" | "environment") { 64 } else { 16 }
}

/// Bytes that a reader may hold whatever the file's size: buffers, tables of colours.
pub const ALLOWANCE: usize = 4 << 20;

/// As `info` and `verify` read a file, up to where they begin to integrate.
fn file(extension: &str, bytes: &[u8]) -> bool {
    let path = Path::new("hostile").with_extension(extension);
    let format = format::named(extension).expect("each target names a format");
    let Ok((texture, encoding)) = format.parse(&path, bytes) else { return false };
    assert!(
        (0..texture.levels.len()).all(|i| texture.levels[i].len() == texture.level_len(i)),
        "a level of another size"
    );
    // Any of these may refuse what the file says of itself.
    let _ = Certificate::texels(&texture, encoding);
    let _ = Steps::of(encoding, &texture.meta);
    let _ = TableJob::from_meta(&texture);
    let _ = VolumeJob::from_meta(&texture);
    let _ = LayersJob::from_meta(&texture);
    let _ = SpecularJob::from_meta(&texture);
    let _ = Atlas::from_meta(&texture);
    let _ = harmonics::stated(&texture.meta);
    let _ = target::snippet(&texture.meta, "hostile");
    true
}

/// As `identify` reads a table of others.
fn picture(bytes: &[u8]) -> bool {
    let read = |layer| Picture::parse(Path::new("hostile"), bytes, layer);
    // A file that holds several is asked for its second.
    let Ok(picture) = read(None).or_else(|_| read(Some(1))) else { return false };
    let _ = picture.texel(picture.width - 1, picture.height - 1);
    true
}

/// As `run` reads a recipe, up to where it looks for files.
fn recipe(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    Recipe::parse(Path::new("hostile"), text).is_ok()
}

/// As `env` reads an environment. The file lies in memory where the system has such a folder.
fn environment(bytes: &[u8]) -> bool {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    let thread = format!("{:?}", std::thread::current().id());
    let number: String = thread.chars().filter(char::is_ascii_digit).collect();
    let path: PathBuf = folder.join(format!("brdf-baker-hostile-{}-{number}", std::process::id()));
    std::fs::write(&path, bytes).expect("the folder is writable");
    let read = import::read(&path, &Options::default(), &mut ignore);
    let _ = std::fs::remove_file(&path);
    read.is_ok()
}
