//! Average albedo E_avg(roughness) = 2 ∫₀¹ E(mu, roughness) mu dmu: the hemispherical mean of the directional albedo.
//!
//! Limits: 1 at roughness 0; 4/3 (1 − ln 2) at roughness 1 with height-correlated Smith. This is the integral of the
//! true E. A furnace test that reads a stored E table through a bilinear filter closes exactly only with the integral of
//! that filtered table, which differs by up to 3e-5 (64 texels) or 2e-6 (256 texels).
//!
//! The kernel is the directional albedo's: it runs at Gauss–Legendre nodes of x, mu = x², where E is smooth, and the
//! host sums up in f64.

use std::sync::LazyLock;

use super::albedo::bake_grid;
use super::grid::Grid;
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::Result;
use crate::ndf::alpha_of;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::verify::truth;

/// The table.
pub struct AverageAlbedo;

/// 16 nodes reach 6e-8 for height-correlated Smith at every roughness; 20 leave the cone rule's error alone.
const NODES: usize = 20;

/// n·v and weights of E in 2 ∫ E mu dmu.
static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| {
    let map = |node: Node| {
        let x = 0.5 * (1.0 + node.x);
        Node { x: x * x, weight: 2.0 * node.weight * x * x * x }
    };
    gauss_legendre(NODES).into_iter().map(map).collect()
});

static FACTS: Facts = Facts {
    name: "average-albedo",
    about: "hemispherical mean of the albedo over roughness, for energy compensation",
    source: "Kulla, Conty 2017, Revisiting Physically Based Shading at Imageworks",
    usage: "multiple scattering lobe = (1 - E(n_dot_l)) * (1 - E(n_dot_v)) / (pi * (1 - average))",
    channels: &[Channel { name: "average", meaning: "2 * integral of albedo * n_dot_v", range: [0.0, 1.0] }],
    default_channels: &["average"],
    axes: &[Coordinate::Roughness],
    rule: |model| format!("{NODES} Gauss-Legendre nodes of sqrt(n_dot_v) x {}", model.rule_name()),
    tolerance: Tolerance {
        worst: 1e-6,
        median: 2.5e-7,
        near_zero: 2e-6,
        why: "256 centers and edges, both Smith terms, llvmpipe 22.3.6: 2e-7 worst, 5e-8 median",
    },
};

impl Table for AverageAlbedo {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        let e = |node: &Node| node.weight * model.rule(At { n_dot_v: node.x, ..at })[0];
        [RULE.iter().map(e).sum(), 0.0, 0.0]
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let alpha = alpha_of(at.roughness);
        // Geometric panels down to the scale of alpha, where E changes: on one wide panel a coarse and a fine rule can
        // agree by missing the same dip.
        let mut breaks = vec![1.0];
        while breaks[breaks.len() - 1] > 0.1 * alpha.max(1e-3) {
            breaks.push(0.3 * breaks[breaks.len() - 1]);
        }
        breaks.push(0.0);
        breaks.reverse();
        let found = integrate(&breaks, 0.5 * tolerance, 100, |mu| {
            let e = truth::albedo(model, mu, at.roughness, 0.2 * tolerance);
            Estimate { value: [2.0 * mu * e.value[0], 0.0, 0.0], error: 2.0 * mu * e.error }
        });
        Estimate { error: found.error.max(tolerance), ..found }
    }

    fn bake(
        &self,
        model: &Model,
        _n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let nodes: Vec<f64> = RULE.iter().map(|n| n.x).collect();
        let grid = Grid { stage: "average-albedo", n_dot_v: &nodes, roughness, channels: 1, first_slice: None };
        let e = bake_grid(&grid, model, backend, on)?;
        let row = |e: &[f32]| e.iter().zip(RULE.iter()).map(|(e, n)| n.weight * f64::from(*e)).sum::<f64>() as f32;
        Ok(e.chunks_exact(nodes.len()).map(row).collect())
    }
}
