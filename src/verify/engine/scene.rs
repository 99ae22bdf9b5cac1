// SPDX-License-Identifier: MIT OR Apache-2.0
//! Spheres on a grid, seen along −Z without perspective.

/// Spheres on a grid, the first one in the top left corner. A tile of the grid is one unit of length wide, and the middle
/// of the picture is the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Spheres in a row.
    pub columns: u32,
    /// Pixels along a side of a tile.
    pub tile_px: u32,
    /// Row by row.
    pub spheres: Vec<Sphere>,
}

/// What a sphere is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Linear base colour: F0 of a metal, albedo of what lies under a dielectric surface.
    pub colour: [f64; 3],
    /// A metal, or a dielectric with F0 = 0.04.
    pub metallic: bool,
    /// Perceptual roughness.
    pub roughness: f64,
}

impl Sphere {
    /// F0, and the albedo under the surface.
    pub fn reflectances(&self) -> ([f64; 3], [f64; 3]) {
        if self.metallic { (self.colour, [0.0; 3]) } else { ([super::DIELECTRIC_F0; 3], self.colour) }
    }

    /// A short name: what it is, how rough.
    pub fn name(&self) -> String {
        format!("{} {:.2}", if self.metallic { "metal" } else { "dielectric" }, self.roughness)
    }
}

/// A point of a sphere's surface under the middle of a pixel. The view is +Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Normal.
    pub n: [f64; 3],
    /// The largest change of a component of the normal from this pixel to the next one, to the right or downwards.
    pub n_step: f64,
}

impl Point {
    /// Cosine between normal and view.
    pub fn n_dot_v(&self) -> f64 {
        self.n[2]
    }

    /// The view, mirrored.
    pub fn r(&self) -> [f64; 3] {
        let [x, y, z] = self.n;
        [2.0 * z * x, 2.0 * z * y, 2.0 * z * z - 1.0]
    }
}

/// Radius of a sphere, in tiles.
pub const RADIUS: f64 = 11.0 / 24.0;
/// Least n·v of the points that are compared: further out, a pixel sees too much of the surface at once.
const LEAST_N_DOT_V: f64 = 0.2;

impl Scene {
    /// Gold above a brown dielectric, each at the roughnesses 0, ¼, ½, ¾ and 1.
    pub fn spheres(tile_px: u32) -> Scene {
        let rows = [([1.0, 0.782, 0.344], true), ([0.5, 0.35, 0.2], false)];
        let roughnesses = [0.0, 0.25, 0.5, 0.75, 1.0];
        let spheres = rows.iter().flat_map(|(colour, metallic)| {
            roughnesses.map(|roughness| Sphere { colour: *colour, metallic: *metallic, roughness })
        });
        Scene { columns: 5, tile_px, spheres: spheres.collect() }
    }

    /// A white mirror beside white chalk: which way round the environment is.
    pub fn lights(tile_px: u32) -> Scene {
        let mirror = Sphere { colour: [1.0; 3], metallic: true, roughness: 0.0 };
        let chalk = Sphere { colour: [1.0; 3], metallic: false, roughness: 1.0 };
        Scene { columns: 2, tile_px, spheres: vec![mirror, chalk] }
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> (u32, u32) {
        (self.columns * self.tile_px, self.rows() * self.tile_px)
    }

    /// Rows of spheres.
    pub fn rows(&self) -> u32 {
        (self.spheres.len() as u32).div_ceil(self.columns)
    }

    /// Where the centre of a sphere lies, in tiles: to the right and upwards.
    pub fn centre(&self, sphere: usize) -> [f64; 2] {
        let (column, row) = (sphere as u32 % self.columns, sphere as u32 / self.columns);
        let (columns, rows) = (f64::from(self.columns), f64::from(self.rows()));
        [f64::from(column) + 0.5 - 0.5 * columns, 0.5 * rows - 0.5 - f64::from(row)]
    }

    /// The surface under the middle of a pixel, if it is well inside of a sphere.
    pub fn point(&self, sphere: usize, pixel: [u32; 2]) -> Option<Point> {
        let (width, height) = self.size_px();
        let tile = f64::from(self.tile_px);
        let [cx, cy] = self.centre(sphere);
        let x = ((f64::from(pixel[0]) + 0.5 - 0.5 * f64::from(width)) / tile - cx) / RADIUS;
        let y = ((0.5 * f64::from(height) - f64::from(pixel[1]) - 0.5) / tile - cy) / RADIUS;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let n_step = (x / z).abs().max((y / z).abs()).max(1.0) / (RADIUS * tile);
        (z >= LEAST_N_DOT_V).then_some(Point { n: [x, y, z], n_step })
    }

    /// Every `stride`-th pixel of a sphere in both directions, and the surface under it.
    pub fn points(&self, sphere: usize, stride: u32) -> impl Iterator<Item = ([u32; 2], Point)> {
        let (column, row) = (sphere as u32 % self.columns, sphere as u32 / self.columns);
        let along = move |tile: u32| {
            (0..self.tile_px).skip(stride as usize / 2).step_by(stride as usize).map(move |i| tile * self.tile_px + i)
        };
        along(row)
            .flat_map(move |y| along(column).map(move |x| [x, y]))
            .filter_map(move |pixel| Some((pixel, self.point(sphere, pixel)?)))
    }

    /// The pixel whose normal is nearest to `n`, a unit vector.
    pub fn pixel(&self, sphere: usize, n: [f64; 3]) -> [u32; 2] {
        let (width, height) = self.size_px();
        let tile = f64::from(self.tile_px);
        let [cx, cy] = self.centre(sphere);
        let x = (cx + RADIUS * n[0]) * tile + 0.5 * f64::from(width);
        let y = 0.5 * f64::from(height) - (cy + RADIUS * n[1]) * tile;
        [x as u32, y as u32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_on_the_sphere_that_the_pixel_shows() {
        let scene = Scene::spheres(48);
        assert_eq!(scene.size_px(), (240, 96));
        assert_eq!((scene.centre(0), scene.centre(9)), ([-2.0, 0.5], [2.0, -0.5]));
        for sphere in [0, 4, 7] {
            let mut count = 0;
            for (pixel, point) in scene.points(sphere, 3) {
                let length: f64 = point.n.iter().map(|v| v * v).sum();
                assert!((length - 1.0).abs() < 1e-12 && point.n[2] >= LEAST_N_DOT_V);
                assert_eq!(scene.pixel(sphere, point.n), pixel);
                count += 1;
            }
            assert!(count > 100);
        }
    }

    #[test]
    fn the_step_of_a_normal_is_that_of_the_next_pixel() {
        let scene = Scene::spheres(480);
        for (pixel, point) in scene.points(6, 60) {
            let next = [[pixel[0] + 1, pixel[1]], [pixel[0], pixel[1] + 1]].map(|p| scene.point(6, p));
            let [Some(right), Some(below)] = next else { continue };
            let change = |to: Point| (0..3).map(|i| (to.n[i] - point.n[i]).abs()).fold(0.0, f64::max);
            let step = change(right).max(change(below));
            assert!((step / point.n_step - 1.0).abs() < 0.1, "{step} {}", point.n_step);
        }
    }

    #[test]
    fn the_mirrored_view_of_the_middle_is_the_view() {
        let scene = Scene::lights(64);
        let point = scene.point(0, scene.pixel(0, [0.0, 0.0, 1.0])).expect("the middle is inside");
        assert!(point.r()[2] > 0.99);
        let half = 0.5f64.sqrt();
        let right = scene.point(0, scene.pixel(0, [half, 0.0, half])).expect("45 degrees are inside");
        assert!(right.r()[0] > 0.99);
    }
}
