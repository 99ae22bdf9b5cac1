// SPDX-License-Identifier: MIT OR Apache-2.0
//! The weight of F90 that a rough surface shows, of a generalised Schlick term F0 (1 − w) + F90 w, over n·v and roughness.
//!
//! weight = ∫ D(h) [G1(v)/(n·v)] (v·h) w(v·h) dh over the half vectors that reflect v to above the surface: the mean of w over
//! the facets that v sees, where those that reflect downwards count as 0. With w = (1 − v·h)^exponent, or as an exact
//! dielectric rises from F(1) to 1 ([`crate::term::fresnel::rescaled`]). A renderer takes F0 + (F90 − F0) weight for what the
//! surface reflects, all scattering included: shadowing, which only redirects, is not counted. This is what Blender Cycles
//! stores as `ggx_gen_schlick_s` over exponents and `ggx_gen_schlick_ior_s` over refractive indices.
//!
//! Limits: w(n·v) at roughness 0. Kernel: `shaders/bake/rings.comp`.

use super::albedo::channel;
use super::grid::Grid;
use super::model::MASKING;
use super::slice_axis::Kind;
use super::{At, AtNumber, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, TableRequest, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::term::fresnel::{Fresnel, Optics, power};
use crate::verify::truth;

/// The table.
pub struct SchlickWeight;

/// Schlick's own exponent.
const SCHLICK: Fresnel = Fresnel { term: &power::POWER, optics: Optics { given: [5.0, 0.0], ..Optics::NONE } };

static CHANNELS: [Channel; 1] = [channel("weight", "mean weight of F90 over the facets that the viewer sees")];

/// Over exponents, or over indices of dielectrics from outside.
static SLICES: &[(Kind, AtNumber)] = &[
    (Kind::Exponent, |exponent, request| with(request, Fresnel::power(exponent)?)),
    (Kind::Ior, |ior, request| with(request, Fresnel::rescaled(ior)?)),
];

fn with(request: TableRequest, fresnel: Fresnel) -> Result<TableRequest> {
    if request.fresnel.is_some() {
        let what = "an exponent or index beside an axis of them";
        return Err(Error::usage(what, "drop --exponent and --ior, or the axis"));
    }
    Ok(TableRequest { fresnel: Some(fresnel), ..request })
}

static FACTS: Facts = Facts {
    name: "schlick-weight",
    about: "weight of F90 in a generalised Schlick term (--exponent, or --ior for an exact dielectric) that a rough surface shows",
    source: "Blender Cycles, app/cycles_precompute.cpp: ggx_gen_schlick_s, ggx_gen_schlick_ior_s",
    usage: "share that the surface reflects, all scattering included = F0 + (F90 - F0) * weight",
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["weight"],
    fresnel: SCHLICK,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: SLICES,
    rule: Model::rule_name,
    tolerance: Tolerance {
        worst: 2e-6,
        median: 5e-7,
        near_zero: 4e-6,
        why: "tests/rings.rs: rule against truth 1e-6, llvmpipe 22.3.6 against the rule 3e-7",
    },
};

/// The model with the geometry term that the table is of.
fn masked(model: &Model) -> Model {
    Model { visibility: &MASKING, ..*model }
}

fn channels(weights: [f64; MAX_CHANNELS]) -> Values {
    [weights[1], 0.0, 0.0, 0.0]
}

impl Table for SchlickWeight {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn fresnel(&self, given: Option<Fresnel>) -> Result<Fresnel> {
        match given {
            None => Ok(SCHLICK),
            Some(fresnel) => match fresnel.term.name {
                "power" | "rescaled" => Ok(fresnel),
                "dielectric" => Fresnel::rescaled(fresnel.optics.eta[0]),
                _ => Err(Error::usage(
                    format!("schlick-weight has no Fresnel term '{fresnel}'"),
                    "give an --exponent, or the --ior of a dielectric from outside",
                )),
            },
        }
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        channels(masked(model).rule(at))
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let found = truth::albedo(&masked(model), at.n_dot_v, at.roughness, tolerance);
        Estimate { value: channels(found.value), ..found }
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let grid = Grid { stage: "schlick-weight", n_dot_v, roughness, first_slice: None };
        let mut texels = grid.run(backend, &masked(model), on)?;
        for texel in texels.as_chunks_mut::<MAX_CHANNELS>().0 {
            *texel = [texel[1], 0.0, 0.0, 0.0];
        }
        Ok(texels)
    }
}
