// SPDX-License-Identifier: MIT OR Apache-2.0
//! Checks: the independent truth, the laws, and what they say of a file.

mod averages;
pub mod certificate;
pub mod cube;
pub mod cube_truth;
pub mod engine;
pub mod environment;
pub mod fibre_layer;
pub mod identify;
pub mod law;
pub mod ltc;
pub mod own;
pub mod refraction;
pub mod seams;
pub mod table;
pub mod truth;
