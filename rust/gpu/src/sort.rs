//! A stable radix sort of u32 keys with u32 values (`shaders/scan/sort.wgsl`).

use std::sync::Arc;

use relievo_core::{Error, Result};

use crate::scan::{BLOCK, Scan, capacity_of};
use crate::wgsl::sort::Digit;
use crate::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, groups, wgpu};

/// Bits of a pass over the keys.
const BITS: u32 = 4;

/// A sort of the keys and values of two buffers, in place.
#[derive(Debug)]
pub struct Sort {
    count: Arc<Kernel>,
    shuffle: Arc<Kernel>,
    /// From the caller's buffers to ours, and back.
    bindings: [Bindings; 2],
    scan: Scan,
    _spare: [Buffer<u32>; 2],
    _histogram: Buffer<u32>,
    capacity: u32,
}

impl Sort {
    /// A sort of `keys` and `values`, which are as many.
    ///
    /// # Errors
    /// Fails with `Internal` if there are not as many values as keys, with `Unsupported` for more than 2³¹ of them, and
    /// as [`Buffer::new`] does: it needs as much memory again.
    pub fn new(device: &Device, keys: &Buffer<u32>, values: &Buffer<u32>) -> Result<Self> {
        if keys.len() != values.len() {
            return Err(Error::internal(format!("{} keys and {} values to sort", keys.len(), values.len())));
        }
        let capacity = capacity_of(keys.len())?;
        let spare = |label| Buffer::new(device, label, keys.len());
        let spare = [spare("sort keys")?, spare("sort values")?];
        let blocks = capacity.div_ceil(BLOCK) as usize;
        let histogram = Buffer::new(device, "sort histogram", blocks << BITS)?;
        let scan = Scan::new(device, &histogram, &spare[0])?;
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "sort",
                entry,
                groups: &[&[Access::Read, Access::Read, Access::Write, Access::Write, Access::Write]],
                immediates: size_of::<Digit>() as u32,
                constants: &[],
            })
        };
        let [count, shuffle] = [kernel("count")?, kernel("move_keys")?];
        let [ours, theirs] = [[spare[0].wgpu(), spare[1].wgpu()], [keys.wgpu(), values.wgpu()]];
        let bind = |from: [&wgpu::Buffer; 2], to: [&wgpu::Buffer; 2]| {
            device.bind(&count, 0, &[from[0], from[1], to[0], to[1], histogram.wgpu()])
        };
        let bindings = [bind(theirs, ours)?, bind(ours, theirs)?];
        Ok(Self { count, shuffle, bindings, scan, _spare: spare, _histogram: histogram, capacity })
    }

    /// Records the sort of the first `count` keys, of which the lowest `bits` bits differ. Equal keys keep their order.
    ///
    /// # Errors
    /// Returns the errors of [`Pass::run`]; the immediate data that it passes have the declared size.
    pub fn run(&self, pass: &mut Pass<'_>, count: u32, bits: u32) -> Result<()> {
        let count = count.min(self.capacity);
        let blocks = count.div_ceil(BLOCK);
        // There and back again, so that the result lies where the keys were.
        let passes = bits.min(u32::BITS).div_ceil(BITS).next_multiple_of(2);
        for (turn, bindings) in (0..passes).zip(self.bindings.iter().cycle()) {
            let digit = Digit { count, shift: turn * BITS, blocks };
            let immediates = bytemuck::bytes_of(&digit);
            pass.run(&self.count, &[bindings], immediates, groups(blocks))?;
            self.scan.run(pass, blocks << BITS)?;
            pass.run(&self.shuffle, &[bindings], immediates, groups(blocks))?;
        }
        Ok(())
    }
}
