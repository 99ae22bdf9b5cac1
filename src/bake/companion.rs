// SPDX-License-Identifier: MIT OR Apache-2.0
//! Channels that engines keep in the same texture as a table, although they belong to another BRDF: cloth beside split-sum
//! (Filament, Babylon.js, glTF), diffuse and sheen terms (Unity's high definition pipeline).

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use super::diffuse::{self, Diffuse};
use super::grid::Grid;
use super::{At, Backend, Channel, Model, Tolerance};
use crate::error::Result;
use crate::ndf::alpha_of;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::term::fresnel::{Fresnel, WEIGHTS, Weights};
use crate::verify::truth;

/// A quantity over n·v and roughness.
pub struct Companion {
    /// Its channel.
    pub channel: Channel,
    /// Paper and equation, or the shader that defines it.
    pub source: &'static str,
    kind: Kind,
}

/// How it is computed.
#[derive(Clone, Copy)]
enum Kind {
    /// The directional albedo of another microfacet model.
    Albedo { ndf: &'static str, visibility: &'static str },
    /// An integral of Charlie's sheen as Unity stores it, over 2π and clamped: by index into the weights of the split sum.
    Charlie(usize),
    /// Unity's diffuse term of fabric: 1 − alpha/2, a constant of l and v.
    FabricLambert,
    /// A rough diffuse BRDF.
    Diffuse(&'static Diffuse),
    /// Burley's diffuse term as Unity normalises it.
    DisneyDiffuse,
}

/// Cloth: directional albedo of Charlie with Neubelt's term, as in Filament's third DFG channel.
const CLOTH: Kind = Kind::Albedo { ndf: "charlie", visibility: "neubelt" };

/// Every companion, in the order of their documentation.
pub static COMPANIONS: &[Companion] = &[
    Companion {
        channel: Channel {
            name: "cloth",
            meaning: "directional albedo of cloth: Charlie with Neubelt's term and F = 1",
            range: [0.0, f32::MAX],
        },
        source: "Estevez, Kulla 2017; Neubelt, Pettineo 2013",
        kind: CLOTH,
    },
    Companion {
        channel: Channel {
            name: "disney-diffuse",
            meaning: "directional albedo of Disney's diffuse term over 1.03571, less 1/2, clamped to [0, 1]",
            range: [0.0, 1.0],
        },
        source: "Burley 2012, Physically-Based Shading at Disney, section 5.3; Unity's BSDF.hlsl normalises by 1.03571",
        kind: Kind::DisneyDiffuse,
    },
    Companion {
        channel: Channel {
            name: "charlie-bias",
            meaning: "integral of sheen (Charlie with its own term) times (1 - v.h)^5, over 2 pi, clamped to [0, 1]",
            range: [0.0, 1.0],
        },
        source: "Estevez, Kulla 2017; Unity's preIntegratedFGD_CharlieFabricLambert.shader",
        kind: Kind::Charlie(1),
    },
    Companion {
        channel: Channel {
            name: "charlie-albedo",
            meaning: "directional albedo of sheen (Charlie with its own term), over 2 pi, clamped to [0, 1]",
            range: [0.0, 1.0],
        },
        source: "Estevez, Kulla 2017; Unity's preIntegratedFGD_CharlieFabricLambert.shader",
        kind: Kind::Charlie(0),
    },
    Companion {
        channel: Channel {
            name: "fabric-lambert",
            meaning: "albedo of Unity's diffuse term of fabric, 1 - alpha/2",
            range: [0.0, 1.0],
        },
        source: "Unity's BSDF.hlsl, FabricLambert",
        kind: Kind::FabricLambert,
    },
    Companion {
        channel: Channel {
            name: "oren-nayar",
            meaning: "directional albedo of Oren's and Nayar's simple form, sigma = roughness in radians; exceeds 1 at grazing",
            range: [0.0, 1.5],
        },
        source: "Oren, Nayar 1994, Generalization of Lambert's Reflectance Model, Eq. 30",
        kind: Kind::Diffuse(&diffuse::OREN_NAYAR),
    },
    Companion {
        channel: Channel {
            name: "oren-nayar-full",
            meaning: "directional albedo of Oren's and Nayar's full form, second bounce included; exceeds 1 at grazing",
            range: [0.0, 1.5],
        },
        source: "Oren, Nayar 1994, Generalization of Lambert's Reflectance Model, Eq. 27 to 29",
        kind: Kind::Diffuse(&diffuse::OREN_NAYAR_FULL),
    },
    Companion {
        channel: Channel {
            name: "eon-single",
            meaning: "directional albedo of EON's single scattering (Fujii's form); multiple scattering returns the rest of 1",
            range: [0.0, 1.0],
        },
        source: "Portsmouth, Kutz, Hill 2025, EON: A Practical Energy-Preserving Rough Diffuse BRDF",
        kind: Kind::Diffuse(&diffuse::FUJII),
    },
];

impl Companion {
    /// The microfacet model behind it, if there is one.
    fn model(&self) -> Option<Model> {
        let (ndf, visibility, fresnel) = match self.kind {
            Kind::Albedo { ndf, visibility } => (ndf, visibility, Fresnel::ONE),
            Kind::Charlie(_) => ("charlie", "charlie", Fresnel::SCHLICK),
            Kind::DisneyDiffuse | Kind::FabricLambert | Kind::Diffuse(_) => return None,
        };
        let model = Model::parse(ndf, visibility).expect("companions name models of the registries");
        Some(model.with(fresnel))
    }

    /// What is stored of the model's weights.
    fn of_weights(&self, weights: Weights) -> f64 {
        match self.kind {
            Kind::Charlie(weight) => (weights[weight] / TAU).min(1.0),
            _ => weights[0],
        }
    }

    /// What is stored where there is no model.
    fn closed_form(&self, at: At) -> f64 {
        match self.kind {
            Kind::FabricLambert => 1.0 - 0.5 * alpha_of(at.roughness),
            Kind::Diffuse(diffuse) => (diffuse.rule)(at.n_dot_v, at.roughness),
            _ => disney_diffuse(at),
        }
    }

    /// Least and greatest value in a table whose roughness is at least `roughness`. Cloth makes light at grazing angles,
    /// about 0.07/roughness times what comes.
    pub fn range(&self, roughness: f64) -> [f32; 2] {
        match self.kind {
            Kind::Albedo { .. } => [0.0, (0.25 / roughness).max(1.0) as f32],
            Kind::DisneyDiffuse | Kind::Charlie(_) | Kind::FabricLambert | Kind::Diffuse(_) => self.channel.range,
        }
    }

    /// Refuses a limit that does not exist, see [`Model::check_limits`].
    pub fn check_limits(&self, at_grazing: bool, at_mirror: bool) -> Result<()> {
        self.model().map_or(Ok(()), |model| model.check_limits(at_grazing, at_mirror))
    }

    /// The deterministic rule in f64.
    pub fn rule(&self, at: At) -> f64 {
        match self.model() {
            Some(model) => self.of_weights(model.rule(at)),
            None => self.closed_form(at),
        }
    }

    /// The rule and its nodes, in words.
    pub fn rule_name(&self) -> String {
        match self.model() {
            Some(model) => model.rule_name(),
            None => match self.kind {
                Kind::FabricLambert => "closed form".into(),
                Kind::Diffuse(diffuse) => diffuse.rule_name.into(),
                _ => format!("Gauss-Legendre, {DIFFUSE_NODES} nodes, which is exact"),
            },
        }
    }

    /// Independent adaptive integration, to about `tolerance`.
    pub fn truth(&self, at: At, tolerance: f64) -> Estimate<1> {
        match self.model() {
            Some(model) => {
                let found = truth::albedo(&model, at.n_dot_v, at.roughness, tolerance);
                Estimate { value: [self.of_weights(found.value)], error: found.error }
            }
            None => match self.kind {
                Kind::FabricLambert => fabric_truth(at, tolerance),
                Kind::Diffuse(diffuse) => diffuse.truth(at, tolerance),
                _ => disney_diffuse_truth(at, tolerance),
            },
        }
    }

    /// The bounds that its texels keep.
    pub fn tolerance(&self) -> Tolerance {
        let why = "src/bake/companion.rs: exact in f64, then rounded to f32";
        let rounding = Tolerance { worst: 2e-7, median: 5e-8, near_zero: 2e-7, why };
        self.model().map_or(rounding, |model| model.tolerance(&rounding))
    }

    /// Its value for every roughness (rows) and every n·v (columns).
    pub fn bake(
        &self,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let Some(model) = self.model() else {
            // A polynomial of 8 terms: no work for a device.
            let row = |roughness: &f64| {
                let roughness = *roughness;
                n_dot_v.iter().map(move |n_dot_v| self.closed_form(At { n_dot_v: *n_dot_v, roughness }) as f32)
            };
            return Ok(roughness.iter().flat_map(row).collect());
        };
        let grid = Grid { stage: self.channel.name, n_dot_v, roughness, first_slice: None };
        let texels = grid.run(backend, &model, on)?;
        let of_texel = |weights: &[f32; WEIGHTS]| self.of_weights(weights.map(f64::from)) as f32;
        Ok(texels.as_chunks::<WEIGHTS>().0.iter().map(of_texel).collect())
    }
}

/// Unity divides by this, the albedo at normal incidence and roughness 1, so that it does not exceed 1 there.
const DISNEY_NORMALIZATION: f64 = 1.03571;

/// The integrand is a polynomial of degree 8 in n·l.
const DIFFUSE_NODES: usize = 5;

static DIFFUSE: LazyLock<Vec<Node>> = LazyLock::new(|| gauss_legendre(DIFFUSE_NODES));

/// ∫ f (n·l) dω_l / 1.03571 − ½, clamped as an unsigned texture holds it, with f = (1 + (F − 1)(1 − n·l)⁵)(1 + (F − 1)(1 − n·v)⁵)/π and
/// F = ½ + roughness (1 + l·v). F is linear in the cosine of the azimuth, so the azimuth's mean is a closed form.
fn disney_diffuse(At { n_dot_v, roughness }: At) -> f64 {
    let view = (1.0 - n_dot_v).powi(5);
    let sum: f64 = DIFFUSE
        .iter()
        .map(|node| {
            let n_dot_l = 0.5 * (1.0 + node.x);
            let light = (1.0 - n_dot_l).powi(5);
            let mean = roughness * (1.0 + n_dot_l * n_dot_v) - 0.5;
            let swing2 = roughness * roughness * (1.0 - n_dot_l * n_dot_l) * (1.0 - n_dot_v * n_dot_v);
            let f = 1.0 + mean * (light + view) + (mean * mean + 0.5 * swing2) * light * view;
            node.weight * n_dot_l * f
        })
        .sum();
    stored(sum)
}

fn stored(albedo: f64) -> f64 {
    (albedo / DISNEY_NORMALIZATION - 0.5).clamp(0.0, 1.0)
}

/// The same by adaptive integration of the BRDF over azimuth and elevation, nothing simplified.
fn disney_diffuse_truth(at: At, tolerance: f64) -> Estimate<1> {
    let sin_v = (1.0 - at.n_dot_v * at.n_dot_v).sqrt();
    let brdf = |theta: f64, phi: f64| {
        let (sin_l, n_dot_l) = theta.sin_cos();
        let l_dot_v = sin_l * sin_v * phi.cos() + n_dot_l * at.n_dot_v;
        let f90 = 0.5 + at.roughness * (1.0 + l_dot_v);
        let scatter = |cos: f64| 1.0 + (f90 - 1.0) * (1.0 - cos).powi(5);
        scatter(n_dot_l) * scatter(at.n_dot_v) / PI
    };
    let ring = |theta: f64| {
        let inner = integrate(&[0.0, PI], 0.1 * tolerance, 1 << 10, |phi| Estimate {
            value: [2.0 * brdf(theta, phi)],
            error: 0.0,
        });
        let weight = theta.sin() * theta.cos();
        Estimate { value: [inner.value[0] * weight], error: inner.error * weight }
    };
    let found = integrate(&[0.0, PI / 2.0], 0.5 * tolerance, 1 << 10, ring);
    Estimate { value: [stored(found.value[0])], error: found.error / DISNEY_NORMALIZATION }
}

/// Fabric's diffuse term by adaptive integration of the constant BRDF over the cosine.
fn fabric_truth(at: At, tolerance: f64) -> Estimate<1> {
    let brdf = (1.0 - 0.5 * at.roughness * at.roughness) / PI;
    integrate(&[0.0, PI / 2.0], tolerance, 1 << 10, |theta| Estimate {
        value: [TAU * brdf * theta.sin() * theta.cos()],
        error: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disney_diffuse_is_its_truth() {
        for n_dot_v in [0.0, 0.03, 0.4, 1.0] {
            for roughness in [0.0, 0.5, 1.0] {
                let at = At { n_dot_v, roughness };
                let truth = disney_diffuse_truth(at, 1e-9);
                let error = (disney_diffuse(at) - truth.value[0]).abs();
                assert!(error <= 1e-9 + truth.error, "{at:?}: off by {error:.1e}");
            }
        }
    }

    #[test]
    fn normalization_is_the_albedo_at_normal_incidence() {
        // Unity rounds it to six digits.
        let albedo = (disney_diffuse(At { n_dot_v: 1.0, roughness: 1.0 }) + 0.5) * DISNEY_NORMALIZATION;
        assert!((albedo - DISNEY_NORMALIZATION).abs() < 5e-6, "{albedo}");
    }
}
