//! The one channel for progress and cancellation.

use std::ops::ControlFlow;

use crate::error::{Error, Result};

/// How far a piece of work has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// What is being done, as a reader would say it: `baking split-sum`, `mip 3 of 8`.
    pub stage: &'a str,
    /// Share of the stage that is done, in [0, 1].
    pub done: f64,
}

/// Called between slices of work; answering `Break` cancels the work within one slice.
pub type OnProgress<'a> = dyn FnMut(Progress<'_>) -> ControlFlow<()> + 'a;

/// Reports progress and turns a `Break` into [`Error::Cancelled`].
pub fn tick(on: &mut OnProgress<'_>, stage: &str, done: f64) -> Result<()> {
    match on(Progress { stage, done }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Cancelled),
    }
}

/// A listener that ignores progress and never cancels.
pub fn ignore(_: Progress<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
