// SPDX-License-Identifier: MIT OR Apache-2.0
//! The transfer function of sRGB.

/// The encoded value of a linear one. IEC 61966-2-1:1999. Domain: [0, 1].
pub fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The 8-bit number nearest to a linear value; what lies outside [0, 1] takes the nearer end.
pub fn encode_8_bit(linear: f64) -> u8 {
    (255.0 * encode(linear.clamp(0.0, 1.0))).round() as u8
}
