// SPDX-License-Identifier: MIT OR Apache-2.0
//! Index ↔ coordinate along one side of a table: the only place that knows where a texel's value is taken.

use std::f64::consts::FRAC_PI_2;

use crate::error::{Error, Result, nearest};

/// What a table depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Cosine between the normal and the view direction, in [0, 1].
    NDotV,
    /// Perceptual roughness, in [0, 1]; the distribution's width is `alpha = roughness²`.
    Roughness,
    /// Cosine between the normal and the direction of light, in [−1, 1].
    NDotL,
    /// Curvature of the surface in 1/mm, in [0, 1].
    Curvature,
}

impl Coordinate {
    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        self.plain().name()
    }

    /// The axis along which it grows evenly.
    pub fn plain(self) -> Warp {
        match self {
            Coordinate::NDotV => Warp::NDotV,
            Coordinate::Roughness => Warp::Roughness,
            Coordinate::NDotL => Warp::NDotL,
            Coordinate::Curvature => Warp::Curvature,
        }
    }
}

/// What the position t in [0, 1] along an axis stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warp {
    /// n·v = t.
    NDotV,
    /// n·v = t², which spreads grazing angles (Unity's high definition pipeline).
    SqrtNDotV,
    /// n·v = 1 − t², as in tables of linearly transformed cosines (Heitz, Dupuy, Hill, Neubelt 2016).
    SqrtOneMinusNDotV,
    /// n·v = cos(t π/2).
    Angle,
    /// Perceptual roughness t, alpha = t².
    Roughness,
    /// The width alpha = t.
    Alpha,
    /// n·l = 2t − 1.
    NDotL,
    /// The curvature t in 1/mm.
    Curvature,
}

impl Warp {
    /// All warps, in the order of their documentation.
    pub const ALL: [Warp; 8] = [
        Warp::NDotV,
        Warp::SqrtNDotV,
        Warp::SqrtOneMinusNDotV,
        Warp::Angle,
        Warp::Roughness,
        Warp::Alpha,
        Warp::NDotL,
        Warp::Curvature,
    ];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Warp::NDotV => "n_dot_v",
            Warp::SqrtNDotV => "sqrt_n_dot_v",
            Warp::SqrtOneMinusNDotV => "sqrt_one_minus_n_dot_v",
            Warp::Angle => "angle",
            Warp::Roughness => "roughness",
            Warp::Alpha => "alpha",
            Warp::NDotL => "n_dot_l",
            Warp::Curvature => "curvature",
        }
    }

    /// The position t as a formula, which is GLSL too.
    pub fn formula(self) -> &'static str {
        match self {
            Warp::NDotV => "n_dot_v",
            Warp::SqrtNDotV => "sqrt(n_dot_v)",
            Warp::SqrtOneMinusNDotV => "sqrt(1.0 - n_dot_v)",
            Warp::Angle => "acos(n_dot_v) * 0.63661977",
            Warp::Roughness => "roughness",
            Warp::Alpha => "roughness * roughness",
            Warp::NDotL => "0.5 + 0.5 * n_dot_l",
            Warp::Curvature => "curvature",
        }
    }

    /// The warp with this name.
    pub fn parse(name: &str) -> Result<Self> {
        let known = || Self::ALL.iter().map(|w| w.name());
        Self::ALL
            .into_iter()
            .find(|w| w.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown axis '{name}'"), nearest(name, known())))
    }

    /// Which coordinate it warps.
    pub fn coordinate(self) -> Coordinate {
        match self {
            Warp::NDotV | Warp::SqrtNDotV | Warp::SqrtOneMinusNDotV | Warp::Angle => Coordinate::NDotV,
            Warp::Roughness | Warp::Alpha => Coordinate::Roughness,
            Warp::NDotL => Coordinate::NDotL,
            Warp::Curvature => Coordinate::Curvature,
        }
    }

    /// The coordinate at t in [0, 1].
    pub fn value(self, t: f64) -> f64 {
        match self {
            Warp::NDotV | Warp::Roughness | Warp::Curvature => t,
            Warp::NDotL => 2.0 * t - 1.0,
            Warp::SqrtNDotV => t * t,
            Warp::SqrtOneMinusNDotV => (1.0 - t) * (1.0 + t),
            // Exact at the end, where the cosine of a rounded right angle is not.
            Warp::Angle if t == 1.0 => 0.0,
            Warp::Angle => (FRAC_PI_2 * t).cos(),
            Warp::Alpha => t.sqrt(),
        }
    }
}

impl Warp {
    /// The position t in [0, 1] of n·v and a perceptual roughness, both in [0, 1]: [`Warp::formula`], which is the inverse of
    /// [`Warp::value`]. Not a number where the warp is of neither. GLSL twin: `shaders/lib/warp.glsl`.
    pub fn position(self, n_dot_v: f64, roughness: f64) -> f64 {
        match self {
            Warp::NDotV => n_dot_v,
            Warp::SqrtNDotV => n_dot_v.sqrt(),
            Warp::SqrtOneMinusNDotV => (1.0 - n_dot_v).sqrt(),
            Warp::Angle => n_dot_v.acos() / FRAC_PI_2,
            Warp::Roughness => roughness,
            Warp::Alpha => roughness * roughness,
            Warp::NDotL | Warp::Curvature => f64::NAN,
        }
    }
}

/// Which point of a texel its value belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// Texel i holds the value at (i + ½)/N: what a sampler with normalised coordinates reads at the texel's center.
    Centers,
    /// Texel i holds the value at i/(N − 1): the first is the limit at 0, the last the value at 1.
    Edges,
}

impl Points {
    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Points::Centers => "centers",
            Points::Edges => "edges",
        }
    }

    /// The rule with this name.
    pub fn parse(name: &str) -> Result<Self> {
        match name {
            "centers" => Ok(Points::Centers),
            "edges" => Ok(Points::Edges),
            _ => Err(Error::usage(format!("unknown texel rule '{name}'"), nearest(name, ["centers", "edges"]))),
        }
    }
}

/// One side of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// What runs along it.
    pub warp: Warp,
    /// Where in its texel a value is taken.
    pub points: Points,
    /// Number of texels, ≥ 1 for centers and ≥ 2 for edges.
    pub len: u32,
    /// `true` when texel 0 holds the largest position.
    pub reversed: bool,
    /// Texel i holds what belongs into texel i + shift; what would lie beyond position 1 is taken there.
    pub shift: u32,
}

impl Axis {
    /// The position of texel `i`, in [0, 1].
    pub fn position(&self, i: u32) -> f64 {
        debug_assert!(i < self.len);
        let i = f64::from(if self.reversed { self.len - 1 - i } else { i } + self.shift);
        let t = match self.points {
            Points::Centers => (i + 0.5) / f64::from(self.len),
            Points::Edges => i / f64::from(self.len - 1),
        };
        t.min(1.0)
    }

    /// The coordinate of texel `i`.
    pub fn at(&self, i: u32) -> f64 {
        self.warp.value(self.position(i))
    }

    /// The coordinates of all texels, in order.
    pub fn coordinates(&self) -> Vec<f64> {
        (0..self.len).map(|i| self.at(i)).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_2_PI;

    use super::*;

    fn axis(points: Points, reversed: bool) -> Axis {
        Axis { warp: Warp::Roughness, points, len: 4, reversed, shift: 0 }
    }

    #[test]
    fn centers_are_half_a_texel_in() {
        assert_eq!(axis(Points::Centers, false).coordinates(), [0.125, 0.375, 0.625, 0.875]);
    }

    #[test]
    fn edges_reach_both_ends() {
        assert_eq!(axis(Points::Edges, false).coordinates(), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
    }

    #[test]
    fn reversed_axis_starts_at_the_largest_coordinate() {
        assert_eq!(axis(Points::Centers, true).coordinates(), [0.875, 0.625, 0.375, 0.125]);
    }

    #[test]
    fn shifted_axis_runs_ahead_and_stops_at_the_end() {
        let axis = Axis { shift: 1, ..axis(Points::Centers, false) };
        assert_eq!(axis.coordinates(), [0.375, 0.625, 0.875, 1.0]);
    }

    #[test]
    fn warps_are_the_inverses_of_their_formulas() {
        let at = |warp| Axis { warp, ..axis(Points::Edges, false) }.at(1);
        let third: f64 = 1.0 / 3.0;
        assert_eq!(at(Warp::SqrtNDotV).sqrt(), third);
        assert!(((1.0 - at(Warp::SqrtOneMinusNDotV)).sqrt() - third).abs() < 1e-15);
        assert!((at(Warp::Angle).acos() * FRAC_2_PI - third).abs() < 1e-8);
        assert!((at(Warp::Alpha) * at(Warp::Alpha) - third).abs() < 1e-15);
        for warp in Warp::ALL {
            let value = warp.value(0.3);
            let position = warp.position(value, value);
            let is_of_either = matches!(warp.coordinate(), Coordinate::NDotV | Coordinate::Roughness);
            assert!((position - 0.3).abs() < 1e-15 || !is_of_either && position.is_nan(), "{}", warp.name());
            assert_eq!(Warp::parse(warp.name()).expect("its own name"), warp);
            assert!(warp.formula().contains(warp.coordinate().name()), "{}", warp.name());
        }
    }
}
