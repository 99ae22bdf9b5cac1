// SPDX-License-Identifier: MIT OR Apache-2.0
//! How texels are stored: components × representation, and what that costs in precision.
//!
//! A file a family: floats, integers, floats that share a word, colours with a range, blocks.

mod bc6h;
mod block;
mod float;
mod packed;
mod range;
mod rgbe;
mod steps;
mod unorm;

use std::borrow::Cow;
use std::ops::RangeInclusive;

use half::f16;
use pulp::{Arch, Simd, WithSimd};

use self::range::Range;
pub use self::steps::Steps;
use crate::error::{Error, Result, nearest};
use crate::texture::{Shape, Texture};

/// How one component is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repr {
    /// IEEE 754 half float: 11 significant bits, largest value 65504.
    F16,
    /// IEEE 754 single float.
    F32,
    /// Unsigned integer over [0, 1], 8 bits.
    Unorm8,
    /// Unsigned integer over [0, 1], 16 bits.
    Unorm16,
    /// Unsigned integer over [0, 1], 10 bits: three in a word.
    Unorm10,
    /// Radiance RGBE: 8-bit mantissas that share one exponent.
    Rgbe8,
    /// 9-bit mantissas that share one exponent of 5 bits.
    Rgb9e5,
    /// Floats without sign of 11, 11 and 10 bits.
    B10g11r11,
    /// Bytes of pow(v, 1/2.2), divided by alpha.
    Rgbd8,
    /// Bytes of the root, multiplied with alpha.
    Rgbm8,
    /// Bytes of the root, multiplied with 8 − 7 alpha.
    Rgbp8,
    /// Blocks of 4 × 4 texels over [0, 1], one channel in 8 bytes.
    Bc4,
    /// The same with two channels.
    Bc5,
    /// Blocks of 4 × 4 texels of halves without sign.
    Bc6h,
}

impl Repr {
    /// The values that a component can hold; beyond them it is clamped.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Repr::F16 => -float::HALF_MAX..=float::HALF_MAX,
            Repr::F32 => f32::MIN..=f32::MAX,
            Repr::Unorm8 | Repr::Unorm16 | Repr::Unorm10 | Repr::Bc4 | Repr::Bc5 => 0.0..=1.0,
            Repr::Rgbe8 => 0.0..=rgbe::MAX,
            Repr::Rgb9e5 => 0.0..=packed::RGB9E5_MAX,
            Repr::B10g11r11 => 0.0..=packed::B10_MAX,
            Repr::Rgbd8 | Repr::Rgbm8 | Repr::Rgbp8 => 0.0..=self.colour_range().map_or(1.0, Range::max),
            Repr::Bc6h => 0.0..=float::HALF_MAX,
        }
    }

    /// Are texels stored in blocks, with losses that depend on their neighbours?
    pub fn is_blocks(self) -> bool {
        matches!(self, Repr::Bc4 | Repr::Bc5 | Repr::Bc6h)
    }

    /// Does what a value loses depend on more than itself, or grow without end towards 0, so that files state it?
    pub fn is_measured(self) -> bool {
        self.is_blocks() || self.colour_range().is_some() || matches!(self, Repr::Rgbe8 | Repr::Rgb9e5)
    }

    /// Bytes that need a shader's arithmetic before they are values.
    fn colour_range(self) -> Option<Range> {
        match self {
            Repr::Rgbd8 => Some(Range::Rgbd),
            Repr::Rgbm8 => Some(Range::Rgbm),
            Repr::Rgbp8 => Some(Range::Rgbp),
            _ => None,
        }
    }

    /// Bytes of a texel with this many components, or of a block.
    fn unit_bytes(self, components: usize) -> usize {
        match self {
            Repr::F16 | Repr::Unorm16 => 2 * components,
            Repr::F32 => 4 * components,
            Repr::Unorm8 => components,
            Repr::Unorm10 | Repr::Rgbe8 | Repr::Rgb9e5 | Repr::B10g11r11 => 4,
            Repr::Rgbd8 | Repr::Rgbm8 | Repr::Rgbp8 => 4,
            Repr::Bc4 => 8,
            Repr::Bc5 | Repr::Bc6h => 16,
        }
    }
}

/// A texel's encoding, named after Vulkan's formats in lower case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoding {
    /// The name used on the command line and in files.
    pub name: &'static str,
    /// Components a texel: 1, 2, 3 or 4. Components beyond the table's channels hold 0, a fourth one 1.
    pub components: usize,
    /// How each component is stored.
    pub repr: Repr,
}

/// Every encoding, in the order of their documentation.
pub const ENCODINGS: &[Encoding] = &[
    Encoding { name: "r16f", components: 1, repr: Repr::F16 },
    Encoding { name: "rg16f", components: 2, repr: Repr::F16 },
    Encoding { name: "rgba16f", components: 4, repr: Repr::F16 },
    Encoding { name: "r32f", components: 1, repr: Repr::F32 },
    Encoding { name: "rg32f", components: 2, repr: Repr::F32 },
    Encoding { name: "rgba32f", components: 4, repr: Repr::F32 },
    Encoding { name: "r8unorm", components: 1, repr: Repr::Unorm8 },
    Encoding { name: "rg8unorm", components: 2, repr: Repr::Unorm8 },
    Encoding { name: "rgb8unorm", components: 3, repr: Repr::Unorm8 },
    Encoding { name: "rgba8unorm", components: 4, repr: Repr::Unorm8 },
    Encoding { name: "r16unorm", components: 1, repr: Repr::Unorm16 },
    Encoding { name: "rg16unorm", components: 2, repr: Repr::Unorm16 },
    Encoding { name: "rgb16unorm", components: 3, repr: Repr::Unorm16 },
    Encoding { name: "rgba16unorm", components: 4, repr: Repr::Unorm16 },
    Encoding { name: "a2b10g10r10", components: 3, repr: Repr::Unorm10 },
    Encoding { name: "rgbe8", components: 3, repr: Repr::Rgbe8 },
    Encoding { name: "rgb9e5", components: 3, repr: Repr::Rgb9e5 },
    Encoding { name: "b10g11r11", components: 3, repr: Repr::B10g11r11 },
    Encoding { name: "rgbd8", components: 3, repr: Repr::Rgbd8 },
    Encoding { name: "rgbm8", components: 3, repr: Repr::Rgbm8 },
    Encoding { name: "rgbp8", components: 3, repr: Repr::Rgbp8 },
    Encoding { name: "bc4", components: 1, repr: Repr::Bc4 },
    Encoding { name: "bc5", components: 2, repr: Repr::Bc5 },
    Encoding { name: "bc6h", components: 3, repr: Repr::Bc6h },
];

impl Encoding {
    /// The encoding with this name.
    pub fn parse(name: &str) -> Result<Encoding> {
        ENCODINGS.iter().copied().find(|e| e.name == name).ok_or_else(|| {
            Error::usage(format!("unknown encoding '{name}'"), nearest(name, ENCODINGS.iter().map(|e| e.name)))
        })
    }

    /// The encoding with the fewest components, at least `channels`, of one representation.
    pub fn fitting(repr: Repr, channels: usize) -> Option<Encoding> {
        ENCODINGS.iter().copied().filter(|e| e.repr == repr && e.components >= channels).min_by_key(|e| e.components)
    }

    /// Has it the range for this shape? Radiance knows no upper bound, so integers over [0, 1] hold only tables. Blocks are of
    /// pictures, layers among them, not of volumes.
    pub fn holds(self, shape: Shape) -> bool {
        match shape {
            Shape::Table | Shape::Array { .. } => true,
            Shape::Volume { .. } => !self.repr.is_blocks(),
            Shape::Map | Shape::Cube => *self.repr.range().end() > 1.0,
        }
    }

    /// Bytes of a texel, or of a block where there are blocks.
    pub fn unit_bytes(self) -> usize {
        self.repr.unit_bytes(self.components)
    }

    /// Texels along the side of what [`Encoding::unit_bytes`] tells the size of: 1, or 4 of a block.
    pub fn unit_side(self) -> u32 {
        if self.repr.is_blocks() { block::SIDE } else { 1 }
    }

    /// Bytes of a level; `None` where they are more than can be counted.
    pub fn level_bytes(self, pictures: Pictures) -> Option<u64> {
        let units = |side: u32| u64::from(side.div_ceil(self.unit_side()));
        let units = units(pictures.width).checked_mul(units(pictures.height))?.checked_mul(pictures.count.into())?;
        units.checked_mul(self.unit_bytes() as u64)
    }

    /// What a shader must do to what it reads, for an encoding that GPUs do not know; `r`, `g`, `b`, `a` are over [0, 1].
    pub fn formula(self) -> Option<&'static str> {
        self.repr.colour_range().map(Range::formula)
    }

    /// The largest error that rounding can make near `value`: half the distance between neighbouring values.
    ///
    /// `largest` is the largest component of the texel, which sets the step where components share something; the others
    /// ignore it. A value outside [`Repr::range`] is clamped, which this bound does not cover. Of blocks it is NaN, within
    /// which nothing is: their loss is measured, see [`Steps`].
    pub fn half_ulp_at(self, value: f64, largest: f64) -> f64 {
        match self.repr {
            Repr::F16 => float::half_ulp_of_half(value),
            Repr::F32 => float::half_ulp_of_single(value),
            Repr::Unorm8 => 0.5 / 255.0,
            Repr::Unorm16 => 0.5 / 65535.0,
            Repr::Unorm10 => 0.5 / unorm::TEN_BITS,
            Repr::Rgbe8 => rgbe::half_step(largest),
            Repr::Rgb9e5 => packed::half_step_of_rgb9e5(largest),
            Repr::B10g11r11 => packed::half_step_of_b10g11r11(value),
            Repr::Rgbd8 => Range::Rgbd.half_step(value, largest),
            Repr::Rgbm8 => Range::Rgbm.half_step(value, largest),
            Repr::Rgbp8 => Range::Rgbp.half_step(value, largest),
            Repr::Bc4 | Repr::Bc5 | Repr::Bc6h => f64::NAN,
        }
    }
}

/// Bytes that a container may pack further, without loss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// What the container always does: a KTX2 holds plain levels, an OpenEXR is zipped.
    #[default]
    Plain,
    /// Zstandard, level by level.
    Zstd,
}

impl Compression {
    /// Every compression, in the order of their documentation.
    pub const ALL: [Compression; 2] = [Compression::Plain, Compression::Zstd];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Compression::Plain => "none",
            Compression::Zstd => "zstd",
        }
    }

    /// The compression with this name.
    pub fn parse(name: &str) -> Result<Compression> {
        let known = || Self::ALL.iter().map(|c| c.name());
        let found = Self::ALL.into_iter().find(|c| c.name() == name);
        found.ok_or_else(|| Error::usage(format!("unknown compression '{name}'"), nearest(name, known())))
    }
}

/// How long the encoders of blocks search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// For looking at a result.
    Fast,
    /// For most.
    #[default]
    Normal,
    /// For the file that ships.
    Slow,
}

impl Effort {
    /// Every effort, in the order of their documentation.
    pub const ALL: [Effort; 3] = [Effort::Fast, Effort::Normal, Effort::Slow];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Effort::Fast => "fast",
            Effort::Normal => "normal",
            Effort::Slow => "slow",
        }
    }

    /// The effort with this name.
    pub fn parse(name: &str) -> Result<Effort> {
        let known = || Self::ALL.iter().map(|e| e.name());
        let found = Self::ALL.into_iter().find(|e| e.name() == name);
        found.ok_or_else(|| Error::usage(format!("unknown effort '{name}'"), nearest(name, known())))
    }
}

/// How a texture is to be stored in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Storage {
    /// How texels are stored.
    pub encoding: Encoding,
    /// What is done to the bytes.
    pub compression: Compression,
    /// How long the encoders of blocks search.
    pub effort: Effort,
}

impl From<Encoding> for Storage {
    /// Without further compression, with the usual effort.
    fn from(encoding: Encoding) -> Self {
        Storage { encoding, compression: Compression::default(), effort: Effort::default() }
    }
}

/// How a texture is stored, with its levels as they were encoded to be certified.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stored {
    /// How.
    pub storage: Storage,
    /// The bytes of every level; `None` where they were not encoded yet.
    pub(super) levels: Option<Vec<Vec<u8>>>,
}

impl<S: Into<Storage>> From<S> for Stored {
    fn from(storage: S) -> Self {
        Stored { storage: storage.into(), levels: None }
    }
}

/// The pictures of a level: one, or of a cube six.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pictures {
    /// Texels from left to right.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How many.
    pub count: u32,
}

impl Pictures {
    /// Of a level of a texture.
    pub fn of(texture: &Texture, level: usize) -> Pictures {
        let (width, height) = texture.level_size(level);
        Pictures { width, height, count: texture.faces() }
    }

    /// All texels.
    pub fn texels(self) -> usize {
        self.count as usize * self.width as usize * self.height as usize
    }
}

/// 2ⁿ, exact, which the standard library's `exp2` need not be; n ∈ [−1022, 1023].
pub(crate) fn exp2i(n: i32) -> f64 {
    debug_assert!((-1022..=1023).contains(&n), "2^{n} is no normal number");
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// ⌊log₂|value|⌋, exact; far below every bound for 0.
fn exponent(value: f64) -> i32 {
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// A little-endian word of four bytes; 0 where there are fewer.
fn word(texel: &[u8]) -> u32 {
    texel.first_chunk().map_or(0, |b| u32::from_le_bytes(*b))
}

/// Texels that are converted together.
const RUN: usize = 1 << 10;

/// A level as bytes, little endian, rounded to nearest even. `values` holds `channels` a texel, picture by picture. Components
/// beyond the channels hold 0, a fourth one 1; a value outside [`Repr::range`] becomes the nearest one inside, NaN stays
/// NaN in floats and becomes 0 elsewhere.
pub fn encode(values: &[f32], channels: usize, pictures: Pictures, storage: impl Into<Storage>) -> Result<Vec<u8>> {
    let Storage { encoding, effort, .. } = storage.into();
    fits(channels, encoding)?;
    if encoding.repr.is_blocks() {
        return Ok(block::encode(values, channels, pictures, encoding.repr, effort));
    }
    let mut bytes = Vec::with_capacity(values.len() / channels * encoding.unit_bytes());
    let range = encoding.repr.range();
    let is_float = matches!(encoding.repr, Repr::F16 | Repr::F32);
    let n = encoding.components;
    // What fills a texel stays as it is from run to run.
    let mut run = [0.0, 0.0, 0.0, 1.0][..n].repeat(RUN.min(values.len() / channels));
    for texels in values.chunks(RUN * channels) {
        let run = &mut run[..texels.len() / channels * n];
        for (to, texel) in run.chunks_exact_mut(n).zip(texels.chunks_exact(channels)) {
            for (to, v) in to.iter_mut().zip(texel) {
                *to = if v.is_nan() && !is_float { 0.0 } else { v.clamp(*range.start(), *range.end()) };
            }
        }
        encode_run(run, encoding, &mut bytes);
    }
    Ok(bytes)
}

/// Texels of as many components as the encoding has, within its range.
fn encode_run(run: &[f32], encoding: Encoding, bytes: &mut Vec<u8>) {
    let mut each = |put: &dyn Fn(&[f32], &mut Vec<u8>)| {
        run.chunks_exact(encoding.components).for_each(|texel| put(texel, bytes));
    };
    let rgb = |texel: &[f32]| [texel[0], texel[1], texel[2]];
    match encoding.repr {
        Repr::F16 => float::encode_halves(run, bytes),
        Repr::F32 => float::encode_singles(run, bytes),
        Repr::Unorm8 => each(&unorm::encode_bytes),
        Repr::Unorm16 => each(&unorm::encode_words),
        Repr::Unorm10 => each(&unorm::encode_ten),
        Repr::Rgbe8 => each(&|texel, out| out.extend(rgbe::encode(rgb(texel)))),
        Repr::Rgb9e5 => each(&|texel, out| packed::encode_rgb9e5(rgb(texel), out)),
        Repr::B10g11r11 => each(&|texel, out| packed::encode_b10g11r11(rgb(texel), out)),
        Repr::Rgbd8 => each(&|texel, out| out.extend(Range::Rgbd.encode(rgb(texel)))),
        Repr::Rgbm8 => each(&|texel, out| out.extend(Range::Rgbm.encode(rgb(texel)))),
        Repr::Rgbp8 => each(&|texel, out| out.extend(Range::Rgbp.encode(rgb(texel)))),
        Repr::Bc4 | Repr::Bc5 | Repr::Bc6h => unreachable!("blocks are encoded by themselves"),
    }
}

/// The first `channels` components of each texel: what [`encode`] wrote. A texel cut short at the end is left out.
pub fn decode(bytes: &[u8], channels: usize, pictures: Pictures, encoding: Encoding) -> Vec<f32> {
    let channels = channels.min(encoding.components);
    if encoding.repr.is_blocks() {
        return block::decode(bytes, channels, pictures, encoding.repr);
    }
    if channels == 0 {
        return vec![];
    }
    let unit = encoding.unit_bytes();
    let bytes = &bytes[..bytes.len() / unit * unit];
    let mut values = vec![0.0; bytes.len() / unit * channels];
    let mut each = |get: &dyn Fn(&[u8]) -> [f32; 4]| {
        for (to, texel) in values.chunks_exact_mut(channels).zip(bytes.chunks_exact(unit)) {
            to.copy_from_slice(&get(texel)[..channels]);
        }
    };
    let rgb = |of: &dyn Fn([u8; 4]) -> [f32; 3], texel: &[u8]| {
        let [r, g, b] = of(word(texel).to_le_bytes());
        [r, g, b, 1.0]
    };
    match encoding.repr {
        Repr::F16 | Repr::F32 => {
            let get = if encoding.repr == Repr::F16 { float::decode_halves } else { float::decode_singles };
            for (to, run) in values.chunks_mut(RUN * channels).zip(bytes.chunks(RUN * unit)) {
                let components = get(run);
                for (to, texel) in to.chunks_exact_mut(channels).zip(components.chunks_exact(encoding.components)) {
                    to.copy_from_slice(&texel[..channels]);
                }
            }
        }
        Repr::Unorm8 => each(&unorm::decode_bytes),
        Repr::Unorm16 => each(&unorm::decode_words),
        Repr::Unorm10 => each(&unorm::decode_ten),
        Repr::Rgbe8 => each(&|texel| rgb(&rgbe::decode, texel)),
        Repr::Rgb9e5 => each(&packed::decode_rgb9e5),
        Repr::B10g11r11 => each(&packed::decode_b10g11r11),
        Repr::Rgbd8 => each(&|texel| rgb(&|b| Range::Rgbd.decode(b), texel)),
        Repr::Rgbm8 => each(&|texel| rgb(&|b| Range::Rgbm.decode(b), texel)),
        Repr::Rgbp8 => each(&|texel| rgb(&|b| Range::Rgbp.decode(b), texel)),
        Repr::Bc4 | Repr::Bc5 | Repr::Bc6h => unreachable!("blocks are decoded above"),
    }
    values
}

/// What an encoding did to values. Those that were clamped are left out.
///
/// Two measures say how much is lost on the whole. `rms_rel` is the root of what renderers call the relative mean squared
/// error (Rousselle, Knaus, Zwicker 2011): it counts every component in proportion to itself. `rms` is the
/// normalised root mean square error, in which the brightest texels decide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// The largest difference between a value and what is stored.
    pub max_abs: f64,
    /// The largest difference relative to the value, over values of at least 2⁻¹⁴: the smallest normal half float.
    /// Below it halves are evenly spaced, and the ratio only tells how near to 0 a value happens to lie.
    pub max_rel: f64,
    /// Root mean square of the differences over that of the values: √(Σ (stored − value)² / Σ value²).
    pub rms: f64,
    /// Root mean square of the differences relative to their values, over values of at least 2⁻¹⁴:
    /// √(mean ((stored − value) / value)²) over texels and channels.
    pub rms_rel: f64,
}

/// What an encoding did to the values of a texture. Values that were clamped are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rounding {
    /// Each figure of the level where it is largest.
    pub most: Loss,
    /// Level by level.
    pub levels: Vec<Loss>,
    /// Of all texels of all levels.
    pub whole: Loss,
    /// Of all texels of the levels after the first, which a filter made smooth; `None` of a single level.
    pub filtered: Option<Loss>,
    /// Values outside [`Repr::range`], stored as its nearest end.
    pub clamped: usize,
}

/// The sums behind a [`Loss`].
#[derive(Clone, Copy, Debug, Default)]
struct Losses {
    max_abs: f64,
    max_rel: f64,
    squares: f64,
    squared_values: f64,
    squared_ratios: f64,
    ratios: f64,
}

/// Values beside what is stored in their place, to be compared with the widest vectors that the processor has.
struct Comparison<'a> {
    values: &'a [f32],
    stored: &'a [f32],
    range: &'a RangeInclusive<f32>,
}

/// Sums that do not wait for each other.
const LANES: usize = 4;

impl WithSimd for Comparison<'_> {
    type Output = (Losses, usize);

    // Without branches, in plain loops: nothing keeps the compiler from wide vectors.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> (Losses, usize) {
        let (least, most) = (*self.range.start(), *self.range.end());
        // Sum by sum, so that the lanes of each lie together.
        let mut max_abs = [0.0; LANES];
        let mut max_rel = [0.0; LANES];
        let [mut squares, mut squared_values, mut squared_ratios] = [[0.0; LANES]; 3];
        let [mut ratios, mut held] = [[0.0; LANES]; 2];
        let (values, last_values) = self.values.as_chunks::<LANES>();
        let (stored, last_stored) = self.stored.as_chunks::<LANES>();
        // What fills up the last lanes is not held.
        let (mut last, mut last_of_stored) = ([f32::NAN; LANES], [0.0; LANES]);
        last[..last_values.len()].copy_from_slice(last_values);
        last_of_stored[..last_stored.len()].copy_from_slice(last_stored);
        let mut compare = |values: &[f32; LANES], stored: &[f32; LANES]| {
            for i in 0..LANES {
                let is_held = values[i] >= least && values[i] <= most;
                let value = if is_held { f64::from(values[i].abs()) } else { 0.0 };
                let error = if is_held { (f64::from(stored[i]) - f64::from(values[i])).abs() } else { 0.0 };
                let is_normal = value >= f64::from(f16::MIN_POSITIVE);
                let ratio = if is_normal { error / value } else { 0.0 };
                max_abs[i] = if error > max_abs[i] { error } else { max_abs[i] };
                squares[i] += error * error;
                squared_values[i] += value * value;
                max_rel[i] = if ratio > max_rel[i] { ratio } else { max_rel[i] };
                squared_ratios[i] += ratio * ratio;
                ratios[i] += if is_normal { 1.0 } else { 0.0 };
                held[i] += if is_held { 1.0 } else { 0.0 };
            }
        };
        values.iter().zip(stored).for_each(|(values, stored)| compare(values, stored));
        compare(&last, &last_of_stored);
        let lane = |i: usize| Losses {
            max_abs: max_abs[i],
            max_rel: max_rel[i],
            squares: squares[i],
            squared_values: squared_values[i],
            squared_ratios: squared_ratios[i],
            ratios: ratios[i],
        };
        let held: f64 = held.iter().sum();
        ((0..LANES).map(lane).fold(Losses::default(), Losses::and), self.values.len() - held as usize)
    }
}

impl Losses {
    /// Of values of which none was clamped, and what is stored in their place; the others are counted.
    fn of(values: &[f32], stored: &[f32], range: &RangeInclusive<f32>) -> (Losses, usize) {
        Arch::new().dispatch(Comparison { values, stored, range })
    }

    /// Of runs of texels beside their bytes.
    fn of_runs<'a>(
        runs: impl Iterator<Item = Result<(&'a [f32], Cow<'a, [u8]>)>>,
        channels: usize,
        encoding: Encoding,
    ) -> Result<(Losses, usize)> {
        let range = encoding.repr.range();
        let (mut losses, mut clamped) = (Losses::default(), 0);
        for run in runs {
            let (values, bytes) = run?;
            let pictures = Pictures { width: (values.len() / channels) as u32, height: 1, count: 1 };
            let (more, also) = Losses::of(values, &decode(&bytes, channels, pictures, encoding), &range);
            (losses, clamped) = (losses.and(more), clamped + also);
        }
        Ok((losses, clamped))
    }

    fn and(self, other: Losses) -> Losses {
        Losses {
            max_abs: self.max_abs.max(other.max_abs),
            max_rel: self.max_rel.max(other.max_rel),
            squares: self.squares + other.squares,
            squared_values: self.squared_values + other.squared_values,
            squared_ratios: self.squared_ratios + other.squared_ratios,
            ratios: self.ratios + other.ratios,
        }
    }

    fn loss(self) -> Loss {
        let root = |sum: f64, over: f64| if over > 0.0 { (sum / over).sqrt() } else { 0.0 };
        Loss {
            max_abs: self.max_abs,
            max_rel: self.max_rel,
            rms: root(self.squares, self.squared_values),
            rms_rel: root(self.squared_ratios, self.ratios),
        }
    }
}

impl Rounding {
    /// Compares, level by level, what is stored with what was to be stored.
    pub(super) fn between(texture: &Texture, repr: Repr, stored: &[Vec<f32>]) -> Rounding {
        let range = repr.range();
        Self::sum(texture.levels.iter().zip(stored).map(|(level, stored)| Losses::of(level, stored, &range)))
    }

    /// Of the levels' losses, and the values that were clamped.
    fn sum(of_levels: impl Iterator<Item = (Losses, usize)>) -> Rounding {
        let (losses, clamped): (Vec<Losses>, Vec<usize>) = of_levels.unzip();
        let levels: Vec<Loss> = losses.iter().map(|level| level.loss()).collect();
        let largest = |of: fn(&Loss) -> f64| levels.iter().map(of).fold(0.0, f64::max);
        let most = Loss {
            max_abs: largest(|l| l.max_abs),
            max_rel: largest(|l| l.max_rel),
            rms: largest(|l| l.rms),
            rms_rel: largest(|l| l.rms_rel),
        };
        let together = |from: usize| losses.iter().skip(from).copied().reduce(Losses::and).map(Losses::loss);
        let (whole, filtered) = (together(0).unwrap_or_default(), together(1));
        Rounding { most, levels, whole, filtered, clamped: clamped.iter().sum() }
    }
}

/// Encodes and decodes every texel, and compares.
pub fn rounding(texture: &Texture, storage: impl Into<Storage>) -> Result<Rounding> {
    let storage @ Storage { encoding, .. } = storage.into();
    if encoding.repr.is_blocks() {
        return Ok(Rounding::between(texture, encoding.repr, &stored(texture, storage)?));
    }
    // Texels by themselves: a few at a time need little memory.
    fits(texture.channels.len(), encoding)?;
    let channels = texture.channels.len();
    let encoded = |values: &[f32]| {
        let run = Pictures { width: (values.len() / channels) as u32, height: 1, count: 1 };
        encode(values, channels, run, storage).map(Cow::Owned)
    };
    let of_levels = texture.levels.iter().map(|level| {
        Losses::of_runs(level.chunks(RUN * channels).map(|values| Ok((values, encoded(values)?))), channels, encoding)
    });
    Ok(Rounding::sum(of_levels.collect::<Result<Vec<_>>>()?.into_iter()))
}

/// The same of texels that were encoded before, not in blocks.
pub(super) fn rounding_of(texture: &Texture, encoding: Encoding, levels: &[Vec<u8>]) -> Result<Rounding> {
    let channels = texture.channels.len();
    let of_levels = texture.levels.iter().zip(levels).map(|(level, bytes)| {
        let runs = level.chunks(RUN * channels).zip(bytes.chunks(RUN * encoding.unit_bytes()));
        Losses::of_runs(runs.map(|(values, bytes)| Ok((values, Cow::Borrowed(bytes)))), channels, encoding)
    });
    Ok(Rounding::sum(of_levels.collect::<Result<Vec<_>>>()?.into_iter()))
}

/// Every level as bytes.
pub(super) fn encoded(texture: &Texture, storage: Storage) -> Result<Vec<Vec<u8>>> {
    let level = |i: usize| encode(&texture.levels[i], texture.channels.len(), Pictures::of(texture, i), storage);
    (0..texture.levels.len()).map(level).collect()
}

/// Every level as a reader finds it in these bytes.
pub(super) fn decoded(bytes: &[Vec<u8>], texture: &Texture, encoding: Encoding) -> Vec<Vec<f32>> {
    let level =
        |(i, bytes): (usize, &Vec<u8>)| decode(bytes, texture.channels.len(), Pictures::of(texture, i), encoding);
    bytes.iter().enumerate().map(level).collect()
}

/// Every level as a reader will find it.
pub(super) fn stored(texture: &Texture, storage: Storage) -> Result<Vec<Vec<f32>>> {
    Ok(decoded(&encoded(texture, storage)?, texture, storage.encoding))
}

/// An error when a texel of `encoding` has fewer components than a texture has channels.
pub(super) fn fits(channels: usize, encoding: Encoding) -> Result<()> {
    if (1..=encoding.components).contains(&channels) {
        return Ok(());
    }
    let what =
        format!("encoding {} holds {} components, the texture has {channels}", encoding.name, encoding.components);
    let help = match Encoding::fitting(encoding.repr, channels).or(Encoding::fitting(Repr::F16, channels)) {
        Some(other) if channels > 0 => format!("use {}", other.name),
        _ => "a texture has 1 to 4 channels".into(),
    };
    Err(Error::usage(what, help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Meta;

    fn by_name(name: &str) -> Encoding {
        Encoding::parse(name).expect("a name of the list")
    }

    const ONE: Pictures = Pictures { width: 1, height: 1, count: 1 };

    /// What becomes of a texel that holds the value in every component.
    fn round(value: f32, name: &str) -> [f32; 4] {
        let (encoding, mut stored) = (by_name(name), [f32::NAN; 4]);
        let n = encoding.components;
        stored[..n].copy_from_slice(&decode(&encode(&[value; 4][..n], n, ONE, encoding).unwrap(), n, ONE, encoding));
        stored
    }

    fn bytes(values: &[f32], name: &str) -> Vec<u8> {
        encode(values, values.len(), ONE, by_name(name)).unwrap()
    }

    #[test]
    fn half_rounds_to_nearest_even() {
        // Halves near 1 are 2^-10 apart: the ties go to the even mantissa, down once and up once.
        assert_eq!(round(1.0 + 1.0 / 2048.0, "r16f")[0], 1.0);
        assert_eq!(round(1.0 + 3.0 / 2048.0, "r16f")[0], 1.0 + 2.0 / 1024.0);
        assert_eq!(round(exp2i(-25) as f32 * 1.001, "r16f")[0], exp2i(-24) as f32, "subnormal");
    }

    #[test]
    fn padding_is_zero_and_a_fourth_component_one() {
        assert_eq!(decode(&bytes(&[0.25, 0.5], "rgba16f"), 4, ONE, by_name("rgba16f")), [0.25, 0.5, 0.0, 1.0]);
        assert_eq!(bytes(&[0.2], "rgb8unorm"), [51, 0, 0]);
        assert_eq!(bytes(&[0.2], "rgba8unorm"), [51, 0, 0, 255]);
        assert_eq!(bytes(&[1.0], "a2b10g10r10"), (3_u32 << 30 | 1023).to_le_bytes());
    }

    #[test]
    fn bytes_are_little_endian() {
        assert_eq!(bytes(&[1.0], "r16f"), [0x00, 0x3c]);
        assert_eq!(bytes(&[1.0], "r32f"), [0, 0, 0x80, 0x3f]);
        assert_eq!(bytes(&[1.0 / 65535.0], "r16unorm"), [1, 0]);
    }

    #[test]
    fn too_many_channels_is_an_error_that_names_a_fit() {
        let error = encode(&[0.0; 3], 3, ONE, by_name("rg16f")).unwrap_err();
        assert_eq!(error.to_string(), "encoding rg16f holds 2 components, the texture has 3");
        assert_eq!(error.help(), "use rgba16f");
        assert_eq!(encode(&[0.0; 4], 4, ONE, by_name("rgb8unorm")).unwrap_err().help(), "use rgba8unorm");
        assert_eq!(encode(&[], 0, ONE, by_name("r16f")).unwrap_err().help(), "a texture has 1 to 4 channels");
    }

    /// A multiplicative walk over all magnitudes, both signs where the representation has them.
    fn probes(encoding: Encoding) -> Vec<f32> {
        let (low, high) = (*encoding.repr.range().start(), *encoding.repr.range().end());
        let mut values = vec![0.0, high, low];
        let mut v = 1e-12_f32;
        while v < high.min(1e12) {
            values.extend([v, if low < 0.0 { -v } else { v }]);
            v *= 1.0137;
        }
        values
    }

    #[test]
    fn half_ulp_bounds_the_rounding_and_is_reached() {
        for &encoding in ENCODINGS.iter().filter(|e| !e.repr.is_blocks()) {
            let mut worst = 0.0_f64;
            for value in probes(encoding) {
                for stored in &round(value, encoding.name)[..encoding.components] {
                    let error = (f64::from(*stored) - f64::from(value)).abs();
                    let bound = encoding.half_ulp_at(f64::from(value), f64::from(value));
                    // Decoded integers are themselves rounded to f32: half an ulp of that on top.
                    assert!(error <= bound + 6e-8 * f64::from(value.abs()), "{}: {value} → {stored}", encoding.name);
                    worst = worst.max(error / bound);
                }
            }
            if encoding.repr == Repr::F32 {
                assert_eq!(worst, 0.0);
            } else {
                assert!(worst > 0.9, "{}: the bound is never approached, {worst}", encoding.name);
            }
        }
    }

    #[test]
    fn half_ulp_bounds_the_rounding_of_colours_beside_their_largest_component() {
        for &encoding in ENCODINGS.iter().filter(|e| e.components == 3 && !e.repr.is_blocks()) {
            let mut worst = 0.0_f64;
            for (i, largest) in probes(encoding).into_iter().enumerate() {
                let texel = [0.618_034, 1.0, 0.01 + i as f32 % 0.9].map(|share| share * largest);
                let stored = decode(&bytes(&texel, encoding.name), 3, ONE, encoding);
                let found = f64::from(stored.iter().fold(0.0_f32, |a, b| a.max(*b)));
                for (value, stored) in texel.into_iter().zip(stored) {
                    // A check knows the largest component as it is stored.
                    let bound = encoding.half_ulp_at(f64::from(value), found) + 6e-8 * f64::from(value);
                    let error = (f64::from(stored) - f64::from(value)).abs();
                    assert!(error <= bound, "{}: {texel:?}, {value} → {stored}, {bound}", encoding.name);
                    worst = worst.max(error / bound);
                }
            }
            assert!(worst > 0.9, "{}: the bound is never approached, {worst}", encoding.name);
        }
    }

    #[test]
    fn half_ulp_matches_the_spacing_of_halves() {
        let e = by_name("r16f");
        for bits in [0_u16, 1, 0x3ff, 0x400, 0x3bff, 0x3c00, 0x3c01, 0x7bfe] {
            let (a, b) = (f16::from_bits(bits).to_f64(), f16::from_bits(bits + 1).to_f64());
            assert_eq!(e.half_ulp_at(0.5 * (a + b), 0.0), 0.5 * (b - a), "{bits:#x}");
        }
    }

    fn table(values: Vec<f32>) -> Texture {
        let width = values.len() as u32;
        let channels = vec!["a".to_string()];
        Texture { shape: Shape::Table, width, height: 1, channels, levels: vec![values], meta: Meta::default() }
    }

    #[test]
    fn rounding_reports_error_and_clamping() {
        let tie = 1.0 + 1.0 / 2048.0;
        let report = rounding(&table(vec![0.5, tie, 70000.0, 65504.0]), by_name("r16f")).unwrap();
        let tie = f64::from(tie);
        let most = report.most;
        assert_eq!((most.max_abs, most.max_rel, report.clamped), (1.0 / 2048.0, 1.0 / 2048.0 / tie, 1));
        let squares = 0.25 + tie * tie + 65504.0 * 65504.0;
        assert_eq!(most.rms, (1.0 / 2048.0 / 2048.0 / squares).sqrt());
        assert_eq!(most.rms_rel, ((1.0 / 2048.0 / tie).powi(2) / 3.0).sqrt());
        assert_eq!((report.levels, report.whole, report.filtered), (vec![most], most, None));
        let exact = rounding(&table(vec![0.1, 1e30]), by_name("r32f")).unwrap();
        assert_eq!((exact.most, exact.clamped), (Loss::default(), 0));
    }

    #[test]
    fn levels_count_together_by_their_texels() {
        let halves = by_name("r16f");
        // Level 0 of 2 × 2 texels is exact; of level 1, one texel, the half is off by a known share.
        let off = 1.0 + 1.0 / 4096.0;
        let texture = Texture {
            shape: Shape::Cube,
            width: 2,
            height: 2,
            channels: vec!["a".into()],
            levels: vec![vec![1.0; 24], vec![1.0, 1.0, 1.0, off, off, 1.0]],
            meta: Meta::default(),
        };
        let report = rounding(&texture, halves).unwrap();
        let share = (f64::from(off) - 1.0) / f64::from(off);
        let filtered = report.filtered.unwrap();
        assert_eq!(filtered.rms_rel, (2.0 * share * share / 6.0).sqrt());
        assert_eq!(report.whole.rms_rel, (2.0 * share * share / 30.0).sqrt());
        assert_eq!((report.levels[0], report.levels[1], report.most), (Loss::default(), filtered, filtered));
    }
}
