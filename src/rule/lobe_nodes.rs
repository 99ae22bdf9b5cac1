// SPDX-License-Identifier: MIT OR Apache-2.0
//! Nodes over all directions of light, placed where a lobe is: what fits of the whole lobe are summed over.
//!
//! Every light direction l belongs to one half vector h with v·h > 0, and dω_l = 4 (v·h) dω_h. The polar angle of h runs
//! through the coordinate in which the distribution is flat ([`crate::ndf::Flat`]), and evenly where that does not reach;
//! its azimuth from v's over half a turn, which mirror symmetry doubles. h below the surface is visited too: it belongs to
//! light from far below the horizon, where a BRDF is 0 and a fitted lobe may not be.
//!
//! For a fixed polar angle the horizon n·l = 0 and the limit v·h = 0 are cosines of the azimuth, so that azimuth panels end
//! there; polar panels end where such a line enters or leaves, at (π/2 ± θ_v)/2 and π/2 − θ_v. Kinks of a geometry term are
//! not followed. Azimuths crowd at the plane of incidence, where a lobe that is fitted at grazing angles has a ridge of a
//! small part of the BRDF's width, and at the horizon, which a BRDF leaves steeply there.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::h_split::Row;
use crate::bake::{At, Model};
use crate::ndf::{Lobe, Ndf};
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::term::visibility::Directions;

/// Directions of light with what the lobe sends there and the solid angle that each stands for, of both halves of space
/// that mirror each other in the plane of incidence. v lies in that plane, at positive x.
#[derive(Clone, Debug, Default)]
pub struct LobeNodes {
    /// Unit vectors towards the light; y ≥ 0.
    pub light: Vec<[f64; 3]>,
    /// f (n·l), per steradian; 0 below the horizon.
    pub value: Vec<f64>,
    /// Solid angle in steradians.
    pub solid_angle_sr: Vec<f64>,
}

/// How finely nodes lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Gauss–Legendre nodes of a polar panel.
    pub polar: usize,
    /// Gauss–Legendre nodes of an azimuth panel.
    pub azimuth: usize,
    /// Longest polar panel in units of the flat coordinate.
    pub panel: f64,
}

/// A polar angle of half vectors.
#[derive(Clone, Copy, Debug)]
pub struct Polar {
    /// Its sine.
    pub sin: f64,
    /// Its cosine; negative below the surface.
    pub cos: f64,
    /// ∫ sin θ dθ that it stands for.
    pub weight: f64,
}

/// The azimuth in which nodes lie evenly: ψ = width · sinh(t) from either end of the half turn.
struct Crowded {
    width: f64,
    /// t of a quarter turn.
    quarter: f64,
}

impl Crowded {
    /// `peak_rad` is the angular size of the lobe's peak; half vectors on a small circle see all of it.
    fn new(peak_rad: f64, sin_h: f64) -> Crowded {
        let width = peak_rad * (RIDGE * peak_rad).max(LEAST_RIDGE) / sin_h.max(1e-300);
        let width = width.min(1e3);
        Crowded { width, quarter: (FRAC_PI_2 / width).asinh() }
    }

    fn at(&self, psi: f64) -> f64 {
        if psi <= FRAC_PI_2 {
            (psi / self.width).asinh()
        } else {
            2.0 * self.quarter - ((PI - psi) / self.width).asinh()
        }
    }

    /// ψ and dψ/dt.
    fn psi(&self, t: f64) -> (f64, f64) {
        let near = if t <= self.quarter { t } else { 2.0 * self.quarter - t };
        let psi = self.width * near.sinh();
        (if t <= self.quarter { psi } else { PI - psi }, self.width * near.cosh())
    }
}

/// Width of the ridge over the peak's: a share of the peak's own width, and at least this.
const RIDGE: f64 = 0.3;
const LEAST_RIDGE: f64 = 0.05;
/// Longest panel of the polar angle itself.
const PANEL_RAD: f64 = 0.4;
/// A lobe whose tail ends nearer to the normal than this is 0 beyond, and so is the third power of whatever fits it.
const NARROW_RAD: f64 = 0.15;

impl LobeNodes {
    /// The nodes of f (n·l) with F = 1 of an isotropic microfacet model. `None` for a mirror.
    pub fn of_model(model: &Model, at: At, fineness: Fineness) -> Option<LobeNodes> {
        let row = Row::new(&model.ndf, model.visibility, at.roughness);
        let lobe = row.lobe?;
        let area = |x: f64| if model.visibility.smith { row.projected_area(x) } else { x };
        let (mu, sigma_v) = (at.n_dot_v, area(at.n_dot_v));
        let polar = polar(&model.ndf, &lobe, mu, fineness);
        Some(LobeNodes::over(&polar, mu, fineness.azimuth, lobe.peak, |sin_h, n_dot_h, v_dot_h, n_dot_l| {
            let alpha = lobe.alpha;
            let sigma_l = area(n_dot_l);
            let d = model.ndf.d(n_dot_h * n_dot_h, sin_h * sin_h, &lobe);
            let directions = Directions { n_dot_l, n_dot_v: mu, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha };
            0.25 * d * (model.visibility.g_over_n_dot_v)(&directions)
        }))
    }

    /// The nodes over these polar angles of half vectors; `peak_rad` is the angular size of the lobe's peak.
    /// `f(sin θ_h, n·h, v·h, n·l)` is the lobe above the horizon.
    pub fn over(
        polar: &[Polar],
        n_dot_v: f64,
        azimuth: usize,
        peak_rad: f64,
        f: impl Fn(f64, f64, f64, f64) -> f64,
    ) -> LobeNodes {
        let rule = gauss_legendre(azimuth);
        let (mu, sin_v) = (n_dot_v, ((1.0 - n_dot_v) * (1.0 + n_dot_v)).sqrt());
        let mut nodes = LobeNodes::default();
        for Polar { sin, cos, weight } in polar.iter().copied() {
            // cos ψ at v·h = 0 and at n·l = 2 (v·h)(n·h) − n·v = 0.
            let scale = sin_v * sin;
            let at = |v_dot_h: f64| if scale > 0.0 { (v_dot_h - mu * cos) / scale } else { f64::NEG_INFINITY };
            let last = if at(0.0) >= 1.0 { continue } else { at(0.0).max(-1.0).acos() };
            let horizon = if cos > 0.0 { at(0.5 * mu / cos) } else { f64::INFINITY };
            let horizon = horizon.clamp(-1.0, 1.0).acos().min(last);
            let crowded = Crowded::new(peak_rad, sin);
            let (horizon, last, quarter) = (crowded.at(horizon), crowded.at(last), crowded.quarter);
            let mut ends = [0.0, horizon, quarter.min(last), last];
            ends.sort_by(f64::total_cmp);
            for pair in ends.windows(2).filter(|pair| pair[1] > pair[0]) {
                let (from, to) = if pair[1] == horizon { (pair[1], pair[0]) } else { (pair[0], pair[1]) };
                for node in &rule {
                    let u = 0.5 * (1.0 + node.x);
                    let (t, slope) = if from == horizon && horizon < last {
                        (from + (to - from) * u * u, 2.0 * u)
                    } else {
                        (from + (to - from) * u, 1.0)
                    };
                    let (psi, d_psi) = crowded.psi(t);
                    let (y, x) = psi.sin_cos();
                    let v_dot_h = (scale * x + mu * cos).max(0.0);
                    let twice = 2.0 * v_dot_h;
                    let light = [twice * sin * x - sin_v, twice * sin * y, twice * cos - mu];
                    let lit = cos > 0.0 && light[2] > 0.0;
                    let d_azimuth = 0.5 * node.weight * (to - from).abs() * slope * d_psi;
                    nodes.light.push(light);
                    nodes.value.push(if lit { f(sin, cos, v_dot_h, light[2]) } else { 0.0 });
                    // Both halves of the turn.
                    nodes.solid_angle_sr.push(2.0 * weight * d_azimuth * 4.0 * v_dot_h);
                }
            }
        }
        nodes
    }

    /// ∫ f (n·l) dω_l.
    pub fn albedo(&self) -> f64 {
        self.value.iter().zip(&self.solid_angle_sr).map(|(f, w)| f * w).sum()
    }
}

/// Polar angles at which an isotropic distribution is integrated.
fn polar(ndf: &Ndf, lobe: &Lobe, n_dot_v: f64, fineness: Fineness) -> Vec<Polar> {
    let flat = &ndf.family.flat;
    let rule = gauss_legendre(fineness.polar);
    let theta_v = n_dot_v.acos();
    // Where a line of the azimuth enters or leaves; below the surface h starts at π/2 − θ_v from the downward normal.
    let ends = [FRAC_PI_4 - 0.5 * theta_v, FRAC_PI_4 + 0.5 * theta_v, FRAC_PI_2 - theta_v];
    let flat_end = (flat.tan)(flat.y_max, lobe).atan();
    let rest = match flat.falling {
        true => [0.0, flat_end],
        false if flat_end < NARROW_RAD => [flat_end; 2],
        false => [flat_end, FRAC_PI_2],
    };
    let mut list = vec![];
    for side in [1.0, -1.0] {
        let first = if side > 0.0 { 0.0 } else { ends[2] };
        // The flat coordinate: y falls where the facets of a family stand upright.
        let y_first = if first > 0.0 {
            (flat.y)(first.tan(), lobe)
        } else if flat.falling {
            flat.y_max
        } else {
            0.0
        };
        let (low, high) = if flat.falling { (0.0, y_first.min(flat.y_max)) } else { (y_first, flat.y_max) };
        let inside = ends.iter().map(|end| (flat.y)(end.max(1e-300).tan(), lobe));
        for (y, dy) in nodes_between(low, high, inside, fineness.panel, &rule) {
            let tan = (flat.tan)(y, lobe);
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            let sin = tan * cos;
            // 2π D cos θ sin θ dθ is the density dy.
            let d = ndf.d(cos * cos, sin * sin, lobe);
            let weight = dy * (flat.density)(y, tan, lobe) / (2.0 * PI * d * cos);
            if weight.is_finite() {
                list.push(Polar { sin, cos: side * cos, weight });
            }
        }
        for (theta, d_theta) in nodes_between(rest[0].max(first), rest[1], ends.into_iter(), PANEL_RAD, &rule) {
            let (sin, cos) = theta.sin_cos();
            list.push(Polar { sin, cos: side * cos, weight: sin * d_theta });
        }
    }
    list
}

/// Nodes and weights over [low, high] with panels no longer than `longest` that end at `inside` too.
pub(super) fn nodes_between(
    low: f64,
    high: f64,
    inside: impl Iterator<Item = f64>,
    longest: f64,
    rule: &[Node],
) -> Vec<(f64, f64)> {
    let mut ends: Vec<f64> = inside.filter(|end| *end > low && *end < high).chain([low, high]).collect();
    ends.sort_by(f64::total_cmp);
    let mut nodes = vec![];
    for pair in ends.windows(2).filter(|pair| low < high && pair[1] > pair[0]) {
        let panels = ((pair[1] - pair[0]) / longest).ceil().max(1.0);
        let half = 0.5 * (pair[1] - pair[0]) / panels;
        for panel in 0..panels as usize {
            let middle = pair[0] + half * (2 * panel + 1) as f64;
            nodes.extend(rule.iter().map(|node| (middle + half * node.x, half * node.weight)));
        }
    }
    nodes
}
