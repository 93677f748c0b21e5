//! Memory of the tiles that an event of a stroke works on, managed on a graphics device (`shaders/brush/brush_manage.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 4: every
//! tile is classified, a multi-compaction makes the lists of tiles to modify, to allocate and to deallocate, and each list
//! is a kernel. Blocks are as large as the largest tile needs; they are taken for an event and given back when the next
//! one begins, or as soon as a dab turns out to have only grazed the tile.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::brush_manage::{Manage, Memory};
use relievo_gpu::{Access, Bindings, Buffer, Compaction, Device, Frame, GROUP, Kernel, KernelSpec, Pass, groups};

/// What is known of a block, as in `brush.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct BlockState {
    /// The tile that has it, or had it last.
    pub tile: u32,
    /// The dab, from 1, that it was taken for; 0 if it was not.
    pub taken: u32,
    /// Texels that changed, dab by dab.
    pub changes: u32,
    /// Bits of the dabs that changed texels.
    pub dabs: u32,
    /// Bits of the dabs that changed the texel at each corner. Of triangles, the first has bits of the parts that changed.
    pub corners: [u32; 4],
}

const _: () = assert!(size_of::<BlockState>() == 4 * 8);

/// What a dab found, as in `brush_edit.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Tested {
    pub tiles: u32,
    pub texels: u32,
    /// Texels that changed.
    pub changed: u32,
}

/// Dabs of an event at most: each has a bit.
pub(crate) const MAX_DABS: usize = 32;

/// The sets that tiles are compacted into.
const ALLOCATE: usize = 1;
const DEALLOCATE: usize = 2;
const SETS: usize = 3;

/// A heap of blocks of one size, and which tile has which.
#[derive(Debug)]
pub(crate) struct DeviceMemory {
    kernels: [Arc<Kernel>; 4],
    pub pointers: Buffer<u32>,
    pub masks: Buffer<u32>,
    pub compaction: Compaction,
    pub states: Buffer<BlockState>,
    _free_table: Buffer<u32>,
    /// The words of [`Memory`].
    pub header: Buffer<u32>,
    pub blocks: Buffer<u32>,
    pub tested: Buffer<Tested>,
    buffers: Bindings,
    /// Words of a block.
    room: u32,
    capacity: u32,
    /// Whether there is room to keep all blocks once more.
    keeps: bool,
}

/// The word of a tile without a block.
const NONE: u32 = u32::MAX;

impl DeviceMemory {
    /// `capacity` blocks of `room` words for so many `tiles`, and as much again where it `keeps` them. Fails where the
    /// device has no room.
    pub fn new(device: &Device, tiles: usize, (room, capacity): (u32, u32), keeps: bool) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "brush_manage",
                entry,
                groups: &[&[Read, Read, Write, Write, Write, Write]],
                immediates: size_of::<Manage>() as u32,
                constants: &[],
            })
        };
        let kernels = [kernel("reset")?, kernel("deallocate")?, kernel("allocate")?, kernel("finish")?];
        let count = capacity as usize;
        let words =
            (count << u32::from(keeps)).checked_mul(room as usize).filter(|words| u32::try_from(*words).is_ok());
        let words = words.ok_or_else(|| Error::memory("a dab reaches too many tiles for a graphics device"))?;
        let pointers = Buffer::of(device, "blocks of tiles", &vec![NONE; tiles])?;
        let masks = Buffer::new(device, "sets of tiles", tiles)?;
        let compaction = Compaction::new(device, &masks, SETS)?;
        let states = Buffer::new(device, "states of blocks", count)?;
        let free_table = Buffer::new(device, "free blocks", count)?;
        let header = Buffer::new(device, "memory of dabs", size_of::<Memory>() / size_of::<u32>())?;
        let blocks = Buffer::new(device, "blocks of dabs", words)?;
        let tested = Buffer::new(device, "tested tiles", MAX_DABS)?;
        let bound = [
            compaction.lists().wgpu(),
            compaction.counts().wgpu(),
            pointers.wgpu(),
            states.wgpu(),
            free_table.wgpu(),
            header.wgpu(),
        ];
        let buffers = device.bind(&kernels[0], 0, &bound)?;
        Ok(Self {
            kernels,
            pointers,
            masks,
            compaction,
            states,
            _free_table: free_table,
            header,
            blocks,
            tested,
            buffers,
            room,
            capacity,
            keeps,
        })
    }

    /// Words of a block.
    pub fn room(&self) -> u32 {
        self.room
    }

    /// Number of blocks.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Whether there is room to keep all blocks once more, after the others.
    pub fn keeps(&self) -> bool {
        self.keeps
    }

    /// Bytes of what grows with the capacity, with another one.
    pub fn bytes(&self, capacity: u32) -> u64 {
        let words = u64::from(self.room) << u32::from(self.keeps);
        u64::from(capacity) * (4 * words + 4 + size_of::<BlockState>() as u64)
    }

    fn run(&self, pass: &mut Pass<'_>, kernel: usize, dab: u32, size: [u32; 3]) -> Result<()> {
        pass.run(&self.kernels[kernel], &[&self.buffers], bytemuck::bytes_of(&self.manage(dab)), size)
    }

    fn manage(&self, dab: u32) -> Manage {
        let stride = self.masks.len() as u32;
        Manage { capacity: self.capacity, stride, dab, parts: self.room.div_ceil(GROUP) }
    }

    /// Records that all blocks are free.
    pub fn reset(&self, frame: &mut Frame) -> Result<()> {
        frame.clear(&self.tested);
        self.run(&mut frame.pass("dab.reset"), 0, 0, groups(self.capacity.div_ceil(GROUP).max(1)))
    }

    /// Records the lists of the sets.
    pub fn compact(&self, pass: &mut Pass<'_>) -> Result<()> {
        self.compaction.run(pass, self.masks.len() as u32)
    }

    /// Records that the tiles to deallocate give their blocks back, and that those to allocate get some, for dab `dab`,
    /// from 1.
    pub fn manage_sets(&self, pass: &mut Pass<'_>, dab: u32) -> Result<()> {
        let counts = self.compaction.counts();
        for (kernel, set) in [(1, DEALLOCATE), (2, ALLOCATE)] {
            let work = self.manage(dab);
            let first = self.compaction.arguments(set);
            let kernel = &self.kernels[kernel];
            pass.run_indirect(kernel, &[&self.buffers], bytemuck::bytes_of(&work), counts, first)?;
        }
        self.run(pass, 3, dab, [1, 1, 1])
    }

    /// Where the arguments of the edit's dispatch are in the header.
    pub const EDIT: usize = std::mem::offset_of!(Memory, edit) / size_of::<u32>();
}

/// Returns how many blocks, from the first, were ever taken of a heap with that `capacity`.
pub(super) fn used(memory: &Memory, capacity: u32) -> u32 {
    capacity.saturating_sub(memory.fewest)
}
