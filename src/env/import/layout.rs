// SPDX-License-Identifier: MIT OR Apache-2.0
//! What lies where in a picture. Every face keeps the axes of [`crate::term::cube`]: neighbours in a cross continue each
//! other. Crosses are those of HDRShop and cmft:
//!
//! ```text
//! cross, 4:3          vertical-cross, 3:4    strip, 6:1             vertical-strip, 1:6
//!      +Y                  +Y                +X -X +Y -Y +Z -Z      +X
//!   -X +Z +X -Z         -X +Z +X                                    -X
//!      -Y                  -Y                                       …
//!                          -Z (turned by 180°)                      -Z
//! ```

use std::borrow::Cow;
use std::path::Path;

use rayon::prelude::*;

use super::{MAX_EQUIRECT, MAX_FACE, Plane};
use crate::env::{CubeMap, Equirect, Picture};
use crate::error::{Error, Result, nearest};

/// How a picture holds an environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Longitude to the right, latitude downwards.
    Equirect,
    /// Six faces side by side.
    Strip,
    /// Six faces below each other.
    VerticalStrip,
    /// A cross that lies.
    Cross,
    /// A cross that stands.
    VerticalCross,
}

use Layout::{Cross, Equirect as Panorama, Strip, VerticalCross, VerticalStrip};

impl Layout {
    /// All layouts, in the order of their documentation.
    pub const ALL: [Layout; 5] = [Panorama, Strip, VerticalStrip, Cross, VerticalCross];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Panorama => "equirect",
            Strip => "strip",
            VerticalStrip => "vertical-strip",
            Cross => "cross",
            VerticalCross => "vertical-cross",
        }
    }

    /// The layout with this name.
    pub fn parse(name: &str) -> Result<Self> {
        let known = || Self::ALL.iter().map(|l| l.name());
        Self::ALL
            .into_iter()
            .find(|l| l.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown layout '{name}'"), nearest(name, known())))
    }

    /// Width to height.
    fn aspect(self) -> [u32; 2] {
        match self {
            Panorama => [2, 1],
            Strip => [6, 1],
            VerticalStrip => [1, 6],
            Cross => [4, 3],
            VerticalCross => [3, 4],
        }
    }

    /// The layout of a picture, `wanted` or the one with its aspect ratio; an error where its size is not that.
    pub fn choose(path: &Path, wanted: Option<Layout>, width: u32, height: u32) -> Result<Layout> {
        let fits = |layout: &Layout| {
            let [across, down] = layout.aspect();
            width > 0
                && u64::from(width) * u64::from(down) == u64::from(height) * u64::from(across)
                && width.is_multiple_of(across)
        };
        let size = format!("it is {width}x{height}");
        let Some(layout) = wanted.or_else(|| Self::ALL.into_iter().find(fits)) else {
            let list: Vec<String> =
                Self::ALL.iter().map(|l| format!("{} {}:{}", l.name(), l.aspect()[0], l.aspect()[1])).collect();
            let help = format!("layouts and their aspect ratios are: {}; six files are six faces", list.join(", "));
            return Err(Error::input(path, format!("{size}, which is no layout's aspect ratio"), help));
        };
        if !fits(&layout) {
            let [across, down] = layout.aspect();
            let what = format!("{size}, and the layout {} has the aspect ratio {across}:{down}", layout.name());
            return Err(Error::input(path, what, "give another --layout, or none to tell it by the aspect ratio"));
        }
        let most = if layout == Panorama {
            MAX_EQUIRECT
        } else {
            (layout.aspect()[0] * MAX_FACE, layout.aspect()[1] * MAX_FACE)
        };
        if width > most.0 || height > most.1 {
            let what = format!("{size}, and at most {}x{} is read as {}", most.0, most.1, layout.name());
            let help = "scale it down first, e.g. `oiiotool in.exr --resize 50% -o out.exr`";
            return Err(Error::input(path, what, help));
        }
        Ok(layout)
    }

    /// Texels along a side of a face; `None` for a panorama.
    pub(super) fn face(self, width: u32, height: u32) -> Option<usize> {
        (self != Panorama).then(|| (width / self.aspect()[0]).min(height) as usize)
    }

    /// Column and row of face `face`, in faces.
    fn cell(self, face: usize) -> [usize; 2] {
        match self {
            Strip => [face, 0],
            VerticalStrip | Panorama => [0, face],
            Cross => [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]][face],
            VerticalCross => [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]][face],
        }
    }

    /// Column and row, in the picture, of texel `index` of the cube whose faces have `size` texels along a side.
    pub(super) fn position(self, size: usize, index: usize) -> [usize; 2] {
        let (face, x, y) = (index / (size * size), index % size, index / size % size);
        let [column, row] = self.cell(face);
        // The last face of a standing cross is upside down.
        let [x, y] = if self == VerticalCross && face == 5 { [size - 1 - x, size - 1 - y] } else { [x, y] };
        [column * size + x, row * size + y]
    }

    /// The picture, its faces cut out where it has any.
    pub(super) fn picture(self, plane: Plane) -> Picture<'static> {
        let Plane { width, height, texels } = plane;
        let Some(size) = self.face(width, height) else {
            return Picture::Equirect(Cow::Owned(Equirect { width, height, texels }));
        };
        // Faces below each other are a cube already.
        let texels = if self == VerticalStrip {
            texels
        } else {
            let mut faces = vec![[0f32; 3]; 6 * size * size];
            faces.par_chunks_mut(size).enumerate().for_each(|(row, out)| {
                for (x, texel) in out.iter_mut().enumerate() {
                    let [column, row] = self.position(size, row * size + x);
                    *texel = texels[row * width as usize + column];
                }
            });
            faces
        };
        Picture::Cube(Cow::Owned(CubeMap { size: size as u32, texels }))
    }
}
