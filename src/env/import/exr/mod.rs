// SPDX-License-Identifier: MIT OR Apache-2.0
//! OpenEXR: half and single floats, scan lines and tiles, any part or layer.
//!
//! Blocks are taken as they are decompressed and go straight to their place in the display window, so that the picture
//! is held once.

mod zip;

use std::io::BufReader;
use std::sync::{Mutex, PoisonError};

use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::block::reader::ChunksReader;
use exr::meta::header::Header;
use exr::prelude as ex;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use super::watched::Watched;
use super::{Job, Plane};
use crate::error::{Error, Result};
use crate::format::DEFLATE_RATIO;

const CONVERT: &str = "export the picture as plain RGB, e.g. `oiiotool in.exr --ch R,G,B -o out.exr`";

/// The channels to read: of which part, and which three; grey has one thrice.
struct Choice {
    part: usize,
    channels: [usize; 3],
}

pub fn read(job: &mut Job<'_>, file: Watched<'_, '_>) -> Result<Plane> {
    job.refuse_color()?;
    let state = file.state();
    let refuse = |job: &Job<'_>, compression: Option<ex::Compression>, e: ex::Error| {
        let name = compression.map_or("unknown", compression_name);
        match e {
            ex::Error::NotSupported(why) => Error::input(
                job.path,
                format!("as OpenEXR it cannot be decoded here, compression {name}: {why}"),
                "convert it with `oiiotool in.exr --compression zip -o out.exr`",
            ),
            ex::Error::Io(e) => state.explain(job.path, e),
            e => Error::input(
                job.path,
                format!("as OpenEXR with {name} compression it is damaged or cut short: {e}"),
                "fetch or export it again; `oiiotool in.exr --compression zip -o out.exr` rewrites a file that other \
                 programs can read",
            ),
        }
    };

    let length = file.length();
    // Headers first: everything that can be refused is refused before texels are touched.
    let file = BufReader::with_capacity(1 << 18, file);
    let reader = exr::block::read(file, false).map_err(|e| refuse(job, None, e))?;
    let choice = choose(job, reader.headers())?;
    let header = reader.headers()[choice.part].clone();
    let display = header.shared_attributes.display_window;
    let (width, height) = (display.size.0, display.size.1);
    let limited = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
    (job.accept)(limited(width), limited(height))?;
    let data = header.data_window();
    if data.size.0 > 2 * (width + height) || data.size.1 > 2 * (width + height) {
        let what = format!("its data window is {}x{}, much larger than its display window", data.size.0, data.size.1);
        return Err(Error::input(job.path, what, "crop it, e.g. `oiiotool in.exr --fullpixels -o out.exr`"));
    }
    let [from, to] = [display.position, data.position].map(|p| [i64::from(p.0), i64::from(p.1)]);
    let offset = [to[0] - from[0], to[1] - from[1]];
    if offset != [0, 0] || data.size != display.size {
        let at = |b: exr::meta::attribute::IntegerBounds| {
            format!("{}x{} at {},{}", b.size.0, b.size.1, b.position.0, b.position.1)
        };
        job.notes.push(format!(
            "'{}' has the data window {} in the display window {}; what is missing counts as black",
            job.path.display(),
            at(data),
            at(display)
        ));
    }

    let texel_bytes = header.channels.bytes_per_pixel as u64;
    job.plausible(texel_bytes.saturating_mul(data.size.area() as u64), length, best_ratio(header.compression))?;
    // The rest of the display window is black and in no file, but takes memory.
    job.plausible((width * height) as u64, length, DEFLATE_RATIO)?;
    let mut texels = vec![[0f32; 3]; width * height];
    // Blocks are decompressed and stored side by side; tiles share rows.
    let rows: Vec<_> = texels.chunks_exact_mut(width).map(Mutex::new).collect();
    let store = |block: UncompressedBlock| {
        // Of a line, as they lie in the file and as floats.
        let (mut halves, mut values): (Vec<f16>, Vec<f32>) = (vec![], vec![]);
        for line in block.lines(&header.channels) {
            let row = line.location.position.1 as i64 + offset[1];
            if row < 0 || row >= height as i64 || !choice.channels.contains(&line.location.channel) {
                continue;
            }
            let first = line.location.position.0 as i64 + offset[0];
            let mut row = rows[row as usize].lock().unwrap_or_else(PoisonError::into_inner);
            let channels = choice.channels.map(|c| c == line.location.channel);
            let bytes = line.value;
            match header.channels.list[line.location.channel].sample_type {
                ex::SampleType::F16 => {
                    halves.clear();
                    halves.extend(bytes.as_chunks().0.iter().map(|b| f16::from_ne_bytes(*b)));
                    values.resize(halves.len(), 0.0);
                    halves.convert_to_f32_slice(&mut values);
                    put(&mut row, channels, first, values.iter().copied());
                }
                ex::SampleType::F32 => {
                    put(&mut row, channels, first, bytes.as_chunks().0.iter().map(|b| f32::from_ne_bytes(*b)));
                }
                ex::SampleType::U32 => {
                    put(&mut row, channels, first, bytes.as_chunks().0.iter().map(|b| u32::from_ne_bytes(*b) as f32));
                }
            }
        }
    };
    let compression = Some(header.compression);
    let wanted = |_: &exr::meta::MetaData, _, block: exr::block::BlockIndex| {
        block.layer == choice.part && block.level == ex::Vec2(0, 0)
    };
    let mut chunks = reader.filter_chunks(false, wanted).map_err(|e| refuse(job, compression, e))?;
    let meta = chunks.meta_data().clone();
    let mut filled = 0;
    // A few for every thread at a time: a cancel is seen between them, and memory is bounded.
    loop {
        let batch: Vec<_> = chunks.by_ref().take(4 * rayon::current_num_threads()).collect();
        if batch.is_empty() {
            break;
        }
        let decompressed = |chunk: ex::Result<Chunk>| {
            let block = UncompressedBlock::decompress_chunk(zip::unpacked(chunk?, &header)?, &meta, false)?;
            let area = block.index.pixel_size.area();
            store(block);
            Ok(area)
        };
        let areas: ex::Result<Vec<usize>> = batch.into_par_iter().map(decompressed).collect();
        filled += areas.map_err(|e| refuse(job, compression, e))?.iter().sum::<usize>();
    }
    if filled != data.size.area() {
        return Err(job.damaged("OpenEXR", "blocks are missing"));
    }
    Ok(Plane { width: width as u32, height: height as u32, texels })
}

/// Puts values into those of a texel's three channels that are true, in a row of the display window, the first value at
/// column `first`. What lies outside is left out.
fn put(row: &mut [[f32; 3]], channels: [bool; 3], first: i64, values: impl Iterator<Item = f32> + Clone) {
    let before = usize::try_from(-first).unwrap_or(0);
    let row = row.get_mut(usize::try_from(first).unwrap_or(0)..).unwrap_or(&mut []);
    for channel in (0..3).filter(|c| channels[*c]) {
        row.iter_mut().zip(values.clone().skip(before)).for_each(|(texel, value)| texel[channel] = value);
    }
}

/// Finds the colour channels.
fn choose(job: &mut Job<'_>, headers: &[Header]) -> Result<Choice> {
    let names = |h: &Header| h.channels.list.iter().map(|c| c.name.to_string()).collect::<Vec<_>>();
    let part_name = |h: &Header| h.own_attributes.layer_name.as_ref().map(ToString::to_string);
    let everything = || {
        let part = |h: &Header| {
            let name = part_name(h).map_or(String::new(), |n| format!("part '{n}': "));
            format!("{name}{}{}", names(h).join(", "), if h.deep { " (deep)" } else { "" })
        };
        headers.iter().map(part).collect::<Vec<_>>().join("; ")
    };
    // Channels that start with a prefix and end in R, G and B, or in Y.
    let colour = |h: &Header, prefix: &str| {
        let list = names(h);
        let index = |suffix: &str| list.iter().position(|name| *name == format!("{prefix}{suffix}"));
        let rgb = [index("R"), index("G"), index("B")];
        match (rgb, index("Y")) {
            ([Some(r), Some(g), Some(b)], _) => Some([r, g, b]),
            (_, Some(y)) => Some([y; 3]),
            _ => None,
        }
    };
    let prefixes = |h: &Header| {
        let mut found: Vec<String> =
            names(h).iter().filter_map(|n| Some(n.rsplit_once('.')?.0.to_string() + ".")).collect();
        found.dedup();
        found.retain(|prefix| colour(h, prefix).is_some());
        found
    };
    let flat = || headers.iter().enumerate().filter(|(_, h)| !h.deep);
    let found = match &job.options.part {
        Some(wanted) => {
            let of_part = flat().filter(|(_, h)| part_name(h).as_ref() == Some(wanted)).find_map(|(part, h)| {
                let prefix = || prefixes(h).into_iter().find_map(|p| colour(h, &p));
                Some(Choice { part, channels: colour(h, "").or_else(prefix)? })
            });
            let of_layer =
                || flat().find_map(|(part, h)| Some(Choice { part, channels: colour(h, &format!("{wanted}."))? }));
            of_part.or_else(of_layer).ok_or_else(|| {
                let what = format!("it has no part or layer '{wanted}' with channels R, G and B, or Y");
                Error::input(job.path, what, format!("it holds {}", everything()))
            })?
        }
        None => match flat().find_map(|(part, h)| Some(Choice { part, channels: colour(h, "")? })) {
            Some(choice) => choice,
            None => {
                let layers: Vec<(usize, String)> =
                    flat().flat_map(|(part, h)| prefixes(h).into_iter().map(move |p| (part, p))).collect();
                match layers.as_slice() {
                    [(part, prefix)] => {
                        job.notes.push(format!(
                            "'{}' has no plain channels; its layer '{}' is read",
                            job.path.display(),
                            prefix.trim_end_matches('.')
                        ));
                        Choice { part: *part, channels: colour(&headers[*part], prefix).expect("found just now") }
                    }
                    [] => {
                        let what = format!("it has no flat channels R, G and B, or Y; it holds {}", everything());
                        return Err(Error::input(job.path, what, CONVERT));
                    }
                    several => {
                        let list: Vec<&str> = several.iter().map(|(_, p)| p.trim_end_matches('.')).collect();
                        let what = format!("it has several layers: {}", list.join(", "));
                        return Err(Error::input(job.path, what, format!("choose one, e.g. --part {}", list[0])));
                    }
                }
            }
        },
    };
    let header = &headers[found.part];
    let chosen = found.channels.map(|c| &header.channels.list[c]);
    if found.channels[0] == found.channels[1] {
        let prefix = chosen[0].name.to_string();
        let prefix = prefix.trim_end_matches('Y');
        if names(header).iter().any(|n| *n == format!("{prefix}RY") || *n == format!("{prefix}BY")) {
            return Err(Error::input(job.path, "its colour is stored as luminance and chroma", CONVERT));
        }
    }
    if chosen.iter().any(|c| c.sampling != ex::Vec2(1, 1)) {
        return Err(Error::input(job.path, "its channels are not sampled at every texel", CONVERT));
    }
    Ok(found)
}

/// What a scheme makes of a byte at best.
fn best_ratio(compression: ex::Compression) -> u64 {
    use ex::Compression as C;
    match compression {
        C::Uncompressed => 1,
        // Two bytes stand for a block of 64 texels of one colour, before deflate.
        C::DWAA(_) | C::DWAB(_) => 64 * DEFLATE_RATIO,
        // Three bytes of four, and then deflate.
        C::PXR24 => 2 * DEFLATE_RATIO,
        // The others stay below deflate's.
        _ => DEFLATE_RATIO,
    }
}

fn compression_name(compression: ex::Compression) -> &'static str {
    use ex::Compression as C;
    match compression {
        C::Uncompressed => "NONE",
        C::RLE => "RLE",
        C::ZIP1 => "ZIPS",
        C::ZIP16 => "ZIP",
        C::PIZ => "PIZ",
        C::PXR24 => "PXR24",
        C::B44 => "B44",
        C::B44A => "B44A",
        C::DWAA(_) => "DWAA",
        C::DWAB(_) => "DWAB",
        _ => "unknown",
    }
}
