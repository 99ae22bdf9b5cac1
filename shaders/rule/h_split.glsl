// The h-split rule for any isotropic distribution: the derivation is in the Rust twin, src/rule/h_split.rs. Names are the
// same there. The including shader declares the buffers of lib/h_table.glsl and includes a geometry term before.

#include "term/fresnel.glsl"
#include "term/trig.glsl"
#include "rule/mirror.glsl"
#include <azimuth_nodes>

// Clenshaw's recurrence by one coefficient.
#define STEP(c) { float next = (c) + 2.0 * x * b1 - b2; b2 = b1; b1 = next; }

// Smith's projected area n_dot_x (1 + Lambda) of the distribution whose row starts at `at`.
float projected_area(float n_dot_x, uint at) {
    vec4 map = row_of[at];
    float power = row_of[at + 1u].x;
    float linear = row_of[at + 1u].y;
    float u = linear == 1.0 ? n_dot_x : sqrt(max((1.0 - n_dot_x) * (1.0 + n_dot_x), 0.0));
    float root = inversesqrt(1.0 + u * map.y);
    float fourth = sqrt(root);
    float v = power == 1.0 ? root * root : (power == 0.5 ? root : (power == 0.25 ? fourth : sqrt(fourth)));
    float x = v * map.z + map.w;
    float b1 = 0.0;
    float b2 = 0.0;
    STEP(row_of[at + 7u].w)
    STEP(row_of[at + 7u].z)
    STEP(row_of[at + 7u].y)
    STEP(row_of[at + 7u].x)
    STEP(row_of[at + 6u].w)
    STEP(row_of[at + 6u].z)
    STEP(row_of[at + 6u].y)
    STEP(row_of[at + 6u].x)
    STEP(row_of[at + 5u].w)
    STEP(row_of[at + 5u].z)
    STEP(row_of[at + 5u].y)
    STEP(row_of[at + 5u].x)
    STEP(row_of[at + 4u].w)
    STEP(row_of[at + 4u].z)
    STEP(row_of[at + 4u].y)
    STEP(row_of[at + 4u].x)
    STEP(row_of[at + 3u].w)
    STEP(row_of[at + 3u].z)
    STEP(row_of[at + 3u].y)
    STEP(row_of[at + 3u].x)
    STEP(row_of[at + 2u].w)
    STEP(row_of[at + 2u].z)
    STEP(row_of[at + 2u].y)
    return linear * n_dot_x + row_of[at + 2u].x + x * b1 - b2;
}

// One node of an azimuth panel, in half the azimuth.
#define AZIMUTH_NODE(g, u) { \
    float s = sin_quarter(from + width * (g)); \
    float v_dot_h = cos_h * max(near - far * s * s, 0.0); \
    float n_dot_l = clamp(2.0 * cos_h * v_dot_h - mu, 0.0, 1.0); \
    float f = (u) * v_dot_h * g_over_n_dot_v( \
        Directions(n_dot_l, mu, cos_h, v_dot_h, projected_area(n_dot_l, at), sigma_v, alpha)); \
    panel += f * vec2(1.0, schlick_weight(1.0 - v_dot_h)); \
}

#define AZIMUTH_PANEL(FROM, TO) { \
    float from = FROM; \
    float width = (TO) - from; \
    if (width > 0.0) { \
        vec2 panel = vec2(0.0); \
        AZIMUTH_NODES(AZIMUTH_NODE) \
        ring += width * panel; \
    } \
}

// Directional albedo E with F = 1 and its part B weighted by (1 - v.h)^5, from the texel's outer nodes [begin, end) and
// the row at `at`. Domain: n_dot_v in [0, 1].
vec2 h_split(float n_dot_v, uint at, uint begin, uint end) {
    float mu = n_dot_v;
    float sv = max(sqrt((1.0 - mu) * (1.0 + mu)), 1e-7);
    float alpha = row_of[at].x;
    if (alpha == 0.0) {
        return mirror(mu);
    }
    float sigma_v = projected_area(mu, at);

    vec2 sum = vec2(0.0);
    for (uint i = begin; i < end; i++) {
        // One polar angle of h; the azimuth counts from v's.
        vec2 node = nodes[i];
        float t = node.x;
        float cos_h = inversesqrt(1.0 + t * t);
        float near = mu + t * sv;
        float far = 2.0 * t * sv;
        float last = half_acos(mu * (t - 1.0) * (t + 1.0) / far);

        vec2 ring = vec2(0.0);
#if KINKS == 0
        AZIMUTH_PANEL(0.0, last)
#else
        vec2 kink = kinks(t, mu, sv, alpha);
        float first_kink = min(half_acos(kink.x), last);
#if KINKS == 1
        AZIMUTH_PANEL(0.0, first_kink)
        AZIMUTH_PANEL(first_kink, last)
#else
        float second_kink = min(half_acos(kink.y), last);
        AZIMUTH_PANEL(0.0, min(first_kink, second_kink))
        AZIMUTH_PANEL(min(first_kink, second_kink), max(first_kink, second_kink))
        AZIMUTH_PANEL(max(first_kink, second_kink), last)
#endif
#endif
        sum += node.y * ring;
    }
    return sum;
}
