// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an engine should draw: spheres under an environment, shaded pixel by pixel in f64.
//!
//! ```text
//! colour = light(r, alpha) · single + light(n, Lambert) · (multiple + diffuse)
//! ```
//!
//! with the exact convolution of the environment ([`Light`]) where an engine reads a mip, the rule of the split sum
//! ([`crate::bake::Model::rule`]) where it reads a table, and the engine's own [`Formula`]: at which roughness it shades,
//! which way it looks, how it adds scattering. What is left between such a picture and the engine's is what its maps,
//! its tables and their interpolation lose.
//!
//! The scene is one that every engine can set exactly: an orthographic camera looks along −Z at spheres on a grid, +Y is
//! up, so that the normal under a pixel is known in closed form and the view is +Z everywhere.

mod formula;
mod light;
mod scene;

pub use formula::{FORMULAS, Formula, Surface};
pub use light::Light;
pub use scene::{Point, RADIUS, Scene, Sphere};

use rayon::prelude::*;

use crate::bake::{At, Model};
use crate::error::Result;

/// The reflectance at normal incidence that engines give to dielectrics.
pub const DIELECTRIC_F0: f64 = 0.04;

/// Linear radiance that `formula` shows at points of a sphere of `material`: the exact convolution at the material's
/// roughness, or, with `mips`, what is read between two of so many exact mips.
pub fn shade(
    formula: &Formula,
    material: &Sphere,
    points: &[Point],
    light: &Light<'_>,
    mips: Option<u32>,
) -> Result<Vec<[f64; 3]>> {
    let model = Model::parse("ggx", "smith")?;
    let colour = |point: &Point| {
        let roughness = (formula.roughness)(material.roughness, point);
        let [whole, bias, ..] = model.rule(At { n_dot_v: point.n_dot_v(), roughness });
        let direction = (formula.direction)(point, roughness);
        let specular = match mips {
            None => light.reflected(direction, roughness),
            Some(mips) => between_mips(formula, direction, roughness, light, mips),
        };
        let diffuse = light.diffuse(point.n);
        let (f0, albedo) = material.reflectances();
        let (scale, n_dot_v) = (whole - bias, point.n_dot_v());
        let surface = Surface { f0: 0.0, albedo: 0.0, scale, bias, n_dot_v, roughness };
        std::array::from_fn(|c| {
            let [single, rest] = (formula.shares)(&Surface { f0: f0[c], albedo: albedo[c], ..surface });
            specular[c] * single + diffuse[c] * rest
        })
    };
    Ok(points.par_iter().map(colour).collect())
}

/// A linear blend of the two mips next to a roughness.
fn between_mips(formula: &Formula, direction: [f64; 3], roughness: f64, light: &Light<'_>, mips: u32) -> [f64; 3] {
    let last = mips - 1;
    let level = (formula.level)(roughness) * f64::from(last);
    let mip = |m: u32| light.reflected(direction, formula.roughness_of(m.min(last), last));
    let (lower, share) = (level.floor(), level.fract());
    if share == 0.0 {
        return mip(lower as u32);
    }
    let [sharper, rougher] = [mip(lower as u32), mip(lower as u32 + 1)];
    std::array::from_fn(|c| sharper[c] + share * (rougher[c] - sharper[c]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Equirect;
    use crate::verify::truth;

    /// In a white room, a white metal that loses nothing to a single bounce is white, whatever the engine.
    #[test]
    fn a_white_metal_vanishes_in_a_white_room() -> Result<()> {
        let white = Equirect::from_fn(64, |_, _| [1.0; 3]);
        let environment = (&white).into();
        let light = Light::new(&environment);
        let scene = Scene::spheres(32);
        for formula in FORMULAS {
            for roughness in [0.0, 0.5, 1.0] {
                let metal = Sphere { colour: [1.0; 3], metallic: true, roughness };
                let points: Vec<Point> = scene.points(0, 5).map(|(_, point)| point).collect();
                assert!(points.len() > 10);
                for [r, g, b] in shade(formula, &metal, &points, &light, None)? {
                    assert!((r - 1.0).abs() < 1e-4 && r == g && g == b, "{}: {r} {g} {b}", formula.name);
                }
            }
        }
        Ok(())
    }

    /// A black dielectric in a white room reflects its directional albedo, what two bounces give included: with the split
    /// sum's two numbers from adaptive integration, F0 · (E − bias) + bias for the first.
    #[test]
    fn a_black_dielectric_reflects_what_its_table_holds() -> Result<()> {
        let white = Equirect::from_fn(64, |_, _| [1.0; 3]);
        let environment = (&white).into();
        let light = Light::new(&environment);
        let scene = Scene::spheres(32);
        let model = Model::parse("ggx", "smith")?;
        let bevy = Formula::parse("bevy")?;
        let coal = Sphere { colour: [0.0; 3], metallic: false, roughness: 0.5 };
        let points: Vec<Point> = scene.points(0, 7).map(|(_, point)| point).collect();
        for (point, seen) in points.iter().zip(shade(bevy, &coal, &points, &light, None)?) {
            let [whole, bias, ..] = truth::albedo(&model, point.n_dot_v(), 0.5, 1e-7).value;
            let first = DIELECTRIC_F0 * (whole - bias) + bias;
            let average = DIELECTRIC_F0 + (1.0 - DIELECTRIC_F0) / 21.0;
            let expected = first + first * average * (1.0 - whole) / (1.0 - (1.0 - whole) * average);
            assert!((seen[0] - expected).abs() < 1e-5, "{} for {expected}", seen[0]);
        }
        Ok(())
    }

    /// Mips that lie close together leave nothing between them: what is read there is the exact convolution.
    #[test]
    fn many_mips_are_as_good_as_all() -> Result<()> {
        let sky = Equirect::from_fn(64, |u, v| {
            let [x, y, z] = Equirect::direction(u, v);
            [1.0 + x, 1.0 + y * y, 2.0 + z].map(|c| c as f32)
        });
        let environment = (&sky).into();
        let light = Light::new(&environment);
        let scene = Scene::spheres(32);
        let points: Vec<Point> = scene.points(0, 9).map(|(_, point)| point).collect();
        for formula in FORMULAS {
            let metal = Sphere { colour: [1.0; 3], metallic: true, roughness: 0.6 };
            let exact = shade(formula, &metal, &points, &light, None)?;
            let worst = |mips| -> Result<f64> {
                let read = shade(formula, &metal, &points, &light, Some(mips))?;
                Ok(exact.iter().flatten().zip(read.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
            };
            let (few, many) = (worst(4)?, worst(40)?);
            assert!(many < 2e-3 && few > 3.0 * many, "{}: {few:.1e} with 4 mips, {many:.1e} with 40", formula.name);
        }
        Ok(())
    }
}
