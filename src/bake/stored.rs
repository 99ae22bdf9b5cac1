// SPDX-License-Identifier: MIT OR Apache-2.0
//! The average of an albedo table as a shader reads it: the exact integral of its stored texels, filtered linearly.
//!
//! Compensation for multiple scattering after Kulla and Conty returns what single scattering loses only if the average is
//! the integral of the very albedo that the shader reads: ∫ (1 − E(l)) (1 − E(v))/(π (1 − average)) (n·l) dω_l = 1 − E(v).
//! Between the points of two texels a shader reads a line, before the first and behind the last a constant (clamped to the
//! edge), so that average = 2 ∫ E mu dmu is a weighted sum of texels. With M = mu² as a function of the position t and a
//! pair of points a, b, ∫ (b − t)/(b − a) dM = mean(M) − M(a) and ∫ (t − a)/(b − a) dM = M(b) − mean(M), the mean taken
//! over t. Along plain n·v with centers the weights are 2(i + ½)/N², and 1/(12N²) more in the first texel and less in the
//! last; with edges 2i/(N − 1)², 1/(3(N − 1)²) in the first and 1/(N − 1) − 1/(3(N − 1)²) in the last.
//!
//! This average differs from the true one by up to 3.1e-5 (64 texels) or 2.0e-6 (256), most at roughness 1, and by what
//! rounding did to the texels.

use std::fmt;

use crate::axis::{Axis, Coordinate, Points, Warp};
use crate::error::{Error, Result};
use crate::format::Encoding;
use crate::quadrature::gauss_legendre::gauss_legendre;

/// An albedo table's side along n·v, and how its texels are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// The side along n·v.
    pub n_dot_v: Axis,
    /// The encoding of its texels; no blocks.
    pub encoding: Encoding,
}

/// M is a polynomial of degree 4 at most, or the square of a cosine over less than a quarter of a turn.
const NODES: usize = 8;

impl Stored {
    /// A table's side and encoding; an error where a shader's reading is no weighted sum that the file could state.
    pub fn new(n_dot_v: Axis, encoding: Encoding) -> Result<Stored> {
        if encoding.repr.is_blocks() {
            return Err(Error::usage(
                format!("the average of a table in {} blocks cannot be checked again", encoding.name),
                "bake the albedo with --encoding r16f or r32f",
            ));
        }
        if n_dot_v.shift != 0 {
            return Err(Error::usage(
                "the table's rows are shifted by a texel: it has no average of what lies at n.v",
                "bake the albedo with --exact-rows",
            ));
        }
        Ok(Stored { n_dot_v, encoding })
    }

    /// What each texel along n·v contributes to the average, in the order of the file. They sum to 1.
    pub fn weights(&self) -> Vec<f64> {
        let axis = Axis { reversed: false, ..self.n_dot_v };
        let len = axis.len as usize;
        let square = |t: f64| axis.warp.value(t).powi(2);
        let rule = gauss_legendre(NODES);
        let mut weights = vec![0.0; len];
        let points: Vec<f64> = (0..axis.len).map(|i| axis.position(i)).collect();
        weights[0] += square(points[0]) - square(0.0);
        for (i, ends) in points.windows(2).enumerate() {
            let [a, b] = [ends[0], ends[1]];
            let mean: f64 = rule.iter().map(|n| 0.5 * n.weight * square(a + (b - a) * 0.5 * (1.0 + n.x))).sum();
            weights[i] += mean - square(a);
            weights[i + 1] += square(b) - mean;
        }
        weights[len - 1] += square(1.0) - square(points[len - 1]);
        // Where n·v falls along the axis the integral runs backwards.
        let sign = square(1.0) - square(0.0);
        weights.iter_mut().for_each(|w| *w *= sign);
        if self.n_dot_v.reversed {
            weights.reverse();
        }
        weights
    }
}

/// The text that a file holds, which [`Stored::parse`] reads back.
impl fmt::Display for Stored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Axis { warp, points, len, reversed, .. } = self.n_dot_v;
        let order = if reversed { "descending" } else { "ascending" };
        write!(f, "{len} texels along {} {} {order} in {}", warp.name(), points.name(), self.encoding.name)
    }
}

impl Stored {
    /// What a file says of the table that its average was taken of.
    pub fn parse(text: &str) -> Result<Stored> {
        let bad = || {
            let way_out = "only `brdf-baker bake average-albedo --of FILE` writes such a statement";
            Error::usage(format!("the file says of '{text}', which is no albedo table"), way_out)
        };
        let words: Vec<&str> = text.split(' ').collect();
        let [len, "texels", "along", warp, points, order, "in", encoding] = words[..] else { return Err(bad()) };
        let points = Points::parse(points)?;
        let least = if points == Points::Edges { 2 } else { 1 };
        let len = len.parse().ok().filter(|len| (least..=super::MAX_SIZE).contains(len)).ok_or_else(bad)?;
        let warp = Warp::parse(warp)?;
        let reversed = order == "descending";
        if warp.coordinate() != Coordinate::NDotV || !(reversed || order == "ascending") {
            return Err(bad());
        }
        Stored::new(Axis { warp, points, len, reversed, shift: 0 }, Encoding::parse(encoding)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(warp: Warp, points: Points, len: u32, reversed: bool) -> Stored {
        let axis = Axis { warp, points, len, reversed, shift: 0 };
        Stored::new(axis, Encoding::parse("r16f").expect("its name")).expect("sound")
    }

    fn close(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-15, "{found:?} instead of {expected:?}");
        }
    }

    #[test]
    fn weights_along_plain_n_dot_v_have_their_closed_forms() {
        let n = 16.0;
        let mut centers: Vec<f64> = (0..16).map(|i| 2.0 * (f64::from(i) + 0.5) / (n * n)).collect();
        centers[0] += 1.0 / (12.0 * n * n);
        centers[15] -= 1.0 / (12.0 * n * n);
        close(&stored(Warp::NDotV, Points::Centers, 16, false).weights(), &centers);
        let h: f64 = 1.0 / 15.0;
        let mut edges: Vec<f64> = (0..16).map(|i| 2.0 * f64::from(i) * h * h).collect();
        edges[0] = h * h / 3.0;
        edges[15] = h - h * h / 3.0;
        close(&stored(Warp::NDotV, Points::Edges, 16, false).weights(), &edges);
        centers.reverse();
        close(&stored(Warp::NDotV, Points::Centers, 16, true).weights(), &centers);
    }

    #[test]
    fn weights_integrate_what_a_shader_reads_along_every_axis() {
        // Texels of a curve, read as a sampler does and summed up over n·v in small steps.
        for warp in Warp::ALL.into_iter().filter(|w| w.coordinate() == Coordinate::NDotV) {
            for (points, len, reversed) in
                [(Points::Centers, 7, false), (Points::Edges, 5, true), (Points::Centers, 1, false)]
            {
                let stored = stored(warp, points, len, reversed);
                let texels: Vec<f64> =
                    stored.n_dot_v.coordinates().iter().map(|mu| (3.0 * mu).sin() - mu * mu).collect();
                let read = |t: f64| {
                    let t = if reversed { 1.0 - t } else { t };
                    let n = f64::from(len);
                    let at = if points == Points::Edges { t * (n - 1.0) } else { t * n - 0.5 };
                    let at = at.clamp(0.0, n - 1.0);
                    let i = (at as usize).min(len as usize - 1);
                    let j = (i + 1).min(len as usize - 1);
                    texels[i] + (at - i as f64) * (texels[j] - texels[i])
                };
                const STEPS: u32 = 20_000;
                let square = |i: u32| warp.value(f64::from(i) / f64::from(STEPS)).powi(2);
                let step = |i: u32| read((f64::from(i) + 0.5) / f64::from(STEPS)) * (square(i + 1) - square(i)).abs();
                let expected: f64 = (0..STEPS).map(step).sum();
                let found: f64 = stored.weights().iter().zip(&texels).map(|(w, e)| w * e).sum();
                assert!((found - expected).abs() < 1e-7, "{stored}: {found} instead of {expected}");
                let sum: f64 = stored.weights().iter().sum();
                assert!((sum - 1.0).abs() < 1e-14, "{stored}: {sum}");
            }
        }
    }

    #[test]
    fn text_is_read_back() {
        for stored in [stored(Warp::Angle, Points::Edges, 32, true), stored(Warp::NDotV, Points::Centers, 64, false)] {
            assert_eq!(Stored::parse(&stored.to_string()).expect("its own text"), stored);
        }
        for text in [
            "",
            "64 texels",
            "64 texels along roughness centers ascending in r16f",
            "1 texels along n_dot_v edges ascending in r16f",
            "64 texels along n_dot_v centers upwards in r16f",
            "64 texels along n_dot_v centers ascending in bc4",
        ] {
            assert!(Stored::parse(text).is_err(), "{text}");
        }
    }
}
