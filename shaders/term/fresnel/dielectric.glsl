// SPDX-License-Identifier: MIT OR Apache-2.0
// A dielectric from outside. Rust twin: src/term/fresnel/dielectric.rs.

#include "lib/optics.glsl"
#define FRESNEL_KINKS 0
#define FRESNEL_AZIMUTH_NODES NODES_14_FAR
// What is not reflected goes on behind the surface.
#define TRANSPARENT

// Unpolarised reflectance. Walter et al. 2007, Eq. 22. Domain: c in [0, 1], eta > 1.
float dielectric(float c, float eta) {
    float g = sqrt((eta - 1.0) * (eta + 1.0) + c * c);
    float s = (g - c) / (g + c);
    float p = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    return 0.5 * s * s * (1.0 + p * p);
}

// 1 and the reflectance.
vec4 weights(float v_dot_h, Optics optics) {
    return vec4(1.0, dielectric(v_dot_h, optics.eta.x), 0.0, 0.0);
}
