// SPDX-License-Identifier: MIT OR Apache-2.0
//! Trigonometry that the kernels may rely on: Vulkan promises sin only to 2⁻¹¹ and atan not at all.

/// sin x. Domain: x in [0, π/2]. GLSL twin `shaders/term/trig.glsl`: odd polynomial of degree 11, absolute error 2e-8
/// before rounding.
pub fn sin_quarter(x: f64) -> f64 {
    x.sin()
}

/// atan x. Domain: x in [0, 1]. GLSL twin `shaders/term/trig.glsl`: odd polynomial of degree 19, absolute error 3e-9
/// before rounding.
pub fn atan_unit(x: f64) -> f64 {
    x.atan()
}

/// ½ acos x. Domain: any x; beyond [−1, 1] the end's value. GLSL twin `shaders/term/trig.glsl`: from [`atan_unit`], absolute
/// error 3e-7 before rounding.
pub fn half_acos(x: f64) -> f64 {
    0.5 * x.clamp(-1.0, 1.0).acos()
}
