// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Transmission through a rough dielectric with height-correlated Smith, one integral a texel. Rust twin:
// src/rule/transmit.rs.

#include "lib/h_table.glsl"
#include "term/visibility/smith.glsl"
#include <fresnel>
#include "rule/transmit.glsl"

// Floats of four a row takes, as in src/rule/h_split.rs.
const uint ROW = 8u;

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    load_row(ROW * (texel / slice.columns));
    float transmitted = transmit(n_dot_v_of[texel % slice.columns], first_node[texel], first_node[texel + 1u]);
    result[texel] = vec4(transmitted, 0.0, 0.0, 0.0);
}
