// SPDX-License-Identifier: MIT OR Apache-2.0
//! A cube of radiance: six faces of one size.

use std::borrow::Cow;

use super::{Picture, orientation};
use crate::term::cube::direction;

/// Six square faces of linear radiance, +X −X +Y −Y +Z −Z, with the axes of [`crate::term::cube`].
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    /// Texels along a side of a face.
    pub size: u32,
    /// Red, green, blue; face by face, rows from the top, finite and not negative.
    pub texels: Vec<[f32; 3]>,
}

impl CubeMap {
    /// A cube whose texels are `at(direction)` for the texels' centres; directions are not normalised.
    ///
    /// # Panics
    /// When `size` is 0.
    pub fn from_fn(size: u32, mut at: impl FnMut([f64; 3]) -> [f32; 3]) -> Self {
        assert!(size > 0, "a face has at least one texel");
        let texels = (0..6 * size * size).map(|i| {
            let (s, t) = orientation::centre(i % size, i / size % size, size);
            at(direction(i / (size * size), s, t))
        });
        Self { size, texels: texels.collect() }
    }

    /// The same cube with every texel repeated `times` × `times`: the same piecewise constant radiance.
    pub fn repeated(&self, times: u32) -> Self {
        let size = self.size * times;
        let texel = |i: u32| self.texel(i / (size * size), i % size / times, i / size % size / times);
        Self { size, texels: (0..6 * size * size).map(texel).collect() }
    }

    /// The texel at column x and row y of a face.
    pub fn texel(&self, face: u32, x: u32, y: u32) -> [f32; 3] {
        let (size, face, x, y) = (self.size as usize, face as usize, x as usize, y as usize);
        self.texels[(face * size + y) * size + x]
    }

    /// Solid angle, in steradians, of every texel of a face, rows from the top.
    pub fn solid_angles_sr(size: u32) -> Vec<f64> {
        let line = |i: u32| 2.0 * f64::from(i) / f64::from(size) - 1.0;
        let corner = |x: u32, y: u32| orientation::solid_angle(line(x), line(y));
        (0..size * size)
            .map(|i| (i % size, i / size))
            .map(|(x, y)| corner(x + 1, y + 1) - corner(x, y + 1) - corner(x + 1, y) + corner(x, y))
            .collect()
    }

    /// Mean radiance over the sphere, per channel.
    pub fn mean(&self) -> [f64; 3] {
        Picture::Cube(Cow::Borrowed(self)).mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_white_is_1() {
        let white = CubeMap::from_fn(5, |_| [1.0; 3]);
        assert!(white.mean().iter().all(|m| (m - 1.0).abs() < 1e-14), "{:?}", white.mean());
    }

    #[test]
    fn repeated_is_the_same_function() {
        let mut value = 0.0;
        let cube = CubeMap::from_fn(2, |_| {
            value += 1.0;
            [value; 3]
        });
        let fine = cube.repeated(3);
        for (face, x, y) in [(0, 0, 0), (3, 5, 2), (5, 2, 5)] {
            assert_eq!(fine.texel(face, x, y), cube.texel(face, x / 3, y / 3));
        }
    }
}
