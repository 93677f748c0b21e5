//! Buffers that are larger than what a device binds at a time: in parts, each a binding of its own.

use bytemuck::Pod;
use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device, Frame, Readback, wgpu};

/// Items in `N` buffers: as many in each as a device binds, and what is left in the last.
#[derive(Debug)]
pub struct Windows<T, const N: usize> {
    parts: [Buffer<T>; N],
    /// Items of all but the last.
    size: u32,
}

impl<T: Pod, const N: usize> Windows<T, N> {
    /// Room for items that are zero, so many bytes of them in a binding. Fails if they are more than the last binding has
    /// room for, and where the device has no memory.
    pub fn new(device: &Device, label: &str, len: usize, bytes: u64) -> Result<Self> {
        let size = (bytes / size_of::<T>() as u64).min(u64::from(u32::MAX)) as u32;
        // A binding is never of nothing.
        let part = |range: std::ops::Range<usize>| Buffer::new(device, label, range.len().max(1));
        let parts = Self::ranges(len, size).map(part).collect::<Result<Vec<_>>>()?;
        let parts = parts.try_into().map_err(|_| Error::internal("buffers of another number"))?;
        Ok(Self { parts, size })
    }

    /// Those of items.
    pub fn of(device: &Device, label: &str, items: &[T], bytes: u64) -> Result<Self> {
        let made = Self::new(device, label, items.len(), bytes)?;
        made.write(device, items)?;
        Ok(made)
    }

    /// Which items are in which part.
    fn ranges(len: usize, size: u32) -> impl Iterator<Item = std::ops::Range<usize>> {
        let start = move |part: usize| part.saturating_mul(size as usize).min(len);
        (0..N).map(move |part| start(part)..if part + 1 == N { len } else { start(part + 1) })
    }

    /// Items of all but the last, as kernels get it.
    pub fn size(&self) -> f64 {
        f64::from(self.size)
    }

    /// Puts items there, as many as there are.
    pub fn write(&self, device: &Device, items: &[T]) -> Result<()> {
        let ranges = Self::ranges(items.len(), self.size);
        self.parts.iter().zip(ranges).try_for_each(|(part, range)| part.write(device, 0, &items[range]))
    }

    /// Records that so many items are copied on their way to the host.
    pub fn read(&self, frame: &mut Frame, len: usize) -> Result<Vec<Readback<T>>> {
        self.parts
            .iter()
            .zip(Self::ranges(len, self.size))
            .map(|(part, range)| frame.read(part, 0..range.len()))
            .collect()
    }

    /// The buffers of wgpu.
    pub fn wgpu(&self) -> [&wgpu::Buffer; N] {
        self.parts.each_ref().map(Buffer::wgpu)
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> usize {
        self.parts.iter().map(|part| part.len() * size_of::<T>()).sum()
    }
}

/// All items that were copied.
pub fn gathered<T: Pod>(device: &Device, parts: Vec<Readback<T>>) -> Result<Vec<T>> {
    let parts = parts.into_iter().map(|part| part.get(device)).collect::<Result<Vec<_>>>()?;
    Ok(parts.concat())
}
