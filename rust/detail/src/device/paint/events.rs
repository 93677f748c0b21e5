//! Events of a stroke on a graphics device, whatever the surface: the dabs of one are one submission with one readback
//! (`shaders/brush/brush_edit.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Sections 3 to 5.

use std::sync::Arc;

use half::f16;
use relievo_core::Result;
use relievo_gpu::wgsl::brush_edit::Edit;
use relievo_gpu::wgsl::brush_manage::Memory;
use relievo_gpu::{Bindings, Buffer, Device, Frame, Kernel, Pass, PassTime, wgpu};
use relievo_tiles::triangle::Offset;
use relievo_tiles::{Rgba8, Rgba16, Texel, Vector};

use super::memory::{BlockState, DeviceMemory, MAX_DABS, Tested, used};
use crate::paint::stamp::Stamp;
use crate::paint::weights::BrushParameters;

/// Returns an edit by a brush in mode 0, without a height and a colour, with the image of the brush if it has one.
pub(super) fn edit_by(brush: &BrushParameters, stamp: Option<&Stamp>) -> Edit {
    let ([row_x, row_y, row_z], [x, y, z, _]) = (brush.rows, brush.origin);
    let over = |stamp: &Stamp| if stamp.is_turned_over() { TURNED_OVER } else { 0 };
    Edit {
        flags: stamp.map_or(0, |stamp| STAMPED | over(stamp)),
        row_x,
        row_y,
        row_z,
        origin: [x, y, z],
        falloff: brush.falloff,
        strength: brush.strength,
        unit: brush.unit(),
        ..Edit::default()
    }
}

/// Has the kernel leave one of the pictures that brushes carry.
pub(super) fn leave(edit: &mut Edit, picture: usize) {
    edit.flags |= (picture as u32) << SMEAR_SHIFT;
}

/// Has the kernel leave vectors as they are kept, for the dabs that follow in the same event.
pub(crate) fn keep_rounded(edit: &mut Edit) {
    edit.flags |= ROUNDED;
}

/// Texels that a device edits.
pub(crate) trait DeviceTexel: Texel {
    /// Whether kernels paint it, and so may smear.
    const SMEARS: bool = true;
    /// Whether they are vectors, which kernels bend by the axes of the brush.
    const BENDS: bool = false;
    /// [`WIDE`] for colours of half floats.
    const FLAGS: u32 = 0;
}

/// Texels that a device edits on tiles.
pub(crate) trait DeviceTile: DeviceTexel {
    /// The module of the kernel that does.
    const MODULE: &'static str;
}

/// Texels that a device edits on triangles.
pub(crate) trait DeviceValue: DeviceTexel {
    /// The entry point of the kernel that does.
    const TRIANGLES: &'static str;
}

/// As in `brush_edit.wgsl`.
const WIDE: u32 = 1;
const STAMPED: u32 = 2;
const TURNED_OVER: u32 = 4;
const ROUNDED: u32 = 8;
const SMEAR_SHIFT: u32 = 16;

impl DeviceTexel for f16 {
    const SMEARS: bool = false;
}

impl DeviceTile for f16 {
    const MODULE: &'static str = "brush_sculpt";
}

impl DeviceValue for f16 {
    const TRIANGLES: &'static str = "sculpt";
}

impl DeviceTexel for Vector {
    const SMEARS: bool = false;
    const BENDS: bool = true;
}

impl DeviceTile for Vector {
    const MODULE: &'static str = "brush_bend";
}

impl DeviceTexel for Offset {
    const SMEARS: bool = false;
    const BENDS: bool = true;
}

impl DeviceValue for Offset {
    const TRIANGLES: &'static str = "bend";
}

impl DeviceTexel for Rgba8 {}

impl DeviceTile for Rgba8 {
    const MODULE: &'static str = "brush_paint";
}

impl DeviceValue for Rgba8 {
    const TRIANGLES: &'static str = "paint";
}

impl DeviceTexel for Rgba16 {
    const FLAGS: u32 = WIDE;
}

impl DeviceTile for Rgba16 {
    const MODULE: &'static str = "brush_paint";
}

impl DeviceValue for Rgba16 {
    const TRIANGLES: &'static str = "paint";
}

/// Words of the blocks of an event, as long as it needs no more.
pub(super) const WORDS: u32 = 1 << 20;

/// Blocks that are read back with an event before it is known how many there are.
const FIRST_READ: u32 = 16;

/// What events on one kind of texels need of a device, beside what they are made on. All of it is kept from event to
/// event.
#[derive(Debug)]
pub(super) struct DeviceEvents {
    kernel: Arc<Kernel>,
    memory: DeviceMemory,
    editing: Bindings,
    /// What the kernel has as its last bindings.
    tables: Vec<wgpu::Buffer>,
    /// The image of the brush, and what the device has of it: something, where there is none.
    stamp: Option<Stamp>,
    image: Buffer<[f32; 4]>,
    /// Blocks that the last event used.
    expected: u32,
    /// Dabs of the next event at most.
    most: usize,
}

/// What came back of the blocks of an event.
#[derive(Debug)]
pub(crate) struct Returned {
    pub states: Vec<BlockState>,
    /// The words of the blocks.
    pub blocks: Vec<u32>,
    /// What each dab found.
    pub tested: Vec<Tested>,
    /// How long its passes took, if the device times.
    pub times: Vec<PassTime>,
}

/// How an event ended.
#[derive(Debug)]
pub(super) enum Ended {
    /// It is made.
    Made(Returned),
    /// It needs so many blocks, and nothing of it was kept.
    Short(u32),
    /// The device cannot hold the blocks that it needs.
    Never,
}

impl DeviceEvents {
    /// Events by `kernel`, whose group 0 ends with `tables`. Fails where the device has no room.
    pub fn new(device: &Device, kernel: Arc<Kernel>, memory: DeviceMemory, tables: &[&wgpu::Buffer]) -> Result<Self> {
        let image = Buffer::new(device, "image of a brush", 1)?;
        let tables: Vec<wgpu::Buffer> = tables.iter().map(|table| (*table).clone()).collect();
        let editing = editing(device, &kernel, &memory, &image, &tables)?;
        Ok(Self { kernel, memory, editing, tables, stamp: None, image, expected: 0, most: MAX_DABS })
    }

    /// The memory of blocks.
    pub fn memory(&self) -> &DeviceMemory {
        &self.memory
    }

    /// Replaces the memory by one of `capacity` blocks of `room` words, which `keeps` them or not.
    pub fn make_room(&mut self, device: &Device, (room, capacity): (u32, u32), keeps: bool) -> Result<()> {
        self.memory = DeviceMemory::new(device, self.memory.masks.len(), (room, capacity), keeps)?;
        self.rebind(device)
    }

    fn rebind(&mut self, device: &Device) -> Result<()> {
        self.editing = editing(device, &self.kernel, &self.memory, &self.image, &self.tables)?;
        Ok(())
    }

    /// Replaces what the kernel has as its last bindings.
    pub fn set_tables(&mut self, device: &Device, tables: &[&wgpu::Buffer]) -> Result<()> {
        self.tables = tables.iter().map(|table| (*table).clone()).collect();
        self.rebind(device)
    }

    /// Takes on the image of the brush. False if the device cannot hold it.
    pub fn take_stamp(&mut self, device: &Device, stamp: Option<&Stamp>) -> Result<bool> {
        let Some(stamp) = stamp.filter(|stamp| !self.stamp.as_ref().is_some_and(|own| own.is_like(stamp))) else {
            return Ok(true);
        };
        let most = device.limits().max_storage_buffer_binding_size.min(device.limits().max_buffer_size);
        // Where pixels begin is a number of an f32.
        if stamp.pixels() >= 1 << 23 || 16 * (stamp.pixels() as u64 + 64) > most {
            return Ok(false);
        }
        self.image = Buffer::of(device, "image of a brush", &stamp.packed())?;
        self.stamp = Some(stamp.clone());
        self.rebind(device)?;
        Ok(true)
    }

    /// How many of `count` dabs are tried as one event.
    pub fn tried(&self, count: usize, together: bool) -> usize {
        count.min(if together { self.most } else { 1 })
    }

    /// Notes that of `tried` dabs the first `apart` may be made together. Where dabs turned out to be too close, fewer are
    /// tried next, and then more again.
    pub fn learn(&mut self, tried: usize, apart: usize) {
        self.most = if apart < tried { apart } else { (2 * self.most).min(MAX_DABS) };
    }

    /// The bindings of the kernel's group 0.
    pub fn editing(&self) -> &Bindings {
        &self.editing
    }

    /// Makes `edits` in one submission. `intersect` records the sets of a dab, and `ready` what its number, from 1, needs
    /// of this before its edit; `groups` are bound as groups 1 to 3.
    pub fn run(
        &mut self,
        device: &Device,
        (edits, flags): (&[(BrushParameters, Edit)], u32),
        groups: [&Bindings; 3],
        intersect: impl Fn(&mut Pass<'_>, &BrushParameters) -> Result<()>,
        ready: impl Fn(&mut Frame, &Self, u32) -> Result<()>,
    ) -> Result<Ended> {
        let memory = &self.memory;
        let mut frame = device.frame()?;
        memory.reset(&mut frame)?;
        for (dab, (brush, edit)) in (1..).zip(edits) {
            let edit = Edit { dab, room: memory.room(), flags: edit.flags | flags, ..*edit };
            intersect(&mut frame.pass("dab.intersect"), brush)?;
            memory.compact(&mut frame.pass("dab.scan"))?;
            memory.manage_sets(&mut frame.pass("dab.manage"), dab)?;
            ready(&mut frame, self, dab)?;
            let groups = [&self.editing, groups[0], groups[1], groups[2]];
            let immediates = bytemuck::bytes_of(&edit);
            let mut pass = frame.pass("dab.edit");
            pass.run_indirect(&self.kernel, &groups, immediates, &memory.header, DeviceMemory::EDIT)?;
        }
        let few = self.expected.max(FIRST_READ).min(memory.capacity());
        let header = frame.read(&memory.header, 0..memory.header.len())?;
        let tested = frame.read(&memory.tested, 0..edits.len())?;
        let states = frame.read(&memory.states, 0..few as usize)?;
        let blocks = frame.read(&memory.blocks, 0..(few * memory.room()) as usize)?;
        let times = frame.submit()?.wait()?;
        let header = header.get(device)?;
        let header: Memory = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&header));
        if header.refused > 0 {
            let there = memory.capacity();
            let needed = there.saturating_add(header.refused).min(memory.masks.len() as u32);
            let limits = device.limits();
            let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
            let never = needed <= there || memory.bytes(needed) > most;
            return Ok(if never { Ended::Never } else { Ended::Short(needed) });
        }
        let used = used(&header, memory.capacity());
        self.expected = used;
        let (mut states, mut blocks) = (states.get(device)?, blocks.get(device)?);
        if used > few {
            let mut frame = device.frame()?;
            let more = frame.read(&memory.states, few as usize..used as usize)?;
            let words = (few * memory.room()) as usize..(used * memory.room()) as usize;
            let rest = frame.read(&memory.blocks, words)?;
            let _ = frame.submit()?;
            states.extend(more.get(device)?);
            blocks.extend(rest.get(device)?);
        }
        states.truncate(used as usize);
        Ok(Ended::Made(Returned { states, blocks, tested: tested.get(device)?, times }))
    }
}

impl Returned {
    /// The blocks that were taken, by ascending tile or triangle, with their states.
    pub fn taken(&self) -> Vec<(usize, BlockState)> {
        let states = self.states.iter().copied().enumerate();
        let mut taken: Vec<(usize, BlockState)> = states.filter(|(_, it)| it.taken > 0).collect();
        taken.sort_unstable_by_key(|(_, it)| (it.tile, it.changes == 0));
        // What was given back and taken again has two blocks, of which one did not change.
        taken.dedup_by_key(|(_, it)| it.tile);
        taken
    }
}

fn editing(
    device: &Device,
    kernel: &Kernel,
    memory: &DeviceMemory,
    image: &Buffer<[f32; 4]>,
    tables: &[wgpu::Buffer],
) -> Result<Bindings> {
    let mut bound = vec![
        memory.compaction.lists().wgpu(),
        memory.compaction.counts().wgpu(),
        memory.pointers.wgpu(),
        memory.states.wgpu(),
        memory.blocks.wgpu(),
        memory.tested.wgpu(),
        image.wgpu(),
    ];
    bound.extend(tables);
    device.bind(kernel, 0, &bound)
}
