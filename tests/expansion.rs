// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables by Chebyshev expansion against the rule at every texel, and what is refused.

use brdf_baker::axis::Points;
use brdf_baker::bake::{Backend, RuleChoice, TableJob, TableRequest};
use brdf_baker::error::Error;
use brdf_baker::format::Encoding;
use brdf_baker::progress::ignore;
use brdf_baker::texture::Texture;
use brdf_baker::verify::certificate::{Certificate, Verdict};
use brdf_baker::verify::table::{Extent, check};
use rayon::prelude::*;

mod common;
use common::on_gpu;

const EXPANSION: RuleChoice = RuleChoice::Expansion(None);

fn request(table: &str, size: u32, rule: RuleChoice) -> TableRequest {
    TableRequest { size: (size, size), rule, ..TableRequest::new(table) }
}

/// The largest and the median difference from the rule in f64, over every third texel of every second row and the ends.
fn differences(job: &TableJob, texture: &Texture) -> (f64, f64) {
    let (width, height) = job.size();
    let rows: Vec<u32> = (0..height).step_by(2).chain([1, height - 1]).collect();
    let mut all: Vec<f64> = rows
        .par_iter()
        .flat_map_iter(|y| (0..width).step_by(3).chain([1, width - 1]).map(move |x| (x, *y)))
        .flat_map_iter(|(x, y)| {
            let expected = job.rule(job.at(x, y));
            let found = texture.texel(0, 0, x, y).to_vec();
            found.into_iter().zip(expected).map(|(f, e)| (f64::from(f) - e).abs() / e.abs().max(1.0))
        })
        .collect();
    all.sort_by(f64::total_cmp);
    (all[all.len() - 1], all[all.len() / 2])
}

#[test]
fn every_texel_is_within_its_bound_on_the_device() {
    on_gpu(|backend| {
        for (table, ndf, visibility, points) in [
            ("split-sum", "ggx", "smith", Points::Centers),
            ("split-sum", "ggx", "smith-uncorrelated", Points::Edges),
            ("albedo", "beckmann", "smith", Points::Centers),
        ] {
            let (ndf, visibility) = (ndf.to_string(), visibility.to_string());
            let request = TableRequest { ndf, visibility, points, ..request(table, 256, EXPANSION) };
            let job = request.resolve().unwrap();
            let texture = job.run(backend, &mut ignore).unwrap();
            let rule = texture.meta.get("rule").unwrap();
            assert!(rule.starts_with("Chebyshev expansion"), "{rule}");
            let (worst, median) = differences(&job, &texture);
            println!(
                "{table} {} {} {points:?}: {rule}: {worst:.2e}, median {median:.2e}",
                job.model.ndf, request.visibility
            );
            let bound = job.tolerance(0);
            assert!(worst <= 0.9 * bound.worst && median <= bound.median, "{worst:e} {median:e}");
            let report = check(&job, &texture, None, Extent::Spot, &mut ignore).unwrap();
            assert_eq!(report.failures, Vec::<String>::new());
        }
    });
}

#[test]
fn device_and_processor_expand_alike() {
    on_gpu(|backend| {
        let job = TableRequest { size: (200, 130), ..request("split-sum", 1, EXPANSION) }.resolve().unwrap();
        let (device, processor) =
            (job.run(backend, &mut ignore).unwrap(), job.run(&Backend::Cpu, &mut ignore).unwrap());
        let pairs = device.levels[0].iter().zip(&processor.levels[0]);
        let worst = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        assert!(worst > 0.0 && worst < 6e-7, "{worst:e}");
    });
}

#[test]
fn stated_error_is_that_of_the_series() {
    // On the processor nothing is rounded but the texels.
    for (table, size) in [("split-sum", 64), ("split-sum", 1024), ("albedo", 160)] {
        let job = TableRequest { size: (size, 40), ..request(table, 1, EXPANSION) }.resolve().unwrap();
        let texture = job.run(&Backend::Cpu, &mut ignore).unwrap();
        let stated = texture.meta.get("rule.error").unwrap();
        let numbers: Vec<f64> = stated.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
        let [tail, measured] = numbers[..] else { panic!("{stated}") };
        let (worst, _) = differences(&job, &texture);
        println!("{table} {size}: {worst:.2e}, {stated}, {}", texture.meta.get("rule").unwrap());
        // Rounding to single floats, and what lies between the points that were looked at.
        assert!(worst <= 1.5 * tail.max(measured) + 3.1e-8 && tail.max(measured) <= 2.05e-7, "{worst:e}, {stated}");
    }
}

#[test]
fn kinked_table_is_refused_and_auto_bakes_it_directly() {
    let of =
        |rule| TableRequest { size: (128, 128), visibility: "cook-torrance".into(), ..request("split-sum", 1, rule) };
    let error = of(EXPANSION).resolve().unwrap().run(&Backend::Cpu, &mut ignore).unwrap_err();
    assert!(matches!(&error, Error::Usage { .. }), "{error:?}");
    assert!(error.to_string().contains("coefficients") && error.help().contains("--rule direct"), "{error}");

    let auto = of(RuleChoice::Auto).resolve().unwrap().run(&Backend::Cpu, &mut ignore).unwrap();
    let direct = of(RuleChoice::Direct).resolve().unwrap().run(&Backend::Cpu, &mut ignore).unwrap();
    assert_eq!(auto.levels, direct.levels);
    assert_eq!(auto.meta.get("rule"), direct.meta.get("rule"));
    assert!(auto.meta.get("rule.note").unwrap().contains("coefficients") && direct.meta.get("rule.note").is_none());

    // A small table is cheaper directly, a large smooth one by expansion.
    let small = request("split-sum", 32, RuleChoice::Auto).resolve().unwrap().run(&Backend::Cpu, &mut ignore).unwrap();
    assert!(small.meta.get("rule").unwrap().starts_with("cone"));
    let large = request("split-sum", 128, RuleChoice::Auto).resolve().unwrap().run(&Backend::Cpu, &mut ignore).unwrap();
    assert!(large.meta.get("rule").unwrap().starts_with("Chebyshev") && large.meta.get("rule.note").is_none());

    let error = request("average-albedo", 64, EXPANSION).resolve().err().unwrap();
    assert!(error.to_string().contains("average-albedo is not expanded"), "{error}");
}

#[test]
fn limits_at_zero_are_those_of_the_rule() {
    let request = TableRequest { points: Points::Edges, ..request("split-sum", 65, EXPANSION) };
    let job = request.resolve().unwrap();
    let texture = job.run(&Backend::Cpu, &mut ignore).unwrap();
    for i in 0..65 {
        for (x, y) in [(0, i), (i, 0)] {
            let expected: Vec<f32> = job.rule(job.at(x, y)).iter().map(|v| *v as f32).collect();
            assert_eq!(texture.texel(0, 0, x, y), expected, "({x}, {y})");
        }
    }
}

#[test]
fn certificate_confirms_the_rule_and_refutes_another() {
    let job = request("split-sum", 128, EXPANSION).resolve().unwrap();
    let mut texture = job.run(&Backend::Cpu, &mut ignore).unwrap();
    let rule = texture.meta.get("rule").unwrap().to_string();
    let verdict = |texture: &Texture| {
        let job = TableJob::from_meta(texture).unwrap();
        let report = check(&job, texture, None, Extent::Spot, &mut ignore).unwrap();
        let certificate = Certificate::texels(texture, Encoding::parse("rg32f").unwrap()).unwrap();
        let certificate = certificate.table(job.rule_name(), &texture.meta, &report);
        certificate.claims.into_iter().find(|c| c.key == "rule").unwrap().verdict
    };
    assert_eq!(verdict(&texture), Verdict::Confirmed);
    texture.meta.set("rule", rule.replace("cone", "h-split"));
    assert_eq!(verdict(&texture), Verdict::Refuted);
}
