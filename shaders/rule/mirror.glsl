// The limit of a lobe that narrows to a mirror. Rust twin: `mirror` in src/rule/cone.rs. A geometry term is included before.

// (E, B): G(v, mirrored v) and its part weighted by (1 - n.v)^5. Domain: n_dot_v in [0, 1].
vec2 mirror(float n_dot_v) {
    float mu = max(n_dot_v, 1e-6);
    float g = mu * g_over_n_dot_v(Directions(mu, mu, 1.0, mu, mu, mu, 0.0));
    return g * vec2(1.0, schlick_weight(1.0 - n_dot_v));
}
