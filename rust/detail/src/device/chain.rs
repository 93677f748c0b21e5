//! Imprints on a graphics device, all stages in a row and several of them in one submission (Schäfer et al. 2014, Sections
//! 5 and 6): culling, the list of blocks, voxels, rays. Nothing is read back before the end; then the blocks that changed
//! are, and become the edit that the processor would have made.
//!
//! What follows needs room that is not known before: there is so much, counters say whether it was enough, and what was
//! not is done again with more.

use std::collections::BTreeMap;

use glam::DAffine3;
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Device, Pass};
use relievo_tiles::Field;

use super::blocks::{DeviceBlocks, MOST_LINKS, Record, Slots, Told, parse};
use super::collider::{DeviceCollider, check};
use super::state::DeviceObject;
use super::voxel::DeviceVoxels;
use crate::collider::Collider;
use crate::cull::VoxelFrame;
use crate::grid::Grid;
use crate::imprint::Cast;
use crate::knots::{BLOCK_KNOTS, block_edge};
use crate::lattice::Lattice;
use crate::object::DisplacedObject;
use crate::raycast::{DentBlock, Limits, TileDents, unkey};
use crate::voxel::Side;

/// An object that is imprinted on.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    pub state: &'a mut DeviceObject,
    pub object: &'a DisplacedObject,
    /// The displacement from which the depth limits count, if it is not what it is now.
    pub start: Option<&'a Field>,
}

/// An imprint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    target: usize,
    /// Which collider, how many triangles it has, and where it is.
    mesh: u64,
    triangles: u64,
    transform: DAffine3,
    side: Side,
    grid: Grid,
    limits: Limits,
    lattice: Lattice,
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
        Some(Self {
            target,
            mesh: collider.identity[0],
            triangles: collider.triangles().len() as u64,
            transform: *collider.transform(),
            side,
            grid: *grid,
            limits: *limits,
            lattice,
        })
    }
}

/// A mesh that was brought to the device.
#[derive(Debug)]
struct Brought {
    mesh: DeviceCollider,
    /// Which points it has.
    points: u64,
    used: u64,
}

/// Meshes that are kept on the device, if more are not needed at once.
const KEPT: usize = 16;

/// Blocks that there is room for at first, and that are read back.
const FEW: usize = 512;

/// What imprints have on a device besides the objects.
#[derive(Debug)]
pub(crate) struct DeviceChain {
    device: Device,
    voxels: Option<DeviceVoxels>,
    blocks: DeviceBlocks,
    colliders: BTreeMap<u64, Brought>,
    uses: u64,
    /// Changed blocks that are read back at once.
    likely: usize,
}

impl DeviceChain {
    /// Room for imprints on a device. Fails where it has none.
    pub fn new(device: &Device) -> Result<Self> {
        let blocks = DeviceBlocks::new(device, FEW, FEW, 1)?;
        let colliders = BTreeMap::new();
        Ok(Self { device: device.clone(), voxels: None, blocks, colliders, uses: 0, likely: FEW })
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
        self.uses += 1;
        for collider in colliders {
            self.bring(collider)?;
        }
        let (slots, slot_count) = slots(targets, links);
        self.enlarge([0, 0, slot_count])?;
        let (told, records) = loop {
            let (kept, told, records) = self.submit(context, targets, links, &slots)?;
            let found = told.iter().map(|told| told.found as usize).max().unwrap_or_default();
            if found <= self.blocks.room && kept <= self.blocks.record_room() {
                break (told, records);
            }
            self.enlarge([found, kept, slot_count])?;
        };
        self.let_go();
        for told in &told {
            check(told.faults)?;
        }
        Ok(casts(targets, links, &told, &records))
    }

    /// Brings a collider to the device as it is.
    fn bring(&mut self, collider: &Collider) -> Result<()> {
        let (device, used, [mesh, points]) = (&self.device, self.uses, collider.identity);
        match self.colliders.get_mut(&mesh) {
            Some(brought) => {
                if brought.points != points {
                    if brought.used == used {
                        return Err(Error::unsupported("a collider in two poses at once"));
                    }
                    brought.mesh.set_points(device, collider.points())?;
                }
                (brought.points, brought.used) = (points, used);
            }
            None => {
                let made = DeviceCollider::new(device, collider.points(), collider.triangles(), collider.is_closed())?;
                self.colliders.insert(mesh, Brought { mesh: made, points, used });
            }
        }
        Ok(())
    }

    /// Lets the meshes go that were not used for longest.
    fn let_go(&mut self) {
        while self.colliders.len() > KEPT {
            let oldest = self.colliders.iter().min_by_key(|(_, brought)| brought.used);
            let Some((mesh, _)) = oldest.filter(|(_, brought)| brought.used < self.uses) else { break };
            let mesh = *mesh;
            self.colliders.remove(&mesh);
        }
    }

    /// Makes room for as many blocks, records and slots.
    fn enlarge(&mut self, wanted: [usize; 3]) -> Result<()> {
        let there = [self.blocks.room, self.blocks.record_room(), self.blocks.slot_room()];
        if wanted.iter().zip(there).all(|(wanted, there)| *wanted <= there) {
            return Ok(());
        }
        let [room, records, slots] =
            [0, 1, 2].map(|k| if wanted[k] > there[k] { wanted[k] + wanted[k] / 4 } else { there[k] });
        self.blocks = DeviceBlocks::new(&self.device, room, records, slots)?;
        Ok(())
    }

    fn mesh(&self, mesh: u64) -> Result<&DeviceCollider> {
        let brought = self.colliders.get(&mesh).map(|brought| &brought.mesh);
        brought.ok_or_else(|| Error::internal("a collider that was not brought to the device"))
    }

    /// Records a stage of an imprint, of which the submission has so many before it.
    fn record(
        &mut self,
        pass: &mut Pass<'_>,
        stage: Stage,
        (index, link): (usize, &Link),
        (Target { state, object, start }, slots): (&Target<'_>, Option<Slots>),
    ) -> Result<()> {
        match &mut self.voxels {
            Some(voxels) => voxels.prepare(&self.device, &link.grid)?,
            none => *none = Some(DeviceVoxels::new(&self.device, &link.grid)?),
        }
        let voxels = self.voxels.as_ref().ok_or_else(|| Error::internal("no room for voxels"))?;
        let (blocks, culling, mesh) = (&self.blocks, state.culling()?, self.mesh(link.mesh)?);
        let view = VoxelFrame::new(&link.grid, object.transform());
        match stage {
            Stage::Cull => culling.cull(pass, &state.surface, &view),
            Stage::Compact => {
                culling.compact(pass)?;
                blocks.list(pass, culling, index as u32)
            }
            Stage::Voxelise => {
                mesh.snap(pass, &link.lattice)?;
                let mirrored = (link.grid.map * link.transform).matrix3.determinant() < 0.0;
                voxels.fill(pass, mesh, link.side, mirrored)
            }
            Stage::Raycast => {
                let start = start.and_then(|_| state.begun());
                blocks.sample(pass, &state.surface, &state.tiles, start, slots)?;
                blocks.cast(pass, voxels, &view, &link.limits)?;
                blocks.keep(pass, culling, slots, index as u32)
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
        slots: &[Option<Slots>],
    ) -> Result<(usize, Vec<Told>, Vec<Record>)> {
        let device = &self.device.clone();
        let stage = context.stats().begin("imprint.device.submit");
        let mut frame = device.frame()?;
        self.blocks.begin(&mut frame);
        if slots.iter().any(Option::is_some) {
            self.blocks.clear_slots(&mut frame);
        }
        let mut steps = links.iter().enumerate().flat_map(|(index, link)| STAGES.map(|stage| (stage, index, link)));
        let of = |link: &Link| (&targets[link.target], slots[link.target]);
        if device.is_timed() {
            steps.try_for_each(|((name, stage), index, link)| {
                self.record(&mut frame.pass(name), stage, (index, link), of(link))
            })?;
        } else {
            // Every pass is a command buffer: those that nobody times are one.
            let mut pass = frame.pass("imprint.device");
            steps.try_for_each(|((_, stage), index, link)| self.record(&mut pass, stage, (index, link), of(link)))?;
        }
        let blocks = &self.blocks;
        let used: BTreeMap<u64, usize> = (0..).zip(links).map(|(index, link)| (link.mesh, index)).collect();
        for (mesh, last) in used {
            let (told, at) = blocks.told(last);
            self.mesh(mesh)?.tell(&mut frame, told, at)?;
        }
        for (target, _) in targets.iter().zip(slots).filter(|(_, slots)| slots.is_some()) {
            target.state.culling()?.forget(&mut frame);
        }
        let told = blocks.read_told(&mut frame, links.len())?;
        let likely = self.likely.min(blocks.record_room());
        let first = blocks.read(&mut frame, 0..likely)?;
        let submission = frame.submit()?;
        stage.end();
        let (kept, told) = parse(&told.get(device)?);
        let mut records = first.get(device)?;
        for time in submission.wait()? {
            context.stats().add(time.name, time.length);
        }
        let there = kept.min(blocks.record_room());
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

/// The stages of an imprint, each a pass where passes are timed.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Cull,
    Compact,
    Voxelise,
    Raycast,
}

const STAGES: [(&str, Stage); 4] = [
    ("imprint.device.cull", Stage::Cull),
    ("imprint.device.compact", Stage::Compact),
    ("imprint.device.voxelise", Stage::Voxelise),
    ("imprint.device.raycast", Stage::Raycast),
];

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
        let stride = (0..field.tile_count() as u32).map(blocks).max().unwrap_or(1);
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
