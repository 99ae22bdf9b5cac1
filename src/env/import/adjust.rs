// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is done to texels as they enter.

use std::path::Path;

use rayon::prelude::*;

use crate::env::Picture;
use crate::error::{Error, Result};

/// What a user asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adjust {
    /// Radiance is multiplied by 2 to this power.
    pub exposure_ev: f64,
    /// Radiance is multiplied by this.
    pub scale: f64,
    /// After that, a texel whose largest channel exceeds this is scaled down to it; its hue stays.
    pub clamp: Option<f64>,
    /// Replaces texels that are not finite instead of refusing them.
    pub repair: bool,
}

impl Default for Adjust {
    fn default() -> Self {
        Self { exposure_ev: 0.0, scale: 1.0, clamp: None, repair: false }
    }
}

impl Adjust {
    /// Refuses numbers that mean nothing.
    pub fn check(&self) -> Result<()> {
        let refuse = |what: String, help: &str| Err(Error::usage(what, help));
        if !(-64.0..=64.0).contains(&self.exposure_ev) {
            return refuse(format!("an exposure of {} EV is out of range", self.exposure_ev), "use -64 to 64");
        }
        if !(self.scale > 0.0 && self.scale.is_finite()) {
            return refuse(format!("radiance cannot be scaled by {}", self.scale), "use a factor above 0");
        }
        if let Some(most) = self.clamp.filter(|most| !(*most > 0.0 && most.is_finite())) {
            return refuse(format!("radiance cannot be clamped to {most}"), "use a radiance above 0");
        }
        Ok(())
    }

    /// What radiance is multiplied by.
    pub fn factor(&self) -> f64 {
        self.scale * self.exposure_ev.exp2()
    }
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Adjusted {
    /// Negative texels that count as 0: lossy compression and bad merges of exposures make them.
    pub negative: Option<Negative>,
    /// Texels that were not finite and were replaced.
    pub repaired: usize,
    /// Texels that were clamped.
    pub clamped: usize,
    /// Share of the mean radiance that clamping removed, in [0, 1).
    pub removed: f64,
}

/// Texels with a negative channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Negative {
    /// How many.
    pub count: usize,
    /// The lowest value found.
    pub lowest: f32,
}

/// Texels that one thread looks at.
const CHUNK: usize = 1 << 16;

/// Adjusts a picture. `place` says where texel `i` lies.
pub fn adjust(
    path: &Path,
    picture: &mut Picture<'_>,
    wanted: &Adjust,
    place: &dyn Fn(usize) -> String,
) -> Result<Adjusted> {
    let width = match &*picture {
        Picture::Equirect(p) => p.width as usize,
        Picture::Cube(p) => p.size as usize,
    };
    let is_cube = matches!(picture, Picture::Cube(_));
    let texels = match &mut *picture {
        Picture::Equirect(p) => &mut p.to_mut().texels,
        Picture::Cube(p) => &mut p.to_mut().texels,
    };

    // Is there anything to do? Most pictures are looked at once.
    let look = |chunk: &[[f32; 3]]| {
        chunk.as_flattened().iter().fold((false, false), |(bad, low), v| (bad | !v.is_finite(), low | (*v < 0.0)))
    };
    let either = |a: (bool, bool), b: (bool, bool)| (a.0 | b.0, a.1 | b.1);
    let (has_bad, has_negative) = texels.par_chunks(CHUNK).map(look).reduce(|| (false, false), either);

    // What is not finite.
    let is_bad = |t: &[f32; 3]| !t.iter().all(|v| v.is_finite());
    let bad = if has_bad { texels.par_iter().filter(|t| is_bad(t)).count() } else { 0 };
    if bad > 0 && !wanted.repair {
        let first = texels.par_iter().position_first(is_bad).expect("one was counted");
        let what = format!("{bad} of its texels are infinite or not a number, the first at {}", place(first));
        return Err(Error::input(path, what, "--repair replaces them by what surrounds them"));
    }
    if bad > 0 {
        let rows = if is_cube { width } else { texels.len() / width };
        texels.chunks_exact_mut(width * rows).for_each(|face| repair(face, width));
    }

    // What is negative.
    let negative = if has_negative { &mut texels[..] } else { &mut [] };
    let (count, lowest) = negative
        .par_chunks_mut(CHUNK)
        .map(|chunk| {
            let (mut count, mut lowest) = (0, 0f32);
            for texel in chunk {
                let least = texel[0].min(texel[1]).min(texel[2]);
                if least < 0.0 {
                    count += 1;
                    lowest = lowest.min(least);
                    *texel = texel.map(|v| v.max(0.0));
                }
            }
            (count, lowest)
        })
        .reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1.min(b.1)));
    let negative = (count > 0).then_some(Negative { count, lowest });

    // Exposure and scale.
    let factor = wanted.factor();
    if factor != 1.0 {
        let most = texels.par_iter().flatten().copied().reduce(|| 0.0, f32::max);
        if f64::from(most) * factor > f64::from(f32::MAX) {
            let what = format!(
                "its brightest texel, {most}, exceeds single floats at {} EV and scale {}",
                wanted.exposure_ev, wanted.scale
            );
            return Err(Error::input(path, what, "use a lower --exposure or --scale"));
        }
        texels.par_iter_mut().for_each(|t| *t = t.map(|v| (f64::from(v) * factor) as f32));
    }

    // Clamp.
    let (mut clamped, mut removed) = (0, 0.0);
    if let Some(most) = wanted.clamp.map(|v| v as f32) {
        let sum = |mean: [f64; 3]| mean.iter().sum::<f64>();
        let largest = |t: &[f32; 3]| t[0].max(t[1]).max(t[2]);
        clamped = texels.par_iter().filter(|t| largest(t) > most).count();
        if clamped > 0 {
            let before = sum(picture.mean());
            let texels = match &mut *picture {
                Picture::Equirect(p) => &mut p.to_mut().texels,
                Picture::Cube(p) => &mut p.to_mut().texels,
            };
            texels.par_iter_mut().filter(|t| largest(t) > most).for_each(|t| {
                let share = f64::from(most) / f64::from(largest(t));
                *t = t.map(|v| ((f64::from(v) * share) as f32).min(most));
            });
            removed = 1.0 - sum(picture.mean()) / before;
        }
    }
    Ok(Adjusted { negative, repaired: bad, clamped, removed })
}

/// An infinite channel becomes the largest finite value of that channel: a sun that overflowed stays a sun. What is not a
/// number becomes the mean of its finite neighbours, of the nearest ring that has any, else 0.
fn repair(texels: &mut [[f32; 3]], width: usize) {
    let height = texels.len() / width;
    let largest: [f32; 3] =
        std::array::from_fn(|c| texels.iter().map(|t| t[c]).filter(|v| v.is_finite()).fold(0.0, f32::max));
    let bad: Vec<usize> = (0..texels.len()).filter(|i| !texels[*i].iter().all(|v| v.is_finite())).collect();
    let mean_around = |texels: &[[f32; 3]], index: usize, c: usize| {
        let (x, y) = ((index % width) as i64, (index / width) as i64);
        for ring in 1..=RINGS {
            let (mut sum, mut count) = (0.0, 0);
            for dy in -ring..=ring {
                for dx in -ring..=ring {
                    let (x, y) = (x + dx, y + dy);
                    let inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
                    if dx.abs().max(dy.abs()) == ring && inside {
                        let value = texels[y as usize * width + x as usize][c];
                        if value.is_finite() {
                            sum += f64::from(value);
                            count += 1;
                        }
                    }
                }
            }
            if count > 0 {
                return (sum / f64::from(count)) as f32;
            }
        }
        0.0
    };
    let repaired: Vec<[f32; 3]> = bad
        .iter()
        .map(|index| {
            let texel = texels[*index];
            std::array::from_fn(|c| match texel[c] {
                v if v.is_finite() => v,
                f32::INFINITY => largest[c],
                _ => mean_around(texels, *index, c),
            })
        })
        .collect();
    for (index, texel) in bad.into_iter().zip(repaired) {
        texels[index] = texel;
    }
}

/// Rings of neighbours that are looked at: holes wider than this are rare, and 0 in their middle is as good.
const RINGS: i64 = 8;

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;
    use crate::env::Equirect;

    fn adjusted(texels: [[f32; 3]; 8], wanted: &Adjust) -> Result<(Adjusted, Vec<[f32; 3]>)> {
        let source = Equirect { width: 4, height: 2, texels: texels.to_vec() };
        let mut picture = Picture::Equirect(Cow::Owned(source));
        let done = adjust(Path::new("t.exr"), &mut picture, wanted, &|i| format!("texel {i}"))?;
        Ok((done, picture.texels().to_vec()))
    }

    #[test]
    fn clamping_keeps_the_hue_and_reports_what_it_took() {
        let mut texels = [[1.0; 3]; 8];
        texels[5] = [9.0, 4.5, 0.0];
        let (done, out) = adjusted(texels, &Adjust { clamp: Some(2.0), ..Adjust::default() }).unwrap();
        assert_eq!((done.clamped, out[5]), (1, [2.0, 1.0, 0.0]));
        // Eight equal solid angles: 7 · 3 + 13.5 before, 7 · 3 + 3 after.
        assert!((done.removed - 10.5 / 34.5).abs() < 1e-12, "{}", done.removed);
    }

    #[test]
    fn repair_keeps_suns_and_fills_holes() {
        let mut texels = [[1.0; 3]; 8];
        texels[1] = [f32::INFINITY, 50.0, f32::NAN];
        texels[6] = [7.0, f32::NEG_INFINITY, 1.0];
        let error = adjusted(texels, &Adjust::default()).unwrap_err().to_string();
        assert!(error.contains("2 of its texels") && error.contains("texel 1"), "{error}");
        let (done, out) = adjusted(texels, &Adjust { repair: true, ..Adjust::default() }).unwrap();
        assert_eq!((done.repaired, out[1]), (2, [7.0, 50.0, 1.0]));
        assert_eq!(out[6], [7.0, (50.0 + 1.0 + 1.0 + 1.0 + 1.0) / 5.0, 1.0]);
    }

    #[test]
    fn nonsense_is_refused() {
        for wanted in [
            Adjust { scale: 0.0, ..Adjust::default() },
            Adjust { exposure_ev: f64::NAN, ..Adjust::default() },
            Adjust { clamp: Some(-1.0), ..Adjust::default() },
        ] {
            assert!(matches!(wanted.check(), Err(Error::Usage { .. })), "{wanted:?}");
        }
        let bright = Adjust { exposure_ev: 60.0, scale: 1e30, ..Adjust::default() };
        assert!(adjusted([[1.0; 3]; 8], &bright).unwrap_err().to_string().contains("exceeds single floats"));
    }
}
