// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Evaluates one shared function at many inputs, so that the host can compare it with its Rust twin.

#include "lib/probe.glsl"
#include "ndf/ggx.glsl"
#include "term/cube.glsl"
#include "term/trig.glsl"
#include "term/zonal/ggx.glsl"
#include <visibility>

float evaluate(float x[8]) {
    switch (push.function) {
    case 0u: return d(x[0], x[1], x[2]);
    case 1u: return stretch(x[0], x[1]);
    case 2u: return sigma(x[0], x[1]);
    case 4u: return sin_quarter(x[0]);
    case 5u: return atan_unit(x[0]);
    case 6u: return half_acos(x[0]);
    case 7u: return direction(uint(x[0]), x[1], x[2])[int(x[3])];
    case 8u: return over_node(x[0], 1.0 - 2.0 * x[0], x[1], x[2], x[3]).x;
    case 9u: return over_node(x[0], 1.0 - 2.0 * x[0], x[1], x[2], x[3]).y;
    case 10u: return g_over_n_dot_v(Directions(x[0], x[1], x[2], x[3], x[4], x[5], x[6]));
#if KINKS > 0
    case 11u: return kinks(x[0], x[1], x[2], x[3]).x;
    case 12u: return kinks(x[0], x[1], x[2], x[3]).y;
#endif
    // Away from 0, for errors relative to the value.
    case 13u: return 2.0 + locate(vec3(x[0], x[1], x[2]))[int(x[3])];
    case 40u: return room(x[0], x[1], x[2], x[3]);
    // The push block as the device sees it.
    default: return float(push.function) + float(push.count) + float(push.echo);
    }
}
