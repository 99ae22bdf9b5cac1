// SPDX-License-Identifier: MIT OR Apache-2.0
// The h-split rule for any isotropic distribution: the derivation is in the Rust twin, src/rule/h_split.rs. Names are the
// same there. The including shader declares the buffers of lib/h_table.glsl and includes a geometry term and a Fresnel term before.

#include "term/trig.glsl"
#include "rule/mirror.glsl"
#include "lib/smith_row.glsl"
#include <azimuth_nodes>

#ifndef FRESNEL_AZIMUTH_NODES
#define FRESNEL_AZIMUTH_NODES AZIMUTH_NODES
#endif

// One node of an azimuth panel, in half the azimuth.
#define AZIMUTH_NODE(g, u) { \
    float s = sin_quarter(from + width * (g)); \
    float v_dot_h = cos_h * max(near - far * s * s, 0.0); \
    float n_dot_l = clamp(2.0 * cos_h * v_dot_h - mu, 1e-20, 1.0); \
    float f = (u) * v_dot_h * g_over_n_dot_v( \
        Directions(n_dot_l, mu, cos_h, v_dot_h, projected_area(n_dot_l), sigma_v, alpha)); \
    panel += f * weights(v_dot_h, optics); \
}

// Ends a panel that starts at `from` at a kink, if the kink lies inside.
#define END_AT(kink) to = (kink) > from ? min(to, kink) : to;

// Directional albedo with F replaced by each Fresnel weight, from the texel's outer nodes [begin, end) and its loaded row.
// Domain: n_dot_v in [0, 1].
vec4 h_split(float n_dot_v, uint begin, uint end) {
    Optics optics = Optics(slice.eta.rgb, slice.k.rgb);
    float mu = n_dot_v;
    float sv = max(sqrt((1.0 - mu) * (1.0 + mu)), 1e-7);
    float alpha = row_map.x;
    if (alpha == 0.0) {
        return mirror(mu, optics);
    }
    float sigma_v = projected_area(mu);

    vec4 sum = vec4(0.0);
    for (uint i = begin; i < end; i++) {
        // One polar angle of h; the azimuth counts from v's.
        vec2 node = nodes[i];
        float t = node.x;
        float cos_h = inversesqrt(1.0 + t * t);
        float near = mu + t * sv;
        float far = 2.0 * t * sv;
        float last = half_acos(mu * (t - 1.0) * (t + 1.0) / far);

#if KINKS > 0
        vec2 kink = kinks(t, mu, sv, alpha);
        float kink_x = half_acos(kink.x);
#endif
#if KINKS > 1
        float kink_y = half_acos(kink.y);
#endif
#if FRESNEL_KINKS > 0
        float kink_z = half_acos(fresnel_kink(t, mu, sv, optics));
#endif
        vec4 ring = vec4(0.0);
        float from = 0.0;
#if KINKS + FRESNEL_KINKS > 0
        for (uint p = 0u; p <= KINKS + FRESNEL_KINKS && from < last; p++)
#endif
        {
            float to = last;
#if KINKS > 0
            END_AT(kink_x)
#endif
#if KINKS > 1
            END_AT(kink_y)
#endif
#if FRESNEL_KINKS > 0
            END_AT(kink_z)
#endif
            float width = to - from;
            vec4 panel = vec4(0.0);
            FRESNEL_AZIMUTH_NODES(AZIMUTH_NODE)
            ring += width * panel;
            from = to;
        }
        sum += node.y * ring;
    }
    return sum;
}
