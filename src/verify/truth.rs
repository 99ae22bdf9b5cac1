// SPDX-License-Identifier: MIT OR Apache-2.0
//! The truth about directional albedos: adaptive f64 integration over *light directions*.
//!
//! Independent of every rule that bakes: rules integrate over half vectors in the space where the lobe is flat; this
//! integrates the reflectance equation as it is written, E = ∫ D G/(4 (n·l)(n·v)) (n·l) dω_l, in the polar angle of l
//! measured from the mirror direction and the azimuth. It shares no node, no Jacobian and no change of variables with
//! them, only D and G themselves (which the laws and the published tables check).

use std::f64::consts::{FRAC_PI_2, PI};

use crate::bake::Model;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::rule::cone::mirror;
use crate::term::fresnel::{WEIGHTS, Weights};
use crate::term::visibility::Directions;

/// More panels than any smooth lobe needs; a kinked one ends here with a larger, honest error.
const MAX_PANELS: usize = 400;

/// Directional albedo with F replaced by each weight of the Fresnel term, to about `tolerance`; where the albedo exceeds 1,
/// relative to it.
///
/// Domain: n_dot_v and roughness in [0, 1]; a lobe that has shrunk to a mirror returns its closed form.
pub fn albedo(model: &Model, n_dot_v: f64, roughness: f64, tolerance: f64) -> Estimate<WEIGHTS> {
    let all = |tolerance| absolute(model, n_dot_v, roughness, tolerance, |weights| weights);
    if model.bounded() {
        return all(tolerance);
    }
    let rough = all(0.02);
    all(tolerance * (rough.value[0] - rough.error).max(1.0))
}

/// What a geometry term that keeps it within 1 reflects with the exact Fresnel term alone, the second weight of
/// [`albedo`], to about `tolerance`. All light, the first one, takes finer panels, which where F is small are many more.
pub fn reflected(model: &Model, n_dot_v: f64, roughness: f64, tolerance: f64) -> Estimate<1> {
    absolute(model, n_dot_v, roughness, tolerance, |[_, reflected, ..]| [reflected])
}

/// [`albedo`] to an absolute tolerance, of the chosen weights.
fn absolute<const N: usize>(
    model: &Model,
    n_dot_v: f64,
    roughness: f64,
    tolerance: f64,
    chosen: fn(Weights) -> [f64; N],
) -> Estimate<N> {
    let (ndf, visibility) = (&model.ndf, model.visibility);
    let mu = n_dot_v;
    let Some(lobe) = ndf.lobe(roughness) else {
        let weights = |v_dot_h| model.fresnel.weights(v_dot_h);
        return Estimate { value: chosen(mirror(mu, visibility.g_over_n_dot_v, weights)), error: 0.0 };
    };
    let sv = ((1.0 - mu) * (1.0 + mu)).sqrt();
    let theta_v = sv.atan2(mu);
    let area = |x: f64| if visibility.smith { ndf.sigma(x, &lobe) } else { x };
    let ellipse = ndf.ellipse(&lobe);
    let sigma_v = ellipse.map_or_else(|| area(mu), |ellipse| ellipse.sigma(ellipse.turned([sv, 0.0, mu])));
    // Offsets from the mirror direction, stretched by sinh so that peak and tails get panels of like width.
    let peak = 2.0 * lobe.peak;
    let warp = |offset: f64| (offset / peak).asinh();
    let panels = |from: f64, to: f64, width: f64| -> Vec<f64> {
        let n = ((to - from) / width).ceil().max(1.0);
        (0..=n as usize).map(|i| from + (to - from) * i as f64 / n).collect()
    };
    let mut breaks = panels(warp(-theta_v), 0.0, 6.0);
    breaks.extend(panels(0.0, warp(FRAC_PI_2 - theta_v), 6.0).into_iter().skip(1));
    let span = breaks[breaks.len() - 1] - breaks[0];
    // At grazing light and viewer are both near the horizon, where a geometry term changes within n·v.
    let mut height = FRAC_PI_2 / 8.0;
    while height > 0.3 * mu.max(1e-4) {
        breaks.push(warp(FRAC_PI_2 - height - theta_v));
        height *= 0.2;
    }
    breaks.extend(kink_angles(model, n_dot_v, lobe.alpha).into_iter().map(|theta_l| warp(theta_l - theta_v)));
    breaks.sort_by(f64::total_cmp);

    let found = integrate(&breaks, 0.5 * tolerance, MAX_PANELS, |y| {
        let offset = peak * y.sinh();
        let theta_l = theta_v + offset;
        let (sin_l, n_dot_l) = (theta_l.sin(), theta_l.cos().max(0.0));
        let sigma_l = area(n_dot_l);
        // l + v, its in-plane part by differences so that nothing cancels near the mirror direction.
        let hz = n_dot_l + mu;
        let hx_mirror = -2.0 * (theta_v + 0.5 * offset).cos() * (0.5 * offset).sin();
        let narrow = ((lobe.peak * hz).hypot(hx_mirror) / sin_l).clamp(1e-30, PI);
        let end = (PI / narrow).asinh();
        let scale = peak * y.cosh();
        let mut inner_breaks = panels(0.0, end, 8.0);
        for kink in kink_azimuths(model, n_dot_l, mu).into_iter().flatten() {
            // The azimuth here counts from the mirror direction, opposite to v.
            if kink.abs() < 1.0 {
                inner_breaks.push(((-kink).acos() / narrow).asinh());
            }
        }
        inner_breaks.sort_by(f64::total_cmp);
        let inner = integrate(&inner_breaks, 0.2 * tolerance / (span * scale), MAX_PANELS, |x| {
            // Sine, sinh and cosh by two functions: this runs millions of times.
            let grown = x.exp_m1();
            let [sinh, cosh] = [0.5 * (grown + grown / (1.0 + grown)), 0.5 * (1.0 + grown + 1.0 / (1.0 + grown))];
            let (sin, cos) = (0.5 * narrow * sinh).sin_cos();
            let hx = hx_mirror + 2.0 * sin_l * sin * sin;
            let hy = 2.0 * sin_l * sin * cos;
            let flat2 = hx * hx + hy * hy;
            let length2 = flat2 + hz * hz;
            let v_dot_h = 0.5 * length2.sqrt();
            let n_dot_h = 0.5 * hz / v_dot_h;
            let lit = |d: f64, sigma_l: f64| {
                let alpha = lobe.alpha;
                let directions = Directions { n_dot_l, n_dot_v: mu, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha };
                d * (visibility.g_over_n_dot_v)(&directions)
            };
            // Both halves of the azimuth.
            let halves = match ellipse {
                None => 2.0 * lit(ndf.d(hz * hz / length2, flat2 / length2, &lobe), sigma_l),
                Some(ellipse) => [hy, -hy]
                    .map(|hy| {
                        let d = ellipse.d(ellipse.turned([hx, hy, hz]).map(|x| x / length2.sqrt()));
                        lit(d, ellipse.sigma(ellipse.turned([hx - sv, hy, n_dot_l])))
                    })
                    .iter()
                    .sum(),
            };
            // The factor 1/4 of the BRDF; Jacobians of angle and stretch.
            let f = 0.25 * halves * sin_l * narrow * cosh;
            Estimate { value: chosen(model.fresnel.weights(v_dot_h.min(1.0))).map(|w| f * w), error: 0.0 }
        });
        Estimate { value: inner.value.map(|v| v * scale), error: inner.error * scale }
    });
    // On a first, wide panel a coarse and a fine rule can agree by accident: never claim more than was asked for.
    Estimate { error: found.error.max(tolerance), ..found }
}

/// Cosines of the azimuth between l and v at which the geometry term or the Fresnel term has a kink.
fn kink_azimuths(model: &Model, n_dot_l: f64, n_dot_v: f64) -> [Option<f64>; 2] {
    let geometry = model.visibility.kinks.as_ref().and_then(|k| k.light_azimuth).map(|at| at(n_dot_l, n_dot_v));
    let fresnel = model.fresnel.kink().map(|v_dot_h| {
        // l·v = 2 (v·h)² − 1
        let sines = ((1.0 - n_dot_l * n_dot_l) * (1.0 - n_dot_v * n_dot_v)).sqrt();
        (2.0 * v_dot_h * v_dot_h - 1.0 - n_dot_l * n_dot_v) / sines
    });
    [geometry, fresnel]
}

/// Polar angles of the light at which a term has a kink, or where the azimuth of one enters or leaves its range: found by
/// bisection, so that nothing is shared with the rules' closed forms.
fn kink_angles(model: &Model, n_dot_v: f64, alpha: f64) -> Vec<f64> {
    let mut found: Vec<f64> =
        model.visibility.kinks.as_ref().and_then(|k| (k.n_dot_l)(alpha)).map(f64::acos).into_iter().collect();
    for term in 0..2 {
        let side = |theta_l: f64| kink_azimuths(model, theta_l.cos(), n_dot_v)[term].map(|cos| (cos > 1.0, cos < -1.0));
        // Crowded towards the horizon.
        let at = |i: usize| FRAC_PI_2 * (1.0 - ((128.0 - i as f64) / 128.5).powi(4));
        for i in 0..128 {
            let (mut low, mut high) = (at(i), at(i + 1));
            if side(low) != side(high) {
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if side(middle) == side(low) { low = middle } else { high = middle }
                }
                found.push(0.5 * (low + high));
            }
        }
    }
    found
}
