// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ring rule, and what it bakes: weights of a generalised Schlick term, thin films.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use brdf_baker::axis::Points;
use brdf_baker::bake::{At, Backend, Model, SliceAxis, TableJob, TableRequest, VolumeJob, table};
use brdf_baker::format::{self, Encoding, Format};
use brdf_baker::progress::ignore;
use brdf_baker::term::fresnel::Fresnel;
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::verify::table::{Extent, check};
use rayon::prelude::*;
use tempfile::TempDir;

mod common;
use common::Random;

/// GGX with height-correlated Smith and a Fresnel term.
fn model(fresnel: &str) -> Model {
    Model::parse("ggx", "smith").unwrap().with(Fresnel::parse(fresnel).unwrap())
}

/// Corners, and `n` places between.
fn places(n: usize) -> Vec<At> {
    let mut list: Vec<At> = vec![];
    for n_dot_v in [0.0, 1.0 / 1024.0, 0.05, 0.4, 1.0] {
        list.extend([1.0 / 256.0, 0.1, 0.5, 1.0].map(|roughness| At { n_dot_v, roughness }));
    }
    let mut random = Random(17);
    let mut draw = || (-(512f64.ln()) * random.next()).exp();
    list.extend((0..n).map(|_| At { n_dot_v: draw(), roughness: draw().sqrt() }));
    list
}

/// Exponents from a layer at grazing to nearly a constant with a dip, and indices from next to none to beyond the one above
/// which the reflectance dips.
const TERMS: [&str; 7] = [
    "power:exponent=70",
    "power:exponent=5",
    "power:exponent=0.769",
    "power:exponent=0.0505",
    "rescaled:ior=1.05",
    "rescaled:ior=1.5",
    "rescaled:ior=7",
];

/// Holds the first `values` of a table's rule to its truth at every place, known to `share` of the bounds.
fn within_bounds_of_the_truth(name: &str, terms: &[&str], list: &[At], values: usize, share: f64) {
    let table = table(name).unwrap();
    for text in terms {
        let model = model(text);
        let bounds = model.tolerance(&table.facts().tolerance);
        let errors: Vec<(f64, At)> = list
            .par_iter()
            .map(|at| {
                let (rule, truth) = (table.rule(&model, *at), table.truth(&model, *at, share * bounds.worst));
                assert!(truth.error <= bounds.worst, "{text} {at:?}: truth {:e}", truth.error);
                let error = (0..values).map(|c| (rule[c] - truth.value[c]).abs()).fold(0.0, f64::max);
                (error, *at)
            })
            .collect();
        let (worst, at) = errors.iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        println!("{name} {text}: worst {worst:.1e} at {at:?}, of {} places", errors.len());
        assert!(*worst <= bounds.at(*at), "{text} {at:?}: {worst:e}");
    }
}

#[test]
fn weights_of_schlick_are_within_their_bounds_of_the_truth() {
    within_bounds_of_the_truth("schlick-weight", &TERMS, &places(8), 1, 0.1);
}

#[test]
fn rings_and_the_cone_find_the_same_albedo() {
    // Two rules with no node in common; Schlick's weight and a dielectric's.
    for at in places(60) {
        let [e, b, ..] = model("power:exponent=5").rule(at);
        let [cone_e, cone_b, ..] = model("schlick").rule(at);
        assert!((e - cone_e).abs() <= 1.5e-6 && (b - cone_b).abs() <= 1.5e-6, "{at:?}: {e} {b}, {cone_e} {cone_b}");
        let [e, w, ..] = model("rescaled:ior=1.5").rule(at);
        let [_, reflected, ..] = model("dielectric:ior=1.5").rule(at);
        let found = 0.04 * e + 0.96 * w;
        assert!((found - reflected).abs() <= 2e-6, "{at:?}: {found}, {reflected}");
    }
}

/// Blender Cycles' published tables, entries of each.
const CYCLES: &str = include_str!("golden/cycles_gen_schlick.txt");

/// An entry: name, indices of z, n·v and roughness, value.
fn cycles() -> impl Iterator<Item = (&'static str, [u32; 3], f64)> {
    CYCLES.lines().filter(|l| !l.starts_with('#')).map(|line| {
        let words: Vec<&str> = line.split(' ').collect();
        let index = |i: usize| words[i].parse().unwrap();
        (words[0], [index(1), index(2), index(3)], words[4].parse().unwrap())
    })
}

#[test]
fn weights_of_schlick_agree_with_the_published_tables_of_cycles() {
    let table = table("schlick-weight").unwrap();
    let mut errors = vec![];
    for (name, [z, mu, roughness], published) in cycles() {
        let (axis, term) = match name {
            "ggx_gen_schlick_s" => (SliceAxis::CyclesExponent, "power:exponent"),
            _ => (SliceAxis::FromF0, "rescaled:ior"),
        };
        let fresnel = Fresnel::parse(&format!("{term}={}", axis.value(z, 16, Points::Edges))).unwrap();
        let at = At { n_dot_v: f64::from(mu) / 15.0, roughness: f64::from(roughness) / 15.0 };
        let found = table.rule(&Model::parse("ggx", "smith").unwrap().with(fresnel), at)[0];
        let error = (found - published).abs();
        // What their random samples leave.
        assert!(error <= 3e-5, "{name} {z} {mu} {roughness}: {found}, published {published}");
        errors.push(error);
    }
    assert_eq!(errors.len(), 300);
    errors.sort_by(f64::total_cmp);
    println!("Cycles, 300 entries: worst {:.1e}, median {:.1e}", errors[299], errors[150]);
    assert!(errors[150] <= 1e-6);
}

#[test]
fn limits_of_the_weight_are_closed_forms() {
    let table = table("schlick-weight").unwrap();
    for n_dot_v in [0.0, 0.2, 0.7, 1.0] {
        let at = At { n_dot_v, roughness: 0.0 };
        let flat = table.rule(&model("power:exponent=3"), at)[0];
        assert!((flat - (1.0 - n_dot_v).powi(3)).abs() < 1e-12, "{n_dot_v}: {flat}");
    }
    // All facets seen from above, alpha 1: cosines are uniform in their square, and half of the facets reflect downwards.
    let at = At { n_dot_v: 1.0, roughness: 1.0 };
    let found = table.rule(&model("power:exponent=1"), at)[0];
    let expected = 0.5 - 2.0 / 3.0 * (1.0 - 0.5f64.powf(1.5));
    assert!((found - expected).abs() < 1e-7, "{found}, {expected}");
    // An infinite exponent and an index of 1 leave nothing.
    for text in ["power:exponent=inf", "rescaled:ior=1"] {
        assert_eq!(table.rule(&model(text), At { n_dot_v: 0.3, roughness: 0.5 })[0], 0.0, "{text}");
    }
}

#[test]
fn rings_agree_with_their_twin_on_a_device() {
    common::on_gpu(|backend| {
        for text in TERMS {
            for (name, points) in [("schlick-weight", Points::Edges), ("albedo", Points::Centers)] {
                let fresnel = Some(Fresnel::parse(text).unwrap());
                let job =
                    TableRequest { size: (24, 16), points, fresnel, ..TableRequest::new(name) }.resolve().unwrap();
                let texture = job.run(backend, &mut ignore).unwrap();
                let mut errors = vec![];
                for y in 0..16 {
                    for x in 0..24 {
                        let at = job.at(x, y);
                        let error = (f64::from(texture.texel(0, 0, x, y)[0]) - job.rule(at)[0]).abs();
                        assert!(error <= 1e-6, "{name} {text} {at:?}: {error:e}");
                        errors.push(error);
                    }
                }
                errors.sort_by(f64::total_cmp);
                println!("{name} {text}: twin worst {:.1e}, median {:.1e}", errors[383], errors[192]);
                assert!(errors[192] <= 2e-7, "{name} {text}: median {:e}", errors[192]);
            }
        }
    });
}

#[test]
fn narrow_lobes_agree_with_their_twin_on_a_device() {
    // Near the horizon, where rings of a narrow lobe are nearly whole.
    common::on_gpu(|backend| {
        for name in ["schlick-weight", "albedo"] {
            let fresnel = Some(Fresnel::parse("power:exponent=5").unwrap());
            let request = TableRequest { size: (256, 256), fresnel, ..TableRequest::new(name) };
            let job = request.resolve().unwrap();
            let texture = job.run(backend, &mut ignore).unwrap();
            for y in 0..12 {
                for x in 0..24 {
                    let at = job.at(x, y);
                    let error = (f64::from(texture.texel(0, 0, x, y)[0]) - job.rule(at)[0]).abs();
                    assert!(error <= 2e-6, "{name} {at:?}: {error:e}");
                }
            }
        }
    });
}

#[test]
fn faults_of_the_weight_are_seen() {
    let request = |text: &str| TableRequest {
        size: (24, 24),
        fresnel: Some(Fresnel::parse(text).unwrap()),
        ..TableRequest::new("schlick-weight")
    };
    let failures =
        |job: &TableJob, texture: &Texture| check(job, texture, None, Extent::Spot, &mut ignore).unwrap().failures;
    let job = request("power:exponent=5").resolve().unwrap();
    let sound = job.run(&Backend::Cpu, &mut ignore).unwrap();
    assert_eq!(failures(&job, &sound), Vec::<String>::new(), "the sound table must pass");
    let mut texture = sound.clone();
    texture.levels[0].iter_mut().for_each(|v| *v *= 1.001);
    assert!(!failures(&job, &texture).is_empty());
    assert!(!failures(&request("power:exponent=5.01").resolve().unwrap(), &sound).is_empty());
    assert!(!failures(&request("rescaled:ior=1.5").resolve().unwrap(), &sound).is_empty());
    // What shadowing takes is in.
    let shadowed = TableRequest { fresnel: job.model.fresnel.into(), ..request("power:exponent=5") };
    let shadowed = TableRequest { channels: None, table: "albedo".into(), ..shadowed }.resolve().unwrap();
    let mut texture = sound.clone();
    texture.levels = shadowed.run(&Backend::Cpu, &mut ignore).unwrap().levels;
    assert!(!failures(&job, &texture).is_empty());
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command.output().expect("the program starts")
}

#[test]
fn weights_of_cycles_are_baked_by_its_own_names() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    for name in ["ggx_gen_schlick_s", "ggx_gen_schlick_ior_s"] {
        let output = run(here, &["bake", name, "--for", "blender"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let path = here.join(name).with_extension("h");
        let (texture, encoding) = format::for_path(&path).unwrap().read(&path).unwrap();
        assert_eq!((texture.levels[0].len(), encoding.name), (16 * 16 * 16, "r32f"));
        let mut compared = 0;
        for (_, [z, mu, roughness], published) in cycles().filter(|(of, ..)| *of == name) {
            let found = texture.levels[0][((z * 16 + mu) * 16 + roughness) as usize];
            assert!((f64::from(found) - published).abs() <= 3e-5, "{name} {z} {mu} {roughness}: {found}");
            compared += 1;
        }
        assert_eq!(compared, 150);
    }
}

#[test]
fn weights_are_baked_verified_and_described() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let succeeds = |arguments: &[&str]| {
        let output = run(here, arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let fails = |arguments: &[&str], words: &[&str]| {
        let output = run(here, arguments);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        words.iter().for_each(|word| assert!(stderr.contains(word), "{arguments:?}: '{word}' is not in: {stderr}"));
    };
    let bake = |more: &[&'static str]| [&["bake", "schlick-weight", "-o", "w.ktx2", "--device", "cpu"], more].concat();
    succeeds(&bake(&["--size", "8", "--exponent", "2.5"]));
    assert!(succeeds(&["info", "w.ktx2"]).contains("power:exponent=2.5"));
    assert!(succeeds(&["verify", "w.ktx2", "--full"]).contains("right"));
    succeeds(&bake(&["--size", "8", "--ior", "1.5"]));
    assert!(succeeds(&["info", "w.ktx2"]).contains("rescaled:ior=1.5"));
    succeeds(&bake(&["--size", "4x4x3", "--axes", "n_dot_v,roughness,cycles_exponent", "--points", "edges"]));
    let info = succeeds(&["info", "w.ktx2"]);
    for word in ["volume", "cycles_exponent", "exponent inf, the last 0.050505"] {
        assert!(info.contains(word), "'{word}' is not in: {info}");
    }
    assert!(succeeds(&["verify", "w.ktx2", "--full"]).contains("right"));

    std::fs::remove_file(here.join("w.ktx2")).unwrap();
    fails(&bake(&["--exponent", "0"]), &["an exponent of 0 ", "5"]);
    fails(&bake(&["--exponent", "5", "--ior", "1.5"]), &["--exponent", "--ior"]);
    fails(&bake(&["--ior", "0.6"]), &["schlick-weight has no Fresnel term", "from outside"]);
    fails(&bake(&["--material", "gold"]), &["schlick-weight has no Fresnel term"]);
    fails(&bake(&["--ndf", "beckmann"]), &["ggx with smith", "beckmann"]);
    fails(&bake(&["--visibility", "smith-uncorrelated"]), &["ggx with smith", "smith-uncorrelated"]);
    fails(&bake(&["--axes", "n_dot_v,roughness,cycles_exponent", "--exponent", "5"]), &["drop --exponent"]);
    fails(
        &["bake", "glass", "-o", "w.ktx2", "--axes", "n_dot_v,roughness,cycles_exponent"],
        &["glass has no axis of exponents", "refractive indices"],
    );
    assert!(!here.join("w.ktx2").exists());
}

/// Soap, oil on water, a lacquered metal, an anodised one.
const FILMS: [&str; 4] = [
    "film:ior=1.33,nm=320,eta=1/1/1,k=0/0/0",
    "film:ior=1.47,nm=900,eta=1.33/1.33/1.33,k=0/0/0",
    "film:ior=1.5,nm=2500,eta=0.2/1.1/1.25,k=3.9/2.6/2.3",
    "film:ior=2.4,nm=110,eta=2.6/2.5/2.3,k=3.7/3.4/3.1",
];

#[test]
fn films_are_within_their_bounds_of_the_truth() {
    within_bounds_of_the_truth("albedo", &FILMS, &places(4), 4, 0.2);
}

#[test]
fn films_agree_with_their_twin_on_a_device() {
    common::on_gpu(|backend| {
        for text in FILMS {
            let fresnel = Some(Fresnel::parse(text).unwrap());
            let job = TableRequest { size: (24, 16), fresnel, ..TableRequest::new("albedo") }.resolve().unwrap();
            let texture = job.run(backend, &mut ignore).unwrap();
            let mut worst = 0.0f64;
            for y in 0..16 {
                for x in 0..24 {
                    let rule = job.rule(job.at(x, y));
                    for (found, expected) in texture.texel(0, 0, x, y).iter().zip(rule) {
                        let error = (f64::from(*found) - expected).abs();
                        assert!(error <= 1e-6, "{text} ({x}, {y}): {error:e}");
                        worst = worst.max(error);
                    }
                }
            }
            println!("{text}: twin worst {worst:.1e}");
        }
    });
}

#[test]
fn film_without_thickness_is_the_base() {
    for (film, base) in [
        ("film:ior=2,nm=0,eta=1.5/1.5/1.5,k=0/0/0", "dielectric:ior=1.5"),
        ("film:ior=1.4,nm=0,eta=0.2/1.1/1.25,k=3.9/2.6/2.3", "conductor:eta=0.2/1.1/1.25,k=3.9/2.6/2.3"),
    ] {
        for at in places(20) {
            let (with, without) = (model(film).rule(at), model(base).rule(at));
            assert!((with[1] - without[1]).abs() <= 1.5e-6, "{film} {at:?}: {with:?}, {without:?}");
        }
    }
}

#[test]
fn faults_of_a_film_are_seen() {
    let request = |nm: f64| TableRequest {
        size: (16, 16),
        fresnel: Some(Fresnel::film(Fresnel::dielectric(1.5).unwrap(), 1.33, nm).unwrap()),
        ..TableRequest::new("albedo")
    };
    let failures =
        |job: &TableJob, texture: &Texture| check(job, texture, None, Extent::Spot, &mut ignore).unwrap().failures;
    let job = request(400.0).resolve().unwrap();
    let sound = job.run(&Backend::Cpu, &mut ignore).unwrap();
    assert_eq!(failures(&job, &sound), Vec::<String>::new(), "the sound table must pass");
    let mut texture = sound.clone();
    texture.levels[0].chunks_exact_mut(3).for_each(|texel| texel.swap(0, 2));
    assert!(!failures(&job, &texture).is_empty());
    assert!(!failures(&request(401.0).resolve().unwrap(), &sound).is_empty());
}

#[test]
fn films_are_baked_over_thickness() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let succeeds = |arguments: &[&str]| {
        let output = run(here, arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let fails = |arguments: &[&str], words: &[&str]| {
        let output = run(here, arguments);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        words.iter().for_each(|word| assert!(stderr.contains(word), "{arguments:?}: '{word}' is not in: {stderr}"));
    };
    let bake = |more: &[&'static str]| [&["bake", "albedo", "-o", "f.ktx2", "--device", "cpu"], more].concat();

    // Angle by thickness at one roughness: a flat table.
    let over =
        ["--film", "1.33", "--ior", "1", "--axes", "n_dot_v,film_nm=0/800", "--size", "8x5", "--points", "edges"];
    let line = succeeds(&bake(&[&over[..], &["--roughness", "0.3"]].concat()));
    assert!(line.contains("f.ktx2  8x5 rgba16f"), "{line}");
    let info = succeeds(&["info", "f.ktx2"]);
    for word in ["film:ior=1.33,nm=0,eta=1/1/1", "thickness in nm 0.000000, the last 800", "red,green,blue", "0.3"] {
        assert!(info.contains(word), "'{word}' is not in: {info}");
    }
    assert!(succeeds(&["verify", "f.ktx2", "--full"]).contains("right"));
    let (texture, _) = format::Ktx2.read(&here.join("f.ktx2")).unwrap();
    assert_eq!(texture.texel(0, 0, 3, 0)[..3], [0.0; 3], "no film and no base reflect nothing");
    let model = model("film:ior=1.33,nm=400,eta=1/1/1,k=0/0/0");
    let expected = model.rule(At { n_dot_v: 3.0 / 7.0, roughness: 0.3 });
    let found = texture.texel(0, 0, 3, 2);
    assert!((0..3).all(|c| (f64::from(found[c]) - expected[c + 1]).abs() < 1e-3), "{found:?} {expected:?}");

    // With roughness a 3-D one; one film a plain table; averages.
    let metal = ["--film", "1.5", "--material", "titanium", "--size", "4x4x3"];
    succeeds(&bake(&[&metal[..], &["--axes", "n_dot_v,roughness,film_nm=50/250"]].concat()));
    assert!(succeeds(&["verify", "f.ktx2", "--full"]).contains("3 of 3 were looked at"));
    succeeds(&bake(&["--film", "1.5,200", "--material", "titanium", "--size", "6"]));
    assert!(succeeds(&["verify", "f.ktx2"]).contains("right"));
    succeeds(&[
        "bake",
        "average-albedo",
        "-o",
        "a.ktx2",
        "--device",
        "cpu",
        "--film",
        "1.5,200",
        "--ior",
        "1.5",
        "--size",
        "6",
    ]);
    assert!(succeeds(&["verify", "a.ktx2"]).contains("right"));

    std::fs::remove_file(here.join("f.ktx2")).unwrap();
    fails(&bake(&["--film", "1.5,200"]), &["--film", "--ior"]);
    fails(&bake(&["--film", "1.5", "--ior", "1.5"]), &["thickness", "film_nm"]);
    fails(&bake(&["--film", "0.9,200", "--ior", "1.5"]), &["film of refractive index 0.9", "1.05"]);
    fails(&bake(&["--film", "1.5,9000", "--ior", "1.5"]), &["film of 9000 nm"]);
    fails(&bake(&["--film", "1.5,200", "--ior", "0.7"]), &["not on the Fresnel term 'dielectric:ior=0.7'"]);
    fails(&bake(&["--axes", "n_dot_v,roughness,film_nm=0/500"]), &["without a film", "--film 1.33"]);
    fails(&bake(&["--film", "1.5,200", "--ior", "1.5", "--ndf", "beckmann"]), &["ggx with smith"]);
    fails(&bake(&["--roughness", "1.5", "--axes", "n_dot_v"]), &["a roughness of 1.5"]);
    fails(&["bake", "average-albedo", "-o", "f.ktx2", "--roughness", "0.5"], &["one number", "drop --roughness"]);
    assert!(!here.join("f.ktx2").exists());
}

#[test]
fn volume_of_six_square_slices_is_no_cube() {
    let request = TableRequest { size: (4, 4), points: Points::Edges, ..TableRequest::new("schlick-weight") };
    let texture = VolumeJob::new(&request, SliceAxis::FromF0, 6).unwrap().run(&Backend::Cpu, &mut ignore).unwrap();
    let read = |texture: &Texture| {
        let (path, encoding) = (Path::new("w.npy"), Encoding::parse("r32f").unwrap());
        let bytes = format::Npy.to_bytes(path, texture, encoding.into()).unwrap();
        format::Npy.parse(path, &bytes).unwrap().0
    };
    let found = read(&texture);
    assert_eq!((found.shape, found.width, found.height), (Shape::Volume { depth: 6 }, 4, 4));
    assert_eq!(found.levels, texture.levels);
    let cube = Texture { shape: Shape::Cube, meta: Meta::default(), ..texture };
    assert_eq!(read(&cube).shape, Shape::Cube);
}
