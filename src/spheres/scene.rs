// SPDX-License-Identifier: MIT OR Apache-2.0
//! Spheres on a grid, seen without perspective: the camera looks along −Z, +X is right and +Y up, so that the normal under a
//! pixel is known in closed form and the view is +Z everywhere. A tile of the grid is a unit of length, the middle of the
//! picture is the origin, and the sphere in its tile has the radius [`RADIUS`].

use crate::error::{Error, Result, nearest};

/// Radius of a sphere in tiles.
pub const RADIUS: f64 = 11.0 / 24.0;
/// Most spheres along a side of the grid.
pub const MAX_SPHERES: u32 = 16;
/// Largest side of a picture.
pub const MAX_SIZE: u32 = 8192;
/// Samples a pixel, in sixteenths from its middle to the right and downwards: each row and column of eight has one.
pub(crate) const PARTS: [[f64; 2]; 8] =
    [[1.0, -3.0], [-1.0, 3.0], [5.0, 1.0], [-3.0, -5.0], [-5.0, 5.0], [-7.0, -1.0], [3.0, 7.0], [7.0, -7.0]];

/// What runs along a side of the grid, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// Blend of dielectric and metal.
    Metallic,
    /// Perceptual roughness.
    Roughness,
}

impl Property {
    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Property::Metallic => "metallic",
            Property::Roughness => "roughness",
        }
    }

    /// The property with this name.
    pub fn parse(name: &str) -> Result<Property> {
        let all = [Property::Metallic, Property::Roughness];
        all.into_iter().find(|p| p.name() == name).ok_or_else(|| {
            let help = nearest(name, all.map(Property::name));
            Error::usage(format!("'{name}' cannot run along a grid of spheres"), help)
        })
    }
}

/// What a sphere is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Linear base colour: F0 of the metal, albedo of the body under the dielectric.
    pub base: [f64; 3],
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f64,
    /// Perceptual roughness.
    pub roughness: f64,
    /// F0 of the dielectric.
    pub f0: f64,
    /// What the F82 tint takes from the metal's edge, [`crate::material::Metal::f0_and_edge`]; 0 where Schlick's Fresnel is
    /// all that is known of it.
    pub edge: [f64; 3],
}

/// A grid of spheres and the picture that shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Spheres in a row.
    pub columns: u32,
    /// Row by row, from the top left.
    pub spheres: Vec<Sphere>,
}

/// What a sample of a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// A sphere, where its normal is.
    Sphere(usize, [f64; 3]),
    /// What is behind, so many pixels to the right of and above the middle.
    Behind([f64; 2]),
}

impl Scene {
    /// A grid of `columns` × `rows` spheres like `sphere`, along whose x and y axis a property runs, or none.
    pub fn grid(
        size: (u32, u32),
        [columns, rows]: [u32; 2],
        axes: [Option<Property>; 2],
        sphere: Sphere,
    ) -> Result<Scene> {
        if !(1..=MAX_SPHERES).contains(&columns) || !(1..=MAX_SPHERES).contains(&rows) {
            let what = format!("a grid of {columns}x{rows} spheres is not drawn");
            return Err(Error::usage(what, format!("use --spheres from 1x1 to {MAX_SPHERES}x{MAX_SPHERES}")));
        }
        let (least, most) = (8 * columns.max(rows), MAX_SIZE);
        if !(least..=most).contains(&size.0) || !(least..=most).contains(&size.1) {
            let what = format!("{columns}x{rows} spheres are not drawn in {}x{} pixels", size.0, size.1);
            return Err(Error::usage(what, format!("use --size from {least}x{least} to {most}x{most}")));
        }
        let share = |i: u32, n: u32| if n > 1 { f64::from(i) / f64::from(n - 1) } else { 0.0 };
        let spheres = (0..columns * rows).map(|i| {
            let mut sphere = sphere;
            let along = [share(i % columns, columns), share(i / columns, rows)];
            for (axis, value) in axes.iter().zip(along) {
                match axis {
                    Some(Property::Metallic) => sphere.metallic = value,
                    Some(Property::Roughness) => sphere.roughness = value,
                    None => {}
                }
            }
            sphere
        });
        Ok(Scene { size, columns, spheres: spheres.collect() })
    }

    /// Rows of spheres.
    pub fn rows(&self) -> u32 {
        (self.spheres.len() as u32).div_ceil(self.columns)
    }

    /// Pixels along a side of a tile: the grid fills the picture.
    pub fn tile_px(&self) -> f64 {
        (f64::from(self.size.0) / f64::from(self.columns)).min(f64::from(self.size.1) / f64::from(self.rows()))
    }

    /// What a point of the picture shows, in pixels from its top left corner.
    pub fn at(&self, x: f64, y: f64) -> Seen {
        let from_middle = [x - 0.5 * f64::from(self.size.0), 0.5 * f64::from(self.size.1) - y];
        let [right, up] = from_middle.map(|v| v / self.tile_px());
        let (columns, rows) = (f64::from(self.columns), f64::from(self.rows()));
        let (column, row) = ((right + 0.5 * columns).floor(), (0.5 * rows - up).floor());
        let nx = (right - (column + 0.5 - 0.5 * columns)) / RADIUS;
        let ny = (up - (0.5 * rows - 0.5 - row)) / RADIUS;
        let left = 1.0 - nx * nx - ny * ny;
        let inside = left > 0.0 && column >= 0.0 && row >= 0.0 && column < columns && row < rows;
        let sphere = if inside { (row * columns + column) as usize } else { usize::MAX };
        if sphere < self.spheres.len() {
            Seen::Sphere(sphere, [nx, ny, left.sqrt()])
        } else {
            Seen::Behind(from_middle)
        }
    }

    /// What the samples of a pixel see.
    pub fn parts(&self, x: u32, y: u32) -> [Seen; 8] {
        PARTS.map(|[dx, dy]| self.at(f64::from(x) + 0.5 + dx / 16.0, f64::from(y) + 0.5 + dy / 16.0))
    }

    /// The sphere that a whole pixel shows, where n·v is at least `least` everywhere in it.
    pub fn inside(&self, x: u32, y: u32, least: f64) -> Option<usize> {
        let mut found = None;
        for seen in self.parts(x, y) {
            match seen {
                Seen::Sphere(sphere, n) if n[2] >= least && found.is_none_or(|f| f == sphere) => found = Some(sphere),
                _ => return None,
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREY: Sphere = Sphere { base: [0.5; 3], metallic: 0.0, roughness: 0.0, f0: 0.04, edge: [0.0; 3] };

    #[test]
    fn properties_run_from_0_to_1() {
        let axes = [Some(Property::Metallic), Some(Property::Roughness)];
        let scene = Scene::grid((640, 360), [5, 5], axes, GREY).expect("valid");
        assert_eq!((scene.spheres[0].metallic, scene.spheres[4].metallic), (0.0, 1.0));
        assert_eq!((scene.spheres[10].roughness, scene.spheres[24].roughness), (0.5, 1.0));
        assert_eq!(scene.tile_px(), 72.0);
    }

    #[test]
    fn the_middle_of_a_sphere_looks_at_the_viewer() {
        let scene = Scene::grid((640, 360), [5, 5], [None; 2], GREY).expect("valid");
        assert_eq!(scene.at(320.0, 180.0), Seen::Sphere(12, [0.0, 0.0, 1.0]));
        // The top left sphere is centred two tiles to the left and two up; its right edge looks to +X.
        let Seen::Sphere(0, n) = scene.at(176.0 + 72.0 * RADIUS * 0.99, 36.0) else { panic!("the top left sphere") };
        assert!((n[0] - 0.99).abs() < 1e-9 && n[1].abs() < 1e-9);
        assert_eq!(scene.at(0.0, 180.0), Seen::Behind([-320.0, 0.0]));
        assert_eq!(scene.inside(320, 180, 0.9), Some(12));
        assert_eq!(scene.inside(0, 0, 0.0), None);
    }

    #[test]
    fn impossible_grids_are_refused() {
        assert!(Scene::grid((640, 360), [0, 5], [None; 2], GREY).is_err());
        assert!(Scene::grid((20, 360), [5, 5], [None; 2], GREY).is_err());
        assert!(Property::parse("rougness").unwrap_err().help().contains("roughness"));
    }
}
