// SPDX-License-Identifier: MIT OR Apache-2.0
//! The h-split rule: any isotropic distribution with any geometry term, kinks included.
//!
//! The half vector is split into its polar angle and its azimuth ψ from v's. With t = tan θ_h, c = cos θ_h, mu = n·v and
//! sv = sin θ_v the mirror direction follows: v·h = c (t sv cos ψ + mu), n·l = 2 c (v·h) − mu, and
//!
//! E = ∫ D(h) [4 V (n·l)] (v·h) dh = (1/π) ∫ dy W(y)/c ∫ dψ [4 V (n·l)] (v·h),   W dy = 2π D cos θ sin θ dθ,
//!
//! where y is the coordinate in which the distribution is flat ([`crate::ndf::Flat`]) and ψ runs over half a turn.
//!
//! All that is not smooth is linear in cos ψ for fixed t: the horizon, cos ψ ≥ mu (t² − 1)/(2 t sv), and every kink of
//! every geometry term ([`crate::term::visibility::Kinks`]). So azimuth panels end at arc cosines of closed forms, and
//! the polar panels end where such a line enters or leaves the range of cos ψ, closed forms of t. Gauss–Legendre does the
//! rest. The distribution is seen by the outer nodes only: the host places them in f64, and a kernel integrates rings.
//!
//! Smith's function of a distribution without a closed form, or with an expensive one, is expanded once a row into a
//! Chebyshev series ([`Row`]).

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::azimuth_nodes::azimuth_nodes;
use crate::ndf::{Lobe, Ndf};
use crate::quadrature::gauss_legendre::Node;
use crate::term::fresnel::internal::fresnel_kink;
use crate::term::fresnel::{Fresnel, WEIGHTS, Weights};
use crate::term::trig::half_acos;
use crate::term::visibility::{Directions, Visibility};

/// Coefficients of Smith's function.
pub const TERMS: usize = 24;
/// Numbers that describe a row to a kernel.
pub const ROW_LEN: usize = 8 + TERMS;

/// cos(k (j + ½) π/TERMS)·2/TERMS: values at Chebyshev points to coefficients.
static TRANSFORM: LazyLock<Vec<[f64; TERMS]>> = LazyLock::new(|| {
    let entry = |k: usize, j: usize| (k as f64 * (j as f64 + 0.5) * PI / TERMS as f64).cos() * 2.0 / TERMS as f64;
    (0..TERMS).map(|k| std::array::from_fn(|j| entry(k, j))).collect()
});

/// Azimuth nodes by size.
pub(super) static AZIMUTH: LazyLock<[Vec<Vec<Node>>; 2]> =
    LazyLock::new(|| [false, true].map(|far| (0..=64).map(|n| azimuth_nodes(n.max(1), far)).collect()));

/// Powers and scales (in mean slopes) of the map that are tried in turn, and the tail of the series that ends the search.
const MAPS: [(f64, f64); 9] = [
    (1.0, 2.0),
    (0.5, 1.0),
    (1.0, 4.0),
    (0.25, 0.3),
    (0.25, 0.03),
    (0.125, 0.3),
    (0.125, 0.03),
    (0.125, 0.003),
    (0.125, 0.0003),
];
const GOOD: f64 = 5e-7;
/// Stands for 0 where a cosine is divided by another one; as in `shaders/rule/h_split.glsl`.
pub(super) const LEAST_COSINE: f64 = 1e-20;

/// What a row of a table, one roughness, has in common.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The distribution's member; `None` at roughness 0.
    pub lobe: Option<Lobe>,
    /// 1 to expand sigma − n·x in n·x; ½ to expand sigma − n·x/2 = ½ ∫ |x·h| D(h) dh, which is even in n·x, in the sine.
    linear: f64,
    /// 1/scale of u, n·x or the sine, in v = (1 + u/scale)^(−power).
    inverse_scale: f64,
    /// 1, ½, ¼ or ⅛: the longer the tail of Smith's function, the smaller.
    power: f64,
    /// x = v·stretch + offset runs over [−1, 1].
    stretch: f64,
    offset: f64,
    /// sigma − linear·n·x is Σ coefficients[k] T_k(x).
    coefficients: [f64; TERMS],
}

impl Row {
    /// The row of a distribution at a roughness. Smith's function is expanded only for a term that reads it.
    pub fn new(ndf: &Ndf, visibility: &Visibility, roughness: f64) -> Row {
        let lobe = ndf.lobe(roughness);
        let mut row = Row {
            lobe,
            linear: 1.0,
            inverse_scale: 1.0,
            power: 1.0,
            stretch: 1.0,
            offset: 0.0,
            coefficients: [0.0; TERMS],
        };
        let Some(lobe) = lobe.filter(|_| visibility.smith) else { return row };
        // Upright facets spread Smith's function over all directions; a lobe's is concentrated at the horizon, but one that
        // is nearly uniform may end in a fractional power of the sine at the normal.
        let usual = if ndf.family.flat.falling { 0.5 } else { 1.0 };
        let best = row.expand(ndf, &lobe, usual, &MAPS, f64::INFINITY);
        if best > GOOD {
            // Gentle maps only, and for a clear gain: rounding grows with the steepness of the map.
            row.expand(ndf, &lobe, 1.5 - usual, &MAPS[..3], 0.1 * best);
        }
        row
    }

    /// Expands Smith's function around `linear`·n·x, with one map after the other until the series is good. Keeps the best one
    /// with an error, relative to the largest value, below `best`, and returns that error.
    fn expand(&mut self, ndf: &Ndf, lobe: &Lobe, linear: f64, maps: &[(f64, f64)], mut best: f64) -> f64 {
        let from_sine = linear != 1.0;
        let rest = |u: f64| {
            let n_dot_x = if from_sine { ((1.0 - u) * (1.0 + u)).sqrt() } else { u };
            ndf.sigma(n_dot_x, lobe) - linear * n_dot_x
        };
        let ends = [rest(0.0), rest(1.0)];
        // The mean slope of the facets is the length over which Smith's function decays.
        let slope = if from_sine { lobe.alpha.sqrt() } else { PI * ends[0] };
        let largest = ends[0].max(ends[1]);
        for (power, factor) in maps.iter().copied() {
            if best < GOOD {
                break;
            }
            let scale = factor * slope;
            let end = (1.0 + 1.0 / scale).powf(-power);
            let half = 0.5 * (1.0 - end);
            let at_point = |j: usize| {
                let v = 0.5 * (1.0 + end) + half * ((j as f64 + 0.5) * PI / TERMS as f64).cos();
                rest((scale * (v.powf(-1.0 / power) - 1.0)).clamp(0.0, 1.0))
            };
            let values: [f64; TERMS] = std::array::from_fn(at_point);
            let mut coefficients: [f64; TERMS] =
                std::array::from_fn(|k| TRANSFORM[k].iter().zip(&values).map(|(t, v)| t * v).sum());
            coefficients[0] *= 0.5;
            // How fast the series ends, and whether it meets both ends, where T_k is 1 or ±1.
            let tail: f64 = coefficients[TERMS - 4..].iter().map(|c| c.abs()).sum();
            let near: f64 = coefficients.iter().sum();
            let far: f64 = coefficients.iter().rev().fold(0.0, |sum, c| c - sum);
            let error = (tail + (near - ends[0]).abs() + (far - ends[1]).abs()) / largest;
            if error < best {
                best = error;
                self.linear = linear;
                self.inverse_scale = 1.0 / scale;
                self.power = power;
                self.stretch = 1.0 / half;
                self.offset = -0.5 * (1.0 + end) / half;
                self.coefficients = coefficients;
            }
        }
        best
    }

    /// Smith's projected area n·x (1 + Λ).
    pub fn projected_area(&self, n_dot_x: f64) -> f64 {
        let u = if self.linear == 1.0 { n_dot_x } else { ((1.0 - n_dot_x) * (1.0 + n_dot_x)).max(0.0).sqrt() };
        let root = 1.0 / (1.0 + u * self.inverse_scale).sqrt();
        let v = match self.power {
            1.0 => root * root,
            0.5 => root,
            0.25 => root.sqrt(),
            _ => root.sqrt().sqrt(),
        };
        let x = v * self.stretch + self.offset;
        let step = |(b1, b2): (f64, f64), c: &f64| (c + 2.0 * x * b1 - b2, b1);
        let (b1, b2) = self.coefficients[1..].iter().rev().fold((0.0, 0.0), step);
        self.linear * n_dot_x + self.coefficients[0] + x * b1 - b2
    }

    /// The row as `shaders/lib/h_table.glsl` reads it.
    pub fn packed(&self) -> [f32; ROW_LEN] {
        let mut packed = [0.0; ROW_LEN];
        let alpha = self.lobe.map_or(0.0, |l| l.alpha);
        let head = [alpha, self.inverse_scale, self.stretch, self.offset, self.power, self.linear];
        for (to, from) in packed.iter_mut().zip(head) {
            *to = from as f32;
        }
        for (to, from) in packed[8..].iter_mut().zip(self.coefficients) {
            *to = from as f32;
        }
        packed
    }
}

/// A node of the polar angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outer {
    /// tan θ_h.
    pub tan_h: f64,
    /// Everything that does not depend on the azimuth.
    pub weight: f64,
}

/// The polar nodes of a texel, appended to `nodes`; none for a lobe that has shrunk to a mirror.
pub fn outer(ndf: &Ndf, visibility: &Visibility, fresnel: &Fresnel, row: &Row, n_dot_v: f64, nodes: &mut Vec<Outer>) {
    let Some(lobe) = &row.lobe else { return };
    let flat = &ndf.family.flat;
    let (mu, sv) = (n_dot_v, sine(n_dot_v));
    let theta_v = sv.atan2(mu);

    // The range of y: up to the steepest facet that still reflects v upwards.
    let steepest = (1.0 + sv) / mu;
    let (mut low, mut high) = (0.0, flat.y_max);
    if steepest.is_finite() {
        let y = (flat.y)(steepest, lobe);
        if flat.falling { low = y } else { high = y.min(high) }
    }
    if high <= low {
        return;
    }

    // Panels between the values of y at which the azimuth's range or a kink changes its nature.
    let mut breaks = [high; 14];
    breaks[0] = low;
    let mut count = 1;
    let mut add = |tan_h: f64| {
        if tan_h > 0.0 && tan_h.is_finite() {
            let y = (flat.y)(tan_h, lobe);
            if y > low && y < high {
                breaks[count] = y;
                count += 1;
            }
        }
    };
    add(mu / (1.0 + sv));
    if let Some(kinks) = &visibility.kinks {
        (kinks.tan_h)(theta_v, lobe.alpha).into_iter().for_each(&mut add);
    }
    if let Some(critical) = fresnel.kink() {
        // v·h is critical in the plane of incidence, and on the horizon of l.
        let theta_c = critical.acos();
        add((theta_v - theta_c).tan().abs());
        add((theta_v + theta_c).tan().abs());
        add((4.0 * critical * critical / (mu * mu) - 1.0).max(0.0).sqrt());
    }
    if mu < 1.0 / 1024.0 {
        // No horizon divides the tail where it is widest: the weight (1 − v·h)⁵ needs panels of its own.
        add(0.1);
        add(1.0);
    }
    let breaks = &mut breaks[..=count];
    breaks.sort_by(f64::total_cmp);
    let crowd = crowding(visibility, fresnel, flat.falling, sv);
    for ends in breaks.windows(2) {
        let width = ends[1] - ends[0];
        if width < 1e-9 {
            continue;
        }
        // From inside the tail is cut by the critical angle, not by the horizon alone.
        let share = if flat.falling || fresnel.kink().is_some() {
            1.0
        } else {
            1.0 + 0.12 * (width.min(1.0).ln() - 0.6 * ends[0] * ends[0])
        };
        let rule = &RULES[(visibility.outer as f64 * share.clamp(0.4, 1.0)).ceil() as usize];
        for node in rule {
            let node = crowd.map(*node);
            let y = ends[0] + width * node.x;
            let tan_h = (flat.tan)(y, lobe);
            let density = (flat.density)(y, tan_h, lobe);
            // 1/π, and twice because the inner rule runs over half the azimuth.
            let weight = node.weight * width * density * (1.0 + tan_h * tan_h).sqrt() * 2.0 / PI;
            nodes.push(Outer { tan_h, weight });
        }
    }
}

/// Where the polar nodes crowd in a panel from 0 to 1.
#[derive(Clone, Copy)]
enum Crowd {
    /// At 0, by the power of a map; 1 for nowhere.
    Low(usize),
    /// At both ends.
    Both,
}

impl Crowd {
    fn map(self, node: Node) -> Node {
        let x = node.x;
        let (to, slope) = match self {
            Crowd::Low(1) => (x, 1.0),
            Crowd::Low(2) => (x * x, 2.0 * x),
            Crowd::Low(_) => (x * x * x, 3.0 * x * x),
            Crowd::Both => (x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x)),
        };
        Node { x: to, weight: slope * node.weight }
    }
}

fn crowding(visibility: &Visibility, fresnel: &Fresnel, falling: bool, sv: f64) -> Crowd {
    // Near normal incidence the polar angle alone carries what the azimuth does elsewhere: the boundary layer at the
    // horizon of Smith's and Schlick's terms, the root at the critical angle.
    let steep = visibility.smith || visibility.crowd_horizon || fresnel.kink().is_some();
    if falling {
        Crowd::Low(3)
    } else if steep && sv < 0.3 {
        Crowd::Both
    } else {
        Crowd::Low(visibility.crowd)
    }
}

/// Polar rules on [0, 1] by size.
pub(super) static RULES: LazyLock<Vec<Vec<Node>>> =
    LazyLock::new(|| (0..=64).map(|n| azimuth_nodes(n.max(1), false)).collect());

/// sin θ of a cosine, kept off 0 so that the azimuth has a meaning.
pub(super) fn sine(cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos)).sqrt().max(1e-7)
}

/// Directional albedo with F replaced by each weight of the Fresnel term, from a texel's polar nodes.
///
/// Domain: n_dot_v in [0, 1], a lobe that is not a mirror. The GLSL twin is `shaders/rule/h_split.glsl`.
pub fn h_split(visibility: &Visibility, fresnel: &Fresnel, row: &Row, n_dot_v: f64, nodes: &[Outer]) -> Weights {
    let (mu, sv) = (n_dot_v, sine(n_dot_v));
    let alpha = row.lobe.map_or(0.0, |l| l.alpha);
    let area = |x: f64| if visibility.smith { row.projected_area(x) } else { x };
    let sigma_v = area(mu);
    let azimuth = match fresnel.term.azimuth {
        Some(size) => &AZIMUTH[1][size],
        None => &AZIMUTH[usize::from(visibility.crowd_horizon)][visibility.azimuth],
    };
    let internal = fresnel.term.kink.is_some();
    let mut sum = [0.0; WEIGHTS];
    for node in nodes {
        // One polar angle of h; the azimuth counts from v's.
        let t = node.tan_h;
        let cos_h = 1.0 / (1.0 + t * t).sqrt();
        let (near, far) = (mu + t * sv, 2.0 * t * sv);
        let last = half_acos(mu * (t - 1.0) * (t + 1.0) / far);
        let mut kinks = [last; 3];
        if let Some(k) = &visibility.kinks {
            (k.azimuth)(t, mu, sv, alpha).iter().zip(&mut kinks).for_each(|(x, kink)| *kink = half_acos(*x));
        }
        if internal {
            kinks[2] = half_acos(fresnel_kink(t, mu, sv, &fresnel.optics));
        }

        let mut ring = [0.0; WEIGHTS];
        let mut from = 0.0;
        while from < last {
            let to = kinks.into_iter().filter(|kink| *kink > from).fold(last, f64::min);
            let width = to - from;
            for inner in azimuth {
                let s = (from + width * inner.x).sin();
                let v_dot_h = cos_h * (near - far * s * s).max(0.0);
                // Rounding may carry it past either end, and at grazing G would be a quotient of zeros.
                let n_dot_l = (2.0 * cos_h * v_dot_h - mu).clamp(LEAST_COSINE, 1.0);
                let sigma_l = area(n_dot_l);
                let d = Directions { n_dot_l, n_dot_v: mu, n_dot_h: cos_h, v_dot_h, sigma_l, sigma_v, alpha };
                let f = width * inner.weight * v_dot_h * (visibility.g_over_n_dot_v)(&d);
                ring.iter_mut().zip(fresnel.weights(v_dot_h)).for_each(|(r, w)| *r += f * w);
            }
            from = to;
        }
        sum.iter_mut().zip(ring).for_each(|(s, r)| *s += node.weight * r);
    }
    sum
}
