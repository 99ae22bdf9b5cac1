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
//! The rule is that of [`super::specular_walk`]: no sampling, but a walk over a tree of moments. What is far from 16 × 16 texels
//! they take together where the kernel's tail lets them ([`super::groups`]). The same bytes come out whatever the slices and
//! however many threads.

use std::borrow::Cow;
use std::ops::Range;

use rayon::prelude::*;

use super::groups::Groups;
use super::quality::{self, Quality};
use super::specular_gpu::Limits;
use super::specular_walk::{Lobe, Precision};
use super::{Backend, RoughnessLaw};
use crate::env::projection::Projection;
use crate::env::tree::{Params, Tree};
use crate::env::{Environment, Frame, Picture, area, resample};
use crate::error::{Error, Result};
use crate::ndf::alpha_of;
use crate::progress::{OnProgress, tick};
use crate::term::zonal::{self, Peak, Zonal};
use crate::texture::{Meta, Shape, Texture};

/// Largest side of a face in texels.
pub const MAX_SIZE: u32 = 4096;
/// Texels along a side of a block: what one invocation computes. Kernels with a ring at the horizon take smaller blocks
/// where the texels of one would look along too many rings.
const BLOCK: u32 = 4;
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
pub(super) const BUFFER_BYTES: usize = 1 << 27;

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
    pub(super) fn texels(&self, m: u32) -> u32 {
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
            Backend::Gpu(gpu) => self.on_gpu(prepared, gpu, Limits::default(), on)?,
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
    pub(super) fn block_size(&self, m: u32) -> u32 {
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

    pub(super) fn blocks(&self, m: u32) -> u32 {
        let (across, down) = self.sides(m);
        self.projection.faces() * across * down
    }

    pub(super) fn stage(&self, m: u32) -> String {
        if self.mips == 1 { "filtering".into() } else { format!("mip {m} of {}", self.mips - 1) }
    }

    pub(super) fn overrun(&self, m: u32) -> Error {
        let detail = format!(
            "mip {m} (alpha {:.5}) needs more than {} steps a block and part of the tree; use fewer mips or a larger --size",
            self.alpha(m),
            self.precision.limit
        );
        Error::Gpu { op: format!("filter the environment with {}", self.kernel.name), detail }
    }

    /// The groups that a mip's blocks share what is far with; `cuts` where leaves are cut.
    pub(super) fn groups(&self, m: u32, prepared: &Prepared<'_>, cuts: bool) -> Option<Groups> {
        let far = self.precision.far;
        let shares = far.is_finite() && self.kernel.has_tail && !cuts && self.block_size(m) == BLOCK;
        shares.then(|| Groups::of(self, m, prepared, far)).flatten()
    }

    /// Is any leaf cut?
    pub(super) fn cuts(&self, prepared: &Prepared<'_>) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

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
