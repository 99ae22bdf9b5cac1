// SPDX-License-Identifier: MIT OR Apache-2.0
// Blinn-Phong lobe (Walter et al. 2007, Eq. 30) with the weight n.w. Rust twin: src/term/zonal/blinn_phong.rs.
#define SHARP_HORIZON 0
#define BEYOND 0.0625
#include "term/fainter.glsl"

// ln(1 - h), h in [0, 3/4]: the built-in loses what it adds to 1.
float ln_one_minus(float h) {
    // 2 artanh(x) with x = -h/(2 - h): x^2 < 1/100 where the series is used, its rest below 1e-9.
    float x = -h / (2.0 - h);
    float x2 = x * x;
    float series = 2.0 * x * fma(x2, fma(x2, fma(x2, 1.0 / 7.0, 0.2), 1.0 / 3.0), 1.0);
    return h < 0.18 ? series : log(1.0 - h);
}

// Mean over a node and slope: (x, y).
// Domain: h in [0, 3/4], mu >= 0, f in [0, 1], v >= 0, alpha in (0, 1].
vec2 over_node(float h, float mu, float f, float v, float alpha) {
    h = min(h, 0.75);
    float m = 1.0 / (alpha * alpha) - 1.0;
    float i = 1.0 / (1.0 - h);
    float g = exp(m * ln_one_minus(h));
    float first = -m * i;
    return g * vec2(fma(v, first * fma((1.0 - m) * i, mu, -4.0 * f), mu), fma(-0.5 * first, mu, f));
}

// The room of a node: 1.5 alpha at the axis, 2.4 over the relative slope beside it; more where the lobe is faint.
float room(float away2, float reach, float extent, float alpha) {
    float d = clamp(sqrt(away2) - reach - extent, 0.0, 1.5);
    float m = 1.0 / (alpha * alpha) - 1.0;
    float i = 1.0 / fma(-0.25 * d, d, 1.0);
    float slope = d * i * m / 4.8;
    float near = 1.0 / (1.5 * alpha);
    return min(fainter(m * log(i)) * inversesqrt(fma(near, near, slope * slope)), 0.3);
}
