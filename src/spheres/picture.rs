// SPDX-License-Identifier: MIT OR Apache-2.0
//! What was drawn: linear radiance, how it becomes a picture to look at, and how two of them differ.

use rayon::prelude::*;
use serde::Serialize;

use super::scene::Scene;
use crate::error::{Error, Result, nearest};
use crate::material::srgb;

/// Pixels of linear radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue, and the share of the pixel that spheres cover; rows from the top.
    pub pixels: Vec<[f32; 4]>,
}

/// How radiance becomes a colour on a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// A fit to the ACES reference rendering: Narkowicz 2016, "ACES Filmic Tone Mapping Curve".
    Aces,
    /// Cut off at 1.
    Clip,
}

impl Tone {
    /// All curves, in the order of their documentation.
    pub const ALL: [Tone; 2] = [Tone::Aces, Tone::Clip];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Tone::Aces => "aces",
            Tone::Clip => "clip",
        }
    }

    /// The curve with this name.
    pub fn parse(name: &str) -> Result<Tone> {
        Self::ALL.into_iter().find(|t| t.name() == name).ok_or_else(|| {
            Error::usage(format!("unknown tone curve '{name}'"), nearest(name, Self::ALL.map(Tone::name)))
        })
    }

    /// The curve. Domain: x ≥ 0; result in [0, 1].
    pub fn apply(self, x: f64) -> f64 {
        match self {
            Tone::Aces => (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0),
            Tone::Clip => x.clamp(0.0, 1.0),
        }
    }
}

/// How a sphere differs from its reference.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Difference {
    /// Pixels that were compared.
    pub pixels: u32,
    /// Root of the mean square of the difference over that of the reference.
    pub rms: f64,
    /// Mean of the difference over the reference's mean.
    pub bias: f64,
}

/// Least n·v of pixels that are compared: at the rim a pixel sees all of the lobe's widest part.
const LEAST_N_DOT_V: f64 = 0.1;

impl Picture {
    /// The factor that shows a mean radiance as a middle grey, 0.18 after the curve's own darkening of it.
    pub fn auto_exposure(mean: [f64; 3]) -> f64 {
        let luminance = 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2];
        if luminance > 0.0 { 0.3 / luminance } else { 1.0 }
    }

    /// 8-bit sRGB, rows from the top.
    pub fn to_srgb(&self, exposure: f64, tone: Tone) -> Vec<u8> {
        let colour = |pixel: &[f32; 4]| {
            [pixel[0], pixel[1], pixel[2]].map(|v| srgb::encode_8_bit(tone.apply(exposure * f64::from(v))))
        };
        self.pixels.par_iter().flat_map_iter(colour).collect()
    }

    /// How every sphere of the scene differs from `reference`, over the pixels that show nothing else.
    pub fn differences(&self, reference: &Picture, scene: &Scene) -> Vec<Difference> {
        let mut sums = vec![(0u32, 0.0, 0.0, 0.0, 0.0); scene.spheres.len()];
        for y in 0..self.height {
            for x in 0..self.width {
                let Some(sphere) = scene.inside(x, y, LEAST_N_DOT_V) else { continue };
                let index = (y * self.width + x) as usize;
                let (count, squares, of_squares, difference, whole) = &mut sums[sphere];
                *count += 1;
                for c in 0..3 {
                    let (a, b) = (f64::from(self.pixels[index][c]), f64::from(reference.pixels[index][c]));
                    *squares += (a - b) * (a - b);
                    *of_squares += b * b;
                    *difference += a - b;
                    *whole += b;
                }
            }
        }
        let of = |(pixels, squares, of_squares, difference, whole): (u32, f64, f64, f64, f64)| Difference {
            pixels,
            rms: (squares / of_squares).sqrt(),
            bias: difference / whole,
        };
        sums.into_iter().map(of).collect()
    }

    /// 8-bit sRGB of the difference from `reference`, `gain` times: orange where this picture is brighter, blue where it is
    /// darker, black where they agree.
    pub fn difference_srgb(&self, reference: &Picture, exposure: f64, gain: f64) -> Vec<u8> {
        let colour = |(a, b): (&[f32; 4], &[f32; 4])| {
            let luminance =
                |p: &[f32; 4]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
            let d = gain * exposure * (luminance(a) - luminance(b));
            let colour = if d > 0.0 { [1.0, 0.45, 0.1] } else { [0.1, 0.45, 1.0] };
            colour.map(|c: f64| srgb::encode_8_bit((c * d.abs()).min(1.0)))
        };
        self.pixels.par_iter().zip(&reference.pixels).flat_map_iter(colour).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spheres::scene::Sphere;

    #[test]
    fn curves_run_from_black_to_white() {
        for tone in Tone::ALL {
            assert_eq!(Tone::parse(tone.name()).expect("its own name"), tone);
            assert_eq!((tone.apply(0.0), tone.apply(1e6)), (0.0, 1.0));
        }
        assert!(Tone::Aces.apply(1.0) < 0.81, "the shoulder leaves room above 1");
    }

    #[test]
    fn a_brighter_sphere_is_seen() {
        let grey = Sphere { base: [0.5; 3], metallic: 0.0, roughness: 0.5, f0: 0.04, edge: [0.0; 3] };
        let scene = Scene::grid((64, 32), [2, 1], [None; 2], grey).expect("valid");
        let flat = |left: f32, right: f32| Picture {
            width: 64,
            height: 32,
            pixels: (0..64 * 32).map(|i| if i % 64 < 32 { [left; 4] } else { [right; 4] }).collect(),
        };
        let found = flat(1.0, 1.1).differences(&flat(1.0, 1.0), &scene);
        assert!(found[0].pixels > 100 && found[0].rms == 0.0);
        assert!((found[1].rms - 0.1).abs() < 1e-6 && (found[1].bias - 0.1).abs() < 1e-6);
        let shown = flat(1.0, 1.1).difference_srgb(&flat(1.0, 1.0), 1.0, 10.0);
        assert_eq!(&shown[..3], &[0, 0, 0]);
        assert_eq!(shown[3 * 40], 255);
    }
}
