// Charlie lobe (Estevez, Kulla 2017, Eq. 2) with the weight n.w. Rust twin: src/term/zonal/charlie.rs.

// Mean over a node and slope: (x, y).
// Domain: h in (0, 1], mu >= 0, f in [0, 1], v >= 0, alpha in (0, 1].
vec2 over_node(float h, float mu, float f, float v, float alpha) {
    float p = 0.5 / alpha;
    h = clamp(h, 1e-9, 0.5);
    float g = exp(p * log(2.0 * h));
    float first = p / h;
    return g * vec2(fma(v * first, fma((p - 1.0) / h, mu, -4.0 * f), mu), fma(-0.5 * first, mu, f));
}

// The room of a node, at the place of the node that is nearest to the ring; more where the lobe is below 1e-5 of its peak.
float room(float away2, float reach, float extent, float alpha) {
    float p = 0.5 / alpha;
    float ring = 1.0 / (p + 1.0);
    float mu = fma(-0.5, away2, 1.0), margin = reach + extent;
    mu = clamp(clamp(ring, mu - margin, mu + margin), ring, 1.0);
    float x = max(1.0 - mu, 1e-4);
    float faint = clamp(fma(-p, log(x), -12.512925), 0.0, 60.0);
    return clamp(1.5 * x * ring * exp(faint / 3.0), min(0.75 * ring, 0.1), 0.3);
}
