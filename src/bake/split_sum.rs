//! Split-sum table (Karis 2013, "Real Shading in Unreal Engine 4"): specular reflection of a white environment with
//! Schlick's Fresnel term, split so that F0 stays outside.
//!
//! scale = ∫ f/F (1 − Fc)(n·l) dω_l, bias = ∫ f/F Fc (n·l) dω_l, Fc = (1 − v·h)⁵; albedo = scale + bias.
//! A shader rebuilds the reflection of a white environment as F0·scale + F90·bias.
//!
//! Limits: roughness 0 is a mirror, (1 − (1 − n·v)⁵, (1 − n·v)⁵). At n·v = 0 with height-correlated Smith albedo is 1.
//! At n·v = 1, roughness 1 albedo is 1 − ln 2. Kernel: `shaders/bake/split_sum.comp`.

use super::grid::Grid;
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::Result;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::verify::truth;

/// The table.
pub struct SplitSum;

static FACTS: Facts = Facts {
    name: "split-sum",
    about: "scale and bias of F0: reflection of a white environment with Schlick's Fresnel",
    source: "Karis 2013, Real Shading in Unreal Engine 4",
    usage: "specular = F0 * scale + F90 * bias; albedo = scale + bias",
    channels: &[
        Channel { name: "scale", meaning: "factor of F0", range: [0.0, 1.0] },
        Channel { name: "bias", meaning: "factor of F90", range: [0.0, 1.0] },
        Channel { name: "albedo", meaning: "scale + bias: directional albedo with F = 1", range: [0.0, 1.0] },
    ],
    default_channels: &["scale", "bias"],
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
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
        let [e, b] = model.rule(at);
        [e - b, b, e]
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let t = truth::albedo(model, at.n_dot_v, at.roughness, tolerance);
        let [e, b] = t.value;
        Estimate { value: [e - b, b, e], error: t.error }
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let grid = Grid { stage: "split-sum", n_dot_v, roughness, channels: 2, first_slice: None };
        let pairs = bake_pairs(&grid, model, backend, on)?;
        Ok(pairs.chunks_exact(2).flat_map(|p| [p[0], p[1], p[0] + p[1]]).collect())
    }
}

/// (scale, bias) over the whole grid.
pub(super) fn bake_pairs(
    grid: &Grid<'_>,
    model: &Model,
    backend: &Backend,
    on: &mut OnProgress<'_>,
) -> Result<Vec<f32>> {
    let rule = |at, out: &mut [f32]| {
        let [e, b] = model.rule(at);
        out.copy_from_slice(&[(e - b) as f32, b as f32]);
    };
    let folder = if model.uses_cone() { "split_sum" } else { "h_split" };
    grid.run(backend, &format!("bake/{folder}+{}", model.visibility.file), model, rule, on)
}
