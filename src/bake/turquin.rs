// SPDX-License-Identifier: MIT OR Apache-2.0
//! Turquin's compensation for multiple scattering, over n·v, roughness and, in slices, Schlick's F0: what single scattering
//! is multiplied with, and what then is reflected.
//!
//! factor = 1 + F0 (1 − E)/E (Hill 2018; Turquin 2019, Eq. 16), reflected = (F0 (E − B) + B) factor with E and B the integrals
//! of the split sum, the weights 1 and (1 − v·h)⁵. Not reciprocal, and two bounces instead of many.
//!
//! Limits: 1 and F(n·v) at roughness 0; at F0 = 1 1/E and 1.

use super::kulla_conty::{SLICES, check};
use super::split_sum::SplitSum;
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Values};
use crate::axis::Coordinate;
use crate::error::Result;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::Estimate;
use crate::term::fresnel::Fresnel;

/// The table.
pub struct Turquin;

/// Single scattering of GGX with Smith's terms keeps at least this: E at n·v = 1 and roughness 1 is 1 − ln 2.
const LEAST_ALBEDO: f64 = 0.3;

static CHANNELS: [Channel; 2] = [
    Channel {
        name: "factor",
        meaning: "1 + F0 (1 - E)/E: what single scattering is multiplied with",
        range: [1.0, 3.3],
    },
    super::albedo::channel("reflected", "share that is then reflected"),
];

static FACTS: Facts = Facts {
    name: "turquin",
    about: "compensation for multiple scattering for Schlick's term (--f0, or axis f0=FROM/TO): factor, and what is reflected",
    source: "Turquin 2019, Practical multiple scattering compensation for microfacet models; Hill 2018",
    usage: "f = factor * single scattering",
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["factor", "reflected"],
    fresnel: Fresnel::GLASS,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: SLICES,
    rule: Model::rule_name,
    tolerance: Tolerance {
        worst: 1e-5,
        median: 2e-6,
        near_zero: 2e-5,
        why: "the albedo's 1e-6 over the square of the least albedo, 0.3",
    },
};

fn channels(f0: f64, [scale, bias, e, _]: Values) -> Values {
    // At grazing on a mirror nothing is lost.
    let factor = 1.0 + f0 * (1.0 - e) / e.max(LEAST_ALBEDO);
    [factor, (f0 * scale + bias) * factor, 0.0, 0.0]
}

impl Table for Turquin {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn check(&self, model: &Model) -> Result<()> {
        check(FACTS.name, model)
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        channels(model.fresnel.f0(), SplitSum.rule(model, at))
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        // The slope over E is at most that of 1/E.
        let slope = 1.0 / (LEAST_ALBEDO * LEAST_ALBEDO);
        let split = SplitSum.truth(model, at, tolerance / slope);
        Estimate { value: channels(model.fresnel.f0(), split.value), error: split.error * slope }
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let mut texels = SplitSum.bake(model, n_dot_v, roughness, backend, on)?;
        for texel in texels.as_chunks_mut::<MAX_CHANNELS>().0 {
            *texel = channels(model.fresnel.f0(), texel.map(f64::from)).map(|v| v as f32);
        }
        Ok(texels)
    }
}
