// SPDX-License-Identifier: MIT OR Apache-2.0
// Transmission through a rough dielectric: the derivation is in the Rust twin, src/rule/transmit.rs. Names are the same
// there. The including shader declares the buffers of lib/h_table.glsl and includes a geometry term and a dielectric's
// Fresnel term before.

#include "term/trig.glsl"
#include "lib/smith_row.glsl"
#include <azimuth_nodes>

#define TRANSMIT_NODES NODES_16_FAR

// The least v.h of a facet that transmits; beyond 1 where none does.
float least(float cos_h, float n_dot_v, Optics optics) {
#if FRESNEL_KINKS > 0
    float vc = critical(optics);
    float needed = cos_h * vc * vc / max(n_dot_v, 1e-30);
    return needed > vc ? 0.5 * (needed + vc * vc / needed) : vc;
#else
    return 0.0;
#endif
}

// Half the azimuth, from v's, up to which facets at a polar angle transmit; 0 where none do.
float last(float tan_h, float cos_h, float n_dot_v, float sin_v, Optics optics) {
    return half_acos((least(cos_h, n_dot_v, optics) / cos_h - n_dot_v) / (tan_h * sin_v));
}

// One node of the azimuth panel, in half the azimuth.
#define TRANSMIT_NODE(g, u) { \
    float s = sin_quarter(width * (g)); \
    float v_dot_h = cos_h * max(near - far * s * s, 0.0); \
    float behind = sqrt(max(excess + v_dot_h * v_dot_h, 0.0)); \
    float n_dot_l = clamp((mu + excess * cos_h / (behind + v_dot_h)) / eta, 1e-20, 1.0); \
    float f = (u) * v_dot_h * g_over_n_dot_v( \
        Directions(n_dot_l, mu, cos_h, v_dot_h, projected_area(n_dot_l), sigma_v, alpha)); \
    ring += f * (1.0 - weights(v_dot_h, optics).y); \
}

// The share of light that is transmitted, from the texel's outer nodes [begin, end) and its loaded row.
// Domain: n_dot_v in [0, 1].
float transmit(float n_dot_v, uint begin, uint end) {
    Optics optics = Optics(slice.eta.rgb, slice.k.rgb);
    float mu = n_dot_v;
    float alpha = row_map.x;
    if (alpha == 0.0) {
        return 1.0 - weights(mu, optics).y;
    }
    float sv = max(sqrt((1.0 - mu) * (1.0 + mu)), 1e-7);
    float eta = optics.eta.x;
#if FRESNEL_KINKS > 0
    float excess = -critical(optics) * critical(optics);
#else
    float excess = (eta - 1.0) * (eta + 1.0);
#endif
    float sigma_v = projected_area(mu);

    float sum = 0.0;
    for (uint i = begin; i < end; i++) {
        // One polar angle of h; the azimuth counts from v's.
        vec2 node = nodes[i];
        float t = node.x;
        float cos_h = inversesqrt(1.0 + t * t);
        float near = mu + t * sv;
        float far = 2.0 * t * sv;
        float width = last(t, cos_h, mu, sv, optics);
        float ring = 0.0;
        TRANSMIT_NODES(TRANSMIT_NODE)
        sum += node.y * width * ring;
    }
    return sum;
}
