// SPDX-License-Identifier: MIT OR Apache-2.0
// Optical constants below the surface relative to those above. Rust twin: `Optics` in src/term/fresnel/mod.rs.

struct Optics {
    // Refractive index of red, green and blue; a dielectric has one, the first.
    vec3 eta;
    // Extinction coefficient, for conductors; from inside a dielectric the first is the cosine of the critical angle.
    vec3 k;
};
