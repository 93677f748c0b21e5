//! What an edit of a channel over triangles is made of: the faces that need a block, new values, and what changed; and
//! the values as readers hold them. Units: those of the values; bytes.

use std::ops::Deref;

use half::f16;
use relievo_surface::TriangleTopology;

use super::field::TriangleField;

/// Elements of a triangle mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TriangleChange {
    /// Faces of which values changed.
    pub faces: Vec<u32>,
    /// Edges of which values changed.
    pub edges: Vec<u32>,
    /// Vertices whose value changed.
    pub vertices: Vec<u32>,
}

impl TriangleChange {
    pub(super) fn sort(&mut self) {
        for list in [&mut self.faces, &mut self.edges, &mut self.vertices] {
            list.sort_unstable();
            list.dedup();
        }
    }

    /// The faces that look different: those of which values changed, and those along an edge or at a vertex that did,
    /// ascending.
    pub fn faces_shown(&self, topology: &TriangleTopology) -> Vec<u32> {
        let along = self.edges.iter().flat_map(|edge| topology.faces_along(*edge));
        let around = self.vertices.iter().flat_map(|vertex| topology.faces_around(*vertex));
        let mut faces: Vec<u32> = self.faces.iter().copied().chain(along.chain(around).map(|(face, _)| face)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }
}

/// What [`TriangleChannel::apply`] is to do.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TriangleSets {
    /// Faces that need a block, with their edges.
    pub allocate: Vec<u32>,
    /// Faces with a block that is going to be written, so that it makes no room for others.
    pub modify: Vec<u32>,
    /// Faces whose block, and that of edges no other face uses, goes back to the heap.
    pub deallocate: Vec<u32>,
}

/// New values of elements. Edges and faces have all values of their block.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleValues<T> {
    /// By face, ascending.
    pub faces: Vec<(u32, Vec<T>)>,
    /// By edge, ascending.
    pub edges: Vec<(u32, Vec<T>)>,
    /// By vertex, ascending.
    pub vertices: Vec<(u32, T)>,
}

impl<T> Default for TriangleValues<T> {
    fn default() -> Self {
        Self { faces: Vec::new(), edges: Vec::new(), vertices: Vec::new() }
    }
}

/// Values as they were at a commit, for any number of readers.
#[derive(Clone, Debug)]
pub struct TriangleSnapshot<T = f16> {
    pub(super) field: TriangleField<T>,
    pub(super) changed: TriangleChange,
    pub(super) revision: u64,
    pub(super) bytes: u64,
}

impl<T> TriangleSnapshot<T> {
    /// The values.
    pub fn field(&self) -> &TriangleField<T> {
        &self.field
    }

    /// What was written, allocated or deallocated since the commit before.
    pub fn changed(&self) -> &TriangleChange {
        &self.changed
    }

    /// The number of the last edit that is in it.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Bytes of vertices and blocks.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl<T> Deref for TriangleSnapshot<T> {
    type Target = TriangleField<T>;

    fn deref(&self) -> &TriangleField<T> {
        &self.field
    }
}
