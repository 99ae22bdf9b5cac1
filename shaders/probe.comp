#version 450
// Evaluates one shared function at many inputs, so that the host can compare it with its Rust twin.

#include "ndf/ggx.glsl"
#include "term/cube.glsl"
#include "term/fresnel.glsl"
#include "term/trig.glsl"
#include "term/zonal/ggx.glsl"
#include <visibility>

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) readonly buffer Input { vec4 inputs[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Output { float outputs[]; };
layout(push_constant) uniform Push { uint function; uint count; uint echo; } push;

float evaluate(vec4 x) {
    switch (push.function) {
    case 0u: return d(x.x, x.y, x.z);
    case 1u: return stretch(x.x, x.y);
    case 2u: return sigma(x.x, x.y);
    case 3u: return schlick_weight(x.x);
    case 4u: return sin_quarter(x.x);
    case 5u: return atan_unit(x.x);
    case 6u: return g_over_n_dot_v(x.x, x.y, x.z, x.w);
    case 7u: return direction(uint(x.x), x.y, x.z)[int(x.w)];
    case 8u: return over_node(x.x, 1.0 - 2.0 * x.x, x.y, x.z, x.w).x;
    case 9u: return over_node(x.x, 1.0 - 2.0 * x.x, x.y, x.z, x.w).y;
    // The push block as the device sees it.
    default: return float(push.function) + float(push.count) + float(push.echo);
    }
}

void main() {
    if (gl_GlobalInvocationID.x < push.count) {
        outputs[gl_GlobalInvocationID.x] = evaluate(inputs[gl_GlobalInvocationID.x]);
    }
}
