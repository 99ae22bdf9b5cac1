// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Directional albedo of GGX with functions of v.h in place of Fresnel's F, four integrals a texel. Rust twin:
// src/rule/rings.rs.

#include "lib/slice.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer NDotV { float n_dot_v_of[]; };
// A row's width, and 1 where the geometry term counts shadowing.
layout(std430, set = 0, binding = 1) readonly buffer Rows { vec2 row_of[]; };
// Rings of all texels, three vectors each.
layout(std430, set = 0, binding = 2) readonly buffer Rings { vec4 ring_of[]; };
// Texel i owns the rings from first_ring[i] to first_ring[i + 1].
layout(std430, set = 0, binding = 3) readonly buffer FirstRing { uint first_ring[]; };
layout(std430, set = 0, binding = 4) writeonly buffer Result { vec4 result[]; };

#include "rule/rings.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    vec2 row = row_of[texel / slice.columns];
    float n_dot_v = n_dot_v_of[texel % slice.columns];
    result[texel] = rings(row.y != 0.0, row.x, n_dot_v, first_ring[texel], first_ring[texel + 1u]);
}
