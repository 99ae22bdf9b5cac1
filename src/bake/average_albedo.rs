// SPDX-License-Identifier: MIT OR Apache-2.0
//! Average albedo E_avg(roughness) = 2 ∫₀¹ E(mu, roughness) mu dmu: the hemispherical mean of the directional albedo.
//!
//! Limits: 1 at roughness 0; 4/3 (1 − ln 2) at roughness 1 with height-correlated Smith. This is the integral of the
//! true E. A furnace test that reads a stored E table through a bilinear filter closes exactly only with the integral of
//! that filtered table, which differs by up to 3e-5 (64 texels) or 2e-6 (256 texels).
//!
//! The kernel is the directional albedo's: it runs at Gauss–Legendre nodes of x, mu = x², where E is smooth, and the
//! host sums up in f64.

use std::f64::consts::FRAC_1_SQRT_2;

use super::albedo::{OVER_FILM, by_reflectances, channel, interference, of_colour};
use super::grid::Grid;
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::ndf::alpha_of;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::term::fresnel::Fresnel;
use crate::verify::truth;

/// The table.
pub struct AverageAlbedo;

/// 16 nodes reach 6e-8 for height-correlated Smith at every roughness; 20 leave the cone rule's error alone.
const NODES: usize = 20;

/// Panels on each side of the critical angle, each a quarter of the one before.
const GRADES: i32 = 5;

/// n·v and weights of E in 2 ∫ E mu dmu: Gauss–Legendre in √mu, on each side of the values at which E is not smooth.
pub(super) fn nodes(model: &Model) -> Vec<Node> {
    let mut breaks = vec![0.0, 1.0];
    if let Some(critical) = model.fresnel.kink() {
        // Where the normal, the mirror direction's facet, and the horizon's reach the critical angle.
        let sine = model.fresnel.optics.eta[0];
        breaks.extend([critical, sine, 2.0 * sine * critical]);
        // Around the critical angle a narrow lobe changes within its own width, whatever that is.
        for k in 1..=GRADES {
            let step = 0.5 * 0.25f64.powi(k);
            breaks.extend([critical - step, critical + step].into_iter().filter(|mu| (0.0..1.0).contains(mu)));
        }
    }
    if model.visibility.kinks.is_some() {
        breaks.extend([0.5, FRAC_1_SQRT_2]);
    }
    breaks.sort_by(f64::total_cmp);
    // At the critical angle E starts like a root.
    let rooted = model.fresnel.kink().is_some();
    let panel = |ends: &[f64]| {
        let (from, width) = (ends[0].sqrt(), ends[1].sqrt() - ends[0].sqrt());
        let map = move |node: Node| {
            let (mut g, mut slope) = (0.5 * (1.0 + node.x), 1.0);
            if rooted {
                (g, slope) = (g * g * (3.0 - 2.0 * g), 6.0 * g * (1.0 - g));
            }
            let x = from + width * g;
            Node { x: x * x, weight: 2.0 * width * slope * node.weight * x * x * x }
        };
        gauss_legendre(NODES).into_iter().map(map).collect::<Vec<_>>()
    };
    breaks.windows(2).filter(|ends| ends[1] > ends[0]).flat_map(panel).collect()
}

static FACTS: Facts = Facts {
    name: "average-albedo",
    about: "hemispherical mean of the albedo over roughness, for energy compensation",
    source: "Kulla, Conty 2017, Revisiting Physically Based Shading at Imageworks",
    usage: "multiple scattering lobe = (1 - E(n_dot_l)) * (1 - E(n_dot_v)) / (pi * (1 - average))",
    channels: |fresnel| {
        by_reflectances(fresnel, &CHANNELS[..1], &CHANNELS, of_colour(fresnel, &CONDUCTOR_CHANNELS, &FILM_CHANNELS))
    },
    complement: Some(&LOST),
    default_channels: |fresnel| by_reflectances(fresnel, &["average"], &["reflected"], &["red", "green", "blue"]),
    fresnel: Fresnel::ONE,
    axes: &[Coordinate::Roughness],
    slices: &[OVER_FILM],
    rule: |model| format!("{} Gauss-Legendre nodes of sqrt(n_dot_v) x {}", nodes(model).len(), model.rule_name()),
    tolerance: Tolerance {
        worst: 1e-6,
        median: 2.5e-7,
        near_zero: 2e-6,
        why: "256 centers and edges, both Smith terms, llvmpipe 22.3.6: 2e-7 worst, 5e-8 median",
    },
};

static LOST: Channel = channel("lost", "1 - average: the mean of what single scattering loses, F = 1");
static CHANNELS: [Channel; 2] = [
    channel("average", "2 * integral of albedo * n_dot_v, F = 1"),
    channel("reflected", "2 * integral of albedo * n_dot_v, exact F"),
];
static CONDUCTOR_CHANNELS: [Channel; 4] = [
    channel("average", "2 * integral of albedo * n_dot_v, F = 1"),
    channel("red", "2 * integral of albedo * n_dot_v, exact F of red"),
    channel("green", "2 * integral of albedo * n_dot_v, exact F of green"),
    channel("blue", "2 * integral of albedo * n_dot_v, exact F of blue"),
];

static FILM_CHANNELS: [Channel; 4] = [
    channel("average", "2 * integral of albedo * n_dot_v, F = 1"),
    interference("red", "2 * integral of albedo * n_dot_v, the film's F of red"),
    interference("green", "2 * integral of albedo * n_dot_v, the film's F of green"),
    interference("blue", "2 * integral of albedo * n_dot_v, the film's F of blue"),
];

impl Table for AverageAlbedo {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        let mut sum = [0.0; MAX_CHANNELS];
        for node in nodes(model) {
            let e = model.rule(At { n_dot_v: node.x, ..at });
            sum.iter_mut().zip(e).for_each(|(s, e)| *s += node.weight * e);
        }
        sum
    }

    fn check(&self, model: &Model) -> Result<()> {
        if !model.is_anisotropic() {
            return Ok(());
        }
        Err(Error::usage(
            "average-albedo holds the mean of a round lobe: an anisotropic one depends on the azimuth as well",
            "bake albedo at some azimuths, --ndf ggx:ratio=0.3,azimuth=45",
        ))
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        mean_truth(at.roughness, tolerance, |mu| truth::albedo(model, mu, at.roughness, 0.2 * tolerance))
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
        let e = Grid { stage: "average-albedo", n_dot_v: &n_dot_v, roughness, first_slice: None }
            .run(backend, model, on)?;
        Ok(means(&e, &rule))
    }
}

/// The means of rows of [`MAX_CHANNELS`] values a texel at the nodes of a rule.
pub(super) fn means(texels: &[f32], rule: &[Node]) -> Vec<f32> {
    let row = |texels: &[f32]| {
        let of = |c: usize| {
            let values = texels.iter().skip(c).step_by(MAX_CHANNELS);
            values.zip(rule).map(|(v, n)| n.weight * f64::from(*v)).sum::<f64>() as f32
        };
        [of(0), of(1), of(2), of(3)]
    };
    texels.chunks_exact(rule.len() * MAX_CHANNELS).flat_map(row).collect()
}

/// 2 ∫ mu `of`(mu) dmu by adaptive integration, to about `tolerance`.
pub(super) fn mean_truth(
    roughness: f64,
    tolerance: f64,
    of: impl Fn(f64) -> Estimate<MAX_CHANNELS>,
) -> Estimate<MAX_CHANNELS> {
    let alpha = alpha_of(roughness);
    // Geometric panels down to the scale of alpha, where E changes: on one wide panel a coarse and a fine rule can
    // agree by missing the same dip.
    let mut breaks = vec![1.0];
    while breaks[breaks.len() - 1] > 0.1 * alpha.max(1e-3) {
        breaks.push(0.3 * breaks[breaks.len() - 1]);
    }
    breaks.push(0.0);
    breaks.reverse();
    let found = integrate(&breaks, 0.5 * tolerance, 100, |mu| {
        let e = of(mu);
        Estimate { value: e.value.map(|e| 2.0 * mu * e), error: 2.0 * mu * e.error }
    });
    Estimate { error: found.error.max(tolerance), ..found }
}
