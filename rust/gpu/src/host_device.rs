//! What a host program says of a Vulkan device that it made and lends.

use std::ffi::c_void;

/// A function of the host, which gets its own pointer.
pub type HostFunction = unsafe extern "C" fn(*mut c_void);

/// A Vulkan device of the host. Objects are numbers: dispatchable ones as pointers in 64 bits, others as they are.
#[derive(Clone, Copy, Debug)]
pub struct HostDevice {
    /// `vkGetInstanceProcAddr`.
    pub loader: *const c_void,
    /// Version of Vulkan that the instance was made with.
    pub api_version: u32,
    /// `VkInstance`.
    pub instance: u64,
    /// `VkPhysicalDevice`.
    pub physical_device: u64,
    /// `VkDevice`.
    pub device: u64,
    /// Index of the family of the queue.
    pub queue_family: u32,
    /// Index of the queue in its family.
    pub queue_index: u32,
    /// The `VkPhysicalDeviceFeatures` that the device was made with; NULL for none.
    pub features: *const c_void,
    /// Called before the queue is used.
    pub lock: Option<HostFunction>,
    /// Called after the queue was used.
    pub unlock: Option<HostFunction>,
    /// Called once nothing of the library uses the device any more.
    pub released: Option<HostFunction>,
    /// What these functions get.
    pub user: *mut c_void,
}
