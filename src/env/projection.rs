// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the sphere is laid out in a picture that is written: six faces of a cube, an equirectangular picture, or an
//! octahedral map.
//!
//! All three place the point (s, t) of a face, both from −1 to 1, s to the right and t downwards:
//!
//! - **cube**: [`crate::term::cube`].
//! - **equirect**: φ = π s, θ = π (t + 1)/2 of [`super::Equirect`]; one face, twice as wide as high. Left and right edge
//!   meet; across the top or bottom edge follows the column half a width away.
//! - **octahedral** (Engelhardt, Dachsbacher 2008; Cigolle et al. 2014, Sec. 3.1): one square face. With y = 1 − |s| − |t|, the
//!   direction is along (s, y, t) where y ≥ 0 and along ((1 − |t|) sign s, y, (1 − |s|) sign t) elsewhere: +Y is the
//!   middle, −Y every corner, s runs along +X and t along +Z. No border is stored: beyond an edge the map goes on
//!   mirrored along that edge, so that texel (−1, y) is texel (0, N − 1 − y).

use std::f64::consts::PI;

use super::Equirect;
use super::orientation::{self, normalized};
use crate::error::{Error, Result, nearest};
use crate::term::cube;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Six faces.
    Cube,
    /// One picture, twice as wide as high.
    Equirect,
    /// One square.
    Octahedral,
}

impl Projection {
    /// All projections, in the order of their documentation.
    pub const ALL: [Projection; 3] = [Projection::Cube, Projection::Equirect, Projection::Octahedral];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Projection::Cube => "cube",
            Projection::Equirect => "equirect",
            Projection::Octahedral => "octahedral",
        }
    }

    /// The projection with this name.
    pub fn parse(name: &str) -> Result<Self> {
        let known = || Self::ALL.iter().map(|p| p.name());
        Self::ALL
            .into_iter()
            .find(|p| p.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown shape '{name}'"), nearest(name, known())))
    }

    /// What a file says of its layout.
    pub fn convention(self) -> &'static str {
        match self {
            Projection::Cube => "faces +X -X +Y -Y +Z -Z, oriented as in the Vulkan and KTX2 specifications",
            Projection::Equirect => {
                "(u, v) looks along (cos φ sin θ, cos θ, sin φ sin θ), φ = 2π(u − 1/2), θ = πv; u wraps"
            }
            Projection::Octahedral => {
                "s = 2u − 1, t = 2v − 1, y = 1 − |s| − |t|: along (s, y, t), \
                 or ((1 − |t|) sign s, y, (1 − |s|) sign t) where y < 0; no border, edges mirror onto themselves"
            }
        }
    }

    /// Number of faces.
    pub fn faces(self) -> u32 {
        if self == Projection::Cube { 6 } else { 1 }
    }

    /// Width and height of a face whose shorter side has `size` texels.
    pub fn level_size(self, size: u32) -> (u32, u32) {
        if self == Projection::Equirect { (2 * size, size) } else { (size, size) }
    }

    /// The widest side of a texel, in radians, of a face whose shorter side has `size` texels; about.
    pub fn texel_rad(self, size: u32) -> f64 {
        let whole_rad = match self {
            Projection::Cube => 2.0,
            Projection::Equirect => PI,
            Projection::Octahedral => 4.0,
        };
        whole_rad / f64::from(size)
    }

    /// The unit vector at a point of a face.
    pub fn direction(self, face: u32, s: f64, t: f64) -> [f64; 3] {
        match self {
            Projection::Cube => normalized(cube::direction(face, s, t)),
            Projection::Equirect => Equirect::direction(0.5 * (s + 1.0), 0.5 * (t + 1.0)),
            Projection::Octahedral => normalized(octahedral(s, t)),
        }
    }

    /// Face, s and t of a direction (of any length). The inverse of [`Projection::direction`].
    pub fn locate(self, d: [f64; 3]) -> (u32, f64, f64) {
        match self {
            Projection::Cube => orientation::locate(d),
            Projection::Equirect => {
                let [u, v] = Equirect::locate(d);
                (0, 2.0 * u - 1.0, 2.0 * v - 1.0)
            }
            Projection::Octahedral => {
                let length = d[0].abs() + d[1].abs() + d[2].abs();
                let [s, y, t] = d.map(|c| c / length);
                if y < 0.0 { (0, (1.0 - t.abs()).copysign(s), (1.0 - s.abs()).copysign(t)) } else { (0, s, t) }
            }
        }
    }

    /// Solid angle, in steradians, of a texel of a face of `width` × `height`.
    pub fn solid_angle_sr(self, x: u32, y: u32, width: u32, height: u32) -> f64 {
        let at = |i: u32, n: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
        let (s0, s1, t0, t1) = (at(x, width), at(x + 1, width), at(y, height), at(y + 1, height));
        match self {
            Projection::Cube => {
                let corner = orientation::solid_angle;
                corner(s1, t1) - corner(s0, t1) - corner(s1, t0) + corner(s0, t0)
            }
            Projection::Equirect => {
                let (middle, half) = (0.25 * PI * (t0 + t1 + 2.0), 0.25 * PI * (t1 - t0));
                2.0 * middle.sin() * half.sin() * PI * (s1 - s0)
            }
            Projection::Octahedral => octahedral_parts(s0, t0, s1, t1).iter().flatten().map(triangle_sr).sum(),
        }
    }
}

/// The point of the octahedron |x| + |y| + |z| = 1 at (s, t).
pub(super) fn octahedral(s: f64, t: f64) -> [f64; 3] {
    let y = 1.0 - s.abs() - t.abs();
    if y < 0.0 { [(1.0 - t.abs()).copysign(s), y, (1.0 - s.abs()).copysign(t)] } else { [s, y, t] }
}

/// A texel of an octahedral map whose size is a power of two, as triangles of the octahedron: two, or two a quadrant for
/// the map of one texel. Folds |s| + |t| = 1 run along their sides, so on each triangle the straight lines of the map are
/// great circles. Corners turn from s to t.
pub(super) fn octahedral_parts(s0: f64, t0: f64, s1: f64, t1: f64) -> [Option<[[f64; 3]; 3]>; 8] {
    let mut parts = [None; 8];
    let mut count = 0;
    // Quadrants first: the axes run through the only texel of the smallest map.
    let cuts = |a: f64, b: f64| if a < 0.0 && b > 0.0 { [(a, 0.0), (0.0, b)] } else { [(a, b), (b, b)] };
    for (a0, a1) in cuts(s0, s1) {
        for (b0, b1) in cuts(t0, t1) {
            if a0 == a1 || b0 == b1 {
                continue;
            }
            // Cut along the diagonal that the fold is parallel to.
            let corners = [[a0, b0], [a1, b0], [a1, b1], [a0, b1]];
            let first = usize::from((a0 + a1) * (b0 + b1) > 0.0);
            for [i, j, k] in [[first, first + 1, first + 2], [first, first + 2, (first + 3) % 4]] {
                parts[count] = Some([i, j, k].map(|c| corners[c % 4]).map(|[s, t]| [s, t, 0.0]));
                count += 1;
            }
        }
    }
    parts.map(|part| part.map(on_octahedron))
}

/// Corners (s, t, ·) on the octahedron; those beyond the fold by the sign of the triangle's middle.
fn on_octahedron(part: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let middle = [0, 1].map(|i| part.iter().map(|corner| corner[i]).sum::<f64>());
    part.map(|[s, t, _]| {
        let y = 1.0 - s.abs() - t.abs();
        if y < 0.0 { [(1.0 - t.abs()).copysign(middle[0]), y, (1.0 - s.abs()).copysign(middle[1])] } else { [s, y, t] }
    })
}

/// Solid angle of a triangle of directions (of any length): van Oosterom, Strackee 1983.
pub(super) fn triangle_sr([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(|v| normalized(*v));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    2.0 * dot(a, cross).abs().atan2(1.0 + dot(a, b) + dot(b, c) + dot(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locate_inverts_direction() {
        for projection in Projection::ALL {
            for (s, t) in [(0.1, 0.2), (-0.7, 0.6), (0.9, -0.8), (-0.3, -0.4)] {
                let (face, s1, t1) = projection.locate(projection.direction(0, s, t).map(|c| 2.0 * c));
                assert!(face == 0 && (s - s1).abs() < 1e-14 && (t - t1).abs() < 1e-14, "{projection:?}: {s1} {t1}");
            }
        }
    }

    #[test]
    fn the_octahedral_map_has_up_in_the_middle_and_down_in_the_corners() {
        let at = |s, t| Projection::Octahedral.direction(0, s, t);
        assert_eq!(at(0.0, 0.0), [0.0, 1.0, 0.0]);
        assert_eq!(at(1.0, 0.0), [1.0, 0.0, 0.0]);
        assert_eq!(at(0.0, 1.0), [0.0, 0.0, 1.0]);
        for (s, t) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            assert_eq!(at(s, t), [0.0, -1.0, 0.0].map(|c: f64| c + 0.0));
        }
        // Across the left edge the map goes on mirrored.
        let (here, there) = (at(-1.0, 0.3), at(-1.0, -0.3));
        assert!((0..3).all(|i| (here[i] - there[i]).abs() < 1e-15), "{here:?} {there:?}");
    }

    #[test]
    fn texels_cover_the_sphere() {
        for projection in Projection::ALL {
            for size in [1, 2, 8, 64] {
                let (width, height) = projection.level_size(size);
                let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                let one: f64 = texels.map(|(x, y)| projection.solid_angle_sr(x, y, width, height)).sum();
                let all = one * f64::from(projection.faces());
                assert!((all / (4.0 * PI) - 1.0).abs() < 1e-12, "{projection:?} {size}: {all}");
            }
        }
    }
}
