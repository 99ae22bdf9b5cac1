// SPDX-License-Identifier: MIT OR Apache-2.0
//! PNG and JPEG: 8 or 16 bits a channel, as sRGB unless told otherwise. Alpha does not count.

use std::io::{BufReader, Cursor, Read, Seek};

use image::codecs::{jpeg::JpegDecoder, png::PngDecoder};
use image::{DynamicImage, ImageDecoder, ImageError};
use png::DecodingError;
use rayon::prelude::*;

use super::watched::Watched;
use super::{Job, Plane, jpeg_head};
use crate::error::{Error, Result, nearest};
use crate::format::{DEFLATE_RATIO, torn_palette};

/// What the integers of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Color {
    /// IEC 61966-2-1: what displays show.
    Srgb,
    /// Shares of 1.
    Linear,
}

impl Color {
    /// All of them, in the order of their documentation.
    pub const ALL: [Color; 2] = [Color::Srgb, Color::Linear];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Color::Srgb => "srgb",
            Color::Linear => "linear",
        }
    }

    /// The one with this name.
    pub fn parse(name: &str) -> Result<Self> {
        let known = || Self::ALL.iter().map(|c| c.name());
        Self::ALL
            .into_iter()
            .find(|c| c.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown colour encoding '{name}'"), nearest(name, known())))
    }

    /// Linear values of the integers from 0 to `largest`.
    pub fn table(self, largest: u16) -> Vec<f32> {
        let linear = |code: u16| {
            let x = f64::from(code) / f64::from(largest);
            match self {
                Color::Linear => x,
                Color::Srgb if x <= 0.04045 => x / 12.92,
                Color::Srgb => ((x + 0.055) / 1.055).powf(2.4),
            }
        };
        (0..=largest).map(|code| linear(code) as f32).collect()
    }
}

pub fn read_png(job: &Job<'_>, file: Watched<'_, '_>) -> Result<Plane> {
    let length = file.length();
    let mut file = BufReader::with_capacity(1 << 16, file);
    match png::Decoder::new(&mut file).read_info().map(|picture| torn_palette(picture.info())) {
        Ok(Some(what)) => return Err(job.damaged("PNG", what)),
        Err(DecodingError::IoError(e)) => return Err(refuse(job, "PNG", ImageError::IoError(e))),
        // What else is wrong the next decoder finds, too.
        Ok(None) | Err(_) => file.rewind().map_err(|e| Error::io("read", job.path, e))?,
    }
    let decoder = PngDecoder::new(file).map_err(|e| refuse(job, "PNG", e))?;
    read(job, "PNG", decoder, length)
}

pub fn read_jpeg(job: &Job<'_>, mut file: Watched<'_, '_>) -> Result<Plane> {
    // The decoder forgives a scan that ends too early and makes the rest up. A whole file ends its last scan (ff da) with a
    // mark (ff d9); inside a scan neither pair occurs.
    let state = file.state();
    let mut bytes = vec![];
    file.read_to_end(&mut bytes).map_err(|e| state.explain(job.path, e))?;
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    if last(0xda).is_none_or(|scan| last(0xd9).is_none_or(|end| end < scan)) {
        return Err(job.damaged("JPEG", "its end is missing"));
    }
    if let Some(why) = jpeg_head::refusal(&bytes) {
        let help = "save it again with a common sampling, e.g. `magick in.jpg -sampling-factor 4:2:0 out.jpg`";
        return Err(Error::input(job.path, format!("this JPEG is not read here: {why}"), help));
    }
    let length = bytes.len() as u64;
    let decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(|e| refuse(job, "JPEG", e))?;
    read(job, "JPEG", decoder, length)
}

fn refuse(job: &Job<'_>, format: &str, error: ImageError) -> Error {
    match error {
        ImageError::IoError(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => Error::io("read", job.path, e),
        ImageError::Unsupported(e) => {
            let help = "convert it, e.g. `magick in.png -depth 16 out.png`";
            Error::input(job.path, format!("this kind of {format} is not read here: {e}"), help)
        }
        e => job.damaged(format, e),
    }
}

fn read(job: &Job<'_>, format: &str, decoder: impl ImageDecoder, file_bytes: u64) -> Result<Plane> {
    let (width, height) = decoder.dimensions();
    (job.accept)(width, height)?;
    // JPEG makes less of a byte: each of its blocks, 192 bytes of colour, takes two bits or more.
    job.plausible(decoder.total_bytes(), file_bytes, DEFLATE_RATIO)?;
    let is_deep = decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count() == 2;
    let image = DynamicImage::from_decoder(decoder).map_err(|e| refuse(job, format, e))?;
    let color = job.options.color.unwrap_or(Color::Srgb);
    let texels = if is_deep {
        let table = color.table(u16::MAX);
        let codes = image.into_rgb16();
        codes.as_raw().par_chunks_exact(3).map(|c| [0, 1, 2].map(|i| table[usize::from(c[i])])).collect()
    } else {
        let table = color.table(u16::from(u8::MAX));
        let codes = image.into_rgb8();
        codes.as_raw().par_chunks_exact(3).map(|c| [0, 1, 2].map(|i| table[usize::from(c[i])])).collect()
    };
    Ok(Plane { width, height, texels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_is_that_of_the_standard() {
        let table = Color::Srgb.table(255);
        assert_eq!((table[0], table[255]), (0.0, 1.0));
        // IEC 61966-2-1: code 188 is half of the light, 10 is on the straight part.
        assert!((table[188] - 0.502_886).abs() < 1e-6, "{}", table[188]);
        assert!((table[10] - 10.0 / 255.0 / 12.92).abs() < 1e-9);
        assert_eq!(Color::Linear.table(65535)[13107], 0.2);
    }
}
