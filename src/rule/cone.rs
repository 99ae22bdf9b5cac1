// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cone rule: GGX lobes of any Smith-like geometry term, exact horizon, 324 nodes for 3e-7.
//!
//! Half vectors whose mirror direction lies above the surface fill a *quadratic cone*. Stretch space by
//! diag(1/alpha, 1/alpha, 1), where the visible GGX normals seen from v have a density proportional to the cosine with
//! the stretched view vector (Walter et al. 2007; Heitz 2018). There the cone's principal axes are closed form; in
//! latitude and longitude about them the region is a rectangle. No node is masked off, n·l > 0 everywhere, and the
//! integrand is smooth up to a square-root end, which the node maps of [`super::cone_nodes`] remove.
//!
//! With mu = n·v, sv = √(1 − mu²), a = alpha, b² = 1 − a²: the axes turn by the angle whose cosine is `cm`, the
//! half-angle of the cone across is `am`, and sin² of its half-width along is `s2` at each latitude. For a node,
//! `k = (n·l) N²` is a product of distances to the horizon, so it vanishes exactly there, N² = a² + b² h_z² turns the
//! stretched half vector back, and `m = 1 − v·h`.
//!
//! Two lengths cancel: the density is σ(v)⁻¹ times the stretched cosine, and σ(v) = ½ (mu + |stretched v|), so that
//! `cd` and `sd` are taken with the stretched view vector as it is, not normalised, and only 2 am/π is left in front.
//!
//! The set-up is written with mu·P in place of P = √(h² + (a sv/mu)²), so that mu = 0, the limit at grazing, is an
//! ordinary input. At alpha = 0 the lobe is a mirror: the limit is returned.

use std::sync::LazyLock;

use super::cone_nodes::{Inner, Outer, inner, outer};
use crate::ndf::ggx;
use crate::term::fresnel::{Fresnel, WEIGHTS, Weights, schlick};
use crate::term::visibility::Directions;

static NODES: LazyLock<(Vec<Outer>, Vec<Inner>)> = LazyLock::new(|| (outer(), inner()));

/// Directional albedo with F replaced by each weight of a smooth Fresnel term.
///
/// Domain: n_dot_v and alpha in [0, 1]. `g_over_n_dot_v` is G/(n·v) of a smooth geometry term. The GLSL twin is
/// `shaders/rule/cone.glsl`; f64 error against adaptive integration ≤ 5e-7 over n·v, roughness in [1/1024, 1].
pub fn cone(n_dot_v: f64, alpha: f64, g_over_n_dot_v: impl Fn(&Directions) -> f64, fresnel: &Fresnel) -> Weights {
    // The usual term is inlined.
    if std::ptr::eq(fresnel.term, &schlick::SCHLICK) {
        weighted(n_dot_v, alpha, g_over_n_dot_v, |v_dot_h| schlick::weights(v_dot_h, &fresnel.optics))
    } else {
        weighted(n_dot_v, alpha, g_over_n_dot_v, |v_dot_h| fresnel.weights(v_dot_h))
    }
}

/// [`cone`] for any weights.
fn weighted(
    n_dot_v: f64,
    alpha: f64,
    g_over_n_dot_v: impl Fn(&Directions) -> f64,
    weights: impl Fn(f64) -> Weights,
) -> Weights {
    let mu = n_dot_v;
    let sv2 = (1.0 - mu) * (1.0 + mu);
    let sv = sv2.sqrt();
    if alpha == 0.0 {
        return mirror(mu, g_over_n_dot_v, weights);
    }

    // The cone's axes and size; a trailing `_mu` marks a quantity multiplied by mu.
    let a2 = alpha * alpha;
    let b2 = (1.0 - alpha) * (1.0 + alpha);
    let tau_mu = alpha * sv;
    let h_mu = 0.5 * (1.0 + a2) * mu;
    let p_mu = (h_mu * h_mu + tau_mu * tau_mu).sqrt();
    let cm = (0.5 + 0.5 * h_mu / p_mu).sqrt();
    let sm = tau_mu / (2.0 * p_mu * cm);
    let cd = mu * cm + tau_mu * sm;
    let sd = tau_mu * cm - mu * sm;
    let q_mu = p_mu + 0.5 * b2 * mu;
    let beta = (alpha * (mu / q_mu).sqrt()).atan();
    let am = std::f64::consts::FRAC_PI_2 - beta;
    let sigma_v = ggx::sigma(mu, alpha);

    let mut sum = [0.0; WEIGHTS];
    for node in &NODES.0 {
        // One latitude: e is the angle from the cone's edge.
        let e = am * node.near;
        let cos_a = (beta + e).sin();
        let cos2_a = cos_a * cos_a;
        let product = e.sin() * (2.0 * beta + e).min(am * node.far).sin();
        let s2 = ((a2 * mu + q_mu) * product / (2.0 * p_mu * cos2_a)).min(1.0);
        let c2 = (tau_mu * tau_mu / (p_mu + h_mu) + a2 * mu / cos2_a) / (2.0 * p_mu);
        let s = s2.sqrt();
        let k_scale = 2.0 * p_mu * cos2_a * s2;

        let mut row = [0.0; WEIGHTS];
        for pair in &NODES.1 {
            let cos_d = (c2 + s2 * pair.one_minus_x2).sqrt();
            let tan_d = s * pair.x / cos_d;
            let cos_h = cos_a * cos_d;
            let k = k_scale * pair.one_minus_x2;
            for sign in [1.0, -1.0] {
                let hz = cos_h * (cm + sign * sm * tan_d);
                let q = cd - sign * sd * tan_d;
                let n2 = a2 + b2 * hz * hz;
                let n_dot_l = k / n2;
                let sigma_l = ggx::sigma(n_dot_l, alpha);
                let v_dot_h = cos_h * q / n2.sqrt();
                let d = Directions { n_dot_l, n_dot_v: mu, n_dot_h: hz / n2.sqrt(), v_dot_h, sigma_l, sigma_v, alpha };
                let f = pair.weight * q * g_over_n_dot_v(&d);
                row.iter_mut().zip(weights(v_dot_h)).for_each(|(r, w)| *r += f * w);
            }
        }
        row.iter().zip(&mut sum).for_each(|(r, s)| *s += node.weight * cos2_a * s2.sqrt() * r);
    }
    sum.map(|s| s * am * std::f64::consts::FRAC_2_PI)
}

/// The limit of any lobe that narrows to a mirror: the weights of F at n·v times G(v, mirrored v).
pub fn mirror(n_dot_v: f64, g_over_n_dot_v: impl Fn(&Directions) -> f64, weights: impl Fn(f64) -> Weights) -> Weights {
    // At grazing G may be a quotient of zeros; just above it is its limit.
    let mu = n_dot_v.max(1e-6);
    let d = Directions { n_dot_l: mu, n_dot_v: mu, n_dot_h: 1.0, v_dot_h: mu, sigma_l: mu, sigma_v: mu, alpha: 0.0 };
    let g = mu * g_over_n_dot_v(&d);
    weights(n_dot_v).map(|w| g * w)
}
