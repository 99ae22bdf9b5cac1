// SPDX-License-Identifier: MIT OR Apache-2.0
//! Split-sum table (Karis 2013, "Real Shading in Unreal Engine 4"): specular reflection of a white environment with
//! Schlick's Fresnel term, split so that F0 stays outside.
//!
//! scale = ∫ f/F (1 − Fc)(n·l) dω_l, bias = ∫ f/F Fc (n·l) dω_l, Fc = (1 − v·h)⁵; albedo = scale + bias.
//! A shader rebuilds the reflection of a white environment as F0·scale + F90·bias. f82 = ∫ f/F (v·h)(1 − v·h)⁶ (n·l) dω_l
//! tints the edge of metals (Kutz, Hašan, Edmondson 2021): subtract b·f82, b = (1 − tint)(F0 + (1 − F0)(6/7)⁵)·7·(7/6)⁶.
//!
//! Limits: roughness 0 is a mirror, (1 − (1 − n·v)⁵, (1 − n·v)⁵). At n·v = 0 with height-correlated Smith albedo is 1.
//! At n·v = 1, roughness 1 albedo is 1 − ln 2. Kernels: `shaders/bake/cone.comp`, `shaders/bake/h_split.comp`.

use super::grid::Grid;
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::term::fresnel::{Fresnel, Weights};
use crate::verify::truth;

/// The table.
pub struct SplitSum;

static CHANNELS: [Channel; 4] = [
    Channel { name: "scale", meaning: "factor of F0", range: [0.0, 1.0] },
    Channel { name: "bias", meaning: "factor of F90", range: [0.0, 1.0] },
    Channel { name: "albedo", meaning: "scale + bias: directional albedo with F = 1", range: [0.0, 1.0] },
    // c (1 − c)⁶ is at most (1/7)(6/7)⁶ = 0.0567.
    Channel { name: "f82", meaning: "what the F82 tint takes away", range: [0.0, 0.0567] },
];

pub(super) static FACTS: Facts = Facts {
    name: "split-sum",
    about: "scale and bias of F0: reflection of a white environment with Schlick's Fresnel",
    source: "Karis 2013, Real Shading in Unreal Engine 4",
    usage: "specular = F0 * scale + F90 * bias; albedo = scale + bias; F82 tint: - (1 - tint) * (F0 + (1 - F0) * 0.462664) \
            * 17.651385 * f82",
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["scale", "bias"],
    fresnel: Fresnel::SCHLICK,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: &[],
    rule: Model::rule_name,
    tolerance: Tolerance {
        worst: 1e-6,
        median: 2.5e-7,
        near_zero: 2e-6,
        why: "256x256 centers and edges, both Smith terms, llvmpipe 22.3.6: 5.9e-7 worst, 1.0e-7 median",
    },
};

impl Table for SplitSum {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        channels(model.rule(at))
    }

    fn check(&self, model: &Model) -> Result<()> {
        if std::ptr::eq(model.fresnel.term, Fresnel::SCHLICK.term) && model.fresnel.f0() == 0.0 {
            return Ok(());
        }
        Err(Error::usage(
            format!("split-sum holds Schlick's split, not the Fresnel term '{}'", model.fresnel),
            "drop --f0, which a shader multiplies with; bake albedo with --ior, --eta-k or --material",
        ))
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let t = truth::albedo(model, at.n_dot_v, at.roughness, tolerance);
        Estimate { value: channels(t.value), error: t.error }
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let grid = Grid { stage: "split-sum", n_dot_v, roughness, first_slice: None };
        let mut texels = grid.run(backend, model, on)?;
        for texel in texels.as_chunks_mut().0 {
            *texel = channels(texel.map(f64::from)).map(|v| v as f32);
        }
        Ok(texels)
    }
}

/// (scale, bias, albedo, f82) from integrals over the weights 1, (1 − v·h)⁵ and (v·h)(1 − v·h)⁶.
fn channels([e, b, tint, _]: Weights) -> Values {
    [e - b, b, e, tint]
}
