//! Edits of a triangle mesh that fade: every value that is edited gets a time stamp, and what was put there goes
//! linearly back to what is blank.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 7.2, as
//! on tiles, see [`crate::decay`]. The edited values and their stamps are two channels more over the same triangles, so
//! that what a finer pattern finds between stamped values is stamped too. Bytes: those of [`super::channel`] for values
//! and for stamps of 8 bytes, of the faces that hold a stamp. Units: seconds.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_surface::TriangleTopology;

use super::allocation::values_of;
use super::block::TriangleBlock;
use super::change::{TriangleChange, TriangleSets, TriangleValues};
use super::channel::{TriangleChannel, TriangleOptions};
use super::field::{TriangleClass, TriangleField};
use super::pattern::Pattern;
use crate::blocks::Blocks;
use crate::decay::{DecayOptions, Faded};
use crate::stored::StoredTexel;
use crate::texel::Texel;

/// When a value was edited.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Stamp {
    /// 1 where it was, 0 where it does not fade; between them where stamps are interpolated.
    pub share: f32,
    /// When, in seconds, times the share.
    pub moment: f32,
}

impl Stamp {
    fn at(time: f64) -> Self {
        Self { share: 1.0, moment: time as f32 }
    }

    fn time(self) -> Option<f32> {
        (self.share > 0.0).then(|| self.moment / self.share)
    }
}

impl Texel for Stamp {
    type Value = DVec3;
    type Difference = Self;

    fn value(self) -> DVec3 {
        DVec3::new(f64::from(self.share), f64::from(self.moment), 0.0)
    }

    fn nearest(value: DVec3) -> Self {
        Self { share: value.x as f32, moment: value.y as f32 }
    }

    fn flipped(self) -> Self {
        self
    }

    fn all_finite(texels: &[Self]) -> bool {
        texels.iter().all(|stamp| stamp.share.is_finite() && stamp.moment.is_finite())
    }
}

/// The stamps of a channel over triangles.
#[derive(Debug)]
pub struct TriangleDecay<T> {
    options: DecayOptions,
    /// The values as they were edited.
    edited: TriangleChannel<T>,
    stamps: TriangleChannel<Stamp>,
}

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
    /// No stamps yet, for a channel; values and stamps may occupy `budget` bytes each. Fails if the times are none, or
    /// the budget does not hold the vertices.
    pub fn new(channel: &TriangleChannel<T>, options: DecayOptions, budget: u64) -> Result<Self> {
        options.check()?;
        let field = channel.field();
        let sizes = TriangleOptions { segments: field.pattern().segments(), budget };
        let edited = TriangleChannel::blank(field.topology().clone(), field.blank(), &sizes)?;
        let stamps = TriangleChannel::blank(field.topology().clone(), Stamp::default(), &sizes)?;
        Ok(Self { options, edited, stamps })
    }

    /// When edits fade.
    pub fn options(&self) -> DecayOptions {
        self.options
    }

    /// Bytes of the stamps and the values they belong to.
    pub fn bytes(&self) -> u64 {
        self.edited.bytes() + self.stamps.bytes()
    }

    /// The stamps as they are.
    pub fn stamps(&self) -> &TriangleField<Stamp> {
        self.stamps.field()
    }

    fn topology(&self) -> Arc<TriangleTopology> {
        self.stamps.field().topology().clone()
    }

    /// Stamps with `time` all values in which `channel` now differs from `before`. Returns the faces, ascending, that
    /// the budget refused; what was edited there stays.
    pub fn stamp(
        &mut self,
        context: &Context,
        before: &TriangleField<T>,
        channel: &TriangleChannel<T>,
        time: f64,
    ) -> Result<Vec<u32>> {
        let (topology, after) = (self.topology(), channel.field());
        let gone = |face: &u32| self.stamps.field().face_pattern(*face) > after.face_pattern(*face);
        let gone: Vec<u32> = self.stamps.field().allocated().filter(gone).collect();
        self.deallocate(context, gone)?;
        let mut change = TriangleBlock::change(&topology, after.changed(before));
        change.vertices.retain(|vertex| !after.vertex(*vertex).same(before.vertex(*vertex)));
        let mut faces: Vec<u32> = change.faces.iter().copied().filter(|face| after.is_allocated(*face)).collect();
        let held =
            |edge: &u32| topology.faces_along(*edge).map(|(face, _)| face).find(|face| after.is_allocated(*face));
        faces.extend(change.edges.iter().filter_map(held));
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
        let stamped = context.map(elements.len(), |index| {
            let element = elements[index];
            let (new, old) = (element.held(after)?, element.read(before, after)?);
            let (mut values, mut times) = (element.held(edited)?, element.held(stamps)?);
            // Where the budget refused, the patterns are others.
            if values.len() != new.len() || times.len() != new.len() {
                return None;
            }
            for (at, (new, old)) in new.iter().zip(&old).enumerate() {
                if !new.same(*old) {
                    (values[at], times[at]) = (*new, Stamp::at(time));
                } else if times[at].share == 0.0 && !matches!(element, Element::Vertex(_)) {
                    // For what a finer pattern finds between it and what is stamped.
                    values[at] = *new;
                }
            }
            Some((element, values, times))
        });
        let stamped: Vec<_> = stamped.into_iter().flatten().collect();
        self.edited.write(listed(stamped.iter().map(|(element, values, _)| (*element, values.clone()))))?;
        self.stamps.write(listed(stamped.into_iter().map(|(element, _, times)| (element, times))))?;
        Ok(refused)
    }

    /// Brings the values of `channel` to what is left of them at `time`, which never goes back. Returns the faces that
    /// look different, and those that were given back.
    pub fn fade(&mut self, context: &Context, channel: &mut TriangleChannel<T>, time: f64) -> Result<Faded> {
        let topology = self.topology();
        let gone = |face: &u32| self.stamps.field().face_pattern(*face) > channel.field().face_pattern(*face);
        let gone: Vec<u32> = self.stamps.field().allocated().filter(gone).collect();
        self.deallocate(context, gone)?;
        let (field, edited, stamps) = (channel.field(), self.edited.field(), self.stamps.field());
        let mut held = TriangleBlock::change(&topology, stamps.blocks());
        held.vertices.retain(|vertex| stamps.vertex(*vertex).share > 0.0);
        let elements = Element::of(&held);
        let (options, blank) = (self.options, field.blank());
        let faded = context.map(elements.len(), |index| {
            let element = elements[index];
            let (mut values, mut from, mut times) =
                (element.held(field)?, element.held(edited)?, element.held(stamps)?);
            if values.len() != times.len() || from.len() != times.len() {
                return None;
            }
            let mut any = false;
            for (at, stamp) in times.iter_mut().enumerate() {
                let share = stamp.time().map_or(1.0, |stamp| options.share(stamp, time));
                if share < 1.0 {
                    any = true;
                    let (low, high) = (blank.value(), from[at].value());
                    values[at] = if share > 0.0 { T::nearest(low + (high - low) * share) } else { blank };
                }
                if share <= 0.0 {
                    (*stamp, from[at]) = (Stamp::default(), blank);
                }
            }
            any.then_some((element, values, from, times))
        });
        let faded: Vec<_> = faded.into_iter().flatten().collect();
        let mut change = TriangleChange::default();
        for (element, ..) in &faded {
            match element {
                Element::Face(face) => change.faces.push(*face),
                Element::Edge(edge) => change.edges.push(*edge),
                Element::Vertex(vertex) => change.vertices.push(*vertex),
            }
        }
        channel.write(listed(faded.iter().map(|(element, values, ..)| (*element, values.clone()))))?;
        self.edited.write(listed(faded.iter().map(|(element, _, from, _)| (*element, from.clone()))))?;
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
        Ok(Faded { changed, freed })
    }

    fn deallocate(&mut self, context: &Context, faces: Vec<u32>) -> Result<()> {
        let sets = TriangleSets { deallocate: faces, ..Default::default() };
        let pattern = self.stamps.field().pattern();
        self.stamps.apply(context, pattern, &sets)?;
        self.edited.apply(context, pattern, &sets).map(drop)
    }

    /// The numbers of the blocks that hold stamps, ascending.
    pub fn blocks(&self) -> Vec<u32> {
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

    /// The stamps of a block as bytes: all values, then all stamps; `None` if there are none. Fails if there is no such
    /// block.
    pub fn read(&self, block: u32) -> Result<Option<Vec<u8>>> {
        let Some(stamps) = self.stamps.read(block)? else { return Ok(None) };
        let field = self.edited.field();
        let values = match TriangleBlock::of(field.topology(), block) {
            Some(TriangleBlock::Face(face)) => field.face(face),
            Some(TriangleBlock::Edge(edge)) => field.edge(edge),
            Some(TriangleBlock::Vertices(chunk)) => field.chunk(chunk),
            None => None,
        };
        let mut bytes = bytemuck::cast_slice::<T, u8>(values.unwrap_or(&[])).to_vec();
        bytes.extend(stamps);
        Ok(Some(bytes))
    }

    /// Puts back what [`Self::read`] gave. Fails if there is no such block, the bytes are not those of one, a number is
    /// not finite, or the budget does not allow it.
    pub fn write(&mut self, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        let Some(bytes) = bytes else {
            self.stamps.write_block(block, None)?;
            return self.edited.write_block(block, None);
        };
        let each = size_of::<T>() + size_of::<Stamp>();
        if bytes.len() % each != 0 {
            let what = format!("stamps of {} bytes cannot be put back", bytes.len());
            return Err(Error::invalid(what).at(format!("block {block}")));
        }
        let (values, stamps) = bytes.split_at(bytes.len() / each * size_of::<T>());
        self.edited.write_block(block, Some(values))?;
        self.stamps.write_block(block, Some(stamps))
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
        let mut decay = TriangleDecay::new(&channel, TIMES, 1 << 20).unwrap();
        let (bytes, stamped) = (channel.bytes(), decay.bytes());
        let vertices = channel.field().topology().vertex_count() as u64;
        assert_eq!(stamped, vertices * 10);
        let start = channel.field().clone();
        edit(&context, &mut channel, 16, &[0, 1, 4], 3);
        assert!(decay.stamp(&context, &start, &channel, 10.0).unwrap().is_empty());
        let edges = channel.field().allocated_edges().count() as u64;
        assert_eq!(decay.bytes(), stamped + 10 * (3 * 169 + 15 * edges));
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
        assert!(channel.field().blocks().is_empty() && decay.blocks().is_empty());
    }

    #[test]
    fn the_latest_edit_wins_and_what_was_there_before_stays() {
        let context = Context::serial();
        let mut channel = channel();
        edit(&context, &mut channel, 16, &[0, 7], 5);
        let old = channel.field().clone();
        let mut decay = TriangleDecay::new(&channel, TIMES, 1 << 20).unwrap();
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
        assert!(decay.blocks().is_empty());
        for (at, then) in old.face(7).unwrap().iter().enumerate().filter(|(at, _)| ![3, 4].contains(at)) {
            assert_eq!(channel.field().face(7).unwrap()[at], *then);
        }
        assert_eq!(channel.field().face(0), old.face(0));
    }

    #[test]
    fn a_fade_in_steps_and_from_what_was_read_is_that_in_one() {
        let context = Context::serial();
        let topology = channel().field().topology().clone();
        let options = TriangleOptions { segments: 32, budget: 1 << 20 };
        let grey = Vec4::new(0.2, 0.2, 0.2, 1.0);
        let mut one = TriangleChannel::<Rgba8>::of_color(topology, grey, &options).unwrap();
        let mut first = TriangleDecay::new(&one, TIMES, 1 << 20).unwrap();
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
        let (mut two, mut second) = (one.clone(), TriangleDecay::new(&one, TIMES, 1 << 20).unwrap());
        for block in first.blocks() {
            second.write(block, first.read(block).unwrap().as_deref()).unwrap();
        }
        assert_eq!((second.blocks(), second.bytes()), (first.blocks(), first.bytes()));
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
        assert!(second.write(0, Some(&[0xff; 12 * 37])).is_err());
    }

    #[test]
    fn what_the_budget_refuses_stays() {
        let context = Context::serial();
        let mut channel = channel();
        let vertices = channel.field().topology().vertex_count() as u64;
        let mut decay = TriangleDecay::new(&channel, TIMES, 8 * (vertices + 169 + 45)).unwrap();
        let start = channel.field().clone();
        edit(&context, &mut channel, 16, &[0, 7, 12], 9);
        let refused = decay.stamp(&context, &start, &channel, 0.0).unwrap();
        assert_eq!(refused, [7, 12]);
        let edited = channel.field().clone();
        decay.fade(&context, &mut channel, 99.0).unwrap();
        assert!(channel.field().face(0).is_none_or(|block| block.iter().all(|value| value.to_f32() == 0.0)));
        assert_eq!(channel.field().face(7), edited.face(7));
        assert!(TriangleDecay::new(&channel, TIMES, 8 * vertices - 1).is_err());
        assert!(TriangleDecay::new(&channel, DecayOptions { delay: 0.0, duration: 0.0 }, 1 << 20).is_err());
    }
}
