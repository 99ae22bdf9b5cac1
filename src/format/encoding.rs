//! How a value is stored: components × representation, and what that costs in precision.

use std::ops::RangeInclusive;

use half::f16;

use crate::error::{Error, Result, nearest};
use crate::texture::Texture;

/// How one component is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repr {
    /// IEEE 754 half float: 11 significant bits, largest value 65504.
    F16,
    /// IEEE 754 single float.
    F32,
    /// Unsigned integer over [0, 1], 8 bits.
    Unorm8,
    /// Unsigned integer over [0, 1], 16 bits.
    Unorm16,
    /// Radiance RGBE: 8-bit mantissas that share one exponent.
    Rgbe8,
}

impl Repr {
    /// The values that a component can hold; beyond them it is clamped.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Repr::F16 => -65504.0..=65504.0,
            Repr::F32 => f32::MIN..=f32::MAX,
            Repr::Unorm8 | Repr::Unorm16 => 0.0..=1.0,
            Repr::Rgbe8 => 0.0..=RGBE_MAX,
        }
    }
}

/// A texel's encoding, named after Vulkan's formats in lower case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoding {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// Components a texel: 1, 2, 3 or 4. Components beyond the table's channels hold 0, a fourth one 1.
    pub components: usize,
    /// How each component is stored.
    pub repr: Repr,
}

/// Every encoding, in the order of their documentation.
pub const ENCODINGS: &[Encoding] = &[
    Encoding { name: "r16f", components: 1, repr: Repr::F16 },
    Encoding { name: "rg16f", components: 2, repr: Repr::F16 },
    Encoding { name: "rgba16f", components: 4, repr: Repr::F16 },
    Encoding { name: "r32f", components: 1, repr: Repr::F32 },
    Encoding { name: "rg32f", components: 2, repr: Repr::F32 },
    Encoding { name: "rgba32f", components: 4, repr: Repr::F32 },
    Encoding { name: "r8unorm", components: 1, repr: Repr::Unorm8 },
    Encoding { name: "rgb8unorm", components: 3, repr: Repr::Unorm8 },
    Encoding { name: "r16unorm", components: 1, repr: Repr::Unorm16 },
    Encoding { name: "rgb16unorm", components: 3, repr: Repr::Unorm16 },
    Encoding { name: "rgbe8", components: 3, repr: Repr::Rgbe8 },
];

impl Encoding {
    /// The encoding with this name.
    pub fn parse(name: &str) -> Result<Encoding> {
        ENCODINGS.iter().copied().find(|e| e.name == name).ok_or_else(|| {
            Error::usage(format!("unknown encoding '{name}'"), nearest(name, ENCODINGS.iter().map(|e| e.name)))
        })
    }

    /// The encoding with the fewest components, at least `channels`, of one representation.
    pub fn fitting(repr: Repr, channels: usize) -> Option<Encoding> {
        ENCODINGS.iter().copied().filter(|e| e.repr == repr && e.components >= channels).min_by_key(|e| e.components)
    }

    /// Bytes a texel.
    pub fn texel_bytes(self) -> usize {
        match self.repr {
            Repr::F16 | Repr::Unorm16 => 2 * self.components,
            Repr::F32 => 4 * self.components,
            Repr::Unorm8 => self.components,
            Repr::Rgbe8 => 4,
        }
    }

    /// The largest error that rounding can make near `value`: half the distance between neighbouring values.
    ///
    /// `largest` is the largest component of the texel, which sets the step of [`Repr::Rgbe8`]; the others ignore it.
    /// A value outside [`Repr::range`] is clamped, which this bound does not cover.
    pub fn half_ulp_at(self, value: f64, largest: f64) -> f64 {
        match self.repr {
            // Below 2^-14 a half float is subnormal: its values are 2^-24 apart. Single floats: 2^-126 and 2^-149.
            Repr::F16 => exp2i(exponent(value).max(-14) - 11),
            Repr::F32 => exp2i(exponent(value).max(-126) - 24),
            Repr::Unorm8 => 0.5 / 255.0,
            Repr::Unorm16 => 0.5 / 65535.0,
            Repr::Rgbe8 if largest < f64::from(RGBE_MIN) => f64::from(RGBE_MIN),
            Repr::Rgbe8 => exp2i(rgbe_exponent(largest) - 9),
        }
    }
}

/// Below this a texel's largest component is written as black, as Radiance itself does.
const RGBE_MIN: f32 = 1e-32;
/// 255 · 2^119: mantissa and exponent at their largest.
const RGBE_MAX: f32 = 255.0 * (1_u128 << 119) as f32;

fn exp2i(n: i32) -> f64 {
    f64::from(n).exp2()
}

/// ⌊log₂|value|⌋, exact; far below every bound for 0.
fn exponent(value: f64) -> i32 {
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// The shared exponent e for which the largest component, m · 2^(e−8), has its rounded mantissa m in 128..=255.
fn rgbe_exponent(largest: f64) -> i32 {
    let e = exponent(largest) + 1;
    // 255.5 and more would round to 256, which no byte holds.
    let e = if largest * exp2i(8 - e) >= 255.5 { e + 1 } else { e };
    e.min(127)
}

fn rgbe_encode(rgb: [f32; 3]) -> [u8; 4] {
    let rgb = rgb.map(|v| v.clamp(0.0, RGBE_MAX));
    let largest = rgb.iter().fold(0.0, |a: f32, &b| a.max(b));
    if largest < RGBE_MIN {
        return [0; 4];
    }
    let e = rgbe_exponent(f64::from(largest));
    let mantissa = |v: f32| (f64::from(v) * exp2i(8 - e)).round_ties_even() as u8;
    [mantissa(rgb[0]), mantissa(rgb[1]), mantissa(rgb[2]), (e + 128) as u8]
}

pub(super) fn rgbe_decode([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    let scale = if e == 0 { 0.0 } else { exp2i(i32::from(e) - 136) };
    [r, g, b].map(|m| (f64::from(m) * scale) as f32)
}

/// Texels as bytes, little endian, rounded to nearest even. Components beyond the channels hold 0, a fourth one 1;
/// a value outside [`Repr::range`] becomes the nearest one inside, NaN stays NaN in floats and becomes 0 elsewhere.
pub fn encode(values: &[f32], channels: usize, encoding: Encoding) -> Result<Vec<u8>> {
    fits(channels, encoding)?;
    let range = encoding.repr.range();
    let mut bytes = Vec::with_capacity(values.len() / channels * encoding.texel_bytes());
    for texel in values.chunks_exact(channels) {
        let mut padded = [0.0, 0.0, 0.0, 1.0];
        padded[..channels].copy_from_slice(texel);
        let components = padded[..encoding.components].iter().map(|v| v.clamp(*range.start(), *range.end()));
        match encoding.repr {
            Repr::F16 => components.for_each(|v| bytes.extend(f16::from_f32(v).to_le_bytes())),
            Repr::F32 => components.for_each(|v| bytes.extend(v.to_le_bytes())),
            Repr::Unorm8 => components.for_each(|v| bytes.push((v * 255.0).round_ties_even() as u8)),
            // In f64: v · 65535 needs 40 bits, and a product rounded to f32 could fall on the wrong side of a tie.
            Repr::Unorm16 => {
                components.for_each(|v| bytes.extend(((f64::from(v) * 65535.0).round_ties_even() as u16).to_le_bytes()))
            }
            Repr::Rgbe8 => bytes.extend(rgbe_encode([padded[0], padded[1], padded[2]])),
        }
    }
    Ok(bytes)
}

/// The first `channels` components of each texel: what [`encode`] wrote. A texel cut short at the end is left out.
pub fn decode(bytes: &[u8], channels: usize, encoding: Encoding) -> Vec<f32> {
    let channels = channels.min(encoding.components);
    let mut values = Vec::with_capacity(bytes.len() / encoding.texel_bytes() * channels);
    for texel in bytes.chunks_exact(encoding.texel_bytes()) {
        match encoding.repr {
            Repr::F16 => {
                values.extend(texel.as_chunks().0.iter().take(channels).map(|b| f16::from_le_bytes(*b).to_f32()));
            }
            Repr::F32 => values.extend(texel.as_chunks().0.iter().take(channels).map(|b| f32::from_le_bytes(*b))),
            Repr::Unorm8 => values.extend(texel.iter().take(channels).map(|b| f32::from(*b) / 255.0)),
            Repr::Unorm16 => values
                .extend(texel.as_chunks().0.iter().take(channels).map(|b| f32::from(u16::from_le_bytes(*b)) / 65535.0)),
            Repr::Rgbe8 => {
                values.extend(texel.as_chunks().0.iter().flat_map(|b| rgbe_decode(*b).into_iter().take(channels)));
            }
        }
    }
    values
}

/// What an encoding did to the values of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// The largest difference between a value and what is stored; values that were clamped are left out.
    pub max_abs: f64,
    /// The largest difference relative to the value, over values of at least 2⁻¹⁴: the smallest normal half float.
    /// Below it halves are evenly spaced, and the ratio only tells how near to 0 a value happens to lie.
    pub max_rel: f64,
    /// Values outside [`Repr::range`], stored as its nearest end.
    pub clamped: usize,
}

/// Encodes and decodes every texel, and compares.
pub fn rounding(texture: &Texture, encoding: Encoding) -> Result<Rounding> {
    let channels = texture.channels.len();
    let range = encoding.repr.range();
    let mut report = Rounding::default();
    for level in &texture.levels {
        let stored = decode(&encode(level, channels, encoding)?, channels, encoding);
        for (&value, stored) in level.iter().zip(stored) {
            if !range.contains(&value) {
                report.clamped += 1;
                continue;
            }
            let error = (f64::from(stored) - f64::from(value)).abs();
            report.max_abs = report.max_abs.max(error);
            if value.abs() >= f16::MIN_POSITIVE.to_f32() {
                report.max_rel = report.max_rel.max(error / f64::from(value.abs()));
            }
        }
    }
    Ok(report)
}

/// An error when a texel of `encoding` has fewer components than a texture has channels.
pub(super) fn fits(channels: usize, encoding: Encoding) -> Result<()> {
    if (1..=encoding.components).contains(&channels) {
        return Ok(());
    }
    let what =
        format!("encoding {} holds {} components, the texture has {channels}", encoding.name, encoding.components);
    let help = match Encoding::fitting(encoding.repr, channels).or(Encoding::fitting(Repr::F16, channels)) {
        Some(other) if channels > 0 => format!("use {}", other.name),
        _ => "a texture has 1 to 4 channels".into(),
    };
    Err(Error::usage(what, help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Meta, Shape};

    fn by_name(name: &str) -> Encoding {
        Encoding::parse(name).expect("a name of the list")
    }

    fn round(value: f32, name: &str) -> f32 {
        decode(&encode(&[value], 1, by_name(name)).unwrap(), 1, by_name(name))[0]
    }

    #[test]
    fn half_rounds_to_nearest_even() {
        // Halves near 1 are 2^-10 apart: the ties go to the even mantissa, down once and up once.
        assert_eq!(round(1.0 + 1.0 / 2048.0, "r16f"), 1.0);
        assert_eq!(round(1.0 + 3.0 / 2048.0, "r16f"), 1.0 + 2.0 / 1024.0);
        assert_eq!(round(2.0_f32.powi(-25) * 1.001, "r16f"), 2.0_f32.powi(-24), "subnormal");
    }

    #[test]
    fn padding_is_zero_and_a_fourth_component_one() {
        let bytes = encode(&[0.25, 0.5], 2, by_name("rgba16f")).unwrap();
        assert_eq!(decode(&bytes, 4, by_name("rgba16f")), [0.25, 0.5, 0.0, 1.0]);
        let bytes = encode(&[0.2], 1, by_name("rgb8unorm")).unwrap();
        assert_eq!(bytes, [51, 0, 0]);
    }

    #[test]
    fn bytes_are_little_endian() {
        assert_eq!(encode(&[1.0], 1, by_name("r16f")).unwrap(), [0x00, 0x3c]);
        assert_eq!(encode(&[1.0], 1, by_name("r32f")).unwrap(), [0, 0, 0x80, 0x3f]);
        assert_eq!(encode(&[1.0 / 65535.0], 1, by_name("r16unorm")).unwrap(), [1, 0]);
    }

    #[test]
    fn rgbe_keeps_the_largest_component_within_its_step() {
        assert_eq!(rgbe_encode([1.0, 0.5, 0.0]), [128, 64, 0, 129]);
        assert_eq!(rgbe_encode([0.999, 0.5, 0.0]), [128, 64, 0, 129], "255.74 rounds up into the next exponent");
        assert_eq!(rgbe_encode([1e-33, 0.0, 0.0]), [0; 4]);
        assert_eq!(rgbe_decode(rgbe_encode([RGBE_MAX, f32::MAX, -1.0])), [RGBE_MAX, RGBE_MAX, 0.0]);
    }

    #[test]
    fn too_many_channels_is_an_error_that_names_a_fit() {
        let error = encode(&[0.0; 3], 3, by_name("rg16f")).unwrap_err();
        assert_eq!(error.to_string(), "encoding rg16f holds 2 components, the texture has 3");
        assert_eq!(error.help(), "use rgba16f");
        assert_eq!(encode(&[0.0; 4], 4, by_name("rgb8unorm")).unwrap_err().help(), "use rgba16f");
        assert_eq!(encode(&[], 0, by_name("r16f")).unwrap_err().help(), "a texture has 1 to 4 channels");
    }

    /// A multiplicative walk over all magnitudes, both signs where the representation has them.
    fn probes(encoding: Encoding) -> Vec<f32> {
        let (low, high) = (*encoding.repr.range().start(), *encoding.repr.range().end());
        let mut values = vec![0.0, high, low];
        let mut v = 1e-12_f32;
        while v < high.min(1e12) {
            values.extend([v, if low < 0.0 { -v } else { v }]);
            v *= 1.0137;
        }
        values
    }

    #[test]
    fn half_ulp_bounds_the_rounding_and_is_reached() {
        for &encoding in ENCODINGS {
            let mut worst = 0.0_f64;
            for value in probes(encoding) {
                let stored = round(value, encoding.name);
                let error = (f64::from(stored) - f64::from(value)).abs();
                let bound = encoding.half_ulp_at(f64::from(value), f64::from(value));
                // Decoded integers are themselves rounded to f32: half an ulp of that on top.
                assert!(error <= bound + 6e-8 * f64::from(value.abs()), "{}: {value} → {stored}", encoding.name);
                worst = worst.max(error / bound);
            }
            if encoding.repr == Repr::F32 {
                assert_eq!(worst, 0.0);
            } else {
                assert!(worst > 0.9, "{}: the bound is never approached, {worst}", encoding.name);
            }
        }
    }

    #[test]
    fn half_ulp_matches_the_spacing_of_halves() {
        let e = by_name("r16f");
        for bits in [0_u16, 1, 0x3ff, 0x400, 0x3bff, 0x3c00, 0x3c01, 0x7bfe] {
            let (a, b) = (f16::from_bits(bits).to_f64(), f16::from_bits(bits + 1).to_f64());
            assert_eq!(e.half_ulp_at(0.5 * (a + b), 0.0), 0.5 * (b - a), "{bits:#x}");
        }
    }

    fn table(values: Vec<f32>) -> Texture {
        let width = values.len() as u32;
        let channels = vec!["a".to_string()];
        Texture { shape: Shape::Table, width, height: 1, channels, levels: vec![values], meta: Meta::default() }
    }

    #[test]
    fn rounding_reports_error_and_clamping() {
        let tie = 1.0 + 1.0 / 2048.0;
        let report = rounding(&table(vec![0.5, tie, 70000.0, 65504.0]), by_name("r16f")).unwrap();
        assert_eq!(report, Rounding { max_abs: 1.0 / 2048.0, max_rel: 1.0 / 2048.0 / f64::from(tie), clamped: 1 });
        assert_eq!(rounding(&table(vec![0.1, 1e30]), by_name("r32f")).unwrap(), Rounding::default());
    }
}
