// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU seconds of whole processes (user + system, all threads: a shared machine's wall clock says little), with the error
//! that the bake itself measured. `cargo bench` prints a table; `cargo bench -- --json` one object a line; `cargo bench -- env`
//! only rows whose title holds the word.

use std::path::Path;
use std::process::Command;

use brdf_baker::env::Equirect;
use serde_json::{Value, json};

/// Runs of each command after one that warms the driver's shader cache.
const RUNS: usize = 5;
/// Runs of each of two commands whose times are compared, also after one that warms.
const TURNS: usize = 15;

/// CPU seconds of all children that this process has waited for, from `/proc/self/stat`; `None` where that is missing.
fn children_cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    // Fields 16 and 17 of proc(5), counted from 1; the rest after the command starts at 3. 100 ticks a second.
    let ticks: f64 = fields.get(13)?.parse::<f64>().ok()? + fields.get(14)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

fn main() {
    let as_json = std::env::args().any(|a| a == "--json");
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut rows: Vec<(String, Vec<String>)> = vec![];
    let mut add = |title: &str, arguments: &[&str]| {
        rows.push((title.into(), arguments.iter().map(|a| a.to_string()).collect()));
    };
    add("split-sum 256", &["bake", "split-sum", "-o", "a.ktx2"]);
    add("split-sum 512", &["bake", "split-sum", "-o", "a.ktx2", "--size", "512"]);
    add("split-sum 1024", &["bake", "split-sum", "-o", "a.ktx2", "--size", "1024"]);
    for size in ["512", "1024"] {
        let title = format!("split-sum {size}, expansion");
        add(&title, &["bake", "split-sum", "-o", "a.ktx2", "--size", size, "--rule", "expansion"]);
    }
    if brdf_baker::glsl::AVAILABLE {
        for (name, table) in [("ggx", "split-sum"), ("oren_nayar", "albedo")] {
            let path = format!("{}/examples/brdf/{name}.glsl", env!("CARGO_MANIFEST_DIR"));
            let title = format!("{table} 64, {name}.glsl");
            add(&title, &["bake", table, "-o", "a.ktx2", "--size", "64", "--glsl", &path]);
        }
    }
    add("split-sum 512, cpu", &["bake", "split-sum", "-o", "a.ktx2", "--size", "512", "--device", "cpu"]);
    add(
        "split-sum 512, uncorrelated",
        &["bake", "split-sum", "-o", "a.ktx2", "--size", "512", "--visibility", "smith-uncorrelated"],
    );
    for (ndf, visibility) in [
        ("ggx", "cook-torrance"),
        ("beckmann", "smith"),
        ("blinn-phong", "smith-uncorrelated"),
        ("gtr:gamma=1.5", "smith"),
        ("charlie", "charlie"),
        ("ggx:ratio=0.1,azimuth=80", "smith"),
    ] {
        let title = format!("split-sum 256, {ndf}, {visibility}");
        add(&title, &["bake", "split-sum", "-o", "a.ktx2", "--ndf", ndf, "--visibility", visibility]);
    }
    add("albedo 256, copper", &["bake", "albedo", "-o", "a.ktx2", "--material", "copper"]);
    add("albedo 256, inside glass", &["bake", "albedo", "-o", "a.ktx2", "--ior", "0.6667"]);
    add("albedo 512", &["bake", "albedo", "-o", "a.ktx2", "--size", "512"]);
    add("average-albedo 256", &["bake", "average-albedo", "-o", "a.ktx2"]);

    add("glass 256", &["bake", "glass", "-o", "a.ktx2"]);
    add("glass 256, inside", &["bake", "glass", "-o", "a.ktx2", "--ior", "0.6667"]);
    for name in [
        "ggx_E",
        "ggx_Eavg",
        "ggx_glass_E",
        "ggx_glass_Eavg",
        "ggx_glass_inv_E",
        "ggx_glass_inv_Eavg",
        "ggx_gen_schlick_s",
        "ggx_gen_schlick_ior_s",
        "sheen_ltc",
    ] {
        add(&format!("{name}, blender"), &["bake", name, "--for", "blender", "-o", "a.h"]);
    }
    let film = ["bake", "albedo", "-o", "a.ktx2", "--film", "1.33", "--ior", "1.5", "--size", "32"];
    add("film 32x32x32, to 1200 nm", &[&film[..], &["--axes", "n_dot_v,roughness,film_nm=0/1200"]].concat());
    add("schlick-weight 256", &["bake", "schlick-weight", "-o", "a.ktx2"]);
    add("kulla-conty 256", &["bake", "kulla-conty", "-o", "a.ktx2"]);
    add("turquin 256", &["bake", "turquin", "-o", "a.ktx2"]);
    add("skin 256", &["bake", "skin", "-o", "a.ktx2"]);

    // Two environments: a small one, as photographs are shared for tests, and a usual one.
    for (name, height) in [("512", 256), ("2048", 1024)] {
        environment(folder.path(), name, height);
    }
    add("env 256, linear, from 512x256", &["env", "512.exr", "-o", "a.ktx2"]);
    add("env 256, quadratic, from 512x256", &["env", "512.exr", "-o", "a.ktx2", "--roughness-law", "quadratic"]);
    // As Radiance HDR, which every tool reads, and as OpenEXR in floats, whose reading costs more.
    for file in ["2048.hdr", "2048.exr"] {
        for quality in ["draft", "standard", "reference"] {
            let title = format!("env 256, {quality}, from {file}");
            add(&title, &["env", file, "-o", "a.ktx2", "--quality", quality]);
        }
    }
    add("env 256, beckmann, from 2048x1024", &["env", "2048.exr", "-o", "a.ktx2", "--kernel", "beckmann"]);
    add("env 256, charlie, from 2048x1024", &["env", "2048.exr", "-o", "a.ktx2", "--kernel", "charlie"]);
    add("irradiance 64, from 2048x1024", &["env", "2048.exr", "--irradiance", "a.ktx2"]);
    add("harmonics, from 2048x1024", &["env", "2048.exr", "--sh", "a.json"]);
    add("env 512, linear, from 2048x1024", &["env", "2048.exr", "-o", "a.ktx2", "--size", "512"]);
    add("env 1024, bc6h, from 2048x1024", &["env", "2048.exr", "-o", "a.ktx2", "--encoding", "bc6h"]);

    if !as_json {
        println!(
            "{:36} {:>6} {:>6} {:>9} {:>9} {:>7} {:>7} {:>8}  device, rule",
            "bake", "CPU s", "wall s", "max err", "typical", "ns/out", "ns/in", "dispatch"
        );
    }
    let wanted = |title: &str| words.is_empty() || words.iter().any(|word| title.contains(word.as_str()));
    rows.retain(|(title, _)| wanted(title));
    for (title, arguments) in rows {
        let row = measure(folder.path(), &title, &arguments);
        if as_json {
            println!("{row}");
            continue;
        }
        let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
        let per_texel = |texels: &str| 1e9 * number("cpu_seconds") / number(texels);
        println!(
            "{title:36} {:6.2} {:6.2} {:>9.1e} {:>9.1e} {:7.0} {:7.0} {:5.0} ms  {}, {}",
            number("cpu_seconds"),
            number("wall_seconds"),
            number("max_error"),
            row["median_error"].as_f64().or(row["rms_error"].as_f64()).unwrap_or(f64::NAN),
            per_texel("output_texels"),
            per_texel("source_texels"),
            number("longest_dispatch_ms"),
            row["device"].as_str().unwrap_or("-"),
            row["rule"].as_str().unwrap_or("moment tree"),
        );
    }
    for (quality, file) in
        [("draft", "2048.hdr"), ("draft", "2048.exr"), ("reference", "2048.hdr"), ("reference", "2048.exr")]
    {
        let title = format!("env 256, {quality} over standard, from {file}");
        if !wanted(&title) {
            continue;
        }
        let ratio = ratio(folder.path(), quality, file);
        if as_json {
            println!("{}", json!({ "bake": title, "cpu_ratio": ratio }));
        } else {
            println!("{title:50} {:6.2} of the CPU s", ratio.unwrap_or(f64::NAN));
        }
    }
}

/// What a quality costs in units of the standard's time, from runs in turn, so that what else the machine does falls on both.
fn ratio(folder: &Path, quality: &str, file: &str) -> Option<f64> {
    let cost = |quality: &str| {
        let before = children_cpu_seconds();
        let arguments = ["env", file, "-o", "a.ktx2", "--quality", quality, "--json"];
        run(folder, &arguments);
        Some(children_cpu_seconds()? - before?)
    };
    let both = (0..=TURNS).map(|_| Some([cost(quality)?, cost("standard")?])).collect::<Option<Vec<_>>>()?;
    let [of, to] = [0, 1].map(|i| both[1..].iter().map(|pair| pair[i]).sum::<f64>());
    Some(of / to)
}

/// A sky with a sun over coloured noise, as an OpenEXR and a Radiance HDR file.
fn environment(folder: &Path, name: &str, height: u32) {
    let mut state = 1u32;
    let sky = Equirect::from_fn(height, |u, v| {
        let [x, y, z] = Equirect::direction(u, v);
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (state >> 8) as f32 / (1 << 24) as f32;
        let sun = 0.6 * x + 0.64 * y + 0.48 * z;
        let disc = if sun > (0.5f64).to_radians().cos() { 20_000.0 } else { 0.0 };
        if y > 0.0 { [0.3 + disc, 0.5 + disc, 1.0 + 0.9 * disc] } else { [0.4, 0.3, 0.2].map(|c| c * noise) }
    });
    let texel = |x: usize, y: usize| {
        let [r, g, b] = sky.texels[y * sky.width as usize + x];
        (r, g, b)
    };
    let (width, height) = (sky.width as usize, sky.height as usize);
    exr::prelude::write_rgb_file(folder.join(format!("{name}.exr")), width, height, texel).expect("a writable folder");
    let pixels: Vec<_> = sky.texels.iter().map(|texel| image::Rgb(*texel)).collect();
    let file = std::fs::File::create(folder.join(format!("{name}.hdr"))).expect("a writable folder");
    let written = image::codecs::hdr::HdrEncoder::new(std::io::BufWriter::new(file)).encode(&pixels, width, height);
    written.expect("a writable folder");
}

/// What a command says of itself.
fn run(folder: &Path, arguments: &[&str]) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    let output = command.current_dir(folder).args(arguments).output().expect("the program starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// Medians over the runs.
fn measure(folder: &Path, title: &str, arguments: &[String]) -> Value {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).chain(["--json"]).collect();
    let (mut cpu, mut wall, mut last) = (vec![], vec![], Value::Null);
    for i in 0..=RUNS {
        let before = children_cpu_seconds();
        let start = std::time::Instant::now();
        last = run(folder, &arguments);
        let seconds = start.elapsed().as_secs_f64();
        if i > 0 {
            wall.push(seconds);
            cpu.extend(children_cpu_seconds().zip(before).map(|(after, before)| after - before));
        }
    }
    let median = |mut v: Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v.get(v.len() / 2).copied()
    };
    json!({
        "bake": title,
        "cpu_seconds": median(cpu),
        "wall_seconds": median(wall),
        "max_error": last["max_error"],
        "median_error": last["median_error"],
        "output_texels": last["output_texels"],
        "source_texels": last["source_texels"],
        "longest_dispatch_ms": last["longest_dispatch_ms"],
        "rule": last["rule"],
        "rms_error": last["rms_error"],
        "device": last["device"],
    })
}
