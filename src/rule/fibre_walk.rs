// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sheen of a thin layer of upright fibres proper: the random walk of Zeltner, Burley and Chiang (2022, Practical
//! Multiple-Scattering Sheen Using Linearly Transformed Cosines; `sheen_volume.h` of github.com/tizian/ltc-sheen), whose mean
//! is computed here, order of scattering by order of scattering.
//!
//! The layer is that of [`super::fibre_layer`]: SGGX flakes of cross section sigma = alpha² about the normal, density and
//! thickness 1, nothing absorbed, no light from below, and what leaves there is lost. Between two scatterings light that flies
//! at the cosine u meets a fibre after exp(−τ z), τ = a(u)/u, and a fibre sends it on by D(h)/4 per steradian
//! ([`super::flake_modes`]). In Fourier modes of the azimuth both are linear maps of what is known at nodes of depth
//! ([`super::slab`]) and polar angle ([`super::ordinates`]); a walk alternates them.
//!
//! The albedo needs mode 0 alone and is followed backwards, for all directions of the viewer at once: the chance to leave above
//! of light that is at a depth and flies in a direction. A lobe is followed forwards from its viewer; the first order, the only
//! one that is not smooth, is a closed form.
//!
//! A walk ends after a given number of scatterings; light that is then still inside counts by where it flies, as reflected if
//! upwards. That is how the published tables were made ([`PUBLISHED`]). Where nothing ends a walk, light between narrow fibres
//! takes thousands of scatterings to leave, and the sum over all orders is the solution of a linear system.

use std::f64::consts::PI;

use super::fibre_layer::FibreLayer;
use super::lobe_nodes::LobeNodes;
use super::ordinates::Ordinates;
use super::slab::Slab;
use crate::quadrature::gauss_legendre::gauss_legendre;
use crate::quadrature::gmres::fixed_point;

/// Scatterings after which a walk ends; `None` where it goes on until its light has left.
pub type Scatterings = Option<usize>;

/// What ends the walks of the published tables.
pub const PUBLISHED: Scatterings = Some(16);

/// Share of its source that the solution for all orders may miss: light between narrow fibres takes 1e4 scatterings to leave.
const MISSED: f64 = 1e-13;
/// One order after the other is followed until so little of what was reflected is still on its way up.
const FAINT: f64 = 1e-6;
/// Modes of the azimuth: from the second order on they fall with the fourth power of their number or faster.
const MODES: usize = 12;

/// How finely a walk is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Below this many sigma, and below [`Detail::finest`], cosines lie evenly.
    pub even: f64,
    /// The largest cosine below which they do.
    pub finest: f64,
    /// Nodes of a panel of cosines.
    pub cosines: usize,
    /// Longest panel.
    pub panel: f64,
    /// Nodes of depth.
    pub depths: usize,
    /// Azimuths of half a turn, of a lobe.
    pub azimuths: usize,
}

/// What is known of light at every ordinate (rows) and depth (columns): of one half of all directions, then of the other.
/// Depths are counted from the surface behind the light of a forward walk, before that of a backward one.
type State = Vec<f64>;

/// A linear map between the ordinates of both halves: its even and its odd part, row by row.
type Join = [Vec<f64>; 2];

/// A layer between its nodes.
struct Layer {
    sigma: f64,
    ordinates: Ordinates,
    slab: Slab,
    /// Rate of meeting fibres, per unit of length.
    area: Vec<f64>,
    /// The same per unit of depth.
    extinction: Vec<f64>,
    /// From where it was scattered to where it meets a fibre, ordinate by ordinate: a matrix by columns.
    flight: Vec<f64>,
}

/// Projected area of the flakes, which is the rate at which light meets them.
fn area(sigma: f64, cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos) + sigma * sigma * cos * cos).sqrt()
}

impl Layer {
    fn new(sigma: f64, detail: Detail) -> Layer {
        let scale = (detail.even * sigma).min(detail.finest);
        let ordinates = Ordinates::new(sigma, scale, detail.cosines, detail.panel);
        let slab = Slab::new(detail.depths);
        let area: Vec<f64> = ordinates.cos.iter().map(|cos| area(sigma, *cos)).collect();
        let extinction: Vec<f64> = area.iter().zip(&ordinates.cos).map(|(a, cos)| a / cos).collect();
        let mut flight = vec![];
        for extinction in &extinction {
            let rows: Vec<_> = slab.depth.iter().map(|z| slab.arriving(*extinction, *z)).collect();
            flight.extend((0..slab.count()).flat_map(|k| rows.iter().map(move |row| extinction * row[k])));
        }
        Layer { sigma, ordinates, slab, area, extinction, flight }
    }

    /// How many nodes of depth.
    fn depths(&self) -> usize {
        self.slab.count()
    }

    /// Even and odd part of the map whose entry (i, j) `weigh` makes of that of the joins from light at ordinate i to j.
    fn join(&self, joined: &[&[Vec<f64>; 2]], weigh: impl Fn(usize, usize) -> f64, transposed: bool) -> Join {
        let n = self.ordinates.count();
        let part = |sign: f64| -> Vec<f64> {
            let entry = |k: usize| {
                let (i, j) = if transposed { (k % n, k / n) } else { (k / n, k % n) };
                weigh(i, j) * (joined[i][0][j] + sign * joined[i][1][j])
            };
            (0..n * n).map(entry).collect()
        };
        [part(1.0), part(-1.0)]
    }

    /// What a map makes of a state: half of the sum and of the difference of both halves each.
    fn scattered(&self, [even, odd]: &Join, state: &[f64]) -> State {
        let n = self.depths();
        let (one, other) = state.split_at(state.len() / 2);
        let (mut sum, mut difference) = (vec![0.0; one.len()], vec![0.0; one.len()]);
        for (j, (row, mirrored)) in one.chunks(n).zip(other.chunks(n)).enumerate() {
            for (i, (x, y)) in row.iter().zip(mirrored.iter().rev()).enumerate() {
                sum[j * n + i] = 0.5 * (x + y);
                difference[j * n + i] = 0.5 * (x - y);
            }
        }
        let [sum, difference] = [(even, sum), (odd, difference)].map(|(map, state)| product(map, &state, n));
        let mut out = vec![0.0; state.len()];
        let (one, other) = out.split_at_mut(state.len() / 2);
        for j in 0..sum.len() / n {
            for i in 0..n {
                let (s, d) = (sum[j * n + i], difference[j * n + i]);
                one[j * n + i] = s + d;
                other[j * n + n - 1 - i] = s - d;
            }
        }
        out
    }

    /// Where light meets the next fibre that starts where a state says.
    fn flown(&self, state: &[f64]) -> State {
        let n = self.depths();
        let mut out = vec![0.0; state.len()];
        let flights = self.flight.chunks(n * n).cycle();
        for ((met, row), flight) in out.chunks_mut(n).zip(state.chunks(n)).zip(flights) {
            for (x, column) in row.iter().zip(flight.chunks(n)) {
                met.iter_mut().zip(column).for_each(|(sum, weight)| *sum += weight * x);
            }
        }
        out
    }
}

/// The product of a square matrix and a matrix with rows of `n`.
fn product(matrix: &[f64], rows: &[f64], n: usize) -> Vec<f64> {
    let count = rows.len() / n;
    let mut out = vec![0.0; rows.len()];
    for (out, weights) in out.chunks_mut(n).zip(matrix.chunks(count)) {
        for (weight, row) in weights.iter().zip(rows.chunks(n)) {
            out.iter_mut().zip(row).for_each(|(sum, x)| *sum += weight * x);
        }
    }
    out
}

/// The albedo of a layer, seen from anywhere.
pub struct FibreAlbedo {
    layer: Layer,
    /// The chance to leave above of light that flies up (depths from above) and down (depths from below), with one scattering
    /// less to go than the walk has.
    chance: State,
}

impl FibreAlbedo {
    /// Domain: sigma in (0, 1]; at least one scattering.
    pub fn new(sigma: f64, scatterings: Scatterings, detail: Detail) -> FibreAlbedo {
        let layer = Layer::new(sigma, detail);
        let joined: Vec<_> = layer.ordinates.cos.iter().map(|cos| layer.ordinates.joined(*cos, 1)).collect();
        let joined: Vec<_> = joined.iter().map(|modes| &modes[0]).collect();
        let join = layer.join(&joined, |i, _| 1.0 / layer.area[i], false);
        let slab = &layer.slab;
        let fades = |extinction: &f64| {
            let extinction = *extinction;
            slab.depth.iter().map(move |z| (-extinction * z).exp())
        };
        let straight: Vec<f64> = layer.extinction.iter().flat_map(fades).collect();
        // Nothing flies straight out above that flies down.
        let nodes = straight.len();
        let straight: State = straight.into_iter().chain(std::iter::repeat_n(0.0, nodes)).collect();
        let back = |chance: &[f64]| layer.flown(&layer.scattered(&join, chance));
        let chance = match scatterings {
            None => fixed_point(&straight, back, MISSED),
            Some(scatterings) => {
                let upwards: State = (0..2 * nodes).map(|i| if i < nodes { 1.0 } else { 0.0 }).collect();
                (1..scatterings).fold(upwards, |chance, _| {
                    back(&chance).iter().zip(&straight).map(|(x, straight)| x + straight).collect()
                })
            }
        };
        FibreAlbedo { layer, chance }
    }

    /// What a light that falls in from here sends back above. Domain: n_dot_v in (0, 1].
    pub fn at(&self, n_dot_v: f64) -> f64 {
        let layer = &self.layer;
        let n = layer.depths();
        let [same, opposite] = &layer.ordinates.joined(n_dot_v, 1)[0];
        // Where it is scattered first.
        let extinction = area(layer.sigma, n_dot_v) / n_dot_v;
        let first = layer.slab.leaving(extinction);
        let (up, down) = self.chance.split_at(self.chance.len() / 2);
        let mut sum = 0.0;
        for (j, (up, down)) in up.chunks(n).zip(down.chunks(n)).enumerate() {
            for (i, first) in first.iter().enumerate() {
                sum += first * (opposite[j] * up[i] + same[j] * down[n - 1 - i]);
            }
        }
        sum / n_dot_v
    }
}

/// The lobes of a layer.
pub struct FibreLobes {
    layer: Layer,
    scatterings: Scatterings,
    /// Mode by mode.
    joins: Vec<Join>,
    /// From where it was scattered to above, ordinate by ordinate.
    leaving: Vec<f64>,
    /// ψ and dψ of the nodes of half a turn, which crowd where light goes straight on.
    azimuths: Vec<(f64, f64)>,
}

impl FibreLobes {
    /// Domain: sigma in (0, 1]; at least one scattering.
    pub fn new(sigma: f64, scatterings: Scatterings, detail: Detail) -> FibreLobes {
        let layer = Layer::new(sigma, detail);
        let Ordinates { cos, weight, .. } = &layer.ordinates;
        let joined: Vec<_> = cos.iter().map(|cos| layer.ordinates.joined(*cos, MODES)).collect();
        // Transposed: a lobe is spread over nodes as they will be summed, which a ridge between two of them survives.
        let weigh = |i: usize, j: usize| weight[i] / (weight[j] * layer.area[i]);
        let join = |m: usize| layer.join(&joined.iter().map(|modes| &modes[m]).collect::<Vec<_>>(), weigh, true);
        let joins = (0..MODES).map(join).collect();
        let leaving = layer.extinction.iter().flat_map(|extinction| layer.slab.leaving(*extinction)).collect();
        let azimuth = |y: f64, w: f64| (PI * y * y, PI * y * w);
        let azimuths =
            gauss_legendre(detail.azimuths).iter().map(|node| azimuth(0.5 + 0.5 * node.x, node.weight)).collect();
        FibreLobes { layer, scatterings, joins, leaving, azimuths }
    }

    /// The nodes of the lobe seen from here: f (n·l) at every ordinate and azimuth above the horizon. Domain: n_dot_v in
    /// (0, 1].
    pub fn at(&self, n_dot_v: f64) -> LobeNodes {
        let layer = FibreLayer::of(self.layer.sigma, n_dot_v);
        let often = self.often(n_dot_v);
        let sin_v = ((1.0 - n_dot_v) * (1.0 + n_dot_v)).sqrt();
        let mut nodes = LobeNodes::default();
        for (k, (cos, weight)) in self.layer.ordinates.cos.iter().zip(&self.layer.ordinates.weight).enumerate() {
            let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
            for (psi, d_psi) in &self.azimuths {
                let (y, x) = psi.sin_cos();
                // ψ turns from where light flies straight on, away from the viewer.
                let light = [-sin * x, sin * y, *cos];
                let h = [light[0] + sin_v, light[1], light[2] + n_dot_v];
                let length = h.iter().map(|c| c * c).sum::<f64>().sqrt();
                let once = layer.once(h[0].hypot(h[1]) / length, h[2] / length, *cos);
                // A cosine series.
                let (mut sum, mut one, mut next) = (0.5 * often[0][k], x, 2.0 * x * x - 1.0);
                for mode in &often[1..] {
                    sum += mode[k] * one;
                    (one, next) = (next, 2.0 * x * next - one);
                }
                nodes.light.push(light);
                nodes.value.push(once + sum / PI);
                // Both halves of the turn.
                nodes.solid_angle_sr.push(2.0 * weight * d_psi);
            }
        }
        nodes
    }

    /// ∫ f (n·l) cos(mψ) dψ over a turn of light that is scattered more than once, mode by mode at each ordinate.
    fn often(&self, n_dot_v: f64) -> Vec<Vec<f64>> {
        let layer = &self.layer;
        let first = area(layer.sigma, n_dot_v) / n_dot_v;
        let joined = layer.ordinates.joined(n_dot_v, MODES);
        let mut reflected = 0.0;
        let mut often = vec![];
        for (join, [same, opposite]) in self.joins.iter().zip(&joined) {
            let on = |emitted: &[f64]| layer.scattered(join, &layer.flown(emitted));
            let mut emitted = layer.scattered(join, &self.first(n_dot_v, first, [same, opposite]));
            if often.is_empty() {
                reflected = self.upwards(&emitted).1;
            }
            let Some(scatterings) = self.scatterings else {
                let all = fixed_point(&emitted, on, MISSED);
                often.push(self.above(&all));
                continue;
            };
            let mut sums = vec![0.0; layer.ordinates.count()];
            for _ in 2..scatterings {
                if self.upwards(&emitted).1 <= FAINT * reflected {
                    break;
                }
                sums.iter_mut().zip(self.above(&emitted)).for_each(|(sum, x)| *sum += x);
                emitted = on(&emitted);
            }
            // What the last scattering sends up.
            sums.iter_mut().zip(self.upwards(&emitted).0).for_each(|(sum, x)| *sum += x);
            often.push(sums);
        }
        often
    }

    /// Of what was scattered upwards: how much leaves above, at each ordinate.
    fn above(&self, emitted: &[f64]) -> Vec<f64> {
        let n = self.layer.depths();
        let up = emitted[emitted.len() / 2..].chunks(n).zip(self.leaving.chunks(n));
        up.map(|(up, leaving)| up.iter().rev().zip(leaving).map(|(x, w)| w * x).sum()).collect()
    }

    /// The same of what was scattered upwards, whether it leaves or not, and of all ordinates how much there is.
    fn upwards(&self, emitted: &[f64]) -> (Vec<f64>, f64) {
        let weights = &self.layer.slab.weight;
        let up = emitted[emitted.len() / 2..].chunks(weights.len());
        let up: Vec<f64> = up.map(|up| up.iter().zip(weights).map(|(x, w)| w * x).sum()).collect();
        let all = up.iter().zip(&self.layer.ordinates.weight).map(|(x, w)| w * x.abs()).sum();
        (up, all)
    }

    /// Where light that was scattered once meets its second fibre, in closed form.
    fn first(&self, n_dot_v: f64, first: f64, joined: [&Vec<f64>; 2]) -> State {
        let layer = &self.layer;
        let ordinates = &layer.ordinates;
        let state = |half: usize| -> State {
            let at = |j: usize| {
                let rate = joined[half][j] / (ordinates.weight[j] * n_dot_v);
                let second = layer.extinction[j];
                layer.slab.depth.iter().map(move |z| {
                    let met = if half == 0 {
                        // Down: ∫ exp(−first z') exp(−second (z − z')) dz' from 0 to z.
                        let (low, apart) = (first.min(second), (first - second).abs());
                        let between = if apart * z > 1e-9 { -(-apart * z).exp_m1() / apart } else { *z };
                        (-low * z).exp() * between
                    } else {
                        // Up, z from below: ∫ exp(−first z') exp(−second (z' − (1 − z))) dz' from 1 − z to 1.
                        (-first * (1.0 - z)).exp() * -(-(first + second) * z).exp_m1() / (first + second)
                    };
                    rate * second * met
                })
            };
            (0..ordinates.count()).flat_map(at).collect()
        };
        [0, 1].into_iter().flat_map(state).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DETAIL: Detail = Detail { even: 0.1, finest: 0.05, cosines: 8, panel: 1.2, depths: 24, azimuths: 16 };

    #[test]
    fn no_light_is_lost_from_order_to_order() {
        for (alpha, n_dot_v) in [(0.1, 0.02), (0.3, 0.4), (1.0, 0.8)] {
            let sigma: f64 = alpha * alpha;
            let lobes = FibreLobes::new(sigma, PUBLISHED, DETAIL);
            let layer = &lobes.layer;
            let n = layer.depths();
            let over = |values: Vec<f64>| values.iter().zip(&layer.ordinates.weight).map(|(x, w)| x * w).sum::<f64>();
            let mirrored = |state: &[f64]| -> State {
                let (one, other) = state.split_at(state.len() / 2);
                [other, one].concat()
            };
            let leaves = |state: &[f64]| over(lobes.above(state)) + over(lobes.above(&mirrored(state)));
            let inside = |state: &[f64]| lobes.upwards(state).1 + lobes.upwards(&mirrored(state)).1;
            // What is scattered once, at every depth.
            let extinction = area(sigma, n_dot_v) / n_dot_v;
            let [same, opposite] = &layer.ordinates.joined(n_dot_v, 1)[0];
            let rate = |joined: &[f64], j: usize| joined[j] / (layer.ordinates.weight[j] * n_dot_v);
            let first = |half: usize| {
                let (layer, joined) = (&layer, [same, opposite][half]);
                (0..joined.len()).flat_map(move |j| {
                    let depth = move |z: &f64| if half == 0 { *z } else { 1.0 - z };
                    layer.slab.depth.iter().map(move |z| rate(joined, j) * (-extinction * depth(z)).exp())
                })
            };
            let once: State = first(0).chain(first(1)).collect();
            assert_eq!(once.len(), 2 * n * same.len());
            let mut gone = (-extinction).exp() + leaves(&once);
            let met = lobes.first(n_dot_v, extinction, [same, opposite]);
            let mut emitted = layer.scattered(&lobes.joins[0], &met);
            for order in 2..9 {
                let all = gone + inside(&emitted);
                assert!((all - 1.0).abs() < 2e-6, "{alpha} {n_dot_v} order {order}: {all}");
                gone += leaves(&emitted);
                emitted = layer.scattered(&lobes.joins[0], &layer.flown(&emitted));
            }
        }
    }

    #[test]
    fn fibres_like_spheres_pass_on_what_grey_gas_does() {
        // sigma = 1 scatters alike in all directions, in a slab of optical depth 1. Of diffuse light 0.5534 passes it: the heat
        // flux between black plates with such a gas between them (Heaslet, Warming 1965, table of Q over tau).
        let albedo = FibreAlbedo::new(1.0, None, DETAIL);
        let rule = gauss_legendre(20);
        let reflected: f64 = rule
            .iter()
            .map(|node| 0.5 * (1.0 + node.x))
            .zip(&rule)
            .map(|(cos, node)| node.weight * cos * albedo.at(cos))
            .sum();
        assert!((1.0 - reflected - 0.5534).abs() < 1e-4, "{reflected}");
    }
}
