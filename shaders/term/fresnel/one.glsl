// SPDX-License-Identifier: MIT OR Apache-2.0
// Total reflection. Rust twin: src/term/fresnel/one.rs.

#include "lib/optics.glsl"
#define FRESNEL_KINKS 0

// 1 alone.
vec4 weights(float v_dot_h, Optics optics) {
    return vec4(1.0, 0.0, 0.0, 0.0);
}
