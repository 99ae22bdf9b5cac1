// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables by expansion: the rule at Chebyshev points in f64 on the processor, the series at every texel on the device.

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use super::grid::BAND_BYTES;
use super::slices::next_slice;
use super::{At, Backend, MAX_CHANNELS, Table, TableJob, Values};
use crate::axis::Coordinate;
use crate::error::{Error, Result, nearest};
use crate::gpu::{Buffer, Gpu, Kernel, MAX_GROUPS};
use crate::progress::{OnProgress, tick};
use crate::rule::expansion::{Domain, Expansion, TERMS, sum};
use crate::shaders;

/// How the texels of a table are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RuleChoice {
    /// By the table's rule at every texel.
    #[default]
    Direct,
    /// By a Chebyshev expansion of the rule with so many terms along n·v and roughness; `None` for as few of
    /// [`TERMS`] as suffice. Refused where none do.
    Expansion(Option<[usize; 2]>),
    /// By expansion where that is cheaper and accurate, else directly.
    Auto,
}

/// What the name of an expanded table's rule begins with.
const PREFIX: &str = "Chebyshev expansion ";
/// The tail of the series, and its error at [`PROBES`] points, are at most this share of the table's bound; the rule and
/// single floats take the rest.
const SHARE: f64 = 0.2;
const PROBES: u32 = 128;
/// Smaller tables cost less by the rule itself.
const FEWEST_TEXELS: usize = 1 << 14;
/// Points between two looks at the listener.
const BATCH: usize = 256;
/// Invocations a workgroup and texels an invocation, as in `shaders/bake/expansion.comp`.
const WORKGROUP: u32 = 64;
const POINTS: u32 = 8;
/// The first slice also compiles the shader, so it is small.
const FIRST_SLICE: u32 = 1024;

impl RuleChoice {
    /// The choice with this name.
    pub fn parse(name: &str) -> Result<RuleChoice> {
        match name {
            "direct" => Ok(RuleChoice::Direct),
            "expansion" => Ok(RuleChoice::Expansion(None)),
            "auto" => Ok(RuleChoice::Auto),
            _ => Err(Error::usage(format!("unknown rule '{name}'"), nearest(name, ["direct", "expansion", "auto"]))),
        }
    }

    /// The choice behind the name of a rule that a file states.
    pub fn of_name(rule: &str) -> RuleChoice {
        let terms = rule.strip_prefix(PREFIX).and_then(|rest| {
            let (n, m) = rest.split_once(' ')?.0.split_once('x')?;
            Some([n.parse().ok()?, m.parse().ok()?])
        });
        terms.map_or(RuleChoice::Direct, |terms| RuleChoice::Expansion(Some(terms)))
    }

    /// The name of a rule that is used in this way.
    pub fn name(self, rule: &str) -> String {
        match self {
            RuleChoice::Expansion(Some([n, m])) => format!("{PREFIX}{n}x{m} of {rule}"),
            _ => rule.into(),
        }
    }

    /// Refuses a table that has no expansion, of these axes.
    pub(super) fn check(self, table: &dyn Table, axes: &[Coordinate]) -> Result<()> {
        match self {
            RuleChoice::Expansion(_) if !expandable(table, axes) => Err(Error::usage(
                format!("{} is not expanded: it takes quadrature over n.v and roughness", table.facts().name),
                "drop --rule",
            )),
            _ => Ok(()),
        }
    }
}

/// Is a table of these axes a quadrature over n·v and roughness, as an expansion needs?
fn expandable(table: &dyn Table, axes: &[Coordinate]) -> bool {
    axes.len() == 2
        && [Coordinate::NDotV, Coordinate::Roughness].iter().all(|axis| axes.contains(axis))
        && !table.usual().on_processor
}

/// How far an expansion is off the rule that it goes through.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExpansionError {
    /// [`Expansion::tail`] of the values in use.
    pub tail: f64,
    /// Largest difference at points between those of the expansion.
    pub measured: f64,
}

/// What a table was computed by in the end.
pub(super) struct Settled {
    /// Direct, or an expansion with its terms.
    pub rule: RuleChoice,
    /// Of an expansion: how far it is off the rule.
    pub error: Option<ExpansionError>,
    /// Why an expansion was not used where one was allowed.
    pub note: Option<String>,
}

impl Settled {
    /// By the table's rule, as a user chose.
    pub const DIRECT: Settled = Settled { rule: RuleChoice::Direct, error: None, note: None };
}

/// A table's texels, and what they were computed by.
type Baked = (Vec<f32>, Settled);

/// [`MAX_CHANNELS`] values for every roughness (rows) and every n·v (columns), as the job's rule is chosen.
pub(super) fn bake(
    job: &TableJob,
    n_dot_v: &[f64],
    roughness: &[f64],
    backend: &Backend,
    on: &mut OnProgress<'_>,
) -> Result<Baked> {
    let direct = |note: Option<String>, on: &mut OnProgress<'_>| {
        let texels = job.table.bake(&job.model, n_dot_v, roughness, backend, on)?;
        Ok((texels, Settled { note, ..Settled::DIRECT }))
    };
    let auto = job.rule == RuleChoice::Auto;
    let axes: Vec<Coordinate> = job.axes.iter().map(|axis| axis.warp.coordinate()).collect();
    let small = n_dot_v.len() * roughness.len() < FEWEST_TEXELS;
    if job.rule == RuleChoice::Direct || auto && (!expandable(job.table, &axes) || small) {
        let why = if small { "the table is small" } else { "the table is not expanded" };
        return direct(auto.then(|| format!("direct: {why}")), on);
    }
    let tried: &[[usize; 2]] = match &job.rule {
        RuleChoice::Expansion(Some(terms)) => std::slice::from_ref(terms),
        _ => &TERMS,
    };
    let bound = SHARE * job.model.tolerance(&job.table.facts().tolerance).worst;
    match Expanded::new(job, n_dot_v, roughness, tried, bound, on)? {
        Ok(expanded) => {
            let settled = RuleChoice::Expansion(Some(expanded.expansion.terms));
            let texels = expanded.texels(job, n_dot_v, roughness, backend, on)?;
            Ok((texels, Settled { rule: settled, error: Some(expanded.error), note: None }))
        }
        Err(why) if auto => direct(Some(format!("direct: {why}")), on),
        Err(why) => Err(Error::usage(
            format!("{} of {} is not expanded: {why}", job.table.facts().name, job.model.ndf),
            "use --rule direct, or auto, which chooses",
        )),
    }
}

/// An expansion that keeps its bound.
struct Expanded {
    expansion: Expansion,
    domains: [Domain; 2],
    error: ExpansionError,
}

impl Expanded {
    /// The first of the `tried` numbers of terms that keeps `bound`; otherwise why none does.
    fn new(
        job: &TableJob,
        n_dot_v: &[f64],
        roughness: &[f64],
        tried: &[[usize; 2]],
        bound: f64,
        on: &mut OnProgress<'_>,
    ) -> Result<Result<Expanded, String>> {
        let (Some(x), Some(y)) = (domain(n_dot_v), domain(roughness)) else {
            return Ok(Err("an axis of it has a single coordinate above 0".into()));
        };
        let chosen: Vec<usize> = job.channels.iter().filter_map(|source| source.value()).collect();
        // As crowded at the ends as the points are.
        let probes: Vec<At> = (0..PROBES)
            .map(|i| {
                // The additive recurrence of the plastic number (Roberts 2018): even in two dimensions.
                let even = |step: f64| 0.5 * (1.0 + (PI * (0.5 + f64::from(i) * step).fract()).cos());
                At { n_dot_v: x.at(even(0.754_877_666_246_693)), roughness: y.at(even(0.569_840_290_998_053)) }
            })
            .collect();
        let expected = rule_at(job, &probes, on)?;
        let mut least = f64::INFINITY;
        for terms in tried {
            let [xs, ys] = [x.points(terms[0]), y.points(terms[1])];
            let points: Vec<At> =
                xs.iter().flat_map(|x| ys.iter().map(|y| At { n_dot_v: *x, roughness: *y })).collect();
            let expansion = Expansion::through(&rule_at(job, &points, on)?, *terms);
            let differ = |(at, expected): (&At, &Values)| {
                let found = expansion.at(x.position(at.n_dot_v), y.position(at.roughness));
                chosen.iter().map(|c| (found[*c] - expected[*c]).abs()).fold(0.0, worse)
            };
            let measured = probes.iter().zip(&expected).map(differ).fold(0.0, worse);
            let error = ExpansionError { tail: expansion.tail(&chosen), measured };
            if worse(error.tail, measured) <= bound {
                return Ok(Ok(Expanded { expansion, domains: [x, y], error }));
            }
            least = least.min(worse(error.tail, measured));
        }
        Ok(Err(format!("the coefficients of its expansion end at {least:.1e}, and {bound:.1e} is wanted")))
    }

    /// The series at every texel; the limits at 0, where a logarithm ends, by the rule.
    fn texels(
        &self,
        job: &TableJob,
        n_dot_v: &[f64],
        roughness: &[f64],
        backend: &Backend,
        on: &mut OnProgress<'_>,
    ) -> Result<Vec<f32>> {
        // A coordinate of 0 gets any position: its texels are replaced below.
        let positions = |list: &[f64], domain: &Domain| -> Vec<f64> {
            list.iter().map(|x| domain.position(x.max(domain.low)).clamp(-1.0, 1.0)).collect()
        };
        let (x, y) = (positions(n_dot_v, &self.domains[0]), positions(roughness, &self.domains[1]));
        let mut texels = match backend {
            Backend::Cpu => self.on_cpu(&x, &y, on)?,
            Backend::Gpu(gpu) => self.on_gpu(gpu, &x, &y, on)?,
        };
        texels.par_chunks_exact_mut(MAX_CHANNELS).enumerate().for_each(|(i, texel)| {
            let at = At { n_dot_v: n_dot_v[i % n_dot_v.len()], roughness: roughness[i / n_dot_v.len()] };
            if at.n_dot_v == 0.0 || at.roughness == 0.0 {
                texel.iter_mut().zip(job.table.rule(&job.model, at)).for_each(|(t, v)| *t = v as f32);
            }
        });
        Ok(texels)
    }

    fn on_cpu(&self, x: &[f64], y: &[f64], on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
        let mut texels = Vec::with_capacity(x.len() * y.len() * MAX_CHANNELS);
        for (i, rows) in y.chunks(BATCH).enumerate() {
            tick(on, "expansion", (i * BATCH) as f64 / y.len() as f64)?;
            texels.par_extend(rows.par_iter().flat_map_iter(|y| {
                let row = self.expansion.row(*y);
                x.iter().flat_map(move |x| sum(&row, *x).map(|v| v as f32))
            }));
        }
        tick(on, "expansion", 1.0)?;
        Ok(texels)
    }

    fn on_gpu(&self, gpu: &Gpu, x: &[f64], y: &[f64], on: &mut OnProgress<'_>) -> Result<Vec<f32>> {
        let name = "bake/expansion";
        let kernel = gpu.kept_kernel(name, &shaders::spirv(name), 3, size_of::<Push>() as u32)?;
        let mut passes = Passes { gpu, kernel, slice: FIRST_SLICE };
        let [n, m] = self.expansion.terms.map(|terms| terms as u32);
        let single = |list: &[f64]| list.iter().map(|v| *v as f32).collect::<Vec<f32>>();
        let coefficients: Vec<[f32; MAX_CHANNELS]> =
            self.expansion.coefficients.iter().map(|c| c.map(|c| c as f32)).collect();
        let coefficients = gpu.upload("coefficients", &coefficients)?;
        let columns = gpu.upload("positions along n_dot_v", &single(x))?;
        let texel_bytes = size_of::<[f32; MAX_CHANNELS]>() as u64;
        let band_rows = (BAND_BYTES / (x.len() as u64 * texel_bytes)).max(1) as usize;
        let mut texels = Vec::with_capacity(x.len() * y.len() * MAX_CHANNELS);
        for (i, band) in y.chunks(band_rows).enumerate() {
            let done = (i * band_rows) as f64 / y.len() as f64;
            let rows = gpu.upload("positions along roughness", &single(band))?;
            let along_rows = gpu.buffer("series along n_dot_v", u64::from(n) * band.len() as u64 * texel_bytes)?;
            let result = gpu.buffer("result", x.len() as u64 * band.len() as u64 * texel_bytes)?;
            let (count, terms) = (band.len() as u32, m);
            // One series a coefficient of n·v, at each row; then one a row, at each column.
            let first = Push { points: count, terms, series_step: m, term_step: 1, ..Push::default() };
            passes.run([&rows, &coefficients, &along_rows], first, n, done, on)?;
            let second = Push { points: x.len() as u32, terms: n, series_step: 1, term_step: count, ..Push::default() };
            passes.run([&columns, &along_rows, &result], second, count, done, on)?;
            texels.extend(gpu.read::<f32>(&result)?);
        }
        tick(on, "expansion", 1.0)?;
        Ok(texels)
    }
}

/// The push block of `shaders/bake/expansion.comp`.
#[repr(C)]
#[derive(Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    first: u32,
    count: u32,
    points: u32,
    terms: u32,
    series_step: u32,
    term_step: u32,
}

/// The kernel, and how much of it runs at once.
struct Passes<'a> {
    gpu: &'a Gpu,
    kernel: Arc<Kernel>,
    slice: u32,
}

impl Passes<'_> {
    /// Sums so many series at all points, in slices.
    fn run(
        &mut self,
        buffers: [&Buffer; 3],
        push: Push,
        series: u32,
        done: f64,
        on: &mut OnProgress<'_>,
    ) -> Result<()> {
        let invocations = series * push.points.div_ceil(POINTS);
        let mut first = 0;
        while first < invocations {
            tick(on, "expansion", done)?;
            let count = self.slice.min(invocations - first).min(MAX_GROUPS * WORKGROUP);
            let start = Instant::now();
            let push = Push { first, count, ..push };
            self.gpu.dispatch(&self.kernel, &buffers, &push, [count.div_ceil(WORKGROUP), 1, 1])?;
            self.slice = next_slice(count, start.elapsed(), WORKGROUP);
            first += count;
        }
        Ok(())
    }
}

/// The table's rule at some places, in parallel.
fn rule_at(job: &TableJob, places: &[At], on: &mut OnProgress<'_>) -> Result<Vec<Values>> {
    let mut values = Vec::with_capacity(places.len());
    for batch in places.chunks(BATCH) {
        tick(on, "expansion: points", values.len() as f64 / places.len() as f64)?;
        values.par_extend(batch.par_iter().map(|at| job.table.rule(&job.model, *at)));
    }
    Ok(values)
}

/// The greater one; NaN is the greatest.
fn worse(a: f64, b: f64) -> f64 {
    if a.total_cmp(&b).is_ge() { a } else { b }
}

/// The range of the coordinates above 0; `None` where they are all the same.
fn domain(coordinates: &[f64]) -> Option<Domain> {
    let positive = || coordinates.iter().copied().filter(|x| *x > 0.0);
    let (low, high) = (positive().fold(f64::INFINITY, f64::min), positive().fold(0.0, f64::max));
    (high > low).then_some(Domain { low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choice_is_read_from_the_name_of_a_rule() {
        let chosen = RuleChoice::Expansion(Some([32, 64]));
        assert_eq!(RuleChoice::of_name(&chosen.name("cone 9x36, 324 nodes")), chosen);
        for direct in ["cone 9x36, 324 nodes", "", "Chebyshev expansion", "Chebyshev expansion 3x of"] {
            assert_eq!(RuleChoice::of_name(direct), RuleChoice::Direct);
        }
        assert!(RuleChoice::parse("expand").unwrap_err().help().contains("expansion"));
    }
}
