// SPDX-License-Identifier: MIT OR Apache-2.0
//! The decoder's arithmetic, exact to the bit (Khronos Data Format Specification 1.3, the chapter on BPTC; unsigned).
//!
//! A *code* is an endpoint as a block stores it, 6 to 16 bits. It stands for a *level* from 0 to 65535. A texel's level
//! lies between those of two endpoints, and 31/64 of it are the bits of a half float. Levels are therefore nearly
//! logarithmic: 2114 of them double a value.

/// Shares of the second endpoint in 64ths that 3 bits of an index choose.
pub const STEPS_OF_3_BITS: [f32; 8] = [0.0, 9.0, 18.0, 27.0, 37.0, 46.0, 55.0, 64.0];
/// The same of 4 bits.
pub const STEPS_OF_4_BITS: [f32; 16] =
    [0.0, 4.0, 9.0, 13.0, 17.0, 21.0, 26.0, 30.0, 34.0, 38.0, 43.0, 47.0, 51.0, 55.0, 60.0, 64.0];

/// The largest level, that of the largest half float.
pub const TOP_LEVEL: f32 = 65535.0;
/// The smallest normal half float, 2⁻¹⁴. Below it halves are evenly spaced.
pub const SMALLEST_NORMAL: f32 = 1.0 / 16384.0;
/// 2¹¹²: from the exponent of a half float to that of a single.
const HALF_BIAS: f32 = (1_u128 << 112) as f32;

/// The level of a code of so many bits.
pub fn unquantize(code: i32, bits: u32) -> f32 {
    let level = match code {
        _ if bits >= 15 => code,
        0 => 0,
        _ if code == (1 << bits) - 1 => 0xffff,
        _ => ((code << 16) + 0x8000) >> bits,
    };
    level as f32
}

/// The code of so many bits that is nearest to a level in [0, 65535], to a step of the bits.
pub fn quantize(level: f32, bits: u32) -> i32 {
    let code = if bits >= 15 { level + 0.5 } else { level * (1_u32 << bits) as f32 / 65536.0 };
    (code as i32).min((1 << bits) - 1)
}

/// The value at a step between two levels. Products stay below 2²⁴, where singles are exact integers.
#[inline(always)]
pub fn value(level_a: f32, level_b: f32, step: f32) -> f32 {
    let level = ((level_a * (64.0 - step) + level_b * step + 32.0) as i32) >> 6;
    let half = ((level << 5) - level) >> 6;
    f32::from_bits((half as u32) << 13) * HALF_BIAS
}

/// The level of a value in [0, 65504], not rounded.
pub fn level(value: f32) -> f32 {
    let half = if value >= SMALLEST_NORMAL {
        // The difference of the bits fits a single to a 64th of a half's step.
        (value.to_bits() - HALF_ZERO) as f32 / 8192.0
    } else {
        value * 16_777_216.0
    };
    half * 64.0 / 31.0
}

/// A single's bits where a half's exponent is 0.
const HALF_ZERO: u32 = 112 << 23;

/// By how much a value in [0, 65504] grows a level.
pub fn slope(value: f32) -> f32 {
    let exponent = value.max(SMALLEST_NORMAL).to_bits() & 0x7f80_0000;
    f32::from_bits(exponent) * (31.0 / 64.0 / 1024.0)
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;

    #[test]
    fn values_of_levels_are_halves() {
        for level in (0..=0xffff_u32).step_by(7).chain([0xffff]) {
            let half = f16::from_bits((level * 31 / 64) as u16).to_f32();
            assert_eq!(value(level as f32, 1.0, 0.0), half);
            assert_eq!(value(1.0, level as f32, 64.0), half);
        }
        assert_eq!(value(TOP_LEVEL, TOP_LEVEL, 30.0), 65504.0);
    }

    #[test]
    fn levels_are_the_inverse_and_slopes_their_growth() {
        for bits in (0..0x7bff_u16).step_by(13) {
            let (v, next) = (f16::from_bits(bits).to_f32(), f16::from_bits(bits + 1).to_f32());
            assert!((level(v) - f32::from(bits) * 64.0 / 31.0).abs() < 0.01, "{bits:#x}");
            assert!((slope(v) * 64.0 / 31.0 / (next - v) - 1.0).abs() < 1e-6, "{bits:#x}");
        }
    }

    #[test]
    fn codes_are_nearest() {
        for bits in [6, 7, 8, 9, 10, 11, 12, 16] {
            for code in (0..1_i32 << bits).step_by(11).chain([(1 << bits) - 1]) {
                assert_eq!(quantize(unquantize(code, bits), bits), code, "{bits} bits");
            }
        }
        assert_eq!(quantize(TOP_LEVEL, 10), 1023);
    }
}
