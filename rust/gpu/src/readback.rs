//! Items on their way back from a device, through buffers that the host can see and that are used again.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::Pod;
use relievo_core::{Error, Result};

use crate::device::{Device, lock};

/// Bytes of buffers that are kept for the next readback. Larger ones are made when they are needed.
const KEPT: u64 = 1 << 26;

/// A copy of items that a frame makes; [`Readback::get`] is what waits for them.
#[derive(Debug)]
#[must_use]
pub struct Readback<T> {
    pub(crate) host: wgpu::Buffer,
    pub(crate) len: usize,
    pub(crate) item: PhantomData<fn() -> T>,
}

impl<T: Pod> Readback<T> {
    /// Waits for the submission that copies the items and returns them.
    ///
    /// # Errors
    /// Fails with `Device` if the device was lost, and with `Internal` if it does not hand out the items.
    pub fn get(self, device: &Device) -> Result<Vec<T>> {
        let mut items = vec![T::zeroed(); self.len];
        read(device, &self.host, bytemuck::cast_slice_mut(&mut items))?;
        keep(device, self.host);
        Ok(items)
    }
}

/// A buffer of at least `bytes` that nobody uses: one of those kept, or a new one. Sizes are powers of two.
pub(crate) fn host(device: &Device, bytes: u64) -> Result<wgpu::Buffer> {
    let most = device.limits().max_buffer_size;
    let size = bytes.max(256).checked_next_power_of_two().filter(|&size| size <= most).unwrap_or(bytes);
    let kept = {
        let mut kept = lock(&device.inner().readbacks);
        let found = kept.iter().position(|buffer| buffer.size() == size);
        found.map(|index| kept.remove(index))
    };
    if let Some(buffer) = kept {
        return Ok(buffer);
    }
    device.guard(|| {
        device.wgpu().create_buffer(&wgpu::BufferDescriptor {
            label: Some("read"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    })
}

/// Keeps a buffer that was read, in place of those kept longest where they are too many bytes together.
fn keep(device: &Device, buffer: wgpu::Buffer) {
    let mut kept = lock(&device.inner().readbacks);
    kept.push(buffer);
    let mut bytes: u64 = kept.iter().map(wgpu::Buffer::size).sum();
    while bytes > KEPT {
        bytes -= kept.remove(0).size();
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
    let copied = host.get_mapped_range(0..span).map(|view| out.copy_from_slice(&view[..out.len()]));
    host.unmap();
    copied.map_err(|error| Error::internal(error.to_string()))
}
