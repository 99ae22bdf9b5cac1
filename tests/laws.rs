//! Laws that hold whatever the implementation: normalisation, closed forms, reciprocity, energy.

use brdf_baker::bake::{At, Model, TABLES, table};
use brdf_baker::ndf::{NDFS, alpha_of};
use brdf_baker::quadrature::gauss_legendre::gauss_legendre;
use brdf_baker::rule::cone::cone;
use brdf_baker::term::visibility::{Directions, VISIBILITIES, smith, smith_uncorrelated};

const LN2: f64 = std::f64::consts::LN_2;

fn close(found: f64, expected: f64, bound: f64) {
    assert!((found - expected).abs() <= bound, "{found} instead of {expected}, bound {bound:e}");
}

/// ∫ f(cos², sin²) dω over the hemisphere, in t = ln tan θ: a lobe of any width is smooth there.
fn hemisphere(f: impl Fn(f64, f64) -> f64) -> f64 {
    let rule = gauss_legendre(400);
    let (from, to) = (-25.0, 25.0);
    let node = |n: &brdf_baker::quadrature::gauss_legendre::Node| {
        let tan = (0.5 * (from + to) + 0.5 * (to - from) * n.x).exp();
        let cos2 = 1.0 / (1.0 + tan * tan);
        let sin2 = tan * tan * cos2;
        // dω = 2π sin θ dθ, dθ = sin θ cos θ dt
        n.weight * 0.5 * (to - from) * 2.0 * std::f64::consts::PI * sin2 * cos2.sqrt() * f(cos2, sin2)
    };
    rule.iter().map(node).sum()
}

#[test]
fn distributions_are_normalised() {
    assert!(!NDFS.is_empty());
    for ndf in NDFS {
        for alpha in [1e-3, 0.01, 0.1, 0.3, 0.7, 1.0] {
            close(hemisphere(|c2, s2| (ndf.d)(c2, s2, alpha) * c2.sqrt()), 1.0, 1e-6);
        }
    }
}

#[test]
fn ggx_equals_the_textbook_form() {
    // Walter et al. 2007, Eq. 33, unchanged.
    let alpha: f64 = 0.3;
    for cos in [0.1f64, 0.5, 0.9, 1.0] {
        let tan2 = (1.0 - cos * cos) / (cos * cos);
        let textbook =
            alpha * alpha / (std::f64::consts::PI * cos.powi(4) * (alpha * alpha + tan2) * (alpha * alpha + tan2));
        close((NDFS[0].d)(cos * cos, 1.0 - cos * cos, alpha), textbook, 1e-12);
    }
}

#[test]
fn projected_area_is_the_visible_part_of_the_distribution() {
    // Smith: n·v (1 + Λ) = ∫ max(0, v·h) D(h) dh; by brute force over the hemisphere of h.
    let (polar, azimuth) = (gauss_legendre(300), gauss_legendre(300));
    for ndf in NDFS {
        for (n_dot_v, alpha) in [(0.8f64, 0.5), (0.2, 0.5), (0.05, 0.9), (0.5, 0.2)] {
            let sin_v = (1.0 - n_dot_v * n_dot_v).sqrt();
            let mut sum = 0.0;
            for p in &polar {
                let theta: f64 = std::f64::consts::FRAC_PI_4 * (1.0 + p.x);
                let (sin, cos) = theta.sin_cos();
                let d = (ndf.d)(cos * cos, sin * sin, alpha);
                for a in &azimuth {
                    let phi = std::f64::consts::FRAC_PI_2 * (1.0 + a.x);
                    let v_dot_h = (sin_v * sin * phi.cos() + n_dot_v * cos).max(0.0);
                    let weight = p.weight * std::f64::consts::FRAC_PI_4 * a.weight * std::f64::consts::PI;
                    sum += weight * d * v_dot_h * sin;
                }
            }
            close(sum, (ndf.sigma)(n_dot_v, alpha), 2e-4);
        }
    }
}

#[test]
fn geometry_terms_are_reciprocal_and_at_most_one() {
    for v in VISIBILITIES {
        for (l, n) in [(0.1, 0.9), (0.5, 0.3), (1.0, 0.02), (0.7, 0.7)] {
            let sigma = NDFS[0].sigma;
            let g = |l: f64, v_: f64| {
                let d = Directions { n_dot_l: l, n_dot_v: v_, sigma_l: sigma(l, 0.4), sigma_v: sigma(v_, 0.4) };
                (v.g_over_n_dot_v)(&d) * v_
            };
            close(g(l, n), g(n, l), 1e-15);
            assert!(g(l, n) > 0.0 && g(l, n) <= 1.0);
        }
    }
}

#[test]
fn correlated_smith_equals_its_textbook_form() {
    // Heitz 2014, Eq. 99 with Λ from Eq. 72.
    let alpha = 0.35;
    let lambda = |x: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 - x * x) / (x * x)).sqrt() - 1.0);
    for (l, v) in [(0.1, 0.9), (0.5, 0.3), (1.0, 0.02f64)] {
        let sigma = NDFS[0].sigma;
        let g = smith::g_over_n_dot_v(l, v, sigma(l, alpha), sigma(v, alpha)) * v;
        close(g, 1.0 / (1.0 + lambda(l) + lambda(v)), 1e-14);
        let separable = smith_uncorrelated::g_over_n_dot_v(l, v, sigma(l, alpha), sigma(v, alpha)) * v;
        close(separable, 1.0 / ((1.0 + lambda(l)) * (1.0 + lambda(v))), 1e-14);
    }
}

#[test]
fn albedo_has_its_closed_forms_at_alpha_one() {
    for mu in [1e-3, 0.01, 0.1, 0.5, 0.9, 1.0f64] {
        close(cone(mu, 1.0, smith::g_over_n_dot_v)[0], 1.0 - mu * (1.0 / mu).ln_1p(), 1e-6);
        close(cone(mu, 1.0, smith_uncorrelated::g_over_n_dot_v)[0], 2.0 * (1.0 - LN2) / (1.0 + mu), 1e-6);
    }
    close(cone(1.0, 1.0, smith::g_over_n_dot_v)[0], 1.0 - LN2, 1e-7);
}

#[test]
fn average_albedo_has_its_closed_form_at_roughness_one() {
    let average = table("average-albedo").unwrap();
    let found = average.rule(&Model::parse("ggx", "smith").unwrap(), At { n_dot_v: 1.0, roughness: 1.0 })[0];
    close(found, 4.0 / 3.0 * (1.0 - LN2), 2e-7);
}

#[test]
fn both_smith_terms_agree_at_normal_incidence() {
    for roughness in [0.1, 0.4, 0.8, 1.0] {
        let alpha = alpha_of(roughness);
        let (a, b) = (cone(1.0, alpha, smith::g_over_n_dot_v), cone(1.0, alpha, smith_uncorrelated::g_over_n_dot_v));
        close(a[0], b[0], 1e-6);
        close(a[1], b[1], 1e-6);
    }
}

#[test]
fn mirror_limit_is_reached_continuously() {
    for mu in [0.0, 0.1, 0.5, 1.0f64] {
        let (limit, near) = (cone(mu, 0.0, smith::g_over_n_dot_v), cone(mu, 1e-8, smith::g_over_n_dot_v));
        close(limit[0], 1.0, 0.0);
        close(limit[1], (1.0 - mu).powi(5), 1e-15);
        close(near[0], limit[0], 1e-6);
        close(near[1], limit[1], 1e-6);
    }
}

#[test]
fn grazing_limit_is_reached_continuously() {
    for roughness in [0.1, 0.5, 1.0] {
        let alpha = alpha_of(roughness);
        let (limit, near) = (cone(0.0, alpha, smith::g_over_n_dot_v), cone(1e-9, alpha, smith::g_over_n_dot_v));
        close(limit[0], 1.0, 1e-6);
        close(near[0], limit[0], 3e-6);
        close(near[1], limit[1], 3e-6);
    }
}

#[test]
fn energy_is_conserved_and_split_into_scale_and_bias() {
    let split_sum = table("split-sum").unwrap();
    for visibility in VISIBILITIES {
        let model = Model::parse("ggx", visibility.name).unwrap();
        for i in 0..=32 {
            for j in 0..=32 {
                let at = At { n_dot_v: f64::from(i) / 32.0, roughness: f64::from(j) / 32.0 };
                let [scale, bias, albedo] = split_sum.rule(&model, at);
                assert!(scale >= -1e-6 && bias >= 0.0 && albedo <= 1.0 + 1e-6, "{at:?}: {scale} {bias} {albedo}");
                close(scale + bias, albedo, 1e-15);
            }
        }
    }
}

#[test]
fn every_table_states_its_source_and_bounds() {
    for table in TABLES {
        let facts = table.facts();
        assert!(!facts.source.is_empty() && !facts.usage.is_empty() && !facts.tolerance.why.is_empty());
        assert!(facts.tolerance.worst <= 1e-6 && facts.tolerance.median < facts.tolerance.worst);
    }
}
