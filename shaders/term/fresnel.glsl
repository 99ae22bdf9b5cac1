// Fresnel reflectance. Rust twin: src/term/fresnel.rs.

// Schlick's weight (1 - v.h)^5 from m = 1 - v.h. Schlick 1994, Eq. 15. Domain: m in [0, 1].
float schlick_weight(float m) {
    float m2 = m * m;
    return m2 * m2 * m;
}

// Reflectance of the plane face of a dielectric, unpolarised; 1 under total internal reflection. Born, Wolf, 7th ed.,
// section 1.5.2. Domain: v_dot_h in [0, 1]; eta > 0, the index of the other side over that of this one.
float dielectric(float v_dot_h, float eta) {
    float inside2 = eta * eta - (1.0 - v_dot_h * v_dot_h);
    if (inside2 <= 0.0) {
        return 1.0;
    }
    float inside = sqrt(inside2);
    float s = (v_dot_h - inside) / (v_dot_h + inside);
    float p = (eta * eta * v_dot_h - inside) / (eta * eta * v_dot_h + inside);
    return 0.5 * (s * s + p * p);
}

// Reflectance of the plane face of a medium of complex index eta - ik relative to this side, unpolarised. Born, Wolf,
// 7th ed., section 14.2. Domain: v_dot_h in [0, 1], eta > 0, k >= 0.
float conductor(float v_dot_h, float eta, float k) {
    if (v_dot_h <= 0.0) {
        return 1.0;
    }
    float sin2 = 1.0 - v_dot_h * v_dot_h;
    float re = eta * eta - k * k - sin2;
    float modulus = sqrt(re * re + 4.0 * eta * eta * k * k);
    float larger = sqrt(0.5 * (modulus + abs(re)));
    float smaller = larger > 0.0 ? eta * k / larger : 0.0;
    float a = re >= 0.0 ? larger : smaller;
    float b = re >= 0.0 ? smaller : larger;
    float s = ((a - v_dot_h) * (a - v_dot_h) + b * b) / ((a + v_dot_h) * (a + v_dot_h) + b * b);
    float lower = a * v_dot_h - sin2;
    float upper = a * v_dot_h + sin2;
    float b_cos = b * v_dot_h;
    return 0.5 * s * (1.0 + (lower * lower + b_cos * b_cos) / (upper * upper + b_cos * b_cos));
}
