// SPDX-License-Identifier: MIT OR Apache-2.0
//! One curve: a distribution, its width, a geometry term and a Fresnel term, in words.

use crate::brdf::Brdf;
use crate::error::{Error, Result, nearest};
use crate::material::{self, Material};
use crate::ndf::{self, NDFS, Ndf};
use crate::term::fresnel::dielectric::dielectric;
use crate::term::fresnel::schlick::schlick_weight;
use crate::term::visibility::{self, VISIBILITIES, Visibility};

/// What F is.
#[derive(Clone, Copy)]
pub enum Reflectance {
    /// F = 1.
    White,
    /// Schlick's, from the reflectance at normal incidence.
    Schlick(f64),
    /// The exact one of a refractive index.
    Dielectric(f64),
    /// That of a named material, metals summed over their spectrum.
    Named(Material),
}

/// A curve of a plot.
#[derive(Clone)]
pub struct Curve {
    /// What the legend says.
    pub label: String,
    /// Distribution.
    pub ndf: Ndf,
    /// Roughness; alpha is its square.
    pub roughness: f64,
    /// Geometry term.
    pub visibility: &'static Visibility,
    /// Fresnel term.
    pub reflectance: Reflectance,
}

impl Curve {
    /// The curve that `words` describe, separated by spaces, in any order: a distribution with its parameters, `alpha=` or
    /// `roughness=`, a geometry term, and a material, `ior=` or `f0=`. What is not said is GGX, roughness 0.5, smith, F = 1.
    ///
    /// ```
    /// use brdf_baker::plot::Curve;
    ///
    /// let curve = Curve::parse("beckmann alpha=0.748 schlick-beckmann copper")?;
    /// assert!((curve.roughness * curve.roughness - 0.748).abs() < 1e-12);
    /// assert!(Curve::parse("bekmann").is_err());
    /// # Ok::<(), brdf_baker::Error>(())
    /// ```
    pub fn parse(words: &str) -> Result<Curve> {
        let mut curve = Curve {
            label: words.split_whitespace().collect::<Vec<_>>().join(" "),
            ndf: ndf::parse("ggx")?,
            roughness: 0.5,
            visibility: visibility::parse("smith")?,
            reflectance: Reflectance::White,
        };
        let mut has_ndf = false;
        for word in words.split_whitespace() {
            let head = word.split(':').next().unwrap_or(word);
            let is_ndf = NDFS.iter().any(|n| n.name == head || n.also.contains(&head));
            if let Some((key, value)) = word.split_once('=').filter(|_| !word.contains(':')) {
                curve.set(key, value)?;
            } else if is_ndf && !has_ndf {
                (curve.ndf, has_ndf) = (ndf::parse(word)?, true);
            } else if let Ok(visibility) = visibility::parse(word) {
                curve.visibility = visibility;
            } else if let Ok(material) = material::parse(word) {
                curve.reflectance = Reflectance::Named(material);
            } else {
                let materials = material::materials().map(|m| m.name());
                let known = NDFS.iter().map(|n| n.name).chain(VISIBILITIES.iter().map(|v| v.name)).chain(materials);
                let what = format!("'{word}' is no distribution, geometry term or material");
                return Err(Error::usage(what, nearest(word, known)));
            }
        }
        if curve.label.is_empty() {
            return Err(Error::usage(
                "a curve needs a word",
                "say --curve ggx, or --curve 'beckmann alpha=0.3 copper'",
            ));
        }
        Ok(curve)
    }

    fn set(&mut self, key: &str, value: &str) -> Result<()> {
        let keys = ["alpha", "roughness", "ior", "f0"];
        let (range, help) = match key {
            "alpha" | "roughness" => (1e-3..=1.0, "give a number from 0.001 to 1"),
            "f0" => (0.0..=1.0, "give a number from 0 to 1"),
            "ior" => (1.0..=10.0, "give a number from 1 to 10"),
            _ => return Err(Error::usage(format!("a curve has no '{key}'"), nearest(key, keys))),
        };
        let number = value.parse::<f64>().ok().filter(|v| range.contains(v));
        let number = number.ok_or_else(|| Error::usage(format!("{key} cannot be '{value}'"), help))?;
        match key {
            "alpha" => self.roughness = number.sqrt(),
            "roughness" => self.roughness = number,
            "ior" => self.reflectance = Reflectance::Dielectric(number),
            _ => self.reflectance = Reflectance::Schlick(number),
        }
        Ok(())
    }

    /// F at the cosine between light and facet, in red, green and blue.
    pub fn f(&self, cos: f64) -> [f64; 3] {
        match self.reflectance {
            Reflectance::White => [1.0; 3],
            Reflectance::Schlick(f0) => [f0 + (1.0 - f0) * schlick_weight(1.0 - cos); 3],
            Reflectance::Dielectric(1.0) => [0.0; 3],
            Reflectance::Dielectric(ior) => [dielectric(cos, ior); 3],
            Reflectance::Named(Material::Dielectric(d)) => [d.fresnel(cos); 3],
            Reflectance::Named(Material::Metal(m)) => m.fresnel_rgb(cos),
        }
    }

    /// Do red, green and blue differ?
    pub fn is_coloured(&self) -> bool {
        matches!(self.reflectance, Reflectance::Named(Material::Metal(_)))
    }

    /// D and G at the curve's width.
    pub fn brdf(&self) -> Brdf {
        Brdf::new(self.ndf, self.visibility, self.roughness).expect("a roughness above 0 has a lobe")
    }
}
