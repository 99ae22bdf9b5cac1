//! Trowbridge–Reitz, known as GGX.

use super::{Family, Flat, Lobe};

/// Registry entry.
pub static GGX: Family = Family {
    name: "ggx",
    also: &["trowbridge-reitz"],
    about: "Trowbridge-Reitz (GGX): long tails, today's default in every engine",
    source: "Walter, Marschner, Li, Torrance 2007, Eq. 33 and 34; Trowbridge, Reitz 1975",
    parameters: &[],
    lobe: |alpha, _| Lobe { alpha, peak: alpha, shape: [0.0; 3] },
    d: |cos2, sin2, lobe| d(cos2, sin2, lobe.alpha),
    sigma: Some(|n_dot_x, lobe| sigma(n_dot_x, lobe.alpha)),
    // The share of steeper facets is 1/(1 + tan²/alpha²).
    flat: Flat {
        tan: |y, lobe| lobe.alpha * (y * y).exp_m1().sqrt(),
        y: |tan, lobe| (tan / lobe.alpha).powi(2).ln_1p().sqrt(),
        // exp(−y²) = alpha²/(alpha² + tan²).
        density: |y, tan, lobe| 2.0 * y / (1.0 + (tan / lobe.alpha) * (tan / lobe.alpha)),
        y_max: 6.0,
        falling: false,
    },
};

/// D(h) per steradian. Walter et al. 2007, Eq. 33; ∫ D·n_dot_h dh = 1.
/// Domain: cos2 + sin2 = 1, alpha in (0, 1]. Written with sin² apart: c²(alpha² − 1) + 1 cancels at the peak.
/// GLSL twin `shaders/ndf/ggx.glsl`.
pub fn d(cos2: f64, sin2: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let w = sin2 + a2 * cos2;
    a2 / (std::f64::consts::PI * w * w)
}

/// √(alpha² + (1 − alpha²) x²): the length of the view vector stretched by the ellipsoid of normals, x = n_dot_x.
/// Domain: x in [0, 1], alpha in [0, 1].
pub fn stretch(n_dot_x: f64, alpha: f64) -> f64 {
    (alpha * alpha + (1.0 - alpha) * (1.0 + alpha) * n_dot_x * n_dot_x).sqrt()
}

/// Smith's projected area n_dot_x (1 + Λ) = (n_dot_x + stretch)/2. Walter et al. 2007, Eq. 34 with G1 = 1/(1 + Λ);
/// finite at grazing, where Λ itself is not.
pub fn sigma(n_dot_x: f64, alpha: f64) -> f64 {
    0.5 * (n_dot_x + stretch(n_dot_x, alpha))
}
