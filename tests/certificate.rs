// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a file claims of itself: confirmed where it is sound, refuted where it was changed; bounds of the user's; pages.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use brdf_baker::format::{self, SHA256};
use brdf_baker::texture::Texture;
use serde_json::Value;
use tempfile::TempDir;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).args(["--device", "cpu"]).stdin(Stdio::null());
    command.output().expect("the program starts")
}

fn bake(folder: &Path, arguments: &[&str]) {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// The exit code and the JSON of `verify`.
fn verify(folder: &Path, arguments: &[&str]) -> (i32, Value) {
    let output = run(folder, &[&["verify", "--json"], arguments].concat());
    let text = String::from_utf8_lossy(&output.stdout);
    let error = || format!("{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    (output.status.code().expect("not killed"), serde_json::from_str(&text).unwrap_or_else(|_| panic!("{}", error())))
}

fn verdict<'a>(result: &'a Value, key: &str) -> &'a str {
    let claims = result["certificate"]["claims"].as_array().expect("claims");
    let claim = claims.iter().find(|c| c["key"] == key).unwrap_or_else(|| panic!("no claim {key}: {result}"));
    claim["verdict"].as_str().expect("a word")
}

/// Rewrites a file with another texture, everything that it states included.
fn edit(folder: &Path, from: &str, to: &str, change: impl FnOnce(&mut Texture)) {
    let (from, to) = (folder.join(from), folder.join(to));
    let (mut texture, encoding) = format::for_path(&from).unwrap().read(&from).unwrap();
    change(&mut texture);
    let bytes = format::for_path(&to).unwrap().to_bytes(&to, &texture, encoding.into()).unwrap();
    std::fs::write(to, bytes).unwrap();
}

fn failures(result: &Value) -> String {
    result["failures"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|f| f.as_str().expect("text"))
        .collect::<Vec<_>>()
        .join("; ")
}

#[test]
fn every_encoding_keeps_its_certificate() {
    let folder = TempDir::new().unwrap();
    for (table, file, encoding) in [
        ("split-sum", "a.ktx2", "rg16f"),
        ("split-sum", "b.ktx2", "rgba32f"),
        ("split-sum", "c.exr", "rg16f"),
        ("split-sum", "d.exr", "rgba16f"),
        ("split-sum", "e.exr", "rg32f"),
        ("split-sum", "f.hdr", "rgbe8"),
        ("split-sum", "g.png", "rgb8unorm"),
        ("split-sum", "h.png", "rgb16unorm"),
        ("albedo", "i.png", "r16unorm"),
        ("average-albedo", "j.ktx2", "r32f"),
        ("split-sum", "k.ktx2", "rg16unorm"),
        ("split-sum", "l.ktx2", "a2b10g10r10"),
        ("split-sum", "m.ktx2", "rgb9e5"),
        ("split-sum", "n.ktx", "b10g11r11"),
        ("split-sum", "o.png", "rgbd8"),
        ("split-sum", "p.png", "rgbm8"),
        ("split-sum", "q.ktx2", "rgbp8"),
        ("albedo", "r.ktx2", "bc4"),
        ("split-sum", "s.ktx2", "bc5"),
        ("split-sum", "t.ktx2", "bc6h"),
        ("split-sum", "u.rs", "rg32f"),
        ("split-sum", "v.py", "rg16f"),
        ("split-sum", "w.json", "rg32f"),
    ] {
        bake(folder.path(), &["bake", table, "-o", file, "--size", "24", "--encoding", encoding]);
        let (code, result) = verify(folder.path(), &[file]);
        assert_eq!((code, &result["passed"]), (0, &Value::Bool(true)), "{file}: {}", failures(&result));
        for key in [SHA256, "rule", "error.worst", "error.median"] {
            assert_eq!(verdict(&result, key), "confirmed", "{file}, {encoding}: {key}");
        }
        assert_eq!(verdict(&result, "device"), "stated");
    }
}

#[test]
fn the_same_texels_have_one_hash_in_every_container() {
    let folder = TempDir::new().unwrap();
    let hash = |file: &str| {
        bake(folder.path(), &["bake", "split-sum", "-o", file, "--size", "16", "--encoding", "rg16f"]);
        let path = folder.path().join(file);
        let (texture, _) = format::for_path(&path).unwrap().read(&path).unwrap();
        texture.meta.get(SHA256).expect("a hash").to_string()
    };
    assert_eq!(hash("a.ktx2"), hash("a.exr"));
    assert_eq!(hash("a.ktx2"), hash("a.c"));
}

#[test]
fn a_changed_block_is_found_and_so_is_a_missing_statement_of_loss() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    bake(here, &["bake", "split-sum", "-o", "sound.ktx2", "--size", "32", "--encoding", "bc5"]);
    let sound = std::fs::read(here.join("sound.ktx2")).unwrap();

    // Other greens in the last block.
    let mut changed = sound.clone();
    let at = changed.len() - 8;
    changed[at..].iter_mut().for_each(|byte| *byte ^= 0x5a);
    std::fs::write(here.join("changed.ktx2"), &changed).unwrap();
    let (code, result) = verify(here, &["changed.ktx2"]);
    assert_eq!((code, verdict(&result, SHA256)), (1, "refuted"), "{}", failures(&result));

    // Without the statement nothing says how far a value may be off.
    let key = b"encoding.error.absolute";
    let at = sound.windows(key.len()).position(|w| w == key).expect("the file states it");
    let mut silent = sound;
    silent[at + 9] = b'x';
    std::fs::write(here.join("silent.ktx2"), &silent).unwrap();
    let output = run(here, &["verify", "silent.ktx2"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("does not state its encoding.error.absolute"));
}

#[test]
fn a_texel_within_every_tolerance_is_named() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    bake(here, &["bake", "split-sum", "-o", "sound.ktx2", "--size", "48", "--encoding", "rg32f"]);
    // Texel (31, 17) is not among those that a spot check looks at, and 2 ulp are well within the bound.
    edit(here, "sound.ktx2", "changed.ktx2", |t| {
        let value = &mut t.levels[0][2 * (17 * 48 + 31) + 1];
        *value = f32::from_bits(value.to_bits() + 2);
    });
    let (code, result) = verify(here, &["changed.ktx2"]);
    assert_eq!((code, verdict(&result, SHA256)), (1, "refuted"));
    assert_eq!(failures(&result), "texel (31, 17) was changed after it was baked");
}

#[test]
fn rows_that_moved_are_refused() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    bake(here, &["bake", "albedo", "-o", "sound.exr", "--size", "32"]);
    edit(here, "sound.exr", "shifted.exr", |t| t.levels[0].rotate_left(32));
    let (code, result) = verify(here, &["shifted.exr"]);
    assert_eq!((code, verdict(&result, SHA256)), (1, "refuted"));
    assert!(failures(&result).contains("several texels were changed"), "{}", failures(&result));
    // All are looked at, to say which is worst.
    assert_eq!(result["report"]["twin_texels"], 32 * 32);
}

#[test]
fn false_claims_are_refuted_and_absent_ones_are_said_to_be_absent() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    bake(here, &["bake", "split-sum", "-o", "sound.exr", "--size", "16", "--encoding", "rg32f"]);
    for (key, value) in [("error.worst", "1.00e-12"), ("error.median", "none"), ("rule", "magic, 3 nodes")] {
        edit(here, "sound.exr", "false.exr", |t| t.meta.set(key, value));
        let (code, result) = verify(here, &["false.exr"]);
        assert_eq!((code, verdict(&result, key)), (1, "refuted"), "{key}");
        assert!(failures(&result).contains(key.rsplit('.').next().unwrap()), "{}", failures(&result));
    }
    // Another version may have had another rule.
    edit(here, "sound.exr", "old.exr", |t| {
        t.meta.set("rule", "cone 3x3");
        t.meta.set("version", "0.0.1");
    });
    let (code, result) = verify(here, &["old.exr"]);
    assert_eq!((code, verdict(&result, "rule")), (0, "stated"));

    edit(here, "sound.exr", "bare.exr", |t| {
        let kept: Vec<_> = t
            .meta
            .iter()
            .filter(|(k, _)| !k.starts_with("texels."))
            .map(|(k, v)| (k.to_string(), v.to_string()))
            .collect();
        t.meta = Default::default();
        kept.iter().for_each(|(k, v)| t.meta.set(k, v));
    });
    let (code, result) = verify(here, &["bare.exr"]);
    assert_eq!((code, verdict(&result, SHA256)), (0, "missing"));
    edit(here, "sound.exr", "odd.exr", |t| t.meta.set("texels.sums", "7"));
    let output = run(here, &["verify", "odd.exr"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("texels.sums"));
}

/// A panorama with a light in it, as an OpenEXR file.
fn panorama(folder: &Path) {
    let radiance = |x: usize, y: usize| {
        let light = if (x, y) == (20, 9) { 40.0 } else { 0.3 + 0.01 * (x % 7) as f32 };
        (light, 0.5 * light, 0.2 + 0.01 * y as f32)
    };
    exr::prelude::write_rgb_file(folder.join("sky.exr"), 64, 32, radiance).unwrap();
}

#[test]
fn an_environment_has_a_certificate_too() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    panorama(here);
    bake(here, &["env", "sky.exr", "-o", "cube.ktx2", "--size", "16"]);
    let (code, result) = verify(here, &["cube.ktx2", "--source", "sky.exr"]);
    assert_eq!(code, 0, "{}", failures(&result));
    for key in [SHA256, "rule", "error.relative.rms", "error.relative.worst"] {
        assert_eq!(verdict(&result, key), "confirmed", "{key}");
    }
    assert_eq!(verdict(&verify(here, &["cube.ktx2"]).1, "error.relative.rms"), "stated");

    edit(here, "cube.ktx2", "changed.ktx2", |t| {
        let texel = (3 * 64 + 5 * 8 + 6) * t.channels.len();
        t.levels[1][texel] *= 1.01;
    });
    let (code, result) = verify(here, &["changed.ktx2", "--source", "sky.exr"]);
    assert_eq!(code, 1);
    assert!(failures(&result).contains("texel (6, 5) of face -Y, mip 1, was changed"), "{}", failures(&result));
}

#[test]
fn max_error_decides() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    panorama(here);
    bake(here, &["bake", "split-sum", "-o", "a.ktx2", "--size", "32"]);
    bake(here, &["env", "sky.exr", "-o", "cube.ktx2", "--size", "16"]);
    for file in [&["a.ktx2"][..], &["cube.ktx2", "--source", "sky.exr"]] {
        let with = |bound: &str| verify(here, &[file, &["--max-error", bound]].concat());
        let (_, plain) = verify(here, file);
        assert_eq!(plain["max_error"], Value::Null);
        let (code, result) = with("1e-2");
        assert_eq!((code, &result["max_error"]), (0, &Value::from(1e-2)));
        let (code, result) = with("1e-6");
        assert_eq!((code, &result["passed"]), (1, &Value::Bool(false)));
        assert!(failures(&result).contains("more than --max-error 1.00e-6"), "{}", failures(&result));
    }
}

#[test]
fn bad_wishes_are_refused() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    panorama(here);
    bake(here, &["bake", "split-sum", "-o", "a.ktx2", "--size", "16"]);
    bake(here, &["env", "sky.exr", "-o", "map.ktx2", "--size", "16", "--shape", "octahedral"]);
    let before = std::fs::read(here.join("a.ktx2")).unwrap();
    for (arguments, word) in [
        (&["a.ktx2", "--max-error", "-1"][..], "no bound"),
        (&["a.ktx2", "--max-error", "nan"], "no bound"),
        (&["a.ktx2", "--report", "a.ktx2"], "ends in .html"),
        (&["a.ktx2", "--report", "no/such/folder.html"], "create the folder"),
        (&["a.ktx2", "--source", "sky.exr"], "drop --source"),
        // Nothing of it can be compared without the source.
        (&["map.ktx2", "--max-error", "1"], "--source"),
    ] {
        let output = run(here, &[&["verify"], arguments].concat());
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(word) && output.stdout.is_empty(), "{arguments:?}: {stderr}");
    }
    assert_eq!(before, std::fs::read(here.join("a.ktx2")).unwrap());
    assert!(!std::fs::read_dir(here).unwrap().any(|e| e.unwrap().file_name().to_string_lossy().contains(".part")));
}

/// The JSON in a page.
fn data(page: &str) -> Value {
    let (_, data) = page.split_once(r#"type="application/json">"#).expect("the data's element");
    serde_json::from_str(data.split_once("</script>").expect("its end").0).expect("JSON")
}

#[test]
fn a_page_holds_what_json_prints_and_needs_no_network() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    panorama(here);
    bake(here, &["bake", "split-sum", "-o", "a.ktx2"]);
    bake(here, &["bake", "albedo", "-o", "b.exr", "--size", "16", "--encoding", "r32f"]);
    edit(here, "b.exr", "wrong.exr", |t| t.levels[0][40] = 0.25);
    bake(here, &["env", "sky.exr", "-o", "cube.ktx2", "--size", "16"]);
    for (file, code, more) in [
        ("a.ktx2", 0, &[][..]),
        ("wrong.exr", 1, &[]),
        ("cube.ktx2", 0, &["--source", "sky.exr"]),
        ("cube.ktx2", 0, &[]),
    ] {
        let (found, result) = verify(here, &[&[file, "--report", "page.html"], more].concat());
        assert_eq!(found, code, "{file}: {}", failures(&result));
        let page = std::fs::read_to_string(here.join("page.html")).unwrap();
        assert!(page.len() < 2_000_000, "{file}: {} bytes", page.len());
        let data = data(&page);
        assert_eq!(data["result"], result, "{file}");
        assert!(data["picture"]["kind"].is_string());
        // The name of SVG's elements is no address.
        let addresses = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!addresses.contains("http:") && !addresses.contains("https:"), "{file}: the page names an address");
        for word in ["{{", "src=", "@import", "url("] {
            let (before, after) = page.split_once(r#"<script id="data""#).expect("data");
            assert!(
                !before.contains(word) && !after.split_once("</script>").unwrap().1.contains(word),
                "{file}: {word}"
            );
        }
    }
}
