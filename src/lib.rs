//! Bakes the lookup tables of physically based shading by deterministic quadrature.
#![deny(unsafe_code)]

pub mod axis;
pub mod bake;
pub mod env;
pub mod error;
pub mod format;
pub mod gpu;
pub mod ndf;
pub mod progress;
pub mod quadrature;
pub mod rule;
pub mod shaders;
pub mod term;
pub mod texture;
pub mod verify;

pub use error::{Error, Result};
