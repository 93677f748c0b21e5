//! An imprint of a submission, as kernels are told of it (`shaders/imprint_link.wgsl`), and what they tell. All imprints
//! of a submission are told of at once, so that a dispatch needs no more than the number of its imprint.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Buffer, Device, Frame, Readback};

use super::meshes::Place;
use super::rim::Rising;
use super::smoothing::Work;
use super::voxel::{MOST_NARROW, VoxelRoom};
use crate::collider::Collider;
use crate::cull::VoxelFrame;
use crate::grid::Grid;
use crate::imprint::ImprintSettings;
use crate::lattice::Lattice;
use crate::raycast::{Limits, deepest};
use crate::voxel::Side;

/// An imprint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// Which of the objects it is pressed into.
    pub target: usize,
    /// Which collider, how many triangles it has, and where it is.
    pub mesh: u64,
    pub triangles: u64,
    transform: DAffine3,
    side: Side,
    pub grid: Grid,
    limits: Limits,
    lattice: Lattice,
    /// How strongly what changed is smoothed for those after it, and in how many passes.
    pub smoothing: (f32, u32),
    /// What it raises.
    pub rising: Option<Rising>,
}

/// Voxels from the grid within which kernels place points, less what rounding takes.
const FAR: f64 = 65_000.0;

impl Link {
    /// The imprint of `collider`, where it is now, on one of the targets. `None` where not all of it is near enough to the
    /// grid for a device: at a first touch voxels may be tiny.
    pub fn new(context: &Context, target: usize, collider: &Collider, grid: &Grid, limits: &Limits) -> Option<Self> {
        let corners = collider.obb().corners();
        let near = corners.into_iter().all(|it| grid.map.transform_point3(it).abs().max_element() < FAR);
        let lattice = collider.lattice(grid).filter(|_| near)?;
        // Of a closed mesh either side will do.
        let side = if collider.is_closed() { Side::Forward } else { collider.side(context, grid).0 };
        Some(Self::of(target, collider, grid, limits, side, lattice))
    }

    /// The same, with what changed smoothed as `settings` say.
    pub fn smoothed(self, settings: &ImprintSettings) -> Self {
        let passes = if settings.smoothing > 0.0 { settings.smoothing_passes } else { 0 };
        Self { smoothing: (settings.smoothing, passes), ..self }
    }

    /// The imprint whose columns come from `side`, with the points on `lattice`.
    pub fn of(target: usize, collider: &Collider, grid: &Grid, limits: &Limits, side: Side, lattice: Lattice) -> Self {
        Self {
            target,
            mesh: collider.identity[0],
            triangles: collider.triangles().len() as u64,
            transform: *collider.transform(),
            side,
            grid: *grid,
            limits: *limits,
            lattice,
            smoothing: (0.0, 0),
            rising: None,
        }
    }

    /// The same on another of the targets.
    pub fn of_target(self, target: usize) -> Self {
        Self { target, ..self }
    }

    /// As an imprint of these settings, whose limits it has.
    pub fn raising(self, settings: &ImprintSettings) -> Self {
        Self { rising: Rising::of(settings), ..self }
    }
}

/// As `Link` in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Words {
    lattice_x: [i32; 3],
    points: u32,
    lattice_y: [i32; 3],
    shift: u32,
    lattice_z: [i32; 3],
    scale: f32,
    lattice_origin: [i32; 3],
    first_point: u32,
    lattice_low: [u32; 3],
    first_index: u32,
    lattice_high: [u32; 3],
    triangles: u32,
    dims: [u32; 3],
    flags: u32,
    x: [f32; 4],
    y: [f32; 4],
    z: [f32; 4],
    origin: [f32; 3],
    tiles: u32,
    share: f32,
    max_displacement: f32,
    depth: f32,
    deepest: i32,
    pub first_corner: u32,
    pub first_work: u32,
    slots: u32,
    stride: u32,
    room: u32,
    records: u32,
    zero: u32,
    first_turn: u32,
    first_column: u32,
    first_word: u32,
    next: u32,
    wave: u32,
    strength: f32,
    block_words: u32,
    blocks: u32,
    parts: u32,
    ring_parts: u32,
    rings: u32,
    entries: u32,
    unused: u32,
}

/// No imprint.
const NONE: u32 = u32::MAX;

const BACKWARD: u32 = 1;
const OPEN: u32 = 2;
const MIRRORED: u32 = 4;
const STARTED: u32 = 8;
const CHAINED: u32 = 16;
const WORKED: u32 = 32;
const NARROW: u32 = 64;
/// Something rises, so that blocks look at others: kernels do not ask.
const RISING: u32 = 128;

/// Where the slots of an object are: of every tile what imprints left of it and of its blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slots {
    pub base: u32,
    /// Slots of a tile.
    pub stride: u32,
}

/// The object of an imprint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground<'a> {
    pub transform: &'a DAffine3,
    pub tiles: usize,
    /// Whether the depth limit counts from another displacement than there is.
    pub started: bool,
    /// Where earlier imprints of the submission leave blocks, if others look at them.
    pub slots: Option<Slots>,
}

/// The way to voxel coordinates, and its rows as kernels have them.
fn view(grid: &Grid, transform: &DAffine3) -> (VoxelFrame, [[f32; 4]; 3]) {
    let view = VoxelFrame::new(grid, transform);
    let row = |axis: usize| {
        let [x, y, z] = view.rows[axis];
        [x, y, z, view.shift[axis]]
    };
    (view, [0, 1, 2].map(row))
}

impl Words {
    /// What kernels are told of `link`, whose collider is at `place`.
    pub fn new(link: &Link, place: &Place, ground: &Ground<'_>) -> Self {
        let Link { lattice: Lattice { rows, shift, scale, origin, offset }, grid, limits, .. } = link;
        let (view, [x, y, z]) = view(grid, ground.transform);
        let flag = |condition: bool, flag: u32| if condition { flag } else { 0 };
        let mirrored = (grid.map * link.transform).matrix3.determinant() < 0.0;
        let flags = flag(link.side == Side::Backward, BACKWARD)
            | flag(!place.closed, OPEN)
            | flag(mirrored, MIRRORED)
            | flag(ground.started, STARTED)
            | flag(ground.slots.is_some(), CHAINED)
            | flag(place.triangles.len() <= MOST_NARROW as usize, NARROW)
            | flag(link.rising.is_some(), RISING);
        let Slots { base, stride } = ground.slots.unwrap_or(Slots { base: 0, stride: 0 });
        Self {
            lattice_x: rows[0],
            points: place.points.len() as u32,
            lattice_y: rows[1],
            shift: *shift,
            lattice_z: rows[2],
            scale: *scale,
            lattice_origin: *origin,
            first_point: place.points.start,
            lattice_low: offset.map(|it| it as u32),
            first_index: 3 * place.triangles.start,
            lattice_high: offset.map(|it| (it >> 32) as u32),
            triangles: place.triangles.len() as u32,
            dims: grid.dims,
            flags,
            x,
            y,
            z,
            origin: view.origin,
            tiles: ground.tiles as u32,
            share: limits.share,
            max_displacement: limits.max_displacement,
            depth: limits.depth,
            deepest: deepest(limits).into(),
            first_corner: 0,
            first_work: 0,
            slots: base,
            stride,
            room: 0,
            records: 0,
            zero: 0,
            first_turn: 0,
            first_column: 0,
            first_word: 0,
            next: NONE,
            wave: 0,
            strength: link.smoothing.0,
            block_words: 0,
            blocks: 0,
            parts: 0,
            ring_parts: 0,
            rings: 0,
            entries: 0,
            unused: 0,
        }
    }

    /// Says how many blocks, records and blocks of tiles there is room for.
    pub fn set_room(&mut self, room: [usize; 3]) {
        [self.room, self.records, self.blocks] = room.map(|count| count as u32);
    }

    /// Has imprints before it, and after it, of the submission meet in blocks of tiles, which are worked on.
    pub fn work_on(&mut self, work: &Work) {
        self.flags = self.flags & !CHAINED | WORKED;
        self.block_words = work.words;
        [self.parts, self.ring_parts, self.rings, self.entries] =
            [work.parts, work.ring_parts, work.rings, work.entries];
    }

    /// The same imprint in another grid, by itself.
    pub fn in_grid(&self, grid: &Grid, transform: &DAffine3) -> Self {
        let (view, [x, y, z]) = view(grid, transform);
        Self { dims: grid.dims, x, y, z, origin: view.origin, next: NONE, ..*self }
    }

    /// Whether imprints before it, or after it, of the submission meet the same object.
    pub fn is_chained(&self) -> bool {
        self.flags & (CHAINED | WORKED) != 0
    }

    /// Words of a block of tiles that are worked on.
    pub fn block_words(&self) -> usize {
        self.block_words as usize
    }

    /// Whether it may be taken together with others of the same object.
    fn is_for_row(&self) -> bool {
        self.flags & (RISING | WORKED) == 0
    }
}

/// Imprints that are submitted together at most.
pub(crate) const MOST_LINKS: usize = 64;

/// Points and triangles that are on the lattices of several imprints at once, and words of winding numbers, unless one
/// alone has more: 320 MiB, which hold eight grids of 2²⁴ voxels.
const MOST_PLACED: usize = 1 << 22;
const MOST_VOXELS: usize = 5 << 24;

/// Imprints whose winding numbers are there at once.
#[derive(Clone, Debug)]
pub(super) struct Wave {
    pub links: Range<usize>,
    /// The largest number of columns.
    pub columns: u32,
    /// Winding numbers.
    turns: usize,
}

/// Imprints that are voxelised together, and whose voxels are there at once.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    pub links: Range<usize>,
    /// The largest numbers of points and of triangles.
    pub most: [u32; 2],
    /// Room that they need.
    pub room: VoxelRoom,
    pub waves: Vec<Wave>,
    /// The first imprint of every row: the next of the same object follow it by `Link.next`, up to one that raises
    /// something, which is a row of its own, as is every imprint of an object whose tiles are worked on.
    pub rows: Vec<usize>,
}

impl Batch {
    /// Of no imprint so far, from `index` on.
    fn from(index: usize) -> Self {
        Self { links: index..index, most: [0; 2], room: VoxelRoom::default(), waves: Vec::new(), rows: Vec::new() }
    }
}

/// Winding numbers that are there at once at most: no more than a buffer of `device` holds.
pub(super) fn most_voxels(device: &Device) -> usize {
    let held = device.limits().max_storage_buffer_binding_size / size_of::<u32>() as u64;
    usize::try_from(held).map_or(MOST_VOXELS, |held| held.min(MOST_VOXELS))
}

/// Says where the points, the work and the voxels of every imprint lie, and which is the next one of the same target, of
/// which `targets` tells for every imprint. There are no more winding numbers, and no more words of voxels, at once than
/// `most_voxels`, unless one imprint alone has more. Fails for a grid that is too wide.
pub(super) fn batches(words: &mut [Words], targets: &[usize], most_voxels: usize) -> Result<Vec<Batch>> {
    let mut batches: Vec<Batch> = Vec::new();
    for index in 0..words.len() {
        let it = &mut words[index];
        let own = VoxelRoom::of(it.points, it.triangles, it.dims)?;
        let VoxelRoom([points, items, turns, columns, bits]) = own;
        let fits = |batch: &&mut Batch| {
            let VoxelRoom([corners, work, _, _, words]) = batch.room;
            corners + work + points + items <= MOST_PLACED && words + bits <= most_voxels
        };
        let batch = match batches.last_mut().filter(fits) {
            Some(batch) => batch,
            None => {
                batches.push(Batch::from(index));
                let last = batches.len() - 1;
                &mut batches[last]
            }
        };
        let wave = match batch.waves.last_mut().filter(|wave| wave.turns + turns <= most_voxels) {
            Some(wave) => wave,
            None => {
                batch.waves.push(Wave { links: index..index, columns: 0, turns: 0 });
                let last = batch.waves.len() - 1;
                &mut batch.waves[last]
            }
        };
        let VoxelRoom([corner, work, _, column, word]) = batch.room;
        [it.first_corner, it.first_work, it.first_turn, it.first_column, it.first_word] =
            [corner, work, wave.turns, column, word].map(|count| count as u32);
        it.wave = wave.links.start as u32;
        batch.most = [batch.most[0].max(it.points), batch.most[1].max(it.triangles)];
        wave.columns = wave.columns.max(columns as u32);
        wave.links.end = index + 1;
        wave.turns += turns;
        batch.room =
            batch.room.and(VoxelRoom([points, items, 0, columns, bits])).or(VoxelRoom([0, 0, wave.turns, 0, 0]));
        batch.links.end = index + 1;
        match (batch.links.start..index).rev().find(|before| targets[*before] == targets[index]) {
            Some(before) if words[before].is_for_row() && words[index].is_for_row() => {
                words[before].next = index as u32
            }
            _ => batch.rows.push(index),
        }
    }
    Ok(batches)
}

/// What is told of an imprint. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct Told {
    /// Blocks that were found, whether or not there was room for them.
    pub found: u32,
    /// Rays that were held at the border of the grid.
    pub clamped: u32,
    pub tiles: u32,
    /// Faults in voxelising.
    faults: u32,
    /// Coefficients that were looked at.
    pub tested: u32,
    /// The work of the triangles, see the kernels.
    work: u32,
    /// Blocks that it changed, where these are smoothed.
    changed: u32,
    unused: u32,
}

impl Told {
    /// Fails if the voxels are not those of the collider.
    pub fn check(&self) -> Result<()> {
        if self.faults & 1 != 0 {
            return Err(Error::unsupported(
                "the collider reaches too far beyond the overlap to be voxelised on a graphics device",
            )
            .advise("cut the collider down, make the objects that collide closer in size, or use the device `cpu`"));
        }
        if self.faults & 2 != 0 {
            return Err(Error::unsupported("the collider covers the voxel grid too many times for a graphics device")
                .advise("use fewer voxels or a coarser collider, or the device `cpu`"));
        }
        Ok(())
    }
}

/// Words of what is told before that of the first imprint.
const FIRST: usize = 4;
const TOLD: usize = size_of::<Told>() / 4;

/// Words of an imprint's arguments: those of chunks of columns, and those of its blocks.
const ARGUMENTS: usize = 8;
const CANDIDATES: usize = 4;

/// What the stages of a submission share.
#[derive(Debug)]
pub(super) struct Shared {
    pub links: Buffer<Words>,
    pub told: Buffer<u32>,
    pub arguments: Buffer<u32>,
    /// Of every imprint the box of the collider's points along the axes of the overlap, as `imprint_box.wgsl` has it.
    pub boxes: Buffer<[u32; 6]>,
    /// Of every imprint how many tiles were listed for it and those of its row, and the arguments of what takes them.
    pub candidates: Buffer<u32>,
}

impl Shared {
    /// Room for as many imprints as there may be. Fails where the device has none.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            links: Buffer::new(device, "imprints", MOST_LINKS)?,
            told: Buffer::new(device, "what is told of imprints", FIRST + TOLD * MOST_LINKS)?,
            arguments: Buffer::new(device, "arguments of imprints", ARGUMENTS * MOST_LINKS)?,
            boxes: Buffer::new(device, "boxes of colliders", MOST_LINKS)?,
            candidates: Buffer::new(device, "tiles of imprints", CANDIDATES * MOST_LINKS)?,
        })
    }

    /// Tells of the imprints of a submission, and records that nothing was told of them so far.
    pub fn begin(&self, device: &Device, frame: &mut Frame, words: &[Words]) -> Result<()> {
        frame.clear(&self.told);
        frame.clear(&self.arguments);
        frame.clear(&self.candidates);
        frame.clear(&self.boxes);
        self.links.write(device, 0, words)
    }

    /// Where the arguments of the dispatch over chunks of columns are, of those that are voxelised with `link`, the first
    /// of them, and of those over the blocks and over the tiles of the row that begins with `link`.
    pub fn chunks(link: usize) -> usize {
        ARGUMENTS * link + 1
    }

    pub fn blocks(link: usize) -> usize {
        ARGUMENTS * link + 5
    }

    pub fn tiles(link: usize) -> usize {
        CANDIDATES * link + 1
    }

    /// Records the way back of what is told of so many imprints.
    pub fn read_told(&self, frame: &mut Frame, links: usize) -> Result<Readback<u32>> {
        frame.read(&self.told, 0..FIRST + TOLD * links)
    }
}

/// The immediate data of a dispatch over `links`.
pub(super) fn step(links: Range<usize>) -> [u32; 2] {
    [links.start as u32, links.len() as u32]
}

/// How many blocks changed in all imprints and how many tiles were worked on, and what is told of each imprint, from the
/// words of [`Shared::read_told`].
pub(super) fn parse(words: &[u32]) -> ([usize; 2], Vec<Told>) {
    let (first, each) = words.split_at(FIRST.min(words.len()));
    let count = |at: usize| first.get(at).map_or(0, |count| *count as usize);
    ([count(0), count(1)], bytemuck::cast_slice(each).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_testing::wgsl::assert_layout;
    use std::mem::offset_of;

    #[test]
    fn the_layouts_are_those_of_the_kernels() {
        macro_rules! fields {
            ($of:ident: $($name:ident),*) => { [$((stringify!($name), offset_of!($of, $name))),*] };
        }
        let link = fields!(Words: lattice_x, points, lattice_y, shift, lattice_z, scale, lattice_origin, first_point,
            lattice_low, first_index, lattice_high, triangles, dims, flags, x, y, z, origin, tiles, share,
            max_displacement, depth, deepest, first_corner, first_work, slots, stride, room, records, zero, first_turn, first_column,
            first_word, next, wave, strength, block_words, blocks, parts, ring_parts, rings, entries, unused);
        assert_layout("imprint_link", "Link", size_of::<Words>(), &link);
        assert_layout(
            "imprint_snap",
            "Told",
            size_of::<Told>(),
            &fields!(Told: found, clamped, tiles, faults, tested, work, changed),
        );
    }
}
