// SPDX-License-Identifier: MIT OR Apache-2.0
//! Smith's projected area by quadrature, for distributions without a closed form.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::{Flat, Lobe};
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};

/// 32 nodes agree with the closed forms of GGX and Beckmann to 1e-12 of the lobe's mean slope.
static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| gauss_legendre(32));

/// n·x Λ(x), the part of the projected area that facets beyond the horizon of x would take away: Smith's integral
/// ∫ max(0, x·h) D(h) dh − n·x (Smith 1967; Heitz 2014, Eq. 24).
///
/// For a polar angle with t = tan θ the azimuth integrates in closed form. With z = cot θ_x and h = √(t² − z²), only
/// t > z adds, (sin θ_x/π) ∫ W [h − z atan2(h, z)] dy with W dy = 2π D cos θ sin θ dθ. In y the integrand starts like
/// (y − y(z))^(3/2), which the squared node map removes.
pub fn smith_excess(n_dot_x: f64, flat: &Flat, lobe: &Lobe) -> f64 {
    let sin = ((1.0 - n_dot_x) * (1.0 + n_dot_x)).sqrt();
    if sin == 0.0 {
        return 0.0;
    }
    let z = n_dot_x / sin;
    // Rising: from y(z) to the end of the tail. Falling: from y(z) down to 0, the horizon.
    let end = if flat.falling { 0.0 } else { flat.y_max + 1.5 };
    let start = if z > 0.0 {
        (flat.y)(z, lobe)
    } else if flat.falling {
        flat.y_max
    } else {
        0.0
    };
    if !flat.falling && start >= end {
        return 0.0;
    }
    let start = start.min(flat.y_max + 1.5);
    let mut sum = 0.0;
    for node in RULE.iter() {
        let x = 0.5 * (1.0 + node.x);
        let y = start + (end - start) * x * x;
        let t = (flat.tan)(y, lobe);
        let h = ((t - z).max(0.0) * (t + z)).sqrt();
        let density = (flat.density)(y, t, lobe);
        sum += node.weight * x * density * (h - z * h.atan2(z));
    }
    sum * (end - start).abs() * sin / PI
}
