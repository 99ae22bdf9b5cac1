#version 450
// Directional albedo: one value a texel. Rust twin: src/bake/albedo.rs.

#include "lib/table.glsl"
#include <visibility>
#include "rule/cone.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    result[texel] = cone(n_dot_v_of[texel % slice.columns], alpha_of[texel / slice.columns]).x;
}
