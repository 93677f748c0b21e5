//! Imprints on a graphics device, all stages in a row and several of them in one submission (Schäfer et al. 2014, Sections
//! 5 and 6): culling, the list of blocks, voxels, rays. Nothing is read back before the end; then the blocks that changed
//! are, and become the edit that the processor would have made.
//!
//! What follows needs room that is not known before: there is so much, counters say whether it was enough, and what was
//! not is done again with more.

use std::collections::BTreeMap;

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Device, Pass};
use relievo_tiles::{DeviceTiles, Field};

use super::blocks::{DeviceBlocks, Record};
use super::link::{Batch, Ground, Link, MOST_LINKS, Shared, Slots, Told, Words, batches, most_voxels, parse};
use super::meshes::DeviceMeshes;
use super::state::DeviceObject;
use super::voxel::{DeviceVoxels, VoxelRoom};
use crate::collider::Collider;
use crate::imprint::Cast;
use crate::knots::{BLOCK_KNOTS, block_edge};
use crate::object::DisplacedObject;
use crate::raycast::{DentBlock, TileDents, unkey};

/// An object that is imprinted on.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    pub state: &'a mut DeviceObject,
    pub object: &'a DisplacedObject,
    /// The displacement from which the depth limits count, if it is not what it is now.
    pub start: Option<&'a Field>,
}

impl Target<'_> {
    /// The displacement on the device from which the depth limits count, if it is not what it is now.
    fn begun(&self) -> Option<&DeviceTiles> {
        self.start.and_then(|_| self.state.begun())
    }
}

/// Blocks that there is room for at first, and that are read back.
const FEW: usize = 512;

/// What imprints have on a device besides the objects.
#[derive(Debug)]
pub(crate) struct DeviceChain {
    device: Device,
    shared: Shared,
    meshes: DeviceMeshes,
    voxels: Option<DeviceVoxels>,
    blocks: Option<DeviceBlocks>,
    /// Changed blocks that are read back at once.
    likely: usize,
    /// Where the blocks of the last submission are, by imprint, tile and block.
    kept: BTreeMap<(u32, u32, u32), u32>,
}

/// A stage of an imprint or, where it does not depend on others, of several.
#[derive(Clone, Copy, Debug)]
enum Stage<'a> {
    /// What is found of a target first.
    Measure(usize),
    Voxelise(&'a Batch),
    /// Of the row of imprints of one object that begins with this one.
    Cull(usize),
    Raycast(usize),
}

impl Stage<'_> {
    /// The name of its pass, where passes are timed.
    fn name(self) -> &'static str {
        match self {
            Self::Measure(_) | Self::Cull(_) => "imprint.device.cull",
            Self::Voxelise(_) => "imprint.device.voxelise",
            Self::Raycast(_) => "imprint.device.raycast",
        }
    }
}

impl DeviceChain {
    /// Room for imprints on a device. Fails where it has none.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            device: device.clone(),
            shared: Shared::new(device)?,
            meshes: DeviceMeshes::new(device)?,
            voxels: None,
            blocks: None,
            likely: FEW,
            kept: BTreeMap::new(),
        })
    }

    /// Whether it is on `device`.
    pub fn is_on(&self, device: &Device) -> bool {
        self.device.is_same(device)
    }

    /// Makes the imprints `links` of `colliders`, each after those before it, in one submission. What is returned is in
    /// their order; nothing is written into the objects.
    ///
    /// Fails, as a whole, where the device does, has no room, or cannot place the points of a collider, and for a collider
    /// that has two poses of its points at once.
    pub fn run(
        &mut self,
        context: &Context,
        targets: &mut [Target<'_>],
        colliders: &[&Collider],
        links: &[Link],
    ) -> Result<Vec<Cast>> {
        if links.len() > MOST_LINKS {
            return Err(Error::internal(format!("{} imprints at once; there may be {MOST_LINKS}", links.len())));
        }
        for target in &mut *targets {
            target.state.follow(target.object, target.start)?;
            target.state.prepare_culling(target.object)?;
        }
        let renewed = self.meshes.bring(&self.device, colliders)?;
        let (slots, slot_count) = slots(targets, links);
        let mut words = links.iter().map(|link| self.tell(link, targets, &slots)).collect::<Result<Vec<_>>>()?;
        let of: Vec<usize> = links.iter().map(|link| link.target).collect();
        let batches = batches(&mut words, &of, most_voxels(&self.device))?;
        let room = batches.iter().fold(VoxelRoom::default(), |room, batch| room.or(batch.room));
        let meshes = (&self.meshes, renewed);
        if DeviceVoxels::prepare(&mut self.voxels, &self.device, &self.shared, meshes, room)? {
            // What was bound is bound to the new ones.
            self.bind(self.blocks.as_ref().map_or([FEW, FEW, slot_count], DeviceBlocks::room))?;
        }
        self.enlarge([FEW, FEW, slot_count])?;
        let (told, records) = loop {
            let [room, record_room, _] = self.blocks()?.room();
            words.iter_mut().for_each(|words| words.set_room([room, record_room]));
            let (kept, told, records) = self.submit(context, targets, links, &words, &batches)?;
            let found = told.iter().map(|told| told.found as usize).max().unwrap_or_default();
            if found <= room && kept <= record_room {
                break (told, records);
            }
            self.enlarge([found, kept, slot_count])?;
        };
        targets.iter_mut().for_each(|target| target.state.settle_culling());
        told.iter().try_for_each(Told::check)?;
        let place = |(place, record): (u32, &Record)| ((record.link(), record.tile, record.block()), place);
        self.kept = (0..).zip(&records).map(place).collect();
        Ok(casts(targets, links, &told, &records))
    }

    /// Writes what the last submission left of an object into what the device has of its displacement, which is `field`
    /// now, and makes the rings there. `stays` says of an imprint and a tile whether it is so.
    pub fn write(&self, state: &mut DeviceObject, field: &Field, stays: impl Fn(usize, u32) -> bool) -> Result<()> {
        let kept = self.kept.iter().filter(|((link, tile, _), _)| stays(*link as usize, *tile));
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

    /// What kernels are told of an imprint.
    fn tell(&self, link: &Link, targets: &[Target<'_>], slots: &[Option<Slots>]) -> Result<Words> {
        let target = &targets[link.target];
        let ground = Ground {
            transform: target.object.transform(),
            tiles: target.object.surface().tile_count(),
            started: target.begun().is_some(),
            slots: slots[link.target],
        };
        Ok(Words::new(link, self.meshes.place(link.mesh)?, &ground))
    }

    fn voxels(&self) -> Result<&DeviceVoxels> {
        self.voxels.as_ref().ok_or_else(|| Error::internal("no room for voxels"))
    }

    fn blocks(&self) -> Result<&DeviceBlocks> {
        self.blocks.as_ref().ok_or_else(|| Error::internal("no room for blocks"))
    }

    /// Makes room for as many blocks, records and slots, and no other.
    fn bind(&mut self, room: [usize; 3]) -> Result<()> {
        // What they took is free before more is asked for.
        self.blocks = None;
        self.blocks = Some(DeviceBlocks::new(&self.device, &self.shared, self.voxels()?, room)?);
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

    /// Records a stage.
    fn record(&self, pass: &mut Pass<'_>, stage: Stage<'_>, targets: &[Target<'_>], links: &[Link]) -> Result<()> {
        let (shared, voxels, blocks) = (&self.shared, self.voxels()?, self.blocks()?);
        match stage {
            Stage::Measure(target) => {
                let state = &*targets[target].state;
                state.culling()?.measure(pass, &state.surface, &state.tiles)
            }
            Stage::Voxelise(batch) => voxels.fill(pass, shared, batch),
            Stage::Cull(link) => {
                let state = &*targets[links[link].target].state;
                state.culling()?.cull(pass, shared, blocks.listing(), &state.surface, link)
            }
            Stage::Raycast(link) => {
                let target = &targets[links[link].target];
                let tiles = &target.state.tiles;
                let fields = [tiles, target.begun().unwrap_or(tiles)];
                blocks.cast(pass, shared, &target.state.surface, fields, link)
            }
        }
    }

    /// Records and submits everything. Returns how many blocks changed, what is told of every imprint, and the blocks, as
    /// many as there was room for.
    fn submit(
        &mut self,
        context: &Context,
        targets: &[Target<'_>],
        links: &[Link],
        words: &[Words],
        batches: &[Batch],
    ) -> Result<(usize, Vec<Told>, Vec<Record>)> {
        let device = &self.device.clone();
        let time = context.stats().begin("imprint.device.submit");
        let mut frame = device.frame()?;
        self.shared.begin(device, &mut frame, words)?;
        let blocks = self.blocks()?;
        if words.iter().any(Words::is_chained) {
            blocks.clear_slots(&mut frame);
        }
        let each = |link| [Stage::Cull(link), Stage::Raycast(link)];
        let of_batch = |batch| std::iter::once(Stage::Voxelise(batch)).chain(batch.rows.iter().copied().flat_map(each));
        let mut stages = (0..targets.len()).map(Stage::Measure).chain(batches.iter().flat_map(of_batch));
        if device.is_timed() {
            stages.try_for_each(|stage| self.record(&mut frame.pass(stage.name()), stage, targets, links))?;
        } else {
            // Every pass is a command buffer: those that nobody times are one.
            let mut pass = frame.pass("imprint.device");
            stages.try_for_each(|stage| self.record(&mut pass, stage, targets, links))?;
        }
        let record_room = blocks.room()[1];
        let told = self.shared.read_told(&mut frame, links.len())?;
        let likely = self.likely.min(record_room);
        let first = blocks.read(&mut frame, 0..likely)?;
        let submission = frame.submit()?;
        time.end();
        let (kept, told) = parse(&told.get(device)?);
        let mut records = first.get(device)?;
        for time in submission.wait()? {
            context.stats().add(time.name, time.length);
        }
        let there = kept.min(record_room);
        records.truncate(there);
        if there > likely {
            let mut frame = device.frame()?;
            let rest = blocks.read(&mut frame, likely..there)?;
            let _ = frame.submit()?;
            records.extend(rest.get(device)?);
        }
        self.likely = (kept + kept / 4).max(FEW);
        Ok((kept, told, records))
    }
}

/// Where the blocks of every target are noted that imprints change before others look at them: of targets that several
/// imprints meet. And how many such places there are.
fn slots(targets: &[Target<'_>], links: &[Link]) -> (Vec<Option<Slots>>, usize) {
    let mut count = 0;
    let each = targets.iter().enumerate().map(|(index, target)| {
        if links.iter().filter(|link| link.target == index).count() < 2 {
            return None;
        }
        let field = target.object.displacement().field();
        let blocks = |tile| (field.size(tile) / block_edge(field.size(tile))).pow(2);
        let stride = 1 + (0..field.tile_count() as u32).map(blocks).max().unwrap_or(1);
        let base = count;
        count += field.tile_count() * stride as usize;
        Some(Slots { base: base as u32, stride })
    });
    (each.collect(), count.max(1))
}

/// What the imprints did, from what was read back.
fn casts(targets: &[Target<'_>], links: &[Link], told: &[Told], records: &[Record]) -> Vec<Cast> {
    let mut order: Vec<&Record> = records.iter().collect();
    order.sort_unstable_by_key(|record| (record.link(), record.tile, record.block()));
    let mut order = &order[..];
    let mut all = Vec::with_capacity(links.len());
    for (index, (link, told)) in links.iter().zip(told).enumerate() {
        let (own, rest) = order.split_at(order.partition_point(|record| record.link() <= index as u32));
        order = rest;
        let field = targets[link.target].object.displacement().field();
        let dents = own.chunk_by(|a, b| a.tile == b.tile).map(|tile| {
            let mut dents = TileDents { tile: tile[0].tile, ..TileDents::default() };
            debug_assert!((dents.tile as usize) < field.tile_count());
            for record in tile {
                let halves: &[f16] = bytemuck::cast_slice(&record.values);
                let mut values = [f16::ZERO; BLOCK_KNOTS];
                values.copy_from_slice(halves);
                dents.blocks.push(DentBlock { index: record.block(), values });
                dents.changed += record.changed;
                dents.least = dents.least.min(unkey(record.least as i16));
            }
            dents
        });
        all.push(Cast {
            dents: dents.collect(),
            tiles: told.tiles.into(),
            tested: told.tested.into(),
            clamped: told.clamped.into(),
            triangles: link.triangles,
        });
    }
    all
}
