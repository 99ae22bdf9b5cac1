// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terms that bakes share: visibility, Fresnel, cube faces. The GLSL twin of `term/x.rs` is `shaders/term/x.glsl`.

pub mod cube;
pub mod fainter;
pub mod fresnel;
pub mod surface;
pub mod trig;
pub mod visibility;
pub mod zonal;
