// SPDX-License-Identifier: MIT OR Apache-2.0
//! [`super::specular_walk`] on the GPU, `shaders/bake/specular_walk.glsl`: first the blocks of each mip, then its groups, in
//! dispatches that a watchdog lets pass.

use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;

use super::groups::{Groups, POINTS};
use super::slices::next_slice;
use super::specular::{BUFFER_BYTES, Prepared, SpecularJob};
use super::specular_walk::MOST_PARTS;
use crate::env::tree::Node;
use crate::env::{Frame, Picture};
use crate::error::Result;
use crate::gpu::{Bindings, Buffer, Gpu, Kernel, MAX_GROUPS};
use crate::progress::{OnProgress, tick};
use crate::shaders;

/// Invocations a workgroup, as in the shader.
const WORKGROUP: u32 = 32;

/// How much a dispatch and a buffer hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Blocks a dispatch; `None` aims at a duration.
    pub blocks: Option<u32>,
    /// Largest buffer of nodes: larger trees are walked in pieces, and nothing is shared in them.
    pub buffer_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { blocks: None, buffer_bytes: BUFFER_BYTES }
    }
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

/// What is walked, one after the other.
struct Plan {
    /// Of each filtered mip, where its blocks share what is far.
    groups: Vec<Option<Groups>>,
    /// Are leaves cut?
    cuts: bool,
    runs: Vec<Run>,
    /// Where every texel looks, mip by mip, then every point of the groups: in the order of the result.
    axes: Vec<[f32; 3]>,
    /// First the lists of ranges: of all nodes, then of the groups. A list is the first range of what is near, their end, and
    /// the same of what is far. Then the ranges of nodes, each a first and an end.
    lists: Vec<[u32; 4]>,
}

impl Plan {
    /// `shares` where ranges of nodes are places in one buffer.
    fn new(job: &SpecularJob, prepared: &Prepared<'_>, shares: bool) -> Self {
        let cuts = job.cuts(prepared);
        let groups = |m| if shares { job.groups(m, prepared, cuts) } else { None };
        let groups: Vec<Option<Groups>> = job.filtered().map(groups).collect();
        let mut axes = job.axes(&prepared.frame);
        let (mut runs, mut offset) = (vec![], 0);
        for m in job.filtered() {
            runs.push(Run { m, blocks: job.blocks(m), push: job.push(m, offset, prepared) });
            offset += job.texels(m);
        }
        let mut lists = vec![[0, 1, 0, 0]];
        let mut ranges = vec![[0, prepared.tree.nodes.len() as u32, 0, 0]];
        for (m, groups) in job.filtered().zip(&groups) {
            let Some(groups) = groups else { continue };
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
            let (blocks, push) = (groups.each.len() as u32, job.push(m, axes.len() as u32, prepared));
            let push = Push { width: POINTS * blocks, height: POINTS, base: [0.0; 3], of_groups: 1, ..push };
            runs.push(Run { m, blocks, push });
            for Run { push, .. } in runs.iter_mut().filter(|run| run.m == m) {
                *push = Push { lists: first_list, groups_across, ..*push };
            }
            axes.extend(groups.axes.iter().map(|n| n.map(|v| v as f32)));
        }
        let before = lists.len() as u32;
        lists.iter_mut().flatten().for_each(|at| *at += before);
        lists.extend(ranges);
        Self { groups, cuts, runs, axes, lists }
    }

    /// Which shader. One for all mips: compiling another costs more than it saves where leaves are cut at all, or shared.
    fn variant(&self, picture: &Picture<'_>) -> &'static str {
        match picture {
            _ if self.groups.iter().any(Option::is_some) => "_shared",
            _ if !self.cuts => "",
            Picture::Equirect(_) => "_cut",
            Picture::Cube(_) => "_cut_faces",
        }
    }
}

/// What dispatches need.
struct Walker<'a> {
    job: &'a SpecularJob,
    prepared: &'a Prepared<'a>,
    gpu: &'a Gpu,
    kernel: &'a Kernel,
    texels: Buffer,
    lines: Buffer,
    axes: Buffer,
    lists: Buffer,
    /// Ranges of the tree's nodes, and where each is.
    nodes: Vec<(Range<usize>, Buffer)>,
    most_nodes: usize,
    result: Buffer,
    status: Buffer,
    fixed_slice: Option<u32>,
    /// Blocks of the next dispatch.
    slice: u32,
}

impl Walker<'_> {
    /// The tree in parts, walked one after the other: as many as it takes that none needs too many steps. `progress` is told
    /// how many blocks are done.
    fn walk(&mut self, run: &Run, progress: &mut dyn FnMut(u32) -> Result<()>) -> Result<()> {
        let mut most = self.most_nodes;
        loop {
            let tree = &self.prepared.tree;
            let of_buffer = |(i, (range, _)): (usize, &(Range<usize>, Buffer))| {
                tree.pieces(range.clone(), most).into_iter().map(move |p| (i, p)).collect::<Vec<_>>()
            };
            let parts: Vec<_> = self.nodes.iter().enumerate().flat_map(of_buffer).collect();
            let mut finished = true;
            for (part, (buffer, piece)) in parts.iter().enumerate() {
                finished = self.walk_part(run, *buffer, piece, part > 0, progress)?;
                if !finished {
                    break;
                }
            }
            if finished {
                return Ok(());
            }
            if parts.len() >= MOST_PARTS || most < 8 {
                return Err(self.job.overrun(run.m));
            }
            most /= 8;
        }
    }

    /// `false` where blocks took more steps than allowed.
    fn walk_part(
        &mut self,
        run: &Run,
        buffer: usize,
        piece: &Range<usize>,
        adds: bool,
        progress: &mut dyn FnMut(u32) -> Result<()>,
    ) -> Result<bool> {
        let (range, nodes) = &self.nodes[buffer];
        let [node_begin, node_count] = [piece.start, piece.end].map(|at| (at - range.start) as u32);
        let mut first = 0;
        while first < run.blocks {
            progress(first)?;
            let count = self.slice.min(run.blocks - first).min(MAX_GROUPS * WORKGROUP);
            let start = Instant::now();
            let end = first + count;
            let push = Push { first, end, node_begin, node_count, adds: u32::from(adds), ..run.push };
            let bound = [&self.texels, &self.lines, &self.axes, &self.result, &self.status, nodes, &self.lists];
            self.gpu.dispatch(self.kernel, &bound, &push, [count.div_ceil(WORKGROUP), 1, 1])?;
            self.slice = self.fixed_slice.unwrap_or_else(|| next_slice(count, start.elapsed(), WORKGROUP));
            let looks = first == 0 || end == run.blocks;
            if looks && self.gpu.read::<u32>(&self.status)?[0] != 0 {
                self.gpu.write(&mut self.status, &[0u32])?;
                return Ok(false);
            }
            first = end;
        }
        Ok(true)
    }
}

impl SpecularJob {
    /// The filtered mips, RGB.
    pub fn on_gpu(
        &self,
        prepared: &Prepared<'_>,
        gpu: &Gpu,
        limits: Limits,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<Vec<f32>>> {
        let Prepared { picture, tree, .. } = prepared;
        let texels_of_node = size_of::<Node>() as u64 / 16;
        let buffer_nodes =
            (limits.buffer_bytes / size_of::<Node>()).min((gpu.info().max_texels / texels_of_node) as usize);
        let plan = Plan::new(self, prepared, tree.nodes.len() <= buffer_nodes);
        let name = format!("bake/specular{}+{}", plan.variant(picture), self.kernel.file());
        // The tree's nodes, and ranges of them, are texel buffers.
        let bindings = Bindings { storage: 5, texel: 2 };
        let kernel = gpu.kept_kernel(&name, &shaders::spirv(&name), bindings, size_of::<Push>() as u32)?;
        let upload = |range: Range<usize>| Ok((range.clone(), gpu.upload_texels("nodes", &tree.nodes[range])?));
        let mut walker = Walker {
            job: self,
            prepared,
            gpu,
            kernel: &kernel,
            texels: gpu.upload("texels", &if plan.cuts { residual(picture, tree.base) } else { vec![0.0] })?,
            lines: gpu.upload("lines", &lines(picture))?,
            axes: gpu.upload("axes", &plan.axes)?,
            lists: gpu.upload_texels("ranges", &plan.lists)?,
            nodes: tree.pieces(tree.whole(), buffer_nodes).into_iter().map(upload).collect::<Result<_>>()?,
            most_nodes: tree.nodes.len().min(buffer_nodes),
            result: gpu.buffer("result", plan.axes.len() as u64 * 12)?,
            status: gpu.upload("status", &[0u32])?,
            fixed_slice: limits.blocks,
            slice: limits.blocks.unwrap_or(1),
        };
        let total: u32 = plan.runs.iter().map(|run| run.blocks).sum();
        let mut done = 0;
        for run in &plan.runs {
            let stage = self.stage(run.m);
            walker.walk(run, &mut |blocks| tick(on, &stage, f64::from(done + blocks) / f64::from(total)))?;
            done += run.blocks;
        }
        tick(on, "filtered", 1.0)?;
        let all = gpu.read::<f32>(&walker.result)?;
        let mut rest = all.as_slice();
        let mut next = |texels: usize| rest.split_off(..3 * texels).expect("the result has them all");
        let mut levels: Vec<Vec<f32>> = self.filtered().map(|m| next(self.texels(m) as usize).to_vec()).collect();
        for (level, groups) in levels.iter_mut().zip(&plan.groups) {
            if let Some(groups) = groups {
                groups.add(next(groups.axes.len()), level);
            }
        }
        Ok(levels)
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
}
