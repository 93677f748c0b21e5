//! Contexts on a Vulkan device of the host, its buffers and semaphores; see `include/relievo/vulkan.h`.

use std::ffi::{c_char, c_void};

use relievo_core::Error;
use relievo_gpu::{Device, DeviceOptions, HostDevice, HostFunction};

use crate::border::array::{present, put};
use crate::border::descriptor::read_descriptor;
use crate::border::registry;
use crate::runtime::buffer::{self, RlvBuffer};
use crate::runtime::context::{self, RlvContext, RlvContextOptions};
use crate::surfaces::tessellate::RlvTessellation;

/// `RlvVulkanLoader`: `vkGetInstanceProcAddr`.
pub type RlvVulkanLoader = Option<unsafe extern "C" fn(*mut c_void, *const c_char) -> *mut c_void>;

/// `RlvVulkanNotice`: NULL, or a function that gets its user pointer.
pub type RlvVulkanNotice = Option<HostFunction>;

descriptor! {
    pub struct RlvVulkanDevice {
        struct_size: u32,
        api_version: u32,
        queue_family: u32,
        queue_index: u32,
        instance: u64,
        physical_device: u64,
        device: u64,
        loader: RlvVulkanLoader,
        features: *const c_void,
        lock: RlvVulkanNotice,
        unlock: RlvVulkanNotice,
        released: RlvVulkanNotice,
        user: *mut c_void,
    }
}

descriptor! {
    pub struct RlvVulkanBuffers {
        struct_size: u32,
        reserved: u32,
        points: u64,
        point_bytes: u64,
        triangles: u64,
        triangle_bytes: u64,
    }
}

entry! {
    fn rlv_vulkan_create_context(device: *const RlvVulkanDevice, options: *const RlvContextOptions, out: *mut RlvContext) {
        present("out", out)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvVulkanDevice = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(device, default) }?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let options = unsafe { context::read(options) }?;
        let host = HostDevice {
            loader: given.loader.map_or(std::ptr::null(), |loader| loader as *const c_void),
            api_version: given.api_version,
            instance: given.instance,
            physical_device: given.physical_device,
            device: given.device,
            queue_family: given.queue_family,
            queue_index: given.queue_index,
            features: given.features,
            lock: given.lock,
            unlock: given.unlock,
            released: given.released,
            user: given.user,
        };
        let handle = context::make(&options, || {
            let limits = DeviceOptions { memory_limit: options.device_memory_limit, ..DeviceOptions::default() };
            // SAFETY: the header says what the objects have to be.
            let device = unsafe { Device::open_host(&host, &limits) }.map_err(|error| error.at("device"))?;
            Ok(Ok(device))
        })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_vulkan_create_buffer(tessellation: RlvTessellation, buffers: *const RlvVulkanBuffers, out: *mut RlvBuffer) {
        present("out", out)?;
        let tessellation = registry::get(tessellation)?;
        // SAFETY: a descriptor of nothing but numbers.
        let default: RlvVulkanBuffers = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(buffers, default) }?;
        let places = [(given.points, given.point_bytes), (given.triangles, given.triangle_bytes)];
        // SAFETY: the header says what the buffers have to be.
        let handle = registry::insert(unsafe { buffer::on_host(tessellation, places) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_vulkan_wait(context: RlvContext, semaphore: u64, value: u64) {
        let object = registry::get(context)?;
        let device = object.opened_device()?;
        check(semaphore)?;
        // SAFETY: the header says what the semaphore has to be.
        unsafe { device.wait_semaphore(semaphore, value) }
    }

    fn rlv_vulkan_signal(context: RlvContext, semaphore: u64, value: u64) {
        let object = registry::get(context)?;
        let device = object.opened_device()?;
        check(semaphore)?;
        // SAFETY: the header says what the semaphore has to be.
        unsafe { device.signal_semaphore(semaphore, value) }
    }
}

/// Fails at a semaphore that is none.
fn check(semaphore: u64) -> relievo_core::Result<()> {
    if semaphore == 0 {
        return Err(Error::invalid("the VkSemaphore is NULL").at("semaphore").advise("pass a semaphore of the device"));
    }
    Ok(())
}
