// SPDX-License-Identifier: MIT OR Apache-2.0
//! The preview: spheres under an environment, shaded with baked maps as engines do, and by an integral of the same BRDF.
//!
//! **Split sum.** `prefiltered(r, roughness) · (F0 · scale + bias)` with F0 = mix(0.04, base colour, metallic), less the F82
//! tint of a named metal's edge ([`Sphere::edge`]), and the irradiance over π times the base colour of what is not metal, less what the dielectric's surface reflects
//! ([`crate::term::surface`]). Compensation for multiple scattering multiplies the specular part (Turquin 2019).
//!
//! **Reference.** ∫ f(l, v) L(l) (n·l) dω_l by a lattice of half vectors ([`nodes`]) over the environment that the maps were
//! made from, mip 0 of the cube: no noise, and what is left of the lattice's error is far below what the split sum loses.
//! Diffuse light needs no split: both read an irradiance map. What multiplies the integrals, compensation and the share that
//! the body gets, is the same too.
//!
//! ```
//! use brdf_baker::bake::{Backend, Model};
//! use brdf_baker::progress::ignore;
//! use brdf_baker::spheres::{Given, Maps, Method, Preview, Property, Scene, Sphere, furnace};
//!
//! // White spheres in a white room, with compensation: nothing is to be seen.
//! let (model, room) = (Model::parse("ggx", "smith")?, furnace());
//! let maps = Maps::new(Some(&(&room).into()), Given::default(), &model, 16, &Backend::Cpu, &mut ignore)?;
//! let white = Sphere { base: [1.0; 3], metallic: 0.0, roughness: 0.0, f0: 0.04, edge: [0.0; 3] };
//! let axes = [Some(Property::Metallic), Some(Property::Roughness)];
//! let scene = Scene::grid((48, 48), [3, 3], axes, white)?;
//! let preview = Preview { compensate: true, ..Preview::new(scene, model) };
//! let picture = preview.render(Method::SplitSum, &maps, &Backend::Cpu, &mut ignore)?;
//! assert!(picture.pixels.iter().all(|p| (p[0] - 1.0).abs() < 1e-3));
//! # Ok::<(), brdf_baker::Error>(())
//! ```

mod gpu;
mod lut;
pub(crate) mod maps;
pub mod nodes;
mod parts;
mod picture;
mod pictures;
mod scene;
mod shade;

pub use lut::Lut;
pub use maps::{Given, Maps, SIZE, first_level, furnace, kernel, upright};
pub use picture::{Difference, Picture, Tone};
pub use pictures::{Files, Pictures};
pub(crate) use scene::PARTS;
pub use scene::{MAX_SIZE, MAX_SPHERES, Property, RADIUS, Scene, Seen, Sphere};

use rayon::prelude::*;

use crate::bake::{Backend, Model};
use crate::env::Frame;
use crate::error::{Error, Result};
use crate::progress::{OnProgress, tick};
use crate::rule::h_split::Row;
use nodes::Node;
use shade::Shade;

/// How a picture is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// From the baked maps.
    SplitSum,
    /// By an integral over the BRDF.
    Reference,
}

/// What is to be drawn.
#[derive(Clone)]
pub struct Preview {
    /// The spheres.
    pub scene: Scene,
    /// D and G.
    pub model: Model,
    /// Gives back what single scattering loses.
    pub compensate: bool,
    /// Radiance behind the spheres; `None` shows the environment.
    pub background: Option<f32>,
    /// Half vectors a pixel of the reference.
    pub half_vectors: u32,
    /// Textures.
    pub pictures: Pictures,
    /// How the environment is turned before the viewer, who looks along −Z: from the viewer's directions to the maps'.
    pub frame: Frame,
}

/// Where the reference looks.
struct Lighting {
    /// For every roughness Smith's function and the half vectors.
    rows: Vec<(Row, Vec<Node>)>,
    /// Which of them a sphere has; `None` for a mirror.
    of_sphere: Vec<Option<usize>>,
    /// Which of them evenly spaced roughnesses from 0 to 1 have, where a texture varies the roughness: a point lies between
    /// two.
    lobes: Vec<Option<usize>>,
}

/// Roughnesses that a texture's are interpolated between.
const LOBES: usize = 65;

/// Half vectors a pixel of the reference, unless told otherwise: [`Preview::half_vectors`].
pub const HALF_VECTORS: u32 = 4096;
/// Most of them: eight times as many at a rim, and software Vulkan counts the iterations of a shader to 65,535.
pub const MAX_HALF_VECTORS: u32 = 7680;

impl Preview {
    /// A preview without compensation, in front of the environment.
    pub fn new(scene: Scene, model: Model) -> Preview {
        Preview {
            scene,
            model,
            compensate: false,
            background: None,
            half_vectors: HALF_VECTORS,
            pictures: Pictures::default(),
            frame: Frame::IDENTITY,
        }
    }

    /// Refuses what cannot be drawn.
    pub fn check(&self, method: Method) -> Result<()> {
        if self.model.is_anisotropic() {
            let what = "the spheres are shaded with round lobes, not with an anisotropic distribution";
            return Err(Error::usage(what, "leave ratio and azimuth out of --ndf"));
        }
        if method == Method::Reference && !(1..=MAX_HALF_VECTORS).contains(&self.half_vectors) {
            let what = format!("a pixel cannot be looked at along {} half vectors", self.half_vectors);
            return Err(Error::usage(what, format!("use --samples up to {MAX_HALF_VECTORS}")));
        }
        Ok(())
    }

    /// Draws.
    pub fn render(&self, method: Method, maps: &Maps, backend: &Backend, on: &mut OnProgress<'_>) -> Result<Picture> {
        self.check(method)?;
        if !maps.table.tinted && self.scene.spheres.iter().any(|s| s.edge != [0.0; 3]) {
            let what = "the edge of a named metal is tinted, and the table has no f82 for it";
            return Err(Error::usage(what, "bake it with --channels scale,bias,f82, or give the metal's --base-color"));
        }
        let lighting = match method {
            Method::SplitSum => {
                Lighting { rows: vec![], of_sphere: vec![None; self.scene.spheres.len()], lobes: vec![] }
            }
            Method::Reference => self.lighting(maps),
        };
        let shade = Shade {
            scene: &self.scene,
            maps,
            pictures: &self.pictures,
            visibility: self.model.visibility,
            lighting: &lighting,
            compensate: self.compensate,
            background: self.background,
            frame: self.frame,
            method,
        };
        let picture = match backend {
            Backend::Gpu(gpu) => shade.on_gpu(gpu, on)?,
            Backend::Cpu => self.on_cpu(&shade, on)?,
        };
        if let Some(bad) = picture.pixels.iter().position(|p| p.iter().any(|v| !v.is_finite())) {
            let (x, y) = (bad as u32 % picture.width, bad as u32 / picture.width);
            let detail = format!("pixel ({x}, {y}) is {:?}", picture.pixels[bad]);
            return Err(Error::Gpu { op: "draw the spheres".into(), detail });
        }
        Ok(picture)
    }

    fn on_cpu(&self, shade: &Shade<'_>, on: &mut OnProgress<'_>) -> Result<Picture> {
        /// Rows between two looks at the progress listener.
        const SLICE: u32 = 2;
        let (width, height) = self.scene.size;
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for first in (0..height).step_by(SLICE as usize) {
            tick(on, "spheres", f64::from(first) / f64::from(height))?;
            let slice = first * width..(first + SLICE).min(height) * width;
            pixels.par_extend(slice.into_par_iter().map(|i| shade.pixel(i % width, i / width).map(|v| v as f32)));
        }
        tick(on, "spheres", 1.0)?;
        Ok(Picture { width, height, pixels })
    }

    fn lighting(&self, maps: &Maps) -> Lighting {
        if self.pictures.vary_roughness {
            return self.lighting_of_textures(maps);
        }
        let texel_sr = maps.texel_sr();
        let (mut rows, mut known, mut of_sphere) = (vec![], Vec::<f64>::new(), vec![]);
        for sphere in &self.scene.spheres {
            let Some(lobe) = self.model.ndf.lobe(sphere.roughness) else {
                of_sphere.push(None);
                continue;
            };
            let found = known.iter().position(|r| *r == sphere.roughness).unwrap_or_else(|| {
                let row = Row::new(&self.model.ndf, self.model.visibility, sphere.roughness);
                let nodes = nodes::half_vectors(&self.model.ndf, &lobe, self.half_vectors, texel_sr);
                rows.push((row, nodes));
                known.push(sphere.roughness);
                known.len() - 1
            });
            of_sphere.push(Some(found));
        }
        Lighting { rows, of_sphere, lobes: vec![] }
    }

    /// A point is shaded by two lobes next to its roughness, each with half of the half vectors. The widths of neighbours
    /// differ by less than the filtered environment's mips do.
    fn lighting_of_textures(&self, maps: &Maps) -> Lighting {
        let (mut rows, mut lobes) = (vec![], vec![]);
        for i in 0..LOBES {
            let roughness = i as f64 / (LOBES - 1) as f64;
            lobes.push(self.model.ndf.lobe(roughness).map(|lobe| {
                let row = Row::new(&self.model.ndf, self.model.visibility, roughness);
                let count = self.half_vectors.div_ceil(2);
                rows.push((row, nodes::half_vectors(&self.model.ndf, &lobe, count, maps.texel_sr())));
                rows.len() - 1
            }));
        }
        Lighting { rows, of_sphere: vec![Some(0); self.scene.spheres.len()], lobes }
    }
}
