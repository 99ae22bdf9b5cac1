//! Fresnel reflectance.

/// Schlick's weight (1 − v·h)⁵ from m = 1 − v·h. Schlick 1994, Eq. 15: F = F0 + (F90 − F0)·weight.
/// Domain: m in [0, 1]. GLSL twin `shaders/term/fresnel.glsl`.
pub fn schlick_weight(m: f64) -> f64 {
    let m2 = m * m;
    m2 * m2 * m
}

/// Reflectance of the plane face of a dielectric, unpolarised: the mean of Fresnel's two. Born, Wolf, Principles of Optics,
/// 7th ed., section 1.5.2. 1 under total internal reflection.
/// Domain: v_dot_h in [0, 1]; eta > 0, the index of the other side over that of this one.
/// GLSL twin `shaders/term/fresnel.glsl`.
pub fn dielectric(v_dot_h: f64, eta: f64) -> f64 {
    // (eta · cosine inside)² by Snell's law.
    let inside2 = eta * eta - (1.0 - v_dot_h * v_dot_h);
    if inside2 <= 0.0 {
        return 1.0;
    }
    let inside = inside2.sqrt();
    let s = (v_dot_h - inside) / (v_dot_h + inside);
    let p = (eta * eta * v_dot_h - inside) / (eta * eta * v_dot_h + inside);
    0.5 * (s * s + p * p)
}

/// Reflectance of the plane face of a medium that absorbs, of complex index eta − ik relative to this side, unpolarised.
/// Born, Wolf, Principles of Optics, 7th ed., section 14.2. With a + ib = √(eta² − k² − s² + 2i eta k), s² = 1 − c²:
/// Rs = ((a − c)² + b²)/((a + c)² + b²), Rp = Rs ((ac − s²)² + (bc)²)/((ac + s²)² + (bc)²), without a limit at c = 0.
/// Domain: v_dot_h in [0, 1], eta > 0, k ≥ 0. GLSL twin `shaders/term/fresnel.glsl`.
pub fn conductor(v_dot_h: f64, eta: f64, k: f64) -> f64 {
    // All is reflected, even where eta = 1 and k = 0 leave 0/0.
    if v_dot_h <= 0.0 {
        return 1.0;
    }
    let sin2 = 1.0 - v_dot_h * v_dot_h;
    let re = eta * eta - k * k - sin2;
    let modulus = (re * re + 4.0 * eta * eta * k * k).sqrt();
    // The larger part is a sum; the other follows from ab = eta k without a difference.
    let larger = (0.5 * (modulus + re.abs())).sqrt();
    let smaller = if larger > 0.0 { eta * k / larger } else { 0.0 };
    let (a, b) = if re >= 0.0 { (larger, smaller) } else { (smaller, larger) };
    let square = |x: f64| x * x;
    let s = (square(a - v_dot_h) + b * b) / (square(a + v_dot_h) + b * b);
    let b_cos2 = square(b * v_dot_h);
    let p_over_s = (square(a * v_dot_h - sin2) + b_cos2) / (square(a * v_dot_h + sin2) + b_cos2);
    0.5 * s * (1.0 + p_over_s)
}
