// SPDX-License-Identifier: MIT OR Apache-2.0
// GGX lobe (Trowbridge-Reitz; Walter et al. 2007, Eq. 33) with the weight n.w. Rust twin: src/term/zonal/ggx.rs.
#define SHARP_HORIZON 0
#define BEYOND 0.0125

// Mean over a node and slope: (x, y).
// Domain: h in [0, 1], mu >= 0, f in [0, 1], v >= 0, alpha in (0, 1].
vec2 over_node(float h, float mu, float f, float v, float alpha) {
    float a2 = alpha * alpha;
    float b = 1.0 - a2;
    float r = 1.0 / fma(b, h, a2);
    float b_r = b * r;
    float v_b_r = v * b_r;
    float x = 2.0 * v_b_r * b_r;
    float above = fma(x, fma(x, fma(x, 20.0, 7.0), 3.0), 1.0);
    float across = fma(16.0, x, 8.0) * v_b_r;
    return r * r * vec2(fma(mu, above, f * across), fma(b_r, mu, f));
}

// The room of a node: at first as far as it is, from 1.5 alpha up; d/1.75 in the tail; at most 0.3 to 0.6.
float room(float away2, float reach, float extent, float alpha) {
    float d = max(1.5 * alpha, sqrt(away2) - reach - extent);
    return min(d * fma(10.5, alpha, d) / fma(1.75, d, 10.0 * alpha), max(0.6 - 2.0 * alpha, 0.3));
}
