// SPDX-License-Identifier: MIT OR Apache-2.0
//! Trowbridge–Reitz, known as GGX.

use super::{Family, Flat, Lobe, Parameter};

/// Registry entry.
pub static GGX: Family = Family {
    name: "ggx",
    also: &["trowbridge-reitz"],
    about: "Trowbridge-Reitz (GGX): long tails, today's default in every engine",
    source: "Walter, Marschner, Li, Torrance 2007, Eq. 33 and 34; Trowbridge, Reitz 1975",
    parameters: &[
        Parameter {
            name: "ratio",
            about: "anisotropic: narrow over wide axis, alpha^2 is the mean of their squares",
            range: [0.04, 1.0],
            required: false,
        },
        Parameter {
            name: "azimuth",
            about: "degrees between the view and the wide axis",
            range: [0.0, 90.0],
            required: false,
        },
    ],
    // `shape` is the ratio and the azimuth in radians.
    lobe: |alpha, given| {
        let ratio = given[0].unwrap_or(1.0);
        Lobe { alpha, peak: alpha * ratio, shape: [ratio, given[1].unwrap_or(0.0).to_radians(), 0.0] }
    },
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

/// An anisotropic lobe seen from one azimuth: ax = alpha √(2/(1 + ratio²)), ay = ratio ax, as in OpenPBR 1.1 (its
/// anisotropy is 1 − ratio). Burley 2012, appendix B; Heitz 2014.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Widths along x and y; the mean of their squares is the lobe's alpha².
    pub alpha: [f64; 2],
    /// Cosine of the azimuth between x and the view.
    pub cos: f64,
    /// Its sine.
    pub sin: f64,
}

impl Ellipse {
    /// The ellipse of a lobe; `None` for a round one.
    pub fn new(lobe: &Lobe) -> Option<Ellipse> {
        let [ratio, azimuth, _] = lobe.shape;
        let (sin, cos) = azimuth.sin_cos();
        let wide = lobe.alpha * (2.0 / (1.0 + ratio * ratio)).sqrt();
        (ratio != 1.0).then_some(Ellipse { alpha: [wide, ratio * wide], cos, sin })
    }

    /// The lobe's alpha.
    pub fn width(&self) -> f64 {
        let [ax, ay] = self.alpha;
        (0.5 * (ax * ax + ay * ay)).sqrt()
    }

    /// A vector given along the view's azimuth, across it, and up, in the ellipse's own axes.
    pub fn turned(&self, [along, across, up]: [f64; 3]) -> [f64; 3] {
        [along * self.cos - across * self.sin, along * self.sin + across * self.cos, up]
    }

    /// D(h) per steradian of a unit vector in the ellipse's axes: 1/(π ax ay (h_x²/ax² + h_y²/ay² + h_z²)²). Burley 2012,
    /// appendix B.
    pub fn d(&self, [x, y, z]: [f64; 3]) -> f64 {
        let [ax, ay] = self.alpha;
        let w = (x / ax) * (x / ax) + (y / ay) * (y / ay) + z * z;
        1.0 / (std::f64::consts::PI * ax * ay * w * w)
    }

    /// Smith's projected area of a unit vector in the ellipse's axes. Heitz 2014.
    pub fn sigma(&self, [x, y, z]: [f64; 3]) -> f64 {
        let [ax, ay] = self.alpha;
        0.5 * (z + (ax * ax * x * x + ay * ay * y * y + z * z).sqrt())
    }
}
