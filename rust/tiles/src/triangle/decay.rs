//! Edits of a triangle mesh that fade: every value that is edited gets a time stamp, and what was put there goes
//! linearly back to what is blank.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 7.2, as
//! on tiles, see [`crate::layers::decay`]. The edited values and their stamps are two channels more over the same triangles, so
//! that what a finer pattern finds between stamped values is stamped too. Bytes: those of [`super::channel`] for values
//! and for stamps of 4 bytes, of the faces that hold a stamp. Units: seconds.

use std::any::Any;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_document::{Document, Kind, Stamps};
use relievo_gpu::Device;
use relievo_surface::TriangleTopology;

use super::allocation::values_of;
use super::block::TriangleBlock;
use super::change::{TriangleChange, TriangleSets, TriangleValues};
use super::channel::{TriangleChannel, TriangleOptions};
use super::field::{TriangleClass, TriangleField};
use super::pattern::Pattern;
use crate::layers::decay::{DecayOptions, FadeReport, PERMANENT, order};
use crate::layers::fade::{Fader, FadingBlock, words};
use crate::store::blocks::Blocks;
use crate::store::stored::StoredTexel;
use crate::texel::Texel;

/// When a value was edited, in seconds; [`PERMANENT`] where it does not fade.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct EditTime(pub f32);

impl EditTime {
    const NONE: Self = Self(PERMANENT);

    fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// As a value it is a share and the time times that, so that means of it are those of the times that there are.
impl Texel for EditTime {
    type Value = DVec3;
    type Difference = Self;

    fn value(self) -> DVec3 {
        if self.is_none() { DVec3::ZERO } else { DVec3::new(1.0, f64::from(self.0), 0.0) }
    }

    fn nearest(value: DVec3) -> Self {
        if value.x > 0.0 { Self((value.y / value.x) as f32) } else { Self::NONE }
    }

    fn flipped(self) -> Self {
        self
    }

    fn all_finite(texels: &[Self]) -> bool {
        texels.iter().all(|stamp| stamp.0.is_finite())
    }
}

/// The stamps of a channel over triangles.
#[derive(Debug)]
pub struct TriangleDecay<T> {
    options: DecayOptions,
    /// The values as they were edited.
    edited: TriangleChannel<T>,
    stamps: TriangleChannel<EditTime>,
    /// Of the faces that hold nothing but what fades, a number that grows with the newest stamp.
    ages: BTreeMap<u32, u64>,
    /// Blocks that were put back one by one, around which some may be missing.
    torn: Vec<u32>,
    fader: Fader,
}

/// Values of an element, the values that it was edited to, and their stamps.
type Stamped<T> = (Element, Vec<T>, Vec<T>, Vec<EditTime>);

/// The elements of a mesh that have values.
#[derive(Clone, Copy, Debug)]
enum Element {
    Face(u32),
    Edge(u32),
    Vertex(u32),
}

impl Element {
    fn of(change: &TriangleChange) -> Vec<Self> {
        let faces = change.faces.iter().copied().map(Self::Face);
        let edges = change.edges.iter().copied().map(Self::Edge);
        faces.chain(edges).chain(change.vertices.iter().copied().map(Self::Vertex)).collect()
    }

    fn change(elements: impl Iterator<Item = Self>) -> TriangleChange {
        let mut change = TriangleChange::default();
        for element in elements {
            match element {
                Self::Face(face) => change.faces.push(face),
                Self::Edge(edge) => change.edges.push(edge),
                Self::Vertex(vertex) => change.vertices.push(vertex),
            }
        }
        change
    }

    /// The number of its block; vertices have none of their own.
    fn block(self, topology: &TriangleTopology) -> Option<u32> {
        match self {
            Self::Face(face) => Some(TriangleBlock::Face(face).number(topology)),
            Self::Edge(edge) => Some(TriangleBlock::Edge(edge).number(topology)),
            Self::Vertex(_) => None,
        }
    }

    /// What `field` holds of it.
    fn held<T: Texel>(self, field: &TriangleField<T>) -> Option<Vec<T>> {
        match self {
            Self::Face(face) => field.face(face).map(<[T]>::to_vec),
            Self::Edge(edge) => field.edge(edge).map(<[T]>::to_vec),
            Self::Vertex(vertex) => Some(vec![field.vertex(vertex)]),
        }
    }

    /// What `field` holds of it, or reads as in the pattern that `other` has it in.
    fn read<T: Texel>(self, field: &TriangleField<T>, other: &TriangleField<T>) -> Option<Vec<T>> {
        let (face, element, wanted) = match self {
            Self::Face(face) => (true, face, other.face_pattern(face)?),
            Self::Edge(edge) => (false, edge, other.edge_pattern(edge)?),
            Self::Vertex(_) => return self.held(field),
        };
        let own = if face { field.face_pattern(element) } else { field.edge_pattern(element) };
        match own == Some(wanted) {
            true => self.held(field),
            false => Some(values_of(field, TriangleClass { face, pattern: wanted }, element).to_vec()),
        }
    }

    /// Whether it has values in `after` that are not what `before` reads as there.
    fn differs<T: Texel>(self, before: &TriangleField<T>, after: &TriangleField<T>) -> bool {
        let both = self.held(after).zip(self.read(before, after));
        both.is_some_and(|(new, old)| new.iter().zip(&old).any(|(new, old)| !new.same(*old)))
    }
}

/// The number under which a device knows the vertices that fade.
const VERTICES: u32 = u32::MAX;

/// What a device says is left, by block and by vertex.
#[derive(Debug)]
struct Left<T> {
    blocks: BTreeMap<u32, Vec<T>>,
    vertices: BTreeMap<u32, T>,
}

impl<T> Default for Left<T> {
    fn default() -> Self {
        Self { blocks: BTreeMap::new(), vertices: BTreeMap::new() }
    }
}

impl<T> Left<T> {
    fn of(&self, element: Element, topology: &TriangleTopology) -> Option<&[T]> {
        match element {
            Element::Vertex(vertex) => self.vertices.get(&vertex).map(std::slice::from_ref),
            _ => self.blocks.get(&element.block(topology)?).map(Vec::as_slice),
        }
    }
}

/// Values by element, as channels are given them.
fn listed<T: Texel>(values: impl Iterator<Item = (Element, Vec<T>)>) -> TriangleValues<T> {
    let mut list = TriangleValues::default();
    for (element, values) in values {
        match element {
            Element::Face(face) => list.faces.push((face, values)),
            Element::Edge(edge) => list.edges.push((edge, values)),
            Element::Vertex(vertex) => list.vertices.extend(values.first().map(|value| (vertex, *value))),
        }
    }
    list
}

impl<T: StoredTexel> TriangleDecay<T> {
    /// No stamps yet, for a channel that is `field`; values and stamps may occupy `budget` bytes together.
    ///
    /// # Errors
    /// Fails as [`DecayOptions::check`], or if the budget does not hold the vertices.
    pub fn new(field: &TriangleField<T>, options: DecayOptions, budget: u64) -> Result<Self> {
        options.check()?;
        // They have the same blocks, so that both are full at once.
        let values = budget / (size_of::<T>() + size_of::<EditTime>()) as u64;
        let sizes = |bytes: usize| TriangleOptions {
            segments: field.pattern().segments(),
            budget: values.saturating_mul(bytes as u64),
        };
        let edited = TriangleChannel::blank(field.topology().clone(), field.blank(), &sizes(size_of::<T>()))?;
        let stamps = TriangleChannel::blank(field.topology().clone(), EditTime::NONE, &sizes(size_of::<EditTime>()))?;
        Ok(Self { options, edited, stamps, ages: BTreeMap::new(), torn: Vec::new(), fader: Fader::default() })
    }

    /// When edits fade.
    pub fn options(&self) -> DecayOptions {
        self.options
    }

    /// Replaces the decay times; edits already recorded follow the new ones.
    ///
    /// # Errors
    /// Fails as [`DecayOptions::check`].
    pub fn set_options(&mut self, options: DecayOptions) -> Result<()> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Bytes of the stamps and the values they belong to.
    pub fn bytes(&self) -> u64 {
        self.edited.bytes() + self.stamps.bytes()
    }

    /// The stamps as they are.
    pub fn stamps(&self) -> &TriangleField<EditTime> {
        self.stamps.field()
    }

    /// The newest stamp there is.
    pub fn newest(&self) -> Option<f32> {
        let field = self.stamps.field();
        let faces = field.allocated().filter_map(|face| field.face(face));
        let edges = field.allocated_edges().filter_map(|edge| field.edge(edge));
        let stamps = faces.chain(edges).chain(field.vertices()).flatten();
        stamps.filter(|stamp| !stamp.is_none()).map(|stamp| stamp.0).max_by(f32::total_cmp)
    }

    /// The faces that hold nothing but what fades, on their edges and at their corners neither, beginning with those
    /// whose newest stamp is oldest, each behind a number that grows with that stamp.
    pub fn oldest(&self) -> Vec<(u64, u32)> {
        let mut ages: Vec<(u64, u32)> = self.ages.iter().map(|(face, age)| (*age, *face)).collect();
        ages.sort_unstable();
        ages
    }

    fn topology(&self) -> Arc<TriangleTopology> {
        self.stamps.field().topology().clone()
    }

    /// Follows a channel that is `field`: to other segments, and where faces have become coarser or were given back.
    #[inline(never)]
    fn follow(&mut self, context: &Context, field: &TriangleField<T>) -> Result<()> {
        let segments = field.pattern().segments();
        if segments != self.stamps.field().pattern().segments() {
            self.edited.set_segments(segments)?;
            self.stamps.set_segments(segments)?;
            self.torn = self.stamps.blocks();
            self.ages.clear();
        }
        let torn = std::mem::take(&mut self.torn);
        if !torn.is_empty() {
            self.edited.mend_edges_around(context, &torn)?;
            self.stamps.mend_edges_around(context, &torn)?;
            self.mend_faces(context, field, &torn)?;
        }
        let gone = |face: &u32| self.stamps.field().face_pattern(*face) > field.face_pattern(*face);
        let gone: Vec<u32> = self.stamps.field().allocated().filter(gone).collect();
        self.deallocate(context, &gone)?;
        let topology = self.topology();
        let mut stale = TriangleBlock::change(&topology, torn).faces_shown(&topology);
        stale.extend(gone);
        self.age(&stale, field);
        Ok(())
    }

    /// Gives faces of `field` along stamped edges of `blocks` that were put back blocks without a stamp, where they have none.
    fn mend_faces(&mut self, context: &Context, field: &TriangleField<T>, blocks: &[u32]) -> Result<()> {
        let (topology, stamps) = (self.topology(), self.stamps.field());
        let mut edges = TriangleBlock::change(&topology, blocks.iter().copied()).edges;
        edges.retain(|edge| stamps.edge(*edge).is_some_and(|times| times.iter().any(|stamp| !stamp.is_none())));
        let beside = edges.into_iter().flat_map(|edge| topology.faces_along(edge)).map(|(face, _)| face);
        let bare = beside.filter(|face| !stamps.is_allocated(*face));
        let mut bare: BTreeMap<u32, Pattern> =
            bare.filter_map(|face| Some((face, field.face_pattern(face)?))).collect();
        self.stamps.without_budget(|stamps| stamps.give_blank(context, &bare))?;
        bare.retain(|face, _| !self.edited.field().is_allocated(*face));
        self.edited.without_budget(|edited| edited.give_blank(context, &bare))
    }

    /// Finds out how old `faces` are.
    fn age(&mut self, faces: &[u32], field: &TriangleField<T>) {
        for face in faces {
            match self.age_of(*face, field) {
                Some(age) => self.ages.insert(*face, age),
                None => self.ages.remove(face),
            };
        }
    }

    /// A number that grows with the newest stamp of a face, its edges and its corners; `None` if something there does
    /// not fade, or nothing can.
    fn age_of(&self, face: u32, field: &TriangleField<T>) -> Option<u64> {
        let (stamps, topology, blank) = (self.stamps.field(), field.topology(), field.blank());
        if !stamps.is_allocated(face) {
            return None;
        }
        let edges = topology.edges_of(face).map(TriangleBlock::Edge);
        let mut newest = f32::NEG_INFINITY;
        let mut take = |value: T, stamp: EditTime| {
            if !stamp.is_none() {
                newest = newest.max(stamp.0);
            }
            !stamp.is_none() || value.is_blank(blank)
        };
        for block in edges.into_iter().chain([TriangleBlock::Face(face)]) {
            let (values, times) = (field.held(block)?, stamps.held(block)?);
            let fades = values.iter().zip(times).all(|(value, stamp)| take(*value, *stamp));
            if !fades || values.len() != times.len() {
                return None;
            }
        }
        let fades = topology.face(face).into_iter().all(|vertex| take(field.vertex(vertex), stamps.vertex(vertex)));
        fades.then(|| order(newest))
    }

    /// Stamps with `time` all values in which `channel` now differs from `before`. Returns the faces, ascending, that
    /// the budget refused; what was edited there stays.
    ///
    /// # Errors
    /// Fails if a face of the channel does not exist in the mesh of the stamps.
    #[inline(never)]
    pub fn stamp(
        &mut self,
        context: &Context,
        before: &TriangleField<T>,
        channel: &TriangleChannel<T>,
        time: f64,
    ) -> Result<Vec<u32>> {
        let (topology, after) = (self.topology(), channel.field());
        self.follow(context, after)?;
        let change = after.changes(before);
        // By the same rule as those of values: a face without stamps would follow what is stamped around it.
        let around = TriangleChange { edges: change.edges.clone(), ..Default::default() };
        let around = Element::of(&around).into_iter().filter(|edge| edge.differs(before, after));
        let around = TriangleChange { vertices: change.vertices.clone(), ..Element::change(around) };
        let mut faces = [change.faces.clone(), around.faces_shown(&topology)].concat();
        faces.retain(|face| after.is_allocated(*face));
        faces.sort_unstable();
        faces.dedup();
        let mut refused = Vec::new();
        for level in [2, 1, 0] {
            let pattern: Pattern = after.pattern().coarser(level);
            let chosen = faces.iter().copied().filter(|face| after.face_pattern(*face) == Some(pattern));
            let mut sets = TriangleSets { allocate: chosen.collect(), ..Default::default() };
            let first = self.stamps.apply(context, pattern, &sets)?;
            sets.allocate.retain(|face| first.binary_search(face).is_err());
            let second = self.edited.apply(context, pattern, &sets)?;
            let whole = second.iter().filter(|face| self.edited.field().face_pattern(**face).is_none());
            let whole = TriangleSets { deallocate: whole.copied().collect(), ..Default::default() };
            self.stamps.apply(context, pattern, &whole)?;
            refused.extend(first.into_iter().chain(second));
        }
        refused.sort_unstable();
        let (edited, stamps) = (self.edited.field(), self.stamps.field());
        let elements = Element::of(&change);
        let blank = after.blank();
        let bare = |vertex: u32| topology.faces_around(vertex).all(|(face, _)| !after.is_allocated(face));
        let lacks = |edge: u32| {
            let mut along = topology.faces_along(edge);
            along.any(|(face, _)| after.is_allocated(face) && !stamps.is_allocated(face))
        };
        let stamped = context.map(elements.len(), |index| {
            let element = elements[index];
            if matches!(element, Element::Edge(edge) if lacks(edge)) {
                return None;
            }
            let (new, old) = (element.held(after)?, element.read(before, after)?);
            let (mut values, mut times) = (element.held(edited)?, element.held(stamps)?);
            // Where the budget refused, the patterns are others.
            if values.len() != new.len() || times.len() != new.len() {
                return None;
            }
            for (at, (new, old)) in new.iter().zip(&old).enumerate() {
                if !new.same(*old) {
                    (values[at], times[at]) = (*new, EditTime(time as f32));
                } else if times[at].is_none() && !matches!(element, Element::Vertex(_)) {
                    // For what a finer pattern finds between it and what is stamped.
                    values[at] = *new;
                }
            }
            // What has become blank with all around it has nothing left to fade.
            if let Element::Vertex(vertex) = element
                && new.iter().all(|value| value.same(blank))
                && bare(vertex)
            {
                (values, times) = (new, vec![EditTime::NONE]);
            }
            Some((element, values, times))
        });
        let stamped: Vec<_> = stamped.into_iter().flatten().collect();
        self.edited.write(listed(stamped.iter().map(|(element, values, _)| (*element, values.clone()))))?;
        self.stamps.write(listed(stamped.into_iter().map(|(element, _, times)| (element, times))))?;
        self.age(&change.faces_shown(&topology), after);
        Ok(refused)
    }

    /// Has a graphics device evaluate what is left of edits from now on, or the processor again, which also takes over
    /// where the device fails.
    pub fn use_device(&mut self, device: Option<&Device>) {
        self.fader.use_device(device);
    }

    /// The failure after which the processor took over, told once.
    pub fn take_device_fault(&mut self) -> Option<Error> {
        self.fader.take_fault()
    }

    /// What a device says is left of `elements` that fade; nothing where the processor is to.
    #[inline(never)]
    fn evaluate(&mut self, context: &Context, elements: &[Element], blank: T, time: f64) -> Left<T> {
        if !self.fader.is_on_device() {
            return Left::default();
        }
        let (edited, stamps, options) = (self.edited.field(), self.stamps.field(), self.options);
        let topology = stamps.topology();
        let fades = |stamp: &EditTime| !stamp.is_none() && options.share(stamp.0, time) < 1.0;
        let blocks = context.map(elements.len(), |index| {
            let block = elements[index].block(topology)?;
            let (from, times) = (elements[index].held(edited)?, elements[index].held(stamps)?);
            if from.len() != times.len() || !times.iter().any(fades) {
                return None;
            }
            Some(FadingBlock { block, texels: from.len(), words: words(&from, bytemuck::cast_slice(&times)) })
        });
        let mut blocks: Vec<FadingBlock> = blocks.into_iter().flatten().collect();
        // Vertices are a block together.
        let vertices = elements.iter().filter_map(|element| match element {
            Element::Vertex(vertex) => Some(*vertex),
            _ => None,
        });
        let vertices: Vec<u32> = vertices.collect();
        let times: Vec<EditTime> = vertices.iter().map(|vertex| stamps.vertex(*vertex)).collect();
        if times.iter().any(fades) {
            let from: Vec<T> = vertices.iter().map(|vertex| edited.vertex(*vertex)).collect();
            let words = words(&from, bytemuck::cast_slice(&times));
            blocks.push(FadingBlock { block: VERTICES, texels: from.len(), words });
        }
        let fader = &mut self.fader;
        let mut blocks = context.stats().time("decay.device", || fader.evaluate(&blocks, blank, options, time));
        let values = blocks.remove(&VERTICES).unwrap_or_default();
        Left { blocks, vertices: vertices.into_iter().zip(values).collect() }
    }

    /// What is left of elements at `time` where something has faded.
    #[inline(never)]
    fn faded(&mut self, context: &Context, field: &TriangleField<T>, time: f64) -> Vec<Stamped<T>> {
        let mut held = TriangleBlock::change(&self.topology(), self.stamps.field().blocks());
        held.vertices.retain(|vertex| !self.stamps.field().vertex(*vertex).is_none());
        let elements = Element::of(&held);
        let (options, blank) = (self.options, field.blank());
        let left = self.evaluate(context, &elements, blank, time);
        let (edited, stamps) = (self.edited.field(), self.stamps.field());
        let faded = context.map(elements.len(), |index| {
            let element = elements[index];
            let times = element.held(stamps)?;
            let share = |stamp: EditTime| if stamp.is_none() { 1.0 } else { options.share(stamp.0, time) };
            if times.iter().all(|stamp| share(*stamp) >= 1.0) {
                return None;
            }
            let (mut values, from) = (element.held(field)?, element.held(edited)?);
            if values.len() != times.len() || from.len() != times.len() {
                return None;
            }
            let left = left.of(element, stamps.topology());
            for (k, ((value, from), stamp)) in values.iter_mut().zip(&from).zip(&times).enumerate() {
                let share = share(*stamp);
                if share < 1.0 {
                    *value = match left {
                        _ if share <= 0.0 => blank,
                        Some(left) => left[k],
                        None => T::nearest(blank.value() + (from.value() - blank.value()) * share),
                    };
                }
            }
            Some((element, values, from, times))
        });
        faded.into_iter().flatten().collect()
    }

    /// Brings the values of `channel` to what is left of them at `time`, which never goes back. Returns the faces that
    /// look different, and the faces that were given back.
    ///
    /// # Errors
    /// Fails if a page of the channel cannot be read or written.
    #[inline(never)]
    pub fn fade(&mut self, context: &Context, channel: &mut TriangleChannel<T>, time: f64) -> Result<FadeReport> {
        let topology = self.topology();
        self.follow(context, channel.field())?;
        let mut faded = self.faded(context, channel.field(), time);
        let change = Element::change(faded.iter().map(|(element, ..)| *element));
        channel.write(listed(faded.iter_mut().map(|(element, values, ..)| (*element, std::mem::take(values)))))?;
        // What has faded is done with.
        let blank = channel.field().blank();
        for (_, _, from, times) in &mut faded {
            for (from, stamp) in from.iter_mut().zip(times) {
                if !stamp.is_none() && self.options.share(stamp.0, time) <= 0.0 {
                    (*stamp, *from) = (EditTime::NONE, blank);
                }
            }
        }
        self.edited.write(listed(faded.iter_mut().map(|(element, _, from, _)| (*element, std::mem::take(from)))))?;
        self.stamps.write(listed(faded.into_iter().map(|(element, _, _, times)| (element, times))))?;
        let mut changed = change.faces_shown(&topology);
        let done = self.stamps.reclaim(context, &changed)?;
        let sets = TriangleSets { deallocate: done, ..Default::default() };
        self.edited.apply(context, self.edited.field().pattern(), &sets)?;
        // With the neighbours that were there for its sake.
        let near = TriangleChange {
            vertices: changed.iter().flat_map(|face| topology.face(*face)).collect(),
            ..Default::default()
        };
        let freed = channel.reclaim(context, &near.faces_shown(&topology))?;
        let around = TriangleChange {
            edges: freed.iter().flat_map(|face| topology.edges_of(*face)).collect(),
            ..Default::default()
        };
        changed.extend(around.faces_shown(&topology));
        changed.sort_unstable();
        changed.dedup();
        self.age(&changed, channel.field());
        Ok(FadeReport { changed, freed })
    }

    /// As [`Self::fade`] without giving anything back, so that stamps stay what they are: after stamps, and the blocks
    /// `restored` of the channel, were put back, which may be those of another time. Returns the faces that look
    /// different.
    ///
    /// # Errors
    /// Fails if a page of the channel cannot be read or written.
    #[inline(never)]
    pub fn bring(
        &mut self,
        context: &Context,
        channel: &mut TriangleChannel<T>,
        time: f64,
        restored: &[u32],
    ) -> Result<Vec<u32>> {
        let topology = self.topology();
        channel.mend_around(context, restored)?;
        self.follow(context, channel.field())?;
        let faded = self.faded(context, channel.field(), time);
        let left = Element::change(faded.iter().map(|(element, ..)| *element));
        let mut shown = left.faces_shown(&topology);
        channel.write(listed(faded.into_iter().map(|(element, values, ..)| (element, values))))?;
        // A vertex or an edge that is not blank would drag along a face that was given back since.
        let mut change = TriangleBlock::change(&topology, restored.iter().copied());
        shown.extend(change.faces_shown(&topology));
        let field = channel.field();
        change.vertices.retain(|vertex| !field.vertex(*vertex).is_blank(field.blank()));
        let around = change.vertices.iter().flat_map(|vertex| topology.faces_around(*vertex)).map(|(face, _)| face);
        let bare = around.filter(|face| !field.is_allocated(*face)).map(|face| (face, field.pattern())).collect();
        let edges: BTreeSet<u32> = left.edges.into_iter().chain(change.edges).collect();
        channel.without_budget(|channel| {
            channel.give_blank(context, &bare)?;
            channel.mend_faces(context, &edges)
        })?;
        self.age(&shown, channel.field());
        Ok(shown)
    }

    #[inline(never)]
    fn deallocate(&mut self, context: &Context, faces: &[u32]) -> Result<()> {
        let sets = TriangleSets { deallocate: faces.to_vec(), ..Default::default() };
        let pattern = self.stamps.field().pattern();
        self.stamps.apply(context, pattern, &sets)?;
        self.edited.apply(context, pattern, &sets).map(drop)
    }

    /// The numbers of the blocks that hold stamps, ascending.
    pub fn stamped(&self) -> Vec<u32> {
        self.stamps.blocks()
    }

    /// The blocks whose stamps changed since this was called last, ascending.
    pub fn take_changed(&mut self) -> Vec<u32> {
        let topology = self.topology();
        let mut blocks = self.stamps.commit().changed().blocks(&topology);
        blocks.extend(self.edited.commit().changed().blocks(&topology));
        blocks.sort_unstable();
        blocks.dedup();
        blocks
    }

    /// The stamps of a block as bytes: all values, then all stamps; `None` without stamps.
    pub fn read(&self, block: u32) -> Option<Vec<u8>> {
        stamped_bytes(self.edited.field(), self.stamps.field(), block)
    }

    /// Puts back what [`Self::read`] gave.
    ///
    /// # Errors
    /// Fails if there is no such block, the bytes are not those of one, a number is not finite, or the budget does not
    /// allow it.
    #[inline(never)]
    pub fn write(&mut self, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        let each = size_of::<T>() + size_of::<EditTime>();
        if let Some(bytes) = bytes.filter(|bytes| bytes.len() % each != 0) {
            let what = format!("stamps of {} bytes cannot be put back", bytes.len());
            return Err(Error::invalid(what).at(format!("block {block}")));
        }
        let both = bytes.map(|bytes| bytes.split_at(bytes.len() / each * size_of::<T>()));
        self.stamps.write_block(block, both.map(|(_, stamps)| stamps))?;
        self.torn.push(block);
        let edited = self.edited.write_block(block, both.map(|(values, _)| values));
        if edited.is_err() {
            self.stamps.write_block(block, None)?;
        }
        edited
    }

    /// As [`Self::write`], whatever the budget says.
    ///
    /// # Errors
    /// Fails as [`Self::write`], but for the budget.
    #[inline(never)]
    pub fn restore(&mut self, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        let budgets = (self.edited.budget(), self.stamps.budget());
        self.edited.set_budget(u64::MAX);
        self.stamps.set_budget(u64::MAX);
        let done = self.write(block, bytes);
        self.edited.set_budget(budgets.0);
        self.stamps.set_budget(budgets.1);
        done
    }

    /// What documents say of the stamps of a channel, the layer `layer`.
    pub fn head(&self, layer: u32) -> Stamps {
        let DecayOptions { delay, duration } = self.options;
        Stamps { layer, texel: T::KIND, delay, duration }
    }

    /// The stamps as histories and documents see them.
    pub fn blocks(&self) -> TriangleStamps<T> {
        let blank = [bytemuck::bytes_of(&T::zeroed()), &PERMANENT.to_le_bytes()].concat();
        TriangleStamps { edited: self.edited.field().clone(), stamps: self.stamps.field().clone(), blank }
    }

    /// The stamps that `document` has as the layer called `name`, for a channel that is `field` now, in `budget` bytes.
    ///
    /// # Errors
    /// Fails if there is no such layer of these values, it is damaged, or `budget` is too small.
    #[inline(never)]
    pub fn stored(
        context: &Context,
        document: &Document,
        name: &str,
        field: &TriangleField<T>,
        budget: u64,
    ) -> Result<Self> {
        let place = |error: Error| error.at(format!("layer `{name}`"));
        let layer = document.layer(name).ok_or_else(|| place(Error::invalid("there is no such layer")))?;
        let stamps = layer.head().stamps.filter(|stamps| stamps.texel == T::KIND);
        let stamps = stamps.ok_or_else(|| place(Error::invalid("its times are those of other texels")))?;
        let Stamps { delay, duration, .. } = stamps;
        let mut decay = Self::new(field, DecayOptions { delay, duration }, budget)?;
        let unpacked = context.map(layer.blocks().len(), |at| layer.unpack(document.topology(), at));
        for (block, bytes) in layer.blocks().iter().zip(unpacked) {
            decay.write(block.tile(), Some(&bytes?)).map_err(place)?;
        }
        Ok(decay)
    }
}

/// The stamps of a channel over triangles at one moment, with the values they belong to.
#[derive(Clone, Debug)]
pub struct TriangleStamps<T> {
    edited: TriangleField<T>,
    stamps: TriangleField<EditTime>,
    blank: Vec<u8>,
}

/// All values of a block and then all stamps, if it holds a stamp.
fn stamped_bytes<T: Texel>(edited: &TriangleField<T>, stamps: &TriangleField<EditTime>, block: u32) -> Option<Vec<u8>> {
    let block = TriangleBlock::of(stamps.topology(), block)?;
    let stamps = stamps.held(block)?;
    let values = match block {
        TriangleBlock::Face(face) => edited.face(face),
        TriangleBlock::Edge(edge) => edited.edge(edge),
        TriangleBlock::Vertices(chunk) => edited.chunk(chunk),
    };
    let values = values.filter(|values| values.len() == stamps.len())?;
    Some([bytemuck::cast_slice::<T, u8>(values), bytemuck::cast_slice::<EditTime, u8>(stamps)].concat())
}

impl<T: StoredTexel> Blocks for TriangleStamps<T> {
    fn kind(&self) -> Kind {
        Kind::Stamps
    }

    fn blank(&self) -> &[u8] {
        &self.blank
    }

    fn face_sizes(&self) -> Vec<u32> {
        self.edited.face_sizes()
    }

    fn bytes(&self, block: u32) -> Option<Cow<'_, [u8]>> {
        stamped_bytes(&self.edited, &self.stamps, block).map(Cow::Owned)
    }

    fn numbers(&self) -> Vec<u32> {
        self.stamps.blocks()
    }

    fn changed(&self, other: &dyn Blocks) -> Vec<u32> {
        let any: &dyn Any = other;
        let blocks: BTreeSet<u32> = match any.downcast_ref::<Self>() {
            Some(other) => {
                let topology = self.stamps.topology();
                let edited = self.edited.changes(&other.edited).blocks(topology);
                edited.into_iter().chain(self.stamps.changes(&other.stamps).blocks(topology)).collect()
            }
            None => self.numbers().into_iter().chain(other.numbers()).collect(),
        };
        blocks.into_iter().filter(|block| self.bytes(*block) != other.bytes(*block)).collect()
    }

    fn is_shaped_as(&self, other: &dyn Blocks) -> bool {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>().is_some_and(|other| self.edited.is_shaped_as(&other.edited))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texel::{ColorTexel, Rgba8};
    use crate::triangle::shapes;
    use glam::Vec4;
    use half::f16;

    const TIMES: DecayOptions = DecayOptions { delay: 1.0, duration: 2.0 };

    fn channel() -> TriangleChannel {
        shapes::channel(16, 1 << 20)
    }

    /// Fills faces with numbers, and the vertices that all have a block around.
    fn edit(context: &Context, channel: &mut TriangleChannel, segments: u32, faces: &[u32], seed: u64) {
        let pattern = Pattern::new(segments).unwrap();
        channel.apply(context, pattern, &shapes::sets(faces)).unwrap();
        shapes::fill(channel, shapes::random(seed));
    }

    #[test]
    fn what_was_edited_fades_linearly_and_gives_all_bytes_back() {
        let context = Context::serial();
        let mut channel = channel();
        let mut decay = TriangleDecay::new(channel.field(), TIMES, 1 << 20).unwrap();
        let (bytes, stamped) = (channel.bytes(), decay.bytes());
        let vertices = channel.field().topology().vertex_count() as u64;
        assert_eq!(stamped, vertices * 6);
        let start = channel.field().clone();
        edit(&context, &mut channel, 16, &[0, 1, 4], 3);
        assert!(decay.stamp(&context, &start, &channel, 10.0).unwrap().is_empty());
        let edges = channel.field().allocated_edges().count() as u64;
        assert_eq!(decay.bytes(), stamped + 6 * (3 * 169 + 15 * edges));
        let edited = channel.field().clone();
        let sum = |field: &TriangleField| -> f64 {
            let blocks = field.allocated().filter_map(|face| field.face(face));
            let edges = field.allocated_edges().filter_map(|edge| field.edge(edge));
            blocks.chain(edges).chain(field.vertices()).flatten().map(|value| f64::from(value.to_f32())).sum()
        };
        let whole = sum(&edited);
        for (time, left) in [(10.5, 1.0), (11.0, 1.0), (11.5, 0.75), (12.25, 0.375), (12.9, 0.05)] {
            decay.fade(&context, &mut channel, time).unwrap();
            let share = sum(channel.field()) / whole;
            assert!((share - left).abs() < 2e-3, "{time}: {share} {left}");
        }
        let faded = decay.fade(&context, &mut channel, 13.0).unwrap();
        assert_eq!(faded.freed, [0, 1, 4]);
        assert_eq!((channel.bytes(), decay.bytes()), (bytes, stamped));
        assert!(channel.field().blocks().is_empty() && decay.stamped().is_empty());
    }

    #[test]
    fn the_latest_edit_wins_and_what_was_there_before_stays() {
        let context = Context::serial();
        let mut channel = channel();
        edit(&context, &mut channel, 16, &[0, 7], 5);
        let old = channel.field().clone();
        let mut decay = TriangleDecay::new(channel.field(), TIMES, 1 << 20).unwrap();
        let mut block = old.face(7).unwrap().to_vec();
        block[3] = f16::from_f32(8.0);
        let write = |channel: &mut TriangleChannel, block: &[f16]| {
            channel.write(TriangleValues { faces: vec![(7, block.to_vec())], ..Default::default() }).unwrap();
        };
        write(&mut channel, &block);
        decay.stamp(&context, &old, &channel, 0.0).unwrap();
        let between = channel.field().clone();
        block[4] = f16::from_f32(-8.0);
        write(&mut channel, &block);
        decay.stamp(&context, &between, &channel, 1.0).unwrap();
        decay.fade(&context, &mut channel, 2.0).unwrap();
        let value = |channel: &TriangleChannel, at: usize| channel.field().face(7).unwrap()[at].to_f32();
        assert_eq!([value(&channel, 3), value(&channel, 4)], [4.0, -8.0]);
        decay.fade(&context, &mut channel, 9.0).unwrap();
        assert_eq!([value(&channel, 3), value(&channel, 4)], [0.0, 0.0]);
        assert!(decay.stamped().is_empty());
        for (at, then) in old.face(7).unwrap().iter().enumerate().filter(|(at, _)| ![3, 4].contains(at)) {
            assert_eq!(channel.field().face(7).unwrap()[at], *then);
        }
        assert_eq!(channel.field().face(0), old.face(0));
    }

    #[test]
    fn what_is_stamped_on_an_edge_or_at_a_vertex_fades_nothing_beside_it() {
        let context = Context::serial();
        let mut channel = channel();
        let all: Vec<u32> = (0..channel.field().topology().face_count() as u32).collect();
        edit(&context, &mut channel, 16, &all, 5);
        let old = channel.field().clone();
        let topology = old.topology().clone();
        let edge = (0..topology.edge_count() as u32).find(|edge| topology.faces_along(*edge).len() == 2).unwrap();
        let beside: Vec<u32> = topology.faces_along(edge).map(|(face, _)| face).collect();
        let vertex = (0..topology.vertex_count() as u32).find(|vertex| !topology.edge(edge).contains(vertex)).unwrap();
        let around: Vec<u32> = topology.faces_around(vertex).map(|(face, _)| face).collect();
        let mut decay = TriangleDecay::new(channel.field(), TIMES, 1 << 20).unwrap();
        let eight = f16::from_f32(8.0);
        let (edges, vertices) = (vec![(edge, vec![eight; 15])], vec![(vertex, eight)]);
        channel.write(TriangleValues { edges, vertices, ..Default::default() }).unwrap();
        decay.stamp(&context, &old, &channel, 0.0).unwrap();
        assert!(beside.iter().chain(&around).all(|face| decay.stamps().is_allocated(*face)));
        // Later edits beside them find nothing stamped there.
        for face in beside.into_iter().chain(around) {
            let between = channel.field().clone();
            let mut block = between.face(face).unwrap().to_vec();
            block[3] = eight;
            channel.write(TriangleValues { faces: vec![(face, block)], ..Default::default() }).unwrap();
            decay.stamp(&context, &between, &channel, 0.5).unwrap();
        }
        decay.fade(&context, &mut channel, 9.0).unwrap();
        let field = channel.field();
        assert!(field.edge(edge).unwrap().iter().chain([&field.vertex(vertex)]).all(|value| *value == f16::ZERO));
        for face in all {
            let faded = |at: usize| field.face(face).unwrap()[at] != old.face(face).unwrap()[at];
            assert!((0..169).filter(|at| *at != 3).all(|at| !faded(at)), "face {face}");
        }
    }

    #[test]
    fn a_fade_in_steps_and_from_what_was_read_is_that_in_one() {
        let context = Context::serial();
        let topology = channel().field().topology().clone();
        let options = TriangleOptions { segments: 32, budget: 1 << 20 };
        let grey = Vec4::new(0.2, 0.2, 0.2, 1.0);
        let mut one = TriangleChannel::<Rgba8>::of_color(topology, grey, &options).unwrap();
        let mut first = TriangleDecay::new(one.field(), TIMES, 1 << 20).unwrap();
        let start = one.field().clone();
        one.apply(&context, Pattern::new(8).unwrap(), &shapes::sets(&[2, 3])).unwrap();
        let red = Rgba8::of_color(Vec4::new(0.9, 0.1, 0.0, 1.0));
        let values = TriangleValues { faces: vec![(2, vec![red; 37])], vertices: vec![(3, red)], ..Default::default() };
        one.write(values).unwrap();
        first.stamp(&context, &start, &one, 0.0).unwrap();
        // A finer edit finds stamped values between.
        let between = one.field().clone();
        one.apply(&context, Pattern::new(32).unwrap(), &shapes::sets(&[2])).unwrap();
        first.stamp(&context, &between, &one, 0.5).unwrap();
        let (mut two, mut second) = (one.clone(), TriangleDecay::new(one.field(), TIMES, 1 << 20).unwrap());
        for block in first.stamped() {
            second.write(block, first.read(block).as_deref()).unwrap();
        }
        assert_eq!((second.stamped(), second.bytes()), (first.stamped(), first.bytes()));
        for time in [1.2, 1.5, 2.0, 2.25] {
            first.fade(&context, &mut one, time).unwrap();
        }
        second.fade(&context, &mut two, 2.25).unwrap();
        let all = |channel: &TriangleChannel<Rgba8>| -> Vec<_> {
            channel.blocks().into_iter().map(|block| channel.read(block).unwrap()).collect()
        };
        assert_eq!(one.blocks(), two.blocks());
        for (one, two) in all(&one).into_iter().zip(all(&two)) {
            assert_eq!(one, two);
        }
        assert!(all(&one).len() > 4);
        first.fade(&context, &mut one, 4.0).unwrap();
        assert!(one.blocks().is_empty(), "{:?}", one.blocks());
        assert!(second.write(0, Some(&[0; 7])).is_err() && second.write(u32::MAX, None).is_err());
        assert!(second.write(0, Some(&[0xff; 8 * 37])).is_err());
    }

    #[test]
    fn what_the_budget_refuses_stays() {
        let context = Context::serial();
        let mut channel = channel();
        let vertices = channel.field().topology().vertex_count() as u64;
        let mut decay = TriangleDecay::new(channel.field(), TIMES, 6 * (vertices + 169 + 45)).unwrap();
        let start = channel.field().clone();
        edit(&context, &mut channel, 16, &[0, 7, 12], 9);
        let refused = decay.stamp(&context, &start, &channel, 0.0).unwrap();
        assert_eq!(refused, [7, 12]);
        let edited = channel.field().clone();
        decay.fade(&context, &mut channel, 99.0).unwrap();
        assert!(channel.field().face(0).is_none_or(|block| block.iter().all(|value| value.to_f32() == 0.0)));
        assert_eq!(channel.field().face(7), edited.face(7));
        assert!(TriangleDecay::new(channel.field(), TIMES, 6 * vertices - 1).is_err());
        assert!(TriangleDecay::new(channel.field(), DecayOptions { delay: 0.0, duration: 0.0 }, 1 << 20).is_err());
    }
}
