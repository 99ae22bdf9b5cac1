// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bakes the lookup tables of physically based shading by deterministic quadrature: the right number in every texel, its
//! error stated in the file.
//!
//! ```
//! use brdf_baker::bake::{Backend, TableRequest};
//! use brdf_baker::progress::ignore;
//! use brdf_baker::verify::table::{Extent, check};
//!
//! // 16 × 16 texels of the split-sum table of GGX with height-correlated Smith, on the processor.
//! let job = TableRequest { size: (16, 16), ..TableRequest::new("split-sum") }.resolve()?;
//! let table = job.run(&Backend::Cpu, &mut ignore)?;
//! let [scale, bias] = table.texel(0, 0, 15, 0) else { unreachable!("two channels") };
//! assert!((scale + bias - 1.0).abs() < 1e-3); // smooth: nothing is lost
//!
//! // Compare with independent adaptive integration.
//! let report = check(&job, &table, None, Extent::Spot, &mut ignore)?;
//! assert!(report.failures.is_empty() && report.worst() < 1e-6);
//! # Ok::<(), brdf_baker::Error>(())
//! ```
//!
//! [`asset`] goes from a request to a file in one call: for the build script of a game, or an engine's asset pipeline.
//!
//! # Concepts
//! - A **table** ([`bake::TABLES`]) is a function of n·v and roughness; a **model** ([`bake::Model`]) is the distribution
//!   and the geometry term that it is computed for.
//! - A **rule** ([`rule`]) is a fixed quadrature. It runs as a Vulkan kernel in f32 and as its **twin** in f64.
//! - The **truth** ([`verify::truth`]) is adaptive f64 integration in other coordinates, with an error bound.
//! - A **material** ([`material`]) is a named metal or dielectric, with its reflectance as linear sRGB.
//! - A [`bake::Backend`] is a Vulkan device or the processor; a [`texture::Texture`] travels between all modules; a
//!   [`format::Format`] writes and reads it.
//! - What comes out can be looked at: [`plot`] draws curves and tables, [`spheres`] a grid of spheres under an environment,
//!   by the baked maps or by an integral of the same BRDF, [`view`] puts them on a page for browsers; [`env::sky`] is an
//!   environment without a file.
//! - A [`recipe`] declares a set of bakes in a file; what it writes states the hash of what it was baked from.
//!
//! # Conventions
//! The normal is +Z; `v`, `l`, `h` are unit vectors that point away from the surface. `roughness` is perceptual, in
//! [0, 1]; the width of a distribution is `alpha = roughness²`. BRDFs are per steradian. Tables have row 0 at the lowest
//! coordinate unless flipped, and a texel's value belongs to its center, (i + ½)/N, unless edges, i/(N − 1), are asked for.
//!
//! Minimum supported Rust version: 1.88.
#![deny(unsafe_code)]

pub mod asset;
pub mod axis;
pub mod bake;
pub mod brdf;
pub mod env;
pub mod error;
pub mod format;
pub mod glsl;
pub mod gpu;
pub mod material;
pub mod ndf;
pub mod plot;
pub mod progress;
pub mod quadrature;
pub mod recipe;
pub mod report;
pub mod rule;
pub mod shaders;
pub mod spheres;
mod stamp;
pub mod target;
pub mod term;
pub mod texture;
pub mod verify;
pub mod view;

pub use error::{Error, Result};

/// The README's examples run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The examples of the contributing guide are tests.
#[cfg(doctest)]
#[doc = include_str!("../CONTRIBUTING.md")]
struct Contributing;

/// So are those of the library's guide.
#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
struct Library;
