//! How far apart the values lie that a file can hold.

use super::{Encoding, Rounding};
use crate::error::{Error, Result};
use crate::texture::Meta;

/// The key of the largest difference that blocks made.
const ABSOLUTE: &str = "encoding.error.absolute";
/// The key of the largest difference relative to its value, over values of at least 2⁻¹⁴.
const RELATIVE: &str = "encoding.error.relative";
/// The key of the same figure's root mean square, of the level where it is largest.
const RELATIVE_RMS: &str = "encoding.error.relative.rms";
/// The key of the root mean square of the differences over that of the values, of the level where it is largest.
const RMS: &str = "encoding.error.rms";

/// An encoding's steps. Where texels are stored one by one, they follow from the value. What blocks lose is measured as
/// they are written, and stated by the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// How texels are stored.
    pub encoding: Encoding,
    /// Largest difference, absolute and relative, of blocks.
    lost: [f64; 2],
}

impl From<Encoding> for Steps {
    /// Of blocks without a statement nothing is known: no value is within their bounds.
    fn from(encoding: Encoding) -> Self {
        Steps { encoding, lost: [f64::NAN; 2] }
    }
}

impl Steps {
    /// Of a file with this meta; an error where it does not state what its blocks lost.
    pub fn of(encoding: Encoding, meta: &Meta) -> Result<Steps> {
        if !encoding.repr.is_blocks() {
            return Ok(encoding.into());
        }
        let stated = |key: &str| {
            let number = meta.get(key).and_then(|text| text.parse::<f64>().ok()).filter(|x| x.is_finite() && *x >= 0.0);
            let what = || format!("it does not state its {key}, so nothing tells what its blocks lost");
            number.ok_or_else(|| Error::usage(what(), "bake it again, or store it in another encoding"))
        };
        Ok(Steps { encoding, lost: [stated(ABSOLUTE)?, stated(RELATIVE)?] })
    }

    /// States in the meta of a file what blocks lost; nothing for other encodings.
    pub fn state(encoding: Encoding, rounding: &Rounding, meta: &mut Meta) {
        if !encoding.repr.is_blocks() {
            return;
        }
        // Rounded up in the last digit, so that the statement is a bound.
        let bound = |x: f64| format!("{:.2e}", x * 1.005);
        meta.set(ABSOLUTE, bound(rounding.max_abs));
        meta.set(RELATIVE, bound(rounding.max_rel));
        meta.set(RELATIVE_RMS, bound(rounding.rms_rel));
        meta.set(RMS, bound(rounding.rms));
    }

    /// The largest error that storing can have made near `value`, in a texel whose largest component is `largest`.
    pub fn half_ulp_at(&self, value: f64, largest: f64) -> f64 {
        let [absolute, relative] = self.lost;
        match self.encoding.repr.is_blocks() {
            true if value.abs() >= 2.0_f64.powi(-14) => absolute.min(relative * value.abs()),
            true => absolute,
            false => self.encoding.half_ulp_at(value, largest),
        }
    }

    /// The same in proportion to the value, near 1; of blocks near any value of at least 2⁻¹⁴.
    pub fn relative(&self) -> f64 {
        if self.encoding.repr.is_blocks() { self.lost[1] } else { self.encoding.half_ulp_at(1.0, 1.0) }
    }
}
