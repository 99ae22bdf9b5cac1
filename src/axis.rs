//! Index ↔ coordinate along one side of a table: the only place that knows where a texel's value is taken.

use crate::error::{Error, Result, nearest};

/// What runs along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Cosine between the normal and the view direction, in [0, 1].
    NDotV,
    /// Perceptual roughness, in [0, 1]; the distribution's width is `alpha = roughness²`.
    Roughness,
}

impl Coordinate {
    /// All coordinates, in the order of their documentation.
    pub const ALL: [Coordinate; 2] = [Coordinate::NDotV, Coordinate::Roughness];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Coordinate::NDotV => "n_dot_v",
            Coordinate::Roughness => "roughness",
        }
    }

    /// The coordinate with this name.
    pub fn parse(name: &str) -> Result<Self> {
        let known = || Self::ALL.iter().map(|c| c.name());
        Self::ALL
            .into_iter()
            .find(|c| c.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown axis '{name}'"), nearest(name, known())))
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
    pub coordinate: Coordinate,
    /// Where in its texel a value is taken.
    pub points: Points,
    /// Number of texels, ≥ 1 for centers and ≥ 2 for edges.
    pub len: u32,
    /// `true` when texel 0 holds the largest coordinate.
    pub reversed: bool,
}

impl Axis {
    /// The coordinate of texel `i`, in [0, 1].
    pub fn at(&self, i: u32) -> f64 {
        debug_assert!(i < self.len);
        let i = if self.reversed { self.len - 1 - i } else { i };
        match self.points {
            Points::Centers => (f64::from(i) + 0.5) / f64::from(self.len),
            Points::Edges => f64::from(i) / f64::from(self.len - 1),
        }
    }

    /// The coordinates of all texels, in order.
    pub fn coordinates(&self) -> Vec<f64> {
        (0..self.len).map(|i| self.at(i)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(points: Points, reversed: bool) -> Axis {
        Axis { coordinate: Coordinate::Roughness, points, len: 4, reversed }
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
}
