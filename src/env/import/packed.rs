// SPDX-License-Identifier: MIT OR Apache-2.0
//! Texels as GPUs store them.

use half::f16;
use image_dds::{ImageFormat, Surface};
use rayon::prelude::*;

use super::{Color, Job};
use crate::error::Result;
use crate::format::exp2i;

/// How a texel is stored. Alpha, where there is any, does not count; one component is grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Packing {
    /// Half floats, this many a texel.
    F16(usize),
    /// Single floats, this many a texel.
    F32(usize),
    /// Bytes, this many a texel; blue first where `bgr`.
    Unorm8 { components: usize, bgr: bool, color: Color },
    /// 16-bit integers, this many a texel.
    Unorm16(usize, Color),
    /// Three mantissas of 9 bits and an exponent, red lowest.
    Rgb9e5,
    /// Floats without sign of 11, 11 and 10 bits, red lowest.
    B10g11r11,
    /// Blocks of 4 × 4 texels.
    Blocks(ImageFormat, Color),
}

impl Packing {
    /// Bytes of a picture.
    pub fn size_bytes(self, width: u32, height: u32) -> usize {
        let texel = match self {
            Packing::F16(n) | Packing::Unorm16(n, _) => 2 * n,
            Packing::F32(n) => 4 * n,
            Packing::Unorm8 { components, .. } => components,
            Packing::Rgb9e5 | Packing::B10g11r11 => 4,
            Packing::Blocks(format, _) => {
                let block = if format == ImageFormat::BC1RgbaUnorm { 8 } else { 16 };
                return width.div_ceil(4) as usize * height.div_ceil(4) as usize * block;
            }
        };
        width as usize * height as usize * texel
    }

    /// The same, with the user's word on what integers mean.
    pub fn with_color(self, job: &Job<'_>) -> Result<Packing> {
        let color = |own: Color| job.options.color.unwrap_or(own);
        Ok(match self {
            Packing::Unorm8 { components, bgr, color: own } => Packing::Unorm8 { components, bgr, color: color(own) },
            Packing::Unorm16(components, own) => Packing::Unorm16(components, color(own)),
            Packing::Blocks(format, own) if !is_float(format) => Packing::Blocks(format, color(own)),
            floats => {
                job.refuse_color()?;
                floats
            }
        })
    }

    /// Appends the texels of a picture; an error says why they cannot be decoded. `bytes` has
    /// [`Packing::size_bytes`].
    pub fn decode(
        self,
        width: u32,
        height: u32,
        bytes: &[u8],
        out: &mut Vec<[f32; 3]>,
    ) -> std::result::Result<(), String> {
        let grey_or_rgb = |components: usize, at: &dyn Fn(usize) -> f32| {
            if components < 3 { [at(0); 3] } else { [at(0), at(1), at(2)] }
        };
        match self {
            Packing::F16(n) => out.par_extend(
                bytes
                    .par_chunks_exact(2 * n)
                    .map(|t| grey_or_rgb(n, &|i| f16::from_le_bytes([t[2 * i], t[2 * i + 1]]).to_f32())),
            ),
            Packing::F32(n) => out.par_extend(bytes.par_chunks_exact(4 * n).map(|t| {
                grey_or_rgb(n, &|i| f32::from_le_bytes([t[4 * i], t[4 * i + 1], t[4 * i + 2], t[4 * i + 3]]))
            })),
            Packing::Unorm8 { components, bgr, color } => {
                let table = color.table(255);
                out.par_extend(bytes.par_chunks_exact(components).map(|t| {
                    let [r, g, b] = grey_or_rgb(components, &|i| table[usize::from(t[i])]);
                    if bgr { [b, g, r] } else { [r, g, b] }
                }));
            }
            Packing::Unorm16(n, color) => {
                let table = color.table(u16::MAX);
                out.par_extend(
                    bytes
                        .par_chunks_exact(2 * n)
                        .map(|t| grey_or_rgb(n, &|i| table[usize::from(u16::from_le_bytes([t[2 * i], t[2 * i + 1]]))])),
                );
            }
            Packing::Rgb9e5 => out.par_extend(words(bytes).map(rgb9e5)),
            Packing::B10g11r11 => out.par_extend(words(bytes).map(b10g11r11)),
            Packing::Blocks(format, color) => {
                let surface =
                    Surface { width, height, depth: 1, layers: 1, mipmaps: 1, image_format: format, data: bytes };
                let decoded = surface.decode_rgbaf32().map_err(|e| e.to_string())?;
                // Integers come as shares of 1.
                let table = (!is_float(format) && color == Color::Srgb).then(|| color.table(255));
                let linear = |v: f32| table.as_ref().map_or(v, |table| table[(v * 255.0).round() as usize]);
                out.par_extend(decoded.data.par_chunks_exact(4).map(|t| [t[0], t[1], t[2]].map(linear)));
            }
        }
        Ok(())
    }
}

fn is_float(format: ImageFormat) -> bool {
    matches!(format, ImageFormat::BC6hRgbUfloat | ImageFormat::BC6hRgbSfloat)
}

fn words(bytes: &[u8]) -> impl IndexedParallelIterator<Item = u32> {
    bytes.par_chunks_exact(4).map(|t| u32::from_le_bytes([t[0], t[1], t[2], t[3]]))
}

/// Mantissa · 2^(exponent − 15 − 9) (Khronos Data Format Specification 1.3, chapter on shared exponents).
fn rgb9e5(word: u32) -> [f32; 3] {
    let scale = exp2i((word >> 27) as i32 - 24) as f32;
    [0, 9, 18].map(|shift| (word >> shift & 0x1ff) as f32 * scale)
}

/// A half float without its sign and its last bits: 5 bits of exponent and 6 or 5 of mantissa.
fn b10g11r11(word: u32) -> [f32; 3] {
    let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
    [half((word & 0x7ff) << 4), half((word >> 11 & 0x7ff) << 4), half((word >> 22) << 5)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_floats_are_those_of_the_specification() {
        // 1 is 256 · 2^−8 at exponent 16; the largest is 511 · 2^7.
        assert_eq!(rgb9e5(16 << 27 | 256), [1.0, 0.0, 0.0]);
        assert_eq!(rgb9e5(u32::MAX), [65408.0; 3]);
        // 1 has the exponent 15; infinity all ones and no mantissa.
        assert_eq!(b10g11r11(15 << 6 | 16 << 17 | 14 << 27), [1.0, 2.0, 0.5]);
        assert_eq!(b10g11r11(31 << 6)[0], f32::INFINITY);
    }

    #[test]
    fn texels_of_every_packing_are_found() {
        let decode = |packing: Packing, bytes: &[u8]| {
            let mut out = vec![];
            assert_eq!(packing.size_bytes(1, 1), bytes.len());
            packing.decode(1, 1, bytes, &mut out).expect("it decodes");
            out[0]
        };
        let bgra = Packing::Unorm8 { components: 4, bgr: true, color: Color::Linear };
        assert_eq!(decode(bgra, &[0, 51, 255, 9]), [1.0, 0.2, 0.0]);
        assert_eq!(decode(Packing::Unorm16(1, Color::Srgb), &[255, 255]), [1.0; 3]);
        let halves: Vec<u8> = [1.0f32, 2.0, 0.5, 1.0].iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
        assert_eq!(decode(Packing::F16(4), &halves), [1.0, 2.0, 0.5]);
        // A BC6H block of one colour: mode 11 (00011), both ends alike, all indices 0.
        let mut block = 0b00011u128;
        for channel in 0..3 {
            let code = [0x1e0u128, 0x1f0, 0][channel];
            block |= code << (5 + 10 * channel) | code << (35 + 10 * channel);
        }
        let [r, g, b] = decode_block(&block.to_le_bytes());
        assert!(r > 0.0 && g > r && b == 0.0, "{r} {g} {b}");
    }

    fn decode_block(bytes: &[u8]) -> [f32; 3] {
        let mut out = vec![];
        Packing::Blocks(ImageFormat::BC6hRgbUfloat, Color::Linear).decode(4, 4, bytes, &mut out).expect("it decodes");
        assert!(out.iter().all(|t| *t == out[0]) && out.len() == 16);
        out[0]
    }
}
