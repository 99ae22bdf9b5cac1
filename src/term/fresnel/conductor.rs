// SPDX-License-Identifier: MIT OR Apache-2.0
//! A conductor, in red, green and blue.

use super::{Optics, Term, Weights};

/// Registry entry.
pub static CONDUCTOR: Term = Term {
    name: "conductor",
    about: "exact conductor, unpolarised, from eta and k of red, green and blue (--eta-k, --material)",
    source: "Fresnel's equations with a complex index; Born, Wolf 1999, Principles of Optics, section 14.2",
    file: Some("conductor"),
    weights,
    kink: None,
    azimuth: Some(14),
    breaks: None,
};

/// 1 and the reflectance of red, green and blue. GLSL twin `shaders/term/fresnel/conductor.glsl`.
pub fn weights(v_dot_h: f64, optics: &Optics) -> Weights {
    let of = |i: usize| conductor(v_dot_h, optics.eta[i], optics.k[i]);
    [1.0, of(0), of(1), of(2)]
}

/// Reflectance of unpolarised light at cosine `c` from the facet's normal, of a medium with the complex index eta + i k.
///
/// Inside, the wave's normal component is a + i b with a² + b² = √(t² + 4 eta² k²), a² − b² = t = eta² − k² − sin². Where t
/// is negative, a² comes from the product a² b² = eta² k², so that nothing cancels. Domain: c in [0, 1], eta and k not
/// negative, not both 0. GLSL twin `shaders/term/fresnel/conductor.glsl`.
pub fn conductor(c: f64, eta: f64, k: f64) -> f64 {
    let (c2, s2) = (c * c, (1.0 - c) * (1.0 + c));
    let (eta2, k2) = (eta * eta, k * k);
    let t = eta2 - k2 - s2;
    let sum = (t * t + 4.0 * eta2 * k2).sqrt();
    let a2 = if t < 0.0 { 2.0 * eta2 * k2 / (sum - t) } else { 0.5 * (sum + t) };
    let ac = 2.0 * c * a2.sqrt();
    let s = (sum + c2 - ac) / (sum + c2 + ac);
    let (all, part) = (c2 * sum + s2 * s2, ac * s2);
    0.5 * s * (1.0 + (all - part) / (all + part))
}
