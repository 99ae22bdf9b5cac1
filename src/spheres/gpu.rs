// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs the kernels of the preview, slice by slice.

use std::time::Instant;

use super::shade::Shade;
use super::{Method, Picture};
use crate::axis::Warp;
use crate::bake::slices::next_slice;
use crate::error::Result;
use crate::gpu::{Gpu, MAX_GROUPS};
use crate::progress::{OnProgress, tick};
use crate::shaders;
use crate::spheres::scene::{RADIUS, Seen};

/// Invocations a workgroup, as in the shader.
const WORKGROUP: u32 = 32;

/// The shader's scene.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Block {
    width: u32,
    height: u32,
    columns: u32,
    rows: u32,
    tile_px: f32,
    radius: f32,
    mips: u32,
    diffuse_level: u32,
    source_level: u32,
    source_levels: u32,
    table_width: u32,
    table_height: u32,
    table_place: [[f32; 2]; 2],
    table_warps: [u32; 2],
    compensate: u32,
    background: f32,
    map_width: u32,
    map_height: u32,
    lobes: u32,
    /// Up to the next multiple of 16 bytes.
    filling: u32,
    frame: [[f32; 4]; 3],
}

/// The shader's push constants.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    first: u32,
    count: u32,
}

impl Shade<'_> {
    /// Renders on a Vulkan device.
    pub fn on_gpu(&self, gpu: &Gpu, on: &mut OnProgress<'_>) -> Result<Picture> {
        let (scene, maps, lighting) = (self.scene, self.maps, self.lighting);
        let (width, height) = scene.size;
        // Nodes of all rows, one after the other.
        let mut nodes: Vec<[f32; 4]> = vec![];
        let mut first_of = vec![];
        let packed = |node: &super::nodes::Node| [node.xy[0], node.xy[1], node.weight, node.lod].map(|v| v as f32);
        for (_, of_row) in &lighting.rows {
            first_of.push(nodes.len() as u32);
            nodes.extend(of_row.iter().map(packed));
        }
        let lobe = |row: &Option<usize>| match row {
            Some(row) => [first_of[*row] + ((*row as u32) << 24), lighting.rows[*row].1.len() as u32],
            None => [0; 2],
        };
        let spheres: Vec<[u32; 12]> = scene
            .spheres
            .iter()
            .zip(&lighting.of_sphere)
            .map(|(s, row)| {
                let [r, g, b] = s.base;
                let [r, g, b, metallic, roughness, f0] =
                    [r, g, b, s.metallic, s.roughness, s.f0].map(|v| (v as f32).to_bits());
                let [first, count] = lobe(row);
                let [red, green, blue] = s.edge.map(|v| (v as f32).to_bits());
                [r, g, b, metallic, roughness, f0, first, count, red, green, blue, 0]
            })
            .collect();
        let levels: Vec<[u32; 4]> =
            maps.levels.levels.iter().map(|(first, size, roughness)| [*first, *size, roughness.to_bits(), 0]).collect();
        let block = Block {
            width,
            height,
            columns: scene.columns,
            rows: scene.rows(),
            tile_px: scene.tile_px() as f32,
            radius: RADIUS as f32,
            mips: maps.mips,
            diffuse_level: maps.diffuse_level(self.method),
            source_level: maps.source_level,
            source_levels: maps.source_levels(),
            table_width: maps.table.width,
            table_height: maps.table.height,
            table_place: maps.table.place.map(|(scale, shift)| [scale as f32, shift as f32]),
            table_warps: maps
                .table
                .warps
                .map(|warp| Warp::ALL.iter().position(|w| *w == warp).expect("every warp is one of them") as u32),
            compensate: u32::from(self.compensate),
            background: self.background.unwrap_or(-1.0),
            map_width: self.pictures.width,
            map_height: self.pictures.height,
            lobes: lighting.lobes.len() as u32,
            filling: 0,
            frame: self.frame.rows().map(|[x, y, z]| [x as f32, y as f32, z as f32, 0.0]),
        };
        // A buffer is never empty.
        let pictures = if self.pictures.width > 0 { &self.pictures.texels[..] } else { &[[[0.0; 4]; 2]][..] };
        let pixels = width * height;
        let (order, groups) = self.order();
        let result = gpu.buffer("result", u64::from(pixels) * 16)?;
        let mut buffers = vec![
            gpu.upload("scene", &[block])?,
            gpu.upload("spheres", &spheres)?,
            gpu.upload("texels", &maps.levels.texels)?,
            gpu.upload("levels", &levels)?,
            gpu.upload("table", &maps.table.texels)?,
            gpu.upload("pictures", pictures)?,
            result,
            gpu.upload("order", &order)?,
        ];
        let (name, stage) = match self.method {
            Method::SplitSum => ("spheres/split_sum".to_string(), "split sum"),
            Method::Reference => {
                let mut rows: Vec<_> = lighting.rows.iter().map(|(row, _)| row.packed()).collect();
                rows.resize(rows.len().max(1), [0.0; crate::rule::h_split::ROW_LEN]);
                buffers.push(gpu.upload("nodes", &nodes)?);
                buffers.push(gpu.upload("rows", rows.as_flattened())?);
                let mut lobes: Vec<[u32; 2]> = lighting.lobes.iter().map(lobe).collect();
                lobes.resize(lobes.len().max(1), [0; 2]);
                buffers.push(gpu.upload("lobes", &lobes)?);
                (format!("spheres/reference+{}", self.visibility.file), "reference")
            }
        };
        let kernel = gpu.kernel(&name, &shaders::spirv(&name), buffers.len() as u32, size_of::<Push>() as u32)?;
        let bound: Vec<_> = buffers.iter().collect();
        let mut first = 0;
        for end in groups {
            // What the last group took says nothing about this one.
            let mut next = 2 * WORKGROUP;
            while first < end {
                tick(on, stage, f64::from(first) / f64::from(pixels))?;
                let count = next.min(end - first).min(MAX_GROUPS * WORKGROUP);
                let start = Instant::now();
                gpu.dispatch(&kernel, &bound, &Push { first, count }, [count.div_ceil(WORKGROUP), 1, 1])?;
                next = next_slice(count, start.elapsed(), WORKGROUP);
                first += count;
            }
        }
        tick(on, stage, 1.0)?;
        Ok(Picture { width, height, pixels: gpu.read::<[f32; 4]>(&buffers[6])? })
    }
    /// All pixels: first those that show no sphere, then the insides of the spheres, then their rims, and where each group
    /// ends: one for what shares a lobe.
    fn order(&self) -> (Vec<u32>, Vec<u32>) {
        let (width, height) = self.scene.size;
        let spheres = self.scene.spheres.len();
        let mut of: Vec<Vec<u32>> = vec![vec![]; 1 + 2 * spheres];
        for y in 0..height {
            for x in 0..width {
                let middle = self.scene.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let sphere = |part: Seen| match part {
                    Seen::Sphere(sphere, _) => Some(sphere),
                    Seen::Behind(_) => None,
                };
                let group = match sphere(middle) {
                    Some(sphere) if self.is_alone(middle) => 1 + sphere,
                    _ => self.scene.parts(x, y).into_iter().find_map(sphere).map_or(0, |s| 1 + spheres + s),
                };
                of[group].push(y * width + x);
            }
        }
        let (mut order, mut groups) = (vec![], vec![]);
        let lobe = |group: usize| (group > spheres, self.lighting.of_sphere[(group - 1) % spheres]);
        for (i, pixels) in of.iter().enumerate() {
            if i > 1 && lobe(i) == lobe(i - 1) {
                groups.pop();
            }
            order.extend(pixels);
            groups.push(order.len() as u32);
        }
        (order, groups)
    }
}
