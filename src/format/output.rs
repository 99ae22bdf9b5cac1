// SPDX-License-Identifier: MIT OR Apache-2.0
//! A file that appears whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use super::encoding::rounding_of;
use super::{Format, Rounding, Stored, leftover, rounding};
use crate::error::{Error, Result};
use crate::texture::Texture;

/// A place that is known to be writable: an empty temporary file in the target's folder.
///
/// Dropping it removes the temporary file, so an error or a cancel between [`Output::prepare`] and [`Output::commit`]
/// leaves the folder as it was. A process that is killed outright leaves a file named `.brdf-baker-….part`, which a later
/// one that writes into the folder removes.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    folder: PathBuf,
    part: NamedTempFile,
    // Dropped after the file is gone.
    _listed: Listed,
}

/// Temporary files that exist now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file's entry in the list.
#[derive(Debug)]
struct Listed(PathBuf);

impl Listed {
    fn new(path: PathBuf) -> Listed {
        unfinished().push(path.clone());
        Listed(path)
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// For a process that ends at once: no [`Output`] is prepared or committed while this lives.
pub struct Abandoned {
    _list: MutexGuard<'static, Vec<PathBuf>>,
}

/// Removes the temporary files of all outputs that were not committed. What was committed is whole and stays.
pub fn abandon() -> Abandoned {
    let list = unfinished();
    for path in list.iter() {
        // It may be gone already: then there is nothing to remove.
        let _ = fs::remove_file(path);
    }
    Abandoned { _list: list }
}

/// What [`Output::commit`] wrote.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Size of the file.
    pub bytes: u64,
    /// What the encoding did to the values.
    pub rounding: Rounding,
}

impl Output {
    /// Checks that `path` can be written. An older file there stays as it is until [`Output::commit`].
    pub fn prepare(path: &Path) -> Result<Output> {
        // A link is followed, so that the file that it names is replaced and not the link.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let refuse = |kind: io::ErrorKind| Err(Error::io("write", path, kind.into()));
        match fs::metadata(&target) {
            Ok(found) if found.is_dir() => return refuse(io::ErrorKind::IsADirectory),
            Ok(found) if !found.is_file() => {
                // Renaming over a device or a pipe would put a plain file in its place.
                return Err(Error::usage(format!("'{}' is not a regular file", path.display()), "name a file"));
            }
            // A rename would replace it all the same; its owner protected it for a reason.
            Ok(found) if found.permissions().readonly() => return refuse(io::ErrorKind::PermissionDenied),
            _ => {}
        }
        if target.file_name().is_none() {
            return refuse(io::ErrorKind::IsADirectory);
        }
        let folder = match target.parent() {
            Some(folder) if folder != Path::new("") => folder.to_path_buf(),
            _ => PathBuf::from("."),
        };
        leftover::sweep(&folder);
        let mut builder = tempfile::Builder::new();
        builder.prefix(leftover::PREFIX).suffix(leftover::SUFFIX);
        // The umask is applied to this; tempfile's own default would keep other users from reading the result.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let part = builder.tempfile_in(&folder).map_err(|e| Error::io("write", path, e))?;
        leftover::claim(part.as_file());
        let listed = Listed::new(part.path().to_path_buf());
        Ok(Output { path: target, folder, part, _listed: listed })
    }

    /// Writes the texture and puts the file in place, over an older one.
    /// `stored` is what [`certify`](super::certify) gave, or just an encoding.
    pub fn commit(self, format: &dyn Format, texture: &Texture, stored: impl Into<Stored>) -> Result<Written> {
        let Stored { storage, levels } = stored.into();
        let is_blocks = storage.encoding.repr.is_blocks();
        let measured = match &levels {
            Some(levels) if !is_blocks => Some(rounding_of(texture, storage.encoding, levels)?),
            _ => None,
        };
        let bytes = match levels {
            Some(levels) => format.to_bytes_of_levels(&self.path, texture, storage, levels)?,
            None => format.to_bytes(&self.path, texture, storage)?,
        };
        let rounding = match measured {
            Some(rounding) => rounding,
            None if is_blocks => {
                // Blocks take long to encode, and little to decode.
                let (read, _) = format.parse(&self.path, &bytes)?;
                let n = (read.channels.len(), texture.channels.len());
                let own = |level: Vec<f32>| level.chunks_exact(n.0).flat_map(|texel| &texel[..n.1]).copied().collect();
                let stored: Vec<Vec<f32>> = read.levels.into_iter().map(own).collect();
                Rounding::between(texture, storage.encoding.repr, &stored)
            }
            None => rounding(texture, storage)?,
        };
        Ok(Written { bytes: self.commit_bytes(&bytes)?, rounding })
    }

    /// The same with a file's content; its size in bytes.
    pub fn commit_bytes(mut self, bytes: &[u8]) -> Result<u64> {
        // Synced before the rename: otherwise a crash could leave the new name with an empty file behind it.
        let written = self.part.write_all(bytes).and_then(|()| self.part.as_file().sync_all());
        written.map_err(|e| Error::io("write", &self.path, e))?;
        let held = unfinished();
        let placed = self.part.persist(&self.path).map_err(|e| Error::io("write", &self.path, e.error));
        drop(held);
        placed?;
        // The rename itself is made durable where the system can; the file is in place either way.
        #[cfg(unix)]
        let _ = fs::File::open(&self.folder).and_then(|folder| folder.sync_all());
        #[cfg(not(unix))]
        let _ = &self.folder;
        Ok(bytes.len() as u64)
    }
}
