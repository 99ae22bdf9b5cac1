// SPDX-License-Identifier: MIT OR Apache-2.0
//! A table in false colour: a panel a channel, with its axes and a scale.

use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::element::{PathElement, Rectangle, Text};
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, IntoFont, IntoTextStyle, RGBColor, TextStyle, WHITE};

use super::canvas::{Canvas, Draw, FONT};
use crate::error::{Error, Result};
use crate::texture::{Shape, Texture};

/// Most cells along a side of a panel: an SVG holds a rectangle for each.
const MOST_CELLS: u32 = 128;

/// The picture of a table: its first row on top, as it lies in the file.
pub fn draw_table(texture: &Texture, canvas: Canvas) -> Result<Vec<u8>> {
    if texture.shape != Shape::Table {
        let (what, help) = match texture.shape {
            Shape::Volume { .. } => ("a table over three axes is no picture", "bake a slice of it, with --ior"),
            Shape::Array { .. } => ("several tables are no picture", "bake one of them"),
            Shape::Table | Shape::Map | Shape::Cube => (
                "only tables are drawn in false colour, and this file holds an environment",
                "see `brdf-baker preview --env` and `brdf-baker verify --report`",
            ),
        };
        return Err(Error::usage(what, help));
    }
    canvas.paint(&Panels(texture))
}

struct Panels<'a>(&'a Texture);

impl Panels<'_> {
    /// Least and largest value of a channel.
    fn range(&self, channel: usize) -> (f32, f32) {
        let values = self.0.levels[0].iter().skip(channel).step_by(self.0.channels.len());
        values.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(*v), high.max(*v)))
    }

    /// What runs along x and y, with the values at both ends, as far as the file says.
    fn axes(&self) -> [(String, [&'static str; 2]); 2] {
        let meta = &self.0.meta;
        let names: Vec<&str> = meta.get("axes").unwrap_or("x,y").split(',').collect();
        let orders: Vec<&str> = meta.get("order").unwrap_or("").split(',').collect();
        std::array::from_fn(|i| {
            let name = names.get(i).map_or(String::new(), |n| n.replace("n_dot_v", "n\u{b7}v"));
            let known = meta.get("axes").is_some() && !name.is_empty();
            let ends = match orders.get(i) {
                _ if !known => ["", ""],
                Some(&"descending") => ["1", "0"],
                _ => ["0", "1"],
            };
            (name, ends)
        })
    }
}

fn font(pixels: f64, scale: f64, h: HPos, v: VPos) -> TextStyle<'static> {
    let style = (FONT, pixels * scale).into_font().into_text_style(&(1, 1));
    style.color(&RGBColor(40, 40, 40)).pos(Pos::new(h, v))
}

impl Draw for Panels<'_> {
    fn draw<B: plotters::backend::DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        scale: f64,
    ) -> std::result::Result<(), String> {
        self.panels(area, scale).map_err(|e| e.to_string())
    }
}

impl Panels<'_> {
    fn panels<B: plotters::backend::DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        scale: f64,
    ) -> std::result::Result<(), plotters::drawing::DrawingAreaErrorKind<B::ErrorType>> {
        let texture = self.0;
        let px = |pixels: f64| (pixels * scale).round() as i32;
        area.fill(&WHITE)?;
        let (width, height) = area.dim_in_pixel();
        let count = texture.channels.len() as i32;
        let panel = width as i32 / count;
        let side = (panel - px(118.0)).min(height as i32 - px(76.0)).max(px(20.0));
        let [(x_name, x_ends), (y_name, y_ends)] = self.axes();
        let cells = (texture.width.min(MOST_CELLS), texture.height.min(MOST_CELLS));
        for (c, name) in texture.channels.iter().enumerate() {
            let (left, top) = (c as i32 * panel + px(44.0), px(34.0));
            let (low, high) = self.range(c);
            let colour = |value: f32| {
                let t = if high > low { (value - low) / (high - low) } else { 0.0 };
                ViridisRGB.get_color(t)
            };
            let line = |i: u32, n: u32| (f64::from(side) * f64::from(i) / f64::from(n)).round() as i32;
            for y in 0..cells.1 {
                for x in 0..cells.0 {
                    let at = |i: u32, cells: u32, size: u32| ((i * 2 + 1) * size / (2 * cells)).min(size - 1);
                    let texel = texture.texel(0, 0, at(x, cells.0, texture.width), at(y, cells.1, texture.height));
                    let from = (left + line(x, cells.0), top + line(y, cells.1));
                    let to = (left + line(x + 1, cells.0), top + line(y + 1, cells.1));
                    area.draw(&Rectangle::new([from, to], colour(texel[c]).filled()))?;
                }
            }
            // Axes.
            let text = |text: String, x: i32, y: i32, h: HPos, v: VPos| {
                area.draw(&Text::new(text, (x, y), font(12.0, scale, h, v)))
            };
            area.draw(&Text::new(name.clone(), (left, px(10.0)), font(15.0, scale, HPos::Left, VPos::Top)))?;
            let below = top + side + px(6.0);
            text(x_ends[0].into(), left, below, HPos::Left, VPos::Top)?;
            text(x_ends[1].into(), left + side, below, HPos::Right, VPos::Top)?;
            text(x_name.clone(), left + side / 2, below, HPos::Center, VPos::Top)?;
            text(y_ends[0].into(), left - px(5.0), top, HPos::Right, VPos::Top)?;
            text(y_ends[1].into(), left - px(5.0), top + side, HPos::Right, VPos::Bottom)?;
            let turned =
                font(12.0, scale, HPos::Center, VPos::Bottom).transform(plotters::style::FontTransform::Rotate270);
            area.draw(&Text::new(y_name.clone(), (left - px(18.0), top + side / 2), turned))?;
            // The scale.
            let bar = left + side + px(12.0);
            for i in 0..64u32 {
                let value = high + (low - high) * (i as f32 + 0.5) / 64.0;
                let (from, to) = (top + line(i, 64), top + line(i + 1, 64));
                area.draw(&Rectangle::new([(bar, from), (bar + px(12.0), to)], colour(value).filled()))?;
            }
            for i in 0..5 {
                let value = high + (low - high) * i as f32 / 4.0;
                let y = top + side * i / 4;
                let grey = RGBColor(90, 90, 90).stroke_width(px(1.0) as u32);
                area.draw(&PathElement::new([(bar + px(12.0), y), (bar + px(15.0), y)], grey))?;
                text(format!("{value:.3}"), bar + px(18.0), y, HPos::Left, VPos::Center)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::{Backend, TableRequest};
    use crate::progress::ignore;

    #[test]
    fn panels_name_channels_axes_and_range() {
        let job = TableRequest { size: (12, 8), ..TableRequest::new("split-sum") }.resolve().expect("valid");
        let table = job.run(&Backend::Cpu, &mut ignore).expect("baked");
        let svg = draw_table(&table, Canvas { width: 800, height: 400, vector: true }).expect("drawn");
        let svg = String::from_utf8(svg).expect("UTF-8");
        for word in ["scale", "bias", "n\u{b7}v", "roughness"] {
            assert!(svg.contains(word), "{word}");
        }
        // 2 × 96 cells, 2 × 64 steps of the scales, the background.
        assert_eq!(svg.matches("<rect").count(), 2 * (96 + 64) + 1);
        assert!(draw_table(&table, Canvas { width: 10, height: 10, vector: true }).is_err());
    }
}
