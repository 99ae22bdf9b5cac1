// SPDX-License-Identifier: MIT OR Apache-2.0
//! Nodes of the cone rule. Shared with the build script, which writes them into the shader.

use crate::quadrature::gauss_legendre::gauss_legendre;

/// Nodes across the cone's short axis; mirror symmetry leaves only the positive half of a rule twice as long.
pub const OUTER: usize = 9;
/// Nodes along the cone's long axis; evaluated in pairs ±x.
pub const INNER: usize = 36;
/// How far the tanh–sinh map of the long axis reaches: larger crowds the nodes at the horizon.
const REACH: f64 = 2.0;

/// A node g in (0, 1) across the cone.
#[derive(Clone, Copy, Debug)]
pub struct Outer {
    /// 1 − g, without cancellation.
    pub near: f64,
    /// 1 + g.
    pub far: f64,
    /// Weight; a rule's weights sum to 1.
    pub weight: f64,
}

/// A pair of nodes ±x along the cone, x in (0, 1).
#[derive(Clone, Copy, Debug)]
pub struct Inner {
    /// Abscissa.
    pub x: f64,
    /// 1 − x², without cancellation.
    pub one_minus_x2: f64,
    /// Weight of each node of the pair; a rule's weights sum to 1.
    pub weight: f64,
}

/// The nodes across: Gauss–Legendre through g = (3x − x³)/2, which flattens the integrand at the end of the range.
pub fn outer() -> Vec<Outer> {
    let positive = gauss_legendre(2 * OUTER).into_iter().skip(OUTER);
    positive
        .map(|node| {
            let x = node.x;
            let near = 0.5 * (1.0 - x) * (1.0 - x) * (2.0 + x);
            Outer { near, far: 2.0 - near, weight: node.weight * 1.5 * (1.0 - x) * (1.0 + x) }
        })
        .collect()
}

/// The pairs along: Gauss–Legendre through T(kx)/T(k) with T(x) = tanh(½π sinh x), which resolves the square-root
/// behaviour at the horizon.
pub fn inner() -> Vec<Inner> {
    use std::f64::consts::FRAC_PI_2;
    let map = |x: f64| (FRAC_PI_2 * x.sinh()).tanh();
    let end = map(REACH);
    let positive = gauss_legendre(INNER).into_iter().skip(INNER / 2);
    positive
        .map(|node| {
            let t = map(REACH * node.x);
            let x = t / end;
            let slope = REACH * FRAC_PI_2 * (REACH * node.x).cosh() * (1.0 - t) * (1.0 + t) / end;
            Inner { x, one_minus_x2: (end - t) * (end + t) / (end * end), weight: node.weight * slope }
        })
        .collect()
}
