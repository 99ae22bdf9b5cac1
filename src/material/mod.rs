// SPDX-License-Identifier: MIT OR Apache-2.0
//! Named materials: what reflects at a smooth surface of a metal or a dielectric, as linear sRGB.
//!
//! - [`Metal`] holds the measured complex index n − ik over the visible range. [`Metal::fresnel_rgb`] is its reflectance
//!   under an angle, summed over the spectrum ([`observer`]); [`Metal::eta_k_rgb`] is one pair (eta, k) a channel for
//!   renderers that know no more than three wavelengths.
//! - [`Dielectric`] holds one index: its reflectance hardly depends on the wavelength.
//! - [`srgb`] turns linear values into the 8-bit numbers that textures hold.
//!
//! ```
//! use brdf_baker::material::{Material, parse};
//!
//! let Material::Metal(copper) = parse("copper")? else { unreachable!("copper is a metal") };
//! let [r, g, b] = copper.f0();
//! assert!(r > 0.9 && g < 0.7 && b < g);
//! # Ok::<(), brdf_baker::Error>(())
//! ```

pub mod dielectric;
mod fit;
pub mod metal;
pub mod observer;
#[allow(clippy::approx_constant, reason = "two of the measured k happen to be 3.14")]
mod optical_constants;
pub mod srgb;

use crate::error::{Error, Result, nearest};
use crate::term::fresnel::Fresnel;

pub use dielectric::{DIELECTRICS, Dielectric};
pub use fit::{Channel, LARGEST_F0};
pub use metal::{METALS, Metal};

/// Where the published values of normal reflectance are from.
pub const PUBLISHED: &str =
    "Akenine-Möller, Haines, Hoffman, Pesce, Iwanicki, Hillaire 2018, Real-Time Rendering, 4th ed.";

/// A named material of either kind.
#[derive(Clone, Copy)]
pub enum Material {
    /// Opaque, with a complex index.
    Metal(&'static Metal),
    /// Transparent, with a real index.
    Dielectric(&'static Dielectric),
}

impl Material {
    /// The name used on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Material::Metal(m) => m.name,
            Material::Dielectric(d) => d.name,
        }
    }

    /// The exact Fresnel term that a bake takes: a conductor with one (eta, k) a channel, or a dielectric from outside.
    pub fn fresnel(&self) -> Result<Fresnel> {
        match self {
            Material::Metal(m) => {
                let pairs = m.eta_k_rgb();
                Fresnel::conductor(pairs.map(|p| p[0]), pairs.map(|p| p[1]))
            }
            Material::Dielectric(d) => Fresnel::dielectric(d.n),
        }
    }

    /// Other names of the same material.
    pub fn also(&self) -> &'static [&'static str] {
        match self {
            Material::Metal(m) => m.also,
            Material::Dielectric(d) => d.also,
        }
    }
}

/// All materials, metals first.
pub fn materials() -> impl Iterator<Item = Material> {
    METALS.iter().map(Material::Metal).chain(DIELECTRICS.iter().map(Material::Dielectric))
}

/// The material of that name; an error names the nearest ones.
pub fn parse(name: &str) -> Result<Material> {
    materials().find(|m| m.name() == name || m.also().contains(&name)).ok_or_else(|| {
        let known = materials().map(|m| m.name());
        Error::usage(format!("unknown material '{name}'"), nearest(name, known))
    })
}
