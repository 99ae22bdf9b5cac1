// SPDX-License-Identifier: MIT OR Apache-2.0
//! Radiance's RGBE: mantissas of 8 bits that share one exponent (Ward 1991, Real Pixels).

use super::{exp2i, exponent};

/// Below this a texel's largest component is written as black, as Radiance itself does.
const MIN: f32 = 1e-32;
/// 255 · 2^119: mantissa and exponent at their largest.
pub const MAX: f32 = 255.0 * (1_u128 << 119) as f32;

/// The shared exponent e for which the largest component, m · 2^(e−8), has its rounded mantissa m in 128..=255.
fn shared_exponent(largest: f64) -> i32 {
    let e = exponent(largest) + 1;
    // 255.5 and more would round to 256, which no byte holds.
    let e = if largest * exp2i(8 - e) >= 255.5 { e + 1 } else { e };
    e.min(127)
}

pub fn encode(rgb: [f32; 3]) -> [u8; 4] {
    let rgb = rgb.map(|v| v.clamp(0.0, MAX));
    let largest = rgb.iter().fold(0.0, |a: f32, &b| a.max(b));
    if largest < MIN {
        return [0; 4];
    }
    let e = shared_exponent(f64::from(largest));
    let mantissa = |v: f32| (f64::from(v) * exp2i(8 - e)).round_ties_even() as u8;
    [mantissa(rgb[0]), mantissa(rgb[1]), mantissa(rgb[2]), (e + 128) as u8]
}

pub fn decode([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    let scale = if e == 0 { 0.0 } else { exp2i(i32::from(e) - 136) };
    [r, g, b].map(|m| (f64::from(m) * scale) as f32)
}

/// Half a step of a texel with this largest component.
pub fn half_step(largest: f64) -> f64 {
    if largest < f64::from(MIN) { f64::from(MIN) } else { exp2i(shared_exponent(largest) - 9) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_component_is_within_its_step() {
        assert_eq!(encode([1.0, 0.5, 0.0]), [128, 64, 0, 129]);
        assert_eq!(encode([0.999, 0.5, 0.0]), [128, 64, 0, 129], "255.74 rounds up into the next exponent");
        assert_eq!(encode([1e-33, 0.0, 0.0]), [0; 4]);
        assert_eq!(decode(encode([MAX, f32::MAX, -1.0])), [MAX, MAX, 0.0]);
    }
}
