//! The vertices of the tessellation that a dab may change: those inside faces, on edges and at corners, in runs of up
//! to 256, with what the brush says of them.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.2: the
//! kernels go over all vertices along an edge and inside a face, and find the barycentric coordinates from the index.

use std::ops::Range;

use glam::Vec3;
use half::slice::HalfFloatSliceExt;
use relievo_core::Context;
use relievo_core::simd::Level;
use relievo_surface::{TriangleSurface, TriangleTopology};
use relievo_tiles::Texel;
use relievo_tiles::triangle::{Node, Offset, Pattern, Slot, TriangleField, TriangleNormals, edge_foot};

use crate::channels::frame::{STILL, Vectors};
use crate::channels::knots::{BLOCK_KNOTS, KnotBlock, PerKnot};
use crate::paint::spot::Spot;
use crate::paint::vector::{Framed, VectorTexel};
use crate::paint::weights::{BrushParameters, Weights};

/// What has values: the inside of a face or of an edge, or a vertex of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Element {
    Face(u32),
    Edge(u32),
    Vertex(u32),
}

/// A vertex of the tessellation, as one of the faces that have it sees it.
pub(super) type Knot = (u32, Pattern, Node);

impl Element {
    /// All that belong to `faces`, in order.
    pub fn of_faces(topology: &TriangleTopology, faces: &[u32]) -> Vec<Self> {
        let mut edges: Vec<u32> = faces.iter().flat_map(|face| topology.edges_of(*face)).collect();
        let mut vertices: Vec<u32> = faces.iter().flat_map(|face| topology.face(*face)).collect();
        for list in [&mut edges, &mut vertices] {
            list.sort_unstable();
            list.dedup();
        }
        let faces = faces.iter().copied().map(Self::Face);
        faces.chain(edges.into_iter().map(Self::Edge)).chain(vertices.into_iter().map(Self::Vertex)).collect()
    }

    /// The first of the faces that have it, if there is one.
    pub fn face(self, topology: &TriangleTopology) -> Option<u32> {
        match self {
            Element::Face(face) => Some(face),
            Element::Edge(edge) => topology.faces_along(edge).next().map(|(face, _)| face),
            Element::Vertex(vertex) => topology.faces_around(vertex).next().map(|(face, _)| face),
        }
    }

    /// What keeps the value of a vertex of the tessellation, and which of its values that is.
    pub fn of_knot(topology: &TriangleTopology, (face, pattern, node): Knot) -> (Self, usize) {
        match pattern.slot(node) {
            Slot::Corner(corner) => (Element::Vertex(topology.face(face)[corner as usize]), 0),
            Slot::Inside(index) => (Element::Face(face), index as usize),
            Slot::Side(side, step) => {
                let side = topology.side(face, side);
                let step = if side.reversed { pattern.segments() - step } else { step };
                (Element::Edge(side.edge), step as usize - 1)
            }
        }
    }

    /// How many values it has.
    pub fn count(self, pattern: Pattern) -> usize {
        match self {
            Element::Face(_) => pattern.face_values(),
            Element::Edge(_) => pattern.edge_values(),
            Element::Vertex(_) => 1,
        }
    }

    /// The vertices of the tessellation, in the order of the values.
    pub fn knots(self, topology: &TriangleTopology, pattern: Pattern) -> Vec<Knot> {
        let knot = |face: u32, slot: Slot| (face, pattern, pattern.at_slot(slot));
        match self {
            Element::Face(face) => (0..pattern.face_values() as u32).map(|at| knot(face, Slot::Inside(at))).collect(),
            Element::Edge(edge) => {
                let Some((face, side)) = topology.faces_along(edge).next() else { return Vec::new() };
                let segments = pattern.segments();
                let reversed = topology.side(face, side).reversed;
                let step = |step: u32| if reversed { segments - step } else { step };
                (1..segments).map(|at| knot(face, Slot::Side(side, step(at)))).collect()
            }
            Element::Vertex(vertex) => {
                let Some((face, corner)) = topology.faces_around(vertex).next() else { return Vec::new() };
                vec![knot(face, Slot::Corner(corner))]
            }
        }
    }

    /// The values that it has in `field`, if they have `pattern`; `None` for vertices.
    fn block<T: Texel>(self, field: &TriangleField<T>, pattern: Pattern) -> Option<&[T]> {
        let block = match self {
            Element::Face(face) => field.face(face),
            Element::Edge(edge) => field.edge(edge),
            Element::Vertex(_) => None,
        };
        block.filter(|_| self.pattern(field) == Some(pattern))
    }

    /// The pattern that its values have in `field`.
    pub fn pattern<T: Texel>(self, field: &TriangleField<T>) -> Option<Pattern> {
        match self {
            Element::Face(face) => field.face_pattern(face),
            Element::Edge(edge) => field.edge_pattern(edge),
            Element::Vertex(_) => None,
        }
    }
}

/// Calls `take` for the neighbours of a vertex of the tessellation in all faces that have it; those on an edge come
/// once for each of its faces.
pub(super) fn around(topology: &TriangleTopology, (face, pattern, node): Knot, mut take: impl FnMut(u32, Node)) {
    match pattern.slot(node) {
        Slot::Inside(_) => pattern.one_ring(node).nodes().iter().for_each(|node| take(face, *node)),
        Slot::Side(side, step) => {
            let edge = topology.side(face, side);
            for (other, side) in topology.faces_along(edge.edge) {
                let same = topology.side(other, side).reversed == edge.reversed;
                let step = if same { step } else { pattern.segments() - step };
                let ring = pattern.one_ring(pattern.node(0, side, step));
                ring.nodes().iter().for_each(|node| take(other, *node));
            }
        }
        Slot::Corner(corner) => {
            for (other, corner) in topology.faces_around(topology.face(face)[corner as usize]) {
                let ring = pattern.one_ring(pattern.node(0, corner, 0));
                ring.nodes().iter().for_each(|node| take(other, *node));
            }
        }
    }
}

/// New values of an element.
#[derive(Clone, Debug)]
pub(super) struct ElementEdit<T> {
    pub element: Element,
    pub pattern: Pattern,
    /// All values, unchanged ones too.
    pub values: Vec<T>,
    /// Values that change.
    pub count: u64,
}

/// Runs of vertices, and what the brush says of them.
pub(super) struct Site<'a, T> {
    runs: Vec<Run>,
    weights: Weights,
    places: KnotBlock,
    heights: PerKnot,
    /// The vectors that the weights were evaluated with, in object space.
    vectors: Vectors,
    /// How much longer a length is across the brush than in object units.
    scale: f32,
    surface: &'a TriangleSurface,
    field: &'a TriangleField<T>,
}

/// Values of an element from `start` on, which are at `at` and behind it in a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub element: Element,
    pub pattern: Pattern,
    pub start: usize,
    pub count: usize,
    pub at: usize,
}

impl Run {
    fn knots(&self, topology: &TriangleTopology) -> Vec<Knot> {
        let all = self.element.knots(topology, self.pattern);
        all.into_iter().skip(self.start).take(self.count).collect()
    }

    /// Where it is in a block.
    fn span(&self) -> Range<usize> {
        self.at..self.at + self.count
    }

    /// The undisplaced surface.
    pub fn places(&self, surface: &TriangleSurface, out: &mut KnotBlock) {
        let mut set = |k: usize, point: Vec3, normal: Vec3| {
            for axis in 0..3 {
                out.p[axis][k] = point[axis];
                out.n[axis][k] = normal[axis];
            }
        };
        match self.element {
            Element::Face(face) => {
                let points = surface.corner_points(face).map(Vec3::from);
                let normals = surface.corner_normals(face).map(Vec3::from);
                let mean = |of: &[Vec3; 3], at: &[f32; 3]| of[0] * at[0] + of[1] * at[1] + of[2] * at[2];
                for (k, at) in self.span().zip(&self.pattern.places()[self.start..][..self.count]) {
                    set(k, mean(&points, at), mean(&normals, at).normalize_or_zero());
                }
            }
            Element::Edge(edge) => {
                for (k, step) in self.span().zip(self.start as u32 + 1..) {
                    let foot = edge_foot(surface, edge, step, self.pattern.segments());
                    set(k, foot.point, foot.normal);
                }
            }
            Element::Vertex(vertex) => {
                let [point, normal] = [surface.points(), surface.normals()].map(|of| of[vertex as usize]);
                set(self.at, point.into(), normal.into());
            }
        }
    }

    /// The values of a displacement there.
    pub fn heights(&self, field: &TriangleField, out: &mut PerKnot) {
        let out = &mut out[self.span()];
        if let Some(block) = self.element.block(field, self.pattern) {
            return block[self.start..][..self.count].convert_to_f32_slice(out);
        }
        match self.element {
            Element::Vertex(vertex) => out.fill(field.vertex(vertex).to_f32()),
            Element::Face(face) if field.is_blank(face) => out.fill(0.0),
            _ => {
                for ((face, pattern, node), out) in self.knots(field.topology()).into_iter().zip(out) {
                    *out = field.at(face, pattern, node) as f32;
                }
            }
        }
    }

    /// The vectors there, in object space.
    pub fn vectors(&self, field: &TriangleField<Offset>, out: &mut Vectors) {
        out.iter_mut().for_each(|out| out[self.span()].fill(0.0));
        if let Some(block) = self.element.block(field, self.pattern) {
            return Offset::read(&block[self.start..][..self.count], out, self.at);
        }
        match self.element {
            Element::Vertex(vertex) => Offset::read(&[field.vertex(vertex)], out, self.at),
            Element::Face(face) if field.is_blank(face) => {}
            _ => {
                for (k, (face, pattern, node)) in self.span().zip(self.knots(field.topology())) {
                    Offset::read(&[field.texel(face, pattern, node)], out, k);
                }
            }
        }
    }
}

impl<T: Texel> Spot<T> for Site<'_, T> {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn heights(&self) -> &PerKnot {
        &self.heights
    }

    /// The mean of the neighbours in all faces with a block of the same pattern.
    fn means<const N: usize>(&self, read: impl Fn(T) -> [f32; N], mut set: impl FnMut(usize, [f32; N])) -> bool {
        for (k, (face, pattern, node)) in self.knots() {
            let (mut sum, mut count) = ([0.0; N], 0.0);
            let take = |face: u32, node: Node| {
                for (sum, value) in sum.iter_mut().zip(read(self.field.texel(face, pattern, node))) {
                    *sum += value;
                }
                count += 1.0;
            };
            around(self.field.topology(), (face, pattern, node), take);
            set(k, sum.map(|sum| sum / count));
        }
        true
    }

    fn footprints(&self) -> PerKnot {
        let mut all = [0.0; BLOCK_KNOTS];
        for run in &self.runs {
            let Some(face) = run.element.face(self.field.topology()) else { continue };
            let [a, b, c] = self.surface.corner_points(face).map(Vec3::from);
            let spacing = (a.distance(b) + b.distance(c) + c.distance(a)) / (3.0 * run.pattern.segments() as f32);
            all[run.span()].fill(spacing * self.scale);
        }
        all
    }
}

/// Vectors are in object space already.
impl<T> Framed for Site<'_, T> {
    fn vectors(&self) -> &Vectors {
        &self.vectors
    }

    fn to_object(&self, _: Level, _: &mut Vectors) {}

    fn from_object(&self, _: Level, _: &mut Vectors) {}
}

impl<T> Site<'_, T> {
    /// The vertices, and where they are in the block.
    fn knots(&self) -> impl Iterator<Item = (usize, Knot)> {
        self.runs.iter().flat_map(|run| run.span().zip(run.knots(self.surface.topology())))
    }

    /// The cosines between the normals of the mesh and of the displaced one.
    pub fn facing(&self, normals: &TriangleNormals, out: &mut PerKnot) {
        for (k, (face, pattern, node)) in self.knots() {
            let normal = normals.at(self.surface, face, pattern, node);
            out[k] = (0..3).map(|axis| normal[axis] * self.places.n[axis][k]).sum();
        }
    }
}

/// The second pass: a brush at every vertex of some elements.
pub(super) struct Pass<'a, T> {
    pub surface: &'a TriangleSurface,
    pub field: &'a TriangleField<T>,
    /// What all elements are seen in, whatever they have.
    pub pattern: Pattern,
    pub brush: &'a BrushParameters,
}

impl<T: Texel> Pass<'_, T> {
    /// Edits `elements`, ascending. `ground` sets the displacement of vertices and, if it returns true, the vectors there;
    /// `change` makes new values of old ones. Only elements that change are returned, ascending.
    pub fn evaluate(
        &self,
        context: &Context,
        elements: &[Element],
        ground: impl Fn(&Run, &mut PerKnot, &mut Vectors) -> bool + Sync,
        change: impl Fn(&mut Site<'_, T>, &mut [T]) + Sync,
    ) -> Vec<ElementEdit<T>> {
        let batches = batches(elements, self.pattern);
        let edits = context.map(batches.len(), |index| {
            self.edit(context.level(), &elements[batches[index].clone()], &ground, &change).unwrap_or_default()
        });
        edits.into_iter().flatten().collect()
    }

    /// Edits elements that fill no more than a block, or one that fills several; `None` where a face is missing.
    fn edit(
        &self,
        level: Level,
        elements: &[Element],
        ground: &impl Fn(&Run, &mut PerKnot, &mut Vectors) -> bool,
        change: &impl Fn(&mut Site<'_, T>, &mut [T]),
    ) -> Option<Vec<ElementEdit<T>>> {
        let Self { surface, field, pattern, brush } = *self;
        let row = |axis: usize| Vec3::from_slice(&brush.rows[axis][..3]).length();
        let mut site = Site {
            runs: Vec::with_capacity(elements.len()),
            weights: Weights::default(),
            places: KnotBlock::ZERO,
            heights: [0.0; BLOCK_KNOTS],
            vectors: STILL,
            scale: row(0).max(row(1)),
            surface,
            field,
        };
        let total: usize = elements.iter().map(|element| element.count(pattern)).sum();
        let (mut new, mut counts) = (Vec::new(), vec![0; elements.len()]);
        for first in (0..total).step_by(BLOCK_KNOTS) {
            site.runs.clear();
            let mut at = 0;
            for element in elements.iter().copied() {
                let count = (element.count(pattern) - first).min(BLOCK_KNOTS);
                site.runs.push(Run { element, pattern, start: first, count, at });
                at += count;
            }
            let mut is_bent = false;
            for run in &site.runs {
                run.places(surface, &mut site.places);
                is_bent |= ground(run, &mut site.heights, &mut site.vectors);
            }
            if is_bent {
                site.places.shift_by(&site.vectors);
            }
            site.weights.evaluate(level, brush, &site.places, &site.heights);
            if !site.weights.share[..at].iter().any(|share| *share > 0.0) {
                continue;
            }
            if new.is_empty() {
                new.reserve_exact(total);
                elements.iter().try_for_each(|element| push_values(field, *element, pattern, &mut new))?;
            }
            let values = &mut new[first..first + at];
            let before = values.to_vec();
            change(&mut site, values);
            for (run, count) in site.runs.iter().zip(&mut counts) {
                let changed = values[run.span()].iter().zip(&before[run.span()]);
                *count += changed.map(|(new, old)| u64::from(!new.same(*old))).sum::<u64>();
            }
        }
        let mut values = &new[..];
        let mut edits = Vec::new();
        for (element, count) in elements.iter().copied().zip(counts) {
            let Some((own, rest)) = values.split_at_checked(element.count(pattern)) else { break };
            values = rest;
            if count > 0 {
                edits.push(ElementEdit { element, pattern, values: own.to_vec(), count });
            }
        }
        Some(edits)
    }
}

/// Parts of `elements` that are evaluated at once, since a block of places costs the same however few there are: as many
/// as fill one, or one that fills more.
fn batches(elements: &[Element], pattern: Pattern) -> Vec<Range<usize>> {
    let mut batches: Vec<Range<usize>> = Vec::new();
    let mut free = 0;
    for (index, element) in elements.iter().enumerate() {
        let count = element.count(pattern);
        match batches.last_mut() {
            Some(last) if count <= free => {
                last.end += 1;
                free -= count;
            }
            _ => {
                batches.push(index..index + 1);
                free = BLOCK_KNOTS.saturating_sub(count);
            }
        }
    }
    batches
}

/// What an element holds, or reads as, in `pattern`; `None` if it has no face.
pub(super) fn values<T: Texel>(field: &TriangleField<T>, element: Element, pattern: Pattern) -> Option<Vec<T>> {
    let mut values = Vec::with_capacity(element.count(pattern));
    push_values(field, element, pattern, &mut values)?;
    Some(values)
}

/// As [`values`], put behind others.
fn push_values<T: Texel>(field: &TriangleField<T>, element: Element, pattern: Pattern, out: &mut Vec<T>) -> Option<()> {
    let face = element.face(field.topology())?;
    match (element, element.block(field, pattern)) {
        (Element::Vertex(vertex), _) => out.push(field.vertex(vertex)),
        (_, Some(block)) => out.extend_from_slice(block),
        _ if field.is_blank(face) => out.resize(out.len() + element.count(pattern), field.blank()),
        _ => {
            let knots = element.knots(field.topology(), pattern);
            out.extend(knots.into_iter().map(|(face, pattern, node)| field.texel(face, pattern, node)));
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_have_every_element_once_and_fill_a_block() {
        let elements: Vec<Element> = (0..40).map(Element::Face).chain((0..500).map(Element::Vertex)).collect();
        for segments in Pattern::SIZES {
            let pattern = Pattern::new(segments).unwrap();
            let batches = batches(&elements, pattern);
            let all: Vec<usize> = batches.iter().cloned().flatten().collect();
            assert_eq!(all, (0..elements.len()).collect::<Vec<_>>());
            let fill = |batch: &Range<usize>| elements[batch.clone()].iter().map(|it| it.count(pattern)).sum::<usize>();
            assert!(batches.iter().all(|batch| fill(batch) <= BLOCK_KNOTS || batch.len() == 1));
            // None could take up the first element of the next one.
            let next = |pair: &[Range<usize>]| elements[pair[1].start].count(pattern);
            assert!(batches.windows(2).all(|pair| fill(&pair[0]) + next(pair) > BLOCK_KNOTS));
        }
    }
}
