//! What dabs that look at neighbours read on a graphics device (`shaders/brush/brush_still.wgsl`): the blocks of an event as they
//! are before a dab, with the rings that the dabs before it left.

use std::sync::Arc;

use relievo_core::Result;
use relievo_gpu::wgsl::brush_still::Still;
use relievo_gpu::{Access, Bindings, Device, Frame, Kernel, KernelSpec, wgpu};
use relievo_tiles::{BoundRing, DeviceRing, DeviceTiles, Texel, WorkedBlocks};

use super::memory::DeviceMemory;

/// The kernels that make blocks ready for such dabs.
#[derive(Debug)]
pub(super) struct DeviceStill {
    fill: Arc<Kernel>,
    keep: Arc<Kernel>,
}

/// What they are bound to in an event.
#[derive(Debug)]
pub(super) struct BoundStill<'a, T> {
    kernels: &'a DeviceStill,
    ring: (&'a DeviceRing, BoundRing),
    bindings: Bindings,
    blank: T,
}

impl DeviceStill {
    /// Compiles them. Fails if the device is lost.
    pub fn new(device: &Device) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "brush_still",
                entry,
                groups: &[&[Read, Read, Read, Read, Write, Read, Read, Read]],
                immediates: size_of::<Still>() as u32,
                constants: &[],
            })
        };
        Ok(Self { fill: kernel("fill")?, keep: kernel("keep")? })
    }

    /// Binds them to the blocks of `memory`, which has room for the copies, the `sizes` of tiles, and the `tiles`
    /// as they were before the event. Fails if the device does.
    pub fn bind<'a, T: Texel>(
        &'a self,
        device: &Device,
        memory: &DeviceMemory,
        ring: &'a DeviceRing,
        (sizes, tiles): (&wgpu::Buffer, &DeviceTiles<T>),
    ) -> Result<BoundStill<'a, T>> {
        let (lists, counts) = (memory.compaction.lists().wgpu(), memory.compaction.counts().wgpu());
        let [entries, texels] = tiles.buffers();
        let (pointers, blocks) = (&memory.pointers, &memory.blocks);
        let bound = [lists, counts, pointers.wgpu(), memory.states.wgpu(), blocks.wgpu(), sizes, entries, texels];
        let bindings = device.bind(&self.fill, 0, &bound)?;
        let worked = WorkedBlocks { pointers, blocks, sizes, room: memory.room() };
        let rings = ring.bind(device, tiles, (lists, counts), Some(worked))?;
        Ok(BoundStill { kernels: self, ring: (ring, rings), bindings, blank: tiles.field().blank() })
    }
}

impl<T: Texel> BoundStill<'_, T> {
    /// Records that the blocks of `memory` to modify are ready for dab `dab`, from 1.
    pub fn record(&self, frame: &mut Frame, memory: &DeviceMemory, dab: u32) -> Result<()> {
        let halves = size_of::<T>() as u32 / 2;
        // A texel of half a word is there twice.
        let bytes: Vec<u8> = bytemuck::bytes_of(&self.blank).iter().copied().cycle().take(8).collect();
        let blank = [0, 4].map(|at| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]));
        let work = Still { blank, dab, room: memory.room(), halves, padding: 0 };
        let (groups, arguments) = ([&self.bindings], (&memory.header, DeviceMemory::EDIT));
        let mut pass = frame.pass("dab.ring");
        let work = bytemuck::bytes_of(&work);
        pass.run_indirect(&self.kernels.fill, &groups, work, arguments.0, arguments.1)?;
        // Those of the first are as the event found them.
        if dab > 1 {
            self.ring.0.update_indirect(&mut pass, &self.ring.1, self.blank, arguments)?;
        }
        pass.run_indirect(&self.kernels.keep, &groups, work, arguments.0, arguments.1)
    }
}
