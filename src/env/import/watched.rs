// SPDX-License-Identifier: MIT OR Apache-2.0
//! A file that reports how far it has been read, that stops when the user cancels, and that tells whether it changed
//! meanwhile: no decoder needs to know of any of it.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::rc::Rc;

use crate::error::{Error, Result};
use crate::progress::{OnProgress, tick};
use crate::stamp::Stamp;

/// Bytes between two looks at the listener.
const STEP: u64 = 1 << 20;

/// An open file under a listener.
pub struct Watched<'a, 'b> {
    file: File,
    length: u64,
    position: u64,
    next_look: u64,
    on: &'a mut OnProgress<'b>,
    state: State,
}

/// Whether the listener cancelled, and what the file was when it was opened. Outlives the decoder's hold on the file.
#[derive(Clone)]
pub struct State {
    cancelled: Rc<Cell<bool>>,
    opened: Rc<(File, Stamp)>,
}

impl State {
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.get()
    }

    /// An error where the file changed since it was opened. Another file that took its name does no harm: what was opened
    /// was read.
    pub fn check(&self, path: &Path) -> Result<()> {
        let (file, stamp) = &*self.opened;
        let now = file.metadata().map_err(|e| Error::io("read", path, e))?;
        if Stamp::of(&now) == *stamp { Ok(()) } else { Err(Stamp::changed(path)) }
    }

    /// A failed read of `path`.
    pub fn explain(&self, path: &Path, error: io::Error) -> Error {
        if self.is_cancelled() { Error::Cancelled } else { Error::io("read", path, error) }
    }
}

impl<'a, 'b> Watched<'a, 'b> {
    pub fn open(path: &Path, on: &'a mut OnProgress<'b>) -> Result<Self> {
        let io = |e| Error::io("read", path, e);
        let file = File::open(path).map_err(io)?;
        let meta = file.metadata().map_err(io)?;
        if meta.is_dir() {
            return Err(io(io::ErrorKind::IsADirectory.into()));
        }
        let opened = Rc::new((file.try_clone().map_err(io)?, Stamp::of(&meta)));
        let state = State { cancelled: Rc::default(), opened };
        Ok(Self { file, length: meta.len(), position: 0, next_look: 0, on, state })
    }

    pub fn state(&self) -> State {
        self.state.clone()
    }

    /// Bytes in the file.
    pub fn length(&self) -> u64 {
        self.length
    }
}

impl Read for Watched<'_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.position >= self.next_look {
            let done = (self.position as f64 / self.length.max(1) as f64).min(1.0);
            if tick(self.on, "reading the environment", done).is_err() {
                self.state.cancelled.set(true);
                return Err(io::Error::other("cancelled"));
            }
            self.next_look = self.position + STEP;
        }
        // A large read is cut, so that each step is seen.
        let most = buffer.len().min(STEP as usize);
        let count = self.file.read(&mut buffer[..most])?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Seek for Watched<'_, '_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.position = self.file.seek(to)?;
        self.next_look = self.next_look.min(self.position + STEP);
        Ok(self.position)
    }
}
