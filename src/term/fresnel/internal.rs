// SPDX-License-Identifier: MIT OR Apache-2.0
//! A dielectric seen from inside: total reflection beyond the critical angle.

use super::{Optics, Term, Weights};

/// Registry entry.
pub static INTERNAL: Term = Term {
    name: "internal",
    about: "exact dielectric seen from inside (--ior below 1), total internal reflection included",
    source: "Fresnel's equations; Walter, Marschner, Li, Torrance 2007, Eq. 22",
    file: Some("internal"),
    weights,
    kink: Some(|optics| critical(optics.eta[0])),
    azimuth: Some(14),
    breaks: None,
};

/// 1 and the reflectance. GLSL twin `shaders/term/fresnel/internal.glsl`.
pub fn weights(v_dot_h: f64, optics: &Optics) -> Weights {
    [1.0, internal(v_dot_h, optics.eta[0]), 0.0, 0.0]
}

/// Cosine of the critical angle, √(1 − eta²). Domain: eta in (0, 1). GLSL twin `shaders/term/fresnel/internal.glsl`.
pub fn critical(eta: f64) -> f64 {
    ((1.0 - eta) * (1.0 + eta)).sqrt()
}

/// Reflectance of unpolarised light at cosine `c` from the facet's normal, refractive index `eta` < 1 relative to where
/// the light comes from; 1 beyond the critical angle. Walter et al. 2007, Eq. 22, with g² = eta² − 1 + c² as a product of
/// distances to the critical angle. Domain: c in [0, 1]. GLSL twin `shaders/term/fresnel/internal.glsl`.
pub fn internal(c: f64, eta: f64) -> f64 {
    let vc = critical(eta);
    let g = ((c - vc) * (c + vc)).max(0.0).sqrt();
    let s = (g - c) / (g + c);
    let p = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    if c > vc { 0.5 * s * s * (1.0 + p * p) } else { 1.0 }
}

/// Cosine of the azimuth between h and v at which v·h is critical, from t = tan θ_h and the sine of v; beyond [−1, 1]
/// where it is for no azimuth. GLSL twin `shaders/term/fresnel/internal.glsl`.
pub fn fresnel_kink(tan_h: f64, n_dot_v: f64, sin_v: f64, optics: &Optics) -> f64 {
    (critical(optics.eta[0]) * (1.0 + tan_h * tan_h).sqrt() - n_dot_v) / (tan_h * sin_v)
}
