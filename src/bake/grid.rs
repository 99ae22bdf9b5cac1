// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs a table kernel, or the rule on the processor, over a grid of (n·v, roughness) in slices.

use std::time::Instant;

use bytemuck::Pod;
use rayon::prelude::*;

use super::model::Method;
use super::slices::next_slice;
use super::{At, Backend, Model};
use crate::error::Result;
use crate::gpu::{Buffer, Gpu, MAX_GROUPS};
use crate::ndf::alpha_of;
use crate::progress::{OnProgress, tick};
use crate::rule::cone_elliptic::{self, Cone};
use crate::rule::cone_nodes;
use crate::rule::h_split::{Outer, Row, outer};
use crate::rule::rings::{self, RING_LEN};
use crate::rule::transmit;
use crate::shaders;
use crate::term::fresnel::{WEIGHTS, Weights};

/// Invocations a workgroup, as in `shaders/lib/table.glsl`.
const WORKGROUP: u32 = 64;
/// The first slice also compiles the shader, so it is small.
const FIRST_SLICE: u32 = 4096;
/// A band of rows has a result buffer of at most this size.
pub(super) const BAND_BYTES: u64 = 64 << 20;

/// A band of the h-split rule has at most this many texels, whose nodes lie in memory.
const NODES_BAND: usize = 1 << 13;

/// A grid to bake.
#[derive(Clone, Copy)]
pub struct Grid<'a> {
    /// What progress is reported as.
    pub stage: &'a str,
    /// n·v of each column.
    pub n_dot_v: &'a [f64],
    /// Roughness of each row.
    pub roughness: &'a [f64],
    /// Texels in the first slice; `None` starts small. Any choice gives the same bytes.
    pub first_slice: Option<u32>,
}

/// The push block of the table kernels, as in `shaders/lib/slice.glsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Slice {
    columns: u32,
    first: u32,
    count: u32,
    padding: u32,
    eta: [f32; 4],
    k: [f32; 4],
}

impl Grid<'_> {
    /// Bakes all weights of the model's Fresnel term, [`WEIGHTS`] values a texel, on a Vulkan device or the processor.
    pub fn run(&self, backend: &Backend, model: &Model, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
        match backend {
            Backend::Cpu => self.on_cpu(|at| model.rule(at), on),
            Backend::Gpu(gpu) => self.on_gpu(gpu, model, model.method(), on),
        }
    }

    /// Bakes what a dielectric interface transmits, the first of [`WEIGHTS`] values a texel; the others are 0.
    pub fn transmitted(&self, backend: &Backend, model: &Model, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
        match backend {
            Backend::Cpu => self.on_cpu(|at| [model.transmitted(at), 0.0, 0.0, 0.0], on),
            Backend::Gpu(gpu) => self.on_gpu(gpu, model, Method::Transmit, on),
        }
    }

    fn on_cpu(&self, rule: impl Fn(At) -> Weights + Sync, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
        let columns = self.n_dot_v.len();
        let mut out = vec![f32::NAN; columns * self.roughness.len() * WEIGHTS];
        let slice = (FIRST_SLICE as usize).div_ceil(columns);
        for (i, rows) in out.chunks_mut(slice * columns * WEIGHTS).enumerate() {
            tick(on, self.stage, (i * slice) as f64 / self.roughness.len() as f64)?;
            rows.par_chunks_mut(WEIGHTS).enumerate().for_each(|(texel, out)| {
                let roughness = self.roughness[i * slice + texel / columns];
                let values = rule(At { n_dot_v: self.n_dot_v[texel % columns], roughness });
                out.iter_mut().zip(values).for_each(|(o, v)| *o = v as f32);
            });
        }
        tick(on, self.stage, 1.0)?;
        Ok(out)
    }

    fn on_gpu(&self, gpu: &Gpu, model: &Model, method: Method, on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
        let name = model.kernel(method);
        let bindings = if matches!(method, Method::Cone | Method::ConeElliptic) { 4 } else { 5 };
        let kernel = gpu.kept_kernel(&name, &shaders::spirv(&name), bindings, size_of::<Slice>() as u32)?;
        let n_dot_v: Vec<f32> = self.n_dot_v.iter().map(|x| *x as f32).collect();
        let n_dot_v = gpu.upload("n_dot_v", &n_dot_v)?;
        let padded = |x: [f64; 3]| [x[0] as f32, x[1] as f32, x[2] as f32, 0.0];
        // As shaders/term/fresnel/internal.glsl reads them.
        let k = model.fresnel.kink().map_or(model.fresnel.optics.k, |critical| [critical, 0.0, 0.0]);
        let (eta, k) = (padded(model.fresnel.optics.eta), padded(k));

        let columns = self.n_dot_v.len() as u32;
        let row_bytes = u64::from(columns) * size_of::<[f32; WEIGHTS]>() as u64;
        let band_rows = (BAND_BYTES / row_bytes).max(1) as usize;
        let band_rows =
            if method == Method::Cone { band_rows } else { (NODES_BAND / self.n_dot_v.len()).clamp(1, band_rows) };
        let total = f64::from(columns) * self.roughness.len() as f64;
        let mut inputs = Inputs::default();
        let mut out = Vec::with_capacity(columns as usize * self.roughness.len() * WEIGHTS);
        let mut slice = self.first_slice.unwrap_or(FIRST_SLICE);
        for band in self.roughness.chunks(band_rows) {
            match method {
                Method::Cone => inputs.cone(gpu, band)?,
                Method::ConeElliptic => inputs.cone_elliptic(gpu, model, self.n_dot_v, band)?,
                Method::HSplit => inputs.h_split(gpu, model, self.n_dot_v, band, |row, n_dot_v, nodes| {
                    outer(&model.ndf, model.visibility, &model.fresnel, row, n_dot_v, nodes);
                })?,
                Method::Rings => inputs.rings(gpu, model, self.n_dot_v, band)?,
                Method::Transmit => inputs.h_split(gpu, model, self.n_dot_v, band, |row, n_dot_v, nodes| {
                    transmit::outer(&model.ndf, &model.fresnel, row, n_dot_v, nodes);
                })?,
            }
            let result = gpu.buffer("result", row_bytes * band.len() as u64)?;
            let buffers: Vec<&Buffer> = std::iter::once(&n_dot_v).chain(&inputs.buffers).chain([&result]).collect();
            let texels = columns * band.len() as u32;
            let mut first = 0;
            while first < texels {
                let done = (out.len() / WEIGHTS) as f64 + f64::from(first);
                tick(on, self.stage, done / total)?;
                let count = slice.min(texels - first).min(MAX_GROUPS * WORKGROUP);
                let start = Instant::now();
                let push = Slice { columns, first, count, padding: 0, eta, k };
                gpu.dispatch(&kernel, &buffers, &push, [count.div_ceil(WORKGROUP), 1, 1])?;
                slice = next_slice(count, start.elapsed(), WORKGROUP);
                first += count;
            }
            let start = out.len();
            out.extend(gpu.read::<f32>(&result)?);
            if method == Method::Rings {
                // A mirror has no rings.
                for (texel, out) in out[start..].as_chunks_mut::<WEIGHTS>().0.iter_mut().enumerate() {
                    let at = At {
                        n_dot_v: self.n_dot_v[texel % self.n_dot_v.len()],
                        roughness: band[texel / self.n_dot_v.len()],
                    };
                    if at.roughness == 0.0 {
                        *out = model.rule(at).map(|v| v as f32);
                    }
                }
            }
        }
        tick(on, self.stage, 1.0)?;
        Ok(out)
    }
}

/// What a rule reads for a band of rows. Buffers live on from band to band: fresh memory costs more than filling it.
#[derive(Default)]
struct Inputs {
    buffers: Vec<Buffer>,
}

impl Inputs {
    /// Puts `data` into buffer `index`, which grows if it must.
    fn put<T: Pod>(&mut self, gpu: &Gpu, index: usize, name: &str, data: &[T]) -> Result<()> {
        let bytes = size_of_val(data) as u64;
        match self.buffers.get_mut(index) {
            Some(buffer) if buffer.size_bytes() >= bytes => gpu.write(buffer, data)?,
            Some(buffer) => *buffer = gpu.upload(name, data)?,
            None => self.buffers.push(gpu.upload(name, data)?),
        }
        Ok(())
    }

    /// The widths of a band and the nodes of the cone rule, as `shaders/lib/table.glsl` reads them.
    fn cone(&mut self, gpu: &Gpu, band: &[f64]) -> Result<()> {
        let alpha: Vec<f32> = band.iter().map(|r| alpha_of(*r) as f32).collect();
        let nodes = cone_nodes::outer();
        let nodes: Vec<[f32; 4]> = nodes.iter().map(|n| [n.near as f32, n.far as f32, n.weight as f32, 0.0]).collect();
        self.put(gpu, 0, "alpha", &alpha)?;
        self.put(gpu, 1, "cone nodes", &nodes)
    }

    /// The cones and their latitudes, as `shaders/rule/cone_elliptic.glsl` reads them.
    fn cone_elliptic(&mut self, gpu: &Gpu, model: &Model, n_dot_v: &[f64], band: &[f64]) -> Result<()> {
        let texels = band.len() * n_dot_v.len();
        let mut records = vec![[[0f32; 4]; cone_elliptic::RECORD]; texels];
        let mut nodes = vec![[[0f32; 4]; cone_elliptic::OUTER]; texels];
        records.par_iter_mut().zip(&mut nodes).enumerate().for_each(|(texel, (record, nodes))| {
            let mu = n_dot_v[texel % n_dot_v.len()];
            let lobe = model.ndf.lobe(band[texel / n_dot_v.len()]);
            let Some(ellipse) = lobe.and_then(|lobe| model.ndf.ellipse(&lobe)) else {
                // A mirror: no width, and nothing but n·v.
                record[4][2] = mu as f32;
                return;
            };
            let cone = Cone::new(ellipse, mu);
            *record = cone.record();
            for (to, n) in nodes.iter_mut().zip(cone.latitudes()) {
                *to = [n.tan as f32, n.sin2 as f32, n.cos2 as f32, n.weight as f32];
            }
        });
        self.put(gpu, 0, "cones", records.as_flattened().as_flattened())?;
        self.put(gpu, 1, "latitudes", nodes.as_flattened().as_flattened())
    }

    /// The widths and the rings of a band, as `shaders/bake/rings.comp` reads them; a mirror has none.
    fn rings(&mut self, gpu: &Gpu, model: &Model, n_dot_v: &[f64], band: &[f64]) -> Result<()> {
        let shadowed = if model.is_shadowed() { 1.0 } else { 0.0 };
        let rows: Vec<[f32; 2]> = band.iter().map(|r| [alpha_of(*r) as f32, shadowed]).collect();
        let of_texel = |texel: usize| -> Vec<[f32; RING_LEN]> {
            let (alpha, mu) = (alpha_of(band[texel / n_dot_v.len()]), n_dot_v[texel % n_dot_v.len()]);
            let mut list = vec![];
            if alpha > 0.0 {
                rings::outer(alpha, mu, &model.fresnel, &mut list);
            }
            list.iter().map(|ring| ring.packed(&model.fresnel)).collect()
        };
        let texels: Vec<_> = (0..band.len() * n_dot_v.len()).into_par_iter().map(of_texel).collect();
        let mut first = vec![0u32];
        let mut list = vec![];
        for texel in &texels {
            list.extend_from_slice(texel);
            first.push(list.len() as u32);
        }
        // A buffer is never empty, even where every lobe is a mirror.
        list.push([0.0; RING_LEN]);
        self.put(gpu, 0, "rows", rows.as_flattened())?;
        self.put(gpu, 1, "rings", list.as_flattened())?;
        self.put(gpu, 2, "first rings", &first)
    }

    /// The rows and the polar nodes of a band, as `shaders/lib/h_table.glsl` reads them.
    fn h_split(
        &mut self,
        gpu: &Gpu,
        model: &Model,
        n_dot_v: &[f64],
        band: &[f64],
        place: impl Fn(&Row, f64, &mut Vec<Outer>) + Sync,
    ) -> Result<()> {
        let rows: Vec<_> = band
            .par_iter()
            .map(|roughness| {
                let row = Row::new(&model.ndf, model.visibility, *roughness);
                let (mut nodes, mut ends) = (vec![], vec![]);
                for n_dot_v in n_dot_v {
                    place(&row, *n_dot_v, &mut nodes);
                    ends.push(nodes.len() as u32);
                }
                (row.packed(), nodes, ends)
            })
            .collect();
        let mut first = vec![0];
        let mut packed = vec![];
        let mut nodes: Vec<[f32; 2]> =
            Vec::with_capacity(1 + rows.iter().map(|(_, nodes, _)| nodes.len()).sum::<usize>());
        for (row, of_row, ends) in &rows {
            first.extend(ends.iter().map(|end| nodes.len() as u32 + end));
            packed.push(*row);
            nodes.extend(of_row.iter().map(|n| [n.tan_h as f32, n.weight as f32]));
        }
        // A buffer is never empty, even where every lobe is a mirror.
        nodes.push([0.0; 2]);
        self.put(gpu, 0, "rows", packed.as_flattened())?;
        self.put(gpu, 1, "polar nodes", &nodes)?;
        self.put(gpu, 2, "first nodes", &first)
    }
}
