// SPDX-License-Identifier: MIT OR Apache-2.0
//! Presets of engines, as a user meets them: one command, the files that the engine loads, and what they say of themselves.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use brdf_baker::bake::{atlas, table};
use brdf_baker::env::Equirect;
use brdf_baker::format::{self, Encoding, Format};
use brdf_baker::target::{self, TARGETS};
use brdf_baker::texture::{Meta, Shape, Texture};
use serde_json::Value;
use tempfile::TempDir;

/// On the processor, so that no test needs a driver.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).args(["--device", "cpu"]).stdin(Stdio::null());
    command.output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// Expects success; what each line of stdout says.
fn json(folder: &Path, arguments: &[&str]) -> Vec<Value> {
    let output = run(folder, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

/// Expects a refusal with these words.
fn fails(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = run(folder, arguments);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    words.iter().for_each(|word| assert!(stderr.contains(word), "{arguments:?}: '{word}' is not in: {stderr}"));
}

fn paths(lines: &[Value]) -> Vec<&str> {
    lines.iter().map(|line| line["path"].as_str().expect("a path")).collect()
}

/// Writes a sky with one bright side, which is enough for what is tested here.
fn sky(folder: &Path) {
    let picture = Equirect::from_fn(32, |x, y| if x < 0.125 && y < 0.5 { [8.0, 4.0, 2.0] } else { [0.25, 0.5, 1.0] });
    let levels = vec![picture.texels.iter().flatten().copied().collect()];
    let channels = ["r", "g", "b"].map(String::from).to_vec();
    let texture = Texture {
        shape: Shape::Table,
        width: picture.width,
        height: picture.height,
        channels,
        levels,
        meta: Meta::default(),
    };
    let path = folder.join("sky.hdr");
    let encoding = Encoding::parse("rgbe8").expect("its name");
    std::fs::write(&path, format::Hdr.to_bytes(&path, &texture, encoding.into()).expect("it fits")).expect("writable");
}

#[test]
fn one_command_bakes_the_table_of_an_engine() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    for target in TARGETS {
        for preset in target.tables {
            // As large as Blender's are small, and of the same tables.
            if preset.stem.starts_with("opaque_") || preset.stem.starts_with("ideal_dielectric_average") {
                continue;
            }
            // By the engine's own name: it may have several of one table.
            // Fits take seconds at full size.
            let is_fit = table(preset.table).unwrap().usual().is_fit;
            let size = if is_fit { &["--size", "6"][..] } else { &[] };
            let lines = json(here, &[&["bake", preset.stem, "--for", target.name], size].concat());
            let file = format!("{}.{}", preset.stem, preset.extension);
            assert_eq!(paths(&lines), [&file], "{}", target.name);
            assert_eq!(lines[0]["encoding"], preset.encoding);
            let slices = preset.slices.map_or(1, |(_, slices)| slices);
            let rows = if preset.axes.len() == 1 { slices } else { preset.size.1 };
            let expected = if is_fit { (6, 6) } else { (u64::from(preset.size.0), u64::from(rows)) };
            assert_eq!((lines[0]["width"].as_u64().unwrap(), lines[0]["height"].as_u64().unwrap()), expected);
            assert!(here.join(&file).is_file(), "{}: {file}", target.name);
        }
    }
}

#[test]
fn one_command_bakes_all_tables_of_an_engine() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let lines = json(here, &["bake", "set", "--for", "unity-hdrp", "-o", "tables/unity"]);
    let names = ["fgd_ggx_disney", "fgd_charlie_fabric", "ltc_ggx"];
    let expected = names.map(|name| format!("tables/unity/{name}.dds"));
    assert_eq!(paths(&lines), expected);
    assert!(paths(&lines).iter().all(|path| here.join(path).is_file()));
    // A certificate each, where the container holds one.
    let lines = json(here, &["bake", "set", "--for", "bevy"]);
    assert_eq!(paths(&lines), ["./dfg.ktx2", "./ltc.ktx2"]);
    assert!(text(&run(here, &["verify", "dfg.ktx2"]).stdout).contains("right"));
    // Nothing else beside them, half-written or not.
    let files = std::fs::read_dir(here.join("tables/unity")).unwrap().count();
    assert_eq!(files, names.len());

    fails(here, &["bake", "set", "-o", "tables"], &["a set is that of an engine", "--for blender"]);
    fails(here, &["bake", "set", "--for", "bevy", "--size", "8"], &["--size does not go with a set", "bevy"]);
    fails(here, &["bake", "set", "--for", "bevy", "-o", "dfg.ktx2"], &["dfg.ktx2"]);
}

#[test]
fn one_command_bakes_the_environment_of_an_engine() {
    for target in TARGETS {
        let Some(preset) = &target.environment else { continue };
        let folder = TempDir::new().unwrap();
        let here = folder.path();
        sky(here);
        // An atlas has one size.
        let size = if preset.shape == atlas::NAME { atlas::SIDE.to_string() } else { "16".into() };
        let lines = json(here, &["env", "sky.hdr", "--for", target.name, "--size", &size]);
        let file = format!("sky{}.{}", preset.suffix, preset.extension);
        let mut expected = vec![file.clone()];
        expected.extend(preset.beside.iter().map(|beside| target::beside_name(&file, preset, beside)));
        let mut found = paths(&lines);
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected, "{}", target.name);
        assert!(found.iter().all(|path| here.join(path).is_file()));
        assert!(lines.iter().all(|line| line["target"] == target.name));
    }
}

#[test]
fn a_file_prints_the_code_that_loads_it() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    sky(here);
    json(here, &["bake", "split-sum", "--for", "unreal", "-o", "gf.ktx2", "--encoding", "rg16f"]);
    let info = &json(here, &["info", "gf.ktx2"])[0];
    assert!(info["snippet"].as_str().expect("code").contains("// gf.ktx2"), "{info}");
    json(here, &["env", "sky.hdr", "--for", "bevy", "-o", "a_specular.ktx2", "--size", "16"]);
    let output = run(here, &["info", "a_specular.ktx2"]);
    let info = text(&output.stdout);
    for word in ["In bevy:", "assets.load(\"a_specular.ktx2\")", "assets.load(\"a_diffuse.ktx2\")"] {
        assert!(info.contains(word), "'{word}' is not in: {info}");
    }
}

#[test]
fn an_override_is_said_and_stored() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let output = run(here, &["bake", "split-sum", "--for", "bevy", "-o", "a.exr", "--size", "32", "--flip-v"]);
    assert!(output.status.success());
    let stderr = text(&output.stderr);
    assert!(stderr.contains("not what bevy wants by default: size, flip-v, container"), "{stderr}");
    let meta = &json(here, &["info", "a.exr"])[0]["meta"];
    assert_eq!((&meta["target"], &meta["target.overrides"]), (&"bevy".into(), &"size,flip-v,container".into()));
    assert_eq!(meta["order"], "ascending,descending");

    // What agrees with the preset is no override.
    let output = run(here, &["bake", "split-sum", "--for", "bevy", "-o", "b.ktx2", "--size", "128"]);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    assert_eq!(json(here, &["info", "b.ktx2"])[0]["meta"]["target.overrides"], Value::Null);
}

#[test]
fn rows_of_filament_are_one_texel_high_unless_they_are_to_be_exact() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let bake = |file, more: &[&str]| {
        let base = ["bake", "split-sum", "--for", "filament", "-o", file, "--size", "16", "--encoding", "rgba32f"];
        assert!(run(here, &[&base[..], more].concat()).status.success());
        format::for_path(Path::new(file)).unwrap().read(&here.join(file)).unwrap().0
    };
    let (shifted, exact) = (bake("a.exr", &[]), bake("b.exr", &["--exact-rows"]));
    for y in 0..15 {
        for x in 0..16 {
            assert_eq!(shifted.texel(0, 0, x, y), exact.texel(0, 0, x, y + 1), "({x}, {y})");
        }
    }
    assert_eq!(shifted.meta.get("row-shift"), Some("1"));
    assert_eq!(exact.meta.get("target.overrides"), Some("size,exact-rows,encoding,container"));
    for file in ["a.exr", "b.exr"] {
        assert_eq!(json(here, &["verify", file, "--full"])[0]["passed"], true, "{file}");
    }
}

#[test]
fn what_an_engine_does_not_take_is_refused() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    sky(here);
    fails(here, &["bake", "split-sum", "--for", "bevi"], &["unknown target 'bevi'", "did you mean 'bevy'"]);
    fails(here, &["bake", "albedo", "--for", "bevy"], &["bevy takes no albedo table", "split-sum"]);
    fails(here, &["bake", "split-sum", "--for", "playcanvas"], &["it takes", "ltc-magnitude"]);
    fails(here, &["env", "sky.hdr", "--for", "openpbr"], &["openpbr takes no environment"]);
    fails(here, &["bake", "split-sum", "-o", "a.ktx2", "--exact-rows"], &["--for"]);
    fails(here, &["env", "sky.hdr", "-o", "a.ktx2", "--file-axes", "x,y"], &["'x,y'", "x,y,-z"]);
    fails(here, &["env", "sky.hdr", "-o", "a.ktx2", "--roughness-law", "cubic"], &["unknown roughness law", "linear"]);
}

#[test]
fn the_guide_has_every_command_and_the_code_that_info_prints() {
    // Area lights have a page of their own.
    let guide = concat!(include_str!("../docs/engines.md"), include_str!("../docs/area-lights.md"));
    let has = |text: &str, target: &str| assert!(guide.contains(text), "{target}: the guide lacks\n{text}");
    for target in TARGETS {
        for preset in target.tables {
            let command = |table: &str| format!("brdf-baker bake {table} --for {}", target.name);
            assert!(
                [preset.table, preset.stem].iter().any(|table| guide.contains(&command(table))),
                "docs/engines.md lacks '{}'",
                command(preset.stem)
            );
            has(&preset.snippet.replace("{file}", &format!("{}.{}", preset.stem, preset.extension)), target.name);
        }
        if let Some(preset) = &target.environment {
            has(&format!("brdf-baker env studio.exr --for {}", target.name), target.name);
            let mut meta = Meta::default();
            meta.set("target", target.name);
            let file = format!("studio{}.{}", preset.suffix, preset.extension);
            has(&target::snippet(&meta, &file).expect("every environment comes with code"), target.name);
        }
    }
}
