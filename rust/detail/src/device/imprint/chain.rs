//! Imprints on a graphics device, all stages in a row and several of them in one submission (Schäfer et al. 2014, Sections
//! 5 and 6): culling, the list of blocks, voxels, rays. Nothing is read back before the end; then the blocks that changed
//! are, and become the edit that the processor would have made.
//!
//! What follows needs room that is not known before: there is so much, counters say whether it was enough, and what was
//! not is done again with more.

use std::collections::BTreeMap;

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_gpu::wgsl::imprint_link::JobCounters;
use relievo_tiles::Field;

use super::batches::{Batch, batches, most_voxels};
use super::blocks::{DeviceBlocks, Record};
use super::ground::BoundGround;
use super::job::{Ground, ImprintJob, JobParams, MAX_JOBS, Slots};
use super::meshes::DeviceMeshes;
use super::rim::{Around, DeviceRims, RimRoom, volumes};
use super::shared::{Shared, check};
use super::slots::{places, slots, works};
use super::smoothing::{BoundTiles, DeviceSmoothing};
use super::stages::{Stages, Target};
use super::submitted::{FIRST_ROOM, Results, Submitted};
use super::voxel::{DeviceVoxels, VoxelRoom};
use crate::channels::knots::BLOCK_KNOTS;
use crate::device::state::DeviceObject;
use crate::imprint::Cast;
use crate::imprint::collider::Collider;
use crate::imprint::dents::{DentBlock, TileDents, unkey};

/// What imprints have on a device besides the objects.
#[derive(Debug)]
pub(crate) struct DeviceChain {
    device: Device,
    shared: Shared,
    voxels: Option<DeviceVoxels>,
    blocks: Option<DeviceBlocks>,
    smoothing: DeviceSmoothing,
    rims: Option<DeviceRims>,
    /// Whether blocks and rims are for objects with vectors too.
    bends: bool,
    rim_room: RimRoom,
    /// Changed blocks that are read back at once.
    likely: usize,
    /// Where the blocks of the last submission are, by imprint, tile and block.
    kept: BTreeMap<(u32, u32, u32), u32>,
}

impl DeviceChain {
    /// Room for imprints on a device. Fails where it has none.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            device: device.clone(),
            shared: Shared::new(device)?,
            voxels: None,
            blocks: None,
            smoothing: DeviceSmoothing::new(device)?,
            rims: None,
            bends: false,
            rim_room: RimRoom::default(),
            likely: FIRST_ROOM,
            kept: BTreeMap::new(),
        })
    }

    /// Makes the imprints `jobs` of `colliders`, each after those before it, in one submission. What is returned is in
    /// their order; nothing is written into the objects. The colliders are brought to `meshes`.
    ///
    /// Fails, as a whole, where the device does, has no room, or cannot place the points of a collider, and for a collider
    /// that has two poses of its points at once.
    pub fn run(
        &mut self,
        context: &Context,
        meshes: &mut DeviceMeshes,
        targets: &mut [Target<'_>],
        colliders: &[&Collider],
        jobs: &[ImprintJob],
    ) -> Result<Vec<Cast>> {
        if jobs.len() > MAX_JOBS {
            return Err(Error::internal(format!("{} imprints at once; there may be {MAX_JOBS}", jobs.len())));
        }
        for target in &mut *targets {
            target.state.follow(target.object, target.start)?;
            target.state.follow_vectors(target.object, None)?;
            target.state.prepare_culling(target.object)?;
        }
        let grounds = targets
            .iter()
            .map(|it| BoundGround::of(&self.device, &it.state.tiles, it.state.vectors.as_ref()))
            .collect::<Result<Vec<_>>>()?;
        if !self.bends && grounds.iter().any(|ground| ground.has_vectors) {
            (self.bends, self.blocks, self.rims) = (true, None, None);
        }
        meshes.bring(&self.device, colliders)?;
        let works = works(targets.len(), jobs);
        let (slots, slot_count) = slots(targets, jobs, &works);
        let mut words = jobs.iter().map(|job| tell(job, meshes, targets, &slots)).collect::<Result<Vec<_>>>()?;
        let (mut largest, mut tiles) = (0, 0);
        for (target, _) in targets.iter_mut().zip(&works).filter(|(_, works)| **works) {
            largest = target.state.prepare_work(target.object)?.max(largest);
            tiles = target.object.surface().tile_count().max(tiles);
        }
        for (words, job) in words.iter_mut().zip(jobs).filter(|(_, job)| works[job.target]) {
            let DeviceObject { worked, ring, .. } = &*targets[job.target].state;
            words.work_on(&worked.as_ref().ok_or_else(no_blocks)?.work(ring, largest));
        }
        let of: Vec<usize> = jobs.iter().map(|job| job.target).collect();
        let batches = batches(&mut words, &of, most_voxels(&self.device))?;
        let room = batches.iter().fold(VoxelRoom::default(), |room, batch| room.or(batch.room));
        if DeviceVoxels::prepare(&mut self.voxels, &self.device, &self.shared, meshes, room)? {
            // What was bound is bound to the new ones.
            self.bind(self.blocks.as_ref().map_or([FIRST_ROOM, FIRST_ROOM, slot_count], DeviceBlocks::room))?;
        }
        self.enlarge([FIRST_ROOM, FIRST_ROOM, slot_count])?;
        let words_of_blocks = words.iter().map(JobParams::block_words).max().unwrap_or_default();
        let (places, place_count) = places(targets, jobs);
        let around = |(job, words): (&ImprintJob, &JobParams)| {
            let (rising, transform) = (job.rising?, targets[job.target].object.transform());
            let words = words.in_grid(&rising.grid(&job.grid, transform), transform);
            Some(Around { rising, words, places: places[job.target] })
        };
        let rims: Vec<Option<Around>> = jobs.iter().zip(&words).map(around).collect();
        let (mut taken, mut rim_room) = (0, rims.iter().any(Option::is_some).then_some(self.rim_room));
        let (counters, records, moved) = loop {
            if tiles > 0 && self.smoothing.enlarge(&self.device, (taken, words_of_blocks, tiles))? {
                self.bind(self.blocks()?.room())?;
            }
            if let Some(room) = rim_room {
                let blocks = self.blocks.as_ref().ok_or_else(no_blocks)?;
                let voxels = self.voxels.as_ref().ok_or_else(no_voxels)?;
                let bound = (&self.shared, voxels, blocks, self.smoothing.blocks());
                DeviceRims::prepare(&mut self.rims, &self.device, bound, (room, place_count), self.bends)?;
            }
            let [room, record_room, _] = self.blocks()?.room();
            let capacity = self.smoothing.capacity();
            words.iter_mut().for_each(|words| words.set_room([room, record_room, capacity]));
            let bound = self.bind_tiles(targets, &works)?;
            let made = self.submit(context, targets, jobs, (&words, &rims), &batches, (&grounds, &bound))?;
            let found = made.counters.iter().map(|counters| counters.found as usize).max().unwrap_or_default();
            let fits = found <= room && made.kept <= record_room && made.taken <= capacity;
            if fits && made.rim_room == rim_room {
                break (made.counters, made.records, made.moved);
            }
            (taken, rim_room) = (made.taken, made.rim_room);
            self.rim_room = rim_room.unwrap_or(self.rim_room);
            self.enlarge([found, made.kept, slot_count])?;
        };
        targets.iter_mut().for_each(|target| target.state.settle_culling());
        counters.iter().try_for_each(check)?;
        let place = |(place, record): (u32, &Record)| ((record.job(), record.tile, record.block()), place);
        self.kept = (0..).zip(&records).map(place).collect();
        Ok(casts(targets, jobs, &counters, &records, &moved))
    }

    /// Writes what the last submission left of an object into what the device has of its displacement, which is `field`
    /// now, and makes the rings there. `stays` says of an imprint and a tile whether it is so.
    pub fn write(&self, state: &mut DeviceObject, field: &Field, stays: impl Fn(usize, u32) -> bool) -> Result<()> {
        let kept = self.kept.iter().filter(|((job, tile, _), _)| stays(*job as usize, *tile));
        // Of every block what the last imprint left.
        let last: BTreeMap<(u32, u32), u32> = kept.map(|((_, tile, block), place)| ((*tile, *block), *place)).collect();
        let chosen: Vec<u32> = last.into_values().collect();
        if chosen.is_empty() {
            return Ok(());
        }
        let (device, blocks) = (&self.device, self.blocks()?);
        let DeviceObject { tiles, ring, .. } = state;
        tiles.follow_with(device, ring, field, |frame, tiles| blocks.write(device, frame, tiles, &chosen)).map(drop)
    }

    /// Binds the tiles of those targets that are worked on to their blocks.
    fn bind_tiles(&mut self, targets: &[Target<'_>], works: &[bool]) -> Result<Vec<Option<BoundTiles>>> {
        let Self { device, shared, blocks, smoothing, .. } = self;
        let blocks = blocks.as_ref().ok_or_else(no_blocks)?;
        let mut bind = |target: &Target<'_>| {
            let DeviceObject { tiles, ring, worked, .. } = &*target.state;
            let worked = worked.as_ref().ok_or_else(no_blocks)?;
            smoothing.bind(device, (shared, blocks), (worked, tiles, ring))
        };
        let each = targets.iter().zip(works);
        each.map(|(target, works)| works.then(|| bind(target)).transpose()).collect()
    }

    fn voxels(&self) -> Result<&DeviceVoxels> {
        self.voxels.as_ref().ok_or_else(no_voxels)
    }

    fn blocks(&self) -> Result<&DeviceBlocks> {
        self.blocks.as_ref().ok_or_else(no_blocks)
    }

    fn rims(&self) -> Result<&DeviceRims> {
        self.rims.as_ref().ok_or_else(|| Error::internal("no room for rims"))
    }

    /// Makes room for as many blocks, records and slots, and no other.
    fn bind(&mut self, room: [usize; 3]) -> Result<()> {
        // What they took is free before more is asked for.
        (self.blocks, self.rims) = (None, None);
        let room = (self.smoothing.blocks(), room);
        self.blocks = Some(DeviceBlocks::new(&self.device, &self.shared, self.voxels()?, room, self.bends)?);
        Ok(())
    }

    /// Makes room for at least as many blocks, records and slots.
    fn enlarge(&mut self, wanted: [usize; 3]) -> Result<()> {
        let there = self.blocks.as_ref().map_or([0; 3], DeviceBlocks::room);
        if wanted.iter().zip(there).all(|(wanted, there)| *wanted <= there) {
            return Ok(());
        }
        let grown = |k: usize| if wanted[k] > there[k] { wanted[k] + wanted[k] / 4 } else { there[k] };
        self.bind([0, 1, 2].map(grown))
    }

    /// Records and submits everything.
    fn submit(
        &mut self,
        context: &Context,
        targets: &[Target<'_>],
        jobs: &[ImprintJob],
        (words, rims): (&[JobParams], &[Option<Around>]),
        batches: &[Batch],
        (grounds, bound): (&[BoundGround], &[Option<BoundTiles>]),
    ) -> Result<Submitted> {
        let device = &self.device.clone();
        let time = context.stats().begin("imprint.device.submit");
        let mut frame = device.frame()?;
        self.shared.begin(device, &mut frame, words)?;
        let blocks = self.blocks()?;
        if words.iter().any(JobParams::is_chained) {
            blocks.clear_slots(&mut frame);
        }
        if bound.iter().any(Option::is_some) {
            self.smoothing.clear(&mut frame);
        }
        for (target, _) in targets.iter().zip(bound).filter(|(_, bound)| bound.is_some()) {
            target.state.worked.as_ref().map_or(Ok(()), |worked| worked.clear(&mut frame))?;
        }
        let rising = rims.iter().any(Option::is_some);
        if rising {
            self.rims()?.stages().begin(device, &mut frame, rims)?;
        }
        let stages = Stages {
            shared: &self.shared,
            voxels: self.voxels()?,
            blocks,
            rims: self.rims.as_ref().filter(|_| rising),
            smoothing: &self.smoothing,
            targets,
            jobs,
            grounds,
            bound,
        };
        stages.record(device, &mut frame, batches)?;
        let rims = self.rims.as_ref().filter(|_| rising).map(DeviceRims::stages);
        let results = Results { shared: &self.shared, records: blocks.records(), rims, jobs: jobs.len() };
        let made = results.submit(context, device, frame, self.likely, time)?;
        self.likely = made.likely();
        Ok(made)
    }
}

/// Returns the parameters of an imprint for the kernels.
fn tell(job: &ImprintJob, meshes: &DeviceMeshes, targets: &[Target<'_>], slots: &[Option<Slots>]) -> Result<JobParams> {
    let target = &targets[job.target];
    let ground = Ground {
        transform: target.object.transform(),
        tiles: target.object.surface().tile_count(),
        started: target.begun().is_some(),
        slots: slots[job.target],
    };
    Ok(JobParams::new(job, meshes.place(job.mesh)?, &ground))
}

/// What the imprints did, from what was read back.
fn casts(
    targets: &[Target<'_>],
    jobs: &[ImprintJob],
    counters: &[JobCounters],
    records: &[Record],
    moved: &[[f32; 2]],
) -> Vec<Cast> {
    let moved = moved.iter().copied().chain(std::iter::repeat([0.0; 2]));
    let mut order: Vec<(&Record, [f32; 2])> = records.iter().zip(moved).collect();
    order.sort_unstable_by_key(|(record, _)| (record.job(), record.tile, record.block()));
    let mut order = &order[..];
    let mut all = Vec::with_capacity(jobs.len());
    for (index, (job, counters)) in jobs.iter().zip(counters).enumerate() {
        let (own, rest) = order.split_at(order.partition_point(|(record, _)| record.job() <= index as u32));
        order = rest;
        let field = targets[job.target].object.displacement().field();
        let rises = job.rising.is_some();
        let by_tile = || own.chunk_by(|(a, _), (b, _)| a.tile == b.tile);
        let of_tile = |tile: &[(&Record, [f32; 2])]| (tile[0].0.tile, tile.iter().map(|(_, it)| volumes(*it)).sum());
        let dents = by_tile().map(|tile| {
            let mut dents = TileDents { tile: tile[0].0.tile, ..TileDents::default() };
            debug_assert!((dents.tile as usize) < field.tile_count());
            for (record, _) in tile {
                let halves: &[f16] = bytemuck::cast_slice(&record.values);
                let mut values = [f16::ZERO; BLOCK_KNOTS];
                values.copy_from_slice(halves);
                if rises {
                    dents.most = values.iter().copied().fold(dents.most, f16::max);
                }
                dents.blocks.push(DentBlock { index: record.block(), values });
                dents.changed += record.changed;
                dents.least = dents.least.min(unkey(record.least as i16));
            }
            dents
        });
        all.push(Cast {
            dents: dents.collect(),
            tiles: counters.tiles.into(),
            tested: counters.tested.into(),
            clamped: counters.clamped.into(),
            triangles: job.triangles,
            volumes: rises.then(|| by_tile().map(of_tile).collect()),
        });
    }
    all
}

fn no_blocks() -> Error {
    Error::internal("no room for blocks")
}

fn no_voxels() -> Error {
    Error::internal("no room for voxels")
}
