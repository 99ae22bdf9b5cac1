//! IEEE 754 halves and singles, little endian.

use half::f16;

use super::{exp2i, exponent};

/// The largest half float.
pub const HALF_MAX: f32 = 65504.0;

pub fn encode_halves(components: &[f32], out: &mut Vec<u8>) {
    components.iter().for_each(|v| out.extend(f16::from_f32(*v).to_le_bytes()));
}

pub fn encode_singles(components: &[f32], out: &mut Vec<u8>) {
    components.iter().for_each(|v| out.extend(v.to_le_bytes()));
}

pub fn decode_halves(texel: &[u8]) -> [f32; 4] {
    let mut values = [0.0; 4];
    values.iter_mut().zip(texel.as_chunks().0).for_each(|(to, b)| *to = f16::from_le_bytes(*b).to_f32());
    values
}

pub fn decode_singles(texel: &[u8]) -> [f32; 4] {
    let mut values = [0.0; 4];
    values.iter_mut().zip(texel.as_chunks().0).for_each(|(to, b)| *to = f32::from_le_bytes(*b));
    values
}

/// Half the distance of neighbouring halves: below 2^−14 they are subnormal, 2^−24 apart.
pub fn half_ulp_of_half(value: f64) -> f64 {
    exp2i(exponent(value).max(-14) - 11)
}

/// The same of singles: 2^−126 and 2^−149.
pub fn half_ulp_of_single(value: f64) -> f64 {
    exp2i(exponent(value).max(-126) - 24)
}
