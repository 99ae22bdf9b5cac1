// SPDX-License-Identifier: MIT OR Apache-2.0
//! Directional albedos of rough diffuse BRDFs of albedo 1, to check shaders' own against: Oren and Nayar's, both forms, and
//! the Fujii model that EON builds on. Roughness is the standard deviation of the slopes' angle in radians for the former,
//! the model's own parameter for the latter.
//!
//! All are polynomials in the cosine of the azimuth on either side of a right angle, so that its integral is a closed form;
//! the polar angle of l is integrated on either side of that of v, where they are not smooth.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

use super::At;
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};

/// A rough diffuse BRDF.
pub struct Diffuse {
    /// The directional albedo from the cosine of v and the roughness.
    pub rule: fn(n_dot_v: f64, roughness: f64) -> f64,
    /// π times the BRDF from the cosines of l and v, the cosine of the azimuth between them, and the roughness.
    pub brdf: fn(n_dot_l: f64, n_dot_v: f64, cos_azimuth: f64, roughness: f64) -> f64,
    /// The rule in words.
    pub rule_name: &'static str,
}

/// Oren and Nayar's simple form. Oren, Nayar 1994, Generalization of Lambert's Reflectance Model, Eq. 30.
pub static OREN_NAYAR: Diffuse = Diffuse { rule: oren_nayar, brdf: oren_nayar_brdf, rule_name: "closed form" };

/// Their full form, the second bounce between facets included. Oren, Nayar 1994, Eq. 27 to 29.
pub static OREN_NAYAR_FULL: Diffuse =
    Diffuse { rule: oren_nayar_full, brdf: oren_nayar_full_brdf, rule_name: "Gauss-Legendre, 2x32 nodes" };

/// Fujii's form, single scattering of EON. Portsmouth, Kutz, Hill 2025, EON: A Practical Energy-Preserving Rough Diffuse BRDF,
/// Eq. 4 and 14.
pub static FUJII: Diffuse = Diffuse { rule: fujii, brdf: fujii_brdf, rule_name: "closed form" };

static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| gauss_legendre(32));

/// ∫₀^{π/2} sin(max) tan(min) cos θ sin θ dθ with max and min of θ and the angle of v, times 2: what the term in the cosine of
/// the azimuth leaves. ½ S (θ − S C) + ⅓ (S/C)(1 − S³), where 1 − S³ = C² (1 + S + S²)/(1 + S) takes the division away.
fn swing(n_dot_v: f64) -> f64 {
    let (c, s) = (n_dot_v, ((1.0 - n_dot_v) * (1.0 + n_dot_v)).sqrt());
    let theta = s.atan2(c);
    s * (theta - s * c) + 2.0 / 3.0 * s * c * (1.0 + s + s * s) / (1.0 + s)
}

/// The coefficients A and B of the simple form.
fn coefficients(sigma: f64) -> [f64; 2] {
    let s2 = sigma * sigma;
    [1.0 - 0.5 * s2 / (s2 + 0.33), 0.45 * s2 / (s2 + 0.09)]
}

fn oren_nayar(n_dot_v: f64, sigma: f64) -> f64 {
    let [a, b] = coefficients(sigma);
    a + b / PI * swing(n_dot_v)
}

fn oren_nayar_brdf(n_dot_l: f64, n_dot_v: f64, cos_azimuth: f64, sigma: f64) -> f64 {
    let [a, b] = coefficients(sigma);
    let (alpha, beta) = angles(n_dot_l, n_dot_v);
    a + b * cos_azimuth.max(0.0) * alpha.sin() * beta.tan()
}

/// The larger and the smaller of both polar angles.
fn angles(n_dot_l: f64, n_dot_v: f64) -> (f64, f64) {
    let (l, v) = (n_dot_l.min(1.0).acos(), n_dot_v.min(1.0).acos());
    (l.max(v), l.min(v))
}

fn oren_nayar_full(n_dot_v: f64, sigma: f64) -> f64 {
    let s2 = sigma * sigma;
    let theta_v = n_dot_v.min(1.0).acos();
    let (c1, c2, c3) = (1.0 - 0.5 * s2 / (s2 + 0.33), 0.45 * s2 / (s2 + 0.09), 0.125 * s2 / (s2 + 0.09));
    let mut sum = c1 + 0.17 * s2 / (s2 + 0.13);
    for [from, to] in [[0.0, theta_v], [theta_v, FRAC_PI_2]] {
        for node in RULE.iter() {
            let theta = from + (to - from) * 0.5 * (1.0 + node.x);
            let (alpha, beta) = (theta.max(theta_v), theta.min(theta_v));
            // Over a turn of the azimuth: the cosine's positive half is 2, its negative one −2, and 1 less its size 2π − 4.
            let (cubed, squared) = ((2.0 * beta / PI).powi(3), (4.0 * alpha * beta / (PI * PI)).powi(2));
            let ring = 2.0 * c2 * cubed * beta.tan() + (2.0 * PI - 4.0) * c3 * squared * (0.5 * (alpha + beta)).tan();
            sum += 0.5 * node.weight * (to - from) * ring * theta.sin() * theta.cos() / PI;
        }
    }
    sum
}

fn oren_nayar_full_brdf(n_dot_l: f64, n_dot_v: f64, cos_azimuth: f64, sigma: f64) -> f64 {
    let s2 = sigma * sigma;
    let (alpha, beta) = angles(n_dot_l, n_dot_v);
    let c1 = 1.0 - 0.5 * s2 / (s2 + 0.33);
    let back = if cos_azimuth < 0.0 { (2.0 * beta / PI).powi(3) } else { 0.0 };
    let c2 = 0.45 * s2 / (s2 + 0.09) * (alpha.sin() - back);
    let c3 = 0.125 * s2 / (s2 + 0.09) * (4.0 * alpha * beta / (PI * PI)).powi(2);
    let first = c1 + cos_azimuth * c2 * beta.tan() + (1.0 - cos_azimuth.abs()) * c3 * (0.5 * (alpha + beta)).tan();
    let second = 0.17 * s2 / (s2 + 0.13) * (1.0 - cos_azimuth * (2.0 * beta / PI).powi(2));
    first + second
}

/// 1/(1 + (½ − 2/(3π)) r).
fn fujii_scale(roughness: f64) -> f64 {
    1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness)
}

fn fujii(n_dot_v: f64, roughness: f64) -> f64 {
    // Where s = l·v − (n·l)(n·v) is negative it is not divided: ⅔ S less.
    let s = ((1.0 - n_dot_v) * (1.0 + n_dot_v)).sqrt();
    fujii_scale(roughness) * (1.0 + roughness / PI * (swing(n_dot_v) - 2.0 / 3.0 * s))
}

fn fujii_brdf(n_dot_l: f64, n_dot_v: f64, cos_azimuth: f64, roughness: f64) -> f64 {
    let sine = |c: f64| ((1.0 - c) * (1.0 + c)).max(0.0).sqrt();
    let s = sine(n_dot_l) * sine(n_dot_v) * cos_azimuth;
    let t = if s > 0.0 { n_dot_l.max(n_dot_v) } else { 1.0 };
    fujii_scale(roughness) * (1.0 + roughness * s / t)
}

impl Diffuse {
    /// The albedo by adaptive integration of the BRDF as it is written, over azimuth and polar angle.
    pub fn truth(&self, at: At, tolerance: f64) -> Estimate<1> {
        let theta_v = at.n_dot_v.min(1.0).acos();
        let ring = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            let inner = integrate(&[0.0, FRAC_PI_2, PI], 0.1 * tolerance, 1 << 10, |azimuth| Estimate {
                value: [2.0 / PI * (self.brdf)(cos, at.n_dot_v, azimuth.cos(), at.roughness)],
                error: 0.0,
            });
            Estimate { value: [inner.value[0] * sin * cos], error: inner.error * sin * cos }
        };
        integrate(&[0.0, theta_v, FRAC_PI_2], 0.5 * tolerance, 1 << 10, ring)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [(&str, &Diffuse); 3] =
        [("oren-nayar", &OREN_NAYAR), ("oren-nayar-full", &OREN_NAYAR_FULL), ("fujii", &FUJII)];

    #[test]
    fn albedos_are_their_truths() {
        for (name, diffuse) in ALL {
            let mut worst = 0.0f64;
            for n_dot_v in [0.0, 0.02, 0.4, 0.8, 1.0] {
                for roughness in [0.0, 0.3, 1.0] {
                    let at = At { n_dot_v, roughness };
                    let truth = diffuse.truth(at, 1e-9);
                    let error = ((diffuse.rule)(n_dot_v, roughness) - truth.value[0]).abs();
                    worst = worst.max(error);
                    assert!(error <= 1e-8 + truth.error, "{name} {at:?}: off by {error:.1e}");
                }
            }
            println!("{name}: worst {worst:.1e}");
        }
    }

    #[test]
    fn smooth_ones_are_lambert() {
        for (name, diffuse) in ALL {
            assert!(((diffuse.rule)(0.37, 0.0) - 1.0).abs() < 1e-15, "{name}");
        }
    }

    #[test]
    fn fit_that_shaders_use_is_near_the_albedo() {
        // Portsmouth, Kutz, Hill 2025, Eq. 16: stated to 1e-3.
        let fit = |mu: f64, r: f64| {
            let m = 1.0 - mu;
            let g = m * (0.057_108_528_9 + m * (0.491_881_867 + m * (-0.332_181_442 + m * 0.071_442_995_3)));
            fujii_scale(r) * (1.0 + r * g)
        };
        let mut worst = 0.0f64;
        for i in 0..=100 {
            let mu = f64::from(i) / 100.0;
            worst = worst.max((fit(mu, 1.0) - fujii(mu, 1.0)).abs());
        }
        println!("EON's fitted albedo: off by up to {worst:.1e}");
        assert!(worst < 1.5e-3 && worst > 1e-5, "{worst:e}");
    }
}
