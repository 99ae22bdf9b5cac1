// SPDX-License-Identifier: MIT OR Apache-2.0
// Schlick's split and the F82 tint. Rust twin: src/term/fresnel/schlick.rs.

#include "lib/optics.glsl"
#define FRESNEL_KINKS 0

// Schlick's weight (1 - v.h)^5 from m = 1 - v.h. Schlick 1994, Eq. 15. Domain: m in [0, 1].
float schlick_weight(float m) {
    float m2 = m * m;
    return m2 * m2 * m;
}

// 1, the weight of F90, the weight of the tint c (1 - c)^6.
vec4 weights(float v_dot_h, Optics optics) {
    float m = 1.0 - v_dot_h;
    float schlick = schlick_weight(m);
    return vec4(1.0, schlick, v_dot_h * m * schlick, 0.0);
}
