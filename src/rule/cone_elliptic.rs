// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cone rule for anisotropic GGX: the same quadratic cone as in [`super::cone`], on axes found numerically.
//!
//! Stretched by diag(1/ax, 1/ay, 1), the facets that are seen from v lie on a hemisphere with a density proportional to
//! the cosine with w = (ax v_x, ay v_y, n·v), and those that reflect v upwards fill the cone h'ᵀ S h' > 0,
//!
//! S = w zᵀ + z wᵀ − (n·v) diag(ax², ay², 1),    h'ᵀ S h' = (n·l) N²,    N² = ax² h'_x² + ay² h'_y² + h'_z².
//!
//! S has one positive eigenvalue l1 (axis e1, upwards) and two that are not, −l2 on e2 and −l3 on e3. With latitude A towards
//! e3 and longitude d towards e2 the cone is |tan A| < √(l1/l3), sin² d < s2 = (l1 − l3 tan² A)/(l1 + l2), and
//! (n·l) N² = (l1 + l2) cos² A (s2 − sin² d): a rectangle again, no node is masked off.
//!
//! Unequal axes raise a peak of 1/N² at the narrow axis, just outside of the cone and near one end of its long axis; the
//! latitudes crowd around it by a sinh map. f64 error against adaptive integration over n·v, roughness in [1/512, 1] and any
//! azimuth: 3e-5 for axes of 1 : 10 and 1 : 25, 3e-6 for 1 : 4, 2e-7 for nearly equal ones.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

use super::cone_nodes::{Inner, inner};
use crate::ndf::ggx::Ellipse;
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::term::fresnel::{Fresnel, WEIGHTS, Weights};
use crate::term::visibility::Directions;

/// Nodes of latitude.
pub const OUTER: usize = 48;
/// Vectors of four numbers that describe a texel to a kernel.
pub const RECORD: usize = 5;

static OUTER_RULE: LazyLock<Vec<Node>> = LazyLock::new(|| {
    // (3x − x³)/2 flattens the square-root ends.
    let map = |n: Node| Node { x: 0.5 * n.x * (3.0 - n.x * n.x), weight: 1.5 * n.weight * (1.0 - n.x) * (1.0 + n.x) };
    gauss_legendre(OUTER).into_iter().map(map).collect()
});
static INNER_RULE: LazyLock<Vec<Inner>> = LazyLock::new(inner);

/// What a texel's nodes have in common.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// The ellipse of normals; its azimuth is that of v.
    pub ellipse: Ellipse,
    /// Direction of view, x along the ellipse's first axis.
    pub v: [f64; 3],
    /// The cone's axes.
    pub axes: [[f64; 3]; 3],
    /// l1, l2, l3, none negative.
    pub eigenvalues: [f64; 3],
    /// The stretched direction of view along the cone's axes.
    pub w: [f64; 3],
}

/// A latitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latitude {
    /// tan A.
    pub tan: f64,
    /// sin² of the half width in longitude.
    pub sin2: f64,
    /// cos² of the half width, without cancellation.
    pub cos2: f64,
    /// Everything that does not depend on the longitude.
    pub weight: f64,
}

impl Cone {
    /// The cone of a view at cosine `n_dot_v`, in the azimuth that the ellipse states.
    pub fn new(ellipse: Ellipse, n_dot_v: f64) -> Cone {
        let mu = n_dot_v;
        let sv = ((1.0 - mu) * (1.0 + mu)).sqrt();
        let v = [sv * ellipse.cos, sv * ellipse.sin, mu];
        let [ax, ay] = ellipse.alpha;
        let w = [ax * v[0], ay * v[1], mu];
        let s = [[-mu * ax * ax, 0.0, w[0]], [0.0, -mu * ay * ay, w[1]], [w[0], w[1], mu]];
        let mut pairs = eigen(s);
        // The positive one first, then the steeper and the gentler of the negative ones.
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (first, third, second) = (pairs[0], pairs[1], pairs[2]);
        let upwards = if first.1[2] < 0.0 { -1.0 } else { 1.0 };
        let axes = [first.1.map(|x| upwards * x), second.1, third.1];
        let eigenvalues = [first.0.max(0.0), (-second.0).max(0.0), (-third.0).max(0.0)];
        let w = axes.map(|e| dot(w, e));
        Cone { ellipse, v, axes, eigenvalues, w }
    }

    /// Width of the peak in latitude: the root of N²'s least value along A = 0 over its growth with the latitude.
    fn peak_width(&self) -> f64 {
        let [ax, ay] = self.ellipse.alpha;
        let q = |a: [f64; 3], b: [f64; 3]| ax * ax * a[0] * b[0] + ay * ay * a[1] * b[1] + a[2] * b[2];
        let [e1, e2, e3] = self.axes;
        let across = q(e3, e3);
        let (c1, c2) = (q(e1, e3), q(e2, e3));
        let (a, b, c) = (q(e1, e1) - c1 * c1 / across, q(e1, e2) - c1 * c2 / across, q(e2, e2) - c2 * c2 / across);
        // The smaller eigenvalue of [[a, b], [b, c]] as a quotient: it may be tiny beside the larger.
        let large = 0.5 * (a + c) + (0.25 * (a - c) * (a - c) + b * b).sqrt();
        ((a * c - b * b).max(0.0) / (large * across)).sqrt()
    }

    /// The latitudes of the rule.
    pub fn latitudes(&self) -> impl Iterator<Item = Latitude> {
        let [l1, l2, l3] = self.eigenvalues;
        let am = if l3 > 0.0 { (l1 / l3).sqrt().atan() } else { FRAC_PI_2 };
        let width = (0.4 * self.peak_width().min(1.0)).max(1e-6);
        let peak = self.axes[2][1].asin().clamp(-am, am);
        let (from, to) = (((-am - peak) / width).asinh(), ((am - peak) / width).asinh());
        let stretch = 0.5 * (to - from);
        OUTER_RULE.iter().map(move |node| {
            let x = 0.5 * (from + to) + stretch * node.x;
            let (a, slope) = (peak + width * x.sinh(), width * stretch * x.cosh());
            let (sin, cos) = a.sin_cos();
            let tan2 = (sin / cos) * (sin / cos);
            let sin2 = ((l1 - l3 * tan2) / (l1 + l2)).clamp(0.0, 1.0);
            let cos2 = (l2 + l3 * tan2) / (l1 + l2);
            Latitude { tan: sin / cos, sin2, cos2, weight: node.weight * slope * cos * sin2.sqrt() / PI }
        })
    }

    /// The texel as `shaders/rule/cone_elliptic.glsl` reads it.
    pub fn record(&self) -> [[f32; 4]; RECORD] {
        let [e1, e2, e3] = self.axes;
        let [ax, ay] = self.ellipse.alpha;
        let vector = |xyz: [f64; 3], w: f64| [xyz[0] as f32, xyz[1] as f32, xyz[2] as f32, w as f32];
        [
            vector(self.w, self.eigenvalues[0] + self.eigenvalues[1]),
            vector(e1, ax),
            vector(e2, ay),
            vector(e3, self.ellipse.width()),
            vector(self.v, self.ellipse.sigma(self.v)),
        ]
    }
}

/// Directional albedo with F replaced by each weight of a smooth Fresnel term.
///
/// Domain: n_dot_v in [0, 1], axes in (0, 5]. `g_over_n_dot_v` is G/(n·v) of a smooth geometry term. The GLSL twin is
/// `shaders/rule/cone_elliptic.glsl`.
pub fn cone_elliptic(
    ellipse: Ellipse,
    n_dot_v: f64,
    g_over_n_dot_v: impl Fn(&Directions) -> f64,
    fresnel: &Fresnel,
) -> Weights {
    let cone = Cone::new(ellipse, n_dot_v);
    let [ax, ay] = ellipse.alpha;
    let alpha = ellipse.width();
    let [e1, e2, e3] = cone.axes;
    let sigma_v = ellipse.sigma(cone.v);
    let mut sum = [0.0; WEIGHTS];
    for node in cone.latitudes() {
        let cos_a = 1.0 / (1.0 + node.tan * node.tan).sqrt();
        let sin_a = node.tan * cos_a;
        let s = node.sin2.sqrt();
        let k_scale = (cone.eigenvalues[0] + cone.eigenvalues[1]) * cos_a * cos_a * node.sin2;

        let mut row = [0.0; WEIGHTS];
        for pair in INNER_RULE.iter() {
            let cos_d = (node.cos2 + node.sin2 * pair.one_minus_x2).sqrt();
            for sin_d in [s * pair.x, -s * pair.x] {
                let along = |x: [f64; 3]| cos_a * (cos_d * x[0] + sin_d * x[1]) + sin_a * x[2];
                let h = [0, 1, 2].map(|i| along([e1[i], e2[i], e3[i]]));
                let q = along(cone.w);
                let n2 = ax * ax * h[0] * h[0] + ay * ay * h[1] * h[1] + h[2] * h[2];
                let n_dot_l = k_scale * pair.one_minus_x2 / n2;
                let v_dot_h = q / n2.sqrt();
                // The mirrored direction, for its projected area.
                let l = [2.0 * q * ax * h[0] / n2 - cone.v[0], 2.0 * q * ay * h[1] / n2 - cone.v[1], n_dot_l];
                let sigma_l = ellipse.sigma(l);
                let n_dot_h = h[2] / n2.sqrt();
                let d = Directions { n_dot_l, n_dot_v, n_dot_h, v_dot_h, sigma_l, sigma_v, alpha };
                let f = pair.weight * q / cos_d * g_over_n_dot_v(&d);
                row.iter_mut().zip(fresnel.weights(v_dot_h.clamp(0.0, 1.0))).for_each(|(r, w)| *r += f * w);
            }
        }
        sum.iter_mut().zip(row).for_each(|(s, r)| *s += node.weight * r);
    }
    sum
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Eigenvalues and unit eigenvectors of a symmetric matrix, by Jacobi rotations.
fn eigen(mut m: [[f64; 3]; 3]) -> [(f64, [f64; 3]); 3] {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Convergence is quadratic; six sweeps leave nothing in f64.
    for _ in 0..6 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] == 0.0 {
                continue;
            }
            let theta = 0.5 * (m[q][q] - m[p][p]) / m[p][q];
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut m {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (row_p, row_q) = (m[p], m[q]);
            m[p] = [0, 1, 2].map(|i| c * row_p[i] - s * row_q[i]);
            m[q] = [0, 1, 2].map(|i| s * row_p[i] + c * row_q[i]);
            let (vp, vq) = (vectors[p], vectors[q]);
            vectors[p] = [0, 1, 2].map(|i| c * vp[i] - s * vq[i]);
            vectors[q] = [0, 1, 2].map(|i| s * vp[i] + c * vq[i]);
        }
    }
    [0, 1, 2].map(|i| (m[i][i], vectors[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_those_of_the_matrix() {
        let m = [[2.0, -1.0, 0.5], [-1.0, 0.3, 0.7], [0.5, 0.7, -1.0]];
        for (value, vector) in eigen(m) {
            for row in 0..3 {
                assert!((dot(m[row], vector) - value * vector[row]).abs() < 1e-14);
            }
            assert!((dot(vector, vector) - 1.0).abs() < 1e-14);
        }
    }
}
