// SPDX-License-Identifier: MIT OR Apache-2.0
// A BRDF of one's own at pairs of directions. The text of `REAL`, `REAL3` and `brdf` comes before and after, see
// src/bake/own/program.rs.

layout(local_size_x = 64) in;
layout(push_constant) uniform BakerPush { uint first; uint count; uint colored; } baker_push;
// Eight numbers a pair: l, v, alpha, 0.
layout(std430, set = 0, binding = 0) readonly buffer BakerPairs { REAL baker_pairs[]; };
layout(std430, set = 0, binding = 1) writeonly buffer BakerValues { REAL baker_values[]; };

void main() {
    if (gl_GlobalInvocationID.x >= baker_push.count) {
        return;
    }
    uint pair = baker_push.first + gl_GlobalInvocationID.x;
    uint at = 8u * pair;
    REAL3 l = REAL3(baker_pairs[at], baker_pairs[at + 1u], baker_pairs[at + 2u]);
    REAL3 v = REAL3(baker_pairs[at + 3u], baker_pairs[at + 4u], baker_pairs[at + 5u]);
    REAL3 f = brdf(l, v, baker_pairs[at + 6u]);
    baker_values[3u * pair] = f.x;
    baker_values[3u * pair + 1u] = f.y;
    baker_values[3u * pair + 2u] = f.z;
}
