//! An environment as a tree of moments, so that an integral over the sphere costs a few thousand nodes instead of
//! millions of texels.
//!
//! **Shape.** A node is a rectangle of the picture: rows r0..r1, columns c0..c1. It is cut across its longer side, in
//! the middle, into two or four, until it is small enough ([`Params`]) or one texel. Sides are measured on the sphere,
//! so rectangles near the poles stay compact although texels are slivers there. Nodes lie in depth-first order and each
//! one knows how many nodes its subtree has (`skip`): a walk needs no stack, `i += 1` enters a node, `i += skip` passes
//! it. The leaves' borders are texel borders, so a leaf may be cut further, analytically, as finely as a narrow lobe asks.
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

use std::f64::consts::{PI, TAU};

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::Equirect;

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
    /// First row (low half), rows (high half).
    pub rows: [u16; 2],
    /// Q: xx, yy, zz, xy, xz, yz, as 16-bit fractions of (2 half diagonals)².
    q: [i16; 6],
    /// First column (low half), columns (high half).
    pub columns: [u16; 2],
}

/// Most nodes that a tree may have.
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
    /// only if they are few; a leaf that is too large itself is cut as finely as need be.
    pub fn is_cut(&self, threshold: f64) -> bool {
        let texels = u32::from(self.rows[1]) * u32::from(self.columns[1]);
        self.key().is_some_and(|key| f64::from(key) > threshold)
            && (f64::from(self.extent) > threshold || (2..=MAX_CUT).contains(&texels))
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
    /// Depth-first.
    pub nodes: Vec<Node>,
    /// Subtracted from every texel: the lowest value of each channel.
    pub base: [f32; 3],
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

#[derive(Clone, Copy)]
struct Rect {
    r0: u32,
    r1: u32,
    c0: u32,
    c1: u32,
}

/// Integrals over the θ extent of a row: ∫ f(θ) sin θ dθ for f = 1, sin, cos, sin², sin·cos, cos².
#[derive(Clone, Copy)]
struct RowTerms {
    one: f64,
    s: f64,
    c: f64,
    ss: f64,
    sc: f64,
    cc: f64,
}

/// Integrals over the φ extent of a column.
#[derive(Clone, Copy)]
struct ColumnTerms {
    c: f64,
    s: f64,
    cc: f64,
    sc: f64,
}

struct Builder<'a> {
    source: &'a Equirect,
    params: Params,
    base: [f32; 3],
    inverse_mean: [f64; 3],
    rows: Vec<RowTerms>,
    columns: Vec<ColumnTerms>,
    d_theta: f64,
    d_phi: f64,
}

fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

impl Tree {
    /// Builds the tree of an environment. `base` is `None` for the lowest value of each channel.
    pub fn new(source: &Equirect, params: &Params, base: Option<[f32; 3]>) -> Self {
        let (width, height) = (source.width, source.height);
        let base = base.unwrap_or_else(|| {
            let least = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|k| a[k].min(b[k]));
            source
                .texels
                .par_chunks(1 << 14)
                .map(|t| t.iter().copied().fold([f32::MAX; 3], least))
                .reduce(|| [f32::MAX; 3], least)
        });
        let mean = source.mean();
        let mean: [f64; 3] = std::array::from_fn(|k| (mean[k] - f64::from(base[k])).max(0.0));
        let mean = mean.map(|m| if m > 1e-12 { m } else { 0.0 });
        let builder = Builder {
            source,
            params: *params,
            base,
            inverse_mean: mean.map(inverse),
            rows: (0..height).map(|i| row_terms(i, height)).collect(),
            columns: (0..width).map(|j| column_terms(j, width)).collect(),
            d_theta: PI / f64::from(height),
            d_phi: TAU / f64::from(width),
        };
        let mut nodes = Vec::new();
        builder.grow(Rect { r0: 0, r1: height, c0: 0, c1: width }, &mut nodes);
        Self { nodes, base, mean }
    }

    /// D of blue is the first times D of red plus the second times D of green.
    pub fn blue_from(&self) -> [f64; 2] {
        [-self.mean[2] * inverse(self.mean[0]), -self.mean[2] * inverse(self.mean[1])]
    }

    /// Can a walk ask for the texels of a leaf, if nodes above `extent_rad` are too large for it?
    pub fn needs_texels(&self, extent_rad: f64) -> bool {
        self.nodes.par_iter().any(|n| n.skip() == 1 && n.is_cut(extent_rad))
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

fn row_terms(i: u32, height: u32) -> RowTerms {
    // Products of the middle's and the half width's sines and cosines: nothing cancels in narrow rows.
    let a = 0.5 * PI / f64::from(height);
    let (sin, cos) = ((2.0 * f64::from(i) + 1.0) * a).sin_cos();
    let (sin_a, sin_2a) = (a.sin(), (2.0 * a).sin());
    // ∫ cos³ and ∫ sin³ come from sin 3θ and cos 3θ.
    let theta = (2.0 * f64::from(i) + 1.0) * a;
    let one = 2.0 * sin * sin_a;
    let third = 2.0 * (3.0 * theta).sin() * (3.0 * a).sin() / 3.0;
    let third_c = 2.0 * (3.0 * theta).cos() * (3.0 * a).sin() / 3.0;
    let ss = (3.0 * one - third) / 4.0;
    let sc = (2.0 * cos * sin_a - third_c) / 4.0;
    let s = a - (2.0 * theta).cos() * sin_2a / 2.0;
    let c = sin * cos * sin_2a;
    RowTerms { one, s, c, ss, sc, cc: one - ss }
}

fn column_terms(j: u32, width: u32) -> ColumnTerms {
    let b = PI / f64::from(width);
    let phi = (2.0 * f64::from(j) + 1.0) * b - PI;
    let (sin, cos) = phi.sin_cos();
    let sin_2b = (2.0 * b).sin();
    ColumnTerms {
        c: 2.0 * cos * b.sin(),
        s: 2.0 * sin * b.sin(),
        cc: b + (2.0 * phi).cos() * sin_2b / 2.0,
        sc: sin * cos * sin_2b,
    }
}

impl Builder<'_> {
    /// Height and greatest width of a rectangle on the sphere, in radians.
    fn sides(&self, r: Rect) -> (f64, f64) {
        let (t0, t1) = (f64::from(r.r0) * self.d_theta, f64::from(r.r1) * self.d_theta);
        let widest = if t0 <= PI / 2.0 && t1 >= PI / 2.0 { 1.0 } else { t0.sin().max(t1.sin()) };
        (t1 - t0, f64::from(r.c1 - r.c0) * self.d_phi * widest)
    }

    fn half_diagonal(&self, r: Rect) -> f64 {
        let (height, width) = self.sides(r);
        0.5 * (height * height + width * width).sqrt()
    }

    /// Cuts a rectangle across its longer side, or both where it is nearly square.
    fn cut(&self, r: Rect) -> impl Iterator<Item = Rect> {
        const LONG: f64 = 1.4;
        let (height, width) = self.sides(r);
        let (rows, columns) = (r.r1 - r.r0, r.c1 - r.c0);
        let by_rows = rows > 1 && (columns == 1 || height * LONG > width);
        let by_columns = columns > 1 && (rows == 1 || width * LONG > height);
        let row = if by_rows { r.r0 + rows / 2 } else { r.r1 };
        let column = if by_columns { r.c0 + columns / 2 } else { r.c1 };
        [
            Rect { r0: r.r0, r1: row, c0: r.c0, c1: column },
            Rect { r0: r.r0, r1: row, c0: column, c1: r.c1 },
            Rect { r0: row, r1: r.r1, c0: r.c0, c1: column },
            Rect { r0: row, r1: r.r1, c0: column, c1: r.c1 },
        ]
        .into_iter()
        .filter(|part| part.r0 < part.r1 && part.c0 < part.c1)
    }

    /// Appends the subtree of a rectangle.
    fn grow(&self, r: Rect, nodes: &mut Vec<Node>) -> Sums {
        let at = nodes.len();
        nodes.push(Node::zeroed());

        // A leaf? Its brightness is known once it has been summed.
        let texels = (r.r1 - r.r0) * (r.c1 - r.c0);
        let extent = self.half_diagonal(r);
        let few = texels <= MAX_CUT;
        if extent <= if few { self.params.leaf_extent_rad } else { self.params.least_extent_rad } || texels == 1 {
            let sums = self.texels(r);
            let key = extent * self.brightness(r, &sums);
            if key <= self.params.leaf_extent_rad || !few || texels == 1 {
                nodes[at] = self.node(r, &sums, 1);
                return sums;
            }
        }

        let mut sums = Sums::default();
        if texels > 1 << 15 {
            let parts: Vec<Rect> = self.cut(r).collect();
            let grown: Vec<(Sums, Vec<Node>)> = parts
                .par_iter()
                .map(|part| {
                    let mut nodes = Vec::new();
                    (self.grow(*part, &mut nodes), nodes)
                })
                .collect();
            for (part, more) in grown {
                sums.add(&part);
                nodes.extend_from_slice(&more);
            }
        } else {
            for part in self.cut(r) {
                sums.add(&self.grow(part, nodes));
            }
        }
        nodes[at] = self.node(r, &sums, (nodes.len() - at) as u32);
        sums
    }

    /// W of a rectangle.
    fn weight(&self, sums: &Sums) -> f64 {
        (0..3).map(|k| sums.e[k] * self.inverse_mean[k]).sum()
    }

    /// The factor by which a rectangle counts as larger.
    fn brightness(&self, r: Rect, sums: &Sums) -> f64 {
        let (t0, t1) = (f64::from(r.r0) * self.d_theta, f64::from(r.r1) * self.d_theta);
        // cos t0 − cos t1 as a product: nothing cancels.
        let solid_angle = 2.0 * (0.5 * (t0 + t1)).sin() * (0.5 * (t1 - t0)).sin() * f64::from(r.c1 - r.c0) * self.d_phi;
        (self.weight(sums) / (3.0 * solid_angle)).sqrt().clamp(1.0, self.params.brightness_limit)
    }

    fn texels(&self, r: Rect) -> Sums {
        let mut sums = Sums::default();
        for y in r.r0..r.r1 {
            let row = &self.source.row(y)[r.c0 as usize..r.c1 as usize];
            let columns = &self.columns[r.c0 as usize..r.c1 as usize];
            let (mut one, mut c, mut s) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            let (mut w_one, mut w_cc, mut w_sc) = (0.0, 0.0, 0.0);
            for (texel, column) in row.iter().zip(columns) {
                let mut w = 0.0;
                for k in 0..3 {
                    let radiance = f64::from(texel[k] - self.base[k]);
                    one[k] += radiance;
                    c[k] += radiance * column.c;
                    s[k] += radiance * column.s;
                    w += radiance * self.inverse_mean[k];
                }
                w_one += w;
                w_cc += w * column.cc;
                w_sc += w * column.sc;
            }
            let row = &self.rows[y as usize];
            for k in 0..3 {
                let plain = one[k] * self.d_phi;
                sums.e[k] += row.one * plain;
                sums.first[k][0] += row.s * c[k];
                sums.first[k][1] += row.c * plain;
                sums.first[k][2] += row.s * s[k];
            }
            let w_c: f64 = (0..3).map(|k| c[k] * self.inverse_mean[k]).sum();
            let w_s: f64 = (0..3).map(|k| s[k] * self.inverse_mean[k]).sum();
            let w_plain = w_one * self.d_phi;
            let second =
                [row.ss * w_cc, row.cc * w_plain, row.ss * (w_plain - w_cc), row.sc * w_c, row.ss * w_sc, row.sc * w_s];
            (0..6).for_each(|i| sums.second[i] += second[i]);
        }
        sums
    }

    fn node(&self, r: Rect, sums: &Sums, skip: u32) -> Node {
        let rows = [r.r0 as u16, (r.r1 - r.r0) as u16];
        let columns = [r.c0 as u16, (r.c1 - r.c0) as u16];
        let extent = self.half_diagonal(r) as f32;
        assert!(skip < MAX_NODES, "the tree's parameters bound its size");
        let weight = self.weight(sums);
        if weight <= 0.0 {
            return Node { extent, key_and_skip: skip, rows, columns, ..Node::zeroed() };
        }
        let m: [f64; 3] = std::array::from_fn(|x| (0..3).map(|k| sums.first[k][x] * self.inverse_mean[k]).sum());
        let c = m.map(|v| v / weight);
        let scale = 2.0 * f64::from(extent);
        let fraction = |v: f64| (v * 32767.0).round().clamp(-32767.0, 32767.0) as i16;
        let pair = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let q = std::array::from_fn(|i| {
            fraction((sums.second[i] / weight - c[pair[i].0] * c[pair[i].1]) / (scale * scale))
        });
        let d = std::array::from_fn(|i| {
            let (k, x) = (i / 3, i % 3);
            fraction((sums.first[k][x] - sums.e[k] * c[x]) * inverse(sums.e[k]) / scale)
        });
        let key = Node::key_code(f64::from(extent) * self.brightness(r, sums));
        let (c, e) = (c.map(|v| v as f32), sums.e.map(|v| v as f32));
        Node { c, key_and_skip: key << 22 | skip, e, extent, d, rows, q, columns }
    }
}
