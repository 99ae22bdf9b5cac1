// SPDX-License-Identifier: MIT OR Apache-2.0
//! The rules against the truth, adaptive integration in other coordinates, and against what others published.

use brdf_baker::bake::{At, Model, TABLES, Table, table};
use brdf_baker::term::fresnel::Fresnel;
use brdf_baker::term::visibility::VISIBILITIES;
use rayon::prelude::*;

mod common;
use common::{ELLIPTIC, FRESNELS, NDFS, Random};

/// Corners, edges, and 60 places that crowd towards 0.
fn places() -> Vec<At> {
    let ends = [1.0 / 1024.0, 0.01, 0.1, 0.5, 1.0];
    let mut list: Vec<At> = vec![];
    for n_dot_v in ends {
        list.extend(ends.map(|roughness| At { n_dot_v, roughness }));
    }
    let mut random = Random(7);
    let mut draw = || (-(1024f64.ln()) * random.next()).exp();
    list.extend((0..60).map(|_| At { n_dot_v: draw(), roughness: draw() }));
    list
}

#[test]
fn rules_are_within_a_microunit_of_the_truth() {
    for name in ["split-sum", "albedo"] {
        let table = table(name).unwrap();
        for visibility in VISIBILITIES.iter().filter(|v| v.smith) {
            let model = Model::parse("ggx", visibility.name).unwrap();
            let errors: Vec<f64> = places()
                .par_iter()
                .map(|at| {
                    let (rule, truth) = (table.rule(&model, *at), table.truth(&model, *at, 1e-8));
                    assert!(truth.error <= 1e-7, "{at:?}: the truth is only within {:e}", truth.error);
                    (0..rule.len()).map(|c| (rule[c] - truth.value[c]).abs()).fold(0.0, f64::max)
                })
                .collect();
            let mut sorted = errors.clone();
            sorted.sort_by(f64::total_cmp);
            let (worst, median) = (sorted[sorted.len() - 1], sorted[sorted.len() / 2]);
            println!("{name} {}: worst {worst:.1e}, median {median:.1e} at {} places", visibility.name, sorted.len());
            assert!(worst <= 7e-7 && median <= 5e-8, "{name} {}: worst {worst:e}, median {median:e}", visibility.name);
        }
    }
}

#[test]
fn every_model_is_within_its_bounds_of_the_truth() {
    let table = table("split-sum").unwrap();
    let mut list = corners_and(24);
    // The limit at grazing, where it exists.
    list.extend([0.03, 0.3, 1.0].map(|roughness| At { n_dot_v: 0.0, roughness }));
    assert!(list.len() >= 40);
    for text in NDFS {
        for visibility in VISIBILITIES {
            let model = Model::parse(text, visibility.name).unwrap();
            within_its_bounds(table, &model, &list);
        }
    }
}

#[test]
fn every_fresnel_term_is_within_its_bounds_of_the_truth() {
    let list = corners_and(14);
    assert!(list.len() >= 30);
    for text in FRESNELS {
        for (ndf, visibility) in
            [("ggx", "smith"), ("ggx", "cook-torrance"), ("beckmann", "smith"), ("charlie", "neubelt")]
        {
            let model = Model::parse(ndf, visibility).unwrap().with(Fresnel::parse(text).unwrap());
            within_its_bounds(table("albedo").unwrap(), &model, &list);
        }
    }
}

#[test]
fn every_anisotropic_lobe_is_within_its_bounds_of_the_truth() {
    let list = corners_and(24);
    assert!(list.len() >= 40);
    for text in ELLIPTIC {
        for visibility in VISIBILITIES.iter().filter(|v| v.kinks.is_none()) {
            within_its_bounds(table("albedo").unwrap(), &Model::parse(text, visibility.name).unwrap(), &list);
        }
    }
}

/// Grazing and near-mirror corners, and `n` places between.
fn corners_and(n: usize) -> Vec<At> {
    let mut list: Vec<At> = vec![];
    for n_dot_v in [1.0 / 512.0, 0.02, 0.5, 1.0] {
        list.extend([1.0 / 512.0, 0.1, 0.5, 0.9, 1.0].map(|roughness| At { n_dot_v, roughness }));
    }
    let mut random = Random(5);
    let mut draw = || (-(512f64.ln()) * random.next()).exp();
    list.extend((0..n).map(|_| At { n_dot_v: draw(), roughness: draw().sqrt() }));
    list
}

/// The rule at these places is as far from the truth as the model's tolerance allows, at most.
fn within_its_bounds(table: &dyn Table, model: &Model, places: &[At]) {
    let what = format!("{} {} {}", model.ndf, model.visibility.name, model.fresnel);
    let tolerance = model.tolerance(&table.facts().tolerance);
    let errors: Vec<(f64, At)> = places
        .par_iter()
        .filter(|at| at.n_dot_v > 0.0 || !model.visibility.diverges_at_grazing)
        .map(|at| {
            let (rule, truth) = (table.rule(model, *at), table.truth(model, *at, 0.1 * tolerance.worst));
            // The albedo is the largest of a table's values.
            let scale = truth.value.into_iter().fold(1.0, f64::max);
            let claim = truth.error / scale;
            assert!(claim <= 0.3 * tolerance.worst, "{what} {at:?}: truth {claim:e}");
            let errors = (0..rule.len()).map(|c| (rule[c] - truth.value[c]).abs() / scale);
            (errors.max_by(f64::total_cmp).expect("channels"), *at)
        })
        .collect();
    // NaN sorts last: it is the worst.
    let (worst, at) = errors.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).expect("places");
    println!("{what}: worst {worst:.1e} at {at:?}");
    let bound = tolerance.at(at);
    assert!(worst <= bound, "{what} {at:?}: {worst:e}, bound {bound:e}");
}

#[test]
fn average_albedo_of_every_model_is_within_its_bounds_of_the_truth() {
    // One roughness a model, where its albedo has the most to it; the truth is a threefold integral.
    let average = table("average-albedo").unwrap();
    for (ndf, visibility, fresnel, roughness) in [
        ("beckmann", "smith", "one", 0.7),
        ("beckmann", "cook-torrance", "one", 1.0),
        ("ggx", "neumann", "one", 0.5),
        ("blinn-phong", "smith-uncorrelated", "one", 0.9),
        ("gtr:gamma=1.5", "smith", "one", 0.3),
        ("abc:a2=3", "schlick-ggx", "one", 0.3),
        ("charlie", "neubelt", "one", 0.2),
        ("charlie", "charlie", "one", 0.8),
        ("ggx", "smith", "dielectric:ior=1.5", 0.3),
        ("ggx", "smith", "dielectric:ior=0.6666666666666666", 0.3),
        ("ggx", "smith", "conductor:eta=0.2/1.1/1.25,k=3.9/2.6/2.3", 0.6),
    ] {
        let model = Model::parse(ndf, visibility).unwrap().with(Fresnel::parse(fresnel).unwrap());
        within_its_bounds(average, &model, &[At { n_dot_v: 1.0, roughness }]);
    }
}

#[test]
fn average_albedo_is_within_a_microunit_of_the_truth() {
    let average = table("average-albedo").unwrap();
    for visibility in VISIBILITIES.iter().filter(|v| v.smith) {
        let model = Model::parse("ggx", visibility.name).unwrap();
        for roughness in [1.0 / 1024.0, 0.05, 0.3, 0.7, 1.0] {
            let at = At { n_dot_v: 1.0, roughness };
            let (rule, truth) = (average.rule(&model, at)[0], average.truth(&model, at, 1e-7));
            assert!(truth.error <= 3e-7);
            assert!((rule - truth.value[0]).abs() <= 6e-7, "{roughness}: {rule} instead of {}", truth.value[0]);
        }
    }
}

/// Blender Cycles' published directional albedo (intern/cycles/scene/shader.tables, Apache-2.0): GGX, height-correlated
/// Smith, from 2^20 and more samples an entry. Rows are n·v = i/31, columns roughness = i/31, both at least 1e-4.
const CYCLES_E: &str = include_str!("golden/cycles_ggx_e.txt");

#[test]
fn albedo_agrees_with_the_published_table_of_cycles() {
    let albedo = table("albedo").unwrap();
    let model = Model::parse("ggx", "smith").unwrap();
    let mut compared = 0;
    for line in CYCLES_E.lines().filter(|l| !l.starts_with('#')) {
        let mut numbers = line.split_whitespace().map(|n| n.parse::<f64>().unwrap());
        let at = At { n_dot_v: numbers.next().unwrap(), roughness: numbers.next().unwrap() };
        let published = numbers.next().unwrap();
        let found = albedo.rule(&model, at)[0];
        assert!((found - published).abs() <= 2e-6, "{at:?}: {found}, published {published}");
        compared += 1;
    }
    assert_eq!(compared, 64);
}

#[test]
fn truth_of_every_table_is_its_own() {
    // A truth that called the rule would agree to the last bit.
    let model = Model::parse("ggx", "smith").unwrap();
    for table in TABLES {
        let (model, at) = (model.with(table.facts().fresnel), At { n_dot_v: 0.37, roughness: 0.61 });
        assert_ne!(table.rule(&model, at)[0], table.truth(&model, at, 1e-7).value[0]);
    }
}
