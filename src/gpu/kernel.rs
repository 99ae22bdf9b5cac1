// SPDX-License-Identifier: MIT OR Apache-2.0
//! A compute pipeline with its descriptor set.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use ash::vk;

use super::device::{Device, gpu_error};
use super::memory::Buffer;
use crate::error::Result;

/// Vulkan guarantees 128 bytes of push constants on every device.
const MAX_PUSH_BYTES: u32 = 128;

/// Vulkan guarantees this many workgroups a dimension on every device.
pub const MAX_GROUPS: u32 = 65_535;

/// What a kernel reads and writes, in set 0: storage buffers at bindings 0, 1, …, then texel buffers, which it only reads,
/// as four words at a time. Mesa's software Vulkan reads those several times faster where neighbours read unlike places.
#[derive(Clone, Copy, Debug)]
pub struct Bindings {
    /// How many storage buffers.
    pub storage: u32,
    /// How many texel buffers ([`super::Gpu::upload_texels`]).
    pub texel: u32,
}

impl From<u32> for Bindings {
    /// Storage buffers alone.
    fn from(storage: u32) -> Self {
        Bindings { storage, texel: 0 }
    }
}

impl Bindings {
    /// What is at each binding.
    fn kinds(self) -> impl Iterator<Item = vk::DescriptorType> {
        (0..self.storage + self.texel).map(move |binding| match binding {
            _ if binding < self.storage => vk::DescriptorType::STORAGE_BUFFER,
            _ => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        })
    }
}

/// A compute shader, ready to dispatch.
pub struct Kernel {
    name: String,
    bindings: Bindings,
    push_bytes: u32,
    module: vk::ShaderModule,
    set_layout: vk::DescriptorSetLayout,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    /// It ran before: a driver may compile a kernel as late as that.
    compiled: AtomicBool,
    device: Arc<Device>,
}

impl Kernel {
    pub(super) fn new(
        device: &Arc<Device>,
        name: &str,
        spirv: &[u32],
        bindings: Bindings,
        push_bytes: u32,
    ) -> Result<Kernel> {
        assert!(push_bytes > 0 && push_bytes <= MAX_PUSH_BYTES, "'{name}': push block of {push_bytes} bytes");
        // Null handles first: Drop destroys what exists (destroying a null handle does nothing), so a step that fails
        // half-way leaks nothing.
        let mut kernel = Kernel {
            name: name.into(),
            bindings,
            push_bytes,
            module: vk::ShaderModule::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            compiled: AtomicBool::new(false),
            device: device.clone(),
        };
        kernel.build(spirv).map_err(|e| gpu_error(&format!("compile '{name}'"), e))?;
        device.label(kernel.pipeline, name);
        Ok(kernel)
    }

    /// What it was made as.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    fn build(&mut self, spirv: &[u32]) -> Result<(), vk::Result> {
        let d = &self.device.raw;
        let buffer = |(binding, kind)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        let bindings: Vec<_> = (0..).zip(self.bindings.kinds()).map(buffer).collect();
        let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(self.push_bytes)];
        let size = |kind| vk::DescriptorPoolSize::default().ty(kind).descriptor_count(1);
        let sizes: Vec<_> = self.bindings.kinds().map(size).collect();
        // SAFETY: the SPIR-V was compiled by shaderc for Vulkan 1.1; every create info lives until its call returns and
        // refers to handles of this device.
        unsafe {
            self.module = d.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(spirv), None)?;
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            self.set_layout = d.create_descriptor_set_layout(&info, None)?;
            let set_layouts = [self.set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(&push);
            self.layout = d.create_pipeline_layout(&info, None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(self.module)
                .name(c"main");
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
            let made = d.create_compute_pipelines(vk::PipelineCache::null(), &info, None).map_err(|(_, e)| e)?;
            self.pipeline = made[0];
            let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
            self.pool = d.create_descriptor_pool(&info, None)?;
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&set_layouts);
            self.set = d.allocate_descriptor_sets(&info)?[0];
        }
        Ok(())
    }

    pub(super) fn dispatch(
        &self,
        device: &Arc<Device>,
        buffers: &[&Buffer],
        push: &[u8],
        groups: [u32; 3],
    ) -> Result<()> {
        assert!(Arc::ptr_eq(device, &self.device), "kernel '{}' belongs to another device", self.name);
        assert_eq!(buffers.len(), self.bindings.kinds().count(), "kernel '{}': buffers", self.name);
        assert_eq!(push.len(), self.push_bytes as usize, "kernel '{}': push block", self.name);
        assert!(groups.iter().all(|g| (1..=MAX_GROUPS).contains(g)), "kernel '{}': {groups:?} groups", self.name);
        let ranges: Vec<_> =
            buffers.iter().map(|b| [vk::DescriptorBufferInfo::default().buffer(b.raw).range(vk::WHOLE_SIZE)]).collect();
        let views: Vec<_> = buffers.iter().map(|b| [b.view]).collect();
        let writes: Vec<_> = self
            .bindings
            .kinds()
            .enumerate()
            .map(|(binding, kind)| {
                let write = vk::WriteDescriptorSet::default().dst_set(self.set).dst_binding(binding as u32);
                let write = write.descriptor_type(kind);
                if kind == vk::DescriptorType::STORAGE_BUFFER {
                    return write.buffer_info(&ranges[binding]);
                }
                assert!(views[binding] != [vk::BufferView::null()], "kernel '{}': a buffer without a view", self.name);
                write.texel_buffer_view(&views[binding])
            })
            .collect();
        let start = Instant::now();
        let done = device.submit(&format!("dispatch '{}'", self.name), |d, commands| {
            let bind = vk::PipelineBindPoint::COMPUTE;
            // SAFETY: submit() holds the queue's lock and waits for every submission, so the set is in none and no
            // other thread updates it; pipeline, layout and set belong together; the push range is the layout's.
            unsafe {
                d.update_descriptor_sets(&writes, &[]);
                d.cmd_bind_pipeline(commands, bind, self.pipeline);
                d.cmd_bind_descriptor_sets(commands, bind, self.layout, 0, &[self.set], &[]);
                d.cmd_push_constants(commands, self.layout, vk::ShaderStageFlags::COMPUTE, 0, push);
                d.cmd_dispatch(commands, groups[0], groups[1], groups[2]);
            }
        });
        if self.compiled.swap(true, Ordering::Relaxed) {
            device.longest_dispatch_ns.fetch_max(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        }
        done
    }
}

impl Drop for Kernel {
    fn drop(&mut self) {
        let d = &self.device.raw;
        // SAFETY: no submission is in flight; null handles are allowed.
        unsafe {
            d.destroy_descriptor_pool(self.pool, None);
            d.destroy_pipeline(self.pipeline, None);
            d.destroy_pipeline_layout(self.layout, None);
            d.destroy_descriptor_set_layout(self.set_layout, None);
            d.destroy_shader_module(self.module, None);
        }
    }
}
