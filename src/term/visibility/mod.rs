//! Geometry terms as visibility, one file each; the GLSL twin of `term/visibility/x.rs` is
//! `shaders/term/visibility/x.glsl`.

pub mod smith;
pub mod smith_uncorrelated;

use crate::error::{Error, Result, nearest};

/// A geometry term G.
pub struct Visibility {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// Paper and equation.
    pub source: &'static str,
    /// Stem of its two files.
    pub file: &'static str,
    /// The cone rule with this term, (E, B) from (n·v, alpha): the rule is generic so that the term is inlined.
    pub cone: fn(n_dot_v: f64, alpha: f64) -> [f64; 2],
    /// G/(n·v): with V = G/(4 (n·l)(n·v)) this is 4 V (n·l). Finite where V is not.
    pub g_over_n_dot_v: fn(&Directions) -> f64,
}

/// What a geometry term may depend on. `sigma_x` is Smith's projected area n·x (1 + Λ(x)) of the chosen distribution.
#[derive(Clone, Copy, Debug)]
pub struct Directions {
    /// Cosine between normal and light.
    pub n_dot_l: f64,
    /// Cosine between normal and viewer.
    pub n_dot_v: f64,
    /// Projected area towards the light.
    pub sigma_l: f64,
    /// Projected area towards the viewer.
    pub sigma_v: f64,
}

/// Every geometry term, in the order of their documentation.
pub static VISIBILITIES: &[&Visibility] = &[&smith::SMITH, &smith_uncorrelated::SMITH_UNCORRELATED];

/// The geometry term with this name.
pub fn parse(name: &str) -> Result<&'static Visibility> {
    VISIBILITIES.iter().copied().find(|v| v.name == name).ok_or_else(|| {
        Error::usage(format!("unknown visibility '{name}'"), nearest(name, VISIBILITIES.iter().map(|v| v.name)))
    })
}
