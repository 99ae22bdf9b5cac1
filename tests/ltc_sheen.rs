// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sheen of a random walk through fibres: against simulated walks, closed forms, adaptive integration, the published table.

mod common;

use std::f64::consts::{PI, TAU};
use std::path::Path;

use brdf_baker::bake::{At, Backend, Model, TableJob, TableRequest, table};
use brdf_baker::format;
use brdf_baker::progress::ignore;
use brdf_baker::quadrature::adaptive::{Estimate, integrate};
use brdf_baker::rule::fibre_walk::{Detail, FibreAlbedo, FibreLobes, PUBLISHED, Scatterings};
use brdf_baker::rule::lobe_nodes::LobeNodes;
use brdf_baker::rule::ltc_sheen::squared_error;
use brdf_baker::texture::Texture;
use brdf_baker::verify::table::{Extent, check};
use rayon::prelude::*;
use tempfile::TempDir;

use common::Random;
use common::program::{command, fails, succeeds};

/// None of the details that tables are baked or verified with.
const DETAIL: Detail = Detail { even: 0.09, finest: 0.045, cosines: 9, panel: 1.1, depths: 26, azimuths: 18 };

fn ggx() -> Model {
    Model::parse("ggx", "smith").unwrap()
}

/// What a test says of a number.
fn near(found: f64, expected: f64, bound: f64, what: &str) {
    assert!((found - expected).abs() <= bound, "{what}: {found} instead of {expected}, off by more than {bound:.1e}");
}

// --- Walks --------------------------------------------------------------------------------------------------------------

/// Sums over walks of what is compared, and of its squares: 1, z, x and x² − y² of a direction that counts as reflected.
#[derive(Clone, Copy, Default)]
struct Sums([[f64; 4]; 2]);

impl Sums {
    fn add(&mut self, [x, y, z]: [f64; 3]) {
        for (i, value) in [1.0, z, x, x * x - y * y].into_iter().enumerate() {
            self.0[0][i] += value;
            self.0[1][i] += value * value;
        }
    }

    /// Mean over `walks` and its standard error.
    fn mean(&self, i: usize, walks: usize) -> (f64, f64) {
        let [mean, square] = self.0.map(|sums| sums[i] / walks as f64);
        (mean, ((square - mean * mean) / walks as f64).sqrt())
    }
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| c / length)
}

/// Light that came from `n_dot_v`, walk by walk: what counts as reflected after 16 scatterings, and after all.
fn walks(sigma: f64, n_dot_v: f64, count: usize, seed: u64) -> [Sums; 2] {
    let mut random = Random(seed);
    let mut sums = [Sums::default(); 2];
    for _ in 0..count {
        let mut flight = [-(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, -n_dot_v];
        let (mut depth, mut scatterings) = (0.0, 0);
        loop {
            let [x, y, z] = flight;
            let area = (x * x + y * y + sigma * sigma * z * z).sqrt();
            depth += z * (1.0 - random.next()).ln() / area;
            if depth < 0.0 {
                if scatterings < 16 {
                    sums[0].add(flight);
                }
                sums[1].add(flight);
                break;
            }
            if depth > 1.0 {
                break;
            }
            // A flake is an ellipsoid's surface seen from where the light comes: a sphere's, when the ellipsoid is stretched
            // to one, and there the cosine's distribution, which is the sum of the pole and a point of the unit sphere.
            let to = unit([-x, -y, -sigma * z]);
            let (cos, phi) = (2.0 * random.next() - 1.0, TAU * random.next());
            let sin = (1.0 - cos * cos).sqrt();
            let on_sphere = [to[0] + sin * phi.cos(), to[1] + sin * phi.sin(), to[2] + cos];
            let m = unit([on_sphere[0], on_sphere[1], sigma * on_sphere[2]]);
            let along = 2.0 * flight.iter().zip(m).map(|(f, m)| f * m).sum::<f64>();
            flight = unit(std::array::from_fn(|i| flight[i] - along * m[i]));
            scatterings += 1;
            if scatterings == 16 && flight[2] > 0.0 {
                sums[0].add(flight);
            }
        }
    }
    sums
}

/// The same means by summing the lobe.
fn moments(lobe: &LobeNodes) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for ((l, f), w) in lobe.light.iter().zip(&lobe.value).zip(&lobe.solid_angle_sr) {
        for (sum, value) in sums.iter_mut().zip([1.0, l[2], l[0], l[0] * l[0] - l[1] * l[1]]) {
            *sum += w * f * value;
        }
    }
    sums
}

#[test]
fn simulated_walks_end_where_the_lobes_say() {
    const WALKS: usize = 250_000;
    let places = [(0.0968, 0.01), (0.0968, 0.1), (0.25, 0.05), (0.45, 0.3), (0.8, 0.9)];
    let off: Vec<f64> = places
        .par_iter()
        .enumerate()
        .flat_map_iter(|(i, &(alpha, n_dot_v))| {
            let sigma: f64 = alpha * alpha;
            let simulated = walks(sigma, n_dot_v, WALKS, 71 + i as u64);
            [PUBLISHED, None].into_iter().zip(simulated).flat_map(move |(scatterings, sums): (Scatterings, Sums)| {
                let albedo = FibreAlbedo::new(sigma, scatterings, DETAIL).at(n_dot_v);
                let lobe = moments(&FibreLobes::new(sigma, scatterings, DETAIL).at(n_dot_v));
                near(lobe[0], albedo, 2e-5, "the sum of a lobe");
                let place = format!("alpha {alpha}, n.v {n_dot_v}, {scatterings:?}");
                (0..4)
                    .map(|c| {
                        let (mean, error) = sums.mean(c, WALKS);
                        let sigmas = (lobe[c] - mean).abs() / error;
                        println!("{place}: moment {c} {:.5}, simulated {mean:.5}, {sigmas:.1} sigma", lobe[c]);
                        assert!(sigmas <= 4.0, "{place}: moment {c} {} instead of {mean} +- {error}", lobe[c]);
                        sigmas
                    })
                    .collect::<Vec<_>>()
            })
        })
        .collect();
    assert_eq!(off.len(), 40);
    // Two of three lie within one standard error: a bound that is too wide would see all of them there.
    let within = off.iter().filter(|sigmas| **sigmas < 1.0).count();
    assert!((16..=36).contains(&within), "{within} of 40");
    // The measure can tell: fibres that are wider by 5 % are others.
    let (mean, error) = walks(0.0625, 0.3, WALKS, 71)[1].mean(0, WALKS);
    let wider = FibreAlbedo::new(1.05 * 0.0625, None, DETAIL).at(0.3);
    assert!((wider - mean).abs() > 6.0 * error, "{wider} and {mean} +- {error}");
}

#[test]
fn where_a_walk_ends_matters_to_narrow_fibres_only() {
    let of = |alpha: f64, n_dot_v: f64| {
        [PUBLISHED, None].map(|scatterings| FibreAlbedo::new(alpha * alpha, scatterings, DETAIL).at(n_dot_v))
    };
    let [published, endless] = of(0.0323, 0.01);
    assert!(endless > published + 0.2, "{published} {endless}");
    let [published, endless] = of(0.5, 0.01);
    near(published, endless, 3e-6, "wide fibres");
}

// --- Orders of scattering -----------------------------------------------------------------------------------------------

/// D(h)/4 of light that is turned from one direction into another.
fn turned(sigma: f64, from: [f64; 3], to: [f64; 3]) -> f64 {
    let h = unit(std::array::from_fn(|i| to[i] - from[i]));
    let w = sigma * sigma * (1.0 - h[2] * h[2]) + h[2] * h[2];
    0.25 * sigma.powi(3) / (PI * w * w)
}

fn area(sigma: f64, cos: f64) -> f64 {
    (1.0 - cos * cos + sigma * sigma * cos * cos).sqrt()
}

fn direction(cos: f64, phi: f64) -> [f64; 3] {
    let sin = (1.0 - cos * cos).sqrt();
    [sin * phi.cos(), sin * phi.sin(), cos]
}

#[test]
fn second_order_is_what_two_fibres_send_up() {
    // With two scatterings a lobe is what leaves after the first, and all that the second turns upwards.
    for (alpha, n_dot_v) in [(0.8f64, 0.6), (0.5, 0.2)] {
        let sigma = alpha * alpha;
        let lobe = FibreLobes::new(sigma, Some(2), DETAIL).at(n_dot_v);
        let from = [-(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, -n_dot_v];
        let first = area(sigma, n_dot_v) / n_dot_v;
        let count = lobe.light.len();
        for i in [count / 3, count / 2 + 5, count - 30] {
            let to = lobe.light[i];
            let leaving = first + area(sigma, to[2]) / to[2];
            let once = turned(sigma, from, to) / n_dot_v * -(-leaving).exp_m1() / leaving;
            // All directions between, and how much of the light meets its second fibre inside.
            let azimuth = to[1].atan2(to[0]);
            let azimuths = [azimuth, PI, azimuth + TAU];
            let mut cosines = [-1.0, -n_dot_v, 0.0, to[2], 1.0];
            cosines.sort_by(f64::total_cmp);
            let twice = integrate(&cosines, 1e-6, 400, |cos| {
                let second = area(sigma, cos) / cos.abs();
                let faded = |t: f64| -(-t).exp_m1() / t;
                let inside = if cos > 0.0 {
                    faded(first) - faded(first + second)
                } else {
                    faded(first) - (-second).exp() * faded(first - second)
                };
                let inner = integrate(&azimuths, 1e-6, 400, |phi| {
                    let between = direction(cos, phi);
                    let value = turned(sigma, from, between) * turned(sigma, between, to);
                    Estimate { value: [value], error: 0.0 }
                });
                let scale = inside / (area(sigma, cos) * n_dot_v);
                Estimate { value: [scale * inner.value[0]], error: scale.abs() * inner.error }
            });
            let expected = once + twice.value[0];
            println!("{to:.3?}: {:.6}, adaptive {expected:.6}, of which once {once:.6}", lobe.value[i]);
            // Modes of the azimuth end at the twelfth.
            near(lobe.value[i], expected, 5e-4 * expected + twice.error, "a lobe of two orders");
        }
    }
}

#[test]
fn light_goes_back_the_way_it_came() {
    // f (n·l) over n·l, from ordinate to ordinate and back.
    for (alpha, bound) in [(0.15f64, 3e-3), (0.5, 2e-4), (0.9, 2e-4)] {
        let lobes = FibreLobes::new(alpha * alpha, None, DETAIL);
        let some = lobes.at(0.5);
        let cosines: Vec<f64> = some.light.iter().map(|l| l[2]).step_by(DETAIL.azimuths).collect();
        let (i, k) = (cosines.len() - 3, cosines.len() / 2);
        let [there, back] = [(i, k), (k, i)].map(|(from, to)| {
            let lobe = lobes.at(cosines[from]);
            let row = to * DETAIL.azimuths..(to + 1) * DETAIL.azimuths;
            lobe.value[row].iter().map(|f| f / cosines[to]).collect::<Vec<_>>()
        });
        let most = there.iter().copied().fold(0.0, f64::max);
        for (there, back) in there.iter().zip(back) {
            near(*there, back, bound * most, &format!("alpha {alpha}"));
        }
    }
}

// --- The tables -----------------------------------------------------------------------------------------------------------

/// Places of published texels with A, B and R.
fn published() -> Vec<(At, [f64; 3])> {
    let lines = include_str!("golden/ltc_sheen_volume.txt").lines().filter(|line| !line.starts_with('#'));
    let numbers = |line: &str| line.split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
    let list: Vec<_> =
        lines.map(numbers).map(|n| (At { n_dot_v: n[1], roughness: n[0].sqrt() }, [n[2], n[3], n[4]])).collect();
    assert_eq!(list.len(), 48);
    list
}

#[test]
fn published_albedos_are_met_within_their_noise() {
    // Zeltner et al. count two million walks a texel; five decimals are published.
    let table = table("ltc-sheen-volume").unwrap();
    let mut sigmas: Vec<f64> = published()
        .iter()
        .map(|(at, [.., albedo])| {
            let found = table.rule(&ggx(), *at)[2];
            let noise = (found * (1.0 - found) / 2e6).sqrt();
            let sigmas = ((found - albedo).abs() - 5e-6).max(0.0) / noise;
            assert!(sigmas <= 4.0, "{at:?}: {found}, published {albedo}, {sigmas:.1} sigma");
            sigmas
        })
        .collect();
    sigmas.sort_by(f64::total_cmp);
    println!("off by {:.2} sigma in the median, {:.2} at worst", sigmas[24], sigmas[47]);
    assert!(sigmas[24] < 1.0);
    // The measure can tell: one scattering less is another table, and so is a walk that goes on.
    for scatterings in [Some(15), None] {
        let seen = published().into_iter().filter(|(at, [.., albedo])| {
            let alpha = at.roughness * at.roughness;
            let found = FibreAlbedo::new(alpha * alpha, scatterings, DETAIL).at(at.n_dot_v);
            (found - albedo).abs() > 5e-6 + 4.0 * (found * (1.0 - found) / 2e6).sqrt()
        });
        let seen = seen.count();
        assert!(seen >= 8, "{scatterings:?}: {seen}");
    }
}

#[test]
fn fits_are_no_worse_than_the_published_ones() {
    let table = table("ltc-sheen-volume").unwrap();
    let mut better = 0;
    for (at, [a, b, _]) in published() {
        let rule = table.rule(&ggx(), at);
        let alpha = at.roughness * at.roughness;
        let nodes = FibreLobes::new(alpha * alpha, PUBLISHED, DETAIL).at(at.n_dot_v);
        let [ours, theirs] = [[rule[0], rule[1]], [a, b]].map(|entries| squared_error(&nodes, rule[2], entries));
        println!("{at:.3?}: {:.4}, published {:.4}", ours.sqrt(), theirs.sqrt());
        assert!(ours <= 1.005 * theirs, "{at:?}: {ours}, published {theirs}");
        better += usize::from(ours < 0.9 * theirs);
    }
    // The measure can tell.
    assert!(better >= 10, "{better}");
}

#[test]
fn rules_agree_with_their_truth() {
    for name in ["ltc-sheen-volume", "ltc-sheen-endless"] {
        let table = table(name).unwrap();
        for (alpha, n_dot_v) in [(0.05f64, 0.01), (0.1, 0.2), (0.3, 0.05), (1.0, 1.0)] {
            let at = At { n_dot_v, roughness: alpha.sqrt() };
            let (rule, truth) = (table.rule(&ggx(), at), table.truth(&ggx(), at, 1e-6));
            for (c, bound) in [(0, 1e-3), (1, 1e-3), (2, 5e-6)] {
                near(rule[c], truth.value[c], bound, &format!("{name} {at:?} {c}"));
            }
            assert_ne!(rule[2], truth.value[2]);
        }
    }
}

fn baked(name: &str, size: u32) -> (TableJob, Texture) {
    let job = TableRequest { size: (size, size), ..TableRequest::new(name) }.resolve().unwrap();
    let texture = job.run(&Backend::Cpu, &mut ignore).unwrap();
    (job, texture)
}

#[test]
fn faults_are_seen() {
    let (job, sound) = baked("ltc-sheen-volume", 4);
    let failures = |texture: &Texture| check(&job, texture, None, Extent::Spot, &mut ignore).unwrap().failures;
    assert_eq!(failures(&sound), [""; 0]);
    for (channel, step) in [(0, 0.03), (1, -0.03), (2, 3e-5)] {
        let mut texture = sound.clone();
        texture.levels[0][3 * (2 * 4 + 1) + channel] += step;
        assert!(!failures(&texture).is_empty(), "{channel}");
    }
    // Nor is a table of endless walks this one.
    assert!(!failures(&baked("ltc-sheen-endless", 4).1).is_empty());
}

#[test]
fn cycles_gets_its_planes() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    succeeds(&mut command(here, &["bake", "sheen_ltc", "--for", "blender", "--size", "5"]));
    let path = here.join("sheen_ltc.h");
    let (texture, encoding) = format::for_path(&path).unwrap().read(&path).unwrap();
    assert_eq!((texture.width, texture.height, encoding.name), (5, 5, "rgba32f"));
    assert_eq!(
        (&texture.channels[..], texture.meta.get("planes")),
        (&["a", "b", "reflectance"].map(String::from)[..], Some("a,b,reflectance"))
    );
    // The numbers of the file: all of A, row by row, then all of B.
    let code = std::fs::read_to_string(&path).unwrap();
    assert!(code.contains("3 planes of 5 x 5 values, one after the other"));
    let body = code.split_once("] = {").unwrap().1.split_once("};").unwrap().0;
    let numbers: Vec<f32> = body
        .split(',')
        .map(|n| n.trim().trim_end_matches('f'))
        .filter(|n| !n.is_empty())
        .map(|n| n.parse().unwrap())
        .collect();
    assert_eq!(numbers.len(), 75);
    for (i, number) in numbers.iter().enumerate() {
        assert_eq!(*number, texture.texel(0, 0, i as u32 % 5, i as u32 % 25 / 5)[i / 25], "{i}");
    }
    // As Cycles has them: rows over alpha, columns over n·v.
    let at = At { n_dot_v: 0.25, roughness: 0.75f64.sqrt() };
    let rule = table("ltc-sheen-volume").unwrap().rule(&ggx(), at);
    near(f64::from(numbers[50 + 3 * 5 + 1]), rule[2], 1e-6, "row 3, column 1");
    succeeds(&mut command(here, &["verify", "sheen_ltc.h"]));
    // A swapped plane is seen.
    let (first, rest) = body.split_at(body.find(',').unwrap());
    std::fs::write(here.join("bad.h"), code.replace(body, &format!("{}{rest}", first.replace("0.", "0.7")))).unwrap();
    fails(&mut command(here, &["verify", "bad.h"]), 1, &[]);
    // Another container has its texels in one piece, and says nothing of planes.
    succeeds(&mut command(here, &["bake", "sheen_ltc", "--for", "blender", "--size", "3", "-o", "s.exr"]));
    let (other, _) = format::for_path(Path::new("s.exr")).unwrap().read(&here.join("s.exr")).unwrap();
    assert_eq!(other.meta.get("planes"), None);
    fails(
        &mut command(here, &["bake", "ltc-sheen-volume", "-o", "a.exr", "--ndf", "charlie"]),
        2,
        &["lobe of its own", "ltc-sheen"],
    );
}
