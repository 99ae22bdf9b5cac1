// SPDX-License-Identifier: MIT OR Apache-2.0
//! How much work one dispatch gets.

use std::time::Duration;

/// A slice should take this long: enough to keep a GPU busy, short enough for progress, cancel and watchdogs.
const AIM: Duration = Duration::from_millis(15);

/// The next slice after one of `count` invocations that took this long: it aims at [`AIM`], grows at most four-fold, and
/// fills at least two workgroups, so that both cores of a small processor get something to do.
pub(crate) fn next_slice(count: u32, took: Duration, workgroup: u32) -> u32 {
    let factor = (AIM.as_secs_f64() / took.as_secs_f64().max(1e-6)).clamp(0.25, 4.0);
    ((f64::from(count) * factor) as u32).max(2 * workgroup) / workgroup * workgroup
}
