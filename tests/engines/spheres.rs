// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the tests of engines share: the scene, the environments, and the comparison with the f64 reference.
//!
//! ```text
//! spheres prepare FOLDER                     writes sky.exr, lights.exr, spheres.json, lights.json
//! spheres compare FOLDER --formula NAME ...  pictures of spheres.json against the reference
//! spheres alike NAME PICTURE OTHER           two pictures of spheres.json against each other
//! spheres lights NAME PICTURE ...            is every light of lights.exr where it belongs?
//! ```
//!
//! Pictures are raw: red, green, blue, alpha as little-endian f32, rows from the top.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use brdf_baker::env::import::{self, Options};
use brdf_baker::env::{Equirect, FileAxes};
use brdf_baker::error::{Error, Result};
use brdf_baker::progress::ignore;
use brdf_baker::verify::engine::{Formula, Light, Point, RADIUS, Scene, shade};
use clap::{Parser, Subcommand};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use serde_json::json;

/// Pixels along a side of a tile.
const TILE_PX: u32 = 192;
/// Every so many pixels are compared, in both directions: it shares no factor with the size of a cube's texels on screen.
const STRIDE: u32 = 9;
/// How much nearer to the reference the engine's own maps may be by accident: errors of interpolation in both, which cancel
/// others here and there.
const SLACK: f64 = 2e-4;
/// Rows of the environments.
const HEIGHT: u32 = 512;
/// Cosine of a light's half angle, 35°.
const LIGHT_COS: f64 = 0.82;

/// The lights: where they are, and their colours.
const LIGHTS: [(&str, [f64; 3], &str, [f32; 3]); 6] = [
    ("+X", [1.0, 0.0, 0.0], "red", [1.0, 0.0, 0.0]),
    ("-X", [-1.0, 0.0, 0.0], "cyan", [0.0, 1.0, 1.0]),
    ("+Y", [0.0, 1.0, 0.0], "green", [0.0, 1.0, 0.0]),
    ("-Y", [0.0, -1.0, 0.0], "magenta", [1.0, 0.0, 1.0]),
    ("+Z", [0.0, 0.0, 1.0], "blue", [0.0, 0.0, 1.0]),
    ("-Z", [0.0, 0.0, -1.0], "yellow", [1.0, 1.0, 0.0]),
];

#[derive(Parser)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write scenes and environments
    Prepare { folder: PathBuf },
    /// Compare pictures of spheres.json with the reference: the first one must be within the bound and nearer than the second
    Compare {
        /// What `prepare` wrote
        folder: PathBuf,
        /// The engine's formula
        #[arg(long)]
        formula: String,
        /// Environment, where it is not the folder's sky
        #[arg(long)]
        source: Option<PathBuf>,
        /// Largest rms of a sphere, relative to its mean
        #[arg(long, default_value_t = 0.02)]
        bound: f64,
        /// The second picture's mips lie at other roughnesses: compare with it by what is left against exact mips
        #[arg(long)]
        other_mips: bool,
        /// Also draw the first picture
        #[arg(long)]
        png: Option<PathBuf>,
        /// NAME@MIPS=PICTURE
        #[arg(required = true)]
        pictures: Vec<String>,
    },
    /// Compare two pictures of spheres.json with each other
    Alike {
        /// What to call them
        name: String,
        /// The one that is looked at
        picture: PathBuf,
        /// The one that it should be like
        other: PathBuf,
        /// Largest rms of a sphere, relative to its mean
        #[arg(long, default_value_t = 0.02)]
        bound: f64,
    },
    /// Look for the lights in a picture of lights.json
    Lights {
        /// What to call the engine
        name: String,
        /// Its picture
        picture: PathBuf,
        /// What it shows behind the scene along +X, -X, +Y, -Y, +Z, -Z: one pixel each
        #[arg(long)]
        background: Option<PathBuf>,
        /// What the picture's right, up and viewer show of the environment, where an engine turns it
        #[arg(long, default_value = "x,y,z", value_name = "X,Y,Z")]
        shows: String,
        /// Also draw it
        #[arg(long)]
        png: Option<PathBuf>,
    },
}

fn main() -> ExitCode {
    let done = match Args::parse().command {
        Command::Prepare { folder } => prepare(&folder).map(|()| true),
        Command::Compare { folder, formula, source, bound, other_mips, png, pictures } => {
            compare(source.unwrap_or(folder.join("sky.exr")), &formula, bound, other_mips, png, &pictures)
        }
        Command::Alike { name, picture, other, bound } => alike(&name, &picture, &other, bound),
        Command::Lights { name, picture, background, shows, png } => {
            FileAxes::parse(&shows).and_then(|axes| lights(&name, &picture, background, &axes, png))
        }
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}\n  help: {}", error.help());
            ExitCode::from(2)
        }
    }
}

// ------------------------------------------------------------------------------------------------ scenes and environments

fn prepare(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    write_exr(&folder.join("sky.exr"), sky)?;
    write_exr(&folder.join("lights.exr"), six_lights)?;
    for (name, scene) in [("spheres", Scene::spheres(TILE_PX)), ("lights", Scene::lights(TILE_PX))] {
        let path = folder.join(format!("{name}.json"));
        let (width, height) = scene.size_px();
        let spheres: Vec<_> = (0..scene.spheres.len())
            .map(|i| {
                let (sphere, centre) = (&scene.spheres[i], scene.centre(i));
                let metallic = f64::from(u8::from(sphere.metallic));
                json!({ "centre": centre, "colour": sphere.colour, "metallic": metallic, "roughness": sphere.roughness })
            })
            .collect();
        let tiles = [scene.columns, scene.rows()];
        let text = json!({ "size_px": [width, height], "tiles": tiles, "radius": RADIUS, "spheres": spheres });
        std::fs::write(&path, format!("{text:#}\n")).map_err(|e| Error::io("write", &path, e))?;
    }
    Ok(())
}

fn write_exr(path: &Path, radiance: fn([f64; 3]) -> [f32; 3]) -> Result<()> {
    let picture = Equirect::from_fn(HEIGHT, |u, v| radiance(Equirect::direction(u, v)));
    let texel = |x: usize, y: usize| {
        let [r, g, b] = picture.texels[y * picture.width as usize + x];
        (r, g, b)
    };
    exr::prelude::write_rgb_file(path, picture.width as usize, picture.height as usize, texel)
        .map_err(|e| Error::input(path, e.to_string(), "choose another folder"))
}

/// A sky with a soft sun, a bright horizon, and ground in two colours: nothing is symmetric, nothing is sharper than a few
/// texels, so that what is measured is not the sampling of edges.
fn sky([x, y, z]: [f64; 3]) -> [f32; 3] {
    let lobe = |d: [f64; 3], sharpness: f64| {
        let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        (sharpness * ((x * d[0] + y * d[1] + z * d[2]) / length - 1.0)).exp()
    };
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t);
    let ground = mix([0.30, 0.16, 0.08], [0.06, 0.22, 0.10], smooth(0.0, 0.35, x - 0.5 * z));
    let zenith = mix([0.8, 0.85, 0.9], [0.10, 0.25, 0.7], y.max(0.0).sqrt());
    let base = mix(ground, zenith, smooth(0.0, 0.3, y));
    // A sun of some 10°, a window to the left, a lamp behind the camera.
    let (sun, window, lamp) =
        (lobe([0.6, 0.7, 0.5], 150.0), lobe([-1.0, 0.2, 0.3], 60.0), lobe([0.2, -0.3, 1.0], 30.0));
    [
        base[0] + 2.5 * sun + 2.0 * window + 0.8 * lamp,
        base[1] + 2.1 * sun + 3.0 * window + 0.2 * lamp,
        base[2] + 1.5 * sun + 4.0 * window + 0.6 * lamp,
    ]
    .map(|v| v as f32)
}

/// Grey, and a round light of another colour around each axis, with a soft edge.
fn six_lights(d: [f64; 3]) -> [f32; 3] {
    let mut sum = [0.05f32; 3];
    for (_, axis, _, colour) in LIGHTS {
        let along = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
        let share = smooth(LIGHT_COS, 0.1, along) as f32;
        (0..3).for_each(|c| sum[c] += share * colour[c]);
    }
    sum
}

/// 0 to 1 as `at` passes through `edge`, over `width`.
fn smooth(edge: f64, width: f64, at: f64) -> f64 {
    let t = ((at - edge) / width + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

// ------------------------------------------------------------------------------------------------------------ comparison

/// An engine's picture.
struct Picture {
    width: u32,
    height: u32,
    texels: Vec<[f32; 4]>,
}

impl Picture {
    fn read(path: &Path, (width, height): (u32, u32)) -> Result<Picture> {
        let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
        if bytes.len() != 16 * width as usize * height as usize {
            let what = format!("it has {} bytes, not those of {width}x{height} pixels", bytes.len());
            return Err(Error::input(path, what, "write four little-endian f32 a pixel"));
        }
        let float = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
        let texels = bytes.chunks_exact(16).map(|t| [0, 4, 8, 12].map(|i| float(&t[i..i + 4])));
        Ok(Picture { width, height, texels: texels.collect() })
    }

    fn at(&self, [x, y]: [u32; 2]) -> [f64; 3] {
        let [r, g, b, _] = self.texels[(y * self.width + x) as usize];
        [r, g, b].map(f64::from)
    }

    /// A picture to look at, half as large: exposed so that 1 is nearly white, as sRGB.
    fn draw(&self, path: &Path) -> Result<()> {
        let srgb = |v: f64| {
            let v = 1.0 - (-1.5 * v.max(0.0)).exp();
            let v = if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
            (255.0 * v + 0.5) as u8
        };
        let at = |x: u32, y: u32| {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.at([2 * x + i, 2 * y + j]));
            image::Rgb([0, 1, 2].map(|c| srgb(four.iter().map(|texel| 0.25 * texel[c]).sum())))
        };
        let picture = image::RgbImage::from_fn(self.width / 2, self.height / 2, at);
        let file = std::fs::File::create(path).map_err(|e| Error::io("create", path, e))?;
        let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::Adaptive);
        picture.write_with_encoder(encoder).map_err(|e| Error::input(path, e.to_string(), "choose another path"))
    }
}

fn compare(
    source: PathBuf,
    formula: &str,
    bound: f64,
    other_mips: bool,
    png: Option<PathBuf>,
    pictures: &[String],
) -> Result<bool> {
    let formula = Formula::parse(formula)?;
    let scene = Scene::spheres(TILE_PX);
    let pictures: Vec<Named> = pictures.iter().map(|text| Named::parse(text, &scene)).collect::<Result<_>>()?;
    if let Some(png) = png {
        pictures[0].picture.draw(&png)?;
    }

    let imported = import::read(&source, &Options::default(), &mut ignore)?;
    let light = Light::new(&imported.environment);
    println!(
        "{}: rms relative to the mean, against the f64 reference (against exact mips, read as the engine does)",
        formula.name
    );
    println!("{:16}{}", "", pictures.iter().map(|p| format!("{:>20}", p.name)).collect::<String>());
    let mut right = true;
    for (i, sphere) in scene.spheres.iter().enumerate() {
        let (pixels, points): (Vec<[u32; 2]>, Vec<Point>) = scene.points(i, STRIDE).unzip();
        let reference = shade(formula, sphere, &points, &light, None)?;
        let mut through_mips = BTreeMap::new();
        let (mut errors, mut line) = (vec![], String::new());
        for Named { picture, mips, .. } in &pictures {
            let read = match through_mips.entry(*mips) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => entry.insert(shade(formula, sphere, &points, &light, Some(*mips))?),
            };
            let [whole, own] = [&reference, &*read].map(|expected| rms(picture, &pixels, expected));
            line.push_str(&format!("{:>9.2} % ({:5.2} %)", 100.0 * whole, 100.0 * own));
            errors.push([whole, own]);
        }
        // Written so that NaN fails.
        let by = usize::from(other_mips);
        let holds = errors[0][0] <= bound && errors.get(1).is_none_or(|own| errors[0][by] <= own[by] + SLACK);
        println!("{:16}{line}{}", sphere.name(), if holds { "" } else { "  <- WRONG" });
        right &= holds;
    }
    println!("{}: {}", formula.name, if right { "right" } else { "WRONG" });
    Ok(right)
}

fn alike(name: &str, picture: &Path, other: &Path, bound: f64) -> Result<bool> {
    let scene = Scene::spheres(TILE_PX);
    let [picture, other] = [Picture::read(picture, scene.size_px())?, Picture::read(other, scene.size_px())?];
    let differences: Vec<f64> = (0..scene.spheres.len())
        .map(|i| {
            let pixels: Vec<[u32; 2]> = scene.points(i, 1).map(|(pixel, _)| pixel).collect();
            let expected: Vec<[f64; 3]> = pixels.iter().map(|pixel| other.at(*pixel)).collect();
            rms(&picture, &pixels, &expected)
        })
        .collect();
    // Written so that NaN fails.
    let right = differences.iter().all(|d| *d <= bound);
    let worst = differences.iter().fold(0.0f64, |a, b| if *b <= a { a } else { *b });
    println!(
        "{name}: rms difference of a sphere at most {:.2} %{}",
        100.0 * worst,
        if right { "" } else { "  <- WRONG" }
    );
    Ok(right)
}

/// A picture, and the number of mips that the engine read.
struct Named {
    name: String,
    mips: u32,
    picture: Picture,
}

impl Named {
    fn parse(text: &str, scene: &Scene) -> Result<Named> {
        let parts = text.split_once('=').and_then(|(name, path)| Some((name.split_once('@')?, path)));
        let parsed = parts.and_then(|((name, mips), path)| Some((name, mips.parse().ok().filter(|m| *m > 0)?, path)));
        let Some((name, mips, path)) = parsed else {
            return Err(Error::usage(format!("'{text}' names no picture"), "say NAME@MIPS=PICTURE"));
        };
        Ok(Named { name: name.into(), mips, picture: Picture::read(Path::new(path), scene.size_px())? })
    }
}

/// Root of the mean square difference over pixels and channels, relative to the reference's mean.
fn rms(picture: &Picture, pixels: &[[u32; 2]], reference: &[[f64; 3]]) -> f64 {
    let (mut squares, mut sum) = (0.0, 0.0);
    for (pixel, expected) in pixels.iter().zip(reference) {
        let got = picture.at(*pixel);
        for c in 0..3 {
            squares += (got[c] - expected[c]).powi(2);
            sum += expected[c];
        }
    }
    let count = 3.0 * pixels.len() as f64;
    (squares / count).sqrt() / (sum / count)
}

// ----------------------------------------------------------------------------------------------------------- orientation

fn lights(
    name: &str,
    path: &Path,
    background: Option<PathBuf>,
    shows: &FileAxes,
    png: Option<PathBuf>,
) -> Result<bool> {
    let scene = Scene::lights(TILE_PX);
    let picture = Picture::read(path, scene.size_px())?;
    if let Some(png) = png {
        picture.draw(&png)?;
    }
    let half = 0.5f64.sqrt();
    // Where the mirror shows each light, and where the chalk is lit by it most. The light behind the mirror is seen at its
    // rim, off its axis; the chalk hides it.
    let mirror = [
        [half, 0.0, half],
        [-half, 0.0, half],
        [0.0, half, half],
        [0.0, -half, half],
        [0.0, 0.0, 1.0],
        [0.9755, 0.0, 0.22],
    ];
    let chalk = [[0.97, 0.0, 0.24], [-0.97, 0.0, 0.24], [0.0, 0.97, 0.24], [0.0, -0.97, 0.24], [0.0, 0.0, 1.0]];
    let mirror = mirror.iter().map(|n| ("mirror", picture.at(scene.pixel(0, *n))));
    let chalk = chalk.iter().map(|n| ("chalk", picture.at(scene.pixel(1, *n))));
    let mut looks: Vec<_> = mirror.enumerate().chain(chalk.enumerate()).collect();
    let mut where_ = "on the mirror and on chalk";
    if let Some(path) = background {
        let seen = Picture::read(&path, (LIGHTS.len() as u32, 1))?;
        looks.extend((0..LIGHTS.len()).map(|i| (i, ("background", seen.at([i as u32, 0])))));
        where_ = "on the mirror, on chalk and behind them";
    }
    let mut right = true;
    for (place, (surface, seen)) in looks {
        let found = nearest_light(seen);
        let along = shows.rows().map(|row| row.iter().zip(LIGHTS[place].1).map(|(a, b)| a * b).sum::<f64>());
        let light = LIGHTS.iter().position(|light| light.1 == along).expect("axes are carried to axes");
        let (axis, _, colour, _) = LIGHTS[light];
        if found != Some(light) {
            let instead = found.map_or("no light".into(), |l| format!("{}, the light at {}", LIGHTS[l].2, LIGHTS[l].0));
            println!("{name}: {surface}: WRONG: {axis} should be {colour}, but it is {seen:.3?}: {instead}");
            right = false;
        }
    }
    if right {
        println!("{name}: six lights where they belong, {where_}");
    }
    Ok(right)
}

/// The light whose colour a pixel has most of.
fn nearest_light(seen: [f64; 3]) -> Option<usize> {
    let unit = |v: [f64; 3]| {
        // What all channels share says nothing.
        let least = v[0].min(v[1]).min(v[2]);
        let v = v.map(|c| c - least);
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        (length > 0.02).then(|| v.map(|c| c / length))
    };
    let seen = unit(seen)?;
    let like = |light: usize| {
        let colour = unit(LIGHTS[light].3.map(f64::from)).expect("lights have colours");
        (0..3).map(|c| colour[c] * seen[c]).sum::<f64>()
    };
    (0..LIGHTS.len()).max_by(|a, b| like(*a).total_cmp(&like(*b)))
}
