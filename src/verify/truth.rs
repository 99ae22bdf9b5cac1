//! The truth about directional albedos: adaptive f64 integration over *light directions*.
//!
//! Independent of every rule that bakes: rules integrate over half vectors in the space where the lobe is flat; this
//! integrates the reflectance equation as it is written, E = ∫ D G/(4 (n·l)(n·v)) (n·l) dω_l, in the polar angle of l
//! measured from the mirror direction and the azimuth. It shares no node, no Jacobian and no change of variables with
//! them, only D and G themselves (which the laws and the published tables check).

use std::f64::consts::{FRAC_PI_2, PI};

use crate::ndf::Ndf;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::term::visibility::{Directions, Visibility};

/// More panels than any smooth lobe needs; a kinked one ends here with a larger, honest error.
const MAX_PANELS: usize = 400;

/// Directional albedo with F = 1 and its part weighted by (1 − v·h)⁵, as (E, B), to about `tolerance`.
///
/// Domain: n_dot_v in [0, 1], alpha in (0, 1]; alpha = 0 returns the mirror's closed form.
pub fn albedo(ndf: &Ndf, visibility: &Visibility, n_dot_v: f64, alpha: f64, tolerance: f64) -> Estimate<2> {
    let mu = n_dot_v;
    if alpha == 0.0 {
        return Estimate { value: [1.0, (1.0 - mu).powi(5)], error: 0.0 };
    }
    let sv = ((1.0 - mu) * (1.0 + mu)).sqrt();
    let theta_v = sv.atan2(mu);
    let sigma_v = (ndf.sigma)(mu, alpha);

    // Offsets from the mirror direction, stretched by sinh so that peak and tails get panels of like width.
    let peak = 2.0 * alpha;
    let warp = |offset: f64| (offset / peak).asinh();
    let panels = |from: f64, to: f64, width: f64| -> Vec<f64> {
        let n = ((to - from) / width).ceil().max(1.0);
        (0..=n as usize).map(|i| from + (to - from) * i as f64 / n).collect()
    };
    let mut breaks = panels(warp(-theta_v), 0.0, 6.0);
    breaks.extend(panels(0.0, warp(FRAC_PI_2 - theta_v), 6.0).into_iter().skip(1));
    let span = breaks[breaks.len() - 1] - breaks[0];

    integrate(&breaks, 0.5 * tolerance, MAX_PANELS, |y| {
        let offset = peak * y.sinh();
        let theta_l = theta_v + offset;
        let (sin_l, n_dot_l) = (theta_l.sin(), theta_l.cos().max(0.0));
        let sigma_l = (ndf.sigma)(n_dot_l, alpha);
        // l + v, its in-plane part by differences so that nothing cancels near the mirror direction.
        let hz = n_dot_l + mu;
        let hx_mirror = -2.0 * (theta_v + 0.5 * offset).cos() * (0.5 * offset).sin();
        let narrow = ((alpha * hz).hypot(hx_mirror) / sin_l).clamp(1e-30, PI);
        let end = (PI / narrow).asinh();
        let scale = peak * y.cosh();
        let inner = integrate(&panels(0.0, end, 8.0), 0.2 * tolerance / (span * scale), MAX_PANELS, |x| {
            let phi = narrow * x.sinh();
            let half = (0.5 * phi).sin();
            let hx = hx_mirror + 2.0 * sin_l * half * half;
            let hy = sin_l * phi.sin();
            let flat2 = hx * hx + hy * hy;
            let length2 = flat2 + hz * hz;
            let d = (ndf.d)(hz * hz / length2, flat2 / length2, alpha);
            let v_dot_h = 0.5 * length2.sqrt();
            let g = (visibility.g_over_n_dot_v)(&Directions { n_dot_l, n_dot_v: mu, sigma_l, sigma_v });
            // Both halves of the azimuth; the factor 1/4 of the BRDF; Jacobians of angle and stretch.
            let f = 0.5 * d * g * sin_l * narrow * x.cosh();
            Estimate { value: [f, f * (1.0 - v_dot_h).max(0.0).powi(5)], error: 0.0 }
        });
        Estimate { value: inner.value.map(|v| v * scale), error: inner.error * scale }
    })
}
