// SPDX-License-Identifier: MIT OR Apache-2.0
//! Metals: complex index over the visible range.

use super::fit::{self, Channel};
use super::observer;
use super::optical_constants::{self as data, Row};
use crate::term::fresnel::conductor::conductor;
use crate::term::fresnel::schlick::{F82_COS, schlick_weight};

/// A metal: names, measured index, and what others print for its reflectance.
pub struct Metal {
    /// The name used on the command line.
    pub name: &'static str,
    /// Other names.
    pub also: &'static [&'static str],
    /// Paper of the index.
    pub source: &'static str,
    /// Wavelength in nm, n, k; ascending, beyond [`observer::RANGE_NM`] at both ends.
    pub n_k: &'static [[f64; 3]],
    /// Normal reflectance in linear sRGB and as 8 bits: Table 9.2 of [`super::PUBLISHED`].
    pub published: ([f64; 3], [u8; 3]),
    /// Largest difference of a channel between `published` (in [0, 1]) and the spectrum's.
    pub agreement: f64,
    /// Why the two differ, where they do.
    pub note: &'static str,
}

/// b of the F82 tint, from the reflectance at normal incidence and that at [`F82_COS`], about 82°: F(c) = F0 + (1 − F0)(1 − c)⁵
/// − b c (1 − c)⁶ goes through both. Domain: both in [0, 1].
fn edge(f0: f64, at_82: f64) -> f64 {
    let m = 1.0 - F82_COS;
    (f0 + (1.0 - f0) * schlick_weight(m) - at_82) / (F82_COS * m * schlick_weight(m))
}

impl Metal {
    /// n and k at a wavelength in nm, linearly between the measured ones; beyond them the end's values.
    pub fn at(&self, wavelength_nm: f64) -> [f64; 2] {
        let last = self.n_k.len() - 1;
        let upper = self.n_k.partition_point(|row| row[0] < wavelength_nm).clamp(1, last);
        let (a, b): (Row, Row) = (self.n_k[upper - 1], self.n_k[upper]);
        let t = ((wavelength_nm - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
        [a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])]
    }

    /// Reflectance in air at the cosine of the angle of incidence, unpolarised, as linear sRGB under D65: the spectrum's sum
    /// over [`observer::SAMPLES`] of the exact conductor. Domain: cos in [0, 1]. The red of gold exceeds 1 near normal
    /// incidence, because its colour lies outside the gamut of sRGB.
    pub fn fresnel_rgb(&self, cos: f64) -> [f64; 3] {
        observer::rgb(|wavelength_nm| {
            let [n, k] = self.at(wavelength_nm);
            conductor(cos, n, k)
        })
    }

    /// Normal reflectance, linear sRGB.
    pub fn f0(&self) -> [f64; 3] {
        self.fresnel_rgb(1.0)
    }

    /// Normal reflectance, clipped to [0, 1], and what the F82 tint takes from Schlick's Fresnel so that it has the
    /// spectrum's reflectance at 82°, too. Over all angles it then differs from the spectrum's by 0.025 at most,
    /// Schlick's by 0.20.
    pub fn f0_and_edge(&self) -> [[f64; 3]; 2] {
        let within = |rgb: [f64; 3]| rgb.map(|v| v.clamp(0.0, 1.0));
        let (f0, at_82) = (within(self.f0()), within(self.fresnel_rgb(F82_COS)));
        [f0, std::array::from_fn(|c| edge(f0[c], at_82[c]))]
    }

    /// For each channel one pair (eta, k) and how well it stands for the spectrum.
    pub fn channels(&self) -> [Channel; 3] {
        fit::channels(|cos| self.fresnel_rgb(cos))
    }

    /// For red, green and blue the pair (eta, k) whose exact conductor has the channel's normal reflectance and, of all
    /// those, the least squared difference from [`Metal::fresnel_rgb`] over cos in [0, 1]. How good it is, and whether the
    /// reflectance had to be clipped to what a conductor can have, is in [`Metal::channels`].
    pub fn eta_k_rgb(&self) -> [[f64; 2]; 3] {
        self.channels().map(|c| [c.eta, c.k])
    }
}

const JOHNSON_1974: &str = "Johnson, Christy 1974, Optical constants of transition metals, Phys. Rev. B 9, 5056-5070";
const PALIK: &str = "Palik (ed.) 1985, Handbook of Optical Constants of Solids, Academic Press";

/// The registry.
pub static METALS: [Metal; 10] = [
    Metal {
        name: "titanium",
        also: &["Ti"],
        source: JOHNSON_1974,
        n_k: data::TITANIUM,
        published: ([0.542, 0.497, 0.449], [194, 187, 179]),
        agreement: 0.1,
        note: "of evaporated films; the published values are of another measurement, and lower",
    },
    Metal {
        name: "chromium",
        also: &["chrome", "Cr"],
        source: JOHNSON_1974,
        n_k: data::CHROMIUM,
        published: ([0.549, 0.556, 0.554], [196, 197, 196]),
        agreement: 0.001,
        note: "",
    },
    Metal {
        name: "iron",
        also: &["Fe"],
        source: "Querry 1985, Optical constants, Contractor Report CRDC-CR-85034",
        n_k: data::IRON,
        published: ([0.562, 0.565, 0.578], [198, 198, 200]),
        agreement: 0.02,
        note: "another measurement than that behind the published values",
    },
    Metal {
        name: "nickel",
        also: &["Ni"],
        source: PALIK,
        n_k: data::NICKEL,
        published: ([0.660, 0.609, 0.526], [212, 205, 192]),
        agreement: 0.001,
        note: "",
    },
    Metal {
        name: "platinum",
        also: &["Pt"],
        source: "Rakić, Djurišić, Elazar, Majewski 1998, Appl. Opt. 37, 5271-5283 (Lorentz-Drude fit)",
        n_k: data::PLATINUM,
        published: ([0.673, 0.637, 0.585], [214, 209, 201]),
        agreement: 0.006,
        note: "a smooth fit to several measurements",
    },
    Metal {
        name: "copper",
        also: &["Cu"],
        source: "Hagemann, Gudat, Kunz 1975, J. Opt. Soc. Am. 65, 742-744",
        n_k: data::COPPER,
        published: ([0.955, 0.638, 0.538], [250, 209, 194]),
        agreement: 0.002,
        note: "",
    },
    Metal {
        name: "palladium",
        also: &["Pd"],
        source: JOHNSON_1974,
        n_k: data::PALLADIUM,
        published: ([0.733, 0.697, 0.652], [222, 217, 211]),
        agreement: 0.001,
        note: "",
    },
    Metal {
        name: "aluminium",
        also: &["aluminum", "Al"],
        source: "Rakić 1995, Algorithm for the determination of intrinsic optical constants of metal films, Appl. Opt. 34, \
                 4755-4767",
        n_k: data::ALUMINIUM,
        published: ([0.913, 0.922, 0.924], [245, 246, 246]),
        agreement: 0.007,
        note: "another analysis than that behind the published values",
    },
    Metal {
        name: "gold",
        also: &["Au"],
        source: PALIK,
        n_k: data::GOLD,
        published: ([1.000, 0.782, 0.344], [255, 229, 158]),
        agreement: 0.002,
        note: "red lies outside the gamut of sRGB; the published value and the fit are clipped",
    },
    Metal {
        name: "silver",
        also: &["Ag"],
        source: PALIK,
        n_k: data::SILVER,
        published: ([0.972, 0.960, 0.915], [252, 250, 245]),
        agreement: 0.001,
        note: "",
    },
];
