// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures on spheres: base colour, metallic, roughness and normal by texture, as glTF 2.0 (section 3.9) means them.
//!
//! u = ½ + atan2(x, z)/2π runs eastwards, from the back of a sphere around its right-hand side; v = acos(y)/π from its top
//! to its bottom. The tangent points east, along +u; the bitangent north, along −v: green up. A texture multiplies the
//! sphere's own value.

use std::f64::consts::PI;
use std::path::Path;

use image::DynamicImage;

use crate::error::{Error, Result};

/// What a file holds for the spheres.
#[derive(Clone, Copy, Debug, Default)]
pub struct Files<'a> {
    /// Base colour, sRGB.
    pub base_color: Option<&'a Path>,
    /// Metallic, linear: the only channel, or blue.
    pub metallic: Option<&'a Path>,
    /// Perceptual roughness, linear: the only channel, or green.
    pub roughness: Option<&'a Path>,
    /// Normal in tangent space, linear: (r, g, b) · 2 − 1.
    pub normal: Option<&'a Path>,
}

/// Textures of one size: base colour and metallic, normal and roughness.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// Texels along u; 0 for no textures.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    /// Two values a texel, rows from the top.
    pub(super) texels: Vec<[[f32; 4]; 2]>,
    /// The roughness differs from place to place.
    pub(super) vary_roughness: bool,
}

/// A picture of linear values, four channels.
struct Plane {
    width: u32,
    height: u32,
    texels: Vec<[f32; 4]>,
}

impl Pictures {
    /// Reads what is given, made small enough that a texel is about half a pixel on a sphere of `radius_px`.
    pub fn read(files: &Files<'_>, radius_px: f64) -> Result<Pictures> {
        let most = (4.0 * PI * radius_px).ceil().max(16.0) as u32;
        let read = |path: Option<&Path>, srgb: bool| path.map(|p| Plane::read(p, srgb, most)).transpose();
        let base = read(files.base_color, true)?;
        let metallic = read(files.metallic, false)?;
        let roughness = read(files.roughness, false)?;
        let normal = read(files.normal, false)?;
        let planes = [&base, &metallic, &roughness, &normal];
        let size = |of: fn(&Plane) -> u32| planes.iter().filter_map(|p| p.as_ref().map(of)).max().unwrap_or(0);
        let (width, height) = (size(|p| p.width), size(|p| p.height));
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let at = |plane: &Option<Plane>| plane.as_ref().map(|p| p.at(x, y, width, height));
                let [r, g, b, _] = at(&base).unwrap_or([1.0; 4]);
                let metallic = at(&metallic).map_or(1.0, |t| t[2]);
                let roughness = at(&roughness).map_or(1.0, |t| t[1]);
                let [nx, ny, nz, _] = at(&normal).map_or([0.0, 0.0, 1.0, 0.0], |t| t.map(|v| 2.0 * v - 1.0));
                texels.push([[r, g, b, metallic], [nx, ny, nz.max(1e-3), roughness]]);
            }
        }
        Ok(Pictures { width, height, texels, vary_roughness: roughness.is_some() })
    }
}

impl Plane {
    fn read(path: &Path, srgb: bool, most: u32) -> Result<Plane> {
        let reader = image::ImageReader::open(path).map_err(|e| Error::io("read", path, e))?;
        let reader = reader.with_guessed_format().map_err(|e| Error::io("read", path, e))?;
        let decoded =
            reader.decode().map_err(|e| Error::input(path, e.to_string(), "give a .png, .jpg or .hdr file"))?;
        if decoded.width() > 16384 || decoded.height() > 16384 {
            let what = format!("a texture of {}x{} texels is not read", decoded.width(), decoded.height());
            return Err(Error::input(path, what, "make it at most 16384x16384"));
        }
        // Floats are linear already.
        let encoded = !matches!(decoded, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
        let grey = !decoded.color().has_color();
        let pixels = decoded.to_rgba32f();
        let texels = pixels.pixels().map(|p| {
            let [r, g, b, a] = p.0;
            // A grey picture has one channel, whichever is asked for.
            let rgb = if grey { [r; 3] } else { [r, g, b] };
            let [r, g, b] = if srgb && encoded { rgb.map(decode) } else { rgb };
            [r, g, b, a]
        });
        let mut plane = Plane { width: pixels.width(), height: pixels.height(), texels: texels.collect() };
        while plane.width > most && plane.width.is_multiple_of(2) && plane.height.is_multiple_of(2) {
            plane = plane.halved();
        }
        Ok(plane)
    }

    fn halved(&self) -> Plane {
        let (width, height) = (self.width / 2, self.height / 2);
        let texel = |x: u32, y: u32| self.texels[(y * self.width + x) as usize];
        let mean = |i: u32| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            let four = [texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)];
            std::array::from_fn(|c| four.iter().map(|t| 0.25 * t[c]).sum())
        };
        Plane { width, height, texels: (0..width * height).map(mean).collect() }
    }

    /// The value at texel (x, y) of a picture of another size: bilinear, repeating along x.
    fn at(&self, x: u32, y: u32, width: u32, height: u32) -> [f32; 4] {
        let place = |i: u32, n: u32, own: u32| (f64::from(i) + 0.5) / f64::from(n) * f64::from(own) - 0.5;
        let (px, py) = (place(x, width, self.width), place(y, height, self.height));
        let (x0, y0) = (px.floor(), py.floor());
        let (fx, fy) = ((px - x0) as f32, (py - y0) as f32);
        let tap = |dx: i64, dy: i64| {
            let x = (x0 as i64 + dx).rem_euclid(i64::from(self.width)) as usize;
            let y = (y0 as i64 + dy).clamp(0, i64::from(self.height) - 1) as usize;
            self.texels[y * self.width as usize + x]
        };
        let four = [tap(0, 0), tap(1, 0), tap(0, 1), tap(1, 1)];
        let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
        std::array::from_fn(|c| four.iter().zip(weights).map(|(t, w)| w * t[c]).sum())
    }
}

/// The linear value of an encoded one. IEC 61966-2-1:1999.
fn decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_those_of_gltf() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        image::RgbImage::from_fn(4, 2, |x, _| image::Rgb([188, 64 * x as u8, 0])).save(at("orm.png")).expect("saved");
        image::GrayImage::from_pixel(2, 2, image::Luma([128])).save(at("grey.png")).expect("saved");
        let (orm, grey) = (at("orm.png"), at("grey.png"));
        let files = Files { base_color: Some(&orm), metallic: Some(&grey), roughness: Some(&orm), normal: None };
        let pictures = Pictures::read(&files, 100.0).expect("read");
        assert_eq!((pictures.width, pictures.height), (4, 2));
        let [[r, ..], _] = pictures.texels[0];
        assert!((r - 0.503).abs() < 1e-3, "sRGB is decoded: {r}");
        for x in 0..4 {
            let [[.., metallic], [nx, ny, nz, roughness]] = pictures.texels[x];
            assert!((metallic - 0.502).abs() < 1e-3 && (roughness - 64.0 * x as f32 / 255.0).abs() < 1e-6);
            assert_eq!([nx, ny, nz], [0.0, 0.0, 1.0]);
        }
        assert!(pictures.vary_roughness);
        // Large pictures are made small.
        image::RgbImage::from_pixel(1024, 512, image::Rgb([9; 3])).save(at("large.png")).expect("saved");
        let large = at("large.png");
        let files = Files { base_color: Some(&large), ..Default::default() };
        assert_eq!(Pictures::read(&files, 10.0).expect("read").width, 64);
        let missing = at("missing.png");
        let files = Files { normal: Some(&missing), ..Default::default() };
        assert!(Pictures::read(&files, 10.0).is_err());
    }
}
