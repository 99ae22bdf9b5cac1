// SPDX-License-Identifier: MIT OR Apache-2.0
// Beckmann lobe (Walter et al. 2007, Eq. 25) with the weight n.w. Rust twin: src/term/zonal/beckmann.rs.
#define SHARP_HORIZON 0
#define BEYOND 0.0625
#include "term/fainter.glsl"

// Mean over a node and slope: (x, y).
// Domain: h in [0, 3/4], mu >= 0, f in [0, 1], v >= 0, alpha in (0, 1].
vec2 over_node(float h, float mu, float f, float v, float alpha) {
    h = min(h, 0.75);
    float i = 1.0 / (1.0 - h);
    float steep = i / (alpha * alpha);
    float g = i * i * exp(-h * steep);
    float first = i * (2.0 - steep);
    float second = fma(first, first, 2.0 * i * i * (1.0 - steep));
    return g * vec2(fma(v, fma(second, mu, -4.0 * first * f), mu), fma(-0.5 * first, mu, f));
}

// The room of a node: 1.5 alpha at the axis, 2.4 over the relative slope beside it; more where the lobe is faint.
float room(float away2, float reach, float extent, float alpha) {
    float d = clamp(sqrt(away2) - reach - extent, 0.0, 1.5);
    float i = 1.0 / fma(-0.25 * d, d, 1.0);
    float steep = i / (alpha * alpha);
    float slope = d * i * (steep - 2.0) / 4.8;
    float near = 1.0 / (1.5 * alpha);
    return min(fainter(0.25 * d * d * steep) * inversesqrt(fma(near, near, slope * slope)), 0.3);
}
