// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws a split-sum table and the mips of a prefiltered cube as one PNG.
//!
//! `cargo run --release --example contact_sheet -- dfg.ktx2 environment.ktx2 picture.png`
//!
//! Left: the table, n·v to the right, row 0 (smooth) on top, scale in red and bias in green. Right: the first eight mips,
//! smooth to rough, each unrolled as an equirectangular picture that looks along +X at its centre.

use std::path::Path;

use brdf_baker::env::orientation::locate;
use brdf_baker::error::{Error, Result};
use brdf_baker::format;
use brdf_baker::term::cube::direction;
use brdf_baker::texture::{Shape, Texture};

const PANEL: (u32, u32) = (384, 192);
const GAP: u32 = 8;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [table, cube, picture] = arguments.as_slice() else {
        eprintln!("usage: contact_sheet TABLE CUBE PICTURE.png");
        std::process::exit(2);
    };
    if let Err(error) = draw(Path::new(table), Path::new(cube), Path::new(picture)) {
        eprintln!("error: {error}\n  help: {}", error.help());
        std::process::exit(i32::from(error.exit_code()));
    }
}

fn draw(table: &Path, cube: &Path, picture: &Path) -> Result<()> {
    let (table, _) = format::for_path(table)?.read(table)?;
    let (cube, _) = format::for_path(cube)?.read(cube)?;
    let side = 2 * PANEL.1 + GAP;
    let mut canvas = Canvas::new(side + 2 * (PANEL.0 + GAP) + 2 * (PANEL.0 + GAP), side);

    canvas.fill(0, 0, side, side, |u, v| {
        let texel = table.texel(0, 0, (u * f64::from(table.width)) as u32, (v * f64::from(table.height)) as u32);
        [texel[0], texel.get(1).copied().unwrap_or(0.0), 0.0]
    });
    let exposure = 0.5 / mean(&cube).max(1e-6);
    for mip in 0..cube.levels.len().min(8) {
        let (column, row) = (mip as u32 % 4, mip as u32 / 4);
        let (x, y) = (side + GAP + column * (PANEL.0 + GAP), row * (PANEL.1 + GAP));
        canvas.fill(x, y, PANEL.0, PANEL.1, |u, v| {
            let (sin_phi, cos_phi) = (std::f64::consts::TAU * (u - 0.5)).sin_cos();
            let (sin_theta, cos_theta) = (std::f64::consts::PI * v).sin_cos();
            let radiance = sample(&cube, mip, [cos_phi * sin_theta, cos_theta, sin_phi * sin_theta]);
            // Reinhard's curve keeps a sun from burning out the picture.
            radiance.map(|c| c * exposure / (1.0 + c * exposure))
        });
    }
    canvas.save(picture)
}

/// Mean of the roughest mip: the exposure of the picture.
fn mean(cube: &Texture) -> f32 {
    let last = cube.levels.last().expect("a cube has a level");
    last.iter().sum::<f32>() / last.len() as f32
}

/// Bilinear value of a mip in a direction, across the seams as a GPU's seamless cube sampler reads it.
fn sample(cube: &Texture, mip: usize, d: [f64; 3]) -> [f32; 3] {
    assert_eq!(cube.shape, Shape::Cube);
    let (size, _) = cube.level_size(mip);
    let (face, s, t) = locate(d);
    let place = |c: f64| 0.5 * (c + 1.0) * f64::from(size) - 0.5;
    let (x, y) = (place(s), place(t));
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
    // A tap beyond the face's edge is read from the face that its direction meets.
    let tap = |x: f64, y: f64| {
        let centre = |c: f64| 2.0 * (c + 0.5) / f64::from(size) - 1.0;
        let (face, s, t) = locate(direction(face, centre(x), centre(y)));
        let nearest = |c: f64| (place(c) + 0.5).clamp(0.0, f64::from(size - 1)) as u32;
        cube.texel(mip, face, nearest(s), nearest(t))
    };
    let taps = [tap(x0, y0), tap(x0 + 1.0, y0), tap(x0, y0 + 1.0), tap(x0 + 1.0, y0 + 1.0)];
    let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
    std::array::from_fn(|c| taps.iter().zip(weights).map(|(tap, w)| w * tap[c]).sum())
}

/// An sRGB picture.
struct Canvas {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
}

impl Canvas {
    fn new(width: u32, height: u32) -> Canvas {
        Canvas { width, height, bytes: vec![24; (width * height * 3) as usize] }
    }

    /// Fills a rectangle with linear colours in [0, 1]; (u, v) run over it from its top left.
    fn fill(&mut self, x0: u32, y0: u32, width: u32, height: u32, colour: impl Fn(f64, f64) -> [f32; 3]) {
        for y in 0..height {
            for x in 0..width {
                let place = ((f64::from(x) + 0.5) / f64::from(width), (f64::from(y) + 0.5) / f64::from(height));
                let at = (((y0 + y) * self.width + x0 + x) * 3) as usize;
                let encoded = colour(place.0, place.1).map(|c| (255.0 * srgb(c) + 0.5) as u8);
                self.bytes[at..at + 3].copy_from_slice(&encoded);
            }
        }
    }

    fn save(&self, path: &Path) -> Result<()> {
        let file = std::fs::File::create(path).map_err(|e| Error::io("write", path, e))?;
        let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&self.bytes));
        written.map_err(|e| Error::input(path, e.to_string(), ""))
    }
}

/// IEC 61966-2-1.
fn srgb(linear: f32) -> f32 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}
