//! Terms that bakes share: visibility, Fresnel. The GLSL twin of `term/x.rs` is `shaders/term/x.glsl`.

pub mod fresnel;
pub mod trig;
pub mod visibility;
