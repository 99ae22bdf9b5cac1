//! File formats: one file each, and their registry.

mod encoding;

use std::io::{Seek, Write};
use std::path::Path;

pub use encoding::{ENCODINGS, Encoding, Repr};

use crate::error::Result;
use crate::texture::{Shape, Texture};

/// A place to write to, as the format writers need it.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// A container that can be written and read back.
pub trait Format: Sync {
    /// The name shown to users: `KTX2`.
    fn name(&self) -> &'static str;
    /// The file extension that selects it, without the dot.
    fn extension(&self) -> &'static str;
    /// The encodings that it can hold for this shape; empty when it cannot hold the shape at all.
    fn encodings(&self, shape: Shape) -> Vec<Encoding>;
    /// What is written when the user names no encoding: half float where the container has it.
    fn default_encoding(&self, shape: Shape, channels: usize) -> Option<Encoding>;
    /// Writes `texture`, whose meta goes into the file.
    fn write(&self, texture: &Texture, encoding: Encoding, out: &mut dyn Sink) -> Result<()>;
    /// Reads a file that this tool wrote (others too where the container says enough).
    fn read(&self, path: &Path) -> Result<(Texture, Encoding)>;
}
