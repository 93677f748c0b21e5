//! Rims on a graphics device (`shaders/imprint/rim`), as [`crate::imprint::rim`] makes them, within the submission
//! of the imprints: the blocks of values around a contact are listed and gathered before the imprint, and raised
//! after it; here of tiles, in [`super::triangle_rim`] of triangles. What rises is left like what was pushed, for the imprints that follow and for the host.
//!
//! There is room for so many blocks, cells and borders; counters say whether it was enough, and what was not is done again
//! with more.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::wgsl::imprint_rim::{Rim, RimCounters};
use relievo_gpu::{
    Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, Readback, groups as groups_of, wgpu,
};
use relievo_surface::{DeviceSurface, SURFACE_GROUP};
use relievo_tiles::{DeviceTiles, TILES_GROUP};

use super::blocks::{DeviceBlocks, Record};
use super::cull::DeviceCull;
use super::ground::{BoundGround, GROUND_GROUP, WITHOUT_AND_WITH_VECTORS};
use super::job::{JobParams, MAX_JOBS};
use super::rising::Rising;
use super::shared::{Shared, parse, step};
use super::voxel::DeviceVoxels;
use crate::imprint::rim::{Volumes, check_bytes};

/// An imprint of which something rises.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    pub rising: Rising,
    /// Its parameters for the kernels, with the grid around its contact.
    pub words: JobParams,
    /// Where the blocks of its object begin, and how many a tile has.
    pub places: [u32; 2],
}

/// Blocks, cells, of which there is a power of two, and borders that there is room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RimRoom {
    pieces: usize,
    cells: usize,
    borders: usize,
}

/// The room at first.
const FIRST_ROOM: RimRoom = RimRoom { pieces: 1024, cells: 1024, borders: 16_384 };

/// Cells that one workgroup joins at most, twice as many as it may have, and blocks that 24 bits number.
const MAX_CELLS: usize = 1 << 16;
const MAX_PIECES: usize = 1 << 24;

/// Words of a piece and of a cell.
const PIECE: usize = 792;
const CELL: usize = 8;

/// What rims of a submission share on a device, whatever they are on.
#[derive(Debug)]
pub(super) struct RimStages {
    /// The imprints with the boxes around their contacts in place of their grids.
    pub around: Shared,
    /// The blocks around a contact.
    pub listed: Buffer<[u32; 4]>,
    /// What kernels have as their group 3.
    pub state: Bindings,
    rims: Buffer<Rim>,
    counters: Buffer<RimCounters>,
    places: Buffer<u32>,
    cells: Buffer<u32>,
    volumes: Buffer<[f32; 2]>,
    room: RimRoom,
    _kept: (Buffer<u32>, [Buffer<[f32; 4]>; 2], Buffer<[u32; 4]>),
}

/// The kernels of a rim after the imprint, in their order.
#[derive(Debug)]
pub(super) struct RimKernels([Arc<Kernel>; 6]);

/// Rims on tiles.
#[derive(Debug)]
pub(super) struct DeviceRims {
    stages: RimStages,
    kernels: RimKernels,
    /// For objects without vectors and, if there are some, for those with.
    gather: Vec<Arc<Kernel>>,
    own: Bindings,
    listing: [Bindings; 2],
}

/// What comes back of a submission.
pub(super) struct RimReadback {
    around: Readback<u32>,
    counters: Readback<RimCounters>,
}

/// What kernels have as their group 3.
pub(super) const RIM_GROUP: [Access; 9] = [
    Access::Read,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
];

/// What they have first as their group 0: imprints, pieces, arguments, voxels, slots, counters, and records.
pub(super) const RIM_OWN: [Access; 8] =
    [Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write, Access::Write];

impl RimKernels {
    /// With these groups; the cells are those of `module`, whose `constants` are given. Records of `triangles` tell of those
    /// before them. Fails where the device does.
    pub fn new(
        device: &Device,
        groups: &[&[Access]],
        (module, constants): (&'static str, &[(&str, f64)]),
        triangles: bool,
    ) -> Result<Self> {
        let immediates = size_of::<Step>() as u32;
        let kernel =
            |module, entry, constants| device.kernel(&KernelSpec { module, entry, groups, immediates, constants });
        Ok(Self([
            kernel("imprint_rim_push", "find_records", &[])?,
            kernel("imprint_rim_push", "push", &[])?,
            kernel(module, "list_cells", constants)?,
            kernel("imprint_rim_join", "join_cells", &[])?,
            kernel("imprint_rim_profile", "profile", &[])?,
            kernel("imprint_rim_raise", "raise", &[("TRIANGLES", f64::from(u8::from(triangles)))])?,
        ]))
    }
}

impl RimStages {
    /// Room for rims with so many `places`, and volumes of so many records. Fails where the device has none.
    pub fn new(device: &Device, room: RimRoom, places: usize, records: usize) -> Result<Self> {
        let around = Shared::new(device)?;
        let rims = Buffer::new(device, "rims", MAX_JOBS)?;
        let counters = Buffer::new(device, "what is counters of rims", MAX_JOBS)?;
        let listed = Buffer::new(device, "blocks around contacts", room.pieces)?;
        let pieces = Buffer::new(device, "coefficients around contacts", PIECE * room.pieces)?;
        let points = Buffer::new(device, "places around contacts", GROUP as usize * room.pieces)?;
        let places = Buffer::new(device, "pieces of blocks", places)?;
        let cells = Buffer::new(device, "cells of contacts", CELL * room.cells)?;
        let borders = Buffer::new(device, "borders of contacts", room.borders)?;
        let edges = Buffer::new(device, "pieces with borders", room.pieces)?;
        let volumes = Buffer::new(device, "volumes of blocks", records)?;
        let state_of = [
            rims.wgpu(),
            counters.wgpu(),
            pieces.wgpu(),
            points.wgpu(),
            places.wgpu(),
            cells.wgpu(),
            borders.wgpu(),
            edges.wgpu(),
            volumes.wgpu(),
        ];
        let state = device.bind_as(&RIM_GROUP, &state_of)?;
        let _kept = (pieces, [points, borders], edges);
        Ok(Self { around, listed, state, rims, counters, places, cells, volumes, room, _kept })
    }

    /// Whether there is that much room, and so many places at least.
    pub fn fits(&self, room: RimRoom, places: usize) -> bool {
        self.room == room && self.places.len() >= places
    }

    /// The buffers of [`RIM_OWN`], of imprints that `shared` tells of.
    pub fn own<'a>(
        &'a self,
        shared: &'a Shared,
        voxels: &'a DeviceVoxels,
        slots: &'a Buffer<u32>,
        records: &'a Buffer<Record>,
    ) -> [&'a wgpu::Buffer; 8] {
        let from = [shared.jobs.wgpu(), self.listed.wgpu(), self.around.arguments.wgpu()];
        let [jobs, listed, arguments] = from;
        let [spans, words] = [voxels.spans().wgpu(), voxels.words().wgpu()];
        [jobs, listed, arguments, spans, words, slots.wgpu(), shared.counters.wgpu(), records.wgpu()]
    }

    /// Tells of the rims of a submission: of every imprint that has one what it raises, and itself around its contact.
    pub fn begin(&self, device: &Device, frame: &mut Frame, rims: &[Option<Around>]) -> Result<()> {
        frame.clear(&self.counters);
        frame.clear(&self.places);
        frame.clear(&self.cells);
        let RimRoom { pieces, cells, borders } = self.room;
        let rim = |Around { rising, places: [first_place, of_tile], .. }: &Around| Rim {
            share: rising.share,
            width: rising.width,
            highest: rising.highest,
            pieces: pieces as u32,
            cells: cells as u32,
            borders: borders as u32,
            first_place: *first_place,
            blocks: *of_tile,
        };
        let counters: Vec<Rim> = rims.iter().map(|it| it.as_ref().map_or(Rim::default(), rim)).collect();
        self.rims.write(device, 0, &counters)?;
        let words = rims.iter().map(|it| {
            let mut words = it.as_ref().map_or_else(JobParams::default, |it| it.words);
            words.set_room([pieces, 0, 0]);
            words
        });
        self.around.begin_lists(frame);
        self.around.begin(device, frame, &words.collect::<Vec<_>>())
    }

    /// Records a kernel over the blocks around the contact of imprint `job`.
    pub fn run(&self, pass: &mut Pass<'_>, kernel: &Kernel, groups: &[&Bindings], job: usize) -> Result<()> {
        let jobs = step(job..job + 1);
        let jobs = bytemuck::bytes_of(&jobs);
        pass.run_indirect(kernel, groups, jobs, &self.around.arguments, Shared::blocks(job))
    }

    /// Records that a rim rises, after the imprint was made.
    pub fn raise(
        &self,
        pass: &mut Pass<'_>,
        RimKernels([find, push, list, join, profile, raise]): &RimKernels,
        groups: &[&Bindings],
        job: usize,
    ) -> Result<()> {
        let jobs = step(job..job + 1);
        let jobs = bytemuck::bytes_of(&jobs);
        pass.run(find, groups, jobs, groups_of((self.volumes.len() as u32).div_ceil(GROUP)))?;
        self.run(pass, push, groups, job)?;
        self.run(pass, list, groups, job)?;
        pass.run(join, groups, jobs, [1, 1, 1])?;
        self.run(pass, profile, groups, job)?;
        self.run(pass, raise, groups, job)
    }

    /// Records the way back of the counters.
    pub fn read(&self, frame: &mut Frame, jobs: usize) -> Result<RimReadback> {
        Ok(RimReadback {
            around: self.around.read_counters(frame, jobs)?,
            counters: frame.read(&self.counters, 0..jobs)?,
        })
    }

    /// The room that a submission needs, more than there is where that was not enough. Fails where there is none, or the
    /// context's memory limit forbids it.
    pub fn needed(&self, context: &Context, device: &Device, read: RimReadback) -> Result<RimRoom> {
        let (_, around) = parse(&read.around.get(device)?);
        let counters = read.counters.get(device)?;
        let most = |count: fn(&RimCounters) -> u32| counters.iter().map(count).max().unwrap_or_default() as usize;
        let pieces = around.iter().map(|counters| counters.found as usize).max().unwrap_or_default();
        check_bytes(context, pieces)?;
        let mut room = self.room;
        if pieces > room.pieces {
            room.pieces = pieces + pieces / 4;
        }
        let borders = most(|counters| counters.borders);
        if borders > room.borders {
            room.borders = borders + borders / 4;
        }
        // Half of them stay free.
        if 2 * most(|counters| counters.cells) > room.cells {
            room.cells *= 4;
        }
        let faulty = room == self.room && counters.iter().any(|counters| counters.faults != 0);
        if faulty || room.cells > MAX_CELLS || room.pieces > MAX_PIECES {
            return Err(Error::unsupported("the contact is too large for the width of its rim on a graphics device")
                .advise("make the rim wider, or use the device `cpu`"));
        }
        Ok(room)
    }

    /// Records the way back of the volumes of the records `range`.
    pub fn read_volumes(&self, frame: &mut Frame, range: std::ops::Range<usize>) -> Result<Readback<[f32; 2]>> {
        frame.read(&self.volumes, range)
    }
}

impl DeviceRims {
    /// Room for rims of imprints whose `voxels` and `blocks` are these, and the blocks of tiles that are `worked` on; with
    /// so many `places`, on objects with vectors too if these `bend`. Fails where the device has none.
    fn new(
        device: &Device,
        (shared, voxels, blocks, worked): (&Shared, &DeviceVoxels, &DeviceBlocks, &Buffer<u32>),
        (room, places): (RimRoom, usize),
        bend: bool,
    ) -> Result<Self> {
        let own = [&RIM_OWN[..], &[Access::Read]].concat();
        let immediates = size_of::<Step>() as u32;
        let gather = |constants: &[(&str, f64)]| {
            let groups: &[&[Access]] = &[&own, &SURFACE_GROUP, &GROUND_GROUP, &RIM_GROUP];
            device.kernel(&KernelSpec { module: "imprint_rim_gather", entry: "gather", groups, immediates, constants })
        };
        let variants = WITHOUT_AND_WITH_VECTORS.iter().take(1 + usize::from(bend));
        let gather = variants.map(|constants| gather(constants)).collect::<Result<Vec<_>>>()?;
        let groups: &[&[Access]] = &[&own, &SURFACE_GROUP, &TILES_GROUP, &RIM_GROUP];
        let kernels = RimKernels::new(device, groups, ("imprint_rim_cells", &[]), false)?;
        let stages = RimStages::new(device, room, places, blocks.records().len())?;
        let listing = DeviceBlocks::list_into(device, &stages.around, blocks.slots(), &stages.listed)?;
        let bound = [&stages.own(shared, voxels, blocks.slots(), blocks.records())[..], &[worked.wgpu()]].concat();
        let own = device.bind_as(&own, &bound)?;
        Ok(Self { stages, kernels, gather, own, listing })
    }

    /// Makes room where it is not that much, with so many places at least, and what is bound elsewhere.
    pub fn prepare(
        there: &mut Option<Self>,
        device: &Device,
        bound: (&Shared, &DeviceVoxels, &DeviceBlocks, &Buffer<u32>),
        (room, places): (RimRoom, usize),
        bend: bool,
    ) -> Result<()> {
        if there.as_ref().is_some_and(|rims| rims.stages.fits(room, places)) {
            return Ok(());
        }
        // What it took is free before more is asked for.
        *there = None;
        *there = Some(Self::new(device, bound, (room, places), bend)?);
        Ok(())
    }

    /// What they share with others.
    pub fn stages(&self) -> &RimStages {
        &self.stages
    }

    /// Records that the blocks around the contact of imprint `job` are listed and gathered, before it is made.
    pub fn gather(
        &self,
        pass: &mut Pass<'_>,
        culling: &DeviceCull,
        (surface, ground): (&DeviceSurface, &BoundGround),
        job: usize,
    ) -> Result<()> {
        culling.cull(pass, &self.stages.around, &self.listing, surface, job)?;
        let kernel = self.gather.get(usize::from(ground.has_vectors));
        let kernel = kernel.ok_or_else(|| Error::internal("no kernel for rims of an object with vectors"))?;
        self.stages.run(pass, kernel, &[&self.own, surface.group(), &ground.group, &self.stages.state], job)
    }

    /// Records that a rim rises, after the imprint was made.
    pub fn raise(
        &self,
        pass: &mut Pass<'_>,
        (surface, tiles): (&DeviceSurface, &DeviceTiles),
        job: usize,
    ) -> Result<()> {
        let groups = [&self.own, surface.group(), tiles.group(), &self.stages.state];
        self.stages.raise(pass, &self.kernels, &groups, job)
    }
}

impl Default for RimRoom {
    fn default() -> Self {
        FIRST_ROOM
    }
}

/// The volumes of a block.
pub(super) fn volumes([pushed, raised]: [f32; 2]) -> Volumes {
    Volumes { pushed: pushed.into(), raised: raised.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::imprint::blocks::tests::changed;
    use crate::device::imprint::chain::DeviceChain;
    use crate::device::imprint::cull::tests::object;
    use crate::device::imprint::job::ImprintJob;
    use crate::device::imprint::meshes::DeviceMeshes;
    use crate::device::imprint::stages::Target;
    use crate::geometry::grid::Grid;
    use crate::geometry::obb::Obb;
    use crate::imprint::Imprinter;
    use crate::imprint::collider::Collider;
    use crate::imprint::dents::key;
    use crate::imprint::rim::raise;
    use crate::imprint::settings::ImprintSettings;
    use crate::object::shapes;
    use glam::{DAffine3, DMat3, DVec3};
    use relievo_testing::device;

    #[test]
    fn what_rises_is_what_the_processor_raises() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let mut object = object(&context);
        let ball = |radius: f32, at: [f32; 3]| shapes::moved(shapes::sphere(radius, 40, 20, 0.0), at);
        let balls = shapes::joined(ball(0.8, [0.0, 0.0, 0.45]), ball(0.6, [2.4, 0.5, 0.4]));
        let place = object.transform().transform_point3(DVec3::new(3.4, 3.6, 0.0));
        let collider = Collider::new(&context, balls.0, balls.1, DAffine3::from_translation(place)).unwrap();
        let settings = ImprintSettings { rim: 0.7, rim_width: 0.5, repose: 1.2, ..ImprintSettings::default() };
        let obb = Obb { center: place, axes: DMat3::from_rotation_z(0.3), half: DVec3::new(3.4, 2.2, 0.9) };
        let grid = Grid::new(&obb, 1 << 18, Some(2));
        let mut imprinter = Imprinter::new();
        let mut here = imprinter.cast_here(&context, &mut object, &collider, None, &grid, &settings).unwrap();
        here.dents.sort_unstable_by_key(|dents| dents.tile);
        let mut moved = raise(&context, &mut object, &mut here.dents, &imprinter.voxels, &settings).unwrap();
        moved.retain(|(_, volumes)| *volumes != Volumes::default());
        let job = ImprintJob::new(&context, 0, &collider, &grid, &settings.limits()).unwrap().raising(&settings);
        object.use_device(Some(&device)).unwrap();
        let mut state = object.device.take().unwrap();
        let mut target = [Target { state: &mut state, object: &object, start: None }];
        let (mut chain, mut meshes) = (DeviceChain::new(&device).unwrap(), DeviceMeshes::new(&device).unwrap());
        let there = chain.run(&context, &mut meshes, &mut target, &[&collider], &[job]).unwrap().pop().unwrap();
        let counters = there.volumes.unwrap();
        assert!(moved.len() > 8 && counters.len() == moved.len(), "{} {}", counters.len(), moved.len());
        for ((tile, a), (other, b)) in moved.iter().zip(&counters) {
            let near = |a: f64, b: f64| (a - b).abs() < 1e-3 * a + 1e-7;
            assert!(tile == other && near(a.pushed, b.pushed) && near(a.raised, b.raised), "{tile} {a:?} {b:?}");
        }
        let (here, there) = (changed(&here.dents), changed(&there.dents));
        assert!(here.keys().eq(there.keys()));
        let (mut all, mut apart, mut risen) = (0, 0, 0);
        for (a, b) in here.values().flatten().zip(there.values().flatten()) {
            all += 1;
            risen += u32::from(a.to_f32() > 0.1);
            apart += u32::from(key(*a).abs_diff(key(*b)) > 1);
        }
        println!("{apart} of {all} coefficients are more than one half apart");
        assert!(risen > 500 && apart * 10_000 < all, "{apart} of {all}, {risen}");
    }
}
