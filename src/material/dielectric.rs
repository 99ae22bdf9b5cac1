// SPDX-License-Identifier: MIT OR Apache-2.0
//! Dielectrics: one real index at the yellow helium line, 587.6 nm.

use crate::term::fresnel::dielectric::dielectric;

/// A dielectric: names, index, and the range that others print for its class.
pub struct Dielectric {
    /// The name used on the command line.
    pub name: &'static str,
    /// Other names.
    pub also: &'static [&'static str],
    /// Where the index is from.
    pub source: &'static str,
    /// Index over that of air. From 450 to 650 nm the normal reflectance strays by less than 5 % of itself.
    pub n: f64,
    /// What class `published` is for.
    pub class: &'static str,
    /// Least and largest normal reflectance of the class, linear and as 8 bits: Table 9.1 of [`super::PUBLISHED`].
    pub published: ([f64; 2], [u8; 2]),
}

impl Dielectric {
    /// Reflectance in air at the cosine of the angle of incidence, unpolarised. Domain: cos in [0, 1].
    pub fn fresnel(&self, cos: f64) -> f64 {
        dielectric(cos, self.n)
    }

    /// Normal reflectance, ((n − 1)/(n + 1))².
    pub fn f0(&self) -> f64 {
        self.fresnel(1.0)
    }
}

/// The registry.
pub static DIELECTRICS: [Dielectric; 5] = [
    Dielectric {
        name: "water",
        also: &[],
        source: "Hale, Querry 1973, Appl. Opt. 12, 555-563, at 25 °C",
        n: 1.333,
        class: "water",
        published: ([0.020, 0.020], [39, 39]),
    },
    Dielectric {
        name: "plastic",
        also: &[],
        source: "a round value between acrylic (1.49) and polycarbonate (1.585), which is what renderers assume",
        n: 1.5,
        class: "plastic, glass",
        published: ([0.040, 0.045], [56, 60]),
    },
    Dielectric {
        name: "glass",
        also: &["crown-glass"],
        source: "Schott N-BK7, data sheet, n_d",
        n: 1.5168,
        class: "plastic, glass",
        published: ([0.040, 0.045], [56, 60]),
    },
    Dielectric {
        name: "flint-glass",
        also: &["crystal-glass"],
        source: "Schott F2 (lead glass), data sheet, n_d",
        n: 1.62004,
        class: "crystalware, gems",
        published: ([0.050, 0.080], [63, 80]),
    },
    // The class's lower end: 0.100 encodes to 89, so the printed 90 belongs to a value from 0.1011 to 0.1034.
    Dielectric {
        name: "diamond",
        also: &[],
        source: "Peter 1923, Z. Phys. 15, 358-368",
        n: 2.4175,
        class: "diamond-like",
        published: ([0.100, 0.200], [90, 124]),
    },
];
