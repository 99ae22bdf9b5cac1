// SPDX-License-Identifier: MIT OR Apache-2.0
//! The truth about transmission through a rough dielectric: adaptive f64 integration over *refracted directions*.
//!
//! Independent of the rule that bakes, which integrates over half vectors: this integrates the transmittance as it is
//! written, E = ∫ |v·h| |l·h| eta² (1 − F) D G/((n·v) (v·h + eta l·h)²) dω_l (Walter, Marschner, Li, Torrance 2007, Eq. 16
//! and 21), in the polar angle of l measured from the direction of a flat surface's refraction, and the azimuth.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::bake::Model;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::term::visibility::Directions;

/// More panels than any lobe needs.
const MAX_PANELS: usize = 400;

/// The share of light that single scattering transmits, to about `tolerance`.
///
/// Domain: n_dot_v and roughness in [0, 1], an isotropic distribution, Smith's geometry term, a dielectric; a lobe that has
/// shrunk to a mirror returns its closed form.
pub fn transmitted(model: &Model, n_dot_v: f64, roughness: f64, tolerance: f64) -> Estimate<1> {
    let (ndf, mu, eta) = (&model.ndf, n_dot_v, model.fresnel.optics.eta[0]);
    let through = |v_dot_h: f64| 1.0 - model.fresnel.weights(v_dot_h)[1];
    let Some(lobe) = ndf.lobe(roughness) else { return Estimate { value: [through(mu)], error: 0.0 } };
    let sv = ((1.0 - mu) * (1.0 + mu)).sqrt();
    let theta_v = sv.atan2(mu);
    let sigma_v = ndf.sigma(mu, &lobe);
    // A flat surface refracts v to here; along the horizon where it would reflect all.
    let sin_t = (sv / eta).min(1.0);
    let cos_t = ((1.0 - sin_t) * (1.0 + sin_t)).sqrt();
    let theta_t = sin_t.atan2(cos_t);

    // The half vector lies on the normal's side: the ray behind a denser medium is steeper than it, or less steep.
    let limit = (mu / eta).min(1.0).acos();
    let (from, to) = if eta > 1.0 { (0.0, limit) } else { (limit, FRAC_PI_2) };
    // Which l a half vector can refract v to at all: v·l below −1/eta from outside, below −eta from inside.
    let bound = eta.min(1.0 / eta);
    let rim = bound.acos();

    // Offsets stretched by sinh, so that peak and tails get panels of like width.
    let peak = (2.0 * lobe.peak * (eta * cos_t - mu).abs() / (eta * cos_t.max(0.1))).max(1e-9);
    let warp = |theta_l: f64| ((theta_l - theta_t) / peak).asinh();
    let panels = |from: f64, to: f64, width: f64| -> Vec<f64> {
        let n = ((to - from) / width).ceil().max(1.0);
        (0..=n as usize).map(|i| from + (to - from) * i as f64 / n).collect()
    };
    let mut breaks = panels(warp(from), 0.0, 6.0);
    breaks.extend(panels(0.0, warp(to), 6.0).into_iter().skip(1));
    let span = breaks[breaks.len() - 1] - breaks[0];
    let mut inside = |theta_l: f64| {
        if theta_l > from && theta_l < to {
            breaks.push(warp(theta_l));
        }
    };
    inside((theta_v - rim).abs());
    inside(theta_v + rim);
    // At grazing a geometry term changes within n·v.
    let mut height = FRAC_PI_2 / 8.0;
    while height > 0.3 * mu.max(1e-4) {
        inside(FRAC_PI_2 - height);
        height *= 0.2;
    }
    breaks.sort_by(f64::total_cmp);

    // Towards v from h: the sum of v and eta l points away from it where the medium behind is the denser one.
    let sign = if eta > 1.0 { -1.0 } else { 1.0 };
    let found = integrate(&breaks, 0.5 * tolerance, MAX_PANELS, |y| {
        let offset = peak * y.sinh();
        let theta_l = theta_t + offset;
        let (sin_l, n_dot_l) = (theta_l.sin(), theta_l.cos().max(0.0));
        let sigma_l = ndf.sigma(n_dot_l, &lobe);
        let hz = sign * (mu - eta * n_dot_l);
        // By differences, so that nothing cancels near the peak.
        let flat = sv - eta * sin_t;
        let hx_plane = sign * (flat - 2.0 * eta * (theta_t + 0.5 * offset).cos() * (0.5 * offset).sin());
        let least = (bound - mu * n_dot_l) / (sin_l * sv);
        if hz <= 0.0 || least >= 1.0 {
            return Estimate { value: [0.0], error: 0.0 };
        }
        let last = least.max(-1.0).acos();
        let narrow = ((lobe.peak * hz).hypot(hx_plane) / (eta * sin_l)).clamp(1e-30, PI);
        let scale = peak * y.cosh();
        let inner_breaks = panels(0.0, (last / narrow).asinh(), 8.0);
        let inner = integrate(&inner_breaks, 0.2 * tolerance / (span * scale), MAX_PANELS, |x| {
            let phi = narrow * x.sinh();
            let half = (0.5 * phi).sin();
            let hx = hx_plane + sign * 2.0 * eta * sin_l * half * half;
            let hy = eta * sin_l * phi.sin();
            let flat2 = hx * hx + hy * hy;
            let length2 = flat2 + hz * hz;
            let length = length2.sqrt();
            // −v·l.
            let opposite = sin_l * sv * phi.cos() + mu * n_dot_l;
            let v_dot_h = ((eta * opposite - 1.0).abs() / length).min(1.0);
            let l_dot_h = (eta - opposite).abs() / length;
            let n_dot_h = hz / length;
            let d = ndf.d(hz * hz / length2, flat2 / length2, &lobe);
            let alpha = lobe.alpha;
            let directions = Directions { n_dot_l, n_dot_v: mu, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha };
            let g = (model.visibility.g_over_n_dot_v)(&directions);
            let f = v_dot_h * l_dot_h * eta * eta * through(v_dot_h) * d * g / length2;
            // Both halves of the azimuth; Jacobians of angle and stretch.
            Estimate { value: [2.0 * f * sin_l * narrow * x.cosh()], error: 0.0 }
        });
        Estimate { value: [inner.value[0] * scale], error: inner.error * scale }
    });
    // On a first, wide panel a coarse and a fine rule can agree by accident: never claim more than was asked for.
    Estimate { error: found.error.max(tolerance), ..found }
}
