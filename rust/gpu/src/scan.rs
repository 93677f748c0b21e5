//! Exclusive prefix sums of u32, modulo 2³², in place: reduce, scan, distribute (`shaders/scan/scan.wgsl`).

use std::sync::Arc;

use relievo_core::{Error, Result};

use crate::wgsl::scan::Length;
use crate::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, groups};

/// Items of a block, as in the kernels.
pub(crate) const BLOCK: u32 = 8 * crate::GROUP;

/// The number of items as kernels count them: half of what fits, so that groups beyond the last item do not wrap round.
pub(crate) fn capacity_of(items: usize) -> Result<u32> {
    match u32::try_from(items) {
        Ok(items) if items <= 1 << 31 => Ok(items),
        _ => Err(Error::unsupported(format!("{items} items are too many for kernels, which count up to 2³¹"))),
    }
}

/// Prefix sums over a buffer.
#[derive(Debug)]
pub struct Scan {
    kernels: [Arc<Kernel>; 3],
    bindings: Bindings,
    sums: Buffer<u32>,
    capacity: u32,
    lengths: usize,
}

impl Scan {
    /// Prefix sums in place over `items`, for which room is made on the device. `lengths` may say how many there are.
    ///
    /// # Errors
    /// Fails with `Unsupported` for more than 2³¹ items, and as [`Buffer::new`] does.
    pub fn new(device: &Device, items: &Buffer<u32>, lengths: &Buffer<u32>) -> Result<Self> {
        let capacity = capacity_of(items.len())?;
        let sums = Buffer::new(device, "scan sums", capacity.div_ceil(BLOCK) as usize + 1)?;
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "scan",
                entry,
                groups: &[&[Access::Write, Access::Write, Access::Read]],
                immediates: size_of::<Length>() as u32,
                constants: &[],
            })
        };
        let kernels = [kernel("reduce")?, kernel("spine")?, kernel("distribute")?];
        let bindings = device.bind(&kernels[0], 0, &[items.wgpu(), sums.wgpu(), lengths.wgpu()])?;
        Ok(Self { kernels, bindings, sums, capacity, lengths: lengths.len() })
    }

    /// The sums of blocks of 2,048 items; the one after the last block is the sum of all.
    pub fn sums(&self) -> &Buffer<u32> {
        &self.sums
    }

    /// Records the prefix sums of the first `count` items.
    ///
    /// # Errors
    /// Returns the errors of [`Pass::run`]; the immediate data that it passes have the declared size.
    pub fn run(&self, pass: &mut Pass<'_>, count: u32) -> Result<()> {
        self.record(pass, Length { count: count.min(self.capacity), indirect: 0 })
    }

    /// Records the prefix sums of as many items as element `index` of the lengths says, at most as many as there are.
    ///
    /// # Errors
    /// Fails with `Internal` if there is no such length.
    pub fn run_indirect(&self, pass: &mut Pass<'_>, index: usize) -> Result<()> {
        if index >= self.lengths {
            return Err(Error::internal(format!("length {index} of {}", self.lengths)));
        }
        self.record(pass, Length { count: self.capacity, indirect: index as u32 + 1 })
    }

    fn record(&self, pass: &mut Pass<'_>, length: Length) -> Result<()> {
        let immediates = bytemuck::bytes_of(&length);
        let blocks = groups(length.count.div_ceil(BLOCK));
        let [reduce, spine, distribute] = &self.kernels;
        pass.run(reduce, &[&self.bindings], immediates, blocks)?;
        pass.run(spine, &[&self.bindings], immediates, [1, 1, 1])?;
        pass.run(distribute, &[&self.bindings], immediates, blocks)
    }
}
