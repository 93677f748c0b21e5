//! Rims on triangle meshes: values of faces, edges and vertices around an imprint rise by a share of what it pushed
//! away. See [`crate::imprint::rim`], which has the method; here are the places, their neighbours and their areas.
//!
//! All triangles of the pattern (Schäfer et al. 2015, Section 6) have the same area in a face, 2/(3T²) of it. Values are
//! linear between its vertices, so each stands for a third of the triangles around it, in all faces that have it. That
//! is how much volume the displacement of a vertex by one makes to first order, once the angle between the interpolated
//! normal and that of the face is taken off. Units: object units.

use glam::Vec3;
use half::f16;
use relievo_core::{Context, Result};
use relievo_surface::{TriangleSurface, TriangleTopology};
use relievo_tiles::triangle::{Pattern, TriangleField};

use super::object::{TriangleGround, TriangleObject};
use super::site::{Element, ElementEdit, Run, around, values};
use crate::channels::frame::STILL;
use crate::channels::knots::{BLOCK_KNOTS, KnotBlock};
use crate::geometry::voxel::Voxels;
use crate::geometry::voxel_frame::VoxelFrame;
use crate::imprint::rim::{Piece, Volumes, check_bytes, rise};
use crate::imprint::settings::ImprintSettings;

/// Raises rims around what `edits` push away, which are ascending by element and those of `voxels`, made from the
/// displacement as it is or was at `start`; they get the values that rise as well. Returns what every element pushed
/// and raised, ascending.
///
/// Fails if what is within the rim's width exceeds the context's memory limit, or 2 GiB.
pub(super) fn raise(
    context: &Context,
    object: &TriangleObject,
    start: Option<TriangleGround<'_>>,
    edits: &mut Vec<ElementEdit<f16>>,
    voxels: &Voxels,
    settings: &ImprintSettings,
) -> Result<Vec<(Element, Volumes)>> {
    let scale = object.transform().matrix3;
    let stretch = scale.x_axis.length().max(scale.y_axis.length()).max(scale.z_axis.length());
    let obb = voxels.grid().obb.enlarged(f64::from(settings.rim_width) * stretch);
    let faces = object.faces_near(context, &obb, start);
    let band = Band::new(context, object, &faces, edits);
    check_bytes(context, band.piece_count())?;
    let pieces = context.map(band.piece_count(), |index| band.piece(index, voxels));
    let risen = rise(context, &pieces, settings);
    let mut volumes = Vec::new();
    let mut raised = Vec::new();
    for (element, first) in band.elements.iter().zip(&band.offsets) {
        let mut sum = Volumes::default();
        let mut count = 0;
        let places = *first..*first + element.count(band.pattern);
        let place = |at: usize| (&pieces[at / BLOCK_KNOTS], risen[at / BLOCK_KNOTS].as_ref(), at % BLOCK_KNOTS);
        for (piece, risen, k) in places.clone().map(place) {
            sum += piece.moved_at(k, risen);
            count += u64::from(risen.is_some_and(|risen| risen[k] > piece.values[k]));
        }
        if sum != Volumes::default() {
            volumes.push((*element, sum));
        }
        if count > 0 {
            let values = places.map(place).map(|(piece, risen, k)| risen.unwrap_or(&piece.values)[k]).collect();
            raised.push(ElementEdit { element: *element, pattern: band.pattern, values, count });
        }
    }
    for edit in raised {
        match edits.binary_search_by_key(&edit.element, |edit| edit.element) {
            Ok(at) => edits[at] = ElementEdit { count: edits[at].count + edit.count, ..edit },
            Err(at) => edits.insert(at, edit),
        }
    }
    volumes.sort_unstable_by_key(|(element, _)| *element);
    Ok(volumes)
}

/// How far an edit pushes its values, and which of them are at the border of what is pushed.
struct Pushed {
    element: Element,
    depth: Vec<f32>,
    border: Vec<bool>,
}

/// What may rise: faces in and around a contact with their edges and vertices, in runs of 256 values that lie together.
struct Band<'a> {
    object: &'a TriangleObject,
    pattern: Pattern,
    edits: &'a [ElementEdit<f16>],
    /// Of the edits, in their order.
    pushed: Vec<Pushed>,
    /// Each edge and each vertex with the first of the faces that has it.
    elements: Vec<Element>,
    /// Values before each element.
    offsets: Vec<usize>,
    total: usize,
}

impl<'a> Band<'a> {
    fn new(context: &Context, object: &'a TriangleObject, faces: &[u32], edits: &'a [ElementEdit<f16>]) -> Self {
        let field = object.displacement().field();
        let (topology, pattern) = (field.topology(), field.pattern());
        let mut elements: Vec<(u32, Element)> = faces.iter().map(|face| (*face, Element::Face(*face))).collect();
        elements
            .extend(faces.iter().flat_map(|face| topology.edges_of(*face).map(|edge| (*face, Element::Edge(edge)))));
        elements.extend(faces.iter().flat_map(|face| topology.face(*face).map(|at| (*face, Element::Vertex(at)))));
        // Each stays with the first face that has it.
        elements.sort_unstable_by_key(|(face, element)| (*element, *face));
        elements.dedup_by_key(|(_, element)| *element);
        elements.sort_unstable();
        let elements: Vec<Element> = elements.into_iter().map(|(_, element)| element).collect();
        let mut total = 0;
        let offset = |element: &Element| {
            total += element.count(pattern);
            total - element.count(pattern)
        };
        let offsets = elements.iter().map(offset).collect();
        Self { object, pattern, edits, pushed: pushed(context, field, edits), elements, offsets, total }
    }

    fn piece_count(&self) -> usize {
        self.total.div_ceil(BLOCK_KNOTS)
    }

    /// Values from 256 times `index` on.
    fn piece(&self, index: usize, voxels: &Voxels) -> Piece {
        let (surface, pattern) = (self.object.surface(), self.pattern);
        let field = self.object.displacement().field();
        let frame = VoxelFrame::new(voxels.grid(), self.object.transform());
        let (first, end) = (index * BLOCK_KNOTS, ((index + 1) * BLOCK_KNOTS).min(self.total));
        let mut piece = Piece { count: end - first, ..Piece::EMPTY };
        let (mut places, mut way) = (KnotBlock::ZERO, STILL);
        let mut at = first;
        while at < end {
            let number = self.offsets.partition_point(|offset| *offset <= at) - 1;
            let (element, offset) = (self.elements[number], self.offsets[number]);
            let start = at - offset;
            let count = (end - at).min(element.count(pattern) - start);
            let run = Run { element, pattern, start, count, at: 0 };
            run.places(surface, &mut places);
            if let Some(vectors) = self.object.ground().vectors {
                run.vectors(vectors, &mut way);
            }
            let edit = self.edits.binary_search_by_key(&element, |edit| edit.element).ok();
            let now = match edit {
                Some(edit) => self.edits[edit].values.clone(),
                None => values(field, element, pattern).unwrap_or_default(),
            };
            let areas = Areas::new(surface, element, pattern);
            if edit.is_some_and(|edit| self.pushed[edit].depth.iter().any(|depth| *depth > 0.0)) {
                piece.spacing = piece.spacing.max(areas.spacing);
            }
            for k in 0..run.count {
                let (into, value) = (at - first + k, start + k);
                let [p, n, way] = [&places.p, &places.n, &way].map(|of| Vec3::new(of[0][k], of[1][k], of[2][k]));
                piece.values[into] = now.get(value).copied().unwrap_or_default();
                if let Some(pushed) = edit.map(|edit| &self.pushed[edit]) {
                    piece.depth[into] = pushed.depth[value];
                    piece.border[into] = pushed.border[value];
                }
                for axis in 0..3 {
                    piece.p[axis][into] = p[axis];
                }
                piece.area[into] = areas.at(value, n);
                let place = frame.place((p + way + n * piece.values[into].to_f32()).to_array());
                piece.free[into] = n != Vec3::ZERO && piece.depth[into] <= 0.0 && !voxels.contains(place);
            }
            at += run.count;
        }
        piece
    }
}

/// What `edits` push.
fn pushed(context: &Context, field: &TriangleField, edits: &[ElementEdit<f16>]) -> Vec<Pushed> {
    let mut pushed = context.map(edits.len(), |index| {
        let ElementEdit { element, pattern, values: new, .. } = &edits[index];
        let old = values(field, *element, *pattern).unwrap_or_default();
        let depth: Vec<f32> = old.iter().zip(new).map(|(old, new)| old.to_f32() - new.to_f32()).collect();
        Pushed { element: *element, border: Vec::new(), depth }
    });
    let (topology, pattern) = (field.topology(), field.pattern());
    let is_pushed = |element: Element, value: usize| {
        let at = pushed.binary_search_by_key(&element, |pushed| pushed.element);
        at.is_ok_and(|at| pushed[at].depth[value] > 0.0)
    };
    let borders = context.map(pushed.len(), |index| {
        let Pushed { element, depth, .. } = &pushed[index];
        let knots = element.knots(topology, pattern).into_iter();
        let at_border = knots.zip(depth).map(|(knot, depth)| {
            let mut alone = false;
            if *depth > 0.0 {
                around(topology, knot, |face, node| {
                    let (element, value) = Element::of_knot(topology, (face, pattern, node));
                    alone |= !is_pushed(element, value);
                });
            }
            alone
        });
        at_border.collect::<Vec<bool>>()
    });
    for (pushed, border) in pushed.iter_mut().zip(borders) {
        pushed.border = border;
    }
    pushed
}

/// The areas that the values of an element stand for.
struct Areas {
    pattern: Pattern,
    /// By face that has it: the normal, as long as a third of a triangle of the pattern is large.
    normals: Vec<Vec3>,
    element: Element,
    /// No neighbours are further apart.
    spacing: f32,
}

impl Areas {
    fn new(surface: &TriangleSurface, element: Element, pattern: Pattern) -> Self {
        let topology: &TriangleTopology = surface.topology();
        let segments = pattern.segments() as f32;
        let mut areas = Self { pattern, normals: Vec::new(), element, spacing: 0.0 };
        let mut add = |face: u32| {
            let [a, b, c] = surface.corner_points(face).map(Vec3::from);
            areas.normals.push((b - a).cross(c - a) / (9.0 * segments * segments));
            // Between two rings lie no more than four thirds of a segment.
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            areas.spacing = areas.spacing.max(longest / (0.75 * segments));
        };
        match element {
            Element::Face(face) => add(face),
            Element::Edge(edge) => topology.faces_along(edge).for_each(|(face, _)| add(face)),
            Element::Vertex(vertex) => topology.faces_around(vertex).for_each(|(face, _)| add(face)),
        }
        areas
    }

    /// That of a value, where the normal is `n`.
    fn at(&self, value: usize, n: Vec3) -> f32 {
        let triangles = match self.element {
            Element::Face(_) => 6,
            // The same seen from either end.
            Element::Edge(_) => {
                let node = self.pattern.node(0, 0, value as u32 + 1);
                self.pattern.one_ring(node).pairs().count()
            }
            Element::Vertex(_) => 2,
        };
        triangles as f32 * self.normals.iter().map(|normal| normal.dot(n).max(0.0)).sum::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_core::Mesh;

    /// A pyramid without a base: three faces around a vertex, of different size and slope.
    fn pyramid() -> Mesh {
        let points = vec![[0.0, 0.0, 0.3], [1.0, 0.0, 0.0], [-0.5, 2.0, 0.1], [-1.0, -1.0, 0.0]];
        Mesh::from_triangles(points, &[[0, 1, 2], [0, 2, 3], [0, 3, 1]])
    }

    #[test]
    fn areas_are_those_of_the_triangles_around_each_value() {
        let context = Context::serial();
        let surface = TriangleSurface::new(&context, &pyramid()).unwrap();
        let topology = surface.topology();
        for segments in [8, 16, 32] {
            let pattern = Pattern::new(segments).unwrap();
            let elements = Element::of_faces(topology, &[0, 1, 2]);
            // A third of every triangle of the pattern to each of its corners, one by one.
            let mut expected: Vec<Vec<f32>> = elements.iter().map(|of| vec![0.0; of.count(pattern)]).collect();
            for face in 0..3 {
                let [a, b, c] = surface.corner_points(face).map(Vec3::from);
                let flat = (b - a).cross(c - a).normalize();
                let foot = |node| relievo_tiles::triangle::foot(&surface, face, pattern, node);
                for nodes in pattern.triangles() {
                    let [a, b, c] = nodes.map(|node| foot(node).point);
                    let area = 0.5 * (b - a).cross(c - a).length();
                    for node in nodes {
                        let (element, value) = Element::of_knot(topology, (face, pattern, node));
                        let at = elements.binary_search(&element).unwrap();
                        expected[at][value] += area / 3.0 * flat.dot(foot(node).normal);
                    }
                }
            }
            for (element, expected) in elements.iter().zip(&expected) {
                let areas = Areas::new(&surface, *element, pattern);
                for ((value, knot), expected) in (0..).zip(element.knots(topology, pattern)).zip(expected) {
                    let (face, pattern, node) = knot;
                    let normal = relievo_tiles::triangle::foot(&surface, face, pattern, node).normal;
                    let found = areas.at(value, normal);
                    assert!((found - expected).abs() < 1e-4 * expected, "{element:?} {value}: {found} {expected}");
                }
            }
        }
    }
}
