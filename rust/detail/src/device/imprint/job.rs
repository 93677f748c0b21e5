//! An imprint of a submission, as kernels get it (`shaders/imprint/imprint_link.wgsl`). One upload describes all
//! imprints of a submission, so that a dispatch needs no more than the number of its imprint.

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use relievo_core::Context;
use relievo_gpu::wgsl::imprint_link;

use super::meshes::Place;
use super::rising::Rising;
use super::work::Work;
use crate::geometry::grid::Grid;
use crate::geometry::lattice::Lattice;
use crate::geometry::voxel::{Side, steep};
use crate::geometry::voxel_frame::VoxelFrame;
use crate::imprint::collider::Collider;
use crate::imprint::dents::{Limits, deepest};
use crate::imprint::settings::ImprintSettings;

/// An imprint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImprintJob {
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
    /// Whether those after it on the same object start from what the ring update makes of it.
    pub worked: bool,
}

/// Voxels from the grid within which kernels place points, less what rounding takes.
const FAR: f64 = 65_000.0;

impl ImprintJob {
    /// The imprint of `collider`, where it is now, on one of the targets. `None` where not all of it is near enough to the
    /// grid for a device: at a first touch voxels may be tiny.
    pub fn new(context: &Context, target: usize, collider: &Collider, grid: &Grid, limits: &Limits) -> Option<Self> {
        let corners = collider.obb().corners();
        let near = corners.into_iter().all(|it| grid.map.transform_point3(it).abs().max_element() < FAR);
        let lattice = collider.lattice(grid).filter(|_| near)?;
        // Of what is solid inside either side will do.
        let side = if collider.is_sheet() { collider.side(context, grid).0 } else { Side::Forward };
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
            triangles: collider.boundary().1.len() as u64,
            transform: *collider.transform(),
            side,
            grid: *grid,
            limits: *limits,
            lattice,
            smoothing: (0.0, 0),
            rising: None,
            worked: false,
        }
    }

    /// The same on another of the targets.
    pub fn of_target(self, target: usize) -> Self {
        Self { target, ..self }
    }

    /// The same, with the ring update made on the device before the next one on the same object if it is `worked` on.
    pub fn worked(self, worked: bool) -> Self {
        Self { worked, ..self }
    }

    /// As an imprint of these settings, whose limits it has.
    pub fn raising(self, settings: &ImprintSettings) -> Self {
        Self { rising: Rising::of(settings), ..self }
    }
}

/// The parameters of an imprint for the kernels.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct JobParams(imprint_link::Link);

/// Imprints that are submitted together at most.
pub(crate) const MAX_JOBS: usize = 64;

/// Triangles of a collider of which no number can change a winding number by more than 16 bits hold.
pub(super) const MAX_NARROW: u32 = i16::MAX as u32;

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
pub(crate) struct Slots {
    pub base: u32,
    /// Slots of a tile.
    pub stride: u32,
}

/// The object of an imprint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
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

impl JobParams {
    /// The parameters of `job`, whose collider is at `place`, for the kernels.
    pub fn new(job: &ImprintJob, place: &Place, ground: &Ground<'_>) -> Self {
        let ImprintJob { lattice: Lattice { rows, shift, scale, origin, offset }, grid, limits, .. } = job;
        let (view, [x, y, z]) = view(grid, ground.transform);
        let flag = |condition: bool, flag: u32| if condition { flag } else { 0 };
        let mirrored = (grid.map * job.transform).matrix3.determinant() < 0.0;
        let flags = flag(job.side == Side::Backward, BACKWARD)
            | flag(!place.closed, OPEN)
            | flag(mirrored, MIRRORED)
            | flag(ground.started, STARTED)
            | flag(ground.slots.is_some(), CHAINED)
            | flag(place.triangles.len() <= MAX_NARROW as usize, NARROW)
            | flag(job.rising.is_some(), RISING);
        let Slots { base, stride } = ground.slots.unwrap_or(Slots { base: 0, stride: 0 });
        Self(imprint_link::Link {
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
            strength: job.smoothing.0,
            block_words: 0,
            blocks: 0,
            parts: 0,
            ring_parts: 0,
            rings: 0,
            entries: 0,
            steep: steep(grid),
        })
    }

    /// Says how many blocks, records and blocks of tiles there is room for.
    pub fn set_room(&mut self, room: [usize; 3]) {
        [self.0.room, self.0.records, self.0.blocks] = room.map(|count| count as u32);
    }

    /// Has imprints before it, and after it, of the submission meet in blocks of tiles, which are worked on.
    pub fn work_on(&mut self, work: &Work) {
        self.0.flags = self.0.flags & !CHAINED | WORKED;
        self.0.block_words = work.words;
        [self.0.parts, self.0.ring_parts, self.0.rings, self.0.entries] =
            [work.parts, work.ring_parts, work.rings, work.entries];
    }

    /// The same imprint in another grid, by itself.
    pub fn in_grid(&self, grid: &Grid, transform: &DAffine3) -> Self {
        let (view, [x, y, z]) = view(grid, transform);
        Self(imprint_link::Link { dims: grid.dims, x, y, z, origin: view.origin, next: NONE, ..self.0 })
    }

    /// Whether imprints before it, or after it, of the submission meet the same object.
    pub fn is_chained(&self) -> bool {
        self.0.flags & (CHAINED | WORKED) != 0
    }

    /// Words of a block of tiles that are worked on.
    pub fn block_words(&self) -> usize {
        self.0.block_words as usize
    }

    /// How many points and triangles its collider has.
    pub fn mesh(&self) -> [u32; 2] {
        [self.0.points, self.0.triangles]
    }

    /// Voxels along every axis of the grid.
    pub fn dims(&self) -> [u32; 3] {
        self.0.dims
    }

    /// Says where its points on the lattice, the work of its triangles, its winding numbers, its columns and their bits
    /// begin, and which is the first of the imprints whose winding numbers are there at once with its own.
    pub fn lie_at(&mut self, places: [usize; 5], wave: usize) {
        [self.0.first_corner, self.0.first_work, self.0.first_turn, self.0.first_column, self.0.first_word] =
            places.map(|place| place as u32);
        self.0.wave = wave as u32;
    }

    /// Has the imprint `next` of the same object taken together with it.
    pub fn go_on_with(&mut self, next: usize) {
        self.0.next = next as u32;
    }

    /// Whether it may be taken together with others of the same object.
    pub fn is_for_row(&self) -> bool {
        self.0.flags & (RISING | WORKED) == 0
    }
}
