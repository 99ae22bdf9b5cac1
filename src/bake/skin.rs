// SPDX-License-Identifier: MIT OR Apache-2.0
//! Diffuse light on skin, pre-integrated over a sphere: what a curved surface shows of a light in the direction l when it
//! scatters below, over n·l and the curvature 1/r in 1/mm, in linear sRGB.
//!
//! On a sphere of radius r, with θ the angle between n and l (Penner, Borshukov 2011, Pre-Integrated Skin Shading, Eq. 1),
//!
//! skin = ∫ max(cos(θ + x), 0) R(2 r sin(x/2)) dx / ∫ R(2 r sin(x/2)) dx,   x from −π to π
//!
//! with the profile R(s) = Σ w exp(−s²/(2v))/(2πv) of six Gaussians that d'Eon and Luebke fitted to measured skin (2007, GPU
//! Gems 3, chapter 14, table 1). A texel holds red, green and blue; a surface without curvature shows max(n·l, 0).
//!
//! The rule is Gauss–Legendre on panels that grow with the distance from x = 0 and end where the light sets. No kernel: a
//! table is a few million exponentials.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

use super::albedo::channel;
use super::{At, Channel, Facts, MAX_CHANNELS, Model, Table, Tolerance, Usual, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result};
use crate::quadrature::adaptive::{Estimate, integrate};
use crate::quadrature::gauss_legendre::{Node, gauss_legendre};
use crate::term::fresnel::Fresnel;

/// The table.
pub struct Skin;

/// Variance in mm² and weights of red, green and blue. D'Eon, Luebke 2007, table 1.
const PROFILE: [(f64, [f64; 3]); 6] = [
    (0.0064, [0.233, 0.455, 0.649]),
    (0.0484, [0.100, 0.336, 0.344]),
    (0.187, [0.118, 0.198, 0.0]),
    (0.567, [0.113, 0.007, 0.007]),
    (1.99, [0.358, 0.004, 0.0]),
    (7.41, [0.078, 0.0, 0.0]),
];

/// Ends of the panels in mm: each Gaussian is smooth within one.
const PANEL_ENDS_MM: [f64; 9] = [0.08, 0.2, 0.45, 0.9, 1.8, 3.5, 7.0, 12.0, 20.0];
/// Nodes a panel.
const NODES: usize = 16;

static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| gauss_legendre(NODES));

static CHANNELS: [Channel; 3] = [
    channel("red", "diffuse light of red that curved skin shows"),
    channel("green", "the same of green"),
    channel("blue", "the same of blue"),
];

static FACTS: Facts = Facts {
    name: "skin",
    about: "pre-integrated skin: diffuse light in red, green, blue over n.l and the curvature in 1/mm, up to 1",
    source: "Penner, Borshukov 2011, Pre-Integrated Skin Shading, GPU Pro 2; d'Eon, Luebke 2007, GPU Gems 3, chapter 14",
    usage: "diffuse = color / pi * light * skin, in place of max(n_dot_l, 0)",
    channels: |_| &CHANNELS,
    complement: None,
    default_channels: |_| &["red", "green", "blue"],
    fresnel: Fresnel::ONE,
    axes: &[Coordinate::NDotL, Coordinate::Curvature],
    slices: &[],
    rule: |_| format!("Gauss-Legendre, {NODES} nodes a panel"),
    tolerance: Tolerance { worst: 1e-6, median: 2.5e-7, near_zero: 2e-6, why: "src/bake/skin.rs: 1e-8 in f64" },
};

/// Red, green and blue of the profile at a distance in mm.
fn profile(distance_mm: f64) -> [f64; 3] {
    let s2 = distance_mm * distance_mm;
    PROFILE.iter().fold([0.0; 3], |mut sum, (variance, weights)| {
        let gaussian = (-0.5 * s2 / variance).exp() / (2.0 * PI * variance);
        sum.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * gaussian);
        sum
    })
}

/// Both integrals by the rule, then their quotient.
fn skin(n_dot_l: f64, curvature: f64) -> [f64; 3] {
    if curvature == 0.0 {
        return [n_dot_l.max(0.0); 3];
    }
    let theta = n_dot_l.clamp(-1.0, 1.0).acos();
    let radius = 1.0 / curvature;
    // The angle whose chord is that long; half a turn where none is.
    let angle = |mm: &f64| 2.0 * (0.5 * mm * curvature).min(1.0).asin();
    let mut breaks: Vec<f64> = PANEL_ENDS_MM.iter().map(angle).collect();
    breaks.extend([0.0, PI]);
    breaks.extend(breaks.clone().iter().map(|x| -x));
    // Where the light sets, on either side.
    breaks.extend([FRAC_PI_2 - theta, -FRAC_PI_2 - theta, 1.5 * PI - theta].into_iter().filter(|x| x.abs() < PI));
    breaks.sort_by(f64::total_cmp);
    let (mut lit, mut all) = ([0.0; 3], [0.0; 3]);
    for ends in breaks.windows(2).filter(|ends| ends[1] - ends[0] > 1e-12) {
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        for node in RULE.iter() {
            let x = middle + half * node.x;
            let light = (theta + x).cos().max(0.0);
            for (c, scattered) in profile(2.0 * radius * (0.5 * x).sin()).into_iter().enumerate() {
                all[c] += half * node.weight * scattered;
                lit[c] += half * node.weight * scattered * light;
            }
        }
    }
    std::array::from_fn(|c| lit[c] / all[c])
}

fn values([r, g, b]: [f64; 3]) -> Values {
    [r, g, b, 0.0]
}

impl Table for Skin {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn usual(&self) -> Usual {
        Usual { on_processor: true, ..Usual::TABLE }
    }

    fn check(&self, model: &Model) -> Result<()> {
        if model.ndf.to_string() == "ggx" && model.visibility.name == "smith" && model.fresnel.term.name == "one" {
            return Ok(());
        }
        Err(Error::usage("skin is diffuse: it has no distribution, geometry or Fresnel term", "drop them"))
    }

    fn rule(&self, _model: &Model, at: At) -> Values {
        values(skin(at.n_dot_v, at.roughness))
    }

    /// Adaptive integration over the distance along the sphere in mm, out to where nothing is left.
    fn truth(&self, _model: &Model, at: At, tolerance: f64) -> Estimate<MAX_CHANNELS> {
        let (n_dot_l, curvature) = (at.n_dot_v, at.roughness);
        if curvature == 0.0 {
            return Estimate { value: values([n_dot_l.max(0.0); 3]), error: 0.0 };
        }
        let theta = n_dot_l.clamp(-1.0, 1.0).acos();
        let end = (PI / curvature).min(30.0);
        let found = integrate(&[-end, -0.5, 0.0, 0.5, end], 0.01 * tolerance, 1 << 12, |mm| {
            let [r, g, b] = profile(2.0 / curvature * (0.5 * mm * curvature).sin());
            let light = (theta + mm * curvature).cos().max(0.0);
            Estimate { value: [r, g, b, r * light, g * light, b * light], error: 0.0 }
        });
        let [r, g, b, lit_r, lit_g, lit_b] = found.value;
        Estimate { value: values([lit_r / r, lit_g / g, lit_b / b]), error: 2.0 * found.error / r.min(g).min(b) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profile_reflects_white_as_white() {
        for c in 0..3 {
            let sum: f64 = PROFILE.iter().map(|(_, weights)| weights[c]).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{c}: {sum}");
        }
    }

    #[test]
    fn skin_is_its_truth_and_scatters_red_furthest() {
        let model = Model::parse("ggx", "smith").unwrap().with(Fresnel::ONE);
        let mut worst = 0.0f64;
        for curvature in [0.004, 0.03, 0.2, 0.7, 1.0] {
            for n_dot_l in [-1.0, -0.4, -0.02, 0.0, 0.05, 0.6, 1.0] {
                let at = At { n_dot_v: n_dot_l, roughness: curvature };
                let (rule, truth) = (Skin.rule(&model, at), Skin.truth(&model, at, 1e-7));
                for c in 0..3 {
                    worst = worst.max((rule[c] - truth.value[c]).abs());
                    assert!((rule[c] - truth.value[c]).abs() <= 1e-7 + truth.error, "{at:?} {c}: {rule:?} {truth:?}");
                }
            }
        }
        let [r, g, b, _] = Skin.rule(&model, At { n_dot_v: -0.1, roughness: 0.7 });
        assert!(r > g && g > b && b > 0.0, "{r} {g} {b}");
        println!("skin: worst {worst:.1e}");
        // Little curvature is none.
        let [r, ..] = skin(0.5, 1e-3);
        assert!((r - 0.5).abs() < 1e-5, "{r}");
    }
}
