//! Faces that may be lost: where the budget of a channel is full, those of layers that fade make room for others, the
//! one whose newest edit is oldest first.
//!
//! A face goes with the edges that no other face uses; its other edges and its corners become blank, because what is not
//! would drag along a face that has no block. What was edited since it was named is not lost. Units: bytes.

use std::sync::Arc;

use relievo_core::Result;

use super::block::TriangleBlock;
use super::channel::TriangleChannel;
use super::field::TriangleField;
use crate::store::heap::Class;
use crate::store::slot::Slot;
use crate::texel::Texel;

/// A face that may be lost, as it was when that was said.
#[derive(Clone, Debug)]
pub(crate) struct Expendable<T> {
    pub face: u32,
    /// The number of the channel's last edit then.
    revision: u64,
    corners: [T; 3],
}

impl<T: Texel> Expendable<T> {
    /// Whether the face, its edges and its corners in `field` are what they were.
    pub fn is_untouched(&self, field: &TriangleField<T>) -> bool {
        let edges = field.topology().edges_of(self.face).map(TriangleBlock::Edge);
        let mut blocks = edges.into_iter().chain([TriangleBlock::Face(self.face)]);
        blocks.all(|block| field.block(block).is_none_or(|entry| entry.version <= self.revision))
            && corners(field, self.face).into_iter().zip(self.corners).all(|(now, then)| now.same(then))
    }
}

fn corners<T: Texel>(field: &TriangleField<T>, face: u32) -> [T; 3] {
    field.topology().face(face).map(|vertex| field.vertex(vertex))
}

impl<T: Texel> TriangleChannel<T> {
    /// Names faces that may be lost where the budget refuses others, the first of them first, unless they are edited
    /// meanwhile: those of layers that fade, by age.
    pub fn set_expendable(&mut self, faces: &[u32]) {
        let (field, revision) = (&self.field, self.blocks.revision);
        let list = faces.iter().rev().filter(|face| field.is_allocated(**face));
        self.expendable =
            list.map(|face| Expendable { face: *face, revision, corners: corners(field, *face) }).collect();
    }

    /// The faces that were lost since this was called last, ascending.
    pub fn take_lost(&mut self) -> Vec<u32> {
        self.blocks.take_lost()
    }

    /// The faces that [`Self::take_lost`] has not told yet.
    pub fn lost(&self) -> &[u32] {
        &self.blocks.lost
    }

    /// Makes `faces`, their edges and their corners blank and gives their blocks back, with the edges that no other face
    /// uses.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a face does not exist.
    #[inline(never)]
    pub fn lose_faces(&mut self, faces: &[u32]) -> Result<()> {
        self.check_faces(faces)?;
        self.blocks.revision += 1;
        self.lose(faces);
        Ok(())
    }

    /// As [`Self::lose_faces`], but only faces that [`Self::set_expendable`] named and that were not edited since.
    ///
    /// # Errors
    /// None at present: faces that were named exist, and others are passed over.
    #[inline(never)]
    pub fn lose_expendable(&mut self, faces: &[u32]) -> Result<()> {
        let named =
            |face: &u32| self.expendable.iter().any(|named| named.face == *face && named.is_untouched(&self.field));
        let gone: Vec<u32> = faces.iter().copied().filter(named).collect();
        if gone.is_empty() { Ok(()) } else { self.lose_faces(&gone) }
    }

    pub(super) fn lose(&mut self, faces: &[u32]) {
        let there: Vec<u32> = faces.iter().copied().filter(|face| self.field.is_allocated(*face)).collect();
        self.deallocate(&there);
        let topology = self.field.topology().clone();
        for edge in there.iter().flat_map(|face| topology.edges_of(*face)) {
            if let Some(values) = self.field.blank_edge(edge) {
                self.replace(TriangleBlock::Edge(edge), values);
            }
        }
        for vertex in there.iter().flat_map(|face| topology.face(*face)) {
            if self.field.blank_vertex(vertex) {
                self.changed.vertices.push(vertex);
            }
        }
        self.blocks.lost.extend(there);
    }
}

impl<T: Texel> TriangleField<T> {
    /// Takes `faces` away as [`TriangleChannel::lose_faces`] does.
    pub fn forget(&mut self, faces: &[u32]) {
        let topology = self.topology().clone();
        for face in faces {
            if !self.is_allocated(*face) {
                continue;
            }
            *self.faces.entry_mut(*face) = None;
            for edge in topology.edges_of(*face) {
                if !topology.faces_along(edge).any(|(face, _)| self.is_allocated(face)) {
                    *self.edges.entry_mut(edge) = None;
                } else if let Some(values) = self.blank_edge(edge)
                    && let Some(entry) = self.edges.entry_mut(edge)
                {
                    entry.texels = Slot::Here(values);
                }
            }
            for vertex in topology.face(*face) {
                self.blank_vertex(vertex);
            }
        }
    }

    /// Whether a face, one of its edges or of its corners was edited since it was `before`.
    pub fn is_edited(&self, before: &Self, face: u32) -> bool {
        let edges = self.topology().edges_of(face).map(TriangleBlock::Edge);
        let version = |field: &Self, block| field.block(block).map(|entry| entry.version);
        let mut blocks = edges.into_iter().chain([TriangleBlock::Face(face)]);
        blocks.any(|block| version(self, block) != version(before, block))
            || corners(self, face).into_iter().zip(corners(before, face)).any(|(now, then)| !now.same(then))
    }

    /// Returns the values of an edge that is blank, if it has a block that is not.
    fn blank_edge(&self, edge: u32) -> Option<Arc<[T]>> {
        let entry = self.block(TriangleBlock::Edge(edge))?;
        let is_blank = entry.texels.iter().all(|value| value.same(self.blank()));
        (!is_blank).then(|| vec![self.blank(); entry.id.class.values()].into())
    }

    /// Makes a vertex blank. Returns whether it was something else.
    fn blank_vertex(&mut self, vertex: u32) -> bool {
        let differs = !self.vertex(vertex).same(self.blank());
        if differs {
            self.set_vertex(vertex, self.blank());
        }
        differs
    }
}

#[cfg(test)]
mod tests {
    use crate::triangle::shapes::{channel, sets};
    use crate::triangle::{TriangleChange, TriangleValues};
    use half::f16;
    use relievo_core::Context;

    #[test]
    fn a_face_that_is_lost_leaves_nothing_on_edges_that_others_use() {
        let context = Context::serial();
        let mut channel = channel(16, 1 << 20);
        let topology = channel.field().topology().clone();
        let pattern = channel.field().pattern();
        let shared = topology.edges_of(0).into_iter().find(|edge| topology.edges_of(1).contains(edge)).unwrap();
        channel.apply(&context, pattern, &sets(&[0, 1])).unwrap();
        let block = |value: f32, count: usize| vec![f16::from_f32(value); count];
        let inside = |face: u32| (face, block(1.0 + face as f32, pattern.face_values()));
        channel.write(TriangleValues { faces: vec![inside(0), inside(1)], ..Default::default() }).unwrap();
        let edges = vec![(shared, block(0.5, pattern.edge_values()))];
        channel.write(TriangleValues { edges, ..Default::default() }).unwrap();
        let mut forgotten = channel.field().clone();
        channel.commit();
        channel.lose_faces(&[0]).unwrap();
        let field = channel.field();
        assert!(!field.is_allocated(0) && field.edge(shared).unwrap().iter().all(|value| *value == f16::ZERO));
        assert_eq!(field.face(1).unwrap(), inside(1).1);
        forgotten.forget(&[0]);
        assert_eq!(field.changes(&forgotten), TriangleChange::default());
        assert!(channel.commit().changed().edges.contains(&shared));
    }
}
