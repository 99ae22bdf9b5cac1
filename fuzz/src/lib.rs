// SPDX-License-Identifier: MIT OR Apache-2.0
//! The targets by name, for `fuzz_targets/`.

#[path = "../targets.rs"]
pub mod targets;

/// Runs the target of this name.
pub fn run(name: &str, bytes: &[u8]) {
    let target = targets::TARGETS.iter().find(|target| target.name == name);
    let target = target.unwrap_or_else(|| panic!("no target is called {name}"));
    (target.run)(bytes);
}
