//! Dabs on a graphics device: intersecting, sets, memory and edit of all dabs of an event are one submission
//! (`shaders/brush`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Sections 3 to 5.
//! The device works on blocks of its own; when an event ends, changed blocks come back at once, and budget, rings,
//! mips and history are the processor's, so that a stroke has the same undo and journal on either. Coefficients are those
//! of the processor up to one unit in the last place of a half float, colours within 1/255. Between dabs that look at
//! neighbours the device's rings are brought up to date ([`DeviceRing`]), those of vectors too.

use std::collections::BTreeMap;

use relievo_core::Result;
use relievo_gpu::wgsl::brush_edit::Edit;
use relievo_gpu::{Access, Buffer, Device, Frame, KernelSpec, Pass, PassTime};
use relievo_surface::{DeviceSurface, Link, RingClass, SURFACE_GROUP};
use relievo_tiles::{Channel, DeviceRing, DeviceTiles, Field, TILES_GROUP, Texel, Vector};

use super::events::{DeviceEvents, DeviceTile, Ended, Returned, WORDS};
use super::intersect::DeviceIntersection;
use super::memory::{BlockState, DeviceMemory, MAX_DABS, Tested};
use super::smear::{ACCESS, DeviceSmear};
use super::still::DeviceStill;
use crate::paint::edit::TileEdit;
use crate::paint::ground::Ground;
use crate::paint::smudge::Smudge;
use crate::paint::stamp::Stamp;
use crate::paint::vector::BrushMaps;
use crate::paint::weights::BrushParameters;

/// What dabs on the texels of tiles need of a device, beside the surface, its displacement and the texels themselves.
#[derive(Debug)]
pub(crate) struct DeviceBrush<T> {
    events: DeviceEvents,
    intersection: DeviceIntersection<T>,
    still: DeviceStill,
    smear: DeviceSmear,
    /// Of vectors three matrices a dab, see [`BrushMaps`].
    maps: Buffer<[[f32; 4]; 3]>,
    /// Whether places go by vectors.
    bent: bool,
}

/// What kernels have as their group 3: the texels before the event, and the vectors that places go by, or anything.
const EDITED_GROUP: [Access; 4] = [Access::Read; 4];

/// What came back of an event.
#[derive(Debug)]
pub(crate) struct Event<T> {
    pub edits: Vec<TileEdit<T>>,
    /// The tiles that were looked at, ascending.
    pub looked: Vec<u32>,
    /// Where in the memory of the event the blocks of the edits begin.
    pub firsts: Vec<(u32, u32)>,
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
    pub ground: (DeviceGround<'a>, Ground<'a>),
    /// The texels before the event.
    pub tiles: &'a DeviceTiles<T>,
    pub field: &'a Field<T>,
    /// What they are of.
    pub channel: &'a Channel<T>,
    pub ring: &'a DeviceRing,
    /// Whether dabs look at neighbours.
    pub looks_beside: bool,
    /// What brushes that smear carry, and which picture of the device that is, see [`smudges_of`](crate::device::smudges_of).
    pub smudges: &'a [(&'a Smudge, usize)],
    /// Of each dab on vectors how its brush lies.
    pub maps: &'a [BrushMaps],
}

/// [`Ground`] on a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeviceGround<'a> {
    pub heights: &'a DeviceTiles,
    pub vectors: Option<&'a DeviceTiles<Vector>>,
}

impl<T: DeviceTile> DeviceBrush<T> {
    /// For the tiles of `surface` in its pose, which are those of `field`, and places that go by vectors or not. Fails
    /// where the device has no room.
    fn new(device: &Device, surface: &DeviceSurface, field: &Field<T>, bent: bool) -> Result<Self> {
        use Access::{Read, Write};
        // Sculpting has nothing to carry.
        let more = if T::SMEARS { &ACCESS[..] } else { &[Read][..usize::from(T::BENDS)] };
        let own = [&[Read, Read, Read, Write, Write, Write, Read, Read][..], more].concat();
        let kernel = device.kernel(&KernelSpec {
            module: T::MODULE,
            entry: "edit",
            groups: &[&own, &SURFACE_GROUP, &TILES_GROUP, &EDITED_GROUP],
            immediates: size_of::<Edit>() as u32,
            constants: &[("VECTORS", f64::from(u8::from(bent)))],
        })?;
        let tiles = field.tile_count();
        // Sizes are known when an event comes.
        let memory = DeviceMemory::new(device, tiles, (1, 1), false)?;
        let intersection = DeviceIntersection::new(device, tiles, &memory)?;
        let smear = DeviceSmear::new(device)?;
        let maps = Buffer::new(device, "how brushes lie", 3 * MAX_DABS)?;
        let [carried, picked] = smear.tables();
        let tables = [intersection.tiles(), if T::BENDS { maps.wgpu() } else { carried }, picked];
        let events = DeviceEvents::new(device, kernel, memory, &tables[..1 + more.len()])?;
        let made = Self { events, intersection, still: DeviceStill::new(device)?, smear, maps, bent };
        let mut frame = device.frame()?;
        made.measure(&mut frame.pass("surface.boxes"), surface)?;
        let _ = frame.submit()?;
        Ok(made)
    }

    /// `known`, if its places go by vectors or do not as those of `ground`; else one as [`Self::new`].
    pub fn ready(
        known: Option<Self>,
        device: &Device,
        (surface, ground): (&DeviceSurface, DeviceGround<'_>),
        field: &Field<T>,
    ) -> Result<Self> {
        let bent = ground.vectors.is_some();
        known.filter(|known| known.bent == bent).map_or_else(|| Self::new(device, surface, field, bent), Ok)
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
        let Stage { device, ground, field, channel, .. } = stage;
        if !self.events.take_stamp(device, stamp)? {
            return Ok(None);
        }
        if let Some(largest) = self.intersection.update(device, ground.1, field)? {
            let room = ((largest + 2) * (largest + 2) * size_of::<T>() as u32).div_ceil(4);
            if room > self.events.memory().room() {
                self.make_room(device, (room, (WORDS / room).clamp(1, field.tile_count().max(1) as u32)), false)?;
            }
        }
        let memory = self.events.memory();
        if stage.looks_beside && !memory.keeps() {
            self.make_room(device, (memory.room(), memory.capacity()), true)?;
        }
        let edits = &edits[..self.events.tried(edits.len(), together)];
        let Some((states, event)) = self.run(stage, edits)? else { return Ok(None) };
        let smudges = stage.smudges;
        let apart = apart(channel, &states, edits.len(), !smudges.is_empty());
        self.events.learn(edits.len(), apart);
        let event = if apart == edits.len() { Some(event) } else { self.run(stage, &edits[..apart])?.map(|it| it.1) };
        if event.is_some() {
            self.smear.give(device, &smudges[..smudges.len().min(apart)])?;
        }
        Ok(event)
    }

    /// Where the blocks of the last event are.
    pub fn blocks(&self) -> &Buffer<u32> {
        &self.events.memory().blocks
    }

    fn make_room(&mut self, device: &Device, size: (u32, u32), keeps: bool) -> Result<()> {
        self.events.make_room(device, size, keeps)?;
        self.intersection.rebind(device, self.events.memory())
    }

    /// Makes `edits` in one submission, and again with more room if they needed it. Returns the states of the blocks that
    /// changed, and what came back; `None` if the device cannot have that much room.
    fn run(
        &mut self,
        stage: Stage<'_, T>,
        edits: &[(BrushParameters, Edit)],
    ) -> Result<Option<(Vec<BlockState>, Event<T>)>> {
        let Stage { device, surface, ground, tiles, field, ring, looks_beside, smudges, maps, .. } = stage;
        for (dab, maps) in maps.iter().take(edits.len()).enumerate() {
            self.maps.write(device, 3 * dab, &maps.packed())?;
        }
        let bent = ground.0.vectors.map_or(tiles.buffers(), DeviceTiles::buffers);
        let edited = device.bind_as(&EDITED_GROUP, &[tiles.buffers(), bent].concat())?;
        loop {
            // Dabs that were made in vain have left their own.
            self.smear.take(device, smudges)?;
            let groups = [surface.group(), ground.0.heights.group(), &edited];
            let intersection = &self.intersection;
            let intersect = |pass: &mut Pass<'_>, brush: &BrushParameters| intersection.intersect(pass, surface, brush);
            let (memory, sizes) = (self.events.memory(), (intersection.tiles(), tiles));
            let (room, keeps) = (memory.room(), memory.keeps());
            let still = looks_beside.then(|| self.still.bind(device, memory, ring, sizes)).transpose()?;
            let smear = &self.smear;
            let ready = |frame: &mut Frame, events: &DeviceEvents, dab| {
                if !smudges.is_empty() {
                    smear.begin(frame, smudges, dab)?;
                }
                still.as_ref().map_or(Ok(()), |still| still.record(frame, events.memory(), dab))
            };
            match self.events.run(device, (edits, T::FLAGS), groups, intersect, ready)? {
                Ended::Made(made) => {
                    return Ok(Some(collect(field, made, room)));
                }
                Ended::Short(needed) => self.make_room(device, (room, needed), keeps)?,
                Ended::Never => return Ok(None),
            }
        }
    }
}

/// The states of blocks that changed, and the event: the edits in them, by ascending tile, and all tiles that had blocks.
fn collect<T: DeviceTile>(field: &Field<T>, made: Returned, room: u32) -> (Vec<BlockState>, Event<T>) {
    let mut used = made.taken();
    let looked = used.iter().map(|(_, it)| it.tile).collect();
    used.retain(|(_, it)| it.changes > 0);
    let edit = |(index, state): &(usize, BlockState)| {
        let words = &made.blocks[index * room as usize..][..room as usize];
        let texels = &bytemuck::cast_slice::<u32, T>(words)[..field.class(state.tile).texels()];
        TileEdit { tile: state.tile, texels: texels.into(), count: u64::from(state.changes) }
    };
    let edits = used.iter().map(edit).collect();
    let firsts = used.iter().map(|(index, state)| (state.tile, *index as u32 * room)).collect();
    let event = Event { edits, looked, firsts, tested: made.tested, times: made.times };
    (used.into_iter().map(|(_, it)| it).collect(), event)
}

/// How many of the `count` dabs of an event, at least one, do together what they do one after the other: the processor
/// equalises texels around some vertices after each of them, and clears those at edges of three or more faces and beside
/// tiles that the budget refuses. One that `smears` looks at all texels in its box.
fn apart<T: Texel>(channel: &Channel<T>, changed: &[BlockState], count: usize, smears: bool) -> usize {
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
        dabs.into_iter()
            .filter(|(_, bits)| bits.count_ones() > u32::from(!smears))
            .filter(|(ring, _)| equalised(*ring))
            .map(|it| it.1),
    );
    // All before the second of them, or up to the first.
    let before = |bits: u32| match smears {
        true => bits.trailing_zeros() as usize + 1,
        false => (bits & bits.wrapping_sub(1)).trailing_zeros() as usize,
    };
    close.into_iter().map(before).fold(count, usize::min)
}
