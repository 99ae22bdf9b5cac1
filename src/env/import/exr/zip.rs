// SPDX-License-Identifier: MIT OR Apache-2.0
//! ZIP and ZIPS of OpenEXR, faster than by the reader of the other compressions: most photographs come in them, and unpacking
//! is most of what reading one takes.

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::meta::header::Header;
use exr::prelude as ex;
use libdeflater::Decompressor;

/// A block with its bytes unpacked, as if it had been stored so. Blocks of other compressions stay as they are.
///
/// The format: <https://openexr.com/en/latest/OpenEXRFileLayout.html>, and for what zlib holds `internal_zip.c` of OpenEXR.
pub fn unpacked(mut block: Chunk, header: &Header) -> ex::Result<Chunk> {
    if !matches!(header.compression, ex::Compression::ZIP1 | ex::Compression::ZIP16) {
        return Ok(block);
    }
    let place = header.get_absolute_block_pixel_coordinates(header.get_block_data_indices(&block.compressed_block)?)?;
    place.validate(Some(header.layer_size))?;
    let bytes = match &mut block.compressed_block {
        CompressedBlock::ScanLine(lines) => &mut lines.compressed_pixels_le,
        CompressedBlock::Tile(tile) => &mut tile.compressed_pixels_le,
        _ => return Ok(block),
    };
    let length = place.size.area() * header.channels.bytes_per_pixel;
    // A block that would not get smaller is stored as it is.
    if bytes.len() != length {
        let mut differences = vec![0; length];
        let unpacked = Decompressor::new().zlib_decompress(bytes, &mut differences);
        if unpacked != Ok(length) {
            return Err(ex::Error::Invalid("a block of zlib is malformed".into()));
        }
        *bytes = interleaved(&mut differences);
    }
    Ok(block)
}

/// What was stored as differences, each 128 too large, of bytes of which those of even place come first. Numbers have two
/// bytes or four, so that both halves are equally long.
fn interleaved(differences: &mut [u8]) -> Vec<u8> {
    if let Some(first) = differences.first_mut() {
        *first ^= 128;
    }
    // Each half is summed by itself, so that one need not wait for the other.
    let (even, odd) = differences.split_at_mut(differences.len() / 2);
    let mut sums = [0u8; 2];
    for (a, b) in even.iter_mut().zip(odd.iter_mut()) {
        sums = [sums[0].wrapping_add(*a ^ 128), sums[1].wrapping_add(*b ^ 128)];
        [*a, *b] = sums;
    }
    let mut bytes = vec![0; even.len() + odd.len()];
    for (pair, (a, b)) in bytes.as_chunks_mut().0.iter_mut().zip(even.iter().zip(odd.iter())) {
        *pair = [*a, b.wrapping_add(sums[0])];
    }
    bytes
}
