//! Decals around one point by the discrete exponential map (Schmidt, Grimm and Wyvill 2006, Section 3).
//!
//! A vertex gets its place from the neighbour through which the shortest path of edges reaches it: the edge, laid into the
//! tangent plane of that neighbour with its length kept, in the frame that was carried there along the path. It costs a
//! fraction of [`crate::lay`] and keeps neither areas nor orientation on surfaces with sharp features: see
//! [`Quality::flips`](crate::Quality::flips).

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use relievo_core::{Mesh, Result};

use crate::decal::{Decal, Frame, Pose, Sticker};
use crate::map::energy::Vec2;
use crate::pins::{Pin, insert, name};
use crate::surface::{NONE, Surface, Vec3, cross, dot, length, minus, previous};

/// Lays a sticker around one pin by the discrete exponential map.
///
/// # Errors
/// The mesh, the pin or the pose is unusable.
pub fn exponential(mesh: &Mesh, sticker: &Sticker, pin: &Pin, pose: Pose) -> Result<Decal> {
    sticker.check(&pin.image).map_err(|error| error.at(name(0)))?;
    let (surface, vertices) = insert(Surface::new(mesh)?, &[pin.place])?;
    let frame = Frame::new(&surface, vertices[0], pose)?;
    Ok(around(&surface, sticker, vertices[0], sticker.place(pin.image), frame, pose.width))
}

/// Lays a sticker around a vertex, whose place in the plane and frame are given.
pub(crate) fn around(
    surface: &Surface,
    sticker: &Sticker,
    vertex: u32,
    place: Vec2,
    frame: Frame,
    width: f64,
) -> Decal {
    // No place of the sticker is farther from the pin than the farthest corner of its bounds.
    let (low, high) = sticker.outline.bounds();
    let reach = (high[0] - place[0]).max(place[0] - low[0]).hypot((high[1] - place[1]).max(place[1] - low[1]));
    let places = spread(surface, vertex, place, frame, width, 1.5 * reach * width);

    let mut numbers: HashMap<u32, u32> = HashMap::new();
    let (mut old, mut positions) = (Vec::new(), Vec::new());
    let (mut faces, mut triangles) = (Vec::new(), Vec::new());
    let mut candidates: Vec<u32> = places.keys().flat_map(|vertex| surface.fan(*vertex)).map(|half| half / 3).collect();
    candidates.sort_unstable();
    candidates.dedup();
    for triangle in candidates {
        let corners = surface.triangles[triangle as usize];
        let Some([a, b, c]) = all(corners.map(|vertex| places.get(&vertex).copied())) else {
            continue;
        };
        let is_pinned = corners.contains(&vertex);
        if !is_pinned && ![(a, b), (b, c), (c, a)].iter().any(|(from, to)| sticker.outline.touches(*from, *to)) {
            continue;
        }
        faces.push(corners.map(|vertex| {
            *numbers.entry(vertex).or_insert_with(|| {
                old.push(vertex);
                positions.push(places[&vertex]);
                old.len() as u32 - 1
            })
        }));
        triangles.push(triangle);
    }
    let pins = vec![numbers.get(&vertex).copied().unwrap_or_default()];
    Decal::assemble(surface, &old, &positions, faces, &triangles, pins, sticker)
}

fn all<T: Copy>(values: [Option<T>; 3]) -> Option<[T; 3]> {
    let [Some(a), Some(b), Some(c)] = values else {
        return None;
    };
    Some([a, b, c])
}

/// The places in the plane of the vertices within a distance along edges, and of their neighbours.
fn spread(surface: &Surface, from: u32, place: Vec2, frame: Frame, width: f64, reach: f64) -> HashMap<u32, Vec2> {
    let mut reached: HashMap<u32, (f64, Vec2, Frame)> = HashMap::new();
    let mut done: HashMap<u32, Vec2> = HashMap::new();
    let mut queue = BinaryHeap::new();
    reached.insert(from, (0.0, place, frame));
    // Distances are positive: their bits sort as they do.
    queue.push(Reverse((0.0_f64.to_bits(), from)));
    while let Some(Reverse((bits, vertex))) = queue.pop() {
        let (distance, place, frame) = reached[&vertex];
        if bits != distance.to_bits() || done.insert(vertex, place).is_some() || distance > reach {
            continue;
        }
        let mut visit = |other: u32| {
            let edge = minus(surface.points[other as usize], surface.points[vertex as usize]);
            let size = length(edge);
            let way = distance + size;
            if reached.get(&other).is_some_and(|known| known.0 <= way) {
                return;
            }
            let flat = [dot(edge, frame.right), dot(edge, frame.up)];
            let norm = flat[0].hypot(flat[1]);
            let scale = if norm > 0.0 { size / (norm * width) } else { 0.0 };
            let position = [place[0] + scale * flat[0], place[1] + scale * flat[1]];
            reached.insert(other, (way, position, frame.carried(Frame::normal(surface, other))));
            queue.push(Reverse((way.to_bits(), other)));
        };
        for half in surface.fan(vertex) {
            visit(surface.target(half));
            if surface.mates[previous(half) as usize] == NONE {
                visit(surface.origin(previous(half)));
            }
        }
    }
    done
}

impl Frame {
    /// Turns the frame so that it has another normal, by the least rotation.
    fn carried(self, normal: Vec3) -> Self {
        let axis = cross(self.normal, normal);
        let cos = dot(self.normal, normal);
        if cos <= -1.0 + 1e-9 {
            // Opposite normals have no least rotation: about the upward direction.
            return Self { normal, up: self.up, right: self.right.map(|value| -value) };
        }
        let turned = |vector: Vec3| -> Vec3 {
            let (first, along) = (cross(axis, vector), dot(axis, vector) / (1.0 + cos));
            std::array::from_fn(|at| cos * vector[at] + first[at] + along * axis[at])
        };
        Self { normal, up: turned(self.up), right: turned(self.right) }
    }
}
