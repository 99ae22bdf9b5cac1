// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that light or shade spheres, told apart by what they hold.

use std::borrow::Cow;
use std::path::Path;

use brdf_baker::bake::specular::SpecularJob;
use brdf_baker::env::import::{self, Options};
use brdf_baker::env::sky::Sky;
use brdf_baker::env::{Environment, Frame, Picture};
use brdf_baker::format;
use brdf_baker::format::picture::Picture as Plain;
use brdf_baker::spheres::{self, Lut};
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::verify::identify::{Verdict, identify};
use brdf_baker::{Error, Result};

use super::console::Console;

/// Rows of the built-in sky.
const SKY_HEIGHT: u32 = 512;

/// What a file holds.
pub enum Lit {
    /// A filtered cube, its axes where ours are.
    Filtered(Texture),
    /// A cube of irradiance, its axes where ours are.
    Diffuse(Texture),
    /// Radiance that is not filtered.
    Environment(Environment<'static>),
    /// A table of the split sum, and what is known of it.
    Table(Lut, Meta),
}

/// Reads a file of any kind.
pub fn read(path: &Path, console: &mut Console) -> Result<Lit> {
    let named = |e: Error| Error::input(path, e.to_string(), e.help().to_string());
    // A file of this program says so itself.
    if let Some((texture, _)) = format::for_path(path).ok().and_then(|f| f.read(path).ok()) {
        if texture.meta.get("kernel").is_some() {
            return cube(path, texture);
        }
        if texture.meta.get("table").is_some() {
            return Ok(Lit::Table(Lut::new(&texture).map_err(named)?, texture.meta));
        }
        let read_elsewhere =
            path.extension().is_some_and(|e| ["ktx2", "dds"].iter().any(|n| e.eq_ignore_ascii_case(n)));
        if texture.shape == Shape::Cube {
            console.warn(&format!(
                "'{}' does not say how its mips are filtered: its mip 0 is taken as the environment",
                path.display()
            ));
            if !read_elsewhere {
                let picture = Picture::Cube(Cow::Owned(spheres::first_level(&texture)));
                return Ok(Lit::Environment(Environment { picture, frame: Frame::IDENTITY }));
            }
        }
    }
    let options = Options::default();
    match import::read(path, &options, &mut |p| console.progress(p)) {
        Ok(imported) => {
            super::source::warn(path, &options, &imported, console);
            Ok(Lit::Environment(imported.environment))
        }
        Err(Error::Cancelled) => Err(Error::Cancelled),
        // What is no environment may be a table that others made.
        Err(first) => match Plain::read(path) {
            Ok(picture) => table_of_others(path, &picture, console),
            Err(_) => Err(first),
        },
    }
}

fn cube(path: &Path, texture: Texture) -> Result<Lit> {
    let named = |e: Error| Error::input(path, e.to_string(), e.help().to_string());
    if texture.shape != Shape::Cube {
        let what =
            format!("it holds {}, and the spheres are lit by cubes", texture.meta.get("projection").unwrap_or("a map"));
        return Err(Error::input(path, what, "bake it with --shape cube"));
    }
    let job = SpecularJob::from_meta(&texture).map_err(named)?;
    let texture = spheres::upright(texture).map_err(named)?;
    Ok(if job.kernel.least_alpha.is_some() { Lit::Filtered(texture) } else { Lit::Diffuse(texture) })
}

fn table_of_others(path: &Path, picture: &Plain, console: &mut Console) -> Result<Lit> {
    let named = |e: Error| Error::input(path, e.to_string(), e.help().to_string());
    let report = identify(picture, &mut |p| console.progress(p)).map_err(named)?;
    let Some(fit) = report.fits.first().filter(|_| report.verdict != Verdict::None) else {
        let what = "it has no layout of an environment, and no convention of a table that is known explains it";
        return Err(Error::input(path, what, "bake one with `brdf-baker bake split-sum`"));
    };
    let words = fit.words();
    if report.verdict == Verdict::Likely {
        let facts: Vec<String> = words.iter().map(|(name, words)| format!("{name} {words}")).collect();
        console.warn(&format!(
            "'{}' does not say what it holds, and is taken for: {}",
            path.display(),
            facts.join("; ")
        ));
    }
    let mut meta = Meta::default();
    meta.set("identified", if report.verdict == Verdict::Certain { "certain" } else { "likely" });
    words.iter().for_each(|(name, words)| meta.set(name, words));
    Ok(Lit::Table(Lut::understood(picture, fit).map_err(named)?, meta))
}

/// The built-in sky with its sun.
pub fn sky() -> Result<Environment<'static>> {
    let sky = Sky { sun_disc: true, ..Sky::default() }.resolve()?.equirect(SKY_HEIGHT);
    Ok(Environment { picture: Picture::Equirect(Cow::Owned(sky)), frame: Frame::IDENTITY })
}

/// White from everywhere.
pub fn white_room() -> Environment<'static> {
    Environment { picture: Picture::Cube(Cow::Owned(spheres::furnace())), frame: Frame::IDENTITY }
}

/// The table in a file; an error where it holds something else.
pub fn table(path: &Path, console: &mut Console) -> Result<Lut> {
    match read(path, console)? {
        Lit::Table(lut, _) => Ok(lut),
        _ => Err(Error::input(path, "it holds light, not a table", "give it to --env or --irradiance")),
    }
}

/// The cube of irradiance in a file; an error where it holds something else.
pub fn diffuse(path: &Path, console: &mut Console) -> Result<Texture> {
    match read(path, console)? {
        Lit::Diffuse(texture) => Ok(texture),
        _ => Err(Error::input(path, "it holds no irradiance", "bake one with `brdf-baker env --irradiance FILE`")),
    }
}
