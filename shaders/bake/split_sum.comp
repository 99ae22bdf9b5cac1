#version 450
// Split-sum table: (scale, bias) a texel. Rust twin: src/bake/split_sum.rs.

#include "lib/table.glsl"
#include <visibility>
#include "rule/cone.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    vec2 eb = cone(n_dot_v_of[texel % slice.columns], alpha_of[texel / slice.columns]);
    result[2u * texel] = eb.x - eb.y;
    result[2u * texel + 1u] = eb.y;
}
