// SPDX-License-Identifier: MIT OR Apache-2.0
//! Charts over an angle, and lobes as polar plots.

use std::f64::consts::FRAC_PI_2;

use plotters::chart::{ChartBuilder, SeriesLabelPosition};
use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::element::{Circle, PathElement, Text};
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, IntoFont, IntoTextStyle, RGBColor, ShapeStyle, TextStyle, WHITE};

use super::canvas::{Canvas, Draw, FONT};
use super::curve::Curve;
use crate::error::{Error, Result, nearest};

/// Points of a curve a degree.
const POINTS_A_DEGREE: usize = 8;

/// Colours that readers with a colour deficiency tell apart: Okabe, Ito 2008.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// What a plot shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// D against the angle between normal and half vector.
    Distribution,
    /// G of the mirror direction against the angle of incidence.
    Geometry,
    /// F against the angle of incidence.
    Fresnel,
    /// f (n·l) in the plane of incidence against the angle of the light.
    Lobe,
    /// The same as a polar plot.
    Polar,
}

impl Kind {
    /// All kinds, in the order of their documentation.
    pub const ALL: [Kind; 5] = [Kind::Distribution, Kind::Geometry, Kind::Fresnel, Kind::Lobe, Kind::Polar];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Distribution => "d",
            Kind::Geometry => "g",
            Kind::Fresnel => "f",
            Kind::Lobe => "lobe",
            Kind::Polar => "polar",
        }
    }

    /// The kind with this name.
    pub fn parse(name: &str) -> Result<Kind> {
        let known = || Self::ALL.iter().map(|k| k.name());
        Self::ALL
            .into_iter()
            .find(|k| k.name() == name)
            .ok_or_else(|| Error::usage(format!("unknown plot '{name}'"), nearest(name, known())))
    }

    /// The curves that show what it is about, where none are asked for.
    pub fn examples(self) -> &'static [&'static str] {
        match self {
            Kind::Distribution => &["ggx", "beckmann", "blinn-phong", "charlie"],
            Kind::Geometry => &["smith", "smith-uncorrelated", "schlick-ggx", "cook-torrance", "neumann", "implicit"],
            Kind::Fresnel => &["copper", "aluminium", "iron", "diamond", "glass", "water"],
            Kind::Lobe | Kind::Polar => &["roughness=0.4", "roughness=0.5", "roughness=0.7"],
        }
    }

    fn axis(self, view_deg: f64) -> (String, &'static str) {
        match self {
            Kind::Distribution => ("angle between normal and half vector, degrees".into(), "D, per steradian"),
            Kind::Geometry => ("angle of incidence, degrees; light in the mirror direction".into(), "G"),
            Kind::Fresnel => ("angle of incidence, degrees".into(), "F"),
            Kind::Lobe | Kind::Polar => (
                format!("angle of the light in the plane of incidence, degrees; viewer at \u{2212}{view_deg}"),
                "f (n\u{b7}l), per steradian",
            ),
        }
    }
}

/// A plot to draw.
#[derive(Clone)]
pub struct Plot {
    /// What it shows.
    pub kind: Kind,
    /// Its curves.
    pub curves: Vec<Curve>,
    /// Angle between normal and viewer of lobes, from 0 to 89 degrees.
    pub view_deg: f64,
    /// Divide each curve by its largest value.
    pub relative: bool,
}

/// One line of a plot: a curve, or one channel of it.
struct Line {
    curve: usize,
    /// Red, green or blue of a coloured curve.
    channel: Option<usize>,
    /// Degrees and values.
    points: Vec<(f64, f64)>,
}

impl Plot {
    /// The file's bytes.
    pub fn draw(&self, canvas: Canvas) -> Result<Vec<u8>> {
        if !(0.0..=89.0).contains(&self.view_deg) {
            let what = format!("the viewer cannot stand at {} degrees", self.view_deg);
            return Err(Error::usage(what, "give an angle from 0 to 89"));
        }
        if self.curves.is_empty() {
            return Err(Error::usage("a plot needs a curve", "give --curve"));
        }
        canvas.paint(self)
    }

    /// The value of a curve at an angle in degrees.
    fn value(&self, curve: &Curve, angle_deg: f64) -> [f64; 3] {
        let theta = angle_deg.to_radians().min(FRAC_PI_2);
        let (sin, cos) = (theta.sin(), theta.cos().max(0.0));
        match self.kind {
            Kind::Distribution => [curve.brdf().d(theta); 3],
            // At the horizon itself G is a limit.
            Kind::Geometry => {
                let cos = cos.max(1e-6);
                [curve.brdf().g([sin, 0.0, cos], [-sin, 0.0, cos]); 3]
            }
            Kind::Fresnel => curve.f(cos),
            Kind::Lobe | Kind::Polar => {
                let (sin_v, cos_v) = self.view_deg.to_radians().sin_cos();
                let (l, v) = ([sin, 0.0, cos], [-sin_v, 0.0, cos_v]);
                let cos_d = ((1.0 + l[0] * v[0] + l[2] * v[2]) / 2.0).max(0.0).sqrt();
                let reflected = curve.brdf().reflected(l, v);
                curve.f(cos_d.min(1.0)).map(|f| f * reflected)
            }
        }
    }

    /// Every line of every curve.
    fn lines(&self) -> Vec<Line> {
        let from_deg = if matches!(self.kind, Kind::Lobe | Kind::Polar) { -90.0 } else { 0.0 };
        let count = (90.0 - from_deg) as usize * POINTS_A_DEGREE;
        let angle = |i: usize| from_deg + (90.0 - from_deg) * i as f64 / count as f64;
        let shows_f = !matches!(self.kind, Kind::Distribution | Kind::Geometry);
        let mut lines = vec![];
        for (curve, of) in self.curves.iter().enumerate() {
            let values: Vec<(f64, [f64; 3])> = (0..=count).map(|i| (angle(i), self.value(of, angle(i)))).collect();
            let channels = if shows_f && of.is_coloured() { vec![Some(0), Some(1), Some(2)] } else { vec![None] };
            let most = values.iter().flat_map(|(_, v)| v).fold(0.0, |a: f64, b| a.max(*b));
            let divisor = if self.relative && most > 0.0 { most } else { 1.0 };
            for channel in channels {
                let points = values.iter().map(|(x, v)| (*x, v[channel.unwrap_or(0)] / divisor)).collect();
                lines.push(Line { curve, channel, points });
            }
        }
        lines
    }

    /// The least round number that no value exceeds by much.
    fn top(&self, lines: &[Line]) -> f64 {
        let most = lines.iter().flat_map(|l| &l.points).fold(0.0, |a: f64, p| a.max(p.1));
        if most > 0.0 { 1.05 * most } else { 1.0 }
    }
}

fn colour(curve: usize) -> RGBColor {
    COLOURS[curve % COLOURS.len()]
}

/// A font of some pixels of the picture.
fn font(pixels: f64, scale: f64) -> TextStyle<'static> {
    (FONT, pixels * scale).into_font().into_text_style(&(1, 1)).color(&RGBColor(40, 40, 40))
}

fn stroke(curve: usize, scale: f64) -> ShapeStyle {
    colour(curve).stroke_width((1.8 * scale).round() as u32)
}

/// Length of dash and gap of green and blue, in pixels; red is solid.
fn dashes(channel: usize) -> (f64, f64) {
    if channel == 1 { (9.0, 4.0) } else { (2.0, 3.0) }
}

impl Draw for Plot {
    fn draw<B: plotters::backend::DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        scale: f64,
    ) -> std::result::Result<(), String> {
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        let lines = self.lines();
        if self.kind == Kind::Polar { polar(self, &lines, area, scale) } else { chart(self, &lines, area, scale) }
            .map_err(|e| e.to_string())
    }
}

type Drawn<B> = std::result::Result<
    (),
    plotters::drawing::DrawingAreaErrorKind<<B as plotters::backend::DrawingBackend>::ErrorType>,
>;

/// Angle to the right, value upwards.
fn chart<B: plotters::backend::DrawingBackend>(
    plot: &Plot,
    lines: &[Line],
    area: &DrawingArea<B, Shift>,
    scale: f64,
) -> Drawn<B> {
    let px = |pixels: f64| (pixels * scale).round() as i32;
    let from = lines[0].points[0].0;
    let top = if plot.kind == Kind::Fresnel { 1.0 } else { plot.top(lines) };
    let (x_name, y_name) = plot.kind.axis(plot.view_deg);
    let y_name = if plot.relative { format!("{y_name} over its largest") } else { y_name.to_string() };
    let y_name = y_name.replace(", per steradian over", " over");
    let mut chart = ChartBuilder::on(area)
        .margin(px(14.0))
        .x_label_area_size(px(42.0))
        .y_label_area_size(px(58.0))
        .build_cartesian_2d(from..90.0, 0.0..top)?;
    chart
        .configure_mesh()
        .x_desc(x_name)
        .y_desc(y_name)
        .x_labels(if from < 0.0 { 13 } else { 10 })
        .y_labels(8)
        .max_light_lines(1)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .label_style(font(12.0, scale))
        .axis_desc_style(font(13.0, scale))
        .axis_style(RGBColor(90, 90, 90).stroke_width(px(1.0) as u32))
        .bold_line_style(RGBColor(222, 222, 222).stroke_width(px(1.0) as u32))
        .light_line_style(RGBColor(242, 242, 242).stroke_width(px(1.0) as u32))
        .set_all_tick_mark_size(px(4.0))
        .draw()?;
    for line in lines {
        let style = stroke(line.curve, scale);
        let points = line.points.iter().copied();
        let labelled = line.channel.unwrap_or(0) == 0;
        let series = match line.channel {
            None | Some(0) => chart.draw_series(LineSeries::new(points, style))?,
            Some(channel) => {
                let (dash, gap) = dashes(channel);
                chart.draw_series(DashedLineSeries::new(points, px(dash), px(gap), style))?
            }
        };
        if labelled {
            let label = plot.curves[line.curve].label.clone();
            series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + (18.0 * scale) as i32, y)], style));
        }
    }
    let position = match plot.kind {
        // Between the metals and diamond.
        Kind::Fresnel => {
            SeriesLabelPosition::Coordinate(px(14.0), (0.5 * f64::from(area.dim_in_pixel().1)) as i32 - px(28.0))
        }
        Kind::Geometry => SeriesLabelPosition::LowerLeft,
        Kind::Lobe => SeriesLabelPosition::UpperLeft,
        _ => SeriesLabelPosition::UpperRight,
    };
    chart
        .configure_series_labels()
        .position(position)
        .margin(px(12.0))
        .legend_area_size(px(26.0))
        .label_font(font(13.0, scale))
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200).stroke_width(px(1.0) as u32))
        .draw()?;
    channels_note(lines, area, scale)
}

/// Says what dashes mean where they occur, at the bottom right.
fn channels_note<B: plotters::backend::DrawingBackend>(
    lines: &[Line],
    area: &DrawingArea<B, Shift>,
    scale: f64,
) -> Drawn<B> {
    if lines.iter().all(|line| line.channel.is_none()) {
        return Ok(());
    }
    let (width, height) = area.dim_in_pixel();
    let style = font(11.0, scale).pos(Pos::new(HPos::Right, VPos::Bottom));
    let at = (width as i32 - (14.0 * scale) as i32, height as i32 - (6.0 * scale) as i32);
    area.draw(&Text::new("metals: red solid, green dashed, blue dotted", at, style))
}

/// The normal upwards, length along a direction is the value there.
fn polar<B: plotters::backend::DrawingBackend>(
    plot: &Plot,
    lines: &[Line],
    area: &DrawingArea<B, Shift>,
    scale: f64,
) -> Drawn<B> {
    let px = |pixels: f64| (pixels * scale).round() as i32;
    let (width, height) = area.dim_in_pixel();
    let (width, height) = (f64::from(width), f64::from(height));
    let radius = (0.5 * width - 40.0 * scale).min(height - 74.0 * scale);
    let origin = (0.5 * width, height - 44.0 * scale);
    let at = |angle_deg: f64, length: f64| {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        ((origin.0 + radius * length * sin).round() as i32, (origin.1 - radius * length * cos).round() as i32)
    };
    let grid = RGBColor(216, 216, 216).stroke_width(px(1.0) as u32);
    let top = plot.top(lines);
    // Rings of a round value.
    let step = round_step(top / 4.0);
    for ring in 1..=(top / step) as usize {
        let length = ring as f64 * step / top;
        let arc: Vec<(i32, i32)> = (-90..=90).map(|deg| at(f64::from(deg), length)).collect();
        area.draw(&PathElement::new(arc, grid))?;
        let style = font(11.0, scale).pos(Pos::new(HPos::Center, VPos::Top));
        let (x, y) = at(90.0, length);
        area.draw(&Text::new(short(ring as f64 * step), (x, y + px(5.0)), style))?;
    }
    for ray in -3i32..=3 {
        let angle_deg = 30.0 * f64::from(ray);
        area.draw(&PathElement::new(vec![at(angle_deg, 0.0), at(angle_deg, 1.0)], grid))?;
        if ray.abs() < 3 {
            let style = font(11.0, scale).pos(Pos::new(HPos::Center, VPos::Bottom));
            let (x, y) = at(angle_deg, 1.01);
            area.draw(&Text::new(format!("{angle_deg:.0}\u{b0}"), (x, y), style))?;
        }
    }
    // The viewer, and where a mirror would send the light.
    let view = BLACK.stroke_width(px(1.2) as u32);
    area.draw(&PathElement::new(vec![at(-plot.view_deg, 0.0), at(-plot.view_deg, 0.93)], view))?;
    area.draw(&Circle::new(at(-plot.view_deg, 0.93), px(3.0), BLACK.filled()))?;
    let style = font(12.0, scale).pos(Pos::new(HPos::Right, VPos::Center));
    let (x, y) = at(-plot.view_deg, 0.93);
    area.draw(&Text::new("viewer", (x - px(8.0), y), style))?;
    for part in 0..24 {
        let ends = vec![at(plot.view_deg, f64::from(part) / 24.0), at(plot.view_deg, (f64::from(part) + 0.5) / 24.0)];
        area.draw(&PathElement::new(ends, RGBColor(120, 120, 120).stroke_width(px(1.0) as u32)))?;
    }
    for line in lines {
        let points: Vec<(i32, i32)> = line.points.iter().map(|(x, value)| at(*x, value / top)).collect();
        let style = stroke(line.curve, scale);
        match line.channel {
            None | Some(0) => area.draw(&PathElement::new(points, style))?,
            Some(channel) => {
                let (dash, gap) = dashes(channel);
                let pieces = plotters::element::DashedPathElement::new(points, px(dash), px(gap), style);
                area.draw(&pieces)?;
            }
        }
    }
    for (i, curve) in plot.curves.iter().enumerate() {
        let y = px(22.0 + 18.0 * i as f64);
        area.draw(&PathElement::new(vec![(px(16.0), y), (px(36.0), y)], stroke(i, scale)))?;
        let style = font(13.0, scale).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(curve.label.clone(), (px(44.0), y), style))?;
    }
    let unit = if plot.relative { "f (n\u{b7}l) over its largest" } else { "f (n\u{b7}l), per steradian" };
    let style = font(12.0, scale).pos(Pos::new(HPos::Center, VPos::Bottom));
    area.draw(&Text::new(unit, (origin.0 as i32, height as i32 - px(6.0)), style))?;
    channels_note(lines, area, scale)
}

/// 1, 2 or 5 times a power of ten, not below `least`.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|f| f * power).find(|s| *s >= least).unwrap_or(10.0 * power)
}

/// A number without trailing noise.
fn short(value: f64) -> String {
    if value >= 100.0 { format!("{value:.0}") } else { format!("{}", (value * 1e4).round() / 1e4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(kind: Kind, curves: &[&str]) -> Plot {
        let curves = curves.iter().map(|c| Curve::parse(c).expect("valid")).collect();
        Plot { kind, curves, view_deg: 45.0, relative: false }
    }

    #[test]
    fn every_kind_draws_its_examples() {
        for kind in Kind::ALL {
            assert_eq!(Kind::parse(kind.name()).expect("its own name"), kind);
            let plot = plot(kind, kind.examples());
            let svg = plot.draw(Canvas { width: 640, height: 400, vector: true }).expect("drawn");
            let svg = String::from_utf8(svg).expect("UTF-8");
            for label in kind.examples() {
                assert!(svg.contains(label), "{}: '{label}' is not in the legend", kind.name());
            }
            let png = plot.draw(Canvas { width: 320, height: 200, vector: false }).expect("drawn");
            assert!(png.starts_with(b"\x89PNG"));
        }
    }

    #[test]
    fn lobes_peak_near_the_mirror_direction() {
        let plot = plot(Kind::Lobe, &["ggx alpha=0.01"]);
        let lines = plot.lines();
        let peak = lines[0].points.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("points");
        assert!((peak.0 - 45.0).abs() < 1.0, "{peak:?}");
    }

    #[test]
    fn fresnel_curves_have_their_known_ends() {
        for line in plot(Kind::Fresnel, Kind::Fresnel.examples()).lines() {
            let (first, last) = (line.points[0], line.points[line.points.len() - 1]);
            assert_eq!((first.0, last.0), (0.0, 90.0));
            assert!((last.1 - 1.0).abs() < 1e-3, "all light is reflected at 90 degrees: {last:?}");
            let expected = match (line.curve, line.channel) {
                (0, Some(0)) => 0.955,
                (0, Some(2)) => 0.538,
                (3, None) => 0.172,
                (5, None) => 0.0204,
                _ => continue,
            };
            assert!((first.1 - expected).abs() < 3e-3, "{first:?} {expected}");
        }
    }

    #[test]
    fn relative_curves_reach_1() {
        let plot = Plot {
            relative: true,
            ..plot(Kind::Distribution, &["beckmann alpha=0.748", "blinn-phong:exponent=10.67"])
        };
        for line in plot.lines() {
            let most = line.points.iter().fold(0.0, |a: f64, p| a.max(p.1));
            assert!((most - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn steps_are_round() {
        assert_eq!([0.013, 0.26, 1.0, 7.0].map(round_step), [0.02, 0.5, 1.0, 10.0]);
    }
}
