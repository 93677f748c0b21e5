//! Devices of the host: a `VkDevice` that the program made, on which the library works beside it; its buffers, and semaphores
//! between its work and ours.
//!
//! wgpu asks a physical device what it can do and takes all of that as enabled, but a host enables what it needs. So wgpu
//! reaches the host's instance through a table in which three functions answer for the host as long as a device is being
//! opened: there are no extensions, the features are what the host enabled, and the version of Vulkan is at most
//! the instance's. Kernels need nothing beyond Vulkan 1.1.

use std::cell::Cell;
use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ash::vk::{self, Handle};
use bytemuck::Pod;
use relievo_core::{Error, ErrorKind, Result};
use wgpu::hal::api::Vulkan;
use wgpu::{BufferUsages, InstanceFlags, MemoryBudgetThresholds, MemoryHints};

use crate::adapter::DeviceOptions;
use crate::buffer::Buffer;
use crate::choice::summary;
use crate::device::Device;
use crate::host_device::{HostDevice, HostFunction};
use crate::host_queue::{HostQueue, replacement};

/// What is said of the physical device while a device is being opened on this thread.
#[derive(Clone, Copy)]
struct Answers {
    properties: vk::PFN_vkGetPhysicalDeviceProperties,
    api_version: u32,
    features: vk::PhysicalDeviceFeatures,
}

thread_local! {
    static ANSWERS: Cell<Option<Answers>> = const { Cell::new(None) };
}

/// Ends the answers, also where opening fails.
struct Answering;

impl Drop for Answering {
    fn drop(&mut self) {
        ANSWERS.set(None);
    }
}

unsafe extern "system" fn properties(physical: vk::PhysicalDevice, out: *mut vk::PhysicalDeviceProperties) {
    let answers = ANSWERS.get();
    // SAFETY: the caller gives room for one struct, which the driver or the default fills.
    unsafe {
        out.write(vk::PhysicalDeviceProperties::default());
        if let Some(answers) = answers {
            (answers.properties)(physical, out);
            (*out).api_version = (*out).api_version.min(answers.api_version);
        }
    }
}

unsafe extern "system" fn features(_: vk::PhysicalDevice, out: *mut vk::PhysicalDeviceFeatures) {
    // SAFETY: the caller gives room for one struct.
    unsafe { out.write(ANSWERS.get().map(|answers| answers.features).unwrap_or_default()) };
}

unsafe extern "system" fn extensions(
    _: vk::PhysicalDevice,
    _: *const c_char,
    count: *mut u32,
    _: *mut vk::ExtensionProperties,
) -> vk::Result {
    // SAFETY: the caller gives a place for the count.
    unsafe { count.write(0) };
    vk::Result::SUCCESS
}

/// The use of a host's device, which ends when wgpu has let its instance and its device go.
struct Lease {
    _queue: HostQueue,
    /// Whether the host hears of the end: not where opening failed.
    opened: AtomicBool,
    released: Option<HostFunction>,
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back to its owner's function, which the header says runs on any thread.
unsafe impl Send for Lease {}
// SAFETY: as above.
unsafe impl Sync for Lease {}

impl Drop for Lease {
    fn drop(&mut self) {
        if let Some(released) = self.released.filter(|_| self.opened.load(Ordering::Acquire)) {
            // SAFETY: the host gave this function for this pointer.
            unsafe { released(self.user) };
        }
    }
}

fn refused(what: &str, error: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Device, format!("the host's {what} cannot be used: {error}"))
        .advise("use rlv_context_create, which opens a device of its own")
}

/// Fails if something that every host has is missing.
fn check(host: &HostDevice) -> Result<()> {
    let objects = [("instance", host.instance), ("physical_device", host.physical_device), ("device", host.device)];
    if let Some((name, _)) = objects.iter().find(|(_, object)| *object == 0) {
        return Err(Error::invalid("the Vulkan object is NULL").at(*name).advise("pass the object that the host made"));
    }
    if host.loader.is_null() {
        return Err(Error::invalid("the function is NULL").at("loader").advise("pass vkGetInstanceProcAddr"));
    }
    if host.api_version < vk::API_VERSION_1_1 {
        return Err(Error::unsupported("the instance was made with a version of Vulkan below 1.1")
            .at("api_version")
            .advise("make it with VK_API_VERSION_1_1 or later, and pass what VkApplicationInfo had"));
    }
    if host.lock.is_some() != host.unlock.is_some() {
        return Err(Error::invalid("one of lock and unlock is NULL").at("lock").advise("pass both or neither"));
    }
    Ok(())
}

/// Fails if there is no such queue, or if it does not both draw and compute.
fn check_queue(instance: &ash::Instance, host: &HostDevice) -> Result<()> {
    let physical = vk::PhysicalDevice::from_raw(host.physical_device);
    // SAFETY: the caller of `open_host` promises a living instance.
    let there = unsafe { instance.enumerate_physical_devices() }.map_err(|error| refused("instance", error))?;
    if !there.contains(&physical) {
        return Err(Error::invalid("the instance has no such device").at("physical_device"));
    }
    // SAFETY: the physical device is one of the instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    let family = families.get(host.queue_family as usize).ok_or_else(|| {
        Error::invalid(format!("there are {} families of queues, and none {}", families.len(), host.queue_family))
            .at("queue_family")
    })?;
    if host.queue_index >= family.queue_count {
        return Err(Error::invalid(format!(
            "the family has {} queues, and none {}",
            family.queue_count, host.queue_index
        ))
        .at("queue_index"));
    }
    let needed = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    if !family.queue_flags.contains(needed) {
        return Err(Error::unsupported("queues of the family do not both draw and compute")
            .at("queue_family")
            .advise("pass a queue of a family with VK_QUEUE_GRAPHICS_BIT and VK_QUEUE_COMPUTE_BIT"));
    }
    Ok(())
}

fn no_vulkan(device: &Device) -> Error {
    Error::unsupported(format!("{} is not reached through Vulkan", device.summary()))
}

impl Device {
    /// Opens a device on what the host made and keeps. The choice of an adapter in `options` is not read.
    ///
    /// # Errors
    /// Fails with `Invalid` if an object or the loader is NULL, only one of `lock` and `unlock` is set, the instance
    /// has no such device or the device no such queue, or another context works on the queue under another lock; with
    /// `Unsupported` below Vulkan 1.1 or if the queue does not both draw and compute; and with `Device` if wgpu or the
    /// driver refuses the objects.
    ///
    /// # Safety
    /// The objects are alive until `released` is called, belong together and are as described; `loader` is
    /// `vkGetInstanceProcAddr` of their Vulkan; `features` is NULL or points to a `VkPhysicalDeviceFeatures`; the functions
    /// may be called on any thread.
    pub unsafe fn open_host(host: &HostDevice, options: &DeviceOptions) -> Result<Self> {
        check(host)?;
        let handle = vk::Instance::from_raw(host.instance);
        let physical = vk::PhysicalDevice::from_raw(host.physical_device);
        // SAFETY: the caller promises that this is vkGetInstanceProcAddr, and that the instance and the device are alive.
        let (entry, plain, device) = unsafe {
            let get = transmute::<*const c_void, vk::PFN_vkGetInstanceProcAddr>(host.loader);
            let entry = ash::Entry::from_static_fn(ash::StaticFn { get_instance_proc_addr: get });
            let plain = ash::Instance::load(entry.static_fn(), handle);
            check_queue(&plain, host)?;
            let device = ash::Device::load(plain.fp_v1_0(), vk::Device::from_raw(host.device));
            (entry, plain, device)
        };
        // SAFETY: the caller promises that the device has this queue.
        let queue = unsafe { device.get_device_queue(host.queue_family, host.queue_index) };
        let lease = Arc::new(Lease {
            _queue: HostQueue::new(queue, &device, host)?,
            opened: AtomicBool::new(false),
            released: host.released,
            user: host.user,
        });
        let ending = || {
            let lease = Arc::clone(&lease);
            Some(Box::new(move || drop(lease)) as wgpu::hal::DropCallback)
        };
        // SAFETY: NULL or a struct, as the caller promises.
        let enabled = unsafe { host.features.cast::<vk::PhysicalDeviceFeatures>().as_ref() };
        ANSWERS.set(Some(Answers {
            properties: plain.fp_v1_0().get_physical_device_properties,
            api_version: host.api_version,
            features: enabled.copied().unwrap_or_default(),
        }));
        let _answering = Answering;
        // SAFETY: the tables hold functions of the instance and the device, or ours of the same types; the objects outlive
        // wgpu's use of them by the caller's promise, and wgpu does not destroy what has an end of its own. No extension
        // and no feature is used that the host did not enable, since wgpu was told of none.
        unsafe {
            let get = entry.static_fn().get_instance_proc_addr;
            let look = |name: &CStr| match name.to_bytes() {
                b"vkGetPhysicalDeviceProperties" => properties as *const c_void,
                b"vkGetPhysicalDeviceFeatures" => features as *const c_void,
                b"vkEnumerateDeviceExtensionProperties" => extensions as *const c_void,
                _ => transmute::<vk::PFN_vkVoidFunction, *const c_void>(get(handle, name.as_ptr())),
            };
            let instance = wgpu::hal::vulkan::Instance::from_raw(
                entry.clone(),
                ash::Instance::load_with(look, handle),
                host.api_version,
                0,
                None,
                Vec::new(),
                InstanceFlags::empty(),
                MemoryBudgetThresholds::default(),
                false,
                ending(),
            )
            .map_err(|error| refused("instance", error))?;
            let exposed =
                instance.expose_adapter(physical).ok_or_else(|| refused("device", "wgpu does not support it"))?;
            let get = plain.fp_v1_0().get_device_proc_addr;
            let look = |name: &CStr| {
                replacement(name).unwrap_or_else(|| {
                    transmute::<vk::PFN_vkVoidFunction, *const c_void>(get(device.handle(), name.as_ptr()))
                })
            };
            let wanted = Self::features(exposed.features);
            let opened = exposed
                .adapter
                .device_from_raw(
                    ash::Device::load_with(look, device.handle()),
                    ending(),
                    &[],
                    wanted,
                    &exposed.capabilities.limits,
                    &MemoryHints::default(),
                    host.queue_family,
                    host.queue_index,
                )
                .map_err(|error| refused("device", error))?;
            let instance = wgpu::Instance::from_hal::<Vulkan>(instance);
            let adapter = instance.create_adapter_from_hal(exposed);
            let summary = summary(&adapter);
            let descriptor = Self::descriptor(&adapter);
            let (device, queue) =
                adapter.create_device_from_hal(opened, &descriptor).map_err(|error| refused("device", error))?;
            lease.opened.store(true, Ordering::Release);
            Ok(Self::assemble(instance, adapter, summary, device, queue, options))
        }
    }

    /// Has what is submitted from now on wait until `semaphore` is signalled, a timeline semaphore with `value`, a
    /// binary one where that is 0.
    ///
    /// # Errors
    /// Fails with `Device` if the device was lost, and with `Unsupported` if it is not reached through Vulkan.
    ///
    /// # Safety
    /// It is a semaphore of the device, of the kind that `value` says, and lives until the wait is over. Its signal
    /// is submitted.
    pub unsafe fn wait_semaphore(&self, semaphore: u64, value: u64) -> Result<()> {
        let frame = self.frame()?;
        {
            // SAFETY: nothing that is reached through it is destroyed.
            let queue = unsafe { self.queue().as_hal::<Vulkan>() }.ok_or_else(|| no_vulkan(self))?;
            let semaphore = vk::Semaphore::from_raw(semaphore);
            queue.add_wait_semaphore(semaphore, (value > 0).then_some(value), vk::PipelineStageFlags::ALL_COMMANDS);
        }
        let _ = frame.submit()?;
        Ok(())
    }

    /// Signals `semaphore`, a timeline semaphore with `value`, a binary one where that is 0, once all that was
    /// submitted is done.
    ///
    /// # Errors
    /// Fails with `Device` if the device was lost, and with `Unsupported` if it is not reached through Vulkan.
    ///
    /// # Safety
    /// It is a semaphore of the device, of the kind that `value` says, that may be signalled, and lives until it is.
    pub unsafe fn signal_semaphore(&self, semaphore: u64, value: u64) -> Result<()> {
        let frame = self.frame()?;
        {
            // SAFETY: nothing that is reached through it is destroyed.
            let queue = unsafe { self.queue().as_hal::<Vulkan>() }.ok_or_else(|| no_vulkan(self))?;
            queue.add_signal_semaphore(vk::Semaphore::from_raw(semaphore), (value > 0).then_some(value));
        }
        let _ = frame.submit()?;
        Ok(())
    }
}

impl<T: Pod> Buffer<T> {
    /// The `VkBuffer` of the host in `handle`, as storage of as many items as `bytes` hold; it is written and read by
    /// copies, and does not count as memory of the device.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is NULL, or `bytes` hold no item or exceed the device's limit, with
    /// `Unsupported` if the device is not reached through Vulkan, and with `Device` if it was lost.
    ///
    /// # Safety
    /// It is a buffer of the device with memory of `bytes` bytes, may be the source and target of transfers, and lives until
    /// the result is dropped and what was submitted is done.
    pub unsafe fn import(device: &Device, label: &str, handle: u64, bytes: u64) -> Result<Self> {
        let len = bytes / size_of::<T>() as u64;
        let size = len * size_of::<T>() as u64 / 4 * 4;
        if handle == 0 {
            return Err(Error::invalid("the VkBuffer is NULL")
                .at(label)
                .advise("pass a VkBuffer of the host's device, with memory bound to it"));
        }
        let most = device.limits().max_buffer_size;
        if size == 0 || size > most {
            let least = (size_of::<T>() as u64).next_multiple_of(4);
            return Err(Error::invalid(format!("the VkBuffer is given with {bytes} bytes"))
                .at(label)
                .advise(format!("pass one of {least} to {most} bytes")));
        }
        let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        let charge = device.charge(0)?;
        // SAFETY: the caller promises a buffer of this size and usage; the device was asked whether it is Vulkan's.
        let raw = unsafe {
            if device.wgpu().as_hal::<Vulkan>().is_none() {
                return Err(no_vulkan(device));
            }
            let raw = vk::Buffer::from_raw(handle);
            let raw = wgpu::hal::vulkan::Buffer::from_raw_externally_owned(raw, Box::new(|| ()));
            device.guard(|| device.wgpu().create_buffer_from_hal::<Vulkan>(raw, &descriptor))?
        };
        Ok(Self::around(raw, len as usize, charge))
    }
}
