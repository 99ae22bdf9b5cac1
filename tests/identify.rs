// SPDX-License-Identifier: MIT OR Apache-2.0
//! What made a table: every convention is recognised, what is not a table is refused, and nothing wrong is certain.

use std::collections::HashMap;
use std::path::Path;

use brdf_baker::axis::Points;
use brdf_baker::bake::{At, Backend, Model, TableRequest};
use brdf_baker::format::picture::{Component, Picture, Precision};
use brdf_baker::format::{Encoding, for_path, formats};
use brdf_baker::progress::ignore;
use brdf_baker::verify::identify::{Report, Verdict, identify};
use half::f16;
use image_dds::ddsfile::{AlphaMode, D3D10ResourceDimension, Dds, DxgiFormat, NewDxgiParams};

/// A table as somebody else might make it, and at the same time what is to be found out. The words are those of a report;
/// the coordinates are computed here, from the words.
#[derive(Clone)]
struct Recipe {
    ndf: &'static str,
    visibility: &'static str,
    channels: &'static [&'static str],
    x: String,
    y: String,
    size: (u32, u32),
    store: Store,
    shift: Option<&'static str>,
}

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Store {
    Half,
    Single,
    Bytes,
    /// Cut off instead of rounded.
    CutBytes,
    Words,
    Ten,
    Srgb,
    Gamma,
    Rgbd,
    TwoBytes,
}

impl Recipe {
    fn new(ndf: &'static str, visibility: &'static str) -> Recipe {
        Recipe {
            ndf,
            visibility,
            channels: &["scale", "bias"],
            x: "n_dot_v ascending, at centers".into(),
            y: "roughness ascending, at centers".into(),
            size: (32, 32),
            store: Store::Half,
            shift: None,
        }
    }

    fn name(&self) -> String {
        format!(
            "{} {} {:?} | {} | {} | {:?} {:?} {}",
            self.ndf,
            self.visibility,
            self.channels,
            self.x,
            self.y,
            self.size,
            self.store,
            self.shift.unwrap_or("")
        )
    }

    /// n·v or roughness of a texel, and whether it is a roughness.
    fn coordinate(side: &str, i: u32, n: u32) -> (f64, bool) {
        let (what, points) = side.split_once(", at ").expect("the words of a side");
        let i = if what.ends_with(" descending") { n - 1 - i } else { i };
        let (i, n) = (f64::from(i), f64::from(n));
        let t = match points {
            "centers" => (i + 0.5) / n,
            "edges" => i / (n - 1.0),
            "i/N" => i / n,
            "(i + 1)/N" => (i + 1.0) / n,
            other => panic!("{other}"),
        };
        match what.rsplit_once(' ').expect("an order").0 {
            "n_dot_v" => (t, false),
            "sqrt_n_dot_v" => (t * t, false),
            "sqrt_one_minus_n_dot_v" => (1.0 - t * t, false),
            "angle" => ((t * std::f64::consts::FRAC_PI_2).cos().max(0.0), false),
            "roughness" => (t, true),
            "alpha" => (t.sqrt(), true),
            other => panic!("{other}"),
        }
    }

    /// The table's values, before they are stored.
    fn values(&self) -> Vec<f64> {
        let model = Model::parse(self.ndf, self.visibility).unwrap();
        let (width, height) = self.size;
        let mut values = vec![];
        for y in 0..height {
            for x in 0..width {
                let (x, y) = self.moved(x, y);
                let (a, transposed) = Recipe::coordinate(&self.x, x, width);
                let (b, _) = Recipe::coordinate(&self.y, y, height);
                let (n_dot_v, roughness) = if transposed { (b, a) } else { (a, b) };
                let [e, b, f82, _] = model.rule(At { n_dot_v, roughness });
                values.extend(self.channels.iter().map(|c| match *c {
                    "scale" => e - b,
                    "bias" => b,
                    "albedo" => e,
                    "1 - albedo" => 1.0 - e,
                    "f82" => f82,
                    "albedo/2pi" => e / std::f64::consts::TAU,
                    "0" => 0.0,
                    "1" => 1.0,
                    other => panic!("{other}"),
                }));
            }
        }
        values
    }

    /// The texel whose value lies at (x, y): the last row or column is repeated by a shift.
    fn moved(&self, x: u32, y: u32) -> (u32, u32) {
        let (width, height) = self.size;
        match self.shift {
            None => (x, y),
            Some("row next") => (x, (y + 1).min(height - 1)),
            Some("row previous") => (x, y.saturating_sub(1)),
            Some("column next") => ((x + 1).min(width - 1), y),
            Some("column previous") => (x.saturating_sub(1), y),
            Some(other) => panic!("{other}"),
        }
    }

    fn picture(&self) -> Picture {
        self.store(&self.values(), self.channels.len())
    }

    /// Values of `n` channels as this recipe stores them.
    fn store(&self, values: &[f64], n: usize) -> Picture {
        let integer = |top: f64, curve: &dyn Fn(f64) -> f64| -> Vec<f32> {
            values.iter().map(|v| ((curve(v.clamp(0.0, 1.0)) * top).round() / top) as f32).collect()
        };
        let (stored, precisions): (Vec<f32>, Vec<Precision>) = match self.store {
            Store::Half => (
                values.iter().map(|v| f16::from_f64(*v).to_f32()).collect(),
                vec![Precision::Float { bits: 11, least_exponent: -14 }; n],
            ),
            Store::Single => (
                values.iter().map(|v| *v as f32).collect(),
                vec![Precision::Float { bits: 24, least_exponent: -126 }; n],
            ),
            Store::Bytes => (integer(255.0, &|v| v), vec![Precision::Integer(255); n]),
            Store::CutBytes => (integer(255.0, &|v| (v * 255.0).floor() / 255.0), vec![Precision::Integer(255); n]),
            Store::Words => (integer(65535.0, &|v| v), vec![Precision::Integer(65535); n]),
            Store::Ten => (integer(1023.0, &|v| v), vec![Precision::Integer(1023); n]),
            Store::Srgb => {
                let curve = |v: f64| if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
                (integer(255.0, &curve), vec![Precision::Integer(255); n])
            }
            Store::Gamma => (integer(255.0, &|v| v.powf(1.0 / 2.2)), vec![Precision::Integer(255); n]),
            Store::Rgbd => {
                // As Babylon.js packs: the divisor is a byte, colour is multiplied by it and gets the gamma.
                let texel = |rgb: &[f64]| -> Vec<f32> {
                    let largest = rgb.iter().copied().fold(1e-6, f64::max);
                    let d = ((1.0 / largest).min(1.0) * 255.0).floor().clamp(1.0, 255.0) / 255.0;
                    let byte = |v: f64| ((v * 255.0).round() / 255.0) as f32;
                    let color = |v: &f64| byte((v * d).clamp(0.0, 1.0).powf(1.0 / 2.2));
                    rgb.iter().map(color).chain([d as f32]).collect()
                };
                (values.chunks(n).flat_map(texel).collect(), vec![Precision::Integer(255); n + 1])
            }
            Store::TwoBytes => {
                let pair = |v: &f64| {
                    let word = (v * 65535.0).round() as u16;
                    [word >> 8, word & 255].map(|b| f32::from(b) / 255.0)
                };
                (values.iter().flat_map(pair).collect(), vec![Precision::Integer(255); 2 * n])
            }
        };
        let component = |(name, precision): (&str, &Precision)| Component { name: name.into(), precision: *precision };
        Picture {
            width: self.size.0,
            height: self.size.1,
            components: ["R", "G", "B", "A"].into_iter().zip(&precisions).map(component).collect(),
            stored: format!("{:?}", self.store),
            values: stored,
        }
    }

    /// The words that a report must find.
    fn expected(&self) -> HashMap<&'static str, String> {
        let names: Vec<&str> = match self.store {
            Store::TwoBytes => vec!["RG", "BA"],
            _ => vec!["R", "G", "B", "A"],
        };
        let channels: Vec<String> = names.iter().zip(self.channels).map(|(a, b)| format!("{a} = {b}")).collect();
        let mut words = HashMap::from([
            ("channels", channels.join(", ")),
            ("x", self.x.clone()),
            ("y", self.y.clone()),
            ("distribution", self.ndf.to_string()),
            ("geometry", self.visibility.to_string()),
        ]);
        if let Some((what, other)) = self.shift.and_then(|s| s.split_once(' ')) {
            let text = format!("{what}s are shifted by one texel: each holds what belongs into the {other} one");
            words.insert("shift", text);
        }
        let encoding = match self.store {
            Store::Srgb => "encoded as sRGB",
            Store::Gamma => "encoded with gamma 2.2",
            Store::Rgbd => "encoded as RGBD, rgb^2.2/a",
            Store::TwoBytes => "16 bits in two bytes, the higher one first",
            _ => return words,
        };
        words.insert("encoding", encoding.into());
        words
    }
}

fn found(report: &Report) -> HashMap<&'static str, String> {
    report.fits.first().map(|fit| fit.words().into_iter().collect()).unwrap_or_default()
}

fn run(picture: &Picture) -> Report {
    identify(picture, &mut ignore).expect("it is large enough")
}

/// Every kind of convention, alone and together.
fn recipes() -> Vec<Recipe> {
    let base = || Recipe::new("ggx", "smith");
    let mut all = vec![];

    // Models.
    for (ndf, visibility) in [
        ("ggx", "smith"),
        ("ggx", "smith-uncorrelated"),
        ("ggx", "schlick-ggx"),
        ("ggx", "schlick-beckmann"),
        ("ggx", "schlick-direct"),
        ("ggx", "cook-torrance"),
        ("ggx", "implicit"),
        ("ggx", "neumann"),
        ("ggx", "kelemen"),
        ("beckmann", "smith"),
        ("beckmann", "beckmann-rational"),
        ("beckmann", "cook-torrance"),
        ("blinn-phong", "smith"),
        ("gtr:gamma=1", "smith"),
        ("charlie", "neubelt"),
        ("charlie", "charlie"),
    ] {
        all.push(Recipe { size: (24, 24), ..Recipe::new(ndf, visibility) });
    }

    // Transposed, flipped, positions; sides of different lengths.
    for (i, x_order) in ["ascending", "descending"].into_iter().enumerate() {
        for (j, y_order) in ["ascending", "descending"].into_iter().enumerate() {
            for (k, points) in ["centers", "edges"].into_iter().enumerate() {
                let view = |order: &str| format!("n_dot_v {order}, at {points}");
                let rough = |order: &str| format!("roughness {order}, at {points}");
                let store = [Store::Half, Store::Bytes, Store::Single, Store::Words][(i + 2 * j + k) % 4];
                let upright = Recipe { x: view(x_order), y: rough(y_order), size: (40, 24), store, ..base() };
                all.push(Recipe { x: rough(x_order), y: view(y_order), size: (24, 40), ..upright.clone() });
                all.push(upright);
            }
        }
    }

    // Warps.
    for x in ["n_dot_v", "sqrt_n_dot_v", "sqrt_one_minus_n_dot_v", "angle"] {
        for (y, points) in [("roughness", "edges"), ("alpha", "centers")] {
            let (x, y) = (format!("{x} ascending, at {points}"), format!("{y} ascending, at {points}"));
            all.push(Recipe { x, y, ..Recipe::new("ggx", "smith-uncorrelated") });
        }
    }
    for points in ["i/N", "(i + 1)/N"] {
        let (x, y) = (format!("n_dot_v ascending, at {points}"), format!("roughness ascending, at {points}"));
        all.push(Recipe { x, y, ..base() });
    }

    // Shifts, with bytes as well.
    for shift in ["row next", "row previous", "column next", "column previous"] {
        for store in [Store::Half, Store::Bytes] {
            all.push(Recipe { shift: Some(shift), store, ..Recipe::new("ggx", "schlick-ggx") });
        }
    }

    // Channels.
    for channels in [
        &["bias", "scale"] as &[&str],
        &["bias", "albedo"],
        &["scale", "bias", "f82"],
        &["albedo"],
        &["1 - albedo"],
        &["scale", "bias", "0", "1"],
    ] {
        all.push(Recipe { channels, ..base() });
    }
    all.push(Recipe { channels: &["albedo/2pi"], ..Recipe::new("charlie", "neubelt") });

    // Encodings.
    for store in [Store::CutBytes, Store::Words, Store::Ten, Store::Srgb, Store::Gamma, Store::TwoBytes] {
        all.push(Recipe { store, ..base() });
    }
    all.push(Recipe {
        store: Store::Rgbd,
        channels: &["bias", "albedo", "albedo"],
        ..Recipe::new("charlie", "neubelt")
    });
    all.push(Recipe { store: Store::Bytes, size: (256, 256), ..base() });
    all.push(Recipe { store: Store::Bytes, size: (768, 256), ..Recipe::new("ggx", "kelemen") });
    all
}

#[test]
fn every_convention_is_recognised_and_nothing_wrong_is_certain() {
    let recipes = recipes();
    let (mut right, mut certain) = (0, 0);
    for recipe in &recipes {
        let report = run(&recipe.picture());
        let (expected, found) = (recipe.expected(), found(&report));
        let is_right = expected == found && report.verdict != Verdict::None;
        if !is_right || report.verdict != Verdict::Certain {
            println!("{:?}: {}", report.verdict, recipe.name());
            println!("  open {:?}, noisiness {:.2}", report.open, report.noisiness);
            for fit in &report.fits {
                println!("  max {:.1e} rms {:.1e} exact {}: {:?}", fit.max, fit.rms, fit.is_exact, fit.words());
            }
        }
        assert!(is_right || report.verdict != Verdict::Certain, "wrong and certain: {}", recipe.name());
        right += usize::from(is_right);
        certain += usize::from(is_right && report.verdict == Verdict::Certain);
    }
    println!("{} recipes, {right} right, {certain} of them certain", recipes.len());
    assert!(recipes.len() >= 60 && right == recipes.len() && certain == right);
}

/// A file as the tool writes it, read back as a stranger's.
fn own(request: &TableRequest, file: &str, encoding: Option<&str>) -> Report {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join(file);
    let texture = request.resolve().unwrap().run(&Backend::Cpu, &mut ignore).unwrap();
    let format = for_path(&path).unwrap();
    let encoding = encoding.map(|e| Encoding::parse(e).unwrap());
    let encoding = encoding.or(format.default_encoding(texture.shape, texture.channels.len())).unwrap();
    std::fs::write(&path, format.to_bytes(&path, &texture, encoding.into()).unwrap()).unwrap();
    run(&Picture::read(&path).unwrap())
}

#[test]
fn own_files_are_recognised_in_every_container() {
    for (file, encoding) in [
        ("a.ktx2", None),
        ("a.ktx2", Some("rgba32f")),
        ("a.exr", None),
        ("a.exr", Some("rg32f")),
        ("a.dds", None),
        ("a.ktx", None),
        ("a.npy", None),
        ("a.hdr", None),
        ("a.png", None),
        ("a.png", Some("rgb8unorm")),
    ] {
        let request = TableRequest {
            size: (48, 32),
            points: Points::Edges,
            flip_v: true,
            visibility: "smith-uncorrelated".into(),
            channels: Some(vec!["bias".into(), "albedo".into()]),
            ..TableRequest::new("split-sum")
        };
        let report = own(&request, file, encoding);
        let words = found(&report);
        assert_eq!(report.verdict, Verdict::Certain, "{file} {encoding:?}: {words:?} {:?}", report.open);
        assert!(words["channels"].starts_with("R = bias, G = albedo"), "{file}: {words:?}");
        assert_eq!(words["x"], "n_dot_v ascending, at edges");
        assert_eq!(words["y"], "roughness descending, at edges");
        assert_eq!(words["geometry"], "smith-uncorrelated");
    }
}

fn golden(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name)
}

/// The table of three.js.
fn three() -> Picture {
    let text = std::fs::read_to_string(golden("three_dfg.txt")).unwrap();
    let words = text.lines().filter(|l| !l.starts_with('#')).flat_map(str::split_whitespace);
    let values: Vec<f32> = words.map(|w| f16::from_bits(u16::from_str_radix(w, 16).unwrap()).to_f32()).collect();
    assert_eq!(values.len(), 16 * 16 * 2);
    let precision = Precision::Float { bits: 11, least_exponent: -14 };
    let components = ["R", "G"].map(|name| Component { name: name.into(), precision }).to_vec();
    Picture { width: 16, height: 16, components, stored: "RG16F".into(), values }
}

/// The table of Bevy, in the container that Bevy has it in.
fn bevy() -> Picture {
    Picture::read(&golden("bevy_dfg.ktx2")).unwrap()
}

#[test]
fn published_tables_are_recognised() {
    for (name, picture, x, y, worst) in
        [("Bevy", bevy(), "n_dot_v", "roughness", 6.4e-3), ("three.js", three(), "roughness", "n_dot_v", 1.5e-2)]
    {
        let report = run(&picture);
        let words = found(&report);
        assert_eq!(report.verdict, Verdict::Certain, "{name}: {words:?} {:?}", report.open);
        assert_eq!(words["channels"], "R = scale, G = bias", "{name}");
        assert_eq!(words["x"], format!("{x} ascending, at centers"), "{name}");
        assert_eq!(words["y"], format!("{y} ascending, at centers"), "{name}");
        assert_eq!((&*words["distribution"], &*words["geometry"]), ("ggx", "smith"), "{name}");
        assert!(!words.contains_key("shift"), "{name}");
        let fit = &report.fits[0];
        assert!(fit.max <= worst && fit.max > 0.5 * worst && !fit.is_exact, "{name}: {}", fit.max);
    }
}

/// The usual way to make such a table: importance sampling with one Hammersley sequence for all texels (Karis 2013), and
/// Schlick's geometry term with k = alpha/2.
fn monte_carlo(size: u32, samples: u32) -> Picture {
    let texel = |n_dot_v: f64, roughness: f64| {
        let alpha = roughness * roughness;
        let v = [(1.0 - n_dot_v * n_dot_v).sqrt(), n_dot_v];
        let mask = |x: f64| x / (x * (1.0 - 0.5 * alpha) + 0.5 * alpha);
        let mut sums = [0.0; 2];
        for i in 0..samples {
            let (a, b) = (f64::from(i) / f64::from(samples), f64::from(i.reverse_bits()) / f64::from(u32::MAX));
            let cos_h = ((1.0 - b) / (1.0 + (alpha * alpha - 1.0) * b)).sqrt();
            let sin_h = (1.0 - cos_h * cos_h).sqrt();
            let v_dot_h = v[0] * sin_h * (std::f64::consts::TAU * a).cos() + v[1] * cos_h;
            let n_dot_l = 2.0 * v_dot_h * cos_h - n_dot_v;
            if n_dot_l > 0.0 && v_dot_h > 0.0 {
                let weight = mask(n_dot_v) * mask(n_dot_l) * v_dot_h / (cos_h * n_dot_v);
                let fc = (1.0 - v_dot_h).powi(5);
                sums[0] += (1.0 - fc) * weight;
                sums[1] += fc * weight;
            }
        }
        sums.map(|s| f16::from_f64(s / f64::from(samples)).to_f32())
    };
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(size);
    let values = (0..size * size).flat_map(|i| texel(at(i % size), at(i / size))).collect();
    let precision = Precision::Float { bits: 11, least_exponent: -14 };
    let components = ["R", "G"].map(|name| Component { name: name.into(), precision }).to_vec();
    Picture { width: size, height: size, components, stored: "halves".into(), values }
}

#[test]
fn monte_carlo_tables_are_recognised() {
    for (size, samples) in [(16, 4096), (32, 1024), (128, 1024), (128, 64)] {
        let report = run(&monte_carlo(size, samples));
        let words = found(&report);
        let fit = &report.fits[0];
        println!(
            "{size} {samples}: {:?} {:.1e} {:.1e} {:.2} {:?}",
            report.verdict, fit.max, fit.rms, report.noisiness, report.open
        );
        assert_eq!((&*words["geometry"], &*words["distribution"]), ("schlick-ggx", "ggx"), "{size} {samples}");
        assert_eq!(words["channels"], "R = scale, G = bias");
        assert!(words["x"].starts_with("n_dot_v ascending") && words["y"].starts_with("roughness ascending"));
        // Where noise hides half a texel, that is what is open, and nothing else.
        assert!(report.open.iter().all(|name| ["x", "y", "shift"].contains(name)), "{:?}", report.open);
        let placed = words["x"].ends_with("centers") && words["y"].ends_with("centers") && !words.contains_key("shift");
        assert!(placed || report.verdict == Verdict::Likely, "{size} {samples}: {words:?}");
    }
}

#[test]
fn shifted_published_table_is_reported_as_such() {
    let picture = bevy();
    let row = picture.width as usize * 2;
    let mut shifted = picture.clone();
    shifted.values.copy_within(row.., 0);
    let report = run(&shifted);
    let words = found(&report);
    assert_eq!(words["shift"], "rows are shifted by one texel: each holds what belongs into the next one");
    assert_eq!((&*words["y"], report.verdict), ("roughness ascending, at centers", Verdict::Certain));
}

#[test]
fn runner_up_and_difference_are_told() {
    let report = run(&bevy());
    assert!(report.fits.len() >= 2 && report.fits[1].rms > 3.0 * report.fits[0].rms);
    let difference = report.difference.expect("there is a runner-up");
    assert_eq!(difference.facts.iter().map(|f| f.0).collect::<Vec<_>>(), ["y"]);
    let off = |says: f64| (difference.found - says).abs();
    assert!(off(difference.best) < 0.1 * off(difference.runner_up));
}

/// A DDS file as Direct3D tools write them.
fn dds(recipe: &Recipe, format: DxgiFormat, bytes: impl Fn(f64) -> Vec<u8>) -> Vec<u8> {
    let (width, height) = recipe.size;
    let parameters = NewDxgiParams {
        height,
        width,
        depth: None,
        format,
        mipmap_levels: None,
        array_layers: None,
        caps2: None,
        is_cubemap: false,
        resource_dimension: D3D10ResourceDimension::Texture2D,
        alpha_mode: AlphaMode::Unknown,
    };
    let mut dds = Dds::new_dxgi(parameters).unwrap();
    dds.data = recipe.values().into_iter().flat_map(bytes).collect();
    let mut out = vec![];
    dds.write(&mut out).unwrap();
    out
}

fn half_dds() -> Vec<u8> {
    let recipe = Recipe::new("ggx", "schlick-direct");
    dds(&recipe, DxgiFormat::R16G16_Float, |v| f16::from_f64(v).to_le_bytes().to_vec())
}

/// A picture from the bytes of a file.
fn read(bytes: &[u8]) -> brdf_baker::Result<Picture> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    Picture::read(file.path())
}

#[test]
fn dds_files_are_read() {
    let report = run(&read(&half_dds()).unwrap());
    assert_eq!((&*found(&report)["geometry"], report.verdict), ("schlick-direct", Verdict::Certain));
    let recipe = Recipe { channels: &["0", "bias", "scale", "1"], ..Recipe::new("ggx", "smith") };
    let bytes = dds(&recipe, DxgiFormat::B8G8R8A8_UNorm, |v| vec![(v * 255.0).round() as u8]);
    let report = run(&read(&bytes).unwrap());
    assert_eq!(found(&report)["channels"], "R = scale, G = bias, B = 0, A = 1");
    assert_eq!(report.verdict, Verdict::Certain);
}

#[test]
fn damaged_files_end_in_errors() {
    let texture = TableRequest { size: (9, 7), ..TableRequest::new("split-sum") };
    let texture = texture.resolve().unwrap().run(&Backend::Cpu, &mut ignore).unwrap();
    let mut files = vec![std::fs::read(golden("bevy_dfg.ktx2")).unwrap(), half_dds()];
    // What others' files are read of; the rest is ours alone.
    let read_of_others = ["ktx2", "exr", "hdr", "png", "dds", "ktx", "npy"];
    for format in formats().iter().filter(|f| read_of_others.contains(&f.extension())) {
        let encoding = format.default_encoding(texture.shape, 2).unwrap();
        files.push(format.to_bytes(Path::new("a"), &texture, encoding.into()).unwrap());
    }
    let mut cuts = 0;
    for bytes in files {
        assert!(read(&bytes).is_ok());
        for cut in (0..bytes.len()).step_by(bytes.len() / 40 + 1) {
            assert!(read(&bytes[..cut]).is_err(), "{:?} cut at {cut} of {}", &bytes[..4], bytes.len());
            cuts += 1;
        }
        // A changed byte may pass as another number, but nothing panics.
        for at in (0..bytes.len()).step_by(bytes.len() / 150 + 1) {
            for bit in [0, 4, 7] {
                let mut changed = bytes.clone();
                changed[at] ^= 1 << bit;
                let _ = read(&changed);
            }
        }
    }
    assert!(cuts > 100);
    assert!(read(b"just a line of text").unwrap_err().to_string().contains("first bytes"));
    let nan = dds(&Recipe::new("ggx", "smith"), DxgiFormat::R32G32_Float, |_| f32::NAN.to_le_bytes().to_vec());
    assert!(read(&nan).unwrap_err().to_string().contains("(0, 0) holds NaN"));
}

#[test]
fn what_is_no_table_fits_nothing() {
    let grey = |at: &dyn Fn(f64, f64) -> [f64; 3]| {
        let n = 64;
        let texels = (0..n * n).flat_map(|i| at(f64::from(i % n) / 64.0, f64::from(i / n) / 64.0));
        let values = texels.map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as f32 / 255.0).collect();
        let components =
            ["R", "G", "B"].map(|name| Component { name: name.into(), precision: Precision::Integer(255) });
        Picture { width: 64, height: 64, components: components.to_vec(), stored: "bytes".into(), values }
    };
    let noise = |x: f64, y: f64| (1e4 * (12.9898 * x + 78.233 * y).sin()).fract().abs();
    let pictures = [
        ("noise", grey(&|x, y| [noise(x, y), noise(y, x), noise(x + 1.0, y)])),
        ("ramp", grey(&|x, y| [x, y, 0.0])),
        (
            "sky over land",
            grey(&|x, y| {
                let ground = 0.55 + 0.05 * (9.0 * x).sin();
                if y < ground { [0.4 + 0.4 * y, 0.6 + 0.3 * y, 0.95] } else { [0.3, 0.25 + 0.1 * noise(x, y), 0.15] }
            }),
        ),
        (
            "sphere",
            grey(&|x, y| {
                let r2 = (2.0 * x - 1.0).powi(2) + (2.0 * y - 1.0).powi(2);
                [(1.0 - r2).max(0.0).sqrt(); 3]
            }),
        ),
        ("one colour", grey(&|_, _| [0.5, 0.25, 1.0])),
        ("photograph", Picture::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/preview.png")).unwrap()),
    ];
    for (name, picture) in pictures {
        let report = run(&picture);
        let rms = report.fits.first().map(|f| f.rms);
        println!("{name}: {rms:?} {:?}", found(&report));
        assert_eq!(report.verdict, Verdict::None, "{name}: {:?}", found(&report));
    }
}

#[test]
fn table_of_an_unknown_model_is_never_certain() {
    for (ndf, visibility) in
        [("gtr:gamma=2.3", "smith"), ("gtr:gamma=1.7", "smith"), ("abc:a2=1.2", "neumann"), ("ggx:ratio=0.5", "smith")]
    {
        let recipe = Recipe::new(ndf, visibility);
        let report = run(&recipe.picture());
        println!("{ndf}: {:?} {:?} {:?}", report.verdict, report.fits[0].rms, found(&report));
        assert_ne!(report.verdict, Verdict::Certain, "{ndf} {visibility}: {:?}", found(&report));
    }
}

#[test]
fn third_channel_may_be_another_models() {
    let mut picture = Recipe { channels: &["bias", "albedo", "0"], ..Recipe::new("ggx", "smith") }.picture();
    let cloth = Recipe { channels: &["albedo"], ..Recipe::new("charlie", "neubelt") }.picture();
    picture.values.chunks_mut(3).zip(&cloth.values).for_each(|(texel, v)| texel[2] = *v);
    let report = run(&picture);
    assert_eq!(found(&report)["channels"], "R = bias, G = albedo, B = albedo of charlie neubelt");
    assert_eq!(report.verdict, Verdict::Certain);
}

/// The layouts of engines (their documentation and shaders say so), with third channels that belong to another model or
/// to none.
#[test]
fn engine_layouts_are_recognised() {
    let table = |visibility, channels, store, x: &str, y: &str| Recipe {
        channels,
        store,
        x: x.into(),
        y: y.into(),
        size: (64, 64),
        ..Recipe::new("ggx", visibility)
    };
    let (n_dot_v, roughness) = ("n_dot_v ascending, at centers", "roughness ascending, at centers");
    let (filament, karis): (&[_], &[_]) = (&["bias", "albedo"], &["scale", "bias"]);
    let turned = "roughness descending, at centers";
    let (spread, edges) = ("sqrt_n_dot_v ascending, at edges", "roughness ascending, at edges");
    let (grazing, alpha) = ("sqrt_one_minus_n_dot_v ascending, at edges", "alpha ascending, at centers");
    for (engine, recipe, third) in [
        ("Filament", table("smith", filament, Store::Half, n_dot_v, roughness), "cloth"),
        ("Godot", table("schlick-ggx", filament, Store::Half, n_dot_v, turned), "cloth"),
        ("Unity HDRP", table("smith", filament, Store::Ten, spread, edges), "diffuse"),
        ("Babylon.js", table("smith", filament, Store::Rgbd, n_dot_v, roughness), "cloth"),
        ("glTF sample viewer", table("smith", karis, Store::Bytes, n_dot_v, roughness), "cloth"),
        ("EEVEE", table("smith", &["scale", "bias", "f82"], Store::Half, edges, grazing), ""),
        ("MaterialX", table("smith", karis, Store::Single, n_dot_v, alpha), ""),
    ] {
        let mut values = recipe.values();
        let mut n = recipe.channels.len();
        let mut expected = recipe.expected();
        if !third.is_empty() {
            let cloth =
                Recipe { ndf: "charlie", visibility: "neubelt", channels: &["albedo"], ..recipe.clone() }.values();
            let diffuse = |i: usize| 0.3 + 0.4 * (i % 64) as f64 / 64.0 + 0.2 * ((i / 64) as f64 / 64.0).powi(2);
            let third_of = |i: usize| if third == "cloth" { cloth[i] } else { diffuse(i) };
            values = values.chunks(n).enumerate().flat_map(|(i, v)| [v, &[third_of(i)]].concat()).collect();
            n += 1;
            let words = if third == "cloth" { ", B = albedo of charlie neubelt" } else { ", B = ?" };
            expected.entry("channels").and_modify(|c| c.push_str(words));
        }
        let report = run(&recipe.store(&values, n));
        assert_eq!(found(&report), expected, "{engine}");
        assert_eq!(report.verdict, Verdict::Certain, "{engine}: {:?}", report.open);
    }
}

#[test]
fn single_wrong_texels_do_not_hide_a_table() {
    let mut picture = Recipe::new("ggx", "smith").picture();
    picture.values[2 * (32 * 10 + 10)] += 0.02;
    let report = run(&picture);
    assert_eq!(found(&report)["geometry"], "smith");
    assert_eq!((report.fits[0].is_exact, report.fits[0].worst_texel), (false, [10, 10]));
}
