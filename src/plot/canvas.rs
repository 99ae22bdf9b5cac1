// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture to draw on: SVG, or PNG by drawing three times as large and averaging.

use std::sync::Once;

use plotters::backend::{BitMapBackend, SVGBackend};
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::Text;
use plotters::style::{BLACK, FontStyle, IntoFont, IntoTextStyle, WHITE, register_font};

use crate::error::{Error, Result};

/// Pixels of the large drawing along a side of a pixel of the PNG.
const OVERSAMPLING: u32 = 3;
/// What the built-in font is called in a drawing, and the viewer's own in an SVG.
pub(super) const FONT: &str = "sans-serif";

/// Size of a picture and how it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Canvas {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// SVG instead of PNG.
    pub vector: bool,
}

/// What can be drawn on either backend. Lengths are in pixels of the drawing: `scale` of them are one of the picture's.
pub(super) trait Draw {
    fn draw<B: plotters::backend::DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        scale: f64,
    ) -> std::result::Result<(), String>;
}

impl Canvas {
    /// The size of a picture of curves, or of a table of some channels.
    pub fn usual(table_channels: Option<usize>, vector: bool) -> Canvas {
        let (width, height) = table_channels.map_or((800, 500), |count| (380 * count as u32, 338));
        Canvas { width, height, vector }
    }

    /// Refuses sizes that hold no plot, or none that a viewer opens.
    pub fn check(&self) -> Result<()> {
        if (200..=8192).contains(&self.width) && (150..=8192).contains(&self.height) {
            return Ok(());
        }
        let what = format!("a plot of {}x{} pixels is not drawn", self.width, self.height);
        Err(Error::usage(what, "use --size from 200x150 to 8192x8192"))
    }

    /// The file's bytes.
    pub(super) fn paint(&self, draw: &impl Draw) -> Result<Vec<u8>> {
        register_fonts();
        self.check()?;
        let failed = |e: String| Error::usage(format!("the plot cannot be drawn: {e}"), "");
        let (width, height) = (self.width, self.height);
        if self.vector {
            let mut text = String::new();
            {
                let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
                draw.draw(&area, 1.0).map_err(failed)?;
                area.present().map_err(|e| failed(e.to_string()))?;
            }
            return Ok(text.into_bytes());
        }
        let n = OVERSAMPLING;
        let mut large = vec![255u8; (3 * n * n * width * height) as usize];
        {
            let area = BitMapBackend::with_buffer(&mut large, (n * width, n * height)).into_drawing_area();
            draw.draw(&area, f64::from(n)).map_err(failed)?;
            area.present().map_err(|e| failed(e.to_string()))?;
        }
        let mut pixels = Vec::with_capacity((3 * width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                for c in 0..3 {
                    let at = |i: u32| (((y * n + i / n) * n * width + x * n + i % n) * 3 + c) as usize;
                    let sum: u32 = (0..n * n).map(|i| u32::from(large[at(i)])).sum();
                    pixels.push(((sum + n * n / 2) / (n * n)) as u8);
                }
            }
        }
        encode_png(&pixels, (width, height))
    }
}

fn register_fonts() {
    static FONTS: Once = Once::new();
    FONTS.call_once(|| {
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).ok().expect("the font is sound");
    });
}

/// A PNG file of 8-bit sRGB pixels, rows from the top.
pub fn encode_png(rgb: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>> {
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(rgb));
    written.map_err(|e| Error::usage(format!("the picture cannot be encoded: {e}"), ""))?;
    Ok(bytes)
}

/// Writes a line of text into 8-bit RGB pixels, its top left corner at `at`: white with a dark edge, `height_px` high.
pub fn write_text(rgb: &mut [u8], size: (u32, u32), at: (i32, i32), height_px: f64, text: &str) -> Result<()> {
    register_fonts();
    let failed = |e: String| Error::usage(format!("the text cannot be drawn: {e}"), "");
    let area = BitMapBackend::with_buffer(rgb, size).into_drawing_area();
    let edges = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|d| (d, BLACK));
    for ((dx, dy), colour) in edges.into_iter().chain([((0, 0), WHITE)]) {
        let style = (FONT, height_px).into_font().into_text_style(&(1, 1)).color(&colour);
        area.draw(&Text::new(text.to_string(), (at.0 + dx, at.1 + dy), style)).map_err(|e| failed(e.to_string()))?;
    }
    area.present().map_err(|e| failed(e.to_string()))
}
