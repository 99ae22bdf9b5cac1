// SPDX-License-Identifier: MIT OR Apache-2.0
//! The encoder of BC6H blocks of halves without sign.
//!
//! A block has 128 bits: two ends of a line of colours and 16 steps between them for all 16 texels, or two lines of 8
//! steps for the two regions of one of 32 partitions. 14 modes share the bits out differently. The search looks for the
//! block that loses least *relative to the values*, and relative to the picture's root mean square besides: radiance spans
//! decades, dark texels are seen beside dark ones, and a sun must not lose its light. Encoders that compare the bits of
//! half floats care for neither. See [`Region::whole`] for the measure.
//!
//! The search: a line through all texels, in the modes of one region that reach that far; partitions in the order of
//! what lines through their regions leave over, likewise; the best few again, code by code; and, of blocks that still lose
//! much, again from other ends. Blocks that lose next to nothing are left earlier. Every candidate's error is that of the
//! values that a GPU decodes, so the file's error is what the search found.

mod layout;
mod palette;
mod partition;
mod region;

use self::layout::{Content, ENDS, MODES, Mode, pack};
use self::palette::{STEPS_OF_3_BITS, STEPS_OF_4_BITS};
use self::partition::PARTITIONS;
use self::region::{Fit, Limits, Line, Region};
use super::Effort;

/// How far the search goes.
#[derive(Clone, Copy, Debug)]
struct Search {
    /// Blocks that lose less than this with one region, in the root mean square of their components, are good enough.
    good: f32,
    /// Partitions whose lines are fitted, those that seem best first.
    lines: usize,
    /// Partitions of which blocks are made, those with the best lines first.
    partitions: usize,
    /// Modes that a partition is tried in, the most precise first.
    modes: usize,
    /// Candidates that are improved code by code.
    refined: usize,
    /// Of these, candidates that are tried again from other ends, in blocks that lose much.
    retried: usize,
    /// By which shares of their line these ends are moved.
    retries: &'static [[f32; 2]],
}

/// Ends pulled in, pushed out, and moved along their line.
const RETRIES: [[f32; 2]; 8] =
    [[0.1, -0.1], [-0.1, 0.1], [0.2, 0.0], [0.0, -0.2], [0.1, 0.1], [-0.1, -0.1], [-0.25, 0.25], [0.3, -0.3]];

impl From<Effort> for Search {
    fn from(effort: Effort) -> Search {
        match effort {
            Effort::Fast => {
                Search { good: 0.0, lines: 0, partitions: 0, modes: 0, refined: 0, retried: 0, retries: &[] }
            }
            Effort::Normal => {
                Search { good: 0.0025, lines: 8, partitions: 2, modes: 1, refined: 1, retried: 0, retries: &[] }
            }
            Effort::Slow => {
                Search { good: 0.001, lines: 16, partitions: 6, modes: 1, refined: 3, retried: 1, retries: &RETRIES }
            }
        }
    }
}

/// Components of a block.
const COMPONENTS: f32 = 48.0;
/// Blocks that lose more than this are worth another try, with less precise modes or from other ends.
const HARD: f32 = 0.005;
/// Codes that an end of two lines may be out of a mode's reach for the mode to be tried.
const NEARLY: i32 = 2;

/// The bytes of a block of 4 × 4 texels, row by row, of values in [0, 65504]. Bit t of `inside` tells whether texel t
/// belongs to the picture or only fills a block at its edge. `rms` is the root mean square of the picture.
pub fn encode(texels: &[[f32; 3]; 16], inside: u16, rms: f32, effort: Effort) -> [u8; 16] {
    pack(&search(&Region::whole(texels, inside, rms), effort.into()).0)
}

/// The block that loses least of those that the search meets, and how much: a sum of weighted squares, see
/// [`Region::whole`].
fn search(whole: &Region, search: Search) -> (Content, f32) {
    let loses = |found: &Candidate<'_>, much: f32| found.error() > COMPONENTS * much * much;

    // One region.
    let lines = [whole.line(&STEPS_OF_4_BITS).0];
    let of_one = |count: usize| {
        let modes = reaching(&lines, 1, count, |mode| mode.reach()[0][1]);
        let mut found: Vec<Candidate<'_>> = modes.map(|mode| Candidate::of_one(mode, whole, &lines[0])).collect();
        keep(&mut found, search.refined);
        found
    };
    let mut found = of_one(1);
    if loses(&found[0], HARD) {
        found = of_one(MODES.len());
    }
    if search.partitions == 0 || !loses(&found[0], search.good) {
        return (found[0].content(), found[0].error());
    }

    // Two regions.
    let residual = |i: usize| (whole.split_residual(PARTITIONS[i].second), i);
    let mut order: Vec<(f32, usize)> = (0..PARTITIONS.len()).map(residual).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut splits: Vec<Split> = order.iter().take(search.lines).map(|(_, i)| Split::new(whole, *i)).collect();
    splits.sort_by(|a, b| a.error.total_cmp(&b.error));
    for split in splits.iter().take(search.partitions) {
        let modes = reaching(&split.lines, 2, search.modes, |_| NEARLY);
        found.extend(modes.map(|mode| Candidate::of_two(mode, split)));
    }
    keep(&mut found, search.refined);

    // The best, code by code; then from other ends.
    found.iter_mut().take(search.refined).for_each(|candidate| candidate.refine(&[]));
    keep(&mut found, search.retried);
    if loses(&found[0], HARD) {
        found.iter_mut().take(search.retried).for_each(|candidate| candidate.refine(search.retries));
        keep(&mut found, 1);
    }
    (found[0].content(), found[0].error())
}

/// The best `count`, at least one, the best first.
fn keep(found: &mut Vec<Candidate<'_>>, count: usize) {
    found.sort_by(|a, b| a.error().total_cmp(&b.error()));
    found.truncate(count.max(1));
}

/// The `count` most precise modes of so many regions that reach from end to end of these lines, and those before them that
/// do but for `nearly` codes.
fn reaching(
    lines: &[Line],
    regions: usize,
    count: usize,
    nearly: fn(&Mode) -> i32,
) -> impl Iterator<Item = &'static Mode> {
    let mut precise: Vec<&Mode> = MODES.iter().filter(|mode| mode.regions == regions).collect();
    precise.sort_by_key(|mode| std::cmp::Reverse(mode.bits));
    let mut reaching = 0;
    precise.into_iter().filter(move |mode| {
        let excess = excess(lines, mode);
        let is_wanted = reaching < count && excess <= nearly(mode);
        reaching += usize::from(is_wanted && excess == 0);
        is_wanted
    })
}

/// By how many codes an end of these lines is out of the mode's reach.
fn excess(lines: &[Line], mode: &Mode) -> i32 {
    let codes = |end: &[f32; 3]| end.map(|level| palette::quantize(level, mode.bits));
    let first = codes(&lines[0][0]);
    let of_end = |end: &[f32; 3]| {
        let beyond = |((code, first), [least, most]): ((i32, i32), [i32; 2])| {
            (code - first - most).max(least - (code - first)).max(0)
        };
        codes(end).into_iter().zip(first).zip(mode.reach()).map(beyond).max().unwrap_or(0)
    };
    lines.iter().flatten().map(of_end).max().unwrap_or(0)
}

/// A partition's regions and the lines through them.
struct Split {
    partition: usize,
    regions: [Region; 2],
    lines: [Line; 2],
    error: f32,
}

impl Split {
    fn new(whole: &Region, partition: usize) -> Split {
        let split = PARTITIONS[partition];
        let regions = [whole.part(!split.second, 0), whole.part(split.second, split.anchor)];
        let [a, b] = [regions[0].line(&STEPS_OF_3_BITS), regions[1].line(&STEPS_OF_3_BITS)];
        Split { partition, regions, lines: [a.0, b.0], error: a.1 + b.1 }
    }
}

/// A block that may be written.
struct Candidate<'a> {
    mode: &'static Mode,
    partition: usize,
    /// The lines of its regions.
    lines: Vec<(&'a Region, Fit)>,
}

impl<'a> Candidate<'a> {
    fn of_one(mode: &'static Mode, whole: &'a Region, line: &Line) -> Candidate<'a> {
        let limits = Limits { range: [[[0, mode.top()]; 3]; 2], gap: mode.reach() };
        let fit = whole.fit(line, mode.bits, mode.steps(), &limits);
        Candidate { mode, partition: 0, lines: vec![(whole, fit)] }
    }

    /// Both orders: the second line as the first one allows it, or the first line as the second one does.
    fn of_two(mode: &'static Mode, split: &'a Split) -> Candidate<'a> {
        let whole_range = [[[0, mode.top()]; 3]; 2];
        let fit = |i: usize, limits: &Limits| split.regions[i].fit(&split.lines[i], mode.bits, mode.steps(), limits);
        let of = |fits: [Fit; 2]| {
            let [a, b] = fits;
            Candidate { mode, partition: split.partition, lines: vec![(&split.regions[0], a), (&split.regions[1], b)] }
        };
        let first = fit(0, &Limits { range: whole_range, gap: mode.reach() });
        let forward = of([first, fit(1, &limits_of_second(mode, &first))]);
        if excess(&split.lines, mode) == 0 {
            return forward;
        }
        let span = mode.reach().map(|[least, most]| [least - most, most - least]);
        let second = fit(1, &Limits { range: whole_range, gap: span });
        let backward = of([fit(0, &limits_of_first(mode, &second)), second]);
        if backward.error() < forward.error() { backward } else { forward }
    }

    /// Sum of the weighted squares of what all texels lose.
    fn error(&self) -> f32 {
        self.lines.iter().map(|(_, fit)| fit.error).sum()
    }

    /// Improves one line after the other, from where it is and from these shares of it away.
    fn refine(&mut self, retries: &[[f32; 2]]) {
        for i in 0..self.lines.len() {
            let limits = match (i, self.lines.get(1)) {
                (0, None) => Limits { range: [[[0, self.mode.top()]; 3]; 2], gap: self.mode.reach() },
                (0, Some((_, second))) => limits_of_first(self.mode, second),
                _ => limits_of_second(self.mode, &self.lines[0].1),
            };
            let (region, fit) = &mut self.lines[i];
            region.descend(fit, self.mode.bits, self.mode.steps(), &limits);
            region.retry(fit, self.mode.bits, self.mode.steps(), &limits, retries);
        }
    }

    fn content(&self) -> Content {
        let mut content =
            Content { mode: self.mode, partition: self.partition, ends: [[0; 3]; ENDS], indices: [0; 16] };
        for (i, (region, fit)) in self.lines.iter().enumerate() {
            content.ends[2 * i..2 * i + 2].copy_from_slice(&fit.ends);
            region.place(fit, &mut content.indices);
        }
        content
    }
}

/// Where the second region's ends may lie while the first region's are those of `first`.
fn limits_of_second(mode: &Mode, first: &Fit) -> Limits {
    let reach = mode.reach();
    let range =
        std::array::from_fn(|c| reach[c].map(|difference| (first.ends[0][c] + difference).clamp(0, mode.top())));
    Limits { range: [range; 2], gap: [[-mode.top(), mode.top()]; 3] }
}

/// Where the first region's ends may lie while the second region's are those of `second`: no further apart than the mode
/// can reach.
fn limits_of_first(mode: &Mode, second: &Fit) -> Limits {
    let reach = mode.reach();
    let range = std::array::from_fn(|c| {
        let [a, b] = [second.ends[0][c], second.ends[1][c]];
        [(a.max(b) - reach[c][1]).max(0), (a.min(b) - reach[c][0]).min(mode.top())]
    });
    Limits { range: [range, [[0, mode.top()]; 3]], gap: reach }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use half::f16;
    use rayon::prelude::*;

    use super::palette::{unquantize, value};
    use super::*;
    use crate::env::sky::Sky;
    use crate::format::{Format, Ktx2};

    type Texels = [[f32; 3]; 16];

    const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Normal, Effort::Slow];

    /// Every partition in every mode that nearly reaches, each a dozen times: about what the format can hold.
    const EXHAUSTIVE: Search =
        Search { good: 0.001, lines: 32, partitions: 32, modes: 10, refined: 48, retried: 48, retries: &MANY };
    const MANY: [[f32; 2]; 12] = [
        [0.1, -0.1],
        [-0.1, 0.1],
        [0.2, 0.0],
        [0.0, -0.2],
        [0.1, 0.1],
        [-0.1, -0.1],
        [-0.25, 0.25],
        [0.3, -0.3],
        [0.05, 0.0],
        [0.0, -0.05],
        [-0.2, 0.0],
        [0.0, 0.2],
    ];
    const ALL: u16 = 0xffff;

    /// Numbers in [0, 1) that repeat from run to run: a linear congruence.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f32 / (1 << 24) as f32
        }

        fn code(&mut self, [least, most]: [i32; 2]) -> i32 {
            least + (self.next() * (most - least + 1) as f32) as i32
        }
    }

    /// What the decoder of the program and that of the `dds` crate make of a block: one answer.
    fn decoded(block: &[u8; 16]) -> Texels {
        let mut halves = [0; 48];
        bcdec_rs::bc6h_half(block, &mut halves, 12, false);
        let texels: Texels = std::array::from_fn(|t| [0, 1, 2].map(|c| f16::from_bits(halves[3 * t + c]).to_f32()));
        let mut other: Texels = [[0.0; 3]; 16];
        let view = ::dds::ImageViewMut::new(
            bytemuck::cast_slice_mut(&mut other),
            ::dds::Size::new(4, 4),
            ::dds::ColorFormat::RGB_F32,
        );
        let options = ::dds::DecodeOptions::default();
        let view = view.expect("16 texels of three singles");
        ::dds::decode(&mut &block[..], view, ::dds::Format::BC6H_UF16, &options).expect("a block");
        assert_eq!(texels, other);
        texels
    }

    /// Sum of the weighted squares of what decoding a block gives.
    fn error_of(texels: &Texels, rms: f32, block: &[u8; 16]) -> f64 {
        let relative = |value: f32, stored: f32| {
            let error = f64::from(stored - value);
            (error / f64::from(value)).powi(2) + (error / f64::from(rms)).powi(2)
        };
        texels.as_flattened().iter().zip(decoded(block).as_flattened()).map(|(v, s)| relative(*v, *s)).sum()
    }

    #[test]
    fn blocks_say_what_two_decoders_read_in_every_mode_and_partition() {
        let mut numbers = Numbers(1);
        for (mode, partition) in MODES.iter().flat_map(|mode| (0..32).map(move |p| (mode, p))) {
            // Random codes in reach of the first, random indices with the anchors in the first half.
            let first = [0; 3].map(|_: i32| numbers.code([0, mode.top()]));
            let mut ends = [first; ENDS];
            for (end, c) in (1..ENDS).flat_map(|end| (0..3).map(move |c| (end, c))) {
                let [least, most] = mode.reach()[c];
                ends[end][c] = numbers.code([(first[c] + least).max(0), (first[c] + most).min(mode.top())]);
            }
            let (second, anchor) = match mode.regions {
                2 => (PARTITIONS[partition].second, PARTITIONS[partition].anchor),
                _ => (0, 0),
            };
            let steps = mode.steps();
            let top = |t: usize| if t == 0 || t == anchor { steps.len() / 2 } else { steps.len() } as i32 - 1;
            let indices = std::array::from_fn(|t| numbers.code([0, top(t)]) as u8);
            let found = decoded(&pack(&Content { mode, partition, ends, indices }));
            for (t, texel) in found.into_iter().enumerate() {
                let region = usize::from(second >> t & 1);
                let end = |i: usize, c: usize| unquantize(ends[2 * region + i][c], mode.bits);
                let step = steps[usize::from(indices[t])];
                let expected = [0, 1, 2].map(|c| value(end(0, c), end(1, c), step));
                assert_eq!(texel, expected, "{} bits, partition {partition}, texel {t}", mode.bits);
            }
        }
    }

    #[test]
    fn blocks_of_one_half_come_back_exactly() {
        let mut numbers = Numbers(2);
        for i in 0..300 {
            let largest = 0x7bff;
            let texel = [0; 3].map(|_: i32| f16::from_bits(numbers.code([0, largest]) as u16).to_f32());
            let texel = if i == 0 { [65504.0, 0.0, 65504.0] } else { texel };
            for effort in EFFORTS {
                assert_eq!(decoded(&encode(&[texel; 16], ALL, 1.0, effort)), [texel; 16], "{effort:?}");
            }
        }
    }

    /// Two ramps of colours on either side of a partition, over contrasts from none to 1 : 16000.
    fn edges(numbers: &mut Numbers) -> Texels {
        let second = PARTITIONS[numbers.code([0, 31]) as usize].second;
        let contrast = (14.0 * numbers.next().powi(2)).exp2();
        let colour = |numbers: &mut Numbers| [0; 3].map(|_: i32| contrast.powf(numbers.next() - 0.5));
        let ends: [[f32; 3]; 4] = std::array::from_fn(|_| colour(numbers));
        std::array::from_fn(|t| {
            let region = 2 * usize::from(second >> t & 1);
            let share = numbers.next();
            [0, 1, 2].map(|c| ends[region][c] * (1.0 - share) + ends[region + 1][c] * share)
        })
    }

    #[test]
    fn every_mode_is_of_use_and_the_stated_error_is_that_of_the_bytes() {
        let (mut numbers, mut used) = (Numbers(3), BTreeSet::new());
        for _ in 0..6000 {
            let texels = edges(&mut numbers);
            let (content, error) = search(&Region::whole(&texels, ALL, 1.0), Effort::Normal.into());
            used.insert(MODES.iter().position(|mode| std::ptr::eq(mode, content.mode)));
            let found = error_of(&texels, 1.0, &pack(&content));
            assert!((found - f64::from(error)).abs() <= 1e-3 * found + 1e-9, "{error} is stated, {found} found");
        }
        assert_eq!(used.len(), MODES.len(), "{used:?}");
    }

    /// Blocks of a sky with its sun, and their root mean square.
    fn sky() -> (Vec<Texels>, f32) {
        let sky = Sky { sun_disc: true, sun_elevation_deg: 25.0, ..Sky::default() };
        let picture = sky.resolve().expect("a day").equirect(128);
        let texel = |x: usize, y: usize| picture.texels[y * picture.width as usize + x].map(|v| v.min(65504.0));
        let (columns, rows) = (picture.width as usize / 4, picture.height as usize / 4);
        let blocks: Vec<Texels> = (0..rows)
            .flat_map(|y| (0..columns).map(move |x| (4 * x, 4 * y)))
            .map(|(x, y)| std::array::from_fn(|t| texel(x + t % 4, y + t / 4)))
            .collect();
        let values = || blocks.iter().flat_map(|texels| texels.as_flattened());
        let rms = (values().map(|v| v * v).sum::<f32>() / values().count() as f32).sqrt();
        (blocks, rms)
    }

    /// Root mean square of the errors that the search minimises.
    fn loss(blocks: &[Texels], rms: f32, how: Search) -> f64 {
        let of = |texels: &Texels| f64::from(search(&Region::whole(texels, ALL, rms), how).1);
        (blocks.par_iter().map(of).sum::<f64>() / blocks.len() as f64 / f64::from(COMPONENTS)).sqrt()
    }

    #[test]
    fn more_effort_loses_less_and_an_exhaustive_search_little_less_again() {
        let (blocks, rms) = sky();
        let mut blocks: Vec<Texels> = blocks.into_iter().step_by(7).collect();
        let [fast, normal, slow] = EFFORTS.map(|effort| loss(&blocks, rms, effort.into()));
        println!("{} blocks of a sky: fast {fast:.2e}, normal {normal:.2e}, slow {slow:.2e}", blocks.len());
        assert!(slow < normal && normal < fast, "{slow} {normal} {fast}");
        // The hardest blocks make up most of the sum.
        blocks
            .sort_by_cached_key(|texels| std::cmp::Reverse((1e6 * loss(&[*texels], rms, Effort::Slow.into())) as u64));
        let (slow, all) = (loss(&blocks[..12], rms, Effort::Slow.into()), loss(&blocks[..12], rms, EXHAUSTIVE));
        println!("the 12 hardest: slow {slow:.2e}, exhaustive {all:.2e}");
        assert!(slow < 1.05 * all, "{slow} {all}");
    }

    #[test]
    fn texels_beyond_the_edge_of_a_picture_cost_nothing() {
        // Four texels of the picture, which two lines hold to a code; 16 need more.
        let mut numbers = Numbers(4);
        let texels: Texels = [[0.0; 3]; 16].map(|texel| texel.map(|_: f32| 0.5 + numbers.next()));
        let inside = 0x0033;
        let worst = |inside: u16| {
            let found = decoded(&encode(&texels, inside, 1.0, Effort::Slow));
            let of_texel = |t: usize| (0..3).map(move |c| (t, c));
            let components = (0..16).filter(|t| 0x0033 >> t & 1 == 1).flat_map(of_texel);
            components.map(|(t, c)| (found[t][c] / texels[t][c] - 1.0).abs()).fold(0.0, f32::max)
        };
        println!("worst of four texels {:.1e}, among 16 {:.1e}", worst(inside), worst(ALL));
        assert!(worst(inside) < 0.25 * worst(ALL));
    }

    /// The figures of docs/bc6h.md: `BC6H_CUBE=cube.ktx2`, of single floats.
    #[test]
    #[ignore = "takes minutes, and a cube of the user's"]
    fn figures_of_a_cube() {
        let path = std::env::var("BC6H_CUBE").expect("BC6H_CUBE names a cube");
        let (cube, _) = Ktx2.read(Path::new(&path)).expect("a cube");
        for (level, values) in cube.levels.iter().enumerate() {
            let size = cube.level_size(level).0 as usize;
            let texel = |face: usize, x: usize, y: usize| {
                let at = cube.channels.len() * ((face * size + y) * size + x);
                [0, 1, 2].map(|c| values[at + c].clamp(0.0, 65504.0))
            };
            let side = size.div_ceil(4);
            let every = if size < 32 { 1 } else { 64 };
            let sample: Vec<(Texels, u16)> = (every / 2..6 * side * side)
                .step_by(every)
                .map(|i| {
                    let at = |t: usize| (4 * (i % side) + t % 4, 4 * (i / side % side) + t / 4);
                    let clamped = |t: usize| (at(t).0.min(size - 1), at(t).1.min(size - 1));
                    let block = std::array::from_fn(|t| texel(i / side / side, clamped(t).0, clamped(t).1));
                    (block, (0..16).map(|t| u16::from(at(t) == clamped(t)) << t).sum())
                })
                .collect();
            let squares: f64 = values.iter().map(|v| f64::from(*v).powi(2)).sum();
            let rms = (squares / values.len() as f64).sqrt() as f32;
            for (name, how) in [("slow", Effort::Slow.into()), ("exhaustive", EXHAUSTIVE)] {
                let [relative, of_values] = losses(&sample, rms, how);
                println!(
                    "level {level}, {} blocks, {name:10} {relative:.2} % relative, {of_values:.2} %",
                    sample.len()
                );
            }
        }
    }

    /// Relative root mean square, and root mean square over that of the values, both in per cent.
    fn losses(sample: &[(Texels, u16)], rms: f32, how: Search) -> [f64; 2] {
        let of_block = |(texels, inside): &(Texels, u16)| {
            let found = decoded(&pack(&search(&Region::whole(texels, *inside, rms), how).0));
            let mut sums = [0.0; 4];
            for t in (0..16).filter(|t| inside >> t & 1 == 1) {
                for (value, stored) in texels[t].into_iter().zip(found[t]) {
                    let (value, error) = (f64::from(value), f64::from(stored) - f64::from(value));
                    let is_relative = value >= f64::from(f16::MIN_POSITIVE);
                    let ratio = if is_relative { error / value } else { 0.0 };
                    let parts = [ratio * ratio, f64::from(u8::from(is_relative)), error * error, value * value];
                    sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
                }
            }
            sums
        };
        let add = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|i| a[i] + b[i]);
        let sums = sample.par_iter().map(of_block).reduce(|| [0.0; 4], add);
        [100.0 * (sums[0] / sums[1]).sqrt(), 100.0 * (sums[2] / sums[3]).sqrt()]
    }
}
