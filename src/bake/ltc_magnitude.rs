// SPDX-License-Identifier: MIT OR Apache-2.0
//! What belongs to a matrix of linearly transformed cosines ([`super::ltc`]): how much light the lobe holds, and what
//! reaches over the horizon.
//!
//! magnitude = ∫ f/F (n·l) dω_l and fresnel = ∫ f/F (1 − v·h)⁵ (n·l) dω_l: the albedo and the bias of [`super::split_sum`].
//! A shader multiplies what it integrates by F0·magnitude + (F90 − F0)·fresnel (Hill, Heitz 2016).
//!
//! sphere: the form factor of a light that reaches below the horizon, over that of the whole light. A polygon's vector
//! form factor has a length and a direction; a sphere with the same two stands for it. It is looked up where √(1 − n·v)
//! is the length, the sine squared of the sphere's angular radius, and roughness (z + 1)/2 with z the cosine between the
//! direction and the normal (Hill, Heitz 2016; Snyder 1996, Area Light Sources for Real-Time Graphics). unused is 0, as in
//! the published texture.
//!
//! Roughness 0 and n·v = 0 are taken where the matrix is: at alpha 1e-5 and 1.57 rad.

use std::f64::consts::{FRAC_PI_2, PI};

use super::albedo::channel;
use super::grid::Grid;
use super::ltc::{USUAL, check, place};
use super::{At, Backend, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Usual, Values};
use crate::axis::Coordinate;
use crate::error::Result;
use crate::progress::OnProgress;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::term::fresnel::{Fresnel, Weights};
use crate::verify::truth;

/// The table.
pub struct LtcMagnitude;

static CHANNELS: [Channel; 4] = [
    channel("magnitude", "directional albedo with F = 1: factor of F0"),
    channel("fresnel", "factor of F90 - F0"),
    channel("unused", "0"),
    channel("sphere", "share of a sphere's form factor that the horizon leaves"),
];

static FACTS: Facts = Facts {
    name: "ltc-magnitude",
    about: "linearly transformed cosines for area lights: magnitude, Fresnel and the horizon's share of a sphere",
    source: "Hill, Heitz 2016, Real-Time Area Lighting: a Journey from Research to Production",
    usage: "specular = (F0 * magnitude + (F90 - F0) * fresnel) * integral; sphere at roughness (z + 1) / 2, \
            sqrt(1 - n.v) length: docs/area-lights.md",
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["magnitude", "fresnel", "unused", "sphere"],
    fresnel: Fresnel::SCHLICK,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: &[],
    rule: |model| format!("{}; sphere in closed form", model.rule_name()),
    tolerance: Tolerance {
        worst: 1e-6,
        median: 2.5e-7,
        near_zero: 2e-6,
        why: "tests/ltc.rs; the rule is that of split-sum",
    },
};

/// From integrals over the weights 1 and (1 − v·h)⁵.
fn channels([magnitude, fresnel, ..]: Weights, sphere: f64) -> Values {
    [magnitude, fresnel, 0.0, sphere]
}

/// The cosine of the direction and the length that a texel stands for.
fn form_factor(at: At) -> (f64, f64) {
    (2.0 * at.roughness - 1.0, (1.0 - at.n_dot_v).sqrt())
}

/// The share of a sphere's form factor that the horizon leaves; `length` is sin² of its angular radius, `z` the cosine
/// between its direction and the normal. Both in their range, [−1, 1] and [0, 1].
///
/// Snyder 1996, Eq. 12 to 14: the cosine over the cap where it stands above the horizon, and the part of it that is cut.
fn sphere(z: f64, length: f64) -> f64 {
    if length == 0.0 {
        return z.max(0.0);
    }
    let (sin_r, cos_r) = (length.sqrt(), (1.0 - length).sqrt());
    let sin_w = ((1.0 - z) * (1.0 + z)).sqrt();
    if z >= sin_r {
        return z;
    }
    if z <= -sin_r {
        return 0.0;
    }
    // The horizon cuts the cap: gamma is the angle at which it does, seen from the cap's axis.
    let sin_g = (cos_r / sin_w).clamp(-1.0, 1.0);
    let cos_g = ((1.0 - sin_g) * (1.0 + sin_g)).sqrt();
    let gamma = sin_g.asin();
    let segment = FRAC_PI_2 - gamma + sin_g * cos_g - 2.0 * sin_w * cos_r * cos_g;
    let root = (length - cos_g * cos_g).max(0.0).sqrt();
    let ellipse = z * (cos_g * root + length * (cos_g / sin_r).min(1.0).asin());
    let cut = if z >= 0.0 { PI * z * length + segment - ellipse } else { segment + ellipse };
    (cut / (PI * length)).clamp(0.0, 1.0)
}

/// The same by adaptive integration over directions of the cap: about its axis by angle and azimuth, nothing simplified.
fn sphere_truth(z: f64, length: f64, tolerance: f64) -> Estimate<1> {
    if length == 0.0 {
        return Estimate { value: [z.max(0.0)], error: 0.0 };
    }
    let radius = length.sqrt().asin();
    let sin_w = ((1.0 - z) * (1.0 + z)).sqrt();
    // Rings that the horizon touches begin where the cap's axis is its own angle from it.
    let touches = (FRAC_PI_2 - z.acos()).abs().min(radius);
    let found = integrate(&[0.0, touches, radius], 0.5 * tolerance * PI * length, 200, |theta| {
        let (sin, cos) = theta.sin_cos();
        let horizon = if sin_w * sin > 0.0 { (-z * cos / (sin_w * sin)).clamp(-1.0, 1.0).acos() } else { PI };
        let inner = integrate(&[0.0, horizon, PI], 0.1 * tolerance, 200, |phi| {
            let up = (z * cos + sin_w * sin * phi.cos()).max(0.0);
            Estimate { value: [2.0 * up * sin], error: 0.0 }
        });
        Estimate { value: inner.value, error: inner.error }
    });
    Estimate { value: [found.value[0] / (PI * length)], error: (found.error / (PI * length)).max(tolerance) }
}

impl Table for LtcMagnitude {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn usual(&self) -> Usual {
        USUAL
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        let (z, length) = form_factor(at);
        channels(model.rule(place(model, at)), sphere(z, length))
    }

    fn check(&self, model: &Model) -> Result<()> {
        check(model, "ltc-magnitude")
    }

    fn check_limits(&self, _model: &Model, _at_grazing: bool, _at_mirror: bool) -> Result<()> {
        Ok(())
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let lobe = place(model, at);
        let found = truth::albedo(model, lobe.n_dot_v, lobe.roughness, tolerance);
        let (z, length) = form_factor(at);
        let cap = sphere_truth(z, length, tolerance);
        Estimate { value: channels(found.value, cap.value[0]), error: found.error.max(cap.error) }
    }

    fn bake(
        &self,
        model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let lobe = |n_dot_v: f64, roughness: f64| place(model, At { n_dot_v, roughness });
        let columns: Vec<f64> = n_dot_v.iter().map(|x| lobe(*x, 1.0).n_dot_v).collect();
        let rows: Vec<f64> = roughness.iter().map(|r| lobe(1.0, *r).roughness).collect();
        let grid = Grid { stage: "ltc-magnitude", n_dot_v: &columns, roughness: &rows, first_slice: None };
        let mut texels = grid.run(backend, model, on)?;
        for (i, texel) in texels.as_chunks_mut().0.iter_mut().enumerate() {
            let at = At { n_dot_v: n_dot_v[i % n_dot_v.len()], roughness: roughness[i / n_dot_v.len()] };
            let (z, length) = form_factor(at);
            *texel = channels(texel.map(f64::from), sphere(z, length)).map(|v| v as f32);
        }
        Ok(texels)
    }
}
