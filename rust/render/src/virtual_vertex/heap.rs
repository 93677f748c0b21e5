//! Runs of values in one buffer of a device, which keep their place until they have another length; what one leaves,
//! another of the same length takes, last in, first out.

use std::collections::BTreeMap;

use bytemuck::Pod;
use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device, wgpu};

/// The runs and their buffer.
#[derive(Debug)]
pub(super) struct Heap<T> {
    label: &'static str,
    buffer: Buffer<T>,
    /// Where there is room, by length.
    free: BTreeMap<u32, Vec<u32>>,
    /// Values in use, freed ones among them.
    end: u32,
}

impl<T: Pod> Heap<T> {
    /// A heap whose first `fixed` values are in use for good. Fails if there are 2³² or the device has no memory.
    pub fn new(device: &Device, label: &'static str, fixed: usize) -> Result<Self> {
        let end = u32::try_from(fixed).map_err(|_| too_large(label))?;
        Ok(Self { label, buffer: Buffer::new(device, label, fixed.max(1))?, free: BTreeMap::new(), end })
    }

    /// Where a run goes that had `before` values at `first` and now has `needed`. Room for it is made by [`Self::grow`].
    pub fn place(&mut self, first: u32, before: u32, needed: u32) -> Result<u32> {
        if before == needed {
            return Ok(first);
        }
        if before > 0 {
            self.free.entry(before).or_default().push(first);
        }
        if needed == 0 {
            return Ok(0);
        }
        match (self.free.get_mut(&needed).and_then(Vec::pop), self.end.checked_add(needed)) {
            (Some(first), _) => Ok(first),
            (None, Some(end)) => Ok(std::mem::replace(&mut self.end, end)),
            (None, None) => Err(too_large(self.label)),
        }
    }

    /// Makes room for all that was placed, with a quarter more, and moves what is there.
    pub fn grow(&mut self, device: &Device) -> Result<()> {
        let (old, needed) = (self.buffer.len(), self.end as usize);
        if needed > old {
            let larger = Buffer::new(device, self.label, needed + needed / 4)?;
            let mut frame = device.frame()?;
            frame.copy(&self.buffer, 0..old, &larger, 0)?;
            let _ = frame.submit()?;
            self.buffer = larger;
        }
        Ok(())
    }

    /// Writes values from `first` on.
    pub fn write(&self, device: &Device, first: u32, values: &[T]) -> Result<()> {
        self.buffer.write(device, first as usize, values)
    }

    /// What is bound.
    pub fn wgpu(&self) -> &wgpu::Buffer {
        self.buffer.wgpu()
    }
}

fn too_large(label: &str) -> Error {
    Error::memory(format!("`{label}` are too many for a graphics device"))
}

/// Writes what belongs to ascending places, run by run.
pub(super) fn write_runs<T: Pod>(
    device: &Device,
    items: &[(u32, T)],
    write: impl Fn(&Device, u32, &[T]) -> Result<()>,
) -> Result<()> {
    for run in items.chunk_by(|a, b| a.0 + 1 == b.0) {
        let values: Vec<T> = run.iter().map(|(_, value)| *value).collect();
        write(device, run[0].0, &values)?;
    }
    Ok(())
}
