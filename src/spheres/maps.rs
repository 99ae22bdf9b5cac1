// SPDX-License-Identifier: MIT OR Apache-2.0
//! The maps that spheres are shaded with: a filtered environment, an irradiance map, a split-sum table, and the environment
//! itself with averages of four texels, of sixteen, and so on.

use super::Method;
use super::lut::Lut;
use crate::axis::Points;
use crate::bake::specular::{SpecularJob, SpecularRequest};
use crate::bake::{Backend, Model, TableRequest};
use crate::env::import::Options;
use crate::env::{CubeMap, Environment, FileAxes, Frame, orientation};
use crate::error::{Error, Result};
use crate::progress::OnProgress;
use crate::term::cube::{direction, locate};
use crate::term::zonal::ZONALS;
use crate::texture::{Shape, Texture};

/// Texels along a side of the irradiance map that is baked: read between texels it is within 1e-4 of the integral.
const DIFFUSE_SIZE: u32 = 64;
/// Texels along a side of the last mip of a cube that is baked: the corners of one texel would show.
const LAST: u32 = 8;
/// Texels along a side of the cube that is baked, unless told otherwise.
pub const SIZE: u32 = 256;

/// A face of every level of a cube, with a border of one texel that repeats its neighbours, and in the cube's corners, where
/// three faces meet, the mean of their texels there, as GPUs take it: bilinear reading then has no seams.
#[derive(Clone, Debug, Default)]
pub(super) struct Levels {
    /// Red, green, blue and nothing.
    pub texels: Vec<[f32; 4]>,
    /// First texel, texels along a side without the border, roughness.
    pub levels: Vec<(u32, u32, f32)>,
}

impl Levels {
    /// Adds a level of `size` × `size` texels a face, RGB.
    fn push(&mut self, size: u32, texels: &[[f32; 3]], roughness: f64) {
        self.levels.push((self.texels.len() as u32, size, roughness as f32));
        let (n, last) = (f64::from(size), f64::from(size - 1));
        let inside = 1..=size;
        // The middle of a texel of the border lies beyond the edge; there is another texel really.
        let centre = |i: u32| (2.0 * f64::from(i) - 1.0) / n - 1.0;
        let at = |face: u32, x: u32, y: u32| {
            let (s, t) = (centre(x), centre(y));
            let (face, s, t) = match inside.contains(&x) && inside.contains(&y) {
                true => (face, s, t),
                false => locate(direction(face, s, t)),
            };
            let nearest = |c: f64| (0.5 * (c + 1.0) * n).floor().clamp(0.0, last) as u32;
            texels[((face * size + nearest(t)) * size + nearest(s)) as usize]
        };
        for face in 0..6 {
            for y in 0..size + 2 {
                for x in 0..size + 2 {
                    let [r, g, b] = if inside.contains(&x) || inside.contains(&y) {
                        at(face, x, y)
                    } else {
                        let (within_x, within_y) = (x.clamp(1, size), y.clamp(1, size));
                        let three = [at(face, within_x, within_y), at(face, x, within_y), at(face, within_x, y)];
                        [0, 1, 2].map(|c| three.iter().map(|texel| texel[c]).sum::<f32>() / 3.0)
                    };
                    self.texels.push([r, g, b, 0.0]);
                }
            }
        }
    }
}

/// What the spheres are shaded with.
#[derive(Clone, Debug)]
pub struct Maps {
    /// All levels: the filtered ones, the irradiance, the environment itself.
    pub(super) levels: Levels,
    /// Filtered levels.
    pub(super) mips: u32,
    /// First level of the environment itself.
    pub(super) source_level: u32,
    /// The table of the split sum.
    pub(super) table: Lut,
    /// Radiance of the environment by direction: its first level.
    pub(super) source: CubeMap,
    /// What the filtered levels are made with.
    pub kernel: String,
}

/// Files that are used in place of what would be baked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given<'a> {
    /// A split-sum table.
    pub table: Option<&'a Lut>,
    /// A filtered cube.
    pub specular: Option<&'a Texture>,
    /// An irradiance cube.
    pub diffuse: Option<&'a Texture>,
}

impl Maps {
    /// Bakes what is not given: with `environment`, or with mip 0 of the given cube as the environment. `size` is that of the
    /// cube that is baked, a power of two; [`SIZE`] is usual.
    pub fn new(
        environment: Option<&Environment<'_>>,
        given: Given<'_>,
        model: &Model,
        size: u32,
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Maps> {
        let specular = match (given.specular, environment) {
            (Some(cube), _) => cube.clone(),
            (None, Some(environment)) => filtered(environment, model, size, backend, on)?,
            (None, None) => return Err(Error::usage("the spheres need light", "give --env, or leave it out")),
        };
        let job = cube_job(&specular)?;
        let source = first_level(&specular);
        let light = environment.map_or_else(|| Environment::from(&source), Environment::borrowed);
        let irradiance = irradiance(&light, backend, on)?;
        let kernel = given.diffuse.map(cube_job).transpose()?.map(|job| job.kernel);
        if let Some(kernel) = kernel.filter(|k| k.least_alpha.is_some()) {
            let what = format!("an irradiance map is filtered with lambert, not with {}", kernel.name);
            return Err(Error::usage(what, "bake one with `brdf-baker env --irradiance FILE`"));
        }
        let table = match given.table {
            Some(table) => table.clone(),
            None => Lut::new(&split_sum(model, backend, on)?)?,
        };

        let mut levels = Levels::default();
        for m in 0..specular.levels.len() {
            let texels = rgb(&specular, m);
            levels.push(specular.level_size(m).0, &texels, job.alpha(m as u32).sqrt());
        }
        levels.push(irradiance.width, &rgb(&irradiance, 0), 1.0);
        if let Some(given) = given.diffuse {
            levels.push(given.width, &rgb(given, 0), 1.0);
        }
        let source_level = levels.levels.len() as u32;
        let mut average = source.clone();
        loop {
            levels.push(average.size, &average.texels, 0.0);
            if !average.size.is_multiple_of(2) {
                break;
            }
            average = halved(&average);
        }
        let mips = specular.levels.len() as u32;
        let kernel = job.kernel.name.into();
        Ok(Maps { levels, mips, source_level, table, source, kernel })
    }

    /// Mean radiance of the environment.
    pub fn mean(&self) -> [f64; 3] {
        self.source.mean()
    }

    /// The number of the irradiance map among the levels: the one to use, or the exact one that was baked from the same light.
    pub(super) fn diffuse_level(&self, method: Method) -> u32 {
        match method {
            Method::SplitSum => self.source_level - 1,
            Method::Reference => self.mips,
        }
    }

    /// How many levels the environment itself has.
    pub(super) fn source_levels(&self) -> u32 {
        self.levels.levels.len() as u32 - self.source_level
    }

    /// Mean solid angle of the environment's texels.
    pub(super) fn texel_sr(&self) -> f64 {
        4.0 * std::f64::consts::PI / (6.0 * f64::from(self.source.size).powi(2))
    }
}

/// The filter kernel of the model's own distribution; GGX's where none is made for it.
pub fn kernel(model: &Model) -> &'static str {
    ZONALS.iter().map(|k| k.name).find(|name| *name == model.ndf.family.name).unwrap_or("ggx")
}

/// An environment filtered for the spheres, `size` texels along a side of mip 0.
pub(crate) fn filtered(
    environment: &Environment<'_>,
    model: &Model,
    size: u32,
    backend: &Backend,
    on: &mut OnProgress<'_>,
) -> Result<Texture> {
    let request = SpecularRequest {
        kernel: kernel(model).into(),
        size: Some(size),
        mips: Some((size / LAST).max(1).ilog2() + 1),
        ..Default::default()
    };
    request.resolve()?.run(environment, backend, on)
}

/// Its irradiance over π.
pub(crate) fn irradiance(environment: &Environment<'_>, backend: &Backend, on: &mut OnProgress<'_>) -> Result<Texture> {
    let request = SpecularRequest { kernel: "lambert".into(), size: Some(DIFFUSE_SIZE), ..Default::default() };
    request.resolve()?.run(environment, backend, on)
}

/// Scale, bias and tint of a model.
pub(crate) fn split_sum(model: &Model, backend: &Backend, on: &mut OnProgress<'_>) -> Result<Texture> {
    // With the values at both ends, where there are any: nothing is read beyond the last texel.
    let points = if model.check_limits(true, true).is_ok() { Points::Edges } else { Points::Centers };
    let request = TableRequest {
        points,
        ndf: model.ndf.to_string(),
        visibility: model.visibility.name.into(),
        channels: Some(["scale", "bias", "f82"].map(String::from).to_vec()),
        ..TableRequest::new("split-sum")
    };
    request.resolve()?.run(backend, on)
}

/// The job behind a cube that this program wrote.
pub(crate) fn cube_job(texture: &Texture) -> Result<SpecularJob> {
    if texture.shape != Shape::Cube {
        return Err(Error::usage("the spheres are lit by cubes, and this is none", "bake it with --shape cube"));
    }
    SpecularJob::from_meta(texture)
}

/// The texels of a level as RGB.
pub(crate) fn rgb(texture: &Texture, level: usize) -> Vec<[f32; 3]> {
    texture.levels[level].chunks_exact(texture.channels.len()).map(|t| [t[0], t[1], t[2]]).collect()
}

/// A cube of a file whose axes point elsewhere ([`crate::env::FileAxes`]), with the axes of [`crate::term::cube`]: the same
/// texels in another order.
pub fn upright(mut cube: Texture) -> Result<Texture> {
    let axes = Options::from_meta(&cube.meta)?.file_axes;
    if axes == FileAxes::IDENTITY {
        return Ok(cube);
    }
    let frame = Frame::IDENTITY.for_file(&axes);
    for m in 0..cube.levels.len() {
        let size = cube.level_size(m).0;
        let mut level = Vec::with_capacity(cube.levels[m].len());
        for i in 0..6 * size * size {
            let (s, t) = orientation::centre(i % size, i / size % size, size);
            let (face, s, t) = locate(frame.from_picture(direction(i / (size * size), s, t)));
            let at = |c: f64| (0.5 * (c + 1.0) * f64::from(size)) as u32;
            level.extend_from_slice(cube.texel(m, face, at(s), at(t)));
        }
        cube.levels[m] = level;
    }
    Ok(cube)
}

/// Mip 0 of a cube, as an environment.
pub fn first_level(texture: &Texture) -> CubeMap {
    CubeMap { size: texture.width, texels: rgb(texture, 0) }
}

/// Half as many texels along a side, each the mean over its solid angle.
fn halved(cube: &CubeMap) -> CubeMap {
    let size = cube.size / 2;
    let weights = CubeMap::solid_angles_sr(cube.size);
    let mut texels = Vec::with_capacity((6 * size * size) as usize);
    for face in 0..6 {
        for y in 0..size {
            for x in 0..size {
                let (mut sum, mut whole) = ([0.0; 3], 0.0);
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (x, y) = (2 * x + dx, 2 * y + dy);
                    let weight = weights[(y * cube.size + x) as usize];
                    let texel = cube.texel(face, x, y);
                    (0..3).for_each(|c| sum[c] += weight * f64::from(texel[c]));
                    whole += weight;
                }
                texels.push(sum.map(|s| (s / whole) as f32));
            }
        }
    }
    CubeMap { size, texels }
}

/// White from everywhere.
pub fn furnace() -> CubeMap {
    CubeMap::from_fn(16, |_| [1.0; 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_are_the_neighbours_and_corners_their_mean() {
        // Face f holds f everywhere.
        let texels: Vec<[f32; 3]> = (0..6 * 4).map(|i| [(i / 4) as f32; 3]).collect();
        let mut levels = Levels::default();
        levels.push(2, &texels, 0.0);
        let at = |face: u32, x: u32, y: u32| levels.texels[((face * 4 + y) * 4 + x) as usize][0];
        // +Z has −X to the left, +X to the right, +Y above.
        assert_eq!([at(4, 1, 1), at(4, 0, 1), at(4, 3, 2), at(4, 1, 0)], [4.0, 1.0, 0.0, 2.0]);
        assert_eq!([at(4, 0, 0), at(4, 3, 3)], [(4.0 + 1.0 + 2.0) / 3.0, (4.0 + 0.0 + 3.0) / 3.0]);
    }
}
