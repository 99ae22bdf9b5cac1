// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a BRDF of one's own is like: how wide its lobe is, whether it has colours, and whether it obeys the laws of
//! reflection, at sampled pairs of directions.

use std::f64::consts::{PI, TAU};

use super::program::{PAIR, Precision, Program};
use crate::brdf::half;
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::progress::OnProgress;

/// What was found at sampled pairs of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laws {
    /// Pairs that were looked at.
    pub pairs: usize,
    /// Largest difference between f(l, v) and f(v, l), relative to the larger one.
    pub reciprocity: f64,
    /// Red, green and blue are not the same.
    pub colored: bool,
}

/// A relative difference that rounding explains.
pub const ROUNDING: f64 = 1e-3;
/// In single precision the roundings of directions show in lobes narrower than this.
const LEAST_SINGLE_ALPHA: f64 = 0.05;
/// And leave so much.
const SINGLE_ROUNDING: f64 = 2e-2;
/// n·v of the viewer that lobes are probed for.
const VIEW: f64 = 0.7;
/// Steps of a factor of √2 in tan θ_h, from just inside the largest that mirrors the viewer upwards.
const STEPS: i32 = 86;
/// A lobe begins to change where the BRDF differs from that at h = n by so much of its largest value.
const CHANGE: f64 = 0.25;
/// A BRDF below this in all facets up to 42 degrees has no lobe there.
const LEAST_LOBE: f64 = 1e-6;
/// Largest distance from the viewer's direction, in radians, at which a lobe back to it is looked for; steps of a
/// factor of 2 down from there, and the share of light that does not matter.
const MOST_RETRO: f64 = 0.1;
const RETRO_STEPS: usize = 20;
const RETRO_LIGHT: f64 = 1e-7;
/// Pairs a width, and most widths that are looked at.
const PAIRS: usize = 256;
const WIDTHS: usize = 16;

/// tan θ_h at which the BRDF of each width begins to change, seen from the normal.
pub(super) fn widths(gpu: &Gpu, program: &Program, alphas: &[f64], on: &mut OnProgress<'_>) -> Result<Vec<f64>> {
    let v = [(1.0 - VIEW * VIEW).sqrt(), 0.0, VIEW];
    let tan = |step: i32| 0.9 * 0.5f64.powf(0.5 * f64::from(step));
    let steps = || (0..STEPS).rev();
    // Across the plane of v and n, where every facet up to 45 degrees mirrors v upwards.
    let pair = |alpha: f64, step: i32| of(mirrored(v, [0.0, tan(step), 1.0]), v, alpha);
    let pairs: Vec<_> = alphas.iter().flat_map(|alpha| steps().map(move |step| pair(*alpha, step))).collect();
    let values = program.evaluate(gpu, &pairs, on)?;
    let width = |(values, alpha): (&[[f64; 3]], &f64)| {
        let f: Vec<f64> = values.iter().map(|f| f.iter().fold(0.0, |most, x| x.abs().max(most))).collect();
        if let Some(bad) = values.iter().position(|f| !f.iter().all(|x| x.is_finite())) {
            let theta = tan(STEPS - 1 - bad as i32).atan().to_degrees();
            return Err(not_finite(
                *alpha,
                &format!("n.v = {VIEW}, {theta:.3e} degrees between normal and half vector"),
            ));
        }
        // Of a lobe elsewhere, a sheen's, powers may leave less than nothing here.
        let largest = f.iter().copied().fold(LEAST_LOBE, f64::max);
        let changed = f.iter().position(|x| (x - f[0]).abs() > CHANGE * largest);
        Ok(changed.map_or(tan(0), |i| tan(STEPS - 1 - i as i32)))
    };
    values.chunks_exact(STEPS as usize).zip(alphas).map(width).collect()
}

/// Angle in radians, of each width, from the viewer's direction to where a lobe back to it begins to change; infinite where
/// there is none.
pub(super) fn retro_widths(gpu: &Gpu, program: &Program, alphas: &[f64], on: &mut OnProgress<'_>) -> Result<Vec<f64>> {
    // Away from the normal, where the mirror direction lies, which has a map of its own.
    const VIEWS: [f64; 4] = [0.8, 0.6, 0.35, 0.1];
    let distance = |step: usize| MOST_RETRO * 0.5f64.powi(step as i32);
    let of_view = |alpha: f64, view: f64| {
        let angle = view.acos();
        let towards_normal = move |d: f64| [(angle - d).sin(), 0.0, (angle - d).cos()];
        let steps = (0..RETRO_STEPS).rev();
        steps.map(move |step| of(towards_normal(distance(step)), towards_normal(0.0), alpha))
    };
    let pairs: Vec<_> =
        alphas.iter().flat_map(|alpha| VIEWS.iter().flat_map(move |view| of_view(*alpha, *view))).collect();
    let values = program.evaluate(gpu, &pairs, on)?;
    let width = |(values, view): (&[[f64; 3]], &f64)| {
        let f: Vec<f64> = values.iter().map(|f| f.iter().fold(0.0, |most, x| x.abs().max(most))).collect();
        let largest = f.iter().copied().fold(0.0, f64::max);
        let changed = f.iter().position(|x| (x - f[0]).abs() > CHANGE * largest);
        let width = changed.map_or(f64::INFINITY, |i| distance(RETRO_STEPS - 1 - i));
        // Not of any light, or not finite: the laws look at that.
        let matters = f[0] * view * PI * width * width > RETRO_LIGHT;
        if matters { width } else { f64::INFINITY }
    };
    let of_alpha =
        |values: &[[f64; 3]]| values.chunks_exact(RETRO_STEPS).zip(&VIEWS).map(width).fold(f64::INFINITY, f64::min);
    Ok(values.chunks_exact(RETRO_STEPS * VIEWS.len()).map(of_alpha).collect())
}

/// Looks at pairs of directions for some of the widths, each with the scale of its lobe. Refuses a BRDF that is not
/// finite, that depends on the azimuth of both directions together, or on the side of the plane of v and n.
pub(super) fn laws(gpu: &Gpu, program: &Program, lobes: &[(f64, f64)], on: &mut OnProgress<'_>) -> Result<Laws> {
    let single = program.precision == Precision::Single;
    let wide: Vec<_> = lobes.iter().copied().filter(|(alpha, _)| !single || *alpha >= LEAST_SINGLE_ALPHA).collect();
    let lobes = if wide.is_empty() { lobes } else { &wide };
    let step = lobes.len().div_ceil(WIDTHS);
    let mut pairs = vec![];
    for (alpha, width) in lobes.iter().step_by(step) {
        for i in 0..PAIRS {
            // The additive recurrence of the plastic number (Roberts 2018): even in three dimensions.
            let even = |power: i32| (0.5 + i as f64 / 1.220_744_084_605_76f64.powi(power)).fract();
            let (a, b, c) = (even(1), even(2), even(3));
            let v = polar(0.02 + 0.97 * c, 0.0);
            // Half of the lights anywhere, half where the lobe is.
            let l = if i % 2 == 0 {
                polar(0.02 + 0.97 * a, TAU * b)
            } else {
                let tan = width * a / (1.0 - a);
                let (sin, cos) = (TAU * b).sin_cos();
                mirrored(v, [tan * cos, tan * sin, 1.0])
            };
            if l[2] <= 1e-3 {
                continue;
            }
            // As it is, exchanged (and turned, so that the viewer is in the plane y = 0), turned, and from the other side.
            let across = l[0].hypot(l[1]).max(f64::MIN_POSITIVE);
            let (cos, sin) = (l[0] / across, l[1] / across);
            let onto = |d: [f64; 3]| [cos * d[0] + sin * d[1], cos * d[1] - sin * d[0], d[2]];
            let (turn_sin, turn_cos) = 1f64.sin_cos();
            let turned = |d: [f64; 3]| [turn_cos * d[0] - turn_sin * d[1], turn_sin * d[0] + turn_cos * d[1], d[2]];
            pairs.push(of(l, v, *alpha));
            pairs.push(of(onto(v), onto(l), *alpha));
            pairs.push(of(turned(l), turned(v), *alpha));
            pairs.push(of([l[0], -l[1], l[2]], v, *alpha));
        }
    }
    let values = program.evaluate(gpu, &pairs, on)?;
    let rounding = if single { SINGLE_ROUNDING } else { ROUNDING };
    let mut laws = Laws { pairs: pairs.len() / 4, reciprocity: 0.0, colored: false };
    for (values, pairs) in values.as_chunks::<4>().0.iter().zip(pairs.as_chunks::<4>().0) {
        let [plain, exchanged, turned, other_side] = values;
        let [lx, ly, lz, vx, _, vz, alpha, _] = pairs[0];
        let place = format!("l = ({lx:.4}, {ly:.4}, {lz:.4}), v = ({vx:.4}, 0, {vz:.4})");
        if !values.as_flattened().iter().all(|f| f.is_finite()) {
            return Err(not_finite(alpha, &place));
        }
        for (values, what, help) in [
            (turned, "depends on the azimuth of both directions", "a table of n.v and roughness is of isotropic BRDFs"),
            (other_side, "is not the same on both sides of the plane of v and n", "make it symmetric in the azimuth"),
        ] {
            if apart(plain, values) > rounding {
                return Err(Error::usage(
                    format!("the BRDF {what}: {} and {} at {place}, alpha = {alpha:.3e}", text(plain), text(values)),
                    help,
                ));
            }
        }
        laws.reciprocity = laws.reciprocity.max(apart(plain, exchanged));
        laws.colored |= apart(&[plain[0]; 3], plain) > 1e-6;
    }
    Ok(laws)
}

/// The largest difference relative to the larger value; of nothing and nothing 0.
fn apart(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let relative = |(a, b): (&f64, &f64)| (a - b).abs() / a.abs().max(b.abs()).max(1e-12);
    a.iter().zip(b).map(relative).fold(0.0, f64::max)
}

fn text(f: &[f64; 3]) -> String {
    if f.iter().all(|x| *x == f[0]) { format!("{:.6}", f[0]) } else { format!("{f:.6?}") }
}

fn not_finite(alpha: f64, place: &str) -> Error {
    let what = format!("the BRDF is not finite at {place}, alpha = {alpha:.3e}");
    Error::Verify { what: format!("{what}: it is NaN or infinite there (--min-roughness keeps alpha away from 0)") }
}

fn of(l: [f64; 3], v: [f64; 3], alpha: f64) -> [f64; PAIR] {
    [l[0], l[1], l[2], v[0], v[1], v[2], alpha, 0.0]
}

fn polar(cos: f64, azimuth: f64) -> [f64; 3] {
    let (y, x) = azimuth.sin_cos();
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    [sin * x, sin * y, cos]
}

/// v mirrored at a facet whose normal has any length.
fn mirrored(v: [f64; 3], facet: [f64; 3]) -> [f64; 3] {
    let h = half(facet, [0.0; 3]);
    let v_dot_h: f64 = v.iter().zip(h).map(|(v, h)| v * h).sum();
    std::array::from_fn(|i| 2.0 * v_dot_h * h[i] - v[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrored_direction_has_the_facet_half_way() {
        let v = polar(0.3, 0.4);
        let l = mirrored(v, [0.2, -0.1, 0.7]);
        let (h, facet) = (half(l, v), half([0.2, -0.1, 0.7], [0.0; 3]));
        assert!(h.iter().zip(facet).all(|(a, b)| (a - b).abs() < 1e-14), "{h:?} {facet:?}");
    }

    #[test]
    fn difference_is_relative_and_of_nothing_is_none() {
        assert_eq!(apart(&[0.0; 3], &[0.0; 3]), 0.0);
        assert_eq!(apart(&[1.0, 2.0, 4.0], &[1.0, 2.0, 2.0]), 0.5);
    }
}
