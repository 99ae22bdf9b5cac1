// SPDX-License-Identifier: MIT OR Apache-2.0
//! The light of an environment that a surface reflects, in f64.

use std::f64::consts::PI;

use crate::env::orientation::normalized;
use crate::env::projection::Projection;
use crate::env::{Environment, Picture};
use crate::ndf::alpha_of;
use crate::term::zonal::{Zonal, ggx::GGX, lambert::LAMBERT};
use crate::verify::cube_truth::CubeTruth;
use crate::verify::environment::{Scale, Truth};

/// An environment, ready to be convolved in any direction by brute force: each of its texels is looked at.
pub struct Light<'a> {
    environment: &'a Environment<'a>,
    truth: AnyTruth<'a>,
}

enum AnyTruth<'a> {
    Equirect(Truth<'a>),
    Cube(CubeTruth<'a>),
}

impl<'a> Light<'a> {
    /// Prepares an environment.
    pub fn new(environment: &'a Environment<'a>) -> Self {
        let truth = match &environment.picture {
            Picture::Equirect(picture) => AnyTruth::Equirect(Truth::new(picture)),
            Picture::Cube(picture) => AnyTruth::Cube(CubeTruth::new(picture)),
        };
        Self { environment, truth }
    }

    /// What a map filtered with GGX holds along `direction`, of any length: mean radiance, weighted as
    /// [`crate::bake::specular`] says. At roughness 0, and where the lobe is narrower than that filter knows, the radiance
    /// of the texel that lies there.
    pub fn reflected(&self, direction: [f64; 3], roughness: f64) -> [f64; 3] {
        let alpha = alpha_of(roughness);
        let along = normalized(self.environment.frame.to_picture(direction));
        match GGX.least_alpha {
            Some(least) if alpha < least => self.texel(along),
            _ => self.integral(&GGX, alpha, along).map(|v| v / (GGX.norm)(alpha)),
        }
    }

    /// Irradiance over π on a surface whose normal is `n`, a unit vector.
    pub fn diffuse(&self, n: [f64; 3]) -> [f64; 3] {
        self.integral(&LAMBERT, 1.0, self.environment.frame.to_picture(n)).map(|v| v / PI)
    }

    fn integral(&self, kernel: &Zonal, alpha: f64, along: [f64; 3]) -> [f64; 3] {
        let (scale, values) = (Scale::of(kernel, alpha), |h: &mut [f64]| (kernel.values)(h, alpha));
        match &self.truth {
            AnyTruth::Equirect(truth) => truth.integral(along, scale, values),
            AnyTruth::Cube(truth) => truth.integral(along, scale, values),
        }
    }

    fn texel(&self, along: [f64; 3]) -> [f64; 3] {
        let (projection, width, height) = match &self.environment.picture {
            Picture::Equirect(picture) => (Projection::Equirect, picture.width, picture.height),
            Picture::Cube(picture) => (Projection::Cube, picture.size, picture.size),
        };
        let (face, s, t) = projection.locate(along);
        let at = |x: f64, n: u32| ((0.5 * (x + 1.0) * f64::from(n)) as u32).min(n - 1);
        let index = (face * height + at(t, height)) * width + at(s, width);
        self.environment.picture.texels()[index as usize].map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::{CubeMap, Equirect};

    /// Radiance that is linear in the direction stays linear: a lobe only shrinks the slope. Of Lambert's cosine it keeps ⅔,
    /// and GGX of width 1 is the same lobe (D is constant).
    #[test]
    fn a_linear_sky_keeps_two_thirds_of_its_slope() {
        let radiance = |[x, y, z]: [f64; 3]| [1.0 + 0.5 * x, 1.0 + 0.5 * y, 1.0 + 0.5 * z].map(|v| v as f32);
        let equirect = Equirect::from_fn(128, |u, v| radiance(Equirect::direction(u, v)));
        let cube = CubeMap::from_fn(64, |d| radiance(normalized(d)));
        let n = normalized([0.3, -0.5, 0.8]);
        for environment in [Environment::from(&equirect), (&cube).into()] {
            let light = Light::new(&environment);
            let (rough, diffuse, mirror) = (light.reflected(n, 1.0), light.diffuse(n), light.reflected(n, 0.0));
            for c in 0..3 {
                assert!((diffuse[c] - 1.0 - n[c] / 3.0).abs() < 2e-4, "{diffuse:?}");
                assert!((rough[c] - diffuse[c]).abs() < 1e-4, "{rough:?} {diffuse:?}");
                assert!((mirror[c] - 1.0 - 0.5 * n[c]).abs() < 0.02, "{mirror:?}");
            }
        }
    }
}
