// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Directional albedo of anisotropic GGX, one integral a Fresnel weight and texel. Rust twin: src/rule/cone_elliptic.rs.

#include "lib/slice.glsl"
#include <visibility>
#include <fresnel>

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer NDotV { float n_dot_v_of[]; };
// A texel's cone, as src/rule/cone_elliptic.rs packs it: (w, l1 + l2), (e1, ax), (e2, ay), (e3, alpha), (v, sigma_v).
layout(std430, set = 0, binding = 1) readonly buffer Cones { vec4 cone_of[]; };
// A texel's latitudes: (tan, sin2, cos2, weight) each.
layout(std430, set = 0, binding = 2) readonly buffer Latitudes { vec4 latitude_of[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Result { vec4 result[]; };

#include "rule/cone_elliptic.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= slice.count) {
        return;
    }
    uint texel = slice.first + gl_GlobalInvocationID.x;
    result[texel] = cone_elliptic(n_dot_v_of[texel % slice.columns], texel);
}
