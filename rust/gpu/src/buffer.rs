//! Typed storage on a device.

use std::marker::PhantomData;
use std::ops::Range;

use bytemuck::Pod;
use relievo_core::{Error, Result};
use wgpu::BufferUsages;

use crate::device::{Charge, Device};

/// `len` items of type `T` on a device, zero at first. Sizes are rounded up to whole 4-byte words.
#[derive(Debug)]
pub struct Buffer<T> {
    raw: wgpu::Buffer,
    len: usize,
    _charge: Charge,
    item: PhantomData<fn() -> T>,
}

/// What the buffers of kernels are used for; more costs nothing on desktop devices.
const USAGES: BufferUsages = BufferUsages::STORAGE
    .union(BufferUsages::COPY_DST)
    .union(BufferUsages::COPY_SRC)
    .union(BufferUsages::INDIRECT)
    .union(BufferUsages::VERTEX)
    .union(BufferUsages::INDEX);

fn rounded(bytes: u64) -> u64 {
    bytes.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT).max(wgpu::COPY_BUFFER_ALIGNMENT)
}

impl<T: Pod> Buffer<T> {
    fn with_usage(device: &Device, label: &str, len: usize, usage: BufferUsages, binding: u64) -> Result<Self> {
        let size = (len as u64).checked_mul(size_of::<T>() as u64).map_or(u64::MAX, |bytes| {
            // wgpu counts in 64 bits: nothing below this overflows by rounding.
            if bytes > u64::MAX / 2 { u64::MAX } else { rounded(bytes) }
        });
        let most = device.limits().max_buffer_size.min(binding);
        if size > most {
            return Err(Error::memory(format!(
                "`{label}` needs a buffer of {size} bytes, and {} has at most {most}",
                device.summary().name
            ))
            .advise("use smaller tiles or a coarser level, or use the device `cpu`"));
        }
        let charge = device.charge(size)?;
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        let raw = device.guard(|| device.wgpu().create_buffer(&descriptor))?;
        Ok(Self { raw, len, _charge: charge, item: PhantomData })
    }

    /// Storage of `len` items that are zero.
    ///
    /// # Errors
    /// Fails with `Memory` above the device's limits for storage, above the memory limit, or if the device has no
    /// memory for it, and with `Device` if the device was lost.
    pub fn new(device: &Device, label: &str, len: usize) -> Result<Self> {
        Self::with_usage(device, label, len, USAGES, device.limits().max_storage_buffer_binding_size)
    }

    /// Storage that holds `items`.
    ///
    /// # Errors
    /// Fails as [`Self::new`] does.
    pub fn of(device: &Device, label: &str, items: &[T]) -> Result<Self> {
        let buffer = Self::new(device, label, items.len())?;
        buffer.write(device, 0, items)?;
        Ok(buffer)
    }

    /// Vertices that are drawn, or their indices, to which no kernel is bound, so that there may be more of them. Zero
    /// at first.
    ///
    /// # Errors
    /// Fails with `Memory` above the device's limit for buffers, above the memory limit, or if the device has no memory
    /// for it, and with `Device` if the device was lost.
    pub fn vertices(device: &Device, label: &str, len: usize) -> Result<Self> {
        let usage = BufferUsages::VERTEX | BufferUsages::INDEX | BufferUsages::COPY_DST;
        Self::with_usage(device, label, len, usage, u64::MAX)
    }

    /// A buffer of wgpu as storage of `len` items.
    #[cfg(not(target_vendor = "apple"))]
    pub(crate) fn around(raw: wgpu::Buffer, len: usize, charge: Charge) -> Self {
        Self { raw, len, _charge: charge, item: PhantomData }
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether it has no items.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The buffer of wgpu.
    pub fn wgpu(&self) -> &wgpu::Buffer {
        &self.raw
    }

    /// Writes `items` from index `first` on, before what is submitted next.
    ///
    /// # Errors
    /// Fails with `Internal` if they do not fit, or do not lie on whole words of 4 bytes, and with `Device` if the
    /// device was lost.
    pub fn write(&self, device: &Device, first: usize, items: &[T]) -> Result<()> {
        if items.is_empty() {
            return Ok(());
        }
        let range = self.bytes(first..first.saturating_add(items.len()))?;
        let bytes: &[u8] = bytemuck::cast_slice(items);
        let whole = bytes.len() / 4 * 4;
        device.guard(|| device.queue().write_buffer(&self.raw, range.start, &bytes[..whole]))?;
        if whole < bytes.len() {
            // The last word of an odd number of halves: what pads it is beyond the last item.
            let mut word = [0; 4];
            word[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
            device.guard(|| device.queue().write_buffer(&self.raw, range.start + whole as u64, &word))?;
        }
        Ok(())
    }

    /// The bytes of a range of items. Fails if they are not all there, or do not begin at a whole word.
    pub(crate) fn bytes(&self, range: Range<usize>) -> Result<Range<u64>> {
        let size = size_of::<T>() as u64;
        if range.start > range.end || range.end > self.len {
            return Err(Error::internal(format!("items {range:?} of a buffer of {} items", self.len)));
        }
        let bytes = range.start as u64 * size..range.end as u64 * size;
        let aligned = bytes.start % 4 == 0 && (bytes.end % 4 == 0 || range.end == self.len);
        if !aligned {
            return Err(Error::internal(format!("items {range:?} of {size} bytes do not lie on whole words")));
        }
        Ok(bytes)
    }
}
