// SPDX-License-Identifier: MIT OR Apache-2.0
//! The one channel for progress and cancellation.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

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

/// Between two looks at the listener from [`watched`].
const LOOK: Duration = Duration::from_millis(10);

/// What parallel work is told, and tells, while it is watched.
pub struct Watch {
    count: usize,
    done: AtomicUsize,
    cancelled: AtomicBool,
}

impl Watch {
    /// Is nobody interested in the result any more? Counts one of the work's parts as begun.
    pub fn cancelled(&self) -> bool {
        self.done.fetch_add(1, Ordering::Relaxed);
        self.gone()
    }

    /// The same of work that is no part by itself.
    pub fn gone(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Runs `work` on the thread pool, while the listener is looked at from here. `work` has about `count` parts and asks
/// [`Watch::cancelled`] at the start of each; what it answers after it was cancelled is dropped.
pub fn watched<R: Send>(
    on: &mut OnProgress<'_>,
    stage: &str,
    count: usize,
    work: impl FnOnce(&Watch) -> R + Send,
) -> Result<R> {
    tick(on, stage, 0.0)?;
    let watch = Watch { count: count.max(1), done: AtomicUsize::new(0), cancelled: AtomicBool::new(false) };
    if rayon::current_thread_index().is_some() {
        // A thread of the pool must not wait for another: there may be only one.
        return Ok(work(&watch));
    }
    let (send, receive) = channel();
    rayon::in_place_scope(|scope| {
        let watch = &watch;
        scope.spawn(move |_| {
            // The receiver waits below until the result is there.
            let _ = send.send(work(watch));
        });
        let mut answer = Ok(());
        loop {
            match receive.recv_timeout(LOOK) {
                Ok(result) => return answer.map(|()| result),
                Err(RecvTimeoutError::Timeout) => {
                    let done = watch.done.load(Ordering::Relaxed).min(watch.count);
                    if answer.is_ok() {
                        answer = tick(on, stage, done as f64 / watch.count as f64);
                    }
                    watch.cancelled.store(answer.is_err(), Ordering::Relaxed);
                }
                // It panicked, and the scope panics in turn.
                Err(RecvTimeoutError::Disconnected) => return Err(Error::Cancelled),
            }
        }
    })
}

/// A listener that ignores progress and never cancels.
pub fn ignore(_: Progress<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;

    #[test]
    fn watched_work_is_seen_and_ends_when_it_is_cancelled() {
        const PARTS: usize = 4000;
        for cancel in [false, true] {
            let mut last = 0.0;
            let on = &mut |p: Progress<'_>| {
                last = p.done;
                if cancel && last > 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let ran = AtomicUsize::new(0);
            let part = |watch: &Watch| {
                if !watch.cancelled() {
                    ran.fetch_add(1, Ordering::Relaxed);
                    std::thread::sleep(Duration::from_micros(50));
                }
            };
            let answer = watched(on, "sleeping", PARTS, |watch| (0..PARTS).into_par_iter().for_each(|_| part(watch)));
            let ran = ran.into_inner();
            assert!(last > 0.0 && last <= 1.0, "{last}");
            match answer {
                Ok(()) => assert!(!cancel && ran == PARTS, "{ran}"),
                Err(error) => assert!(cancel && ran < PARTS && matches!(error, Error::Cancelled), "{ran}: {error}"),
            }
        }
    }

    #[test]
    fn work_on_a_pool_of_one_thread_ends() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let sum = pool.install(|| watched(&mut ignore, "adding", 10, |_| (0..10).into_par_iter().sum::<i32>()));
        assert_eq!(sum.expect("nobody cancels"), 45);
    }
}
