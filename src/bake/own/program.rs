// SPDX-License-Identifier: MIT OR Apache-2.0
//! A BRDF of one's own as kernels of a device.

use std::time::Instant;

use bytemuck::Pod;

use super::source::OwnSource;
use crate::bake::slices::next_slice;
use crate::error::{Error, Result};
use crate::glsl;
use crate::gpu::{Buffer, Gpu, Kernel, MAX_GROUPS};
use crate::progress::{OnProgress, tick};
use crate::quadrature::gauss_kronrod::{self, NODES};

/// In which precision a BRDF is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// `float` means double: right down to the narrowest lobes.
    Double,
    /// `float` stays: what the device of a game computes, with its rounding.
    Single,
}

impl Precision {
    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Precision::Double => "double",
            Precision::Single => "single",
        }
    }

    /// The precision with this name.
    pub fn parse(name: &str) -> Result<Precision> {
        [Precision::Double, Precision::Single]
            .into_iter()
            .find(|p| p.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown precision '{name}'"), "known are: double, single"))
    }
}

/// Numbers that a pair of directions, a place and a cell's sums take.
pub(super) const PAIR: usize = 8;
pub(super) const PLACE: usize = 8;
pub(super) const SUMS: usize = 8;

/// Invocations a workgroup, as in `shaders/own/*.glsl`.
const WORKGROUP: u32 = 64;
/// The first slice also compiles the kernel, so it is small.
const FIRST_SLICE: u32 = 256;
/// Cells or pairs that are in memory at once.
const BATCH: usize = 1 << 18;

/// A part of a panel of a place: `shaders/own/cells.glsl` reads it as six words.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Cell {
    pub place: u32,
    pub panel: u32,
    /// Start and width along the polar angle, in [0, 1] of the panel; all four are exact in binary.
    pub u: f32,
    pub du: f32,
    /// Start and width along the azimuth.
    pub x: f32,
    pub dx: f32,
}

/// The push block of both kernels.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    first: u32,
    count: u32,
    colored: u32,
}

/// The compiled kernels of a BRDF.
pub(super) struct Program {
    pub precision: Precision,
    evaluate: Kernel,
    cells: Kernel,
    nodes: Buffer,
}

/// What both kernels begin with, in double precision.
const DOUBLE: &str = "#define REAL double
#define REAL2 dvec2
#define REAL3 dvec3
#define BAKER_TINY 1e-14lf
#define BAKER_ACOS(x) acos(x)
";
/// And in single.
const SINGLE: &str = "#define REAL float
#define REAL2 vec2
#define REAL3 vec3
#define BAKER_TINY 1e-7
#define BAKER_ACOS(x) (2.0 * half_acos(x))
";
/// What `float` means in the user's text from here on.
const FLOATS_ARE_DOUBLES: &str = "#define float double
#define vec2 dvec2
#define vec3 dvec3
#define vec4 dvec4
#define mat2 dmat2
#define mat3 dmat3
#define mat4 dmat4
";
/// A BRDF of a distribution and a visibility.
const OF_D_AND_V: &str = "REAL D(REAL n_dot_h, REAL alpha);
REAL V(REAL n_dot_v, REAL n_dot_l, REAL alpha);
REAL3 brdf(REAL3 l, REAL3 v, REAL alpha) {
    return REAL3(D(normalize(l + v).z, alpha) * V(v.z, l.z, alpha));
}
";
const WHOLE: &str = "REAL3 brdf(REAL3 l, REAL3 v, REAL alpha);\n";

impl Program {
    /// Compiles the kernels; an error tells what is wrong with the text.
    pub fn new(gpu: &Gpu, source: &OwnSource, precision: Precision) -> Result<Program> {
        let double = precision == Precision::Double;
        if double && !gpu.info().float64 {
            return Err(Error::usage(
                format!("{} does not compute in double precision", gpu.info().name),
                "use --precision single, or another --device",
            ));
        }
        let functions = match double {
            true => include_str!("../../../shaders/own/elementary.glsl").to_string(),
            false => {
                [include_str!("../../../shaders/term/trig.glsl"), include_str!("../../../shaders/own/single.glsl")]
                    .concat()
            }
        };
        let kernel = |name: &str, main: &str, bindings: u32| {
            let before = [
                "#version 450\n",
                if double { DOUBLE } else { SINGLE },
                &functions,
                if source.is_whole() { WHOLE } else { OF_D_AND_V },
                main,
                if double { FLOATS_ARE_DOUBLES } else { "" },
            ];
            let words = glsl::compile(&before.concat(), source.text(), source.path())?;
            gpu.kernel(name, &words, bindings, size_of::<Push>() as u32)
        };
        let evaluate = kernel("own/evaluate", include_str!("../../../shaders/own/evaluate.glsl"), 2)?;
        let cells = kernel("own/cells", include_str!("../../../shaders/own/cells.glsl"), 4)?;
        let nodes: Vec<f64> =
            gauss_kronrod::on_unit_interval().iter().flat_map(|n| [n.x, n.kronrod, n.gauss]).collect();
        let nodes = upload(gpu, "nodes", &nodes, double)?;
        Ok(Program { precision, evaluate, cells, nodes })
    }

    /// The BRDF at pairs of directions, (l, v, alpha, 0) each.
    pub fn evaluate(&self, gpu: &Gpu, pairs: &[[f64; PAIR]], on: &mut OnProgress<'_>) -> Result<Vec<[f64; 3]>> {
        let double = self.precision == Precision::Double;
        let mut values: Vec<[f64; 3]> = Vec::with_capacity(pairs.len());
        for batch in pairs.chunks(BATCH) {
            let input = upload(gpu, "pairs", batch.as_flattened(), double)?;
            let output = buffer(gpu, "values", 3 * batch.len(), double)?;
            self.run(gpu, &self.evaluate, &[&input, &output], batch.len() as u32, false, on)?;
            values.extend(read(gpu, &output, double)?.as_chunks::<3>().0);
        }
        Ok(values)
    }

    /// The sums of cells of some places.
    pub fn cells(
        &self,
        gpu: &Gpu,
        places: &[[f64; PLACE]],
        cells: &[Cell],
        colored: bool,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<[f64; SUMS]>> {
        let double = self.precision == Precision::Double;
        let places = upload(gpu, "places", places.as_flattened(), double)?;
        let mut sums: Vec<[f64; SUMS]> = Vec::with_capacity(cells.len());
        for batch in cells.chunks(BATCH) {
            let input = gpu.upload("cells", batch)?;
            let output = buffer(gpu, "sums", SUMS * batch.len(), double)?;
            let buffers = [&places, &input, &self.nodes, &output];
            self.run(gpu, &self.cells, &buffers, batch.len() as u32, colored, on)?;
            sums.extend(read(gpu, &output, double)?.as_chunks::<SUMS>().0);
        }
        let evaluations = (NODES * NODES) as f64;
        match sums.iter().find(|s| s[6] != evaluations) {
            None => Ok(sums),
            Some(short) => Err(Error::Gpu {
                op: "integrate".into(),
                detail: format!(
                    "a loop ended after {} of {evaluations} evaluations: this device stops a shader's loops after a number \
                     of steps, and the BRDF's own count too",
                    short[6]
                ),
            }),
        }
    }

    /// Runs a kernel in slices.
    fn run(
        &self,
        gpu: &Gpu,
        kernel: &Kernel,
        buffers: &[&Buffer],
        count: u32,
        colored: bool,
        on: &mut OnProgress<'_>,
    ) -> Result<()> {
        let (mut first, mut slice) = (0, FIRST_SLICE);
        while first < count {
            tick(on, "integrating", f64::from(first) / f64::from(count))?;
            let now = slice.min(count - first).min(MAX_GROUPS * WORKGROUP);
            let start = Instant::now();
            let push = Push { first, count: now, colored: colored.into() };
            gpu.dispatch(kernel, buffers, &push, [now.div_ceil(WORKGROUP), 1, 1])?;
            slice = next_slice(now, start.elapsed(), WORKGROUP);
            first += now;
        }
        Ok(())
    }
}

fn upload(gpu: &Gpu, name: &str, numbers: &[f64], double: bool) -> Result<Buffer> {
    if double {
        return gpu.upload(name, numbers);
    }
    gpu.upload(name, &numbers.iter().map(|x| *x as f32).collect::<Vec<f32>>())
}

fn buffer(gpu: &Gpu, name: &str, numbers: usize, double: bool) -> Result<Buffer> {
    gpu.buffer(name, (numbers * if double { 8 } else { 4 }) as u64)
}

fn read(gpu: &Gpu, buffer: &Buffer, double: bool) -> Result<Vec<f64>> {
    fn all<T: Pod + Into<f64>>(gpu: &Gpu, buffer: &Buffer) -> Result<Vec<f64>> {
        Ok(gpu.read::<T>(buffer)?.into_iter().map(Into::into).collect())
    }
    if double { all::<f64>(gpu, buffer) } else { all::<f32>(gpu, buffer) }
}
