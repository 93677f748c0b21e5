//! Inserts geodesics into a surface: each crossed edge gets a vertex, and each crossed face is divided along the path.

use std::collections::{BTreeMap, HashMap};

use crate::paths::geodesic::{Crossing, Path};
use crate::surface::{Surface, Vec3, between, cross, length, minus};

/// A crossing this near to the end of an edge moves into the vertex, so that no sliver of a face is cut off.
const SNAPPED: f64 = 1e-3;

/// A surface with paths as edges.
pub struct Cut {
    /// The divided surface. Vertices of the undivided one keep their numbers.
    pub surface: Surface,
    /// The triangle of the undivided surface that each triangle is a part of.
    pub parents: Vec<u32>,
    /// The vertices of each path.
    pub paths: Vec<Vec<u32>>,
}

/// Two paths that cross, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// The numbers of the paths.
    pub paths: [usize; 2],
    /// A point near the crossing.
    pub point: Vec3,
}

/// Inserts paths. `is_pin` names the vertices that belong to pins.
///
/// # Errors
/// Two paths cross or touch elsewhere than in their common ends.
pub fn cut(surface: &Surface, paths: &[Path], is_pin: &dyn Fn(u32) -> bool) -> Result<Cut, Meeting> {
    let mut points = surface.points.clone();
    // New vertices on each edge, by the smaller half-edge: place along that half-edge, vertex.
    let mut on_edges: HashMap<u32, Vec<(f64, u32)>> = HashMap::new();
    // Divisions of each face, with their path.
    let mut chords: BTreeMap<u32, Vec<(u32, u32, usize)>> = BTreeMap::new();
    let mut owner: HashMap<u32, usize> = HashMap::new();
    // Edges that a path follows, by the smaller half-edge.
    let mut followed: BTreeMap<u32, usize> = BTreeMap::new();
    let mut lines = Vec::with_capacity(paths.len());
    for (number, path) in paths.iter().enumerate() {
        let mut line = vec![path.vertices[0]];
        for (index, span) in path.spans.iter().enumerate() {
            let end = path.vertices[index + 1];
            let can_move = |vertex: u32| !is_pin(vertex) && !owner.contains_key(&vertex);
            let moved = moved(surface, span, &can_move);
            for (crossing, moved) in span.iter().zip(moved) {
                let (from, to) = (surface.origin(crossing.half), surface.target(crossing.half));
                let vertex = if let Some(vertex) = moved {
                    vertex
                } else {
                    let share = crossing.share.clamp(1e-6, 1.0 - 1e-6);
                    let mate = surface.mates[crossing.half as usize];
                    let (edge, place) = if crossing.half < mate { (crossing.half, share) } else { (mate, 1.0 - share) };
                    let (from, to) = (surface.points[from as usize], surface.points[to as usize]);
                    points.push(between(from, to, share));
                    on_edges.entry(edge).or_default().push((place, points.len() as u32 - 1));
                    points.len() as u32 - 1
                };
                append(&mut line, vertex, crossing.half / 3, number, &mut chords);
            }
            match span.last() {
                Some(last) => append(&mut line, end, surface.mates[last.half as usize] / 3, number, &mut chords),
                None if line[line.len() - 1] != end => {
                    let last = line[line.len() - 1];
                    let edge = from_to(surface, last, end).or_else(|| from_to(surface, end, last));
                    followed.extend(edge.map(|half| (half.min(surface.mates[half as usize]), number)));
                    line.push(end);
                }
                None => {}
            }
        }
        for vertex in &line[1..line.len() - 1] {
            if is_pin(*vertex) {
                return Err(Meeting { paths: [number; 2], point: points[*vertex as usize] });
            }
            if let Some(other) = owner.insert(*vertex, number) {
                return Err(Meeting { paths: [other, number], point: points[*vertex as usize] });
            }
        }
        lines.push(line);
    }
    for (edge, number) in &followed {
        // An edge that one path follows is divided where another crosses it.
        let crossed = on_edges.get(edge).and_then(|places| places.first());
        if let Some((_, vertex)) = crossed {
            let other = owner.get(vertex).copied().unwrap_or(*number);
            return Err(Meeting { paths: [other.min(*number), other.max(*number)], point: points[*vertex as usize] });
        }
    }
    for places in on_edges.values_mut() {
        places.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    }

    let mut triangles = Vec::with_capacity(surface.triangles.len() + 4 * points.len());
    let mut sources = Vec::with_capacity(triangles.capacity());
    let mut parents = Vec::with_capacity(triangles.capacity());
    for (face, triangle) in surface.triangles.iter().enumerate() {
        let mut polygon = Vec::new();
        for corner in 0..3 {
            polygon.push(triangle[corner]);
            let half = (3 * face + corner) as u32;
            let mate = surface.mates[half as usize];
            if let Some(places) = on_edges.get(&half.min(mate)) {
                let vertices = places.iter().map(|(_, vertex)| *vertex);
                if half < mate { polygon.extend(vertices) } else { polygon.extend(vertices.rev()) }
            }
        }
        let source = surface.sources[face];
        if polygon.len() == 3 {
            triangles.push(*triangle);
            sources.push(source);
            parents.push(face as u32);
            continue;
        }
        let none = Vec::new();
        let chords = chords.get(&(face as u32)).unwrap_or(&none);
        divide(&polygon, chords, &points, &mut triangles)?;
        sources.resize(triangles.len(), source);
        parents.resize(triangles.len(), face as u32);
    }
    Ok(Cut {
        surface: Surface::from_triangles(points, triangles, sources, surface.holes.clone()),
        parents,
        paths: lines,
    })
}

/// The vertex that each crossing moves into. The crossings beside it that lie on edges of that vertex move along, or the
/// path would enclose a spur.
fn moved(surface: &Surface, span: &[Crossing], can_move: &dyn Fn(u32) -> bool) -> Vec<Option<u32>> {
    let ends = |at: usize| [surface.origin(span[at].half), surface.target(span[at].half)];
    let mut moved = vec![None; span.len()];
    for at in 0..span.len() {
        let [from, to] = ends(at);
        let near = if span[at].share < SNAPPED {
            from
        } else if span[at].share > 1.0 - SNAPPED {
            to
        } else {
            continue;
        };
        if moved[at].is_none() && can_move(near) {
            let before = (0..at).rev().take_while(|other| ends(*other).contains(&near));
            let after = (at..span.len()).take_while(|other| ends(*other).contains(&near));
            for other in before.chain(after) {
                moved[other].get_or_insert(near);
            }
        }
    }
    moved
}

fn append(
    line: &mut Vec<u32>,
    vertex: u32,
    face: u32,
    path: usize,
    chords: &mut BTreeMap<u32, Vec<(u32, u32, usize)>>,
) {
    let last = line[line.len() - 1];
    if last != vertex {
        line.push(vertex);
        chords.entry(face).or_default().push((last, vertex, path));
    }
}

/// Divides a convex polygon along chords, and what is left into triangles.
fn divide(
    polygon: &[u32],
    chords: &[(u32, u32, usize)],
    points: &[Vec3],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), Meeting> {
    let count = polygon.len();
    let place = |vertex: u32| polygon.iter().position(|other| *other == vertex);
    for (index, (a, b, path)) in chords.iter().enumerate() {
        let (Some(first), Some(second)) = (place(*a), place(*b)) else {
            // One end lies on each side of a chord that was cut before.
            let other = chords[..index].last().map_or(*path, |other| other.2);
            return Err(Meeting { paths: [other, *path], point: points[*a as usize] });
        };
        let (first, second) = (first.min(second), first.max(second));
        if second - first == 1 || (first == 0 && second == count - 1) {
            continue;
        }
        let inner = &polygon[first..=second];
        let outer: Vec<u32> = polygon[..=first].iter().chain(&polygon[second..]).copied().collect();
        // Of the remaining chords, each belongs to the side that has both of its ends.
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for chord in &chords[index + 1..] {
            let has = |side: &[u32]| side.contains(&chord.0) && side.contains(&chord.1);
            if has(inner) {
                inside.push(*chord);
            } else if has(&outer) {
                outside.push(*chord);
            } else {
                return Err(Meeting { paths: [*path, chord.2], point: points[chord.0 as usize] });
            }
        }
        divide(inner, &inside, points, triangles)?;
        return divide(&outer, &outside, points, triangles);
    }
    fill(polygon, points, triangles);
    Ok(())
}

/// Cuts the best-shaped ear off a convex polygon until a triangle is left.
fn fill(polygon: &[u32], points: &[Vec3], triangles: &mut Vec<[u32; 3]>) {
    let mut rest = polygon.to_vec();
    while rest.len() > 3 {
        let count = rest.len();
        let ear = |at: usize| [rest[(at + count - 1) % count], rest[at], rest[(at + 1) % count]];
        // An ear that leaves corners on one line would make the last triangle flat.
        let quality = |at: usize| {
            let left: Vec<u32> = (0..count).filter(|other| *other != at).map(|other| rest[other]).collect();
            let worst = (0..left.len()).map(|corner| {
                shape([left[corner], left[(corner + 1) % left.len()], left[(corner + 2) % left.len()]], points)
            });
            let widest = worst.fold(0.0, f64::max);
            shape(ear(at), points).min(if widest > 1e-9 { 1.0 } else { 0.0 })
        };
        let best = (0..count).max_by(|a, b| quality(*a).total_cmp(&quality(*b))).unwrap_or_default();
        triangles.push(ear(best));
        rest.remove(best);
    }
    triangles.push([rest[0], rest[1], rest[2]]);
}

/// The ratio of area to the square of the longest edge, scaled to 1 for an equilateral triangle.
fn shape(triangle: [u32; 3], points: &[Vec3]) -> f64 {
    let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
    let edges = [minus(b, a), minus(c, b), minus(a, c)];
    let longest = edges.iter().map(|edge| length(*edge)).fold(0.0, f64::max);
    if longest > 0.0 { length(cross(edges[0], edges[1])) / (longest * longest * 0.75_f64.sqrt()) } else { 0.0 }
}

/// The half-edge from one vertex to another.
fn from_to(surface: &Surface, from: u32, to: u32) -> Option<u32> {
    surface.fan(from).find(|half| surface.target(*half) == to)
}

/// Returns the half-edges of a path of edges, in its direction.
pub fn half_edges(surface: &Surface, path: &[u32]) -> Option<Vec<PathEdge>> {
    path.windows(2)
        .map(|pair| {
            let forward = from_to(surface, pair[0], pair[1]);
            let backward = from_to(surface, pair[1], pair[0]);
            (forward.is_some() || backward.is_some()).then_some(PathEdge { forward, backward })
        })
        .collect()
}

/// An edge of a path with its half-edges, either of which may be missing on a boundary.
#[derive(Clone, Copy, Debug)]
pub struct PathEdge {
    /// The half-edge in the direction of the path: its face is on the left.
    pub forward: Option<u32>,
    /// The other one.
    pub backward: Option<u32>,
}
