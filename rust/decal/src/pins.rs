//! Pins: points of the image with the places of the surface they belong to, inserted into the surface as vertices.

use std::collections::HashMap;

use relievo_core::{Error, Result};

use crate::map::energy::Vec2;
use crate::surface::{NONE, Surface, Vec3, cross, dot, minus};

/// Barycentric coordinates below this are zero: the pin lies on an edge or a vertex.
const SNAPPED: f64 = 1e-7;

/// A place on a triangle of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The face.
    pub face: u32,
    /// Barycentric coordinates: the weights of its three corners. They are scaled to a sum of 1.
    pub barycentric: [f64; 3],
}

/// A point of the image and the place of the surface it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// The point in pixels, from the lower left corner of the image.
    pub image: Vec2,
    /// The place on the mesh.
    pub place: Place,
}

/// Names a pin in an error.
pub fn name(pin: usize) -> String {
    format!("pin {pin}")
}

/// Returns the surface with a vertex at each place, and those vertices.
///
/// # Errors
/// A place does not exist or is on a hole, or two are the same. The error names the pins.
pub fn insert(surface: Surface, places: &[Place]) -> Result<(Surface, Vec<u32>)> {
    let counts = [surface.points.len(), surface.triangles.len()];
    let mut cells = Cells { surface, counts, parts: HashMap::new() };
    // A place on an edge divides two faces, or more where other places have divided them before.
    let Surface { points, triangles, sources, .. } = &mut cells.surface;
    points.reserve_exact(places.len());
    triangles.reserve_exact(4 * places.len());
    sources.reserve_exact(4 * places.len());
    let mut vertices: Vec<u32> = Vec::with_capacity(places.len());
    let mut pin_of = HashMap::with_capacity(places.len());
    for (pin, place) in places.iter().enumerate() {
        let vertex = cells.insert(*place).map_err(|error| error.at(name(pin)))?;
        if let Some(other) = pin_of.insert(vertex, pin) {
            return Err(Error::invalid(format!("it is at the same place as pin {other}"))
                .at(name(pin))
                .advise("move or remove one of them"));
        }
        vertices.push(vertex);
    }
    let Cells { surface, counts, .. } = cells;
    if surface.points.len() == counts[0] {
        return Ok((surface, vertices));
    }
    let Surface { points, triangles, sources, holes, mates, leaving } = surface;
    // Edges are joined anew, which takes memory.
    drop((mates, leaving));
    Ok((Surface::from_triangles(points, triangles, sources, holes), vertices))
}

/// Triangles of a surface that are split at pins.
struct Cells {
    /// Its edges are those of the surface as it was.
    surface: Surface,
    /// Its points and triangles as it was.
    counts: [usize; 2],
    /// Of each triangle that was split, its corners as they were and its parts.
    parts: HashMap<u32, ([u32; 3], Vec<u32>)>,
}

impl Cells {
    fn insert(&mut self, place: Place) -> Result<u32> {
        let Place { face, barycentric } = place;
        if face as usize >= self.counts[1] {
            return Err(Error::invalid(format!("face {face} does not exist"))
                .advise(format!("use faces from 0 to {}", self.counts[1].saturating_sub(1))));
        }
        if self.surface.is_hole(face) {
            return Err(Error::invalid(format!("face {face} is a hole")).advise("move the place onto a face beside it"));
        }
        let sum: f64 = barycentric.iter().sum();
        let is_usable = barycentric.iter().all(|weight| weight.is_finite() && *weight >= -1e-6) && sum > 1e-6;
        if !is_usable {
            return Err(Error::invalid(format!("the weights {barycentric:?} are no place on face {face}"))
                .advise("give three weights that are not negative and do not vanish together"));
        }
        let weights = barycentric.map(|weight| weight.max(0.0) / sum);
        let (corners, parts) = self.whole(face);
        let on_edge: Vec<usize> = (0..3).filter(|corner| weights[*corner] > SNAPPED).collect();
        if let [corner] = on_edge[..] {
            return Ok(corners[corner]);
        }
        let positions = corners.map(|vertex| self.surface.points[vertex as usize]);
        let point: Vec3 =
            std::array::from_fn(|axis| (0..3).map(|corner| weights[corner] * positions[corner][axis]).sum());

        let best = parts.iter().map(|part| (*part, self.weights(*part, point)));
        let least = |weights: &[f64; 3]| weights.iter().fold(f64::INFINITY, |least, weight| least.min(*weight));
        let best = best.max_by(|a, b| least(&a.1).total_cmp(&least(&b.1)));
        let Some((part, weights)) = best else {
            return Err(Error::internal("a face has no parts"));
        };
        let vertices = self.surface.triangles[part as usize];
        let away: Vec<usize> = (0..3).filter(|corner| weights[*corner] > SNAPPED).collect();
        match away[..] {
            [corner] => Ok(vertices[corner]),
            [first, second] => {
                let (a, b) = (vertices[first], vertices[second]);
                Ok(self.split_edge(face, a, b, point))
            }
            _ => Ok(self.split_part(face, part, point)),
        }
    }

    /// The corners of a triangle of the surface as it was, and the triangles that are its parts now.
    fn whole(&self, face: u32) -> ([u32; 3], Vec<u32>) {
        let unsplit = || (self.surface.triangles[face as usize], vec![face]);
        self.parts.get(&face).cloned().unwrap_or_else(unsplit)
    }

    /// Barycentric coordinates of a point in the plane of a triangle.
    fn weights(&self, part: u32, point: Vec3) -> [f64; 3] {
        let [a, b, c] = self.surface.corners(part);
        let normal = cross(minus(b, a), minus(c, a));
        let whole = dot(normal, normal);
        if whole <= 0.0 {
            return [f64::NEG_INFINITY; 3];
        }
        let share = |from: Vec3, to: Vec3| dot(normal, cross(minus(to, from), minus(point, from))) / whole;
        [share(b, c), share(c, a), share(a, b)]
    }

    /// Puts triangles in place of a part of a face.
    fn divide(&mut self, face: u32, part: u32, made: &[[u32; 3]]) {
        let (corners, mut parts) = self.whole(face);
        let Surface { triangles, sources, .. } = &mut self.surface;
        triangles[part as usize] = made[0];
        for triangle in &made[1..] {
            parts.push(triangles.len() as u32);
            triangles.push(*triangle);
            sources.push(sources[face as usize]);
        }
        self.parts.insert(face, (corners, parts));
    }

    fn split_part(&mut self, face: u32, part: u32, point: Vec3) -> u32 {
        let vertex = self.surface.points.len() as u32;
        self.surface.points.push(point);
        let [a, b, c] = self.surface.triangles[part as usize];
        self.divide(face, part, &[[a, b, vertex], [b, c, vertex], [c, a, vertex]]);
        vertex
    }

    /// Splits the edge in the parts of a face and of its neighbours.
    fn split_edge(&mut self, face: u32, a: u32, b: u32, point: Vec3) -> u32 {
        let vertex = self.surface.points.len() as u32;
        self.surface.points.push(point);
        let mates = (3 * face..3 * face + 3).map(|half| self.surface.mates[half as usize]);
        let faces: Vec<u32> = mates.filter(|mate| *mate != NONE).map(|mate| mate / 3).chain([face]).collect();
        for face in faces {
            for part in self.whole(face).1 {
                let triangle = self.surface.triangles[part as usize];
                let edge = (0..3).find(|corner| {
                    let (from, to) = (triangle[*corner], triangle[(corner + 1) % 3]);
                    (from, to) == (a, b) || (from, to) == (b, a)
                });
                if let Some(edge) = edge {
                    let (from, to, apex) = (triangle[edge], triangle[(edge + 1) % 3], triangle[(edge + 2) % 3]);
                    self.divide(face, part, &[[from, vertex, apex], [vertex, to, apex]]);
                }
            }
        }
        vertex
    }
}
