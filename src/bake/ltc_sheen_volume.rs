// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sheen as a linearly transformed cosine of the layer of fibres proper (Zeltner, Burley, Chiang 2022): A, B and the albedo R
//! as [`super::ltc_sheen`] has them, of the random walk that [`crate::rule::fibre_walk`] follows.
//!
//! Two tables. `ltc-sheen-volume` ends a walk after 16 scatterings and takes what is then still inside for reflected where it
//! flies upwards, as the tables of the paper, of pbrt and of Cycles (`sheen_ltc`) do. `ltc-sheen-endless` follows it until it
//! has left: up to 0.23 more is reflected of light that grazes narrow fibres, and less than 1e-4 from alpha 0.3 on.
//!
//! Axes as published: n·v to the right, alpha down, both limits included; n·v and alpha are at least 0.01.

use std::cell::RefCell;
use std::rc::Rc;

use rayon::prelude::*;

use super::ltc::FITTED;
use super::ltc_sheen::{FACTS, TRUTH, USUAL, check_own, error, error_channel, place, values};
use super::{At, Backend, Derived, Facts, MAX_CHANNELS, Model, Table, Tolerance, Usual, Values};
use crate::error::Result;
use crate::progress::{OnProgress, watched};
use crate::quadrature::adaptive::Estimate;
use crate::rule::fibre_layer::sigma_of;
use crate::rule::fibre_walk::{Detail, FibreAlbedo, FibreLobes, PUBLISHED, Scatterings};
use crate::rule::lobe_nodes::LobeNodes;

/// A table of the walk.
pub struct LtcSheenVolume {
    facts: &'static Facts,
    derived: &'static [Derived],
    /// Scatterings after which a walk ends.
    scatterings: Scatterings,
    details: Details,
}

/// The table as published.
pub static VOLUME: LtcSheenVolume =
    LtcSheenVolume { facts: &VOLUME_FACTS, derived: &VOLUME_DERIVED, scatterings: PUBLISHED, details: RULE };
/// The table of walks that nothing ends.
pub static ENDLESS_VOLUME: LtcSheenVolume =
    LtcSheenVolume { facts: &ENDLESS_FACTS, derived: &ENDLESS_DERIVED, scatterings: None, details: ENDLESS_RULE };

/// How finely the walks of a row are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Details {
    albedo: Detail,
    lobe: Detail,
}

/// Of a bake.
const RULE: Details = Details {
    albedo: Detail { even: 0.07, finest: 0.04, cosines: 9, panel: 1.05, depths: 22, azimuths: 1 },
    lobe: Detail { even: 0.1, finest: 0.05, cosines: 8, panel: 1.35, depths: 16, azimuths: 16 },
};
/// The same where no walk ends: light that was caught between narrow fibres comes back along the horizon.
const ENDLESS_RULE: Details = Details { lobe: Detail { cosines: 10, ..RULE.lobe }, ..RULE };
/// Of the truth.
const FINE: Details = Details {
    albedo: Detail { even: 0.05, finest: 0.03, cosines: 11, panel: 1.0, depths: 30, azimuths: 1 },
    lobe: Detail { even: 0.1, finest: 0.05, cosines: 10, panel: 1.1, depths: 22, azimuths: 21 },
};
/// What the truth of an albedo is good for.
const ALBEDO_TRUTH: f64 = 1e-6;

const ALBEDO: Tolerance = Tolerance {
    worst: 1e-5,
    median: 1e-6,
    near_zero: 1e-5,
    why: "tests/ltc_sheen.rs: over other nodes; 4 sigma of 1e6 walks",
};

/// How its values are computed.
fn rule_name(orders: &str, Details { lobe, .. }: &Details) -> String {
    let Detail { cosines, depths, azimuths, .. } = lobe;
    format!(
        "{orders} by discrete ordinates, {cosines} a panel and {depths} depths; Newton's method on the squared difference \
         over them and {azimuths} azimuths"
    )
}

static VOLUME_FACTS: Facts = Facts {
    name: "ltc-sheen-volume",
    about: "sheen as a linearly transformed cosine, of a random walk through fibres as published: Cycles' and pbrt's",
    rule: |_| rule_name("16 orders of scattering", &RULE),
    ..FACTS
};

static ENDLESS_FACTS: Facts = Facts {
    name: "ltc-sheen-endless",
    about: "the same of walks that no number of scatterings ends, where the published ones end after 16",
    rule: |_| rule_name("all orders of scattering", &ENDLESS_RULE),
    ..VOLUME_FACTS
};

static VOLUME_DERIVED: [Derived; 1] = [Derived {
    tolerance: FITTED,
    channel: error_channel(),
    rule: |_, at, values| error(&lobe(at, PUBLISHED, RULE), values),
    truth: |_, at, values| Estimate { value: [error(&lobe(at, PUBLISHED, FINE), values)], error: TRUTH },
}];

static ENDLESS_DERIVED: [Derived; 1] = [Derived {
    tolerance: FITTED,
    channel: error_channel(),
    rule: |_, at, values| error(&lobe(at, None, ENDLESS_RULE), values),
    truth: |_, at, values| Estimate { value: [error(&lobe(at, None, FINE), values)], error: TRUTH },
}];

/// Fibres of one width.
struct Row {
    albedo: FibreAlbedo,
    lobes: FibreLobes,
}

impl Row {
    fn new(sigma: f64, scatterings: Scatterings, details: Details) -> Row {
        Row {
            albedo: FibreAlbedo::new(sigma, scatterings, details.albedo),
            lobes: FibreLobes::new(sigma, scatterings, details.lobe),
        }
    }

    fn values(&self, at: At) -> Values {
        values(&self.lobes.at(at.n_dot_v), self.albedo.at(at.n_dot_v))
    }
}

/// A row and what it is of: neighbouring texels ask for the same one.
type LastRow = Option<(f64, Scatterings, Details, Rc<Row>)>;

thread_local! {
    static LAST_ROW: RefCell<LastRow> = const { RefCell::new(None) };
}

/// The row that a texel is in.
fn row(at: At, scatterings: Scatterings, details: Details) -> Rc<Row> {
    let sigma = sigma_of(place(at));
    LAST_ROW.with_borrow_mut(|last| match last {
        Some((s, n, d, row)) if (*s, *n, *d) == (sigma, scatterings, details) => row.clone(),
        _ => {
            let row = Rc::new(Row::new(sigma, scatterings, details));
            *last = Some((sigma, scatterings, details, row.clone()));
            row
        }
    })
}

fn lobe(at: At, scatterings: Scatterings, details: Details) -> LobeNodes {
    row(at, scatterings, details).lobes.at(place(at).n_dot_v)
}

impl Table for LtcSheenVolume {
    fn facts(&self) -> &'static Facts {
        self.facts
    }

    fn usual(&self) -> Usual {
        Usual { model: None, ..USUAL }
    }

    fn rule(&self, _model: &Model, at: At) -> Values {
        row(at, self.scatterings, self.details).values(place(at))
    }

    fn check(&self, model: &Model) -> Result<()> {
        check_own(model, self.facts.name)
    }

    fn check_limits(&self, _model: &Model, _at_grazing: bool, _at_mirror: bool) -> Result<()> {
        Ok(())
    }

    fn tolerance(&self, _model: &Model, value: usize) -> Tolerance {
        if value == 2 { ALBEDO } else { FITTED }
    }

    fn derived(&self) -> &'static [Derived] {
        self.derived
    }

    fn truth(&self, _model: &Model, at: At, _tolerance: f64) -> Estimate<MAX_CHANNELS> {
        Estimate { value: row(at, self.scatterings, FINE).values(place(at)), error: ALBEDO_TRUTH }
    }

    fn truth_name(&self) -> &'static str {
        "the same walk and fit over other nodes"
    }

    /// As any table without a kernel, but what a row has in common is computed once.
    fn bake(
        &self,
        _model: &Model,
        n_dot_v: &[f64],
        roughness: &[f64],
        _backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        let texels = watched(on, self.facts.name, n_dot_v.len() * roughness.len(), |watch| -> Vec<Values> {
            let rows = roughness.par_iter().flat_map(|&roughness| {
                let at = move |n_dot_v: f64| place(At { n_dot_v, roughness });
                let row = (!watch.gone()).then(|| Row::new(sigma_of(at(1.0)), self.scatterings, self.details));
                let texel = move |n_dot_v: &f64| match &row {
                    Some(row) if !watch.cancelled() => row.values(at(*n_dot_v)),
                    _ => Values::default(),
                };
                n_dot_v.par_iter().map(texel)
            });
            rows.collect()
        })?;
        Ok(texels.into_iter().flatten().map(|v| v as f32).collect())
    }
}
