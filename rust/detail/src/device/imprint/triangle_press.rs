//! What imprints on a triangle mesh need of a device beside the mesh: its values, which of its triangles have blocks, and the
//! kernels in its pattern.

use std::sync::Arc;

use half::f16;
use relievo_core::Result;
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, wgpu};
use relievo_surface::MESH_GROUP;
use relievo_tiles::triangle::{DeviceTriangles, Offset, Pattern, TRIANGLES_GROUP, TriangleField};

use super::triangle_rim::RimMesh;
use super::triangle_smoothing::SmoothedMesh;
use crate::channels::knots::BLOCK_KNOTS;
use crate::triangle::{TriangleObject, field_length, field_range};

/// What imprints on a triangle mesh need of a device, beside the mesh.
#[derive(Debug)]
pub(crate) struct TrianglePress {
    pub(crate) values: DeviceTriangles,
    /// The displacement from when the depth limit began to count, once there was one.
    pub(crate) begun: Option<DeviceTriangles>,
    /// The vectors in object space, if there are some.
    vectors: Option<DeviceTriangles<Offset>>,
    ranges: Buffer<[f32; 2]>,
    /// How long vectors of triangles are.
    lengths: Buffer<f32>,
    pub(super) listed: Buffer<u32>,
    /// Barycentric coordinates of the values inside a triangle.
    pub(super) inside: Buffer<[f32; 3]>,
    /// Of every triangle whether it has a block, see `triangle_imprint_slot.wgsl`.
    pub(crate) held: Buffer<u32>,
    pub(crate) culling: Arc<Kernel>,
    pub(super) casting: Arc<Kernel>,
    pub(crate) culled: Bindings,
    /// What smoothing and rims need, once something was smoothed or rose.
    pub(super) smoothed: Option<SmoothedMesh>,
    pub(super) raised: Option<RimMesh>,
}

/// What the kernels have of a submission: imprints, slots, boxes, arguments and counters.
pub(super) const CULLING: [Access; 5] = [Access::Read, Access::Write, Access::Read, Access::Write, Access::Write];
/// Imprints, triangles, arguments, voxels, slots, counters, records, places inside triangles, and vectors.
pub(super) const CASTING: [Access; 11] = [
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
    Access::Read,
];
/// Ranges, the list, and the lengths of vectors.
const CULLED: [Access; 3] = [Access::Read, Access::Write, Access::Read];

/// Words of the values of a record.
const PAIRS: u32 = BLOCK_KNOTS as u32 / 2;

impl TrianglePress {
    /// For imprints on `object`. Fails where the device has no room.
    fn new(device: &Device, object: &TriangleObject) -> Result<Self> {
        let (field, vectors) = (object.displacement().field(), object.ground().vectors);
        let (pattern, faces) = (field.pattern(), field.topology().face_count());
        let immediates = size_of::<Step>() as u32;
        let constants = constants(pattern, vectors.is_some());
        let culling = device.kernel(&KernelSpec {
            module: "triangle_imprint_cull",
            entry: "cull_faces",
            groups: &[&CULLING, &MESH_GROUP, &CULLED],
            immediates,
            constants: &constants[..2],
        })?;
        let casting = device.kernel(&KernelSpec {
            module: "triangle_imprint",
            entry: "cast_values",
            groups: &[&CASTING, &MESH_GROUP, &TRIANGLES_GROUP, &TRIANGLES_GROUP],
            immediates,
            constants: &constants,
        })?;
        let all: Vec<_> = (0..faces as u32).map(|face| field_range(field, face)).collect();
        let ranges = Buffer::of(device, "ranges of triangles", &all)?;
        let length = |face| vectors.map_or(0.0, |vectors| field_length(vectors, face));
        let all: Vec<f32> = (0..faces as u32).map(length).collect();
        let lengths = Buffer::of(device, "lengths of vectors", &all)?;
        let listed = Buffer::new(device, "triangles in the overlap", faces)?;
        let culled = device.bind_as(&CULLED, &[ranges.wgpu(), listed.wgpu(), lengths.wgpu()])?;
        let inside = Buffer::of(device, "places inside triangles", pattern.places())?;
        let holds: Vec<_> = (0..faces as u32).map(|face| held_by(field, face)).collect();
        let held = Buffer::of(device, "triangles with blocks", &holds)?;
        let values = DeviceTriangles::new(device, field, pattern)?;
        let vectors = vectors.map(|vectors| DeviceTriangles::new(device, vectors, pattern)).transpose()?;
        Ok(Self {
            values,
            begun: None,
            vectors,
            ranges,
            lengths,
            listed,
            inside,
            held,
            culling,
            casting,
            culled,
            smoothed: None,
            raised: None,
        })
    }

    /// Makes `there` have the displacement of `object`, and `start`, from which the depth limit counts. Fails where the
    /// device has no room.
    pub(crate) fn follow<'a>(
        there: &'a mut Option<Self>,
        device: &Device,
        object: &TriangleObject,
        start: Option<&TriangleField>,
    ) -> Result<&'a mut Self> {
        let (field, vectors) = (object.displacement().field(), object.ground().vectors);
        let fits = |it: &Self| it.values.pattern() == field.pattern() && it.vectors.is_some() == vectors.is_some();
        let press = match there.take().filter(fits) {
            Some(mut press) => {
                for face in press.values.update(device, field)? {
                    press.ranges.write(device, face as usize, &[field_range(field, face)])?;
                    press.held.write(device, face as usize, &[held_by(field, face)])?;
                }
                if let Some((known, vectors)) = press.vectors.as_mut().zip(vectors) {
                    for face in known.update(device, vectors)? {
                        press.lengths.write(device, face as usize, &[field_length(vectors, face)])?;
                    }
                }
                there.insert(press)
            }
            None => there.insert(Self::new(device, object)?),
        };
        if let Some(start) = start {
            match &mut press.begun {
                Some(begun) => drop(begun.update(device, start)?),
                None => press.begun = Some(DeviceTriangles::new(device, start, field.pattern())?),
            }
        }
        Ok(press)
    }

    /// Makes ready for what is smoothed, and for what rises, where something does. Fails where the device has no room.
    pub(super) fn prepare(&mut self, device: &Device, smooths: bool, rises: bool) -> Result<()> {
        let pattern = self.values.pattern();
        let constants = constants(pattern, self.vectors.is_some());
        if smooths && self.smoothed.is_none() {
            let mesh = SmoothedMesh::new(device, self.held.len(), &constants[..2], parts(pattern))?;
            self.smoothed = Some(mesh);
        }
        if rises && self.raised.is_none() {
            self.raised = Some(RimMesh::new(device, constants)?);
        }
        Ok(())
    }

    /// The buffers of the vectors, or others without vectors.
    pub(super) fn ways(&self) -> [&wgpu::Buffer; 2] {
        self.vectors.as_ref().map_or(self.values.buffers(), DeviceTriangles::buffers)
    }
}

/// The constants of kernels for a mesh.
fn constants(pattern: Pattern, bent: bool) -> [(&'static str, f64); 3] {
    let vectors = f64::from(u8::from(bent));
    [("SEGMENTS", f64::from(pattern.segments())), ("PARTS", f64::from(parts(pattern))), ("VECTORS", vectors)]
}

/// Whether a triangle has a block, as kernels read it.
fn held_by(field: &TriangleField, face: u32) -> u32 {
    match field.face_pattern(face) {
        None => 0,
        Some(own) if own == field.pattern() => 1,
        Some(_) => 2,
    }
}

/// Records that the values of a triangle's block make at most.
pub(crate) fn parts(pattern: Pattern) -> u32 {
    DeviceTriangles::<f16>::words(pattern).div_ceil(PAIRS)
}
