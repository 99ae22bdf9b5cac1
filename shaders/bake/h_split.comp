// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Directional albedo of any distribution, one integral a Fresnel weight and texel. Rust twin: src/rule/h_split.rs.

#include "lib/h_table.glsl"
#include <visibility>
#include <fresnel>
#include "rule/h_split.glsl"

// Floats of four a row takes, as in src/rule/h_split.rs.
const uint ROW = 8u;

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    load_row(ROW * (texel / slice.columns));
    result[texel] = h_split(n_dot_v_of[texel % slice.columns], first_node[texel], first_node[texel + 1u]);
}
