// SPDX-License-Identifier: MIT OR Apache-2.0
//! IEEE 754 halves and singles, little endian.

use half::f16;
use half::slice::HalfFloatSliceExt;
use half::vec::HalfFloatVecExt;

use super::{exp2i, exponent};

/// The largest half float.
pub const HALF_MAX: f32 = 65504.0;

/// Many at once: processors convert eight halves in an instruction.
pub fn encode_halves(components: &[f32], out: &mut Vec<u8>) {
    let halves = Vec::<f16>::from_f32_slice(components);
    let start = out.len();
    out.resize(start + 2 * halves.len(), 0);
    out[start..].as_chunks_mut().0.iter_mut().zip(halves).for_each(|(to, half)| *to = half.to_le_bytes());
}

pub fn encode_singles(components: &[f32], out: &mut Vec<u8>) {
    components.iter().for_each(|v| out.extend(v.to_le_bytes()));
}

/// Components of any number of texels.
pub fn decode_halves(bytes: &[u8]) -> Vec<f32> {
    let halves: Vec<f16> = bytes.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b)).collect();
    halves.to_f32_vec()
}

/// Components of any number of texels.
pub fn decode_singles(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

/// Half the distance of neighbouring halves: below 2^−14 they are subnormal, 2^−24 apart.
pub fn half_ulp_of_half(value: f64) -> f64 {
    exp2i(exponent(value).max(-14) - 11)
}

/// The same of singles: 2^−126 and 2^−149.
pub fn half_ulp_of_single(value: f64) -> f64 {
    exp2i(exponent(value).max(-126) - 24)
}
