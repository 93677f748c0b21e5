//! Dabs on triangle meshes on a graphics device (`shaders/triangles`): triangles in the box, sets, memory and edit of
//! all dabs of an event are one submission.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 6. The
//! paper's kernels go over faces and over edges. Here a triangle's block, which lives for an event, has the values of its
//! sides and corners too, so that there is one list: what changes is in the box, and so are all triangles that share it.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::brush::Intersect;
use relievo_gpu::wgsl::brush_edit::Edit;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, groups};
use relievo_surface::{DeviceMesh, MESH_GROUP};
use relievo_tiles::triangle::{DeviceTriangles, Offset, Pattern, TRIANGLES_GROUP, TriangleField};

use super::events::{DeviceEvents, DeviceTexel, DeviceValue, Ended, Returned, WORDS};
use super::intersect;
use super::memory::{BlockState, DeviceMemory, MAX_DABS};
use super::smear::{ACCESS, DeviceSmear};
use crate::paint::smudge::Smudge;
use crate::paint::stamp::Stamp;
use crate::paint::vector::BrushMaps;
use crate::paint::weights::BrushParameters;
use crate::triangle::TriangleGround;

/// What dabs on the values of triangles need of a device, beside the mesh, its displacement and the values themselves.
#[derive(Debug)]
pub(crate) struct TriangleBrush {
    events: DeviceEvents,
    intersect: Arc<Kernel>,
    /// Keeps blocks apart as they are before a dab that looks at neighbours.
    keep: Arc<Kernel>,
    /// How far triangles are displaced, what the device has of it, and the displacement that it is of.
    reaches: Buffer<f32>,
    known: Vec<f32>,
    seen: Option<(TriangleField, Option<TriangleField<Offset>>)>,
    sets: Bindings,
    smear: DeviceSmear,
    /// Of vectors three matrices a dab, see [`BrushMaps`].
    maps: Buffer<[[f32; 4]; 3]>,
}

/// What kernels have as their group 2: displacement and vectors that places go by, or of the latter anything.
const GROUND_GROUP: [Access; 4] = [Access::Read; 4];

/// What dabs are made on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleStage<'a, T: DeviceTexel> {
    pub device: &'a Device,
    pub mesh: &'a DeviceMesh,
    /// The displacement that places go by, there, along the normals and the vectors, and here.
    pub ground: (&'a DeviceTriangles, Option<&'a DeviceTriangles<Offset>>, TriangleGround<'a>),
    /// The values before the event, in the pattern of the ground.
    pub values: &'a DeviceTriangles<T>,
    pub field: &'a TriangleField<T>,
    /// Bytes that new blocks may take.
    pub left: u64,
    /// Whether dabs look at neighbours.
    pub looks_beside: bool,
    /// What brushes that smear carry, and which picture of the device that is, see [`smudges_of`](crate::device::smudges_of).
    pub smudges: &'a [(&'a Smudge, usize)],
    /// Of each dab on vectors how its brush lies.
    pub maps: &'a [BrushMaps],
}

impl TriangleBrush {
    /// For the values of `mesh` in `pattern`, and places that go by vectors if they are `bent`. Fails where the device has
    /// no room.
    pub fn new<T: DeviceValue>(device: &Device, mesh: &DeviceMesh, pattern: Pattern, bent: bool) -> Result<Self> {
        use Access::{Read, Write};
        // Tables of normals, of which painting and vectors have no use, and what these have instead.
        let tables = if T::SMEARS { [&[Read][..], &ACCESS].concat() } else { vec![Read; 2] };
        let own = [&[Read, Read, Read, Write, Write, Write, Read][..], &tables].concat();
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "triangle_brush",
                entry,
                groups: &[&own, &MESH_GROUP, &GROUND_GROUP, &TRIANGLES_GROUP],
                immediates: size_of::<Edit>() as u32,
                constants: &[("VECTORS", f64::from(u8::from(bent)))],
            })
        };
        let (edit, keep) = (kernel(T::TRIANGLES)?, kernel("keep")?);
        let intersect = device.kernel(&KernelSpec {
            module: "triangle_intersect",
            entry: "intersect",
            groups: &[&[Read, Read, Read, Write], &MESH_GROUP],
            immediates: size_of::<Intersect>() as u32,
            constants: &[],
        })?;
        let (faces, room) = (mesh.face_count(), DeviceTriangles::<T>::words(pattern));
        let memory = DeviceMemory::new(device, faces, (room, (WORDS / room).clamp(1, faces.max(1) as u32)), false)?;
        let known = vec![0.0; faces];
        let reaches = Buffer::of(device, "reaches of triangles", &known)?;
        let sets = bind(device, &intersect, &reaches, &memory)?;
        // There are no normals until a mode needs them.
        let smear = DeviceSmear::new(device)?;
        let [carried, picked] = smear.tables();
        let maps = Buffer::new(device, "how brushes lie", 3 * MAX_DABS)?;
        let second = if T::BENDS { maps.wgpu() } else { reaches.wgpu() };
        let normals = [reaches.wgpu(), second];
        let tables = if T::SMEARS { &[reaches.wgpu(), carried, picked][..] } else { &normals };
        let events = DeviceEvents::new(device, edit, memory, tables)?;
        Ok(Self { events, intersect, keep, reaches, known, seen: None, sets, smear, maps })
    }

    /// Takes on by how much normals differ from the smooth ones, for modes that need them.
    pub fn take_turns(&mut self, device: &Device, turns: &DeviceTriangles<Offset>) -> Result<()> {
        self.events.set_tables(device, &turns.buffers())
    }

    /// Makes the first of `edits`, or the first few at once where they may be made `together`, all with the same image of
    /// the brush. Returns what came back and the words of a block; `None` if the device cannot hold that, or blocks for
    /// all triangles that they reach.
    pub fn event<T: DeviceTexel>(
        &mut self,
        stage: TriangleStage<'_, T>,
        (edits, stamp): (&[(BrushParameters, Edit)], Option<&Stamp>),
        together: bool,
    ) -> Result<Option<(Returned, u32)>> {
        let pattern = stage.values.pattern();
        if !self.events.take_stamp(stage.device, stamp)? {
            return Ok(None);
        }
        self.update(stage.device, stage.ground.2)?;
        let memory = self.events.memory();
        if stage.looks_beside && !memory.keeps() {
            self.make_room(stage.device, (memory.room(), memory.capacity()), true)?;
        }
        let tried = &edits[..self.events.tried(edits.len(), together)];
        let Some(made) = self.run(stage, tried)? else { return Ok(None) };
        let states: Vec<BlockState> = made.0.taken().into_iter().map(|(_, state)| state).collect();
        let smudges = stage.smudges;
        // Vectors beside a new block are rounded in other frames.
        let looks = stage.looks_beside || !smudges.is_empty() || T::BENDS;
        let apart = apart((stage.field, stage.left, looks), pattern, &states, tried.len());
        self.events.learn(tried.len(), apart);
        let made = if apart == tried.len() { Some(made) } else { self.run(stage, &tried[..apart])? };
        if made.is_some() {
            self.smear.give(stage.device, &smudges[..smudges.len().min(apart)])?;
        }
        Ok(made)
    }

    /// Takes on how far triangles are displaced by `ground`.
    fn update(&mut self, device: &Device, ground: TriangleGround<'_>) -> Result<()> {
        let TriangleGround { heights, vectors } = ground;
        let topology = heights.topology();
        if topology.face_count() != self.known.len() {
            return Err(Error::internal("another displacement than that of the triangles"));
        }
        let before = self.seen.replace((heights.clone(), vectors.cloned()));
        let Some((before, bent_before)) = before.filter(|(_, before)| before.is_some() == vectors.is_some()) else {
            self.known = (0..self.known.len() as u32).map(|face| ground.reach(face)).collect();
            return self.reaches.write(device, 0, &self.known);
        };
        let mut faces = heights.changes(&before).faces_shown(topology);
        if let Some((vectors, before)) = vectors.zip(bent_before.as_ref()) {
            faces.extend(vectors.changes(before).faces_shown(topology));
        }
        faces.into_iter().try_for_each(|face| {
            let new = ground.reach(face);
            if std::mem::replace(&mut self.known[face as usize], new) == new {
                return Ok(());
            }
            self.reaches.write(device, face as usize, &[new])
        })
    }

    fn make_room(&mut self, device: &Device, size: (u32, u32), keeps: bool) -> Result<()> {
        self.events.make_room(device, size, keeps)?;
        self.sets = bind(device, &self.intersect, &self.reaches, self.events.memory())?;
        Ok(())
    }

    /// Makes `edits` in one submission, and again with more room if they needed it.
    fn run<T: DeviceTexel>(
        &mut self,
        stage: TriangleStage<'_, T>,
        edits: &[(BrushParameters, Edit)],
    ) -> Result<Option<(Returned, u32)>> {
        let TriangleStage { device, mesh, ground, values, looks_beside, smudges, maps, .. } = stage;
        for (dab, maps) in maps.iter().take(edits.len()).enumerate() {
            self.maps.write(device, 3 * dab, &maps.packed())?;
        }
        let bent = ground.1.map_or(ground.0.buffers(), DeviceTriangles::buffers);
        let places = device.bind_as(&GROUND_GROUP, &[ground.0.buffers(), bent].concat())?;
        loop {
            // Dabs that were made in vain have left their own.
            self.smear.take(device, smudges)?;
            let groups = [mesh.group(), &places, values.group()];
            let (kernel, sets, count) = (&self.intersect, &self.sets, self.known.len() as u32);
            let intersect = |pass: &mut Pass<'_>, brush: &BrushParameters| {
                let (work, size) = (intersect::work(brush, count), groups_of(count));
                pass.run(kernel, &[sets, mesh.group()], bytemuck::bytes_of(&work), size)
            };
            let (room, keeps) = (self.events.memory().room(), self.events.memory().keeps());
            let (smear, keep) = (&self.smear, &self.keep);
            let ready = |frame: &mut Frame, events: &DeviceEvents, dab| {
                if !smudges.is_empty() {
                    smear.begin(frame, smudges, dab)?;
                }
                if !looks_beside {
                    return Ok(());
                }
                let work = Edit { room, ..Edit::default() };
                let groups = [events.editing(), groups[0], groups[1], groups[2]];
                let mut pass = frame.pass("dab.keep");
                let header = &events.memory().header;
                pass.run_indirect(keep, &groups, bytemuck::bytes_of(&work), header, DeviceMemory::EDIT)
            };
            match self.events.run(device, (edits, T::FLAGS), groups, intersect, ready)? {
                Ended::Made(made) => return Ok(Some((made, room))),
                Ended::Short(needed) => self.make_room(device, (room, needed), keeps)?,
                Ended::Never => return Ok(None),
            }
        }
    }
}

fn groups_of(count: u32) -> [u32; 3] {
    groups(count.div_ceil(GROUP))
}

fn bind(device: &Device, kernel: &Kernel, reaches: &Buffer<f32>, memory: &DeviceMemory) -> Result<Bindings> {
    device.bind(kernel, 0, &[reaches.wgpu(), memory.pointers.wgpu(), memory.states.wgpu(), memory.masks.wgpu()])
}

/// How many of the `count` dabs of an event, at least one, do together what they do one after the other. A triangle gets its
/// block with the first change of what it reads; but that block divides the sides of its neighbours, so that the dab comes
/// before any that looks further than at what it changes; and the budget may refuse blocks.
fn apart<T: DeviceTexel>(
    (field, left, looks): (&TriangleField<T>, u64, bool),
    pattern: Pattern,
    states: &[BlockState],
    count: usize,
) -> usize {
    let values = pattern.face_values() + 3 * pattern.edge_values();
    let changed = states.iter().filter(|state| state.changes > 0);
    let wanted = changed.clone().count() as u64 * (values * size_of::<T>()) as u64;
    if wanted > left {
        return 1;
    }
    let without = changed.filter(|state| looks && field.face_pattern(state.tile) != Some(pattern));
    without.map(|state| state.dabs.trailing_zeros() as usize + 1).fold(count, usize::min)
}
