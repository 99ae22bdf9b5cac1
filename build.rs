// SPDX-License-Identifier: MIT OR Apache-2.0
//! Puts the SPIR-V of every shader into the library.
//!
//! With the feature `compile-shaders`, which every build of the checkout has, shaderc compiles it from `shaders/`.
//! Without, it comes ready from `spirv/`, which is in the published package and which `make spirv` writes: whoever depends on
//! this crate needs no shader compiler. `spirv/SOURCES` says what it was compiled from, so that an old one is refused.

#[cfg(feature = "compile-shaders")]
#[path = "build/compile.rs"]
mod compile;
#[cfg(not(feature = "compile-shaders"))]
#[path = "build/ready.rs"]
mod ready;
#[path = "build/sources.rs"]
mod sources;

#[cfg(feature = "compile-shaders")]
#[path = "src/rule/azimuth_nodes.rs"]
mod azimuth_nodes;
#[cfg(feature = "compile-shaders")]
#[path = "src/rule/cone_nodes.rs"]
#[allow(dead_code, reason = "the library uses the rest")]
mod cone_nodes;
#[cfg(feature = "compile-shaders")]
#[path = "src/quadrature"]
#[allow(dead_code, reason = "the library uses the rest")]
mod quadrature {
    pub mod gauss_legendre;
}

use std::fmt::Write as _;
use std::path::PathBuf;

fn main() {
    let sources = sources::fingerprint();
    #[cfg(feature = "compile-shaders")]
    let shaders = compile::shaders();
    #[cfg(not(feature = "compile-shaders"))]
    let shaders = ready::shaders(&sources);

    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let mut rust =
        format!("/// Fingerprint of the sources of [`SHADERS`].\npub const SOURCES: &str = {sources:?};\n\n");
    rust.push_str("/// Every compiled shader by name.\npub static SHADERS: &[(&str, &[u8])] = &[\n");
    for (name, bytes) in shaders {
        let file = format!("{}.spv", name.replace('/', "-"));
        std::fs::write(out.join(&file), bytes).expect("OUT_DIR is writable");
        writeln!(rust, "    ({name:?}, include_bytes!({file:?})),").expect("writing to a string");
    }
    rust.push_str("];\n");
    std::fs::write(out.join("shaders.rs"), rust).expect("OUT_DIR is writable");
}
