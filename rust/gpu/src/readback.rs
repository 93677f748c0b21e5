//! Items on their way back from a device.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::Pod;
use relievo_core::{Error, Result};

use crate::device::Device;

/// A copy of items that a frame makes; [`Readback::get`] is what waits for them.
#[derive(Debug)]
#[must_use]
pub struct Readback<T> {
    pub(crate) host: wgpu::Buffer,
    pub(crate) len: usize,
    pub(crate) item: PhantomData<fn() -> T>,
}

impl<T: Pod> Readback<T> {
    /// Waits for the submission that copies the items and returns them. Fails if the device was lost.
    pub fn get(self, device: &Device) -> Result<Vec<T>> {
        let mut items = vec![T::zeroed(); self.len];
        read(device, &self.host, bytemuck::cast_slice_mut(&mut items))?;
        Ok(items)
    }
}

/// Waits until `host` may be read, copies its beginning to `out` and releases it.
pub(crate) fn read(device: &Device, host: &wgpu::Buffer, out: &mut [u8]) -> Result<()> {
    if out.is_empty() {
        return device.check();
    }
    let there = Arc::new(AtomicBool::new(false));
    let arrived = Arc::clone(&there);
    let span = (out.len() as u64).next_multiple_of(4);
    device.guard(|| {
        host.map_async(wgpu::MapMode::Read, 0..span, move |result| arrived.store(result.is_ok(), Ordering::Release));
    })?;
    device.wait(None)?;
    if !there.load(Ordering::Acquire) {
        return Err(Error::internal("the graphics device did not hand out what it computed"));
    }
    let view = host.get_mapped_range(0..span).map_err(|error| Error::internal(error.to_string()))?;
    out.copy_from_slice(&view[..out.len()]);
    drop(view);
    host.unmap();
    Ok(())
}
