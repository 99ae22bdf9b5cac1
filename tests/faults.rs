// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every comparator is fed the faults that it exists for, and must say no.

use brdf_baker::axis::Points;
use brdf_baker::bake::{Backend, LayersJob, TableJob, TableRequest};
use brdf_baker::format::Encoding;
use brdf_baker::progress::ignore;
use brdf_baker::term::fresnel::Fresnel;
use brdf_baker::term::visibility::VISIBILITIES;
use brdf_baker::texture::Texture;
use brdf_baker::verify::table::{Extent, check};

mod common;
use common::{ELLIPTIC, FRESNELS};

fn job(name: &str) -> TableJob {
    let size = if name == "average-albedo" { (64, 1) } else { (32, 32) };
    TableRequest { size, ..TableRequest::new(name) }.resolve().unwrap()
}

fn baked(job: &TableJob) -> Texture {
    job.run(&Backend::Cpu, &mut ignore).unwrap()
}

/// The failures that a spot check of a fresh bake states.
fn failures(job: &TableJob, texture: &Texture) -> Vec<String> {
    check(job, texture, None, Extent::Spot, &mut ignore).unwrap().failures
}

/// Bakes, breaks, checks; the untouched table must pass and the broken one must not.
fn rejects(name: &str, fault: impl Fn(&mut Texture)) {
    let job = job(name);
    let mut texture = baked(&job);
    assert_eq!(failures(&job, &texture), Vec::<String>::new(), "the sound table must pass");
    fault(&mut texture);
    assert!(!failures(&job, &texture).is_empty(), "the fault was not seen");
}

#[test]
fn scale_by_a_thousandth_is_seen() {
    rejects("split-sum", |t| t.levels[0].iter_mut().for_each(|v| *v *= 1.001));
    rejects("albedo", |t| t.levels[0].iter_mut().for_each(|v| *v *= 0.999));
    rejects("average-albedo", |t| t.levels[0].iter_mut().for_each(|v| *v *= 0.999));
}

#[test]
fn faults_of_companions_are_seen() {
    let names = ["scale", "cloth", "disney-diffuse"].map(String::from).to_vec();
    let request = TableRequest { size: (32, 32), channels: Some(names), ..TableRequest::new("split-sum") };
    let job = request.resolve().unwrap();
    let sound = baked(&job);
    assert_eq!(failures(&job, &sound), Vec::<String>::new(), "the sound table must pass");
    for channel in 0..3 {
        let mut texture = sound.clone();
        texture.levels[0].chunks_exact_mut(3).for_each(|texel| texel[channel] *= 1.001);
        let found = failures(&job, &texture);
        assert!(found.iter().any(|f| f.contains(&texture.channels[channel])), "{channel}: {found:?}");
    }
    // Rows that run one ahead, as a shifted axis has them, are not those of a table that says otherwise.
    let ahead = TableRequest { row_shift: 1, ..request }.resolve().unwrap();
    assert_eq!(failures(&ahead, &baked(&ahead)), Vec::<String>::new());
    assert!(!failures(&job, &baked(&ahead)).is_empty() && !failures(&ahead, &sound).is_empty());
}

#[test]
fn scale_by_a_few_microunits_is_seen() {
    rejects("split-sum", |t| t.levels[0].iter_mut().for_each(|v| *v *= 1.0 - 4e-6));
}

#[test]
fn shifted_row_is_seen() {
    rejects("split-sum", |t| t.levels[0].rotate_right(32 * 2));
    rejects("albedo", |t| t.levels[0].rotate_right(32));
}

#[test]
fn shifted_column_is_seen() {
    rejects("split-sum", |t| t.levels[0].rotate_left(2));
}

#[test]
fn flipped_table_is_seen() {
    rejects("albedo", |t| t.levels[0].reverse());
}

#[test]
fn swapped_channels_are_seen() {
    rejects("split-sum", |t| t.levels[0].chunks_exact_mut(2).for_each(|p| p.swap(0, 1)));
}

#[test]
fn faults_in_any_layer_are_seen() {
    let request = |table: &str, visibility: &str, channels: [&str; 2]| TableRequest {
        size: (16, 16),
        visibility: visibility.into(),
        channels: Some(channels.map(String::from).to_vec()),
        ..TableRequest::new(table)
    };
    let scale = request("split-sum", "smith", ["scale", "bias"]);
    let albedo = request("albedo", "smith-uncorrelated", ["albedo", "cloth"]);
    let job = LayersJob::new(&[scale.clone(), albedo.clone()]).unwrap();
    let sound = job.run(&[&Backend::Cpu; 2], &mut ignore).unwrap();
    let failures = |job: &LayersJob, t: &Texture| job.check(t, None, Extent::Spot, &mut ignore).unwrap().all.failures;
    assert_eq!(failures(&job, &sound), Vec::<String>::new(), "the sound layers must pass");
    let half = sound.levels[0].len() / 2;
    let names = ["layer 0, split-sum: ", "layer 1, albedo: "];
    let fault = |change: &dyn Fn(&mut [f32])| {
        let mut texture = sound.clone();
        change(&mut texture.levels[0]);
        failures(&job, &texture)
    };
    let swapped = fault(&|texels| texels.rotate_left(half));
    assert!(names.iter().all(|name| swapped.iter().any(|f| f.starts_with(name))), "{swapped:?}");
    // Of each fault the layer is named, and no other.
    for (layer, name) in names.iter().enumerate() {
        let scaled = fault(&|texels| texels[layer * half..][..half].iter_mut().for_each(|v| *v *= 1.001));
        assert!(!scaled.is_empty() && scaled.iter().all(|f| f.starts_with(name)), "{scaled:?}");
        let nan = fault(&|texels| texels[layer * half + 37] = f32::NAN);
        assert!(!nan.is_empty() && nan.iter().all(|f| f.starts_with(name)), "{nan:?}");
    }
    // Layers whose descriptions are swapped.
    let swapped = LayersJob::new(&[albedo, scale]).unwrap();
    assert!(!failures(&swapped, &sound).is_empty());
}

#[test]
fn one_nan_is_seen() {
    for at in [0, 1001, 2047] {
        rejects("split-sum", |t| t.levels[0][at] = f32::NAN);
    }
}

#[test]
fn one_value_above_one_is_seen() {
    rejects("albedo", |t| t.levels[0][517] = 1.01);
}

#[test]
fn alpha_for_roughness_is_seen() {
    // A table whose rows hold alpha where roughness is stated.
    let stated = job("split-sum");
    let mut texture = baked(&stated);
    for y in 0..32 {
        for x in 0..32 {
            let mut at = stated.at(x, y);
            at.roughness = at.roughness.sqrt();
            let wrong = stated.rule(at);
            let texel = (y * 32 + x) as usize * 2;
            texture.levels[0][texel] = wrong[0] as f32;
            texture.levels[0][texel + 1] = wrong[1] as f32;
        }
    }
    assert!(!failures(&stated, &texture).is_empty());
}

#[test]
fn other_geometry_term_is_seen() {
    let stated = job("albedo");
    let other = TableRequest { visibility: "smith-uncorrelated".into(), size: (32, 32), ..TableRequest::new("albedo") };
    assert!(!failures(&stated, &baked(&other.resolve().unwrap())).is_empty());
}

/// A split-sum table of each pair of distribution and geometry term passes as itself and fails as the next one.
fn told_apart(models: &[(&str, &str)]) {
    let request = |(ndf, visibility): &(&str, &str)| TableRequest {
        ndf: ndf.to_string(),
        visibility: visibility.to_string(),
        size: (24, 24),
        ..TableRequest::new("split-sum")
    };
    requests_told_apart(&models.iter().map(request).collect::<Vec<_>>());
}

/// A table of each request passes as itself and fails as the next one.
fn requests_told_apart(requests: &[TableRequest]) {
    let jobs: Vec<TableJob> = requests.iter().map(|r| r.resolve().unwrap()).collect();
    for (i, job) in jobs.iter().enumerate() {
        let next = &jobs[(i + 1) % jobs.len()];
        let texture = baked(job);
        let name = |job: &TableJob| format!("{} {} {}", job.model.ndf, job.model.visibility.name, job.model.fresnel);
        assert_eq!(failures(job, &texture), Vec::<String>::new(), "{}", name(job));
        assert!(!failures(next, &texture).is_empty(), "{} passes for {}", name(job), name(next));
    }
}

#[test]
fn every_fresnel_term_is_told_from_the_next() {
    // Dielectrics have one channel, metals three.
    let request = |text: &str| TableRequest {
        fresnel: Some(Fresnel::parse(text).unwrap()),
        size: (24, 24),
        ..TableRequest::new("albedo")
    };
    let (metals, dielectrics): (Vec<&str>, Vec<&str>) =
        FRESNELS.into_iter().filter(|t| t.contains(':')).partition(|t| t.starts_with("conductor"));
    assert!(metals.len() >= 2 && dielectrics.len() >= 3);
    requests_told_apart(&metals.iter().map(|t| request(t)).collect::<Vec<_>>());
    requests_told_apart(&dielectrics.iter().map(|t| request(t)).collect::<Vec<_>>());
    // 1 % of an index.
    requests_told_apart(&["dielectric:ior=1.5", "dielectric:ior=1.515"].map(request));
}

#[test]
fn every_anisotropic_lobe_is_told_from_the_next() {
    let mut models: Vec<_> = ELLIPTIC.iter().map(|ndf| (*ndf, "smith")).collect();
    // One degree of azimuth, and none at all.
    models.extend([("ggx:ratio=0.3,azimuth=31", "smith"), ("ggx", "smith")]);
    told_apart(&models);
}

#[test]
fn f82_for_bias_is_seen() {
    let channels = |list: &[&str]| TableRequest {
        channels: Some(list.iter().map(|c| c.to_string()).collect()),
        size: (24, 24),
        ..TableRequest::new("split-sum")
    };
    requests_told_apart(&[channels(&["scale", "f82"]), channels(&["scale", "bias"])]);
}

#[test]
fn every_geometry_term_is_told_from_the_next() {
    let models: Vec<_> = VISIBILITIES.iter().map(|v| ("beckmann", v.name)).collect();
    told_apart(&models);
}

#[test]
fn every_distribution_is_told_from_the_next() {
    let models = common::NDFS.map(|ndf| (ndf, "smith"));
    told_apart(&models);
}

#[test]
fn edges_for_centers_are_seen() {
    let stated = job("split-sum");
    let other = TableRequest { points: Points::Edges, size: (32, 32), ..TableRequest::new("split-sum") };
    assert!(!failures(&stated, &baked(&other.resolve().unwrap())).is_empty());
}

#[test]
fn stored_half_off_by_two_ulp_is_seen_by_a_full_check() {
    let job = job("split-sum");
    let encoding = Encoding::parse("rg16f").unwrap();
    let mut texture = baked(&job);
    texture.levels[0].iter_mut().for_each(|v| *v = half::f16::from_f32(*v).to_f32());
    let full = |t: &Texture| check(&job, t, Some(encoding.into()), Extent::Full, &mut ignore).unwrap().failures;
    assert_eq!(full(&texture), Vec::<String>::new());
    let bits = half::f16::from_f32(texture.levels[0][999]).to_bits();
    texture.levels[0][999] = half::f16::from_bits(bits + 2).to_f32();
    assert_eq!(full(&texture).len(), 2, "twin and truth both see it");
}

#[test]
fn systematic_error_within_the_worst_bound_lifts_the_median() {
    // 6e-7 everywhere is within the worst bound of 1e-6, but no rounding looks like that.
    rejects("albedo", |t| t.levels[0].iter_mut().for_each(|v| *v -= 6e-7));
}

#[test]
fn cancelled_bake_ends_with_cancelled() {
    let mut ticks = 0;
    let result = job("albedo").run(&Backend::Cpu, &mut |_| {
        ticks += 1;
        std::ops::ControlFlow::Break(())
    });
    assert!(matches!(result, Err(brdf_baker::Error::Cancelled)) && ticks == 1);
}
