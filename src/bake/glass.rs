// SPDX-License-Identifier: MIT OR Apache-2.0
//! A rough dielectric interface: what single scattering reflects and transmits, over n·v and roughness at one refractive
//! index (Walter, Marschner, Li, Torrance 2007). The index is that behind the surface over that before it: above 1 seen
//! from outside, below 1 from inside.
//!
//! reflected = ∫ f_r (n·l) dω_l, transmitted = ∫ f_t |n·l| dω_l over the other side, total = reflected + transmitted; what
//! is missing from 1 is lost to shadowing, masking, and to rays that a facet refracts or reflects to the wrong side: those
//! are not counted. Transmitted is a share of power: radiance behind the surface is eta² times as large in proportion.
//!
//! Limits: at roughness 0 Fresnel's F and 1 − F at n·v. From inside nothing is transmitted at n·v = 0. Averages over n·v
//! obey reciprocity, transmitted average (eta) = eta² · transmitted average (1/eta). Kernels: those of the albedo, and
//! `shaders/bake/transmit.comp`.

use super::albedo::channel;
use super::grid::Grid;
use super::slice_axis::Kind;
use super::{At, AtNumber, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, TableRequest, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::rule::transmit;
use crate::term::fresnel::{Fresnel, IOR_RANGE, Optics, dielectric};
use crate::verify::{refraction, truth};

/// The table, or the part of it that reflects.
pub struct Glass(Lobes);

/// All of it.
pub static GLASS: Glass = Glass(Lobes::Both);
static REFLECTING: Glass = Glass(Lobes::Reflected);

/// What is computed of an interface. What is transmitted costs most of the time.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Lobes {
    /// All of its values.
    Both,
    /// Only `reflected` is right: nothing counts as transmitted.
    Reflected,
}

impl Lobes {
    /// What these of the values need.
    pub(super) fn needed(values: &[usize]) -> Lobes {
        if values.iter().all(|value| *value == REFLECTED) { Lobes::Reflected } else { Lobes::Both }
    }
}

/// The place of `reflected` among the values.
const REFLECTED: usize = 0;

/// Crown glass from outside.
pub(super) const WINDOW: Fresnel =
    Fresnel { term: &dielectric::DIELECTRIC, optics: Optics { eta: [1.5; 3], ..Optics::NONE } };

static CHANNELS: [Channel; 4] = [
    channel("reflected", "share that single scattering reflects"),
    channel("transmitted", "share that single scattering transmits, of power"),
    channel("total", "reflected + transmitted"),
    channel("lost", "1 - total: what single scattering loses"),
];
static UNREFLECTED: Channel = channel("unreflected", "1 - reflected: what single scattering does not reflect");

static FACTS: Facts = Facts {
    name: "glass",
    about: "rough dielectric interface: reflected, transmitted and their sum, from outside (--ior above 1) or inside (below 1)",
    source: "Walter, Marschner, Li, Torrance 2007, Microfacet Models for Refraction through Rough Surfaces",
    usage: "energy that single scattering loses = 1 - total; both lobes divided by total keep all",
    channels: |_| &CHANNELS,
    complement: Some(&UNREFLECTED),
    default_channels: |_| &["reflected", "transmitted"],
    fresnel: WINDOW,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: SLICES,
    rule: rule_name,
    tolerance: TOLERANCE,
};

/// From outside; from inside [`Model::tolerance`] has its own.
pub(super) const TOLERANCE: Tolerance = Tolerance {
    worst: 2e-6,
    median: 5e-7,
    near_zero: 4e-6,
    why: "tests/energy.rs: rule against truth 3e-7, llvmpipe 22.3.6 against the rule 6e-7",
};

/// Over indices, of either side, 1 for no interface included.
pub(super) static SLICES: &[(Kind, AtNumber)] = &[(Kind::Ior, |ior, request| match request.fresnel {
    None => Ok(TableRequest { fresnel: Some(Fresnel::interface(ior)), ..request }),
    Some(_) => Err(Error::usage("an index beside an axis of indices", "drop --ior, or the axis")),
})];

/// Both rules in words.
pub(super) fn rule_name(model: &Model) -> String {
    format!("{}; {}", model.rule_name(), transmit::rule_name(&model.fresnel))
}

/// Refuses what is no dielectric interface that the rule for transmission knows.
pub(super) fn check(model: &Model) -> Result<()> {
    if !["dielectric", "internal"].contains(&model.fresnel.term.name) {
        return Err(Error::usage(
            format!("glass is a dielectric, which the Fresnel term '{}' is not", model.fresnel),
            "give its refractive index, --ior 1.5, or --ior 0.6667 from inside",
        ));
    }
    let is_ggx = model.ndf.family.name == "ggx" && !model.is_anisotropic();
    if !is_ggx || model.visibility.name != "smith" {
        return Err(Error::usage(
            format!("transmission is baked for ggx with smith, not for {} with {}", model.ndf, model.visibility.name),
            "drop --ndf and --visibility; `bake albedo --ior` has what others reflect",
        ));
    }
    Ok(())
}

/// Media of the same index: there is no interface, and none of its facets.
pub(super) fn is_nothing(model: &Model) -> bool {
    model.fresnel.optics.eta[0] == 1.0
}

/// (reflected, transmitted, total, lost) from what is reflected and transmitted.
pub(super) fn channels(reflected: f64, transmitted: f64) -> Values {
    let total = reflected + transmitted;
    [reflected, transmitted, total, 1.0 - total]
}

/// The lobes by the rule.
pub(super) fn rule(model: &Model, at: At, lobes: Lobes) -> Values {
    if is_nothing(model) {
        return channels(0.0, 1.0);
    }
    channels(model.rule(at)[1], if lobes == Lobes::Both { model.transmitted(at) } else { 0.0 })
}

/// What the truth says of them.
pub(super) fn truth(model: &Model, at: At, lobes: Lobes, tolerance: f64) -> Estimate<MAX_CHANNELS> {
    if is_nothing(model) {
        return Estimate { value: channels(0.0, 1.0), error: 0.0 };
    }
    let reflected = truth::reflected(model, at.n_dot_v, at.roughness, 0.5 * tolerance);
    let transmitted = match lobes {
        Lobes::Both => refraction::transmitted(model, at.n_dot_v, at.roughness, 0.5 * tolerance),
        Lobes::Reflected => Estimate { value: [0.0], error: 0.0 },
    };
    Estimate { value: channels(reflected.value[0], transmitted.value[0]), error: reflected.error + transmitted.error }
}

/// The lobes on a grid: [`MAX_CHANNELS`] values a texel.
pub(super) fn on_grid(
    grid: Grid<'_>,
    model: &Model,
    lobes: Lobes,
    backend: &Backend,
    on: &mut OnProgress<'_>,
) -> Result<Vec<f32>> {
    if is_nothing(model) {
        return Ok(channels(0.0, 1.0).map(|v| v as f32).repeat(grid.n_dot_v.len() * grid.roughness.len()));
    }
    // The cone through which light leaves a medium of a far larger index is narrower than single floats resolve.
    let [least, most] = IOR_RANGE;
    let backend = if (least..=most).contains(&model.fresnel.optics.eta[0]) { backend } else { &Backend::Cpu };
    let mut texels = grid.run(backend, model, on)?;
    let transmitted = match lobes {
        Lobes::Both => grid.transmitted(backend, model, on)?,
        Lobes::Reflected => vec![0.0; texels.len()],
    };
    for (texel, transmitted) in
        texels.as_chunks_mut::<MAX_CHANNELS>().0.iter_mut().zip(transmitted.as_chunks::<MAX_CHANNELS>().0)
    {
        let [_, reflected, ..] = *texel;
        *texel = channels(f64::from(reflected), f64::from(transmitted[0])).map(|v| v as f32);
    }
    Ok(texels)
}

impl Table for Glass {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn narrowed(&self, values: &[usize]) -> Option<&'static dyn Table> {
        (Lobes::needed(values) == Lobes::Reflected).then_some(&REFLECTING)
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        rule(model, at, self.0)
    }

    fn check(&self, model: &Model) -> Result<()> {
        check(model)
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        truth(model, at, self.0, tolerance)
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        on_grid(Grid { stage: "glass", n_dot_v, roughness, first_slice: None }, model, self.0, backend, on)
    }
}
