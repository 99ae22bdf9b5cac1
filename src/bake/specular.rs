// SPDX-License-Identifier: MIT OR Apache-2.0
//! Filtered environments: what image-based lighting reads for glossy reflections.
//!
//! Mip m of a cube, an equirectangular picture or an octahedral map ([`Projection`]) holds, at the centre direction n of
//! every texel,
//!
//! ```text
//! P_m(n) = ∫ K(h) L(ω) dω / ∫ K(h) dω,    h = (1 − n·ω)/2
//! ```
//!
//! with the kernel K of [`crate::term::zonal`] at the mip's width alpha; view, normal and reflection are equal
//! (Karis 2013). L is the source as [`crate::env`] defines it. Mip 0 has alpha = 0: it holds the source itself, averaged
//! over every texel's exact solid angle ([`crate::env::area`], [`crate::env::resample`]). The other mips are smooth, so
//! they hold values at points, which is what a bilinear reader interpolates.
//!
//! A kernel without a width ([`Zonal::least_alpha`]) has nothing to run over mips: its map has one level, and that is
//! filtered.
//!
//! **Rule.** No sampling: for each 4 × 4 texels the tree of moments ([`crate::env::tree`]) is walked. A node that is
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
//! third power of extent/room. What is far from 16 × 16 texels they take together where the kernel's tail lets them
//! ([`super::groups`]). Division is by the kernel's own norm, never by a sum of weights. The same bytes come out whatever the
//! slices and however many threads.

use std::borrow::Cow;
use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;

use super::groups::{Groups, POINTS};
use super::quality::{self, Quality};
use super::slices::next_slice;
use super::{Backend, RoughnessLaw};
use crate::env::orientation::normalized;
use crate::env::projection::Projection;
use crate::env::tree::{FINE, Moments, Node, Params, Tree, face_and_corner};
use crate::env::{CubeMap, Environment, Equirect, Frame, Picture, area, resample};
use crate::error::{Error, Result};
use crate::gpu::{Bindings, Gpu, MAX_GROUPS};
use crate::ndf::alpha_of;
use crate::progress::{OnProgress, tick};
use crate::shaders;
use crate::term::cube::direction;
use crate::term::zonal::{self, Peak, Zonal};
use crate::texture::{Meta, Shape, Texture};

/// Largest side of a face in texels.
pub const MAX_SIZE: u32 = 4096;
/// Texels along a side of a block: what one invocation computes. Kernels with a ring at the horizon take smaller blocks
/// where the texels of one would look along too many rings.
const BLOCK: u32 = 4;
/// More parts than these a tree is not walked in.
const MOST_PARTS: usize = 64;
/// Invocations a workgroup, as in the shader.
const WORKGROUP: u32 = 32;
/// Sources with fewer columns are repeated texel by texel: a leaf must not be cut into too many parts.
const LEAST_WIDTH: u32 = 512;
/// The same for the faces of a cube.
const LEAST_FACE: u32 = 192;
/// Leaves are this part of the least extent that the narrowest lobe asks for.
const LEAF: f64 = 0.8;
/// Leaves are not smaller than this, so that the tree of a large source stays within some ten megabytes.
const LEAST_LEAF_RAD: f64 = 0.006;

/// Key of the gutter.
const GUTTER: &str = "gutter";
/// Key of the radiance that an encoding clamped texels to.
pub const CLAMPED: &str = "encoding.clamped-to";

/// Every Vulkan device takes buffers of this size: larger trees are walked in pieces.
const BUFFER_BYTES: usize = 1 << 27;

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

/// A filtered environment as a user words it.
#[derive(Clone, Debug)]
pub struct SpecularRequest {
    /// Name of the kernel.
    pub kernel: String,
    /// Name of the projection.
    pub shape: String,
    /// Texels along the shorter side of a face at mip 0; `None` is 256, or 64 for a kernel without a width.
    pub size: Option<u32>,
    /// Number of mips; `None` goes down to one texel.
    pub mips: Option<u32>,
    /// Name of the roughness law.
    pub roughness_law: String,
    /// Name of the quality.
    pub quality: String,
    /// Texels around every level that repeat what lies across its edges: [`SpecularJob::gutter`].
    pub gutter: u32,
}

impl Default for SpecularRequest {
    fn default() -> Self {
        Self {
            kernel: "ggx".into(),
            shape: "cube".into(),
            size: None,
            mips: None,
            roughness_law: "linear".into(),
            quality: quality::STANDARD.name.into(),
            gutter: 0,
        }
    }
}

impl SpecularRequest {
    /// Checks every name and number.
    pub fn resolve(&self) -> Result<SpecularJob> {
        let kernel = zonal::parse(&self.kernel)?;
        let law = RoughnessLaw::parse(&self.roughness_law)?;
        let projection = Projection::parse(&self.shape)?;
        let quality = quality::parse(&self.quality)?;
        let size = self.size.unwrap_or(if kernel.least_alpha.is_some() { 256 } else { 64 });
        if !(1..=MAX_SIZE).contains(&size) {
            let what = format!("a {} whose side has {size} texels cannot be baked", projection.name());
            return Err(Error::usage(what, format!("use --size from 1 to {MAX_SIZE}")));
        }
        if projection == Projection::Octahedral && !size.is_power_of_two() {
            let what = format!("an octahedral map of size {size} has texels across its folds");
            return Err(Error::usage(what, format!("use a power of two, e.g. --size {}", size.next_power_of_two())));
        }
        let (most, why) = match kernel.least_alpha {
            Some(_) => (size.ilog2() + 1, format!("of size {size}")),
            None => (1, format!("of {}, which knows no roughness,", kernel.name)),
        };
        let mips = self.mips.unwrap_or(most);
        if !(1..=most).contains(&mips) {
            let what = format!("a {} {why} cannot have {mips} mips", projection.name());
            let help = if most == 1 { "use --mips 1".into() } else { format!("use --mips from 1 to {most}") };
            return Err(Error::usage(what, help));
        }
        if self.gutter > 0 && projection != Projection::Equirect {
            let what = format!("a {} map has no gutter", projection.name());
            return Err(Error::usage(what, "choose --shape equirect"));
        }
        if size >> (mips - 1) <= 2 * self.gutter {
            let what = format!("{mips} mips of size {size} leave nothing inside a gutter of {} texels", self.gutter);
            return Err(Error::usage(what, "use fewer --mips or a larger --size"));
        }
        let shared = quality.precision;
        let precision = Precision { eps: if kernel.has_tail { shared.eps } else { quality.eps_alone }, ..shared };
        let (clamped_to, gutter) = (f64::INFINITY, self.gutter);
        let job = SpecularJob { kernel, projection, size, mips, law, quality, precision, clamped_to, gutter };
        let narrowest = job.alpha(job.filtered().start);
        if let Some(least) = kernel.least_alpha.filter(|least| mips > 1 && narrowest < *least) {
            let what = format!("mip 1 has alpha {narrowest:.5}, and {} is right from {least:.5} up", kernel.name);
            return Err(Error::usage(what, "use fewer --mips, or --roughness-law linear"));
        }
        Ok(job)
    }
}

/// A filtered environment to bake.
#[derive(Clone)]
pub struct SpecularJob {
    /// What to filter with.
    pub kernel: &'static Zonal,
    /// How the sphere is laid out.
    pub projection: Projection,
    /// Texels along the shorter side of a face at mip 0.
    pub size: u32,
    /// Number of mips, mip 0 included.
    pub mips: u32,
    /// How roughness runs over the mips.
    pub law: RoughnessLaw,
    /// What the result is held to.
    pub quality: &'static Quality,
    /// How finely the walk looks: the quality's, unless a test changes it.
    pub precision: Precision,
    /// What a file's encoding clamped radiance to; infinite where it did not.
    pub clamped_to: f64,
    /// Texels on every side of each level of an equirect that repeat what lies across that edge, so that neighbours in an
    /// atlas do not bleed into it. Sizes count them.
    pub gutter: u32,
}

/// A source made ready: its tree, and the texels that leaves are cut into.
pub struct Prepared<'a> {
    /// The source, repeated where it was too coarse.
    pub picture: Picture<'a>,
    /// From directions of the output to the picture's.
    pub frame: Frame,
    /// May leaves be cut into parts of their texels? Not where the texels exceed a buffer.
    pub cuts: bool,
    /// Its tree.
    pub tree: Tree,
}

/// A kernel at one width, with the bounds of the walk.
#[derive(Clone, Copy)]
pub struct Lobe {
    kernel: &'static Zonal,
    /// Width.
    pub alpha: f64,
    inverse_norm: f64,
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

impl SpecularJob {
    /// The job that made a file, from what the file says.
    pub fn from_meta(texture: &Texture) -> Result<SpecularJob> {
        let get = |key: &str| {
            texture.meta.get(key).filter(|_| texture.shape != Shape::Table && texture.channels.len() >= 3).ok_or_else(
                || {
                    let help = "only environments that brdf-baker wrote carry their kernel and roughness law";
                    Error::usage(format!("the file does not say its '{key}'"), help)
                },
            )
        };
        let shape = if texture.shape == Shape::Cube { "cube" } else { get("projection")? };
        let request = SpecularRequest {
            kernel: get("kernel")?.into(),
            shape: shape.into(),
            size: Some(texture.height),
            mips: Some(texture.levels.len() as u32),
            roughness_law: get("roughness-law")?.into(),
            quality: get("quality")?.into(),
            gutter: match texture.meta.get(GUTTER) {
                None => 0,
                Some(text) => text.parse().map_err(|_| {
                    Error::usage(format!("the file says gutter '{text}'"), "a gutter is a number of texels")
                })?,
            },
        };
        let mut job = request.resolve()?;
        if let Some(text) = texture.meta.get(CLAMPED) {
            job.clamped_to = text.parse().map_err(|_| {
                Error::usage(format!("the file says {CLAMPED} '{text}'"), "radiance is clamped to a number")
            })?;
        }
        if job.level_size(0) != (texture.width, texture.height) {
            let what = format!("it is {}x{}, which is no {shape}", texture.width, texture.height);
            return Err(Error::usage(what, "bake it again"));
        }
        Ok(job)
    }

    /// The rule, for the file's certificate.
    pub fn rule(&self) -> String {
        let Precision { eps, far, .. } = self.precision;
        let shared = if far.is_finite() && self.kernel.has_tail { format!(", far {far}") } else { String::new() };
        format!("moment tree, eps {eps}{shared}")
    }

    /// The shape of the result.
    pub fn shape(&self) -> Shape {
        if self.projection == Projection::Cube { Shape::Cube } else { Shape::Map }
    }

    /// The mips that are filtered: all but the first, or the only one of a kernel without a width.
    pub fn filtered(&self) -> Range<u32> {
        u32::from(self.kernel.least_alpha.is_some())..self.mips
    }

    /// The width of mip `m`: 0 at mip 0, 1 for a kernel without one.
    pub fn alpha(&self, m: u32) -> f64 {
        match m {
            _ if self.kernel.least_alpha.is_none() => 1.0,
            0 => 0.0,
            _ => alpha_of(self.law.roughness(m, self.mips - 1, self.size)),
        }
    }

    /// Width and height of a face at mip `m`.
    pub fn level_size(&self, m: u32) -> (u32, u32) {
        let (width, height) = self.projection.level_size(self.size);
        ((width >> m).max(1), (height >> m).max(1))
    }

    /// Width and height of a face at mip `m` without its gutter.
    pub fn inner_size(&self, m: u32) -> (u32, u32) {
        let (width, height) = self.level_size(m);
        (width - 2 * self.gutter, height - 2 * self.gutter)
    }

    /// The point (s, t) of a face that lies `x` texels from the left and `y` rows from the top of mip `m`: from −1 to 1, and
    /// beyond in a gutter.
    pub fn place(&self, m: u32, x: f64, y: f64) -> (f64, f64) {
        let (width, height) = self.inner_size(m);
        let at = |i: f64, n: u32| 2.0 * (i - f64::from(self.gutter)) / f64::from(n) - 1.0;
        (at(x, width), at(y, height))
    }

    /// Texels of mip `m`.
    fn texels(&self, m: u32) -> u32 {
        let (width, height) = self.level_size(m);
        self.projection.faces() * width * height
    }

    /// The lobe of a filtered mip.
    pub fn lobe(&self, m: u32) -> Lobe {
        Lobe::new(self.kernel, self.alpha(m), self.precision)
    }

    /// The axis of texel (x, y) at mip `m`.
    pub fn axis(&self, m: u32, face: u32, x: u32, y: u32) -> [f64; 3] {
        let (s, t) = self.place(m, f64::from(x) + 0.5, f64::from(y) + 0.5);
        self.projection.direction(face, s, t)
    }

    /// Builds the tree for this job's narrowest lobe. `base` is `None` for the lowest value of each channel.
    pub fn prepare<'a>(
        &self,
        environment: impl Into<Environment<'a>>,
        base: Option<[f32; 3]>,
        on: &mut OnProgress<'_>,
    ) -> Result<Prepared<'a>> {
        let Environment { picture, frame } = environment.into();
        let picture = match picture {
            Picture::Equirect(p) if p.width < LEAST_WIDTH => {
                Picture::Equirect(Cow::Owned(p.repeated(LEAST_WIDTH.div_ceil(p.width))))
            }
            Picture::Cube(p) if p.size < LEAST_FACE => {
                Picture::Cube(Cow::Owned(p.repeated(LEAST_FACE.div_ceil(p.size))))
            }
            large => large,
        };
        let p = self.precision;
        let least = p.eps * (self.kernel.least_room)(self.alpha(self.filtered().start));
        // Leaves this small are few enough; what is finer is cut out of the source when it is asked for, if the source
        // fits into a buffer.
        let fits = size_of_val(picture.texels()) <= BUFFER_BYTES;
        // Where a light at a kink shows more, bright leaves of many texels must come apart, too.
        let leaf = LEAF * least / self.kernel.brightness;
        let params = Params {
            leaf_extent_rad: leaf.max(if fits { LEAST_LEAF_RAD } else { 0.0 }),
            least_extent_rad: leaf,
            brightness_limit: p.brightness_limit * self.kernel.brightness,
        };
        let tree = Tree::new(&picture, &params, base, on)?;
        Ok(Prepared { picture, frame, cuts: fits, tree })
    }

    /// Bakes the environment; its meta says everything but the measured error.
    pub fn run<'a>(
        &self,
        environment: impl Into<Environment<'a>>,
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Texture> {
        let environment = environment.into();
        let mut levels = vec![];
        if self.filtered().start > 0 {
            levels.push(match self.projection {
                Projection::Cube => area::cube(&environment, self.size, on)?,
                Projection::Equirect => {
                    let size = self.inner_size(0);
                    with_gutter(resample::equirect(&environment, size, on)?, size, self.gutter)
                }
                Projection::Octahedral => resample::octahedral(&environment, self.size, on)?,
            });
        }
        if !self.filtered().is_empty() {
            let prepared = self.prepare(&environment, None, on)?;
            levels.extend(self.filter(&prepared, backend, on)?);
        }
        let channels = ["r", "g", "b"].map(String::from).to_vec();
        let (width, height) = self.level_size(0);
        Ok(Texture { shape: self.shape(), width, height, channels, levels, meta: self.meta(backend) })
    }

    /// The filtered mips, RGB.
    pub fn filter(&self, prepared: &Prepared<'_>, backend: &Backend, on: &mut OnProgress<'_>) -> Result<Vec<Vec<f32>>> {
        let mut levels = match backend {
            Backend::Cpu => self.on_cpu(prepared, on)?,
            Backend::Gpu(gpu) => self.on_gpu(prepared, gpu, None, on)?,
        };
        for (m, level) in self.filtered().zip(&levels) {
            if let Some(bad) = level.iter().position(|v| !v.is_finite()) {
                let detail = format!("value {bad} of mip {m} is {}", level[bad]);
                return Err(Error::Gpu { op: format!("filter the environment with {}", self.kernel.name), detail });
            }
        }
        // A mean is within the range of what it is the mean of; the walk is only nearly so.
        let Tree { base, most, .. } = prepared.tree;
        for texel in levels.iter_mut().flat_map(|level| level.as_chunks_mut::<3>().0) {
            (0..3).for_each(|c| texel[c] = texel[c].clamp(base[c], most[c]));
        }
        Ok(levels)
    }

    /// Texels along a side of a block at mip `m`: as many as keep its reach within twice the least room.
    fn block_size(&self, m: u32) -> u32 {
        let texel_rad = self.projection.texel_rad(self.level_size(m).1);
        let most = 2.0 * (self.kernel.least_room)(self.alpha(m));
        let fits = |size: &u32| f64::from(size - 1) * texel_rad * 0.5f64.sqrt() <= most;
        match self.kernel.peak {
            Peak::Axis => BLOCK,
            Peak::Horizon => [BLOCK, BLOCK / 2].into_iter().find(fits).unwrap_or(1),
        }
    }

    /// Blocks along the sides of a face at mip `m`.
    fn sides(&self, m: u32) -> (u32, u32) {
        let ((width, height), block) = (self.level_size(m), self.block_size(m));
        (width.div_ceil(block), height.div_ceil(block))
    }

    fn blocks(&self, m: u32) -> u32 {
        let (across, down) = self.sides(m);
        self.projection.faces() * across * down
    }

    fn stage(&self, m: u32) -> String {
        if self.mips == 1 { "filtering".into() } else { format!("mip {m} of {}", self.mips - 1) }
    }

    fn overrun(&self, m: u32) -> Error {
        let detail = format!(
            "mip {m} (alpha {:.5}) needs more than {} steps a block and part of the tree; use fewer mips or a larger --size",
            self.alpha(m),
            self.precision.limit
        );
        Error::Gpu { op: format!("filter the environment with {}", self.kernel.name), detail }
    }

    /// The groups that a mip's blocks share what is far with; `cuts` where leaves are cut.
    fn groups(&self, m: u32, prepared: &Prepared<'_>, cuts: bool) -> Option<Groups> {
        let far = self.precision.far;
        let shares = far.is_finite() && self.kernel.has_tail && !cuts && self.block_size(m) == BLOCK;
        shares.then(|| Groups::of(self, m, prepared, far)).flatten()
    }

    /// Is any leaf cut?
    fn cuts(&self, prepared: &Prepared<'_>) -> bool {
        let least = self.lobe(self.filtered().start).least_threshold();
        prepared.cuts && prepared.tree.needs_texels(least, self.kernel.sharp_horizon)
    }

    fn on_cpu(&self, prepared: &Prepared<'_>, on: &mut OnProgress<'_>) -> Result<Vec<Vec<f32>>> {
        /// Blocks between two looks at the progress listener.
        const SLICE: u32 = 64;
        let total: u32 = self.filtered().map(|m| self.blocks(m)).sum();
        let mut done = 0;
        let mut levels = vec![];
        let cuts = self.cuts(prepared);
        let all = prepared.tree.whole();
        for m in self.filtered() {
            let ((width, height), lobe, stage) = (self.level_size(m), self.lobe(m), self.stage(m));
            let groups = self.groups(m, prepared, cuts);
            let mut level = vec![f32::NAN; 3 * self.texels(m) as usize];
            for first in (0..self.blocks(m)).step_by(SLICE as usize) {
                tick(on, &stage, f64::from(done) / f64::from(total))?;
                let end = (first + SLICE).min(self.blocks(m));
                let found: Vec<_> = (first..end)
                    .into_par_iter()
                    .map(|index| {
                        let texels = self.block(m, index);
                        let axis = |[face, x, y]: &[u32; 3]| prepared.frame.to_picture(self.axis(m, *face, *x, *y));
                        let axes: Vec<_> = texels.iter().map(axis).collect();
                        let [face, x, y] = texels[0];
                        let near =
                            groups.as_ref().map(|groups| &groups.of_block([face, x / BLOCK, y / BLOCK]).near[..]);
                        lobe.walk(prepared, &axes, near.unwrap_or(std::slice::from_ref(&all)))
                            .map(|walked| (texels, walked))
                    })
                    .collect();
                for block in found {
                    let (texels, walked) = block.ok_or_else(|| self.overrun(m))?;
                    for ([face, x, y], value) in texels.into_iter().zip(walked.values) {
                        let at = 3 * ((face * height + y) * width + x) as usize;
                        level[at..at + 3].copy_from_slice(&value.map(|v| v as f32));
                    }
                }
                done += end - first;
            }
            if let Some(groups) = groups {
                let axes = |group: usize| groups.block(group).map(|at| groups.axes[at]).collect::<Vec<_>>();
                let walk = |group: usize| lobe.walk(prepared, &axes(group), &groups.each[group].distant);
                let found: Vec<_> = (0..groups.each.len()).into_par_iter().map(walk).collect();
                let mut far = vec![0.0; 3 * groups.axes.len()];
                for (group, walked) in found.into_iter().enumerate() {
                    let values = walked.ok_or_else(|| self.overrun(m))?.values;
                    for (at, value) in groups.block(group).zip(values) {
                        (0..3).for_each(|k| far[3 * at + k] = (value[k] - f64::from(prepared.tree.base[k])) as f32);
                    }
                }
                groups.add(&far, &mut level);
            }
            levels.push(level);
        }
        tick(on, "filtered", 1.0)?;
        Ok(levels)
    }

    /// Face, column and row of a block's 16 texels; beyond the end of the face or of a smaller block the last texels stand
    /// in. The order of the blocks is the shader's.
    pub fn block(&self, m: u32, index: u32) -> Vec<[u32; 3]> {
        let ((across, down), (width, height)) = (self.sides(m), self.level_size(m));
        let (face, at) = (index / (across * down), index % (across * down));
        let (x, y) = if across.is_multiple_of(4) && down.is_multiple_of(2) {
            let (groups, group, within) = (across / 4, at / 8, at % 8);
            ((group % groups) * 4 + within % 4, (group / groups) * 2 + within / 4)
        } else {
            (at % across, at / across)
        };
        let size = self.block_size(m);
        let at = |block: u32, i: u32, end: u32| (block * size + i.min(size - 1)).min(end - 1);
        (0..BLOCK * BLOCK).map(|i| [face, at(x, i % BLOCK, width), at(y, i / BLOCK, height)]).collect()
    }

    /// The axes of all texels of the filtered mips in the picture, in the order of the result.
    fn axes(&self, frame: &Frame) -> Vec<[f32; 3]> {
        let mut axes = vec![];
        for m in self.filtered() {
            let (width, height) = self.level_size(m);
            let rows = (0..self.projection.faces() * height).into_par_iter();
            axes.par_extend(rows.flat_map_iter(|row| {
                (0..width).map(move |x| frame.to_picture(self.axis(m, row / height, x, row % height)).map(|v| v as f32))
            }));
        }
        axes
    }

    /// `slice` fixes the number of blocks a dispatch; `None` aims at a duration.
    pub fn on_gpu(
        &self,
        prepared: &Prepared<'_>,
        gpu: &Gpu,
        slice: Option<u32>,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<Vec<f32>>> {
        let Prepared { picture, tree, .. } = prepared;
        // One kernel for all mips: compiling another costs more than it saves where leaves are cut at all, or shared.
        let cuts = self.cuts(prepared);
        let texels_of_node = size_of::<Node>() as u64 / 16;
        let buffer_nodes = (BUFFER_BYTES / size_of::<Node>()).min((gpu.info().max_texels / texels_of_node) as usize);
        // Ranges of nodes are places in one buffer.
        let fits = tree.nodes.len() <= buffer_nodes;
        let groups = |m| if fits { self.groups(m, prepared, cuts) } else { None };
        let groups: Vec<Option<Groups>> = self.filtered().map(groups).collect();
        let variant = match picture {
            _ if groups.iter().any(Option::is_some) => "_shared",
            _ if !cuts => "",
            Picture::Equirect(_) => "_cut",
            Picture::Cube(_) => "_cut_faces",
        };
        let name = format!("bake/specular{variant}+{}", self.kernel.file());
        // The tree's nodes, and ranges of them, are texel buffers.
        let bindings = Bindings { storage: 5, texel: 2 };
        let kernel = gpu.kept_kernel(&name, &shaders::spirv(&name), bindings, size_of::<Push>() as u32)?;

        // What is walked, one after the other: of each mip its blocks, then its groups.
        let mut axes = self.axes(&prepared.frame);
        let (mut runs, mut offset) = (vec![], 0);
        for m in self.filtered() {
            runs.push(Run { m, blocks: self.blocks(m), push: self.push(m, offset, prepared) });
            offset += self.texels(m);
        }
        let of_groups: Vec<_> = self.filtered().zip(&groups).filter_map(|(m, g)| g.as_ref().map(|g| (m, g))).collect();
        // Lists of ranges: that of all nodes, then those of the groups.
        let mut lists = vec![[0, 1, 0, 0]];
        let mut ranges = vec![[0, tree.nodes.len() as u32, 0, 0]];
        for (m, groups) in &of_groups {
            let (first_list, groups_across) = (lists.len() as u32, groups.across);
            for group in &groups.each {
                let mut list = |of: &[Range<usize>]| {
                    let first = ranges.len() as u32;
                    ranges.extend(of.iter().map(|r| [r.start as u32, r.end as u32, 0, 0]));
                    [first, ranges.len() as u32]
                };
                let ([near, near_end], [far, far_end]) = (list(&group.near), list(&group.distant));
                lists.push([near, near_end, far, far_end]);
            }
            let (blocks, push) = (groups.each.len() as u32, self.push(*m, axes.len() as u32, prepared));
            let push = Push { width: POINTS * blocks, height: POINTS, base: [0.0; 3], of_groups: 1, ..push };
            runs.push(Run { m: *m, blocks, push });
            for Run { push, .. } in runs.iter_mut().filter(|run| run.m == *m) {
                *push = Push { lists: first_list, groups_across, ..*push };
            }
            axes.extend(groups.axes.iter().map(|n| n.map(|v| v as f32)));
        }
        // Ranges follow the lists in one buffer.
        let before = lists.len() as u32;
        lists.iter_mut().flatten().for_each(|at| *at += before);
        let count = axes.len() as u64;
        lists.extend(ranges);

        let texels = if cuts { residual(picture, tree.base) } else { vec![0.0] };
        let texels = gpu.upload("texels", &texels)?;
        let lines = gpu.upload("lines", &lines(picture))?;
        let mut status = gpu.upload("status", &[0u32])?;
        let axes = gpu.upload("axes", &axes)?;
        let lists = gpu.upload_texels("ranges", &lists)?;
        let result = gpu.buffer("result", count * 12)?;
        let mut buffers = vec![];
        for range in tree.pieces(tree.whole(), buffer_nodes) {
            let nodes = gpu.upload_texels("nodes", &tree.nodes[range.clone()])?;
            buffers.push((range, nodes));
        }

        let total: u32 = runs.iter().map(|run| run.blocks).sum();
        let mut done = 0;
        let mut next = slice.unwrap_or(1);
        for Run { m, blocks, push } in runs {
            // Parts of the tree, walked one after the other: as many as it takes that none needs too many steps.
            let mut most = tree.nodes.len().min(buffer_nodes);
            'again: loop {
                let parts: Vec<_> = buffers
                    .iter()
                    .flat_map(|(range, nodes)| {
                        tree.pieces(range.clone(), most).into_iter().map(move |p| (range, nodes, p))
                    })
                    .collect();
                for (part, (range, nodes, piece)) in parts.iter().enumerate() {
                    let (node_begin, node_count) =
                        ((piece.start - range.start) as u32, (piece.end - range.start) as u32);
                    let mut first = 0;
                    while first < blocks {
                        tick(on, &self.stage(m), f64::from(done + first) / f64::from(total))?;
                        let count = next.min(blocks - first).min(MAX_GROUPS * WORKGROUP);
                        let start = Instant::now();
                        let end = first + count;
                        let push = Push { first, end, node_begin, node_count, adds: u32::from(part > 0), ..push };
                        let bound = [&texels, &lines, &axes, &result, &status, nodes, &lists];
                        gpu.dispatch(&kernel, &bound, &push, [count.div_ceil(WORKGROUP), 1, 1])?;
                        next = slice.unwrap_or_else(|| next_slice(count, start.elapsed(), WORKGROUP));
                        let last = end == blocks;
                        if (first == 0 || last) && gpu.read::<u32>(&status)?[0] != 0 {
                            gpu.write(&mut status, &[0u32])?;
                            if parts.len() >= MOST_PARTS || most < 8 {
                                return Err(self.overrun(m));
                            }
                            most /= 8;
                            continue 'again;
                        }
                        first = end;
                    }
                }
                break;
            }
            done += blocks;
        }
        tick(on, "filtered", 1.0)?;
        let all = gpu.read::<f32>(&result)?;
        let mut rest = all.as_slice();
        let mut next = |texels: usize| rest.split_off(..3 * texels).expect("the result has them all");
        let mut levels: Vec<Vec<f32>> = self.filtered().map(|m| next(self.texels(m) as usize).to_vec()).collect();
        for (level, groups) in levels.iter_mut().zip(&groups) {
            if let Some(groups) = groups {
                groups.add(next(groups.axes.len()), level);
            }
        }
        Ok(levels)
    }

    fn push(&self, m: u32, offset: u32, prepared: &Prepared<'_>) -> Push {
        let Prepared { picture, tree, .. } = prepared;
        let (rows, columns) = match picture {
            Picture::Equirect(p) => (p.height, p.width),
            Picture::Cube(p) => (p.size, p.size),
        };
        let lobe = self.lobe(m);
        let [blue_red, blue_green] = tree.blue_from();
        let (width, height) = self.level_size(m);
        Push {
            width,
            height,
            block: self.block_size(m),
            first: 0,
            end: 0,
            offset,
            node_begin: 0,
            node_count: tree.nodes.len() as u32,
            adds: 0,
            limit: self.precision.limit,
            rows,
            d_theta: (std::f64::consts::PI / f64::from(rows)) as f32,
            d_phi: (std::f64::consts::TAU / f64::from(columns)) as f32,
            alpha: lobe.alpha as f32,
            eps: self.precision.eps as f32,
            inverse_norm: lobe.inverse_norm as f32,
            blue_red: blue_red as f32,
            blue_green: blue_green as f32,
            base: tree.base,
            lists: 0,
            groups_across: 0,
            of_groups: 0,
        }
    }

    /// What the file says of itself.
    fn meta(&self, backend: &Backend) -> Meta {
        let mut meta = Meta::default();
        let list =
            |of: &dyn Fn(u32) -> f64| (0..self.mips).map(|m| format!("{:.6}", of(m))).collect::<Vec<_>>().join(",");
        meta.set("environment", if self.filtered().start == 0 { "irradiance over pi" } else { "specular" });
        meta.set("projection", self.projection.name());
        meta.set("kernel", self.kernel.name);
        meta.set("roughness-law", self.law.name());
        meta.set("alpha", list(&|m| self.alpha(m)));
        if self.gutter > 0 {
            meta.set(GUTTER, self.gutter);
        }
        if self.filtered().start > 0 {
            meta.set("mip.0", "mean over the texel's solid angle");
        }
        meta.set("layout", self.projection.convention());
        meta.set(
            "orientation",
            "equirect (u, v) looks along (cos φ sin θ, cos θ, sin φ sin θ), φ = 2π(u − 1/2), θ = πv",
        );
        meta.set("source", self.kernel.source);
        meta.set("rule", self.rule());
        meta.set("quality", self.quality.name);
        meta.set("device", backend.name());
        meta.set("driver", backend.driver());
        meta.set("version", env!("CARGO_PKG_VERSION"));
        meta
    }
}

/// An equirectangular picture, RGB interleaved, with `gutter` texels around it that go on across its edges.
pub(super) fn with_gutter(texels: Vec<f32>, (width, height): (u32, u32), gutter: u32) -> Vec<f32> {
    if gutter == 0 {
        return texels;
    }
    let (w, h, g) = (i64::from(width), i64::from(height), i64::from(gutter));
    let mut out = Vec::with_capacity(3 * ((w + 2 * g) * (h + 2 * g)) as usize);
    for y in -g..h + g {
        // Across a pole follows the column half a turn away.
        let (row, turned) = match y {
            _ if y < 0 => (-1 - y, w / 2),
            _ if y >= h => (2 * h - 1 - y, w / 2),
            _ => (y, 0),
        };
        for x in -g..w + g {
            let at = 3 * (row * w + (x + turned).rem_euclid(w)) as usize;
            out.extend_from_slice(&texels[at..at + 3]);
        }
    }
    out
}

/// The source without its base, RGB interleaved.
fn residual(picture: &Picture<'_>, base: [f32; 3]) -> Vec<f32> {
    picture.texels().iter().flat_map(|t| [t[0] - base[0], t[1] - base[1], t[2] - base[2]]).collect()
}

/// Cosine and sine of θ at the middle of every row, then of φ at the middle of every column. Cubes need none.
fn lines(picture: &Picture<'_>) -> Vec<[f32; 2]> {
    let Picture::Equirect(source) = picture else { return vec![[0.0; 2]] };
    let theta = (0..source.height).map(|i| std::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(source.height));
    let phi = (0..source.width).map(|j| std::f64::consts::TAU * ((f64::from(j) + 0.5) / f64::from(source.width) - 0.5));
    theta.chain(phi).map(|a| [a.cos() as f32, a.sin() as f32]).collect()
}

/// The shader's push constants.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    width: u32,
    height: u32,
    block: u32,
    first: u32,
    end: u32,
    offset: u32,
    node_begin: u32,
    node_count: u32,
    adds: u32,
    limit: u32,
    rows: u32,
    d_theta: f32,
    d_phi: f32,
    alpha: f32,
    eps: f32,
    inverse_norm: f32,
    blue_red: f32,
    blue_green: f32,
    base: [f32; 3],
    lists: u32,
    groups_across: u32,
    of_groups: u32,
}

/// Blocks of a mip, or its groups.
struct Run {
    m: u32,
    blocks: u32,
    push: Push,
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
    fn least_threshold(&self) -> f64 {
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

    #[test]
    fn every_texel_is_in_one_block() {
        for (size, m) in [(64, 0), (64, 1), (64, 3), (64, 4), (64, 6), (50, 0), (50, 2)] {
            for shape in ["cube", "equirect"] {
                let request = SpecularRequest { size: Some(size), shape: shape.into(), ..Default::default() };
                let job = request.resolve().expect("valid");
                let (width, height) = job.level_size(m);
                let mut seen = vec![0; job.texels(m) as usize];
                for index in 0..job.blocks(m) {
                    let mut texels = job.block(m, index);
                    texels.sort_unstable();
                    texels.dedup();
                    texels.iter().for_each(|[face, x, y]| seen[((face * height + y) * width + x) as usize] += 1);
                }
                assert!(seen.iter().all(|s| *s == 1), "{shape} {size}, mip {m}");
            }
        }
    }
}
