// SPDX-License-Identifier: MIT OR Apache-2.0
//! Instance, devices, the one queue, and what the validation layer says.

use std::ffi::{CStr, c_char, c_void};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use ash::{Entry, ext, vk};

use super::inject::Faults;
use crate::error::{Error, Result};

/// A driver that has not finished one dispatch after this long has hung.
const TIMEOUT_NS: u64 = 60_000_000_000;

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What a device is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A card with memory of its own.
    Discrete,
    /// A GPU that shares the processor's memory.
    Integrated,
    /// A GPU seen through a virtual machine.
    Virtual,
    /// Vulkan in software, such as Mesa's lavapipe.
    Software,
    /// Something else.
    Other,
}

impl DeviceKind {
    /// The word shown to users.
    pub fn name(self) -> &'static str {
        match self {
            DeviceKind::Discrete => "discrete",
            DeviceKind::Integrated => "integrated",
            DeviceKind::Virtual => "virtual",
            DeviceKind::Software => "software",
            DeviceKind::Other => "other",
        }
    }
}

/// One Vulkan device with a compute queue.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Position in [`devices`].
    pub index: usize,
    /// The driver's name for it.
    pub name: String,
    /// What it is made of.
    pub kind: DeviceKind,
    /// Its UUID as 32 hexadecimal digits.
    pub uuid: String,
    /// Driver name and version.
    pub driver: String,
    /// Vulkan version, `major.minor.patch`.
    pub api: String,
    /// Largest storage buffer range in bytes.
    pub max_buffer_bytes: u64,
    /// Most texels of 16 bytes in a texel buffer.
    pub max_texels: u64,
    /// Kernels may compute in double precision.
    pub float64: bool,
    raw: vk::PhysicalDevice,
    queue_family: u32,
}

/// All Vulkan devices that can compute, in the driver's order.
pub fn devices() -> Result<Vec<DeviceInfo>> {
    Instance::new(false)?.devices()
}

/// The index of the device that `selector` names.
pub(super) fn select(found: &[DeviceInfo], selector: &str) -> Result<usize> {
    let list = || {
        let lines: Vec<String> = found.iter().map(|d| format!("{}: {} ({})", d.index, d.name, d.kind.name())).collect();
        format!("found: {}; or use `--device cpu`", if lines.is_empty() { "none".into() } else { lines.join(", ") })
    };
    let missing = |what: String| Error::NoDevice { what, help: list() };
    if selector == "auto" {
        return (0..found.len())
            .min_by_key(|i| found[*i].kind)
            .ok_or_else(|| missing("no Vulkan device that can compute".into()));
    }
    if let Ok(index) = selector.parse::<usize>() {
        return if index < found.len() {
            Ok(index)
        } else {
            Err(missing(format!("no Vulkan device has index {index}")))
        };
    }
    let wanted = selector.to_lowercase();
    let plain: String = wanted.chars().filter(|c| *c != '-').collect();
    let fits = |d: &&DeviceInfo| d.uuid == plain || d.name.to_lowercase().contains(&wanted);
    let fitting: Vec<&DeviceInfo> = found.iter().filter(fits).collect();
    match fitting[..] {
        [one] => Ok(one.index),
        [] => Err(missing(format!("no Vulkan device is called '{selector}'"))),
        _ => Err(missing(format!("several Vulkan devices are called '{selector}': name one by index or UUID"))),
    }
}

/// Messages of the validation layer, shared with the callback.
type Messages = Mutex<Vec<String>>;

/// The Vulkan instance and its messenger, which outlive the device so that leaks are reported.
pub(super) struct Instance {
    raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<Messages>,
    faults: Faults,
    // The loaded library: dropped last, after everything that calls into it.
    _entry: Entry,
}

impl Instance {
    pub(super) fn new(validate: bool) -> Result<Arc<Instance>> {
        let faults = Faults::wanted()?;
        // SAFETY: loading the system's Vulkan loader runs its initialisers, which is what any Vulkan program does.
        let entry = unsafe { Entry::load() }.map_err(|e| Error::NoDevice {
            what: format!("no Vulkan loader on this machine ({e})"),
            help: "install a Vulkan driver (Mesa's lavapipe needs no GPU), or use `--device cpu`".into(),
        })?;
        let app = vk::ApplicationInfo::default().application_name(c"brdf-baker").api_version(vk::API_VERSION_1_1);
        let messages: Box<Messages> = Box::default();
        let mut debug = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
            .user_data(&raw const *messages as *mut c_void);
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let layers = [VALIDATION_LAYER.as_ptr()];
        let extensions = [ext::debug_utils::NAME.as_ptr()];
        let mut info = vk::InstanceCreateInfo::default().application_info(&app);
        if validate {
            require_validation_layer(&entry)?;
            info = info
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features)
                .push_next(&mut debug);
        }
        // SAFETY: `info` and all that it points to live until the call returns.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|e| Error::NoDevice {
            what: format!("the Vulkan loader cannot create an instance: {e}"),
            help: "install a Vulkan driver (Mesa's lavapipe needs no GPU), or use `--device cpu`".into(),
        })?;
        let messenger = if validate {
            let loader = ext::debug_utils::Instance::new(&entry, &raw);
            debug.p_next = std::ptr::null();
            // SAFETY: the extension is enabled, and `messages` lives as long as the messenger (both fields of Self).
            let made = unsafe { loader.create_debug_utils_messenger(&debug, None) }
                .map_err(|e| gpu_error("create messenger", e))?;
            Some((loader, made))
        } else {
            None
        };
        Ok(Arc::new(Instance { raw, messenger, messages, faults, _entry: entry }))
    }

    pub(super) fn faults(&self) -> &Faults {
        &self.faults
    }

    pub(super) fn messages(&self) -> Vec<String> {
        self.messages.lock().map(|m| m.clone()).unwrap_or_default()
    }

    pub(super) fn devices(&self) -> Result<Vec<DeviceInfo>> {
        // SAFETY: the instance is alive.
        let all = unsafe { self.raw.enumerate_physical_devices() }.map_err(|e| gpu_error("list devices", e))?;
        Ok(all
            .into_iter()
            .filter_map(|d| self.describe(d))
            .enumerate()
            .map(|(index, d)| DeviceInfo { index, ..d })
            .collect())
    }

    /// Facts about a physical device; `None` when it cannot compute or is older than Vulkan 1.1.
    fn describe(&self, raw: vk::PhysicalDevice) -> Option<DeviceInfo> {
        // SAFETY: `raw` comes from this instance.
        let basic = unsafe { self.raw.get_physical_device_properties(raw) };
        if basic.api_version < vk::API_VERSION_1_1 || self.faults.old_driver.is_some() {
            return None;
        }
        let mut id = vk::PhysicalDeviceIDProperties::default();
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut id);
        if basic.api_version >= vk::API_VERSION_1_2 {
            properties = properties.push_next(&mut driver);
        }
        // SAFETY: the chained structs are core in the device's version (ID: 1.1, driver: 1.2) and outlive the call.
        unsafe { self.raw.get_physical_device_properties2(raw, &mut properties) };
        let limits = properties.properties.limits;
        // SAFETY: `raw` comes from this instance.
        let features = unsafe { self.raw.get_physical_device_features(raw) };
        // SAFETY: `raw` comes from this instance.
        let families = unsafe { self.raw.get_physical_device_queue_family_properties(raw) };
        let queue_family = families.iter().position(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE))?;
        let kind = match basic.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
            vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
            vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
            vk::PhysicalDeviceType::CPU => DeviceKind::Software,
            _ => DeviceKind::Other,
        };
        let version = basic.api_version;
        Some(DeviceInfo {
            index: 0,
            name: text(basic.device_name_as_c_str().ok()),
            kind,
            uuid: id.device_uuid.iter().map(|b| format!("{b:02x}")).collect(),
            driver: format!(
                "{} {}",
                text(driver.driver_name_as_c_str().ok()),
                text(driver.driver_info_as_c_str().ok())
            )
            .trim()
            .to_string(),
            api: format!(
                "{}.{}.{}",
                vk::api_version_major(version),
                vk::api_version_minor(version),
                vk::api_version_patch(version)
            ),
            max_buffer_bytes: u64::from(limits.max_storage_buffer_range)
                .min(self.faults.max_buffer.unwrap_or(u64::MAX)),
            max_texels: limits.max_texel_buffer_elements.into(),
            float64: features.shader_float64 == vk::TRUE,
            raw,
            queue_family: queue_family as u32,
        })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: devices hold an Arc of this instance, so none is alive; the messenger goes before its instance.
        unsafe {
            if let Some((loader, messenger)) = &self.messenger {
                loader.destroy_debug_utils_messenger(*messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn require_validation_layer(entry: &Entry) -> Result<()> {
    // SAFETY: a global query without preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.map_err(|e| gpu_error("list layers", e))?;
    if layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
        return Ok(());
    }
    Err(Error::NoDevice {
        what: "--validate needs the Khronos validation layer, which is not installed".into(),
        help: "install it (Debian: vulkan-validationlayers), or leave --validate out".into(),
    })
}

fn text(s: Option<&CStr>) -> String {
    s.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Collects one message of the validation layer.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes a valid struct with a NUL-terminated message or null; `user` is the `Messages` that
    // Instance keeps until after the messenger is destroyed.
    let (message, messages) = unsafe {
        let message: *const c_char = data.as_ref().map_or(std::ptr::null(), |d| d.p_message);
        let message = if message.is_null() { c"(no text)" } else { CStr::from_ptr(message) };
        (message.to_string_lossy().into_owned(), user.cast::<Messages>().as_ref())
    };
    if let Some(Ok(mut list)) = messages.map(Mutex::lock) {
        list.push(message);
    }
    vk::FALSE
}

/// An open device, its compute queue, and one reusable command buffer.
pub(super) struct Device {
    pub(super) raw: ash::Device,
    pub(super) info: DeviceInfo,
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    pub(super) instance: Arc<Instance>,
    names: Option<ext::debug_utils::Device>,
    queue: Mutex<Queue>,
    /// Submissions so far.
    submissions: AtomicU64,
    /// Bytes that buffers hold.
    pub(super) taken_bytes: AtomicU64,
    /// Of a kernel that had run before.
    pub(super) longest_dispatch_ns: AtomicU64,
}

struct Queue {
    raw: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

impl Device {
    pub(super) fn open(instance: Arc<Instance>, info: &DeviceInfo) -> Result<Device> {
        let priorities = [1.0];
        let queues =
            [vk::DeviceQueueCreateInfo::default().queue_family_index(info.queue_family).queue_priorities(&priorities)];
        let features = vk::PhysicalDeviceFeatures::default().shader_float64(info.float64);
        let create = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_features(&features);
        // SAFETY: the physical device and the family come from this instance; the device has the feature that is asked for,
        // and no extension is.
        let raw = unsafe { instance.raw.create_device(info.raw, &create, None) }
            .map_err(|e| gpu_error(&format!("open {}", info.name), e))?;
        // SAFETY: as above.
        let memory = unsafe { instance.raw.get_physical_device_memory_properties(info.raw) };
        let names = instance.messenger.is_some().then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        let queue = Queue::new(&raw, info.queue_family);
        let queue = match queue {
            Ok(queue) => Mutex::new(queue),
            Err(e) => {
                // SAFETY: nothing made from the device is alive.
                unsafe { raw.destroy_device(None) };
                return Err(gpu_error("create queue", e));
            }
        };
        let [submissions, taken_bytes, longest_dispatch_ns] = [0; 3].map(AtomicU64::new);
        let info = info.clone();
        Ok(Device { raw, info, memory, instance, names, queue, submissions, taken_bytes, longest_dispatch_ns })
    }

    /// Gives an object a name that validation messages show.
    pub(super) fn label<H: vk::Handle>(&self, handle: H, name: &str) {
        let (Some(names), Ok(name)) = (&self.names, std::ffi::CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle belongs to this device and is alive. A refused name costs nothing but the name.
        let _ = unsafe { names.set_debug_utils_object_name(&info) };
    }

    /// Records with `record`, submits, and waits. Whatever ran before is visible to the recorded commands, and their
    /// writes are visible to the host and to later submissions.
    pub(super) fn submit(&self, op: &str, record: impl FnOnce(&ash::Device, vk::CommandBuffer)) -> Result<()> {
        let queue = self.queue.lock().map_err(|_| gpu_error(op, vk::Result::ERROR_UNKNOWN))?;
        let number = 1 + self.submissions.fetch_add(1, Ordering::Relaxed);
        if self.instance.faults.device_lost.is_some_and(|fault| number >= fault) {
            return Err(gpu_error(op, vk::Result::ERROR_DEVICE_LOST));
        }
        let stages = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER;
        let before = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)];
        let after = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::SHADER_WRITE | vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ | vk::AccessFlags::HOST_WRITE)];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let list = [queue.commands];
        let submits = [vk::SubmitInfo::default().command_buffers(&list)];
        // SAFETY: the mutex makes this thread the only user of the command buffer and queue; the fence waited for at the
        // end of the previous call means that the command buffer is not pending. Barriers use stages and access masks
        // that a compute queue supports.
        let run = || unsafe {
            let (d, c) = (&self.raw, queue.commands);
            d.begin_command_buffer(c, &begin)?;
            d.cmd_pipeline_barrier(c, stages, stages, vk::DependencyFlags::empty(), &before, &[], &[]);
            record(d, c);
            let host = vk::PipelineStageFlags::HOST;
            d.cmd_pipeline_barrier(c, stages, host, vk::DependencyFlags::empty(), &after, &[], &[]);
            d.end_command_buffer(c)?;
            d.reset_fences(&[queue.fence])?;
            d.queue_submit(queue.raw, &submits, queue.fence)?;
            d.wait_for_fences(&[queue.fence], true, TIMEOUT_NS)
        };
        run().map_err(|e: vk::Result| gpu_error(op, e))
    }
}

impl Queue {
    fn new(device: &ash::Device, family: u32) -> Result<Queue, vk::Result> {
        let pool_info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: the device was created with one queue of this family; each object is destroyed if a later one fails.
        unsafe {
            let raw = device.get_device_queue(family, 0);
            let pool = device.create_command_pool(&pool_info, None)?;
            let allocate = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let rest = device.allocate_command_buffers(&allocate).and_then(|c| {
                let fence = device.create_fence(&vk::FenceCreateInfo::default(), None)?;
                Ok((c[0], fence))
            });
            match rest {
                Ok((commands, fence)) => Ok(Queue { raw, pool, commands, fence }),
                Err(e) => {
                    device.destroy_command_pool(pool, None);
                    Err(e)
                }
            }
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: buffers and kernels hold an Arc of this device, so they are gone; waiting ends a submission that
        // timed out.
        unsafe {
            let _ = self.raw.device_wait_idle();
            if let Ok(queue) = self.queue.lock() {
                self.raw.destroy_fence(queue.fence, None);
                self.raw.destroy_command_pool(queue.pool, None);
            }
            self.raw.destroy_device(None);
        }
    }
}

/// A failed Vulkan call, in words.
pub(super) fn gpu_error(op: &str, result: vk::Result) -> Error {
    let detail = match result {
        vk::Result::ERROR_DEVICE_LOST => "the device was lost (driver reset, or a dispatch ran too long)".into(),
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => "out of device memory".into(),
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => "out of host memory".into(),
        vk::Result::TIMEOUT => format!("no answer within {} s", TIMEOUT_NS / 1_000_000_000),
        other => format!("{other}"),
    };
    Error::Gpu { op: op.into(), detail }
}
