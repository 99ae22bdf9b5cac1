//! `brdf-baker env`

use std::path::{Path, PathBuf};

use brdf_baker::format::Encoding;
use brdf_baker::texture::Texture;
use brdf_baker::verify::table::Extent;
use brdf_baker::{Error, Result};

use super::Global;
use super::console::Console;

#[derive(clap::Args)]
pub struct EnvArgs {
    /// Equirectangular environment, .hdr or .exr
    input: PathBuf,
}

impl EnvArgs {
    pub fn run(self, _global: &Global, _console: &mut Console) -> Result<()> {
        Err(Error::usage("not yet", ""))
    }
}

pub fn verify(_: &Path, _: &Texture, _: Encoding, _: Extent, _: &mut Console) -> Result<()> {
    Err(Error::usage("not yet", ""))
}

pub fn kernels() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    std::iter::empty()
}
