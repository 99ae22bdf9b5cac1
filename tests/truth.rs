//! The rules against the truth, adaptive integration in other coordinates, and against what others published.

use brdf_baker::bake::{At, Model, TABLES, table};
use brdf_baker::term::visibility::VISIBILITIES;
use rayon::prelude::*;

mod common;
use common::{NDFS, Random};

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
    // Grazing and near-mirror corners, then 24 places between.
    let ends = [1.0 / 512.0, 0.02, 0.5, 1.0];
    let mut list: Vec<At> = vec![];
    for n_dot_v in ends {
        list.extend([1.0 / 512.0, 0.1, 0.5, 1.0].map(|roughness| At { n_dot_v, roughness }));
    }
    let mut random = Random(5);
    let mut draw = || (-(512f64.ln()) * random.next()).exp();
    list.extend((0..24).map(|_| At { n_dot_v: draw(), roughness: draw().sqrt() }));
    // The limit at grazing, where it exists.
    list.extend([0.03, 0.3, 1.0].map(|roughness| At { n_dot_v: 0.0, roughness }));
    assert!(list.len() >= 40);
    for text in NDFS {
        for visibility in VISIBILITIES {
            let model = Model::parse(text, visibility.name).unwrap();
            let tolerance = model.tolerance(&table.facts().tolerance);
            let errors: Vec<(f64, At)> = list
                .par_iter()
                .filter(|at| at.n_dot_v > 0.0 || !visibility.diverges_at_grazing)
                .map(|at| {
                    let (rule, truth) = (table.rule(&model, *at), table.truth(&model, *at, 0.1 * tolerance.worst));
                    let scale = truth.value[2].max(1.0);
                    let claim = truth.error / scale;
                    assert!(claim <= 0.3 * tolerance.worst, "{text} {} {at:?}: truth {claim:e}", visibility.name);
                    let errors = (0..rule.len()).map(|c| (rule[c] - truth.value[c]).abs() / scale);
                    (errors.max_by(f64::total_cmp).expect("channels"), *at)
                })
                .collect();
            // NaN sorts last: it is the worst.
            let (worst, at) = errors.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).expect("places");
            println!("{text} {}: worst {worst:.1e} at {at:?}", visibility.name);
            let bound = tolerance.at(at);
            assert!(worst <= bound, "{text} {} {at:?}: {worst:e}, bound {bound:e}", visibility.name);
        }
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
        let at = At { n_dot_v: 0.37, roughness: 0.61 };
        assert_ne!(table.rule(&model, at)[0], table.truth(&model, at, 1e-7).value[0]);
    }
}
