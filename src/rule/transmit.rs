// SPDX-License-Identifier: MIT OR Apache-2.0
//! Transmission through a rough dielectric by the h-split rule ([`super::h_split`]).
//!
//! With eta the refractive index behind the surface over that before it, X = v·h and h on the side of v, light that
//! arrives along the refracted direction l contributes (Walter, Marschner, Li, Torrance 2007, Eq. 21, integrated over l
//! and changed to h, where the Jacobian takes all of the index away):
//!
//! E = ∫ D(h) (1 − F(X)) [G/(n·v)] X dh = (1/π) ∫ dy W(y)/c ∫ dψ (1 − F) [G/(n·v)] X,
//!
//! |n·l| = (mu + (eta² − 1) c/(√(eta² − 1 + X²) + X))/eta, a form in which nothing cancels from outside.
//!
//! For fixed θ_h the facets that transmit are those with cos ψ above a bound, so that one azimuth panel does. From outside
//! (eta > 1) it is where v sees the facet's back, X > 0. From inside X must exceed vc = √(1 − eta²), or all is reflected;
//! and the refracted ray must leave the surface, √(X² − vc²) + X > c vc²/mu, or it hits the surface again: such rays are
//! not counted. Their bound is a closed form, X > ½ (q + vc²/q) with q = c vc²/mu, where q > vc. Polar panels end where
//! such a line enters or leaves the range of cos ψ: for the last condition where the refracted ray runs along the horizon
//! in the plane of incidence, tan θ_h = |sin θ_v ± eta|/mu.

use std::f64::consts::PI;

use super::h_split::{AZIMUTH, LEAST_COSINE, Outer, RULES, Row, sine};
use crate::ndf::Ndf;
use crate::quadrature::gauss_legendre::Node;
use crate::term::fresnel::Fresnel;
use crate::term::trig::half_acos;
use crate::term::visibility::{Directions, Visibility};

/// Polar nodes a panel from outside and from inside.
const OUTER: [usize; 2] = [28, 24];
/// Azimuth nodes a panel, crowded at its end: there 1 − F starts like a root from inside, and from outside as steeply as
/// the index is large.
const AZIMUTH_NODES: usize = 16;

/// Nodes in words.
pub fn rule_name(fresnel: &Fresnel) -> String {
    format!("transmission h-split {}x{AZIMUTH_NODES} a panel", OUTER[usize::from(fresnel.kink().is_some())])
}

/// The polar nodes of a texel, appended to `nodes`; none for a lobe that has shrunk to a mirror.
pub fn outer(ndf: &Ndf, fresnel: &Fresnel, row: &Row, n_dot_v: f64, nodes: &mut Vec<Outer>) {
    let Some(lobe) = &row.lobe else { return };
    let flat = &ndf.family.flat;
    let (mu, sv) = (n_dot_v, sine(n_dot_v));
    let eta = fresnel.optics.eta[0];
    let mut breaks = vec![0.0, flat.y_max];
    let mut add = |tan_h: f64| {
        if tan_h > 0.0 && tan_h.is_finite() {
            breaks.push((flat.y)(tan_h, lobe));
        }
    };
    match fresnel.kink() {
        None => add(mu / sv),
        Some(critical) => {
            let (theta_v, theta_c) = (sv.atan2(mu), critical.acos());
            add((theta_v - theta_c).tan().abs());
            add((theta_v + theta_c).tan());
            add((critical * critical / (mu * mu) - 1.0).max(0.0).sqrt());
            add((sv + eta) / mu);
            add((sv - eta).abs() / mu);
        }
    }
    if mu < 1.0 / 1024.0 {
        // No line divides the tail where it is widest.
        add(0.1);
        add(1.0);
    }
    breaks.retain(|y| *y <= flat.y_max);
    breaks.sort_by(f64::total_cmp);
    let inside = fresnel.kink().is_some();
    for ends in breaks.windows(2) {
        let width = ends[1] - ends[0];
        if width < 1e-9 {
            continue;
        }
        let middle = (flat.tan)(ends[0] + 0.5 * width, lobe);
        if last(middle, 1.0 / (1.0 + middle * middle).sqrt(), mu, sv, eta) == 0.0 {
            continue;
        }
        let share = 1.0 + 0.12 * (width.min(1.0).ln() - 0.6 * ends[0] * ends[0]);
        let rule = &RULES[(OUTER[usize::from(inside)] as f64 * share.clamp(0.4, 1.0)).ceil() as usize];
        for node in rule {
            let node = if inside { at_both_ends(*node) } else { *node };
            let y = ends[0] + width * node.x;
            let tan_h = (flat.tan)(y, lobe);
            let density = (flat.density)(y, tan_h, lobe);
            // 1/π, and twice because the inner rule runs over half the azimuth.
            let weight = node.weight * width * density * (1.0 + tan_h * tan_h).sqrt() * 2.0 / PI;
            nodes.push(Outer { tan_h, weight });
        }
    }
}

/// Crowds a node on [0, 1] at both ends.
fn at_both_ends(node: Node) -> Node {
    let x = node.x;
    Node { x: x * x * (3.0 - 2.0 * x), weight: 6.0 * x * (1.0 - x) * node.weight }
}

/// Half the azimuth, from v's, up to which facets at a polar angle transmit; 0 where none do. GLSL twin
/// `shaders/rule/transmit.glsl`.
fn last(tan_h: f64, cos_h: f64, n_dot_v: f64, sin_v: f64, eta: f64) -> f64 {
    half_acos((least(cos_h, n_dot_v, eta) / cos_h - n_dot_v) / (tan_h * sin_v))
}

/// The least v·h of a facet that transmits; beyond 1 where none does. GLSL twin `shaders/rule/transmit.glsl`.
fn least(cos_h: f64, n_dot_v: f64, eta: f64) -> f64 {
    if eta > 1.0 {
        return 0.0;
    }
    let critical2 = (1.0 - eta) * (1.0 + eta);
    let critical = critical2.sqrt();
    let needed = cos_h * critical2 / n_dot_v.max(1e-30);
    if needed > critical { 0.5 * (needed + critical2 / needed) } else { critical }
}

/// The share of light that a dielectric interface transmits by single scattering, from a texel's polar nodes.
///
/// Domain: n_dot_v in [0, 1], a lobe that is not a mirror, a dielectric. The GLSL twin is `shaders/rule/transmit.glsl`.
pub fn transmit(visibility: &Visibility, fresnel: &Fresnel, row: &Row, n_dot_v: f64, nodes: &[Outer]) -> f64 {
    let (mu, sv) = (n_dot_v, sine(n_dot_v));
    let eta = fresnel.optics.eta[0];
    let excess = (eta - 1.0) * (eta + 1.0);
    let alpha = row.lobe.map_or(0.0, |l| l.alpha);
    let sigma_v = row.projected_area(mu);
    let azimuth = &AZIMUTH[1][AZIMUTH_NODES];
    let mut sum = 0.0;
    for node in nodes {
        // One polar angle of h; the azimuth counts from v's.
        let t = node.tan_h;
        let cos_h = 1.0 / (1.0 + t * t).sqrt();
        let (near, far) = (mu + t * sv, 2.0 * t * sv);
        let width = last(t, cos_h, mu, sv, eta);
        let mut ring = 0.0;
        for inner in azimuth {
            let s = (width * inner.x).sin();
            let v_dot_h = cos_h * (near - far * s * s).max(0.0);
            let behind = (excess + v_dot_h * v_dot_h).max(0.0).sqrt();
            // Rounding may carry it past either end, and at grazing G would be a quotient of zeros.
            let n_dot_l = ((mu + excess * cos_h / (behind + v_dot_h)) / eta).clamp(LEAST_COSINE, 1.0);
            let sigma_l = row.projected_area(n_dot_l);
            let d = Directions { n_dot_l, n_dot_v: mu, n_dot_h: cos_h, v_dot_h, sigma_l, sigma_v, alpha };
            let transmitted = 1.0 - fresnel.weights(v_dot_h)[1];
            ring += inner.weight * v_dot_h * (visibility.g_over_n_dot_v)(&d) * transmitted;
        }
        sum += node.weight * width * ring;
    }
    sum
}
