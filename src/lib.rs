//! Bakes the lookup tables of physically based shading by deterministic quadrature.
#![deny(unsafe_code)]

pub mod axis;
pub mod env;
pub mod error;
pub mod format;
pub mod progress;
pub mod term;
pub mod texture;

pub use error::{Error, Result};
