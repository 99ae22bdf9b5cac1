// SPDX-License-Identifier: MIT OR Apache-2.0
//! Azimuth nodes of the h-split rule. Shared with the build script, which writes them into the shader.

use crate::quadrature::gauss_legendre::{Node, gauss_legendre};

/// Sizes that shaders may choose from, as `NODES_n`, or `NODES_n_FAR` with the nodes crowded at the horizon.
pub const SIZES: [usize; 7] = [6, 7, 8, 10, 12, 14, 16];

/// Gauss–Legendre nodes on [0, 1]; the weights sum to 1. With `far` through 1 − (1 − x)³, which crowds them at the end.
pub fn azimuth_nodes(n: usize, far: bool) -> Vec<Node> {
    let map = |node: Node| {
        let rest = 0.5 * (1.0 - node.x);
        let (x, slope) = if far { (1.0 - rest * rest * rest, 3.0 * rest * rest) } else { (1.0 - rest, 1.0) };
        Node { x, weight: 0.5 * node.weight * slope }
    };
    gauss_legendre(n).into_iter().map(map).collect()
}
