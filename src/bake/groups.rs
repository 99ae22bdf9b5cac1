// SPDX-License-Identifier: MIT OR Apache-2.0
//! Groups of 16 × 16 texels of a filtered mip, which take what is far from them together: at 4 × 4 points, from which their
//! texels are interpolated.
//!
//! Seen from some half diagonals of the group away ([`super::specular_walk::Precision::far`]), a lobe with a tail like GGX's changes
//! so evenly over the group that a bicubic polynomial follows it: with K ~ δ⁻⁴ and Chebyshev's points the error is
//! 35/8 (ρ/δ)⁴ of a node's part at worst, ρ half a side and δ the node's distance. That is 1.4 % at three half diagonals and
//! 0.08 % at six; a texel that has its light from there alone is as wrong, most have it from all sides. Two fifths of the nodes
//! of a narrow lobe are that far: their work is done once for 16 blocks.
//!
//! **Which nodes.** The tree is parted for each group before anything is walked. A node that is a leaf, or small against its
//! distance, is far or near as its centroid is; a larger one only if all of it must be, else its children are asked. What is near
//! or far lies in subtrees, and those in ranges of nodes.

use std::f64::consts::PI;
use std::ops::Range;

use rayon::prelude::*;

use super::specular::{Prepared, SpecularJob};
use super::specular_walk::Lobe;
use crate::env::orientation::normalized;
use crate::env::projection::Projection;
use crate::env::tree::Node;

/// Texels along a side of a group.
pub const SIDE: u32 = 16;
/// Points along a side of a group: a block of the walk.
pub const POINTS: u32 = 4;
/// Where nothing nearer than this is far, in radians, little is left to share.
const MOST: f64 = 1.2;

/// A group, with the tree in two parts.
#[derive(Clone, Debug)]
pub struct Group {
    /// Direction of its middle, in the picture's axes.
    middle: [f64; 3],
    /// Distance of what is far, on the unit ball.
    far: f64,
    /// Nodes that its blocks add.
    pub near: Vec<Range<usize>>,
    /// Nodes that it adds.
    pub distant: Vec<Range<usize>>,
}

/// The groups of a mip: face by face, in rows.
pub struct Groups {
    /// In a row of a face.
    pub across: u32,
    down: u32,
    /// Each of them.
    pub each: Vec<Group>,
    /// Their points as texels of a picture that is [`POINTS`] high and has the groups side by side, in rows from the top.
    pub axes: Vec<[f64; 3]>,
}

/// How a node lies to a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Near,
    Far,
    /// Its children are asked.
    Open,
}

impl Group {
    /// Parts the nodes; those up to `whole` are not opened for this.
    fn part(&mut self, nodes: &[Node], whole: f64) {
        let add = |ranges: &mut Vec<Range<usize>>, from: usize, to: usize| match ranges.last_mut() {
            Some(last) if last.end == from => last.end = to,
            _ => ranges.push(from..to),
        };
        let mut i = 0;
        while i < nodes.len() {
            let (node, next) = (&nodes[i], i + nodes[i].skip() as usize);
            // What has no key holds nothing.
            let side = node.key().map(|key| self.side(node.c.map(f64::from), key.into(), node.skip() == 1, whole));
            match side {
                Some(Side::Near) => add(&mut self.near, i, next),
                Some(Side::Far) => add(&mut self.distant, i, next),
                Some(Side::Open) | None => {}
            }
            i = if side == Some(Side::Open) { i + 1 } else { next };
        }
    }

    /// Of a node with its centroid, its key and whether it is a leaf.
    fn side(&self, c: [f64; 3], key: f64, is_leaf: bool, whole: f64) -> Side {
        // Whatever is in a node lies within twice its half diagonal, which is at most its key.
        let slack = if is_leaf || key <= whole { 0.0 } else { 2.0 * key };
        let away2: f64 = (0..3).map(|i| (self.middle[i] - c[i]).powi(2)).sum();
        if away2 >= (self.far + slack).powi(2) {
            Side::Far
        } else if away2 < (self.far - slack).max(0.0).powi(2) {
            Side::Near
        } else {
            Side::Open
        }
    }
}

impl Groups {
    /// What is more than `far` half diagonals away is far. `None` where a mip is no whole number of groups, has edges inside of
    /// them, or has groups too large for anything to be far.
    pub fn of(job: &SpecularJob, m: u32, prepared: &Prepared<'_>, far: f64) -> Option<Groups> {
        let (width, height) = job.level_size(m);
        if job.projection == Projection::Octahedral || !width.is_multiple_of(SIDE) || !height.is_multiple_of(SIDE) {
            return None;
        }
        let (across, down) = (width / SIDE, height / SIDE);
        let count = job.projection.faces() * across * down;
        let axis = |group: u32, x: f64, y: f64| {
            let (face, at) = (group / (across * down), group % (across * down));
            let from = |i: u32| f64::from(i * SIDE);
            let (s, t) = job.place(m, from(at % across) + x, from(at / across) + y);
            prepared.frame.to_picture(normalized(job.projection.direction(face, s, t)))
        };
        let group = |index: u32| {
            let side = f64::from(SIDE);
            let middle = axis(index, 0.5 * side, 0.5 * side);
            let reach = |x: f64, y: f64| {
                let corner = axis(index, x, y);
                (0..3).map(|i| (corner[i] - middle[i]).powi(2)).sum::<f64>().sqrt()
            };
            let corners = [(0.0, 0.0), (side, 0.0), (0.0, side), (side, side)];
            let reach = corners.iter().map(|(x, y)| reach(*x, *y)).fold(0.0, f64::max);
            Group { middle, far: far * reach, near: vec![], distant: vec![] }
        };
        let mut each: Vec<Group> = (0..count).map(group).collect();
        if each.iter().any(|group| group.far > MOST) {
            return None;
        }
        let lobe: Lobe = job.lobe(m);
        each.par_iter_mut().for_each(|g| g.part(&prepared.tree.nodes, lobe.threshold(g.far * g.far, g.far / far, 0.0)));
        let at = points().map(|x| 0.5 * f64::from(SIDE) * (1.0 + x));
        let axes = at.iter().flat_map(|y| (0..count).flat_map(move |group| at.map(|x| axis(group, x, *y)))).collect();
        Some(Groups { across, down, each, axes })
    }

    /// Where the points of a group are among [`axes`](Groups::axes): rows from the top.
    pub fn block(&self, group: usize) -> impl Iterator<Item = usize> + use<> {
        let (points, stride) = (POINTS as usize, self.each.len() * POINTS as usize);
        (0..points * points).map(move |i| i / points * stride + group * points + i % points)
    }

    /// Adds to a level, RGB interleaved, what the groups found at their [`axes`](Groups::axes).
    pub fn add(&self, found: &[f32], level: &mut [f32]) {
        let weights: Vec<[f32; POINTS as usize]> = (0..SIDE).map(weights).collect();
        let (side, points) = (SIDE as usize, POINTS as usize);
        let (width, stride) = (self.across as usize * side, self.each.len() * points);
        level.par_chunks_exact_mut(3 * side * width).enumerate().for_each(|(row_of_groups, rows)| {
            for x in 0..self.across as usize {
                let group = row_of_groups * self.across as usize + x;
                let point = |i: usize, j: usize, k: usize| found[3 * (j * stride + group * points + i) + k];
                for (y, down) in weights.iter().enumerate() {
                    let line: [[f32; 3]; POINTS as usize] = std::array::from_fn(|i| {
                        std::array::from_fn(|k| (0..points).map(|j| down[j] * point(i, j, k)).sum())
                    });
                    let texels = &mut rows[3 * (y * width + x * side)..][..3 * side];
                    for (texel, across) in texels.chunks_exact_mut(3).zip(&weights) {
                        (0..3).for_each(|k| texel[k] += (0..points).map(|i| across[i] * line[i][k]).sum::<f32>());
                    }
                }
            }
        });
    }

    /// The group of a block of the walk, four texels wide, at column `x` and row `y` of blocks of a face.
    pub fn of_block(&self, [face, x, y]: [u32; 3]) -> &Group {
        let blocks = SIDE / POINTS;
        &self.each[((face * self.down + y / blocks) * self.across + x / blocks) as usize]
    }
}

/// Chebyshev's points, from −1 to 1.
fn points() -> [f64; POINTS as usize] {
    std::array::from_fn(|k| -(PI * (k as f64 + 0.5) / f64::from(POINTS)).cos())
}

/// Lagrange's weights of the points at the middle of texel `i` of a side.
fn weights(i: u32) -> [f32; POINTS as usize] {
    let (points, x) = (points(), (2.0 * f64::from(i) + 1.0) / f64::from(SIDE) - 1.0);
    std::array::from_fn(|k| {
        let others = points.iter().enumerate().filter(|(other, _)| *other != k);
        others.map(|(_, p)| (x - p) / (points[k] - p)).product::<f64>() as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::specular::SpecularRequest;
    use crate::env::Equirect;
    use crate::progress::ignore;

    fn groups(size: u32) -> (SpecularJob, Option<Groups>, Vec<Node>) {
        let job = SpecularRequest { size: Some(size), quality: "draft".into(), ..Default::default() };
        let job = job.resolve().expect("valid");
        let source = Equirect::from_fn(256, |u, v| [1.0 + u as f32, 2.0 + (9.0 * v).sin() as f32, 1.0]);
        let prepared = job.prepare(&source, None, &mut ignore).expect("nobody cancels");
        let groups = Groups::of(&job, 1, &prepared, 3.0);
        (job, groups, prepared.tree.nodes)
    }

    #[test]
    fn cubic_fields_are_interpolated_as_they_are() {
        assert!(groups(64).1.is_none(), "32 texels a face: their groups see nothing far");
        let (job, groups, _) = groups(256);
        let groups = groups.expect("128 texels a face");
        assert_eq!(groups.each.len(), 6 * 8 * 8);
        // A polynomial in the texels' columns and rows of the face, whatever it means there.
        let field = |x: f64, y: f64, face: f64| 1.0 + face + x * x * x - 2.0 * x * y * y + y * y * y * x;
        let mut found = vec![0.0; 3 * groups.axes.len()];
        let at = points().map(|x| 8.0 * (1.0 + x));
        for group in 0..groups.each.len() {
            let (face, x, y) = (group / 64, group % 8, group / 8 % 8);
            for (i, place) in groups.block(group).enumerate() {
                let (x, y) = (16.0 * x as f64 + at[i % 4], 16.0 * y as f64 + at[i / 4]);
                found[3 * place..3 * place + 3].fill(field(x / 128.0, y / 128.0, face as f64) as f32);
            }
        }
        let mut level = vec![0.0; 3 * 6 * 128 * 128];
        groups.add(&found, &mut level);
        for (index, texel) in level.chunks_exact(3).enumerate() {
            let (face, x, y) = (index / (128 * 128), index % 128, index / 128 % 128);
            let expected = field((x as f64 + 0.5) / 128.0, (y as f64 + 0.5) / 128.0, face as f64);
            assert!((f64::from(texel[0]) - expected).abs() < 1e-5, "{face} {x} {y}: {texel:?}, not {expected}");
        }
        let axis = groups.axes[groups.block(3).nth(1).unwrap()];
        let (s, t) = job.place(1, 3.0 * 16.0 + at[1], at[0]);
        let expected = normalized(job.projection.direction(0, s, t));
        assert!((0..3).all(|i| (axis[i] - expected[i]).abs() < 1e-12), "{axis:?}, not {expected:?}");
    }

    #[test]
    fn the_tree_is_parted_without_gaps_of_light() {
        let (_, groups, nodes) = groups(256);
        for group in &groups.expect("128 texels a face").each {
            let mut seen = vec![0; nodes.len()];
            group.near.iter().chain(&group.distant).for_each(|r| seen[r.clone()].iter_mut().for_each(|s| *s += 1));
            assert!(seen.iter().all(|s| *s <= 1), "a node in two parts");
            let is_light = |node: &Node| node.skip() == 1 && node.key().is_some();
            assert!(nodes.iter().zip(&seen).all(|(node, seen)| *seen == 1 || !is_light(node)), "a leaf in none");
            assert!(!group.near.is_empty() && !group.distant.is_empty());
        }
    }

    #[test]
    fn large_nodes_are_opened_where_they_may_be_both() {
        let group = Group { middle: [1.0, 0.0, 0.0], far: 0.4, near: vec![], distant: vec![] };
        let at = |angle: f64| [angle.cos(), angle.sin(), 0.0];
        assert_eq!(group.side(at(0.35), 0.3, true, 0.1), Side::Near);
        assert_eq!(group.side(at(0.45), 0.3, true, 0.1), Side::Far);
        assert_eq!(group.side(at(0.45), 0.3, false, 0.1), Side::Open);
        assert_eq!(group.side(at(0.45), 0.1, false, 0.1), Side::Far);
        assert_eq!(group.side(at(1.2), 0.3, false, 0.1), Side::Far);
        assert_eq!(group.side(at(0.05), 0.15, false, 0.1), Side::Near);
    }
}
