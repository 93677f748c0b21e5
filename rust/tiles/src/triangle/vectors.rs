//! Vector displacement of a triangle mesh, which comes after the scalar one.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6. A vector
//! has the components (along T, along N × T, along N), where N is the interpolated unit normal and T the direction, at
//! right angles to N, of what the value belongs to: of a face its first side, of an edge the edge, of a vertex the side of
//! its first face that starts there. So vectors turn with the mesh when it is posed, and each is in one frame, whichever
//! faces have it. To be read between values they are brought to object space. Units: object units.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Mat3, Vec3};
use relievo_core::{Context, Result};
use relievo_surface::{TriangleSurface, TriangleTopology};

use super::channel::{TriangleChannel, TriangleOptions};
use super::displaced::{edge_foot, foot};
use super::field::TriangleField;
use super::pattern::Slot;
use crate::pages::Entry;
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
    /// A vector displacement of zero everywhere. Fails as [`TriangleChannel::blank`] does.
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

impl TriangleField<Vector> {
    /// The vectors in object space, where the mesh is `surface`.
    pub fn in_object_space(&self, context: &Context, surface: &TriangleSurface) -> TriangleField<Offset> {
        let topology = self.topology();
        let mut out = TriangleField::new(topology.clone(), self.pattern(), Offset::default());
        let points = surface.points();
        let way = |[a, b]: [u32; 2]| Vec3::from(points[b as usize]) - Vec3::from(points[a as usize]);
        let turned = |frame: Mat3, vector: Vector| Offset((frame * vector.value().as_vec3()).to_array());
        for (vertex, value) in (0..).zip(self.vertices().flatten()) {
            if value.is_blank(Vector::ZERO) {
                continue;
            }
            let Some((face, corner)) = topology.faces_around(vertex).next() else { continue };
            let next = topology.face(face)[(corner as usize + 1) % 3];
            let normal = Vec3::from(surface.normals()[vertex as usize]);
            out.set_vertex(vertex, turned(frame(normal, way([vertex, next])), *value));
        }
        let edges: Vec<u32> = self.allocated_edges().collect();
        let blocks = context.map(edges.len(), |index| {
            let edge = edges[index];
            let block = self.edge(edge).unwrap_or(&[]);
            let (along, segments) = (way(topology.edge(edge)), block.len() as u32 + 1);
            let values = (1..)
                .zip(block)
                .map(|(step, value)| turned(frame(edge_foot(surface, edge, step, segments).normal, along), *value));
            values.collect::<Arc<[Offset]>>()
        });
        for (edge, texels) in edges.into_iter().zip(blocks) {
            if let Some(Entry { id, version, .. }) = self.edges.entry(edge) {
                *out.edges.entry_mut(edge) = Some(Entry { texels, id: *id, version: *version });
            }
        }
        let faces: Vec<u32> = self.allocated().collect();
        let blocks = context.map(faces.len(), |index| {
            let face = faces[index];
            let [a, b, _] = topology.face(face);
            let (along, pattern) = (way([a, b]), self.face_pattern(face).unwrap_or(self.pattern()));
            let values = (0..).zip(self.face(face).unwrap_or(&[])).map(|(index, value)| {
                let foot = foot(surface, face, pattern, pattern.at_slot(Slot::Inside(index)));
                turned(frame(foot.normal, along), *value)
            });
            values.collect::<Arc<[Offset]>>()
        });
        for (face, texels) in faces.into_iter().zip(blocks) {
            if let Some(Entry { id, version, .. }) = self.faces.entry(face) {
                *out.faces.entry_mut(face) = Some(Entry { texels, id: *id, version: *version });
            }
        }
        out
    }
}
