// SPDX-License-Identifier: MIT OR Apache-2.0
//! Compares the sheen of a random walk through fibres with the published table, texel by texel and by the same measure.
//!
//! `cargo run --release --example sheen_published -- ltc_table_sheen_volume.npy`, which is the 32 × 32 × 3 numbers of
//! <https://github.com/tizian/ltc-sheen> (`fitting/python/data`), rows over alpha, columns over n·v, A, B and R.

use std::path::Path;

use brdf_baker::Result;
use brdf_baker::bake::{At, Backend, TableRequest};
use brdf_baker::format;
use brdf_baker::progress::ignore;
use brdf_baker::rule::fibre_walk::{Detail, FibreLobes, PUBLISHED};
use brdf_baker::rule::ltc_sheen::squared_error;
use rayon::prelude::*;

/// Both tables are measured by nodes of which none was fitted over.
const DETAIL: Detail = Detail { even: 0.09, finest: 0.045, cosines: 9, panel: 1.1, depths: 26, azimuths: 18 };
/// Where fewer of their walks come back, Zeltner et al. do not fit: their A is 0 there.
const LEAST_FITTED: f64 = 3e-6;
/// Walks of a published albedo, and half a step of its last digit.
const WALKS: f64 = 2e6;
const HALF_DIGIT: f64 = 5e-6;

/// A texel: how many standard errors the published albedo is off, by how much, and both fit errors.
struct Compared {
    sigmas: f64,
    off: f64,
    errors: [f64; 2],
}

fn main() -> Result<()> {
    let path = std::env::args().nth(1).expect("give the path of ltc_table_sheen_volume.npy");
    let (published, _) = format::for_path(Path::new(&path))?.read(Path::new(&path))?;
    let job = TableRequest::new("ltc-sheen-volume").resolve()?;
    let ours = job.run(&Backend::Cpu, &mut ignore)?;
    let (width, height) = job.size();
    let compare = |lobes: &FibreLobes, x: u32, y: u32| {
        let At { n_dot_v, .. } = job.at(x, y);
        let [ours, theirs] = [&ours, &published].map(|t| [0, 1, 2].map(|c| f64::from(t.texel(0, 0, x, y)[c])));
        let albedo = ours[2];
        let nodes = lobes.at(n_dot_v.max(0.01));
        let off = (theirs[2] - albedo).abs();
        let sigmas = (off - HALF_DIGIT).max(0.0) / (albedo * (1.0 - albedo) / WALKS).sqrt();
        let errors = [ours, theirs].map(|[a, b, _]| squared_error(&nodes, albedo, [a, b]).sqrt());
        (albedo >= LEAST_FITTED && theirs[0] > 0.0).then_some(Compared { sigmas, off, errors })
    };
    let row = |y: u32| -> Vec<Compared> {
        let alpha = job.at(0, y).roughness.powi(2).max(0.01);
        let lobes = FibreLobes::new(alpha * alpha, PUBLISHED, DETAIL);
        (0..width).filter_map(|x| compare(&lobes, x, y)).collect()
    };
    let texels: Vec<Compared> = (0..height).into_par_iter().flat_map_iter(row).collect();
    let state = |what: &str, value: &dyn Fn(&Compared) -> f64| {
        let mut values: Vec<f64> = texels.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        println!("{what}: {:.2e} in the median, {:.2e} at worst", values[values.len() / 2], values[values.len() - 1]);
    };
    println!("{} of {} texels are fitted in both", texels.len(), width * height);
    state("published albedo off by", &|t| t.off);
    state("the same in its own standard errors", &|t| t.sigmas);
    state("fit error, ours", &|t| t.errors[0]);
    state("fit error, published", &|t| t.errors[1]);
    state("ours over published", &|t| t.errors[0] / t.errors[1]);
    let worse = texels.iter().filter(|t| t.errors[0].powi(2) > 1.05 * t.errors[1].powi(2)).count();
    println!("texels that are worse by more than 5 %: {worse}");
    Ok(())
}
