// SPDX-License-Identifier: MIT OR Apache-2.0
// The cone rule for anisotropic GGX: the derivation is in the Rust twin, src/rule/cone_elliptic.rs. Names are the same
// there. The including shader declares the buffers and includes a geometry term and a Fresnel term before.

#include "rule/mirror.glsl"
#include <cone_nodes>

// As in src/rule/cone_elliptic.rs.
const uint RECORD = 5u;
const uint LATITUDES = 48u;

// One node of a pair: `sin_d` is +- the longitude's sine.
#define ELLIPTIC_NODE(sin_d, u) { \
    vec3 h = cos_a * (cos_d * e1.xyz + (sin_d) * e2.xyz) + sin_a * e3.xyz; \
    float q = cos_a * (cos_d * w.x + (sin_d) * w.y) + sin_a * w.z; \
    float hx = e1.w * h.x; \
    float hy = e2.w * h.y; \
    float inverse_n2 = 1.0 / (hx * hx + hy * hy + h.z * h.z); \
    float inverse_n = sqrt(inverse_n2); \
    float n_dot_l = k * inverse_n2; \
    float v_dot_h = clamp(q * inverse_n, 0.0, 1.0); \
    float lx = e1.w * (2.0 * q * hx * inverse_n2 - v.x); \
    float ly = e2.w * (2.0 * q * hy * inverse_n2 - v.y); \
    float sigma_l = 0.5 * (n_dot_l + sqrt(lx * lx + ly * ly + n_dot_l * n_dot_l)); \
    float f = (u) * q / cos_d * g_over_n_dot_v( \
        Directions(n_dot_l, v.z, h.z * inverse_n, v_dot_h, sigma_l, v.w, e3.w)); \
    row += f * weights(v_dot_h, optics); \
}

#define ELLIPTIC_PAIR(x, o, u) { \
    float cos_d = sqrt(node.z + node.y * (o)); \
    float k = k_scale * (o); \
    ELLIPTIC_NODE(s * (x), u) \
    ELLIPTIC_NODE(-s * (x), u) \
}

// Directional albedo with F replaced by each Fresnel weight, of a texel whose cone and latitudes are loaded by its index.
// Domain: n_dot_v in [0, 1].
vec4 cone_elliptic(float n_dot_v, uint texel) {
    Optics optics = Optics(slice.eta.rgb, slice.k.rgb);
    vec4 w = cone_of[RECORD * texel];
    vec4 e1 = cone_of[RECORD * texel + 1u];
    vec4 e2 = cone_of[RECORD * texel + 2u];
    vec4 e3 = cone_of[RECORD * texel + 3u];
    vec4 v = cone_of[RECORD * texel + 4u];
    if (e3.w == 0.0) {
        return mirror(n_dot_v, optics);
    }

    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < LATITUDES; i++) {
        vec4 node = latitude_of[LATITUDES * texel + i];
        float cos_a = inversesqrt(1.0 + node.x * node.x);
        float sin_a = node.x * cos_a;
        float s = sqrt(node.y);
        float k_scale = w.w * cos_a * cos_a * node.y;

        vec4 row = vec4(0.0);
        CONE_PAIRS(ELLIPTIC_PAIR)
        sum += node.w * row;
    }
    return sum;
}
