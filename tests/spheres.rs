// SPDX-License-Identifier: MIT OR Apache-2.0
//! The preview: both kernels against their f64 twins, the reference against a brute-force sum, the white furnace, goldens.

mod common;

use std::fmt::Write as _;
use std::ops::ControlFlow;

use brdf_baker::Error;
use brdf_baker::axis::Points;
use brdf_baker::bake::specular::SpecularRequest;
use brdf_baker::bake::{Backend, Model, TableRequest};
use brdf_baker::brdf::Brdf;
use brdf_baker::env::sky::Sky;
use brdf_baker::env::{CubeMap, Environment, Equirect, FileAxes, Frame};
use brdf_baker::progress::ignore;
use brdf_baker::quadrature::gauss_legendre::gauss_legendre;
use brdf_baker::spheres::{
    Files, Given, Lut, Maps, Method, Picture, Pictures, Preview, Property, Scene, Seen, Sphere, furnace, upright,
};
use brdf_baker::term::cube::direction;
use rayon::prelude::*;

const METHODS: [Method; 2] = [Method::SplitSum, Method::Reference];
const GOLD: Sphere =
    Sphere { base: [1.0, 0.78, 0.34], metallic: 1.0, roughness: 0.0, f0: 0.04, edge: [0.9, 0.4, -0.3] };
const WHITE: Sphere = Sphere { base: [1.0; 3], metallic: 0.0, roughness: 0.5, f0: 0.04, edge: [0.0; 3] };
const AXES: [Option<Property>; 2] = [Some(Property::Metallic), Some(Property::Roughness)];

fn model(visibility: &str) -> Model {
    Model::parse("ggx", visibility).expect("valid")
}

fn sky() -> Equirect {
    let sky = Sky { sun_disc: true, sun_elevation_deg: 35.0, ..Sky::default() };
    sky.resolve().expect("valid").equirect(128)
}

fn maps(environment: &Environment<'_>, model: &Model) -> Maps {
    Maps::new(Some(environment), Given::default(), model, 64, &Backend::Cpu, &mut ignore).expect("baked")
}

fn rms(a: &Picture, b: &Picture) -> f64 {
    let values = |p: &Picture| p.pixels.iter().flat_map(|p| p[..3].to_vec()).map(f64::from).collect::<Vec<_>>();
    let (a, b) = (values(a), values(b));
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

#[test]
fn kernels_draw_what_their_twins_draw() {
    common::on_gpu(|gpu| {
        let sky = sky();
        let environment = (&sky).into();
        for (ndf, visibility) in [("ggx", "smith"), ("beckmann", "schlick-beckmann"), ("phong", "smith")] {
            let model = Model::parse(ndf, visibility).expect("valid");
            let maps = maps(&environment, &model);
            let scene = Scene::grid((48, 32), [3, 3], AXES, GOLD).expect("valid");
            let frame = Frame::new(false, [20.0, -130.0, 0.0]);
            let preview = Preview { compensate: true, half_vectors: 256, frame, ..Preview::new(scene.clone(), model) };
            for method in METHODS {
                let [drawn, twin] =
                    [gpu, &Backend::Cpu].map(|b| preview.render(method, &maps, b, &mut ignore).expect("drawn"));
                let found = rms(&drawn, &twin);
                println!("{ndf} {visibility} {method:?}: {found:.1e}");
                assert!(found < 1e-5, "{ndf} {visibility} {method:?}: {found}");
                // Pixel by pixel: the sun outshines everything else in a sum.
                let inside = |i: &usize| scene.inside(*i as u32 % 48, *i as u32 / 48, 0.0).is_some();
                let off = |i: usize| {
                    let (a, b) = (drawn.pixels[i], twin.pixels[i]);
                    (0..3).map(|c| f64::from((a[c] - b[c]).abs() / b[c].max(1e-3))).fold(0.0, f64::max)
                };
                let mut off: Vec<f64> = (0..48 * 32).filter(inside).map(off).collect();
                off.sort_by(f64::total_cmp);
                assert!(off.len() > 300 && off[off.len() / 2] < 1e-6, "median {} of {}", off[off.len() / 2], off.len());
            }
        }
    });
}

#[test]
fn white_spheres_vanish_in_a_white_room() {
    let room = furnace();
    let environment = (&room).into();
    let check = |backend: &Backend, name: &str| {
        for visibility in ["smith", "smith-uncorrelated", "schlick-ggx"] {
            let model = model(visibility);
            let maps = maps(&environment, &model);
            let scene = Scene::grid((80, 80), [5, 5], AXES, WHITE).expect("valid");
            let preview = Preview { compensate: true, ..Preview::new(scene.clone(), model) };
            for method in METHODS {
                let picture = preview.render(method, &maps, backend, &mut ignore).expect("drawn");
                // Next to the horizon the albedo is steeper than a table between two texels.
                let least = if method == Method::SplitSum { 0.0 } else { 0.1 };
                let inside = |i: &usize| scene.inside(*i as u32 % 80, *i as u32 / 80, least).is_some();
                let far = |i: usize| picture.pixels[i][..3].iter().map(|v| (v - 1.0).abs()).fold(0.0, f32::max);
                let worst = (0..80 * 80).filter(inside).map(far).fold(0.0, f32::max);
                println!("{name} {visibility} {method:?}: {worst:.1e}");
                assert!(worst < 1e-3, "{name} {visibility} {method:?}: {worst}");
            }
        }
    };
    common::on_gpu(|gpu| check(gpu, "gpu"));
    check(&Backend::Cpu, "cpu");
}

#[test]
fn without_compensation_rough_metals_are_dark() {
    let room = furnace();
    let model = model("smith");
    let maps = maps(&(&room).into(), &model);
    let scene = Scene::grid((32, 32), [1, 1], [None; 2], Sphere { metallic: 1.0, roughness: 1.0, ..WHITE });
    let preview = Preview::new(scene.expect("valid"), model);
    let picture = preview.render(Method::SplitSum, &maps, &Backend::Cpu, &mut ignore).expect("drawn");
    // 1 − ln 2 = 0.307 in the middle.
    let middle = picture.pixels[16 * 32 + 16][1];
    assert!((0.30..0.33).contains(&middle), "{middle}");
}

/// ∫ f L (n·l) over every texel of a cube by 4 × 4 Gauss points, for a view along +Z.
fn brute_force(light: &CubeMap, brdf: &Brdf, n: [f64; 3], Sphere { base: f0, edge, .. }: Sphere) -> [f64; 3] {
    let nodes = gauss_legendre(4);
    let size = light.size;
    // About n, with v in the plane of x.
    let sin_v = (1.0 - n[2] * n[2]).sqrt();
    let (z, v) = (n, [sin_v, 0.0, n[2]]);
    let x = if sin_v > 1e-9 { [0, 1, 2].map(|i| ([0.0, 0.0, 1.0][i] - n[2] * n[i]) / sin_v) } else { [1.0, 0.0, 0.0] };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    (0..6 * size * size)
        .into_par_iter()
        .map(|i| {
            let (face, row, column) = (i / (size * size), i / size % size, i % size);
            let mut sum = [0.0; 3];
            for a in &nodes {
                for b in &nodes {
                    let at = |i: u32, node: f64| 2.0 * (f64::from(i) + 0.5 + 0.5 * node) / f64::from(size) - 1.0;
                    let (s, t) = (at(column, a.x), at(row, b.x));
                    let length2 = 1.0 + s * s + t * t;
                    let d = direction(face, s, t).map(|c| c / length2.sqrt());
                    let l = [dot(d, x), dot(d, y), dot(d, z)];
                    let weight = a.weight * b.weight / f64::from(size * size) * length2.powf(-1.5);
                    let value = weight * brdf.reflected(l, v);
                    let v_dot_h = (0.5 * (1.0 + dot(l, v))).max(0.0).sqrt();
                    let schlick = (1.0 - v_dot_h).powi(5);
                    for c in 0..3 {
                        let f = f0[c] + (1.0 - f0[c]) * schlick - edge[c] * v_dot_h * (1.0 - v_dot_h) * schlick;
                        sum[c] += value * f * f64::from(light.texel(face, column, row)[c]);
                    }
                }
            }
            sum
        })
        .reduce(|| [0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
}

#[test]
fn reference_is_the_integral() {
    // Soft light, two small lamps of 500 times its radiance. The preview reads a fine cube, the sum a coarse one: the same
    // function.
    let coarse = CubeMap::from_fn(32, |[x, y, z]| {
        let lamp = if z > 0.99 && (x - 0.4).abs() < 0.04 && (y - 0.3).abs() < 0.04 { 500.0 } else { 0.0 };
        let other = if x < -0.99 && (y - 0.6).abs() < 0.04 && (z - 0.6).abs() < 0.04 { 500.0 } else { 0.0 };
        [1.0 + 0.5 * y as f32 + lamp, 1.0 + other, 1.0]
    });
    let environment = (&coarse).into();
    for (ndf, visibility, bound) in [("ggx", "smith", 0.015), ("beckmann", "cook-torrance", 0.02)] {
        let model = Model::parse(ndf, visibility).expect("valid");
        let maps = maps(&environment, &model);
        for roughness in [0.3, 0.5, 0.8] {
            let brdf = Brdf::new(model.ndf, model.visibility, roughness).expect("a lobe");
            let sphere = Sphere { roughness, ..GOLD };
            let scene = Scene::grid((16, 16), [1, 1], [None; 2], sphere).expect("valid");
            let preview = Preview::new(scene.clone(), model);
            let picture = preview.render(Method::Reference, &maps, &Backend::Cpu, &mut ignore).expect("drawn");
            let (mut squares, mut of_squares) = (0.0, 0.0);
            for (x, y) in [(8, 8), (10, 5), (4, 6), (8, 12), (12, 9), (9, 6), (7, 3)] {
                let Seen::Sphere(0, n) = scene.at(f64::from(x) + 0.5, f64::from(y) + 0.5) else {
                    panic!("({x}, {y}) is inside of the sphere")
                };
                let expected = brute_force(&coarse, &brdf, n, sphere);
                let found = picture.pixels[(y * 16 + x) as usize];
                for c in 0..3 {
                    squares += (f64::from(found[c]) - expected[c]).powi(2);
                    of_squares += expected[c].powi(2);
                }
            }
            let found = (squares / of_squares).sqrt();
            println!("{ndf} {visibility} roughness {roughness}: {found:.1e}");
            assert!(found < bound, "{ndf} {visibility} roughness {roughness}: {found}");
        }
    }
}

#[test]
fn more_half_vectors_change_little() {
    let sky = sky();
    let model = model("smith");
    let maps = maps(&(&sky).into(), &model);
    // Sphere by sphere: mirrors need no half vectors, and in a sum their sun would hide all else.
    for (roughness, bound) in [(0.25, 0.02), (0.5, 0.07), (1.0, 0.06)] {
        let sphere = Sphere { roughness, ..GOLD };
        let scene = Scene::grid((20, 20), [1, 1], [None; 2], sphere).expect("valid");
        let draw = |half_vectors| {
            let preview = Preview { half_vectors, ..Preview::new(scene.clone(), model) };
            preview.render(Method::Reference, &maps, &Backend::Cpu, &mut ignore).expect("drawn")
        };
        let found = draw(2048).differences(&draw(7680), &scene)[0].rms;
        println!("roughness {roughness}, 2048 against 7680 half vectors: {found:.1e}");
        assert!(found < bound, "{found}");
    }
}

/// The mirror of a room whose walls have six colours shows each where it is.
#[test]
fn the_mirror_shows_what_is_where() {
    let walls = CubeMap::from_fn(16, |[x, y, z]| {
        let largest = x.abs().max(y.abs()).max(z.abs());
        match () {
            _ if x == largest => [1.0, 0.0, 0.0],
            _ if -x == largest => [0.0, 1.0, 1.0],
            _ if y == largest => [0.0, 1.0, 0.0],
            _ if -y == largest => [1.0, 0.0, 1.0],
            _ if z == largest => [0.0, 0.0, 1.0],
            _ => [1.0, 1.0, 0.0],
        }
    });
    let model = model("smith");
    let maps = maps(&(&walls).into(), &model);
    let scene = Scene::grid((96, 96), [1, 1], [None; 2], Sphere { metallic: 1.0, roughness: 0.0, ..WHITE });
    let preview = Preview::new(scene.expect("valid"), model);
    for method in METHODS {
        let picture = preview.render(method, &maps, &Backend::Cpu, &mut ignore).expect("drawn");
        let at = |x: usize, y: usize| picture.pixels[y * 96 + x];
        let is = |pixel: [f32; 4], colour: [f32; 3]| {
            (0..3).all(|c| (pixel[c] - colour[c]).abs() < 0.05) || panic!("{method:?}: {pixel:?} is not {colour:?}")
        };
        // A normal at 45° mirrors the view to the side: at 0.707 of the radius of 44 pixels.
        is(at(48, 48), [0.0, 0.0, 1.0]);
        is(at(48 + 31, 48), [1.0, 0.0, 0.0]);
        is(at(48 - 31, 48), [0.0, 1.0, 1.0]);
        is(at(48, 48 - 31), [0.0, 1.0, 0.0]);
        is(at(48, 48 + 31), [1.0, 0.0, 1.0]);
    }
}

#[test]
fn textures_lie_where_they_should() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    // Red west of the middle, green east of it; normals that lean east everywhere.
    let half = |x: u32, _| if x < 8 { image::Rgb([255, 0, 0]) } else { image::Rgb([0, 255, 0]) };
    image::RgbImage::from_fn(16, 8, half).save(path("base.png")).expect("saved");
    image::RgbImage::from_pixel(4, 4, image::Rgb([128, 128, 255])).save(path("flat.png")).expect("saved");
    image::RgbImage::from_pixel(4, 4, image::Rgb([218, 128, 218])).save(path("east.png")).expect("saved");
    let room = CubeMap::from_fn(16, |[x, ..]| [1.0, 1.0, if x > 0.0 { 2.0 } else { 1.0 }]);
    let model = model("smith");
    let maps = maps(&(&room).into(), &model);
    let draw = |base: Option<&str>, normal: Option<&str>| {
        let (base, normal) = (base.map(path), normal.map(path));
        let files = Files { base_color: base.as_deref(), normal: normal.as_deref(), metallic: None, roughness: None };
        let scene = Scene::grid((64, 64), [1, 1], [None; 2], WHITE).expect("valid");
        let pictures = Pictures::read(&files, 30.0).expect("read");
        let preview = Preview { pictures, ..Preview::new(scene, model) };
        preview.render(Method::SplitSum, &maps, &Backend::Cpu, &mut ignore).expect("drawn")
    };
    let painted = draw(Some("base.png"), None);
    let at = |picture: &Picture, x: usize| picture.pixels[32 * 64 + x];
    assert!(at(&painted, 22)[0] > 0.5 && at(&painted, 22)[1] < 0.2, "west is red: {:?}", at(&painted, 22));
    assert!(at(&painted, 42)[1] > 0.5 && at(&painted, 42)[0] < 0.2, "east is green: {:?}", at(&painted, 42));
    let plain = draw(None, None);
    assert!(rms(&draw(None, Some("flat.png")), &plain) < 0.01, "a flat normal map changes nothing");
    let leaning = draw(None, Some("east.png"));
    assert!(at(&leaning, 32)[2] > 1.1 * at(&plain, 32)[2], "normals that lean east see more of +X");
}

/// A texture of one roughness is that roughness, a ramp is the same on the GPU and in f64, and by both methods.
#[test]
fn reference_takes_textures_of_roughness() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    image::GrayImage::from_pixel(4, 4, image::Luma([128])).save(path("even.png")).expect("saved");
    image::GrayImage::from_fn(32, 4, |x, _| image::Luma([8 * x as u8])).save(path("ramp.png")).expect("saved");
    let sky = Sky::default().resolve().expect("valid").equirect(64);
    let model = model("smith");
    let maps = maps(&(&sky).into(), &model);
    let draw = |file: Option<&str>, roughness: f64, method: Method, half_vectors: u32, backend: &Backend| {
        let file = file.map(path);
        let files = Files { roughness: file.as_deref(), ..Files::default() };
        let sphere = Sphere { roughness, ..GOLD };
        let scene = Scene::grid((32, 32), [1, 1], [None; 2], sphere).expect("valid");
        let pictures = Pictures::read(&files, 15.0).expect("read");
        let preview = Preview { pictures, half_vectors, ..Preview::new(scene, model) };
        preview.render(method, &maps, backend, &mut ignore).expect("drawn")
    };
    // At one of the roughnesses that are integrated, and half way to the next.
    for (roughness, bound) in [(0.5, 1e-6), (0.5078125, 2e-3)] {
        let number = draw(None, roughness, Method::Reference, 2048, &Backend::Cpu);
        let texture = draw(Some("even.png"), roughness * 255.0 / 128.0, Method::Reference, 4096, &Backend::Cpu);
        let found = rms(&texture, &number);
        println!("texture against number {roughness}: {found:.1e}");
        assert!(found < bound, "{roughness}: {found}");
    }
    // The ramp is 0 at the back and next to 1 in front of it: no single roughness.
    let ramp = draw(Some("ramp.png"), 1.0, Method::Reference, 1024, &Backend::Cpu);
    let number = draw(None, 0.5, Method::Reference, 1024, &Backend::Cpu);
    assert!(rms(&ramp, &number) > 0.05, "{}", rms(&ramp, &number));
    common::on_gpu(|gpu| {
        let found = rms(&draw(Some("ramp.png"), 1.0, Method::Reference, 1024, gpu), &ramp);
        println!("ramp on the gpu: {found:.1e}");
        assert!(found < 1e-5, "{found}");
    });
}

/// Other axes, rows and channels of a table, and other axes of a cube, give the same picture.
#[test]
fn conventions_of_files_are_honoured() {
    // Without the sun, which would outshine what a texel's shift changes.
    let sky = Sky::default().resolve().expect("valid").equirect(64);
    let environment: Environment<'_> = (&sky).into();
    let model = model("smith");
    let request = SpecularRequest { size: Some(32), mips: Some(3), ..Default::default() };
    let job = request.resolve().expect("valid");
    let cube = job.run(&environment, &Backend::Cpu, &mut ignore).expect("baked");
    let draw = |cube: &brdf_baker::texture::Texture, request: &TableRequest, frame: Frame| {
        let table = request.resolve().expect("valid").run(&Backend::Cpu, &mut ignore).expect("baked");
        let lut = Lut::new(&table).expect("understood");
        let given = Given { table: Some(&lut), specular: Some(cube), diffuse: None };
        let maps = Maps::new(None, given, &model, 32, &Backend::Cpu, &mut ignore).expect("baked");
        let scene = Scene::grid((48, 48), [3, 3], AXES, GOLD).expect("valid");
        let preview = Preview { frame, ..Preview::new(scene, model) };
        preview.render(Method::SplitSum, &maps, &Backend::Cpu, &mut ignore).expect("drawn")
    };
    let list = |names: &[&str]| Some(names.iter().map(|name| name.to_string()).collect::<Vec<_>>());
    let channels = list(&["scale", "bias", "f82"]);
    let plain = TableRequest { size: (256, 256), channels, ..TableRequest::new("split-sum") };
    let expected = draw(&cube, &plain, Frame::IDENTITY);
    for (axes, points, flip_v, row_shift) in [
        (["roughness", "n_dot_v"], Points::Edges, true, 0),
        (["sqrt_n_dot_v", "roughness"], Points::Centers, true, 1),
        (["alpha", "angle"], Points::Centers, false, 0),
        (["sqrt_one_minus_n_dot_v", "roughness"], Points::Edges, false, 0),
    ] {
        let channels = list(&["f82", "bias", "albedo"]);
        let request = TableRequest { axes: list(&axes), points, flip_v, row_shift, channels, ..plain.clone() };
        let found = rms(&draw(&cube, &request, Frame::IDENTITY), &expected);
        println!("{axes:?}: {found:.1e}");
        assert!(found < 5.5e-4, "{axes:?}: {found}");
    }
    // A quarter of a turn carries texels to texels.
    let turned = Environment { frame: Frame::new(false, [0.0, 90.0, 0.0]), ..environment.borrowed() };
    let baked = job.run(&turned, &Backend::Cpu, &mut ignore).expect("baked");
    let found = rms(&draw(&cube, &plain, turned.frame), &draw(&baked, &plain, Frame::IDENTITY));
    assert!(found < 1e-3, "turned: {found}");
    let axes = FileAxes::parse("-z,y,x").expect("a name");
    let file = Environment { frame: environment.frame.for_file(&axes), ..environment.borrowed() };
    let mut file = job.run(&file, &Backend::Cpu, &mut ignore).expect("baked");
    assert!(rms(&draw(&file, &plain, Frame::IDENTITY), &expected) > 0.1, "the file's axes matter");
    file.meta.set("file-axes", axes.name());
    let found = rms(&draw(&upright(file).expect("understood"), &plain, Frame::IDENTITY), &expected);
    assert!(found < 1e-3, "upright: {found}");
}

#[test]
fn progress_is_shown_and_a_break_ends_the_work() {
    let room = furnace();
    let model = model("smith");
    let maps = maps(&(&room).into(), &model);
    let cancel = |backend: &Backend, method: Method| {
        let scene = Scene::grid((64, 64), [2, 2], AXES, WHITE).expect("valid");
        let mut calls = 0;
        let mut on = |progress: brdf_baker::progress::Progress<'_>| {
            assert!((0.0..=1.0).contains(&progress.done));
            calls += 1;
            if calls == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let result = Preview::new(scene, model).render(method, &maps, backend, &mut on);
        assert!(matches!(result, Err(Error::Cancelled)));
    };
    METHODS.into_iter().for_each(|method| cancel(&Backend::Cpu, method));
    common::on_gpu(|gpu| METHODS.into_iter().for_each(|method| cancel(gpu, method)));
}

/// Mean radiance of every sphere of the usual grid under the sky, by both methods in f64. `BLESS=1` writes it anew.
#[test]
fn spheres_keep_their_means() {
    let sky = sky();
    let model = model("smith");
    let maps = maps(&(&sky).into(), &model);
    let scene =
        Scene::grid((60, 60), [5, 5], AXES, Sphere { base: [0.8, 0.6, 0.35], edge: [0.0; 3], ..GOLD }).expect("valid");
    let preview = Preview { half_vectors: 1024, ..Preview::new(scene.clone(), model) };
    let mut found = String::from("# metallic, roughness: split sum r g b, reference r g b, kcd/m2\n");
    let pictures = METHODS.map(|m| preview.render(m, &maps, &Backend::Cpu, &mut ignore).expect("drawn"));
    for (i, sphere) in scene.spheres.iter().enumerate() {
        write!(found, "{} {}:", sphere.metallic, sphere.roughness).expect("a string");
        for picture in &pictures {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for y in 0..60 {
                for x in (0..60).filter(|x| scene.inside(*x, y, 0.0) == Some(i)) {
                    let pixel = picture.pixels[(y * 60 + x) as usize];
                    (0..3).for_each(|c| sum[c] += f64::from(pixel[c]));
                    count += 1.0;
                }
            }
            sum.iter().for_each(|s| write!(found, " {:.5}", s / count).expect("a string"));
        }
        found.push('\n');
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/spheres.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(path, &found).expect("writable");
    }
    let golden = std::fs::read_to_string(path).expect("tests/golden/spheres.txt exists");
    assert!(golden.len() <= 4096);
    let numbers = |text: &str| -> Vec<f64> {
        text.lines().skip(1).flat_map(|l| l.split([' ', ':'])).filter_map(|n| n.parse().ok()).collect()
    };
    let (found, golden) = (numbers(&found), numbers(&golden));
    assert_eq!((found.len(), golden.len()), (8 * 25, 8 * 25));
    for (i, (found, golden)) in found.iter().zip(&golden).enumerate() {
        assert!((found - golden).abs() <= 1e-4 * golden.max(1.0), "number {i}: {found} {golden}");
    }
}
