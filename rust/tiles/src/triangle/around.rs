//! What the triangles of a divided face say at its vertices: their areas, displaced and not, of which normals are made,
//! see [`super::normals`].
//!
//! A face whose sides and inside have one pattern takes its triangles and the places inside from a table; points on an
//! edge are computed from the edge alone, as [`super::displaced`] has them.

use std::borrow::Cow;
use std::sync::OnceLock;

use glam::{DVec3, Vec3};
use relievo_surface::TriangleSide;

use super::displaced::{Foot, TriangleDisplaced};
use super::pattern::{Pattern, Slot};
use super::piece::FaceRates;
use super::vectors::Offset;
use crate::texel::Texel;

/// The share of a segment from which on a displacement counts in full.
const FULL: f64 = 1.0 / 64.0;

/// What the triangles around a vertex of the tessellation say: twice the sums of their areas as vectors, displaced and
/// not, the largest displacement among them and the square of the shortest of their sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    displaced: DVec3,
    flat: DVec3,
    height: f32,
    step: f64,
}

impl Around {
    /// What no triangle says.
    pub const NOTHING: Self = Self { displaced: DVec3::ZERO, flat: DVec3::ZERO, height: 0.0, step: f64::INFINITY };

    /// Adds what other triangles around the vertex say.
    pub fn add(&mut self, other: &Self) {
        self.displaced += other.displaced;
        self.flat += other.flat;
        self.height = self.height.max(other.height);
        self.step = self.step.min(other.step);
    }

    /// Returns by how much the normal differs from the smooth one.
    pub fn turn(&self, smooth: Vec3) -> Offset {
        if self.height == 0.0 {
            return Offset::default();
        }
        let full = FULL * self.step.sqrt();
        let share = if full > 0.0 && full.is_finite() { (f64::from(self.height) / full).min(1.0) } else { 1.0 };
        let change = self.displaced.normalize_or_zero() - self.flat.normalize_or_zero();
        let smooth = smooth.as_dvec3();
        let turned = (smooth + change * share).normalize_or(smooth);
        Offset((turned - smooth).as_vec3().to_array())
    }
}

/// What the triangles of a face say.
pub(super) struct Said {
    /// How the face is divided.
    pub rates: FaceRates,
    /// At its vertices along the border, from corner 0.
    pub border: Vec<Around>,
    /// By how much normals inside differ from the smooth ones; empty where they are not asked for.
    pub inside: Vec<Offset>,
}

/// A vertex of a divided face.
struct Vertex {
    flat: DVec3,
    moved: DVec3,
    normal: Vec3,
    height: f32,
}

/// A face with one pattern at its sides and inside.
struct Even {
    /// Barycentric coordinates of the values inside, in multiples of 1 / 3T.
    weights: Vec<[f32; 3]>,
    /// The triangles as [`FaceRates::triangles`] lists them.
    triangles: Vec<[u32; 3]>,
    /// How many of them, the first ones, have a vertex on the border.
    bordering: usize,
}

impl Even {
    /// The face of `rates`, if it is one with a power of two of segments.
    fn of(rates: &FaceRates) -> Option<(Pattern, &'static Self)> {
        static TABLES: [OnceLock<Even>; 6] = [const { OnceLock::new() }; 6];
        let pattern = rates.inside?;
        let segments = pattern.segments();
        if rates.sides != [segments; 3] || !segments.is_power_of_two() {
            return None;
        }
        let make = || {
            let node = |index| pattern.at_slot(Slot::Inside(index));
            let weights = (0..pattern.face_values() as u32).map(|index| pattern.weights(node(index)));
            let (triangles, border) = (rates.triangles(), rates.border());
            let is_inside = |triangle: &[u32; 3]| triangle.iter().all(|at| *at >= border);
            Self {
                weights: weights.map(|it| it.map(|it| it as f32)).collect(),
                bordering: triangles.iter().position(is_inside).unwrap_or(triangles.len()),
                triangles,
            }
        };
        Some((pattern, TABLES.get(segments.ilog2() as usize - 1)?.get_or_init(make)))
    }
}

impl Said {
    /// Adds up what the triangles of `face` say at its border and, where `inside` says so, inside.
    pub fn by(displaced: &TriangleDisplaced<'_>, face: u32, inside: bool) -> Self {
        let rates = displaced.rates(face);
        let even = Even::of(&rates);
        let vertices = vertices(displaced, face, &rates, even);
        let triangles = match even {
            Some((_, even)) if inside => Cow::Borrowed(&even.triangles[..]),
            Some((_, even)) => Cow::Borrowed(&even.triangles[..even.bordering]),
            None => Cow::Owned(rates.triangles()),
        };
        let mut sums = vec![Around::NOTHING; vertices.len()];
        for corners in triangles.iter() {
            let [a, b, c] = corners.map(|at| &vertices[at as usize]);
            let sides = |[a, b, c]: [DVec3; 3]| [b - a, c - b, a - c];
            let (flat, moved) = (sides([a.flat, b.flat, c.flat]), sides([a.moved, b.moved, c.moved]));
            let shortest = flat.iter().map(|side| side.length_squared()).fold(f64::INFINITY, f64::min);
            let says = Around {
                displaced: moved[2].cross(moved[0]),
                flat: flat[2].cross(flat[0]),
                height: a.height.max(b.height).max(c.height),
                // Corners at one place say nothing of lengths.
                step: if shortest > 0.0 { shortest } else { f64::INFINITY },
            };
            corners.iter().for_each(|at| sums[*at as usize].add(&says));
        }
        let border = rates.border() as usize;
        let inside = match (inside, rates.inside) {
            (true, Some(_)) => {
                sums[border..].iter().zip(&vertices[border..]).map(|(sum, at)| sum.turn(at.normal)).collect()
            }
            _ => Vec::new(),
        };
        sums.truncate(border);
        Self { rates, border: sums, inside }
    }
}

/// Returns the vertices of a face, as [`FaceRates::places`] lists them.
fn vertices(
    displaced: &TriangleDisplaced<'_>,
    face: u32,
    rates: &FaceRates,
    even: Option<(Pattern, &Even)>,
) -> Vec<Vertex> {
    let (surface, field) = (displaced.surface(), displaced.field());
    let topology = surface.topology();
    let numbers = topology.face(face);
    let corners = numbers.map(|vertex| Foot::at_vertex(surface, vertex));
    let count = rates.border() as usize + even.map_or(1, |(_, even)| even.weights.len());
    let mut vertices = Vec::with_capacity(count);
    let mut push = |foot: Foot, height: f32, vector: Option<Vec3>| {
        let point = foot.point + foot.normal * height;
        let moved = vector.map_or(point, |vector| point + vector);
        let (flat, height) = (foot.point.as_dvec3(), moved.distance(foot.point));
        vertices.push(Vertex { flat, moved: moved.as_dvec3(), normal: foot.normal, height });
    };
    for (side, segments) in rates.sides.into_iter().enumerate() {
        let vector = displaced.vectors().map(|vectors| vectors.vertex(numbers[side]).value().as_vec3());
        push(corners[side], field.vertex(numbers[side]).to_f32(), vector);
        let TriangleSide { edge, reversed } = topology.side(face, side as u32);
        let (mut low, mut high) = (corners[side], corners[(side + 1) % 3]);
        if reversed {
            std::mem::swap(&mut low, &mut high);
        }
        let heights = field.along(edge, segments);
        let vectors = displaced.vectors().map(|vectors| vectors.along(edge, segments));
        for step in 1..segments {
            let step = if reversed { segments - step } else { step };
            let vector = vectors.as_ref().map(|vectors| vectors(step).as_vec3());
            push(low.toward(&high, step, segments), heights(step) as f32, vector);
        }
    }
    match even {
        Some((pattern, even)) => {
            let heights = field.inside(face, pattern);
            let vectors = displaced.vectors().map(|vectors| vectors.inside(face, pattern));
            for (index, weights) in (0..).zip(&even.weights) {
                let vector = vectors.as_ref().map(|vectors| vectors(index).as_vec3());
                push(Foot::inside(&corners, *weights, pattern), heights(index) as f32, vector);
            }
        }
        None => {
            for (pattern, node) in rates.places().into_iter().skip(rates.border() as usize) {
                let (foot, height) = displaced.at(face, pattern, node);
                let vector = displaced.vectors().map(|vectors| vectors.at(face, pattern, node).as_vec3());
                push(foot, height, vector);
            }
        }
    }
    vertices
}
