// SPDX-License-Identifier: MIT OR Apache-2.0
//! Unsigned integers over [0, 1]: 8 or 16 bits a component, or 10 bits of red, green and blue in one word.

/// The largest integer of 10 bits.
pub const TEN_BITS: f64 = 1023.0;

pub fn encode_bytes(components: &[f32], out: &mut Vec<u8>) {
    components.iter().for_each(|v| out.push((v * 255.0).round_ties_even() as u8));
}

/// Little endian. In f64: v · 65535 needs 40 bits, and a product rounded to f32 could fall on the wrong side of a tie.
pub fn encode_words(components: &[f32], out: &mut Vec<u8>) {
    components.iter().for_each(|v| out.extend(((f64::from(*v) * 65535.0).round_ties_even() as u16).to_le_bytes()));
}

pub fn decode_bytes(texel: &[u8]) -> [f32; 4] {
    let mut values = [0.0; 4];
    values.iter_mut().zip(texel).for_each(|(to, b)| *to = f32::from(*b) / 255.0);
    values
}

pub fn decode_words(texel: &[u8]) -> [f32; 4] {
    let mut values = [0.0; 4];
    values.iter_mut().zip(texel.as_chunks().0).for_each(|(to, b)| *to = f32::from(u16::from_le_bytes(*b)) / 65535.0);
    values
}

/// Red in the lowest 10 bits, alpha, which is 1, in the highest 2 (VK_FORMAT_A2B10G10R10_UNORM_PACK32).
pub fn encode_ten(components: &[f32], out: &mut Vec<u8>) {
    let code = |v: f32| (f64::from(v) * TEN_BITS).round_ties_even() as u32;
    let word = code(components[0]) | code(components[1]) << 10 | code(components[2]) << 20 | 3 << 30;
    out.extend(word.to_le_bytes());
}

pub fn decode_ten(texel: &[u8]) -> [f32; 4] {
    let word = super::word(texel);
    let code = |shift: u32| (f64::from(word >> shift & 0x3ff) / TEN_BITS) as f32;
    [code(0), code(10), code(20), 1.0]
}
