//! Filtered environments: orientation, energy, white furnace, and every mip against a brute-force f64 sum.

use brdf_baker::Error;
use brdf_baker::bake::Backend;
use brdf_baker::bake::specular::{SpecularJob, SpecularRequest};
use brdf_baker::env::Equirect;
use brdf_baker::env::orientation::locate;
use brdf_baker::progress::ignore;
use brdf_baker::texture::Texture;
use brdf_baker::verify::cube::mean;
use brdf_baker::verify::environment::{Extent, check};

mod common;
use common::{Random, on_gpu};

fn job(size: u32, law: &str) -> SpecularJob {
    SpecularRequest { size, roughness_law: law.into(), ..SpecularRequest::default() }.resolve().unwrap()
}

fn baked(job: &SpecularJob, source: &Equirect, backend: &Backend) -> Texture {
    job.run(source, backend, &mut ignore).unwrap()
}

/// A sky with a sun of 50,000 times its radiance over dark ground.
fn sun_sky(height: u32) -> Equirect {
    Equirect::from_fn(height, |u, v| {
        let [x, y, z] = Equirect::direction(u, v);
        let sun = 0.6 * x + 0.64 * y + 0.48 * z;
        let disc = if sun > (0.4f64).to_radians().cos() { 50_000.0 } else { 0.0 };
        if y > 0.0 { [0.5 + disc, 0.7 + disc, 1.0 + 0.8 * disc] } else { [0.2, 0.17, 0.12] }
    })
}

/// Dim coloured noise a texel, with lights over four orders of magnitude.
fn room(height: u32) -> Equirect {
    let mut random = Random(3);
    let mut direction = || {
        let d = [random.next() - 0.5, random.next() - 0.5, random.next() - 0.5];
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        (d.map(|x| x / length), (0.01 + 0.05 * random.next()).cos(), 10f32.powf(4.0 * random.next() as f32))
    };
    let lights: Vec<_> = (0..12).map(|_| direction()).collect();
    let mut noise = Random(4);
    Equirect::from_fn(height, |u, v| {
        let d = Equirect::direction(u, v);
        for (axis, edge, power) in &lights {
            if d.iter().zip(axis).map(|(a, b)| a * b).sum::<f64>() > *edge {
                return [*power, 0.8 * power, 0.5 * power];
            }
        }
        [0.0; 3].map(|_: f32| 0.05 + 0.1 * noise.next() as f32)
    })
}

/// Grey, with single bright texels at the pole and on both sides of the wrap seam.
fn pole_and_seam(height: u32) -> Equirect {
    let mut source = Equirect::from_fn(height, |_, _| [0.1; 3]);
    let width = source.width as usize;
    for texel in [width / 5, 100 * width, 100 * width + width - 1] {
        source.texels[texel] = [20_000.0, 10_000.0, 5_000.0];
    }
    source
}

#[test]
fn coloured_lights_are_seen_where_they_are() {
    // One colour an axis, in the order of the faces.
    let colours: [[f32; 3]; 6] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
    let source = Equirect::from_fn(64, |u, v| colours[locate(Equirect::direction(u, v)).0 as usize]);
    // The documented places of the axes in the picture, not through the code that is tested.
    for (u, v, face) in [(0.5, 0.5, 0), (0.0, 0.5, 1), (0.3, 0.0, 2), (0.3, 1.0, 3), (0.75, 0.5, 4), (0.25, 0.5, 5)] {
        let (x, y) = (((u * 128.0) as usize).min(127), ((v * 64.0) as usize).min(63));
        assert_eq!(source.texels[y * 128 + x], colours[face], "the picture at ({u}, {v})");
    }
    let cube = baked(&job(16, "linear"), &source, &Backend::Cpu);
    for face in 0..6 {
        for mip in 0..3 {
            let middle = cube.level_size(mip).0 / 2;
            let texel = cube.texel(mip, face, middle, middle);
            let colour = colours[face as usize];
            assert!(texel.iter().zip(colour).all(|(t, c)| (t - c).abs() < 0.4), "face {face}, mip {mip}: {texel:?}");
        }
    }
}

#[test]
fn faces_have_the_axes_of_the_vulkan_specification() {
    // Red grows along +X, green along +Y, blue along +Z.
    let source = Equirect::from_fn(128, |u, v| Equirect::direction(u, v).map(|c| 0.5 + 0.5 * c as f32));
    let cube = baked(&job(8, "linear"), &source, &Backend::Cpu);
    // From Vulkan's table of cube map face selection: (s axis, t axis) as signed channel numbers from 1.
    let axes: [(i32, i32); 6] = [(-3, -2), (3, -2), (1, 3), (1, -3), (1, -2), (-1, -2)];
    for (face, (s, t)) in axes.into_iter().enumerate() {
        let along = |axis: i32, from: &[f32], to: &[f32]| {
            let channel = axis.unsigned_abs() as usize - 1;
            assert!((to[channel] - from[channel]) * axis as f32 > 0.0, "face {face}, axis {axis}: {from:?} to {to:?}");
        };
        let texel = |x, y| cube.texel(0, face as u32, x, y);
        along(s, texel(0, 4), texel(7, 4));
        along(t, texel(4, 0), texel(4, 7));
    }
}

#[test]
fn white_stays_white() {
    let white = Equirect::from_fn(32, |_, _| [0.25, 1.0, 7.0]);
    let check = |backend: &Backend| {
        for law in ["linear", "quadratic"] {
            for (mip, level) in baked(&job(64, law), &white, backend).levels.iter().enumerate() {
                for texel in level.chunks_exact(3) {
                    for (found, expected) in texel.iter().zip([0.25f32, 1.0, 7.0]) {
                        assert!((found / expected - 1.0).abs() <= 1e-6, "mip {mip}: {texel:?}");
                    }
                }
            }
        }
    };
    check(&Backend::Cpu);
    on_gpu(check);
}

#[test]
fn mip_0_keeps_the_mean_radiance() {
    for (name, source) in [("sun", sun_sky(256)), ("room", room(256)), ("pole and seam", pole_and_seam(256))] {
        let job = SpecularRequest { mips: Some(1), ..SpecularRequest::default() }.resolve().unwrap();
        let found = mean(&baked(&job, &source, &Backend::Cpu), 0);
        for (found, expected) in found.iter().zip(source.mean()) {
            let off = (found / expected - 1.0).abs();
            println!("{name}: mean off by {off:.1e}");
            assert!(off <= 1e-4, "{name}: {found} instead of {expected}");
        }
    }
}

#[test]
fn every_mip_agrees_with_a_brute_force_sum() {
    on_gpu(|backend| {
        for (name, source) in [("sun", sun_sky(256)), ("room", room(256)), ("pole and seam", pole_and_seam(256))] {
            for law in ["linear", "quadratic"] {
                let job = job(256, law);
                let cube = baked(&job, &source, backend);
                let extent = Extent { random: 60, bright: 12 };
                let errors = check(&job, &source, &cube, extent, &mut ignore).unwrap();
                assert_eq!(errors.len(), 8);
                for e in errors {
                    println!("{name} {law}: mip {} rms {:.1e}, max {:.1e} of {} texels", e.mip, e.rms, e.max, e.texels);
                    assert!(e.rms <= 1e-3 && e.max <= 1e-2, "{name} {law}: mip {}: {:e} {:e}", e.mip, e.rms, e.max);
                }
            }
        }
    });
}

#[test]
fn no_texel_is_brighter_than_the_source() {
    let source = sun_sky(128);
    let brightest = source.texels.iter().flatten().copied().fold(0.0, f32::max);
    let cube = baked(&job(64, "linear"), &source, &Backend::Cpu);
    for level in &cube.levels {
        assert!(level.iter().all(|v| *v >= 0.0 && *v <= brightest * 1.000_001));
    }
}

#[test]
fn gpu_agrees_with_its_twin() {
    on_gpu(|backend| {
        let source = room(128);
        for law in ["linear", "quadratic"] {
            let job = job(64, law);
            let (gpu, cpu) = (baked(&job, &source, backend), baked(&job, &source, &Backend::Cpu));
            for mip in 1..gpu.levels.len() {
                let mut errors: Vec<f32> =
                    gpu.levels[mip].iter().zip(&cpu.levels[mip]).map(|(a, b)| (a / b - 1.0).abs()).collect();
                errors.sort_by(f32::total_cmp);
                let (worst, median) = (errors[errors.len() - 1], errors[errors.len() / 2]);
                println!("{law}: mip {mip} worst {worst:.1e}, median {median:.1e}");
                assert!(worst <= 1e-4 && median <= 2e-6, "{law}: mip {mip}: {worst:e} {median:e}");
            }
        }
    });
}

#[test]
fn exposure_by_a_power_of_two_changes_exponents_only() {
    on_gpu(|backend| {
        let source = room(64);
        let mut brighter = source.clone();
        brighter.texels.iter_mut().for_each(|t| *t = t.map(|c| 64.0 * c));
        let (a, b) = (baked(&job(32, "linear"), &source, backend), baked(&job(32, "linear"), &brighter, backend));
        for (a, b) in a.levels.iter().flatten().zip(b.levels.iter().flatten()) {
            assert!((64.0 * a / b - 1.0).abs() <= 1e-6, "{a} became {b}");
        }
    });
}

#[test]
fn too_many_steps_are_an_error_not_a_picture() {
    on_gpu(|backend| {
        let mut job = job(64, "linear");
        job.precision.limit = 100;
        let error = job.run(&room(128), backend, &mut ignore).unwrap_err();
        assert!(matches!(&error, Error::Gpu { detail, .. } if detail.contains("100 steps")), "{error}");
    });
}

#[test]
fn comparator_sees_a_dimmed_and_a_turned_mip() {
    let source = sun_sky(64);
    let job = job(32, "linear");
    let sound = baked(&job, &source, &Backend::Cpu);
    let worst = |cube: &Texture| {
        let errors = check(&job, &source, cube, Extent::SPOT, &mut ignore).unwrap();
        errors.iter().map(|e| e.max).fold(0.0, |a: f64, b| if b <= a { a } else { b })
    };
    assert!(worst(&sound) <= 1e-2);
    let mut dimmed = sound.clone();
    dimmed.levels[2].iter_mut().for_each(|v| *v *= 0.98);
    assert!(worst(&dimmed) > 1e-2);
    let mut turned = sound.clone();
    let face = turned.levels[1].len() / 6;
    turned.levels[1].rotate_right(face);
    assert!(worst(&turned) > 1e-2);
    let mut broken = sound;
    broken.levels[3].iter_mut().for_each(|v| *v = f32::NAN);
    let errors = check(&job, &source, &broken, Extent::SPOT, &mut ignore).unwrap();
    assert!(errors[2].max.is_nan());
}
