// SPDX-License-Identifier: MIT OR Apache-2.0
//! Spheres to turn and to change in a browser: one page of HTML that needs nothing else.
//!
//! The page holds the maps as half floats, red, green and blue, with a power of two in front where they exceed what half
//! floats hold. Its shader (`spheres.frag`) is the split sum of [`crate::spheres`] in WebGL 2: the same grid under the same
//! samples of a pixel, the same term for term (`shaders/term/surface.glsl` is part of it), but bilinear and trilinear
//! filtering are left to the GPU, as an engine leaves them. What `brdf-baker preview` draws by the command that the page
//! shows is the same picture.

mod texels;

use serde_json::{Value, json};

use crate::axis::Warp;
use crate::bake::{Backend, Model};
use crate::env::import::Options;
use crate::env::orientation::normalized;
use crate::env::{CubeMap, Environment, Frame};
use crate::error::{Error, Result};
use crate::format::harmonics;
use crate::material::{DIELECTRICS, METALS};
use crate::progress::OnProgress;
use crate::report::{fill, pairs};
use crate::spheres::maps::{cube_job, filtered, first_level, irradiance, split_sum};
use crate::spheres::{Lut, PARTS, Picture, RADIUS, SIZE};
use crate::texture::{Meta, Shape, Texture};
use texels::{cube, table};

const STYLE: [&str; 2] = [include_str!("../report/page.css"), include_str!("view.css")];
const SCRIPTS: [&str; 4] = [
    include_str!("../report/element.js"),
    include_str!("picture.js"),
    include_str!("controls.js"),
    include_str!("view.js"),
];
/// The shader without its first lines, which depend on the table.
const SHADER: [&str; 2] = [include_str!("../../shaders/term/surface.glsl"), include_str!("spheres.frag")];
/// Texels along a side of the cube that shows nine harmonics: between its texels they are within 1e-3 of their mean.
const HARMONICS_SIZE: u32 = 32;
/// Most bytes of a page: beyond, browsers take long to open it, or refuse.
const MOST_BYTES: usize = 128 << 20;

/// Where something on the page comes from.
#[derive(Clone, Debug)]
pub struct Origin {
    /// What the page calls it.
    pub name: String,
    /// What `brdf-baker preview` is told to take the same.
    pub words: Vec<String>,
    /// What its file says of itself.
    pub facts: Meta,
}

/// A filtered environment and its irradiance.
struct Light {
    origin: Origin,
    cube: Texture,
    diffuse: Texture,
    white: bool,
}

/// What a page shows.
#[derive(Default)]
pub struct View {
    lights: Vec<Light>,
    diffuses: Vec<(Origin, Texture)>,
    tables: Vec<(Origin, Lut)>,
}

impl View {
    /// Adds a filtered cube with the axes of [`crate::term::cube`], under an irradiance that is integrated over its mip 0.
    pub fn add_filtered(
        &mut self,
        origin: Origin,
        cube: Texture,
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<()> {
        let source = first_level(&cube);
        let diffuse = irradiance(&(&source).into(), backend, on)?;
        self.lights.push(Light { origin, cube, diffuse, white: false });
        Ok(())
    }

    /// Adds an environment, filtered for `model`.
    pub fn add_environment(
        &mut self,
        origin: Origin,
        environment: &Environment<'_>,
        model: &Model,
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<()> {
        let cube = filtered(environment, model, SIZE, backend, on)?;
        let diffuse = irradiance(environment, backend, on)?;
        self.lights.push(Light { origin, cube, diffuse, white: false });
        Ok(())
    }

    /// Adds white from everywhere, shown without a tone curve: what is not white is lost.
    pub fn add_white_room(
        &mut self,
        origin: Origin,
        room: &Environment<'_>,
        model: &Model,
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<()> {
        let cube = filtered(room, model, 8, backend, on)?;
        // White is white in any map.
        let diffuse = cube.clone();
        self.lights.push(Light { origin, cube, diffuse, white: true });
        Ok(())
    }

    /// Adds a cube of irradiance with the axes of [`crate::term::cube`].
    pub fn add_diffuse(&mut self, origin: Origin, cube: Texture) {
        self.diffuses.push((origin, cube));
    }

    /// Adds a table.
    pub fn add_table(&mut self, origin: Origin, lut: Lut) {
        self.tables.push((origin, lut));
    }

    /// Adds a table that is baked for `model`.
    pub fn add_baked_table(
        &mut self,
        origin: Origin,
        model: &Model,
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<()> {
        let texture = split_sum(model, backend, on)?;
        let lut = Lut::new(&texture)?;
        self.tables.push((Origin { facts: texture.meta, ..origin }, lut));
        Ok(())
    }

    /// The page. `title` is what a browser shows on the tab, `words` are what every command of `brdf-baker preview` needs.
    pub fn page(&self, title: &str, words: &[String]) -> Result<String> {
        let data = json!({
            "title": title,
            "words": words,
            "lights": self.lights.iter().map(|light| self.light(light)).collect::<Result<Vec<_>>>()?,
            "diffuses": self.diffuses.iter().map(|(origin, map)| diffuse(origin, map)).collect::<Result<Vec<_>>>()?,
            "tables": self.tables.iter().map(|(origin, lut)| of_table(origin, lut)).collect::<Result<Vec<_>>>()?,
            "metals": METALS.iter().map(|m| {
                let [f0, edge] = m.f0_and_edge();
                json!({ "name": m.name, "f0": f0, "edge": edge })
            }).collect::<Vec<_>>(),
            "dielectrics": DIELECTRICS.iter().map(|d| json!({ "name": d.name, "f0": d.f0() })).collect::<Vec<_>>(),
            "radius": RADIUS,
            "parts": PARTS,
            "shader": SHADER.concat(),
        });
        let page = fill(title, &STYLE.concat(), &SCRIPTS.concat(), &data);
        if page.len() > MOST_BYTES {
            let what = format!("the page would have {} MB, more than a browser opens with pleasure", page.len() >> 20);
            return Err(Error::usage(what, "give fewer files, or bake the environments with --size 256"));
        }
        Ok(page)
    }

    fn light(&self, light: &Light) -> Result<Value> {
        let job = cube_job(&light.cube)?;
        let roughness: Vec<f64> = (0..job.mips).map(|m| job.alpha(m).sqrt()).collect();
        let mean = first_level(&light.cube).mean();
        let harmonics = of_harmonics(&light.origin.facts)?;
        let exposure = if light.white { 1.0 } else { Picture::auto_exposure(mean) };
        // The irradiance that was baked from the same input lights it unless another is chosen.
        let input = light.origin.facts.get("input");
        let own = self.diffuses.iter().position(|(origin, _)| input.is_some() && origin.facts.get("input") == input);
        Ok(json!({
            "name": light.origin.name,
            "words": light.origin.words,
            "facts": pairs(&light.origin.facts),
            "white": light.white,
            "exposure_ev": exposure.log2(),
            "kernel": job.kernel.name,
            "law": job.law.name(),
            "roughness": roughness,
            "specular": cube(&light.cube)?,
            "diffuse": cube(&light.diffuse)?,
            "harmonics": harmonics.as_ref().map(cube).transpose()?,
            "baked_diffuse": own,
        }))
    }

    /// How many environments, irradiance maps and tables there are.
    pub fn counts(&self) -> [usize; 3] {
        [self.lights.len(), self.diffuses.len(), self.tables.len()]
    }
}

/// The irradiance over π of the nine harmonics that a file states, as a cube with the axes of [`crate::term::cube`].
fn of_harmonics(facts: &Meta) -> Result<Option<Texture>> {
    let Some(stated) = harmonics::stated(facts)? else { return Ok(None) };
    // They are in the file's axes.
    let frame = Frame::IDENTITY.for_file(&Options::from_meta(facts)?.file_axes);
    let map = CubeMap::from_fn(HARMONICS_SIZE, |d| {
        harmonics::at(&stated, normalized(frame.from_picture(d))).map(|v| v.max(0.0) as f32)
    });
    Ok(Some(Texture {
        shape: Shape::Cube,
        width: map.size,
        height: map.size,
        channels: ["r", "g", "b"].map(String::from).to_vec(),
        levels: vec![map.texels.into_flattened()],
        meta: Meta::default(),
    }))
}

fn diffuse(origin: &Origin, map: &Texture) -> Result<Value> {
    Ok(json!({ "name": origin.name, "words": origin.words, "facts": pairs(&origin.facts), "map": cube(map)? }))
}

fn of_table(origin: &Origin, lut: &Lut) -> Result<Value> {
    Ok(json!({
        "name": origin.name,
        "words": origin.words,
        "facts": pairs(&origin.facts),
        "size": [lut.width, lut.height],
        "position": lut.warps.map(Warp::formula),
        "place": lut.place,
        "tinted": lut.tinted,
        "texels": table(lut)?,
    }))
}
