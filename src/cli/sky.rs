// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker sky`

use std::path::PathBuf;
use std::time::Instant;

use brdf_baker::env::projection::Projection;
use brdf_baker::env::sky::{SUN_DIAMETER_DEG, Sky};
use brdf_baker::format::{self, Encoding, Output, Repr};
use brdf_baker::texture::{Meta, Shape, Texture};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::console::Console;

/// Rows of the largest picture that `env` reads.
const MAX_HEIGHT: u32 = 8192;

#[derive(clap::Args)]
pub struct SkyArgs {
    /// Picture to write, equirectangular: .exr or .hdr
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Rows; the picture is twice as wide
    #[arg(long, default_value_t = 512, value_name = "N")]
    size: u32,
    /// Haze: 2 very clear, 3 clear, 6 hazy, 10 nearly foggy
    #[arg(long, default_value_t = Sky::default().turbidity, value_name = "T")]
    turbidity: f64,
    /// Angle of the sun above the horizon, 0 to 90
    #[arg(long, default_value_t = Sky::default().sun_elevation_deg, value_name = "DEGREES", allow_hyphen_values = true)]
    elevation: f64,
    /// Azimuth of the sun: 0 at +X, the middle of the picture, 90 at +Z, to the right of it
    #[arg(long, default_value_t = Sky::default().sun_azimuth_deg, value_name = "DEGREES", allow_hyphen_values = true)]
    azimuth: f64,
    /// Draw the sun's disc, 0.53 degrees across: in every texel the exact part of it that lies there
    #[arg(long)]
    sun_disc: bool,
    /// Share of light that the ground reflects: one number, or red,green,blue
    #[arg(long, default_value = "0.2", value_name = "ALBEDO", value_delimiter = ',', allow_hyphen_values = true)]
    ground: Vec<f64>,
    /// Multiply the picture, which is in kcd/m2, by 2 to this power
    #[arg(long, value_name = "EV", allow_hyphen_values = true, default_value_t = 0.0)]
    exposure: f64,
    /// How texels are stored [default: rgba16f in .exr, rgba32f where the sun exceeds it, rgbe8 in .hdr]
    #[arg(long, value_name = "NAME")]
    encoding: Option<String>,
}

impl SkyArgs {
    pub fn run(self, console: &mut Console) -> Result<()> {
        let start = Instant::now();
        let ground_albedo = match self.ground[..] {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            _ => {
                let what = format!("--ground got {} numbers", self.ground.len());
                return Err(Error::usage(what, "give one number, or three for red, green and blue"));
            }
        };
        let sky = Sky {
            turbidity: self.turbidity,
            sun_elevation_deg: self.elevation,
            sun_azimuth_deg: self.azimuth,
            sun_disc: self.sun_disc,
            ground_albedo,
        };
        let daylight = sky.resolve()?;
        if !(1..=MAX_HEIGHT).contains(&self.size) {
            let what = format!("a picture of {} rows is not written", self.size);
            return Err(Error::usage(what, format!("use --size from 1 to {MAX_HEIGHT}")));
        }
        let scale = self.exposure.exp2() as f32;
        if !(scale.is_finite() && scale > 0.0) {
            let what = format!("--exposure {} leaves nothing of the picture", self.exposure);
            return Err(Error::usage(what, "give a number from -100 to 100"));
        }
        let extension = self.output.extension().map(|e| e.to_string_lossy().to_lowercase());
        if !matches!(extension.as_deref(), Some("exr" | "hdr")) {
            let what = format!("'{}' is not named like a picture of radiance", self.output.display());
            return Err(Error::usage(what, "write a .exr or .hdr file"));
        }
        let wanted = self.encoding.as_deref().map(Encoding::parse).transpose()?;
        let format = format::for_path(&self.output)?;
        format::choose(format, Shape::Map, 3, wanted)?;
        let output = Output::prepare(&self.output)?;

        let picture = daylight.equirect(self.size);
        let texels: Vec<f32> = picture.texels.iter().flatten().map(|v| v * scale).collect();
        let peak = texels.iter().fold(0.0f32, |a, b| a.max(*b));
        // Half floats end at 65504, far below the sun.
        let wide = Encoding::fitting(Repr::F32, 4).filter(|wide| format.encodings(Shape::Map).contains(wide));
        let wanted = wanted.or(wide.filter(|_| peak > *Repr::F16.range().end()));
        let encoding = format::choose(format, Shape::Map, 3, wanted)?;

        let mut meta = Meta::default();
        meta.set("environment", "sky");
        meta.set("projection", Projection::Equirect.name());
        meta.set("layout", Projection::Equirect.convention());
        meta.set("source", "Preetham, Shirley, Smits 1999, A Practical Analytic Model for Daylight");
        meta.set("turbidity", sky.turbidity);
        meta.set("sun.elevation", format!("{} degrees", sky.sun_elevation_deg));
        meta.set("sun.azimuth", format!("{} degrees from +X towards +Z", sky.sun_azimuth_deg));
        let drawn = format!("drawn, {SUN_DIAMETER_DEG} degrees across");
        meta.set("sun.disc", if sky.sun_disc { &drawn } else { "left out" });
        meta.set("ground.albedo", ground_albedo.map(|a| a.to_string()).join(","));
        meta.set("units", format!("0.2126 r + 0.7152 g + 0.0722 b is kcd/m2 times 2^{}", self.exposure));
        meta.set("version", env!("CARGO_PKG_VERSION"));
        let texture = Texture {
            shape: Shape::Map,
            width: picture.width,
            height: picture.height,
            channels: ["r", "g", "b"].map(String::from).to_vec(),
            levels: vec![texels],
            meta,
        };
        let written = output.commit(format, &texture, encoding)?;
        let path = self.output.display();
        if written.rounding.clamped > 0 {
            console.warn(&format!(
                "{} values of '{path}' exceed what {} holds and were clamped; --encoding rgba32f keeps them, or lower the \
                 --exposure",
                written.rounding.clamped, encoding.name
            ));
        }
        let seconds = start.elapsed().as_secs_f64();
        let klx = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let (sky_klx, sun_klx) = (klx(daylight.sky_irradiance), klx(daylight.sun_irradiance));
        console.result(
            &format!(
                "{path}  {}x{} {}  sun {} degrees up, {sky_klx:.1} klx of sky and {sun_klx:.1} klx of sun on the ground  \
                 {seconds:.2} s",
                texture.width, texture.height, encoding.name, sky.sun_elevation_deg
            ),
            &json!({
                "path": self.output,
                "width": texture.width,
                "height": texture.height,
                "encoding": encoding.name,
                "bytes": written.bytes,
                "turbidity": sky.turbidity,
                "sun_direction": daylight.sun,
                "sun_disc": sky.sun_disc,
                "sun_radiance_kcd_m2": daylight.sun_radiance,
                "zenith_radiance_kcd_m2": daylight.radiance([0.0, 1.0, 0.0]),
                "ground_radiance_kcd_m2": daylight.ground,
                "sky_illuminance_klx": sky_klx,
                "sun_illuminance_klx": sun_klx,
                "scale": scale,
                "largest_value": peak,
                "rounding": written.rounding.most.max_rel,
                "clamped": written.rounding.clamped,
                "seconds": seconds,
            }),
        )
    }
}
