// SPDX-License-Identifier: MIT OR Apache-2.0
//! Compares the table of linearly transformed cosines with the published one, texel by texel and by the same measure.
//!
//! `cargo run --release --example ltc_published -- ltc_1.npy ltc_2.npy`, where both are the 64 × 64 × 4 single floats of
//! <https://github.com/selfshadow/ltc_code> (`fit/results`), rows over √(1 − n·v), columns over roughness.

use std::path::Path;

use brdf_baker::Result;
use brdf_baker::bake::ltc::place;
use brdf_baker::bake::{Backend, TableRequest};
use brdf_baker::format;
use brdf_baker::progress::ignore;
use brdf_baker::rule::lobe_nodes::{Fineness, LobeNodes};
use brdf_baker::rule::ltc::Inverse;
use brdf_baker::texture::Texture;
use rayon::prelude::*;

/// Both tables are measured by nodes of which none was fitted over.
const FINE: Fineness = Fineness { polar: 15, azimuth: 20, panel: 0.9 };

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [matrix, magnitude] = &arguments[..] else { panic!("give the paths of ltc_1.npy and ltc_2.npy") };
    let read = |path: &String| format::for_path(Path::new(path))?.read(Path::new(path)).map(|(texture, _)| texture);
    let (matrix, magnitude) = (read(matrix)?, read(magnitude)?);

    let job = TableRequest::new("ltc").resolve()?;
    let ours = job.run(&Backend::Cpu, &mut ignore)?;
    let (width, height) = job.size();
    let inverse = |texture: &Texture, x: u32, y: u32| {
        let texel = texture.texel(0, 0, x, y);
        Inverse(std::array::from_fn(|i| f64::from(texel[i])))
    };
    let texels: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    let cubes: Vec<[f64; 2]> = texels
        .par_iter()
        .map(|(x, y)| {
            // Heitz et al. stop both axes just before their ends, as the table does.
            let at = place(&job.model, job.at(*x, *y));
            let nodes = LobeNodes::of_model(&job.model, at, FINE).expect("a lobe");
            [&ours, &matrix].map(|texture| inverse(texture, *x, *y).cubed_error(&nodes))
        })
        .collect();
    for (i, name) in ["ours", "published"].iter().enumerate() {
        let mut errors: Vec<f64> = cubes.iter().map(|c| c[i].cbrt()).collect();
        errors.sort_by(f64::total_cmp);
        println!("{name}: fit error {:.4} worst, {:.4} median", errors[errors.len() - 1], errors[errors.len() / 2]);
    }
    // Errors below 1e-4 are those of rounding.
    let ratio = |i: usize| cubes[i][0] / cubes[i][1].max(1e-12);
    let worst = (0..texels.len()).max_by(|a, b| ratio(*a).total_cmp(&ratio(*b))).expect("texels");
    println!("largest ratio of the cubed errors {:.4} at texel {:?}", ratio(worst), texels[worst]);
    println!("texels that are worse by more than 5 %: {}", (0..texels.len()).filter(|i| ratio(*i) > 1.05).count());

    let job = TableRequest::new("ltc-magnitude").resolve()?;
    for (c, channel) in job.channel_facts().enumerate().filter(|(_, channel)| channel.name != "unused") {
        let off = |(x, y): &(u32, u32)| {
            let published = f64::from(magnitude.texel(0, 0, *x, *y)[c]);
            ((published - job.rule(job.at(*x, *y))[c]).abs(), [*x, *y])
        };
        let (worst, at) = texels.iter().map(off).max_by(|a, b| a.0.total_cmp(&b.0)).expect("texels");
        println!("published {} is off by up to {worst:.1e}, at texel {at:?}", channel.name);
    }
    Ok(())
}
