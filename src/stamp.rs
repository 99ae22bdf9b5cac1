// SPDX-License-Identifier: MIT OR Apache-2.0
//! When a file last changed: to notice that somebody writes a file while it is read.

use std::fs::Metadata;
use std::path::Path;
use std::time::SystemTime;

use crate::error::Error;

/// Length, time of the last change, and on Unix which file it is. Two stamps of a file agree if nobody wrote to it in
/// between, as far as the file system's clock tells (Linux: some milliseconds).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
    file: (u64, u64),
}

impl Stamp {
    /// Of a file with this metadata.
    pub(crate) fn of(meta: &Metadata) -> Stamp {
        #[cfg(unix)]
        let file = (std::os::unix::fs::MetadataExt::dev(meta), std::os::unix::fs::MetadataExt::ino(meta));
        #[cfg(not(unix))]
        let file = (0, 0);
        Stamp { length: meta.len(), modified: meta.modified().ok(), file }
    }

    /// The error when stamps differ.
    pub(crate) fn changed(path: &Path) -> Error {
        Error::input(path, "it changed while it was read", "wait until it is written, then bake again")
    }
}
