// SPDX-License-Identifier: MIT OR Apache-2.0
//! Averages of a rough dielectric interface, 2 ∫₀¹ X mu dmu of what it reflects, transmits, and of both: over roughness at
//! one refractive index. See [`super::glass`].
//!
//! Reciprocity ties both sides: transmitted (eta) = eta² · transmitted (1/eta). At roughness 0 these are the averages of
//! Fresnel's F and 1 − F.

use super::albedo::channel;
use super::average_albedo::{mean_truth, means, nodes};
use super::glass::{self, Lobes, TOLERANCE, WINDOW};
use super::grid::Grid;
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Values};
use crate::axis::Coordinate;
use crate::error::Result;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;

/// The table, or the part of it that reflects.
pub struct GlassAverage(Lobes);

/// All of it.
pub static GLASS_AVERAGE: GlassAverage = GlassAverage(Lobes::Both);
static REFLECTING: GlassAverage = GlassAverage(Lobes::Reflected);

static CHANNELS: [Channel; 4] = [
    channel("reflected", "mean share that single scattering reflects"),
    channel("transmitted", "mean share that single scattering transmits, of power"),
    channel("total", "reflected + transmitted"),
    channel("lost", "1 - total: mean of what single scattering loses"),
];
static UNREFLECTED: Channel = channel("unreflected", "1 - reflected: mean of what single scattering does not reflect");

static FACTS: Facts = Facts {
    name: "glass-average",
    about: "hemispherical means of a rough dielectric interface over roughness, from outside or inside",
    source: "Walter, Marschner, Li, Torrance 2007, Microfacet Models for Refraction through Rough Surfaces",
    usage: "mean of the energy that single scattering loses = 1 - total",
    channels: |_| &CHANNELS,
    complement: Some(&UNREFLECTED),
    default_channels: |_| &["reflected", "transmitted"],
    fresnel: WINDOW,
    axes: &[Coordinate::Roughness],
    slices: glass::SLICES,
    rule: |model| {
        format!("{} Gauss-Legendre nodes of sqrt(n_dot_v) x ({})", nodes(model).len(), glass::rule_name(model))
    },
    tolerance: TOLERANCE,
};

impl Table for GlassAverage {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn narrowed(&self, values: &[usize]) -> Option<&'static dyn Table> {
        (Lobes::needed(values) == Lobes::Reflected).then_some(&REFLECTING)
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        let mut sum = [0.0; MAX_CHANNELS];
        for node in nodes(model) {
            let values = glass::rule(model, At { n_dot_v: node.x, ..at }, self.0);
            sum.iter_mut().zip(values).for_each(|(s, v)| *s += node.weight * v);
        }
        sum
    }

    fn check(&self, model: &Model) -> Result<()> {
        glass::check(model)
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let of = |n_dot_v| glass::truth(model, At { n_dot_v, ..at }, self.0, 0.5 * tolerance);
        mean_truth(at.roughness, tolerance, of)
    }

    fn bake(
        &self,
        model: &Model,
        _n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let rule = nodes(model);
        let n_dot_v: Vec<f64> = rule.iter().map(|n| n.x).collect();
        let grid = Grid { stage: "glass-average", n_dot_v: &n_dot_v, roughness, first_slice: None };
        Ok(means(&glass::on_grid(grid, model, self.0, backend, on)?, &rule))
    }
}
