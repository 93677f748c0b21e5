//! The triangles of a face of a displaced or painted triangle mesh.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.4: an
//! untouched face stays one triangle. A face with a block has the triangles of its pattern; where an edge is finer, the
//! outermost strip is stitched to it. A face without a block beside edges with one is a fan: from the opposite corner
//! if it is one edge, else from the centroid. Both faces of an edge thus have the same vertices on it, without cracks.

use super::displaced::TriangleDisplaced;
use super::field::{TriangleField, barycentric};
use super::normals::TriangleNormals;
use super::pattern::{Node, Pattern, Slot};
use crate::texel::Texel;

/// How finely a face is divided: segments along its sides, and of the pattern inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceRates {
    /// Segments along each side, 1 where the edge is not divided.
    pub sides: [u32; 3],
    /// The pattern inside, if there is one. It has no more segments than any side.
    pub inside: Option<Pattern>,
}

impl FaceRates {
    /// An untouched face.
    pub const SINGLE: Self = Self { sides: [1; 3], inside: None };

    /// What the blocks of `field` need.
    pub fn of<T: Texel>(field: &TriangleField<T>, face: u32) -> Self {
        let topology = field.topology();
        let side = |edge: u32| field.edge_pattern(edge).map_or(1, Pattern::segments);
        Self { sides: topology.edges_of(face).map(side), inside: field.face_pattern(face) }
    }

    /// What both need.
    pub fn with(self, other: Self) -> Self {
        Self {
            sides: [0, 1, 2].map(|side| self.sides[side].max(other.sides[side])),
            inside: self.inside.max(other.inside),
        }
    }

    /// Whether the face is one triangle.
    pub fn is_single(&self) -> bool {
        *self == Self::SINGLE
    }

    /// Where the vertices are, each with a pattern that has it: around the border from corner 0, then inside.
    pub fn places(&self) -> Vec<(Pattern, Node)> {
        let mut places = Vec::new();
        for (side, segments) in (0..).zip(self.sides) {
            let pattern = if segments == 1 { Pattern::COARSEST } else { Pattern::of_power(segments) };
            places.extend((0..segments).map(|step| (pattern, pattern.node(0, side, step))));
        }
        match self.inside {
            Some(pattern) => {
                let values = 0..pattern.face_values() as u32;
                places.extend(values.map(|index| (pattern, pattern.at_slot(Slot::Inside(index)))));
            }
            None if self.is_from_center() => {
                places.push((Pattern::COARSEST, Pattern::COARSEST.at_slot(Slot::Inside(0))));
            }
            None => {}
        }
        places
    }

    fn is_from_center(&self) -> bool {
        self.inside.is_none() && self.sides.iter().filter(|side| **side > 1).count() > 1
    }

    /// Vertices on the border.
    pub fn border(&self) -> u32 {
        self.sides.iter().sum()
    }

    /// The triangles, counter-clockwise, as indices of [`Self::places`].
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let border = self.border();
        let start = [0, self.sides[0], self.sides[0] + self.sides[1]];
        let outer = |side: usize, step: u32| (start[side] + step) % border;
        let Some(pattern) = self.inside else {
            if self.is_from_center() {
                return (0..border).map(|at| [at, (at + 1) % border, border]).collect();
            }
            let long = (0..3).find(|side| self.sides[*side] > 1).unwrap_or(0);
            let tip = start[(long + 2) % 3];
            return (0..self.sides[long]).map(|step| [outer(long, step), outer(long, step + 1), tip]).collect();
        };
        let inner = |node: Node| match pattern.slot(node) {
            Slot::Inside(index) => border + index,
            Slot::Corner(corner) => start[corner as usize],
            Slot::Side(side, step) => outer(side as usize, step),
        };
        let mut triangles = Vec::new();
        for side in 0..3 {
            let segments = self.sides[side];
            let at = |number: u32| match number.checked_sub(segments + 1) {
                Some(step) => inner(pattern.node(1, side as u32, step)),
                None => outer(side, number),
            };
            triangles.extend(border_strip(pattern, segments).into_iter().map(|triangle| triangle.map(at)));
        }
        let deeper = (1..pattern.center()).flat_map(|ring| (0..3).flat_map(move |side| pattern.strip(ring, side)));
        triangles.extend(deeper.map(|triangle| triangle.map(inner)));
        triangles
    }
}

/// The triangles, counter-clockwise, between a side of a face that is divided into `segments` and ring 1 of the pattern
/// inside. Vertices are those of the side, then those of the ring beside it.
pub fn border_strip(pattern: Pattern, segments: u32) -> Vec<[u32; 3]> {
    let (own, last) = (pattern.segments(), pattern.segments() - 2);
    let ring = |step: u32| segments + 1 + step;
    if segments == own {
        let number = |node: Node| match node {
            Node { ring: 0, side: 0, step } => step,
            Node { ring: 0, .. } => segments,
            // The ring's other corner starts its next side; the centroid has no other.
            Node { side, step, .. } => ring(if side == 0 { step } else { last }),
        };
        return pattern.strip(0, 0).map(|triangle| triangle.map(number)).collect();
    }
    let mut triangles = Vec::with_capacity((segments + last) as usize);
    let (mut i, mut k) = (0, 0);
    while k < segments || i < last {
        // Step i of the ring is beside i + 1 of the pattern's own border. Middles of the next steps, times 2 · both
        // counts.
        let outer_next = (2 * k + 1) * own;
        let inner_next = (2 * i + 3) * segments;
        if k < segments && (i == last || outer_next <= inner_next) {
            triangles.push([k, k + 1, ring(i)]);
            k += 1;
        } else {
            triangles.push([ring(i), k, ring(i + 1)]);
            i += 1;
        }
    }
    triangles
}

/// The triangles of one face, with what is known at their vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrianglePiece {
    /// Positions in object space: the border from corner 0 around, then the inside.
    pub points: Vec<[f32; 3]>,
    /// Unit normals; zero where there is none.
    pub normals: Vec<[f32; 3]>,
    /// Barycentric coordinates.
    pub places: Vec<[f32; 3]>,
    /// Triangles, wound as the face is.
    pub triangles: Vec<[u32; 3]>,
    /// How many of the points, at the beginning, are on the border.
    pub border: usize,
}

impl TrianglePiece {
    /// The triangles of `face` at `rates`, displaced, with `normals`.
    pub fn new(displaced: &TriangleDisplaced<'_>, normals: &TriangleNormals, face: u32, rates: &FaceRates) -> Self {
        let places = rates.places();
        let at = |(pattern, node): &(Pattern, Node)| {
            let normal = normals.at(displaced.surface(), face, *pattern, *node);
            (displaced.point(face, *pattern, *node).to_array(), normal.to_array())
        };
        let (points, normals) = places.iter().map(at).unzip();
        Self {
            points,
            normals,
            places: places.iter().map(|(pattern, node)| barycentric(*pattern, *node)).collect(),
            triangles: rates.triangles(),
            border: rates.border() as usize,
        }
    }

    /// The value of a channel at every vertex.
    pub fn values<T: Texel>(field: &TriangleField<T>, face: u32, rates: &FaceRates) -> Vec<T::Value> {
        rates.places().into_iter().map(|(pattern, node)| field.at(face, pattern, node)).collect()
    }
}
