// SPDX-License-Identifier: MIT OR Apache-2.0
//! A microfacet BRDF at one width, evaluated for a pair of directions: what curves and pictures are made of.

use crate::ndf::{Lobe, Ndf};
use crate::term::visibility::{Directions, Visibility};

/// D and G at one width. The normal is +Z; `l` and `v` are unit vectors that point away from the surface.
#[derive(Clone, Copy)]
pub struct Brdf {
    ndf: Ndf,
    visibility: &'static Visibility,
    lobe: Lobe,
}

impl Brdf {
    /// The BRDF at a roughness; `None` where it is a mirror, at roughness 0.
    pub fn new(ndf: Ndf, visibility: &'static Visibility, roughness: f64) -> Option<Brdf> {
        Some(Brdf { ndf, visibility, lobe: ndf.lobe(roughness)? })
    }

    /// The distribution's lobe.
    pub fn lobe(&self) -> &Lobe {
        &self.lobe
    }

    /// D per steradian at the angle between normal and half vector, in radians from 0 to π/2.
    pub fn d(&self, theta_h: f64) -> f64 {
        let (sin, cos) = theta_h.sin_cos();
        self.ndf.d(cos * cos, sin * sin, &self.lobe)
    }

    /// G, the share of facets that is neither masked nor shadowed.
    pub fn g(&self, l: [f64; 3], v: [f64; 3]) -> f64 {
        let directions = self.directions(l, v);
        directions.n_dot_v * (self.visibility.g_over_n_dot_v)(&directions)
    }

    /// f (n·l) with F = 1: D G/(4 n·v), per steradian of l. 0 below the horizon; finite at grazing.
    pub fn reflected(&self, l: [f64; 3], v: [f64; 3]) -> f64 {
        if l[2] <= 0.0 || v[2] < 0.0 {
            return 0.0;
        }
        let directions = self.directions(l, v);
        let cos2 = directions.n_dot_h * directions.n_dot_h;
        let d = self.ndf.d(cos2, (1.0 - cos2).max(0.0), &self.lobe);
        0.25 * d * (self.visibility.g_over_n_dot_v)(&directions)
    }

    fn directions(&self, l: [f64; 3], v: [f64; 3]) -> Directions {
        let h = half(l, v);
        Directions {
            n_dot_l: l[2],
            n_dot_v: v[2],
            n_dot_h: h[2],
            v_dot_h: v.iter().zip(h).map(|(v, h)| v * h).sum::<f64>().clamp(0.0, 1.0),
            sigma_l: self.ndf.sigma(l[2], &self.lobe),
            sigma_v: self.ndf.sigma(v[2], &self.lobe),
            alpha: self.lobe.alpha,
        }
    }
}

/// The unit vector half-way between two; the normal where they are opposite.
pub fn half(l: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    let sum: [f64; 3] = std::array::from_fn(|i| l[i] + v[i]);
    let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { sum.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::{At, Model};
    use crate::quadrature::gauss_legendre::gauss_legendre;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn reflected_integrates_to_the_albedo() {
        for (ndf, visibility) in [("ggx", "smith"), ("beckmann", "smith"), ("phong", "smith"), ("ggx", "schlick-ggx")] {
            let model = Model::parse(ndf, visibility).expect("valid");
            let brdf = Brdf::new(model.ndf, model.visibility, 0.8).expect("a lobe");
            let v = [0.6, 0.0, 0.8];
            let mut sum = 0.0;
            for node in gauss_legendre(200) {
                let cos = 0.5 + 0.5 * node.x;
                let sin = (1.0 - cos * cos).sqrt();
                for i in 0..200 {
                    let (y, x) = (TAU * (f64::from(i) + 0.5) / 200.0).sin_cos();
                    sum += 0.5 * node.weight * TAU / 200.0 * brdf.reflected([sin * x, sin * y, cos], v);
                }
            }
            let albedo = model.rule(At { n_dot_v: 0.8, roughness: 0.8 })[0];
            assert!((sum - albedo).abs() < 1e-6, "{ndf} {visibility}: {sum} {albedo}");
        }
    }

    #[test]
    fn d_is_normalised() {
        let model = Model::parse("beckmann", "smith").expect("valid");
        let brdf = Brdf::new(model.ndf, model.visibility, 0.7).expect("a lobe");
        let projected = |node: crate::quadrature::gauss_legendre::Node| {
            let theta = 0.25 * PI * (1.0 + node.x);
            0.25 * PI * node.weight * TAU * brdf.d(theta) * theta.cos() * theta.sin()
        };
        let sum: f64 = gauss_legendre(100).into_iter().map(projected).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
}
