// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reflectance integral of any isotropic BRDF, adaptively, with an estimate of its error.
//!
//! E = ∫ f(l, v) w(l, v) (n·l) dω_l over the light directions of the upper hemisphere. Lobes of surfaces are narrow around
//! the mirror direction, which is h = n whatever v is, so the integral runs over half vectors: dω_l = 4 (v·h) dω_h and
//! dω_h = t c³ dt dψ with t = tan θ_h, c = cos θ_h and ψ the azimuth from v's. With mu = n·v and sv = sin θ_v
//!
//! v·h = c (t sv cos ψ + mu),   l = 2 (v·h) h − v,   n·l > 0 where cos ψ > mu (t² − 1)/(2 t sv):
//!
//! whole circles up to t1 = mu/(1 + sv), parts of them up to t2 = (1 + sv)/mu, as in [`crate::rule::h_split`]. So every light
//! direction has its place, and no node is wasted below the horizon. t = scale·sinh(y) spreads all widths from the
//! scale of the lobe, which is probed, to the horizon over panels of like length. Panels end at t1, at t2 and at sv/mu, where
//! the half vector is v: a lobe back to the viewer lies there, at ψ = 0, and the first cells are as
//! narrow there as it is. Seen from near the horizon they are graded towards the light's horizon, too. In each the position is u with
//! y = y0 + (y1 − y0) u² (3 − 2u), which removes the square root with which circles open and close, and x = ψ/ψ_max.
//! The BRDF is symmetric about the plane of v and n (the laws look at that): half of the circle counts twice.
//!
//! Cells of (u, x) are integrated by Kronrod's 15 × 15 nodes on the device, and by Gauss's 7 nodes along one side and
//! Kronrod's along the other: the two differences are the error of the poorer rules, and their sum the estimate of the cell.
//! The host adds the cells up in f64. Until the estimates of a place add up to its tolerance, the cells that
//! have most of them are halved, along u, along x, or both. What the evaluation of the BRDF itself is off no difference of
//! rules can show: it is added from the width of the lobe and the precision.

use rayon::prelude::*;

use super::program::{Cell, PLACE as RECORD, Precision, Program, SUMS};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::progress::OnProgress;
use crate::quadrature::gauss_kronrod::{NODES, on_unit_interval};

/// Where an integral is taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Cosine between normal and viewer, in (0, 1].
    pub n_dot_v: f64,
    /// Width that the BRDF is given.
    pub alpha: f64,
    /// tan θ_h at which the BRDF begins to change.
    pub width: f64,
    /// Angle from the viewer's direction at which it begins to change there, in radians; infinite where it does not.
    pub retro: f64,
}

/// An integral, and how far it can be off.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Integral {
    /// Over the weights 1, (1 − v·h)⁵ and (v·h)(1 − v·h)⁶, or over red, green and blue.
    pub value: [f64; 3],
    /// Of the worst of them, rounding included.
    pub error: f64,
    /// Least value of the BRDF at any node.
    pub least: f64,
}

/// How hard to try.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// What the rule may be off beyond what rounding leaves: absolutely up to a value of 1, relative to it beyond.
    pub tolerance: f64,
    /// What both may be off together.
    pub most: f64,
    /// Halvings of the first cells beyond what usually suffices, and another scale of the map: nodes that share nothing with
    /// those of 0.
    pub fineness: u32,
}

/// Cells of a place after which it is given up.
const MOST_CELLS: usize = 8192;
/// Places that are worked on at once.
const BAND: usize = 1 << 11;
/// Range of y of a first cell.
const FIRST_RANGE: f64 = 3.0;
/// A viewer below this n·v is low: from above, the nodes of a whole panel see how light sets.
const LOW: f64 = 1.0 / 16.0;
/// Cells are halved no further: single floats hold their ends exactly so far.
const LEAST_SIDE: f32 = 1.0 / (1 << 22) as f32;
/// What roundings of an integrand leave of a sum, in units of the last place.
const SUM_ROUNDING: f64 = 4.0;
/// A distribution of n·h is off by the rounding of n·h times its slope, about this over the square of the width at
/// which it begins to change. Measured for GGX and Blinn-Phong at alpha 4e-6: at most half of that.
const COSINE_ROUNDING: f64 = 0.2;

/// A cell that was integrated.
#[derive(Clone, Copy)]
struct Done {
    cell: Cell,
    value: [f64; 3],
    along_u: f64,
    along_x: f64,
}

impl Done {
    fn error(&self) -> f64 {
        self.along_u + self.along_x
    }
}

/// The integrals at some places.
pub(super) fn integrate(
    gpu: &Gpu,
    program: &Program,
    places: &[Place],
    colored: bool,
    effort: Effort,
    on: &mut OnProgress<'_>,
) -> Result<Vec<Integral>> {
    let mut out = Vec::with_capacity(places.len());
    for band in places.chunks(BAND) {
        let done = |share: f64| (out.len() as f64 + share * band.len() as f64) / places.len() as f64;
        let share = [done(0.0), done(1.0)];
        let integrals = integrate_band(gpu, program, band, colored, effort, share, on)?;
        out.extend(integrals);
    }
    Ok(out)
}

/// [`integrate`] for as many places as are worked on at once; progress runs over a share of the whole.
fn integrate_band(
    gpu: &Gpu,
    program: &Program,
    places: &[Place],
    colored: bool,
    effort: Effort,
    share: [f64; 2],
    on: &mut OnProgress<'_>,
) -> Result<Vec<Integral>> {
    let records: Vec<[f64; RECORD]> = places.iter().map(|place| record(place, effort)).collect();
    let mut pending: Vec<Cell> = (0..)
        .zip(places)
        .zip(&records)
        .flat_map(|((i, place), record)| first_cells(i, place, record, effort))
        .collect();
    let mut done: Vec<Vec<Done>> = vec![vec![]; places.len()];
    let mut least = vec![f64::INFINITY; places.len()];
    let mut open = places.len();
    while !pending.is_empty() {
        let begun = 1.0 - open as f64 / places.len() as f64;
        let progress = share[0] + begun * (share[1] - share[0]);
        let sums = program
            .cells(gpu, &records, &pending, colored, &mut |p| on(crate::progress::Progress { done: progress, ..p }))?;
        for (cell, sums) in pending.iter().zip(&sums) {
            let place = cell.place as usize;
            let [a, b, c, along_u, along_x, smallest, _, bad] = *sums;
            if bad != 0.0 || !sums[..5].iter().all(|s| s.is_finite()) {
                return Err(not_finite(&places[place], &records[place], cell, sums));
            }
            least[place] = least[place].min(smallest);
            done[place].push(Done { cell: *cell, value: [a, b, c], along_u, along_x });
        }
        let next: Vec<Result<Vec<Cell>>> = done
            .par_iter_mut()
            .zip(places)
            .map(|(done, place)| split(done, place, effort, program.precision))
            .collect();
        pending.clear();
        open = 0;
        for cells in next {
            let cells = cells?;
            open += usize::from(!cells.is_empty());
            pending.extend(cells);
        }
    }
    let sum = |((done, place), least): ((&Vec<Done>, &Place), &f64)| {
        let total = Total::of(done, place, program.precision);
        Integral { value: total.value, error: total.error(), least: *least }
    };
    Ok(done.iter().zip(places).zip(&least).map(sum).collect())
}

/// The sum of all cells of a place.
struct Total {
    value: [f64; 3],
    /// Sum of the cells' estimates.
    rule: f64,
    /// What the evaluation of the BRDF may be off.
    rounding: f64,
}

impl Total {
    fn of(done: &[Done], place: &Place, precision: Precision) -> Total {
        let mut total = Total { value: [0.0; 3], rule: 0.0, rounding: 0.0 };
        for cell in done {
            total.value.iter_mut().zip(cell.value).for_each(|(sum, v)| *sum += v);
            total.rule += cell.error();
        }
        let unit = match precision {
            Precision::Double => 0.5 * f64::EPSILON,
            Precision::Single => 0.5 * f64::from(f32::EPSILON),
        };
        total.rounding = unit * (SUM_ROUNDING + COSINE_ROUNDING / (place.width * place.width)) * largest(&total.value);
        total
    }

    fn error(&self) -> f64 {
        self.rule + self.rounding
    }
}

fn largest(value: &[f64; 3]) -> f64 {
    value.iter().fold(0.0, |most, v| v.abs().max(most))
}

/// Takes the cells with most of the error out of `done` and returns their halves; none where the rest is good enough.
fn split(done: &mut Vec<Done>, place: &Place, effort: Effort, precision: Precision) -> Result<Vec<Cell>> {
    let total = Total::of(done, place, precision);
    let scale = largest(&total.value).max(1.0);
    let refuse = |why: &str, evaluations: usize| {
        let Place { n_dot_v, alpha, .. } = place;
        let (value, error, most) = (total.value[0], total.error(), effort.most * scale);
        Err(Error::Verify {
            what: format!(
                "the BRDF's integral at n.v = {n_dot_v:.6}, alpha = {alpha:.3e} is {value:.4} with an error estimate of \
                 {error:.1e} after {evaluations} evaluations: {why} (--max-estimate allows more than {most:.1e}, \
                 --min-roughness leaves out the narrowest lobes)"
            ),
        })
    };
    // Differences below what rounding leaves mean nothing.
    let allowed = effort.tolerance * scale + total.rounding;
    if total.rule <= allowed {
        return match total.error() <= effort.most * scale {
            true => Ok(vec![]),
            false => refuse("n.h is rounded too coarsely for so narrow a lobe", done.len() * NODES * NODES),
        };
    }
    done.sort_by(|a, b| a.error().total_cmp(&b.error()));
    let mut kept = 0.0;
    let good = done.iter().take_while(|cell| {
        kept += cell.error();
        kept <= 0.5 * allowed
    });
    let good = good.count();
    let mut halves = vec![];
    for cell in done.split_off(good.min(done.len() - 1)) {
        let Cell { u, du, x, dx, .. } = cell.cell;
        let (along_u, along_x) = (2.0 * cell.along_u > cell.along_x, 2.0 * cell.along_x > cell.along_u);
        let us = if along_u { [Some((u, 0.5 * du)), Some((u + 0.5 * du, 0.5 * du))] } else { [Some((u, du)), None] };
        let xs = if along_x { [Some((x, 0.5 * dx)), Some((x + 0.5 * dx, 0.5 * dx))] } else { [Some((x, dx)), None] };
        for (u, du) in us.into_iter().flatten() {
            halves.extend(xs.into_iter().flatten().map(|(x, dx)| Cell { u, du, x, dx, ..cell.cell }));
        }
    }
    let too_small = halves.iter().any(|cell| cell.du.min(cell.dx) < LEAST_SIDE);
    if too_small || done.len() + halves.len() > MOST_CELLS {
        return refuse("it diverges, or jumps too often", (done.len() + halves.len()) * NODES * NODES);
    }
    Ok(halves)
}

/// A place as `shaders/own/cells.glsl` reads it.
fn record(place: &Place, effort: Effort) -> [f64; RECORD] {
    let mu = place.n_dot_v;
    let sine = ((1.0 - mu) * (1.0 + mu)).sqrt();
    let scale = place.width * if effort.fineness == 0 { 0.5 } else { 0.31 };
    let y = |t: f64| (t / scale).asinh();
    // Circles are whole up to the first, and closed from the last on; in between the half vector meets v.
    let (whole, closed, viewer) = (y(mu / (1.0 + sine)), y((1.0 + sine) / mu), y(sine / mu));
    [mu, sine, place.alpha, scale, 0.0, whole.min(viewer), whole.max(viewer), closed]
}

/// The first cells of the place with this index.
fn first_cells(index: u32, place: &Place, record: &[f64; RECORD], effort: Effort) -> Vec<Cell> {
    let viewer = (record[1] / place.n_dot_v / record[3]).asinh();
    // So often the side of a whole panel must be halved to become as narrow as a lobe back to the viewer.
    let levels = (1.0 / place.retro).log2().ceil().clamp(0.0, 18.0) as u32;
    let mut cells = vec![];
    for panel in 0..3 {
        let ends = [record[4 + panel], record[5 + panel]];
        let range = ends[1] - ends[0];
        if range <= 0.0 {
            continue;
        }
        let along_u = ((range / FIRST_RANGE).ceil() as u32).next_power_of_two() << effort.fineness;
        let along_x = 1u32 << effort.fineness;
        let (du, dx) = (1.0 / along_u as f32, 1.0 / along_x as f32);
        for i in 0..along_u {
            for j in 0..along_x {
                let cell = Cell { place: index, panel: panel as u32, u: i as f32 * du, du, x: j as f32 * dx, dx };
                let at_viewer = j == 0 && (i == 0 && ends[0] == viewer || i == along_u - 1 && ends[1] == viewer);
                if at_viewer {
                    graded(cell, ends[1] == viewer, levels, &mut cells);
                } else {
                    cells.push(cell);
                }
            }
        }
    }
    // Whole circles do not reach the horizon.
    let whole = (place.n_dot_v / (1.0 + record[1]) / record[3]).asinh();
    let reaches = |cell: &Cell| cell.x + cell.dx == 1.0 && record[5 + cell.panel as usize] > whole;
    let at_horizon = |cell: Cell| if reaches(&cell) { towards_horizon(cell, place.n_dot_v) } else { vec![cell] };
    cells.into_iter().flat_map(at_horizon).collect()
}

/// Cuts off three quarters of a cell again and again, towards x = 1 where the light sets. Models change where the light is as
/// low as a low viewer, in a strip about as wide as n·v: no node may lie in it, and no difference of rules tells.
fn towards_horizon(mut cell: Cell, n_dot_v: f64) -> Vec<Cell> {
    let mut cells = vec![];
    while n_dot_v < LOW && f64::from(cell.dx) > 4.0 * n_dot_v {
        let most = 0.75 * cell.dx;
        cells.push(Cell { dx: most, ..cell });
        cell = Cell { x: cell.x + most, dx: cell.dx - most, ..cell };
    }
    cells.push(cell);
    cells
}

/// Halves a cell again and again towards its corner at x = 0 and its end, or its start, along u: along x each time, along u
/// every other time, because distances from the end grow like the square of those in u. Cells as long as wide miss nothing.
fn graded(mut cell: Cell, at_end: bool, levels: u32, cells: &mut Vec<Cell>) {
    for level in 0..levels {
        let dx = 0.5 * cell.dx;
        cells.push(Cell { x: cell.x + dx, dx, ..cell });
        cell.dx = dx;
        if level % 2 == 1 {
            let du = 0.5 * cell.du;
            let (near, far) = if at_end { (cell.u + du, cell.u) } else { (cell.u, cell.u + du) };
            cells.push(Cell { u: far, du, ..cell });
            cell = Cell { u: near, du, ..cell };
        }
    }
    cells.push(cell);
}

/// The error of a node at which a BRDF is not finite, or of a sum that is not.
fn not_finite(place: &Place, record: &[f64; RECORD], cell: &Cell, sums: &[f64; SUMS]) -> Error {
    let mut what = format!("the BRDF is not finite at n.v = {:.6}, alpha = {:.3e}", place.n_dot_v, place.alpha);
    if sums[7] > 0.0 {
        let node = sums[7] as usize - 1;
        let [x, y, z] = direction(record, cell, node / NODES, node % NODES);
        what.push_str(&format!(", l = ({x:.6}, {y:.6}, {z:.3e})"));
    }
    what.push_str(": it is NaN or infinite there (--min-roughness keeps alpha away from 0)");
    Error::Verify { what }
}

/// The light direction of a node. The twin of `shaders/own/cells.glsl`.
fn direction(record: &[f64; RECORD], cell: &Cell, i: usize, j: usize) -> [f64; 3] {
    let nodes = on_unit_interval();
    let [mu, sine, _, scale, ..] = *record;
    let panel = 4 + cell.panel as usize;
    let u = f64::from(cell.u) + f64::from(cell.du) * nodes[i].x;
    let y = record[panel] + (record[panel + 1] - record[panel]) * u * u * (3.0 - 2.0 * u);
    let t = scale * y.sinh();
    let c = 1.0 / (1.0 + t * t).sqrt();
    let end = (mu * (t - 1.0) * (t + 1.0) / (2.0 * t * sine)).clamp(-1.0, 1.0).acos();
    let (sin, cos) = (end * (f64::from(cell.x) + f64::from(cell.dx) * nodes[j].x)).sin_cos();
    let v_dot_h = c * (t * sine * cos + mu);
    let [hx, hy, hz] = [c * t * cos, c * t * sin, c];
    [2.0 * v_dot_h * hx - sine, 2.0 * v_dot_h * hy, 2.0 * v_dot_h * hz - mu]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE: Place = Place { n_dot_v: 0.5, alpha: 0.25, width: 0.1, retro: f64::INFINITY };
    const EFFORT: Effort = Effort { tolerance: 1e-6, most: 1e-5, fineness: 0 };

    fn done(errors: &[(f64, f64)]) -> Vec<Done> {
        let cell = Cell { place: 3, panel: 1, u: 0.5, du: 0.25, x: 0.0, dx: 1.0 };
        errors
            .iter()
            .map(|(along_u, along_x)| Done { cell, value: [0.1; 3], along_u: *along_u, along_x: *along_x })
            .collect()
    }

    #[test]
    fn cells_with_most_of_the_error_are_halved_where_it_lies() {
        let split = |list: &mut Vec<Done>| split(list, &PLACE, EFFORT, Precision::Double).unwrap();
        let mut list = done(&[(1e-9, 1e-9), (1e-4, 1e-9), (1e-9, 1e-5), (1e-5, 1e-5)]);
        let halves = split(&mut list);
        assert_eq!((list.len(), halves.len()), (1, 2 + 2 + 4));
        let area = |cell: &Cell| f64::from(cell.du) * f64::from(cell.dx);
        assert!((halves.iter().map(area).sum::<f64>() - 0.75).abs() < 1e-12);
        assert!(halves.iter().all(|c| c.place == 3 && c.panel == 1 && c.u >= 0.5 && c.u + c.du <= 0.75));
        assert!(split(&mut done(&[(1e-9, 1e-9); 3])).is_empty());
    }

    #[test]
    fn what_does_not_converge_is_refused() {
        let error = split(&mut done(&vec![(1.0, 1.0); MOST_CELLS / 2]), &PLACE, EFFORT, Precision::Double).unwrap_err();
        assert!(matches!(error, Error::Verify { .. }) && error.to_string().contains("n.v = 0.5"), "{error}");
        // Cells that agree, of a lobe that single precision cannot hold.
        let narrow = Place { width: 1e-3, ..PLACE };
        let error = split(&mut done(&[(0.0, 0.0)]), &narrow, EFFORT, Precision::Single).unwrap_err();
        assert!(error.to_string().contains("too coarsely"), "{error}");
        assert!(split(&mut done(&[(0.0, 0.0)]), &narrow, EFFORT, Precision::Double).unwrap().is_empty());
        let mut tiny = done(&[(1.0, 0.0)]);
        tiny[0].cell.du = LEAST_SIDE;
        assert!(split(&mut tiny, &PLACE, EFFORT, Precision::Double).is_err());
    }

    #[test]
    fn cells_crowd_around_a_lobe_back_to_the_viewer() {
        for n_dot_v in [1.0, 0.9, 0.5, 0.01] {
            let place = Place { n_dot_v, retro: 1e-3, ..PLACE };
            let record = record(&place, EFFORT);
            let cells = first_cells(0, &place, &record, EFFORT);
            let plain = first_cells(0, &PLACE, &record, EFFORT);
            let area = |cells: &[Cell]| cells.iter().map(|c| f64::from(c.du) * f64::from(c.dx)).sum::<f64>();
            assert!((area(&cells) - area(&plain)).abs() < 1e-9 && cells.len() > plain.len() + 10);
            // The smallest cells touch the viewer's direction.
            let v = [record[1], 0.0, n_dot_v];
            let narrow = cells.iter().filter(|c| c.dx < 1.5e-3);
            let far = |cell: &Cell| {
                direction(&record, cell, 7, 7).iter().zip(v).map(|(l, v)| (l - v).powi(2)).sum::<f64>().sqrt()
            };
            assert!(narrow.clone().count() > 0 && narrow.map(far).all(|d| d < 0.05), "{n_dot_v}");
        }
    }

    #[test]
    fn panels_end_where_circles_open_and_close() {
        for n_dot_v in [1.0, 0.9, 0.5, 1e-3] {
            let place = Place { n_dot_v, alpha: 0.1, width: 0.01, ..PLACE };
            let record = record(&place, EFFORT);
            assert!(record[4..].windows(2).all(|ends| ends[0] <= ends[1]), "{record:?}");
            let cells = first_cells(0, &place, &record, EFFORT);
            for cell in &cells {
                for (i, j) in [(0, 0), (7, 7), (14, 14), (0, 14), (14, 0)] {
                    let l = direction(&record, cell, i, j);
                    let length: f64 = l.iter().map(|x| x * x).sum();
                    assert!(l[2] > -1e-9 && (length - 1.0).abs() < 1e-9, "{n_dot_v} {cell:?}: {l:?}");
                }
            }
        }
    }
}
