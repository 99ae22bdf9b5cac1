// SPDX-License-Identifier: MIT OR Apache-2.0
//! BRDFs of one's own, compiled at run time: against exact tables and independent integration, with their estimates; the
//! laws; what is refused; and the command line.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use brdf_baker::Error;
use brdf_baker::axis::Points;
use brdf_baker::bake::own::{OwnJob, OwnOptions, OwnSource, OwnTable, Precision, usual_most};
use brdf_baker::bake::{At, Backend, Model, TableRequest};
use brdf_baker::glsl;
use brdf_baker::progress::ignore;
use brdf_baker::quadrature::adaptive::{Estimate, integrate};
use brdf_baker::verify::own::check;
use brdf_baker::verify::table::Extent;
use tempfile::TempDir;

mod common;
use common::{Random, on_gpu};

const DOUBLE: OwnOptions = OwnOptions { least_roughness: 0.0, most: 2e-5, precision: Precision::Double };

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/brdf").join(name)
}

fn text(text: &str) -> OwnSource {
    OwnSource::new(Path::new("my.glsl"), text).unwrap()
}

/// A BRDF that is `body`.
fn whole(body: &str) -> OwnSource {
    text(&format!("vec3 brdf(vec3 l, vec3 v, float alpha) {{ {body} }}"))
}

fn request(table: &str, size: (u32, u32)) -> TableRequest {
    TableRequest { size, ..TableRequest::new(table) }
}

fn bake(backend: &Backend, request: &TableRequest, source: OwnSource, options: OwnOptions) -> Result<OwnTable, Error> {
    OwnJob::new(request, source, options, backend, &mut ignore)?.run(&mut ignore)
}

/// Bakes and compares each texel with `truth`, which is itself within `truth_error`: no texel is off by more than its own
/// estimate, and none of usual width by more than 1e-5. Returns the worst error and the worst estimate.
fn compare(
    backend: &Backend,
    request: &TableRequest,
    source: OwnSource,
    options: OwnOptions,
    truth_error: f64,
    truth: impl Fn(At) -> Vec<f64>,
) -> (f64, f64) {
    compare_where(|_| true, backend, request, source, options, truth_error, truth)
}

/// The same of some texels.
fn compare_where(
    which: impl Fn(At) -> bool,
    backend: &Backend,
    request: &TableRequest,
    source: OwnSource,
    options: OwnOptions,
    truth_error: f64,
    truth: impl Fn(At) -> Vec<f64>,
) -> (f64, f64) {
    let name = source.name();
    let job = OwnJob::new(request, source, options, backend, &mut ignore).unwrap();
    let table = job.run(&mut ignore).unwrap();
    let (width, height) = job.table().size();
    let (mut worst, mut most) = (0f64, 0f64);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let at = job.table().at(x, y);
        if !which(at) {
            continue;
        }
        let estimate = f64::from(table.estimates.texel(0, 0, x, y)[0]);
        let expected = truth(at);
        assert_eq!(expected.len(), table.texture.channels.len());
        for (found, expected) in table.texture.texel(0, 0, x, y).iter().zip(expected) {
            let scale = expected.abs().max(1.0);
            let error = (f64::from(*found) - expected).abs() / scale;
            // A texel is a single float.
            assert!(
                error <= estimate / scale + truth_error + 6e-8,
                "{name} at {at:?}: {found} instead of {expected}, off by {error:.1e}, estimate {estimate:.1e}"
            );
            // In rows of alpha below 1.6e-5 doubles hold n·h too coarsely for the usual formulas; their estimates say so.
            assert!(error <= 1e-5 || at.roughness < 0.004, "{name} at {at:?}: {error:e}");
            worst = worst.max(error);
        }
        most = most.max(estimate);
    }
    println!("{name}, {} {}: error {worst:.1e}, estimate {most:.1e}", request.table, options.precision.name());
    assert!(worst > 0.0, "{name}: the truth is its own");
    (worst, most)
}

#[test]
fn known_brdfs_agree_with_exact_tables_down_to_narrow_lobes() {
    on_gpu(|backend| {
        for (file, ndf, visibility) in
            [("ggx", "ggx", "smith"), ("blinn_phong", "blinn-phong", "implicit"), ("charlie", "charlie", "neubelt")]
        {
            let model = Model::parse(ndf, visibility).unwrap();
            let source = OwnSource::read(&example(&format!("{file}.glsl"))).unwrap();
            // Row 0 of 256 has alpha 4e-6; no sheen is that narrow, and that of 24 is a thread at the horizon.
            let size = if file == "charlie" { (6, 24) } else { (2, 256) };
            let request = TableRequest {
                channels: Some(names(&["scale", "bias", "albedo", "f82"])),
                ..request("split-sum", size)
            };
            compare(backend, &request, source, DOUBLE, 1e-6, |at| {
                let [e, b, tint, _] = model.rule(at);
                vec![e - b, b, e, tint]
            });
        }
    });
}

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|name| name.to_string()).collect()
}

/// ∫ f (n·l) dω_l over light directions in polar coordinates about the normal, of a BRDF without colours that is kinked at
/// the viewer's angle and at right angles to it, to about 1e-7. Across from a low viewer it may have a peak as narrow as n·v.
fn albedo(n_dot_v: f64, f: impl Fn([f64; 3], [f64; 3]) -> f64) -> f64 {
    let v = [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v];
    let (theta_v, peak) = (v[0].atan2(n_dot_v), (16.0 * n_dot_v).min(1.0));
    let outer = integrate(&[0.0, (1.0 - peak) * theta_v, theta_v, FRAC_PI_2], 1e-7, 400, |theta| {
        let (sin, cos) = theta.sin_cos();
        let inner = integrate(&[0.0, FRAC_PI_2, PI - peak, PI], 2e-8, 400, |phi| {
            let l = [sin * phi.cos(), sin * phi.sin(), cos];
            Estimate { value: [2.0 * f(l, v) * cos * sin], error: 0.0 }
        });
        Estimate { value: inner.value, error: inner.error }
    });
    assert!(outer.error < 3e-7, "{outer:?}");
    outer.value[0]
}

fn oren_nayar(alpha: f64) -> impl Fn([f64; 3], [f64; 3]) -> f64 {
    let s2 = alpha * alpha;
    let (a, b) = (1.0 - 0.5 * s2 / (s2 + 0.33), 0.45 * s2 / (s2 + 0.09));
    move |l: [f64; 3], v: [f64; 3]| (a + b * (l[0] * v[0] + l[1] * v[1]).max(0.0) / l[2].max(v[2])) / PI
}

fn ashikhmin_shirley(alpha: f64) -> impl Fn([f64; 3], [f64; 3]) -> f64 {
    let n = 2.0 / (alpha * alpha) - 2.0;
    move |l: [f64; 3], v: [f64; 3]| {
        let h = brdf_baker::brdf::half(l, v);
        let v_dot_h: f64 = v.iter().zip(h).map(|(v, h)| v * h).sum();
        (n + 1.0) / (8.0 * PI) * h[2].powf(n) / (v_dot_h * l[2].max(v[2]))
    }
}

#[test]
fn kinked_brdfs_agree_with_independent_integration() {
    on_gpu(|backend| {
        let size = (5, 4);
        let request = request("albedo", size);
        let read = |name: &str| OwnSource::read(&example(name)).unwrap();
        compare(backend, &request, read("oren_nayar.glsl"), DOUBLE, 3e-7, |at| {
            vec![albedo(at.n_dot_v, oren_nayar(at.roughness * at.roughness))]
        });
        let clamped = OwnOptions { least_roughness: 0.4, ..DOUBLE };
        compare(backend, &request, read("ashikhmin_shirley.glsl"), clamped, 3e-7, |at| {
            vec![albedo(at.n_dot_v, ashikhmin_shirley(at.roughness.max(0.4).powi(2)))]
        });
    });
}

#[test]
fn low_viewers_see_where_lights_are_as_low() {
    on_gpu(|backend| {
        // n·v from 0.001 up: the kink at n·l = n·v is a strip at the horizon.
        let request = TableRequest { axes: Some(names(&["sqrt_n_dot_v", "roughness"])), ..request("albedo", (16, 3)) };
        let read = |name: &str| OwnSource::read(&example(name)).unwrap();
        let low = |at: At| at.n_dot_v < 0.1;
        let clamped = OwnOptions { least_roughness: 0.7, ..DOUBLE };
        for (name, options) in [("oren_nayar.glsl", DOUBLE), ("ashikhmin_shirley.glsl", clamped)] {
            let is_diffuse = name.starts_with("oren");
            compare_where(low, backend, &request, read(name), options, 3e-7, |at| {
                let alpha = at.roughness.max(options.least_roughness).powi(2);
                let found = if is_diffuse {
                    albedo(at.n_dot_v, oren_nayar(alpha))
                } else {
                    albedo(at.n_dot_v, ashikhmin_shirley(alpha))
                };
                vec![found]
            });
        }
    });
}

#[test]
fn colours_have_channels_of_their_own() {
    on_gpu(|backend| {
        let model = Model::parse("ggx", "smith").unwrap();
        let source = || OwnSource::read(&example("clear_coat.glsl")).unwrap();
        let expected = |at| [0.75, 0.3, 0.15].map(|base| 0.75 * base + 0.25 * model.rule(at)[0]).to_vec();
        compare(backend, &request("albedo", (6, 16)), source(), DOUBLE, 1e-6, expected);
        let refused = bake(backend, &request("split-sum", (4, 4)), source(), DOUBLE).err().unwrap();
        assert!(refused.to_string().contains("coloured") && refused.help().contains("albedo"), "{refused}");
    });
}

#[test]
fn average_agrees_with_the_exact_table() {
    on_gpu(|backend| {
        let average = brdf_baker::bake::table("average-albedo").unwrap();
        let model = Model::parse("ggx", "smith").unwrap();
        let source = OwnSource::read(&example("ggx.glsl")).unwrap();
        let request = request("average-albedo", (5, 1));
        compare(backend, &request, source, DOUBLE, 1e-6, |at| vec![average.rule(&model, at)[0]]);
    });
}

#[test]
fn single_precision_states_what_it_keeps() {
    on_gpu(|backend| {
        let model = Model::parse("ggx", "smith").unwrap();
        let source = || OwnSource::read(&example("ggx.glsl")).unwrap();
        let precision = Precision::Single;
        let options = OwnOptions { least_roughness: 0.3, most: usual_most(precision), precision };
        let expected = |at: At| {
            let [e, b, ..] = model.rule(At { roughness: at.roughness.max(0.3), ..at });
            vec![e - b, b]
        };
        compare(backend, &request("split-sum", (6, 6)), source(), options, 1e-6, expected);
        // Where roundings of n·h are as large as the lobe, no estimate falls: that is refused, not written.
        let narrow = OwnOptions { least_roughness: 0.02, ..options };
        assert!(matches!(bake(backend, &request("split-sum", (4, 64)), source(), narrow), Err(Error::Verify { .. })));
    });
}

#[test]
fn finer_rule_confirms_the_bake_and_finds_a_changed_texel() {
    on_gpu(|backend| {
        let source = OwnSource::read(&example("ggx.glsl")).unwrap();
        let job = OwnJob::new(&request("split-sum", (8, 8)), source.clone(), DOUBLE, backend, &mut ignore).unwrap();
        let mut texture = job.run(&mut ignore).unwrap().texture;
        let report = check(&job, &texture, None, Extent::Full, &mut ignore).unwrap();
        println!("finer: {:.1e}, itself {:.1e}", report.worst(), report.reference_error);
        assert_eq!(report.failures, Vec::<String>::new());
        assert!(report.worst() > 0.0 && report.worst() < 1e-6 && report.reference_error <= 3e-7);
        for fault in [1.0 + 8e-6, f32::NAN] {
            let sound = texture.levels[0][20];
            texture.levels[0][20] *= fault;
            let report = check(&job, &texture, None, Extent::Full, &mut ignore).unwrap();
            assert!(report.failures[0].contains("texel (2, 1)"), "{:?}", report.failures);
            texture.levels[0][20] = sound;
        }
        let again = OwnJob::from_meta(&texture, source, backend, &mut ignore).unwrap();
        assert_eq!(again.rule_name(), job.rule_name());
    });
}

#[test]
fn laws_that_do_not_hold_are_told() {
    on_gpu(|backend| {
        let laws = |source: OwnSource| {
            let table = bake(backend, &request("albedo", (4, 4)), source, DOUBLE).unwrap();
            let of = |key: &str| table.texture.meta.get(key).unwrap().starts_with("holds");
            (["brdf.reciprocity", "brdf.energy", "brdf.positivity"].map(of), table.warnings.len())
        };
        assert_eq!(laws(whole("return vec3(1.0 / 3.14159265);")), ([true, true, true], 0));
        assert_eq!(laws(whole("return vec3(0.2 * v.z);")), ([false, true, true], 1));
        assert_eq!(laws(whole("return vec3(0.4);")), ([true, false, true], 1));
        assert_eq!(laws(whole("return vec3(0.3 - 0.4 * l.z * v.z);")), ([true, true, false], 1));
    });
}

#[test]
fn what_cannot_be_baked_is_refused() {
    on_gpu(|backend| {
        let refused = |source: OwnSource, words: &[&str]| {
            let error = bake(backend, &request("albedo", (4, 4)), source, DOUBLE).err().expect("refused");
            let said = format!("{error} {}", error.help());
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
        };
        // Not a number on a part of the hemisphere, infinite at one angle, and an integral that does not converge.
        refused(whole("return vec3(sqrt(0.9 - l.z));"), &["not finite", "l = ("]);
        refused(whole("return vec3(1.0 / (v.z - v.z));"), &["not finite", "--min-roughness"]);
        refused(whole("return vec3(1e-3 / abs(l.z - 0.51234));"), &["n.v =", "error estimate", "diverges"]);
        refused(whole("return vec3(0.1 + 0.1 * l.x * l.x);"), &["azimuth of both", "isotropic"]);
        refused(whole("return vec3(0.1 + 0.1 * (l.x * v.y - l.y * v.x));"), &["both sides of the plane"]);
        let error = |request: &TableRequest, words: &str| {
            let error = bake(backend, request, whole("return vec3(0.1);"), DOUBLE).err().expect("refused");
            assert!(error.to_string().contains(words), "{error}");
        };
        error(&request("glass", (4, 4)), "glass");
        error(&TableRequest { points: Points::Edges, ..request("albedo", (4, 4)) }, "roughness 0");
        error(&TableRequest { channels: Some(names(&["scale", "cloth"])), ..request("split-sum", (4, 4)) }, "'cloth'");
    });
    let request = request("albedo", (4, 4));
    let error = OwnJob::new(&request, whole("return vec3(0.1);"), DOUBLE, &Backend::Cpu, &mut ignore).err().unwrap();
    assert!(error.to_string().contains("Vulkan device"), "{error}");
}

#[test]
fn lobe_back_to_the_viewer_is_found() {
    on_gpu(|backend| {
        for sigma in [0.01f64, 0.003, 1e-4] {
            let s2 = sigma * sigma;
            let body = format!("vec3 d = l - v; return vec3(0.1 + 0.2 * exp(-dot(d, d) / {s2:e}) / ({s2:e} * v.z));");
            // ∫ exp(−|l − v|²/σ²) dω/σ² is π, the mean of n·l in it (1 − σ²/2) n·v, and the horizon is 12 σ away.
            let expected = PI * 0.1 + PI * 0.2 * (1.0 - 0.5 * s2);
            compare(backend, &request("albedo", (4, 2)), whole(&body), DOUBLE, 1e-7, |_| vec![expected]);
        }
    });
}

/// Some devices end the loops of an invocation after 65,535 steps without a word.
#[test]
fn loop_that_the_device_cuts_short_is_no_result() {
    on_gpu(|backend| {
        let body =
            "float s = 0.0; for (int i = 0; i < 400; i++) { s = fract(s * 1.375 + 0.125); } return vec3(0.25 * s);";
        let expected = (0..400).fold(0.0f64, |s, _| (s * 1.375 + 0.125).fract()) * 0.25 * PI;
        match bake(backend, &request("albedo", (2, 2)), whole(body), DOUBLE) {
            Ok(table) => assert!((f64::from(table.texture.levels[0][0]) - expected).abs() < 1e-5),
            Err(error) => assert!(error.to_string().contains("a loop ended after"), "{error}"),
        }
    });
}

#[test]
fn edges_at_grazing_and_with_a_least_roughness_are_baked() {
    on_gpu(|backend| {
        let source = OwnSource::read(&example("ggx.glsl")).unwrap();
        let options = OwnOptions { least_roughness: 0.045, ..DOUBLE };
        let request = TableRequest { points: Points::Edges, ..request("albedo", (3, 3)) };
        let texture = bake(backend, &request, source, options).unwrap().texture;
        assert!(texture.meta.get("n_dot_v.least").is_some());
        let model = Model::parse("ggx", "smith").unwrap();
        let expected = model.rule(At { n_dot_v: 1e-4, roughness: 0.045 })[0];
        assert!((f64::from(texture.texel(0, 0, 0, 0)[0]) - expected).abs() < 2e-6);
    });
}

/// The functions that double precision lacks, at random arguments of their domains.
#[test]
fn elementary_functions_are_those_of_rust() {
    type Function = (&'static str, fn(f64, f64) -> f64, fn(&mut Random) -> (f64, f64));
    let functions: [Function; 15] = [
        ("exp(x)", |x, _| x.exp(), |r| (80.0 * r.next() - 60.0, 0.0)),
        ("exp2(x)", |x, _| x.exp2(), |r| (80.0 * r.next() - 60.0, 0.0)),
        ("log(x)", |x, _| x.ln(), |r| ((60.0 * r.next() - 40.0).exp(), 0.0)),
        ("log2(x)", |x, _| x.log2(), |r| ((60.0 * r.next() - 40.0).exp(), 0.0)),
        ("pow(x, y)", f64::powf, |r| (r.next(), 40.0 * r.next())),
        ("sin(x)", |x, _| x.sin(), |r| (40.0 * r.next() - 20.0, 0.0)),
        ("cos(x)", |x, _| x.cos(), |r| (40.0 * r.next() - 20.0, 0.0)),
        ("tan(x)", |x, _| x.tan(), |r| (3.0 * r.next() - 1.5, 0.0)),
        ("atan(x, y)", f64::atan2, |r| (2.0 * r.next() - 1.0, 2.0 * r.next() - 1.0)),
        ("atan(x)", |x, _| x.atan(), |r| ((8.0 * r.next() - 4.0).sinh(), 0.0)),
        ("asin(x)", |x, _| x.asin(), |r| (2.0 * r.next() - 1.0, 0.0)),
        ("acos(x)", |x, _| x.acos(), |r| (2.0 * r.next() - 1.0, 0.0)),
        ("sinh(x)", |x, _| x.sinh(), |r| (8.0 * r.next() - 4.0, 0.0)),
        ("cosh(x)", |x, _| x.cosh(), |r| (8.0 * r.next() - 4.0, 0.0)),
        ("tanh(x)", |x, _| x.tanh(), |r| (8.0 * r.next() - 4.0, 0.0)),
    ];
    const COUNT: usize = 1000;
    on_gpu(|backend| {
        let Backend::Gpu(gpu) = backend else { return };
        let cases: String =
            functions.iter().enumerate().map(|(i, (call, ..))| format!("case {i}u: return {call};\n")).collect();
        let before = format!(
            "#version 450
            layout(local_size_x = 64) in;
            layout(push_constant) uniform Push {{ uint function; uint count; }} push;
            layout(std430, binding = 0) readonly buffer Input {{ double arguments[]; }};
            layout(std430, binding = 1) writeonly buffer Output {{ double values[]; }};
            {}
            double f(double x, double y) {{ switch (push.function) {{ {cases} }} return 0.0lf; }}
            void main() {{
                uint i = gl_GlobalInvocationID.x;
                if (i < push.count) {{ values[i] = f(arguments[2u * i], arguments[2u * i + 1u]); }}
            }}\n",
            include_str!("../shaders/own/elementary.glsl")
        );
        let words = glsl::compile(&before, "", Path::new("none.glsl")).unwrap();
        let kernel = gpu.kernel("elementary", &words, 2, 8).unwrap();
        let mut random = Random(3);
        for (i, (call, twin, argument)) in functions.iter().enumerate() {
            let arguments: Vec<(f64, f64)> = (0..COUNT).map(|_| argument(&mut random)).collect();
            let flat: Vec<f64> = arguments.iter().flat_map(|(x, y)| [*x, *y]).collect();
            let input = gpu.upload("arguments", &flat).unwrap();
            let output = gpu.buffer("values", 8 * COUNT as u64).unwrap();
            let push = [i as u32, COUNT as u32];
            gpu.dispatch(&kernel, &[&input, &output], &push, [COUNT.div_ceil(64) as u32, 1, 1]).unwrap();
            let errors = gpu.read::<f64>(&output).unwrap().into_iter().zip(&arguments).map(|(found, (x, y))| {
                let expected = twin(*x, *y);
                // Near a zero of log, sin and cos the argument's own rounding counts.
                (found - expected).abs() / expected.abs().max(1e-3)
            });
            let worst = errors.fold(0.0, |a: f64, b| if b <= a { a } else { b });
            println!("{call}: {worst:.1e}");
            assert!(worst < if call.starts_with("pow") { 2e-14 } else { 4e-15 }, "{call}: {worst:e}");
        }
    });
}

#[test]
fn messages_name_line_and_column() {
    on_gpu(|backend| {
        let said = |source: OwnSource| {
            bake(backend, &request("albedo", (4, 4)), source, DOUBLE).err().expect("it does not compile").to_string()
        };
        let wrong = "float square(float x) { return x * x; }\n\nvec3 brdf(vec3 l, vec3 v, float alpha) {\n\
                     \tfloat a2 = square(alpha) * gamma;\n    return vec3(a2)\n}\n";
        let error = said(text(wrong));
        assert!(error.contains("my.glsl:4:29: 'gamma' : undeclared identifier"), "{error}");
        assert!(error.contains("my.glsl:6:1: syntax error"), "{error}");
        let error = said(text("vec3 brdf(vec3 l, vec3 v) { return l; }"));
        assert!(error.contains("`brdf` is not defined with the arguments"), "{error}");
    });
    let error = OwnSource::new(Path::new("my.glsl"), "vec3 f(vec3 l) { return l; }").unwrap_err();
    assert!(error.to_string().contains("my.glsl") && error.help().contains("vec3 brdf(vec3 l, vec3 v, float alpha)"));
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).output().expect("the program starts")
}

#[test]
fn command_line_bakes_verifies_and_refuses() {
    if common::gpu().is_none() {
        return;
    }
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    std::fs::copy(example("ggx.glsl"), here.join("mine.glsl")).unwrap();
    std::fs::copy(example("charlie.glsl"), here.join("other.glsl")).unwrap();
    let said =
        |output: &Output| String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned();
    let expect = |arguments: &[&str], code: i32, words: &[&str]| {
        let output = run(here, arguments);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
    };
    let bake = ["bake", "split-sum", "--glsl", "mine.glsl", "-o", "a.ktx2", "--size", "8", "--estimates", "e.npy"];
    expect(&bake, 0, &["a.ktx2", "error estimate", "double"]);
    assert!(here.join("e.npy").exists());
    expect(&["info", "a.ktx2"], 0, &["mine.glsl", "brdf.sha256", "brdf.reciprocity", "error.estimate"]);
    expect(&["verify", "a.ktx2", "--glsl", "mine.glsl"], 0, &["right", "confirmed texels.sha256, rule, error.worst"]);
    expect(&["verify", "a.ktx2"], 2, &["'mine.glsl'", "--glsl"]);
    expect(&["verify", "a.ktx2", "--glsl", "other.glsl"], 2, &["not the BRDF that was baked", "SHA-256"]);
    expect(&["bake", "average-albedo", "--of", "a.ktx2", "-o", "b.exr"], 2, &["--glsl"]);
    expect(&["bake", "split-sum", "--glsl", "mine.glsl", "--ndf", "ggx", "-o", "b.exr"], 2, &["cannot be used with"]);
    expect(&["bake", "split-sum", "--min-roughness", "0.1", "-o", "b.exr"], 2, &["--glsl"]);
    expect(&["bake", "split-sum", "--glsl", "none.glsl", "-o", "b.exr"], 2, &["cannot read 'none.glsl'"]);
    std::fs::write(here.join("broken.glsl"), "vec3 brdf(vec3 l, vec3 v, float alpha) {\n    return vec3(a);\n}\n")
        .unwrap();
    expect(&["bake", "albedo", "--glsl", "broken.glsl", "-o", "b.exr"], 2, &["broken.glsl:2:17: 'a' : undeclared"]);
    assert!(!here.join("b.exr").exists());
}
