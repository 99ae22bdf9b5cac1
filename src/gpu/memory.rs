// SPDX-License-Identifier: MIT OR Apache-2.0
//! Buffers, mapped where the device allows it and staged where it does not.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;
use bytemuck::Pod;

use super::device::{Device, gpu_error};
use crate::error::{Error, Result};

/// A storage buffer on the device, or a texel buffer.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    /// Of a texel buffer; else null.
    pub(super) view: vk::BufferView,
    memory: vk::DeviceMemory,
    /// Start of the mapped memory; `None` when the memory is not visible to the host.
    mapped: Option<Mapped>,
    /// The host reads this memory through its caches. A card's own memory, mapped over the bus, is written fast and
    /// read a hundred times slower than it is copied.
    cached: bool,
    size_bytes: u64,
    name: String,
    device: Arc<Device>,
    _taken: Taken,
}

/// Memory that counts as taken, until this is dropped.
struct Taken(Arc<Device>, u64);

impl Taken {
    /// An error where a fault says that there is not so much left.
    fn new(device: &Arc<Device>, bytes: u64) -> Result<Taken, vk::Result> {
        let held = device.taken_bytes.fetch_add(bytes, Ordering::Relaxed);
        let taken = Taken(device.clone(), bytes);
        let most = device.instance.faults().device_memory.unwrap_or(u64::MAX);
        if held + bytes > most { Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY) } else { Ok(taken) }
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.0.taken_bytes.fetch_sub(self.1, Ordering::Relaxed);
    }
}

/// The address of mapped device memory.
struct Mapped(*mut u8);

// SAFETY: the address is only dereferenced through &Buffer or &mut Buffer of the buffer that owns the mapping, and a
// mapping belongs to no thread.
unsafe impl Send for Mapped {}
// SAFETY: shared access only reads.
unsafe impl Sync for Mapped {}

const HOST: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::from_raw(
    vk::MemoryPropertyFlags::HOST_VISIBLE.as_raw() | vk::MemoryPropertyFlags::HOST_COHERENT.as_raw(),
);

/// Host memory to copy into and read from.
const CACHED: vk::MemoryPropertyFlags =
    vk::MemoryPropertyFlags::from_raw(HOST.as_raw() | vk::MemoryPropertyFlags::HOST_CACHED.as_raw());

/// Of texel buffers: one that Vulkan demands of every device.
const FORMAT: vk::Format = vk::Format::R32G32B32A32_UINT;
/// Bytes of a texel.
pub(super) const TEXEL_BYTES: u64 = 16;

impl Buffer {
    /// Device memory, mapped as well where the device has such a kind.
    pub(super) fn new(device: &Arc<Device>, name: &str, size_bytes: u64) -> Result<Buffer> {
        let local = vk::MemoryPropertyFlags::DEVICE_LOCAL;
        Buffer::with(device, name, size_bytes, &[local | HOST, local, HOST])
    }

    /// The same, to be read as four words at a time.
    pub(super) fn texels(device: &Arc<Device>, name: &str, size_bytes: u64) -> Result<Buffer> {
        let most = device.info.max_texels;
        if size_bytes > TEXEL_BYTES * most {
            let detail = format!("{size_bytes} bytes asked for, the device reads up to {most} texels");
            return Err(Error::Gpu { op: format!("allocate '{name}'"), detail });
        }
        let mut buffer = Buffer::new(device, name, size_bytes)?;
        let info = vk::BufferViewCreateInfo::default().buffer(buffer.raw).format(FORMAT).range(vk::WHOLE_SIZE);
        // SAFETY: the buffer has the usage, every device reads the format, and Drop destroys the view before the buffer.
        let view = unsafe { device.raw.create_buffer_view(&info, None) };
        buffer.view = view.map_err(|e| gpu_error(&format!("view '{name}'"), e))?;
        Ok(buffer)
    }

    /// Memory of the first of `wishes` that the device has.
    fn with(device: &Arc<Device>, name: &str, size_bytes: u64, wishes: &[vk::MemoryPropertyFlags]) -> Result<Buffer> {
        if size_bytes == 0 || !size_bytes.is_multiple_of(4) || size_bytes > device.info.max_buffer_bytes {
            let detail =
                format!("{size_bytes} bytes asked for, the device allows up to {}", device.info.max_buffer_bytes);
            return Err(Error::Gpu { op: format!("allocate '{name}'"), detail });
        }
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size_bytes).usage(usage);
        let failed = |e| gpu_error(&format!("allocate '{name}' ({size_bytes} bytes)"), e);
        let taken = Taken::new(device, size_bytes).map_err(failed)?;
        let d = &device.raw;
        // SAFETY: each handle is used on the device that made it and destroyed if a later step fails; the memory type
        // is one that the buffer's requirements list; the whole allocation is mapped once and unmapped by freeing it.
        unsafe {
            let raw = d.create_buffer(&info, None).map_err(failed)?;
            let needs = d.get_buffer_memory_requirements(raw);
            let made = (|| {
                let (kind, wish, cached) = memory_type(device, needs.memory_type_bits, wishes)
                    .ok_or(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY)?;
                let allocate = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
                let memory = d.allocate_memory(&allocate, None)?;
                let rest = d.bind_buffer_memory(raw, memory, 0).and_then(|()| {
                    if !wish.contains(HOST) {
                        return Ok(None);
                    }
                    let start = d.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
                    Ok(Some(Mapped(start.cast())))
                });
                rest.map(|mapped| (memory, mapped, cached)).inspect_err(|_| d.free_memory(memory, None))
            })();
            match made {
                Ok((memory, mapped, cached)) => {
                    device.label(raw, name);
                    let (name, device) = (name.into(), device.clone());
                    let view = vk::BufferView::null();
                    Ok(Buffer { raw, view, memory, mapped, cached, size_bytes, name, device, _taken: taken })
                }
                Err(e) => {
                    d.destroy_buffer(raw, None);
                    Err(failed(e))
                }
            }
        }
    }

    /// Size in bytes.
    pub fn size_bytes(&self) -> u64 {
        self.size_bytes
    }

    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<()> {
        assert!(bytes.len() as u64 <= self.size_bytes, "'{}' is smaller than what is written to it", self.name);
        match &self.mapped {
            // SAFETY: the mapping covers the buffer, `bytes` fits, and no submission is in flight (submit() waits).
            Some(start) => unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), start.0, bytes.len()) },
            None => {
                let mut staging = Buffer::with(&self.device, "staging", bytes.len() as u64, &[HOST])?;
                staging.write(bytes)?;
                self.copy(staging.raw, self.raw, bytes.len() as u64)?;
            }
        }
        Ok(())
    }

    pub(super) fn read<T: Pod>(&self) -> Result<Vec<T>> {
        match &self.mapped {
            Some(start) if self.cached => Ok(self.copy_out(start)),
            _ => {
                let staging = Buffer::with(&self.device, "staging", self.size_bytes, &[CACHED, HOST])?;
                self.copy(self.raw, staging.raw, self.size_bytes)?;
                let start = staging.mapped.as_ref().expect("host memory is mapped");
                Ok(staging.copy_out(start))
            }
        }
    }

    /// What this buffer holds, through its mapping at `start`.
    fn copy_out<T: Pod>(&self, start: &Mapped) -> Vec<T> {
        let mut out = vec![T::zeroed(); self.size_bytes as usize / size_of::<T>()];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut out);
        // SAFETY: `bytes` is no longer than the buffer, which the mapping covers; the last submission was waited for
        // and ended with a barrier to the host.
        unsafe { std::ptr::copy_nonoverlapping(start.0, bytes.as_mut_ptr(), bytes.len()) };
        out
    }

    fn copy(&self, from: vk::Buffer, to: vk::Buffer, size_bytes: u64) -> Result<()> {
        let region = [vk::BufferCopy::default().size(size_bytes)];
        self.device.submit(&format!("copy '{}'", self.name), |device, commands| {
            // SAFETY: both buffers have transfer usage, hold at least `size_bytes`, and outlive the wait in submit().
            unsafe { device.cmd_copy_buffer(commands, from, to, &region) };
        })
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: submit() waits, so no submission uses the buffer.
        unsafe {
            self.device.raw.destroy_buffer_view(self.view, None);
            self.device.raw.destroy_buffer(self.raw, None);
            self.device.raw.free_memory(self.memory, None);
        }
    }
}

/// The first memory type that a wish and `allowed` (a bit per type) have in common, the wish, and whether the host has a
/// cache over it.
fn memory_type(
    device: &Device,
    allowed: u32,
    wishes: &[vk::MemoryPropertyFlags],
) -> Option<(u32, vk::MemoryPropertyFlags, bool)> {
    let types = device.memory.memory_types_as_slice();
    wishes.iter().find_map(|wish| {
        let fits = |(i, t): &(usize, &vk::MemoryType)| allowed & (1 << i) != 0 && t.property_flags.contains(*wish);
        let (i, found) = types.iter().enumerate().find(fits)?;
        Some((i as u32, *wish, found.property_flags.contains(vk::MemoryPropertyFlags::HOST_CACHED)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Gpu;

    /// Cards without host-visible device memory copy through a staging buffer; a software device can do so too.
    #[test]
    fn staged_buffer_holds_what_was_written() {
        let Ok(gpu) = Gpu::open("auto", true) else {
            assert!(std::env::var_os("REQUIRE_GPU").is_none(), "REQUIRE_GPU is set, but there is no Vulkan device");
            eprintln!("skipped: no Vulkan device");
            return;
        };
        let data: Vec<u32> = (0..1000).collect();
        let mut buffer = Buffer::with(&gpu.device, "staged", 4000, &[vk::MemoryPropertyFlags::DEVICE_LOCAL]).unwrap();
        assert!(buffer.mapped.is_none());
        gpu.write(&mut buffer, &data).unwrap();
        assert_eq!(gpu.read::<u32>(&buffer).unwrap(), data);
        drop(buffer);
        assert_eq!(gpu.close(), Vec::<String>::new());
    }

    #[test]
    fn impossible_size_is_an_error() {
        let Ok(gpu) = Gpu::open("auto", false) else { return };
        let most = gpu.device.info.max_texels;
        assert!(most >= 65_536, "Vulkan demands it: {most}");
        assert!(Buffer::texels(&gpu.device, "impossible", TEXEL_BYTES * (most + 1)).is_err());
        for size_bytes in [0, 3, u64::MAX - 3] {
            assert!(gpu.buffer("impossible", size_bytes).is_err(), "{size_bytes}");
        }
    }
}
