// SPDX-License-Identifier: MIT OR Apache-2.0
// What every probe shares: one of some functions, chosen by number, at many inputs, so that the host can compare it with
// its Rust twin. The including shader defines `float evaluate(float x[8])`.

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) readonly buffer Input { float inputs[][8]; };
layout(std430, set = 0, binding = 1) writeonly buffer Output { float outputs[]; };
layout(push_constant) uniform Push { uint function; uint count; uint echo; } push;

float evaluate(float x[8]);

void main() {
    if (gl_GlobalInvocationID.x < push.count) {
        outputs[gl_GlobalInvocationID.x] = evaluate(inputs[gl_GlobalInvocationID.x]);
    }
}
