// SPDX-License-Identifier: MIT OR Apache-2.0
// The ring rule for GGX with any function of v.h in place of Fresnel's F: the derivation is in the Rust twin,
// src/rule/rings.rs. Names are the same there. The including shader declares the buffer `ring_of`, three vectors a ring.

#include "term/trig.glsl"
#include "ndf/ggx.glsl"
#include <azimuth_nodes>

#define RING_NODES NODES_16_FAR

// One node of the azimuth.
#define RING_NODE(g, u) { \
    float s = sin_quarter(half_end * (g)); \
    float c = sin_quarter(rest + half_end * (1.0 - (g))); \
    float s2 = s * s; \
    float den = far * c * c + near * s2; \
    float fall = 2.0 * near * s2 / den; \
    float n_dot_h = at.z - at.w * fall; \
    float n_dot_l = clamp(to.x - to.y * fall, 1e-20, 1.0); \
    float g_over_n_dot_v = shadowed ? n_dot_l / (sigma(n_dot_l, alpha) * mu + (sigma_v - mu) * n_dot_l) : 1.0 / sigma_v; \
    float other = 1.0 + b * n_dot_h; \
    around += (u) * den * g_over_n_dot_v / (other * other); \
}

// Directional albedo with F replaced by each weight that the rings carry, from the texel's rings [begin, end).
// Domain: n_dot_v in [0, 1], alpha in (0, 1].
vec4 rings(bool shadowed, float alpha, float n_dot_v, uint begin, uint end) {
    float mu = n_dot_v;
    float b = sqrt((1.0 - alpha) * (1.0 + alpha));
    float sigma_v = sigma(mu, alpha);
    vec4 sum = vec4(0.0);
    for (uint i = begin; i < end; i++) {
        // near, far, n.h and how it falls; n.l and how it falls, what half the azimuth
        // leaves of a right angle, weight.
        vec4 at = ring_of[3u * i];
        vec4 to = ring_of[3u * i + 1u];
        float near = at.x;
        float far = at.y;
        float rest = to.z;
        float half_end = 1.57079632679490 - rest;
        float around = 0.0;
        RING_NODES(RING_NODE)
        sum += to.w * around * ring_of[3u * i + 2u];
    }
    return sum;
}
