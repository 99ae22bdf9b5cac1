// SPDX-License-Identifier: MIT OR Apache-2.0
//! Laws that hold whatever the implementation: normalisation, closed forms, reciprocity, energy.

use brdf_baker::axis::Points;
use brdf_baker::bake::{At, Model, TABLES, TableRequest, table};
use brdf_baker::ndf::{self, alpha_of, ggx};
use brdf_baker::quadrature::gauss_legendre::gauss_legendre;
use brdf_baker::rule::cone::cone;
use brdf_baker::term::fresnel::Fresnel;
use brdf_baker::term::visibility::{self, Directions, VISIBILITIES, smith, smith_uncorrelated};

mod common;
use common::{ELLIPTIC, FRESNELS, NDFS};

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

/// √alpha: the roughness of a width.
fn roughness_of(alpha: f64) -> f64 {
    alpha.sqrt()
}

#[test]
fn every_family_has_a_tested_member() {
    for family in ndf::NDFS {
        assert!(NDFS.iter().any(|text| text.split(':').next() == Some(family.name)), "{}", family.name);
    }
}

#[test]
fn distributions_are_normalised() {
    for text in NDFS {
        let ndf = ndf::parse(text).unwrap();
        for alpha in [1e-3, 0.01, 0.1, 0.3, 0.7, 1.0] {
            let lobe = ndf.lobe(roughness_of(alpha)).unwrap();
            let found = hemisphere(|c2, s2| ndf.d(c2, s2, &lobe) * c2.sqrt());
            assert!((found - 1.0).abs() <= 1e-6, "{text}, alpha {alpha}: {found}");
        }
    }
}

#[test]
fn flat_coordinates_carry_the_distribution() {
    // density dy = 2π D cos θ sin θ dθ, the right side by differences of tan θ(y).
    for text in NDFS {
        let ndf = ndf::parse(text).unwrap();
        let flat = &ndf.family.flat;
        for alpha in [0.003, 0.2, 0.8, 1.0] {
            let lobe = ndf.lobe(roughness_of(alpha)).unwrap();
            for y in [0.05, 0.6, 1.3, 2.5] {
                let step = 1e-5 * y;
                let theta = |y: f64| (flat.tan)(y, &lobe).atan();
                let slope = ((theta(y + step) - theta(y - step)) / (2.0 * step)).abs();
                let tan = (flat.tan)(y, &lobe);
                let cos2 = 1.0 / (1.0 + tan * tan);
                let sin2 = tan * tan * cos2;
                let right = 2.0 * std::f64::consts::PI * ndf.d(cos2, sin2, &lobe) * (cos2 * sin2).sqrt() * slope;
                let left = (flat.density)(y, tan, &lobe);
                assert!((left / right - 1.0).abs() < 1e-5, "{text}, alpha {alpha}, y {y}: {left} and {right}");
            }
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
        close(ggx::d(cos * cos, 1.0 - cos * cos, alpha), textbook, 1e-12);
    }
}

#[test]
fn projected_area_is_the_visible_part_of_the_distribution() {
    // Smith: n·v (1 + Λ) = ∫ max(0, v·h) D(h) dh; by brute force over the hemisphere of h.
    let (polar, azimuth) = (gauss_legendre(300), gauss_legendre(300));
    for text in NDFS {
        let ndf = ndf::parse(text).unwrap();
        for (n_dot_v, alpha) in [(0.8f64, 0.5), (0.2, 0.5), (0.05, 0.9), (0.5, 0.2)] {
            let lobe = ndf.lobe(roughness_of(alpha)).unwrap();
            let sin_v = (1.0 - n_dot_v * n_dot_v).sqrt();
            let mut sum = 0.0;
            for p in &polar {
                let theta: f64 = std::f64::consts::FRAC_PI_4 * (1.0 + p.x);
                let (sin, cos) = theta.sin_cos();
                let d = ndf.d(cos * cos, sin * sin, &lobe);
                for a in &azimuth {
                    let phi = std::f64::consts::FRAC_PI_2 * (1.0 + a.x);
                    let v_dot_h = (sin_v * sin * phi.cos() + n_dot_v * cos).max(0.0);
                    let weight = p.weight * std::f64::consts::FRAC_PI_4 * a.weight * std::f64::consts::PI;
                    sum += weight * d * v_dot_h * sin;
                }
            }
            close(sum, ndf.sigma(n_dot_v, &lobe), 2e-4);
        }
    }
}

/// The directions of a pair of cosines, seen over GGX.
fn directions(n_dot_l: f64, n_dot_v: f64, alpha: f64) -> Directions {
    let sigma = |x| ggx::sigma(x, alpha);
    // l and v in one plane with the normal, on its two sides.
    let v_dot_h = (0.5 * (n_dot_l.acos() + n_dot_v.acos())).cos();
    let n_dot_h = (0.5 * (n_dot_l.acos() - n_dot_v.acos())).cos();
    Directions { n_dot_l, n_dot_v, n_dot_h, v_dot_h, sigma_l: sigma(n_dot_l), sigma_v: sigma(n_dot_v), alpha }
}

#[test]
fn geometry_terms_are_reciprocal_and_at_most_one() {
    for v in VISIBILITIES {
        for (l, n) in [(0.1, 0.9), (0.5, 0.3), (1.0, 0.02), (0.7, 0.7)] {
            let g = |l: f64, v_: f64| (v.g_over_n_dot_v)(&directions(l, v_, 0.4)) * v_;
            close(g(l, n), g(n, l), 1e-15);
            assert!(g(l, n) > 0.0 && (g(l, n) <= 1.0 || v.name == "kelemen"), "{}: {}", v.name, g(l, n));
        }
    }
}

#[test]
fn geometry_terms_equal_their_textbook_forms() {
    let alpha: f64 = 0.35;
    // Heitz 2014, Eq. 72.
    let lambda = |x: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 - x * x) / (x * x)).sqrt() - 1.0);
    let schlick = |x: f64, k: f64| x / (x * (1.0 - k) + k);
    for (l, v) in [(0.1, 0.9), (0.5, 0.3), (1.0, 0.02f64)] {
        let d = directions(l, v, alpha);
        for (name, textbook) in [
            ("smith", 1.0 / (1.0 + lambda(l) + lambda(v))),
            ("smith-uncorrelated", 1.0 / ((1.0 + lambda(l)) * (1.0 + lambda(v)))),
            (
                "schlick-beckmann",
                [l, v].map(|x| schlick(x, alpha * (2.0 / std::f64::consts::PI).sqrt())).iter().product(),
            ),
            ("schlick-ggx", [l, v].map(|x| schlick(x, alpha / 2.0)).iter().product()),
            ("schlick-direct", [l, v].map(|x| schlick(x, (alpha.sqrt() + 1.0).powi(2) / 8.0)).iter().product()),
            ("cook-torrance", 1f64.min(2.0 * d.n_dot_h * v / d.v_dot_h).min(2.0 * d.n_dot_h * l / d.v_dot_h)),
            ("implicit", l * v),
            ("neumann", l * v / l.max(v)),
            ("kelemen", l * v / (d.v_dot_h * d.v_dot_h)),
            ("neubelt", l * v / (l + v - l * v)),
        ] {
            let found = (visibility::parse(name).unwrap().g_over_n_dot_v)(&d) * v;
            assert!((found - textbook).abs() <= 1e-14, "{name}: {found} instead of {textbook}");
        }
        let rational = (visibility::parse("beckmann-rational").unwrap().g_over_n_dot_v)(&d) * v;
        let beckmann = ndf::parse("beckmann").unwrap();
        let lobe = beckmann.lobe(roughness_of(alpha)).unwrap();
        let exact = l * v / (beckmann.sigma(l, &lobe) * beckmann.sigma(v, &lobe));
        assert!((rational / exact - 1.0).abs() < 0.007, "Walter's fit is within 0.35 % a direction");
    }
    // Both branches of Charlie's fit meet at 1/2.
    let charlie = visibility::charlie::lambda;
    close(charlie(0.5 - 1e-12, 0.3), charlie(0.5, 0.3), 1e-9);
}

#[test]
fn kinks_lie_where_the_terms_have_them() {
    // A term is smooth in the azimuth of h except at its stated cosines: second differences peak there.
    for v in VISIBILITIES {
        let Some(kinks) = &v.kinks else { continue };
        // The two branches of Charlie's fit share their slope: only the curvature jumps.
        if v.name == "charlie" {
            continue;
        }
        let alpha = 0.6;
        for (n_dot_v, tan_h) in [(0.3f64, 0.4f64), (0.3, 0.6), (0.6, 1.3), (0.5, 0.7)] {
            let sin_v = (1.0 - n_dot_v * n_dot_v).sqrt();
            let n_dot_h = 1.0 / (1.0 + tan_h * tan_h).sqrt();
            let g = |x: f64| {
                let v_dot_h = n_dot_h * (n_dot_v + tan_h * sin_v * x);
                let n_dot_l = 2.0 * n_dot_h * v_dot_h - n_dot_v;
                let sigma = |x| ggx::sigma(x, alpha);
                let (sigma_l, sigma_v) = (sigma(n_dot_l), sigma(n_dot_v));
                (v.g_over_n_dot_v)(&Directions { n_dot_l, n_dot_v, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha })
            };
            let lowest = n_dot_v * (tan_h * tan_h - 1.0) / (2.0 * tan_h * sin_v);
            let bend = |x: f64, step: f64| ((g(x + step) - 2.0 * g(x) + g(x - step)) / step).abs();
            for x in (kinks.azimuth)(tan_h, n_dot_v, sin_v, alpha) {
                if x.abs() < 0.98 && x > lowest + 0.02 {
                    // A smooth function's second difference, over the step, halves with it; a kink's stays.
                    assert!(bend(x, 1e-5) > 0.7 * bend(x, 2e-5), "{} has no kink at {x}", v.name);
                }
            }
        }
    }
}

#[test]
fn albedo_has_its_closed_forms_at_alpha_one() {
    for mu in [1e-3, 0.01, 0.1, 0.5, 0.9, 1.0f64] {
        close(cone(mu, 1.0, smith::g_over_n_dot_v, &Fresnel::ONE)[0], 1.0 - mu * (1.0 / mu).ln_1p(), 1e-6);
        close(
            cone(mu, 1.0, smith_uncorrelated::g_over_n_dot_v, &Fresnel::ONE)[0],
            2.0 * (1.0 - LN2) / (1.0 + mu),
            1e-6,
        );
    }
    close(cone(1.0, 1.0, smith::g_over_n_dot_v, &Fresnel::ONE)[0], 1.0 - LN2, 1e-7);
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
        let (a, b) = (
            cone(1.0, alpha, smith::g_over_n_dot_v, &Fresnel::SCHLICK),
            cone(1.0, alpha, smith_uncorrelated::g_over_n_dot_v, &Fresnel::SCHLICK),
        );
        close(a[0], b[0], 1e-6);
        close(a[1], b[1], 1e-6);
    }
}

#[test]
fn mirror_limit_is_reached_continuously() {
    for mu in [0.0, 0.1, 0.5, 1.0f64] {
        let (limit, near) = (
            cone(mu, 0.0, smith::g_over_n_dot_v, &Fresnel::SCHLICK),
            cone(mu, 1e-8, smith::g_over_n_dot_v, &Fresnel::SCHLICK),
        );
        close(limit[0], 1.0, 1e-15);
        close(limit[1], (1.0 - mu).powi(5), 1e-15);
        close(near[0], limit[0], 1e-6);
        close(near[1], limit[1], 1e-6);
    }
}

#[test]
fn grazing_limit_is_reached_continuously() {
    for roughness in [0.1, 0.5, 1.0] {
        let alpha = alpha_of(roughness);
        let (limit, near) = (
            cone(0.0, alpha, smith::g_over_n_dot_v, &Fresnel::SCHLICK),
            cone(1e-9, alpha, smith::g_over_n_dot_v, &Fresnel::SCHLICK),
        );
        close(limit[0], 1.0, 1e-6);
        close(near[0], limit[0], 3e-6);
        close(near[1], limit[1], 3e-6);
    }
}

#[test]
fn energy_is_conserved_and_split_into_scale_and_bias() {
    let split_sum = table("split-sum").unwrap();
    for text in NDFS {
        for visibility in VISIBILITIES {
            let model = Model::parse(text, visibility.name).unwrap();
            if !model.bounded() {
                assert!(model.note().is_some(), "{text} {}: says nothing of its energy", visibility.name);
                continue;
            }
            let slack = model.tolerance(&split_sum.facts().tolerance).worst;
            let n = if text == "ggx" { 32 } else { 8 };
            for i in 0..=n {
                for j in 1..=n {
                    let at = At { n_dot_v: f64::from(i) / f64::from(n), roughness: f64::from(j) / f64::from(n) };
                    let [scale, bias, albedo, f82] = split_sum.rule(&model, at);
                    let tint = f82 >= 0.0 && f82 <= 0.0567 * albedo;
                    let fits = scale >= -slack && bias >= 0.0 && albedo <= 1.0 + slack && tint;
                    assert!(fits, "{text} {} {at:?}: {scale} {bias} {albedo} {f82}", visibility.name);
                    close(scale + bias, albedo, 1e-15);
                }
            }
        }
    }
}

#[test]
fn charlie_with_neubelt_does_not_conserve_energy() {
    // Documented, not a fault of the bake: upright facets are not shadowed by this denominator.
    let model = Model::parse("charlie", "neubelt").unwrap();
    let albedo = |n_dot_v, roughness| model.rule(At { n_dot_v, roughness })[0];
    assert!(albedo(1.0 / 512.0, 0.05) > 5.0, "{}", albedo(1.0 / 512.0, 0.05));
    assert!(albedo(0.5, 1.0) < 1.0);
    assert!(model.note().unwrap().contains("does not conserve energy"));
}

#[test]
fn gtr_with_gamma_two_is_ggx() {
    // Two distributions, two rules, the same table; both Smith's own and a term with kinks.
    for visibility in ["smith", "smith-uncorrelated", "schlick-ggx", "cook-torrance"] {
        let (gtr, ggx) = (Model::parse("gtr:gamma=2", visibility).unwrap(), Model::parse("ggx", visibility).unwrap());
        for n_dot_v in [0.002, 0.1, 0.6, 1.0] {
            for roughness in [0.05, 0.3, 0.7, 1.0] {
                let at = At { n_dot_v, roughness };
                let (a, b) = (gtr.rule(at), ggx.rule(at));
                for c in 0..2 {
                    assert!((a[c] - b[c]).abs() <= 4e-6, "{visibility} {at:?}: {a:?} and {b:?}");
                }
            }
        }
    }
}

#[test]
fn uniform_facets_have_their_closed_forms() {
    // At roughness 1 Blinn–Phong has exponent 0 and GTR is flat for every gamma: D = 1/π.
    for text in ["ggx", "blinn-phong", "gtr:gamma=1", "gtr:gamma=3"] {
        for mu in [0.01, 0.2, 0.7, 1.0f64] {
            let e =
                |visibility: &str| Model::parse(text, visibility).unwrap().rule(At { n_dot_v: mu, roughness: 1.0 })[0];
            close(e("smith"), 1.0 - mu * (1.0 / mu).ln_1p(), 2e-6);
            close(e("smith-uncorrelated"), 2.0 * (1.0 - LN2) / (1.0 + mu), 2e-6);
            close(e("implicit"), 0.25, 2e-6);
            close(e("neumann"), 0.5 * (1.0 - 0.5 * mu), 2e-6);
            let k = 0.5f64;
            let schlick = 0.5 / (mu * (1.0 - k) + k) * (1.0 / (1.0 - k) - k * (1.0 / k).ln() / ((1.0 - k) * (1.0 - k)));
            close(e("schlick-ggx"), schlick, 2e-6);
        }
    }
}

#[test]
fn limits_that_do_not_exist_are_refused() {
    let request = |ndf: &str, visibility: &str| {
        let request = TableRequest {
            ndf: ndf.into(),
            visibility: visibility.into(),
            points: Points::Edges,
            ..TableRequest::new("split-sum")
        };
        request.resolve().err().map(|e| e.to_string())
    };
    assert!(request("ggx", "charlie").is_some_and(|e| e.contains("at n.v = 0 it is infinite")));
    assert!(request("charlie", "smith").is_some_and(|e| e.contains("no limit at roughness 0")));
    for (ndf, visibility) in [("ggx", "kelemen"), ("beckmann", "cook-torrance"), ("abc:a1=9,a2=2", "neubelt")] {
        assert_eq!(request(ndf, visibility), None);
    }
}

#[test]
fn every_table_states_its_source_and_bounds() {
    for table in TABLES {
        let facts = table.facts();
        assert!(!facts.source.is_empty() && !facts.usage.is_empty() && !facts.tolerance.why.is_empty());
        let most = match facts.name {
            name if name.starts_with("glass") => 5e-6,
            "schlick-weight" => 2e-6,
            // 1/E.
            "turquin" => 1e-5,
            // Fits: tests/ltc.rs has what they keep.
            _ if table.usual().is_fit => 1e-2,
            _ => 1e-6,
        };
        assert!(facts.tolerance.worst <= most && facts.tolerance.median < facts.tolerance.worst);
    }
}

/// ∫ f(x, y, z) over unit vectors of the hemisphere, smooth for any ellipse that is not too narrow.
fn over_facets(ellipse: &ggx::Ellipse, f: impl Fn([f64; 3]) -> f64) -> f64 {
    let (polar, azimuth) = (gauss_legendre(160), 512);
    let mut sum = 0.0;
    for p in &polar {
        // In the stretched hemisphere, where the density is 1/π times the cosine z, which is 0 at the steepest facets.
        let z = 0.5 * (1.0 + p.x);
        let sine = ((1.0 - z) * (1.0 + z)).sqrt();
        for i in 0..azimuth {
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(i) + 0.5) / f64::from(azimuth)).sin_cos();
            let stretched = [sine * cos * ellipse.alpha[0], sine * sin * ellipse.alpha[1], z];
            let length = stretched.iter().map(|x| x * x).sum::<f64>().sqrt();
            let h = stretched.map(|x| x / length);
            // D(h) cos θ dh = 2z dz dφ/(2π), so an integral of f is one of f/(D cos θ).
            sum += p.weight * z / f64::from(azimuth) * f(h) / (ellipse.d(h) * h[2]);
        }
    }
    sum
}

#[test]
fn anisotropic_distribution_is_normalised_and_shadowed_by_its_own_area() {
    for text in ELLIPTIC {
        let ndf = ndf::parse(text).unwrap();
        for roughness in [0.04, 0.3, 0.8, 1.0] {
            let ellipse = ndf.ellipse(&ndf.lobe(roughness).unwrap()).unwrap();
            // By brute force over the polar angle and the azimuth in the ellipse's own axes: tan θ = e^t.
            let (polar, azimuth) = (gauss_legendre(400), 512);
            let mut sum = 0.0;
            for p in &polar {
                let tan = (25.0 * p.x).exp();
                let cos2 = 1.0 / (1.0 + tan * tan);
                let (sin, cos) = (tan * cos2.sqrt(), cos2.sqrt());
                for i in 0..azimuth {
                    let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(azimuth)).sin_cos();
                    let d = ellipse.d([sin * c, sin * s, cos]);
                    sum += 25.0 * p.weight * std::f64::consts::TAU / f64::from(azimuth) * sin * sin * cos * cos * d;
                }
            }
            close(sum, 1.0, 1e-6);
            // Smith's identity: the area that is seen from v.
            for n_dot_v in [0.2f64, 0.7] {
                let v = ellipse.turned([(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v]);
                let seen = |h: [f64; 3]| ellipse.d(h) * (v[0] * h[0] + v[1] * h[1] + v[2] * h[2]).max(0.0);
                close(over_facets(&ellipse, seen), ellipse.sigma(v), 2e-4);
            }
        }
    }
}

#[test]
fn nearly_round_ellipse_is_round() {
    let (round, nearly) = (Model::parse("ggx", "smith").unwrap(), Model::parse("ggx:ratio=0.999999", "smith").unwrap());
    for n_dot_v in [0.0, 0.01, 0.3, 1.0] {
        for roughness in [0.0, 0.05, 0.4, 1.0] {
            let at = At { n_dot_v, roughness };
            let (a, b) = (round.rule(at), nearly.rule(at));
            for c in 0..3 {
                assert!((a[c] - b[c]).abs() <= 2e-6, "{at:?}: {a:?} and {b:?}");
            }
        }
    }
}

#[test]
fn what_no_rule_computes_is_refused() {
    let refused = |ndf: &str, visibility: &str, fresnel: Fresnel, table: &str| {
        let request = TableRequest {
            ndf: ndf.into(),
            visibility: visibility.into(),
            fresnel: Some(fresnel),
            ..TableRequest::new(table)
        };
        request.resolve().err().map(|e| e.to_string()).expect("refused")
    };
    assert!(refused("ggx:ratio=0.5", "cook-torrance", Fresnel::ONE, "albedo").contains("not smooth"));
    let internal = Fresnel::dielectric(0.7).unwrap();
    assert!(refused("ggx:ratio=0.5", "smith", internal, "albedo").contains("internal reflection"));
    assert!(refused("ggx:ratio=0.5", "smith", Fresnel::ONE, "average-albedo").contains("azimuth"));
    assert!(refused("ggx", "smith", internal, "split-sum").contains("Schlick's split"));
}

#[test]
fn what_is_reflected_is_less_than_what_is_kept() {
    for text in FRESNELS {
        for (ndf, visibility) in [("ggx", "smith"), ("beckmann", "cook-torrance")] {
            let model = Model::parse(ndf, visibility).unwrap().with(Fresnel::parse(text).unwrap());
            for n_dot_v in [0.01, 0.3, 1.0] {
                for roughness in [0.0, 0.1, 0.6, 1.0] {
                    let [e, rest @ ..] = model.rule(At { n_dot_v, roughness });
                    assert!(e <= 1.0 + 2e-6 && rest.iter().all(|r| (0.0..=e).contains(r)), "{text}: {e} {rest:?}");
                }
            }
        }
    }
}

#[test]
fn beckmann_and_blinn_phong_of_like_width_are_alike() {
    // The classic pair, Beckmann with m = 0.748 and Blinn–Phong with n = 10.67, both with Schlick's geometry term: they
    // part visibly only where the lobe is wide, off the normal.
    let roughness = roughness_of(0.748);
    let beckmann = Model::parse("beckmann", "schlick-beckmann").unwrap();
    let (b, p) = (ndf::parse("beckmann").unwrap(), ndf::parse("phong:exponent=10.67").unwrap());
    let (b_lobe, p_lobe) = (b.lobe(roughness).unwrap(), p.lobe(1.0).unwrap());
    let ratio = |cos: f64| b.d(cos * cos, 1.0 - cos * cos, &b_lobe) / p.d(cos * cos, 1.0 - cos * cos, &p_lobe);
    assert!(ratio(1.0) < 1.0 && ratio(0.5) > 1.3, "{} {}", ratio(1.0), ratio(0.5));
    assert!(beckmann.rule(At { n_dot_v: 0.5, roughness })[0] < 1.0);
}
