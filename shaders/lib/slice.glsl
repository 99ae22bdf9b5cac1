// SPDX-License-Identifier: MIT OR Apache-2.0
// A slice of a grid of texels: [first, first + count), rows of `columns` texels with n_dot_v along them; and the optical
// constants of the Fresnel term. Rust twin: `Slice` in src/bake/grid.rs.

layout(push_constant) uniform Slice { uint columns; uint first; uint count; vec4 eta; vec4 k; } slice;
