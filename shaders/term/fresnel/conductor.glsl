// SPDX-License-Identifier: MIT OR Apache-2.0
// A conductor in red, green and blue. Rust twin: src/term/fresnel/conductor.rs.

#include "lib/optics.glsl"
#define FRESNEL_KINKS 0
#define FRESNEL_AZIMUTH_NODES NODES_14_FAR

// Unpolarised reflectance of a medium with the complex index eta + i k. Domain: c in [0, 1].
float conductor(float c, float eta, float k) {
    float c2 = c * c;
    float s2 = (1.0 - c) * (1.0 + c);
    float eta2 = eta * eta;
    float k2 = k * k;
    float t = eta2 - k2 - s2;
    float sum = sqrt(t * t + 4.0 * eta2 * k2);
    float a2 = t < 0.0 ? 2.0 * eta2 * k2 / (sum - t) : 0.5 * (sum + t);
    float ac = 2.0 * c * sqrt(a2);
    float s = (sum + c2 - ac) / (sum + c2 + ac);
    float total = c2 * sum + s2 * s2;
    float part = ac * s2;
    return 0.5 * s * (1.0 + (total - part) / (total + part));
}

// 1 and the reflectance of red, green and blue.
vec4 weights(float v_dot_h, Optics optics) {
    return vec4(
        1.0, conductor(v_dot_h, optics.eta.x, optics.k.x), conductor(v_dot_h, optics.eta.y, optics.k.y),
        conductor(v_dot_h, optics.eta.z, optics.k.z));
}
