//! GPU f32 against the same code in f64, under the validation and synchronisation layers.

use brdf_baker::axis::{Axis, Coordinate, Points};
use brdf_baker::bake::grid::Grid;
use brdf_baker::bake::{At, Backend, Model, TABLES, TableRequest};
use brdf_baker::gpu::Gpu;
use brdf_baker::ndf::{alpha_of, ggx};
use brdf_baker::progress::ignore;
use brdf_baker::shaders::spirv;
use brdf_baker::term::visibility::{VISIBILITIES, smith, smith_uncorrelated};
use brdf_baker::term::{cube, fresnel, trig, zonal};

mod common;
use common::{Random, on_gpu};

const PROBES: usize = 4096;

fn vulkan(backend: &Backend) -> &Gpu {
    match backend {
        Backend::Gpu(gpu) => gpu,
        Backend::Cpu => panic!("these tests are for Vulkan devices"),
    }
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    function: u32,
    count: u32,
    echo: u32,
}

/// Values of a shared function on the device.
fn probe(gpu: &Gpu, visibility: &str, function: u32, inputs: &[[f32; 4]]) -> Vec<f32> {
    let kernel = gpu.kernel("probe", spirv(&format!("probe+{visibility}")), 2, 12).unwrap();
    let (input, output) =
        (gpu.upload("inputs", inputs).unwrap(), gpu.buffer("outputs", 4 * inputs.len() as u64).unwrap());
    let push = Push { function, count: inputs.len() as u32, echo: 1000 };
    gpu.dispatch(&kernel, &[&input, &output], &push, [inputs.len().div_ceil(64) as u32, 1, 1]).unwrap();
    gpu.read(&output).unwrap()
}

/// A shared function: its number in the probe, its inputs, its twin, and its bound.
struct Term {
    name: &'static str,
    visibility: &'static str,
    function: u32,
    input: fn(&mut Random) -> [f32; 4],
    twin: fn([f64; 4]) -> f64,
    /// Worst error relative to the value.
    worst: f64,
}

/// A number in (0, 1] that crowds towards 0, or one of the ends.
fn unit(random: &mut Random) -> f64 {
    match (random.next() * 20.0) as u32 {
        0 => 1.0,
        1 => 1.0 / 1024.0,
        _ => (-7.0 * random.next()).exp(),
    }
}

/// cos² and sin² of a half vector near the peak of a lobe of width alpha, and alpha.
fn half_vector(random: &mut Random) -> [f32; 4] {
    let alpha = unit(random);
    let tan = alpha * (6.0 * random.next() - 3.0).exp();
    let cos2 = 1.0 / (1.0 + tan * tan);
    [cos2 as f32, (tan * tan * cos2) as f32, alpha as f32, 0.0]
}

/// n·l, n·v and the projected areas towards both.
fn directions(random: &mut Random) -> [f32; 4] {
    let (l, v, alpha) = (unit(random), unit(random), unit(random));
    [l as f32, v as f32, ggx::sigma(l, alpha) as f32, ggx::sigma(v, alpha) as f32]
}

const TERMS: &[Term] = &[
    Term {
        name: "d",
        visibility: "smith",
        function: 0,
        input: half_vector,
        twin: |x| ggx::d(x[0], x[1], x[2]),
        worst: 6e-7,
    },
    Term {
        name: "stretch",
        visibility: "smith",
        function: 1,
        input: |r| [unit(r) as f32, unit(r) as f32, 0.0, 0.0],
        twin: |x| ggx::stretch(x[0], x[1]),
        worst: 2e-7,
    },
    Term {
        name: "sigma",
        visibility: "smith",
        function: 2,
        input: |r| [unit(r) as f32, unit(r) as f32, 0.0, 0.0],
        twin: |x| ggx::sigma(x[0], x[1]),
        worst: 2e-7,
    },
    Term {
        name: "schlick_weight",
        visibility: "smith",
        function: 3,
        input: |r| [unit(r) as f32, 0.0, 0.0, 0.0],
        twin: |x| fresnel::schlick_weight(x[0]),
        worst: 4e-7,
    },
    Term {
        name: "sin_quarter",
        visibility: "smith",
        function: 4,
        input: |r| [(std::f64::consts::FRAC_PI_2 * unit(r)) as f32, 0.0, 0.0, 0.0],
        twin: |x| trig::sin_quarter(x[0]),
        worst: 2e-7,
    },
    Term {
        name: "atan_unit",
        visibility: "smith",
        function: 5,
        input: |r| [unit(r) as f32, 0.0, 0.0, 0.0],
        twin: |x| trig::atan_unit(x[0]),
        worst: 3e-7,
    },
    Term {
        name: "smith",
        visibility: "smith",
        function: 6,
        input: directions,
        twin: |x| smith::g_over_n_dot_v(x[0], x[1], x[2], x[3]),
        worst: 5e-7,
    },
    Term {
        name: "smith_uncorrelated",
        visibility: "smith_uncorrelated",
        function: 6,
        input: directions,
        twin: |x| smith_uncorrelated::g_over_n_dot_v(x[0], x[1], x[2], x[3]),
        worst: 3e-7,
    },
    Term {
        name: "direction",
        visibility: "smith",
        function: 7,
        input: |r| {
            [(6.0 * r.next()).floor(), 2.0 * r.next() - 1.0, 2.0 * r.next() - 1.0, (3.0 * r.next()).floor()]
                .map(|v| v as f32)
        },
        twin: |x| cube::direction(x[0] as u32, x[1], x[2])[x[3] as usize],
        worst: 0.0,
    },
    Term {
        name: "over_node",
        visibility: "smith",
        function: 8,
        input: node,
        twin: |x| zonal::ggx::over_node(x[0], 1.0 - 2.0 * x[0], x[1], x[2], x[3])[0],
        worst: 2e-6,
    },
    Term {
        name: "over_node",
        visibility: "smith",
        function: 9,
        input: node,
        twin: |x| zonal::ggx::over_node(x[0], 1.0 - 2.0 * x[0], x[1], x[2], x[3])[1],
        worst: 2e-6,
    },
];

/// h in [0, ½], share above the horizon, variance of h below h²/8, alpha.
fn node(random: &mut Random) -> [f32; 4] {
    let (h, alpha) = (0.5 * unit(random), unit(random));
    [h as f32, random.next() as f32, (0.1 * h * h * random.next()) as f32, alpha as f32]
}

#[test]
fn every_shared_function_is_probed() {
    // Functions that are probed under another name: the geometry terms share theirs.
    let probed: Vec<&str> = TERMS.iter().map(|t| t.name).collect();
    for ndf_or_term in ["ndf/ggx", "term/cube", "term/fresnel", "term/trig", "term/zonal/ggx"] {
        let path = format!("{}/shaders/{ndf_or_term}.glsl", env!("CARGO_MANIFEST_DIR"));
        let source = std::fs::read_to_string(path).unwrap();
        for line in source.lines().filter(|l| l.starts_with("float ") || l.starts_with("vec")) {
            let name = line.split([' ', '(']).nth(1).unwrap();
            assert!(probed.contains(&name), "{ndf_or_term}::{name} is not probed");
        }
    }
    for visibility in VISIBILITIES {
        assert!(probed.contains(&visibility.file), "{} is not probed", visibility.name);
    }
}

#[test]
fn shared_functions_agree_with_their_twins() {
    on_gpu(|backend| {
        for term in TERMS {
            let mut random = Random(11);
            let inputs: Vec<[f32; 4]> = (0..PROBES).map(|_| (term.input)(&mut random)).collect();
            let found = probe(vulkan(backend), term.visibility, term.function, &inputs);
            let worst = inputs
                .iter()
                .zip(&found)
                .map(|(x, found)| {
                    let expected = (term.twin)(x.map(f64::from));
                    ((f64::from(*found) - expected) / expected).abs()
                })
                .fold(0.0, |a: f64, b| if b <= a { a } else { b });
            println!("{}: {worst:.1e} relative on {}", term.name, backend.name());
            assert!(worst <= term.worst, "{}: {worst:e}, bound {:e}", term.name, term.worst);
        }
    });
}

#[test]
fn push_block_is_echoed() {
    on_gpu(|backend| {
        let found = probe(vulkan(backend), "smith", 99, &[[0.0; 4]; 3]);
        assert_eq!(found, [99.0 + 3.0 + 1000.0; 3]);
    });
}

#[test]
fn unwritten_texels_are_nan() {
    on_gpu(|backend| {
        let gpu = vulkan(backend);
        let buffer = gpu.buffer("fresh", 256).unwrap();
        assert!(gpu.read::<f32>(&buffer).unwrap().iter().all(|v| v.is_nan()));
    });
}

#[test]
fn tables_agree_with_their_twins() {
    on_gpu(|backend| {
        for table in TABLES {
            for visibility in VISIBILITIES {
                for points in [Points::Centers, Points::Edges] {
                    let facts = table.facts();
                    let request = TableRequest {
                        visibility: visibility.name.into(),
                        size: (96, 64),
                        points,
                        ..TableRequest::new(facts.name)
                    };
                    let request =
                        if facts.axes.len() == 1 { TableRequest { size: (256, 1), ..request } } else { request };
                    let job = request.resolve().unwrap();
                    let texture = job.run(backend, &mut ignore).unwrap();
                    let (width, height) = job.size();
                    let mut errors = vec![];
                    for y in 0..height {
                        for x in 0..width {
                            let at = job.at(x, y);
                            for (found, expected) in texture.texel(0, 0, x, y).iter().zip(job.rule(at)) {
                                let error = (f64::from(*found) - expected).abs();
                                assert!(error <= facts.tolerance.at(at), "{} at {at:?}: {error:e}", facts.name);
                                errors.push(error);
                            }
                        }
                    }
                    errors.sort_by(f64::total_cmp);
                    let (worst, median) = (errors[errors.len() - 1], errors[errors.len() / 2]);
                    println!("{} {} {points:?}: worst {worst:.1e}, median {median:.1e}", facts.name, visibility.name);
                    assert!(median <= facts.tolerance.median, "{} {}: median {median:e}", facts.name, visibility.name);
                }
            }
        }
    });
}

#[test]
fn any_slices_give_the_same_bytes() {
    on_gpu(|backend| {
        let axis = Axis { coordinate: Coordinate::NDotV, points: Points::Centers, len: 48, reversed: false };
        let places = axis.coordinates();
        let bake = |first_slice| {
            let grid = Grid {
                stage: "slices",
                n_dot_v: &places,
                roughness: &places,
                channels: 2,
                first_slice: Some(first_slice),
            };
            grid.run(backend, "bake/split_sum+smith", |_, _| unreachable!("on the GPU"), &mut ignore).unwrap()
        };
        let whole = bake(48 * 48);
        assert!(whole.iter().all(|v| v.is_finite()));
        for slice in [64, 1000] {
            assert!(whole == bake(slice), "slices of {slice} texels change the table");
        }
    });
}

#[test]
fn half_floats_are_correctly_rounded() {
    on_gpu(|backend| {
        for points in [Points::Centers, Points::Edges] {
            let job = TableRequest { points, ..TableRequest::new("split-sum") }.resolve().unwrap();
            let texture = job.run(backend, &mut ignore).unwrap();
            let (mut wrong, mut total) = (0, 0);
            for y in 0..256 {
                for x in 0..256 {
                    for (found, exact) in texture.texel(0, 0, x, y).iter().zip(job.rule(job.at(x, y))) {
                        let (found, exact) = (half::f16::from_f32(*found), half::f16::from_f64(exact.clamp(0.0, 1.0)));
                        let ulps = found.to_bits().abs_diff(exact.to_bits());
                        assert!(ulps <= 1, "texel ({x}, {y}) is {ulps} ulp off");
                        wrong += usize::from(ulps != 0);
                        total += 1;
                    }
                }
            }
            println!("{points:?}: {wrong} of {total} halves are not the nearest");
            assert!((wrong as f64) < 0.005 * total as f64);
        }
    });
}

#[test]
fn cpu_backend_bakes_the_same_table() {
    on_gpu(|backend| {
        let job = TableRequest { size: (33, 17), ..TableRequest::new("split-sum") }.resolve().unwrap();
        let (gpu, cpu) = (job.run(backend, &mut ignore).unwrap(), job.run(&Backend::Cpu, &mut ignore).unwrap());
        for (a, b) in gpu.levels[0].iter().zip(&cpu.levels[0]) {
            assert!((a - b).abs() <= 1e-6, "{a} on the GPU, {b} on the processor");
        }
    });
}

#[test]
fn axes_and_flip_move_texels_and_change_none() {
    let bake = |axes: [&str; 2], size, flip_v| {
        let axes = Some(axes.map(String::from).to_vec());
        let job = TableRequest { size, axes, flip_v, ..TableRequest::new("split-sum") }.resolve().unwrap();
        (job.run(&Backend::Cpu, &mut ignore).unwrap(), job)
    };
    let (plain, job) = bake(["n_dot_v", "roughness"], (8, 4), false);
    let (turned, turned_job) = bake(["roughness", "n_dot_v"], (4, 8), false);
    let (flipped, _) = bake(["n_dot_v", "roughness"], (8, 4), true);
    for y in 0..4 {
        for x in 0..8 {
            assert_eq!(plain.texel(0, 0, x, y), turned.texel(0, 0, y, x));
            assert_eq!(plain.texel(0, 0, x, y), flipped.texel(0, 0, x, 3 - y));
            assert_eq!(job.at(x, y), turned_job.at(y, x));
        }
    }
    assert_eq!(job.at(0, 0), At { n_dot_v: 0.0625, roughness: 0.125 });
    assert_eq!(alpha_of(0.5), 0.25);
    assert!(Model::parse("ggx", "smith").is_ok());
}

#[test]
fn validation_layer_is_listening() {
    let Some(gpu) = common::gpu() else { return };
    // The probe uses two buffers; a layout with one is a mistake that the layer must report.
    let broken = gpu.kernel("broken", spirv("probe+smith"), 1, 12);
    drop(broken);
    assert!(gpu.check_messages().is_err());
    assert!(!gpu.close().is_empty());
}
