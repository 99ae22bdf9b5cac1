// SPDX-License-Identifier: MIT OR Apache-2.0
//! A dielectric, light coming from the side of the lower refractive index.

use super::{Optics, Term, Weights};

/// Registry entry.
pub static DIELECTRIC: Term = Term {
    name: "dielectric",
    about: "exact dielectric, unpolarised, from its refractive index (--ior); below 1 seen from inside, see 'internal'",
    source: "Fresnel's equations; Walter, Marschner, Li, Torrance 2007, Eq. 22",
    file: Some("dielectric"),
    weights,
    kink: None,
    azimuth: Some(14),
    breaks: None,
};

/// 1 and the reflectance. GLSL twin `shaders/term/fresnel/dielectric.glsl`.
pub fn weights(v_dot_h: f64, optics: &Optics) -> Weights {
    [1.0, dielectric(v_dot_h, optics.eta[0]), 0.0, 0.0]
}

/// Reflectance of unpolarised light at cosine `c` from the facet's normal, refractive index `eta` > 1 relative to where
/// the light comes from. Walter et al. 2007, Eq. 22, with g² = eta² − 1 + c² written as a product.
/// Domain: c in [0, 1]. GLSL twin `shaders/term/fresnel/dielectric.glsl`.
pub fn dielectric(c: f64, eta: f64) -> f64 {
    let g = ((eta - 1.0) * (eta + 1.0) + c * c).sqrt();
    let s = (g - c) / (g + c);
    let p = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    0.5 * s * s * (1.0 + p * p)
}
