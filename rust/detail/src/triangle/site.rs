//! The vertices of the tessellation that a dab may change: those inside faces, on edges and at corners, in runs of up
//! to 256, with what the brush says of them.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.2: the
//! kernels go over all vertices along an edge and inside a face, and find the barycentric coordinates from the index.

use glam::Vec3;
use half::slice::HalfFloatSliceExt;
use relievo_core::Context;
use relievo_core::simd::Level;
use relievo_surface::{TriangleSurface, TriangleTopology};
use relievo_tiles::Texel;
use relievo_tiles::triangle::displaced::foot;
use relievo_tiles::triangle::{Node, Offset, Pattern, Slot, TriangleField, TriangleNormals};

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

/// A run of vertices, and what the brush says of them.
pub(super) struct Site<'a, T> {
    run: Run,
    weights: Weights,
    places: KnotBlock,
    heights: PerKnot,
    /// The vectors that the weights were evaluated with, in object space.
    vectors: Vectors,
    /// Object units between a vertex and its neighbours.
    spacing: f32,
    /// How much longer a length is across the brush than in object units.
    scale: f32,
    field: &'a TriangleField<T>,
}

/// Values of an element from `start` on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub element: Element,
    pub pattern: Pattern,
    pub start: usize,
    pub count: usize,
}

impl Run {
    fn knots(&self, topology: &TriangleTopology) -> Vec<Knot> {
        let all = self.element.knots(topology, self.pattern);
        all.into_iter().skip(self.start).take(self.count).collect()
    }

    /// The undisplaced surface.
    pub fn places(&self, surface: &TriangleSurface, out: &mut KnotBlock) {
        let mut set = |k: usize, point: Vec3, normal: Vec3| {
            for axis in 0..3 {
                out.p[axis][k] = point[axis];
                out.n[axis][k] = normal[axis];
            }
        };
        if let Element::Face(face) = self.element {
            let points = surface.corner_points(face).map(Vec3::from);
            let normals = surface.corner_normals(face).map(Vec3::from);
            let mean = |of: &[Vec3; 3], at: &[f32; 3]| of[0] * at[0] + of[1] * at[1] + of[2] * at[2];
            for (k, at) in self.pattern.places()[self.start..][..self.count].iter().enumerate() {
                set(k, mean(&points, at), mean(&normals, at).normalize_or_zero());
            }
            return;
        }
        for (k, (face, pattern, node)) in self.knots(surface.topology()).into_iter().enumerate() {
            let foot = foot(surface, face, pattern, node);
            set(k, foot.point, foot.normal);
        }
    }

    /// The values of a displacement there.
    pub fn heights(&self, field: &TriangleField, out: &mut PerKnot) {
        if let Element::Face(face) = self.element {
            if let Some(block) = field.face(face).filter(|_| field.face_pattern(face) == Some(self.pattern)) {
                return block[self.start..][..self.count].convert_to_f32_slice(&mut out[..self.count]);
            }
            if field.is_blank(face) {
                return out.fill(0.0);
            }
        }
        for ((face, pattern, node), out) in self.knots(field.topology()).into_iter().zip(out) {
            *out = field.at(face, pattern, node) as f32;
        }
    }

    /// The vectors there, in object space.
    pub fn vectors(&self, field: &TriangleField<Offset>, out: &mut Vectors) {
        *out = STILL;
        if let Element::Face(face) = self.element {
            if let Some(block) = field.face(face).filter(|_| field.face_pattern(face) == Some(self.pattern)) {
                return Offset::read(&block[self.start..][..self.count], out, 0);
            }
            if field.is_blank(face) {
                return;
            }
        }
        for (k, (face, pattern, node)) in self.knots(field.topology()).into_iter().enumerate() {
            Offset::read(&[field.texel(face, pattern, node)], out, k);
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
        let topology = self.field.topology();
        for (k, (face, pattern, node)) in self.run.knots(topology).iter().enumerate() {
            let (mut sum, mut count) = ([0.0; N], 0.0);
            let take = |face: u32, node: Node| {
                for (sum, value) in sum.iter_mut().zip(read(self.field.texel(face, *pattern, node))) {
                    *sum += value;
                }
                count += 1.0;
            };
            around(topology, (*face, *pattern, *node), take);
            set(k, sum.map(|sum| sum / count));
        }
        true
    }

    fn footprints(&self) -> PerKnot {
        [self.spacing * self.scale; BLOCK_KNOTS]
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
    /// The cosines between the normals of the mesh and of the displaced one.
    pub fn facing(&self, surface: &TriangleSurface, normals: &TriangleNormals, out: &mut PerKnot) {
        for (k, (face, pattern, node)) in self.run.knots(surface.topology()).iter().enumerate() {
            let normal = normals.at(surface, *face, *pattern, *node);
            out[k] = (0..3).map(|axis| normal[axis] * self.places.n[axis][k]).sum();
        }
    }
}

/// The second pass: the brush at every vertex of the elements. `ground` sets the displacement of vertices and, if it
/// returns true, the vectors there; `change` makes new values of old ones. All is in `pattern`, whatever elements have.
/// Only elements that change are returned.
#[allow(clippy::too_many_arguments)]
pub(super) fn evaluate<T: Texel>(
    context: &Context,
    surface: &TriangleSurface,
    field: &TriangleField<T>,
    pattern: Pattern,
    elements: &[Element],
    brush: &BrushParameters,
    ground: impl Fn(&Run, &mut PerKnot, &mut Vectors) -> bool + Sync,
    change: impl Fn(&mut Site<'_, T>, &mut [T]) + Sync,
) -> Vec<ElementEdit<T>> {
    let level = context.level();
    let topology = surface.topology();
    let edits = context.map(elements.len(), |index| {
        let element = elements[index];
        edit_element(level, surface, field, (element, pattern), brush, &ground, &change, topology)
    });
    edits.into_iter().flatten().collect()
}

#[allow(clippy::too_many_arguments)]
fn edit_element<T: Texel>(
    level: Level,
    surface: &TriangleSurface,
    field: &TriangleField<T>,
    (element, pattern): (Element, Pattern),
    brush: &BrushParameters,
    ground: &impl Fn(&Run, &mut PerKnot, &mut Vectors) -> bool,
    change: &impl Fn(&mut Site<'_, T>, &mut [T]),
    topology: &TriangleTopology,
) -> Option<ElementEdit<T>> {
    let face = element.face(topology)?;
    let [a, b, c] = surface.corner_points(face).map(Vec3::from);
    let spacing = (a.distance(b) + b.distance(c) + c.distance(a)) / (3.0 * pattern.segments() as f32);
    let row = |axis: usize| Vec3::from_slice(&brush.rows[axis][..3]).length();
    let total = element.count(pattern);
    let mut site = Site {
        run: Run { element, pattern, start: 0, count: 0 },
        weights: Weights::default(),
        places: KnotBlock::ZERO,
        heights: [0.0; BLOCK_KNOTS],
        vectors: STILL,
        spacing,
        scale: row(0).max(row(1)),
        field,
    };
    let mut new: Vec<T> = Vec::new();
    let mut count = 0;
    for start in (0..total).step_by(BLOCK_KNOTS) {
        site.run = Run { element, pattern, start, count: BLOCK_KNOTS.min(total - start) };
        site.run.places(surface, &mut site.places);
        if ground(&site.run, &mut site.heights, &mut site.vectors) {
            site.places.shift_by(&site.vectors);
        }
        site.weights.evaluate(level, brush, &site.places, &site.heights);
        if !site.weights.share[..site.run.count].iter().any(|share| *share > 0.0) {
            continue;
        }
        if new.is_empty() {
            new = values(field, element, pattern)?;
        }
        let run = &mut new[start..start + site.run.count];
        let before = run.to_vec();
        change(&mut site, run);
        count += run.iter().zip(&before).map(|(new, old)| u64::from(!new.same(*old))).sum::<u64>();
    }
    (count > 0).then_some(ElementEdit { element, pattern, values: new, count })
}

/// What an element holds, or reads as, in `pattern`; `None` if it has no face.
pub(super) fn values<T: Texel>(field: &TriangleField<T>, element: Element, pattern: Pattern) -> Option<Vec<T>> {
    let face = element.face(field.topology())?;
    let own = match element {
        Element::Face(face) => field.face(face),
        Element::Edge(edge) => field.edge(edge),
        Element::Vertex(_) => None,
    };
    Some(match own.filter(|_| element.pattern(field) == Some(pattern)) {
        Some(block) => block.to_vec(),
        None if field.is_blank(face) => vec![field.blank(); element.count(pattern)],
        None => {
            let knots = element.knots(field.topology(), pattern);
            knots.into_iter().map(|(face, pattern, node)| field.texel(face, pattern, node)).collect()
        }
    })
}
