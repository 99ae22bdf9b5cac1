// SPDX-License-Identifier: MIT OR Apache-2.0
//! How much more room a filter kernel leaves where it is faint. GLSL twin: `shaders/term/fainter.glsl`.

/// The factor where K is exp(−`fall`) of its peak: K^(−1/10), and below 1e-4 of the peak, where hardly any light is seen,
/// another K^(−1/3).
pub fn fainter(fall: f64) -> f64 {
    (0.1 * fall.clamp(0.0, 200.0) + (fall - 9.21).clamp(0.0, 60.0) / 3.0).exp()
}
