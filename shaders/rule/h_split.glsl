// The h-split rule for any isotropic distribution: the derivation is in the Rust twin, src/rule/h_split.rs. Names are the
// same there. The including shader declares the buffers of lib/h_table.glsl and includes a geometry term and a Fresnel term before.

#include "term/trig.glsl"
#include "rule/mirror.glsl"
#include <azimuth_nodes>

#ifndef FRESNEL_AZIMUTH_NODES
#define FRESNEL_AZIMUTH_NODES AZIMUTH_NODES
#endif

// The texel's row, loaded once: a load costs many times a multiply-add in software Vulkan.
vec4 row_map;
vec4 row_form;
vec4 row_0;
vec4 row_1;
vec4 row_2;
vec4 row_3;
vec4 row_4;
vec4 row_5;

// Loads the row that starts at `at`.
void load_row(uint at) {
    row_map = row_of[at];
    row_form = row_of[at + 1u];
    row_0 = row_of[at + 2u];
    row_1 = row_of[at + 3u];
    row_2 = row_of[at + 4u];
    row_3 = row_of[at + 5u];
    row_4 = row_of[at + 6u];
    row_5 = row_of[at + 7u];
}

// Clenshaw's recurrence by one coefficient; one multiply-add long, because each step waits for the one before.
#define STEP(c) { float next = fma(x2, b1, (c) - b2); b2 = b1; b1 = next; }

// Smith's projected area n_dot_x (1 + Lambda) of the loaded row's distribution.
float projected_area(float n_dot_x) {
    float power = row_form.x;
    float linear = row_form.y;
    float u = linear == 1.0 ? n_dot_x : sqrt(max((1.0 - n_dot_x) * (1.0 + n_dot_x), 0.0));
    float root = inversesqrt(1.0 + u * row_map.y);
    float fourth = sqrt(root);
    float v = power == 1.0 ? root * root : (power == 0.5 ? root : (power == 0.25 ? fourth : sqrt(fourth)));
    float x = v * row_map.z + row_map.w;
    float x2 = 2.0 * x;
    float b1 = 0.0;
    float b2 = 0.0;
    STEP(row_5.w)
    STEP(row_5.z)
    STEP(row_5.y)
    STEP(row_5.x)
    STEP(row_4.w)
    STEP(row_4.z)
    STEP(row_4.y)
    STEP(row_4.x)
    STEP(row_3.w)
    STEP(row_3.z)
    STEP(row_3.y)
    STEP(row_3.x)
    STEP(row_2.w)
    STEP(row_2.z)
    STEP(row_2.y)
    STEP(row_2.x)
    STEP(row_1.w)
    STEP(row_1.z)
    STEP(row_1.y)
    STEP(row_1.x)
    STEP(row_0.w)
    STEP(row_0.z)
    STEP(row_0.y)
    return linear * n_dot_x + row_0.x + x * b1 - b2;
}

// One node of an azimuth panel, in half the azimuth.
#define AZIMUTH_NODE(g, u) { \
    float s = sin_quarter(from + width * (g)); \
    float v_dot_h = cos_h * max(near - far * s * s, 0.0); \
    float n_dot_l = clamp(2.0 * cos_h * v_dot_h - mu, 0.0, 1.0); \
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
