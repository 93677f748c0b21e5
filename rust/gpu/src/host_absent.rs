//! Devices of the host in builds that have no Vulkan: every call fails.
#![allow(missing_docs, clippy::missing_safety_doc, reason = "the functions of a build with Vulkan describe them")]

use bytemuck::Pod;
use relievo_core::{Error, Result};

use crate::{Buffer, Device, DeviceOptions, HostDevice};

fn absent() -> Error {
    Error::unsupported("this build has no Vulkan devices")
        .advise("use rlv_context_create, or build for Linux or Windows with the feature `wgpu`")
}

impl Device {
    pub unsafe fn open_host(_: &HostDevice, _: &DeviceOptions) -> Result<Self> {
        Err(absent())
    }

    pub unsafe fn wait_semaphore(&self, _: u64, _: u64) -> Result<()> {
        Err(absent())
    }

    pub unsafe fn signal_semaphore(&self, _: u64, _: u64) -> Result<()> {
        Err(absent())
    }
}

impl<T: Pod> Buffer<T> {
    pub unsafe fn import(_: &Device, _: &str, _: u64, _: u64) -> Result<Self> {
        Err(absent())
    }
}
