// SPDX-License-Identifier: MIT OR Apache-2.0
//! The truth about the albedo of a layer of fibres ([`crate::rule::fibre_layer`]): adaptive f64 integration over light
//! directions by polar angle and azimuth, nothing substituted.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::bake::At;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::rule::fibre_layer::FibreLayer;

/// More panels than a smooth lobe takes.
const MAX_PANELS: usize = 300;

/// ∫ f (n·l) dω_l to about `tolerance`. Domain: n_dot_v in (0, 1], roughness in (0, 1].
pub fn albedo(at: At, tolerance: f64) -> Estimate<1> {
    let layer = FibreLayer::new(at);
    let mu = at.n_dot_v;
    let sin_v = ((1.0 - mu) * (1.0 + mu)).sqrt();
    // Light leaves mostly near the horizon.
    let breaks = [0.0, 0.5, 0.9, 0.97, 0.99, 0.999, 1.0].map(|share| share * FRAC_PI_2);
    integrate(&breaks, 0.5 * tolerance, MAX_PANELS, |theta_l| {
        let (sin_l, n_dot_l) = theta_l.sin_cos();
        let inner = integrate(&[0.0, 0.05, FRAC_PI_2, PI - 0.05, PI], 0.1 * tolerance, MAX_PANELS, |phi| {
            let (y, x) = phi.sin_cos();
            let h = [sin_l * x + sin_v, sin_l * y, n_dot_l.max(0.0) + mu];
            let length = h.iter().map(|c| c * c).sum::<f64>().sqrt();
            let f = layer.reflected(h[0].hypot(h[1]) / length, h[2] / length, n_dot_l.max(1e-300));
            // Both halves of the azimuth.
            Estimate { value: [2.0 * sin_l * f], error: 0.0 }
        });
        Estimate { value: inner.value, error: inner.error }
    })
}
