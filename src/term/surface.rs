// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a surface shares out the light: specular reflection of a metal and of a dielectric, and what a dielectric leaves to
//! the body below. GLSL twin: `shaders/term/surface.glsl`.
//!
//! Single scattering is linear in F0, so that a blend of metal and dielectric is the familiar F0 = mix(0.04, base color,
//! metallic). Compensation is not linear, and is applied to each part on its own: a white surface in a white room then
//! reflects all light, whatever its roughness and however metallic it is.

/// By what compensation for multiple scattering multiplies single scattering: 1 + f0 (1/E − 1). Turquin 2019, Eq. 16.
/// Domain: f0 in [0, 1], albedo E in (0, 1].
pub fn compensation(f0: f64, albedo: f64) -> f64 {
    1.0 + f0 * (1.0 / albedo - 1.0)
}

/// Specular reflection of one channel, from the split sum's parts of it: metallic · metal + (1 − metallic) · dielectric.
/// `split` holds what F0 and F90 are multiplied with, and the tint that `edge` takes from a metal's
/// ([`crate::material::Metal::f0_and_edge`]). `gain_metal` and `gain_dielectric` are their compensations, or 1.
pub fn specular(
    split: [f64; 3],
    base: f64,
    edge: f64,
    f0: f64,
    metallic: f64,
    gain_metal: f64,
    gain_dielectric: f64,
) -> f64 {
    let [scale, bias, f82] = split;
    let dielectric = (f0 * scale + bias) * gain_dielectric;
    let metal = (base * scale + bias - edge * f82) * gain_metal;
    dielectric + metallic * (metal - dielectric)
}

/// Share of one channel of the irradiance over π that comes back out of the body. `reflected` is the dielectric's albedo.
pub fn body(base: f64, metallic: f64, reflected: f64) -> f64 {
    (1.0 - metallic) * base * (1.0 - reflected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_in_a_white_room() {
        for (scale, bias) in [(0.9, 0.05), (0.3, 0.01), (1.0, 0.0)] {
            for metallic in [0.0, 0.3, 1.0] {
                let albedo = scale + bias;
                let [metal, dielectric] = [1.0, 0.04].map(|f0| compensation(f0, albedo));
                let reflected = specular([scale, bias, 0.05], 1.0, 0.0, 0.04, metallic, metal, dielectric);
                let alone = specular([scale, bias, 0.05], 1.0, 0.0, 0.04, 0.0, metal, dielectric);
                let total = reflected + body(1.0, metallic, alone);
                assert!((total - 1.0).abs() < 1e-15, "{scale} {bias} {metallic}: {total}");
            }
        }
    }

    #[test]
    fn without_compensation_f0_is_mixed() {
        let mixed = 0.04 + 0.7 * (0.5 - 0.04);
        let split = [0.6, 0.1, 0.02];
        assert!((specular(split, 0.5, 0.0, 0.04, 0.7, 1.0, 1.0) - (mixed * 0.6 + 0.1)).abs() < 1e-15);
        // A dielectric's edge is not tinted.
        let tinted = specular(split, 0.5, 3.0, 0.04, 0.7, 1.0, 1.0);
        assert!((tinted - (mixed * 0.6 + 0.1 - 0.7 * 3.0 * 0.02)).abs() < 1e-15);
    }
}
