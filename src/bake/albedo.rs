//! Directional albedo E(n·v, roughness) = ∫ f (n·l) dω_l with F = 1: the share of light that single scattering keeps.
//! 1 − E is what energy compensation has to give back (Kulla and Conty 2017).
//!
//! Limits: 1 at roughness 0; 1 at n·v = 0 with height-correlated Smith; 1 − ln 2 at n·v = 1, roughness 1.
//! Kernel: `shaders/bake/albedo.comp`.

use super::grid::Grid;
use super::split_sum::bake_pairs;
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::Result;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::verify::truth;

/// The table.
pub struct Albedo;

static FACTS: Facts = Facts {
    name: "albedo",
    about: "directional albedo with F = 1, for energy compensation",
    source: "Kulla, Conty 2017, Revisiting Physically Based Shading at Imageworks",
    usage: "energy lost by single scattering = 1 - albedo",
    channels: &[Channel { name: "albedo", meaning: "directional albedo with F = 1", range: [0.0, 1.0] }],
    default_channels: &["albedo"],
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    rule: Model::rule_name,
    tolerance: Tolerance {
        worst: 1e-6,
        median: 2.5e-7,
        near_zero: 2e-6,
        why: "256x256 centers and edges, both Smith terms, llvmpipe 22.3.6: 5.8e-7 worst, 1.0e-7 median",
    },
};

/// Directional albedo over the whole grid; [`super::average_albedo`] integrates it further.
pub(super) fn bake_grid(
    grid: &Grid<'_>,
    model: &Model,
    backend: &Backend,
    on: &mut OnProgress<'_>,
) -> Result<Vec<f32>> {
    if !model.uses_cone() {
        let pairs = bake_pairs(&Grid { channels: 2, ..*grid }, model, backend, on)?;
        return Ok(pairs.chunks_exact(2).map(|p| p[0] + p[1]).collect());
    }
    let rule = |at, out: &mut [f32]| out[0] = model.rule(at)[0] as f32;
    grid.run(backend, &format!("bake/albedo+{}", model.visibility.file), model, rule, on)
}

impl Table for Albedo {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        [model.rule(at)[0], 0.0, 0.0]
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let t = truth::albedo(model, at.n_dot_v, at.roughness, tolerance);
        Estimate { value: [t.value[0], 0.0, 0.0], error: t.error }
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let grid = Grid { stage: "albedo", n_dot_v, roughness, channels: 1, first_slice: None };
        bake_grid(&grid, model, backend, on)
    }
}
