// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is wanted of all texels of a picture, in one pass: large pictures do not fit into a cache.

use rayon::prelude::*;

use super::{CubeMap, Picture};

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    /// Mean radiance over the sphere, per channel.
    pub mean: [f64; 3],
    /// The lowest value of each channel.
    pub least: [f32; 3],
    /// The highest.
    pub most: [f32; 3],
    /// The first of the texels whose channels have the largest sum, in the order of [`Picture::texels`].
    pub brightest: usize,
}

/// Of a row.
struct RowSurvey {
    integral: [f64; 3],
    least: [f32; 3],
    most: [f32; 3],
    /// The largest sum of a texel's channels.
    peak: f32,
}

fn sum(texel: &[f32; 3]) -> f32 {
    texel[0] + texel[1] + texel[2]
}

/// `weights_sr` has a solid angle a texel, or one for all of them. The row stays in the nearest cache from loop to loop.
fn of_row(texels: &[[f32; 3]], weights_sr: &[f64]) -> RowSurvey {
    // Four texels at a time, whose figures do not wait for each other.
    let (fours, rest) = texels.as_chunks::<4>();
    let (mut sums, mut least, mut most) = ([0.0; 12], [f32::MAX; 12], [f32::MIN; 12]);
    for values in fours.iter().map(|texels| texels.as_flattened()) {
        for i in 0..12 {
            sums[i] += f64::from(values[i]);
            least[i] = if values[i] < least[i] { values[i] } else { least[i] };
            most[i] = if values[i] > most[i] { values[i] } else { most[i] };
        }
    }
    for texel in rest {
        for c in 0..3 {
            sums[c] += f64::from(texel[c]);
            least[c] = least[c].min(texel[c]);
            most[c] = most[c].max(texel[c]);
        }
    }
    let of_channel = |c: usize| [c, 3 + c, 6 + c, 9 + c];
    let integral = match weights_sr {
        [weight] => [0, 1, 2].map(|c| weight * of_channel(c).iter().map(|i| sums[*i]).sum::<f64>()),
        weights => {
            let mut sums = [0.0; 3];
            for (texel, weight) in texels.iter().zip(weights) {
                (0..3).for_each(|c| sums[c] += weight * f64::from(texel[c]));
            }
            sums
        }
    };
    RowSurvey {
        integral,
        least: [0, 1, 2].map(|c| of_channel(c).iter().map(|i| least[*i]).fold(f32::MAX, f32::min)),
        most: [0, 1, 2].map(|c| of_channel(c).iter().map(|i| most[*i]).fold(f32::MIN, f32::max)),
        peak: texels.iter().map(sum).fold(f32::MIN, |a, b| if b > a { b } else { a }),
    }
}

impl Survey {
    /// Goes through a picture.
    pub fn of(picture: &Picture<'_>) -> Survey {
        let rows: Vec<RowSurvey> = match picture {
            Picture::Equirect(picture) => (0..picture.height)
                .into_par_iter()
                .map(|y| of_row(picture.row(y), &[picture.solid_angle_sr(y)]))
                .collect(),
            Picture::Cube(picture) => {
                let size = picture.size as usize;
                let weights_sr = CubeMap::solid_angles_sr(picture.size);
                let rows = picture.texels.par_chunks_exact(size).enumerate();
                rows.map(|(row, texels)| of_row(texels, &weights_sr[row % size * size..][..size])).collect()
            }
        };
        // Added in order, so that the same sum comes out on any number of threads.
        let (mut mean, mut least, mut most) = ([0.0; 3], [f32::MAX; 3], [f32::MIN; 3]);
        for row in &rows {
            for c in 0..3 {
                mean[c] += row.integral[c] / (4.0 * std::f64::consts::PI);
                least[c] = least[c].min(row.least[c]);
                most[c] = most[c].max(row.most[c]);
            }
        }
        let peak = rows.iter().map(|row| row.peak).fold(f32::MIN, f32::max);
        let width = picture.texels().len() / rows.len();
        let from = width * rows.iter().position(|row| row.peak == peak).expect("a picture has rows");
        let within = picture.texels()[from..].iter().position(|texel| sum(texel) == peak).expect("its row has it");
        Survey { mean, least, most, brightest: from + within }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::{Environment, speckle};

    #[test]
    fn a_survey_is_what_plain_loops_find() {
        let equirect = speckle(20);
        let cube = CubeMap { size: 8, texels: equirect.texels[..6 * 64].to_vec() };
        for environment in [Environment::from(&equirect), Environment::from(&cube)] {
            let picture = &environment.picture;
            let found = Survey::of(picture);
            let texels = picture.texels();
            let values = |c: usize| texels.iter().map(move |texel| texel[c]);
            for c in 0..3 {
                assert_eq!(found.least[c], values(c).fold(f32::MAX, f32::min));
                assert_eq!(found.most[c], values(c).fold(f32::MIN, f32::max));
            }
            let sums: Vec<f32> = texels.iter().map(sum).collect();
            let peak = sums.iter().copied().fold(f32::MIN, f32::max);
            assert_eq!(Some(found.brightest), sums.iter().position(|s| *s == peak));
            // Against points that are dense enough to hit every texel by its solid angle.
            let mut mean = [0.0; 3];
            const STEPS: u32 = 400;
            for i in 0..STEPS {
                let y = 2.0 * (f64::from(i) + 0.5) / f64::from(STEPS) - 1.0;
                for j in 0..2 * STEPS {
                    let phi = std::f64::consts::PI * (f64::from(j) + 0.5) / f64::from(STEPS);
                    let r = (1.0 - y * y).sqrt();
                    let value = picture.radiance([r * phi.cos(), y, r * phi.sin()]);
                    (0..3).for_each(|c| mean[c] += f64::from(value[c]) / f64::from(2 * STEPS * STEPS));
                }
            }
            assert!((0..3).all(|c| (found.mean[c] / mean[c] - 1.0).abs() < 2e-3), "{found:?}, not {mean:?}");
        }
    }
}
