// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a request to a file in one call, for the asset pipeline of an engine: what `brdf-baker bake` and `brdf-baker env` do.
//!
//! ```no_run
//! use brdf_baker::asset::Baker;
//! use brdf_baker::bake::{TableRequest, specular::SpecularRequest};
//!
//! let baker = Baker::open("auto")?;
//! baker.table(&TableRequest::new("split-sum"), "dfg.ktx2")?;
//! baker.environment("studio.exr", &SpecularRequest::default(), "studio.ktx2")?;
//! # Ok::<(), brdf_baker::Error>(())
//! ```
//! A file that is found to be wrong is not written; one that is written says what it holds and how exact it is, and appears
//! whole or not at all. Whoever wants less, or more, calls the parts: [`TableRequest::resolve`], [`TableJob::run`],
//! [`check`](crate::verify::table::check), [`format::certify`], [`Output`].

use std::path::Path;

use crate::bake::specular::{CLAMPED, SpecularRequest};
use crate::bake::{Backend, TableJob, TableRequest};
use crate::env::import::{self, Options};
use crate::error::{Error, Result};
use crate::format::{self, Encoding, Format, Output, Written, harmonics};
use crate::progress::ignore;
use crate::texture::{Shape, Texture};
use crate::verify::environment::{self, Summary};
use crate::verify::table::{self, Extent};

/// Bakes files, all on one device.
pub struct Baker {
    /// Where it runs.
    pub backend: Backend,
    /// How environments are read.
    pub import: Options,
    /// How texels are stored; `None` is the format's default: half floats where it has them.
    pub encoding: Option<Encoding>,
}

impl Baker {
    /// A baker on the device that `selector` names, as [`Backend::open`] has it: `auto`, `cpu`, an index, a UUID or a part of
    /// the name.
    pub fn open(selector: &str) -> Result<Baker> {
        Ok(Baker { backend: Backend::open(selector, false)?, import: Options::default(), encoding: None })
    }

    /// Bakes a table to `path`, whose extension is the format.
    pub fn table(&self, request: &TableRequest, path: impl AsRef<Path>) -> Result<Written> {
        let path = path.as_ref();
        let job: TableJob = request.resolve()?;
        let place = Place::prepare(path, Shape::Table, job.channels.len(), self.encoding)?;
        let mut texture = job.run(&self.backend, &mut ignore)?;
        let report = table::check(&job, &texture, None, Extent::Spot, &mut ignore)?;
        if let Some(failure) = report.failures.first() {
            return Err(not_written(path, failure));
        }
        report.state(job.loosest().worst, &mut texture.meta);
        place.write(&mut texture)
    }

    /// Filters the environment in `input` (see [`import::read`]) to `path`, whose extension is the format.
    pub fn environment(
        &self,
        input: impl AsRef<Path>,
        request: &SpecularRequest,
        path: impl AsRef<Path>,
    ) -> Result<Written> {
        let (input, path) = (input.as_ref(), path.as_ref());
        let job = request.resolve()?;
        let place = Place::prepare(path, job.shape(), 3, self.encoding)?;
        if job.mips > 1 && !place.format.holds_mips() {
            let what = format!("{} holds one level, not the {} of '{}'", place.format.name(), job.mips, path.display());
            return Err(Error::usage(what, "ask for one mip, or write a .ktx2 or .exr file"));
        }
        place.format.accepts(job.size, job.mips)?;
        let imported = import::read(input, &self.import, &mut ignore)?;
        let mut texture = job.run(&imported.environment, &self.backend, &mut ignore)?;
        let spot = environment::Extent::after_baking(job.quality, &imported.environment);
        let errors = environment::check(&job, &imported.environment, &texture, spot, &mut ignore)?;
        let summary = Summary::of(&errors);
        let bound = job.quality.worst_bound;
        // Written so that NaN is refused.
        if !(summary.worst <= bound && errors.len() == job.filtered().len()) {
            let what = format!("a texel is off by {:.1e} of its value, more than {bound:.1e}", summary.worst);
            return Err(not_written(path, &what));
        }
        let name = input.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        texture.meta.set("input", name);
        self.import.describe(&imported, &mut texture.meta);
        summary.state(job.quality, &mut texture.meta);
        harmonics::state(&harmonics::irradiance(&imported.environment), &mut texture.meta);
        let most = *place.encoding.repr.range().end();
        if texture.levels.iter().flatten().any(|v| *v > most) {
            texture.meta.set(CLAMPED, most);
        }
        place.write(&mut texture)
    }
}

/// A file to come.
struct Place {
    format: &'static dyn Format,
    encoding: Encoding,
    output: Output,
}

impl Place {
    fn prepare(path: &Path, shape: Shape, channels: usize, wanted: Option<Encoding>) -> Result<Place> {
        let format = format::for_path(path)?;
        let encoding = format::choose(format, shape, channels, wanted)?;
        Ok(Place { format, encoding, output: Output::prepare(path)? })
    }

    fn write(self, texture: &mut Texture) -> Result<Written> {
        let stored = format::certify(texture, self.encoding)?;
        self.output.commit(self.format, texture, stored)
    }
}

fn not_written(path: &Path, why: &str) -> Error {
    Error::Verify { what: format!("'{}' was not written: {why}", path.display()) }
}
