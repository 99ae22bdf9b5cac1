// SPDX-License-Identifier: MIT OR Apache-2.0
//! Geometry terms as visibility, one file each; the GLSL twin of `term/visibility/x.rs` is
//! `shaders/term/visibility/x.glsl`.

pub mod beckmann_rational;
pub mod charlie;
pub mod cook_torrance;
pub mod implicit;
pub mod kelemen;
pub mod neubelt;
pub mod neumann;
pub mod schlick_beckmann;
pub mod schlick_direct;
pub mod schlick_ggx;
pub mod smith;
pub mod smith_uncorrelated;

use super::fresnel::{Fresnel, Weights};
use crate::error::{Error, Result, nearest};

/// A geometry term G.
#[derive(Clone, Copy)]
pub struct Visibility {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// Paper and equation.
    pub source: &'static str,
    /// Stem of its two files.
    pub file: &'static str,
    /// The cone rule with this term: the rule is generic so that the term is inlined.
    pub cone: fn(n_dot_v: f64, alpha: f64, fresnel: &Fresnel) -> Weights,
    /// G/(n·v): with V = G/(4 (n·l)(n·v)) this is 4 V (n·l). Finite where V is not.
    pub g_over_n_dot_v: fn(&Directions) -> f64,
    /// Is the albedo with F = 1 at most 1?
    pub bounded: Bounded,
    /// It reads the projected areas `sigma_x`.
    pub smith: bool,
    /// Where it is not smooth.
    pub kinks: Option<Kinks>,
    /// Outer nodes a panel of the h-split rule.
    pub outer: usize,
    /// Power of the node map that crowds them at the gentle end of a panel; 1 for none.
    pub crowd: usize,
    /// Azimuth nodes a panel of the h-split rule; the GLSL twin says the same as `AZIMUTH_NODES`.
    pub azimuth: usize,
    /// They crowd at the horizon; the GLSL twin then says `NODES_n_FAR`.
    pub crowd_horizon: bool,
    /// What a user should know.
    pub note: Option<&'static str>,
    /// The albedo grows without bound as n·v goes to 0.
    pub diverges_at_grazing: bool,
}

/// For which distributions a term keeps the albedo with F = 1 at or below 1.
#[derive(Clone, Copy)]
pub enum Bounded {
    /// All.
    Always,
    /// All but these families.
    Unless(&'static [&'static str]),
    /// Not in general.
    Never,
}

/// Where a geometry term has a kink or a jump, in the coordinates of the h-split rule and in those of the truth.
///
/// All of them are linear in the cosine of the azimuth of h, so that panel ends are closed form.
#[derive(Clone, Copy)]
pub struct Kinks {
    /// Cosines of the azimuth between h and v, from tan θ_h, n·v, sin θ_v and alpha; 1 for none.
    pub azimuth: fn(tan_h: f64, n_dot_v: f64, sin_v: f64, alpha: f64) -> [f64; 2],
    /// tan θ_h where such a line enters or leaves the range of azimuths.
    pub tan_h: fn(theta_v: f64, alpha: f64) -> Vec<f64>,
    /// A cosine of the light at which the term has a kink whatever the azimuth.
    pub n_dot_l: fn(alpha: f64) -> Option<f64>,
    /// Cosine of the azimuth between l and v at which it has a kink, from n·l and n·v.
    pub light_azimuth: Option<fn(n_dot_l: f64, n_dot_v: f64) -> f64>,
}

/// What a geometry term may depend on. `sigma_x` is Smith's projected area n·x (1 + Λ(x)) of the chosen distribution.
/// GLSL twin: `shaders/lib/directions.glsl`.
#[derive(Clone, Copy, Debug)]
pub struct Directions {
    /// Cosine between normal and light.
    pub n_dot_l: f64,
    /// Cosine between normal and viewer.
    pub n_dot_v: f64,
    /// Cosine between normal and half vector.
    pub n_dot_h: f64,
    /// Cosine between viewer, or light, and half vector.
    pub v_dot_h: f64,
    /// Projected area towards the light.
    pub sigma_l: f64,
    /// Projected area towards the viewer.
    pub sigma_v: f64,
    /// Width of the distribution.
    pub alpha: f64,
}

/// Every geometry term, in the order of their documentation.
pub static VISIBILITIES: &[&Visibility] = &[
    &smith::SMITH,
    &smith_uncorrelated::SMITH_UNCORRELATED,
    &beckmann_rational::BECKMANN_RATIONAL,
    &schlick_beckmann::SCHLICK_BECKMANN,
    &schlick_ggx::SCHLICK_GGX,
    &schlick_direct::SCHLICK_DIRECT,
    &cook_torrance::COOK_TORRANCE,
    &implicit::IMPLICIT,
    &neumann::NEUMANN,
    &kelemen::KELEMEN,
    &neubelt::NEUBELT,
    &charlie::CHARLIE,
];

/// The geometry term with this name.
pub fn parse(name: &str) -> Result<&'static Visibility> {
    VISIBILITIES.iter().copied().find(|v| v.name == name).ok_or_else(|| {
        Error::usage(format!("unknown visibility '{name}'"), nearest(name, VISIBILITIES.iter().map(|v| v.name)))
    })
}
