// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sheen as a linearly transformed cosine (Zeltner, Burley, Chiang 2022): A and B of M⁻¹ = (A 0 B; 0 A 0; 0 0 1) in rows,
//! x along the view, as [`crate::rule::ltc_sheen`] fits them, and the albedo R.
//!
//! f (n·l) ≈ R A² z/(π |M⁻¹ l|⁴). Two tables: of any sheen that a distribution and a geometry term make, Charlie's unless
//! told otherwise; and of the layer of fibres that the paper approximates by a formula ([`crate::rule::fibre_layer`]). Those of
//! the layer itself are in [`super::ltc_sheen_volume`].
//!
//! Axes as published: n·v to the right, alpha down, both limits included; n·v and alpha are at least 0.01,
//! alpha 0.07 of distributions whose facets stand upright.

use super::ltc::{FITTED, LEAST_UPRIGHT_ALPHA, check};
use super::{At, Channel, Derived, Facts, MAX_CHANNELS, Model, Table, Tolerance, Usual, Values};
use crate::axis::{Coordinate, Points, Warp};
use crate::error::{Error, Result};
use crate::quadrature::adaptive::Estimate;
use crate::rule::fibre_layer::FibreLayer;
use crate::rule::lobe_nodes::{Fineness, LobeNodes};
use crate::rule::ltc_sheen::{FIT, fit, squared_error};
use crate::term::fresnel::Fresnel;
use crate::verify::{fibre_layer, truth};

/// The table of a sheen that is made of microfacets.
pub struct LtcSheen;
/// The table of a layer of fibres.
pub struct LtcSheenFibres;

/// The least n·v and the least alpha that have a lobe, as published.
const LEAST: f64 = 0.01;
/// Nodes of the fit that the truth is.
const FINE: Fineness = Fineness { polar: 14, azimuth: 21, panel: 0.7 };
/// Nodes of the albedo of fibres.
const ALBEDO: Fineness = Fineness { polar: 36, azimuth: 48, panel: 0.5 };
/// What the truth of A and B is good for.
pub(super) const TRUTH: f64 = 1e-4;
/// Most light that a sheen of the registries sends back per light that comes: geometry terms that make light.
const MOST: f32 = 65504.0;

static CHANNELS: [Channel; 3] = [
    Channel { name: "a", meaning: "inverse matrix, first and second entry of the diagonal", range: [0.0, 100.0] },
    Channel { name: "b", meaning: "inverse matrix, row 0, column 2", range: [-100.0, 100.0] },
    Channel { name: "reflectance", meaning: "directional albedo", range: [0.0, MOST] },
];

const USAGE: &str =
    "f (n.l) = reflectance * a * a * l.z / (pi * q * q), w = (a * l.x + b * l.z, a * l.y, l.z), q = dot(w, w)";
const SOURCE: &str =
    "Zeltner, Burley, Chiang 2022, Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines";
/// Of the albedo of fibres.
const FIBRES: Tolerance =
    Tolerance { worst: 1e-5, median: 1e-6, near_zero: 1e-5, why: "tests/ltc.rs: against adaptive integration" };

fn rule_name() -> String {
    format!("Newton's method on the squared difference over {} x {} nodes a panel", FIT.polar, FIT.azimuth)
}

/// What the tables of sheen have in common but for name and rule.
pub(super) static FACTS: Facts = Facts {
    name: "ltc-sheen",
    about: "sheen as a linearly transformed cosine, of Charlie or another distribution: two entries and the albedo",
    source: SOURCE,
    usage: USAGE,
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["a", "b", "reflectance"],
    fresnel: Fresnel::SCHLICK,
    axes: &[Coordinate::NDotV, Coordinate::Roughness],
    slices: &[],
    rule: |model| format!("{}; reflectance by {}", rule_name(), model.rule_name()),
    tolerance: FITTED,
};

static FIBRES_FACTS: Facts = Facts {
    name: "ltc-sheen-fibres",
    about: "sheen as a linearly transformed cosine, of the approximate layer of fibres of its authors",
    rule: |_| format!("{}; reflectance over {} x {}", rule_name(), ALBEDO.polar, ALBEDO.azimuth),
    ..FACTS
};

/// The channel of the fit's error.
pub(super) const fn error_channel() -> Channel {
    let meaning = "how far the fitted lobe is from the true one, root of mean squares: 0 perfect, 1 no lobe";
    Channel { name: "fit-error", meaning, range: [0.0, 1.0] }
}

static DERIVED: [Derived; 1] = [Derived {
    tolerance: FITTED,
    channel: error_channel(),
    rule: |model, at, values| error(&microfacets(model, at, FIT), values),
    truth: |model, at, values| Estimate { value: [error(&microfacets(model, at, FINE), values)], error: TRUTH },
}];

static FIBRES_DERIVED: [Derived; 1] = [Derived {
    tolerance: FITTED,
    channel: error_channel(),
    rule: |_, at, values| error(&FibreLayer::new(place(at)).nodes(FIT), values),
    truth: |_, at, values| Estimate { value: [error(&FibreLayer::new(place(at)).nodes(FINE), values)], error: TRUTH },
}];

/// Where a texel of fibres is taken.
pub(super) fn place(at: At) -> At {
    At { n_dot_v: at.n_dot_v.max(LEAST), roughness: at.roughness.max(LEAST.sqrt()) }
}

/// Where a texel of microfacets is taken.
fn place_of(model: &Model, at: At) -> At {
    let least = if model.ndf.family.flat.falling { LEAST_UPRIGHT_ALPHA } else { LEAST };
    At { n_dot_v: at.n_dot_v.max(LEAST), roughness: at.roughness.max(least.sqrt()) }
}

/// Refuses a model for a table that has its own lobe.
pub(super) fn check_own(model: &Model, name: &str) -> Result<()> {
    let usual = model.ndf.family.name == "ggx" && model.visibility.name == "smith" && !model.is_anisotropic();
    if usual && std::ptr::eq(model.fresnel.term, Fresnel::SCHLICK.term) {
        return Ok(());
    }
    Err(Error::usage(
        format!("{name} has a lobe of its own"),
        "drop --ndf, --visibility and the material, or bake ltc-sheen",
    ))
}

fn microfacets(model: &Model, at: At, fineness: Fineness) -> LobeNodes {
    LobeNodes::of_model(model, place_of(model, at), fineness).expect("a width above 0 has a lobe")
}

/// The fit's error over these nodes.
pub(super) fn error(nodes: &LobeNodes, [a, b, albedo, _]: &Values) -> f64 {
    squared_error(nodes, *albedo, [*a, *b]).sqrt()
}

/// (A, B, R) of a lobe whose albedo is known.
pub(super) fn values(nodes: &LobeNodes, albedo: f64) -> Values {
    let [a, b] = fit(nodes, albedo).entries;
    [a, b, albedo, 0.0]
}

/// As published: 32 × 32 over n·v and alpha, with both limits.
pub(super) const USUAL: Usual = Usual {
    size: (32, 32),
    axes: Some(&[Warp::NDotV, Warp::Alpha]),
    points: Points::Edges,
    model: Some(["charlie", "charlie"]),
    single: true,
    on_processor: true,
    is_fit: true,
};

impl Table for LtcSheen {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn usual(&self) -> Usual {
        USUAL
    }

    fn rule(&self, model: &Model, at: At) -> Values {
        values(&microfacets(model, at, FIT), model.rule(place_of(model, at))[0])
    }

    fn check(&self, model: &Model) -> Result<()> {
        check(model, "ltc-sheen")
    }

    fn check_limits(&self, _model: &Model, _at_grazing: bool, _at_mirror: bool) -> Result<()> {
        Ok(())
    }

    fn tolerance(&self, model: &Model, value: usize) -> Tolerance {
        // The albedo is that of the other tables.
        if value == 2 { model.tolerance(&super::split_sum::FACTS.tolerance) } else { FITTED }
    }

    fn derived(&self) -> &'static [Derived] {
        &DERIVED
    }

    fn truth(&self, model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let lobe = place_of(model, at);
        let albedo = truth::albedo(model, lobe.n_dot_v, lobe.roughness, tolerance);
        Estimate { value: values(&microfacets(model, at, FINE), albedo.value[0]), error: albedo.error }
    }

    fn truth_name(&self) -> &'static str {
        "the same fit over other nodes, reflectance by adaptive f64 integration"
    }
}

impl Table for LtcSheenFibres {
    fn facts(&self) -> &'static Facts {
        &FIBRES_FACTS
    }

    fn usual(&self) -> Usual {
        Usual { model: None, ..USUAL }
    }

    fn rule(&self, _model: &Model, at: At) -> Values {
        let layer = FibreLayer::new(place(at));
        values(&layer.nodes(FIT), layer.nodes(ALBEDO).albedo())
    }

    fn check(&self, model: &Model) -> Result<()> {
        check_own(model, FIBRES_FACTS.name)
    }

    fn check_limits(&self, _model: &Model, _at_grazing: bool, _at_mirror: bool) -> Result<()> {
        Ok(())
    }

    fn tolerance(&self, _model: &Model, value: usize) -> Tolerance {
        if value == 2 { FIBRES } else { FITTED }
    }

    fn derived(&self) -> &'static [Derived] {
        &FIBRES_DERIVED
    }

    fn truth(&self, _model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let albedo = fibre_layer::albedo(place(at), tolerance);
        let nodes = FibreLayer::new(place(at)).nodes(FINE);
        Estimate { value: values(&nodes, albedo.value[0]), error: albedo.error }
    }

    fn truth_name(&self) -> &'static str {
        "the same fit over other nodes, reflectance by adaptive f64 integration"
    }
}
