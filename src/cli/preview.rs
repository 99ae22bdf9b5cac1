// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker preview`

use std::path::{Path, PathBuf};
use std::time::Instant;

use brdf_baker::bake::{Backend, Model};
use brdf_baker::env::{Environment, Frame};
use brdf_baker::format::{self, Format, Output};
use brdf_baker::material::{self, Material};
use brdf_baker::plot::{encode_png, write_text};
use brdf_baker::spheres::{
    self, Difference, Files, Given, HALF_VECTORS, MAX_HALF_VECTORS, Maps, Method, Picture, Pictures, Preview, Property,
    RADIUS, Scene, Sphere, Tone,
};
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::Global;
use super::bake::parse_size;
use super::console::Console;
use super::lit::{self, Lit};

/// How many times the difference is amplified in a comparison.
const GAIN: f64 = 8.0;

#[derive(clap::Args)]
pub struct PreviewArgs {
    /// Picture to write: .png, or linear radiance as .exr
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// What lights the spheres: a picture, or a filtered cube [default: the built-in sky with its sun]
    #[arg(long, value_name = "FILE", conflicts_with = "furnace")]
    env: Option<PathBuf>,
    /// Light the spheres with white from everywhere: what is not white is lost
    #[arg(long)]
    furnace: bool,
    /// Turn the environment about the vertical, counter-clockwise seen from above
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, default_value_t = 0.0, hide_default_value = true)]
    rotate: f64,
    /// Look upwards by so many degrees, as if the viewer and the spheres were tilted
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, default_value_t = 0.0, hide_default_value = true)]
    tilt: f64,
    /// A split-sum table [default: baked for --ndf and --visibility]
    #[arg(long, value_name = "FILE")]
    lut: Option<PathBuf>,
    /// An irradiance cube [default: baked]
    #[arg(long, value_name = "FILE")]
    irradiance: Option<PathBuf>,
    /// Pixels; of each of the three panels of --compare
    #[arg(long, default_value = "1280x720", value_name = "WxH", value_parser = parse_size)]
    size: (u32, u32),
    /// What runs to the right and downwards over the spheres, from 0 to 1
    #[arg(long, default_value = "metallic,roughness", value_name = "X,Y", value_delimiter = ',')]
    grid: Vec<String>,
    /// Spheres in a row and in a column
    #[arg(long, default_value = "5x5", value_name = "CxR", value_parser = parse_size)]
    spheres: (u32, u32),
    /// Linear base colour, or a texture of it, sRGB
    #[arg(long, value_name = "R,G,B|FILE", default_value = "0.8,0.6,0.35", conflicts_with = "material")]
    base_color: String,
    /// A named material: a metal's reflectance at normal incidence as the base colour and at 82 degrees as the tint of its
    /// edge, or a dielectric's F0
    #[arg(long, value_name = "NAME")]
    material: Option<String>,
    /// Metallic where it does not run over the grid, or a texture of it: its only channel, or blue
    #[arg(long, value_name = "0..1|FILE", default_value = "0")]
    metallic: String,
    /// Roughness where it does not run over the grid, or a texture of it: its only channel, or green
    #[arg(long, value_name = "0..1|FILE", default_value = "0.5")]
    roughness: String,
    /// Texture of normals in tangent space, green up
    #[arg(long, value_name = "FILE")]
    normal: Option<PathBuf>,
    /// Distribution of normals
    #[arg(long, default_value = "ggx", value_name = "NAME[:PARAMETER=VALUE,...]")]
    ndf: String,
    /// Geometry term
    #[arg(long, default_value = "smith", value_name = "NAME")]
    visibility: String,
    /// Give back what single scattering loses
    #[arg(long)]
    compensate: bool,
    /// Integrate the BRDF instead of reading baked maps
    #[arg(long, conflicts_with = "compare")]
    reference: bool,
    /// Draw both, and their difference: orange where the maps are too bright, blue where they are too dark
    #[arg(long)]
    compare: bool,
    /// Half vectors a pixel of the reference
    #[arg(long, default_value_t = HALF_VECTORS, value_name = "N")]
    samples: u32,
    /// Multiply by 2 to this power [default: so that the mean of the environment is a middle grey; 0 in .exr]
    #[arg(long, value_name = "EV", allow_hyphen_values = true)]
    exposure: Option<f64>,
    /// Tone curve of a .png [default: aces; clip with --furnace]
    #[arg(long, value_name = "aces|clip")]
    tone: Option<String>,
    /// What is behind the spheres: the environment out of focus, or a grey of this radiance
    #[arg(long, default_value = "env", value_name = "env|GREY")]
    background: String,
}

/// A number, or the path of a texture.
enum Value {
    Number(f64),
    File(PathBuf),
}

impl Value {
    fn parse(flag: &str, text: &str) -> Result<Value> {
        match text.parse::<f64>() {
            Ok(number) if (0.0..=1.0).contains(&number) => Ok(Value::Number(number)),
            Ok(number) => {
                Err(Error::usage(format!("{flag} cannot be {number}"), "give a number from 0 to 1, or a file"))
            }
            Err(_) => Ok(Value::File(text.into())),
        }
    }

    /// The number, and the file; the factor of a texture is 1.
    fn split(&self) -> (f64, Option<&Path>) {
        match self {
            Value::Number(number) => (*number, None),
            Value::File(path) => (1.0, Some(path)),
        }
    }
}

impl PreviewArgs {
    pub fn run(self, global: &Global, console: &mut Console) -> Result<()> {
        let start = Instant::now();

        // Everything that can be refused is refused before any work.
        let linear = match self.output.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
            Some("png") => false,
            Some("exr") if self.compare => {
                return Err(Error::usage("--compare draws a picture to look at", "write a .png file"));
            }
            Some("exr") => true,
            _ => {
                let what = format!("'{}' is not named like a picture of spheres", self.output.display());
                return Err(Error::usage(what, "write a .png or .exr file"));
            }
        };
        // A furnace shows what is lost, not what a film would make of it.
        let usual = if self.furnace { Tone::Clip } else { Tone::Aces };
        let tone = self.tone.as_deref().map_or(Ok(usual), Tone::parse)?;
        let background = match self.background.as_str() {
            "env" => None,
            text => Some(text.parse::<f32>().ok().filter(|v| (0.0..=1e6).contains(v)).ok_or_else(|| {
                Error::usage(format!("--background cannot be '{text}'"), "say env, or give a radiance, e.g. 0.1")
            })?),
        };
        if !(64..=MAX_HALF_VECTORS).contains(&self.samples) {
            let what = format!("--samples cannot be {}", self.samples);
            return Err(Error::usage(what, format!("give a number from 64 to {MAX_HALF_VECTORS}")));
        }
        if self.exposure.is_some_and(|e| !(-100.0..=100.0).contains(&e)) {
            return Err(Error::usage("--exposure is out of range", "give a number from -100 to 100"));
        }
        let metallic = Value::parse("--metallic", &self.metallic)?;
        let roughness = Value::parse("--roughness", &self.roughness)?;
        let base = base_color(&self.base_color)?;
        let (sphere, base_file) = sphere(&base, self.material.as_deref(), metallic.split().0, roughness.split().0)?;
        let axes = match &self.grid[..] {
            [x, y] if x != y => [Some(Property::parse(x)?), Some(Property::parse(y)?)],
            other => {
                let what = format!("--grid got '{}'", other.join(","));
                return Err(Error::usage(what, "name two properties, e.g. metallic,roughness"));
            }
        };
        let scene = Scene::grid(self.size, [self.spheres.0, self.spheres.1], axes, sphere)?;
        // A single column or row has the property's own value.
        let scene = fixed(scene, axes, &sphere, self.spheres);
        let model = Model::parse(&self.ndf, &self.visibility)?;
        let files = Files {
            base_color: base_file,
            metallic: metallic.split().1,
            roughness: roughness.split().1,
            normal: self.normal.as_deref(),
        };
        let pictures = Pictures::read(&files, RADIUS * scene.tile_px())?;
        let preview = Preview {
            compensate: self.compensate,
            background,
            half_vectors: self.samples,
            pictures,
            frame: frame(self.rotate, self.tilt)?,
            ..Preview::new(scene, model)
        };
        let methods: &[Method] = match (self.compare, self.reference) {
            (true, _) => &[Method::SplitSum, Method::Reference],
            (_, true) => &[Method::Reference],
            _ => &[Method::SplitSum],
        };
        methods.iter().try_for_each(|m| preview.check(*m))?;
        let output = Output::prepare(&self.output)?;
        let light = self.light(console)?;
        let table = self.lut.as_ref().map(|path| lit::table(path, console)).transpose()?;
        let diffuse = self.irradiance.as_ref().map(|path| lit::diffuse(path, console)).transpose()?;
        let filter = spheres::kernel(&preview.model);
        if filter != preview.model.ndf.family.name && light.cube.is_none() {
            let name = preview.model.ndf.family.name;
            console.warn(&format!("no filter kernel is made for {name}: the maps are filtered with {filter}'s"));
        }

        let backend = Backend::open(&global.device, global.validate)?;
        let given = Given { table: table.as_ref(), specular: light.cube.as_ref(), diffuse: diffuse.as_ref() };
        let on = &mut |p: brdf_baker::progress::Progress<'_>| console.progress(p);
        let maps = Maps::new(light.environment.as_ref(), given, &preview.model, spheres::SIZE, &backend, on)?;
        let drawn: Vec<Picture> =
            methods.iter().map(|m| preview.render(*m, &maps, &backend, on)).collect::<Result<_>>()?;
        backend.check_messages()?;

        let auto = if self.furnace { 1.0 } else { Picture::auto_exposure(maps.mean()) };
        let exposure = self.exposure.map_or(if linear { 1.0 } else { auto }, f64::exp2);
        let differences = match &drawn[..] {
            [split_sum, reference] => split_sum.differences(reference, &preview.scene),
            _ => vec![],
        };
        let bytes = match (&drawn[..], linear) {
            ([split_sum, reference], _) => side_by_side(split_sum, reference, exposure, tone)?,
            ([picture, ..], false) => encode_png(&picture.to_srgb(exposure, tone), self.size)?,
            ([picture, ..], true) => exr(&self.output, picture, exposure)?,
            ([], _) => unreachable!("there is at least one method"),
        };
        let size = output.commit_bytes(&bytes)?;

        let seconds = start.elapsed().as_secs_f64();
        let ev = exposure.log2();
        let method = if self.compare {
            "split sum and reference"
        } else if self.reference {
            "reference"
        } else {
            "split sum"
        };
        let count = preview.scene.spheres.len();
        let mut text = format!(
            "{}  {}x{}, {count} spheres  {method}, {} {}, filtered with {}, exposure {ev:+.2}  {seconds:.2} s  {}",
            self.output.display(),
            self.size.0,
            self.size.1,
            preview.model.ndf,
            preview.model.visibility.name,
            maps.kernel,
            backend.name()
        );
        if !differences.is_empty() {
            text.push_str(&rows_of(&differences, preview.scene.columns as usize));
        }
        let of_spheres: Vec<_> = preview
            .scene
            .spheres
            .iter()
            .enumerate()
            .map(|(i, s)| {
                let d = differences.get(i);
                json!({
                    "metallic": s.metallic,
                    "roughness": s.roughness,
                    "rms": d.map(|d| d.rms),
                    "bias": d.map(|d| d.bias),
                    "pixels": d.map(|d| d.pixels),
                })
            })
            .collect();
        console.result(
            &text,
            &json!({
                "path": self.output,
                "width": self.size.0,
                "height": self.size.1,
                "method": method,
                "ndf": preview.model.ndf.to_string(),
                "visibility": preview.model.visibility.name,
                "kernel": maps.kernel,
                "compensate": self.compensate,
                "exposure_ev": ev,
                "spheres": of_spheres,
                "bytes": size,
                "longest_dispatch_ms": backend.longest_dispatch_ms(),
                "seconds": seconds,
                "device": backend.name(),
            }),
        )
    }

    /// What lights the spheres.
    fn light(&self, console: &mut Console) -> Result<Light> {
        let light = |environment| Ok(Light { environment: Some(environment), cube: None });
        match &self.env {
            _ if self.furnace => light(lit::white_room()),
            None => light(lit::sky()?),
            Some(path) => match lit::read(path, console)? {
                Lit::Environment(environment) => light(environment),
                Lit::Filtered(cube) => Ok(Light { environment: None, cube: Some(cube) }),
                Lit::Diffuse(_) => Err(Error::input(path, "it holds irradiance alone", "give it to --irradiance")),
                Lit::Table(..) => Err(Error::input(path, "it holds a table, not light", "give it to --lut")),
            },
        }
    }
}

/// An environment, or a cube that was filtered before.
struct Light {
    environment: Option<Environment<'static>>,
    cube: Option<Texture>,
}

/// From the directions of a viewer who looks up by `tilt_deg` to those of an environment that is turned by `rotate_deg`.
fn frame(rotate_deg: f64, tilt_deg: f64) -> Result<Frame> {
    if let Some((flag, bad)) = [("--rotate", rotate_deg), ("--tilt", tilt_deg)].iter().find(|(_, v)| !v.is_finite()) {
        return Err(Error::usage(format!("{flag} cannot be {bad}"), "give a number of degrees"));
    }
    Ok(Frame::new(false, [0.0, rotate_deg, 0.0]).seen_through(&Frame::new(false, [-tilt_deg, 0.0, 0.0])))
}

/// Linear red, green and blue, or the path of a texture.
fn base_color(text: &str) -> Result<(Option<[f64; 3]>, PathBuf)> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        None => Ok((None, text.into())),
        Some([r, g, b]) if [r, g, b].iter().all(|v| (0.0..=1.0).contains(*v)) => {
            Ok((Some([*r, *g, *b]), PathBuf::new()))
        }
        Some(_) => {
            let what = format!("--base-color cannot be {text}");
            Err(Error::usage(what, "give red,green,blue from 0 to 1, linear, or a file"))
        }
    }
}

/// The sphere that all are like, and its texture of base colour.
fn sphere<'a>(
    (base, file): &'a (Option<[f64; 3]>, PathBuf),
    material: Option<&str>,
    metallic: f64,
    roughness: f64,
) -> Result<(Sphere, Option<&'a Path>)> {
    let plain = Sphere { base: base.unwrap_or([1.0; 3]), metallic, roughness, f0: 0.04, edge: [0.0; 3] };
    let found = match material.map(material::parse).transpose()? {
        None => return Ok((plain, base.is_none().then_some(file))),
        Some(Material::Metal(m)) => {
            let [base, edge] = m.f0_and_edge();
            Sphere { base, edge, ..plain }
        }
        Some(Material::Dielectric(d)) => Sphere { base: [0.5; 3], f0: d.f0(), ..plain },
    };
    Ok((found, None))
}

/// Where the grid has one column or one row, nothing runs along it.
fn fixed(mut scene: Scene, axes: [Option<Property>; 2], sphere: &Sphere, (columns, rows): (u32, u32)) -> Scene {
    for (axis, count) in axes.into_iter().zip([columns, rows]).filter(|(_, count)| *count == 1) {
        debug_assert_eq!(count, 1);
        for s in &mut scene.spheres {
            match axis {
                Some(Property::Metallic) => s.metallic = sphere.metallic,
                Some(Property::Roughness) => s.roughness = sphere.roughness,
                None => {}
            }
        }
    }
    scene
}

/// The rms of all spheres as they stand.
fn rows_of(differences: &[Difference], columns: usize) -> String {
    let mut text = "\n  rms of the difference over the reference's rms, sphere by sphere:".to_string();
    for row in differences.chunks(columns) {
        let cells: Vec<String> = row.iter().map(|d| format!("{:6.2} %", 100.0 * d.rms)).collect();
        text.push_str(&format!("\n  {}", cells.join("  ")));
    }
    text
}

/// Three panels: split sum, reference, difference.
fn side_by_side(split_sum: &Picture, reference: &Picture, exposure: f64, tone: Tone) -> Result<Vec<u8>> {
    const GAP: u32 = 4;
    let (width, height) = (split_sum.width, split_sum.height);
    let size = (3 * width + 2 * GAP, height);
    let mut rgb = vec![24u8; (3 * size.0 * size.1) as usize];
    let panels = [
        (split_sum.to_srgb(exposure, tone), "split sum".to_string()),
        (reference.to_srgb(exposure, tone), "reference".to_string()),
        (split_sum.difference_srgb(reference, exposure, GAIN), format!("split sum - reference, x {GAIN}")),
    ];
    for (i, (pixels, label)) in panels.iter().enumerate() {
        let left = i as u32 * (width + GAP);
        for (y, row) in pixels.chunks_exact(3 * width as usize).enumerate() {
            let at = 3 * (y * size.0 as usize + left as usize);
            rgb[at..at + row.len()].copy_from_slice(row);
        }
        let text_px = (f64::from(height) / 30.0).clamp(11.0, 22.0);
        write_text(&mut rgb, size, (left as i32 + 6, 4), text_px, label)?;
    }
    encode_png(&rgb, size)
}

/// Linear radiance as half floats.
fn exr(path: &Path, picture: &Picture, exposure: f64) -> Result<Vec<u8>> {
    let texels = picture.pixels.iter().flat_map(|p| [p[0], p[1], p[2]].map(|v| v * exposure as f32));
    let mut meta = Meta::default();
    meta.set("picture", "spheres, linear radiance");
    meta.set("exposure", format!("2^{:.4}", exposure.log2()));
    meta.set("version", env!("CARGO_PKG_VERSION"));
    let texture = Texture {
        shape: Shape::Table,
        width: picture.width,
        height: picture.height,
        channels: ["r", "g", "b"].map(String::from).to_vec(),
        levels: vec![texels.collect()],
        meta,
    };
    let encoding = format::choose(&format::Exr, Shape::Table, 3, None)?;
    format::Exr.to_bytes(path, &texture, encoding.into())
}
