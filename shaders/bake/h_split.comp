#version 450
// Split-sum pair (scale, bias) a texel of any distribution. Rust twin: src/rule/h_split.rs.

#include "lib/h_table.glsl"
#include <visibility>
#include "rule/h_split.glsl"

// Floats of four a row takes, as in src/rule/h_split.rs.
const uint ROW = 8u;

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    float n_dot_v = n_dot_v_of[texel % slice.columns];
    vec2 eb = h_split(n_dot_v, ROW * (texel / slice.columns), first_node[texel], first_node[texel + 1u]);
    result[2u * texel] = eb.x - eb.y;
    result[2u * texel + 1u] = eb.y;
}
