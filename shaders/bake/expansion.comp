// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Sums of Chebyshev series: result[s][p] = sum over k of coefficient[s][k] T_k(x_p), for POINTS points p an invocation. Run
// along roughness and then along n_dot_v it expands a table. Rust twin: src/rule/expansion.rs.

layout(local_size_x = 64) in;

// Invocations [first, first + count) of series * ceil(points/POINTS); term k of series s lies at s*series_step + k*term_step.
layout(push_constant) uniform Push {
    uint first;
    uint count;
    uint points;
    uint terms;
    uint series_step;
    uint term_step;
} push;

layout(std430, set = 0, binding = 0) readonly buffer Positions { float x_of[]; };
layout(std430, set = 0, binding = 1) readonly buffer Coefficients { vec4 coefficient[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Result { vec4 result[]; };

// A coefficient is loaded once for so many points: a load costs many times a multiply-add in software Vulkan. As in
// src/bake/expanded.rs.
const uint POINTS = 8u;

void main() {
    if (gl_GlobalInvocationID.x >= push.count) {
        return;
    }
    uint invocation = push.first + gl_GlobalInvocationID.x;
    uint blocks = (push.points + POINTS - 1u) / POINTS;
    uint series = invocation / blocks;
    uint point = POINTS * (invocation % blocks);

    float x[POINTS];
    float now[POINTS];
    float next[POINTS];
    vec4 sum[POINTS];
    for (uint p = 0u; p < POINTS; p++) {
        x[p] = x_of[min(point + p, push.points - 1u)];
        now[p] = 1.0;
        next[p] = x[p];
        sum[p] = vec4(0.0);
    }
    for (uint k = 0u; k < push.terms; k++) {
        vec4 c = coefficient[series * push.series_step + k * push.term_step];
        for (uint p = 0u; p < POINTS; p++) {
            sum[p] += now[p] * c;
            float after = 2.0 * x[p] * next[p] - now[p];
            now[p] = next[p];
            next[p] = after;
        }
    }
    for (uint p = 0u; p < POINTS; p++) {
        if (point + p < push.points) {
            result[series * push.points + point + p] = sum[p];
        }
    }
}
