// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks of 4 × 4 texels, which GPUs decode as they read them (Khronos Data Format Specification 1.3, the chapters on
//! RGTC and BPTC).
//!
//! `bc4` and `bc5` hold one and two channels over [0, 1] in 8 bytes each: two ends of 8 bits and 8 or 6 steps between
//! them, encoded by the `dds` crate. `bc6h` holds three channels of unsigned halves in 16 bytes, encoded by the module of
//! that name. All are decoded by `bcdec_rs`: neither encoder's own idea of what it wrote.
//!
//! What a block loses depends on how its texels differ, so there is no bound but what is measured. A picture whose size is
//! no multiple of 4 is filled up with its last column and row.

use half::f16;
use rayon::prelude::*;

use super::{Effort, Pictures, Repr, bc6h, float};

/// Texels along a block's side.
pub const SIDE: u32 = 4;
/// Texels of a block.
const TEXELS: usize = 16;

/// The blocks of every picture, one after the other. `values` has `channels` a texel, at most as many as the blocks
/// hold; further ones are 0.
pub fn encode(values: &[f32], channels: usize, pictures: Pictures, repr: Repr, effort: Effort) -> Vec<u8> {
    let columns = pictures.width.div_ceil(SIDE);
    let rows = pictures.height.div_ceil(SIDE);
    let held = |v: f32| if v.is_nan() { 0.0 } else { v.clamp(0.0, float::HALF_MAX) };
    let rms = root_mean_square(values.iter().map(|v| held(*v)));
    let of_row = |row: u32| {
        let (picture, y0) = (row / rows, row % rows * SIDE);
        let value = |x: u32, y: u32, c: usize| {
            let (x, y) = (x.min(pictures.width - 1), (y0 + y).min(pictures.height - 1));
            let texel = (picture as usize * pictures.height as usize + y as usize) * pictures.width as usize;
            if c < channels { values[(texel + x as usize) * channels + c] } else { 0.0 }
        };
        let width = SIDE * columns;
        let plane = |c: usize| -> Vec<f32> {
            (0..SIDE).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| value(x, y, c)).collect()
        };
        match repr {
            Repr::Bc6h => {
                let texel = |x: u32, y: u32| [0, 1, 2].map(|c| held(value(x, y, c)));
                let block = |x0: u32| {
                    let at = |t: usize| (SIDE * x0 + t as u32 % SIDE, t as u32 / SIDE);
                    let is_inside = |(x, y): (u32, u32)| x < pictures.width && y0 + y < pictures.height;
                    let inside = (0..TEXELS).map(|t| u16::from(is_inside(at(t))) << t).sum();
                    bc6h::encode(&std::array::from_fn(|t| texel(at(t).0, at(t).1)), inside, rms, effort)
                };
                (0..columns).flat_map(block).collect()
            }
            Repr::Bc5 => {
                let (red, green) = (bc4(&plane(0), width, effort), bc4(&plane(1), width, effort));
                let pairs = red.chunks_exact(8).zip(green.chunks_exact(8));
                pairs.flat_map(|(r, g)| r.iter().chain(g)).copied().collect()
            }
            _ => bc4(&plane(0), width, effort),
        }
    };
    (0..pictures.count * rows).into_par_iter().map(of_row).collect::<Vec<_>>().concat()
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f32>) -> f32 {
    let count = values.len().max(1) as f64;
    let squares: f64 = values.map(|v| f64::from(v).powi(2)).sum();
    (squares / count).sqrt() as f32
}

/// A row of blocks of one channel.
fn bc4(plane: &[f32], width: u32, effort: Effort) -> Vec<u8> {
    let view = ::dds::ImageView::new(
        bytemuck::cast_slice(plane),
        ::dds::Size::new(width, SIDE),
        ::dds::ColorFormat::GRAYSCALE_F32,
    )
    .expect("the plane has 4 rows of `width` values");
    let mut options = ::dds::EncodeOptions::default();
    options.quality = match effort {
        Effort::Fast => ::dds::CompressionQuality::Fast,
        Effort::Normal => ::dds::CompressionQuality::Normal,
        Effort::Slow => ::dds::CompressionQuality::High,
    };
    let mut out = vec![];
    ::dds::encode(&mut out, view, ::dds::Format::BC4_UNORM, None, &options).expect("a vector takes what is written");
    out
}

/// The first `channels` values of every texel. What is missing at the end of `bytes` is left out, block row by block row.
pub fn decode(bytes: &[u8], channels: usize, pictures: Pictures, repr: Repr) -> Vec<f32> {
    let (columns, rows) = (pictures.width.div_ceil(SIDE) as usize, pictures.height.div_ceil(SIDE));
    let block_bytes = repr.unit_bytes(1);
    let mut values = Vec::with_capacity(pictures.texels() * channels);
    for (row, blocks) in bytes.chunks_exact(columns * block_bytes).enumerate() {
        let texels: Vec<[[f32; 3]; TEXELS]> = blocks.chunks_exact(block_bytes).map(|b| decode_block(b, repr)).collect();
        let y0 = row as u32 % rows * SIDE;
        for y in 0..SIDE.min(pictures.height - y0) {
            for x in 0..pictures.width {
                let texel = &texels[(x / SIDE) as usize][(y * SIDE + x % SIDE) as usize];
                values.extend(&texel[..channels]);
            }
        }
    }
    values
}

/// Rows of texels of one block.
fn decode_block(block: &[u8], repr: Repr) -> [[f32; 3]; TEXELS] {
    let mut texels = [[0.0; 3]; TEXELS];
    match repr {
        Repr::Bc6h => {
            let mut halves = [0u16; 3 * TEXELS];
            bcdec_rs::bc6h_half(block, &mut halves, 3 * SIDE as usize, false);
            let halves = halves.as_chunks::<3>().0;
            texels.iter_mut().zip(halves).for_each(|(to, from)| *to = from.map(|h| f16::from_bits(h).to_f32()));
        }
        _ => {
            for (c, half) in block.chunks_exact(8).enumerate() {
                let mut plane = [0.0; TEXELS];
                bcdec_rs::bc4_float(half, &mut plane, SIDE as usize, false);
                texels.iter_mut().zip(plane).for_each(|(to, v)| to[c] = v);
            }
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::*;

    const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Normal, Effort::Slow];

    /// Decoded again, of a smooth picture.
    fn worst(repr: Repr, channels: usize, pictures: Pictures, effort: Effort) -> f32 {
        let texels = pictures.texels();
        let values: Vec<f32> = (0..texels * channels)
            .map(|i| {
                let (x, y) = (i / channels % pictures.width as usize, i / channels / pictures.width as usize);
                0.2 + 0.01 * (x + i % channels) as f32 + 0.02 * (y as f32 / 3.0).sin()
            })
            .collect();
        let stored = decode(&encode(&values, channels, pictures, repr, effort), channels, pictures, repr);
        assert_eq!(stored.len(), values.len());
        values.iter().zip(&stored).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn smooth_pictures_come_back_in_every_size() {
        for (width, height, count) in [(16, 8, 1), (1, 1, 6), (2, 2, 6), (5, 7, 1), (33, 3, 6)] {
            let pictures = Pictures { width, height, count };
            for effort in EFFORTS {
                assert!(worst(Repr::Bc4, 1, pictures, effort) < 0.006, "{pictures:?} {effort:?}");
                assert!(worst(Repr::Bc5, 2, pictures, effort) < 0.006, "{pictures:?} {effort:?}");
                assert!(worst(Repr::Bc6h, 3, pictures, effort) < 0.006, "{pictures:?} {effort:?}");
            }
        }
    }

    #[test]
    fn ends_of_a_block_are_exact() {
        let pictures = Pictures { width: 4, height: 4, count: 1 };
        let mut values = vec![0.0; 16];
        values[5] = 1.0;
        assert_eq!(decode(&encode(&values, 1, pictures, Repr::Bc4, Effort::Normal), 1, pictures, Repr::Bc4), values);
        // 8 of the 16 texels of both halves are the largest half, the others 0.
        let halves: Vec<f32> = (0..48).map(|i| if i % 6 < 3 { float::HALF_MAX } else { 0.0 }).collect();
        let stored = decode(&encode(&halves, 3, pictures, Repr::Bc6h, Effort::Slow), 3, pictures, Repr::Bc6h);
        assert!(stored.iter().all(|v| v.is_finite() && *v >= 0.0), "{stored:?}");
    }
}
