//! Imprints on triangle meshes on a graphics device (`shaders/imprint`): culling of triangles, voxels,
//! rays of their values, rims and smoothing are one submission of one or more imprints, each of which starts from what
//! those before it left.
//! Nothing is read back before the end; what comes back becomes the edits that the processor would have made.
//!
//! Stages and voxels are those of imprints on tiles, see [`super::chain`]. A triangle's block has the values of its sides
//! and corners too, so that there is one list; 256 values of a block are a record as 256 coefficients of a tile are.

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::imprint_link::JobCounters;
use relievo_gpu::{Bindings, Buffer, Device, GROUP, Pass, groups};
use relievo_surface::DeviceMesh;
use relievo_tiles::triangle::TriangleField;

use super::batches::{Batch, batches, most_voxels};
use super::blocks::Record;
use super::job::{Ground, ImprintJob, JobParams, MAX_JOBS, Slots};
use super::meshes::DeviceMeshes;
use super::rim::{Around, RimRoom, RimStages, volumes};
use super::shared::{Shared, check, step};
use super::submitted::{FIRST_ROOM, Results, Submitted};
use super::triangle_press::{CASTING, CULLING, TrianglePress, parts};
use super::triangle_rim::BoundRim;
use super::triangle_smoothing::{Beside, BoundMesh, TriangleSmoothing};
use super::voxel::{DeviceVoxels, VoxelRoom};
use crate::channels::knots::BLOCK_KNOTS;
use crate::imprint::collider::Collider;
use crate::imprint::rim::Volumes;
use crate::triangle::TriangleObject;

/// In the number of a record's part: it is what smoothing left.
const SETTLED: u32 = 0x4000;

/// A mesh that is imprinted on.
#[derive(Debug)]
pub(crate) struct TriangleTarget<'a> {
    pub press: &'a mut Option<TrianglePress>,
    pub mesh: &'a DeviceMesh,
    pub object: &'a TriangleObject,
    /// The displacement from which the depth limits count, if it is not what it is now.
    pub start: Option<&'a TriangleField>,
}

impl TriangleTarget<'_> {
    fn press(&self) -> Result<&TrianglePress> {
        self.press.as_ref().ok_or_else(|| Error::internal("a mesh that is not ready for imprints"))
    }
}

/// Values of a triangle's block as an imprint left them.
#[derive(Clone, Debug)]
pub(crate) struct PressedValues {
    pub face: u32,
    /// The first of them: those inside, then those of the sides from the lower vertex of each edge, then the corners.
    pub first: usize,
    /// As many as there are from there on; what follows the last is of no meaning.
    pub values: [f16; BLOCK_KNOTS],
    /// Whether they are what smoothing left afterwards, and no edit.
    pub settled: bool,
}

/// What the rays of an imprint found.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleCast {
    /// By triangle, ascending.
    pub pressed: Vec<PressedValues>,
    /// Triangles and values that were looked at, those of sides and corners once for each triangle that has them.
    pub faces: u64,
    pub tested: u64,
    pub clamped: u64,
    pub triangles: u64,
    /// What triangles pushed and raised, ascending, where something rises.
    pub volumes: Vec<(u32, Volumes)>,
}

/// What imprints on triangle meshes have on a device besides the meshes.
#[derive(Debug)]
pub(crate) struct TriangleChain {
    device: Device,
    shared: Shared,
    voxels: Option<DeviceVoxels>,
    records: Buffer<Record>,
    slots: Buffer<u32>,
    smoothing: TriangleSmoothing,
    rims: Option<RimStages>,
    rim_room: RimRoom,
    /// Records that are read back at once.
    likely: usize,
}

/// What is bound of a mesh.
#[derive(Debug)]
struct Bound {
    culling: Bindings,
    casting: Bindings,
    smoothing: Option<BoundMesh>,
    /// What culls around contacts, and what rises there.
    rim: Option<(Bindings, BoundRim)>,
}

impl TriangleChain {
    /// Room for imprints on a device. Fails where it has none.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            device: device.clone(),
            shared: Shared::new(device)?,
            voxels: None,
            records: Buffer::new(device, "changed values", FIRST_ROOM)?,
            slots: Buffer::new(device, "values' slots", 1)?,
            smoothing: TriangleSmoothing::new(device)?,
            rims: None,
            rim_room: RimRoom::default(),
            likely: FIRST_ROOM,
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
        targets: &mut [TriangleTarget<'_>],
        colliders: &[&Collider],
        jobs: &[ImprintJob],
    ) -> Result<Vec<TriangleCast>> {
        if jobs.len() > MAX_JOBS {
            return Err(Error::internal(format!("{} imprints at once; there may be {MAX_JOBS}", jobs.len())));
        }
        for (index, target) in targets.iter_mut().enumerate() {
            let press = TrianglePress::follow(target.press, &self.device, target.object, target.start)?;
            let smooths = (0..jobs.len()).any(|job| jobs[job].target == index && is_smoothed(jobs, job));
            let rises = jobs.iter().any(|job| job.target == index && job.rising.is_some());
            press.prepare(&self.device, smooths, rises)?;
        }
        meshes.bring(&self.device, colliders)?;
        let (slots, slot_count) = slots(targets, jobs);
        if slot_count > self.slots.len() {
            self.slots = Buffer::new(&self.device, "values' slots", slot_count)?;
        }
        let tell = |job: &ImprintJob| {
            let TriangleTarget { object, start, .. } = &targets[job.target];
            let tiles = object.surface().topology().face_count();
            let ground =
                Ground { transform: object.transform(), tiles, started: start.is_some(), slots: slots[job.target] };
            Ok(JobParams::new(job, meshes.place(job.mesh)?, &ground))
        };
        let mut words = jobs.iter().map(tell).collect::<Result<Vec<_>>>()?;
        // Every imprint is a row of its own.
        let rows: Vec<usize> = (0..jobs.len()).collect();
        let batches = batches(&mut words, &rows, most_voxels(&self.device))?;
        let room = batches.iter().fold(VoxelRoom::default(), |room, batch| room.or(batch.room));
        DeviceVoxels::prepare(&mut self.voxels, &self.device, &self.shared, meshes, room)?;
        let (places, place_count) = places(targets, jobs);
        let around = |(job, words): (&ImprintJob, &JobParams)| {
            let (rising, transform) = (job.rising?, targets[job.target].object.transform());
            let words = words.in_grid(&rising.grid(&job.grid, transform), transform);
            Some(Around { rising, words, places: places[job.target] })
        };
        let rims: Vec<Option<Around>> = jobs.iter().zip(&words).map(around).collect();
        let smooths = (0..jobs.len()).any(|job| is_smoothed(jobs, job));
        let (mut taken, mut rim_room) = (0, rims.iter().any(Option::is_some).then_some(self.rim_room));
        let (counters, records, moved) = loop {
            if smooths {
                let smoothed = targets.iter().filter_map(|target| target.press.as_ref()?.smoothed.as_ref());
                self.smoothing.enlarge(&self.device, taken, smoothed)?;
            }
            if let Some(room) =
                rim_room.filter(|room| !self.rims.as_ref().is_some_and(|it| it.fits(*room, place_count)))
            {
                // What they took is free before more is asked for.
                self.rims = None;
                self.rims = Some(RimStages::new(&self.device, room, place_count, self.records.len())?);
            }
            let (room, capacity) = (self.records.len(), self.smoothing.capacity());
            words.iter_mut().for_each(|words| words.set_room([0, room, capacity]));
            let made = self.submit(context, targets, jobs, (&words, &rims), &batches)?;
            if made.kept <= room && made.taken <= capacity && made.rim_room == rim_room {
                break (made.counters, made.records, made.moved);
            }
            (taken, rim_room) = (made.taken, made.rim_room);
            self.rim_room = rim_room.unwrap_or(self.rim_room);
            if made.kept > room {
                self.rims = None;
                self.records = Buffer::new(&self.device, "changed values", made.kept + made.kept / 4)?;
            }
        };
        counters.iter().try_for_each(check)?;
        Ok(casts(jobs, &counters, &records, &moved))
    }

    fn rims(&self) -> Result<&RimStages> {
        self.rims.as_ref().ok_or_else(|| Error::internal("no room for rims"))
    }

    /// Records and submits everything.
    fn submit(
        &mut self,
        context: &Context,
        targets: &[TriangleTarget<'_>],
        jobs: &[ImprintJob],
        (words, rims): (&[JobParams], &[Option<Around>]),
        batches: &[Batch],
    ) -> Result<Submitted> {
        let device = &self.device;
        let time = context.stats().begin("imprint.device.submit");
        let voxels = self.voxels.as_ref().ok_or_else(|| Error::internal("no room for voxels"))?;
        let bound = targets.iter().map(|target| self.bind(target.press()?, voxels)).collect::<Result<Vec<_>>>()?;
        let mut frame = device.frame()?;
        self.shared.begin(device, &mut frame, words)?;
        if words.iter().any(JobParams::is_chained) {
            frame.clear(&self.slots);
        }
        self.smoothing.clear(&mut frame);
        let rising = rims.iter().any(Option::is_some);
        if rising {
            self.rims()?.begin(device, &mut frame, rims)?;
        }
        let mut pass = frame.pass("imprint.device.triangles");
        for batch in batches {
            voxels.fill(&mut pass, &self.shared, batch)?;
            for job in batch.jobs.clone() {
                let index = jobs[job].target;
                self.press(&mut pass, &targets[index], &bound[index], (jobs, job))?;
            }
        }
        drop(pass);
        let rims = if rising { Some(self.rims()?) } else { None };
        let results = Results { shared: &self.shared, records: &self.records, rims, jobs: jobs.len() };
        let made = results.submit(context, device, frame, self.likely, time)?;
        self.likely = made.likely();
        Ok(made)
    }

    /// What is bound of a mesh.
    fn bind(&self, press: &TrianglePress, voxels: &DeviceVoxels) -> Result<Bound> {
        let (device, shared) = (&self.device, &self.shared);
        let (counters, slots) = (shared.counters.wgpu(), self.slots.wgpu());
        let culling = |of: &Shared| {
            let (boxes, arguments) = (of.boxes.wgpu(), shared.arguments.wgpu());
            device.bind_as(&CULLING, &[of.jobs.wgpu(), slots, boxes, arguments, counters])
        };
        let (jobs, held, inside) = (shared.jobs.wgpu(), press.held.wgpu(), press.inside.wgpu());
        let records = self.records.wgpu();
        let from = [jobs, press.listed.wgpu(), shared.arguments.wgpu(), voxels.spans().wgpu(), voxels.words().wgpu()];
        let beside = [&[inside][..], &press.ways()].concat();
        let casting = device.bind_as(&CASTING, &[&from[..], &[slots, counters, records], &beside].concat())?;
        let smoothing = press
            .smoothed
            .as_ref()
            .map(|mesh| self.smoothing.bind(device, mesh, Beside { jobs, held, slots, counters, records }));
        let rim = self.rims.as_ref().filter(|_| press.raised.is_some()).map(|stages| {
            let [entries, values] = press.ways();
            let beside = (press.listed.wgpu(), [inside, entries, values]);
            let bound = BoundRim::new(device, stages, (shared, voxels), (&self.slots, &self.records), beside)?;
            Ok((culling(&stages.around)?, bound))
        });
        Ok(Bound { culling: culling(shared)?, casting, smoothing: smoothing.transpose()?, rim: rim.transpose()? })
    }

    /// Records an imprint whose voxels are there: culling and rays, what rises, and where others go on from it what is
    /// smoothed.
    fn press(
        &self,
        pass: &mut Pass<'_>,
        target: &TriangleTarget<'_>,
        it: &Bound,
        (jobs, job): (&[ImprintJob], usize),
    ) -> Result<()> {
        let (press, mesh) = (target.press()?, target.mesh);
        let ImprintJob { target: index, smoothing: (_, passes), rising, .. } = jobs[job];
        let rim = it.rim.as_ref().zip(press.raised.as_ref()).filter(|_| rising.is_some());
        let immediates = step(job..job + 1);
        let immediates = bytemuck::bytes_of(&immediates);
        let faces = groups((mesh.face_count() as u32).div_ceil(GROUP));
        let culling = rim.map_or(&it.culling, |((around, _), _)| around);
        pass.run(&press.culling, &[culling, mesh.group(), &press.culled], immediates, faces)?;
        let on = (mesh, &press.values);
        if let Some(((_, bound), kernels)) = rim {
            bound.gather(pass, (self.rims()?, kernels), on, job)?;
        }
        let start = press.begun.as_ref().filter(|_| target.start.is_some()).unwrap_or(&press.values);
        let bound = [&it.casting, mesh.group(), press.values.group(), start.group()];
        let (arguments, first) = (&self.shared.arguments, Shared::blocks(job));
        pass.run_indirect(&press.casting, &bound, immediates, arguments, first)?;
        if let Some(((_, bound), kernels)) = rim {
            bound.raise(pass, (self.rims()?, kernels), on, job)?;
        }
        if !jobs[job + 1..].iter().any(|job| job.target == index) {
            return Ok(());
        }
        match press.smoothed.as_ref().zip(it.smoothing.as_ref()).filter(|_| passes > 0) {
            Some(smoothed) => self.smoothing.smooth(pass, smoothed, on, job, passes),
            None => Ok(()),
        }
    }
}

/// Whether what an imprint changed is smoothed for another one that follows it on the same mesh.
fn is_smoothed(jobs: &[ImprintJob], job: usize) -> bool {
    jobs[job].smoothing.1 > 0 && jobs[job + 1..].iter().any(|later| later.target == jobs[job].target)
}

/// Where the pieces of every target are on which something rises, and how many a triangle has. And how many there are.
fn places(targets: &[TriangleTarget<'_>], jobs: &[ImprintJob]) -> (Vec<[u32; 2]>, usize) {
    let mut count = 0;
    let each = targets.iter().enumerate().map(|(index, target)| {
        if !jobs.iter().any(|job| job.target == index && job.rising.is_some()) {
            return [0; 2];
        }
        let field = target.object.displacement().field();
        let (base, of_face) = (count, parts(field.pattern()));
        count += field.topology().face_count() * of_face as usize;
        [base as u32, of_face]
    });
    (each.collect(), count)
}

/// Where the slots of every target are that several imprints meet, see `triangle_imprint_slot.wgsl`, and how many there are.
fn slots(targets: &[TriangleTarget<'_>], jobs: &[ImprintJob]) -> (Vec<Option<Slots>>, usize) {
    let mut count = 0;
    let each = targets.iter().enumerate().map(|(index, target)| {
        if jobs.iter().filter(|job| job.target == index).count() < 2 {
            return None;
        }
        let field = target.object.displacement().field();
        let (base, stride) = (count, 3 + parts(field.pattern()));
        count += field.topology().face_count() * stride as usize;
        Some(Slots { base: base as u32, stride })
    });
    (each.collect(), count)
}

/// What the imprints did, from what was read back.
fn casts(jobs: &[ImprintJob], counters: &[JobCounters], records: &[Record], moved: &[[f32; 2]]) -> Vec<TriangleCast> {
    let moved = moved.iter().copied().chain(std::iter::repeat([0.0; 2]));
    let mut order: Vec<(&Record, [f32; 2])> = records.iter().zip(moved).collect();
    let part = |record: &Record| record.block() & !SETTLED;
    let is_settled = |record: &Record| record.block() & SETTLED != 0;
    order.sort_unstable_by_key(|(record, _)| (record.job(), record.tile, part(record), is_settled(record)));
    let mut order = &order[..];
    let mut all = Vec::with_capacity(jobs.len());
    for (index, (job, counters)) in jobs.iter().zip(counters).enumerate() {
        let (own, rest) = order.split_at(order.partition_point(|(record, _)| record.job() <= index as u32));
        order = rest;
        let pressed = own.iter().map(|(record, _)| {
            let mut values = [f16::ZERO; BLOCK_KNOTS];
            values.copy_from_slice(bytemuck::cast_slice(&record.values));
            PressedValues {
                face: record.tile,
                first: part(record) as usize * BLOCK_KNOTS,
                values,
                settled: is_settled(record),
            }
        });
        // Of records that are no edits nothing is known.
        let edited = own.iter().filter(|(record, _)| job.rising.is_some() && record.changed > 0);
        let edited: Vec<_> = edited.map(|(record, moved)| (record.tile, volumes(*moved))).collect();
        let by_face = edited.chunk_by(|(a, _), (b, _)| a == b);
        all.push(TriangleCast {
            pressed: pressed.collect(),
            faces: counters.tiles.into(),
            tested: counters.tested.into(),
            clamped: counters.clamped.into(),
            triangles: job.triangles,
            volumes: by_face.map(|of| (of[0].0, of.iter().map(|(_, volumes)| *volumes).sum())).collect(),
        });
    }
    all
}
