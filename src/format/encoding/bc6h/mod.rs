//! The encoder of BC6H blocks of halves without sign.
//!
//! A block has 128 bits: two ends of a line of colours and 16 steps between them for all 16 texels, or two lines of 8
//! steps for the two regions of one of 32 partitions. 14 modes share the bits out differently. The search looks for the
//! block that loses least *relative to the values*, not least in levels of light: radiance spans decades, and its dark
//! texels are seen beside dark ones. See [`Region::whole`] for the measure.
//!
//! The search: a line through all texels, in each mode of one region; the partitions in the order of what lines through
//! their regions leave over, in the modes that reach that far; the best few again, code by code; and, of blocks that still
//! lose much, again from other ends. Blocks that lose next to nothing are left earlier. Every candidate's error is that
//! of the values that a GPU decodes, so the file's error is what the search found.

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
            Effort::Fast => Search { lines: 0, partitions: 0, modes: 0, refined: 0, retried: 0, retries: &[] },
            Effort::Normal => Search { lines: 8, partitions: 2, modes: 1, refined: 1, retried: 0, retries: &[] },
            Effort::Slow => Search { lines: 16, partitions: 6, modes: 1, refined: 3, retried: 1, retries: &RETRIES },
        }
    }
}

/// Components of a block.
const COMPONENTS: f32 = 48.0;
/// Blocks that lose less than this, in the root mean square of their components, are good enough.
const GOOD: f32 = 0.001;
/// Blocks that lose more than this are worth another try.
const HARD: f32 = 0.005;
/// Codes that an end may be out of a mode's reach for the mode to be tried.
const NEARLY: i32 = 2;

/// The bytes of a block of 4 × 4 texels, row by row, of values in [0, 65504]. `rms` is the root mean square of the picture
/// that the block belongs to.
pub fn encode(texels: &[[f32; 3]; 16], rms: f32, effort: Effort) -> [u8; 16] {
    pack(&search(texels, rms, effort.into()))
}

fn search(texels: &[[f32; 3]; 16], rms: f32, search: Search) -> Content {
    let loses = |found: &Candidate<'_>, much: f32| found.error() > COMPONENTS * much * much;

    // One region.
    let whole = Region::whole(texels, rms);
    let lines = [whole.line(&STEPS_OF_4_BITS).0];
    let reaching = MODES.iter().filter(|mode| mode.regions == 1 && excess(&lines, mode) <= mode.reach()[0][1]);
    let mut found: Vec<Candidate<'_>> = reaching.map(|mode| Candidate::of_one(mode, &whole, &lines[0])).collect();
    keep(&mut found, search.refined);
    if search.partitions == 0 || !loses(&found[0], GOOD) {
        return found[0].content();
    }

    // Two regions.
    let residual = |i: usize| (whole.split_residual(PARTITIONS[i].second), i);
    let mut order: Vec<(f32, usize)> = (0..PARTITIONS.len()).map(residual).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut splits: Vec<Split> = order.iter().take(search.lines).map(|(_, i)| Split::new(&whole, *i)).collect();
    splits.sort_by(|a, b| a.error.total_cmp(&b.error));
    for split in splits.iter().take(search.partitions) {
        found.extend(split.modes(search.modes).map(|mode| Candidate::of_two(mode, split)));
    }
    keep(&mut found, search.refined);

    // The best, code by code; then from other ends.
    found.iter_mut().take(search.refined).for_each(|candidate| candidate.refine(&[]));
    keep(&mut found, search.retried);
    if loses(&found[0], HARD) {
        found.iter_mut().take(search.retried).for_each(|candidate| candidate.refine(search.retries));
        keep(&mut found, 1);
    }
    found[0].content()
}

/// The best `count`, at least one, the best first.
fn keep(found: &mut Vec<Candidate<'_>>, count: usize) {
    found.sort_by(|a, b| a.error().total_cmp(&b.error()));
    found.truncate(count.max(1));
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

    /// The `count` most precise modes that reach from end to end, and those before them that nearly do.
    fn modes(&self, count: usize) -> impl Iterator<Item = &'static Mode> {
        let mut precise: Vec<&Mode> = MODES.iter().filter(|mode| mode.regions == 2).collect();
        precise.sort_by_key(|mode| std::cmp::Reverse(mode.bits));
        let mut reaching = 0;
        precise.into_iter().filter(move |mode| {
            let excess = excess(&self.lines, mode);
            let is_wanted = reaching < count && excess <= NEARLY;
            reaching += usize::from(is_wanted && excess == 0);
            is_wanted
        })
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
            Candidate {
                mode,
                partition: split.partition,
                lines: vec![(&split.regions[0], a), (&split.regions[1], b)],
            }
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
        let mut content = Content { mode: self.mode, partition: self.partition, ends: [[0; 3]; ENDS], indices: [0; 16] };
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
    let range = std::array::from_fn(|c| reach[c].map(|difference| (first.ends[0][c] + difference).clamp(0, mode.top())));
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
