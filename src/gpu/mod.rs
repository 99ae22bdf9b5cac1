// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vulkan compute behind a safe face: SPIR-V, bytes and sizes go in, `f32` comes out.
//!
//! This is the only module with `unsafe` code. It knows no table: what a kernel computes is its caller's business.
//! Vulkan is loaded at run time; without a loader or a driver [`devices`] says so and the rest of the program goes on.
//!
//! Every call records, submits and waits: a [`Gpu`] never has work in flight when a method returns, so buffers may be
//! dropped at any time and a slice of work is the unit of progress and cancellation.
#![allow(unsafe_code)]

mod device;
mod inject;
mod kernel;
mod memory;

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytemuck::Pod;

use device::{Device, Instance};
pub use device::{DeviceInfo, DeviceKind, devices};
pub use kernel::{Bindings, Kernel, MAX_GROUPS};
pub use memory::Buffer;

use crate::error::{Error, Result};

/// An open Vulkan device with one compute queue.
pub struct Gpu {
    /// Kernels that were asked for by name, because a driver compiles each anew.
    kept: Mutex<Vec<Arc<Kernel>>>,
    device: Arc<Device>,
}

impl Gpu {
    /// Opens the device that `selector` names: `auto`, an index of [`devices`], a UUID, or a part of a name.
    ///
    /// `auto` prefers a discrete GPU, then an integrated one, then a virtual one, then software Vulkan. With `validate`
    /// the Khronos validation layer checks every call, synchronisation included; what it says is kept for
    /// [`Gpu::messages`].
    pub fn open(selector: &str, validate: bool) -> Result<Gpu> {
        let instance = Instance::new(validate)?;
        let found = instance.devices()?;
        let chosen = device::select(&found, selector)?;
        Ok(Gpu { kept: Mutex::default(), device: Arc::new(Device::open(instance, &found[chosen])?) })
    }

    /// What the device is.
    pub fn info(&self) -> &DeviceInfo {
        &self.device.info
    }

    /// The longest that one dispatch took, each kernel's first one left out, which may compile it: what a watchdog sees.
    pub fn longest_dispatch(&self) -> Duration {
        Duration::from_nanos(self.device.longest_dispatch_ns.load(Ordering::Relaxed))
    }

    /// What the validation layer has said so far; empty without `validate`.
    pub fn messages(&self) -> Vec<String> {
        self.device.instance.messages()
    }

    /// An error when the validation layer has said anything.
    pub fn check_messages(&self) -> Result<()> {
        match self.messages().first() {
            None => Ok(()),
            Some(first) => Err(Error::Gpu { op: "validation".into(), detail: first.clone() }),
        }
    }

    /// Destroys the device and returns everything that the validation layer said, leaks included.
    ///
    /// Kernels and buffers hold their device: drop them first, or the device lives on.
    pub fn close(self) -> Vec<String> {
        let instance = self.device.instance.clone();
        drop(self);
        instance.messages()
    }

    /// A storage buffer of `size_bytes` (a multiple of 4) whose every `f32` is NaN, so that "not written" is seen.
    pub fn buffer(&self, name: &str, size_bytes: u64) -> Result<Buffer> {
        let buffer = Buffer::new(&self.device, name, size_bytes)?;
        self.device.submit(name, |device, commands| {
            // SAFETY: the buffer was made with TRANSFER_DST usage, and `size_bytes` is its size.
            unsafe { device.cmd_fill_buffer(commands, buffer.raw, 0, size_bytes, u32::MAX) };
        })?;
        Ok(buffer)
    }

    /// A storage buffer that holds `data`.
    pub fn upload<T: Pod>(&self, name: &str, data: &[T]) -> Result<Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mut buffer = Buffer::new(&self.device, name, bytes.len() as u64)?;
        buffer.write(bytes)?;
        Ok(buffer)
    }

    /// A texel buffer that holds `data`, a multiple of four words.
    pub fn upload_texels<T: Pod>(&self, name: &str, data: &[T]) -> Result<Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mut buffer = Buffer::texels(&self.device, name, bytes.len() as u64)?;
        buffer.write(bytes)?;
        Ok(buffer)
    }

    /// Overwrites the start of a buffer.
    pub fn write<T: Pod>(&self, buffer: &mut Buffer, data: &[T]) -> Result<()> {
        buffer.write(bytemuck::cast_slice(data))
    }

    /// The whole content of a buffer.
    pub fn read<T: Pod>(&self, buffer: &Buffer) -> Result<Vec<T>> {
        buffer.read()
    }

    /// A compute pipeline from SPIR-V whose entry point is `main`, with a push-constant block of `push_bytes`.
    pub fn kernel(&self, name: &str, spirv: &[u32], bindings: impl Into<Bindings>, push_bytes: u32) -> Result<Kernel> {
        Kernel::new(&self.device, name, spirv, bindings.into(), push_bytes)
    }

    /// The same, made once for each name and then kept.
    pub fn kept_kernel(
        &self,
        name: &str,
        spirv: &[u32],
        bindings: impl Into<Bindings>,
        push_bytes: u32,
    ) -> Result<Arc<Kernel>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kernel) = kept.iter().find(|kernel| kernel.name() == name) {
            return Ok(kernel.clone());
        }
        let kernel = Arc::new(self.kernel(name, spirv, bindings, push_bytes)?);
        kept.push(kernel.clone());
        Ok(kernel)
    }

    /// Runs `groups` workgroups of a kernel and waits until they are done.
    pub fn dispatch<P: Pod>(&self, kernel: &Kernel, buffers: &[&Buffer], push: &P, groups: [u32; 3]) -> Result<()> {
        kernel.dispatch(&self.device, buffers, bytemuck::bytes_of(push), groups)
    }
}
