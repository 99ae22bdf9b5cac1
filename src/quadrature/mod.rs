// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numerical integration: fixed rules for the bakes, an adaptive integrator for the truth that checks them; and the minima
//! that fits look for, polynomials between nodes, linear systems.

pub mod adaptive;
pub mod gauss_kronrod;
pub mod gauss_legendre;
pub mod gmres;
pub mod lagrange;
pub mod newton;
