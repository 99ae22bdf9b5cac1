//! Fresnel reflectance.

/// Schlick's weight (1 − v·h)⁵ from m = 1 − v·h. Schlick 1994, Eq. 15: F = F0 + (F90 − F0)·weight.
/// Domain: m in [0, 1]. GLSL twin `shaders/term/fresnel.glsl`.
pub fn schlick_weight(m: f64) -> f64 {
    let m2 = m * m;
    m2 * m2 * m
}
