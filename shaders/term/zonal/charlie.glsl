// Charlie lobe (Estevez, Kulla 2017, Eq. 2) with the weight n.w. Rust twin: src/term/zonal/charlie.rs.
#define SHARP_HORIZON 1
#include "term/fainter.glsl"

// Mean over a node and slope: (x, y).
// Domain: h in (0, 1], mu >= 0, f in [0, 1], v >= 0, alpha in (0, 1].
vec2 over_node(float h, float mu, float f, float v, float alpha) {
    float p = 0.5 / alpha;
    h = clamp(h, 1e-9, 0.5);
    float g = exp(p * log(2.0 * h));
    float first = p / h;
    return g * vec2(fma(v * first, fma((p - 1.0) / h, mu, -4.0 * f), mu), fma(-0.5 * first, mu, f));
}

// The room of a node, at the place of the node that is nearest to the ring: three times its width at the horizon, less
// towards the axis; once, at most 0.12, where an axis's horizon may run through the node.
float room(float away2, float reach, float extent, float alpha) {
    float p = 0.5 / alpha;
    float ring = 1.0 / (p + 1.0);
    float mu = fma(-0.5, away2, 1.0), margin = reach + extent;
    float x = 1.0 - clamp(mu - margin, ring, 1.0 - 1e-4);
    float sine_over = max(sqrt(x / (2.0 - x)), 0.1);
    float whole = min(3.0 * ring * sine_over * fainter(fma(-p, log(x), -1.0)), 0.3);
    return abs(mu) <= margin + extent ? min(whole, min(ring, 0.12)) : whole;
}
