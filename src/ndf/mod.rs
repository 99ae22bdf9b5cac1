//! Normal distribution functions, one file each; the GLSL twin of `ndf/x.rs` is `shaders/ndf/x.glsl`.

pub mod ggx;

use crate::error::{Error, Result, nearest};

/// A distribution of microfacet normals: the facts and functions that every bake needs.
///
/// All functions take `alpha`, the width; [`alpha_of`] makes it from roughness.
pub struct Ndf {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// Paper and equation.
    pub source: &'static str,
    /// D per steradian from cos² and sin² of the half vector's polar angle, kept apart so that nothing cancels.
    pub d: fn(cos2: f64, sin2: f64, alpha: f64) -> f64,
    /// Smith's projected area n·x (1 + Λ(x)) of the visible side, seen at cosine `n_dot_x`.
    pub sigma: fn(n_dot_x: f64, alpha: f64) -> f64,
}

/// Every distribution, in the order of their documentation.
pub static NDFS: &[&Ndf] = &[&ggx::GGX];

/// The distribution with this name.
pub fn parse(name: &str) -> Result<&'static Ndf> {
    NDFS.iter().copied().find(|n| n.name == name).ok_or_else(|| {
        Error::usage(format!("unknown distribution '{name}'"), nearest(name, NDFS.iter().map(|n| n.name)))
    })
}

/// The width of a distribution from perceptual roughness (Burley 2012, section 5.4): the only place that squares.
pub fn alpha_of(roughness: f64) -> f64 {
    roughness * roughness
}
