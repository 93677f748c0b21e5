//! Imprints on triangle meshes on a graphics device (`shaders/triangle_imprint*.wgsl`): culling of triangles, voxels and
//! rays of their values are one submission of one or more imprints, each of which starts from what those before it left.
//! Nothing is read back before the end; what comes back becomes the edits that the processor would have made.
//!
//! Stages and voxels are those of imprints on tiles, see [`super::chain`]. A triangle's block has the values of its sides
//! and corners too, so that there is one list; 256 values of a block are a record as 256 coefficients of a tile are.

use std::sync::Arc;

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, Pass, groups};
use relievo_surface::{DeviceMesh, MESH_GROUP};
use relievo_tiles::triangle::{DeviceTriangles, Pattern, TRIANGLES_GROUP, TriangleField};

use super::blocks::Record;
use super::link::{Batch, Ground, Link, MOST_LINKS, Shared, Slots, Told, Words, batches, most_voxels, parse, step};
use super::meshes::DeviceMeshes;
use super::voxel::{DeviceVoxels, VoxelRoom};
use crate::collider::Collider;
use crate::knots::BLOCK_KNOTS;
use crate::triangle::{TriangleObject, field_range};

/// What imprints on a triangle mesh need of a device, beside the mesh.
#[derive(Debug)]
pub(crate) struct TrianglePress {
    values: DeviceTriangles,
    /// The displacement from when the depth limit began to count, once there was one.
    begun: Option<DeviceTriangles>,
    ranges: Buffer<[f32; 2]>,
    listed: Buffer<u32>,
    /// Barycentric coordinates of the values inside a triangle.
    inside: Buffer<[f32; 3]>,
    /// Of every triangle whether it has a block, see `triangle_imprint.wgsl`.
    held: Buffer<u32>,
    culling: Arc<Kernel>,
    casting: Arc<Kernel>,
    following: Arc<Kernel>,
    culled: Bindings,
}

/// What the kernels have of a submission: imprints, slots, boxes, arguments and what is told.
const CULLING: [Access; 5] = [Access::Read, Access::Write, Access::Read, Access::Write, Access::Write];
/// Imprints, triangles, arguments, voxels, slots, what is told, records, places inside triangles, and which have blocks.
const CASTING: [Access; 10] = [
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Read,
    Access::Read,
];
/// Ranges, and the list.
const CULLED: [Access; 2] = [Access::Read, Access::Write];

/// Words of the values of a record.
const PAIRS: u32 = BLOCK_KNOTS as u32 / 2;

impl TrianglePress {
    /// For imprints on a mesh with the displacement `field`. Fails where the device has no room.
    fn new(device: &Device, field: &TriangleField) -> Result<Self> {
        let (pattern, faces) = (field.pattern(), field.topology().face_count());
        let immediates = size_of::<[u32; 2]>() as u32;
        let segments = ("SEGMENTS", f64::from(pattern.segments()));
        let parts = ("PARTS", f64::from(parts(pattern)));
        let culling = device.kernel(&KernelSpec {
            module: "triangle_imprint_cull",
            entry: "cull_faces",
            groups: &[&CULLING, &MESH_GROUP, &CULLED],
            immediates,
            constants: &[segments, parts],
        })?;
        let of_values = |entry| {
            device.kernel(&KernelSpec {
                module: "triangle_imprint",
                entry,
                groups: &[&CASTING, &MESH_GROUP, &TRIANGLES_GROUP, &TRIANGLES_GROUP],
                immediates,
                constants: &[segments, parts],
            })
        };
        let (casting, following) = (of_values("cast_values")?, of_values("follow_sides")?);
        let all: Vec<_> = (0..faces as u32).map(|face| field_range(field, face)).collect();
        let ranges = Buffer::of(device, "ranges of triangles", &all)?;
        let listed = Buffer::new(device, "triangles in the overlap", faces)?;
        let culled = device.bind_as(&CULLED, &[ranges.wgpu(), listed.wgpu()])?;
        let inside = Buffer::of(device, "places inside triangles", pattern.places())?;
        let holds: Vec<_> = (0..faces as u32).map(|face| held_by(field, face)).collect();
        let held = Buffer::of(device, "triangles with blocks", &holds)?;
        let values = DeviceTriangles::new(device, field, pattern)?;
        Ok(Self { values, begun: None, ranges, listed, inside, held, culling, casting, following, culled })
    }

    /// Makes `there` have `field`, and `start`, the displacement from which the depth limit counts. Fails where the device
    /// has no room.
    fn follow<'a>(
        there: &'a mut Option<Self>,
        device: &Device,
        field: &TriangleField,
        start: Option<&TriangleField>,
    ) -> Result<&'a mut Self> {
        let press = match there.take().filter(|it| it.values.pattern() == field.pattern()) {
            Some(mut press) => {
                for face in press.values.update(device, field)? {
                    press.ranges.write(device, face as usize, &[field_range(field, face)])?;
                    press.held.write(device, face as usize, &[held_by(field, face)])?;
                }
                there.insert(press)
            }
            None => there.insert(Self::new(device, field)?),
        };
        if let Some(start) = start {
            match &mut press.begun {
                Some(begun) => drop(begun.update(device, start)?),
                None => press.begun = Some(DeviceTriangles::new(device, start, field.pattern())?),
            }
        }
        Ok(press)
    }
}

/// Whether a triangle has a block, as kernels are told.
fn held_by(field: &TriangleField, face: u32) -> u32 {
    match field.face_pattern(face) {
        None => 0,
        Some(own) if own == field.pattern() => 1,
        Some(_) => 2,
    }
}

/// In the number of a record's part: values inside follow those on the sides.
const FOLLOWS: u32 = 0x8000;

/// Records that the values of a triangle's block make at most.
fn parts(pattern: Pattern) -> u32 {
    DeviceTriangles::<f16>::words(pattern).div_ceil(PAIRS)
}

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
    /// Whether those inside are what the sides say, since the triangle has no block.
    pub follows: bool,
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
}

/// Records that there is room for at first, and that are read back.
const FEW: usize = 512;

/// What imprints on triangle meshes have on a device besides the meshes.
#[derive(Debug)]
pub(crate) struct TriangleChain {
    device: Device,
    shared: Shared,
    meshes: DeviceMeshes,
    voxels: Option<DeviceVoxels>,
    records: Buffer<Record>,
    slots: Buffer<u32>,
    /// Records that are read back at once.
    likely: usize,
}

impl TriangleChain {
    /// Room for imprints on a device. Fails where it has none.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            device: device.clone(),
            shared: Shared::new(device)?,
            meshes: DeviceMeshes::new(device)?,
            voxels: None,
            records: Buffer::new(device, "changed values", FEW)?,
            slots: Buffer::new(device, "values' slots", 1)?,
            likely: FEW,
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
        targets: &mut [TriangleTarget<'_>],
        colliders: &[&Collider],
        links: &[Link],
    ) -> Result<Vec<TriangleCast>> {
        if links.len() > MOST_LINKS {
            return Err(Error::internal(format!("{} imprints at once; there may be {MOST_LINKS}", links.len())));
        }
        for target in &mut *targets {
            TrianglePress::follow(target.press, &self.device, target.object.displacement().field(), target.start)?;
        }
        let renewed = self.meshes.bring(&self.device, colliders)?;
        let (slots, slot_count) = slots(targets, links);
        if slot_count > self.slots.len() {
            self.slots = Buffer::new(&self.device, "values' slots", slot_count)?;
        }
        let tell = |link: &Link| {
            let TriangleTarget { object, start, .. } = &targets[link.target];
            let tiles = object.surface().topology().face_count();
            let ground =
                Ground { transform: object.transform(), tiles, started: start.is_some(), slots: slots[link.target] };
            Ok(Words::new(link, self.meshes.place(link.mesh)?, &ground))
        };
        let mut words = links.iter().map(tell).collect::<Result<Vec<_>>>()?;
        // Every imprint is a row of its own.
        let rows: Vec<usize> = (0..links.len()).collect();
        let batches = batches(&mut words, &rows, most_voxels(&self.device))?;
        let room = batches.iter().fold(VoxelRoom::default(), |room, batch| room.or(batch.room));
        DeviceVoxels::prepare(&mut self.voxels, &self.device, &self.shared, (&self.meshes, renewed), room)?;
        let (told, records) = loop {
            let room = self.records.len();
            words.iter_mut().for_each(|words| words.set_room([0, room, 0]));
            let (kept, told, records) = self.submit(context, targets, links, &words, &batches)?;
            if kept <= room {
                break (told, records);
            }
            self.records = Buffer::new(&self.device, "changed values", kept + kept / 4)?;
        };
        told.iter().try_for_each(Told::check)?;
        Ok(casts(links, &told, &records))
    }

    /// Records and submits everything. Returns how many records there are, whether or not there was room for them, what is
    /// told of the imprints, and the records that there are.
    fn submit(
        &mut self,
        context: &Context,
        targets: &[TriangleTarget<'_>],
        links: &[Link],
        words: &[Words],
        batches: &[Batch],
    ) -> Result<(usize, Vec<Told>, Vec<Record>)> {
        let device = &self.device;
        let time = context.stats().begin("imprint.device.submit");
        let voxels = self.voxels.as_ref().ok_or_else(|| Error::internal("no room for voxels"))?;
        let bound = targets.iter().map(|target| self.bind(target.press()?, voxels)).collect::<Result<Vec<_>>>()?;
        let mut frame = device.frame()?;
        self.shared.begin(device, &mut frame, words)?;
        if words.iter().any(Words::is_chained) {
            frame.clear(&self.slots);
        }
        let mut pass = frame.pass("imprint.device.triangles");
        for batch in batches {
            voxels.fill(&mut pass, &self.shared, batch)?;
            for link in batch.links.clone() {
                let index = links[link].target;
                let goes_on = links[link + 1..].iter().any(|link| link.target == index);
                self.press(&mut pass, &targets[index], &bound[index], (link, goes_on))?;
            }
        }
        drop(pass);
        let told = self.shared.read_told(&mut frame, links.len())?;
        let likely = self.likely.min(self.records.len());
        let first = frame.read(&self.records, 0..likely)?;
        let submission = frame.submit()?;
        time.end();
        let ([kept, _], told) = parse(&told.get(device)?);
        let mut records = first.get(device)?;
        for time in submission.wait()? {
            context.stats().add(time.name, time.length);
        }
        let there = kept.min(self.records.len());
        records.truncate(there);
        if there > likely {
            let mut frame = device.frame()?;
            let rest = frame.read(&self.records, likely..there)?;
            let _ = frame.submit()?;
            records.extend(rest.get(device)?);
        }
        self.likely = (kept + kept / 4).max(FEW);
        Ok((kept, told, records))
    }

    /// What is bound for culling and rays of a mesh.
    fn bind(&self, press: &TrianglePress, voxels: &DeviceVoxels) -> Result<[Bindings; 2]> {
        let Shared { links, told, arguments, boxes, .. } = &self.shared;
        let (told, slots) = (told.wgpu(), self.slots.wgpu());
        let culling = [links.wgpu(), slots, boxes.wgpu(), arguments.wgpu(), told];
        let from = [links.wgpu(), press.listed.wgpu(), arguments.wgpu(), voxels.spans().wgpu(), voxels.words().wgpu()];
        let to = [slots, told, self.records.wgpu(), press.inside.wgpu(), press.held.wgpu()];
        Ok([self.device.bind_as(&CULLING, &culling)?, self.device.bind_as(&CASTING, &[&from[..], &to[..]].concat())?])
    }

    /// Records the culling and the rays of an imprint whose voxels are there, and what follows of them if another one `goes
    /// on` from it.
    fn press(
        &self,
        pass: &mut Pass<'_>,
        target: &TriangleTarget<'_>,
        [culling, casting]: &[Bindings; 2],
        (link, goes_on): (usize, bool),
    ) -> Result<()> {
        let (press, mesh) = (target.press()?, target.mesh);
        let links = step(link..link + 1);
        let links = bytemuck::bytes_of(&links);
        let faces = groups((mesh.face_count() as u32).div_ceil(GROUP));
        pass.run(&press.culling, &[culling, mesh.group(), &press.culled], links, faces)?;
        let start = press.begun.as_ref().filter(|_| target.start.is_some()).unwrap_or(&press.values);
        let bound = [casting, mesh.group(), press.values.group(), start.group()];
        let (arguments, first) = (&self.shared.arguments, Shared::blocks(link));
        pass.run_indirect(&press.casting, &bound, links, arguments, first)?;
        if goes_on {
            pass.run_indirect(&press.following, &bound, links, arguments, first)?;
        }
        Ok(())
    }
}

/// Where the slots of every target are that several imprints meet, see `triangle_imprint_slot.wgsl`, and how many there are.
fn slots(targets: &[TriangleTarget<'_>], links: &[Link]) -> (Vec<Option<Slots>>, usize) {
    let mut count = 0;
    let each = targets.iter().enumerate().map(|(index, target)| {
        if links.iter().filter(|link| link.target == index).count() < 2 {
            return None;
        }
        let field = target.object.displacement().field();
        let (base, stride) = (count, 2 + 2 * parts(field.pattern()));
        count += field.topology().face_count() * stride as usize;
        Some(Slots { base: base as u32, stride })
    });
    (each.collect(), count)
}

/// What the imprints did, from what was read back.
fn casts(links: &[Link], told: &[Told], records: &[Record]) -> Vec<TriangleCast> {
    let mut order: Vec<&Record> = records.iter().collect();
    order.sort_unstable_by_key(|record| (record.link(), record.tile, record.block() & !FOLLOWS));
    let mut order = &order[..];
    let mut all = Vec::with_capacity(links.len());
    for (index, (link, told)) in links.iter().zip(told).enumerate() {
        let (own, rest) = order.split_at(order.partition_point(|record| record.link() <= index as u32));
        order = rest;
        let pressed = own.iter().map(|record| {
            let mut values = [f16::ZERO; BLOCK_KNOTS];
            values.copy_from_slice(bytemuck::cast_slice(&record.values));
            let part = record.block() & !FOLLOWS;
            let follows = record.block() & FOLLOWS != 0;
            PressedValues { face: record.tile, first: part as usize * BLOCK_KNOTS, values, follows }
        });
        all.push(TriangleCast {
            pressed: pressed.collect(),
            faces: told.tiles.into(),
            tested: told.tested.into(),
            clamped: told.clamped.into(),
            triangles: link.triangles,
        });
    }
    all
}
