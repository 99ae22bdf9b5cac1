// SPDX-License-Identifier: MIT OR Apache-2.0
//! The rule of filtered environments, in f64: a lobe walks the tree of a picture. GLSL twin: `shaders/bake/specular_walk.glsl`.
//!
//! No sampling: for each 4 × 4 texels the tree of moments ([`crate::env::tree`]) is walked. A node that is
//! small against its distance from the lobe's axis is added as a whole, through its energy, centroid, colour moments
//! and spread:
//!
//! ```text
//! h̄ = (|n − c|² + tr Q)/4            the exact mean of h over the node
//! v = (n − c)ᵀ Q (n − c)/8 + beyond (tr Q)²    half its variance; the second part also stands for terms beyond
//! w = √(1.5 tr Q)                    half the node's reach in μ; √(3 (n − c)ᵀ Q (n − c)) for kernels with a sharp horizon
//! f = clamp(½ + (1 − 2h̄)/(2w), 0, 1), μ̄ = max(1 − 2h̄, w f²)    share above the horizon, mean of max(μ, 0)
//! s += mean(h̄, μ̄, f, v) e + slope(…) n·D
//! ```
//!
//! Otherwise its children are visited, or the leaf is cut into parts of its texels. "Small" is
//!
//! ```text
//! extent · brightness ≤ eps · room
//! ```
//!
//! with the kernel's own `room`: the length over which it changes at the node's place. The error of a node goes with the
//! third power of extent/room. Division is by the kernel's own norm, never by a sum of weights.

use std::ops::Range;

use super::quality;
use super::specular::Prepared;
use crate::env::orientation::normalized;
use crate::env::tree::{FINE, Moments, Node, Tree, face_and_corner};
use crate::env::{CubeMap, Equirect, Picture};
use crate::term::cube::direction;
use crate::term::zonal::Zonal;

/// More parts than these a tree is not walked in.
pub(super) const MOST_PARTS: usize = 64;

/// How finely the walk looks. The error goes with eps³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// Extent of a node over the room that the kernel leaves it ([`Zonal::room`]).
    pub eps: f64,
    /// Nodes brighter than the mean are cut finer by the root of the ratio, up to this factor.
    pub brightness_limit: f64,
    /// Iterations of all loops together after which an invocation gives up with an error: one a node that is looked at, two
    /// a node that is added. Software Vulkan counts to 65,535.
    pub limit: u32,
    /// What is more than this many half diagonals away from a group of texels is far and shared by them, where the kernel's tail
    /// lets it: [`super::groups`]. Infinite where nothing is shared.
    pub far: f64,
}

impl Default for Precision {
    fn default() -> Self {
        quality::STANDARD.precision
    }
}

/// A kernel at one width, with the bounds of the walk.
#[derive(Clone, Copy)]
pub struct Lobe {
    kernel: &'static Zonal,
    /// Width.
    pub alpha: f64,
    pub(super) inverse_norm: f64,
    precision: Precision,
}

/// What a walk found, and how far it went.
#[derive(Clone, Debug)]
pub struct Walked {
    /// The filtered radiance at every axis.
    pub values: Vec<[f64; 3]>,
    /// Iterations.
    pub steps: u32,
    /// Nodes and parts that were added.
    pub added: u32,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Area of a leaf in units of a texel / [`FINE`].
fn units(node: &Node) -> u32 {
    u32::from(node.rows[1]) * u32::from(node.columns[1])
}

/// dᵀ Q d.
fn quadratic(q: &[f64; 6], d: [f64; 3]) -> f64 {
    q[0] * d[0] * d[0]
        + q[1] * d[1] * d[1]
        + q[2] * d[2] * d[2]
        + 2.0 * (q[3] * d[0] * d[1] + q[4] * d[0] * d[2] + q[5] * d[1] * d[2])
}

impl Lobe {
    /// A kernel at width `alpha` > 0.
    pub fn new(kernel: &'static Zonal, alpha: f64, precision: Precision) -> Self {
        Self { kernel, alpha, inverse_norm: 1.0 / (kernel.norm)(alpha), precision }
    }

    /// No node has to be smaller than this.
    pub(super) fn least_threshold(&self) -> f64 {
        self.precision.eps * (self.kernel.least_room)(self.alpha)
    }

    /// A node whose key is above this is too large; see [`Zonal::room`].
    pub(super) fn threshold(&self, away2: f64, reach: f64, key: f64) -> f64 {
        self.precision.eps * (self.kernel.room)(away2, reach, key, self.alpha)
    }

    /// Walks ranges of the tree's nodes, whole subtrees, for the axes of a block in the picture's frame: the rule in f64, over the
    /// nodes that the shader reads. `None` when it takes more steps than allowed.
    pub fn walk(&self, prepared: &Prepared<'_>, axes: &[[f64; 3]], ranges: &[Range<usize>]) -> Option<Walked> {
        let Prepared { picture, tree, .. } = prepared;
        let middle = axes.iter().fold([0.0; 3], |a, n| [a[0] + n[0], a[1] + n[1], a[2] + n[2]]);
        let middle = normalized(middle);
        let reach = axes.iter().map(|n| dot(minus(*n, middle), minus(*n, middle))).fold(0.0, f64::max).sqrt();
        let most_steps = self.precision.limit * MOST_PARTS as u32;
        let mut walked = Walked { values: vec![[0.0; 3]; axes.len()], steps: 0, added: 0 };
        for range in ranges {
            let mut i = range.start;
            while i < range.end {
                walked.steps += 1;
                if walked.steps > most_steps {
                    return None;
                }
                let node = &tree.nodes[i];
                let Some(key) = node.key().map(f64::from) else {
                    i += node.skip() as usize;
                    continue;
                };
                let away = minus(middle, node.c.map(f64::from));
                let away2 = dot(away, away);
                if 1.0 - 0.5 * away2 + reach + 2.0 * key < 0.0 {
                    i += node.skip() as usize;
                    continue;
                }
                let threshold = self.threshold(away2, reach, key);
                if key > threshold && node.skip() > 1 {
                    i += 1;
                    continue;
                }
                if prepared.cuts && node.is_cut(threshold, self.kernel.sharp_horizon) {
                    // At a sharp horizon the parts of a bright texel are small for their brightness too.
                    let brightness = node.key().map_or(1.0, |key| f64::from(key / node.extent));
                    let finer = self.kernel.sharp_horizon && units(node) <= FINE * FINE;
                    let side = 2f64.sqrt() * threshold / if finer { brightness.max(1.0) } else { 1.0 };
                    match picture {
                        Picture::Equirect(p) => self.cut(p, tree, node, side, axes, &mut walked),
                        Picture::Cube(p) => self.cut_faces(p, tree, node, side, axes, &mut walked),
                    }
                } else {
                    self.add(&tree.moments(i), axes, &mut walked);
                    walked.steps += 2;
                }
                i += node.skip() as usize;
            }
        }
        for value in &mut walked.values {
            (0..3).for_each(|k| value[k] = value[k] * self.inverse_norm + f64::from(tree.base[k]));
        }
        (walked.steps <= most_steps).then_some(walked)
    }

    /// Adds a leaf by parts of at most `side`: rectangles in (θ, φ), each with its texel's radiance.
    fn cut(&self, source: &Equirect, tree: &Tree, node: &Node, side: f64, axes: &[[f64; 3]], walked: &mut Walked) {
        let unit_theta = std::f64::consts::PI / f64::from(FINE * source.height);
        let unit_phi = std::f64::consts::TAU / f64::from(FINE * source.width);
        let [r0, rows] = node.rows.map(u32::from);
        let [c0, columns] = node.columns.map(u32::from);
        // A texel of the leaf, or the leaf where it is a part of one, and how it is cut.
        let (high, wide) = (rows.min(FINE), columns.min(FINE));
        let middle = (f64::from(r0 / FINE + rows / FINE / 2) + 0.5) * f64::from(FINE) * unit_theta;
        let parts = |length: f64| (length / side).ceil().max(1.0) as u32;
        let down = parts(f64::from(high) * unit_theta);
        let across = parts(f64::from(wide) * unit_phi * middle.sin());
        let a = 0.5 * f64::from(high) * unit_theta / f64::from(down);
        let b = 0.5 * f64::from(wide) * unit_phi / f64::from(across);
        for y in 0..rows / high * down {
            let row = (r0 + y / down * high) / FINE;
            let theta = f64::from(r0) * unit_theta + f64::from(2 * y + 1) * a;
            let (sin_theta, cos_theta) = theta.sin_cos();
            for x in 0..columns / wide * across {
                let texel = source.row(row)[((c0 + x / across * wide) / FINE) as usize];
                let phi = f64::from(c0) * unit_phi + f64::from(2 * x + 1) * b - std::f64::consts::PI;
                let (sin_phi, cos_phi) = phi.sin_cos();
                let radius =
                    b.sin() / b * (sin_theta * a.cos() + (a - 0.5 * (2.0 * a).sin()) / (2.0 * sin_theta * a.sin()));
                let c = [radius * cos_phi, cos_theta * a.cos(), radius * sin_phi];
                let (q_down, q_along) = (a * a / 3.0, b * b / 3.0 * sin_theta * sin_theta);
                let (u, v) = ([cos_theta * cos_phi, -sin_theta, cos_theta * sin_phi], [-sin_phi, 0.0, cos_phi]);
                let q = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
                    .map(|(i, j)| q_down * u[i] * u[j] + q_along * v[i] * v[j]);
                let solid_angle = 4.0 * a.sin() * b * sin_theta;
                let e = std::array::from_fn(|k| solid_angle * f64::from(texel[k] - tree.base[k]));
                self.add(&Moments { c, e, d: [[0.0; 3]; 3], q }, axes, walked);
                walked.steps += 2;
            }
        }
    }

    /// The same on a cube: rectangles in (s, t), whose moments are taken to the second order of their sides.
    fn cut_faces(&self, source: &CubeMap, tree: &Tree, node: &Node, side: f64, axes: &[[f64; 3]], walked: &mut Walked) {
        let unit = 2.0 / f64::from(FINE * source.size);
        let (face, [c0, r0]) = face_and_corner(node);
        let (rows, columns) = (u32::from(node.rows[1]), u32::from(node.columns[1]));
        let centre = direction(face, 0.0, 0.0);
        let s_axis = minus(direction(face, 1.0, 0.0), centre);
        let t_axis = minus(direction(face, 0.0, 1.0), centre);
        // A texel of the leaf, or the leaf where it is a part of one, and how it is cut.
        let (high, wide) = (rows.min(FINE), columns.min(FINE));
        let middle = |first: u32, count: u32| unit * (f64::from(first) + 0.5 * f64::from(count)) - 1.0;
        let (s2, t2) = (middle(c0, columns).powi(2), middle(r0, rows).powi(2));
        let parts = |units: u32, across2: f64| {
            let length_rad = f64::from(units) * unit * (1.0 + across2).sqrt() / (1.0 + s2 + t2);
            (length_rad / side).ceil().max(1.0) as u32
        };
        let (down, across) = (parts(high, s2), parts(wide, t2));
        let a = 0.5 * f64::from(high) * unit / f64::from(down);
        let b = 0.5 * f64::from(wide) * unit / f64::from(across);
        for y in 0..rows / high * down {
            let row = (r0 + y / down * high) / FINE;
            let t = f64::from(r0) * unit + f64::from(2 * y + 1) * a - 1.0;
            for x in 0..columns / wide * across {
                let texel = source.texel(face, (c0 + x / across * wide) / FINE, row);
                let s = f64::from(c0) * unit + f64::from(2 * x + 1) * b - 1.0;
                let p = direction(face, s, t);
                let (inverse2, sixth_a, sixth_b) = (1.0 / (1.0 + s * s + t * t), a * a / 6.0, b * b / 6.0);
                let inverse = inverse2.sqrt();
                let spread = (sixth_a + sixth_b) * inverse2;
                let slant = (sixth_a * t * t + sixth_b * s * s) * inverse2 * inverse2;
                let solid_angle = 4.0 * a * b * inverse2 * inverse * (1.0 - 3.0 * spread + 15.0 * slant);
                let (outwards, along) = (inverse * (1.0 - spread + 9.0 * slant), -8.0 * inverse * inverse2);
                let c =
                    [0, 1, 2].map(|i| outwards * p[i] + along * (sixth_b * s * s_axis[i] + sixth_a * t * t_axis[i]));
                // How the direction moves with s and t.
                let u = [0, 1, 2].map(|i| inverse * (s_axis[i] - p[i] * s * inverse2));
                let v = [0, 1, 2].map(|i| inverse * (t_axis[i] - p[i] * t * inverse2));
                let q = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
                    .map(|(i, j)| 2.0 * (sixth_b * u[i] * u[j] + sixth_a * v[i] * v[j]));
                let e = [0, 1, 2].map(|k| solid_angle * f64::from(texel[k] - tree.base[k]));
                self.add(&Moments { c, e, d: [[0.0; 3]; 3], q }, axes, walked);
                walked.steps += 2;
            }
        }
    }

    fn add(&self, node: &Moments, axes: &[[f64; 3]], walked: &mut Walked) {
        let spread = node.q[0] + node.q[1] + node.q[2];
        let w_mean = (1.5 * spread).sqrt() + 1e-7;
        let v0 = self.kernel.beyond * spread * spread;
        for (n, sum) in axes.iter().zip(&mut walked.values) {
            let d = minus(*n, node.c);
            let h = 0.25 * (dot(d, d) + spread);
            let along = 0.125 * quadratic(&node.q, d);
            let v = (v0 + along).max(0.0);
            let mu0 = 1.0 - 2.0 * h;
            let w = if self.kernel.sharp_horizon { (24.0 * along).max(0.0).sqrt() + 1e-7 } else { w_mean };
            let f = (0.5 + 0.5 * mu0 / w).clamp(0.0, 1.0);
            let mu = mu0.max(w * f * f);
            let [mean, slope] = (self.kernel.over_node)(h, mu, f, v, self.alpha);
            (0..3).for_each(|k| sum[k] += mean * node.e[k] + slope * dot(*n, node.d[k]));
        }
        walked.added += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::specular::SpecularRequest;
    use crate::progress::ignore;

    #[test]
    fn pieces_of_a_tree_add_up_to_it() {
        let mut value = 0u32;
        let source = Equirect::from_fn(64, |_, _| {
            value = value.wrapping_mul(1664525).wrapping_add(1013904223);
            [(value >> 16) as f32, (value >> 20) as f32, 1.0 + (value >> 24) as f32]
        });
        let job = SpecularRequest { size: Some(32), ..Default::default() }.resolve().expect("valid");
        let whole = job.prepare(&source, None, &mut ignore).expect("nobody cancels");
        let walk = |prepared: &Prepared<'_>| {
            let axes = [normalized([0.3, 0.5, -0.8])];
            let walked =
                job.lobe(1).walk(prepared, &axes, std::slice::from_ref(&prepared.tree.whole())).expect("few steps");
            [0, 1, 2].map(|k| walked.values[0][k] - f64::from(whole.tree.base[k]))
        };
        let expected = walk(&whole);
        for most in [100, 5000, 1 << 21] {
            let pieces = whole.tree.pieces(0..whole.tree.nodes.len(), most);
            assert_eq!(pieces.len() == 1, most > whole.tree.nodes.len());
            assert!(pieces.iter().all(|p| p.len() <= most));
            let mut sum = [0.0; 3];
            for piece in pieces {
                let tree = Tree { nodes: whole.tree.nodes[piece].to_vec(), ..whole.tree.clone() };
                let part =
                    walk(&Prepared { picture: whole.picture.borrowed(), frame: whole.frame, cuts: whole.cuts, tree });
                (0..3).for_each(|k| sum[k] += part[k]);
            }
            // Parents that were left out are looked at through their children, which is finer.
            assert!((0..3).all(|k| (sum[k] / expected[k] - 1.0).abs() < 1e-3), "{most}: {sum:?} {expected:?}");
        }
    }
}
