// SPDX-License-Identifier: MIT OR Apache-2.0
//! GPU f32 against the same code in f64, under the validation and synchronisation layers.

use brdf_baker::axis::{Axis, Points, Warp};
use brdf_baker::bake::grid::Grid;
use brdf_baker::bake::{At, Backend, Model, TABLES, Table, TableRequest};
use brdf_baker::gpu::Gpu;
use brdf_baker::ndf::{alpha_of, ggx};
use brdf_baker::progress::ignore;
use brdf_baker::shaders::spirv;
use brdf_baker::term::fresnel::{self, Fresnel};
use brdf_baker::term::visibility::{self, Directions, VISIBILITIES};
use brdf_baker::term::{cube, trig, zonal};

mod common;
use common::{ELLIPTIC, FRESNELS, NDFS, Random, on_gpu};

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
fn probe(gpu: &Gpu, shader: &str, function: u32, inputs: &[[f32; 8]]) -> Vec<f32> {
    let kernel = gpu.kernel("probe", &spirv(shader), 2, 12).unwrap();
    let (input, output) =
        (gpu.upload("inputs", inputs).unwrap(), gpu.buffer("outputs", 4 * inputs.len() as u64).unwrap());
    let push = Push { function, count: inputs.len() as u32, echo: 1000 };
    gpu.dispatch(&kernel, &[&input, &output], &push, [inputs.len().div_ceil(64) as u32, 1, 1]).unwrap();
    gpu.read(&output).unwrap()
}

/// A shared function: its number in the probe, its inputs, its twin, and its bound.
struct Term {
    name: &'static str,
    function: u32,
    input: fn(&mut Random) -> [f32; 8],
    twin: fn([f64; 8]) -> f64,
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
fn half_vector(random: &mut Random) -> [f32; 8] {
    let alpha = unit(random);
    let tan = alpha * (6.0 * random.next() - 3.0).exp();
    let cos2 = 1.0 / (1.0 + tan * tan);
    [cos2 as f32, (tan * tan * cos2) as f32, alpha as f32, 0.0, 0.0, 0.0, 0.0, 0.0]
}

/// The fields of `Directions`, in order.
fn directions(random: &mut Random) -> [f32; 8] {
    let (l, v, alpha) = (unit(random), unit(random), unit(random));
    let (v_dot_h, n_dot_h) = (0.5 * (l + v), unit(random));
    [l, v, n_dot_h, v_dot_h, ggx::sigma(l, alpha), ggx::sigma(v, alpha), alpha, 0.0].map(|x| x as f32)
}

/// What the host makes of [`directions`].
fn unpack(x: [f64; 8]) -> Directions {
    let [n_dot_l, n_dot_v, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha, _] = x;
    Directions { n_dot_l, n_dot_v, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha }
}

const TERMS: &[Term] = &[
    Term { name: "d", function: 0, input: half_vector, twin: |x| ggx::d(x[0], x[1], x[2]), worst: 6e-7 },
    Term {
        name: "stretch",
        function: 1,
        input: |r| [unit(r) as f32, unit(r) as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        twin: |x| ggx::stretch(x[0], x[1]),
        worst: 2e-7,
    },
    Term {
        name: "sigma",
        function: 2,
        input: |r| [unit(r) as f32, unit(r) as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        twin: |x| ggx::sigma(x[0], x[1]),
        worst: 2e-7,
    },
    Term {
        name: "sin_quarter",
        function: 4,
        input: |r| [(std::f64::consts::FRAC_PI_2 * unit(r)) as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        twin: |x| trig::sin_quarter(x[0]),
        worst: 2e-7,
    },
    Term {
        name: "atan_unit",
        function: 5,
        input: |r| [unit(r) as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        twin: |x| trig::atan_unit(x[0]),
        worst: 3e-7,
    },
    Term {
        name: "half_acos",
        function: 6,
        input: |r| [(0.999 - 1.998 * unit(r)) as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        twin: |x| trig::half_acos(x[0]),
        worst: 4e-7,
    },
    Term {
        name: "direction",
        function: 7,
        input: |r| {
            let (face, s, t) = ((6.0 * r.next()).floor(), 2.0 * r.next() - 1.0, 2.0 * r.next() - 1.0);
            [face, s, t, (3.0 * r.next()).floor(), 0.0, 0.0, 0.0, 0.0].map(|v| v as f32)
        },
        twin: |x| cube::direction(x[0] as u32, x[1], x[2])[x[3] as usize],
        worst: 0.0,
    },
    Term {
        name: "locate",
        function: 13,
        input: |r| {
            let d = [0; 3].map(|_| 2.0 * r.next() - 1.0);
            [d[0], d[1], d[2], (3.0 * r.next()).floor(), 0.0, 0.0, 0.0, 0.0].map(|v| v as f32)
        },
        twin: |x| {
            let (face, s, t) = cube::locate([x[0], x[1], x[2]]);
            2.0 + [f64::from(face), s, t][x[3] as usize]
        },
        worst: 4e-7,
    },
    Term {
        name: "over_node",
        function: 8,
        input: node,
        twin: |x| zonal::ggx::over_node(x[0], 1.0 - 2.0 * x[0], x[1], x[2], x[3])[0],
        worst: 2e-6,
    },
    Term {
        name: "over_node",
        function: 9,
        input: node,
        twin: |x| zonal::ggx::over_node(x[0], 1.0 - 2.0 * x[0], x[1], x[2], x[3])[1],
        worst: 2e-6,
    },
    Term { name: "room", function: 40, input: place, twin: |x| zonal::ggx::room(x[0], x[1], x[2], x[3]), worst: 2e-6 },
];

/// Squared distance, reach and extent of a node, alpha.
fn place(random: &mut Random) -> [f32; 8] {
    let (away2, alpha) = (4.0 * unit(random), unit(random));
    [away2, 0.1 * random.next(), 0.1 * random.next(), alpha, 0.0, 0.0, 0.0, 0.0].map(|v| v as f32)
}

/// h in [0, ½], share above the horizon, variance of h below h²/8, alpha.
fn node(random: &mut Random) -> [f32; 8] {
    let (h, alpha) = (0.5 * unit(random), unit(random));
    [h, random.next(), 0.1 * h * h * random.next(), alpha, 0.0, 0.0, 0.0, 0.0].map(|v| v as f32)
}

#[test]
fn every_shared_function_is_probed() {
    // The geometry and Fresnel terms have tests of their own, over their registries.
    let probed: Vec<&str> = TERMS.iter().map(|t| t.name).collect();
    for ndf_or_term in ["ndf/ggx", "term/cube", "term/trig", "term/zonal/ggx"] {
        let path = format!("{}/shaders/{ndf_or_term}.glsl", env!("CARGO_MANIFEST_DIR"));
        let source = std::fs::read_to_string(path).unwrap();
        for line in source.lines().filter(|l| l.starts_with("float ") || l.starts_with("vec")) {
            let name = line.split([' ', '(']).nth(1).unwrap();
            assert!(probed.contains(&name), "{ndf_or_term}::{name} is not probed");
        }
    }
}

#[test]
fn shared_functions_agree_with_their_twins() {
    on_gpu(|backend| {
        for term in TERMS {
            let mut random = Random(11);
            let inputs: Vec<[f32; 8]> = (0..PROBES).map(|_| (term.input)(&mut random)).collect();
            let found = probe(vulkan(backend), "probe+smith", term.function, &inputs);
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
fn geometry_terms_agree_with_their_twins() {
    on_gpu(|backend| {
        for v in VISIBILITIES {
            let mut random = Random(12);
            let inputs: Vec<[f32; 8]> = (0..PROBES).map(|_| directions(&mut random)).collect();
            let found = probe(vulkan(backend), &format!("probe+{}", v.file), 10, &inputs);
            let mut worst = 0.0;
            for (x, found) in inputs.iter().zip(&found) {
                let expected = (v.g_over_n_dot_v)(&unpack(x.map(f64::from)));
                // Next to its jump a term may fall on either side of it.
                let jump = v.name == "beckmann-rational"
                    && [x[0], x[1]].iter().any(|n| {
                        (f64::from(*n) / visibility::beckmann_rational::jump(f64::from(x[6])) - 1.0).abs() < 1e-5
                    });
                let error = ((f64::from(*found) - expected) / expected).abs();
                if !jump && (error.is_nan() || error > worst) {
                    worst = error;
                }
            }
            // Two exponentials of up to 20 in the fit; elsewhere a few roundings.
            let bound = if v.name == "charlie" { 2e-5 } else { 1e-6 };
            println!("{}: {worst:.1e} relative on {}", v.name, backend.name());
            assert!(worst <= bound, "{}: {worst:e}, bound {bound:e}", v.name);

            let Some(kinks) = &v.kinks else { continue };
            for (i, function) in [11, 12].into_iter().enumerate() {
                let inputs: Vec<[f32; 8]> = (0..PROBES)
                    .map(|_| {
                        let (tan_h, mu, alpha) =
                            (0.1 / unit(&mut random), 0.999 * unit(&mut random), unit(&mut random));
                        [tan_h, mu, (1.0 - mu * mu).sqrt(), alpha, 0.0, 0.0, 0.0, 0.0].map(|x| x as f32)
                    })
                    .collect();
                for (x, found) in
                    inputs.iter().zip(probe(vulkan(backend), &format!("probe+{}", v.file), function, &inputs))
                {
                    let y = x.map(f64::from);
                    let expected = (kinks.azimuth)(y[0], y[1], y[2], y[3])[i];
                    // A panel's end may be off by this without a trace in the table.
                    let error = (f64::from(found) - expected).abs();
                    assert!(error <= 1e-4 + 1e-5 * expected.abs(), "{} {y:?}: {found}, {expected}", v.name);
                }
            }
        }
    });
}

#[test]
fn fresnel_terms_agree_with_their_twins() {
    on_gpu(|backend| {
        for text in FRESNELS {
            let fresnel = Fresnel::parse(text).unwrap();
            let fresnel::Optics { eta, k, .. } = fresnel.optics;
            // From inside, the cosine of the critical angle comes from the host.
            let on_device = fresnel.kink().map_or(k, |critical| [critical, 0.0, 0.0]);
            let shader = format!("probe_fresnel+{}", fresnel.term.file.unwrap());
            let mut random = Random(13);
            let inputs: Vec<[f32; 8]> = (0..PROBES)
                .map(|_| {
                    let c = [random.next(), unit(&mut random)][usize::from(random.next() < 0.5)];
                    let [a, b, d] = on_device;
                    [c, eta[0], eta[1], eta[2], a, b, d, 0.0].map(|x| x as f32)
                })
                .collect();
            for (i, bound) in [0.0, 6e-7, 6e-7, 6e-7].into_iter().enumerate() {
                let found = probe(vulkan(backend), &shader, i as u32, &inputs);
                let mut worst = 0.0;
                for (x, found) in inputs.iter().zip(&found) {
                    let x = x.map(f64::from);
                    let optics = fresnel::Optics { eta: [x[1], x[2], x[3]], k: [x[4], x[5], x[6]], given: [0.0; 2] };
                    let expected = (fresnel.term.weights)(x[0], &optics)[i];
                    let error = (f64::from(*found) - expected).abs();
                    // Next to the critical angle a reflectance is as steep as a root.
                    let steep = fresnel.kink().map_or(0.0, |vc| 3e-7 / (x[0] - vc).abs().max(1e-7).sqrt());
                    if error.is_nan() || error - steep > worst {
                        worst = error - steep;
                    }
                }
                println!("{text} {i}: {worst:.1e} on {}", backend.name());
                assert!(worst <= bound, "{text} {i}: {worst:e}, bound {bound:e}");
            }
            if fresnel.kink().is_none() {
                continue;
            }
            let inputs: Vec<[f32; 8]> = (0..PROBES)
                .map(|_| {
                    let (tan_h, mu) = (0.1 / unit(&mut random), 0.999 * unit(&mut random));
                    [tan_h, eta[0], 0.0, 0.0, on_device[0], 0.0, mu, (1.0 - mu * mu).sqrt()].map(|x| x as f32)
                })
                .collect();
            for (x, found) in inputs.iter().zip(probe(vulkan(backend), &shader, 4, &inputs)) {
                let x = x.map(f64::from);
                let optics = fresnel::Optics { eta: [x[1]; 3], ..fresnel::Optics::NONE };
                let expected = fresnel::internal::fresnel_kink(x[0], x[6], x[7], &optics);
                let error = (f64::from(found) - expected).abs();
                assert!(error <= 1e-4 + 1e-5 * expected.abs(), "{x:?}: {found}, {expected}");
            }
        }
    });
}

#[test]
fn every_fresnel_term_agrees_with_its_twin() {
    on_gpu(|backend| {
        for text in FRESNELS {
            for (ndf, visibility) in [("ggx", "smith"), ("ggx", "cook-torrance"), ("beckmann", "smith")] {
                let request = TableRequest {
                    ndf: ndf.into(),
                    visibility: visibility.into(),
                    fresnel: Some(Fresnel::parse(text).unwrap()),
                    size: (32, 24),
                    ..TableRequest::new("albedo")
                };
                agrees(&request, backend);
            }
        }
    });
}

#[test]
fn anisotropic_lobes_agree_with_their_twins() {
    on_gpu(|backend| {
        for ndf in ELLIPTIC {
            for visibility in VISIBILITIES.iter().filter(|v| v.kinks.is_none()) {
                for points in [Points::Centers, Points::Edges] {
                    let request = TableRequest {
                        ndf: ndf.into(),
                        visibility: visibility.name.into(),
                        size: (16, 12),
                        points,
                        ..TableRequest::new("split-sum")
                    };
                    agrees(&request, backend);
                }
            }
        }
    });
}

#[test]
fn companions_agree_with_their_twins() {
    on_gpu(|backend| {
        let all = |names: &[&str]| Some(names.iter().map(|name| name.to_string()).collect::<Vec<_>>());
        for (channels, axes) in
            [(["scale", "cloth"], ["n_dot_v", "roughness"]), (["cloth", "disney-diffuse"], ["alpha", "sqrt_n_dot_v"])]
        {
            let request = TableRequest {
                size: (32, 24),
                channels: all(&channels),
                axes: all(&axes),
                ..TableRequest::new("split-sum")
            };
            agrees(&request, backend);
        }
    });
}

/// The table that a device bakes is the twin's, to the bounds of the job.
fn agrees(request: &TableRequest, backend: &Backend) {
    let job = request.resolve().unwrap();
    let what = format!("{} {} {}", job.model.ndf, job.model.visibility.name, job.model.fresnel);
    let tolerance = job.loosest();
    let texture = job.run(backend, &mut ignore).unwrap();
    let (width, height) = job.size();
    let mut errors = vec![];
    for y in 0..height {
        for x in 0..width {
            for (found, expected) in texture.texel(0, 0, x, y).iter().zip(job.rule(job.at(x, y))) {
                let error = (f64::from(*found) - expected).abs() / expected.abs().max(1.0);
                assert!(error <= tolerance.worst, "{what} ({x}, {y}): {error:e}");
                errors.push(error);
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let (worst, median) = (errors[errors.len() - 1], errors[errors.len() / 2]);
    println!("{what}: worst {worst:.1e}, median {median:.1e}");
    assert!(median <= 5e-7, "{what}: median {median:e}");
}

#[test]
fn every_model_agrees_with_its_twin() {
    on_gpu(|backend| {
        for text in NDFS {
            for visibility in VISIBILITIES {
                let request = TableRequest {
                    ndf: text.into(),
                    visibility: visibility.name.into(),
                    size: (32, 24),
                    ..TableRequest::new("split-sum")
                };
                agrees(&request, backend);
            }
        }
    });
}

#[test]
fn push_block_is_echoed() {
    on_gpu(|backend| {
        let found = probe(vulkan(backend), "probe+smith", 99, &[[0.0; 8]; 3]);
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
        // Glass and weights of Schlick's term have tests of their own, tests/energy.rs and tests/rings.rs; others have no
        // kernel.
        let own = |t: &&&dyn Table| {
            ["glass", "glass-average", "schlick-weight"].contains(&t.facts().name) || t.usual().on_processor
        };
        for table in TABLES.iter().filter(|t| !own(t)) {
            for visibility in VISIBILITIES.iter().filter(|v| v.smith) {
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
        let axis = Axis { warp: Warp::NDotV, points: Points::Centers, len: 48, reversed: false, shift: 0 };
        let places = axis.coordinates();
        let bake = |[ndf, visibility]: [&str; 2], first_slice| {
            let grid = Grid { stage: "slices", n_dot_v: &places, roughness: &places, first_slice: Some(first_slice) };
            grid.run(backend, &Model::parse(ndf, visibility).unwrap(), &mut ignore).unwrap()
        };
        for model in [["ggx", "smith"], ["beckmann", "smith"], ["ggx", "cook-torrance"]] {
            let whole = bake(model, 48 * 48);
            assert!(whole.iter().all(|v| v.is_finite()));
            for slice in [64, 1000] {
                assert!(whole == bake(model, slice), "{model:?}: slices of {slice} texels change the table");
            }
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
    let broken = gpu.kernel("broken", &spirv("probe+smith"), 1, 12);
    drop(broken);
    assert!(gpu.check_messages().is_err());
    assert!(!gpu.close().is_empty());
}
