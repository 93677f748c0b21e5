//! A channel over a triangle mesh, with blocks on edges and faces where something happened: displacement or colour.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 6 and
//! 7.1. A face and its edges get their blocks together or not at all; an edge gives its block back when no face with a
//! block uses it. Vertices always have their value. The bytes in use are therefore
//!
//! (bytes of a value) · (vertices + Σ edges (T − 1) + Σ faces ⌊(3T/2)(T/2 − 1) + 1⌋),
//!
//! where T is that of each block. A face has the finest of the patterns it was asked for; what it held before is
//! interpolated. An edit goes: [`TriangleChannel::apply`], [`TriangleChannel::write`], [`TriangleChannel::commit`].
//! Where the byte budget refuses a face it stays as it was and is reported. Units: those of the values; bytes.

use std::sync::Arc;

use glam::Vec4;
use half::f16;
use relievo_core::{Error, Result};
use relievo_surface::TriangleTopology;

use super::block::TriangleBlock;
use super::change::{TriangleChange, TriangleSnapshot, TriangleValues};
use super::expendable::Expendable;
use super::field::{Entry, TriangleClass, TriangleField};
use super::pattern::Pattern;
use crate::store::heap::{Class, Heap};
use crate::store::pages::CowBlocks;
use crate::store::paging::{BlockStore, Paged};
use crate::texel::{ColorTexel, Texel};

/// How a channel over triangles is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleOptions {
    /// Segments along an edge at the finest: 8, 16, 32 or 64.
    pub segments: u32,
    /// Bytes that vertices and blocks may occupy.
    pub budget: u64,
}

impl Default for TriangleOptions {
    fn default() -> Self {
        Self { segments: 16, budget: 1 << 30 }
    }
}

/// Values on a triangle mesh that may be edited. See the [module](self).
#[derive(Debug)]
pub struct TriangleChannel<T = f16> {
    pub(super) field: TriangleField<T>,
    pub(super) blocks: BlockStore<TriangleClass>,
    /// Faces, edges and vertices changed since the last commit, with repetition.
    pub(super) changed: TriangleChange,
    /// Faces that may be lost where the budget refuses others, the last first.
    pub(super) expendable: Vec<Expendable<T>>,
}

impl<T: Texel> Clone for TriangleChannel<T> {
    #[inline(never)]
    fn clone(&self) -> Self {
        let mut copy = Self {
            field: self.field.clone(),
            blocks: self.blocks.clone(),
            changed: self.changed.clone(),
            expendable: self.expendable.clone(),
        };
        copy.fork();
        copy
    }
}

impl TriangleChannel {
    /// A displacement of zero everywhere.
    ///
    /// # Errors
    /// Fails as [`TriangleChannel::blank`] does.
    pub fn displacement(topology: Arc<TriangleTopology>, options: &TriangleOptions) -> Result<Self> {
        Self::blank(topology, f16::ZERO, options)
    }
}

impl<T: ColorTexel> TriangleChannel<T> {
    /// A mesh that has the colour `blank` all over, rounded as values are.
    ///
    /// # Errors
    /// Fails as [`TriangleChannel::blank`] does.
    pub fn of_color(topology: Arc<TriangleTopology>, blank: Vec4, options: &TriangleOptions) -> Result<Self> {
        Self::blank(topology, T::of_color(blank), options)
    }
}

impl<T: Texel> TriangleChannel<T> {
    /// A channel that reads as `blank` everywhere.
    ///
    /// # Errors
    /// Fails unless there are 8, 16, 32 or 64 segments, or if the budget does not hold the vertices.
    #[inline(never)]
    pub fn blank(topology: Arc<TriangleTopology>, blank: T, options: &TriangleOptions) -> Result<Self> {
        let pattern = Pattern::new(options.segments)?;
        if !Pattern::SIZES.contains(&options.segments) {
            return Err(Error::invalid(format!("a triangle cannot keep {} segments a side", options.segments))
                .advise("use 8, 16, 32 or 64"));
        }
        let vertices = (topology.vertex_count() * size_of::<T>()) as u64;
        let Some(budget) = options.budget.checked_sub(vertices) else {
            return Err(Error::memory("the budget does not even hold the vertices")
                .advise(format!("allow at least {vertices} bytes")));
        };
        Ok(Self {
            field: TriangleField::new(topology, pattern, blank),
            blocks: BlockStore::new(Heap::new(size_of::<T>(), budget)),
            changed: TriangleChange::default(),
            expendable: Vec::new(),
        })
    }

    /// The values as they are now.
    pub fn field(&self) -> &TriangleField<T> {
        &self.field
    }

    /// Number of faces with a block.
    pub fn allocated_count(&self) -> usize {
        self.field.allocated().count()
    }

    fn vertex_bytes(&self) -> u64 {
        (self.field.topology().vertex_count() * size_of::<T>()) as u64
    }

    /// Bytes of vertices and blocks. Blocks on pages count nothing.
    pub fn bytes(&self) -> u64 {
        self.vertex_bytes() + self.blocks.heap.bytes()
    }

    /// Bytes if every face and edge had a block of the finest pattern.
    pub fn full_bytes(&self) -> u64 {
        let (topology, pattern) = (self.field.topology(), self.field.pattern());
        let values = topology.face_count() * pattern.face_values() + topology.edge_count() * pattern.edge_values();
        self.vertex_bytes() + (values * size_of::<T>()) as u64
    }

    /// Bytes that vertices and blocks may occupy.
    pub fn budget(&self) -> u64 {
        self.vertex_bytes().saturating_add(self.blocks.heap.budget())
    }

    /// Changes the budget. Blocks stay, even beyond it, unless they page: see [`Self::page_to`].
    #[inline(never)]
    pub fn set_budget(&mut self, budget: u64) {
        self.blocks.heap.set_budget(budget.saturating_sub(self.vertex_bytes()));
        self.trim();
    }

    /// Writes new values; elements whose values stay the same are not touched.
    ///
    /// # Errors
    /// Fails, and changes nothing, if an element does not exist or is listed out of order, has no block or one of
    /// another length, a number is not finite, or a page cannot be read.
    #[inline(never)]
    pub fn write(&mut self, values: TriangleValues<T>) -> Result<()> {
        check(&values.faces, &self.field.faces, self.field.topology().face_count(), "face")?;
        check(&values.edges, &self.field.edges, self.field.topology().edge_count(), "edge")?;
        let count = self.field.topology().vertex_count();
        if let Some((vertex, _)) = values.vertices.iter().find(|(vertex, _)| *vertex as usize >= count) {
            return Err(Error::invalid(format!("vertex {vertex} does not exist")));
        }
        if let Some((vertex, _)) = values.vertices.iter().find(|(_, value)| !T::all_finite(std::slice::from_ref(value)))
        {
            return Err(Error::invalid("an edit left a number that is not finite").at(format!("vertex {vertex}")));
        }
        let faces = values.faces.into_iter().map(|(face, values)| (TriangleBlock::Face(face), values));
        let edges = values.edges.into_iter().map(|(edge, values)| (TriangleBlock::Edge(edge), values));
        let blocks: Vec<(TriangleBlock, Vec<T>)> = faces.chain(edges).collect();
        self.check_pages(blocks.iter().map(|(block, _)| *block))?;
        self.blocks.revision += 1;
        let same = |old: &[T], new: &[T]| bytemuck::cast_slice::<T, u8>(old) == bytemuck::cast_slice::<T, u8>(new);
        for (block, new) in blocks {
            if !self.field.block(block).is_some_and(|entry| same(&entry.texels, &new)) {
                self.replace(block, new.into());
            }
        }
        for (vertex, value) in values.vertices {
            if !self.field.vertex(vertex).same(value) {
                self.field.set_vertex(vertex, value);
                self.changed.vertices.push(vertex);
            }
        }
        self.trim();
        Ok(())
    }

    /// Notes that a block changed.
    pub(super) fn mark(&mut self, block: TriangleBlock) {
        match block {
            TriangleBlock::Face(face) => self.changed.faces.push(face),
            TriangleBlock::Edge(edge) => self.changed.edges.push(edge),
            TriangleBlock::Vertices(_) => {}
        }
    }

    /// Makes everything up to now visible as a snapshot.
    pub fn commit(&mut self) -> Arc<TriangleSnapshot<T>> {
        self.trim();
        let mut changed = std::mem::take(&mut self.changed);
        changed.sort();
        Arc::new(TriangleSnapshot {
            field: self.field.clone(),
            changed,
            revision: self.blocks.revision,
            bytes: self.bytes(),
        })
    }
}

fn check<T: Texel>(list: &[(u32, Vec<T>)], pages: &CowBlocks<Entry<T>>, count: usize, kind: &str) -> Result<()> {
    let place = |element: u32| format!("{kind} {element}");
    if let Some(pair) = list.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
        return Err(Error::invalid("it is listed twice or out of order").at(place(pair[1].0)));
    }
    for (element, values) in list {
        if *element as usize >= count {
            return Err(Error::invalid(format!("{kind} {element} does not exist")));
        }
        let Some(entry) = pages.entry(*element) else {
            return Err(Error::invalid("it is not allocated").at(place(*element)).advise("allocate it first"));
        };
        let count = entry.id.class.values();
        if count != values.len() {
            return Err(Error::invalid(format!("it has {count} values and got {}", values.len())).at(place(*element)));
        }
        if !T::all_finite(values) {
            return Err(Error::invalid("an edit left a number that is not finite").at(place(*element)));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::TriangleSets;
    use crate::triangle::shapes::{channel, fill, random, sets};
    use relievo_core::Context;

    #[test]
    fn edits_that_cannot_be_are_refused() {
        let context = Context::serial();
        let mut channel = channel(8, 1 << 20);
        let pattern = channel.field().pattern();
        channel.apply(&context, pattern, &sets(&[4])).unwrap();
        let values = vec![f16::ONE; pattern.face_values()];
        let faces = |faces: Vec<(u32, Vec<f16>)>| TriangleValues { faces, ..Default::default() };
        for bad in [
            faces(vec![(5, values.clone())]),
            faces(vec![(99, values.clone())]),
            faces(vec![(4, values[1..].to_vec())]),
            faces(vec![(4, values.clone()), (4, values.clone())]),
            faces(vec![(4, vec![f16::NAN; pattern.face_values()])]),
            TriangleValues { vertices: vec![(99, f16::ONE)], ..Default::default() },
            TriangleValues { vertices: vec![(0, f16::INFINITY)], ..Default::default() },
        ] {
            assert!(channel.write(bad).is_err());
        }
        channel.commit();
        channel.write(faces(vec![(4, values.clone())])).unwrap();
        let before = channel.commit();
        channel.write(faces(vec![(4, values)])).unwrap();
        assert_eq!(before.changed().faces, [4]);
        assert_eq!(channel.commit().changed(), &TriangleChange::default());
    }

    #[test]
    fn snapshots_stay_as_they_were() {
        let context = Context::serial();
        let mut channel = channel(8, 1 << 20);
        let pattern = channel.field().pattern();
        channel.apply(&context, pattern, &sets(&[0, 4])).unwrap();
        fill(&mut channel, random(7));
        let before = channel.commit();
        let old: Vec<f16> = before.face(4).unwrap().to_vec();
        let corner = before.vertex(before.topology().face(4)[0]);
        fill(&mut channel, random(8));
        channel.apply(&context, pattern, &TriangleSets { deallocate: vec![0], ..Default::default() }).unwrap();
        assert_eq!(before.face(4).unwrap(), old);
        assert_eq!(before.vertex(before.topology().face(4)[0]), corner);
        assert!(before.is_allocated(0) && !channel.field().is_allocated(0));
        let changed = channel.commit();
        assert!(changed.changed().faces_shown(changed.topology()).contains(&0));
    }
}
