// SPDX-License-Identifier: MIT OR Apache-2.0
//! Radiance in four bytes: red, green and blue, and an alpha that says what they are to be multiplied with.
//!
//! With r the byte of a component and a that of alpha, both over 255:
//!
//! | | value | largest | as in |
//! |---|---|---|---|
//! | `rgbd8` | r^2.2 / a | 255 | Babylon.js: `toRGBD` and `fromRGBD` of its shaders |
//! | `rgbm8` | (8 r a)² | 64 | PlayCanvas: `decodeRGBM` |
//! | `rgbp8` | (r (8 − 7 a))² | 64 | PlayCanvas: `decodeRGBP` |
//!
//! Alpha is the one that its engine chooses: it follows from the texel's largest component, and leaves the others the
//! largest bytes. A component then takes the byte whose value lies nearest.

/// Which of the three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    Rgbd,
    Rgbm,
    Rgbp,
}

impl Range {
    /// The largest value.
    pub fn max(self) -> f32 {
        if self == Range::Rgbd { 255.0 } else { 64.0 }
    }

    /// How a shader gets the value back.
    pub fn formula(self) -> &'static str {
        match self {
            Range::Rgbd => "pow(rgb, 2.2) / a",
            Range::Rgbm => "(8 rgb a)^2",
            Range::Rgbp => "(rgb (8 - 7 a))^2",
        }
    }

    /// The byte of alpha of a texel with this largest component.
    fn alpha(self, largest: f64) -> u8 {
        let largest = largest.clamp(0.0, f64::from(self.max()));
        match self {
            Range::Rgbd => (255.0 / largest.max(1.0)).floor() as u8,
            Range::Rgbm => (255.0 * largest.sqrt() / 8.0).ceil().max(1.0) as u8,
            Range::Rgbp => (255.0 * (1.0 - (largest.sqrt().max(1.0) - 1.0) / 7.0)).floor() as u8,
        }
    }

    fn value(self, byte: f64, alpha: u8) -> f64 {
        let (r, a) = (byte / 255.0, f64::from(alpha) / 255.0);
        match self {
            Range::Rgbd => r.powf(2.2) / a,
            Range::Rgbm => (8.0 * r * a).powi(2),
            Range::Rgbp => (r * (8.0 - 7.0 * a)).powi(2),
        }
    }

    /// The inverse of [`Range::value`], between two bytes.
    fn byte(self, value: f64, alpha: u8) -> f64 {
        let a = f64::from(alpha) / 255.0;
        let r = match self {
            Range::Rgbd => (value * a).powf(1.0 / 2.2),
            Range::Rgbm => value.sqrt() / (8.0 * a),
            Range::Rgbp => value.sqrt() / (8.0 - 7.0 * a),
        };
        (255.0 * r).min(255.0)
    }

    /// The components lie in [0, [`Range::max`]].
    pub fn encode(self, rgb: [f32; 3]) -> [u8; 4] {
        let alpha = self.alpha(rgb.iter().fold(0.0, |a: f64, b| a.max(f64::from(*b))));
        let nearest = |v: f32| {
            let v = f64::from(v);
            let below = self.byte(v, alpha).floor();
            let above = (below + 1.0).min(255.0);
            let off = |byte: f64| (self.value(byte, alpha) - v).abs();
            (if off(below) <= off(above) { below } else { above }) as u8
        };
        [nearest(rgb[0]), nearest(rgb[1]), nearest(rgb[2]), alpha]
    }

    /// Finite for every texel: an alpha of 0, by which `rgbd8` would divide, is written by none and read as 1/255.
    pub fn decode(self, [r, g, b, a]: [u8; 4]) -> [f32; 3] {
        let alpha = if self == Range::Rgbd { a.max(1) } else { a };
        [r, g, b].map(|byte| self.value(f64::from(byte), alpha) as f32)
    }

    /// Half the distance of neighbouring values near `value`, in a texel whose largest component is about `largest`.
    pub fn half_step(self, value: f64, largest: f64) -> f64 {
        let step = |value: f64, alpha: u8| {
            let below = self.byte(value.max(0.0), alpha).floor().min(254.0);
            0.5 * (self.value(below + 1.0, alpha) - self.value(below, alpha))
        };
        // `largest` may be a rounded one, and the texel's own alpha that of one a little larger.
        let own = self.alpha(largest);
        let coarser = self.alpha(largest + step(largest, own));
        step(value, own).max(step(value, coarser))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_are_those_of_the_engines() {
        assert_eq!(Range::Rgbd.encode([1.0, 0.0, 0.5]), [255, 0, 186, 255]);
        assert_eq!(Range::Rgbd.encode([255.0, 1.0, 0.0]), [255, 21, 0, 1]);
        // 127 and 128 are as far from half by their roots; squared, 127 is nearer.
        assert_eq!(Range::Rgbm.encode([64.0, 16.0, 0.0]), [255, 127, 0, 255]);
        assert_eq!(Range::Rgbp.encode([1.0, 0.25, 0.0]), [255, 127, 0, 255]);
        assert_eq!(Range::Rgbp.encode([64.0, 64.0, 0.0]), [255, 255, 0, 0]);
        assert_eq!(Range::Rgbd.decode([255, 0, 0, 0]), [255.0, 0.0, 0.0], "no division by 0");
    }
}
