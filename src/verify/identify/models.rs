// SPDX-License-Identifier: MIT OR Apache-2.0
//! The models that are tried, and a sketch of each: a coarse interpolation that is cheap to ask anywhere.

use std::f64::consts::PI;

use crate::bake::{At, Model};
use crate::ndf::NDFS;
use crate::term::visibility::VISIBILITIES;

/// Weights that a table can be made of: E, B and T.
pub const WEIGHTS: usize = 3;
/// Nodes along √(n·v).
const VIEW_NODES: usize = 20;
/// Nodes along the roughness.
const ROUGHNESS_NODES: usize = 16;
/// Below this n·v a model may have no limit.
const LEAST_N_DOT_V: f64 = 1e-4;

/// Members of families that need a parameter, where one member has a use of its own: GTR's gamma = 1 is the clear coat of
/// Burley 2012.
const MEMBERS: [&str; 1] = ["gtr:gamma=1"];

/// Every distribution that needs no parameter, and [`MEMBERS`], with every geometry term.
pub fn candidates() -> Vec<Model> {
    let plain = NDFS.iter().filter(|n| n.parameters.iter().all(|p| !p.required)).map(|n| n.name);
    let ndfs: Vec<&str> = plain.chain(MEMBERS).collect();
    let pair = |ndf: &str, visibility: &str| Model::parse(ndf, visibility).expect("both are names of the registries");
    ndfs.iter().flat_map(|ndf| VISIBILITIES.iter().map(move |v| pair(ndf, v.name))).collect()
}

/// The rule, kept away from limits that do not exist.
pub fn rule(model: &Model, n_dot_v: f64, roughness: f64) -> [f64; WEIGHTS] {
    let n_dot_v = if model.visibility.diverges_at_grazing { n_dot_v.max(LEAST_N_DOT_V) } else { n_dot_v };
    let roughness = if model.ndf.family.flat.falling { roughness.max(0.01) } else { roughness };
    let [e, b, t, _] = model.rule(At { n_dot_v, roughness });
    [e, b, t]
}

/// E, B and T at Chebyshev points of √(n·v) and roughness, good to about 1e-2 at grazing on smooth surfaces, and to 1e-3
/// elsewhere.
pub struct Sketch {
    /// Node values, `[√(n·v)][roughness]`.
    nodes: Vec<[f64; WEIGHTS]>,
    /// The values are multiplied by n·v, because they grow like its inverse.
    diverges: bool,
}

impl Sketch {
    /// Asks the rule at every node.
    pub fn new(model: &Model) -> Sketch {
        let diverges = model.visibility.diverges_at_grazing;
        let (views, roughnesses) = (points(VIEW_NODES), points(ROUGHNESS_NODES));
        let mut nodes = vec![[0.0; WEIGHTS]; VIEW_NODES * ROUGHNESS_NODES];
        // Row by row, because the rule keeps what a roughness needs.
        for (r, roughness) in roughnesses.iter().enumerate() {
            for (v, view) in views.iter().enumerate() {
                let n_dot_v = view * view;
                let scale = if diverges { n_dot_v } else { 1.0 };
                nodes[v * ROUGHNESS_NODES + r] = rule(model, n_dot_v, *roughness).map(|x| scale * x);
            }
        }
        Sketch { nodes, diverges }
    }

    /// Values along the roughness nodes at an n·v.
    pub fn column(&self, view: &View) -> [[f64; ROUGHNESS_NODES]; WEIGHTS] {
        let mut column = [[0.0; ROUGHNESS_NODES]; WEIGHTS];
        let scale = if self.diverges { 1.0 / view.n_dot_v.max(LEAST_N_DOT_V) } else { 1.0 };
        for (weight, row) in view.weights.iter().zip(self.nodes.chunks_exact(ROUGHNESS_NODES)) {
            for (r, node) in row.iter().enumerate() {
                for (to, from) in column.iter_mut().zip(node) {
                    to[r] += scale * weight * from;
                }
            }
        }
        column
    }
}

/// An n·v, ready to interpolate at.
#[derive(Clone)]
pub struct View {
    n_dot_v: f64,
    weights: [f64; VIEW_NODES],
}

impl View {
    /// At n·v in [0, 1].
    pub fn new(n_dot_v: f64) -> View {
        View { n_dot_v, weights: weights(n_dot_v.sqrt()) }
    }
}

/// A roughness, ready to interpolate at.
#[derive(Clone)]
pub struct Rough([f64; ROUGHNESS_NODES]);

impl Rough {
    /// At a roughness in [0, 1].
    pub fn new(roughness: f64) -> Rough {
        Rough(weights(roughness))
    }

    /// E, B and T from a column of nodes.
    pub fn of(&self, column: &[[f64; ROUGHNESS_NODES]; WEIGHTS]) -> [f64; WEIGHTS] {
        column.map(|nodes| nodes.iter().zip(&self.0).map(|(a, b)| a * b).sum())
    }
}

/// Chebyshev points of the first kind on [0, 1].
fn points(n: usize) -> Vec<f64> {
    (0..n).map(|k| 0.5 - 0.5 * (PI * (k as f64 + 0.5) / n as f64).cos()).collect()
}

/// Interpolation weights of each point at x (Berrut, Trefethen 2004, Eq. 4.2).
fn weights<const N: usize>(x: f64) -> [f64; N] {
    let points = points(N);
    if let Some(hit) = points.iter().position(|p| (p - x).abs() < 1e-12) {
        return std::array::from_fn(|k| if k == hit { 1.0 } else { 0.0 });
    }
    let term = |k: usize| {
        let sine = (PI * (k as f64 + 0.5) / N as f64).sin();
        (if k.is_multiple_of(2) { sine } else { -sine }) / (x - points[k])
    };
    let sum: f64 = (0..N).map(term).sum();
    std::array::from_fn(|k| term(k) / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sketch_is_near_the_rule() {
        for (ndf, visibility) in [("ggx", "smith"), ("ggx", "charlie"), ("ggx", "schlick-ggx")] {
            let model = Model::parse(ndf, visibility).unwrap();
            let sketch = Sketch::new(&model);
            for (n_dot_v, roughness) in [(0.02, 0.7), (0.3, 0.1), (0.6, 0.4), (1.0, 1.0)] {
                let near = Rough::new(roughness).of(&sketch.column(&View::new(n_dot_v)));
                for (a, b) in near.iter().zip(rule(&model, n_dot_v, roughness)) {
                    assert!((a - b).abs() < 3e-3 * b.max(1.0), "{ndf} {visibility} {n_dot_v} {roughness}: {a} not {b}");
                }
            }
        }
    }

    #[test]
    fn candidates_come_from_the_registries() {
        let all = candidates();
        assert_eq!(all.len() % VISIBILITIES.len(), 0);
        assert!(all.iter().any(|m| m.ndf.to_string() == "gtr:gamma=1" && m.visibility.name == "neumann"));
    }
}
