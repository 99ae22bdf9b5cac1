// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a table's texels lie: what runs along each side, how it is warped, and where in its texel a value is taken.

use crate::axis::{Coordinate, Warp};

/// Warps of the view direction.
pub const VIEW: [Warp; 4] = [Warp::NDotV, Warp::SqrtNDotV, Warp::SqrtOneMinusNDotV, Warp::Angle];
/// Warps of the roughness.
pub const ROUGHNESS: [Warp; 2] = [Warp::Roughness, Warp::Alpha];

/// Which position along a side belongs to texel i of N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// (i + ½)/N.
    Centers,
    /// i/(N − 1).
    Edges,
    /// i/N: a loop that forgot the half texel.
    Starts,
    /// (i + 1)/N: a loop that keeps off 0.
    Ends,
}

impl Points {
    /// As a report names it.
    pub fn name(self) -> &'static str {
        match self {
            Points::Centers => "centers",
            Points::Edges => "edges",
            Points::Starts => "i/N",
            Points::Ends => "(i + 1)/N",
        }
    }
}

/// One side of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// What runs along it.
    pub warp: Warp,
    /// Where in its texel a value is taken.
    pub points: Points,
    /// Texel 0 holds the largest position.
    pub reversed: bool,
    /// Texel i holds what belongs into texel i + shift: −1, 0 or 1.
    pub shift: i32,
}

impl Side {
    /// n·v or roughness of texel `i` of `len`; `None` where a shift leads out of the table.
    pub fn at(&self, i: u32, len: u32) -> Option<f64> {
        let i = i64::from(i) + i64::from(self.shift);
        let n = i64::from(len);
        if !(0..n).contains(&i) {
            return None;
        }
        let i = (if self.reversed { n - 1 - i } else { i }) as f64;
        let n = f64::from(len);
        let t = match self.points {
            Points::Centers => (i + 0.5) / n,
            Points::Edges => i / (n - 1.0),
            Points::Starts => i / n,
            Points::Ends => (i + 1.0) / n,
        };
        Some(self.warp.value(t))
    }

    /// `n_dot_v ascending, at centers`.
    pub fn words(&self) -> String {
        let order = if self.reversed { "descending" } else { "ascending" };
        format!("{} {order}, at {}", self.warp.name(), self.points.name())
    }
}

/// Both sides of a table: one is a view direction, the other a roughness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// From left to right.
    pub x: Side,
    /// From row 0 to the last.
    pub y: Side,
}

impl Layout {
    /// x is the roughness.
    pub fn is_transposed(&self) -> bool {
        self.x.warp.coordinate() == Coordinate::Roughness
    }

    /// Its positions and shifts.
    pub fn placement(&self) -> Placement {
        [self.x, self.y].map(|side| (side.points, side.shift))
    }

    /// (n·v, roughness) of a texel; `None` where a shift leads out of the table.
    pub fn at(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Option<(f64, f64)> {
        let (x, y) = (self.x.at(x, width)?, self.y.at(y, height)?);
        Some(if self.is_transposed() { (y, x) } else { (x, y) })
    }

    /// What is odd about it, if anything.
    pub fn shift_words(&self) -> Option<String> {
        let text = |what: &str, shift: i32| {
            let other = if shift > 0 { "next" } else { "previous" };
            format!("{what}s are shifted by one texel: each holds what belongs into the {other} one")
        };
        match (self.x.shift, self.y.shift) {
            (0, 0) => None,
            (0, shift) => Some(text("row", shift)),
            (shift, _) => Some(text("column", shift)),
        }
    }
}

/// Positions and shifts of both sides, x first.
pub type Placement = [(Points, i32); 2];

/// Positions and shifts of both sides that are tried, x first: the same positions along both, one shift, or a mixture of
/// centers and edges.
pub fn placements() -> Vec<Placement> {
    use Points::{Centers, Edges, Ends, Starts};
    let mut all = vec![[(Starts, 0); 2], [(Ends, 0); 2], [(Centers, 0), (Edges, 0)], [(Edges, 0), (Centers, 0)]];
    for points in [Centers, Edges] {
        for (x, y) in [(0, 0), (0, 1), (0, -1), (1, 0), (-1, 0)] {
            all.push([(points, x), (points, y)]);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifted_side_ends_early() {
        let side = Side { warp: Warp::Roughness, points: Points::Centers, reversed: false, shift: 1 };
        assert_eq!([0, 3].map(|i| side.at(i, 4)), [Some(0.375), None]);
        let side = Side { reversed: true, ..side };
        assert_eq!([0, 2, 3].map(|i| side.at(i, 4)), [Some(0.625), Some(0.125), None]);
    }

    #[test]
    fn warps_keep_their_ends() {
        for warp in VIEW {
            let mut ends = [warp.value(0.0), warp.value(1.0)];
            ends.sort_by(f64::total_cmp);
            assert_eq!(ends, [0.0, 1.0], "{}", warp.name());
        }
    }
}
