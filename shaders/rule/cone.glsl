// SPDX-License-Identifier: MIT OR Apache-2.0
// The cone rule for GGX lobes: the derivation is in the Rust twin, src/rule/cone.rs. Names are the same there.
// The including shader declares the buffers of lib/table.glsl and includes a geometry term and a Fresnel term before.

#include "ndf/ggx.glsl"
#include "term/trig.glsl"
#include "rule/mirror.glsl"
#include <cone_nodes>

// One node of a pair: `side` is +-tan_d.
#define CONE_NODE(side, u) { \
    float hz = cos_h * (cm + sm * (side)); \
    float q = cd - sd * (side); \
    float n2 = a2 + b2 * hz * hz; \
    float inverse_n = inversesqrt(n2); \
    float n_dot_l = k * inverse_n * inverse_n; \
    float v_dot_h = cos_h * q * inverse_n; \
    float f = (u) * q * g_over_n_dot_v( \
        Directions(n_dot_l, mu, hz * inverse_n, v_dot_h, sigma(n_dot_l, alpha), sigma_v, alpha)); \
    row += f * weights(v_dot_h, optics); \
}

#define CONE_PAIR(x, o, u) { \
    float cos_d = sqrt(c2 + s2 * (o)); \
    float tan_d = s * (x) / cos_d; \
    float cos_h = cos_a * cos_d; \
    float k = k_scale * (o); \
    CONE_NODE(tan_d, u) \
    CONE_NODE(-tan_d, u) \
}

// Directional albedo with F replaced by each Fresnel weight. Domain: n_dot_v, alpha in [0, 1].
vec4 cone(float n_dot_v, float alpha) {
    Optics optics = Optics(slice.eta.rgb, slice.k.rgb);
    float mu = n_dot_v;
    float sv2 = (1.0 - mu) * (1.0 + mu);
    float sv = sqrt(sv2);
    if (alpha == 0.0) {
        return mirror(mu, optics);
    }

    // The cone's axes and size; a trailing `_mu` marks a quantity multiplied by mu.
    float a2 = alpha * alpha;
    float b2 = (1.0 - alpha) * (1.0 + alpha);
    float tau_mu = alpha * sv;
    float h_mu = 0.5 * (1.0 + a2) * mu;
    float p_mu = sqrt(h_mu * h_mu + tau_mu * tau_mu);
    float cm = sqrt(0.5 + 0.5 * h_mu / p_mu);
    float sm = tau_mu / (2.0 * p_mu * cm);
    float cd = mu * cm + tau_mu * sm;
    float sd = tau_mu * cm - mu * sm;
    float q_mu = p_mu + 0.5 * b2 * mu;
    float beta = atan_unit(alpha * sqrt(mu / q_mu));
    float am = 1.57079632679490 - beta;
    float sigma_v = sigma(mu, alpha);

    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < CONE_OUTER; i++) {
        // One latitude: e is the angle from the cone's edge.
        vec4 node = cone_outer[i];
        float e = am * node.x;
        float cos_a = sin_quarter(beta + e);
        float cos2_a = cos_a * cos_a;
        float product = sin_quarter(e) * sin_quarter(min(2.0 * beta + e, am * node.y));
        float s2 = min(1.0, (a2 * mu + q_mu) * product / (2.0 * p_mu * cos2_a));
        float c2 = (tau_mu * tau_mu / (p_mu + h_mu) + a2 * mu / cos2_a) / (2.0 * p_mu);
        float s = sqrt(s2);
        float k_scale = 2.0 * p_mu * cos2_a * s2;

        vec4 row = vec4(0.0);
        CONE_PAIRS(CONE_PAIR)
        sum += node.z * cos2_a * s * row;
    }
    return 0.636619772367581 * am * sum;
}
