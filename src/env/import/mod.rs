// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reading environments: pictures and cubes from files, as linear radiance.
//!
//! | file | content |
//! |---|---|
//! | `.hdr`, `.pic`, `.exr`, `.png`, `.jpg` | a picture: equirectangular, strip or cross ([`Layout`]), or one face of six |
//! | `.ktx2`, `.dds` | a cube |
//!
//! The content decides, not the extension: the first bytes tell the formats apart. Sizes are checked before anything of
//! that size is allocated. What enters is adjusted on its way ([`Adjust`]): texels that are not finite are refused or
//! repaired, negative ones become 0, and exposure, scale and clamp apply, in this order.

mod adjust;
mod dds;
mod describe;
mod exr;
mod faces;
mod hdr;
mod jpeg_head;
mod ktx2;
mod layout;
mod ldr;
mod packed;
mod watched;

use std::borrow::Cow;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

pub use adjust::{Adjust, Adjusted, Negative};
pub use layout::Layout;
pub use ldr::Color;

use super::{CubeMap, Environment, FileAxes, Frame, Picture};
use crate::error::{Error, Result};
use crate::format::plausible;
use crate::progress::OnProgress;
use watched::Watched;

/// The largest equirectangular picture that is read, in texels.
pub const MAX_EQUIRECT: (u32, u32) = (16384, 8192);
/// The largest face of a cube that is read, in texels.
pub const MAX_FACE: u32 = super::tree::MAX_SIZE;

/// How an environment is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// What lies where in a picture; `None` tells by the aspect ratio.
    pub layout: Option<Layout>,
    /// What integers mean; `None` takes what the file says, and sRGB where it says nothing.
    pub color: Option<Color>,
    /// The part or layer of an OpenEXR file; `None` takes the first with colour.
    pub part: Option<String>,
    /// What is done to texels.
    pub adjust: Adjust,
    /// Mirrors the environment, x becoming −x, before it is turned.
    pub mirror: bool,
    /// Turns about the X, the Y and the Z axis, in this order, in degrees: [`Frame::new`].
    pub turns_deg: [f64; 3],
    /// The axes of the file that is made from the environment.
    pub file_axes: FileAxes,
}

/// An environment from a file, and what had to be done to it.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The environment.
    pub environment: Environment<'static>,
    /// How the file was understood: a layout's name, `faces` or `cube`.
    pub layout: &'static str,
    /// What was done to texels.
    pub adjusted: Adjusted,
    /// Sentences about the file that its user should know.
    pub notes: Vec<String>,
}

/// Texels in rows from the top.
struct Plane {
    width: u32,
    height: u32,
    texels: Vec<[f32; 3]>,
}

/// What one file holds.
enum Content {
    Plane(Plane),
    Cube(CubeMap),
}

/// What every decoder is told, and where it leaves its notes.
struct Job<'a> {
    path: &'a Path,
    options: &'a Options,
    /// Refuses a picture of this width and height.
    accept: &'a dyn Fn(u32, u32) -> Result<()>,
    notes: &'a mut Vec<String>,
}

impl Job<'_> {
    /// Refuses a picture that a file of this size cannot hold, before memory is taken for it. `bytes` are those of the
    /// picture as the file's format holds it; `best_ratio` is what the format makes of a byte at best.
    fn plausible(&self, bytes: u64, file_bytes: u64, best_ratio: u64) -> Result<()> {
        plausible(self.path, Some(bytes), file_bytes, best_ratio)
    }

    /// Refuses a colour encoding for a file that holds floats.
    fn refuse_color(&self) -> Result<()> {
        match self.options.color {
            None => Ok(()),
            Some(color) => {
                let what = format!("--color {} does not go with '{}'", color.name(), self.path.display());
                Err(Error::usage(what, "leave it out: the file holds floats, which are linear"))
            }
        }
    }

    /// A file whose content is damaged, or cut short.
    fn damaged(&self, format: &str, why: impl std::fmt::Display) -> Error {
        let what = format!("as {format} it is damaged or cut short: {why}");
        Error::input(self.path, what, "fetch or export it again")
    }
}

/// Reads an environment. `input` is
///
/// - a file;
/// - a folder that holds six faces, named `px nx py ny pz nz`, `posx negx …` or `right left top bottom front back`;
/// - a path with `{face}` in it, which stands for those names;
/// - six paths joined by commas, in the order +X −X +Y −Y +Z −Z.
///
/// A file that is missing or unreadable is [`Error::Io`]; anything wrong with its content is [`Error::Input`].
pub fn read(input: &Path, options: &Options, on: &mut OnProgress<'_>) -> Result<Imported> {
    options.adjust.check()?;
    let mut notes = vec![];
    let (mut picture, layout, place): (_, _, Box<dyn Fn(usize) -> String>) = match faces::find(input)? {
        Some(paths) => {
            if let Some(layout) = options.layout {
                let what = format!("--layout {} does not go with six files", layout.name());
                return Err(Error::usage(what, "leave it out: each file is one face"));
            }
            let cube = faces::read(&paths, options, &mut notes, on)?;
            let size = cube.size as usize;
            let place = move |i: usize| {
                let (name, at) = (&paths[i / (size * size)], i % (size * size));
                format!("column {}, row {} of '{}'", at % size, at / size, name.display())
            };
            (Picture::Cube(Cow::Owned(cube)), "faces", Box::new(place))
        }
        None => {
            let accept = |width, height| Layout::choose(input, options.layout, width, height).map(|_| ());
            match decode(&mut Job { path: input, options, accept: &accept, notes: &mut notes }, on)? {
                Content::Plane(plane) => {
                    let layout = Layout::choose(input, options.layout, plane.width, plane.height)?;
                    let width = plane.width as usize;
                    let size = layout.face(plane.width, plane.height);
                    let place = move |i: usize| {
                        let [x, y] = size.map_or([i % width, i / width], |size| layout.position(size, i));
                        format!("column {x}, row {y}")
                    };
                    (layout.picture(plane), layout.name(), Box::new(place))
                }
                Content::Cube(cube) => {
                    if let Some(layout) = options.layout {
                        let what = format!("--layout {} does not go with a file that holds a cube", layout.name());
                        return Err(Error::usage(what, "leave it out: the file says where its faces are"));
                    }
                    let size = cube.size as usize;
                    let place = move |i: usize| {
                        let (face, at) = (faces::NAMES[i / (size * size)], i % (size * size));
                        format!("column {}, row {} of face {face}", at % size, at / size)
                    };
                    (Picture::Cube(Cow::Owned(cube)), "cube", Box::new(place))
                }
            }
        }
    };
    let adjusted = adjust::adjust(input, &mut picture, &options.adjust, &*place)?;
    let frame = Frame::new(options.mirror, options.turns_deg).for_file(&options.file_axes);
    Ok(Imported { environment: Environment { picture, frame }, layout, adjusted, notes })
}

/// The files that an input of [`read`] stands for: one, or six in the order +X −X +Y −Y +Z −Z.
pub fn files(input: &Path) -> Result<Vec<PathBuf>> {
    Ok(faces::find(input)?.map_or_else(|| vec![input.to_path_buf()], Vec::from))
}

/// What an input is called: its name without extension and without the place of the faces, `yard` of `yard_{face}.png`.
pub fn stem(input: &Path) -> String {
    let stem = input.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = stem.replace(faces::PLACEHOLDER, "");
    let stem = stem.trim_end_matches(['_', '-', '.']);
    if stem.is_empty() { "environment".into() } else { stem.into() }
}

/// The first bytes of an OpenEXR file.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Decodes one file.
fn decode(job: &mut Job<'_>, on: &mut OnProgress<'_>) -> Result<Content> {
    let mut file = Watched::open(job.path, on)?;
    let state = file.state();
    let mut magic = Vec::with_capacity(12);
    file.by_ref()
        .take(12)
        .read_to_end(&mut magic)
        .and_then(|_| file.rewind())
        .map_err(|e| state.explain(job.path, e))?;
    if job.options.part.is_some() && !magic.starts_with(&EXR) {
        let what = format!("--part does not go with '{}'", job.path.display());
        return Err(Error::usage(what, "leave it out: only OpenEXR files have parts and layers"));
    }
    let decoded = match magic.as_slice() {
        [a, b, c, d, ..] if [*a, *b, *c, *d] == EXR => exr::read(job, file).map(Content::Plane),
        [b'#', b'?', ..] => hdr::read(job, file).map(Content::Plane),
        [0x89, b'P', b'N', b'G', ..] => ldr::read_png(job, file).map(Content::Plane),
        [0xff, 0xd8, 0xff, ..] => ldr::read_jpeg(job, file).map(Content::Plane),
        [0xab, b'K', b'T', b'X', b' ', b'2', ..] => ktx2::read(job, file).map(Content::Cube),
        [b'D', b'D', b'S', b' ', ..] => dds::read(job, file).map(Content::Cube),
        _ => {
            let what = if magic.is_empty() { "it is empty" } else { "it is not in a format that is read here" };
            Err(Error::input(job.path, what, "give a .hdr, .exr, .png, .jpg, .ktx2 or .dds file"))
        }
    };
    // Decoders see a cancelled read as a failed one, and a file that someone writes as a damaged one.
    if state.is_cancelled() {
        return Err(Error::Cancelled);
    }
    state.check(job.path)?;
    decoded
}
