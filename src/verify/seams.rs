// SPDX-License-Identifier: MIT OR Apache-2.0
//! Seams of a map of the sphere: where a face ends and another (or the same one) goes on.
//!
//! Of four texels a₁ a₀ | b₀ b₁ in a line across a seam, the step a₀ → b₀ of a smooth function is the mean of the steps
//! beside it, in proportion to their lengths along a₀ → b₀. A line of texels bends there, but symmetrically, so the bend
//! cancels. How far it is off is compared with the worst of the same figures further in: a light that sets makes a real
//! crease, but it does not follow seams.

use serde::Serialize;

use crate::env::projection::Projection;
use crate::texture::Texture;

/// Face, column, row.
type Texel = [u32; 3];

/// Texels in a line: a₀ … on this side of a seam, as far as the middle, b₀ and b₁ on the other.
struct Line {
    here: Vec<Texel>,
    there: [Texel; 2],
}

/// Root mean squares over all seams of a level, over the root mean square of the level's values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Seams {
    /// Of what the step across is off by.
    pub across: f64,
    /// Of what the second step inside is off by, to which the outermost texel belongs.
    pub edge: f64,
    /// The largest of the same further inside.
    pub within: f64,
    /// Of the steps themselves.
    pub steps: f64,
}

impl Seams {
    /// Are there no rings, for values that are stored to a relative `rounding`? A line that bends at a seam adds to what
    /// its step is off by, in proportion to the steps and to the texels' size.
    pub fn are_clean(&self, rounding: f64) -> bool {
        self.across.max(self.edge) <= 2.0 * self.within + 0.1 * self.steps + 2.0 * rounding
    }
}

/// Faces smaller than this are all seam.
const LEAST_SIZE: u32 = 16;

/// Measures a level; `None` where its faces are too small to have an inside.
pub fn measure(texture: &Texture, projection: Projection, level: usize) -> Option<Seams> {
    let (width, height) = texture.level_size(level);
    if height < LEAST_SIZE {
        return None;
    }
    let channels = texture.channels.len().min(3);
    let at = |i: u32, n: u32| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
    let direction = |[face, x, y]: Texel| projection.direction(face, at(x, width), at(y, height));
    let off = |four: [Texel; 4]| -> f64 {
        let d = four.map(direction);
        let step = |i: usize| -> [f64; 3] { std::array::from_fn(|k| d[i + 1][k] - d[i][k]) };
        let length = |i: usize| -> f64 { step(i).iter().zip(step(1)).map(|(a, b)| a * b).sum() };
        let share = length(1) / (length(0) + length(2));
        // Near the middles of an octahedral map's edges a line turns by a right angle: it says nothing there.
        if !(0.25..1.0).contains(&share) {
            return 0.0;
        }
        (0..channels)
            .map(|c| {
                let v = four.map(|texel| f64::from(texture.texel(level, texel[0], texel[1], texel[2])[c]));
                ((v[2] - v[1]) - share * ((v[1] - v[0]) + (v[3] - v[2]))).powi(2)
            })
            .sum()
    };
    let [mut across, mut edge, mut steps, mut scale] = [0.0; 4];
    let mut within = vec![];
    for Line { here, there: [b0, b1] } in lines(projection, width, height) {
        let (a0, a1) = (here[0], here[1]);
        across += off([a1, a0, b0, b1]);
        edge += off([here[3], here[2], a1, a0]);
        within.resize(here.len() - 4, 0.0);
        for (sum, four) in within.iter_mut().zip(here[1..].windows(4)) {
            *sum += off([four[3], four[2], four[1], four[0]]);
        }
        let value = |texel: Texel| &texture.texel(level, texel[0], texel[1], texel[2])[..channels];
        let pairs = value(a0).iter().zip(value(a1));
        pairs.for_each(|(outer, inner)| {
            steps += f64::from(outer - inner).powi(2);
            scale += f64::from(*outer).powi(2);
        });
    }
    let scale = f64::max(scale, f64::MIN_POSITIVE);
    let within = within.into_iter().fold(0.0, f64::max);
    let [across, edge, within, steps] = [across, edge, within, steps].map(|sum| (sum / scale).sqrt());
    Some(Seams { across, edge, within, steps })
}

/// Every line of texels across a seam, from both sides.
fn lines(projection: Projection, width: u32, height: u32) -> Vec<Line> {
    match projection {
        Projection::Equirect => {
            (0..height).map(|y| line(width / 2, |i| [0, i, y], |i| [0, width - 1 - i, y])).collect()
        }
        Projection::Octahedral => {
            let last = width - 1;
            (0..last.div_ceil(2))
                .flat_map(|k| {
                    [
                        line(width / 2, |i| [0, i, k], |i| [0, i, last - k]),
                        line(width / 2, |i| [0, last - i, k], |i| [0, last - i, last - k]),
                        line(width / 2, |i| [0, k, i], |i| [0, last - k, i]),
                        line(width / 2, |i| [0, k, last - i], |i| [0, last - k, last - i]),
                    ]
                })
                .collect()
        }
        Projection::Cube => {
            let sides = (0..6).flat_map(|face| [0, 1, 2, 3].map(|side| (face, side)));
            sides.flat_map(|(face, side)| (0..width).map(move |k| cube_line(face, side, k, width))).collect()
        }
    }
}

/// A line that runs `depth` texels into the face.
fn line(depth: u32, here: impl Fn(u32) -> Texel, there: impl Fn(u32) -> Texel) -> Line {
    Line { here: (0..depth).map(here).collect(), there: [0, 1].map(there) }
}

/// The line through texel `k` of a side of a face: left, right, top, bottom.
fn cube_line(face: u32, side: u32, k: u32, size: u32) -> Line {
    let last = size - 1;
    let at = |side: u32, k: u32, i: u32| match side {
        0 => [i, k],
        1 => [last - i, k],
        2 => [k, i],
        _ => [k, last - i],
    };
    // A point just beyond the middle of the texel's edge says which side of which face is there.
    let along = 2.0 * (f64::from(k) + 0.5) / f64::from(size) - 1.0;
    const BEYOND: f64 = 1.0 + 1e-9;
    let (s, t) = [(-BEYOND, along), (BEYOND, along), (along, -BEYOND), (along, BEYOND)][side as usize];
    let (other, s, t) = Projection::Cube.locate(crate::term::cube::direction(face, s, t));
    let index = |x: f64| (((x + 1.0) / 2.0 * f64::from(size)) as u32).min(last);
    let (other_side, other_k) =
        if s.abs() > t.abs() { (u32::from(s > 0.0), index(t)) } else { (2 + u32::from(t > 0.0), index(s)) };
    let texel = |face: u32, [x, y]: [u32; 2]| [face, x, y];
    line(size / 2, |i| texel(face, at(side, k, i)), |i| texel(other, at(other_side, other_k, i)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Meta, Shape};

    /// A smooth function of direction, as a level of a map.
    fn smooth(projection: Projection, size: u32) -> Texture {
        let (width, height) = projection.level_size(size);
        let at = |i: u32, n: u32| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
        let mut level = vec![];
        for face in 0..projection.faces() {
            for y in 0..height {
                for x in 0..width {
                    let [a, b, c] = projection.direction(face, at(x, width), at(y, height));
                    level.extend([1.0 + 0.4 * a - 0.3 * b * c, 2.0 + a * b + c, (3.0 * c + a).exp()].map(|v| v as f32));
                }
            }
        }
        let shape = if projection == Projection::Cube { Shape::Cube } else { Shape::Map };
        let channels = ["r", "g", "b"].map(String::from).to_vec();
        Texture { shape, width, height, channels, levels: vec![level], meta: Meta::default() }
    }

    #[test]
    fn smooth_functions_have_no_seams() {
        for projection in Projection::ALL {
            let seams = measure(&smooth(projection, 64), projection, 0).expect("large enough");
            assert!(seams.are_clean(1e-7), "{projection:?}: {seams:?}");
        }
    }

    #[test]
    fn a_turned_face_and_a_dim_border_are_seen() {
        let mut turned = smooth(Projection::Cube, 64);
        let face = turned.levels[0].len() / 6;
        turned.levels[0][..face].reverse();
        let seams = measure(&turned, Projection::Cube, 0).expect("large enough");
        assert!(!seams.are_clean(1e-3), "{seams:?}");
        for projection in [Projection::Equirect, Projection::Octahedral] {
            let mut dim = smooth(projection, 64);
            let width = dim.width as usize;
            dim.levels[0].chunks_exact_mut(3).step_by(width).for_each(|t| t.iter_mut().for_each(|v| *v *= 0.7));
            let seams = measure(&dim, projection, 0).expect("large enough");
            assert!(!seams.are_clean(5e-4), "{projection:?}: {seams:?}");
        }
    }
}
