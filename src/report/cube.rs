// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a page draws of a filtered environment.

use serde_json::{Value, json};

use super::{floats, pairs};
use crate::bake::specular::SpecularJob;
use crate::env::Environment;
use crate::env::projection::Projection;
use crate::error::Result;
use crate::progress::{OnProgress, tick};
use crate::texture::Texture;
use crate::verify::cube::CubeReport;
use crate::verify::{cube, environment};

/// Texels along the height of a face that a page shows of a level.
const SHOWN: u32 = 64;
/// The same that it compares of a mip: with the source, or with mip 0, which costs some ten times as much.
const COMPARED: u32 = 8;
const COMPARED_ALONE: u32 = 4;

/// Every level, shrunk, and for each mip that `report` compared a coarse grid of texels beside the brute-force integral.
pub fn picture(
    job: &SpecularJob,
    texture: &Texture,
    source: Option<&Environment<'_>>,
    report: &CubeReport,
    on: &mut OnProgress<'_>,
) -> Result<Value> {
    let levels: Vec<_> = (0..job.mips)
        .map(|mip| {
            let (size, shown) = (job.level_size(mip), grid(job, mip, SHOWN));
            json!({
                "mip": mip,
                "alpha": job.alpha(mip),
                "filtered": job.filtered().contains(&mip),
                "size": size,
                "shown": shown,
                "texels": floats(shrunk(texture, job.projection, mip, shown)),
            })
        })
        .collect();
    let most = if source.is_some() { COMPARED } else { COMPARED_ALONE };
    let mut compared = vec![];
    for (i, mip) in report.mips.iter().map(|m| m.mip as u32).enumerate() {
        tick(on, "report: brute force", i as f64 / report.mips.len() as f64)?;
        let ((width, height), [columns, rows]) = (job.level_size(mip), grid(job, mip, most));
        let at = |i: u32, n: u32, size: u32| ((f64::from(i) + 0.5) * f64::from(size) / f64::from(n)) as u32;
        let texels: Vec<[u32; 3]> = (0..job.projection.faces() * rows * columns)
            .map(|i| [i / (rows * columns), at(i % columns, columns, width), at(i / columns % rows, rows, height)])
            .collect();
        let expected = match source {
            Some(source) => environment::expected(job, source, mip, &texels),
            None => cube::expected(job, texture, mip, &texels),
        };
        let found = texels.iter().flat_map(|[face, x, y]| texture.texel(mip as usize, *face, *x, *y)[..3].to_vec());
        compared.push(json!({
            "mip": mip,
            "grid": [columns, rows],
            "found": floats(found),
            "expected": floats(expected.into_iter().flatten().map(|v| v as f32)),
        }));
    }
    tick(on, "report: brute force", 1.0)?;
    Ok(json!({
        "kind": "environment",
        "projection": job.projection.name(),
        "kernel": job.kernel.name,
        "roughness_law": job.law.name(),
        "faces": job.projection.faces(),
        "levels": levels,
        "compared": compared,
        "meta": pairs(&texture.meta),
    }))
}

/// Columns and rows of at most `most` rows a face.
fn grid(job: &SpecularJob, mip: u32, most: u32) -> [u32; 2] {
    let (width, height) = job.level_size(mip);
    // One face in place of six has room for more.
    let most = if job.projection == Projection::Cube { most } else { 2 * most };
    let rows = height.min(most);
    [(width * rows).div_ceil(height), rows]
}

/// RGB of a level, averaged over blocks of texels.
fn shrunk(texture: &Texture, projection: Projection, mip: u32, [columns, rows]: [u32; 2]) -> Vec<f32> {
    let (width, height) = texture.level_size(mip as usize);
    let block = |i: u32, n: u32, size: u32| i * size / n..((i + 1) * size / n).max(i * size / n + 1);
    let mut out = Vec::with_capacity((projection.faces() * rows * columns * 3) as usize);
    for face in 0..projection.faces() {
        for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
            let (mut sum, mut count) = ([0.0f64; 3], 0.0);
            for (y, x) in block(y, rows, height).flat_map(|y| block(x, columns, width).map(move |x| (y, x))) {
                let texel = texture.texel(mip as usize, face, x, y);
                (0..3).for_each(|c| sum[c] += f64::from(texel[c]));
                count += 1.0;
            }
            out.extend(sum.map(|s| (s / count) as f32));
        }
    }
    out
}
