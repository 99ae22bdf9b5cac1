// SPDX-License-Identifier: MIT OR Apache-2.0
//! Environments: radiance from every direction, as a picture and the way it is turned.
//!
//! An environment here is *piecewise constant*: every texel holds one radiance over its exact solid angle. Everything
//! that this crate computes from an environment refers to that function, so that "the right answer" is well defined.
//!
//! **Orientation.** An equirectangular picture's point (u, v), both in [0, 1] from the top left, looks along
//!
//! ```text
//! (cos φ sin θ, cos θ, sin φ sin θ)    φ = 2π (u − ½)    θ = π v
//! ```
//!
//! so its centre looks along +X, u = ¾ along +Z, and its top edge is +Y, as in glTF viewers and three.js.
//! Cube faces are those of [`crate::term::cube`]. A [`Frame`] turns either.

use std::borrow::Cow;

pub mod area;
mod cube_map;
mod file_axes;
mod frame;
pub mod import;
pub mod orientation;
pub mod projection;
pub mod resample;
pub mod sh;
pub mod sky;
mod survey;
pub mod tree;

pub use cube_map::CubeMap;
pub use file_axes::FileAxes;
pub use frame::Frame;
pub use survey::Survey;

/// A picture, owned or borrowed, and how it is turned.
#[derive(Clone, Debug)]
pub struct Environment<'a> {
    /// Radiance by direction, in the picture's own axes.
    pub picture: Picture<'a>,
    /// From directions of the output to the picture's.
    pub frame: Frame,
}

/// Radiance that is constant over each texel's solid angle.
#[derive(Clone, Debug)]
pub enum Picture<'a> {
    /// Texels between parallels and meridians.
    Equirect(Cow<'a, Equirect>),
    /// Texels on six faces.
    Cube(Cow<'a, CubeMap>),
}

impl Environment<'_> {
    /// The same environment, borrowed.
    pub fn borrowed(&self) -> Environment<'_> {
        Environment { picture: self.picture.borrowed(), frame: self.frame }
    }
}

impl Picture<'_> {
    /// The same picture, borrowed.
    pub fn borrowed(&self) -> Picture<'_> {
        match self {
            Picture::Equirect(picture) => Picture::Equirect(Cow::Borrowed(picture)),
            Picture::Cube(picture) => Picture::Cube(Cow::Borrowed(picture)),
        }
    }

    /// Mean radiance over the sphere, per channel.
    pub fn mean(&self) -> [f64; 3] {
        Survey::of(self).mean
    }

    /// Every texel, in the order of the picture.
    pub fn texels(&self) -> &[[f32; 3]] {
        match self {
            Picture::Equirect(picture) => &picture.texels,
            Picture::Cube(picture) => &picture.texels,
        }
    }

    /// Radiance in a direction (of any length) of the picture's axes.
    pub fn radiance(&self, d: [f64; 3]) -> [f32; 3] {
        let cell = |v: f64, n: u32| ((v * f64::from(n)) as u32).min(n - 1);
        match self {
            Picture::Equirect(picture) => {
                let [u, v] = Equirect::locate(d);
                picture.row(cell(v, picture.height))[cell(u, picture.width) as usize]
            }
            Picture::Cube(picture) => {
                let (face, s, t) = orientation::locate(d);
                picture.texel(face, cell(0.5 * (s + 1.0), picture.size), cell(0.5 * (t + 1.0), picture.size))
            }
        }
    }

    /// The direction of the centre of texel `index` of [`Picture::texels`].
    pub fn direction(&self, index: usize) -> [f64; 3] {
        match self {
            Picture::Equirect(picture) => {
                let (x, y) = (index % picture.width as usize, index / picture.width as usize);
                let centre = |i: usize, n: u32| (i as f64 + 0.5) / f64::from(n);
                Equirect::direction(centre(x, picture.width), centre(y, picture.height))
            }
            Picture::Cube(picture) => {
                let size = picture.size as usize;
                let (face, y, x) = (index / (size * size), index / size % size, index % size);
                let (s, t) = orientation::centre(x as u32, y as u32, picture.size);
                orientation::normalized(crate::term::cube::direction(face as u32, s, t))
            }
        }
    }
}

impl<'a> From<&'a Equirect> for Environment<'a> {
    fn from(picture: &'a Equirect) -> Self {
        Environment { picture: Picture::Equirect(Cow::Borrowed(picture)), frame: Frame::IDENTITY }
    }
}

impl<'a> From<&'a CubeMap> for Environment<'a> {
    fn from(picture: &'a CubeMap) -> Self {
        Environment { picture: Picture::Cube(Cow::Borrowed(picture)), frame: Frame::IDENTITY }
    }
}

impl<'a> From<&'a Environment<'_>> for Environment<'a> {
    fn from(environment: &'a Environment<'_>) -> Self {
        environment.borrowed()
    }
}

/// An equirectangular picture of linear radiance, twice as wide as high.
#[derive(Clone, Debug, PartialEq)]
pub struct Equirect {
    /// Texels in a row: twice the height.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue; rows from the top (+Y), finite and not negative.
    pub texels: Vec<[f32; 3]>,
}

impl Equirect {
    /// A picture whose texel at column x and row y is `at(u, v)` for the texel's centre.
    ///
    /// # Panics
    /// When `height` is 0.
    pub fn from_fn(height: u32, mut at: impl FnMut(f64, f64) -> [f32; 3]) -> Self {
        assert!(height > 0, "a picture has at least one row");
        let width = 2 * height;
        let centre = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            texels.extend((0..width).map(|x| at(centre(x, width), centre(y, height))));
        }
        Self { width, height, texels }
    }

    /// The same picture with every texel repeated `times` × `times`: the same piecewise constant radiance.
    pub fn repeated(&self, times: u32) -> Self {
        let (width, height) = (self.width * times, self.height * times);
        let texel = |i: u32| self.row(i / width / times)[(i % width / times) as usize];
        Self { width, height, texels: (0..width * height).map(texel).collect() }
    }

    /// The texels of row `y`.
    pub fn row(&self, y: u32) -> &[[f32; 3]] {
        &self.texels[y as usize * self.width as usize..][..self.width as usize]
    }

    /// The direction that the point (u, v) looks along.
    pub fn direction(u: f64, v: f64) -> [f64; 3] {
        let (sin_phi, cos_phi) = (std::f64::consts::TAU * (u - 0.5)).sin_cos();
        let (sin_theta, cos_theta) = (std::f64::consts::PI * v).sin_cos();
        [cos_phi * sin_theta, cos_theta, sin_phi * sin_theta]
    }

    /// The point (u, v) that looks along `d`, a vector of any length. The inverse of [`Equirect::direction`].
    pub fn locate(d: [f64; 3]) -> [f64; 2] {
        let [x, y, z] = d;
        [z.atan2(x) / std::f64::consts::TAU + 0.5, x.hypot(z).atan2(y) / std::f64::consts::PI]
    }

    /// Solid angle of a texel in row `y`, in steradians.
    pub fn solid_angle_sr(&self, y: u32) -> f64 {
        let half = 0.5 * std::f64::consts::PI / f64::from(self.height);
        let theta = (2.0 * f64::from(y) + 1.0) * half;
        2.0 * theta.sin() * half.sin() * std::f64::consts::TAU / f64::from(self.width)
    }

    /// Mean radiance over the sphere, per channel.
    pub fn mean(&self) -> [f64; 3] {
        Picture::Equirect(Cow::Borrowed(self)).mean()
    }
}

/// For tests: uneven radiance, no two neighbours alike.
#[cfg(test)]
fn speckle(height: u32) -> Equirect {
    let mut state = 1u32;
    Equirect::from_fn(height, |_, _| {
        std::array::from_fn(|_| {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 16) as f32 / 65536.0 + if state >> 26 == 0 { 5.0 } else { 0.0 }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15)
    }

    #[test]
    fn directions_are_those_of_the_documentation() {
        assert!(near(Equirect::direction(0.5, 0.5), [1.0, 0.0, 0.0]));
        assert!(near(Equirect::direction(0.75, 0.5), [0.0, 0.0, 1.0]));
        assert!(near(Equirect::direction(0.25, 0.5), [0.0, 0.0, -1.0]));
        assert!(near(Equirect::direction(0.3, 0.0), [0.0, 1.0, 0.0]));
    }

    #[test]
    fn locate_inverts_direction() {
        for (u, v) in [(0.1, 0.2), (0.6, 0.9), (0.99, 0.5)] {
            let [u1, v1] = Equirect::locate(Equirect::direction(u, v));
            assert!((u - u1).abs() < 1e-14 && (v - v1).abs() < 1e-14, "({u}, {v}) became ({u1}, {v1})");
        }
    }

    #[test]
    fn solid_angles_sum_to_the_sphere() {
        let white = Equirect::from_fn(32, |_, _| [1.0; 3]);
        assert!(white.mean().iter().all(|m| (m - 1.0).abs() < 1e-14), "{:?}", white.mean());
    }
}
