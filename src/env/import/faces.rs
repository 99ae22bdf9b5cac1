// SPDX-License-Identifier: MIT OR Apache-2.0
//! Six files, one a face.

use std::path::{Path, PathBuf};

use super::{Content, Job, MAX_FACE, Options, decode};
use crate::env::CubeMap;
use crate::error::{Error, Result};
use crate::progress::OnProgress;

/// What the faces are called in messages, and in the first set of file names.
pub const NAMES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];
/// The names that tell faces apart, each in the order +X −X +Y −Y +Z −Z.
const SETS: [[&str; 6]; 4] = [
    NAMES,
    ["posx", "negx", "posy", "negy", "posz", "negz"],
    ["right", "left", "top", "bottom", "front", "back"],
    ["right", "left", "up", "down", "front", "back"],
];
/// Extensions of pictures.
const EXTENSIONS: [&str; 6] = ["hdr", "pic", "exr", "png", "jpg", "jpeg"];
/// Stands for their names in a path.
pub const PLACEHOLDER: &str = "{face}";

/// The six files that an input stands for; `None` where it is one file.
pub fn find(input: &Path) -> Result<Option<[PathBuf; 6]>> {
    let text = input.to_string_lossy();
    if input.is_dir() {
        return in_folder(input).map(Some);
    }
    if input.exists() {
        return Ok(None);
    }
    if text.contains(PLACEHOLDER) {
        let sets = SETS.map(|set| set.map(|name| PathBuf::from(text.replace(PLACEHOLDER, name))));
        return only(input, sets.into_iter().filter(|set| set.iter().all(|path| path.exists())).collect(), "match")
            .map(Some);
    }
    let listed: Vec<PathBuf> = text.split(',').map(PathBuf::from).collect();
    match <[PathBuf; 6]>::try_from(listed) {
        Ok(six) => Ok(Some(six)),
        Err(listed) if listed.len() > 1 && listed.iter().all(|p| p.exists()) => {
            let what = format!("'{text}' names {} files, and a cube has six faces", listed.len());
            Err(Error::usage(what, "list them in the order +X,-X,+Y,-Y,+Z,-Z"))
        }
        Err(_) => Ok(None),
    }
}

fn in_folder(folder: &Path) -> Result<[PathBuf; 6]> {
    let io = |e| Error::io("read", folder, e);
    let mut files = vec![];
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let lower = |text: Option<&std::ffi::OsStr>| text.unwrap_or_default().to_string_lossy().to_lowercase();
        if EXTENSIONS.contains(&lower(path.extension()).as_str()) {
            files.push((lower(path.file_stem()), lower(path.extension()), path));
        }
    }
    let mut found = vec![];
    for set in SETS {
        for extension in EXTENSIONS {
            let file =
                |name: &str| files.iter().find(|(stem, e, _)| stem == name && e == extension).map(|f| f.2.clone());
            let paths: Vec<PathBuf> = set.iter().filter_map(|name| file(name)).collect();
            found.extend(<[PathBuf; 6]>::try_from(paths));
        }
    }
    only(folder, found, "lie in")
}

/// The only set of files, or an error.
fn only(input: &Path, mut sets: Vec<[PathBuf; 6]>, how: &str) -> Result<[PathBuf; 6]> {
    let names: Vec<String> = SETS.iter().map(|set| set.join(" ")).collect();
    let help = format!("faces are called one of: {}; or list six files: +X,-X,+Y,-Y,+Z,-Z", names.join("; "));
    match sets.len() {
        1 => Ok(sets.remove(0)),
        0 => Err(Error::usage(format!("no six faces {how} '{}'", input.display()), help)),
        n => Err(Error::usage(format!("{n} sets of six faces {how} '{}'", input.display()), help)),
    }
}

/// Reads six files as the faces of a cube.
pub fn read(
    paths: &[PathBuf; 6],
    options: &Options,
    notes: &mut Vec<String>,
    on: &mut OnProgress<'_>,
) -> Result<CubeMap> {
    let mut cube = CubeMap { size: 0, texels: vec![] };
    for path in paths {
        let first = cube.size;
        let accept = |width: u32, height: u32| {
            let what = match () {
                () if width == 0 || width != height => format!("it is {width}x{height}, and a face is square"),
                () if width > MAX_FACE => {
                    format!("it is {width}x{height}, and a face of at most {MAX_FACE}x{MAX_FACE} is read")
                }
                () if first > 0 && width != first => {
                    format!("it is {width}x{height}, and '{}' is {first}x{first}", paths[0].display())
                }
                () => return Ok(()),
            };
            Err(Error::input(path, what, "give six square pictures of one size"))
        };
        match decode(&mut Job { path, options, accept: &accept, notes }, on)? {
            Content::Plane(plane) => {
                cube.size = plane.width;
                cube.texels.reserve_exact(plane.texels.len() * 6 - cube.texels.len());
                cube.texels.extend(plane.texels);
            }
            Content::Cube(_) => {
                return Err(Error::input(path, "it holds a whole cube", "give it alone, not as a face"));
            }
        }
    }
    Ok(cube)
}
