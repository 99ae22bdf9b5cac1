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

pub use formula::{FORMULAS, Formula};
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
        std::array::from_fn(|c| {
            let [single, rest] = (formula.shares)(f0[c], albedo[c], whole - bias, bias);
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
}
