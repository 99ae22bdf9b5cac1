// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a component may hold, and how its numbers may be encoded.

use std::f64::consts::TAU;

use crate::format::picture::{Picture, Value};
use crate::term::fresnel::Weights;

/// What a component holds, from the integrals E, B and T over the weights 1, (1 − v·h)⁵ and (v·h)(1 − v·h)⁶.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// E − B, the factor of F0.
    Scale,
    /// B, the factor of F90.
    Bias,
    /// E, the directional albedo with F = 1.
    Albedo,
    /// 1 − E, the energy that single scattering loses.
    Loss,
    /// T, what the F82 tint takes away.
    F82,
    /// E/2π: cloth tables of shaders that multiply with the hemisphere.
    AlbedoOverTau,
    /// B/2π.
    BiasOverTau,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 7] = [
        Quantity::Scale,
        Quantity::Bias,
        Quantity::Albedo,
        Quantity::Loss,
        Quantity::F82,
        Quantity::AlbedoOverTau,
        Quantity::BiasOverTau,
    ];

    /// As a report names it.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Scale => "scale",
            Quantity::Bias => "bias",
            Quantity::Albedo => "albedo",
            Quantity::Loss => "1 - albedo",
            Quantity::F82 => "f82",
            Quantity::AlbedoOverTau => "albedo/2pi",
            Quantity::BiasOverTau => "bias/2pi",
        }
    }

    /// Its value.
    pub fn of(self, [e, b, t, _]: Weights) -> f64 {
        match self {
            Quantity::Scale => e - b,
            Quantity::Bias => b,
            Quantity::Albedo => e,
            Quantity::Loss => 1.0 - e,
            Quantity::F82 => t,
            Quantity::AlbedoOverTau => e / TAU,
            Quantity::BiasOverTau => b / TAU,
        }
    }
}

/// How the stored components of a texel become values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// As they are.
    Linear,
    /// The curve of IEC 61966-2-1.
    Srgb,
    /// The power 2.2.
    Gamma22,
    /// Colour to the power 2.2, divided by alpha (Babylon.js).
    Rgbd,
    /// 16 bits in two bytes, the higher one first.
    TwoBytes,
}

impl Transfer {
    /// All of them.
    pub const ALL: [Transfer; 5] =
        [Transfer::Linear, Transfer::Srgb, Transfer::Gamma22, Transfer::Rgbd, Transfer::TwoBytes];

    /// As a report names it; empty for values as they are.
    pub fn words(self) -> &'static str {
        match self {
            Transfer::Linear => "",
            Transfer::Srgb => "encoded as sRGB",
            Transfer::Gamma22 => "encoded with gamma 2.2",
            Transfer::Rgbd => "encoded as RGBD, rgb^2.2/a",
            Transfer::TwoBytes => "16 bits in two bytes, the higher one first",
        }
    }

    /// Can a picture be encoded so? Curves and packings are made for integers.
    pub fn fits(self, picture: &Picture) -> bool {
        let bytes = picture.components.iter().all(|c| c.precision.steps() == Some(255));
        let integers = picture.components.iter().all(|c| c.precision.steps().is_some());
        match self {
            Transfer::Linear => true,
            Transfer::Srgb | Transfer::Gamma22 => integers,
            Transfer::Rgbd => bytes && picture.components.len() == 4,
            Transfer::TwoBytes => bytes && picture.components.len().is_multiple_of(2) && is_low_byte(picture, 1),
        }
    }

    /// Names of the values of a texel.
    pub fn names(self, picture: &Picture) -> Vec<String> {
        let own = || picture.components.iter().map(|c| c.name.clone());
        match self {
            Transfer::Rgbd => own().take(3).collect(),
            Transfer::TwoBytes => own().collect::<Vec<_>>().as_chunks::<2>().0.iter().map(|p| p.concat()).collect(),
            _ => own().collect(),
        }
    }

    /// Values of a texel, from its components.
    pub fn values(self, stored: &[Value]) -> Vec<f64> {
        self.decode(stored).into_iter().map(|v| v.value).collect()
    }

    /// Values of a texel and half the distance of neighbouring ones, from the same of its components.
    fn decode(self, stored: &[Value]) -> Vec<Value> {
        let curve = |of: fn(f64) -> f64, v: &Value| Value {
            value: of(v.value),
            half_step: 0.5 * (of((v.value + v.half_step).min(1.0)) - of((v.value - v.half_step).max(0.0))),
        };
        match self {
            Transfer::Linear => stored.to_vec(),
            Transfer::Srgb => stored.iter().map(|v| curve(from_srgb, v)).collect(),
            Transfer::Gamma22 => stored.iter().map(|v| curve(from_gamma, v)).collect(),
            Transfer::Rgbd => {
                let divisor = stored[3].value.max(1.0 / 255.0);
                let color = stored[..3].iter().map(|v| curve(from_gamma, v));
                color.map(|v| Value { value: v.value / divisor, half_step: v.half_step / divisor }).collect()
            }
            Transfer::TwoBytes => {
                let pair = |[high, low]: &[Value; 2]| Value {
                    value: (256.0 * high.value + low.value) / 257.0,
                    half_step: 0.5 / 65535.0,
                };
                stored.as_chunks().0.iter().map(pair).collect()
            }
        }
    }
}

/// Does a component jump from texel to texel, as the lower byte of a smooth number does?
fn is_low_byte(picture: &Picture, component: usize) -> bool {
    let n = picture.components.len();
    let values: Vec<f64> = picture.values.iter().skip(component).step_by(n).map(|v| f64::from(*v)).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    let jumps = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>() / values.len() as f64;
    // Independent numbers have twice their variance; the other channels of a table have a hundredth of it.
    jumps > 0.25 * variance
}

fn from_srgb(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn from_gamma(v: f64) -> f64 {
    v.powf(2.2)
}

/// Some texels of a picture, decoded.
pub struct Samples {
    /// Their places.
    pub texels: Vec<[u32; 2]>,
    /// Of how many texels, width and height.
    pub size: [u32; 2],
    /// Columns that were taken; [`Samples::texels`] runs over them first.
    pub columns: usize,
    /// The largest number that can be stored.
    top: f64,
    /// Values of each component, texel by texel.
    pub values: Vec<Vec<Value>>,
}

impl Samples {
    /// Some of them, as one row.
    pub fn only(&self, indices: &[usize]) -> Samples {
        Samples {
            texels: indices.iter().map(|i| self.texels[*i]).collect(),
            size: self.size,
            columns: indices.len(),
            top: self.top,
            values: self.values.iter().map(|v| indices.iter().map(|i| v[*i]).collect()).collect(),
        }
    }

    /// A quantity as it can be stored: cloth reflects more than 1, which integers cut off.
    pub fn expected(&self, quantity: Quantity, [e, b, t]: [f64; 3]) -> f64 {
        let value = quantity.of([e, b, t, 0.0]);
        // Not `min`, which would hide NaN.
        if value > self.top { self.top } else { value }
    }

    /// Up to `n` columns times up to `n` rows, both ends included.
    pub fn take(picture: &Picture, transfer: Transfer, n: u32) -> Samples {
        let (xs, ys) = (spread(picture.width, n), spread(picture.height, n));
        let texels: Vec<[u32; 2]> = ys.iter().flat_map(|y| xs.iter().map(|x| [*x, *y])).collect();
        let decoded: Vec<Vec<Value>> = texels.iter().map(|[x, y]| transfer.decode(&picture.texel(*x, *y))).collect();
        let integers = picture.components.iter().all(|c| c.precision.steps().is_some());
        let top = if integers && transfer != Transfer::Rgbd { 1.0 } else { f64::INFINITY };
        let components = decoded.first().map_or(0, Vec::len);
        let values = (0..components).map(|c| decoded.iter().map(|texel| texel[c]).collect()).collect();
        Samples { texels, size: [picture.width, picture.height], columns: xs.len(), top, values }
    }
}

/// Up to `n` indices of `len`, evenly.
fn spread(len: u32, n: u32) -> Vec<u32> {
    let n = n.min(len);
    let last = f64::from(n.max(2) - 1);
    (0..n).map(|i| (f64::from(i) / last * f64::from(len - 1)).round() as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_bytes_are_sixteen_bits() {
        let byte = |v: u32| Value { value: f64::from(v) / 255.0, half_step: 0.5 / 255.0 };
        let decoded = Transfer::TwoBytes.decode(&[byte(0x12), byte(0x34)]);
        assert!((decoded[0].value - f64::from(0x1234) / 65535.0).abs() < 1e-15);
    }

    #[test]
    fn rgbd_divides_by_alpha() {
        let v = |value| Value { value, half_step: 0.0 };
        let decoded = Transfer::Rgbd.decode(&[v(1.0), v(0.5), v(0.0), v(0.5)]);
        assert!((decoded[0].value - 2.0).abs() < 1e-12 && (decoded[1].value - 0.5f64.powf(1.2)).abs() < 1e-12);
    }

    #[test]
    fn spread_reaches_both_ends() {
        assert_eq!(spread(100, 3), [0, 50, 99]);
        assert_eq!(spread(2, 5), [0, 1]);
        assert_eq!(spread(1, 5), [0]);
    }
}
