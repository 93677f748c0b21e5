//! The values of a triangle mesh at one moment: at every vertex, and on the edges and in the faces that have a block.
//!
//! A face with a block has one on each of its edges, at least as fine; a face without one reads as what its corners and
//! edges say. So what is read is continuous over the whole mesh, whichever faces have blocks and how fine they are:
//!
//! - along an edge, linear between its values, or between its ends if it has none;
//! - in a face with a block, linear in the triangles of the pattern (Schäfer et al. 2012, Multiresolution Attributes
//!   for Tessellated Meshes); beside an edge that is finer than the face, what that edge has more fades out over the
//!   outermost strip of the pattern;
//! - in a face without a block, linear between the corners, and what an edge differs from that by fades out toward the
//!   opposite corner, as in a fan of triangles from there. Edits give all faces of an edge that they change blocks,
//!   so that this is nothing unless values were written without.
//!
//! Copies share what is not written afterwards. Units: those of the values.

use std::sync::Arc;

use half::f16;
use relievo_surface::{TriangleSide, TriangleTopology};

use super::block::TriangleBlock;
use super::pattern::{Node, Pattern, Slot};
use crate::store::heap::{BlockId, Class};
use crate::store::pages::CowBlocks;
use crate::store::slot::{self, Pager};
use crate::texel::Texel;

/// A kind and size of block: the inside of an edge or of a face of a pattern whose segments are a power of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TriangleClass {
    /// Whether it is that of a face.
    pub face: bool,
    /// The pattern.
    pub pattern: Pattern,
}

impl Class for TriangleClass {
    const COUNT: usize = 12;

    fn index(self) -> usize {
        2 * (self.pattern.segments().ilog2() as usize - 1) + usize::from(self.face)
    }

    fn values(self) -> usize {
        if self.face { self.pattern.face_values() } else { self.pattern.edge_values() }
    }

    /// A closed mesh has one and a half times as many edges as faces, a part of it more.
    fn group(self) -> usize {
        if self.face { 64 } else { 128 }
    }
}

/// The block of an edge or a face.
#[derive(Clone, Debug)]
pub(crate) struct Entry<T> {
    pub texels: slot::Slot<T>,
    pub id: BlockId<TriangleClass>,
    /// The number of the edit that last changed it.
    pub version: u64,
}

type Blocks<T> = CowBlocks<Entry<T>>;

/// Vertices that share a page.
pub(crate) const CHUNK: usize = 256;

/// Values on a triangle mesh, immutable where they are shared. Cloning is cheap.
#[derive(Clone, Debug)]
pub struct TriangleField<T = f16> {
    topology: Arc<TriangleTopology>,
    pattern: Pattern,
    blank: T,
    vertices: Vec<Arc<[T]>>,
    pub(crate) edges: Blocks<T>,
    pub(crate) faces: Blocks<T>,
    pub(crate) pager: Option<Arc<Pager>>,
}

impl<T: Texel> TriangleField<T> {
    /// A field without blocks, whose finest pattern is `pattern`, and which reads as `blank`.
    pub(crate) fn new(topology: Arc<TriangleTopology>, pattern: Pattern, blank: T) -> Self {
        let count = topology.vertex_count();
        let whole: Arc<[T]> = vec![blank; CHUNK].into();
        let chunk =
            |start: usize| if start + CHUNK <= count { whole.clone() } else { vec![blank; count - start].into() };
        Self {
            vertices: (0..count).step_by(CHUNK).map(chunk).collect(),
            edges: CowBlocks::new(topology.edge_count()),
            faces: CowBlocks::new(topology.face_count()),
            pager: None,
            topology,
            pattern,
            blank,
        }
    }

    /// How the triangles meet.
    pub fn topology(&self) -> &Arc<TriangleTopology> {
        &self.topology
    }

    /// The finest pattern a face can have.
    pub fn pattern(&self) -> Pattern {
        self.pattern
    }

    /// What is read where nothing was written.
    pub fn blank(&self) -> T {
        self.blank
    }

    pub(crate) fn blank_ref(&self) -> &T {
        &self.blank
    }

    /// The value at a vertex. Panics if there is no such vertex.
    pub fn vertex(&self, vertex: u32) -> T {
        self.vertices[vertex as usize / CHUNK][vertex as usize % CHUNK]
    }

    /// The values at the vertices, in runs.
    pub fn vertices(&self) -> impl Iterator<Item = &[T]> {
        self.vertices.iter().map(|chunk| &**chunk)
    }

    /// Vertices from `CHUNK` times a number on; `None` beyond the last one.
    pub(super) fn chunk(&self, number: u32) -> Option<&[T]> {
        self.vertices.get(number as usize).map(|chunk| &**chunk)
    }

    pub(crate) fn set_vertex(&mut self, vertex: u32, value: T) {
        let chunk = &mut self.vertices[vertex as usize / CHUNK];
        if Arc::get_mut(chunk).is_none() {
            *chunk = chunk[..].into();
        }
        if let Some(values) = Arc::get_mut(chunk) {
            values[vertex as usize % CHUNK] = value;
        }
    }

    /// The pattern of an edge, `None` if it has no block.
    pub fn edge_pattern(&self, edge: u32) -> Option<Pattern> {
        self.edges.entry(edge).map(|entry| entry.id.class.pattern)
    }

    /// The pattern of a face, `None` if it has no block.
    pub fn face_pattern(&self, face: u32) -> Option<Pattern> {
        self.faces.entry(face).map(|entry| entry.id.class.pattern)
    }

    /// Whether a face has a block.
    pub fn is_allocated(&self, face: u32) -> bool {
        self.faces.entry(face).is_some()
    }

    /// The values inside an edge, from its lower vertex to the other; `None` if it has no block.
    pub fn edge(&self, edge: u32) -> Option<&[T]> {
        self.edges.entry(edge).map(|entry| &*entry.texels)
    }

    /// The values inside a face, as [`Slot::Inside`] counts them; `None` if it has no block.
    pub fn face(&self, face: u32) -> Option<&[T]> {
        self.faces.entry(face).map(|entry| &*entry.texels)
    }

    /// What there is of a block of a face or an edge.
    pub(crate) fn block(&self, block: TriangleBlock) -> Option<&Entry<T>> {
        match block {
            TriangleBlock::Face(face) => self.faces.entry(face),
            TriangleBlock::Edge(edge) => self.edges.entry(edge),
            TriangleBlock::Vertices(_) => None,
        }
    }

    /// As [`Self::block`], for writing: what a face or an edge, which must exist, has; `None` for vertices.
    pub(crate) fn block_mut(&mut self, block: TriangleBlock) -> Option<&mut Option<Entry<T>>> {
        match block {
            TriangleBlock::Face(face) => Some(self.faces.entry_mut(face)),
            TriangleBlock::Edge(edge) => Some(self.edges.entry_mut(edge)),
            TriangleBlock::Vertices(_) => None,
        }
    }

    /// As [`Self::block`], by number.
    pub(crate) fn entry(&self, number: u32) -> Option<&Entry<T>> {
        self.block(TriangleBlock::of(&self.topology, number)?)
    }

    /// Whether a block of a face or an edge, by number, is there and on a page, see [`super::paging`].
    pub fn is_paged(&self, block: u32) -> bool {
        self.entry(block).is_some_and(|entry| entry.texels.is_paged())
    }

    /// The numbers of the blocks of faces and edges, ascending.
    pub(crate) fn all_blocks(&self) -> impl Iterator<Item = u32> {
        let faces = self.allocated().map(TriangleBlock::Face);
        let blocks = faces.chain(self.allocated_edges().map(TriangleBlock::Edge));
        blocks.map(|block| block.number(&self.topology))
    }

    /// The faces with a block, ascending.
    pub fn allocated(&self) -> impl Iterator<Item = u32> {
        self.faces.used()
    }

    /// The edges with a block, ascending.
    pub fn allocated_edges(&self) -> impl Iterator<Item = u32> {
        self.edges.used()
    }

    /// The number of the edit that last changed the block of `face`, 0 if it has none.
    pub fn version(&self, face: u32) -> u64 {
        self.faces.entry(face).map_or(0, |entry| entry.version)
    }

    /// The value at a vertex of the pattern of `face`, which has a block of that pattern or a finer one of powers of
    /// two.
    fn node(&self, face: u32, pattern: Pattern, node: Node) -> T {
        let (mut pattern, mut node) = (pattern, node);
        if let Slot::Inside(_) = pattern.slot(node) {
            while self.face_pattern(face).is_some_and(|own| own > pattern) {
                (pattern, node) = (pattern.finer(), pattern.refined(node));
            }
        }
        match pattern.slot(node) {
            Slot::Corner(corner) => self.vertex(self.topology.face(face)[corner as usize]),
            Slot::Side(side, step) => {
                let TriangleSide { edge, reversed } = self.topology.side(face, side);
                let step = if reversed { pattern.segments() - step } else { step };
                match (self.edge(edge), self.edge_pattern(edge)) {
                    (Some(block), Some(own)) if own >= pattern => {
                        block[(step * (own.segments() / pattern.segments())) as usize - 1]
                    }
                    // While blocks are put back one by one.
                    _ => T::nearest(self.on_edge(edge, step as f32 / pattern.segments() as f32)),
                }
            }
            Slot::Inside(index) => self.face(face).map_or(self.blank, |block| block[index as usize]),
        }
    }

    /// What is read on `edge`, `along` of the way from its lower vertex to the other. Panics if there is no such edge.
    pub fn on_edge(&self, edge: u32, along: f32) -> T::Value {
        match self.edges.entry(edge) {
            Some(entry) => self.on_segments(edge, &entry.texels, 1, along),
            None => self.on_segments(edge, &[], 1, along),
        }
    }

    /// Returns what is read on an edge, by the step from its lower vertex of `segments`, 1 to one less than these.
    pub(super) fn along(&self, edge: u32, segments: u32) -> impl Fn(u32) -> T::Value + '_ {
        let block = self.edge(edge).unwrap_or(&[]);
        let is_even = block.len() + 1 == segments as usize;
        move |step| match block.get((step as usize).wrapping_sub(1)) {
            Some(value) if is_even => value.value(),
            _ => self.on_segments(edge, block, 1, step as f32 / segments as f32),
        }
    }

    /// Returns what is read inside a face, by the number in `pattern`, see [`Slot::Inside`].
    pub(super) fn inside(&self, face: u32, pattern: Pattern) -> impl Fn(u32) -> T::Value + '_ {
        let block = self.face(face).filter(|block| block.len() == pattern.face_values()).unwrap_or(&[]);
        move |index| match block.get(index as usize) {
            Some(value) => value.value(),
            None => self.at(face, pattern, pattern.at_slot(Slot::Inside(index))),
        }
    }

    /// Linear between every `stride`-th value of an edge.
    fn on_segments(&self, edge: u32, block: &[T], stride: usize, along: f32) -> T::Value {
        let segments = (block.len() + 1) / stride;
        let ends = self.topology.edge(edge);
        let value = |step: usize| match step {
            0 => self.vertex(ends[0]),
            step if step == segments => self.vertex(ends[1]),
            step => block[step * stride - 1],
        };
        let x = along.clamp(0.0, 1.0) * segments as f32;
        let step = (x as usize).min(segments - 1);
        let part = x - step as f32;
        // Values themselves are exact.
        if part == 0.0 {
            return value(step).value();
        }
        let low = value(step).value();
        low + (value(step + 1).value() - low) * f64::from(part)
    }

    /// What is read on side `side` of `face`, `along` of the way from its first corner.
    fn on_side(&self, face: u32, side: u32, along: f32) -> T::Value {
        let TriangleSide { edge, reversed } = self.topology.side(face, side);
        self.on_edge(edge, if reversed { 1.0 - along } else { along })
    }

    /// What is read at the place of `face` with barycentric coordinates `at`. Panics if there is no such face.
    pub fn value(&self, face: u32, at: [f32; 3]) -> T::Value {
        if let Some(side) = (0..3).find(|side| at[(side + 2) % 3] == 0.0) {
            return self.on_side(face, side as u32, at[(side + 1) % 3]);
        }
        match self.face_pattern(face) {
            Some(pattern) => self.in_pattern(face, pattern, at),
            None => self.in_fans(face, at),
        }
    }

    fn in_pattern(&self, face: u32, pattern: Pattern, at: [f32; 3]) -> T::Value {
        let (nodes, shares) = pattern.locate(at);
        let terms = nodes.into_iter().zip(shares).filter(|(_, share)| *share != 0.0);
        let value: T::Value =
            terms.map(|(node, share)| self.node(face, pattern, node).value() * f64::from(share)).sum();
        // What a finer edge has more.
        let least = at[0].min(at[1]).min(at[2]);
        let depth = 1.5 * least * pattern.segments() as f32;
        if depth >= 1.0 {
            return value;
        }
        let side = (0..3).find(|side| at[(side + 2) % 3] == least).unwrap_or(0);
        let TriangleSide { edge, reversed } = self.topology.side(face, side as u32);
        let Some(entry) = self.edges.entry(edge) else { return value };
        let stride = (entry.texels.len() + 1) / pattern.segments() as usize;
        if stride <= 1 {
            return value;
        }
        let along = (at[(side + 1) % 3] + 0.5 * least) * pattern.segments() as f32;
        let along = (along - depth) / (pattern.segments() as f32 - 2.0 * depth);
        let along = if reversed { 1.0 - along } else { along };
        let fine = self.on_segments(edge, &entry.texels, 1, along);
        let coarse = self.on_segments(edge, &entry.texels, stride, along);
        value + (fine - coarse) * f64::from(1.0 - depth)
    }

    fn in_fans(&self, face: u32, at: [f32; 3]) -> T::Value {
        let corners = self.topology.face(face).map(|vertex| self.vertex(vertex).value());
        let mut value: T::Value = corners.iter().zip(at).map(|(corner, share)| *corner * f64::from(share)).sum();
        for side in 0..3 {
            let TriangleSide { edge, reversed } = self.topology.side(face, side as u32);
            let Some(entry) = self.edges.entry(edge) else { continue };
            let [a, b] = [at[side], at[(side + 1) % 3]];
            if a + b <= 0.0 {
                continue;
            }
            let along = b / (a + b);
            let along = if reversed { 1.0 - along } else { along };
            let stride = entry.texels.len() + 1;
            let fine = self.on_segments(edge, &entry.texels, 1, along);
            let straight = self.on_segments(edge, &entry.texels, stride, along);
            value = value + (fine - straight) * f64::from(a + b);
        }
        value
    }

    /// What is read at a vertex of any pattern laid over `face`, equal to the bit from all faces that have it.
    pub fn at(&self, face: u32, pattern: Pattern, node: Node) -> T::Value {
        match (pattern.slot(node), self.face_pattern(face)) {
            (Slot::Corner(corner), _) => self.vertex(self.topology.face(face)[corner as usize]).value(),
            (Slot::Side(side, step), _) => {
                let TriangleSide { edge, reversed } = self.topology.side(face, side);
                let step = if reversed { pattern.segments() - step } else { step };
                self.on_edge(edge, step as f32 / pattern.segments() as f32)
            }
            (Slot::Inside(_), Some(own)) if holds(own, pattern) => self.node(face, pattern, node).value(),
            (Slot::Inside(_), _) => self.value(face, barycentric(pattern, node)),
        }
    }

    /// The value at a vertex of any pattern laid over `face`, as it would be kept there.
    pub fn texel(&self, face: u32, pattern: Pattern, node: Node) -> T {
        match (pattern.slot(node), self.face_pattern(face)) {
            (Slot::Corner(corner), _) => self.vertex(self.topology.face(face)[corner as usize]),
            (_, Some(own)) if holds(own, pattern) => self.node(face, pattern, node),
            _ => T::nearest(self.at(face, pattern, node)),
        }
    }

    /// Whether all of a face, its edges and corners read as blank.
    pub fn is_blank(&self, face: u32) -> bool {
        let blank =
            |block: Option<&[T]>| block.is_none_or(|block| block.iter().all(|value| value.is_blank(self.blank)));
        self.topology.face(face).iter().all(|vertex| self.vertex(*vertex).is_blank(self.blank))
            && self.topology.edges_of(face).iter().all(|edge| blank(self.edge(*edge)))
            && blank(self.face(face))
    }
}

impl TriangleField {
    /// The least and the largest value of a block; `None` if it is not there. Reads no pages.
    pub fn range(&self, block: TriangleBlock) -> Option<[f32; 2]> {
        if let TriangleBlock::Vertices(chunk) = block {
            return self.chunk(chunk).map(f16::bound);
        }
        self.block(block).map(|entry| entry.texels.bound().unwrap_or_else(|| f16::bound(&entry.texels)))
    }
}

/// Whether the values of a pattern are among those of `own`.
fn holds(own: Pattern, pattern: Pattern) -> bool {
    own >= pattern && pattern.segments().is_power_of_two()
}

/// Barycentric coordinates of a vertex of a pattern.
pub(crate) fn barycentric(pattern: Pattern, node: Node) -> [f32; 3] {
    let unit = 1.0 / (3.0 * f64::from(pattern.segments()));
    pattern.weights(node).map(|weight| (f64::from(weight) * unit) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::shapes::{channel, fill, random, sets};
    use relievo_core::Context;

    #[test]
    fn what_is_read_in_a_triangle_of_the_pattern_is_the_mean_of_its_corners_by_barycentric_coordinates() {
        let context = Context::serial();
        let mut channel = channel(16, 1 << 20);
        let pattern = channel.field().pattern();
        channel.apply(&context, pattern, &sets(&[4, 5])).unwrap();
        fill(&mut channel, random(5));
        let field = channel.field();
        for triangle in pattern.triangles() {
            let corners = triangle.map(|node| field.at(4, pattern, node));
            for shares in [[1.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.25, 0.25, 0.5], [0.6, 0.3, 0.1f32]] {
                let mut at = [0.0; 3];
                for (node, share) in triangle.iter().zip(shares) {
                    let place = barycentric(pattern, *node);
                    (0..3).for_each(|axis| at[axis] += share * place[axis]);
                }
                let mean: f64 = corners.iter().zip(shares).map(|(corner, share)| corner * f64::from(share)).sum();
                // Values up to 4 apart over a 48th of the face, in single precision.
                assert!((field.value(4, at) - mean).abs() < 1e-3, "{triangle:?} {shares:?}");
            }
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
}
