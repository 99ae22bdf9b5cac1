// SPDX-License-Identifier: MIT OR Apache-2.0
// How a surface shares out the light: specular reflection of a metal and of a dielectric, and what a dielectric leaves to the
// body below. Rust twin: src/term/surface.rs.

// By what compensation for multiple scattering multiplies single scattering: 1 + f0 (1/E - 1). Turquin 2019, Eq. 16.
// Domain: f0 in [0, 1], albedo E in (0, 1].
float compensation(float f0, float albedo) {
    return 1.0 + f0 * (1.0 / albedo - 1.0);
}

// Specular reflection of one channel, from the split sum's parts of it: metallic * metal + (1 - metallic) * dielectric.
// `split` holds what F0 and F90 are multiplied with, and the tint that `edge` takes from a metal's. `gain_metal` and
// `gain_dielectric` are their compensations, or 1.
float specular(
    vec3 split, float base, float edge, float f0, float metallic, float gain_metal, float gain_dielectric) {
    float dielectric = (f0 * split.x + split.y) * gain_dielectric;
    float metal = (base * split.x + split.y - edge * split.z) * gain_metal;
    return mix(dielectric, metal, metallic);
}

// Share of one channel of the irradiance over pi that comes back out of the body. `reflected` is the dielectric's albedo.
float body(float base, float metallic, float reflected) {
    return (1.0 - metallic) * base * (1.0 - reflected);
}
