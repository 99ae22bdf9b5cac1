//! `brdf-baker bake`

use std::path::PathBuf;
use std::time::Instant;

use brdf_baker::axis::Points;
use brdf_baker::bake::{Backend, TableRequest};
use brdf_baker::format::{self, Encoding, Output};
use brdf_baker::material;
use brdf_baker::term::fresnel::Fresnel;
use brdf_baker::texture::Shape;
use brdf_baker::verify::table::{Extent, check};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::Global;
use super::console::Console;
use super::storage::{self, StorageArgs};

#[derive(clap::Args)]
pub struct BakeArgs {
    /// split-sum, albedo or average-albedo
    table: String,
    /// File to write; its extension chooses the container, see `brdf-baker list formats`
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Texels: 256, or 128x32 for width x height
    #[arg(long, default_value = "256", value_name = "N|WxH", value_parser = parse_size)]
    size: (u32, u32),
    /// Normal distribution function
    #[arg(long, default_value = "ggx", value_name = "NAME[:PARAMETER=VALUE,...]")]
    ndf: String,
    /// Geometry term
    #[arg(long, default_value = "smith", value_name = "NAME")]
    visibility: String,
    /// Exact Fresnel of a dielectric of this refractive index over the medium's that light comes from; below 1 from inside
    #[arg(long, value_name = "N", group = "fresnel")]
    ior: Option<f64>,
    /// Exact Fresnel of a conductor: eta and k, or eta of red, green, blue and then k of red, green, blue
    #[arg(long, value_name = "ETA,K|R,G,B,R,G,B", group = "fresnel", value_delimiter = ',')]
    eta_k: Option<Vec<f64>>,
    /// Exact Fresnel of a named material, see `brdf-baker materials`
    #[arg(long, value_name = "NAME", group = "fresnel")]
    material: Option<String>,
    /// What runs along x and y [default: n_dot_v,roughness]
    #[arg(long, value_name = "X,Y", value_delimiter = ',')]
    axes: Option<Vec<String>>,
    /// Where in its texel a value is taken: centers, (i + 1/2)/N, or edges, i/(N - 1)
    #[arg(long, default_value = "centers", value_name = "centers|edges")]
    points: String,
    /// Put the largest y coordinate into row 0 (the default is the smallest)
    #[arg(long)]
    flip_v: bool,
    /// What the channels hold, in order [default: scale,bias for split-sum]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    channels: Option<Vec<String>>,
    /// How texels are stored [default: half float where the container has it, single in source code]
    #[arg(long, value_name = "NAME")]
    encoding: Option<String>,
    #[command(flatten)]
    storage: StorageArgs,
}

impl BakeArgs {
    pub fn run(self, global: &Global, console: &mut Console) -> Result<()> {
        let start = Instant::now();

        // Everything that can be refused is refused before any work.
        let fresnel = fresnel(self.ior, self.eta_k.as_deref(), self.material.as_deref())?;
        let request = TableRequest {
            table: self.table,
            size: self.size,
            ndf: self.ndf,
            visibility: self.visibility,
            fresnel,
            axes: self.axes,
            points: Points::parse(&self.points)?,
            flip_v: self.flip_v,
            channels: self.channels,
        };
        let job = request.resolve()?;
        let wanted = self.encoding.as_deref().map(Encoding::parse).transpose()?;
        let format = format::for_path(&self.output)?;
        let encoding = format::choose(format, Shape::Table, job.channels.len(), wanted)?;
        let storage = self.storage.of(format, encoding)?;
        for channel in job.channel_facts() {
            let [low, high] = job.range(channel);
            format::check_range(&self.output, format, encoding, channel.name, &(low..=high))?;
        }
        let output = Output::prepare(&self.output)?;

        let backend = Backend::open(&global.device, global.validate)?;
        let mut texture = job.run(&backend, &mut |p| console.progress(p))?;
        let report = check(&job, &texture, None, Extent::Spot, &mut |p| console.progress(p))?;
        if let Some(failure) = report.failures.first() {
            return Err(Error::Verify { what: format!("'{}' was not written: {failure}", self.output.display()) });
        }
        backend.check_messages()?;
        if let Some(name) = &self.material {
            texture.meta.set("material", name);
        }
        texture.meta.set("error.worst", format!("{:.2e}", report.worst() + report.truth_error));
        texture.meta.set("error.median", format!("{:.2e}", report.median()));
        texture.meta.set("error.bound", format!("{:.0e}", job.tolerance().worst));
        texture.meta.set("error.checked", format!("{} texels against adaptive f64 integration", report.truth_texels));
        format::certify(&mut texture, storage)?;
        let written = output.commit(format, &texture, storage)?;
        storage::warn_of_lost_meta(format, &self.output, console);

        let seconds = start.elapsed().as_secs_f64();
        let (width, height) = job.size();
        let path = self.output.display();
        let (worst, rounding) = (report.worst() + report.truth_error, written.rounding.max_abs);
        console.result(
            &format!(
                "{path}  {width}x{height} {}  max error {worst:.1e} (+ {rounding:.1e} rounding)  {seconds:.2} s  {}",
                encoding.name,
                backend.name()
            ),
            &json!({
                "path": self.output,
                "table": job.table.facts().name,
                "width": width,
                "height": height,
                "encoding": encoding.name,
                "bytes": written.bytes,
                "max_error": worst,
                "median_error": report.median(),
                "rounding": rounding,
                "rounding_rms": written.rounding.rms,
                "checked_texels": report.truth_texels,
                "rule": job.rule_name(),
                "output_texels": width * height,
                "longest_dispatch_ms": backend.longest_dispatch_ms(),
                "seconds": seconds,
                "device": backend.name(),
            }),
        )
    }
}

/// The Fresnel term that was asked for; `None` for the table's own.
fn fresnel(ior: Option<f64>, eta_k: Option<&[f64]>, material: Option<&str>) -> Result<Option<Fresnel>> {
    let term = match (ior, eta_k, material) {
        (Some(ior), ..) => Fresnel::dielectric(ior)?,
        (_, Some([eta, k]), _) => Fresnel::conductor([*eta; 3], [*k; 3])?,
        (_, Some([er, eg, eb, kr, kg, kb]), _) => Fresnel::conductor([*er, *eg, *eb], [*kr, *kg, *kb])?,
        (_, Some(other), _) => {
            return Err(Error::usage(
                format!("--eta-k got {} numbers", other.len()),
                "give 2, eta and k, or 6, eta of red, green and blue and then k of red, green and blue",
            ));
        }
        (.., Some(name)) => material::parse(name)?.fresnel()?,
        (None, None, None) => return Ok(None),
    };
    Ok(Some(term))
}

/// `N` or `WxH`.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let number = |s: &str| s.parse::<u32>().map_err(|_| format!("'{s}' is not a number of texels"));
    match text.split_once('x') {
        None => number(text).map(|n| (n, n)),
        Some((width, height)) => Ok((number(width)?, number(height)?)),
    }
}

#[cfg(test)]
mod tests {
    use super::parse_size;

    #[test]
    fn size_is_one_or_two_numbers() {
        assert_eq!(parse_size("256"), Ok((256, 256)));
        assert_eq!(parse_size("128x32"), Ok((128, 32)));
        assert!(parse_size("128x").is_err() && parse_size("-1").is_err() && parse_size("big").is_err());
    }
}
