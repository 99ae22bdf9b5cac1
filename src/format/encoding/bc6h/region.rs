// SPDX-License-Identifier: MIT OR Apache-2.0
//! Texels that share a line of colours: the ends of the line, and where on it each texel lies.
//!
//! Indices for given ends follow from the values themselves, decoded as a GPU does it. Ends for given indices are a
//! weighted least-squares fit in levels, where the line is straight, and the best of the codes around it. The two steps
//! take turns; a descent code by code ends the search.

use super::palette::{SMALLEST_NORMAL, TOP_LEVEL, level, quantize, slope, unquantize, value};

/// Texels that a processor takes at once.
const OCTET: usize = 8;
/// A number a texel, in octets: without bounds to check within them, loops become vector instructions. Lanes beyond a
/// region's texels have weight 0.
type Lanes = [[f32; OCTET]; 2];

/// Levels of the two ends of a line.
pub type Line = [[f32; 3]; 2];
/// Codes of the two ends of a line.
pub type Ends = [[i32; 3]; 2];

/// Steps between the ends in a channel that are tried together.
const MOVES: [[i32; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]];

/// Codes that the ends may have.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Least and most of each end and channel.
    pub range: [[[i32; 2]; 3]; 2],
    /// Least and most that the second end may lie above the first.
    pub gap: [[i32; 2]; 3],
}

impl Limits {
    fn allow(&self, channel: usize, ends: [i32; 2]) -> bool {
        let inside = |value: i32, [least, most]: [i32; 2]| (least..=most).contains(&value);
        inside(ends[0], self.range[0][channel])
            && inside(ends[1], self.range[1][channel])
            && inside(ends[1] - ends[0], self.gap[channel])
    }

    /// The ends moved to where they are allowed: into their ranges, then towards each other.
    fn clamp(&self, channel: usize, ends: [i32; 2]) -> [i32; 2] {
        let clamp = |value: i32, [least, most]: [i32; 2]| value.clamp(least, most);
        let [a, b] = [clamp(ends[0], self.range[0][channel]), clamp(ends[1], self.range[1][channel])];
        let excess = b - a - clamp(b - a, self.gap[channel]);
        let a = clamp(a + excess / 2, self.range[0][channel]);
        let [least, most] = self.gap[channel];
        [a, clamp(b.clamp(a + least, a + most), self.range[1][channel])]
    }
}

/// The line of a region, as a block stores it.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// Sum of the weighted squares of what all texels lose.
    pub error: f32,
    /// The line's ends.
    pub ends: Ends,
    /// Index of every texel, lane by lane.
    indices: [u8; 16],
}

/// Some of a block's texels.
#[derive(Clone, Debug)]
pub struct Region {
    values: [Lanes; 3],
    /// What the square of an error counts.
    weights: [Lanes; 3],
    levels: [Lanes; 3],
    /// The same of an error in levels, as long as it is small.
    level_weights: [Lanes; 3],
    texels: [u8; 16],
    count: usize,
    octets: usize,
    /// The lane whose index lies in the first half of the line.
    anchor: usize,
}

impl Region {
    const EMPTY: Region = Region {
        values: [[[0.0; OCTET]; 2]; 3],
        weights: [[[0.0; OCTET]; 2]; 3],
        levels: [[[0.0; OCTET]; 2]; 3],
        level_weights: [[[0.0; OCTET]; 2]; 3],
        texels: [0; 16],
        count: 0,
        octets: 0,
        anchor: 0,
    };

    /// A whole block, of values in [0, 65504]. Texels whose bit of `inside` is not set count next to nothing.
    ///
    /// The square of an error counts relative to the value, and relative to the level's root mean square `rms` besides:
    /// both measures of the loss get smaller together. Values below 2⁻¹⁴ have no meaningful relative error; they are held
    /// relative to their texel's largest component, or to a thousandth of the root mean square.
    pub fn whole(texels: &[[f32; 3]; 16], inside: u16, rms: f32) -> Region {
        let rms = rms.max(SMALLEST_NORMAL);
        let mut region = Region { texels: std::array::from_fn(|t| t as u8), count: 16, octets: 2, ..Region::EMPTY };
        for (t, texel) in texels.iter().enumerate() {
            // Not 0: a line through texels that do not count would have no ends.
            let share = if inside >> t & 1 == 1 { 1.0 } else { 1e-6 };
            let largest = texel.iter().fold((1e-3 * rms).max(SMALLEST_NORMAL), |a, b| a.max(*b));
            for (c, &value) in texel.iter().enumerate() {
                let scale = if value >= SMALLEST_NORMAL { value } else { largest };
                let weight = share * (1.0 / (scale * scale) + 1.0 / (rms * rms));
                region.values[c].as_flattened_mut()[t] = value;
                region.weights[c].as_flattened_mut()[t] = weight;
                region.levels[c].as_flattened_mut()[t] = level(value);
                region.level_weights[c].as_flattened_mut()[t] = weight * slope(value) * slope(value);
            }
        }
        region
    }

    /// The texels whose bits are set in `mask`, `anchor` among them.
    pub fn part(&self, mask: u16, anchor: usize) -> Region {
        let mut part = Region::EMPTY;
        for t in (0..16).filter(|t| mask >> t & 1 == 1) {
            let lane = part.count;
            if t == anchor {
                part.anchor = lane;
            }
            for c in 0..3 {
                let copy = |from: &Lanes, to: &mut Lanes| to.as_flattened_mut()[lane] = from.as_flattened()[t];
                copy(&self.values[c], &mut part.values[c]);
                copy(&self.weights[c], &mut part.weights[c]);
                copy(&self.levels[c], &mut part.levels[c]);
                copy(&self.level_weights[c], &mut part.level_weights[c]);
            }
            part.texels[lane] = t as u8;
            part.count += 1;
        }
        part.octets = part.count.div_ceil(OCTET);
        part
    }

    /// What lines through the texels of `second` and through the others leave over, about, in squared levels: variance
    /// beside the axis, and of the variance along it what indices of 3 bits lose.
    pub fn split_residual(&self, second: u16) -> f32 {
        [second, !second].into_iter().map(|mask| self.residual(mask)).sum()
    }

    fn residual(&self, mask: u16) -> f32 {
        let share: Lanes = lanes(|t| f32::from(mask >> t & 1));
        let (covariance, _) = self.covariance(&share);
        let (_, along) = principal_axis(&covariance);
        let all = covariance[0][0] + covariance[1][1] + covariance[2][2];
        // 7 intervals: a square of 1/12 of an interval's, over about 1/4 of that of 7.
        (all - along).max(0.0) + along * (4.0 / 12.0 / 49.0)
    }

    /// Sums of products of the deviations from the mean, and the mean, of texels that count by their share.
    fn covariance(&self, share: &Lanes) -> ([[f32; 3]; 3], [f32; 3]) {
        let count: f32 = share.as_flattened().iter().sum();
        let mean: [f32; 3] = std::array::from_fn(|c| dot(&self.levels[c], share) / count);
        let deviations: [Lanes; 3] = std::array::from_fn(|c| {
            std::array::from_fn(|o| std::array::from_fn(|t| (self.levels[c][o][t] - mean[c]) * share[o][t]))
        });
        (std::array::from_fn(|r| std::array::from_fn(|c| dot(&deviations[r], &deviations[c]))), mean)
    }

    /// The line through the texels along their principal axis, fitted in turns with the indices, its first end nearer to
    /// the anchor; and its error, before codes round it.
    pub fn line(&self, steps: &[f32]) -> (Line, f32) {
        // From the first to the last texel along the axis.
        let share = lanes(|t| if t < self.count { 1.0 } else { 0.0 });
        let (covariance, mean) = self.covariance(&share);
        let (axis, _) = principal_axis(&covariance);
        let along = |t: usize| (0..3).map(|c| axis[c] * (self.levels[c].as_flattened()[t] - mean[c])).sum::<f32>();
        let (low, high) = (0..self.count).map(along).fold((f32::MAX, f32::MIN), |(a, b), x| (a.min(x), b.max(x)));
        let end = |x: f32| std::array::from_fn(|c| (mean[c] + axis[c] * x).clamp(0.0, TOP_LEVEL));
        let mut line = [end(low), end(high)];

        let (mut error, mut indices) = self.assign_levels(&line, steps);
        for _ in 0..2 {
            let (mut next, mut ends) = (line, [[0.0; 2]; 3]);
            for (c, ends) in ends.iter_mut().enumerate() {
                *ends = self.solve(c, &indices, steps);
                next[0][c] = ends[0];
                next[1][c] = ends[1];
            }
            let found = self.assign_levels(&next, steps);
            if found.0 >= error {
                break;
            }
            line = next;
            (error, indices) = found;
        }

        let distance = |end: &[f32; 3]| {
            let at = |lanes: &Lanes| lanes.as_flattened()[self.anchor];
            let of = |c: usize| (at(&self.levels[c]) - end[c]).powi(2) * at(&self.level_weights[c]);
            (0..3).map(of).sum::<f32>()
        };
        if distance(&line[1]) < distance(&line[0]) {
            line.swap(0, 1);
        }
        let rounded = line.map(|end| end.map(f32::round));
        let palette = |c: usize, step: f32| value(rounded[0][c], rounded[1][c], step);
        (line, self.assign_values(palette, steps, None).0)
    }

    /// The best codes that this search finds within the limits, from those of a line.
    pub fn fit(&self, line: &Line, bits: u32, steps: &[f32], limits: &Limits) -> Fit {
        let mut ends = line.map(|end| end.map(|level| quantize(level, bits)));
        let [first, second] = &mut ends;
        for (c, (a, b)) in first.iter_mut().zip(second).enumerate() {
            [*a, *b] = limits.clamp(c, [*a, *b]);
        }
        let mut best = self.assign(ends, bits, steps);
        for _ in 0..2 {
            let mut next = best.ends;
            let at: Lanes = lanes(|t| steps[usize::from(best.indices[t])]);
            let [first, second] = &mut next;
            for (c, (a, b)) in first.iter_mut().zip(second).enumerate() {
                [*a, *b] = self.best_codes(c, &best, &at, bits, steps, limits);
            }
            if next == best.ends {
                break;
            }
            let found = self.assign(next, bits, steps);
            if found.error >= best.error {
                break;
            }
            best = found;
        }
        best
    }

    /// The ends of a channel that lose least while the texels stay at their steps: those of `fit`, or one of nine around
    /// the least-squares solution.
    fn best_codes(&self, c: usize, fit: &Fit, at: &Lanes, bits: u32, steps: &[f32], limits: &Limits) -> [i32; 2] {
        let mut best = (f32::MAX, [fit.ends[0][c], fit.ends[1][c]]);
        let mut consider = |ends: [i32; 2]| {
            let error = self.channel_error(c, ends.map(|code| unquantize(code, bits)), at);
            if error < best.0 {
                best = (error, ends);
            }
        };
        consider([fit.ends[0][c], fit.ends[1][c]]);
        let [a, b] = limits.clamp(c, self.solve(c, &fit.indices, steps).map(|level| quantize(level, bits)));
        for [i, j] in [[0, 0]].into_iter().chain(MOVES) {
            if limits.allow(c, [a + i, b + j]) {
                consider([a + i, b + j]);
            }
        }
        best.1
    }

    /// Changes the ends by single codes as long as that helps, with the indices that are then the best.
    pub fn descend(&self, fit: &mut Fit, bits: u32, steps: &[f32], limits: &Limits) {
        let mut moved = true;
        while moved {
            moved = false;
            for c in 0..3 {
                let others = self.errors_without(c, &fit.ends, bits, steps);
                for [i, j] in MOVES {
                    let ends = [fit.ends[0][c] + i, fit.ends[1][c] + j];
                    if !limits.allow(c, ends) {
                        continue;
                    }
                    let error = self.error_with(c, ends.map(|code| unquantize(code, bits)), steps, &others);
                    // A share of a millionth is rounding.
                    if error < fit.error * (1.0 - 1e-6) {
                        (fit.error, fit.ends[0][c], fit.ends[1][c]) = (error, ends[0], ends[1]);
                        moved = true;
                    }
                }
            }
        }
        *fit = self.assign(fit.ends, bits, steps);
    }

    /// Tries again from ends that are pulled in or pushed out by these shares of the line.
    pub fn retry(&self, fit: &mut Fit, bits: u32, steps: &[f32], limits: &Limits, shares: &[[f32; 2]]) {
        let start: Line = fit.ends.map(|end| end.map(|code| unquantize(code, bits)));
        for [first, second] in shares {
            let mut line = start;
            for c in 0..3 {
                let span = start[1][c] - start[0][c];
                line[0][c] = (start[0][c] + first * span).clamp(0.0, TOP_LEVEL);
                line[1][c] = (start[1][c] + second * span).clamp(0.0, TOP_LEVEL);
            }
            let mut found = self.fit(&line, bits, steps, limits);
            self.descend(&mut found, bits, steps, limits);
            if found.error < fit.error {
                *fit = found;
            }
        }
    }

    /// Writes the indices of a fit to where the region's texels are in a block.
    pub fn place(&self, fit: &Fit, indices: &mut [u8; 16]) {
        for (texel, index) in self.texels[..self.count].iter().zip(fit.indices) {
            indices[usize::from(*texel)] = index;
        }
    }

    /// The ends of a channel, in levels, that lose least by weighted least squares.
    fn solve(&self, c: usize, indices: &[u8; 16], steps: &[f32]) -> [f32; 2] {
        // Relative to a texel's level, so that singles are precise enough.
        let (levels, weights) = (self.levels[c].as_flattened(), self.level_weights[c].as_flattened());
        let origin = levels[0];
        let (mut aa, mut ab, mut bb, mut ay, mut by) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for ((index, level), w) in indices.iter().zip(levels).zip(weights).take(self.count) {
            let b = steps[usize::from(*index)] / 64.0;
            let (a, y) = (1.0 - b, level - origin);
            aa += w * a * a;
            ab += w * a * b;
            bb += w * b * b;
            ay += w * a * y;
            by += w * b * y;
        }
        let determinant = aa * bb - ab * ab;
        let ends = if determinant > 1e-5 * (aa + bb) * (aa + bb) {
            [(ay * bb - by * ab) / determinant, (by * aa - ay * ab) / determinant]
        } else {
            // All texels at one step: both ends there.
            [(ay + by) / (aa + 2.0 * ab + bb); 2]
        };
        ends.map(|level| (level + origin).clamp(0.0, TOP_LEVEL))
    }

    /// Error and indices of a line, as if values were straight in levels.
    fn assign_levels(&self, line: &Line, steps: &[f32]) -> (f32, [u8; 16]) {
        let palette = |c: usize, step: f32| line[0][c] + (line[1][c] - line[0][c]) * (step / 64.0);
        nearest([&self.levels, &self.level_weights], self.octets, palette, steps, None)
    }

    /// Error and indices of a palette of values.
    fn assign_values(
        &self,
        palette: impl Fn(usize, f32) -> f32,
        steps: &[f32],
        anchor: Option<usize>,
    ) -> (f32, [u8; 16]) {
        nearest([&self.values, &self.weights], self.octets, palette, steps, anchor)
    }

    /// The best indices of these ends.
    fn assign(&self, ends: Ends, bits: u32, steps: &[f32]) -> Fit {
        let levels: Line = ends.map(|end| end.map(|code| unquantize(code, bits)));
        let palette = |c: usize, step: f32| value(levels[0][c], levels[1][c], step);
        let (error, indices) = self.assign_values(palette, steps, Some(self.anchor));
        Fit { error, ends, indices }
    }

    /// What a channel loses between two levels, with the texels at these steps.
    fn channel_error(&self, c: usize, [a, b]: [f32; 2], at: &Lanes) -> f32 {
        let mut sums = [0.0; OCTET];
        for o in 0..self.octets {
            let (values, weights, at) = (&self.values[c][o], &self.weights[c][o], &at[o]);
            for t in 0..OCTET {
                let error = value(a, b, at[t]) - values[t];
                sums[t] += error * error * weights[t];
            }
        }
        sums.iter().sum()
    }

    /// What the channels beside `c` lose at every step.
    fn errors_without(&self, c: usize, ends: &Ends, bits: u32, steps: &[f32]) -> [Lanes; 16] {
        let mut errors = [[[0.0; OCTET]; 2]; 16];
        for other in (0..3).filter(|other| *other != c) {
            let [a, b] = [unquantize(ends[0][other], bits), unquantize(ends[1][other], bits)];
            for (errors, step) in errors.iter_mut().zip(steps) {
                let entry = value(a, b, *step);
                for o in 0..self.octets {
                    let (values, weights, errors) = (&self.values[other][o], &self.weights[other][o], &mut errors[o]);
                    for t in 0..OCTET {
                        let error = entry - values[t];
                        errors[t] += error * error * weights[t];
                    }
                }
            }
        }
        errors
    }

    /// The error with the best indices, of a channel between two levels and of the others.
    fn error_with(&self, c: usize, [a, b]: [f32; 2], steps: &[f32], others: &[Lanes; 16]) -> f32 {
        let mut best = [[f32::MAX; OCTET]; 2];
        let mut of_anchor = 0.0;
        for (i, (others, step)) in others.iter().zip(steps).enumerate() {
            if i == steps.len() / 2 {
                of_anchor = best.as_flattened()[self.anchor];
            }
            let entry = value(a, b, *step);
            for o in 0..self.octets {
                let (values, weights, others, best) =
                    (&self.values[c][o], &self.weights[c][o], &others[o], &mut best[o]);
                for t in 0..OCTET {
                    let error = entry - values[t];
                    let sum = others[t] + error * error * weights[t];
                    best[t] = if sum < best[t] { sum } else { best[t] };
                }
            }
        }
        best.as_flattened_mut()[self.anchor] = of_anchor;
        best[..self.octets].as_flattened().iter().sum()
    }
}

/// A number for each lane.
fn lanes(of: impl Fn(usize) -> f32) -> Lanes {
    std::array::from_fn(|o| std::array::from_fn(|t| of(OCTET * o + t)))
}

fn dot(a: &Lanes, b: &Lanes) -> f32 {
    let products: [f32; OCTET] = std::array::from_fn(|t| a[0][t] * b[0][t] + a[1][t] * b[1][t]);
    products.iter().sum()
}

/// Sum over the lanes of the least weighted squares, and the steps where they are: of the lane `anchor` in the first half
/// of the steps.
#[inline(always)]
fn nearest(
    [points, weights]: [&[Lanes; 3]; 2],
    octets: usize,
    palette: impl Fn(usize, f32) -> f32,
    steps: &[f32],
    anchor: Option<usize>,
) -> (f32, [u8; 16]) {
    let (mut best, mut at) = ([[f32::MAX; OCTET]; 2], [[0_i32; OCTET]; 2]);
    let mut of_anchor = (0.0, 0);
    for (i, step) in steps.iter().enumerate() {
        if let Some(lane) = anchor.filter(|_| i == steps.len() / 2) {
            of_anchor = (best.as_flattened()[lane], at.as_flattened()[lane]);
        }
        let entry: [f32; 3] = std::array::from_fn(|c| palette(c, *step));
        for o in 0..octets {
            let [r, g, b]: [&[f32; OCTET]; 3] = std::array::from_fn(|c| &points[c][o]);
            let [r2, g2, b2]: [&[f32; OCTET]; 3] = std::array::from_fn(|c| &weights[c][o]);
            let (best, at) = (&mut best[o], &mut at[o]);
            for t in 0..OCTET {
                let (r, g, b) = (r[t] - entry[0], g[t] - entry[1], b[t] - entry[2]);
                let error = r * r * r2[t] + g * g * g2[t] + b * b * b2[t];
                let is_less = error < best[t];
                best[t] = if is_less { error } else { best[t] };
                at[t] = if is_less { i as i32 } else { at[t] };
            }
        }
    }
    if let Some(lane) = anchor {
        (best.as_flattened_mut()[lane], at.as_flattened_mut()[lane]) = of_anchor;
    }
    let mut indices = [0; 16];
    indices.iter_mut().zip(at.as_flattened()).for_each(|(to, from)| *to = *from as u8);
    (best[..octets].as_flattened().iter().sum(), indices)
}

/// The unit vector along which most of the variance lies, and how much, by power iteration; (0, 0, 0) where there is none.
fn principal_axis(covariance: &[[f32; 3]; 3]) -> ([f32; 3], f32) {
    let times = |v: [f32; 3]| covariance.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    let widest = (0..3).max_by(|&a, &b| covariance[a][a].total_cmp(&covariance[b][b])).expect("three channels");
    let (mut axis, mut along) = (covariance[widest], 0.0);
    for _ in 0..4 {
        let length = axis.iter().map(|x| x * x).sum::<f32>().sqrt();
        if length <= 0.0 {
            return ([0.0; 3], 0.0);
        }
        axis = axis.map(|x| x / length);
        let next = times(axis);
        along = axis.iter().zip(next).map(|(a, b)| a * b).sum();
        axis = next;
    }
    let length = axis.iter().map(|x| x * x).sum::<f32>().sqrt();
    (axis.map(|x| if length > 0.0 { x / length } else { 0.0 }), along)
}
