// SPDX-License-Identifier: MIT OR Apache-2.0
//! Mip 0 of an environment, texel by texel: means of the source by plain sampling.
//!
//! A texel's mean radiance is taken over points of its face, each weighted by the solid angle that it stands for, and read
//! from the source texel that it falls into. Nothing is shared with what is checked but the source and the layout. Points
//! miss the share of a light that a texel only touches, so several sets of points tell how far they agree: what is within
//! that counts as right.

use rayon::prelude::*;

use super::environment::{Extent, MipError, chosen};
use crate::bake::specular::SpecularJob;
use crate::env::projection::Projection;
use crate::env::{Environment, Survey};
use crate::error::Result;
use crate::progress::{OnProgress, watched};
use crate::texture::Texture;

/// Sets of points.
const SETS: u32 = 16;
/// Points in a set.
const POINTS: u32 = 4096;
/// Standard errors of the mean of the sets within which a texel counts as right.
const AGREEMENT: f64 = 4.0;

/// Compares mip 0 with the means of the source. `texture` holds RGB (or RGBA) texels.
pub fn check(
    job: &SpecularJob,
    source: &Environment<'_>,
    texture: &Texture,
    extent: Extent,
    on: &mut OnProgress<'_>,
) -> Result<MipError> {
    let Survey { mean: whole, brightest, .. } = Survey::of(&source.picture);
    let brightest = source.frame.from_picture(source.picture.direction(brightest));
    let texels = chosen(job, 0, brightest, extent);
    let expected = watched(on, "checking mip 0", texels.len(), |watch| -> Vec<_> {
        let of_texel = |texel: &[u32; 3]| if watch.cancelled() { [[0.0; 2]; 3] } else { mean(job, source, *texel) };
        texels.par_iter().map(of_texel).collect()
    })?;
    let floor = 1e-9 * whole.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let (mut squares, mut max) = (0.0, 0.0f64);
    let (mut gained, mut whole) = (0.0, 0.0);
    for ([face, x, y], expected) in texels.iter().zip(&expected) {
        for (c, [mean, uncertain]) in expected.iter().enumerate() {
            let mean = mean.min(job.clamped_to);
            let off = f64::from(texture.texel(0, *face, *x, *y)[c]) - mean;
            let error = if off.abs() <= *uncertain { 0.0 } else { (off.abs() - uncertain) / mean.max(floor) };
            squares += error * error;
            gained += off;
            whole += mean;
            // A NaN must not get lost in max().
            max = if error > max || error.is_nan() { error } else { max };
        }
    }
    let rms = (squares / (3 * texels.len()) as f64).sqrt();
    Ok(MipError { mip: 0, rms, max, bias: gained / whole.max(floor), texels: texels.len() as u32 })
}

/// Per channel: a texel's mean radiance, and how far it is uncertain.
fn mean(job: &SpecularJob, source: &Environment<'_>, [face, x, y]: [u32; 3]) -> [[f64; 2]; 3] {
    let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
    for set in 0..SETS {
        let of_set = of_points(job.projection, source, face, |u, v| {
            // Each set is the lattice of Korobov's kind moved by another step of the golden ratio.
            let moved = f64::from(set) * 0.618_033_988_749_894_9;
            job.place(0, f64::from(x) + (u + moved) % 1.0, f64::from(y) + (v + moved * moved) % 1.0)
        });
        for c in 0..3 {
            sum[c] += of_set[c];
            squares[c] += of_set[c] * of_set[c];
        }
    }
    let sets = f64::from(SETS);
    std::array::from_fn(|c| {
        let mean = sum[c] / sets;
        let variance = (squares[c] / sets - mean * mean).max(0.0);
        [mean, AGREEMENT * (variance / (sets - 1.0)).sqrt()]
    })
}

/// The mean over one set of points: (u, v) runs over a lattice in the unit square, `place` says where that is on a face.
fn of_points(
    projection: Projection,
    source: &Environment<'_>,
    face: u32,
    place: impl Fn(f64, f64) -> (f64, f64),
) -> [f64; 3] {
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for i in 0..POINTS {
        let u = (f64::from(i) + 0.5) / f64::from(POINTS);
        let (s, t) = place(u, f64::from(i) * 0.618_033_988_749_894_9 % 1.0);
        let d = projection.direction(face, s, t);
        // What a point of the face covers: the cube of its direction's length over that of the point on the solid.
        let weight = match projection {
            Projection::Cube => d.iter().fold(0.0f64, |most, v| most.max(v.abs())).powi(3),
            Projection::Equirect => d[0].hypot(d[2]),
            Projection::Octahedral => d.iter().map(|v| v.abs()).sum::<f64>().powi(3),
        };
        let radiance = source.picture.radiance(source.frame.to_picture(d));
        (0..3).for_each(|c| sum[c] += weight * f64::from(radiance[c]));
        weights += weight;
    }
    sum.map(|s| s / weights)
}
