// SPDX-License-Identifier: MIT OR Apache-2.0
//! From all conventions to the few that fit: sketches of every model on a coarse grid of texels first, then the rule
//! itself on finer and finer grids for those that are left.

use std::sync::LazyLock;

use rayon::prelude::*;

use super::content::{Quantity, Samples, Transfer};
use super::layout::{Layout, Points, ROUGHNESS, Side, VIEW, placements};
use super::models::{Rough, Sketch, View, WEIGHTS, candidates, rule};
use crate::axis::Warp;
use crate::bake::Model;
use crate::error::Result;
use crate::format::picture::Picture;
use crate::progress::{OnProgress, tick};

/// Texels a side of the grid on which sketches are compared.
const SKETCH_GRID: u32 = 9;
/// Errors beyond this count as this: a component that no quantity explains must not drown the others.
const CAP: f64 = 0.05;
/// Grids a side for the rule, and how many hypotheses go on from each.
const STAGES: [(u32, usize); 3] = [(7, 20), (16, 6), (LAST_GRID, 6)];
/// Texels a side of the last grid.
pub const LAST_GRID: u32 = 32;
/// Hypotheses that go on from the sketches, at most.
const SKETCHED: usize = 120;
/// Of one model.
const SKETCHED_OF_MODEL: usize = 24;
/// Directions and warps of one model that go on to all positions in a texel, encodings counted apart.
const PLACED_OF_MODEL: usize = 16;
/// They may be this much worse than the best, as far as a sketch may be off.
const SKETCH_ERROR: f64 = 8e-3;

/// Every model with its sketch.
pub static MODELS: LazyLock<Vec<(Model, Sketch)>> =
    LazyLock::new(|| candidates().into_par_iter().map(|model| (model, Sketch::new(&model))).collect());

/// A convention that may explain a picture.
#[derive(Clone, Copy)]
pub struct Hypothesis {
    /// Distribution and geometry term.
    pub model: Model,
    /// Which coordinates the texels have.
    pub layout: Layout,
    /// How numbers are encoded.
    pub transfer: Transfer,
}

/// What a component holds under a hypothesis, and how well.
#[derive(Clone, Copy)]
pub struct Match {
    /// What.
    pub quantity: Quantity,
    /// Mean of the squared errors, absolute up to 1, relative to the value beyond.
    pub mean_square: f64,
}

/// A hypothesis compared with some texels.
pub struct Compared {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// E, B and T of each texel; `None` where a shift leads out of the table.
    pub expected: Vec<Option<[f64; WEIGHTS]>>,
    /// The best match of each component.
    pub matches: Vec<Match>,
    /// What is least for the best one.
    score: f64,
}

/// The quantities that a table of a model may hold.
fn quantities(model: &Model) -> &'static [Quantity] {
    let all = &Quantity::ALL;
    // Only cloth tables are divided by the hemisphere.
    if model.ndf.family.name == "charlie" { all } else { &all[..5] }
}

/// A picture under one encoding.
struct Grid {
    transfer: Transfer,
    samples: Samples,
    /// Which components say something.
    telling: Vec<bool>,
}

/// Hypotheses from the best to the worst of the last stage, on its grid. `constant` says which components are the same
/// everywhere.
pub fn search(
    picture: &Picture,
    transfers: &[Transfer],
    constant: &dyn Fn(Transfer, usize) -> bool,
    on: &mut OnProgress<'_>,
) -> Result<Vec<Compared>> {
    // Which components say something, encoding by encoding.
    let telling = |transfer: Transfer| -> Vec<bool> {
        (0..transfer.names(picture).len()).map(|c| !constant(transfer, c)).collect()
    };
    let grids = |n: u32| -> Vec<Grid> {
        let of = |t: &Transfer| Grid { transfer: *t, samples: Samples::take(picture, *t, n), telling: telling(*t) };
        transfers.iter().map(of).collect()
    };
    let sketch_grids = grids(SKETCH_GRID);
    let sides = Sides::new(&sketch_grids[0].samples);
    tick(on, "identify: sketches", 0.0)?;
    let lists: Vec<Vec<_>> =
        MODELS.par_iter().map(|(model, sketch)| sketched(model, sketch, &sides, &sketch_grids)).collect();
    let mut found: Vec<(f64, Hypothesis)> = lists.into_iter().flatten().collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let limit = found.first().map_or(0.0, |best| (3.0 * best.0.sqrt() + SKETCH_ERROR).powi(2));
    found.truncate(SKETCHED.min(found.partition_point(|(score, _)| *score <= limit)));

    let mut left: Vec<Hypothesis> = found.into_iter().map(|(_, hypothesis)| hypothesis).collect();
    let mut compared = vec![];
    for (i, (grid, keep)) in STAGES.into_iter().enumerate() {
        tick(on, "identify: rules", i as f64 / STAGES.len() as f64)?;
        let grids = grids(grid);
        compared = left
            .par_iter()
            .map(|hypothesis| {
                let of = |grid: &&Grid| grid.transfer == hypothesis.transfer;
                let grid = grids.iter().find(of).expect("a hypothesis has one of the encodings");
                compare(hypothesis, &grid.samples, &grid.telling)
            })
            .collect();
        compared.sort_by(|a: &Compared, b| a.score.total_cmp(&b.score));
        compared.truncate(keep);
        left = compared.iter().map(|c| c.hypothesis).collect();
    }
    tick(on, "identify: rules", 1.0)?;
    Ok(compared)
}

/// The rule at each texel, and what each component is.
pub fn compare(hypothesis: &Hypothesis, samples: &Samples, telling: &[bool]) -> Compared {
    let at: Vec<Option<(f64, f64)>> =
        samples.texels.iter().map(|texel| hypothesis.layout.at(*texel, samples.size)).collect();
    // Roughness by roughness, because the rule keeps what a roughness needs.
    let mut order: Vec<usize> = (0..at.len()).collect();
    order.sort_by(|a, b| at[*a].map_or(0.0, |(_, r)| r).total_cmp(&at[*b].map_or(0.0, |(_, r)| r)));
    let mut expected = vec![None; at.len()];
    for i in order {
        expected[i] = at[i].map(|(n_dot_v, roughness)| rule(&hypothesis.model, n_dot_v, roughness));
    }
    let matches: Vec<Match> =
        (0..samples.values.len()).map(|c| best(&hypothesis.model, samples, c, &expected, f64::INFINITY)).collect();
    let score = score(&matches, telling);
    Compared { hypothesis: *hypothesis, expected, matches, score }
}

/// The quantity that explains a component best; single errors count up to `cap`.
fn best(model: &Model, samples: &Samples, component: usize, expected: &[Option<[f64; WEIGHTS]>], cap: f64) -> Match {
    let values = &samples.values[component];
    let of = |quantity: Quantity| {
        let (mut sum, mut n) = (0.0, 0.0);
        for (value, expected) in values.iter().zip(expected) {
            if let Some(expected) = expected {
                let wanted = samples.expected(quantity, *expected);
                let error = ((value.value - wanted) / wanted.abs().max(1.0)).abs().min(cap);
                sum += error * error;
                n += 1.0;
            }
        }
        Match { quantity, mean_square: sum / n }
    };
    let all = quantities(model).iter().map(|q| of(*q));
    all.min_by(|a, b| a.mean_square.total_cmp(&b.mean_square)).expect("there are quantities")
}

/// Mean over the components that say something.
fn score(matches: &[Match], telling: &[bool]) -> f64 {
    let told = matches.iter().zip(telling).filter(|(_, telling)| **telling);
    let (sum, n) = told.fold((0.0, 0.0), |(sum, n), (m, _)| (sum + m.mean_square.min(CAP * CAP), n + 1.0));
    // NaN comes last.
    if n == 0.0 { f64::INFINITY } else { sum / n }
}

/// Every way that a side can lie, with the interpolation weights of its samples: they are the same for all models.
struct Sides {
    /// Along x, then along y.
    view: [Vec<(Side, Vec<Option<View>>)>; 2],
    rough: [Vec<(Side, Vec<Option<Rough>>)>; 2],
    columns: usize,
}

impl Sides {
    fn new(samples: &Samples) -> Sides {
        let indices = [
            samples.texels[..samples.columns].iter().map(|t| t[0]).collect::<Vec<_>>(),
            samples.texels.iter().step_by(samples.columns).map(|t| t[1]).collect(),
        ];
        let at = |axis: usize, side: &Side| -> Vec<Option<f64>> {
            indices[axis].iter().map(|i| side.at(*i, samples.size[axis])).collect()
        };
        let view = |axis: usize| {
            let sides = every(&VIEW).into_iter();
            sides.map(|s| (s, at(axis, &s).into_iter().map(|v| v.map(View::new)).collect())).collect()
        };
        let rough = |axis: usize| {
            let sides = every(&ROUGHNESS).into_iter();
            sides.map(|s| (s, at(axis, &s).into_iter().map(|v| v.map(Rough::new)).collect())).collect()
        };
        Sides { view: [view(0), view(1)], rough: [rough(0), rough(1)], columns: samples.columns }
    }
}

/// Every side with one of these warps.
fn every(warps: &[Warp]) -> Vec<Side> {
    let mut all = vec![];
    for warp in warps.iter().copied() {
        for reversed in [false, true] {
            for (points, shifts) in [
                (Points::Centers, &[0, 1, -1] as &[i32]),
                (Points::Edges, &[0, 1, -1]),
                (Points::Starts, &[0]),
                (Points::Ends, &[0]),
            ] {
                all.extend(shifts.iter().map(|shift| Side { warp, points, reversed, shift: *shift }));
            }
        }
    }
    all
}

/// The best hypotheses of one model by its sketch, with their scores.
///
/// Directions and warps are told apart at centers first: a wrong position in the texel costs less than any of them.
fn sketched(model: &Model, sketch: &Sketch, sides: &Sides, grids: &[Grid]) -> Vec<(f64, Hypothesis)> {
    let mut rough = sketched_at(model, sketch, sides, grids, &|layout| layout.placement() == [(Points::Centers, 0); 2]);
    rough.truncate(PLACED_OF_MODEL);
    let directions: Vec<Directions> = rough.iter().map(|(_, hypothesis)| directions(&hypothesis.layout)).collect();
    let placements = placements();
    let mut found = sketched_at(model, sketch, sides, grids, &|layout| {
        placements.contains(&layout.placement()) && directions.contains(&self::directions(layout))
    });
    found.truncate(SKETCHED_OF_MODEL);
    found
}

/// A layout without positions in the texel.
type Directions = [(Warp, bool); 2];

fn directions(layout: &Layout) -> Directions {
    [layout.x, layout.y].map(|side| (side.warp, side.reversed))
}

/// Every wanted hypothesis of one model by its sketch, best first.
fn sketched_at(
    model: &Model,
    sketch: &Sketch,
    sides: &Sides,
    grids: &[Grid],
    wanted: &dyn Fn(&Layout) -> bool,
) -> Vec<(f64, Hypothesis)> {
    let mut found: Vec<(f64, Hypothesis)> = vec![];
    let mut expected = vec![None; grids[0].samples.texels.len()];
    for transposed in [false, true] {
        let (view_axis, rough_axis) = if transposed { (1, 0) } else { (0, 1) };
        for (view, views) in &sides.view[view_axis] {
            let mut columns = None;
            for (rough, roughnesses) in &sides.rough[rough_axis] {
                let (x, y) = if transposed { (*rough, *view) } else { (*view, *rough) };
                let layout = Layout { x, y };
                if !wanted(&layout) {
                    continue;
                }
                let columns: &Vec<_> =
                    columns.get_or_insert_with(|| views.iter().map(|v| v.as_ref().map(|v| sketch.column(v))).collect());
                for (i, to) in expected.iter_mut().enumerate() {
                    let (column, row) = (i % sides.columns, i / sides.columns);
                    let (v, r) = if transposed { (row, column) } else { (column, row) };
                    *to = columns[v].as_ref().zip(roughnesses[r].as_ref()).map(|(c, r)| r.of(c));
                }
                for Grid { transfer, samples, telling } in grids {
                    let matches: Vec<Match> =
                        (0..samples.values.len()).map(|c| best(model, samples, c, &expected, 2.0 * CAP)).collect();
                    let hypothesis = Hypothesis { model: *model, layout, transfer: *transfer };
                    found.push((score(&matches, telling), hypothesis));
                }
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}
