// SPDX-License-Identifier: MIT OR Apache-2.0
// Charlie lobe (Estevez, Kulla 2017, Eq. 2) with the weight n.w. Rust twin: src/term/zonal/charlie.rs.
#define SHARP_HORIZON 1
#define BEYOND 0.0625
#include "term/fainter.glsl"

// Mean over a node and slope: (x, y). Nodes that the horizon runs through (f < 1) are even in mu.
// Domain: h in (0, 1], mu >= 0, f in [0, 1], v >= 0, alpha in (0, 1].
vec2 over_node(float h, float mu, float f, float v, float alpha) {
    float p = 0.5 / alpha;
    h = clamp(h, 1e-9, 0.5);
    bool crosses = f < 1.0;
    float x = crosses ? 1.0 - min(2.0 * mu / max(f, 1e-9), 1.0) : 2.0 * h;
    float g = exp(p * log(max(x, 1e-9)));
    float a = 1.0 / (p + 1.0), b = 1.0 / (p + 2.0);
    float mean_across = 0.5 * f * f / max(mu, 1e-12) * fma(-x * g, fma(-x, b, a), a * b);
    // The fourth order with a flatness of 2.1.
    float inverse = 1.0 / h;
    float first = p * inverse, second = (p - 1.0) * inverse, third = (p - 2.0) * inverse, fourth = (p - 3.0) * inverse;
    float order_4 = 0.35 * v * second * third * fma(fourth, mu, -8.0);
    float mean_above = fma(v * first, fma(second, mu, -4.0) + order_4, mu);
    return crosses ? vec2(mean_across, g * f) : g * vec2(mean_above, fma(-0.5 * first, mu, 1.0));
}

// The room of a node, at the place of the node that is nearest to the ring: 3.6 times its width at the horizon, less
// towards the axis; 1.2 times, at most 0.12, where an axis's horizon may run through the node.
float room(float away2, float reach, float extent, float alpha) {
    float p = 0.5 / alpha;
    float ring = 1.0 / (p + 1.0);
    float mu = fma(-0.5, away2, 1.0), margin = reach + extent;
    float x = 1.0 - clamp(mu - margin, ring, 1.0 - 1e-4);
    float sine_over = max(sqrt(x / (2.0 - x)), 0.1);
    float whole = min(3.6 * ring * sine_over * fainter(fma(-p, log(x), -1.0)), 0.3);
    return abs(mu) <= margin + extent ? min(whole, min(1.2 * ring, 0.12)) : whole;
}
