// SPDX-License-Identifier: MIT OR Apache-2.0
//! Three floats without sign in a word of 32 bits, red lowest (Khronos Data Format Specification 1.3, the chapters on
//! unsigned 10- and 11-bit floats and on shared exponents).

use half::f16;

use super::{exp2i, exponent, word};

/// 511 · 2^7: mantissa and exponent at their largest.
pub const RGB9E5_MAX: f32 = 65408.0;
/// The largest float of 10 bits; those of 11 bits reach 65024.
pub const B10_MAX: f32 = 64512.0;

/// Mantissas of 9 bits that share an exponent of 5 (VK_FORMAT_E5B9G9R9_UFLOAT_PACK32). The components lie in
/// [0, [`RGB9E5_MAX`]].
pub fn encode_rgb9e5(rgb: [f32; 3], out: &mut Vec<u8>) {
    let e = shared_exponent(rgb.iter().fold(0.0, |a: f64, b| a.max(f64::from(*b))));
    let mantissa = |v: f32| (f64::from(v) * exp2i(24 - e)).round_ties_even() as u32;
    let word = mantissa(rgb[0]) | mantissa(rgb[1]) << 9 | mantissa(rgb[2]) << 18 | (e as u32) << 27;
    out.extend(word.to_le_bytes());
}

pub fn decode_rgb9e5(texel: &[u8]) -> [f32; 4] {
    let word = word(texel);
    let scale = exp2i((word >> 27) as i32 - 24);
    let component = |shift: u32| (f64::from(word >> shift & 0x1ff) * scale) as f32;
    [component(0), component(9), component(18), 1.0]
}

/// The least exponent e, with its bias, for which the mantissa of `largest` = m · 2^(e−24) rounds to at most 511.
fn shared_exponent(largest: f64) -> i32 {
    let e = (exponent(largest).max(-16) + 16).clamp(0, 31);
    if largest * exp2i(24 - e) >= 511.5 { e + 1 } else { e }
}

/// Half a step of a texel with this largest component.
pub fn half_step_of_rgb9e5(largest: f64) -> f64 {
    exp2i(shared_exponent(largest.min(f64::from(RGB9E5_MAX))) - 25)
}

/// Exponents of 5 bits and mantissas of 6, 6 and 5 (VK_FORMAT_B10G11R11_UFLOAT_PACK32). The components lie in
/// [0, [`B10_MAX`]].
pub fn encode_b10g11r11(rgb: [f32; 3], out: &mut Vec<u8>) {
    // A half float has the same exponents: rounded to fewer bits first, its own conversion is exact.
    let half = |v: f32, bits: i32| {
        let step = exp2i(exponent(f64::from(v)).max(-14) - bits);
        u32::from(f16::from_f64((f64::from(v) / step).round_ties_even() * step).to_bits())
    };
    let word = half(rgb[0], 6) >> 4 | half(rgb[1], 6) >> 4 << 11 | half(rgb[2], 5) >> 5 << 22;
    out.extend(word.to_le_bytes());
}

pub fn decode_b10g11r11(texel: &[u8]) -> [f32; 4] {
    let word = word(texel);
    let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
    [half((word & 0x7ff) << 4), half((word >> 11 & 0x7ff) << 4), half(word >> 22 << 5), 1.0]
}

/// Half the distance of neighbouring blue components; red and green are twice as fine.
pub fn half_step_of_b10g11r11(value: f64) -> f64 {
    exp2i(exponent(value).max(-14) - 6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rgb9e5(rgb: [f32; 3]) -> u32 {
        let mut out = vec![];
        encode_rgb9e5(rgb, &mut out);
        word(&out)
    }

    fn b10g11r11(rgb: [f32; 3]) -> u32 {
        let mut out = vec![];
        encode_b10g11r11(rgb, &mut out);
        word(&out)
    }

    #[test]
    fn words_are_those_of_the_specification() {
        // 1 is 256 · 2^−8 at exponent 16; the largest is 511 · 2^7.
        assert_eq!(rgb9e5([1.0, 0.0, 0.0]), 16 << 27 | 256);
        assert_eq!(rgb9e5([RGB9E5_MAX; 3]), u32::MAX);
        assert_eq!(rgb9e5([0.999, 0.0, 0.0]), 15 << 27 | 511);
        assert_eq!(rgb9e5([0.9999, 0.0, 0.0]), 16 << 27 | 256, "511.9 has no mantissa");
        // Everything below half of 2^−24 is 0.
        assert_eq!(rgb9e5([2e-8, 4e-8, 0.0]), 1 << 9);
        // 1 has the exponent 15.
        assert_eq!(b10g11r11([1.0, 2.0, 0.5]), 15 << 6 | 16 << 17 | 14 << 27);
        assert_eq!(b10g11r11([1.0 + 1.0 / 128.0; 3]), 15 << 6 | 15 << 17 | 15 << 27, "a tie goes to even");
        assert_eq!(b10g11r11([B10_MAX; 3]) >> 22, 30 << 5 | 31);
    }

    #[test]
    fn every_word_comes_back() {
        // Miri takes minutes for all of them.
        for i in (0..1u32 << 16).step_by(if cfg!(miri) { 61 } else { 1 }) {
            // All floats of 11 and of 10 bits that are finite.
            let (r, b) = (i % (31 << 6), i % (31 << 5));
            let word = r | r << 11 | b << 22;
            let [x, y, z, _] = decode_b10g11r11(&word.to_le_bytes());
            assert_eq!(b10g11r11([x, y, z]), word);
            // A largest mantissa with its highest bit set, as it is written.
            let word = (256 | i & 0xff) | (i >> 7 & 0x1ff) << 9 | (i & 31) << 27;
            let [x, y, z, _] = decode_rgb9e5(&word.to_le_bytes());
            assert_eq!(rgb9e5([x, y, z]), word);
        }
    }
}
