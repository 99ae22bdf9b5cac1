// SPDX-License-Identifier: MIT OR Apache-2.0
//! The same input, parameters, version and device give the same bytes, however many threads there are and however the work
//! is cut; another device gives values as near as the files' certificates say. (Slices of tables are compared in
//! `tests/twins.rs`, shares of a recipe in `tests/recipe.rs`.)

mod common;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

use brdf_baker::bake::Backend;
use brdf_baker::bake::specular::SpecularRequest;
use brdf_baker::bake::specular_gpu::Limits;
use brdf_baker::env::import::{self, Options};
use brdf_baker::format::{Format, Ktx2};
use brdf_baker::progress::ignore;
use common::program::{environment, files, on_any_device, succeeds};
use tempfile::TempDir;

/// Bakes with sums over texels, rows, directions and slices, into containers of every way to state facts.
const RECIPE: &str = r#"
[[bake]]
table = "split-sum"
output = "dfg.ktx2"
size = 48

[[bake]]
table = "albedo"
ndf = "beckmann"
output = "albedo.exr"
size = 24

[[bake]]
table = "average-albedo"
output = "average.json"
size = 16

[[bake]]
table = "glass"
output = "glass.dds"
axes = ["n_dot_v", "roughness", "ior=1/2"]
size = "6x6x4"

[[env]]
input = "lamp.exr"
output = "lamp.ktx2"
size = 32
irradiance = "diffuse.exr"
sh = "harmonics.json"

[[env]]
input = "lamp.exr"
output = "blocks.ktx2"
size = 16
encoding = "bc6h"
compression = "zstd"
rotate = 30
"#;

/// Held by a test that has the driver inside of this process: NVIDIA's 580 crashes where one thread lets go of it while another
/// opens it.
static DRIVER: Mutex<()> = Mutex::new(());

fn has_device() -> bool {
    let _alone = DRIVER.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    common::gpu().is_some()
}

/// What is written by so many threads of the program, and of a driver that computes on the processor: with fewer threads
/// dispatches take longer, so that they get less work each.
fn written(device: &str, threads: u32) -> BTreeMap<PathBuf, Vec<u8>> {
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    environment(&here.join("lamp.exr"), 0.0);
    std::fs::write(here.join("recipe.toml"), RECIPE).expect("writable");
    let mut command = on_any_device(here, &["run", "recipe.toml", "-o", "out", "--device", device]);
    command.env("RAYON_NUM_THREADS", threads.to_string()).env("LP_NUM_THREADS", threads.to_string());
    let said = succeeds(&mut command);
    assert!(said.contains("6 baked"), "{said}");
    let out = here.join("out");
    files(&out).into_iter().map(|name| (name.clone(), std::fs::read(out.join(name)).expect("readable"))).collect()
}

fn same_bytes_on(device: &str) {
    let first = written(device, 1);
    assert_eq!(first.len(), 9, "{:?}", first.keys());
    for threads in [2, 5] {
        let other = written(device, threads);
        assert!(first.keys().eq(other.keys()));
        for (name, bytes) in &first {
            assert!(*bytes == other[name], "{device}: {} differs with {threads} threads", name.display());
        }
    }
}

#[test]
fn devices_agree_within_their_certificates() {
    if !has_device() {
        return;
    }
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    environment(&here.join("lamp.exr"), 0.0);
    for (bake, relative) in [
        (&["bake", "split-sum", "--size", "32", "--encoding", "rg32f"][..], false),
        (&["bake", "albedo", "--size", "32", "--encoding", "r32f", "--ndf", "beckmann"], false),
        (&["env", "lamp.exr", "--size", "16", "--encoding", "rgba32f"], true),
    ] {
        let [one, other] = ["cpu", "auto"].map(|device| {
            let name = format!("{device}.ktx2");
            succeeds(&mut on_any_device(here, &[bake, &["-o", &name, "--device", device]].concat()));
            Ktx2.read(&here.join(name)).expect("readable").0
        });
        // The errors that both files state, which the difference may add up to.
        let stated = |key: &str| -> f64 {
            [&one, &other].map(|t| t.meta.get(key).expect(key).parse::<f64>().expect("a number")).iter().sum()
        };
        assert_ne!(one.meta.get("device"), other.meta.get("device"));
        if relative {
            for (level, (a, b)) in one.levels.iter().zip(&other.levels).enumerate() {
                let squares = a.iter().zip(b).map(|(a, b)| (f64::from(b - a) / f64::from(*a)).powi(2));
                let (rms, most) = ((squares.sum::<f64>() / a.len() as f64).sqrt(), stated("error.relative.rms"));
                assert!(rms <= most, "mip {level}: {rms:e}, and both state {most:e} together");
            }
        } else {
            let worst =
                one.levels[0].iter().zip(&other.levels[0]).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
            // The worst of the texels that were checked; the bound holds for all.
            let most = stated("error.bound");
            assert!(worst > 0.0 && worst <= most, "{bake:?}: {worst:e}, and both state {most:e} together");
        }
    }
}

#[test]
fn threads_do_not_change_what_the_processor_writes() {
    same_bytes_on("cpu");
}

#[test]
fn threads_do_not_change_what_a_device_writes() {
    if has_device() {
        same_bytes_on("auto");
    }
}

#[test]
fn slices_do_not_change_an_environment() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("lamp.exr");
    environment(&path, 0.0);
    let lamp = import::read(&path, &Options::default(), &mut ignore).expect("sound").environment;
    let _alone = DRIVER.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    common::on_gpu(|backend| {
        let Backend::Gpu(gpu) = backend else { unreachable!("it is one") };
        for kernel in ["ggx", "beckmann"] {
            let request = SpecularRequest { kernel: kernel.into(), size: Some(16), ..SpecularRequest::default() };
            let job = request.resolve().expect("sound");
            let prepared = job.prepare(lamp.clone(), None, &mut ignore).expect("nobody cancels");
            let bake = |slice| {
                let limits = Limits { blocks: Some(slice), ..Limits::default() };
                job.on_gpu(&prepared, gpu, limits, &mut ignore).expect("baked")
            };
            let whole = bake(1 << 20);
            assert!(whole.iter().flatten().all(|v| v.is_finite()));
            for slice in [1, 7] {
                assert!(whole == bake(slice), "{kernel}: slices of {slice} blocks change the cube");
            }
        }
    });
}
