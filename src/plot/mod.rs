// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plots: D, G, F and whole lobes against the angle, and tables in false colour, as SVG or PNG.
//!
//! Nothing but this crate is needed to draw them: DejaVu Sans (Bitstream Vera licence) is built in for what is laid out and
//! for the text of PNGs. An SVG names the viewer's own sans-serif font.
//!
//! ```
//! use brdf_baker::plot::{Canvas, Curve, Kind, Plot};
//!
//! let curves = ["beckmann alpha=0.748", "blinn-phong:exponent=10.67"].map(Curve::parse).into_iter().collect::<Result<_, _>>()?;
//! let plot = Plot { kind: Kind::Distribution, curves, view_deg: 45.0, relative: true };
//! assert!(plot.draw(Canvas { width: 640, height: 400, vector: true })?.starts_with(b"<svg"));
//! # Ok::<(), brdf_baker::Error>(())
//! ```

mod canvas;
mod chart;
mod curve;
mod table;

pub use canvas::{Canvas, encode_png, write_text};
pub use chart::{Kind, Plot};
pub use curve::{Curve, Reflectance};
pub use table::draw_table;
