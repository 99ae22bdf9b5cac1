// SPDX-License-Identifier: MIT OR Apache-2.0
//! Compiles every `shaders/**/*.comp` to SPIR-V and writes the tables of constants that shaders and Rust share.
//!
//! `#include "x.glsl"` reads `shaders/x.glsl`. `#include <ndf>`, `<visibility>`, `<fresnel>` and `<zonal>` stand for one file
//! of `shaders/ndf`, `shaders/term/visibility`, `shaders/term/fresnel` or `shaders/term/zonal`: a shader that uses some is
//! compiled once per combination and is called `path/name+file+file`. `#include <cone_nodes>` and `#include <azimuth_nodes>` read the node
//! tables that this script generates.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::{azimuth_nodes, cone_nodes};

/// What `#include <slot>` may stand for.
const SLOTS: [(&str, &str); 4] =
    [("ndf", "ndf"), ("visibility", "term/visibility"), ("fresnel", "term/fresnel"), ("zonal", "term/zonal")];

/// The name and the words of every shader.
pub fn shaders() -> Vec<(String, Vec<u8>)> {
    let root = PathBuf::from("shaders");
    let generated = BTreeMap::from([("cone_nodes", cone_nodes_glsl()), ("azimuth_nodes", azimuth_nodes_glsl())]);
    let compiler = shaderc::Compiler::new().expect("shaderc starts");
    let mut sources = vec![];
    collect(&root, "comp", &mut sources);
    sources.sort();

    let mut compiled = vec![];
    for source in &sources {
        let text = read(source);
        let name = source.strip_prefix(&root).expect("under shaders").with_extension("");
        let name = name.to_string_lossy().replace('\\', "/");
        let used: Vec<_> = SLOTS.iter().filter(|(slot, _)| uses(&root, &text, &format!("<{slot}>"))).collect();
        let mut variants = vec![(name.clone(), BTreeMap::new())];
        for (slot, folder) in used {
            let mut files = vec![];
            collect(&root.join(folder), "glsl", &mut files);
            files.sort();
            variants = variants
                .into_iter()
                .flat_map(|(name, chosen)| {
                    files.iter().map(move |file| {
                        let stem = file.file_stem().expect("a file name").to_string_lossy();
                        let mut chosen = chosen.clone();
                        chosen.insert(*slot, read(file));
                        (format!("{name}+{stem}"), chosen)
                    })
                })
                .collect();
        }
        // The cone rules are for smooth terms (`Model::method`): no model asks for them with others.
        let smooth = name.starts_with("bake/cone");
        let opaque = |text: &String| !text.contains("#define TRANSPARENT\n");
        let asked = |chosen: &BTreeMap<&str, String>| match name.as_str() {
            // Transmission is for dielectrics.
            "bake/transmit" => !chosen.values().any(opaque),
            _ => !smooth || !chosen.values().any(|text| has_kinks(text)),
        };
        for (name, chosen) in variants.into_iter().filter(|(_, chosen)| asked(chosen)) {
            let bytes = compile(&compiler, &root, source, &text, &chosen, &generated);
            compiled.push((name, bytes));
        }
    }
    compiled
}

fn compile(
    compiler: &shaderc::Compiler,
    root: &Path,
    source: &Path,
    text: &str,
    chosen: &BTreeMap<&str, String>,
    generated: &BTreeMap<&str, String>,
) -> Vec<u8> {
    let mut options = shaderc::CompileOptions::new().expect("shaderc has options");
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_1 as u32);
    options.set_warnings_as_errors();
    options.set_include_callback(|wanted, kind, _, _| {
        let content = match kind {
            shaderc::IncludeType::Relative => std::fs::read_to_string(root.join(wanted)).map_err(|e| e.to_string())?,
            shaderc::IncludeType::Standard => chosen
                .get(wanted)
                .or_else(|| generated.get(wanted))
                .cloned()
                .ok_or_else(|| format!("<{wanted}> is neither a variant slot nor generated"))?,
        };
        Ok(shaderc::ResolvedInclude { resolved_name: format!("shaders/{wanted}"), content })
    });
    let name = source.to_string_lossy();
    match compiler.compile_into_spirv(text, shaderc::ShaderKind::Compute, &name, "main", Some(&options)) {
        Ok(binary) => binary.as_binary_u8().to_vec(),
        Err(e) => {
            eprintln!("{e}");
            println!("cargo::error=shader {name}: {}", e.to_string().replace('\n', " "));
            std::process::exit(1);
        }
    }
}

/// Does a term say that it is not smooth?
fn has_kinks(term: &str) -> bool {
    term.lines().any(|l| {
        let count = l.strip_prefix("#define KINKS ").or(l.strip_prefix("#define FRESNEL_KINKS "));
        count.is_some_and(|count| count.trim() != "0")
    })
}

/// Does the source, or anything it includes by path, contain `needle`?
fn uses(root: &Path, text: &str, needle: &str) -> bool {
    text.contains(needle)
        || text
            .lines()
            .filter_map(|l| l.trim().strip_prefix("#include \"")?.strip_suffix('"'))
            .any(|included| uses(root, &read(&root.join(included)), needle))
}

fn collect(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("cannot read {}: {e}", folder.display()));
    for entry in entries {
        let path = entry.expect("a readable folder entry").path();
        if path.is_dir() {
            collect(&path, extension, found);
        } else if path.extension().is_some_and(|e| e == extension) {
            found.push(path);
        }
    }
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("cannot read {}: {e}", path.display()))
}

/// The cone rule's pairs as a macro to unroll: a memory load costs many times a multiply-add in software Vulkan.
fn cone_nodes_glsl() -> String {
    let mut glsl = format!("const uint CONE_OUTER = {}u;\n#define CONE_PAIRS(PAIR)", cone_nodes::OUTER);
    for pair in cone_nodes::inner() {
        write!(glsl, " \\\n    PAIR({:e}, {:e}, {:e})", pair.x as f32, pair.one_minus_x2 as f32, pair.weight as f32)
            .expect("writing to a string");
    }
    glsl.push('\n');
    glsl
}

/// The h-split rule's azimuth nodes, one macro a size.
fn azimuth_nodes_glsl() -> String {
    let mut glsl = String::new();
    let variants = azimuth_nodes::SIZES.into_iter().flat_map(|size| [(size, "", false), (size, "_FAR", true)]);
    for (size, suffix, far) in variants {
        write!(glsl, "#define NODES_{size}{suffix}(NODE)").expect("writing to a string");
        for node in azimuth_nodes::azimuth_nodes(size, far) {
            write!(glsl, " \\\n    NODE({:e}, {:e})", node.x as f32, node.weight as f32).expect("writing to a string");
        }
        glsl.push('\n');
    }
    glsl
}
