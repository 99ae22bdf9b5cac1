// SPDX-License-Identifier: MIT OR Apache-2.0
//! The independent truth of an environment that is given as a cube: a sum over its texels, in f64.
//!
//! Every texel is a constant over its solid angle. By its distance from the lobe's axis it is taken at its middle, or cut
//! into parts over which the kernel is integrated at 2 × 2 Gauss points of (s, t). Nothing is shared with what is checked
//! but the source and the kernel.

use rayon::prelude::*;

use super::environment::{GoOn, Scale};
use crate::env::{CubeMap, orientation};
use crate::term::cube::direction;
use crate::term::zonal::Peak;

/// Half the distance between Gauss points, in units of the interval.
const GAUSS: f64 = 0.288_675_134_594_812_9;
/// Beyond this many texel sides one point a texel is enough: it errs by less than 1e-4 of the texel's own part.
const FAR: f64 = 90.0;
/// Parts are at most 1/NEAR of their distance.
const NEAR: f64 = 8.0;
/// A ring at the horizon is cut this many times its width above it.
const RING: f64 = 14.0;

/// A source, with what every direction needs.
pub struct CubeTruth<'a> {
    source: &'a CubeMap,
    /// Unit vectors towards the middles of all texels.
    middles: Vec<[f32; 3]>,
    /// Of the texels of a face.
    solid_angles_sr: Vec<f64>,
}

impl<'a> CubeTruth<'a> {
    /// Prepares a source.
    pub fn new(source: &'a CubeMap) -> Self {
        let n = source.size;
        let middle = |i: u32| {
            let (s, t) = orientation::centre(i % n, i / n % n, n);
            orientation::normalized(direction(i / (n * n), s, t)).map(|v| v as f32)
        };
        let middles = (0..6 * n * n).into_par_iter().map(middle).collect();
        Self { source, middles, solid_angles_sr: CubeMap::solid_angles_sr(n) }
    }

    /// ∫ kernel(h) L dω around `n`, a unit vector, with h = (1 − n·ω)/2; directions with n·ω ≤ 0 count nothing.
    /// `kernel` replaces every h by the kernel's value.
    pub fn integral(&self, n: [f64; 3], scale: Scale, kernel: impl Fn(&mut [f64])) -> [f64; 3] {
        self.integral_while(n, scale, kernel, &|| true)
    }

    /// Rows of texels of all faces.
    pub(super) fn rows(&self) -> usize {
        6 * self.source.size as usize
    }

    /// The same as long as it is wanted.
    pub(super) fn integral_while(
        &self,
        n: [f64; 3],
        scale: Scale,
        kernel: impl Fn(&mut [f64]),
        go_on: GoOn<'_>,
    ) -> [f64; 3] {
        let size = self.source.size as usize;
        let side_rad = 2.0 / size as f64;
        let mut sum = [0.0; 3];
        let mut far: Vec<(usize, f64)> = Vec::with_capacity(size);
        let mut h = Vec::with_capacity(size);
        for row in 0..6 * size {
            if !go_on() {
                break;
            }
            far.clear();
            h.clear();
            for index in row * size..(row + 1) * size {
                let m = self.middles[index];
                let mu = n[0] * f64::from(m[0]) + n[1] * f64::from(m[1]) + n[2] * f64::from(m[2]);
                if mu < -side_rad {
                    continue;
                }
                let distance = (2.0 - 2.0 * mu).max(0.0).sqrt();
                // Beside a ring at the horizon, the kernel is steep everywhere.
                if scale.peak == Peak::Axis && mu > side_rad && distance > FAR * side_rad {
                    far.push((index, self.solid_angles_sr[index % (size * size)]));
                    h.push(0.5 - 0.5 * mu);
                } else {
                    let part = self.by_parts(n, index, distance, scale, &kernel);
                    (0..3).for_each(|c| sum[c] += part * f64::from(self.source.texels[index][c]));
                }
            }
            kernel(&mut h);
            for ((index, solid_angle_sr), k) in far.iter().zip(&h) {
                (0..3).for_each(|c| sum[c] += k * solid_angle_sr * f64::from(self.source.texels[*index][c]));
            }
        }
        sum
    }

    /// The integral of the kernel over a texel.
    fn by_parts(&self, n: [f64; 3], index: usize, distance: f64, scale: Scale, kernel: &impl Fn(&mut [f64])) -> f64 {
        let size = self.source.size;
        let (face, x, y) = (index as u32 / (size * size), index as u32 % size, index as u32 / size % size);
        let side = 2.0 / f64::from(size);
        let mu = 1.0 - 0.5 * distance * distance;
        let part_rad = match scale.peak {
            Peak::Axis => ((distance - 1.5 * side) / NEAR).max(0.25 * scale.width_rad),
            Peak::Horizon if mu > (1.1 * side).max((RING * scale.width_rad).min(0.7)) => side,
            Peak::Horizon => 0.25 * scale.width_rad,
        };
        // What the horizon crosses is cut in any case.
        let least = if distance > 1.2 { 4 } else { 1 };
        let parts = ((side / part_rad).ceil() as u32).clamp(least, 256);
        let at = |texel: u32, i: u32| {
            let gauss = if i.is_multiple_of(2) { -GAUSS } else { GAUSS };
            side * (f64::from(texel) + (f64::from(i / 2) + 0.5 + gauss) / f64::from(parts)) - 1.0
        };
        let mut h = Vec::with_capacity(4 * (parts * parts) as usize);
        let mut shares = Vec::with_capacity(h.capacity());
        for j in 0..2 * parts {
            for i in 0..2 * parts {
                let (s, t) = (at(x, i), at(y, j));
                let d = direction(face, s, t);
                let inverse2 = 1.0 / (1.0 + s * s + t * t);
                let mu = (n[0] * d[0] + n[1] * d[1] + n[2] * d[2]) * inverse2.sqrt();
                h.push(0.5 - 0.5 * mu);
                shares.push(if mu > 0.0 { inverse2 * inverse2.sqrt() } else { 0.0 });
            }
        }
        kernel(&mut h);
        let cell = side / f64::from(2 * parts);
        cell * cell * h.iter().zip(&shares).map(|(k, share)| if *share > 0.0 { k * share } else { 0.0 }).sum::<f64>()
    }
}
