// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a file stores what was baked, beside its encoding.

use std::path::Path;

use brdf_baker::Result;
use brdf_baker::format::{self, Compression, Effort, Encoding, Format, Storage};

use super::console::Console;

#[derive(clap::Args, Clone)]
pub struct StorageArgs {
    /// Compress the levels of a .ktx2 without loss
    #[arg(long, default_value = "none", value_name = "none|zstd")]
    compression: String,
    /// How long to search for the blocks of bc4, bc5 and bc6h
    #[arg(long, default_value = "normal", value_name = "fast|normal|slow")]
    bc_quality: String,
}

impl StorageArgs {
    /// With an encoding that the format holds.
    pub fn of(&self, format: &dyn Format, encoding: Encoding) -> Result<Storage> {
        let storage = Storage {
            encoding,
            compression: Compression::parse(&self.compression)?,
            effort: Effort::parse(&self.bc_quality)?,
        };
        format::check_compression(format, storage.compression)?;
        Ok(storage)
    }
}

/// Says so where a file cannot say what it holds.
pub fn warn_of_lost_meta(format: &dyn Format, path: &Path, console: &Console) {
    if !format.holds_meta() {
        console.warn(&format!(
            "'{}' does not say what it holds: {} has no place for metadata. What was baked, its axes and its certificate \
             are lost; bake a .ktx2 beside it to keep them",
            path.display(),
            format.name()
        ));
    }
}
