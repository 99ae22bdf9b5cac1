//! The SPIR-V that `build.rs` made of `shaders/`.

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// The words of a shader, e.g. `bake/split_sum+smith`: the path under `shaders/`, then its variants.
pub fn spirv(name: &str) -> &'static [u32] {
    let found = SHADERS.iter().find(|(n, _)| *n == name);
    found.unwrap_or_else(|| panic!("no shader '{name}': tests/mirror.rs checks that every registered one exists")).1
}
