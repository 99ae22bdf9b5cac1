// SPDX-License-Identifier: MIT OR Apache-2.0
// The limit of a lobe that narrows to a mirror. Rust twin: `mirror` in src/rule/cone.rs. A geometry term and a Fresnel term
// are included before.

// G(v, mirrored v) times the Fresnel weights at n_dot_v. Domain: n_dot_v in [0, 1].
vec4 mirror(float n_dot_v, Optics optics) {
    float mu = max(n_dot_v, 1e-6);
    float g = mu * g_over_n_dot_v(Directions(mu, mu, 1.0, mu, mu, mu, 0.0));
    return g * weights(n_dot_v, optics);
}
