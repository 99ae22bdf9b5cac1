// SPDX-License-Identifier: MIT OR Apache-2.0
//! The truth about a fitted lobe: how far a linearly transformed cosine is from the lobe of a BRDF, by adaptive f64
//! integration over *light directions*.
//!
//! The coordinates are those of [`super::truth`]: the polar angle of l from the mirror direction and the azimuth, both
//! stretched where the lobe is narrow, over the whole sphere: a fitted lobe may reach below the horizon. It shares no node
//! and no change of variables with the fit ([`crate::rule::ltc`]), only D, G and the cosine's density.

use std::f64::consts::{FRAC_PI_2, PI};

use super::truth;
use crate::bake::{At, Model};
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::rule::ltc::Inverse;
use crate::term::visibility::Directions;

/// More panels than a lobe takes; where it takes more, its error is larger than it should be.
const MAX_PANELS: usize = 300;

/// The cube root of ∫ |f (n·l) − E D|³ dω over ∫ (f (n·l))³ dω, to about `tolerance`; E is the true albedo.
///
/// Domain: n_dot_v in (0, 1], roughness in [0, 1]; 0 for a mirror.
pub fn fit_error(model: &Model, at: At, inverse: &Inverse, tolerance: f64) -> Estimate<1> {
    let Some(lobe) = model.ndf.lobe(at.roughness) else { return Estimate { value: [0.0], error: 0.0 } };
    let albedo = truth::albedo(model, at.n_dot_v, at.roughness, 1e-7).value[0];
    let area = |x: f64| if model.visibility.smith { model.ndf.sigma(x, &lobe) } else { x };
    let sigma_v = area(at.n_dot_v);
    // The lobe and what fits it, from l and from l + v, whose part in the plane of incidence comes without cancellation.
    let cubes = |l: [f64; 3], h: [f64; 3]| {
        let fitted = albedo * inverse.density(l);
        if l[2] <= 0.0 {
            return [fitted.powi(3), 0.0];
        }
        let (flat2, z2) = (h[0] * h[0] + h[1] * h[1], h[2] * h[2]);
        let (length2, n_dot_l) = (flat2 + z2, l[2]);
        let directions = Directions {
            n_dot_l,
            n_dot_v: at.n_dot_v,
            n_dot_h: h[2] / length2.sqrt(),
            v_dot_h: 0.5 * length2.sqrt(),
            sigma_l: area(n_dot_l),
            sigma_v,
            alpha: lobe.alpha,
        };
        let d = model.ndf.d(z2 / length2, flat2 / length2, &lobe);
        let f = 0.25 * d * (model.visibility.g_over_n_dot_v)(&directions);
        [(f - fitted).abs().powi(3), f.powi(3)]
    };
    let once = |tolerance: f64| over_sphere(at.n_dot_v, lobe.peak, tolerance, cubes);

    // The cubes have any size: a first look scales the second, whose result says how well a root is known.
    let mut asked = 1e-3 * once(f64::INFINITY).value[1];
    loop {
        let [cubed, norm] = once(asked).value;
        let error = (cubed / norm).cbrt();
        let enough = norm * (3.0 * error * error * tolerance).max(tolerance.powi(3));
        if asked <= enough {
            return Estimate { value: [error], error: tolerance };
        }
        asked = 0.5 * enough;
    }
}

/// ∫ g(l, l + v) dω_l over the sphere, g being even in y, to an absolute tolerance. `peak` is the angular size of what is
/// near the mirror direction.
fn over_sphere(n_dot_v: f64, peak: f64, tolerance: f64, g: impl Fn([f64; 3], [f64; 3]) -> [f64; 2]) -> Estimate<2> {
    let mu = n_dot_v;
    let sin_v = ((1.0 - mu) * (1.0 + mu)).sqrt();
    let theta_v = sin_v.atan2(mu);
    let peak = 2.0 * peak;
    let warp = |offset: f64| (offset / peak).asinh();
    let unwarp = |y: f64| peak * y.sinh();
    let mut breaks: Vec<f64> =
        [0.0, theta_v, 0.5 * (theta_v + FRAC_PI_2), FRAC_PI_2, PI].map(|theta| warp(theta - theta_v)).to_vec();
    let mut height = FRAC_PI_2 / 8.0;
    while height > 0.3 * mu.max(1e-4) {
        breaks.extend([FRAC_PI_2 - height, FRAC_PI_2 + height].map(|theta| warp(theta - theta_v)));
        height *= 0.2;
    }
    breaks.sort_by(f64::total_cmp);
    let span = breaks[breaks.len() - 1] - breaks[0];
    integrate(&breaks, 0.5 * tolerance, MAX_PANELS, |y| {
        let offset = unwarp(y);
        let theta_l = theta_v + offset;
        let (sin_l, n_dot_l) = theta_l.sin_cos();
        let hz = n_dot_l + mu;
        let hx_mirror = -2.0 * (theta_v + 0.5 * offset).cos() * (0.5 * offset).sin();
        let narrow = ((0.5 * peak * hz.abs()).hypot(hx_mirror) / sin_l).clamp(1e-30, PI);
        let end = (PI / narrow).asinh();
        let scale = peak * y.cosh();
        let panels = (end / 8.0).ceil();
        let inner_breaks: Vec<f64> = (0..=panels as usize).map(|i| end * i as f64 / panels).collect();
        let inner = integrate(&inner_breaks, 0.2 * tolerance / (span * scale), MAX_PANELS, |x| {
            let phi = narrow * x.sinh();
            let half = (0.5 * phi).sin();
            let hx = hx_mirror + 2.0 * sin_l * half * half;
            let hy = sin_l * phi.sin();
            // Both halves of the azimuth; Jacobians of angle and stretch.
            let solid_angle = 2.0 * sin_l * narrow * x.cosh();
            Estimate { value: g([hx - sin_v, hy, n_dot_l], [hx, hy, hz]).map(|v| v * solid_angle), error: 0.0 }
        });
        Estimate { value: inner.value.map(|v| v * scale), error: inner.error * scale }
    })
}
