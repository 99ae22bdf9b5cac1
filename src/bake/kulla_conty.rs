// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tint of Kulla and Conty's lobe for multiple scattering, over roughness and, in rows, over Schlick's F0.
//!
//! tint = F_avg² average/(1 − F_avg (1 − average)) with F_avg = 2 ∫₀¹ F(mu) mu dmu, which is (20 F0 + 1)/21 for Schlick's
//! term: all further bounces between facets, each of which keeps F_avg, and of which the share `average` leaves. A shader
//! multiplies (1 − E(n·l)) (1 − E(n·v))/(π (1 − average)) by it.
//!
//! Limits: 1 at F0 = 1 for every roughness; F_avg² at roughness 0.

use super::albedo::channel;
use super::average_albedo::AverageAlbedo;
use super::slice_axis::Kind;
use super::{At, AtNumber, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, TableRequest, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::term::fresnel::Fresnel;

/// The table.
pub struct KullaConty;

static CHANNELS: [Channel; 1] =
    [channel("tint", "F_avg^2 average / (1 - F_avg (1 - average)), F_avg = (20 F0 + 1)/21")];

/// Over F0.
pub(super) static SLICES: &[(Kind, AtNumber)] = &[(Kind::F0, |f0, request| match request.fresnel {
    None => Ok(TableRequest { fresnel: Some(Fresnel::schlick(f0)?), ..request }),
    Some(_) => Err(Error::usage("an F0 beside an axis of F0", "drop --f0, or the axis")),
})];

static FACTS: Facts = Facts {
    name: "kulla-conty",
    about: "tint of the multiple scattering lobe for Schlick's term (--f0, or axis f0=FROM/TO) over roughness",
    source: "Kulla, Conty 2017, Revisiting Physically Based Shading at Imageworks, appendix",
    usage: "multiple scattering lobe = tint * (1 - E(n_dot_l)) * (1 - E(n_dot_v)) / (pi * (1 - average))",
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["tint"],
    fresnel: Fresnel::GLASS,
    axes: &[Coordinate::Roughness],
    slices: SLICES,
    rule: |model| format!("closed form of {}", (AverageAlbedo.facts().rule)(model)),
    tolerance: Tolerance {
        worst: 1e-6,
        median: 2.5e-7,
        near_zero: 2e-6,
        why: "the average albedo's, of which it is a function of slope at most 1",
    },
};

/// The tint from F0 and the average albedo with F = 1. Kulla, Conty 2017, appendix.
pub(super) fn tint(f0: f64, average: f64) -> f64 {
    let f = (20.0 * f0 + 1.0) / 21.0;
    f * f * average / (1.0 - f * (1.0 - average))
}

/// Refuses what is not Schlick's term at an F0 over a lobe of the cone rule, whose average is within its bounds.
pub(super) fn check(name: &str, model: &Model) -> Result<()> {
    if !std::ptr::eq(model.fresnel.term, Fresnel::SCHLICK.term) {
        return Err(Error::usage(
            format!("{name} is for Schlick's Fresnel term, not for '{}'", model.fresnel),
            "give --f0; docs/energy.md has the formula for any other average reflectance",
        ));
    }
    if !(model.ndf.family.name == "ggx" && !model.is_anisotropic() && model.visibility.smith && model.bounded()) {
        return Err(Error::usage(
            format!("{name} is baked for ggx with a Smith term, not for {} with {}", model.ndf, model.visibility.name),
            "drop --ndf and --visibility; docs/energy.md has the formula",
        ));
    }
    Ok(())
}

impl Table for KullaConty {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn check(&self, model: &Model) -> Result<()> {
        check(FACTS.name, model)
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        [tint(model.fresnel.f0(), AverageAlbedo.rule(model, at)[0]), 0.0, 0.0, 0.0]
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        // The slope over the average is at most 1.
        let average = AverageAlbedo.truth(model, at, tolerance);
        Estimate { value: [tint(model.fresnel.f0(), average.value[0]), 0.0, 0.0, 0.0], ..average }
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let mut texels = AverageAlbedo.bake(model, n_dot_v, roughness, backend, on)?;
        for texel in texels.as_chunks_mut::<MAX_CHANNELS>().0 {
            *texel = [tint(model.fresnel.f0(), f64::from(texel[0])) as f32, 0.0, 0.0, 0.0];
        }
        Ok(texels)
    }
}
