// SPDX-License-Identifier: MIT OR Apache-2.0
//! The command line as a user meets it: results, exit codes, and no file left behind.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use brdf_baker::env::Equirect;
use tempfile::TempDir;

/// A command with its own empty folder, on the processor, so that no test needs a driver.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).args(["--device", "cpu"]).stdin(Stdio::null());
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn files(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).expect("readable").map(|e| e.expect("readable").path()).collect()
}

/// Runs and expects success; returns stdout.
fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs and expects exit code 2, the words on stderr, nothing on stdout, and no new file.
fn fails(folder: &Path, arguments: &[&str], words: &[&str]) {
    let before = files(folder);
    let output = run(folder, arguments);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{arguments:?}: '{word}' is not in: {stderr}");
    }
    assert!(output.stdout.is_empty(), "{arguments:?} wrote to stdout");
    assert!(!stderr.contains("panicked"), "{arguments:?}: {stderr}");
    assert_eq!(before, files(folder), "{arguments:?} left a file");
}

#[test]
fn every_container_is_baked_verified_and_described() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    for (table, file) in [
        ("split-sum", "a.ktx2"),
        ("split-sum", "b.exr"),
        ("split-sum", "c.hdr"),
        ("split-sum", "d.png"),
        ("albedo", "e.ktx2"),
        ("average-albedo", "f.exr"),
        ("split-sum", "g.ktx"),
        ("split-sum", "h.json"),
        ("split-sum", "i.rs"),
        ("albedo", "j.py"),
    ] {
        let line = succeeds(here, &["bake", table, "-o", file, "--size", "32"]);
        assert!(line.starts_with(file) && line.contains("max error") && line.trim_end().ends_with("cpu"), "{line}");
        assert_eq!(line.lines().count(), 1);
        assert!(succeeds(here, &["verify", file]).contains("right"));
        let info = succeeds(here, &["info", file]);
        for word in [table, "ggx", "smith", "centers", "ascending", "error.worst"] {
            assert!(info.contains(word), "'{word}' is not in: {info}");
        }
    }
}

#[cfg(not(feature = "glsl"))]
#[test]
fn build_without_a_compiler_says_so() {
    let folder = TempDir::new().unwrap();
    let bake = ["bake", "split-sum", "--glsl", "mine.glsl", "-o", "a.ktx2"];
    fails(folder.path(), &bake, &["has no GLSL compiler", "--features glsl"]);
}

#[test]
fn containers_without_metadata_say_so_and_are_identified() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    for file in ["a.dds", "b.npy"] {
        let output = run(here, &["bake", "split-sum", "-o", file, "--size", "32"]);
        assert!(output.status.success() && text(&output.stderr).contains("does not say what it holds"), "{file}");
        assert!(succeeds(here, &["verify", file]).contains("identified"), "{file}");
    }
}

#[test]
fn levels_are_compressed_and_blocks_searched_as_asked() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let size = |file: &str| std::fs::metadata(here.join(file)).unwrap().len();
    succeeds(here, &["bake", "split-sum", "-o", "a.ktx2", "--size", "64"]);
    succeeds(here, &["bake", "split-sum", "-o", "b.ktx2", "--size", "64", "--compression", "zstd"]);
    assert!(size("b.ktx2") < size("a.ktx2"));
    assert!(succeeds(here, &["verify", "b.ktx2"]).contains("right"));
    let bake = |quality: &str| {
        let options = ["--size", "64", "--encoding", "bc5", "--bc-quality", quality, "--json"];
        let line = succeeds(here, &[&["bake", "split-sum", "-o", "c.ktx2"][..], &options].concat());
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        value["rounding_rms"].as_f64().unwrap()
    };
    assert!(bake("slow") < bake("fast"));
    assert!(succeeds(here, &["info", "c.ktx2"]).contains("encoding.error.relative.rms"));
    let zstd = ["bake", "split-sum", "-o", "d.exr", "--compression", "zstd"];
    fails(here, &zstd, &["OpenEXR is not compressed by zstd", "drop --compression, or write a .ktx2 file"]);
    fails(here, &["bake", "split-sum", "-o", "d.ktx2", "--compression", "lzma"], &["unknown compression 'lzma'"]);
    fails(here, &["bake", "split-sum", "-o", "d.ktx2", "--bc-quality", "best"], &["unknown effort 'best'", "slow"]);
}

#[test]
fn blocks_of_a_sky_keep_filtered_radiance_to_one_per_cent() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    succeeds(here, &["sky", "-o", "sky.exr", "--size", "256", "--elevation", "25", "--sun-disc", "--exposure", "-5"]);
    let env = ["env", "sky.exr", "-o", "sky.ktx2", "--size", "128", "--encoding", "bc6h"];
    let line = succeeds(here, &[&env[..], &["--json"]].concat());
    let value: serde_json::Value = serde_json::from_str(&line).unwrap();
    let per_cent = |loss: &serde_json::Value, key: &str| 100.0 * loss[key].as_f64().unwrap();
    let mips = value["rounding_mips"].as_array().unwrap();
    assert_eq!(mips.len(), 8);
    let filtered = &value["rounding_filtered"];
    let relative = per_cent(filtered, "relative_rms");
    println!("{relative:.2} % relative rms, {:.2} % of the rms", per_cent(filtered, "rms"));
    assert!((0.1..1.0).contains(&relative), "{relative}");
    assert!(per_cent(filtered, "rms") < 3.5, "{filtered}");
    // Mip 1 has three quarters of their texels, mip 2 three sixteenths.
    let parts = [0.75, 0.1875].iter().zip(&mips[1..]).map(|(share, mip)| share * per_cent(mip, "relative_rms").powi(2));
    assert!(parts.sum::<f64>() < relative.powi(2));

    // All mips lie between mip 0 and the filtered ones, nearer to mip 0, which has most texels.
    let [first, whole] = [&mips[0], &value["rounding_whole"]].map(|loss| per_cent(loss, "relative_rms"));
    assert!(0.5 * (first + relative) < whole && whole < first, "{relative} {whole} {first}");

    // In words, and in the file; with the way out where mip 0 loses more than filtered mips may.
    let text = succeeds(here, &env);
    let help = "a larger --size loses less";
    assert!(text.contains(help), "{text}");
    let expected = format!("\n  mips 1-7   bc6h loses {relative:.2} % of each value (relative rms), ");
    assert!(text.contains(&expected), "{text}");
    assert_eq!(text.lines().filter(|line| line.contains("bc6h loses")).count(), 10, "{text}");
    assert!(text.contains("\n  all mips   bc6h loses "), "{text}");
    // Less than half as much at eight times the size, which is what is baked unless told otherwise.
    let large = succeeds(here, &["env", "sky.exr", "-o", "large.ktx2", "--encoding", "bc6h", "--quality", "draft"]);
    assert!(large.contains("6x1024x1024") && !large.contains(help), "{large}");
    let info: serde_json::Value = serde_json::from_str(&succeeds(here, &["info", "large.ktx2", "--json"])).unwrap();
    let stated = |key: &str| -> f64 {
        let text = &info["meta"][format!("encoding.error.{key}")];
        100.0 * text.as_str().unwrap_or_else(|| panic!("{key}: {info}")).parse::<f64>().unwrap()
    };
    assert!(stated("filtered.relative.rms") < 0.5 * relative && stated("whole.relative.rms") < 1.0, "{large}");
    assert!(stated("filtered.rms") < 3.5 && stated("whole.rms") < 5.0, "{large}");
}

#[test]
fn environments_go_into_the_containers_of_engines() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    picture(&here.join("a.hdr"), (64, 32), |x, y| 1.0 + ((x / 8 + y / 8) % 2) as f32);
    for (file, encoding) in
        [("a.env", "rgbd8"), ("b.ktx", "b10g11r11"), ("c.ktx2", "bc6h"), ("d.ktx2", "rgb9e5"), ("e.ktx2", "rgbm8")]
    {
        let line = succeeds(here, &["env", "a.hdr", "-o", file, "--size", "16", "--encoding", encoding]);
        assert!(line.contains(encoding), "{line}");
        assert!(succeeds(here, &["verify", file]).contains("right"), "{file}");
        assert!(succeeds(here, &["verify", file, "--source", "a.hdr"]).contains("right"), "{file}");
        assert!(succeeds(here, &["info", file]).contains("sh.irradiance"), "{file}");
    }
    succeeds(here, &["env", "a.hdr", "-o", "f.dds", "--size", "16"]);
    fails(here, &["env", "a.hdr", "-o", "g.env", "--size", "24"], &["Babylon.js reads no cube of 24 texels"]);
    fails(here, &["env", "a.hdr", "-o", "g.env", "--size", "16", "--mips", "3"], &["with 3 mips"]);
    fails(here, &["env", "a.hdr", "-o", "g.ktx2", "--encoding", "rgba8unorm"], &["does not hold encoding rgba8unorm"]);
}

#[test]
fn json_is_one_object_a_line() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    for arguments in [
        vec!["bake", "split-sum", "-o", "a.ktx2", "--size", "32x16", "--json"],
        vec!["verify", "a.ktx2", "--json"],
        vec!["info", "a.ktx2", "--json"],
        vec!["list", "--json"],
    ] {
        for line in succeeds(here, &arguments).lines() {
            let value: serde_json::Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
            assert!(value.is_object());
            if arguments[0] == "bake" {
                assert_eq!((&value["width"], &value["height"]), (&32.into(), &16.into()));
                assert!(value["max_error"].as_f64().unwrap() <= 1e-6);
            }
            if arguments[0] == "verify" {
                assert_eq!(value["passed"], true);
            }
        }
    }
}

#[test]
fn every_flag_is_stated_in_the_file() {
    let folder = TempDir::new().unwrap();
    let arguments = [
        "bake",
        "split-sum",
        "-o",
        "a.ktx2",
        "--size",
        "16x8",
        "--visibility",
        "smith-uncorrelated",
        "--ndf",
        "ggx",
        "--axes",
        "roughness,n_dot_v",
        "--points",
        "edges",
        "--flip-v",
        "--channels",
        "bias,albedo",
        "--encoding",
        "rg32f",
    ];
    succeeds(folder.path(), &arguments);
    let info: serde_json::Value =
        serde_json::from_str(&succeeds(folder.path(), &["info", "a.ktx2", "--json"])).unwrap();
    assert_eq!((&info["width"], &info["height"]), (&16.into(), &8.into()));
    assert_eq!(info["encoding"], "rg32f");
    assert_eq!(info["channels"], serde_json::json!(["bias", "albedo"]));
    for (key, value) in [
        ("visibility", "smith-uncorrelated"),
        ("axes", "roughness,n_dot_v"),
        ("points", "edges"),
        ("order", "ascending,descending"),
    ] {
        assert_eq!(info["meta"][key], value, "{key}");
    }
    assert!(succeeds(folder.path(), &["verify", "a.ktx2", "--full"]).contains("right"));
}

#[test]
fn bad_requests_are_refused_before_any_work() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    std::fs::create_dir(here.join("folder.ktx2")).unwrap();
    let bake = |extra: &[&'static str]| [&["bake", "split-sum", "-o", "out.ktx2"], extra].concat();
    for (arguments, words) in [
        (bake(&["--size", "0"]), vec!["0 texels", "--size"]),
        (bake(&["--size", "100000"]), vec!["100000", "8192"]),
        (bake(&["--size", "big"]), vec!["big"]),
        (bake(&["--points", "edges", "--size", "1"]), vec!["1 texels", "from 2"]),
        (bake(&["--ndf", "gxg"]), vec!["gxg", "did you mean 'ggx'"]),
        (bake(&["--visibility", "smiht"]), vec!["smiht", "did you mean 'smith'"]),
        (bake(&["--axes", "n_dot_v"]), vec!["axes", "n_dot_v,roughness"]),
        (bake(&["--axes", "n_dot_v,n_dot_v"]), vec!["axes"]),
        (bake(&["--axes", "n_dot_v,rough"]), vec!["rough", "known are"]),
        (bake(&["--channels", "scael"]), vec!["scael", "did you mean 'scale'"]),
        (bake(&["--points", "corners"]), vec!["corners", "centers"]),
        (bake(&["--encoding", "rg15f"]), vec!["rg15f", "did you mean 'rg16f'"]),
        (bake(&["--encoding", "r16f"]), vec!["r16f"]),
        (bake(&["--encoding", "rgbe8"]), vec!["rgbe8", "KTX2"]),
        (bake(&["--sizes", "4"]), vec!["--sizes", "--size"]),
        (vec!["bake", "split-sums", "-o", "out.ktx2"], vec!["split-sums", "did you mean 'split-sum'"]),
        (vec!["bake", "split-sum", "-o", "out.tga"], vec!["tga", "ktx2"]),
        (vec!["bake", "split-sum", "-o", "out"], vec!["out", "extension"]),
        (vec!["bake", "split-sum", "-o", "missing/out.ktx2"], vec!["missing/out.ktx2", "create the folder"]),
        (vec!["bake", "split-sum", "-o", "folder.ktx2"], vec!["folder.ktx2"]),
        (vec!["bake", "average-albedo", "-o", "out.ktx2", "--size", "8x4"], vec!["one axis", "--size 8"]),
        (vec!["verify", "missing.ktx2"], vec!["missing.ktx2"]),
        (vec!["info", "folder.ktx2"], vec!["folder.ktx2"]),
    ] {
        fails(here, &arguments, &words);
    }
}

/// An equirectangular picture as a Radiance or OpenEXR file.
fn picture(path: &Path, (width, height): (usize, usize), at: impl Fn(usize, usize) -> f32 + Sync) {
    if path.extension() == Some("exr".as_ref()) {
        exr::prelude::write_rgb_file(path, width, height, |x, y| (at(x, y), 0.5 * at(x, y), 0.25f32)).unwrap();
        return;
    }
    let texels: Vec<image::Rgb<f32>> =
        (0..width * height).map(|i| image::Rgb([at(i % width, i / width), 0.5, 0.25])).collect();
    let file = std::fs::File::create(path).unwrap();
    image::codecs::hdr::HdrEncoder::new(file).encode(&texels, width, height).unwrap();
}

#[test]
fn environment_is_baked_verified_and_described() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    for (input, output, law) in
        [("a.hdr", "a.ktx2", "linear"), ("b.exr", "b.exr.ktx2", "quadratic"), ("a.hdr", "c.exr", "linear")]
    {
        picture(&here.join(input), (64, 32), |x, y| 1.0 + ((x / 8 + y / 8) % 2) as f32);
        let line = succeeds(here, &["env", input, "-o", output, "--size", "16", "--roughness-law", law]);
        assert!(line.starts_with(output) && line.contains("5 mips") && line.trim_end().ends_with("cpu"), "{line}");
        assert!(succeeds(here, &["verify", output]).contains("right"));
        assert!(succeeds(here, &["verify", output, "--source", input]).contains("right"));
        let info = succeeds(here, &["info", output]);
        for word in ["cube", "ggx", law, "orientation", "error.relative.worst", input] {
            assert!(info.contains(word), "'{word}' is not in: {info}");
        }
    }
    picture(&here.join("d.hdr"), (64, 32), |x, _| 1.0 + x as f32);
    assert_eq!(run(here, &["verify", "a.ktx2", "--source", "d.hdr"]).status.code(), Some(1));
}

#[test]
fn bad_environments_are_refused_before_any_work() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    picture(&here.join("good.hdr"), (32, 16), |_, _| 1.0);
    picture(&here.join("square.hdr"), (16, 16), |_, _| 1.0);
    picture(&here.join("nan.exr"), (32, 16), |x, y| if (x, y) == (5, 3) { f32::NAN } else { 1.0 });
    picture(&here.join("infinite.exr"), (32, 16), |x, y| if (x, y) == (7, 2) { f32::INFINITY } else { 1.0 });
    std::fs::write(here.join("text.exr"), "just a line of text").unwrap();
    std::fs::write(here.join("text.hdr"), "just a line of text").unwrap();
    std::fs::create_dir(here.join("folder.exr")).unwrap();
    for name in ["good.hdr", "nan.exr"] {
        let bytes = std::fs::read(here.join(name)).unwrap();
        std::fs::write(here.join(format!("cut.{}", &name[name.len() - 3..])), &bytes[..bytes.len() * 2 / 3]).unwrap();
    }
    let env = |input: &'static str, extra: &[&'static str]| [&["env", input, "-o", "out.ktx2"], extra].concat();
    for (arguments, words) in [
        (env("missing.hdr", &[]), vec!["missing.hdr", "path"]),
        (env("folder.exr", &[]), vec!["folder.exr"]),
        (env("text.exr", &[]), vec!["text.exr"]),
        (env("text.hdr", &[]), vec!["text.hdr"]),
        (env("cut.hdr", &[]), vec!["cut.hdr"]),
        (env("cut.exr", &[]), vec!["cut.exr"]),
        (env("square.hdr", &[]), vec!["square.hdr", "16x16", "equirect 2:1", "cross 4:3"]),
        (env("nan.exr", &[]), vec!["nan.exr", "1 of its texels", "column 5, row 3", "--repair"]),
        (env("good.hdr", &["--layout", "crosss"]), vec!["crosss", "did you mean 'cross'"]),
        (env("good.hdr", &["--layout", "cross"]), vec!["good.hdr", "32x16", "4:3"]),
        (env("good.hdr", &["--color", "sRGB"]), vec!["sRGB", "srgb, linear"]),
        (env("good.hdr", &["--color", "srgb"]), vec!["--color srgb", "good.hdr", "floats"]),
        (env("good.hdr", &["--part", "left"]), vec!["--part", "good.hdr", "OpenEXR"]),
        (env("good.hdr", &["--rotate-xyz", "1,2"]), vec!["1,2", "X,Y,Z"]),
        (env("good.hdr", &["--rotate", "inf"]), vec!["inf"]),
        (env("good.hdr", &["--rotate", "1", "--rotate-xyz", "1,2,3"]), vec!["--rotate-xyz"]),
        (env("good.hdr", &["--scale", "-1"]), vec!["-1", "above 0"]),
        (env("good.hdr", &["--clamp", "0"]), vec!["0", "above 0"]),
        (env("good.hdr", &["--exposure", "1000"]), vec!["1000", "64"]),
        (env("infinite.exr", &[]), vec!["infinite.exr", "7", "2"]),
        (env("good.hdr", &["--size", "0"]), vec!["0 texels", "--size"]),
        (env("good.hdr", &["--size", "100000"]), vec!["100000", "4096"]),
        (env("good.hdr", &["--mips", "0"]), vec!["0 mips", "--mips"]),
        (env("good.hdr", &["--mips", "10"]), vec!["10 mips", "9"]),
        (env("good.hdr", &["--kernel", "gxg"]), vec!["gxg", "ggx"]),
        (env("good.hdr", &["--roughness-law", "liner"]), vec!["liner", "did you mean 'linear'"]),
        (env("good.hdr", &["--encoding", "rg16f"]), vec!["rg16f"]),
        (vec!["env", "good.hdr", "-o", "out.png"], vec!["PNG", "ktx2"]),
        (vec!["env", "good.hdr", "-o", "missing/out.ktx2"], vec!["missing/out.ktx2"]),
    ] {
        fails(here, &arguments, &words);
    }
}

#[test]
fn every_way_to_give_an_environment_is_baked_and_verified() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let uneven = |x: usize, y: usize| 1.0 + ((x / 5 + y / 3) % 3) as f32;
    picture(&here.join("panorama.exr"), (64, 32), uneven);
    picture(&here.join("cross.exr"), (64, 48), uneven);
    picture(&here.join("cross.hdr"), (48, 64), uneven);
    picture(&here.join("strip.exr"), (96, 16), uneven);
    picture(&here.join("standing.exr"), (16, 96), uneven);
    std::fs::create_dir(here.join("faces")).unwrap();
    for (i, name) in ["px", "nx", "py", "ny", "pz", "nz"].iter().enumerate() {
        picture(&here.join(format!("faces/{name}.exr")), (16, 16), |x, y| uneven(x + 7 * i, y));
    }
    image::RgbImage::from_fn(64, 32, |x, y| image::Rgb([x as u8, 4 * y as u8, 90])).save(here.join("p.png")).unwrap();
    let bake = |input: &str, extra: &[&str]| {
        let arguments = [&["env", input, "-o", "out.ktx2", "--size", "16"], extra].concat();
        let output = run(here, &arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        let verdict = succeeds(here, &["verify", "out.ktx2", "--source", input]);
        assert!(verdict.contains("right"), "{arguments:?}: {verdict}");
        (succeeds(here, &["info", "out.ktx2"]), text(&output.stderr))
    };
    let turned = ["--rotate-xyz", "10,-20,30", "--mirror", "--exposure", "-1.5", "--scale", "3", "--clamp", "2"];
    for (input, layout) in [
        ("panorama.exr", "equirect"),
        ("cross.exr", "cross"),
        ("cross.hdr", "vertical-cross"),
        ("strip.exr", "strip"),
        ("standing.exr", "vertical-strip"),
        ("faces", "faces"),
        ("faces/{face}.exr", "faces"),
        ("faces/px.exr,faces/nx.exr,faces/py.exr,faces/ny.exr,faces/pz.exr,faces/nz.exr", "faces"),
    ] {
        for extra in [&[] as &[&str], &turned] {
            let (info, warnings) = bake(input, extra);
            assert!(info.lines().any(|l| l.contains("input.layout") && l.ends_with(&format!(" {layout}"))), "{info}");
            // The clamp takes a part of the energy, and says which.
            assert_eq!(warnings.contains("% of its mean radiance"), !extra.is_empty(), "{warnings}");
            assert_eq!(info.contains("input.clamp.removed"), !extra.is_empty(), "{info}");
        }
    }
    bake("p.png", &["--color", "linear", "--rotate", "45"]);

    // A cube that was baked is an input as well, in both containers.
    for copy in ["copy.ktx2", "copy.exr"] {
        succeeds(here, &["env", "cross.exr", "-o", copy, "--size", "16", "--encoding", "rgba32f"]);
        bake(copy, &["--rotate", "90"]);
    }

    // A file that says another turn is wrong.
    bake("cross.exr", &["--rotate", "30"]);
    let mut bytes = std::fs::read(here.join("out.ktx2")).unwrap();
    let at = bytes.windows(6).position(|w| w == b"0,30,0").unwrap();
    bytes[at + 2] = b'7';
    std::fs::write(here.join("wrong.ktx2"), bytes).unwrap();
    assert_eq!(run(here, &["verify", "wrong.ktx2", "--source", "cross.exr"]).status.code(), Some(1));
}

#[test]
fn texels_that_are_not_finite_are_repaired_with_a_warning() {
    let folder = TempDir::new().unwrap();
    picture(&folder.path().join("a.exr"), (32, 16), |x, y| if y == 3 && x < 2 { f32::NAN } else { 1.0 });
    let output = run(folder.path(), &["env", "a.exr", "-o", "a.ktx2", "--size", "8", "--repair"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("2 texels of 'a.exr'"), "{}", text(&output.stderr));
    assert!(succeeds(folder.path(), &["info", "a.ktx2"]).contains("2 texels"));
    assert!(succeeds(folder.path(), &["verify", "a.ktx2", "--source", "a.exr"]).contains("right"));
}

#[test]
fn negative_texels_are_clamped_with_a_warning_that_counts_them() {
    let folder = TempDir::new().unwrap();
    picture(&folder.path().join("a.exr"), (32, 16), |x, _| if x < 2 { -1.5 } else { 1.0 });
    let output = run(folder.path(), &["env", "a.exr", "-o", "a.ktx2", "--size", "8"]);
    assert!(output.status.success());
    let stderr = text(&output.stderr);
    assert!(stderr.contains("32 negative texels") && stderr.contains("-1.5"), "{stderr}");
}

#[test]
fn values_beyond_half_float_are_clamped_with_a_warning() {
    let folder = TempDir::new().unwrap();
    picture(&folder.path().join("a.exr"), (32, 16), |x, y| if (x, y) == (9, 6) { 1e6 } else { 1.0 });
    let output = run(folder.path(), &["env", "a.exr", "-o", "a.ktx2", "--size", "16"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("rgba32f"), "{}", text(&output.stderr));
}

#[test]
fn file_that_is_not_what_its_name_says_is_refused() {
    let folder = TempDir::new().unwrap();
    for name in ["a.ktx2", "a.exr", "a.hdr", "a.png"] {
        std::fs::write(folder.path().join(name), "just a line of text\n").unwrap();
        fails(folder.path(), &["info", name], &[name]);
        fails(folder.path(), &["verify", name], &[name]);
    }
}

#[test]
fn missing_device_is_an_error_that_lists_those_found() {
    let folder = TempDir::new().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_brdf-baker"))
        .current_dir(folder.path())
        .args(["bake", "split-sum", "-o", "out.ktx2", "--device", "no such device"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let stderr = text(&output.stderr);
    assert!(
        stderr.contains("no such device") && stderr.contains("found:") || stderr.contains("no Vulkan loader"),
        "{stderr}"
    );
    assert!(files(folder.path()).is_empty());
}

#[test]
fn without_a_driver_auto_bakes_on_the_processor_and_says_so() {
    let folder = TempDir::new().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_brdf-baker"))
        .current_dir(folder.path())
        .args(["bake", "albedo", "-o", "out.ktx2", "--size", "16"])
        // A loader that finds no driver reports no device.
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .env("VK_ICD_FILENAMES", "/nonexistent.json")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).trim_end().ends_with("cpu"));
}

#[test]
fn wrong_file_fails_verification_with_exit_code_1() {
    let folder = TempDir::new().unwrap();
    succeeds(folder.path(), &["bake", "split-sum", "-o", "a.ktx2", "--size", "32"]);
    let path = folder.path().join("a.ktx2");
    let mut bytes = std::fs::read(&path).unwrap();
    // The last level ends the file: move its rows by one.
    let texels = bytes.len() - 32 * 32 * 4;
    bytes[texels..].rotate_right(32 * 4);
    std::fs::write(&path, bytes).unwrap();
    let output = run(folder.path(), &["verify", "a.ktx2"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("WRONG") && text(&output.stderr).contains("instead of"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_with_130_and_leaves_no_file() {
    let folder = TempDir::new().unwrap();
    let mut child = command(folder.path(), &["bake", "split-sum", "-o", "out.ktx2", "--size", "4096"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(500));
    // The shell's own `kill`: a minimal system has no other.
    let killed = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(files(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_command_that_does_not_look() {
    let (folder, source) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    // Opening a pipe that nobody writes to waits for ever.
    let pipe = source.path().join("pipe.hdr");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut child = command(folder.path(), &["env", pipe.to_str().unwrap(), "-o", "out.ktx2"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Its temporary file is there before it reads.
    let start = std::time::Instant::now();
    while files(folder.path()).is_empty() {
        assert!(start.elapsed().as_secs() < 30, "no temporary file");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(files(folder.path()).is_empty());
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
    assert_eq!(said, "error: cancelled\n");
}

#[cfg(unix)]
#[test]
fn ctrl_c_at_any_moment_leaves_a_whole_file_or_none() {
    let folder = TempDir::new().unwrap();
    let picture = Equirect::from_fn(128, |u, v| [u as f32, v as f32, 1.0]);
    let texel = |x: usize, y: usize| {
        let [r, g, b] = picture.texels[y * 256 + x];
        (r, g, b)
    };
    exr::prelude::write_rgb_file(folder.path().join("sky.exr"), 256, 128, texel).unwrap();
    for wait_ms in (0..400).step_by(40) {
        let mut child = command(folder.path(), &["env", "sky.exr", "-o", "out.ktx2", "--size", "64"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait_ms));
        let _ = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).stderr(Stdio::null()).status();
        let status = child.wait().unwrap();
        let mut found = files(folder.path());
        found.retain(|path| !path.ends_with("sky.exr"));
        if found.is_empty() {
            // Before the handler is in place, the signal ends the process.
            assert!(status.code().is_none_or(|code| code == 130), "{wait_ms} ms: {status}");
        } else {
            assert_eq!(found, [folder.path().join("out.ktx2")], "{wait_ms} ms");
            assert!(matches!(status.code(), Some(0 | 130)), "{wait_ms} ms: {status}");
            succeeds(folder.path(), &["info", "out.ktx2"]);
            std::fs::remove_file(folder.path().join("out.ktx2")).unwrap();
        }
    }
}

#[cfg(unix)]
#[test]
fn unwritable_folder_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let folder = TempDir::new().unwrap();
    let locked = folder.path().join("locked");
    std::fs::create_dir(&locked).unwrap();
    std::fs::set_permissions(&locked, PermissionsExt::from_mode(0o555)).unwrap();
    // The superuser may write anywhere; /proc refuses even that.
    let target = if std::fs::write(locked.join("probe"), "").is_ok() { "/proc/out.ktx2" } else { "locked/out.ktx2" };
    let output = run(folder.path(), &["bake", "split-sum", "-o", target]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains(target), "{}", text(&output.stderr));
}

#[test]
fn help_of_each_command_ends_with_examples() {
    let folder = TempDir::new().unwrap();
    for command in [
        "bake",
        "env",
        "run",
        "sky",
        "curves",
        "preview",
        "verify",
        "identify",
        "info",
        "devices",
        "list",
        "materials",
        "completions",
    ] {
        let help =
            text(&Command::new(env!("CARGO_BIN_EXE_brdf-baker")).args([command, "--help"]).output().unwrap().stdout);
        let examples = help.split("Examples:").nth(1).unwrap_or_else(|| panic!("{command} --help has no examples"));
        assert!(examples.lines().filter(|l| l.trim().starts_with("brdf-baker ")).count() >= 2, "{command}");
    }
    assert!(succeeds(folder.path(), &["completions", "bash"]).contains("brdf-baker"));
}

#[test]
fn exact_fresnel_terms_are_baked_verified_and_described() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    for (options, channels, words) in [
        (vec!["--material", "copper"], "red,green,blue", ["conductor:eta=", "copper"]),
        (vec!["--eta-k", "0.2,3.9"], "red,green,blue", ["conductor:eta=0.2/0.2/0.2,k=3.9/3.9/3.9", "ggx"]),
        (vec!["--eta-k", "0.2,1.1,1.25,3.9,2.6,2.3"], "red,green,blue", ["eta=0.2/1.1/1.25,k=3.9/2.6/2.3", "ggx"]),
        (vec!["--material", "water"], "reflected", ["dielectric:ior=1.33", "water"]),
        (vec!["--ior", "0.7"], "reflected", ["dielectric:ior=0.7", "ggx"]),
    ] {
        for table in ["albedo", "average-albedo"] {
            let mut arguments = vec!["bake", table, "-o", "x.exr", "--size", "8"];
            arguments.extend(&options);
            succeeds(here, &arguments);
            assert!(succeeds(here, &["verify", "x.exr"]).contains("right"));
            let info = succeeds(here, &["info", "x.exr"]);
            assert!(info.contains(channels) && words.iter().all(|w| info.contains(w)), "{info}");
        }
    }
    let bake = |options: &[&'static str]| [&["bake", "albedo", "-o", "y.exr"], options].concat();
    fails(here, &bake(&["--ior", "1"]), &["refractive index of 1", "0.2 to 5"]);
    fails(here, &bake(&["--ior", "1.5", "--material", "gold"]), &["--ior", "--material"]);
    fails(here, &bake(&["--material", "coper"]), &["unknown material 'coper'", "copper"]);
    fails(here, &bake(&["--eta-k", "1,2,3"]), &["3 numbers", "give 2"]);
    fails(here, &bake(&["--eta-k", "0.5,0"]), &["no extinction"]);
    fails(here, &bake(&["--ndf", "ggx:ratio=0.5", "--visibility", "neumann"]), &["not smooth", "smith"]);
    fails(here, &bake(&["--channels", "red"]), &["no channel 'red'", "albedo"]);
}

#[test]
fn one_environment_gives_specular_irradiance_and_harmonics() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    picture(&here.join("sky.hdr"), (64, 32), |x, y| 1.0 + ((x / 8 + y / 8) % 2) as f32);
    let all = ["env", "sky.hdr", "-o", "a.ktx2", "--size", "16", "--shape", "octahedral", "--irradiance", "i.hdr"];
    let rest = ["--irradiance-size", "8", "--sh", "s.json", "--sh-order", "3", "--sh-window", "hanning", "--json"];
    // A cube or an octahedral map of one level: .hdr holds the latter.
    let lines = succeeds(here, &[&all[..], &rest[..]].concat());
    let lines: Vec<serde_json::Value> = lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let paths: Vec<&str> = lines.iter().map(|l| l["path"].as_str().unwrap()).collect();
    assert_eq!(paths, ["a.ktx2", "i.hdr", "s.json"]);
    let sh: serde_json::Value = serde_json::from_slice(&std::fs::read(here.join("s.json")).unwrap()).unwrap();
    assert_eq!(sh["basis"].as_array().unwrap().len(), 16);
    assert_eq!(sh["radiance"]["coefficients"].as_array().unwrap().len(), 16);
    for file in ["a.ktx2", "i.hdr"] {
        assert!(succeeds(here, &["verify", file, "--source", "sky.hdr"]).contains("right"), "{file}");
    }
    fails(here, &["env", "sky.hdr", "-o", "b.hdr", "--shape", "equirect"], &["holds one level", "--mips 1"]);
}

#[test]
fn foreign_tables_are_identified_and_verified() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let bake = ["bake", "split-sum", "-o", "a.png", "--size", "48x32", "--encoding", "rgb8unorm", "--flip-v"];
    succeeds(here, &[&bake as &[&str], &["--visibility", "schlick-ggx"]].concat());
    // Without its texts it says nothing, and has an alpha channel as pictures have.
    image::open(here.join("a.png")).unwrap().to_rgba8().save(here.join("b.png")).unwrap();
    let line = succeeds(here, &["identify", "b.png"]);
    for words in
        ["b.png  48x32", "certain", "R = scale, G = bias", "roughness descending", "schlick-ggx", "1 differs from 2"]
    {
        assert!(line.contains(words), "'{words}' is not in: {line}");
    }
    let json: serde_json::Value = serde_json::from_str(&succeeds(here, &["identify", "b.png", "--json"])).unwrap();
    assert_eq!((&json["verdict"], &json["fits"][0]["geometry"]), (&"certain".into(), &"schlick-ggx".into()));
    assert!(json["fits"][0]["max_error"].as_f64().unwrap() <= 0.5 / 255.0 + 1e-6);

    // What cannot be told from the texels is not hidden.
    succeeds(here, &["bake", "albedo", "-o", "copper.exr", "--size", "16", "--material", "copper"]);
    let output = run(here, &["identify", "copper.exr"]);
    let line = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        line.contains("none") && line.contains("says of itself: red,green,blue of albedo ggx smith conductor"),
        "{line}"
    );

    // Verified as what it is found to be, and as what it is said to be.
    assert!(succeeds(here, &["verify", "b.png"]).contains("identified, certain): right"));
    let said = ["verify", "b.png", "--ndf", "ggx", "--visibility", "schlick-ggx", "--flip-v"];
    assert!(succeeds(here, &said).contains("stated): right"));
    for (extra, code) in [
        (vec!["--max-error", "0.002"], 0),
        (vec!["--max-error", "0.0001"], 1),
        (vec!["--ndf", "ggx", "--visibility", "smith", "--flip-v"], 1),
        (vec!["--ndf", "ggx", "--visibility", "schlick-ggx"], 1),
    ] {
        let output = run(here, &[vec!["verify", "b.png"], extra.clone()].concat());
        assert_eq!(output.status.code(), Some(code), "{extra:?}: {}", text(&output.stderr));
    }

    // Bare texels, rows from the top.
    let texels: Vec<u8> = image::open(here.join("a.png")).unwrap().to_rgb8().into_raw();
    std::fs::write(here.join("c.bin"), &texels).unwrap();
    let raw = ["identify", "c.bin", "--size", "48x32", "--encoding", "rgb8unorm"];
    assert!(succeeds(here, &raw).contains("schlick-ggx"));

    // What is no table ends with 1, what cannot be read with 2.
    image::RgbImage::from_fn(32, 32, |x, y| image::Rgb([(x * 8) as u8, (y * 8) as u8, 90]))
        .save(here.join("d.png"))
        .unwrap();
    for command in ["identify", "verify"] {
        let output = run(here, &[command, "d.png"]);
        assert_eq!(output.status.code(), Some(1), "{command}: {}", text(&output.stderr));
    }
    assert!(text(&run(here, &["identify", "d.png"]).stdout).contains("none"));
    image::RgbImage::from_pixel(3, 3, image::Rgb([1, 2, 3])).save(here.join("e.png")).unwrap();
    fails(here, &["identify", "e.png"], &["3x3", "at least 4"]);
    fails(here, &["identify", "c.bin"], &["c.bin", "--size WxH --encoding"]);
    fails(here, &["identify", "c.bin", "--size", "48"], &["--encoding"]);
    fails(here, &["identify", "c.bin", "--size", "40", "--encoding", "rgb8unorm"], &["4608 bytes", "4800"]);
    fails(here, &["identify", "missing.png"], &["missing.png"]);
    fails(here, &["verify", "b.png", "--ndf", "ggx", "--visibility", "smiht"], &["smiht", "smith"]);
    fails(here, &["verify", "a.png", "--ndf", "ggx", "--visibility", "smith"], &["a.png", "says itself", "--ndf"]);
    std::fs::write(here.join("cut.png"), &std::fs::read(here.join("b.png")).unwrap()[..900]).unwrap();
    fails(here, &["identify", "cut.png"], &["cut.png", "PNG"]);
}

#[test]
fn lists_come_from_the_registries() {
    let folder = TempDir::new().unwrap();
    let all = succeeds(folder.path(), &["list"]);
    for name in ["split-sum", "albedo", "average-albedo", "ggx", "smith-uncorrelated", "conductor", "rg16f"] {
        assert!(all.contains(name), "{name}");
    }
    let tables = succeeds(folder.path(), &["list", "tables"]);
    assert!(tables.contains("split-sum") && !tables.contains("rg16f"));
}

#[test]
fn a_sky_is_written_described_and_filtered() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let small = ["sky", "-o", "sky.exr", "--size", "32", "--elevation", "30", "--sun-disc", "--json"];
    let line: serde_json::Value = serde_json::from_str(&succeeds(here, &small)).unwrap();
    assert_eq!((&line["width"], &line["height"]), (&64.into(), &32.into()));
    assert_eq!(line["encoding"], "rgba16f", "of these texels the sun fills a small part");
    assert!((line["sun_direction"][1].as_f64().unwrap() - 0.5).abs() < 1e-12);
    let fine = [&small[..2], &["sun.exr", "--size", "512", "--sun-disc", "--json"]].concat();
    let line: serde_json::Value = serde_json::from_str(&succeeds(here, &fine)).unwrap();
    assert_eq!(line["encoding"], "rgba32f", "half floats end below the sun");
    assert_eq!(line["clamped"], 0);
    let info = succeeds(here, &["info", "sky.exr"]);
    for word in ["Preetham", "turbidity", "kcd/m2", "30 degrees", "equirect"] {
        assert!(info.contains(word), "'{word}' is not in: {info}");
    }
    succeeds(here, &["env", "sky.exr", "-o", "sky.ktx2", "--size", "16"]);
    succeeds(here, &["sky", "-o", "sky.hdr", "--size", "16", "--exposure", "-5", "--ground", "0.3,0.2,0.1"]);
    fails(here, &["sky", "-o", "a.exr", "--turbidity", "1"], &["turbidity", "2 to 10"]);
    fails(here, &["sky", "-o", "a.exr", "--elevation", "-5"], &["elevation", "0 to 90"]);
    fails(here, &["sky", "-o", "a.exr", "--ground", "0.1,0.2"], &["--ground", "three"]);
    fails(here, &["sky", "-o", "a.exr", "--exposure", "-400"], &["--exposure"]);
    fails(here, &["sky", "-o", "a.png"], &["a.png", ".exr"]);
    fails(here, &["sky", "-o", "a.exr", "--size", "0"], &["--size from 1"]);
}

#[test]
fn curves_and_tables_are_drawn() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    succeeds(here, &["bake", "split-sum", "-o", "dfg.ktx2", "--size", "16"]);
    for plot in ["d", "g", "f", "lobe", "polar"] {
        succeeds(here, &["curves", "-o", "a.svg", "--plot", plot]);
        let svg = std::fs::read_to_string(here.join("a.svg")).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{plot}");
    }
    let curve = "beckmann alpha=0.748 schlick-beckmann";
    let line = succeeds(here, &["curves", "-o", "b.png", "--curve", curve, "--curve", "phong copper", "--json"]);
    let line: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!((&line["width"], &line["curves"][0]), (&800.into(), &curve.into()));
    let line = succeeds(here, &["curves", "dfg.ktx2", "-o", "c.png"]);
    assert!(line.contains("760x338") && line.contains("scale, bias"), "{line}");
    let picture = image::open(here.join("c.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (760, 338));
    succeeds(here, &["sky", "-o", "sky.exr", "--size", "16"]);
    fails(here, &["curves", "sky.exr", "-o", "d.png"], &["sky.exr", "environment", "preview"]);
    fails(here, &["curves", "-o", "d.pdf"], &["d.pdf", ".svg"]);
    fails(here, &["curves", "-o", "d.svg", "--plot", "h"], &["unknown plot 'h'", "polar"]);
    fails(here, &["curves", "-o", "d.svg", "--curve", "bekmann"], &["'bekmann'", "beckmann"]);
    fails(here, &["curves", "-o", "d.svg", "--curve", "gtr:gamma=99"], &["gamma", "99"]);
    fails(here, &["curves", "-o", "d.svg", "--curve", "alpha=2"], &["alpha", "'2'", "0.001 to 1"]);
    fails(here, &["curves", "-o", "d.svg", "--view", "95"], &["95", "0 to 89"]);
    fails(here, &["curves", "-o", "d.svg", "--size", "10x10"], &["10x10", "200x150"]);
}

#[test]
fn spheres_are_drawn_from_files() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    succeeds(here, &["sky", "-o", "sky.exr", "--size", "32"]);
    succeeds(
        here,
        &["env", "sky.exr", "-o", "sky.ktx2", "--size", "16", "--mips", "2", "--irradiance", "diffuse.ktx2"],
    );
    succeeds(
        here,
        &[
            "bake",
            "split-sum",
            "-o",
            "dfg.ktx2",
            "--size",
            "16",
            "--flip-v",
            "--axes",
            "roughness,n_dot_v",
            "--channels",
            "scale,bias,f82",
        ],
    );
    succeeds(here, &["bake", "split-sum", "-o", "untinted.ktx2", "--size", "16"]);
    let files = ["--env", "sky.ktx2", "--lut", "dfg.ktx2", "--irradiance", "diffuse.ktx2"];
    let small = ["--size", "48x32", "--spheres", "3x2", "--samples", "64", "--json"];
    let draw = |output: &str, rest: &[&str]| {
        let line = succeeds(here, &[&["preview", "-o", output], &files[..], &small[..], rest].concat());
        serde_json::from_str::<serde_json::Value>(&line).unwrap()
    };
    let line = draw("a.png", &["--compare", "--compensate", "--material", "gold"]);
    assert_eq!(line["spheres"].as_array().unwrap().len(), 6);
    assert_eq!(line["spheres"][2]["metallic"], 1.0);
    assert!(line["spheres"][5]["rms"].as_f64().unwrap() < 0.5);
    let picture = image::open(here.join("a.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (3 * 48 + 8, 32));
    let line = draw("b.exr", &["--reference", "--exposure", "-1"]);
    assert_eq!((&line["method"], &line["exposure_ev"]), (&"reference".into(), &(-1.0).into()));
    image::RgbImage::from_pixel(4, 2, image::Rgb([200, 30, 30])).save(here.join("red.png")).unwrap();
    draw("c.png", &["--base-color", "red.png", "--normal", "red.png", "--metallic", "red.png"]);
    let refused = |rest: &[&str], words: &[&str]| {
        fails(here, &[&["preview", "-o", "d.png"], &files[..], &small[..], rest].concat(), words);
    };
    draw("d.exr", &["--roughness", "red.png", "--reference", "--rotate", "90", "--tilt", "-20"]);
    fails(
        here,
        &["preview", "-o", "d.png", "--env", "sky.ktx2", "--lut", "untinted.ktx2", "--material", "gold"],
        &["no f82", "--channels scale,bias,f82"],
    );
    refused(&["--grid", "metallic,metallic"], &["--grid", "metallic,roughness"]);
    refused(&["--grid", "metallic,rougness"], &["rougness", "roughness"]);
    refused(&["--base-color", "1,2,3"], &["--base-color", "0 to 1"]);
    refused(&["--base-color", "missing.png"], &["missing.png"]);
    refused(&["--ndf", "ggx:ratio=0.5"], &["anisotropic", "--ndf"]);
    fails(here, &["preview", "-o", "d.png", "--samples", "9000"], &["9000", "7680"]);
    refused(&["--tone", "filmic"], &["filmic", "aces"]);
    refused(&["--rotate", "inf"], &["--rotate", "inf"]);
    fails(here, &["preview", "-o", "d.png", "--env", "dfg.ktx2"], &["dfg.ktx2", "--lut"]);
    fails(here, &["preview", "-o", "d.png", "--env", "diffuse.ktx2"], &["diffuse.ktx2", "--irradiance"]);
    fails(here, &["preview", "-o", "d.png", "--env", "sky.ktx2", "--lut", "sky.ktx2"], &["sky.ktx2", "table"]);
    fails(here, &["preview", "-o", "d.png", "--env", "sky.ktx2", "--irradiance", "sky.ktx2"], &["no irradiance"]);
    fails(here, &["preview", "-o", "d.gif"], &["d.gif", ".png"]);
    fails(here, &["preview", "-o", "d.exr", "--compare"], &["--compare", ".png"]);
}

#[test]
fn a_page_of_spheres_is_written_and_opened() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    succeeds(here, &["sky", "-o", "sky.exr", "--size", "32"]);
    succeeds(
        here,
        &["env", "sky.exr", "-o", "sky.ktx2", "--size", "16", "--mips", "2", "--irradiance", "diffuse.ktx2"],
    );
    succeeds(here, &["env", "sky.exr", "-o", "flat.exr", "--size", "16", "--mips", "2", "--shape", "octahedral"]);
    succeeds(here, &["env", "sky.exr", "-o", "cube.dds", "--size", "16", "--mips", "2"]);
    succeeds(here, &["bake", "split-sum", "-o", "dfg.ktx2", "--size", "16"]);
    succeeds(here, &["bake", "albedo", "-o", "albedo.ktx2", "--size", "16"]);
    let line = succeeds(here, &["view", "sky.ktx2", "dfg.ktx2", "diffuse.ktx2", "--json"]);
    let line: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!((&line["environments"], &line["irradiance_maps"], &line["tables"]), (&2.into(), &1.into(), &1.into()));
    let page = std::fs::read_to_string(here.join("view.html")).unwrap();
    assert_eq!(page.len() as u64, line["bytes"].as_u64().unwrap());
    assert!(!page.contains("http://") && !page.contains("https://"), "the page needs no network");
    // The same order of kinds whatever the order of files, and what does not say how it is filtered is filtered anew.
    let output = run(here, &["view", "cube.dds", "dfg.ktx2", "-o", "anew.html"]);
    assert!(output.status.success() && text(&output.stderr).contains("does not say how its mips are filtered"));

    fails(here, &["view", "flat.exr"], &["flat.exr", "octahedral", "--shape cube"]);
    fails(here, &["view", "sky.ktx2", "albedo.ktx2"], &["albedo.ktx2", "scale and bias"]);
    fails(here, &["view", "missing.ktx2"], &["missing.ktx2"]);
    fails(here, &["view", "sky.ktx2", "-o", "view.png"], &["view.png", ".html"]);
    fails(here, &["view", "sky.ktx2", "--ndf", "ggx:ratio=0.5"], &["anisotropic"]);
    image::RgbImage::from_pixel(16, 16, image::Rgb([9, 99, 200])).save(here.join("blue.png")).unwrap();
    fails(here, &["view", "sky.ktx2", "blue.png"], &["blue.png", "table"]);

    #[cfg(target_os = "linux")]
    {
        use std::os::unix::fs::PermissionsExt;
        let browser = here.join("xdg-open");
        std::fs::write(&browser, "#!/bin/sh\necho \"$1\" > opened.part && mv opened.part opened\n").unwrap();
        std::fs::set_permissions(&browser, std::fs::Permissions::from_mode(0o755)).unwrap();
        let path = std::env::join_paths([here, Path::new("/usr/bin"), Path::new("/bin")]).unwrap();
        let mut opens = command(here, &["view", "sky.ktx2", "dfg.ktx2", "-o", "seen.html", "--open"]);
        assert!(opens.env("PATH", path).output().unwrap().status.success());
        let opened = (0..100).find_map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            std::fs::read_to_string(here.join("opened")).ok()
        });
        assert!(opened.is_some_and(|path| path.trim_end().ends_with("/seen.html")), "the page is given to the browser");
        let mut alone = command(here, &["view", "sky.ktx2", "dfg.ktx2", "-o", "alone.html", "--open"]);
        let output = alone.env("PATH", here.join("nothing")).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains("no browser opens it") && here.join("alone.html").exists());
    }
}
