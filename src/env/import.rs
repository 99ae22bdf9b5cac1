//! Reading environments: equirectangular Radiance HDR (`.hdr`, `.pic`) and OpenEXR (`.exr`).
//!
//! The content decides, not the extension: the first bytes tell the two formats apart. Sizes are checked before
//! anything of that size is allocated.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use exr::prelude as ex;
use rayon::prelude::*;

use super::{Clamped, Equirect};
use crate::error::{Error, Result};

/// The largest picture that is read, in texels: 16384 × 8192.
pub const MAX_SIZE: (u32, u32) = (16384, 8192);

/// Reads an equirectangular environment.
///
/// A file that is missing or unreadable is [`Error::Io`]; anything wrong with its content is [`Error::Input`]: neither
/// format, cut short, not 2:1, too large, without colour, or with texels that are not finite. Negative texels become 0
/// and are counted in [`Equirect::clamped`].
pub fn equirect(path: &Path) -> Result<Equirect> {
    let mut file = File::open(path).map_err(|e| Error::io("read", path, e))?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(Error::io("read", path, std::io::ErrorKind::IsADirectory.into()));
    }
    let mut magic = Vec::with_capacity(4);
    file.by_ref().take(4).read_to_end(&mut magic).map_err(|e| Error::io("read", path, e))?;
    drop(file);
    let (width, height, texels) = match magic.as_slice() {
        [0x76, 0x2f, 0x31, 0x01] => read_exr(path)?,
        [b'#', b'?', ..] => read_hdr(path)?,
        _ => {
            let what = if magic.is_empty() { "it is empty" } else { "it is neither OpenEXR nor Radiance HDR" };
            return Err(Error::input(path, what, "give an equirectangular .exr or .hdr picture"));
        }
    };
    checked(path, width, height, texels)
}

/// Refuses sizes that are not an equirectangular picture's, before memory is spent on them.
fn check_size(path: &Path, width: u32, height: u32) -> Result<()> {
    if width == 0 || height == 0 || width > MAX_SIZE.0 || height > MAX_SIZE.1 {
        let what = format!("it is {width}x{height}, and at most {}x{} is read", MAX_SIZE.0, MAX_SIZE.1);
        return Err(Error::input(
            path,
            what,
            "scale it down first, e.g. `oiiotool in.exr --resize 4096x2048 -o out.exr`",
        ));
    }
    if width != 2 * height {
        let what = format!("it is {width}x{height}, and an equirectangular picture is twice as wide as high");
        return Err(Error::input(path, what, "give a full 360° x 180° panorama"));
    }
    Ok(())
}

/// Refuses texels that are not finite, and sets negative ones to 0.
fn checked(path: &Path, width: u32, height: u32, mut texels: Vec<[f32; 3]>) -> Result<Equirect> {
    debug_assert_eq!(texels.len(), width as usize * height as usize);
    let (bad, negative, lowest) = texels
        .par_chunks_mut(1 << 16)
        .map(|chunk| {
            let (mut bad, mut negative, mut lowest) = (0usize, 0usize, 0f32);
            for texel in chunk {
                bad += usize::from(!texel.iter().all(|v| v.is_finite()));
                let least = texel[0].min(texel[1]).min(texel[2]);
                negative += usize::from(least < 0.0);
                lowest = lowest.min(least);
                *texel = texel.map(|v| if v < 0.0 { 0.0 } else { v });
            }
            (bad, negative, lowest)
        })
        .reduce(|| (0, 0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2.min(b.2)));
    if bad > 0 {
        let first = texels.iter().position(|t| !t.iter().all(|v| v.is_finite())).expect("one was counted");
        let (x, y) = (first % width as usize, first / width as usize);
        let what = format!("{bad} of its texels are infinite or not a number, the first at column {x}, row {y}");
        return Err(Error::input(path, what, "paint them over, e.g. `oiiotool in.exr --fixnan box3 -o out.exr`"));
    }
    let clamped = (negative > 0).then_some(Clamped { count: negative, lowest });
    Ok(Equirect { width, height, texels, clamped })
}

fn read_hdr(path: &Path) -> Result<(u32, u32, Vec<[f32; 3]>)> {
    use image::ImageDecoder;
    let refuse = |e: image::ImageError| match e {
        image::ImageError::IoError(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => Error::io("read", path, e),
        image::ImageError::IoError(_) => Error::input(path, "it is cut short", "fetch or export it again"),
        e => Error::input(path, format!("as Radiance HDR it is damaged: {e}"), "fetch or export it again"),
    };
    let file = File::open(path).map_err(|e| Error::io("read", path, e))?;
    let decoder = image::codecs::hdr::HdrDecoder::new(BufReader::with_capacity(1 << 16, file)).map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    check_size(path, width, height)?;
    let mut texels = vec![[0f32; 3]; width as usize * height as usize];
    decoder.read_image(bytemuck::cast_slice_mut(&mut texels)).map_err(refuse)?;
    Ok((width, height, texels))
}

fn read_exr(path: &Path) -> Result<(u32, u32, Vec<[f32; 3]>)> {
    // Read the headers alone, so that size, channels and compression are known before the texels are touched.
    let damaged = |e: ex::Error| match e {
        ex::Error::Io(e) => Error::io("read", path, e),
        e => Error::input(path, format!("as OpenEXR it is damaged or cut short: {e}"), "fetch or export it again"),
    };
    let meta = exr::meta::MetaData::read_from_file(path, false).map_err(damaged)?;
    let names = |h: &exr::meta::header::Header| h.channels.list.iter().map(|c| c.name.to_string()).collect::<Vec<_>>();
    let has = |h: &exr::meta::header::Header, wanted: &[&str]| wanted.iter().all(|w| names(h).iter().any(|n| n == w));
    let Some(header) = meta.headers.iter().find(|h| !h.deep && (has(h, &["R", "G", "B"]) || has(h, &["Y"]))) else {
        let found: Vec<String> = meta.headers.iter().flat_map(names).collect();
        let what =
            format!("it has no layer with flat channels R, G and B, or Y; its channels are: {}", found.join(", "));
        return Err(Error::input(
            path,
            what,
            "export the picture as plain RGB, e.g. `oiiotool in.exr --ch R,G,B -o out.exr`",
        ));
    };
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    check_size(path, u32::try_from(width).unwrap_or(u32::MAX), u32::try_from(height).unwrap_or(u32::MAX))?;

    // Read the texels. A compression that this reader lacks is named as the format's own tools name it.
    let compression = compression_name(header.compression);
    let refuse = |e: ex::Error| match e {
        ex::Error::NotSupported(why) => Error::input(
            path,
            format!("its compression {compression} cannot be decoded here ({why})"),
            "convert it with `oiiotool in.exr --compression zip -o out.exr`",
        ),
        ex::Error::Io(e) => Error::io("read", path, e),
        e => Error::input(
            path,
            format!("as OpenEXR with {compression} compression it is damaged or cut short: {e}"),
            "fetch or export it again; `oiiotool in.exr --compression zip -o out.exr` rewrites a file that other programs can read",
        ),
    };
    use ex::{ReadChannels, ReadLayers, ReadSpecificChannel};
    let reader = ex::read().no_deep_data().largest_resolution_level();
    let texels = if has(header, &["R", "G", "B"]) {
        let store = |(stride, texels): &mut (usize, Vec<[f32; 3]>), at: ex::Vec2<usize>, (r, g, b): (f32, f32, f32)| {
            texels[at.1 * *stride + at.0] = [r, g, b];
        };
        let channels = reader.specific_channels().required("R").required("G").required("B");
        let image = channels.collect_pixels(blank, store).first_valid_layer().all_attributes().from_file(path);
        image.map_err(refuse)?.layer_data.channel_data.pixels.1
    } else {
        let store = |(stride, texels): &mut (usize, Vec<[f32; 3]>), at: ex::Vec2<usize>, (y,): (f32,)| {
            texels[at.1 * *stride + at.0] = [y; 3];
        };
        let channels = reader.specific_channels().required("Y");
        let image = channels.collect_pixels(blank, store).first_valid_layer().all_attributes().from_file(path);
        image.map_err(refuse)?.layer_data.channel_data.pixels.1
    };
    if texels.len() != width * height {
        return Err(Error::input(path, "its layers differ in size", "export the picture as a single layer"));
    }
    Ok((width as u32, height as u32, texels))
}

/// The width, and black texels in rows from the top.
fn blank<Channels>(size: ex::Vec2<usize>, _: &Channels) -> (usize, Vec<[f32; 3]>) {
    (size.0, vec![[0.0; 3]; size.0 * size.1])
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
        _ => "(unknown)",
    }
}
