// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linearly transformed cosines for area lights (Heitz, Dupuy, Hill, Neubelt 2016): the inverse matrix M⁻¹ over roughness
//! and n·v, as [`crate::rule::ltc`] fits it. The table `ltc-magnitude` holds what belongs to it.
//!
//! M⁻¹ = (m00 0 m02; 0 1 0; m20 0 m22) in rows, over its middle entry; x points along the view's projection. A shader turns
//! the light's polygon into that frame, multiplies by M⁻¹ and integrates the clamped cosine over what comes out. `fit-error`
//! is the cube root of ∫ |f (n·l) − E D|³ dω over ∫ (f (n·l))³ dω: 0 is perfect, 1 is no lobe at all.
//!
//! Axes as published: roughness to the right, √(1 − n·v) down, both limits included. Neither has a lobe: what belongs to
//! roughness 0 is taken at alpha 1e-5 (0.07 of distributions whose facets stand upright), what belongs to n·v = 0 at 1.57 rad, as Heitz et al. take them. At n·v = 1 m20 and
//! m02 are 0 and m00 is 1; at roughness 0 M⁻¹ is that of a mirror of that width.

use rayon::prelude::*;

use super::albedo::channel;
use super::{At, Channel, Derived, Facts, MAX_CHANNELS, Model, Table, TexelLaw, Tolerance, Usual, Values};
use crate::axis::{Coordinate, Points, Warp};
use crate::error::{Error, Result};
use crate::quadrature::adaptive::Estimate;
use crate::rule::lobe_nodes::{Fineness, LobeNodes};
use crate::rule::ltc::{FIT, Fit, Inverse, fit};
use crate::term::fresnel::Fresnel;
use crate::texture::Meta;
use crate::verify::ltc as truth;

/// The table.
pub struct Ltc;

/// The least width that has a lobe.
const LEAST_ALPHA: f64 = 1e-5;
/// The same where facets stand upright: with less, they reflect nothing along the normal that could be fitted.
pub(super) const LEAST_UPRIGHT_ALPHA: f64 = 0.07;
/// The largest angle between normal and viewer.
const LARGEST_ANGLE_RAD: f64 = 1.57;
/// Nodes of the fit that the truth is, and over which fit errors are stated: none of them is one of [`FIT`].
const FINE: Fineness = Fineness { polar: 14, azimuth: 21, panel: 0.9 };
/// What the truth of a matrix is good for: kinks of the integrand at the end of the cosine move between nodes.
const TRUTH: f64 = 1e-4;

/// An entry of the matrix.
const fn entry(name: &'static str, meaning: &'static str) -> Channel {
    Channel { name, meaning, range: [-1e6, 1e6] }
}

static CHANNELS: [Channel; 4] = [
    entry("m00", "inverse matrix, row 0, column 0, over the middle entry"),
    entry("m20", "inverse matrix, row 2, column 0, over the middle entry"),
    entry("m02", "inverse matrix, row 0, column 2, over the middle entry"),
    entry("m22", "inverse matrix, row 2, column 2, over the middle entry"),
];

static DERIVED: [Derived; 5] = [
    Derived {
        tolerance: OTHERS,
        channel: channel("fit-error", "how far the fitted lobe is from the true one: 0 perfect, 1 no lobe"),
        rule: |model, at, values| Inverse(*values).cubed_error(&nodes(model, at, FINE)).cbrt(),
        truth: |model, at, values| truth::fit_error(model, place(model, at), &Inverse(*values), TRUTH),
    },
    // As Unity's high definition pipeline stores them.
    Derived {
        tolerance: OVER,
        channel: entry("m00/m22", "inverse matrix, row 0, column 0, over the last entry"),
        rule: |_, _, [m00, _, _, m22]| m00 / last(m22),
        truth: |_, _, [m00, _, _, m22]| exactly(m00 / last(m22)),
    },
    Derived {
        tolerance: OVER,
        channel: entry("m20/m22", "inverse matrix, row 2, column 0, over the last entry"),
        rule: |_, _, [_, m20, _, m22]| m20 / last(m22),
        truth: |_, _, [_, m20, _, m22]| exactly(m20 / last(m22)),
    },
    Derived {
        tolerance: OVER,
        channel: entry("m11/m22", "inverse matrix, the middle entry over the last one"),
        rule: |_, _, [.., m22]| 1.0 / last(m22),
        truth: |_, _, [.., m22]| exactly(1.0 / last(m22)),
    },
    Derived {
        tolerance: OVER,
        channel: entry("m02/m22", "inverse matrix, row 0, column 2, over the last entry"),
        rule: |_, _, [_, _, m02, m22]| m02 / last(m22),
        truth: |_, _, [_, _, m02, m22]| exactly(m02 / last(m22)),
    },
];

/// What is divided by: halves hold nothing over less, and only mirrors have less.
fn last(m22: &f64) -> f64 {
    m22.max(1.6e-5)
}

static LAW: TexelLaw = TexelLaw {
    statement: "is no further from the true lobe than the best fit and the rounding of its matrix",
    broken: |model, at, found, rounding| {
        let (nodes, best) = (nodes(model, at, FIT), best(model, at, FIT).inverse);
        // Half a step of an entry moves the lobe; the cube root of a mean cube obeys the triangle inequality.
        let moved = |i: usize| {
            let mut inverse = best;
            inverse.0[i] += rounding[i];
            inverse.distance(&best, &nodes)
        };
        let error = |inverse: &Inverse| truth::fit_error(model, place(model, at), inverse, TRUTH).value[0];
        let allowed = error(&best) + (0..4).map(moved).sum::<f64>();
        let error = error(&Inverse(*found));
        // NaN is not within any bound.
        let within = error <= 1.01 * allowed + 5.0 * TRUTH;
        (!within).then(|| format!("its fit error is {error:.4}, where {allowed:.4} can be had"))
    },
};

/// Of a fit against one over other nodes; the law of texels is sharper.
pub(super) const FITTED: Tolerance =
    Tolerance { worst: 1e-2, median: 1e-3, near_zero: 1e-2, why: "tests/ltc.rs: fits over other nodes" };
/// Of lobes with kinks, or of facets that stand upright.
const OTHERS: Tolerance =
    Tolerance { worst: 5e-2, median: 2e-3, near_zero: 5e-2, why: "tests/ltc.rs: fits over other nodes" };
/// Of what is divided by the last entry, which a narrow lobe at grazing angles hardly depends on.
const OVER: Tolerance =
    Tolerance { worst: 0.3, median: 1e-3, near_zero: 0.3, why: "tests/targets.rs: 0.16 at roughness 1/63, n_dot_v 0" };

static FACTS: Facts = Facts {
    name: "ltc",
    about: "linearly transformed cosines for area lights: the inverse matrix, fitted to the lobe",
    source: "Heitz, Dupuy, Hill, Neubelt 2016, Real-Time Polygonal-Light Shading with Linearly Transformed Cosines",
    usage: "inverse matrix (m00 0 m02; 0 1 0; m20 0 m22) by rows, x along the view: docs/area-lights.md",
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["m00", "m20", "m02", "m22"],
    fresnel: Fresnel::SCHLICK,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: &[],
    rule: |_| format!("Newton's method on the cubed difference over {} x {} nodes a panel", FIT.polar, FIT.azimuth),
    tolerance: FITTED,
};

/// Where a texel's lobe is taken: at n·v = 0 and at roughness 0 there is none.
pub fn place(model: &Model, at: At) -> At {
    let least = if model.ndf.family.flat.falling { LEAST_UPRIGHT_ALPHA } else { LEAST_ALPHA };
    At { n_dot_v: at.n_dot_v.max(LARGEST_ANGLE_RAD.cos()), roughness: at.roughness.max(least.sqrt()) }
}

/// A value without an error of its own.
fn exactly(value: f64) -> Estimate<1> {
    Estimate { value: [value], error: 0.0 }
}

/// The nodes of a texel's lobe.
fn nodes(model: &Model, at: At, fineness: Fineness) -> LobeNodes {
    LobeNodes::of_model(model, place(model, at), fineness).expect("a width above 0 has a lobe")
}

/// The best fit.
fn best(model: &Model, at: At, fineness: Fineness) -> Fit {
    let at = place(model, at);
    let lobe = model.ndf.lobe(at.roughness).expect("a width above 0 has a lobe");
    fit(&nodes(model, at, fineness), at.n_dot_v, lobe.peak)
}

/// Refuses what has no lobe in the plane of incidence, or a Fresnel term that no fit knows.
pub(super) fn check(model: &Model, what: &str) -> Result<()> {
    if model.is_anisotropic() {
        return Err(Error::usage(
            format!("{what} is fitted to isotropic lobes, not to {}", model.ndf),
            "drop the ratio of --ndf",
        ));
    }
    if !std::ptr::eq(model.fresnel.term, Fresnel::SCHLICK.term) {
        return Err(Error::usage(
            format!("{what} holds Schlick's split, not the Fresnel term '{}'", model.fresnel),
            "drop --ior, --eta-k or --material",
        ));
    }
    Ok(())
}

/// As published: 64 × 64 over roughness and √(1 − n·v), with both limits.
pub(super) const USUAL: Usual = Usual {
    size: (64, 64),
    axes: Some(&[Warp::Roughness, Warp::SqrtOneMinusNDotV]),
    points: Points::Edges,
    single: true,
    ..Usual::TABLE
};

impl Table for Ltc {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn usual(&self) -> Usual {
        Usual { on_processor: true, is_fit: true, ..USUAL }
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        best(model, at, FIT).inverse.0
    }

    fn check(&self, model: &Model) -> Result<()> {
        check(model, "ltc")
    }

    fn check_limits(&self, _model: &Model, _at_grazing: bool, _at_mirror: bool) -> Result<()> {
        Ok(())
    }

    fn tolerance(&self, model: &Model, _value: usize) -> Tolerance {
        if model.ndf.family.name == "ggx" && model.visibility.smith { FITTED } else { OTHERS }
    }

    fn derived(&self) -> &'static [Derived] {
        &DERIVED
    }

    fn law(&self) -> Option<&'static TexelLaw> {
        Some(&LAW)
    }

    fn truth(&self, model: &Model, at: At, _tolerance: f64) -> Estimate<MAX_CHANNELS> {
        Estimate { value: best(model, at, FINE).inverse.0, error: TRUTH }
    }

    fn truth_name(&self) -> &'static str {
        "the same fit over other nodes"
    }

    fn describe(&self, model: &Model, places: &[At], texels: &[f32], meta: &mut Meta) {
        let error = |(at, texel): (&At, &[f32; MAX_CHANNELS])| {
            Inverse(texel.map(f64::from)).cubed_error(&nodes(model, *at, FINE)).cbrt()
        };
        let mut errors: Vec<f64> = places.par_iter().zip(texels.as_chunks().0).map(error).collect();
        errors.sort_by(f64::total_cmp);
        if let (Some(worst), Some(median)) = (errors.last(), errors.get(errors.len() / 2)) {
            meta.set("fit-error.worst", format!("{worst:.4}"));
            meta.set("fit-error.median", format!("{median:.4}"));
        }
    }
}
