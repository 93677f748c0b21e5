//! Points of a displaced triangle mesh: flat triangles, moved along their interpolated normals.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6. What
//! lies on an edge is computed from the edge alone, in its own direction, and what lies at a vertex from the vertex, so
//! that all faces there have the same points to the bit. Units: object units.

use glam::Vec3;
use half::f16;
use relievo_core::{Error, Result};
use relievo_surface::{TriangleSide, TriangleSurface};

use super::field::TriangleField;
use super::pattern::{Node, Pattern, Slot};
use super::piece::FaceRates;
use super::vectors::Offset;
use crate::texel::Texel;

/// A triangle mesh with its displacement.
#[derive(Clone, Copy, Debug)]
pub struct TriangleDisplaced<'a> {
    surface: &'a TriangleSurface,
    field: &'a TriangleField,
    vectors: Option<&'a TriangleField<Offset>>,
}

/// The undisplaced surface at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The point.
    pub point: Vec3,
    /// The unit normal; zero where there is none.
    pub normal: Vec3,
}

impl Foot {
    /// The undisplaced surface at a vertex of the mesh.
    pub(super) fn at_vertex(surface: &TriangleSurface, vertex: u32) -> Self {
        let [point, normal] = [surface.points(), surface.normals()].map(|of| Vec3::from(of[vertex as usize]));
        Self { point, normal }
    }

    /// `step` of `segments` on the edge from here, its lower vertex, to `high`.
    pub(super) fn toward(&self, high: &Self, step: u32, segments: u32) -> Self {
        let (whole, part) = (segments as f32, step as f32);
        let mean = |low: Vec3, high: Vec3| (low * (whole - part) + high * part) / whole;
        Self { point: mean(self.point, high.point), normal: mean(self.normal, high.normal).normalize_or_zero() }
    }

    /// The place inside a face with these corners whose barycentric coordinates are `weights`, in multiples of 1 / 3T.
    pub(super) fn inside(corners: &[Self; 3], weights: [f32; 3], pattern: Pattern) -> Self {
        let whole = 3.0 * pattern.segments() as f32;
        let mean = |of: [Vec3; 3]| (of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2]) / whole;
        let [a, b, c] = corners;
        let normal = mean([a.normal, b.normal, c.normal]).normalize_or_zero();
        Self { point: mean([a.point, b.point, c.point]), normal }
    }
}

/// The undisplaced surface at a vertex of any pattern laid over `face`.
pub fn foot(surface: &TriangleSurface, face: u32, pattern: Pattern, node: Node) -> Foot {
    let topology = surface.topology();
    match pattern.slot(node) {
        Slot::Corner(corner) => Foot::at_vertex(surface, topology.face(face)[corner as usize]),
        Slot::Side(side, step) => {
            let TriangleSide { edge, reversed } = topology.side(face, side);
            let segments = pattern.segments();
            edge_foot(surface, edge, if reversed { segments - step } else { step }, segments)
        }
        Slot::Inside(_) => {
            let corners = topology.face(face).map(|vertex| Foot::at_vertex(surface, vertex));
            Foot::inside(&corners, pattern.weights(node).map(|weight| weight as f32), pattern)
        }
    }
}

/// The undisplaced surface on an edge, `step` of `segments` from its lower vertex.
pub fn edge_foot(surface: &TriangleSurface, edge: u32, step: u32, segments: u32) -> Foot {
    let [low, high] = surface.topology().edge(edge).map(|vertex| Foot::at_vertex(surface, vertex));
    low.toward(&high, step, segments)
}

/// The undisplaced surface at the place of `face` with barycentric coordinates `at`; what lies on an edge is computed
/// from the edge alone.
pub fn foot_at(surface: &TriangleSurface, face: u32, at: [f32; 3]) -> Foot {
    let topology = surface.topology();
    let corners = topology.face(face);
    let [points, normals] = [surface.points(), surface.normals()];
    let mean = |shares: &[(u32, f32)]| {
        let sum =
            |of: &[[f32; 3]]| shares.iter().map(|(vertex, share)| Vec3::from(of[*vertex as usize]) * *share).sum();
        let (point, normal): (Vec3, Vec3) = (sum(points), sum(normals));
        Foot { point, normal: normal.normalize_or_zero() }
    };
    match (0..3).find(|side| at[(side + 2) % 3] == 0.0) {
        Some(side) => {
            let TriangleSide { edge, reversed } = topology.side(face, side as u32);
            let [low, high] = topology.edge(edge);
            let along = if reversed { 1.0 - at[(side + 1) % 3] } else { at[(side + 1) % 3] };
            mean(&[(low, 1.0 - along), (high, along)])
        }
        None => mean(&[(corners[0], at[0]), (corners[1], at[1]), (corners[2], at[2])]),
    }
}

impl<'a> TriangleDisplaced<'a> {
    /// The surface with a displacement of its own.
    ///
    /// # Errors
    /// Fails if the displacement is one of another mesh.
    pub fn new(surface: &'a TriangleSurface, field: &'a TriangleField) -> Result<Self> {
        let [own, other] = [surface.topology(), field.topology()];
        if (own.face_count(), own.vertex_count()) != (other.face_count(), other.vertex_count()) {
            return Err(Error::invalid("the displacement is that of another mesh")
                .advise("make the displacement from the topology of this surface"));
        }
        Ok(Self { surface, field, vectors: None })
    }

    /// The same moved further, see [`TriangleField::in_object_space`].
    ///
    /// # Errors
    /// Fails if the vectors are those of another mesh.
    pub fn with_vectors(self, vectors: &'a TriangleField<Offset>) -> Result<Self> {
        let [own, other] = [self.field.topology(), vectors.topology()];
        if (own.face_count(), own.vertex_count()) != (other.face_count(), other.vertex_count()) {
            return Err(Error::invalid("the vector displacement is that of another mesh")
                .advise("make it from the topology of this surface"));
        }
        Ok(Self { vectors: Some(vectors), ..self })
    }

    /// How finely a face has to be divided to show its displacement.
    pub fn rates(&self, face: u32) -> FaceRates {
        let rates = FaceRates::of(self.field, face);
        self.vectors.map_or(rates, |vectors| rates.with(FaceRates::of(vectors, face)))
    }

    /// The pattern of the values on an edge, `None` if nothing is.
    pub fn edge_pattern(&self, edge: u32) -> Option<Pattern> {
        let vectors = self.vectors.and_then(|vectors| vectors.edge_pattern(edge));
        self.field.edge_pattern(edge).max(vectors)
    }

    /// Whether a face is not one undisplaced triangle.
    pub fn is_modified(&self, face: u32) -> bool {
        fn corners<T: Texel>(field: &TriangleField<T>, face: u32) -> bool {
            field.topology().face(face).iter().any(|vertex| !field.vertex(*vertex).is_blank(field.blank()))
        }
        !self.rates(face).is_single()
            || corners(self.field, face)
            || self.vectors.is_some_and(|vectors| corners(vectors, face))
    }

    /// The undisplaced surface.
    pub fn surface(&self) -> &'a TriangleSurface {
        self.surface
    }

    /// The displacement.
    pub fn field(&self) -> &'a TriangleField {
        self.field
    }

    /// The vectors that it is moved by further.
    pub fn vectors(&self) -> Option<&'a TriangleField<Offset>> {
        self.vectors
    }

    /// The undisplaced surface and the displacement at a vertex of any pattern laid over `face`.
    pub fn at(&self, face: u32, pattern: Pattern, node: Node) -> (Foot, f32) {
        (foot(self.surface, face, pattern, node), self.field.at(face, pattern, node) as f32)
    }

    /// The displaced point at a vertex of any pattern laid over `face`.
    pub fn point(&self, face: u32, pattern: Pattern, node: Node) -> Vec3 {
        let (foot, height) = self.at(face, pattern, node);
        let point = foot.point + foot.normal * height;
        self.vectors.map_or(point, |vectors| point + vectors.at(face, pattern, node).as_vec3())
    }

    /// From the undisplaced surface to the displaced one at the place of `face` with barycentric coordinates `at`,
    /// where the smooth normal is `normal`.
    pub fn offset(&self, face: u32, at: [f32; 3], normal: Vec3) -> Vec3 {
        let height = normal * self.field.value(face, at) as f32;
        self.vectors.map_or(height, |vectors| height + vectors.value(face, at).as_vec3())
    }

    /// The length of the longest of its vectors.
    pub fn vector_reach(&self) -> f32 {
        let Some(vectors) = self.vectors else { return 0.0 };
        let faces = vectors.allocated().filter_map(|face| vectors.face(face));
        let edges = vectors.allocated_edges().filter_map(|edge| vectors.edge(edge));
        let all = faces.chain(edges).chain(vectors.vertices()).flatten();
        all.map(|vector| vector.value().length() as f32).fold(0.0, f32::max)
    }

    /// The least and the largest displacement in and around `face`, 0 between them.
    pub fn range(&self, face: u32) -> [f32; 2] {
        let topology = self.field.topology();
        let mut range = [0.0f32; 2];
        let mut widen = |values: &[f16]| {
            for value in values {
                let value = value.to_f32();
                range = [range[0].min(value), range[1].max(value)];
            }
        };
        widen(self.field.face(face).unwrap_or(&[]));
        for edge in topology.edges_of(face) {
            widen(self.field.edge(edge).unwrap_or(&[]));
        }
        widen(&topology.face(face).map(|vertex| self.field.vertex(vertex)));
        range
    }
}
