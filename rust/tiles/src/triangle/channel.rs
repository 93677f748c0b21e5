//! A channel over a triangle mesh, with blocks on edges and faces where something happened: displacement or colour.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 6 and
//! 7.1. A face and its edges get their blocks together or not at all; an edge gives its block back when no face with a
//! block uses it. Vertices always have their value. The bytes in use are therefore
//!
//! (bytes of a value) · (vertices + Σ edges (T − 1) + Σ faces ⌊(3T/2)(T/2 − 1) + 1⌋),
//!
//! where T is that of each block. A face has the finest of the patterns it was asked for; what it held before is
//! interpolated. An edit goes: [`TriangleChannel::apply`], [`TriangleChannel::write`], [`TriangleChannel::commit`]. Where
//! the byte budget refuses a face it stays as it was and is reported. Units: those of the values; bytes.

use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_surface::TriangleTopology;

use super::field::{TriangleClass, TriangleField, barycentric};
use super::pattern::{Pattern, Slot};
use crate::heap::{Class, Heap};
use crate::pages::{Entry, Pages};
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
    field: TriangleField<T>,
    heap: Heap<TriangleClass>,
    revision: u64,
    /// Faces, edges and vertices changed since the last commit, with repetition.
    changed: TriangleChange,
}

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
    fn sort(&mut self) {
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
    field: TriangleField<T>,
    changed: TriangleChange,
    revision: u64,
    bytes: u64,
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

/// A block that an edit makes: of a face or an edge.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    class: TriangleClass,
    element: u32,
}

impl TriangleChannel {
    /// A displacement of zero everywhere. Fails as [`TriangleChannel::blank`] does.
    pub fn displacement(topology: Arc<TriangleTopology>, options: &TriangleOptions) -> Result<Self> {
        Self::blank(topology, f16::ZERO, options)
    }
}

impl<T: ColorTexel> TriangleChannel<T> {
    /// A mesh that has the colour `blank` all over, rounded as values are. Fails as [`TriangleChannel::blank`] does.
    pub fn of_color(topology: Arc<TriangleTopology>, blank: Vec4, options: &TriangleOptions) -> Result<Self> {
        Self::blank(topology, T::of_color(blank), options)
    }
}

impl<T: Texel> TriangleChannel<T> {
    /// A channel that reads as `blank` everywhere. Fails if the segments are none of those allowed or the budget does
    /// not hold the vertices.
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
            heap: Heap::new(size_of::<T>(), budget),
            revision: 0,
            changed: TriangleChange::default(),
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

    /// Bytes of vertices and blocks.
    pub fn bytes(&self) -> u64 {
        self.vertex_bytes() + self.heap.bytes()
    }

    /// Bytes if every face and edge had a block of the finest pattern.
    pub fn full_bytes(&self) -> u64 {
        let (topology, pattern) = (self.field.topology(), self.field.pattern());
        let values = topology.face_count() * pattern.face_values() + topology.edge_count() * pattern.edge_values();
        self.vertex_bytes() + (values * size_of::<T>()) as u64
    }

    /// Bytes that vertices and blocks may occupy.
    pub fn budget(&self) -> u64 {
        self.vertex_bytes().saturating_add(self.heap.budget())
    }

    /// Changes the budget. Blocks stay, even beyond it.
    pub fn set_budget(&mut self, budget: u64) {
        self.heap.set_budget(budget.saturating_sub(self.vertex_bytes()));
    }

    /// Gives faces blocks of `pattern`, and takes others' away. Nothing reads otherwise where a block is made, but for
    /// rounding. Faces that already are as wished are left out. Returns the faces the budget refused, ascending.
    ///
    /// Fails, and does nothing, if a face does not exist or the pattern is not the finest, half or a quarter of it.
    pub fn apply(&mut self, context: &Context, pattern: Pattern, sets: &TriangleSets) -> Result<Vec<u32>> {
        let finest = self.field.pattern().segments();
        if ![1, 2, 4].iter().any(|part| pattern.segments() * part == finest) {
            return Err(Error::invalid(format!("the mesh has no level of {} segments", pattern.segments()))
                .advise(format!("use {finest}, {} or {}", finest / 2, finest / 4)));
        }
        let count = self.field.topology().face_count();
        if let Some(face) = sets.allocate.iter().chain(&sets.deallocate).find(|face| **face as usize >= count) {
            return Err(Error::invalid(format!("face {face} does not exist")).advise(format!("use 0 to {}", count - 1)));
        }
        self.revision += 1;
        self.deallocate(&sets.deallocate);
        Ok(self.allocate(context, pattern, &sets.allocate))
    }

    fn deallocate(&mut self, faces: &[u32]) {
        let topology = self.field.topology().clone();
        let mut freed = Vec::new();
        for face in faces {
            let Some(entry) = self.field.faces.entry_mut(*face).take() else { continue };
            freed.push(entry.id);
            self.changed.faces.push(*face);
            for edge in topology.edges_of(*face) {
                if topology.faces_along(edge).any(|(face, _)| self.field.is_allocated(face)) {
                    continue;
                }
                if let Some(entry) = self.field.edges.entry_mut(edge).take() {
                    freed.push(entry.id);
                    self.changed.edges.push(edge);
                }
            }
        }
        self.heap.free(&freed);
    }

    fn allocate(&mut self, context: &Context, pattern: Pattern, faces: &[u32]) -> Vec<u32> {
        let coarser = |own: Option<Pattern>| own.is_none_or(|own| own < pattern);
        let mut faces: Vec<u32> =
            faces.iter().copied().filter(|face| coarser(self.field.face_pattern(*face))).collect();
        faces.sort_unstable();
        faces.dedup();
        let (mut refused, mut wanted) = (Vec::new(), Vec::new());
        let mut edges = BTreeMap::new();
        let mut bytes = self.heap.bytes();
        let size = |class: TriangleClass| (class.values() * size_of::<T>()) as u64;
        let class = |face: bool| TriangleClass { face, pattern };
        for face in faces {
            let own = self.field.topology().edges_of(face);
            let new =
                own.into_iter().filter(|edge| coarser(self.field.edge_pattern(*edge)) && !edges.contains_key(edge));
            let new: Vec<u32> = new.collect();
            let old = |edge: &u32| {
                self.field.edge_pattern(*edge).map_or(0, |pattern| size(TriangleClass { face: false, pattern }))
            };
            let replaced =
                self.field.face_pattern(face).map_or(0, |pattern| size(TriangleClass { face: true, pattern }));
            let more = size(class(true)) + new.len() as u64 * size(class(false));
            let less = replaced + new.iter().map(old).sum::<u64>();
            // What is replaced is smaller.
            let then = bytes.saturating_add(more - less);
            if then > self.heap.budget() {
                refused.push(face);
                continue;
            }
            bytes = then;
            edges.extend(new.into_iter().map(|edge| (edge, ())));
            wanted.push(Wanted { class: class(true), element: face });
        }
        wanted.extend(edges.into_keys().map(|element| Wanted { class: class(false), element }));
        let field = &self.field;
        let blocks = context.map(wanted.len(), |index| values_of(field, &wanted[index]));
        let mut freed = Vec::new();
        for Wanted { class, element } in &wanted {
            let pages = if class.face { &mut self.field.faces } else { &mut self.field.edges };
            freed.extend(pages.entry_mut(*element).take().map(|entry| entry.id));
        }
        self.heap.free(&freed);
        let classes: Vec<TriangleClass> = wanted.iter().map(|wanted| wanted.class).collect();
        for ((wanted, texels), id) in wanted.iter().zip(blocks).zip(self.heap.allocate(&classes)) {
            let Some(id) = id else { continue };
            let (pages, list) = match wanted.class.face {
                true => (&mut self.field.faces, &mut self.changed.faces),
                false => (&mut self.field.edges, &mut self.changed.edges),
            };
            *pages.entry_mut(wanted.element) = Some(Entry { texels, id, version: self.revision });
            list.push(wanted.element);
        }
        refused
    }

    /// Writes new values; elements whose values stay the same are not touched.
    ///
    /// Fails, and changes nothing, if an element does not exist or is listed out of order, has no block or one of
    /// another length, or if a number is not finite.
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
        self.revision += 1;
        let same = |old: &[T], new: &[T]| bytemuck::cast_slice::<T, u8>(old) == bytemuck::cast_slice::<T, u8>(new);
        let lists = [
            (values.faces, &mut self.field.faces, &mut self.changed.faces),
            (values.edges, &mut self.field.edges, &mut self.changed.edges),
        ];
        for (list, pages, changed) in lists {
            for (element, new) in list {
                if pages.entry(element).is_some_and(|entry| same(&entry.texels, &new)) {
                    continue;
                }
                if let Some(entry) = pages.entry_mut(element) {
                    entry.texels = new.into();
                    entry.version = self.revision;
                    changed.push(element);
                }
            }
        }
        for (vertex, value) in values.vertices {
            if !self.field.vertex(vertex).same(value) {
                self.field.set_vertex(vertex, value);
                self.changed.vertices.push(vertex);
            }
        }
        Ok(())
    }

    /// Gives back the blocks of those of `faces` that hold nothing but what is read without them: those whose corners and
    /// inside are blank, and whose edges are blank or have another face with a block. Returns the faces, ascending.
    ///
    /// Fails, and changes nothing, if a face does not exist.
    pub fn reclaim(&mut self, context: &Context, faces: &[u32]) -> Result<Vec<u32>> {
        let topology = self.field.topology().clone();
        let blank = self.field.blank();
        let empty = |block: Option<&[T]>| block.is_none_or(|block| block.iter().all(|value| value.is_blank(blank)));
        let mut faces: Vec<u32> =
            faces.iter().copied().filter(|face| (*face as usize) < topology.face_count()).collect();
        faces.sort_unstable();
        faces.dedup();
        let mut gone: Vec<u32> = Vec::new();
        for face in faces {
            let field = &self.field;
            let corners = topology.face(face);
            if !field.is_allocated(face)
                || !empty(field.face(face))
                || !corners.iter().all(|vertex| field.vertex(*vertex).is_blank(blank))
            {
                continue;
            }
            let stays = |other: u32| field.is_allocated(other) && gone.binary_search(&other).is_err();
            let free = |edge: &u32| {
                let mut along = topology.faces_along(*edge);
                empty(field.edge(*edge)) || along.any(|(other, _)| other != face && stays(other))
            };
            if topology.edges_of(face).iter().all(free) {
                gone.push(face);
            }
        }
        let pattern = self.field.pattern();
        self.apply(context, pattern, &TriangleSets { deallocate: gone.clone(), ..Default::default() })?;
        Ok(gone)
    }

    /// What the exchange of blocks writes: the values, what changed, the heap, and the number of the last edit.
    pub(super) fn parts(&mut self) -> (&mut TriangleField<T>, &mut TriangleChange, &mut Heap<TriangleClass>, &mut u64) {
        (&mut self.field, &mut self.changed, &mut self.heap, &mut self.revision)
    }

    /// Makes everything up to now visible as a snapshot.
    pub fn commit(&mut self) -> Arc<TriangleSnapshot<T>> {
        let mut changed = std::mem::take(&mut self.changed);
        changed.sort();
        Arc::new(TriangleSnapshot { field: self.field.clone(), changed, revision: self.revision, bytes: self.bytes() })
    }
}

/// What the block of an element reads as before it has it.
fn values_of<T: Texel>(field: &TriangleField<T>, wanted: &Wanted) -> Arc<[T]> {
    let Wanted { class: TriangleClass { face, pattern }, element } = *wanted;
    if !face {
        let segments = pattern.segments();
        let value = |step: u32| T::nearest(field.on_edge(element, step as f32 / segments as f32));
        return (1..segments).map(value).collect();
    }
    if field.is_blank(element) {
        return vec![field.blank(); pattern.face_values()].into();
    }
    let value = |index: u32| {
        let node = pattern.at_slot(Slot::Inside(index));
        T::nearest(field.value(element, barycentric(pattern, node)))
    };
    (0..pattern.face_values() as u32).map(value).collect()
}

fn check<T: Texel>(
    list: &[(u32, Vec<T>)],
    pages: &Pages<Entry<T, TriangleClass>>,
    count: usize,
    kind: &str,
) -> Result<()> {
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
        if entry.texels.len() != values.len() {
            return Err(Error::invalid(format!("it has {} values and got {}", entry.texels.len(), values.len()))
                .at(place(*element)));
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
    use crate::texel::Rgba8;
    use crate::triangle::shapes;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn channel(segments: u32, budget: u64) -> TriangleChannel {
        let topology = Arc::new(TriangleTopology::of_mesh(&shapes::sail(3)).unwrap());
        TriangleChannel::displacement(topology, &TriangleOptions { segments, budget }).unwrap()
    }

    fn sets(allocate: &[u32]) -> TriangleSets {
        TriangleSets { allocate: allocate.to_vec(), deallocate: Vec::new() }
    }

    fn random(seed: u64) -> impl FnMut(u32) -> u32 {
        let mut state = seed | 1;
        move |below| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 16) as u32 % below
        }
    }

    /// Fills what has a block with numbers.
    fn fill(channel: &mut TriangleChannel, mut random: impl FnMut(u32) -> u32) {
        let field = channel.field().clone();
        let mut number = || f16::from_f32(random(1000) as f32 / 256.0 - 2.0);
        let mut block = |block: Option<&[f16]>| block.unwrap_or(&[]).iter().map(|_| number()).collect::<Vec<_>>();
        let faces = field.allocated().map(|face| (face, block(field.face(face)))).collect();
        let edges = field.allocated_edges().map(|edge| (edge, block(field.edge(edge)))).collect();
        let mut vertices: Vec<u32> = field.allocated().flat_map(|face| field.topology().face(face)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let vertices = vertices.into_iter().map(|vertex| (vertex, number())).collect();
        channel.write(TriangleValues { faces, edges, vertices }).unwrap();
    }

    #[test]
    fn a_face_and_its_edges_take_the_bytes_of_the_formula() {
        let context = Context::serial();
        let mut channel = channel(16, 1 << 20);
        let vertices = 2 * channel.field().topology().vertex_count() as u64;
        assert_eq!(channel.bytes(), vertices);
        let pattern = channel.field().pattern();
        assert!(channel.apply(&context, pattern, &sets(&[0])).unwrap().is_empty());
        assert_eq!(channel.bytes(), vertices + 2 * (169 + 3 * 15));
        // The neighbour across the diagonal shares an edge.
        assert!(channel.apply(&context, pattern, &sets(&[0, 1])).unwrap().is_empty());
        assert_eq!(channel.bytes(), vertices + 2 * (2 * 169 + 5 * 15));
        let gone = TriangleSets { deallocate: vec![0], ..Default::default() };
        channel.apply(&context, pattern, &gone).unwrap();
        assert_eq!(channel.bytes(), vertices + 2 * (169 + 3 * 15));
        assert_eq!(channel.reclaim(&context, &[0, 1, 2, 999]).unwrap(), [1]);
        assert_eq!(channel.bytes(), vertices);
        let full = channel.full_bytes();
        let all: Vec<u32> = (0..channel.field().topology().face_count() as u32).collect();
        channel.apply(&context, pattern, &sets(&all)).unwrap();
        assert_eq!(channel.bytes(), full);
    }

    #[test]
    fn what_does_not_fit_is_refused_whole() {
        let context = Context::serial();
        let small = channel(16, 1 << 20);
        let vertices = small.bytes();
        let one = 2 * (169 + 3 * 15);
        let mut channel = channel(16, vertices + one + 2 * 169);
        let pattern = channel.field().pattern();
        assert_eq!(channel.apply(&context, pattern, &sets(&[0, 1, 2])).unwrap(), [1, 2]);
        assert_eq!(channel.bytes(), vertices + one);
        channel.set_budget(vertices + one + 2 * (169 + 2 * 15));
        assert_eq!(channel.apply(&context, pattern, &sets(&[0, 1, 2])).unwrap(), [2]);
        let topology = channel.field().topology().clone();
        let starved = TriangleOptions { segments: 16, budget: vertices - 1 };
        assert!(TriangleChannel::displacement(topology.clone(), &starved).is_err());
        for segments in [0, 4, 12, 128] {
            let options = TriangleOptions { segments, budget: 1 << 30 };
            assert!(TriangleChannel::displacement(topology.clone(), &options).is_err());
        }
        assert!(channel.apply(&context, Pattern::new(32).unwrap(), &sets(&[0])).is_err());
        assert!(channel.apply(&context, pattern, &sets(&[u32::MAX])).is_err());
    }

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

    #[test]
    fn nothing_reads_otherwise_where_a_block_is_made() {
        let context = Context::serial();
        let mut channel = channel(32, 1 << 20);
        let [fine, middle, coarse] = [32, 16, 8].map(|segments| Pattern::new(segments).unwrap());
        channel.apply(&context, coarse, &sets(&[4])).unwrap();
        channel.apply(&context, fine, &sets(&[5])).unwrap();
        fill(&mut channel, random(3));
        let places: Vec<[f32; 3]> =
            (0..=30).flat_map(|i| (0..=30 - i).map(move |j| [i, j, 30 - i - j].map(|k| k as f32 / 30.0))).collect();
        let faces = channel.field().topology().face_count() as u32;
        let read = |channel: &TriangleChannel| -> Vec<f64> {
            (0..faces)
                .flat_map(|face| places.iter().map(move |at| (face, at)))
                .map(|(face, at)| channel.field().value(face, *at))
                .collect()
        };
        let before = read(&channel);
        // At the vertices of the finer pattern it is what it was; the surface between them is another.
        let old = channel.field().clone();
        for pattern in [middle, fine] {
            let before = channel.field().clone();
            channel.apply(&context, pattern, &sets(&[4, 7, 9])).unwrap();
            for face in 0..faces {
                let Some(pattern) = channel.field().face_pattern(face) else { continue };
                for index in 0..pattern.face_values() as u32 {
                    let node = pattern.at_slot(Slot::Inside(index));
                    let [now, then] = [channel.field(), &before].map(|field| field.at(face, pattern, node));
                    assert!((now - then).abs() < 4e-3, "face {face} {now} {then}");
                }
            }
        }
        let furthest = read(&channel).iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(furthest < 4.0, "{furthest}");
        // Those that were there are the same to the bit.
        for index in 0..coarse.face_values() as u32 {
            let node = coarse.at_slot(Slot::Inside(index));
            let refined = middle.refined(coarse.refined(node));
            let (Slot::Inside(now), Some(block)) = (fine.slot(refined), channel.field().face(4)) else { panic!() };
            assert_eq!(block[now as usize], old.face(4).unwrap()[index as usize]);
        }
    }

    #[test]
    fn what_is_read_is_continuous_across_edges_of_all_kinds() {
        let context = Context::serial();
        let mut channel = channel(32, 1 << 20);
        let [fine, middle, coarse] = [32, 16, 8].map(|segments| Pattern::new(segments).unwrap());
        channel.apply(&context, fine, &sets(&[4, 11])).unwrap();
        channel.apply(&context, middle, &sets(&[5, 12])).unwrap();
        channel.apply(&context, coarse, &sets(&[9])).unwrap();
        fill(&mut channel, random(11));
        let field = channel.field();
        let topology = field.topology();
        for edge in 0..topology.edge_count() as u32 {
            for (face, side) in topology.faces_along(edge) {
                let side = side as usize;
                for k in 0..=70 {
                    let along = k as f32 / 70.0;
                    let wanted = field
                        .on_edge(edge, if topology.side(face, side as u32).reversed { 1.0 - along } else { along });
                    for (off, tolerance) in [(0.0, 1e-5), (1e-5, 5e-3)] {
                        let mut at = [off; 3];
                        at[side] = (1.0 - along) * (1.0 - off);
                        at[(side + 1) % 3] = along * (1.0 - off);
                        let found = field.value(face, at);
                        assert!(
                            (found - wanted).abs() < tolerance,
                            "edge {edge} face {face} {along} {off}: {found} {wanted}"
                        );
                    }
                }
            }
        }
        // And inside, over small steps, at 32 segments whose values differ by up to 4.
        for face in [4, 5, 6, 8, 9] {
            for i in 1..199 {
                let at = |x: f32| [x * 0.3, x * 0.7, 1.0 - x];
                let [a, b] = [0, 1].map(|step| field.value(face, at((i + step) as f32 / 200.0)));
                assert!((a - b).abs() < 4.0 * 3.0 * 32.0 / 200.0, "face {face} {i}: {a} {b}");
            }
        }
    }

    #[test]
    fn colours_of_one_colour_stay_that_colour() {
        let context = Context::serial();
        let topology = Arc::new(TriangleTopology::of_mesh(&shapes::sail(2)).unwrap());
        let grey = Rgba8([120, 130, 140, 255]);
        let mut channel =
            TriangleChannel::blank(topology, grey, &TriangleOptions { segments: 16, budget: 1 << 20 }).unwrap();
        channel.apply(&context, Pattern::new(8).unwrap(), &sets(&[2])).unwrap();
        channel.apply(&context, Pattern::new(16).unwrap(), &sets(&[2, 3])).unwrap();
        assert!(channel.field().face(2).unwrap().iter().all(|value| *value == grey));
        for face in 0..4 {
            assert_eq!(Rgba8::nearest(channel.field().value(face, [0.2, 0.35, 0.45])), grey);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Against a model: the pattern of every face, and of every edge the finest it was ever given with.
        #[test]
        fn blocks_are_those_of_a_model(seed: u64, budget in 0u64..60_000) {
            let context = Context::serial();
            let mut channel = channel(32, 1 << 30);
            let vertices = channel.bytes();
            channel.set_budget(vertices + budget);
            let topology = channel.field().topology().clone();
            let faces = topology.face_count() as u32;
            let mut random = random(seed);
            let mut model: BTreeMap<u32, Pattern> = BTreeMap::new();
            let mut edges: BTreeMap<u32, Pattern> = BTreeMap::new();
            for _ in 0..400 {
                let list: BTreeSet<u32> = (0..random(6)).map(|_| random(faces)).collect();
                if random(3) > 0 {
                    let pattern = Pattern::new([8, 16, 32][random(3) as usize]).unwrap();
                    let refused = channel.apply(&context, pattern, &sets(&list.iter().copied().collect::<Vec<_>>())).unwrap();
                    prop_assert!(refused.iter().all(|face| list.contains(face)));
                    for face in list.iter().filter(|face| refused.binary_search(face).is_err()) {
                        let own = model.entry(*face).or_insert(pattern);
                        *own = pattern.max(*own);
                        for edge in topology.edges_of(*face) {
                            let own = edges.entry(edge).or_insert(pattern);
                            *own = pattern.max(*own);
                        }
                    }
                } else {
                    let gone = TriangleSets { deallocate: list.iter().copied().collect(), ..Default::default() };
                    channel.apply(&context, channel.field().pattern(), &gone).unwrap();
                    model.retain(|face, _| !list.contains(face));
                    let used: BTreeSet<u32> = model.keys().flat_map(|face| topology.edges_of(*face)).collect();
                    edges.retain(|edge, _| used.contains(edge));
                }
                let field = channel.field();
                prop_assert!(field.allocated().eq(model.keys().copied()));
                prop_assert!(field.allocated_edges().eq(edges.keys().copied()));
                prop_assert!(model.iter().all(|(face, pattern)| field.face_pattern(*face) == Some(*pattern)));
                prop_assert!(edges.iter().all(|(edge, pattern)| field.edge_pattern(*edge) == Some(*pattern)));
                let values = model.values().map(|pattern| pattern.face_values()).sum::<usize>()
                    + edges.values().map(|pattern| pattern.edge_values()).sum::<usize>();
                prop_assert_eq!(channel.bytes(), vertices + 2 * values as u64);
                prop_assert!(channel.bytes() <= channel.budget());
            }
            let all: Vec<u32> = (0..faces).collect();
            channel.reclaim(&context, &all).unwrap();
            prop_assert_eq!(channel.bytes(), vertices);
        }
    }
}
