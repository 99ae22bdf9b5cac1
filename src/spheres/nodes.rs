// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where the reference looks: half vectors that share out a distribution's projected area.
//!
//! ∫ f L (n·l) dω_l = ∫ F G/(n·v) (v·h)/(n·h) L(l(h)) [D (n·h) dω_h], so a rule for the measure in brackets serves every
//! view. With y the coordinate in which the distribution is flat ([`crate::ndf::Flat`]) and t in (0, 1),
//!
//! ```text
//! y² = −2 ln(1 − t),    D (n·h) dω_h = density(y) dy/dt dt dφ/2π
//! ```
//!
//! a lattice of n points (t, φ) = ((i + ½)/n, i golden angles) is spread evenly, and more finely over the lobe's tail than
//! over its core: a tail that sees the sun must not see it through one node. Each node stands for a piece of the sphere of
//! directions about as large as 4 (v·h) dω_h, over which the environment is averaged before it is read.

use std::f64::consts::PI;

use crate::ndf::{Lobe, Ndf};

/// Golden angle: the turn between neighbours that repeats last.
const GOLDEN_RAD: f64 = PI * (3.0 - 2.236_067_977_499_79);
/// Area over which the environment is averaged, in shares of a node: bilinear reading spreads it once more, so that neighbours
/// overlap and a small light is not seen by more nodes here than there.
const OVERLAP: f64 = 2.0;

/// A half vector, its weight, and at which level of detail the environment is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// x and y about the normal.
    pub xy: [f64; 2],
    /// Share of the measure.
    pub weight: f64,
    /// Level of detail where v·h is 1: how often the texels of the environment are halved.
    pub lod: f64,
}

/// log4 of the number of texels of the environment in a solid angle.
fn lod(solid_angle_sr: f64, texel_sr: f64) -> f64 {
    0.5 * (OVERLAP * solid_angle_sr / texel_sr).log2()
}

/// `count` half vectors of a lobe, over an environment whose texels have the solid angle `texel_sr`.
pub fn half_vectors(ndf: &Ndf, lobe: &Lobe, count: u32, texel_sr: f64) -> Vec<Node> {
    let flat = &ndf.family.flat;
    let n = f64::from(count);
    (0..count)
        .filter_map(|i| {
            let left = 1.0 - (f64::from(i) + 0.5) / n;
            let y = (-2.0 * left.ln()).sqrt();
            let tan = (flat.tan)(y, lobe);
            // dy/dt = 1/(y (1 − t)).
            let weight = (flat.density)(y, tan, lobe) / (y * left * n);
            let cos2 = 1.0 / (1.0 + tan * tan);
            let sin2 = cos2 * tan * tan;
            let projected = ndf.d(cos2, sin2, lobe) * cos2.sqrt();
            if !(tan.is_finite() && weight > 0.0 && projected > 0.0) {
                return None;
            }
            let (sin_phi, cos_phi) = (f64::from(i) * GOLDEN_RAD).sin_cos();
            let sin = sin2.sqrt();
            let lod = lod(4.0 * weight / projected, texel_sr);
            Some(Node { xy: [sin * cos_phi, sin * sin_phi], weight, lod })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf;
    use std::f64::consts::TAU;

    #[test]
    fn weights_sum_to_the_measure() {
        for text in ["ggx", "beckmann", "phong", "gtr:gamma=1.5", "charlie"] {
            let ndf = ndf::parse(text).expect("valid");
            for roughness in [0.1, 0.5, 1.0] {
                let nodes = half_vectors(&ndf, &ndf.lobe(roughness).expect("a lobe"), 2048, 1e-5);
                let sum: f64 = nodes.iter().map(|n| n.weight).sum();
                assert!((sum - 1.0).abs() < 1e-3, "{text} {roughness}: {sum}");
            }
        }
    }

    #[test]
    fn pieces_of_the_sphere_add_up() {
        // Phong's lobe of exponent 0 is D = 1/π: nodes all over the hemisphere.
        let ndf = ndf::parse("phong:exponent=0").expect("valid");
        let nodes = half_vectors(&ndf, &ndf.lobe(1.0).expect("a lobe"), 4096, 1e-5);
        let total: f64 = nodes.iter().map(|n| 4f64.powf(n.lod) * 1e-5 / OVERLAP / 4.0).sum();
        assert!((total / TAU - 1.0).abs() < 0.02, "{total}");
        let off: f64 = nodes.iter().map(|n| n.weight * n.xy[0]).sum();
        assert!(off.abs() < 1e-3, "{off}");
    }
}
