// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linearly transformed cosines: fits against published ones by the same measure, against independent integration, from
//! texel to texel, and what a file of them says.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use brdf_baker::bake::ltc::place;
use brdf_baker::bake::{At, Backend, Model, TableJob, TableRequest, table};
use brdf_baker::brdf::Brdf;
use brdf_baker::format;
use brdf_baker::progress::ignore;
use brdf_baker::rule::fibre_layer::FibreLayer;
use brdf_baker::rule::lobe_nodes::{Fineness, LobeNodes};
use brdf_baker::rule::ltc::{FIT, Inverse, fit};
use brdf_baker::rule::ltc_sheen::squared_error;
use brdf_baker::texture::Texture;
use brdf_baker::verify::ltc::fit_error;
use brdf_baker::verify::table::{Extent, check};
use brdf_baker::verify::truth;
use rayon::prelude::*;
use serde_json::Value;
use tempfile::TempDir;

/// Nodes of which none is one of a fit's.
const FINE: Fineness = Fineness { polar: 15, azimuth: 20, panel: 0.9 };

fn ggx() -> Model {
    Model::parse("ggx", "smith").unwrap()
}

/// Numbers of a golden file, line by line.
fn golden(text: &str) -> Vec<Vec<f64>> {
    let line = |line: &str| line.split_whitespace().map(|n| n.parse().unwrap()).collect();
    text.lines().filter(|l| !l.starts_with('#')).map(line).collect()
}

/// Places of published texels with the four entries and magnitude, Fresnel, sphere.
fn published() -> Vec<(At, Vec<f64>)> {
    let at = |numbers: &[f64]| {
        let t = numbers[1] / 63.0;
        At { n_dot_v: (1.0 - t) * (1.0 + t), roughness: numbers[0] / 63.0 }
    };
    let list = golden(include_str!("golden/ltc_published.txt"));
    assert_eq!(list.len(), 48);
    list.into_iter().map(|numbers| (at(&numbers), numbers[2..].to_vec())).collect()
}

fn lobe(model: &Model, at: At, fineness: Fineness) -> LobeNodes {
    LobeNodes::of_model(model, place(model, at), fineness).unwrap()
}

fn matrix(model: &Model, at: At) -> Inverse {
    Inverse(table("ltc").unwrap().rule(model, at))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn fits_are_no_worse_than_the_published_ones() {
    let model = ggx();
    let cubes: Vec<[f64; 2]> = published()
        .par_iter()
        .map(|(at, numbers)| {
            let nodes = lobe(&model, *at, FINE);
            let theirs = Inverse(std::array::from_fn(|i| numbers[i]));
            [matrix(&model, *at), theirs].map(|inverse| inverse.cubed_error(&nodes))
        })
        .collect();
    for (i, name) in ["ours", "published"].iter().enumerate() {
        let errors: Vec<f64> = cubes.iter().map(|c| c[i].cbrt()).collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        println!("{name}: fit error {worst:.4} worst, {:.4} median", median(errors));
    }
    // Errors below 1e-4 are those of rounding.
    let ratio = cubes.iter().map(|[ours, theirs]| ours / theirs.max(1e-12)).fold(0.0, f64::max);
    println!("largest ratio of the cubed errors {ratio:.4}");
    assert!(ratio <= 1.05, "{ratio}");
    // The measure can tell: the published fits are not all as good as ours.
    assert!(cubes.iter().filter(|[ours, theirs]| *ours < 0.8 * theirs).count() >= 20);
}

#[test]
fn magnitudes_are_right_where_published_ones_are_near() {
    let (model, table) = (ggx(), table("ltc-magnitude").unwrap());
    let errors: Vec<[f64; 3]> = published()
        .par_iter()
        .map(|(at, numbers)| {
            let (rule, truth) = (table.rule(&model, *at), table.truth(&model, *at, 1e-7));
            for (c, (rule, truth_value)) in rule.iter().zip(truth.value).enumerate() {
                let error = (rule - truth_value).abs();
                assert!(error <= 1e-6 + truth.error && truth.error <= 1e-6, "{at:?} {c}: {error:e}");
            }
            [0, 1, 3].map(|c| (rule[c] - numbers[4 + c.min(2)]).abs())
        })
        .collect();
    let worst: [f64; 3] = std::array::from_fn(|c| errors.iter().map(|e| e[c]).fold(0.0, f64::max));
    println!("published magnitude, Fresnel and sphere are off by up to {worst:?}");
    // Height-correlated Smith: the separable one is off by 0.25 at the same texels.
    assert!(worst[0] < 0.08 && worst[1] < 0.05 && worst[2] < 3e-6, "{worst:?}");
    let other = Model::parse("ggx", "smith-uncorrelated").unwrap();
    let off = |(at, numbers): &(At, Vec<f64>)| (table.rule(&other, *at)[0] - numbers[4]).abs();
    assert!(published().iter().map(off).fold(0.0, f64::max) > 0.2);
}

#[test]
fn no_entry_of_a_fit_can_be_moved_to_advantage() {
    // By the independent integral. Where a fit's nodes see the lobe a little differently, so little is to be had.
    for (ndf, visibility, n_dot_v, roughness) in [
        ("ggx", "smith", 0.9, 0.2),
        ("ggx", "smith", 0.5, 0.5),
        ("ggx", "smith", 0.15, 0.4),
        ("ggx", "smith", 0.7, 1.0),
        ("beckmann", "smith", 0.6, 0.6),
        ("charlie", "neubelt", 0.4, 0.8),
    ] {
        let (model, at) = (Model::parse(ndf, visibility).unwrap(), At { n_dot_v, roughness });
        let best = matrix(&model, at);
        let error = |inverse: &Inverse| fit_error(&model, at, inverse, 1e-5).value[0];
        let least = error(&best);
        let by_nodes = best.cubed_error(&lobe(&model, at, FIT)).cbrt();
        assert!((by_nodes - least).abs() <= 5e-3 * least + 1e-4, "{ndf} {at:?}: {by_nodes} and {least}");
        let mut gained = 0.0f64;
        for i in 0..4 {
            for step in [-0.01, 0.01] {
                let mut moved = best;
                moved.0[i] += step * (best.0[i].abs() + 0.02 * best.0[3].abs());
                gained = gained.max(least - error(&moved));
            }
        }
        println!("{ndf} {visibility} {at:?}: fit error {least:.4}, {gained:.1e} to be had");
        assert!(gained <= 4e-3 * least + 2e-5, "{ndf} {at:?}: {gained} of {least}");
    }
}

#[test]
fn a_narrow_lobe_is_a_transformed_cosine() {
    // In the limit GGX is one: twice alpha wide in the plane of incidence, and n·v times as wide across it.
    let (model, at) = (ggx(), At { n_dot_v: 0.6, roughness: 0.03 });
    let Inverse([m00, m20, m02, m22]) = matrix(&model, at);
    assert!((m00 - 0.6 * 0.6).abs() < 1e-4 && (m02 - 0.8 * 0.6).abs() < 1e-4, "{m00} {m02}");
    let wide = (m00 * m22 - m20 * m02) / m00.hypot(m02).powi(2) * m00.hypot(m02);
    assert!((wide / (2.0 * 0.0009 * 0.6) - 1.0).abs() < 1e-3, "{wide}");
    assert!(fit_error(&model, at, &matrix(&model, at), 1e-5).value[0] < 1e-3);
    // Along the normal it is round.
    let Inverse(round) = matrix(&model, At { n_dot_v: 1.0, roughness: 0.5 });
    assert_eq!([round[0], round[1], round[2]], [1.0, 0.0, 0.0]);
}

#[test]
fn neighbours_are_alike() {
    // Three texels in a row of the usual table, along both axes: no entry bends by more than this, the last rows included.
    let model = ggx();
    let at = |x: f64, y: f64| At { n_dot_v: (1.0 - y / 63.0) * (1.0 + y / 63.0), roughness: x / 63.0 };
    let places =
        [(3, 40), (9, 58), (14, 61), (18, 62), (27, 61), (30, 20), (40, 55), (45, 62), (55, 59), (61, 60), (61, 62)];
    let bends: Vec<(f64, (i32, i32))> = places
        .par_iter()
        .map(|&(x, y)| {
            let entries = |dx: i32, dy: i32| matrix(&model, at(f64::from(x + dx), f64::from(y + dy))).0;
            let middle = entries(0, 0);
            let bend =
                |a: [f64; 4], b: [f64; 4]| (0..4).map(|i| (a[i] - 2.0 * middle[i] + b[i]).abs()).fold(0.0, f64::max);
            (bend(entries(-1, 0), entries(1, 0)).max(bend(entries(0, -1), entries(0, 1))), (x, y))
        })
        .collect();
    let (worst, place) = bends.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    println!("second difference {worst:.4} at {place:?}");
    assert!(worst < 0.1, "{bends:?}");
}

#[test]
fn between_texels_the_lobe_still_fits() {
    // What a shader reads half-way between four texels of the usual table.
    let model = ggx();
    let at = |x: f64, y: f64| At { n_dot_v: (1.0 - y / 63.0) * (1.0 + y / 63.0), roughness: x / 63.0 };
    for (x, y) in [(4, 30), (9, 50), (18, 57), (30, 60), (45, 61), (60, 40)] {
        let (x, y) = (f64::from(x), f64::from(y));
        let mut mean = [0.0; 4];
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let Inverse(entries) = matrix(&model, at(x + dx, y + dy));
            (0..4).for_each(|i| mean[i] += 0.25 * entries[i]);
        }
        let middle = at(x + 0.5, y + 0.5);
        let nodes = lobe(&model, middle, FIT);
        let [read, best] = [Inverse(mean), matrix(&model, middle)].map(|m| m.cubed_error(&nodes).cbrt());
        println!("({x}, {y}): fit error {read:.4}, {best:.4} at best");
        assert!(read <= best + 0.04, "({x}, {y}): {read}, {best} at best");
    }
}

/// The solid angle of a polygon above z = 0, weighted by the cosine over π: Lambert's formula, clipped.
fn cosine_of_polygon(vertices: &[[f64; 3]]) -> f64 {
    let mut clipped = vec![];
    for (i, a) in vertices.iter().enumerate() {
        let b = vertices[(i + 1) % vertices.len()];
        if a[2] > 0.0 {
            clipped.push(*a);
        }
        if (a[2] > 0.0) != (b[2] > 0.0) {
            let t = a[2] / (a[2] - b[2]);
            clipped.push(std::array::from_fn(|k| a[k] + t * (b[k] - a[k])));
        }
    }
    let unit = |v: [f64; 3]| v.map(|x| x / v.iter().map(|x| x * x).sum::<f64>().sqrt());
    let edge = |i: usize| {
        let (a, b) = (unit(clipped[i]), unit(clipped[(i + 1) % clipped.len()]));
        let angle = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().clamp(-1.0, 1.0).acos();
        (a[0] * b[1] - a[1] * b[0]) * angle / angle.sin().max(1e-12)
    };
    ((0..clipped.len()).map(edge).sum::<f64>() / std::f64::consts::TAU).abs()
}

#[test]
fn a_lamp_lights_as_the_brdf_itself_does() {
    // A rectangular lamp, by the formulas of docs/area-lights.md and by summing the BRDF over its area.
    let model = ggx();
    for (n_dot_v, roughness, centre, bound) in [
        (0.8, 0.4, [-0.75, 0.0, 1.0], 0.02),
        (0.5, 0.5, [-1.5, 0.3, 1.0], 0.05),
        (0.5, 0.8, [0.2, 0.5, 1.5], 0.06),
        (0.3, 0.3, [-2.5, 0.0, 1.0], 0.08),
        (1.0, 0.7, [0.0, 0.8, 1.0], 0.05),
    ] {
        let at = At { n_dot_v, roughness };
        let v = [f64::sqrt(1.0 - n_dot_v * n_dot_v), 0.0, n_dot_v];
        // It faces the point that it lights; half as high as wide.
        let distance = centre.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
        let normal = centre.map(|x| -x / distance);
        let (side, length) = ([-normal[1], normal[0], 0.0], normal[0].hypot(normal[1]));
        let side = if length > 0.0 { side.map(|x| 0.4 * x / length) } else { [0.4, 0.0, 0.0] };
        let up: [f64; 3] = std::array::from_fn(|i| {
            0.5 * (normal[(i + 1) % 3] * side[(i + 2) % 3] - normal[(i + 2) % 3] * side[(i + 1) % 3])
        });
        let point = |a: f64, b: f64| -> [f64; 3] { std::array::from_fn(|i| centre[i] + a * side[i] + b * up[i]) };
        let brdf = Brdf::new(model.ndf, model.visibility, roughness).unwrap();
        let (n, area) = (200, 4.0 * 0.4 * 0.2);
        let mut sum = 0.0;
        for i in 0..n * n {
            let place = |k: i32| (2.0 * f64::from(k) + 1.0) / f64::from(n) - 1.0;
            let p = point(place(i % n), place(i / n));
            let d = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            let l = p.map(|x| x / d);
            let facing: f64 = -l.iter().zip(normal).map(|(l, n)| l * n).sum::<f64>();
            sum += brdf.reflected(l, v) * facing / (d * d) * area / f64::from(n * n);
        }
        let inverse = matrix(&model, at);
        let corners = [point(-1.0, -1.0), point(1.0, -1.0), point(1.0, 1.0), point(-1.0, 1.0)];
        let magnitude = table("ltc-magnitude").unwrap().rule(&model, at)[0];
        let fitted = magnitude * cosine_of_polygon(&corners.map(|p| inverse.apply(p)));
        println!("{at:?}: {fitted:.5}, by the BRDF {sum:.5}, off by {:.2} %", 100.0 * (fitted / sum - 1.0));
        assert!((fitted / sum - 1.0).abs() < bound, "{at:?}: {fitted} instead of {sum}");
    }
}

#[test]
fn every_lobe_of_the_registries_is_fitted() {
    for (ndf, visibility) in [
        ("ggx", "smith-uncorrelated"),
        ("ggx", "schlick-ggx"),
        ("beckmann", "cook-torrance"),
        ("blinn-phong", "smith"),
        ("gtr:gamma=1.5", "smith"),
        ("abc:a1=50,a2=2", "smith"),
        ("charlie", "charlie"),
        ("charlie", "neubelt"),
    ] {
        let model = Model::parse(ndf, visibility).unwrap();
        for at in [(1.0, 0.3), (0.5, 0.6), (0.1, 0.9), (0.0, 0.0)].map(|(n_dot_v, roughness)| At { n_dot_v, roughness })
        {
            let (nodes, at) = (lobe(&model, at, FIT), place(&model, at));
            let found = fit(&nodes, at.n_dot_v, model.ndf.lobe(at.roughness).unwrap().peak);
            println!("{ndf} {visibility} {at:?}: {:.4} {:.4?}", found.error(), found.inverse.0);
            assert!(found.inverse.0.iter().all(|m| m.is_finite()) && found.error() < 0.9, "{ndf} {at:?}: {found:?}");
            // The nodes hold the lobe.
            let albedo = truth::albedo(&model, at.n_dot_v, at.roughness, 1e-6).value[0];
            let off = (nodes.albedo() - albedo).abs() / albedo.max(1e-3);
            assert!(off < 5e-3, "{ndf} {visibility} {at:?}: {} instead of {albedo}", nodes.albedo());
        }
    }
}

fn baked(name: &str, size: u32) -> (TableJob, Texture) {
    let job = TableRequest { size: (size, size), ..TableRequest::new(name) }.resolve().unwrap();
    let texture = job.run(&Backend::Cpu, &mut ignore).unwrap();
    (job, texture)
}

fn failures(job: &TableJob, texture: &Texture) -> Vec<String> {
    check(job, texture, None, Extent::Spot, &mut ignore).unwrap().failures
}

#[test]
fn faults_of_matrices_are_seen() {
    let (job, sound) = baked("ltc", 6);
    assert_eq!(failures(&job, &sound), [""; 0]);
    let spoilt = |texel: usize, fault: &dyn Fn(&mut [f32])| {
        let mut texture = sound.clone();
        fault(&mut texture.levels[0][4 * texel..4 * texel + 4]);
        failures(&job, &texture).join("; ")
    };
    let law = "further from the true lobe";
    // At roughness 0.2, n·v 0.64 the last entry is 0.05: 5 % of it is within the absolute bound of a fit, not of the law.
    let narrow = 3 * 6 + 1;
    assert!(sound.levels[0][4 * narrow + 3] < 0.1);
    assert!(spoilt(narrow, &|t| t[3] *= 1.1).contains("fit error"), "{law}");
    assert!(spoilt(narrow, &|t| t.swap(1, 2)).contains("are off against"));
    assert!(spoilt(4 * 6 + 3, &|t| t[0] = f32::NAN).contains("outside"));
    // A table of another geometry term is not this one.
    let other = TableRequest { visibility: "implicit".into(), size: (6, 6), ..TableRequest::new("ltc") };
    let other = other.resolve().unwrap();
    assert!(!failures(&other, &sound).is_empty());
}

#[test]
fn faults_of_magnitudes_are_seen() {
    let (job, sound) = baked("ltc-magnitude", 6);
    assert_eq!(failures(&job, &sound), [""; 0]);
    for (c, step) in [(0, 3e-6), (1, 3e-6), (2, 3e-6), (3, 3e-6)] {
        let mut texture = sound.clone();
        texture.levels[0][4 * (2 * 6 + 4) + c] += step;
        assert!(!failures(&job, &texture).is_empty(), "{c}");
    }
}

#[test]
fn sheen_of_fibres_fits_as_the_published_table_does() {
    let table = table("ltc-sheen-fibres").unwrap();
    let mut worst = [0.0f64; 2];
    for numbers in golden(include_str!("golden/ltc_sheen_approx.txt")) {
        let at = At { n_dot_v: numbers[1], roughness: numbers[0].sqrt() };
        let (rule, truth) = (table.rule(&ggx(), at), table.truth(&ggx(), at, 1e-6));
        let off = (rule[2] - truth.value[2]).abs();
        assert!(off <= 1e-5, "{at:?}: reflectance {} instead of {}", rule[2], truth.value[2]);
        let nodes = FibreLayer::new(at).nodes(FINE);
        let [ours, theirs] =
            [[rule[0], rule[1]], [numbers[2], numbers[3]]].map(|e| squared_error(&nodes, rule[2], e).sqrt());
        println!("{at:?}: {ours:.4}, published {theirs:.4}; reflectance {:.4}, published {:.4}", rule[2], numbers[4]);
        assert!(ours <= 1.005 * theirs, "{at:?}: {ours}, published {theirs}");
        worst = [worst[0].max(ours), worst[1].max((rule[2] - numbers[4]).abs())];
    }
    println!("fit error {:.3} worst; published reflectance off by up to {:.3}", worst[0], worst[1]);
    assert!(worst[0] < 0.6 && worst[1] < 0.12, "{worst:?}");
}

#[test]
fn sheen_of_charlie_holds_its_albedo() {
    let table = table("ltc-sheen").unwrap();
    for visibility in ["charlie", "neubelt"] {
        let model = Model::parse("charlie", visibility).unwrap();
        for (n_dot_v, alpha) in [(0.1, 0.3), (0.5, 0.5), (0.9, 0.8), (1.0, 1.0)] {
            let at = At { n_dot_v, roughness: f64::sqrt(alpha) };
            let (rule, truth) = (table.rule(&model, at), table.truth(&model, at, 1e-6));
            let scale = truth.value[2].max(1.0);
            assert!(
                (rule[2] - truth.value[2]).abs() <= 1e-5 * scale,
                "{visibility} {at:?}: {rule:?} {:?}",
                truth.value
            );
            assert!(
                (0..2).all(|i| (rule[i] - truth.value[i]).abs() < 1e-2),
                "{visibility} {at:?}: {rule:?} {:?}",
                truth.value
            );
        }
    }
}

/// On the processor, so that no test needs a driver.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).args(["--device", "cpu"]).stdin(Stdio::null());
    command.output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

#[test]
fn files_are_verified_and_say_how_well_they_fit() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let good = |arguments: &[&str]| -> Value {
        let output = run(here, &[arguments, &["--json"]].concat());
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        serde_json::from_str(&text(&output.stdout)).unwrap()
    };
    assert_eq!(good(&["bake", "ltc", "-o", "l.ktx2", "--size", "6"])["encoding"], "rgba32f");
    let verified = good(&["verify", "l.ktx2"]);
    let claim = |key: &str| {
        let claims = verified["certificate"]["claims"].as_array().unwrap();
        claims.iter().find(|c| c["key"] == key).map(|c| c["verdict"].clone()).unwrap_or_default()
    };
    assert_eq!([claim("fit-error.worst"), claim("fit-error.median"), claim("rule")], ["confirmed"; 3]);
    let info = good(&["info", "l.ktx2"]);
    assert_eq!(info["meta"]["axes"], "roughness,sqrt_one_minus_n_dot_v");
    assert!(info["meta"]["fit-error.worst"].as_str().unwrap().parse::<f64>().unwrap() > 0.1);
    // Halves of a preset, and the code that loads both.
    good(&["bake", "ltc", "--for", "three", "--size", "6"]);
    good(&["bake", "ltc-magnitude", "--for", "three", "--size", "6"]);
    let module = std::fs::read_to_string(here.join("ltc_mat_1.js")).unwrap();
    assert!(module.contains("export const LTC_MAT_1 = new Uint16Array(["));
    assert!(good(&["info", "ltc_mat_2.js"])["snippet"].as_str().unwrap().contains("LTC_FLOAT_2"));
    good(&["verify", "ltc_mat_1.js"]);
    // Over the last entry, in half floats: the mirror's 1/m22 too.
    good(&["bake", "ltc", "--for", "unity-hdrp", "--size", "6"]);
    let path = here.join("ltc_ggx.dds");
    let (slice, encoding) = format::for_path(&path).unwrap().read(&path).unwrap();
    assert_eq!((encoding.name, slice.width), ("rgba16f", 6));
    assert!(slice.levels[0].iter().all(|m| m.abs() < 65504.0) && slice.texel(0, 0, 0, 0)[2] > 4e4);
    // The fit error as a channel, and a table without a model.
    good(&["bake", "ltc", "-o", "e.exr", "--size", "6", "--channels", "fit-error"]);
    let (errors, _) = format::for_path(Path::new("e.exr")).unwrap().read(&here.join("e.exr")).unwrap();
    assert!(errors.levels[0].iter().all(|e| (0.0..=1.0).contains(e)));
    good(&["bake", "ltc-sheen-fibres", "-o", "s.ktx2", "--size", "4"]);
    assert_eq!(good(&["verify", "s.ktx2"])["ndf"], Value::Null);
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let folder = TempDir::new().unwrap();
    for (arguments, words) in [
        (&["bake", "ltc", "-o", "a.ktx2", "--ior", "1.5"][..], &["Schlick's split", "--ior"][..]),
        (&["bake", "ltc", "-o", "a.ktx2", "--ndf", "ggx:ratio=0.5"], &["isotropic"]),
        (&["bake", "ltc-sheen-fibres", "-o", "a.ktx2", "--ndf", "charlie"], &["lobe of its own", "ltc-sheen"]),
        (&["bake", "ltc", "-o", "a.png"], &["16-bit PNG", ".ktx2"]),
        (&["bake", "ltc", "-o", "a.ktx2", "--channels", "m11"], &["no channel 'm11'", "m00"]),
    ] {
        let output = run(folder.path(), arguments);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        words.iter().for_each(|word| assert!(stderr.contains(word), "{arguments:?}: '{word}' is not in: {stderr}"));
        assert!(!folder.path().join("a.ktx2").exists());
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder.path()).args(["bake", "ltc", "-o", "a.ktx2", "--device", "llvmpipe"]);
    let output = command.output().unwrap();
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains("on the processor"));
}
