// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a page draws of a table.

use half::f16;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{floats, halves, pairs, spread};
use crate::bake::{Channel, TableJob};
use crate::error::Result;
use crate::format::{Repr, Steps};
use crate::progress::{OnProgress, tick};
use crate::texture::Texture;
use crate::verify::table::expected;

/// Lines across the table that are compared with the truth, and points on each.
const SLICES: u32 = 5;
const POINTS: u32 = 33;
/// Bytes of texels and their errors that a page holds: twelve a texel of two channels of 256 × 256 fit well.
const BUDGET_BYTES: u64 = 1_300_000;

/// Texels, their errors against the twin in units of the last place, and slices of the truth. Large tables are thinned:
/// every k-th texel of every k-th row.
pub fn picture(job: &TableJob, texture: &Texture, steps: &Steps, on: &mut OnProgress<'_>) -> Result<Value> {
    let (width, height) = job.size();
    let channels = texture.channels.len();
    let texel_bytes = (channels * (size_of::<f32>() + size_of::<f16>())) as u64;
    let shown = |step: u32| u64::from(width.div_ceil(step)) * u64::from(height.div_ceil(step)) * texel_bytes;
    let step = (1..).find(|step| shown(*step) <= BUDGET_BYTES).expect("one texel fits");
    let columns: Vec<u32> = (0..width).step_by(step as usize).collect();
    let rows: Vec<u32> = (0..height).step_by(step as usize).collect();

    // Texels, each beside the same rule in f64.
    let texel = |x: u32, y: u32| texture.texel(0, 0, x, y);
    let ulps = |x: u32, y: u32, expected: &[f64]| -> Vec<f32> {
        let largest = expected.iter().copied().fold(0.0, f64::max);
        let of = |(found, e): (&f32, &f64)| ((f64::from(*found) - e) / ulp(steps, *e, largest)) as f32;
        texel(x, y).iter().zip(expected).map(of).collect()
    };
    let mut errors = Vec::with_capacity(rows.len() * columns.len() * channels);
    for (i, band) in rows.chunks(16).enumerate() {
        tick(on, "report: every texel", (16 * i) as f64 / rows.len() as f64)?;
        let texels: Vec<_> = band.iter().flat_map(|y| columns.iter().map(move |x| [*x, *y])).collect();
        let found: Vec<Vec<f32>> = texels.par_iter().map(|[x, y]| ulps(*x, *y, &job.rule(job.at(*x, *y)))).collect();
        errors.extend(found.iter().flatten().copied());
    }
    let values = rows.iter().flat_map(|y| columns.iter().flat_map(|x| texel(*x, *y).iter().copied()));

    // Lines of the truth along either axis.
    let mut slices = vec![];
    for (along, across) in [(0, 1), (1, 0)] {
        let sizes = [width, height];
        if sizes[along] == 1 {
            continue;
        }
        let (lines, places) = (spread(sizes[across], SLICES), spread(sizes[along], POINTS));
        for (i, line) in lines.iter().enumerate() {
            tick(on, "report: truth", i as f64 / lines.len() as f64)?;
            let points: Vec<_> = places
                .par_iter()
                .map(|place| {
                    let [x, y] = if along == 0 { [*place, *line] } else { [*line, *place] };
                    let (truth, _) = expected(job, job.at(x, y));
                    let error = ulps(x, y, &truth);
                    (truth, error)
                })
                .collect();
            slices.push(json!({
                "along": along,
                "at": line,
                "places": places,
                "found": places.iter().map(|p| {
                    let [x, y] = if along == 0 { [*p, *line] } else { [*line, *p] };
                    texel(x, y)
                }).collect::<Vec<_>>(),
                "truth": points.iter().map(|(truth, _)| truth).collect::<Vec<_>>(),
                "ulps": points.iter().map(|(_, error)| error).collect::<Vec<_>>(),
            }));
        }
    }
    tick(on, "report: truth", 1.0)?;

    let axes: Vec<_> = job
        .axes
        .iter()
        .map(|axis| {
            json!({
                "coordinate": axis.warp.coordinate().name(),
                "position": axis.warp.formula(),
                "points": axis.points.name(),
                "reversed": axis.reversed,
                "coordinates": axis.coordinates(),
            })
        })
        .collect();
    let fact = |(i, c): (usize, &Channel)| json!({ "name": c.name, "meaning": c.meaning, "range": job.range(i) });
    let facts: Vec<_> = job.channel_facts().enumerate().map(fact).collect();
    Ok(json!({
        "kind": "table",
        "width": width,
        "height": height,
        "step": step,
        "shown": [columns.len(), rows.len()],
        "channels": facts,
        "axes": axes,
        "values": floats(values),
        "ulps": halves(errors),
        "ulp": ulp_text(steps.encoding.repr),
        "single": steps.encoding.repr == Repr::F32,
        "slices": slices,
        "meta": pairs(&texture.meta),
    }))
}

/// The distance between neighbouring stored values. Single floats are far finer than any bound near 0: theirs is that at
/// 1, and in proportion beyond.
fn ulp(steps: &Steps, value: f64, largest: f64) -> f64 {
    let value = if steps.encoding.repr == Repr::F32 { value.abs().max(1.0) } else { value };
    2.0 * steps.half_ulp_at(value, largest)
}

/// The same in words.
fn ulp_text(repr: Repr) -> &'static str {
    match repr {
        Repr::F16 => "1 ulp is the distance between neighbouring half floats at the value",
        Repr::F32 => "1 ulp is the distance between neighbouring single floats at 1.0, 1.2e-7",
        Repr::Unorm8 => "1 ulp is 1/255",
        Repr::Unorm16 => "1 ulp is 1/65535",
        Repr::Unorm10 => "1 ulp is 1/1023",
        Repr::Rgbe8 | Repr::Rgb9e5 => "1 ulp is the step of the texel's shared exponent",
        Repr::B10g11r11 => "1 ulp is the distance between neighbouring floats of 10 bits at the value",
        Repr::Rgbd8 | Repr::Rgbm8 | Repr::Rgbp8 => "1 ulp is the distance between neighbouring bytes at the value",
        Repr::Bc4 | Repr::Bc5 | Repr::Bc6h => "1 ulp is twice the largest error that the file states of its blocks",
    }
}
