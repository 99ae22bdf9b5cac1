// SPDX-License-Identifier: MIT OR Apache-2.0
//! Radiance HDR.

use std::io::BufReader;

use image::{ImageDecoder, ImageError};

use super::watched::Watched;
use super::{Job, Plane};
use crate::error::{Error, Result};
use crate::format::DEFLATE_RATIO;

pub fn read(job: &Job<'_>, file: Watched<'_, '_>) -> Result<Plane> {
    job.refuse_color()?;
    let refuse = |e: ImageError| match e {
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Error::input(job.path, "it is cut short", "fetch or export it again")
        }
        ImageError::IoError(e) => Error::io("read", job.path, e),
        e => job.damaged("Radiance HDR", e),
    };
    let length = file.length();
    let decoder = image::codecs::hdr::HdrDecoder::new(BufReader::with_capacity(1 << 16, file)).map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    (job.accept)(width, height)?;
    // Runs of today make 64 bytes of one. Those of 1991 make more of a row of one colour, and less than this of anything that
    // lights a scene.
    job.plausible(4 * u64::from(width) * u64::from(height), length, DEFLATE_RATIO)?;
    let mut texels = vec![[0f32; 3]; width as usize * height as usize];
    decoder.read_image(bytemuck::cast_slice_mut(&mut texels)).map_err(refuse)?;
    Ok(Plane { width, height, texels })
}
