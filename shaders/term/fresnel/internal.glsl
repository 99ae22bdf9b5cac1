// SPDX-License-Identifier: MIT OR Apache-2.0
// A dielectric from inside. Rust twin: src/term/fresnel/internal.rs.

#include "lib/optics.glsl"
#define FRESNEL_KINKS 1
#define FRESNEL_AZIMUTH_NODES NODES_14_FAR
// What is not reflected goes on behind the surface.
#define TRANSPARENT

// Cosine of the critical angle. The host rounds it: from an index near 1, rounded, little of it would be left.
float critical(Optics optics) {
    return optics.k.x;
}

// Unpolarised reflectance, 1 beyond the critical angle, whose cosine is vc. Walter et al. 2007, Eq. 22. Domain: c in
// [0, 1], vc in (0, 1).
float internal(float c, float vc) {
    float g = sqrt(max((c - vc) * (c + vc), 0.0));
    float s = (g - c) / (g + c);
    float p = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    return c > vc ? 0.5 * s * s * (1.0 + p * p) : 1.0;
}

// 1 and the reflectance.
vec4 weights(float v_dot_h, Optics optics) {
    return vec4(1.0, internal(v_dot_h, critical(optics)), 0.0, 0.0);
}

// Cosine of the azimuth between h and v at which v_dot_h is critical.
float fresnel_kink(float tan_h, float n_dot_v, float sin_v, Optics optics) {
    return (critical(optics) * sqrt(1.0 + tan_h * tan_h) - n_dot_v) / (tan_h * sin_v);
}
