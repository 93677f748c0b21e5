//! Vector displacement of a triangle mesh, which comes after the scalar one.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6. A
//! vector has the components (along T, along N × T, along N), where N is the interpolated unit normal and T the
//! direction, at right angles to N, of what the value belongs to: of a face its first side, of an edge the edge, of a
//! vertex the side of its first face that starts there. So vectors turn with the mesh when it is posed, and each is in
//! one frame, whichever faces have it. To be read between values they are brought to object space. Units: object units.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Mat3, Vec3};
use relievo_core::{Context, Result};
use relievo_surface::{TriangleSurface, TriangleTopology};

use super::channel::{TriangleChannel, TriangleOptions};
use super::displaced::{edge_foot, foot};
use super::field::{Entry, TriangleField};
use super::pattern::Slot;
use crate::store::slot;
use crate::texel::{Texel, Vector};

/// A vector of object space: by how much a point is moved, or a normal differs from that of the undisplaced mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Offset(pub [f32; 3]);

impl Texel for Offset {
    type Value = DVec3;
    type Difference = Self;

    fn value(self) -> DVec3 {
        DVec3::from(self.0.map(f64::from))
    }

    fn nearest(value: DVec3) -> Self {
        Self(value.as_vec3().to_array())
    }

    fn flipped(self) -> Self {
        self
    }

    fn all_finite(texels: &[Self]) -> bool {
        texels.iter().flat_map(|texel| texel.0).all(f32::is_finite)
    }
}

impl TriangleChannel<Vector> {
    /// A vector displacement of zero everywhere.
    ///
    /// # Errors
    /// Fails as [`TriangleChannel::blank`] does.
    pub fn vectors(topology: Arc<TriangleTopology>, options: &TriangleOptions) -> Result<Self> {
        Self::blank(topology, Vector::ZERO, options)
    }
}

/// The frame at a place with a normal, for what runs `along`: its columns are T, N × T and N.
fn frame(normal: Vec3, along: Vec3) -> Mat3 {
    let across = normal.cross(along).try_normalize();
    let across = across.or_else(|| normal.try_normalize().map(Vec3::any_orthonormal_vector)).unwrap_or(Vec3::ZERO);
    Mat3::from_cols(across.cross(normal), across, normal)
}

fn way(surface: &TriangleSurface, [a, b]: [u32; 2]) -> Vec3 {
    let points = surface.points();
    Vec3::from(points[b as usize]) - Vec3::from(points[a as usize])
}

/// The frame of a value in `face` where the unit normal is `normal`: its columns are T, N × T and N. Panics if there is
/// no such face.
pub fn face_frame(surface: &TriangleSurface, face: u32, normal: Vec3) -> Mat3 {
    let [a, b, _] = surface.topology().face(face);
    frame(normal, way(surface, [a, b]))
}

/// The frame of a value on `edge`, as of [`face_frame`]. Panics if there is no such edge.
pub fn edge_frame(surface: &TriangleSurface, edge: u32, normal: Vec3) -> Mat3 {
    frame(normal, way(surface, surface.topology().edge(edge)))
}

/// The frame of the value at `vertex`, as of [`face_frame`]; that of no direction if it has no face. Panics if there is
/// no such vertex.
pub fn vertex_frame(surface: &TriangleSurface, vertex: u32) -> Mat3 {
    let topology = surface.topology();
    let Some((face, corner)) = topology.faces_around(vertex).next() else { return Mat3::ZERO };
    let next = topology.face(face)[(corner as usize + 1) % 3];
    frame(Vec3::from(surface.normals()[vertex as usize]), way(surface, [vertex, next]))
}

impl TriangleField<Vector> {
    /// The vectors in object space, where the mesh is `surface`.
    pub fn in_object_space(&self, context: &Context, surface: &TriangleSurface) -> TriangleField<Offset> {
        let mut out = TriangleField::new(self.topology().clone(), self.pattern(), Offset::default());
        for (vertex, value) in (0..).zip(self.vertices().flatten()) {
            if !value.is_blank(Vector::ZERO) {
                out.set_vertex(vertex, turned(vertex_frame(surface, vertex), *value));
            }
        }
        self.turn_blocks(context, surface, self.allocated().collect(), self.allocated_edges().collect(), &mut out);
        out
    }

    /// Brings what [`Self::in_object_space`] gave of this field up to date where only `faces`, their edges and their
    /// corners changed. Panics if a face does not exist.
    pub fn renew_in_object_space(
        &self,
        context: &Context,
        surface: &TriangleSurface,
        faces: &[u32],
        out: &mut TriangleField<Offset>,
    ) {
        let topology = self.topology();
        let sorted = |mut list: Vec<u32>| {
            list.sort_unstable();
            list.dedup();
            list
        };
        for vertex in sorted(faces.iter().flat_map(|face| topology.face(*face)).collect()) {
            let value = self.vertex(vertex);
            let blank = value.is_blank(Vector::ZERO);
            out.set_vertex(
                vertex,
                if blank { Offset::default() } else { turned(vertex_frame(surface, vertex), value) },
            );
        }
        let edges = sorted(faces.iter().flat_map(|face| topology.edges_of(*face)).collect());
        self.turn_blocks(context, surface, sorted(faces.to_vec()), edges, out);
    }

    fn turn_blocks(
        &self,
        context: &Context,
        surface: &TriangleSurface,
        faces: Vec<u32>,
        edges: Vec<u32>,
        out: &mut TriangleField<Offset>,
    ) {
        let blocks = context.map(edges.len(), |index| {
            let edge = edges[index];
            let block = self.edge(edge)?;
            let segments = block.len() as u32 + 1;
            let foot = |step: u32| edge_foot(surface, edge, step, segments);
            let values =
                (1..).zip(block).map(|(step, value)| turned(edge_frame(surface, edge, foot(step).normal), *value));
            Some(values.collect::<Arc<[Offset]>>())
        });
        for (edge, texels) in edges.into_iter().zip(blocks) {
            let entry = self.edges.entry(edge).zip(texels);
            let entry = entry.map(|(Entry { id, version, .. }, texels)| {
                let texels = slot::Slot::Here(texels);
                Entry { texels, id: *id, version: *version }
            });
            if entry.is_some() || out.edges.entry(edge).is_some() {
                *out.edges.entry_mut(edge) = entry;
            }
        }
        let blocks = context.map(faces.len(), |index| {
            let face = faces[index];
            let (block, pattern) = (self.face(face)?, self.face_pattern(face).unwrap_or(self.pattern()));
            let values = (0..).zip(block).map(|(index, value)| {
                let foot = foot(surface, face, pattern, pattern.at_slot(Slot::Inside(index)));
                turned(face_frame(surface, face, foot.normal), *value)
            });
            Some(values.collect::<Arc<[Offset]>>())
        });
        for (face, texels) in faces.into_iter().zip(blocks) {
            let entry = self.faces.entry(face).zip(texels);
            let entry = entry.map(|(Entry { id, version, .. }, texels)| {
                let texels = slot::Slot::Here(texels);
                Entry { texels, id: *id, version: *version }
            });
            if entry.is_some() || out.faces.entry(face).is_some() {
                *out.faces.entry_mut(face) = entry;
            }
        }
    }
}

fn turned(frame: Mat3, vector: Vector) -> Offset {
    Offset((frame * vector.value().as_vec3()).to_array())
}
