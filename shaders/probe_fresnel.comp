// SPDX-License-Identifier: MIT OR Apache-2.0
#version 450
// Evaluates a Fresnel term's functions at many inputs, so that the host can compare them with their Rust twins.

#include "lib/probe.glsl"
#include <fresnel>

float evaluate(float x[8]) {
    Optics optics = Optics(vec3(x[1], x[2], x[3]), vec3(x[4], x[5], x[6]));
#if FRESNEL_KINKS > 0
    if (push.function == 4u) {
        return fresnel_kink(x[0], x[6], x[7], optics);
    }
#endif
    return weights(x[0], optics)[push.function];
}
