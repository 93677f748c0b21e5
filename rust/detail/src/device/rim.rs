//! Rims on a graphics device (`shaders/imprint_rim*.wgsl`), as [`crate::rim`] makes them on tiles, within the submission
//! of the imprints: the blocks of coefficients around a contact are listed and gathered before the imprint, and raised
//! after it. What rises is left like what was pushed, for the imprints that follow and for the host.
//!
//! There is room for so many blocks, cells and borders; counters say whether it was enough, and what was not is done again
//! with more.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{
    Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, Readback, groups as groups_of,
};
use relievo_surface::{DeviceSurface, SURFACE_GROUP};
use relievo_tiles::{DeviceTiles, TILES_GROUP};

use super::blocks::DeviceBlocks;
use super::cull::DeviceCull;
use super::link::{MOST_LINKS, Shared, Words, parse, step};
use super::moved::{MOVED_GROUP, Moved, STRAIGHT_AND_BENT};
use super::voxel::DeviceVoxels;
use crate::grid::Grid;
use crate::imprint::ImprintSettings;
use crate::rim::{Volumes, check_bytes, highest, surroundings};

/// What an imprint raises.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rising {
    share: f32,
    width: f32,
    highest: f32,
}

impl Rising {
    /// What imprints of these settings raise; `None` where they raise nothing.
    pub fn of(settings: &ImprintSettings) -> Option<Self> {
        let rising = Self { share: settings.rim, width: settings.rim_width, highest: highest(settings) };
        (settings.rim > 0.0).then_some(rising)
    }

    /// The grid of nothing but the box in which something may rise, around that of an imprint.
    pub fn grid(&self, grid: &Grid, transform: &DAffine3) -> Grid {
        surroundings(&grid.obb, transform, self.width)
    }
}

/// As `Rim` in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Rim {
    share: f32,
    width: f32,
    highest: f32,
    pieces: u32,
    cells: u32,
    borders: u32,
    first_place: u32,
    blocks: u32,
}

/// An imprint of which something rises.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    pub rising: Rising,
    /// What kernels are told of it, with the grid around its contact.
    pub words: Words,
    /// Where the blocks of its object begin, and how many a tile has.
    pub places: [u32; 2],
}

/// As `RimTold` in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct RimTold {
    spacing: u32,
    edges: u32,
    borders: u32,
    cells: u32,
    faults: u32,
}

/// Blocks, cells, of which there is a power of two, and borders that there is room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RimRoom {
    pieces: usize,
    cells: usize,
    borders: usize,
}

/// The room at first.
const FEW: RimRoom = RimRoom { pieces: 1024, cells: 1024, borders: 16_384 };

/// Cells that one workgroup joins at most, twice as many as it may have, and blocks that 24 bits number.
const MOST_CELLS: usize = 1 << 16;
const MOST_PIECES: usize = 1 << 24;

/// Words of a piece and of a cell.
const PIECE: usize = 792;
const CELL: usize = 8;

/// What rims have on a device.
#[derive(Debug)]
pub(super) struct DeviceRims {
    /// The imprints with the boxes around their contacts in place of their grids.
    around: Shared,
    rims: Buffer<Rim>,
    told: Buffer<RimTold>,
    kernels: [Arc<Kernel>; 7],
    /// The first one for objects with vectors, if there are some.
    bent: Option<Arc<Kernel>>,
    bound: [Bindings; 2],
    listing: [Bindings; 2],
    places: Buffer<u32>,
    cells: Buffer<u32>,
    volumes: Buffer<[f32; 2]>,
    room: RimRoom,
    _kept: (Buffer<u32>, [Buffer<[f32; 4]>; 2], [Buffer<[u32; 4]>; 2]),
}

/// What comes back of a submission.
pub(super) struct RimReadback {
    around: Readback<u32>,
    told: Readback<RimTold>,
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
        use Access::{Read, Write};
        let own = [Read, Read, Read, Read, Read, Write, Write, Write, Read];
        let state = [Read, Write, Write, Write, Write, Write, Write, Write, Write];
        let immediates = size_of::<[u32; 2]>() as u32;
        let gather = |constants: &[(&str, f64)]| {
            let groups: &[&[Access]] = &[&own, &SURFACE_GROUP, &MOVED_GROUP, &state];
            device.kernel(&KernelSpec { module: "imprint_rim_gather", entry: "gather", groups, immediates, constants })
        };
        let kernel = |[module, entry]: [&str; 2]| {
            let groups: &[&[Access]] = &[&own, &SURFACE_GROUP, &TILES_GROUP, &state];
            device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &[] })
        };
        let [straight, bent] = STRAIGHT_AND_BENT;
        let bent = bend.then(|| gather(&bent)).transpose()?;
        let kernels = [
            gather(&straight)?,
            kernel(["imprint_rim_cells", "find_records"])?,
            kernel(["imprint_rim_cells", "push"])?,
            kernel(["imprint_rim_cells", "list_cells"])?,
            kernel(["imprint_rim_join", "join_cells"])?,
            kernel(["imprint_rim_profile", "profile"])?,
            kernel(["imprint_rim_raise", "raise"])?,
        ];
        let around = Shared::new(device)?;
        let rims = Buffer::new(device, "rims", MOST_LINKS)?;
        let told = Buffer::new(device, "what is told of rims", MOST_LINKS)?;
        let listed = Buffer::new(device, "blocks around contacts", room.pieces)?;
        let pieces = Buffer::new(device, "coefficients around contacts", PIECE * room.pieces)?;
        let points = Buffer::new(device, "places around contacts", GROUP as usize * room.pieces)?;
        let places = Buffer::new(device, "pieces of blocks", places)?;
        let cells = Buffer::new(device, "cells of contacts", CELL * room.cells)?;
        let borders = Buffer::new(device, "borders of contacts", room.borders)?;
        let edges = Buffer::new(device, "pieces with borders", room.pieces)?;
        let volumes = Buffer::new(device, "volumes of blocks", blocks.records().len())?;
        let listing = DeviceBlocks::list_into(device, &around, blocks.slots(), &listed)?;
        let from = [shared.links.wgpu(), listed.wgpu(), around.arguments.wgpu()];
        let to = [blocks.slots().wgpu(), shared.told.wgpu(), blocks.records().wgpu()];
        let solid = [voxels.spans().wgpu(), voxels.words().wgpu()];
        let own = device.bind_as(&own, &[&from[..], &solid, &to, &[worked.wgpu()]].concat())?;
        let state_of = [
            rims.wgpu(),
            told.wgpu(),
            pieces.wgpu(),
            points.wgpu(),
            places.wgpu(),
            cells.wgpu(),
            borders.wgpu(),
            edges.wgpu(),
            volumes.wgpu(),
        ];
        let bound = [own, device.bind_as(&state, &state_of)?];
        let _kept = (pieces, [points, borders], [listed, edges]);
        Ok(Self { around, rims, told, kernels, bent, bound, listing, places, cells, volumes, room, _kept })
    }

    /// Makes room where it is not that much, with so many places at least, and what is bound elsewhere.
    pub fn prepare(
        there: &mut Option<Self>,
        device: &Device,
        bound: (&Shared, &DeviceVoxels, &DeviceBlocks, &Buffer<u32>),
        (room, places): (RimRoom, usize),
        bend: bool,
    ) -> Result<()> {
        if there.as_ref().is_some_and(|rims| rims.room == room && rims.places.len() >= places) {
            return Ok(());
        }
        // What it took is free before more is asked for.
        *there = None;
        *there = Some(Self::new(device, bound, (room, places), bend)?);
        Ok(())
    }

    /// Tells of the rims of a submission: of every imprint that has one what it raises, and itself around its contact.
    pub fn begin(&self, device: &Device, frame: &mut Frame, rims: &[Option<Around>]) -> Result<()> {
        frame.clear(&self.told);
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
        let told: Vec<Rim> = rims.iter().map(|it| it.as_ref().map_or(Rim::default(), rim)).collect();
        self.rims.write(device, 0, &told)?;
        let words = rims.iter().map(|it| {
            let mut words = it.as_ref().map_or_else(Words::zeroed, |it| it.words);
            words.set_room([pieces, 0, 0]);
            words
        });
        self.around.begin(device, frame, &words.collect::<Vec<_>>())
    }

    /// Records that the blocks around the contact of imprint `link` are listed and gathered, before it is made.
    pub fn gather(
        &self,
        pass: &mut Pass<'_>,
        culling: &DeviceCull,
        (surface, moved): (&DeviceSurface, &Moved),
        link: usize,
    ) -> Result<()> {
        culling.cull(pass, &self.around, &self.listing, surface, link)?;
        let kernel = if moved.bent { self.bent.as_ref() } else { Some(&self.kernels[0]) };
        let kernel = kernel.ok_or_else(|| Error::internal("no kernel for rims of an object with vectors"))?;
        let [own, state] = &self.bound;
        let groups = [own, surface.group(), &moved.group, state];
        let links = step(link..link + 1);
        let links = bytemuck::bytes_of(&links);
        pass.run_indirect(kernel, &groups, links, &self.around.arguments, Shared::blocks(link))
    }

    /// Records that a rim rises, after the imprint was made.
    pub fn raise(
        &self,
        pass: &mut Pass<'_>,
        (surface, tiles): (&DeviceSurface, &DeviceTiles),
        link: usize,
    ) -> Result<()> {
        (1..self.kernels.len()).try_for_each(|kernel| self.run(pass, kernel, (surface, tiles), link))
    }

    fn run(
        &self,
        pass: &mut Pass<'_>,
        number: usize,
        (surface, tiles): (&DeviceSurface, &DeviceTiles),
        link: usize,
    ) -> Result<()> {
        let [own, state] = &self.bound;
        let groups = [own, surface.group(), tiles.group(), state];
        let links = step(link..link + 1);
        let links = bytemuck::bytes_of(&links);
        let kernel = &self.kernels[number];
        match number {
            FIND => return pass.run(kernel, &groups, links, groups_of((self.volumes.len() as u32).div_ceil(GROUP))),
            JOIN => return pass.run(kernel, &groups, links, [1, 1, 1]),
            _ => {}
        }
        pass.run_indirect(kernel, &groups, links, &self.around.arguments, Shared::blocks(link))
    }

    /// Records the way back of what is told.
    pub fn read(&self, frame: &mut Frame, links: usize) -> Result<RimReadback> {
        Ok(RimReadback { around: self.around.read_told(frame, links)?, told: frame.read(&self.told, 0..links)? })
    }

    /// The room that a submission needs, more than there is where that was not enough. Fails where there is none, or the
    /// context's memory limit forbids it.
    pub fn needed(&self, context: &Context, device: &Device, read: RimReadback) -> Result<RimRoom> {
        let (_, around) = parse(&read.around.get(device)?);
        let told = read.told.get(device)?;
        let most = |count: fn(&RimTold) -> u32| told.iter().map(count).max().unwrap_or_default() as usize;
        let pieces = around.iter().map(|told| told.found as usize).max().unwrap_or_default();
        check_bytes(context, pieces)?;
        let mut room = self.room;
        if pieces > room.pieces {
            room.pieces = pieces + pieces / 4;
        }
        let borders = most(|told| told.borders);
        if borders > room.borders {
            room.borders = borders + borders / 4;
        }
        // Half of them stay free.
        if 2 * most(|told| told.cells) > room.cells {
            room.cells *= 4;
        }
        let faulty = room == self.room && told.iter().any(|told| told.faults != 0);
        if faulty || room.cells > MOST_CELLS || room.pieces > MOST_PIECES {
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

impl Default for RimRoom {
    fn default() -> Self {
        FEW
    }
}

/// Which of the kernels takes records, and which is one workgroup.
const FIND: usize = 1;
const JOIN: usize = 4;

/// The volumes of a block.
pub(super) fn volumes([pushed, raised]: [f32; 2]) -> Volumes {
    Volumes { pushed: pushed.into(), raised: raised.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collider::Collider;
    use crate::device::blocks::tests::changed;
    use crate::device::chain::{DeviceChain, Target};
    use crate::device::cull::tests::object;
    use crate::device::link::Link;
    use crate::imprint::Imprinter;
    use crate::obb::Obb;
    use crate::raycast::key;
    use crate::rim::raise;
    use crate::shapes;
    use glam::{DMat3, DVec3};
    use relievo_testing::{device, wgsl::assert_layout};
    use std::mem::offset_of;

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
        let link = Link::new(&context, 0, &collider, &grid, &settings.limits()).unwrap().raising(&settings);
        object.use_device(Some(&device)).unwrap();
        let mut state = object.device.take().unwrap();
        let mut target = [Target { state: &mut state, object: &object, start: None }];
        let mut chain = DeviceChain::new(&device).unwrap();
        let there = chain.run(&context, &mut target, &[&collider], &[link]).unwrap().pop().unwrap();
        let told = there.volumes.unwrap();
        assert!(moved.len() > 8 && told.len() == moved.len(), "{} {}", told.len(), moved.len());
        for ((tile, a), (other, b)) in moved.iter().zip(&told) {
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

    #[test]
    fn the_layouts_are_those_of_the_kernels() {
        macro_rules! fields {
            ($of:ident: $($name:ident),*) => { [$((stringify!($name), offset_of!($of, $name))),*] };
        }
        let rim = fields!(Rim: share, width, highest, pieces, cells, borders, first_place, blocks);
        assert_layout("imprint_rim", "Rim", size_of::<Rim>(), &rim);
        let told = fields!(RimTold: spacing, edges, borders, cells, faults);
        assert_layout("imprint_rim", "RimTold", size_of::<RimTold>(), &told);
    }
}
