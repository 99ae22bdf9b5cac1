// SPDX-License-Identifier: MIT OR Apache-2.0
//! Quadrature rules that bakes are made of. The GLSL twin of `rule/x.rs` is `shaders/rule/x.glsl`, that of the expansion, which
//! is a kernel, `shaders/bake/expansion.comp`; fits to a whole lobe have none, they run on the processor.

pub mod azimuth_nodes;
pub mod cone;
pub mod cone_elliptic;
pub mod cone_nodes;
pub mod expansion;
pub mod fibre_layer;
pub mod fibre_walk;
pub mod flake_modes;
pub mod h_split;
pub mod lobe_nodes;
pub mod ltc;
pub mod ltc_sheen;
pub mod ordinates;
pub mod rings;
pub mod slab;
pub mod transmit;
