// SPDX-License-Identifier: MIT OR Apache-2.0
//! Array textures: tables in the layers of one file, and the slices of a table over three axes as layers. What they hold, who
//! reads them. Faults in layers are in tests/faults.rs.

use std::path::Path;
use std::process::{Command, Stdio};

use brdf_baker::bake::volume::Stacking;
use brdf_baker::bake::{Backend, LayersJob, SliceAxis, TableRequest, VolumeJob};
use brdf_baker::format::picture::Picture;
use brdf_baker::format::{self, Encoding, Format, formats};
use brdf_baker::progress::ignore;
use brdf_baker::texture::{Shape, Texture};
use brdf_baker::verify::table::Extent;
use serde_json::Value;
use tempfile::TempDir;

/// On the processor, so that no test needs a driver. Exit code, stdout, stderr.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brdf-baker"));
    command.current_dir(folder).args(arguments).args(["--device", "cpu"]).stdin(Stdio::null());
    let output = command.output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let (code, stdout, stderr) = run(folder, arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {stderr}");
    stdout
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&succeeds(folder, &[arguments, &["--json"]].concat())).expect("JSON")
}

/// Expects an exit code and these words.
fn fails(folder: &Path, arguments: &[&str], expected: i32, words: &[&str]) {
    let (code, stdout, stderr) = run(folder, arguments);
    assert_eq!(code, Some(expected), "{arguments:?}: {stdout}{stderr}");
    words.iter().for_each(|word| assert!(stderr.contains(word), "{arguments:?}: '{word}' is not in: {stderr}"));
}

fn request(table: &str, size: u32, channels: &[&str]) -> TableRequest {
    let channels = Some(channels.iter().map(|c| c.to_string()).collect());
    TableRequest { size: (size, size), channels, ..TableRequest::new(table) }
}

/// Scale and bias, and two albedos behind them.
fn layers() -> LayersJob {
    let albedo = TableRequest { visibility: "smith-uncorrelated".into(), ..request("albedo", 8, &["albedo", "cloth"]) };
    LayersJob::new(&[request("split-sum", 8, &["scale", "bias"]), albedo]).expect("they go together")
}

fn baked(job: &LayersJob) -> Texture {
    job.run(&vec![&Backend::Cpu; job.layers().len()], &mut ignore).expect("a bake")
}

#[test]
fn each_layer_is_its_table() {
    let job = layers();
    let texture = baked(&job);
    assert_eq!((texture.shape, texture.width, texture.height), (Shape::Array { layers: 2 }, 8, 8));
    assert_eq!(texture.channels, ["r", "g"]);
    for (i, alone) in job.layers().iter().enumerate() {
        let expected = alone.run(&Backend::Cpu, &mut ignore).expect("a bake");
        let found = job.layer(&texture, i);
        assert_eq!((&found.levels, &found.channels), (&expected.levels, &expected.channels));
        // What a layer says of itself is what its table says, and its channels.
        for (key, value) in expected.meta.iter() {
            assert_eq!(found.meta.get(key), Some(value), "layer {i}: {key}");
        }
    }
    assert_eq!(texture.meta.get("table"), Some("split-sum+albedo"));
    assert_eq!(texture.meta.get("layer1.channels"), Some("albedo,cloth"));
    assert_eq!(texture.meta.get("layer0.visibility"), Some("smith"));
    assert_eq!((texture.meta.get("ndf"), texture.meta.get("layer0.ndf")), (Some("ggx"), None), "said once for all");
    let again = LayersJob::from_meta(&texture).expect("sound").expect("of tables");
    assert_eq!((again.name(), again.rule_name()), (job.name(), job.rule_name()));
    let found = again.check(&texture, None, Extent::Spot, &mut ignore).expect("a check");
    assert_eq!(found.all.failures, Vec::<String>::new());
}

#[test]
fn what_does_not_go_together_is_refused() {
    let error = |list: &[TableRequest]| LayersJob::new(list).err().expect("refused").to_string();
    let scale = request("split-sum", 8, &["scale"]);
    assert_eq!(error(std::slice::from_ref(&scale)), "an array of 1 tables cannot be baked");
    assert_eq!(error(&vec![scale.clone(); 257]), "an array of 257 tables cannot be baked");
    let other = error(&[scale.clone(), request("albedo", 9, &["albedo"])]);
    assert_eq!(other, "split-sum and albedo have different axes or sizes");
    let other = error(&[scale.clone(), request("albedo", 8, &["albedo", "cloth"])]);
    assert_eq!(other, "split-sum has 1 channels and albedo has 2");

    // Slices: one layer is no array, nor is a table of rows.
    let volume = |size, depth| {
        let axis = SliceAxis::Ior([1.2, 1.8]);
        let roughness = (size == (4, 1)).then_some(0.5);
        VolumeJob::new(&TableRequest { size, roughness, ..TableRequest::new("glass") }, axis, depth).expect("a volume")
    };
    let refused = |volume: VolumeJob| volume.stacked(Stacking::Array).err().expect("refused").to_string();
    assert!(refused(volume((4, 4), 1)).contains("at least two layers"));
    assert!(refused(volume((4, 1), 3)).contains("is flat"));
}

#[test]
fn slices_are_stored_as_layers() {
    let request = TableRequest { size: (5, 3), ..TableRequest::new("glass") };
    let volume = VolumeJob::new(&request, SliceAxis::FromF0, 4).expect("a volume");
    let array = volume.clone().stacked(Stacking::Array).expect("an array");
    let (volume, array) = [volume, array].map(|job| job.run(&Backend::Cpu, &mut ignore).expect("a bake")).into();
    assert_eq!((volume.shape, array.shape), (Shape::Volume { depth: 4 }, Shape::Array { layers: 4 }));
    assert_eq!(volume.levels, array.levels);
    let stated: Vec<f64> =
        array.meta.get("slices.values").expect("stated").split(' ').map(|v| v.parse().expect("a number")).collect();
    let job = VolumeJob::from_meta(&array).expect("sound").expect("over slices");
    assert_eq!((job.shape(), stated.len()), (array.shape, 4));
    assert!(stated.iter().zip(job.values()).all(|(a, b)| (a - b).abs() < 1e-7), "{stated:?} {:?}", job.values());
    assert_eq!(job.misstated(&array), None);

    let report = |texture: &Texture| job.check(texture, None, Extent::Full, &mut ignore).expect("a check").all;
    assert_eq!(report(&array).failures, Vec::<String>::new());
    let mut wrong = array.clone();
    let layer = wrong.levels[0].len() / 4;
    wrong.levels[0][layer..3 * layer].rotate_left(layer);
    let found = report(&wrong).failures;
    assert!(
        found.iter().any(|f| f.starts_with("slice 1")) && found.iter().any(|f| f.starts_with("slice 2")),
        "{found:?}"
    );
    wrong.meta.set("slices.values", "1 1.1 1.2 1.3");
    assert!(job.misstated(&wrong).expect("seen").contains("ior_from_f0"));
}

/// Every container that has arrays gives back nine texels of each layer, and its reader of others' files one layer.
#[test]
fn containers_keep_the_layers() {
    let (job, folder) = (layers(), TempDir::new().expect("a folder"));
    let texture = baked(&job);
    let able: Vec<&dyn Format> = formats().iter().copied().filter(|f| !f.encodings(texture.shape).is_empty()).collect();
    let extensions: Vec<&str> = able.iter().map(|f| f.extension()).collect();
    assert_eq!(extensions, ["ktx2", "exr", "dds", "npy", "json", "rs", "c", "h", "js", "ts", "py"]);
    let single = Encoding::parse("rg32f").expect("its name");
    for format in able {
        let path = folder.path().join(format!("two.{}", format.extension()));
        let bytes = format.to_bytes(&path, &texture, single.into()).expect("it fits");
        std::fs::write(&path, bytes).expect("writable");
        let (read, _) = format.read(&path).expect("sound");
        let what = format.name();
        let shape = if format.extension() == "npy" { Shape::Volume { depth: 2 } } else { texture.shape };
        assert_eq!((read.shape, &read.levels), (shape, &texture.levels), "{what}");
        if format.holds_meta() {
            assert!(LayersJob::from_meta(&read).expect("sound").is_some(), "{what}");
        }
        if !["ktx2", "exr", "dds", "npy"].contains(&format.extension()) {
            continue;
        }
        for layer in 0..2 {
            let picture = Picture::read_layer(&path, Some(layer)).unwrap_or_else(|e| panic!("{what}: {e}"));
            for (x, y) in (0..9).map(|i| (i % 3 * 7 / 2, i / 3 * 7 / 2)) {
                let found: Vec<f64> = picture.texel(x, y).iter().map(|v| v.value).collect();
                let expected: Vec<f64> = texture.texel(0, layer, x, y).iter().map(|v| f64::from(*v)).collect();
                assert_eq!(found, expected, "{what}: layer {layer} at ({x}, {y})");
            }
        }
        // None is taken for the whole.
        let error = Picture::read(&path).expect_err("it holds two");
        assert!(error.to_string().contains("holds 2 tables") && error.help().contains("--layer"), "{what}: {error}");
        assert!(Picture::read_layer(&path, Some(2)).expect_err("there is none").to_string().contains("no layer 2"));
    }
    for extension in ["png", "hdr", "ktx", "env"] {
        let format = format::named(extension).expect("a format");
        let error = format::choose(format, texture.shape, 2, None).expect_err("it has no arrays");
        assert!(error.to_string().contains("cannot hold an array of tables"), "{extension}: {error}");
        assert!(error.help().contains(".ktx2, .exr, .dds"), "{extension}: {}", error.help());
    }
    // One layer is a table.
    let mut one = texture.clone();
    (one.shape, one.levels[0]) = (Shape::Array { layers: 1 }, one.levels[0][..128].to_vec());
    assert!(format::Ktx2.to_bytes(Path::new("one.ktx2"), &one, single.into()).is_err());
}

#[test]
fn commands_take_layers() {
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    let channels = ["--channels", "scale,bias+albedo,cloth"];
    let bake = |file: &str, more: &[&str]| {
        let base = ["bake", "split-sum+albedo", "--size", "16", "-o", file];
        json(here, &[&base[..], &channels, more].concat())
    };
    let line = bake("two.ktx2", &[]);
    assert_eq!(
        (&line["layers"], &line["encoding"], &line["table"]),
        (&2.into(), &"rg16f".into(), &"split-sum+albedo".into())
    );
    let info = json(here, &["info", "two.ktx2"]);
    assert_eq!((&info["shape"], &info["depth"]), (&"array".into(), &2.into()));
    let right = json(here, &["verify", "two.ktx2"]);
    assert_eq!((&right["passed"], &right["layers"][1]["table"]), (&true.into(), &"albedo".into()));
    let channels: Vec<&str> =
        right["report"]["channels"].as_array().expect("channels").iter().filter_map(|c| c["name"].as_str()).collect();
    assert_eq!(channels, ["scale", "bias", "albedo", "cloth"]);

    // One layer alone, on a page and by its texels; a file of others too.
    let alone = json(here, &["verify", "two.ktx2", "--layer", "1", "--report", "page.html"]);
    assert_eq!((&alone["passed"], &alone["table"]), (&true.into(), &"albedo".into()));
    assert!(std::fs::read_to_string(here.join("page.html")).expect("a page").contains("cloth"));
    let found = json(here, &["identify", "two.ktx2", "--layer", "0"]);
    assert_eq!((&found["verdict"], &found["fits"][0]["channels"]), (&"certain".into(), &"R = scale, G = bias".into()));
    bake("two.dds", &["--encoding", "rg32f"]);
    assert!(succeeds(here, &["verify", "two.dds", "--layer", "0"]).contains("identified"));
    fails(here, &["verify", "two.dds"], 2, &["holds 2 tables", "--layer"]);
    fails(here, &["identify", "two.ktx2"], 2, &["holds 2 tables", "--layer"]);
    fails(here, &["verify", "two.ktx2", "--layer", "2"], 2, &["no layer 2"]);
    fails(here, &["verify", "two.ktx2", "--report", "page.html"], 2, &["--layer"]);
    fails(here, &["curves", "two.ktx2", "-o", "two.svg"], 2, &["several tables are no picture"]);
    fails(here, &["preview", "--lut", "two.ktx2", "-o", "a.png"], 2, &["in its layers"]);

    // Layers that were exchanged, behind everything else that the file has.
    let bytes = std::fs::read(here.join("two.ktx2")).expect("readable");
    let (start, half) = (bytes.len() - 2 * 16 * 16 * 4, 16 * 16 * 4);
    std::fs::write(
        here.join("swapped.ktx2"),
        [&bytes[..start], &bytes[start + half..], &bytes[start..start + half]].concat(),
    )
    .expect("writable");
    fails(here, &["verify", "swapped.ktx2"], 1, &["layer 0, split-sum: "]);

    // Slices.
    let glass = ["bake", "glass", "--axes", "n_dot_v,roughness,ior=1.2/1.8", "--size", "4x4x3", "-o"];
    let line = json(here, &[&glass[..], &["g.ktx2", "--slices", "array"]].concat());
    assert_eq!(line["slices"], 3);
    assert_eq!(json(here, &["info", "g.ktx2"])["meta"]["slices.values"], "1.3000000 1.5000000 1.7000000");
    assert!(succeeds(here, &["verify", "g.ktx2", "--full"]).contains("3 of 3 were looked at"));
    fails(here, &["verify", "g.ktx2", "--layer", "0"], 2, &["no layers that are tables of their own"]);
    fails(here, &[&glass[..], &["h.ktx2", "--slices", "atlas"]].concat(), 2, &["'atlas'", "volume", "array"]);

    let refused = |arguments: &[&str], words: &[&str]| {
        fails(here, &[&["bake"][..], arguments, &["-o", "none.ktx2"]].concat(), 2, words);
    };
    refused(&["split-sum+albedo"], &["split-sum has 2 channels and albedo has 1", "--channels A,B+C,D"]);
    refused(&["split-sum+albedo", "--channels", "scale,bias"], &["those of 1 tables, but there are 2"]);
    refused(&["split-sum+"], &["unknown table ''"]);
    refused(&["split-sum+glas"], &["unknown table 'glas'", "glass"]);
    refused(&["split-sum", "--slices", "array"], &["no axis over slices"]);
    refused(&["split-sum", "--glsl", "mine.glsl", "--slices", "array"], &["has no slices"]);
    refused(&["split-sum+albedo", "--glsl", "mine.glsl"], &["has no layers"]);
    refused(&["glass+glass", "--axes", "n_dot_v,roughness,ior=1.2/1.8"], &["are no layers"]);
    fails(here, &["bake", "split-sum+split-sum", "-o", "none.png"], 2, &["PNG cannot hold an array", ".ktx2"]);
    assert!(!here.join("none.ktx2").exists() && !here.join("none.png").exists());
}

/// Bevy's file of area lights, as its `AreaLightLuts` reads it: matrix, then magnitude, half floats.
#[test]
fn area_lights_of_bevy_are_one_array() {
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    let line = json(here, &["bake", "ltc", "--for", "bevy", "--size", "6"]);
    assert_eq!((&line["path"], &line["encoding"], &line["layers"]), (&"ltc.ktx2".into(), &"rgba16f".into(), &2.into()));
    let bytes = std::fs::read(here.join("ltc.ktx2")).expect("readable");
    let word = |i: usize| u32::from_le_bytes(bytes[12 + 4 * i..][..4].try_into().expect("four bytes"));
    // VkFormat, bytes of a component, width, height, depth, layers, faces, levels: those of Bevy's own file but for the size.
    assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(word), [97, 2, 6, 6, 0, 2, 1, 1]);
    let (texture, _) = format::Ktx2.read(&here.join("ltc.ktx2")).expect("sound");
    assert_eq!(texture.meta.get("layer0.channels"), Some("m00,m20,m02,m22"));
    assert_eq!(texture.meta.get("layer1.channels"), Some("magnitude,fresnel,unused,sphere"));
    // A mirror seen from above reflects all light.
    assert_eq!(texture.texel(0, 1, 0, 0)[..3], [1.0, 0.0, 0.0]);
    let verified = json(here, &["verify", "ltc.ktx2"]);
    assert_eq!((&verified["passed"], &verified["layers"][0]["table"]), (&true.into(), &"ltc".into()));
    let info = json(here, &["info", "ltc.ktx2"]);
    assert!(info["snippet"].as_str().expect("code").contains("AreaLightLuts"), "{info}");
    fails(here, &["bake", "ltc-magnitude", "--for", "bevy"], 2, &["takes ltc-magnitude as a layer of ltc"]);
}
