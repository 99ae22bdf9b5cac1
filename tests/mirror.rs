// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shaders and Rust stay in step: every shared function has its twin with the same name and number of arguments.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use brdf_baker::rule::rings;
use brdf_baker::shaders::SHADERS;
use brdf_baker::term::fresnel;
use brdf_baker::term::visibility::VISIBILITIES;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = vec![];
    for entry in std::fs::read_dir(folder).expect("the folder exists") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) && path.file_stem() != Some("mod".as_ref()) {
            found.push(path);
        }
    }
    found
}

/// Name → number of arguments of the functions whose definition starts a line with one of `starts`.
fn functions(source: &str, starts: &[&str]) -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    for (at, line) in source.match_indices('\n').map(|(i, _)| (i + 1, &source[i + 1..])) {
        let Some(rest) = starts.iter().find_map(|s| line.strip_prefix(s)) else { continue };
        let Some(open) = rest.find('(') else { continue };
        let name = &rest[..open];
        if !name.chars().all(|c| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let close = rest[open..].find(')').map(|i| open + i).unwrap_or_else(|| panic!("unclosed list at byte {at}"));
        let arguments = rest[open + 1..close].split(',').filter(|a| !a.trim().is_empty()).count();
        found.insert(name.to_string(), arguments);
    }
    found
}

const GLSL: [&str; 6] = ["float ", "vec2 ", "vec3 ", "vec4 ", "uint ", "bool "];

/// Every difference between the twins of a folder, in words; and how many functions agree.
fn differences(folder: &str, read: impl Fn(&Path) -> String) -> (Vec<String>, usize) {
    let mut wrong = vec![];
    let mut agree = 0;
    let stems = |base: &str, extension: &str| -> Vec<PathBuf> {
        let base = root().join(base);
        files(&base.join(folder), extension)
            .iter()
            .map(|p| p.strip_prefix(&base).expect("below").with_extension(""))
            .collect()
    };
    let (glsl, rust) = (stems("shaders", "glsl"), stems("src", "rs"));
    for stem in glsl.iter().filter(|s| !rust.contains(s)) {
        wrong.push(format!("shaders/{}.glsl has no Rust twin", stem.display()));
    }
    for stem in &rust {
        let in_rust = functions(&read(&root().join("src").join(stem).with_extension("rs")), &["pub fn "]);
        if !glsl.contains(stem) {
            // Distributions and Fresnel terms that no shader evaluates live in Rust alone.
            let host_only =
                fresnel::TERMS.iter().filter(|t| t.file.is_none()).map(|t| format!("term/fresnel/{}", t.name));
            if folder == "ndf" || host_only.into_iter().any(|host| stem == Path::new(&host)) {
                continue;
            }
            wrong.push(format!("src/{}.rs has no GLSL twin", stem.display()));
            continue;
        }
        let in_glsl = functions(&read(&root().join("shaders").join(stem).with_extension("glsl")), &GLSL);
        for name in in_rust.keys().chain(in_glsl.keys()) {
            match (in_rust.get(name), in_glsl.get(name)) {
                (a, b) if a == b => agree += 1,
                (a, b) => wrong.push(format!("{}::{name}: {a:?} arguments in Rust, {b:?} in GLSL", stem.display())),
            }
        }
    }
    (wrong, agree)
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).expect("readable")
}

#[test]
fn shared_functions_have_twins() {
    for folder in ["ndf", "term"] {
        let (wrong, agree) = differences(folder, read);
        assert!(wrong.is_empty(), "{wrong:#?}");
        assert!(agree >= 3, "only {agree} functions of {folder} were compared");
    }
}

#[test]
fn missing_twin_and_wrong_arity_are_seen() {
    let renamed = |p: &Path| read(p).replace("float sigma(", "float sigmo(");
    assert_eq!(differences("ndf", renamed).0.len(), 2);
    let longer = |p: &Path| read(p).replace("float schlick_weight(float m)", "float schlick_weight(float m, float n)");
    assert!(!differences("term", longer).0.is_empty());
}

#[test]
fn every_shader_is_compiled() {
    for file in files(&root().join("shaders"), "comp") {
        let name = file.strip_prefix(root().join("shaders")).expect("below").with_extension("");
        let name = name.to_str().expect("UTF-8");
        assert!(SHADERS.iter().any(|(n, _)| n.split('+').next() == Some(name)), "{name} is not compiled");
    }
}

#[test]
fn every_rule_has_a_shader_per_geometry_and_fresnel_term() {
    for visibility in VISIBILITIES {
        for (fresnel, file) in fresnel::TERMS.iter().filter_map(|t| Some((t, t.file?))) {
            // The cone rules are for smooth terms.
            let smooth = visibility.kinks.is_none() && fresnel.kink.is_none();
            for rule in if smooth { &["cone", "cone_elliptic", "h_split"][..] } else { &["h_split"] } {
                let name = format!("bake/{rule}+{}+{}", visibility.file, file);
                assert!(SHADERS.iter().any(|(n, _)| *n == name), "{name} is not compiled");
            }
        }
    }
}

#[test]
fn fresnel_terms_state_the_same_rule_on_both_sides() {
    for (term, file) in fresnel::TERMS.iter().filter_map(|t| Some((t, t.file?))) {
        let glsl = read(&root().join("shaders/term/fresnel").join(file).with_extension("glsl"));
        assert!(glsl.contains(&format!("#define FRESNEL_KINKS {}\n", u32::from(term.kink.is_some()))), "{}", term.name);
        let nodes = term.azimuth.map(|size| format!("#define FRESNEL_AZIMUTH_NODES NODES_{size}_FAR\n"));
        assert_eq!(glsl.contains("FRESNEL_AZIMUTH_NODES"), nodes.is_some(), "{}", term.name);
        assert!(nodes.is_none_or(|nodes| glsl.contains(&nodes)), "{}", term.name);
    }
}

#[test]
fn geometry_terms_state_the_same_rule_on_both_sides() {
    for v in VISIBILITIES {
        let glsl = read(&root().join("shaders/term/visibility").join(v.file).with_extension("glsl"));
        let far = if v.crowd_horizon { "_FAR" } else { "" };
        let nodes = format!("#define AZIMUTH_NODES NODES_{}{far}\n", v.azimuth);
        assert!(glsl.contains(&nodes), "{}: the shader does not say {nodes}", v.name);
        let kinks = v.kinks.as_ref().map_or(0, |k| {
            let lines = |tan_h: f64| (k.azimuth)(tan_h, 0.3, 0.9, 0.5);
            if [0.3, 0.7].iter().any(|t| lines(*t)[1] != 1.0) { 2 } else { 1 }
        });
        assert!(glsl.contains(&format!("#define KINKS {kinks}\n")), "{}: {kinks} kinks", v.name);
    }
}

#[test]
fn transmission_has_a_shader_for_either_side_and_the_same_nodes() {
    for fresnel in fresnel::TERMS {
        let name = format!("bake/transmit+{}", fresnel.file.unwrap_or(fresnel.name));
        let transparent = ["dielectric", "internal"].contains(&fresnel.name);
        assert_eq!(SHADERS.iter().any(|(n, _)| *n == name), transparent, "{name}");
    }
    let glsl = read(&root().join("shaders/rule/transmit.glsl"));
    let nodes = glsl.split("#define TRANSMIT_NODES NODES_").nth(1).and_then(|rest| rest.split('_').next()).unwrap();
    let outside = fresnel::Fresnel::dielectric(1.5).unwrap();
    assert!(brdf_baker::rule::transmit::rule_name(&outside).ends_with(&format!("x{nodes} a panel")), "{nodes}");
}

#[test]
fn rings_have_the_same_nodes_on_both_sides() {
    let glsl = read(&root().join("shaders/rule/rings.glsl"));
    let nodes = format!("#define RING_NODES NODES_{}_FAR\n", rings::AZIMUTH_NODES);
    assert!(glsl.contains(&nodes), "the shader does not say {nodes}");
    assert_eq!(rings::RING_LEN, 3 * 4);
}
