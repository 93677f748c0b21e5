//! Dabs on a graphics device: intersecting, sets, memory and edit of all dabs of an event are one submission
//! (`shaders/brush_*.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Sections 3 to 5.
//! The device works on blocks of its own; when an event ends, those that changed come back at once, and budget, rings,
//! mips and history are the processor's, so that a stroke has the same undo and journal on either. Coefficients are those
//! of the processor up to one unit in the last place of a half float, colours within 1/255. Only edits whose dabs know of
//! each other by their own texels alone are made together; else the processor's rings come between them.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use half::f16;
use relievo_core::Result;
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, PassTime};
use relievo_surface::{DeviceSurface, Link, RingClass, SURFACE_GROUP};
use relievo_tiles::{Channel, DeviceTiles, Field, Rgba8, Rgba16, TILES_GROUP, Texel};

use super::intersect::DeviceIntersection;
use super::memory::{BlockState, DeviceMemory, MOST_DABS, Memory, Tested};
use crate::edit::TileEdit;
use crate::stamp::Stamp;
use crate::weights::BrushParameters;

/// What a dab does to texels, as in `brush_edit.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Edit {
    rows: [[f32; 4]; 3],
    origin: [f32; 3],
    falloff: u32,
    strength: f32,
    /// What is drawn where the share is 1, object units.
    pub height: f32,
    unit: f32,
    /// The number of the mode.
    pub mode: u32,
    dab: u32,
    room: u32,
    /// Bits, see [`WIDE`] and what follows.
    pub flags: u32,
    /// To the alignment of the colours.
    padding: u32,
    /// The colour of the brush.
    pub color: [f32; 4],
    /// The colour of what is not painted.
    pub blank: [f32; 4],
}

impl Edit {
    /// An edit by a brush in mode 0, without a height and a colour, with the image of the brush if it has one.
    pub fn new(brush: &BrushParameters, stamp: Option<&Stamp>) -> Self {
        let [x, y, z, _] = brush.origin;
        let over = |stamp: &Stamp| if stamp.is_turned_over() { TURNED_OVER } else { 0 };
        Self {
            flags: stamp.map_or(0, |stamp| STAMPED | over(stamp)),
            rows: brush.rows,
            origin: [x, y, z],
            falloff: brush.falloff,
            strength: brush.strength,
            unit: brush.unit(),
            ..Self::zeroed()
        }
    }
}

/// Texels that a device edits.
pub(crate) trait DeviceTexel: Texel {
    /// The module of the kernel that does.
    const MODULE: &'static str;
    /// [`WIDE`] for colours of half floats.
    const FLAGS: u32 = 0;
}

/// As in `brush_edit.wgsl`.
const WIDE: u32 = 1;
const STAMPED: u32 = 2;
const TURNED_OVER: u32 = 4;

impl DeviceTexel for f16 {
    const MODULE: &'static str = "brush_sculpt";
}

impl DeviceTexel for Rgba8 {
    const MODULE: &'static str = "brush_paint";
}

impl DeviceTexel for Rgba16 {
    const MODULE: &'static str = "brush_paint";
    const FLAGS: u32 = WIDE;
}

/// Words of the blocks of an event, as long as it needs no more.
const WORDS: u32 = 1 << 20;

/// Blocks that are read back with an event before it is known how many there are.
const FEW: u32 = 16;

/// What dabs on one kind of texels need of a device, beside the surface, its displacement and the texels themselves. All
/// of it is kept from event to event.
#[derive(Debug)]
pub(crate) struct DeviceBrush<T> {
    kernel: Arc<Kernel>,
    memory: DeviceMemory,
    intersection: DeviceIntersection<T>,
    editing: Bindings,
    /// The image of the brush, and what the device has of it: something, where there is none.
    stamp: Option<Stamp>,
    image: Buffer<[f32; 4]>,
    /// Blocks that the last event used.
    expected: u32,
    /// Dabs of the next event at most.
    most: usize,
}

/// What came back of an event.
#[derive(Debug)]
pub(crate) struct Event<T> {
    pub edits: Vec<TileEdit<T>>,
    /// The tiles that were looked at, ascending.
    pub looked: Vec<u32>,
    /// What each dab found.
    pub tested: Vec<Tested>,
    /// How long its passes took, if the device times.
    pub times: Vec<PassTime>,
}

/// What dabs are made on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage<'a, T: Texel> {
    pub device: &'a Device,
    pub surface: &'a DeviceSurface,
    /// The displacement that places go by, there and here.
    pub ground: (&'a DeviceTiles, &'a Field),
    /// The texels before the event.
    pub tiles: &'a DeviceTiles<T>,
    pub channel: &'a Channel<T>,
}

impl<T: DeviceTexel> DeviceBrush<T> {
    /// For the tiles of `surface` in its pose, which are those of `field`. Fails where the device has no room.
    pub fn new(device: &Device, surface: &DeviceSurface, field: &Field<T>) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = device.kernel(&KernelSpec {
            module: T::MODULE,
            entry: "edit",
            groups: &[&[Read, Read, Read, Read, Write, Write, Write, Read], &SURFACE_GROUP, &TILES_GROUP, &TILES_GROUP],
            immediates: size_of::<Edit>() as u32,
            constants: &[],
        })?;
        let tiles = field.tile_count();
        // Sizes are known when an event comes.
        let memory = DeviceMemory::new(device, tiles, 1, 1)?;
        let intersection = DeviceIntersection::new(device, tiles, &memory)?;
        let image = Buffer::new(device, "image of a brush", 1)?;
        let editing = editing(device, &kernel, &memory, &intersection, &image)?;
        let made = Self { kernel, memory, intersection, editing, stamp: None, image, expected: 0, most: MOST_DABS };
        let mut frame = device.frame()?;
        made.measure(&mut frame.pass("surface.boxes"), surface)?;
        let _ = frame.submit()?;
        Ok(made)
    }

    /// Records the boxes of the tiles of `surface` in its pose.
    pub fn measure(&self, pass: &mut Pass<'_>, surface: &DeviceSurface) -> Result<()> {
        self.intersection.measure(pass, surface)
    }

    /// Makes the first of `edits`, or the first few at once where they may be made `together`, all with the same image of
    /// the brush. `None` if the device cannot hold that, or blocks for all tiles that they reach.
    pub fn event(
        &mut self,
        stage: Stage<'_, T>,
        (edits, stamp): (&[(BrushParameters, Edit)], Option<&Stamp>),
        together: bool,
    ) -> Result<Option<Event<T>>> {
        let Stage { device, ground, channel, .. } = stage;
        let field = channel.field();
        if !self.take_stamp(device, stamp)? {
            return Ok(None);
        }
        if let Some(largest) = self.intersection.update(device, ground.1, field)? {
            let room = ((largest + 2) * (largest + 2) * size_of::<T>() as u32).div_ceil(4);
            if room > self.memory.room() {
                self.make_room(device, room, (WORDS / room).clamp(1, field.tile_count().max(1) as u32))?;
            }
        }
        // Where dabs turned out to be too close, fewer are tried, and then more again.
        let edits = &edits[..edits.len().min(if together { self.most } else { 1 })];
        let Some((states, event)) = self.run(stage, edits)? else { return Ok(None) };
        let apart = apart(channel, &states, edits.len());
        self.most = if apart < edits.len() { apart } else { (2 * self.most).min(MOST_DABS) };
        if apart == edits.len() {
            return Ok(Some(event));
        }
        Ok(self.run(stage, &edits[..apart])?.map(|(_, event)| event))
    }

    fn make_room(&mut self, device: &Device, room: u32, capacity: u32) -> Result<()> {
        self.memory = DeviceMemory::new(device, self.memory.masks.len(), room, capacity)?;
        self.intersection.rebind(device, &self.memory)?;
        self.rebind(device)
    }

    fn rebind(&mut self, device: &Device) -> Result<()> {
        self.editing = editing(device, &self.kernel, &self.memory, &self.intersection, &self.image)?;
        Ok(())
    }

    /// Takes on the image of the brush. False if the device cannot hold it.
    fn take_stamp(&mut self, device: &Device, stamp: Option<&Stamp>) -> Result<bool> {
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

    /// Makes `edits` in one submission, and again with more room if they needed it. Returns the states of the blocks that
    /// changed, and what came back; `None` if the device cannot have that much room.
    fn run(
        &mut self,
        stage: Stage<'_, T>,
        edits: &[(BrushParameters, Edit)],
    ) -> Result<Option<(Vec<BlockState>, Event<T>)>> {
        let Stage { device, surface, ground, tiles, channel } = stage;
        let field = channel.field();
        loop {
            let memory = &self.memory;
            let mut frame = device.frame()?;
            memory.reset(&mut frame)?;
            for (dab, (brush, edit)) in (1..).zip(edits) {
                let edit = Edit { dab, room: memory.room(), flags: edit.flags | T::FLAGS, ..*edit };
                self.intersection.intersect(&mut frame.pass("dab.intersect"), surface, brush)?;
                memory.compact(&mut frame.pass("dab.scan"))?;
                memory.manage_sets(&mut frame.pass("dab.manage"), dab)?;
                let groups = [&self.editing, surface.group(), ground.0.group(), tiles.group()];
                let immediates = bytemuck::bytes_of(&edit);
                let mut pass = frame.pass("dab.edit");
                pass.run_indirect(&self.kernel, &groups, immediates, &memory.header, DeviceMemory::EDIT)?;
            }
            let few = self.expected.max(FEW).min(memory.capacity());
            let header = frame.read(&memory.header, 0..memory.header.len())?;
            let tested = frame.read(&memory.tested, 0..edits.len())?;
            let states = frame.read(&memory.states, 0..few as usize)?;
            let blocks = frame.read(&memory.blocks, 0..(few * memory.room()) as usize)?;
            let times = frame.submit()?.wait()?;
            let header = header.get(device)?;
            let header: Memory = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&header));
            if header.refused > 0 {
                let (room, there) = (memory.room(), memory.capacity());
                let needed = there.saturating_add(header.refused).min(field.tile_count() as u32);
                let limits = device.limits();
                let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
                if needed <= there || DeviceMemory::bytes(room, needed) > most {
                    return Ok(None);
                }
                self.make_room(device, room, needed)?;
                continue;
            }
            let used = header.used(memory.capacity());
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
            let tested = tested.get(device)?;
            let (states, edits, looked) = collect(field, states, &blocks, memory.room());
            return Ok(Some((states, Event { edits, looked, tested, times })));
        }
    }
}

fn editing<T: DeviceTexel>(
    device: &Device,
    kernel: &Kernel,
    memory: &DeviceMemory,
    intersection: &DeviceIntersection<T>,
    image: &Buffer<[f32; 4]>,
) -> Result<Bindings> {
    let bound = [
        memory.compaction.lists().wgpu(),
        memory.compaction.counts().wgpu(),
        memory.pointers.wgpu(),
        intersection.tiles(),
        memory.states.wgpu(),
        memory.blocks.wgpu(),
        memory.tested.wgpu(),
        image.wgpu(),
    ];
    device.bind(kernel, 0, &bound)
}

/// The states of blocks that changed, the edits in them, by ascending tile, and all tiles that had blocks.
fn collect<T: DeviceTexel>(
    field: &Field<T>,
    states: Vec<BlockState>,
    blocks: &[u32],
    room: u32,
) -> (Vec<BlockState>, Vec<TileEdit<T>>, Vec<u32>) {
    let mut used: Vec<(usize, BlockState)> = states.into_iter().enumerate().filter(|(_, it)| it.taken > 0).collect();
    used.sort_unstable_by_key(|(_, it)| (it.tile, it.changes == 0));
    // What was given back and taken again has two blocks, of which one did not change.
    used.dedup_by_key(|(_, it)| it.tile);
    let looked = used.iter().map(|(_, it)| it.tile).collect();
    used.retain(|(_, it)| it.changes > 0);
    let edit = |(index, state): &(usize, BlockState)| {
        let words = &blocks[index * room as usize..][..room as usize];
        let texels = &bytemuck::cast_slice::<u32, T>(words)[..field.class(state.tile).texels()];
        TileEdit { tile: state.tile, texels: texels.into(), count: u64::from(state.changes) }
    };
    let edits = used.iter().map(edit).collect();
    (used.into_iter().map(|(_, it)| it).collect(), edits, looked)
}

/// How many of the `count` dabs of an event, at least one, do together what they do one after the other: the processor
/// equalises texels around some vertices after each of them, and clears those at edges of three or more faces and beside
/// tiles that the budget refuses.
fn apart<T: Texel>(channel: &Channel<T>, changed: &[BlockState], count: usize) -> usize {
    let field = channel.field();
    let topology = field.topology();
    // A tile may want all those around it.
    let wanted: u64 = changed.iter().map(|state| 9 * field.tile_bytes(state.tile)).sum();
    if channel.bytes().saturating_add(wanted) > channel.budget() {
        return 1;
    }
    let mut dabs: BTreeMap<u32, u32> = BTreeMap::new();
    // Those of dabs that may not be made together.
    let mut close: Vec<u32> = Vec::new();
    for state in changed {
        let pinned = |edge: u8| matches!(topology.link(state.tile, edge), Link::Pinned { .. });
        if (0..4).any(pinned) {
            close.push(state.dabs);
        }
        for (ring, bits) in topology.rings(state.tile).iter().zip(state.corners) {
            *dabs.entry(*ring).or_default() |= bits;
        }
    }
    let equalised = |ring: u32| {
        let entries = topology.ring(ring);
        let density = |tile: u32| field.size(tile) << u32::from(topology.is_sub(tile));
        let even = entries.iter().all(|entry| density(entry.tile) == density(entries[0].tile));
        match topology.ring_class(ring) {
            RingClass::Tee => false,
            RingClass::Regular => !even,
            RingClass::Boundary => !even || entries.len() > 2,
            RingClass::Extraordinary | RingClass::Pinned => true,
        }
    };
    close.extend(
        dabs.into_iter().filter(|(_, bits)| bits.count_ones() > 1).filter(|(ring, _)| equalised(*ring)).map(|it| it.1),
    );
    // All before the second of them.
    let before = |bits: u32| (bits & bits.wrapping_sub(1)).trailing_zeros() as usize;
    close.into_iter().map(before).fold(count, usize::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_testing::wgsl::assert_layout;
    use std::mem::offset_of;

    #[test]
    fn the_layout_is_that_of_the_kernels() {
        let rows = offset_of!(Edit, rows);
        let fields = [
            ("row_x", rows),
            ("row_y", rows + 16),
            ("row_z", rows + 32),
            ("origin", offset_of!(Edit, origin)),
            ("falloff", offset_of!(Edit, falloff)),
            ("strength", offset_of!(Edit, strength)),
            ("height", offset_of!(Edit, height)),
            ("unit", offset_of!(Edit, unit)),
            ("mode", offset_of!(Edit, mode)),
            ("dab", offset_of!(Edit, dab)),
            ("room", offset_of!(Edit, room)),
            ("flags", offset_of!(Edit, flags)),
            ("color", offset_of!(Edit, color)),
            ("blank", offset_of!(Edit, blank)),
        ];
        for module in ["brush_sculpt", "brush_paint"] {
            assert_layout(module, "Edit", size_of::<Edit>(), &fields);
        }
    }
}
