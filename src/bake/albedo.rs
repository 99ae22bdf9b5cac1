// SPDX-License-Identifier: MIT OR Apache-2.0
//! Directional albedo E(n·v, roughness) = ∫ f (n·l) dω_l with F = 1: the share of light that single scattering keeps.
//! 1 − E is what energy compensation has to give back (Kulla and Conty 2017). With an exact Fresnel term it is the share
//! that a smooth-faceted dielectric or metal reflects.
//!
//! Limits with F = 1: 1 at roughness 0; 1 at n·v = 0 with height-correlated Smith; 1 − ln 2 at n·v = 1, roughness 1.
//! Kernels: `shaders/bake/cone.comp`, `shaders/bake/h_split.comp`.

use super::grid::Grid;
use super::slice_axis::Kind;
use super::{At, AtNumber, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, TableRequest, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::term::fresnel::Fresnel;
use crate::verify::truth;

/// The table.
pub struct Albedo;

static FACTS: Facts = Facts {
    name: "albedo",
    about: "directional albedo, for energy compensation: with F = 1, an exact dielectric or an exact conductor",
    source: "Kulla, Conty 2017, Revisiting Physically Based Shading at Imageworks",
    usage: "energy lost by single scattering = 1 - albedo",
    channels: |fresnel| {
        by_reflectances(fresnel, &CHANNELS[..1], &CHANNELS, of_colour(fresnel, &CONDUCTOR_CHANNELS, &FILM_CHANNELS))
    },
    // F = 1 answers only where no Fresnel term was given.
    complement: Some(&LOST),
    default_channels: |fresnel| by_reflectances(fresnel, &["albedo"], &["reflected"], &["red", "green", "blue"]),
    fresnel: Fresnel::ONE,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: &[OVER_FILM, OVER_AZIMUTH],
    rule: Model::rule_name,
    tolerance: Tolerance {
        worst: 1e-6,
        median: 2.5e-7,
        near_zero: 2e-6,
        why: "256x256 centers and edges, both Smith terms, llvmpipe 22.3.6: 5.8e-7 worst, 1.0e-7 median",
    },
};

/// Over thicknesses of the film that was asked for.
pub(super) const OVER_FILM: (Kind, AtNumber) = (Kind::FilmNm, |nm, request| match request.fresnel {
    Some(fresnel) if fresnel.term.name == "film" => {
        Ok(TableRequest { fresnel: Some(fresnel.with_film_nm(nm)), ..request })
    }
    _ => Err(Error::usage("film thicknesses without a film", "give its refractive index, --film 1.33, and its base")),
});

/// Over azimuths of an anisotropic lobe, in degrees: with a file for each ratio all that it depends on.
const OVER_AZIMUTH: (Kind, AtNumber) = (Kind::Azimuth, |degrees, request| {
    if !request.ndf.contains("ratio=") || request.ndf.contains("azimuth=") {
        let what = format!("an axis of azimuths over the distribution '{}'", request.ndf);
        return Err(Error::usage(what, "give an anisotropic lobe without its azimuth, --ndf ggx:ratio=0.3"));
    }
    Ok(TableRequest { ndf: format!("{},azimuth={degrees}", request.ndf), ..request })
});

/// A channel of shares, in [0, 1].
pub(super) const fn channel(name: &'static str, meaning: &'static str) -> Channel {
    Channel { name, meaning, range: [0.0, 1.0] }
}

static LOST: Channel = channel("lost", "1 - albedo: what single scattering loses, F = 1");
static CHANNELS: [Channel; 2] =
    [channel("albedo", "directional albedo with F = 1"), channel("reflected", "directional albedo with the exact F")];
static CONDUCTOR_CHANNELS: [Channel; 4] = [
    channel("albedo", "directional albedo with F = 1"),
    channel("red", "directional albedo with the exact F of red"),
    channel("green", "directional albedo with the exact F of green"),
    channel("blue", "directional albedo with the exact F of blue"),
];

static FILM_CHANNELS: [Channel; 4] = [
    channel("albedo", "directional albedo with F = 1"),
    interference("red", "directional albedo with the film's F of red"),
    interference("green", "directional albedo with the film's F of green"),
    interference("blue", "directional albedo with the film's F of blue"),
];

/// A channel of interference colours, which may lie outside the primaries of sRGB.
pub(super) const fn interference(name: &'static str, meaning: &'static str) -> Channel {
    Channel { name, meaning, range: [-0.5, 1.5] }
}

/// What fits a conductor, or a film.
pub(super) fn of_colour<T>(fresnel: &Fresnel, conductor: T, film: T) -> T {
    if fresnel.term.name == "film" { film } else { conductor }
}

/// What fits a Fresnel term of no reflectance beside F = 1, of one (a dielectric's, a single weight), or of red, green and
/// blue.
pub(super) fn by_reflectances<T>(fresnel: &Fresnel, none: T, one: T, three: T) -> T {
    match fresnel.term.name {
        "dielectric" | "internal" | "power" | "rescaled" => one,
        "conductor" | "film" => three,
        _ => none,
    }
}

impl Table for Albedo {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        model.rule(at)
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        truth::albedo(model, at.n_dot_v, at.roughness, tolerance)
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        Grid { stage: "albedo", n_dot_v, roughness, first_slice: None }.run(backend, model, on)
    }
}
