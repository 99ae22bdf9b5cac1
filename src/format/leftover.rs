// SPDX-License-Identifier: MIT OR Apache-2.0
//! Temporary files of processes that were killed outright: nobody else can remove them.
//!
//! A living process holds a lock on each of its temporary files, which ends with it however it ends. On systems without
//! such locks, and on disks that do not know them, what is left stays.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// What the name of a temporary file begins and ends with.
pub(super) const PREFIX: &str = ".brdf-baker-";
pub(super) const SUFFIX: &str = ".part";

/// A younger file may be one that its process has not locked yet.
const YOUNG: Duration = Duration::from_secs(60);

/// Holds a temporary file, for as long as it is open.
pub(super) fn claim(part: &File) {
    // A disk without locks refuses this, and then refuses those who would sweep as well.
    let _ = lock(part);
}

/// Removes what is left in a folder, the first time that this process comes to it.
pub(super) fn sweep(folder: &Path) {
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    if !SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_path_buf()) {
        return;
    }
    // A folder that cannot be read is found wrong by whoever writes into it.
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(PREFIX) && name.ends_with(SUFFIX) && is_orphan(&entry.path()) {
            // Another process may have been faster.
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_orphan(path: &Path) -> bool {
    let age = fs::symlink_metadata(path)
        .ok()
        .filter(|meta| meta.is_file())
        .and_then(|meta| meta.modified().ok()?.elapsed().ok());
    age.is_some_and(|age| age >= YOUNG) && File::open(path).is_ok_and(|file| lock(&file))
}

#[cfg(unix)]
fn lock(file: &File) -> bool {
    rustix::fs::flock(file, rustix::fs::FlockOperation::NonBlockingLockExclusive).is_ok()
}

#[cfg(not(unix))]
fn lock(_: &File) -> bool {
    false
}

#[cfg(all(test, unix))]
mod tests {
    use std::time::SystemTime;

    use super::*;

    #[test]
    fn only_old_files_without_an_owner_are_removed() {
        let folder = tempfile::TempDir::new().unwrap();
        let old = SystemTime::now() - 2 * YOUNG;
        let make = |name: &str, modified: SystemTime| {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_modified(modified).unwrap();
            file
        };
        drop(make(".brdf-baker-dead.part", old));
        drop(make(".brdf-baker-young.part", SystemTime::now()));
        drop(make("mine.part", old));
        let held = make(".brdf-baker-held.part", old);
        claim(&held);
        sweep(folder.path());
        let mut left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, [".brdf-baker-held.part", ".brdf-baker-young.part", "mine.part"]);
    }
}
