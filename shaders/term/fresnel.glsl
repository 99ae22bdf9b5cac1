// Fresnel reflectance. Rust twin: src/term/fresnel.rs.

// Schlick's weight (1 - v.h)^5 from m = 1 - v.h. Schlick 1994, Eq. 15. Domain: m in [0, 1].
float schlick_weight(float m) {
    float m2 = m * m;
    return m2 * m2 * m;
}
