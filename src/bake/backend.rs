// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a bake runs.

use crate::error::{Error, Result};
use crate::gpu::{self, Gpu};

/// A Vulkan device, or the same rules in f64 on the processor.
pub enum Backend {
    /// All processor cores, f64.
    Cpu,
    /// A Vulkan device, f32.
    Gpu(Gpu),
}

impl Backend {
    /// Opens what `selector` names: `auto`, `cpu`, or a Vulkan device by index, UUID or part of its name.
    ///
    /// `auto` is the processor when the machine has no Vulkan device at all; [`Backend::name`] says so. A device that
    /// exists but cannot be opened is an error.
    pub fn open(selector: &str, validate: bool) -> Result<Backend> {
        if selector == "cpu" {
            return Ok(Backend::Cpu);
        }
        match Gpu::open(selector, validate) {
            Err(Error::NoDevice { .. }) if selector == "auto" && !validate && no_devices() => Ok(Backend::Cpu),
            opened => opened.map(Backend::Gpu),
        }
    }

    /// The device's name; `cpu` for the processor.
    pub fn name(&self) -> &str {
        match self {
            Backend::Cpu => "cpu",
            Backend::Gpu(gpu) => &gpu.info().name,
        }
    }

    /// The longest dispatch in milliseconds, compilation left out; `None` on the processor.
    pub fn longest_dispatch_ms(&self) -> Option<f64> {
        match self {
            Backend::Cpu => None,
            Backend::Gpu(gpu) => Some(1e3 * gpu.longest_dispatch().as_secs_f64()),
        }
    }

    /// The driver's name and version.
    pub fn driver(&self) -> &str {
        match self {
            Backend::Cpu => "f64",
            Backend::Gpu(gpu) => &gpu.info().driver,
        }
    }

    /// An error when the validation layer has said anything.
    pub fn check_messages(&self) -> Result<()> {
        match self {
            Backend::Cpu => Ok(()),
            Backend::Gpu(gpu) => gpu.check_messages(),
        }
    }
}

fn no_devices() -> bool {
    gpu::devices().map_or(true, |found| found.is_empty())
}
