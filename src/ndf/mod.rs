// SPDX-License-Identifier: MIT OR Apache-2.0
//! Normal distribution functions, one file each.
//!
//! Only the cone rule evaluates a distribution in a shader: the GLSL twin of `ndf/ggx.rs` is `shaders/ndf/ggx.glsl`.
//! The h-split rule ([`crate::rule::h_split`]) takes any distribution from its Rust file alone: the host places the polar
//! angles and expands Smith's function, the kernel integrates over the azimuth.

pub mod abc;
pub mod beckmann;
pub mod blinn_phong;
pub mod charlie;
pub mod ggx;
pub mod gtr;
mod projected_area;

use std::fmt;

use crate::error::{Error, Result, nearest};

pub use projected_area::smith_excess;

/// Most parameters that a family of distributions has.
pub const MAX_PARAMETERS: usize = 2;

/// A family of distributions of microfacet normals: the facts and functions that every bake needs.
pub struct Family {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// Other names of the same family.
    pub also: &'static [&'static str],
    /// One line for lists.
    pub about: &'static str,
    /// Paper and equation.
    pub source: &'static str,
    /// What may be given besides alpha, as `NAME:parameter=value,…`.
    pub parameters: &'static [Parameter],
    /// The lobe at a width alpha in (0, 1] and the given parameters.
    pub lobe: fn(alpha: f64, given: &Given) -> Lobe,
    /// D per steradian from cos² and sin² of the half vector's polar angle, kept apart so that nothing cancels.
    pub d: fn(cos2: f64, sin2: f64, lobe: &Lobe) -> f64,
    /// Smith's projected area n·x (1 + Λ(x)) in closed form; `None` integrates D.
    pub sigma: Option<fn(n_dot_x: f64, lobe: &Lobe) -> f64>,
    /// The polar coordinate in which the lobe is flat.
    pub flat: Flat,
}

/// A polar coordinate y of the half vector in which a distribution looks like 2y exp(−y²), whatever its width: outer
/// nodes of the h-split rule are placed in it.
///
/// 2π D cos θ sin θ dθ = `density` dy, usually 2y exp(−y²): exp(−y²) is then the share of the projected microfacet area
/// that is steeper than θ (or less steep, where y falls as θ grows).
pub struct Flat {
    /// tan θ at y.
    pub tan: fn(y: f64, lobe: &Lobe) -> f64,
    /// y at tan θ.
    pub y: fn(tan: f64, lobe: &Lobe) -> f64,
    /// Projected microfacet area per y, at y and its tan θ.
    pub density: fn(y: f64, tan: f64, lobe: &Lobe) -> f64,
    /// Beyond it nothing is left that an `f32` table could show.
    pub y_max: f64,
    /// y falls as θ grows.
    pub falling: bool,
}

/// A parameter of a family.
pub struct Parameter {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// Least and greatest value.
    pub range: [f64; 2],
    /// It must be given.
    pub required: bool,
}

/// The parameters that were given, in the order of [`Family::parameters`].
pub type Given = [Option<f64>; MAX_PARAMETERS];

/// One member of a family: all that its functions depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Width as geometry terms see it: the alpha of a Beckmann or GGX lobe of like width.
    pub alpha: f64,
    /// Angular size of the peak, a hint for integrators.
    pub peak: f64,
    /// What else the family needs.
    pub shape: [f64; 3],
}

/// A family with its parameters: a distribution for every roughness.
#[derive(Clone, Copy)]
pub struct Ndf {
    /// Its family.
    pub family: &'static Family,
    /// Its parameters.
    pub given: Given,
}

/// Every family, in the order of their documentation.
pub static NDFS: &[&Family] =
    &[&ggx::GGX, &beckmann::BECKMANN, &blinn_phong::BLINN_PHONG, &gtr::GTR, &abc::ABC, &charlie::CHARLIE];

/// The distribution that `text`, `NAME[:parameter=value,…]`, describes.
pub fn parse(text: &str) -> Result<Ndf> {
    let (name, list) = text.split_once(':').unwrap_or((text, ""));
    let family = NDFS.iter().copied().find(|n| n.name == name || n.also.contains(&name)).ok_or_else(|| {
        let known = NDFS.iter().flat_map(|n| std::iter::once(n.name).chain(n.also.iter().copied()));
        Error::usage(format!("unknown distribution '{name}'"), nearest(name, known))
    })?;
    let mut given: Given = [None; MAX_PARAMETERS];
    for pair in list.split(',').filter(|p| !p.is_empty()) {
        let known = || family.parameters.iter().map(|p| p.name);
        let (key, value) = pair.split_once('=').ok_or_else(|| {
            Error::usage(format!("'{pair}' is not a parameter of {name}"), "write --ndf name:parameter=value")
        })?;
        let index = known().position(|k| k == key).ok_or_else(|| {
            let way_out = if family.parameters.is_empty() { "it has none".into() } else { nearest(key, known()) };
            Error::usage(format!("{name} has no parameter '{key}'"), way_out)
        })?;
        let [low, high] = family.parameters[index].range;
        let number = value.parse::<f64>().ok().filter(|v| (low..=high).contains(v)).ok_or_else(|| {
            Error::usage(format!("{name}: {key} cannot be '{value}'"), format!("give a number from {low} to {high}"))
        })?;
        given[index] = Some(number);
    }
    if let Some((p, _)) = family.parameters.iter().zip(&given).find(|(p, g)| p.required && g.is_none()) {
        return Err(Error::usage(
            format!("{name} needs its parameter '{}', {}", p.name, p.about),
            format!("write --ndf {name}:{}=…", p.name),
        ));
    }
    Ok(Ndf { family, given })
}

/// The canonical text, which [`parse`] reads back.
impl fmt::Display for Ndf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.family.name)?;
        let named = self.family.parameters.iter().zip(&self.given).filter_map(|(p, g)| Some((p.name, (*g)?)));
        for (i, (name, value)) in named.enumerate() {
            write!(f, "{}{name}={value}", if i == 0 { ':' } else { ',' })?;
        }
        Ok(())
    }
}

impl Ndf {
    /// The lobe at a roughness; `None` where it has shrunk to nothing, at roughness 0.
    pub fn lobe(&self, roughness: f64) -> Option<Lobe> {
        let alpha = alpha_of(roughness);
        // Parameters may fix the width; then any roughness will do.
        let lobe = (self.family.lobe)(if alpha == 0.0 { 1.0 } else { alpha }, &self.given);
        (alpha > 0.0 || self.is_fixed()).then_some(lobe)
    }

    /// The ellipse of an anisotropic lobe; `None` for a round one.
    pub fn ellipse(&self, lobe: &Lobe) -> Option<ggx::Ellipse> {
        std::ptr::eq(self.family, &ggx::GGX).then(|| ggx::Ellipse::new(lobe)).flatten()
    }

    /// Its parameters fix its width: it is the same for every roughness.
    pub fn is_fixed(&self) -> bool {
        (self.family.lobe)(0.5, &self.given) == (self.family.lobe)(1.0, &self.given)
    }

    /// D per steradian.
    pub fn d(&self, cos2: f64, sin2: f64, lobe: &Lobe) -> f64 {
        (self.family.d)(cos2, sin2, lobe)
    }

    /// Smith's projected area n·x (1 + Λ(x)) of the visible side, seen at cosine `n_dot_x`.
    pub fn sigma(&self, n_dot_x: f64, lobe: &Lobe) -> f64 {
        match self.family.sigma {
            Some(sigma) => sigma(n_dot_x, lobe),
            None => n_dot_x + smith_excess(n_dot_x, &self.family.flat, lobe),
        }
    }
}

/// The usual density in y.
fn bell(y: f64) -> f64 {
    2.0 * y * (-y * y).exp()
}

/// The width of a distribution from perceptual roughness (Burley 2012, section 5.4): the only place that squares.
pub fn alpha_of(roughness: f64) -> f64 {
    roughness * roughness
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_parsed_and_printed_canonically() {
        for (text, canonical) in [
            ("ggx", "ggx"),
            ("phong", "blinn-phong"),
            ("phong:exponent=10.67", "blinn-phong:exponent=10.67"),
            ("gtr:gamma=1.50", "gtr:gamma=1.5"),
            ("abc:a2=2,a1=50", "abc:a1=50,a2=2"),
        ] {
            let ndf = parse(text).unwrap();
            assert_eq!(ndf.to_string(), canonical);
            assert_eq!(parse(canonical).unwrap().given, ndf.given);
        }
    }

    #[test]
    fn bad_parameters_are_refused_by_name() {
        for (text, word) in [
            ("gtr", "gamma"),
            ("gtr:gamma=99", "'99'"),
            ("gtr:gamma=nan", "'nan'"),
            ("ggx:gamma=2", "no parameter 'gamma'"),
            ("gtr:gamma", "'gamma'"),
        ] {
            let error = parse(text).err().expect(text).to_string();
            assert!(error.contains(word), "{text}: {error}");
        }
    }

    #[test]
    fn flat_coordinates_invert_each_other() {
        for text in ["ggx", "beckmann", "phong", "gtr:gamma=1", "gtr:gamma=1.5", "gtr:gamma=3", "abc:a2=2", "charlie"] {
            let ndf = parse(text).unwrap();
            for roughness in [0.03, 0.3, 0.9, 1.0] {
                let lobe = ndf.lobe(roughness).unwrap();
                for y in [1e-3, 0.1, 0.8, 2.0, 4.0] {
                    let back = (ndf.family.flat.y)((ndf.family.flat.tan)(y, &lobe), &lobe);
                    assert!((back - y).abs() <= 1e-6 * y, "{text} {roughness}: {y} comes back as {back}");
                }
            }
        }
    }
}
