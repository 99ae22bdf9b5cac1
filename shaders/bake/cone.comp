// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Directional albedo of GGX, one integral a Fresnel weight and texel. Rust twin: src/rule/cone.rs.

#include "lib/table.glsl"
#include <visibility>
#include <fresnel>
#include "rule/cone.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    result[texel] = cone(n_dot_v_of[texel % slice.columns], alpha_of[texel / slice.columns]);
}
