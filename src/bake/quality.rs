// SPDX-License-Identifier: MIT OR Apache-2.0
//! How finely an environment is filtered: points on the curve of error against time.

use super::specular_walk::Precision;
use crate::error::{Error, Result, nearest};

/// A named precision with what it keeps, measured over the scenes of `tests/environment.rs` with a factor of about two
/// in hand.
#[derive(Debug)]
pub struct Quality {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// One line for lists.
    pub about: &'static str,
    /// How finely the walk looks.
    pub precision: Precision,
    /// `eps` of kernels without a tail, whose blocks share nothing: there the same step costs more and gains less.
    pub eps_alone: f64,
    /// Bound of the root mean square of the relative errors of a mip, before rounding.
    pub rms_bound: f64,
    /// Bound of any texel's relative error, before rounding.
    pub worst_bound: f64,
    /// Texels of each mip that are compared with a brute-force sum after a bake, beside the one at the brightest place: of a
    /// large source. See [`Extent::after_baking`](crate::verify::environment::Extent::after_baking).
    pub spot_texels: u32,
}

/// Every quality, from fast to fine.
pub static QUALITIES: [Quality; 3] = [
    Quality {
        name: "draft",
        about: "for looking at: a third of the time",
        precision: Precision { eps: 1.2, brightness_limit: 3.0, limit: 60_000, far: 3.0 },
        eps_alone: 1.2,
        rms_bound: 1e-2,
        worst_bound: 1e-1,
        spot_texels: 0,
    },
    Quality {
        name: "standard",
        about: "below the rounding of half floats",
        precision: Precision { eps: 0.36, brightness_limit: 4.0, limit: 60_000, far: 6.0 },
        eps_alone: 0.42,
        rms_bound: 1e-3,
        worst_bound: 1e-2,
        spot_texels: 4,
    },
    Quality {
        name: "reference",
        about: "a quarter of the error, about three times the filtering time",
        precision: Precision { eps: 0.21, brightness_limit: 5.0, limit: 60_000, far: 8.0 },
        eps_alone: 0.25,
        rms_bound: 2.5e-4,
        worst_bound: 2.5e-3,
        spot_texels: 6,
    },
];

/// The one that is used when none is named.
pub static STANDARD: &Quality = &QUALITIES[1];

/// The quality with this name.
pub fn parse(name: &str) -> Result<&'static Quality> {
    let known = || QUALITIES.iter().map(|q| q.name);
    QUALITIES
        .iter()
        .find(|q| q.name == name)
        .ok_or_else(|| Error::usage(format!("unknown quality '{name}'"), nearest(name, known())))
}
