// SPDX-License-Identifier: MIT OR Apache-2.0
//! The SPIR-V of `shaders/`, put together by the build script.

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// The words of a shader, e.g. `bake/split_sum+smith`: the path under `shaders/`, then its variants.
pub fn spirv(name: &str) -> Vec<u32> {
    let found = SHADERS.iter().find(|(n, _)| *n == name);
    let found = found.unwrap_or_else(|| panic!("no shader '{name}': tests/mirror.rs checks that every one exists"));
    bytemuck::pod_collect_to_vec(found.1)
}
