// SPDX-License-Identifier: MIT OR Apache-2.0
//! An environment as a tree of moments, so that an integral over the sphere costs a few thousand nodes instead of
//! millions of texels.
//!
//! **Shape.** A node is a rectangle of the picture: rows r0..r1, columns c0..c1; on a cube the faces lie below each
//! other, and only nodes above the faces span several. It is cut across its longer side, in
//! the middle, into two or four, until it is small enough ([`Params`]) or one texel. Sides are measured on the sphere,
//! so rectangles near the poles stay compact although texels are slivers there. Nodes lie in depth-first order and each
//! one knows how many nodes its subtree has (`skip`): a walk needs no stack, `i += 1` enters a node, `i += skip` passes
//! it. The leaves' borders are texel borders, so a leaf may be cut further, analytically, as finely as a narrow lobe asks.
//! Only texels much brighter than the mean are cut into nodes of their own: beside them nothing averages errors out.
//!
//! **Moments.** Radiance is split as L = base + R with `base` the lowest value of each channel: the base needs no
//! integration, R ≥ 0. Over a node, with W = Σ_k R_k/mean_k (each channel counts alike):
//!
//! ```text
//! e   = ∫ R dω                      energy, per channel
//! c   = ∫ W ω dω / ∫ W dω           centroid: inside the unit ball
//! Q   = ∫ W (ω−c)(ω−c)ᵀ dω / ∫ W dω spread; trace Q = 1 − |c|²
//! D_k = ∫ R_k (ω−c) dω              a channel's own first moment
//! ```
//!
//! With these, the first moment of every channel is exact and the second is exact for the channels' mean. All integrals
//! over a texel are closed: ω = (cos φ sin θ, cos θ, sin φ sin θ) separates. Σ_k D_k/mean_k = 0, so two channels suffice.
//!
//! Sums are `f64`; a node is stored in 64 bytes, D and Q as 16-bit integers relative to the node's size.

mod equirect;
mod faces;

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::{Picture, Survey};
use crate::error::Result;
use crate::progress::{OnProgress, tick, watched};
pub use faces::{MAX_SIZE, face_and_corner};

/// How a tree is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// A node whose half diagonal × brightness factor is below this angle is a leaf, if it has no more than [`MAX_CUT`]
    /// texels.
    pub leaf_extent_rad: f64,
    /// A node whose half diagonal is below this angle is a leaf: no lobe asks for more.
    pub least_extent_rad: f64,
    /// A node brighter than the mean counts as larger, so that it is cut more finely: by the root of the ratio, up to
    /// this factor.
    pub brightness_limit: f64,
}

/// Texels in a leaf that a walk may look at one by one.
pub const MAX_CUT: u32 = 16;

/// A rectangle of the picture with its moments, as the shader reads it: four times four words.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Centroid.
    pub c: [f32; 3],
    /// Low 22 bits: [`Node::skip`]. High 10 bits: [`Node::key`].
    key_and_skip: u32,
    /// Energy.
    pub e: [f32; 3],
    /// Half diagonal of the rectangle.
    pub extent: f32,
    /// D of red (x, y, z) and green, as 16-bit fractions of e_k × 2 half diagonals.
    d: [i16; 6],
    /// First row (low half), rows (high half), in units of a texel / [`FINE`]. On a cube the face is part of both first
    /// ones: [`face_and_corner`].
    pub rows: [u16; 2],
    /// Q: xx, yy, zz, xy, xz, yz, as 16-bit fractions of (2 half diagonals)².
    q: [i16; 6],
    /// First column (low half), columns (high half), in units of a texel / [`FINE`].
    pub columns: [u16; 2],
}

const STAGE: &str = "building the tree";

/// Subtrees of at most this many texels are grown side by side.
const PART: u32 = 1 << 15;

/// A texel's sides are cut into this many units at most.
pub const FINE: u32 = 4;
/// A texel this many times brighter (as a factor of its extent) than the mean is cut into nodes.
const CUT_BRIGHTNESS: f64 = 2.0;

/// A node whose channels lie apart by its half diagonal counts as larger by 1 and this.
const COLOUR: f64 = 20.0;

/// Nodes of a subtree: more do not get a common root.
pub const MAX_NODES: u32 = 1 << 22;

impl Node {
    /// Nodes in this subtree, this one included.
    pub fn skip(&self) -> u32 {
        self.key_and_skip & (MAX_NODES - 1)
    }

    /// Half diagonal × brightness factor: 5 bits of exponent, 5 of mantissa, rounded up. `None` where R = 0.
    pub fn key(&self) -> Option<f32> {
        let code = self.key_and_skip >> 22;
        (code != 0).then(|| f32::from_bits(KEY_BASE | code << 18))
    }

    /// Is a leaf cut into parts, if what is above `threshold` is too large? A bright leaf is cut down to its texels, but
    /// only if they are few; a leaf that is too large itself is cut as finely as need be. With `sharp`, so are bright
    /// parts of a texel.
    pub fn is_cut(&self, threshold: f64, sharp: bool) -> bool {
        let units = u32::from(self.rows[1]) * u32::from(self.columns[1]);
        let least = if sharp { 1 } else { FINE * FINE + 1 };
        self.key().is_some_and(|key| f64::from(key) > threshold)
            && (f64::from(self.extent) > threshold || (least..=MAX_CUT * FINE * FINE).contains(&units))
    }

    fn key_code(key: f64) -> u32 {
        let bits =
            (key as f32).clamp(f32::from_bits(KEY_BASE | 1 << 18), f32::from_bits(KEY_BASE | 1023 << 18)).to_bits();
        (bits.div_ceil(1 << 18) - (KEY_BASE >> 18)).min(1023)
    }
}

/// Bits that every key shares as `f32`: keys run from 2⁻³¹ to 2.
const KEY_BASE: u32 = 0x3000_0000;

/// A [`Node`], decoded.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    /// Centroid.
    pub c: [f64; 3],
    /// Energy per channel.
    pub e: [f64; 3],
    /// D per channel.
    pub d: [[f64; 3]; 3],
    /// Q: xx, yy, zz, xy, xz, yz.
    pub q: [f64; 6],
}

/// The tree and what goes with it.
#[derive(Clone, Debug)]
pub struct Tree {
    /// Depth-first; several trees in a row where one would have more than [`MAX_NODES`].
    pub nodes: Vec<Node>,
    /// Subtracted from every texel: the lowest value of each channel.
    pub base: [f32; 3],
    /// The highest value of each channel.
    pub most: [f32; 3],
    /// Mean of R over the sphere, per channel.
    pub mean: [f64; 3],
}

/// Sums over a rectangle, before they are divided.
#[derive(Clone, Copy, Default)]
struct Sums {
    e: [f64; 3],
    /// ∫ R_k ω
    first: [[f64; 3]; 3],
    /// ∫ W ω ωᵀ: xx, yy, zz, xy, xz, yz
    second: [f64; 6],
}

impl Sums {
    fn add(&mut self, o: &Sums) {
        for k in 0..3 {
            self.e[k] += o.e[k];
            for x in 0..3 {
                self.first[k][x] += o.first[k][x];
            }
        }
        for i in 0..6 {
            self.second[i] += o.second[i];
        }
    }
}

/// Rows r0..r1 and columns c0..c1 in units of a texel / [`FINE`]: whole texels, or a part of one.
#[derive(Clone, Copy)]
struct Rect {
    r0: u32,
    r1: u32,
    c0: u32,
    c1: u32,
}

/// Whole texels of a rectangle; 0 for a part of one.
fn texel_count(r: Rect) -> u32 {
    (r.r1 - r.r0) / FINE * ((r.c1 - r.c0) / FINE)
}

/// How a kind of picture lies on the sphere.
trait Chart: Sync {
    /// Rows and columns in units of a texel / [`FINE`].
    fn size(&self) -> (u32, u32);
    /// Height and greatest width of a rectangle on the sphere, in radians.
    fn sides(&self, r: Rect) -> (f64, f64);
    /// At most this far, in radians, from the middle of a rectangle to its corners.
    fn half_diagonal(&self, r: Rect) -> f64;
    /// Solid angle of a rectangle, in steradians.
    fn solid_angle_sr(&self, r: Rect) -> f64;
    /// The row where a rectangle must be cut before anything else.
    fn seam(&self, r: Rect) -> Option<u32>;
    /// Sums over whole texels or over a part of one.
    fn sums(&self, r: Rect, light: &Light) -> Sums;
    /// Where a rectangle lies, as [`Node::rows`] and [`Node::columns`] hold it.
    fn place(&self, r: Rect) -> [[u16; 2]; 2];
}

/// What turns texels into R and W.
struct Light {
    base: [f32; 3],
    inverse_mean: [f64; 3],
}

struct Builder<'a, C> {
    chart: &'a C,
    params: Params,
    light: Light,
}

fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

impl Tree {
    /// Builds the tree of a picture. `base` is `None` for the lowest value of each channel.
    pub fn new(
        picture: &Picture<'_>,
        params: &Params,
        base: Option<[f32; 3]>,
        on: &mut OnProgress<'_>,
    ) -> Result<Self> {
        tick(on, STAGE, 0.0)?;
        let Survey { mean: whole, least, most, .. } = Survey::of(picture);
        let base = base.unwrap_or(least);
        // What is left of a constant channel is rounding.
        let mean: [f64; 3] = std::array::from_fn(|k| {
            let mean = whole[k] - f64::from(base[k]);
            if mean > 1e-12 * whole[k] { mean } else { 0.0 }
        });
        let light = Light { base, inverse_mean: mean.map(inverse) };
        let nodes = match picture {
            Picture::Equirect(picture) => Self::grown(&equirect::Chart::new(picture), params, light, on),
            Picture::Cube(picture) => Self::grown(&faces::Chart::new(picture), params, light, on),
        };
        Ok(Self { nodes: nodes?, base, most, mean })
    }

    fn grown(chart: &impl Chart, params: &Params, light: Light, on: &mut OnProgress<'_>) -> Result<Vec<Node>> {
        let builder = Builder { chart, params: *params, light };
        let (rows, columns) = chart.size();
        let all = Rect { r0: 0, r1: rows, c0: 0, c1: columns };
        let mut parts = Vec::new();
        builder.split_up(all, &mut parts);
        let grown: Vec<(Sums, Vec<Node>)> = watched(on, STAGE, parts.len(), |watch| {
            let grow = |part: &Rect| {
                let mut nodes = Vec::new();
                if watch.cancelled() { (Sums::default(), nodes) } else { (builder.grow(*part, &mut nodes), nodes) }
            };
            parts.par_iter().map(grow).collect()
        })?;
        let count = grown.iter().map(|(_, nodes)| nodes.len()).sum::<usize>() + parts.len();
        let mut nodes = Vec::with_capacity(count);
        if count >= MAX_NODES as usize {
            grown.iter().for_each(|(_, part)| nodes.extend_from_slice(part));
            return Ok(nodes);
        }
        builder.assemble(all, &mut grown.into_iter(), &mut nodes);
        Ok(nodes)
    }

    /// All nodes.
    pub fn whole(&self) -> Range<usize> {
        0..self.nodes.len()
    }

    /// Cuts a range of nodes into ranges of at most `most` that can be walked one after the other. Roots of more are left out:
    /// their children stand for them.
    pub fn pieces(&self, range: Range<usize>, most: usize) -> Vec<Range<usize>> {
        let mut pieces: Vec<Range<usize>> = vec![];
        let mut i = range.start;
        while i < range.end {
            let end = i + self.nodes[i].skip() as usize;
            if end - i > most {
                i += 1;
                continue;
            }
            match pieces.last_mut() {
                Some(last) if last.end == i && end - last.start <= most => last.end = end,
                _ => pieces.push(i..end),
            }
            i = end;
        }
        pieces
    }

    /// D of blue is the first times D of red plus the second times D of green.
    pub fn blue_from(&self) -> [f64; 2] {
        [-self.mean[2] * inverse(self.mean[0]), -self.mean[2] * inverse(self.mean[1])]
    }

    /// Can a walk ask for the texels of a leaf, if nodes above `extent_rad` are too large for it? `sharp` as in
    /// [`Node::is_cut`].
    pub fn needs_texels(&self, extent_rad: f64, sharp: bool) -> bool {
        self.nodes.par_iter().any(|n| n.skip() == 1 && n.is_cut(extent_rad, sharp))
    }

    /// Decodes node `i`.
    pub fn moments(&self, i: usize) -> Moments {
        let node = &self.nodes[i];
        let scale = 2.0 * f64::from(node.extent);
        let fraction = |v: i16| (f64::from(v) / 32767.0).max(-1.0);
        let [blue_red, blue_green] = self.blue_from();
        let e = node.e.map(f64::from);
        let red = [0, 1, 2].map(|x| fraction(node.d[x]) * scale * e[0]);
        let green = [3, 4, 5].map(|x| fraction(node.d[x]) * scale * e[1]);
        let blue = [0, 1, 2].map(|x| blue_red * red[x] + blue_green * green[x]);
        Moments { c: node.c.map(f64::from), e, d: [red, green, blue], q: node.q.map(|v| fraction(v) * scale * scale) }
    }
}

impl<C: Chart> Builder<'_, C> {
    /// Cuts a rectangle across its longer side, or both where it is nearly square.
    fn cut(&self, r: Rect) -> impl Iterator<Item = Rect> {
        const LONG: f64 = 1.4;
        let seam = self.chart.seam(r);
        let (height, width) = self.chart.sides(r);
        let (rows, columns) = (r.r1 - r.r0, r.c1 - r.c0);
        // Between texels while there are several, then through the one.
        let least = if rows > FINE || columns > FINE { FINE } else { 1 };
        let by_rows = rows > least && (columns <= least || height * LONG > width);
        let by_columns = columns > least && (rows <= least || width * LONG > height);
        let half = |count: u32| count / least / 2 * least;
        let (row, column) = match seam {
            Some(row) => (row, r.c1),
            None => {
                (if by_rows { r.r0 + half(rows) } else { r.r1 }, if by_columns { r.c0 + half(columns) } else { r.c1 })
            }
        };
        [
            Rect { r0: r.r0, r1: row, c0: r.c0, c1: column },
            Rect { r0: r.r0, r1: row, c0: column, c1: r.c1 },
            Rect { r0: row, r1: r.r1, c0: r.c0, c1: column },
            Rect { r0: row, r1: r.r1, c0: column, c1: r.c1 },
        ]
        .into_iter()
        .filter(|part| part.r0 < part.r1 && part.c0 < part.c1)
    }

    /// The subtrees that are grown side by side, in order.
    fn split_up(&self, r: Rect, parts: &mut Vec<Rect>) {
        if texel_count(r) > PART {
            self.cut(r).for_each(|part| self.split_up(part, parts));
        } else {
            parts.push(r);
        }
    }

    /// Puts the subtrees that were grown side by side under their common ancestors.
    fn assemble(&self, r: Rect, grown: &mut impl Iterator<Item = (Sums, Vec<Node>)>, nodes: &mut Vec<Node>) -> Sums {
        if texel_count(r) <= PART {
            let (sums, more) = grown.next().expect("split_up made as many parts");
            nodes.extend_from_slice(&more);
            return sums;
        }
        let at = nodes.len();
        nodes.push(Node::zeroed());
        let mut sums = Sums::default();
        for part in self.cut(r) {
            sums.add(&self.assemble(part, grown, nodes));
        }
        nodes[at] = self.node(r, &sums, (nodes.len() - at) as u32);
        sums
    }

    /// Appends the subtree of a rectangle.
    fn grow(&self, r: Rect, nodes: &mut Vec<Node>) -> Sums {
        let at = nodes.len();
        nodes.push(Node::zeroed());

        // A leaf? Its brightness is known once it has been summed.
        let texels = texel_count(r);
        let extent = self.chart.half_diagonal(r);
        let (few, one) = (texels <= MAX_CUT, texels <= 1);
        if one || extent <= if few { self.params.leaf_extent_rad } else { self.params.least_extent_rad } {
            let sums = self.chart.sums(r, &self.light);
            let factor = self.factor(r, &sums);
            let small = extent * factor <= self.params.leaf_extent_rad;
            let whole = one && factor < CUT_BRIGHTNESS || r.r1 - r.r0 == 1 && r.c1 - r.c0 == 1;
            if small || !few || whole {
                nodes[at] = self.node(r, &sums, 1);
                return sums;
            }
        }

        let mut sums = Sums::default();
        for part in self.cut(r) {
            sums.add(&self.grow(part, nodes));
        }
        nodes[at] = self.node(r, &sums, (nodes.len() - at) as u32);
        sums
    }

    /// W of a rectangle.
    fn weight(&self, sums: &Sums) -> f64 {
        (0..3).map(|k| sums.e[k] * self.light.inverse_mean[k]).sum()
    }

    /// The factor by which a rectangle counts as larger: for its brightness, and for channels that lie apart, whose second
    /// moments the common one misses.
    fn factor(&self, r: Rect, sums: &Sums) -> f64 {
        let weight = self.weight(sums);
        let bright = (weight / (3.0 * self.chart.solid_angle_sr(r))).sqrt().clamp(1.0, self.params.brightness_limit);
        bright * (1.0 + COLOUR * self.apart(sums, weight) / self.chart.half_diagonal(r))
    }

    /// How far a channel's centroid lies from that of all, on the unit ball; a channel counts less where it has little of the
    /// weight.
    fn apart(&self, sums: &Sums, weight: f64) -> f64 {
        if weight <= 0.0 {
            return 0.0;
        }
        let centroid: [f64; 3] = std::array::from_fn(|x| {
            (0..3).map(|k| sums.first[k][x] * self.light.inverse_mean[k]).sum::<f64>() / weight
        });
        let of_channel = |k: usize| {
            let e = sums.e[k];
            let offset = |x: usize| sums.first[k][x] - e * centroid[x];
            let moment = (0..3).map(|x| offset(x).powi(2)).sum::<f64>().sqrt();
            // The moment over the channel's energy is the distance. Its share of the weight counts by the fourth root: what a
            // bright light lacks is little of a rectangle's weight, but all that is seen of a channel elsewhere.
            moment * inverse(e) * (3.0 * e * self.light.inverse_mean[k] / weight).min(1.0).sqrt().sqrt()
        };
        (0..3).map(of_channel).fold(0.0, f64::max)
    }

    fn node(&self, r: Rect, sums: &Sums, skip: u32) -> Node {
        let [rows, columns] = self.chart.place(r);
        let extent = self.chart.half_diagonal(r) as f32;
        assert!(skip < MAX_NODES, "larger trees are left in parts");
        let weight = self.weight(sums);
        if weight <= 0.0 {
            return Node { extent, key_and_skip: skip, rows, columns, ..Node::zeroed() };
        }
        let m: [f64; 3] = std::array::from_fn(|x| (0..3).map(|k| sums.first[k][x] * self.light.inverse_mean[k]).sum());
        let c = m.map(|v| v / weight);
        let scale = 2.0 * f64::from(extent);
        // To nearest; a cast cuts towards 0.
        let fraction = |v: f64| (v * 32767.0 + 0.5f64.copysign(v)).clamp(-32767.0, 32767.0) as i16;
        let pair = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let q = std::array::from_fn(|i| {
            fraction((sums.second[i] / weight - c[pair[i].0] * c[pair[i].1]) / (scale * scale))
        });
        let d = std::array::from_fn(|i| {
            let (k, x) = (i / 3, i % 3);
            fraction((sums.first[k][x] - sums.e[k] * c[x]) * inverse(sums.e[k]) / scale)
        });
        let key = Node::key_code(f64::from(extent) * self.factor(r, sums));
        let (c, e) = (c.map(|v| v as f32), sums.e.map(|v| v as f32));
        Node { c, key_and_skip: key << 22 | skip, e, extent, d, rows, q, columns }
    }
}
