// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far apart the values lie that a file can hold.

use half::f16;

use super::{Encoding, Rounding};
use crate::error::{Error, Result};
use crate::texture::Meta;

/// The key of the largest difference.
const ABSOLUTE: &str = "encoding.error.absolute";
/// The key of the largest difference relative to its value, over values of at least 2⁻¹⁴.
const RELATIVE: &str = "encoding.error.relative";
/// The key of the same figure's root mean square, of the level where it is largest.
const RELATIVE_RMS: &str = "encoding.error.relative.rms";
/// The key of the root mean square of the differences over that of the values, of the level where it is largest.
const RMS: &str = "encoding.error.rms";

/// The two root mean squares once more, of all levels together.
const WHOLE_RELATIVE_RMS: &str = "encoding.error.whole.relative.rms";
/// See [`WHOLE_RELATIVE_RMS`].
const WHOLE_RMS: &str = "encoding.error.whole.rms";
/// The same of all levels after the first.
const FILTERED_RELATIVE_RMS: &str = "encoding.error.filtered.relative.rms";
/// See [`FILTERED_RELATIVE_RMS`].
const FILTERED_RMS: &str = "encoding.error.filtered.rms";

/// A sample of a level's texels, some of them its brightest, may have this many times the level's root mean square.
const SAMPLE: f64 = 4.0;

/// An encoding's steps. Where components are stored one by one, they follow from the value. What a texel's components
/// lose to the largest of them, dark ones to a curve, or texels to others of their block, is measured as the file is
/// written, and stated by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// How texels are stored.
    pub encoding: Encoding,
    lost: Option<Lost>,
}

/// What a file states.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lost {
    absolute: f64,
    relative: f64,
    relative_rms: f64,
}

impl From<Encoding> for Steps {
    /// Without a file's statement. Of blocks nothing is known then: no value is within their bounds.
    fn from(encoding: Encoding) -> Self {
        Steps { encoding, lost: None }
    }
}

impl Steps {
    /// Of a file with this meta; an error where it does not state what its blocks lost.
    pub fn of(encoding: Encoding, meta: &Meta) -> Result<Steps> {
        let stated = |key: &str| {
            let number = meta.get(key).and_then(|text| text.parse::<f64>().ok()).filter(|x| x.is_finite() && *x >= 0.0);
            let what = || format!("it does not state its {key}, so nothing tells what its blocks lost");
            number.ok_or_else(|| Error::usage(what(), "bake it again, or store it in another encoding"))
        };
        let lost = || {
            let [absolute, relative, relative_rms] = [stated(ABSOLUTE)?, stated(RELATIVE)?, stated(RELATIVE_RMS)?];
            Ok(Lost { absolute, relative, relative_rms })
        };
        let lost = match encoding.repr.is_blocks() {
            true => Some(lost()?),
            false if encoding.repr.is_measured() => lost().ok(),
            false => None,
        };
        Ok(Steps { encoding, lost })
    }

    /// States in the meta of a file what was lost.
    pub fn state(rounding: &Rounding, meta: &mut Meta) {
        // Rounded up in the last digit, so that the statement is a bound.
        let bound = |x: f64| format!("{:.2e}", x * 1.005);
        meta.set(ABSOLUTE, bound(rounding.most.max_abs));
        meta.set(RELATIVE, bound(rounding.most.max_rel));
        meta.set(RELATIVE_RMS, bound(rounding.most.rms_rel));
        meta.set(RMS, bound(rounding.most.rms));
        if let Some(filtered) = rounding.filtered {
            meta.set(WHOLE_RELATIVE_RMS, bound(rounding.whole.rms_rel));
            meta.set(WHOLE_RMS, bound(rounding.whole.rms));
            meta.set(FILTERED_RELATIVE_RMS, bound(filtered.rms_rel));
            meta.set(FILTERED_RMS, bound(filtered.rms));
        }
    }

    /// The largest error that storing can have made near `value`, in a texel whose largest component is `largest`.
    pub fn half_ulp_at(&self, value: f64, largest: f64) -> f64 {
        match self.lost.filter(|_| self.encoding.repr.is_blocks()) {
            Some(lost) if value.abs() >= f64::from(f16::MIN_POSITIVE) => lost.absolute.min(lost.relative * value.abs()),
            Some(lost) => lost.absolute,
            None => self.encoding.half_ulp_at(value, largest),
        }
    }

    /// The largest error in proportion to its value, over values of at least 2⁻¹⁴.
    pub fn relative(&self) -> f64 {
        self.lost.map_or(self.encoding.half_ulp_at(1.0, 1.0), |lost| lost.relative)
    }

    /// The root mean square of the same, over a sample of texels. Blocks lose most beside the brightest texels, which are
    /// in every sample: nothing less than their largest error bounds it.
    pub fn relative_rms(&self) -> f64 {
        match self.lost {
            Some(lost) if !self.encoding.repr.is_blocks() => lost.relative.min(SAMPLE * lost.relative_rms),
            _ => self.relative(),
        }
    }
}
