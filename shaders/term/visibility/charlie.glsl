// SPDX-License-Identifier: MIT OR Apache-2.0
// The fitted Smith term of Charlie. Rust twin: src/term/visibility/charlie.rs.

#include "lib/directions.glsl"
#define KINKS 1
#define AZIMUTH_NODES NODES_12

// L(x) = a / (1 + b x^c) + d x + e; Estevez, Kulla 2017.
float exponent(float x, float alpha) {
    float smooth_share = (1.0 - alpha) * (1.0 - alpha);
    float a = mix(21.5473, 25.3245, smooth_share);
    float b = mix(3.82987, 3.32435, smooth_share);
    float c = mix(0.19823, 0.16801, smooth_share);
    float d = mix(-1.97760, -1.27393, smooth_share);
    float e = mix(-4.32054, -4.85967, smooth_share);
    return a / (1.0 + b * exp2(c * log2(max(x, 1e-30)))) + d * x + e;
}

// The fitted Lambda. Domain: n_dot_x, alpha in [0, 1].
float lambda(float n_dot_x, float alpha) {
    float half_way = 2.0 * exponent(0.5, alpha);
    float l = n_dot_x < 0.5 ? exponent(n_dot_x, alpha) : half_way - exponent(1.0 - n_dot_x, alpha);
    return exp2(1.44269504088896 * l);
}

// G / n_dot_v with G = 1 / (1 + Lambda(l) + Lambda(v)).
float g_over_n_dot_v(Directions d) {
    return 1.0 / (d.n_dot_v * (1.0 + lambda(d.n_dot_v, d.alpha) + lambda(d.n_dot_l, d.alpha)));
}

// Cosines of the azimuth between h and v where n_dot_l = 1/2; 1 for none.
vec2 kinks(float tan_h, float n_dot_v, float sin_v, float alpha) {
    return vec2((0.5 * (n_dot_v + 0.5) * (1.0 + tan_h * tan_h) - n_dot_v) / (tan_h * sin_v), 1.0);
}
