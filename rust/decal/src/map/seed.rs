//! The seed of the patch: the surface between the pins, mapped into the image (the paper's Section 4).

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use relievo_core::{Error, Result};

use crate::map::embed::embed;
use crate::map::energy::{Vec2, distance};
use crate::map::graph::Graph;
use crate::map::patch::Patch;
use crate::paths::cut::{Cut, Meeting, cut, half_edges};
use crate::paths::geodesic::{Path, geodesic};
use crate::pins::name;
use crate::surface::{Surface, dot, length, minus, previous};

/// How many times larger than expected a region between three pins may be.
const TOO_LARGE: f64 = 25.0;

/// A patch between pins on a surface with the paths inserted.
#[derive(Clone, Debug)]
pub struct Seed {
    /// The surface. Vertices of pins keep their numbers.
    pub surface: Arc<Surface>,
    /// The patch. The positions of pins are exact.
    pub patch: Patch,
    /// Pins that the patch holds, with their vertices in it. The others are on bridges of the graph.
    pub pins: Vec<(usize, u32)>,
    /// Units of the plane for a unit of the surface.
    pub scale: f64,
}

impl Seed {
    /// Returns the point in space of a point of the plane, if the patch covers it.
    pub fn point_at(&self, place: Vec2) -> Option<[f64; 3]> {
        self.patch.faces.iter().zip(&self.patch.triangles).find_map(|(face, triangle)| {
            let [a, b, c] = face.map(|vertex| self.patch.positions[vertex as usize]);
            let side = |p: Vec2, q: Vec2| (q[0] - p[0]) * (place[1] - p[1]) - (q[1] - p[1]) * (place[0] - p[0]);
            let weights = [side(b, c), side(c, a), side(a, b)];
            let sum: f64 = weights.iter().sum();
            let corners = self.surface.corners(*triangle);
            let point = |axis: usize| (0..3).map(|corner| weights[corner] * corners[corner][axis]).sum::<f64>() / sum;
            (sum > 0.0 && weights.iter().all(|weight| *weight >= 0.0)).then(|| std::array::from_fn(point))
        })
    }
}

/// Makes the seed of two or more pins. `vertices` are those of the pins, `places` their points in the plane.
///
/// # Errors
/// Pins lie on different components, or paths cross or enclose no region. The error names the pins and proposes another.
pub fn between_pins(surface: &Arc<Surface>, vertices: &[u32], places: &[Vec2], graph: &Graph) -> Result<Seed> {
    let mut paths = Vec::with_capacity(graph.edges.len());
    let (mut on_surface, mut in_image) = (0.0, 0.0);
    for [a, b] in &graph.edges {
        let (a, b) = (*a as usize, *b as usize);
        let path = joined(surface, vertices, a, b)?;
        on_surface += path.length(surface);
        in_image += distance(places[a], places[b]);
        paths.push(path);
    }
    let scale = in_image / on_surface;
    let is_side =
        |edge: &[u32; 2]| graph.triangles.iter().any(|triangle| edge.iter().all(|end| triangle.contains(end)));
    let sides: Vec<usize> = (0..graph.edges.len()).filter(|edge| is_side(&graph.edges[*edge])).collect();
    let inserted: Vec<Path> = sides.iter().map(|side| paths[*side].clone()).collect();
    let pin_vertices: HashSet<u32> = vertices.iter().copied().collect();
    let Cut { surface: divided, parents, paths } = cut(surface, &inserted, &|vertex| pin_vertices.contains(&vertex))
        .map_err(|meeting| crossing(&meeting, &sides, graph, places))?;
    let parts = Parts { surface: &divided, graph, sides: &sides, paths: &paths, vertices, places, scale };
    let (patch, pins) = parts.join()?;
    match undivided(surface, &patch, &parents, vertices) {
        // Without a pin the patch would not know where that corner of the sticker lies.
        Some((patch, held)) if held.len() == pins.len() => {
            Ok(Seed { patch, pins: held, scale, surface: Arc::clone(surface) })
        }
        _ => Ok(Seed { patch, pins, scale, surface: Arc::new(divided) }),
    }
}

/// The patch of the whole triangles in a patch of parts. It has no slivers, which would slow the relaxation down. There is
/// none where the whole triangles form no disk.
fn undivided(surface: &Surface, parts: &Patch, parents: &[u32], pins: &[u32]) -> Option<(Patch, Vec<(usize, u32)>)> {
    let mut counts: HashMap<u32, u32> = HashMap::new();
    for parent in parents {
        *counts.entry(*parent).or_default() += 1;
    }
    for triangle in &parts.triangles {
        if let Some(count) = counts.get_mut(&parents[*triangle as usize]) {
            *count -= 1;
        }
    }
    let mut whole: Vec<u32> = parts.triangles.iter().map(|triangle| parents[*triangle as usize]).collect();
    whole.sort_unstable();
    whole.dedup();
    whole.retain(|triangle| counts.get(triangle) == Some(&0));
    let places: HashMap<u32, Vec2> = parts.vertices.iter().copied().zip(parts.positions.iter().copied()).collect();
    let (mut vertices, mut positions, mut numbers) = (Vec::new(), Vec::new(), HashMap::new());
    let mut faces = Vec::with_capacity(whole.len());
    for triangle in &whole {
        let mut face = [0; 3];
        for (corner, vertex) in surface.triangles[*triangle as usize].into_iter().enumerate() {
            let position = *places.get(&vertex)?;
            face[corner] = *numbers.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                positions.push(position);
                vertices.len() as u32 - 1
            });
        }
        faces.push(face);
    }
    let held = pins.iter().enumerate().filter_map(|(pin, vertex)| Some((pin, *numbers.get(vertex)?)));
    let held: Vec<(usize, u32)> = held.collect();
    Some((Patch::new(vertices, positions, faces, whole).ok()?, held))
}

/// Describes where paths cross, and proposes the pin that keeps them apart.
fn crossing(meeting: &Meeting, sides: &[usize], graph: &Graph, places: &[Vec2]) -> Error {
    let edges = meeting.paths.map(|path| graph.edges[sides[path]]);
    let [[a, b], [c, d]] = edges;
    let middle: Vec2 = std::array::from_fn(|axis| 0.5 * (places[a as usize][axis] + places[b as usize][axis]));
    let [x, y, z] = meeting.point;
    Error::invalid(format!(
        "the paths between pins {a} and {b} and between pins {c} and {d} meet on the surface near ({x:.6}, {y:.6}, {z:.6})"
    ))
    .at(format!("pins {a}, {b}, {c} and {d}"))
    .advise(format!(
        "add a pin for the point ({:.6}, {:.6}) of the image, on the surface beside that place, or move one of the four",
        middle[0], middle[1]
    ))
}

/// The regions between triples of pins.
struct Parts<'a> {
    surface: &'a Surface,
    graph: &'a Graph,
    sides: &'a [usize],
    paths: &'a [Vec<u32>],
    vertices: &'a [u32],
    places: &'a [Vec2],
    scale: f64,
}

impl Parts<'_> {
    fn join(&self) -> Result<(Patch, Vec<(usize, u32)>)> {
        let (mut vertices, mut positions, mut is_fixed) = (Vec::new(), Vec::new(), Vec::new());
        let mut pins = Vec::new();
        let mut pin_at = HashMap::new();
        let triangles = self.largest_component();
        for pin in 0..self.places.len() {
            if triangles.iter().any(|triangle| triangle.contains(&(pin as u32))) {
                pin_at.insert(pin as u32, vertices.len() as u32);
                pins.push((pin, vertices.len() as u32));
                vertices.push(self.vertices[pin]);
                positions.push(self.places[pin]);
                is_fixed.push(true);
            }
        }
        // Vertices of the patch along each path.
        let mut lines = Vec::with_capacity(self.paths.len());
        for (side, path) in self.sides.iter().zip(self.paths) {
            let [a, b] = self.graph.edges[*side];
            let (Some(first), Some(last)) = (pin_at.get(&a), pin_at.get(&b)) else {
                lines.push(Vec::new());
                continue;
            };
            let mut ways = vec![0.0];
            for pair in path.windows(2) {
                ways.push(ways[ways.len() - 1] + self.surface.distance(pair[0], pair[1]));
            }
            let mut line = vec![*first];
            for (vertex, way) in path.iter().zip(&ways).take(path.len() - 1).skip(1) {
                let share = way / ways[ways.len() - 1];
                let (from, to) = (self.places[a as usize], self.places[b as usize]);
                line.push(vertices.len() as u32);
                vertices.push(*vertex);
                positions.push([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]);
                is_fixed.push(true);
            }
            line.push(*last);
            lines.push(line);
        }
        let (mut faces, mut face_triangles) = (Vec::new(), Vec::new());
        for triangle in &triangles {
            let mut border: HashMap<u32, u32> = HashMap::new();
            let mut forward = Vec::new();
            let mut walls = HashSet::new();
            for corner in 0..3 {
                let (from, to) = (triangle[corner], triangle[(corner + 1) % 3]);
                let edge = [from.min(to), from.max(to)];
                let Some(side) = self.sides.iter().position(|side| self.graph.edges[*side] == edge) else {
                    return Err(Error::internal("a side of a region has no path"));
                };
                border.extend(self.paths[side].iter().copied().zip(lines[side].iter().copied()));
                let edges = half_edges(self.surface, &self.paths[side])
                    .ok_or_else(|| Error::internal("a path was not inserted into the surface"))?;
                for edge in edges {
                    let ahead = if from < to { edge.forward } else { edge.backward };
                    walls.extend([edge.forward, edge.backward].into_iter().flatten());
                    forward.push(ahead.ok_or_else(|| self.no_region(*triangle))?);
                }
            }
            let region = self.flood(*triangle, &forward, &walls)?;
            let start = vertices.len();
            for face in &region {
                let face_vertices = self.surface.triangles[*face as usize].map(|vertex| {
                    *border.entry(vertex).or_insert_with(|| {
                        vertices.push(vertex);
                        positions.push([0.0; 2]);
                        is_fixed.push(false);
                        vertices.len() as u32 - 1
                    })
                });
                faces.push(face_vertices);
                face_triangles.push(*face);
            }
            // Edges between the three paths and as many triangles as a disk has.
            let inner = vertices.len() - start;
            if region.len() != forward.len() + 2 * inner - 2 {
                return Err(self.no_region(*triangle));
            }
        }
        embed(self.surface, &faces, &face_triangles, &is_fixed, &mut positions)?;
        Ok((Patch::new(vertices, positions, faces, face_triangles)?, pins))
    }

    /// The triangles of the graph that hang together by edges, of the largest set.
    fn largest_component(&self) -> Vec<[u32; 3]> {
        let mut rest = self.graph.triangles.clone();
        let mut largest = Vec::new();
        while let Some(first) = rest.pop() {
            let mut set = vec![first];
            let mut index = 0;
            while index < set.len() {
                let current = set[index];
                let is_beside = |other: &[u32; 3]| current.iter().filter(|pin| other.contains(pin)).count() == 2;
                let (beside, apart): (Vec<_>, Vec<_>) = rest.into_iter().partition(is_beside);
                set.extend(beside);
                rest = apart;
                index += 1;
            }
            if set.len() > largest.len() {
                largest = set;
            }
        }
        largest.sort_unstable();
        largest
    }

    /// The faces on the left of the paths around three pins.
    fn flood(&self, triangle: [u32; 3], forward: &[u32], walls: &HashSet<u32>) -> Result<Vec<u32>> {
        let [a, b, c] = triangle.map(|pin| self.places[pin as usize]);
        let expected = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        let around: f64 = distance(a, b) + distance(b, c) + distance(c, a);
        let limit = TOO_LARGE * expected.max(0.01 * around * around) / (self.scale * self.scale);
        let mut seen = HashSet::new();
        let mut region = Vec::new();
        let mut queue: Vec<u32> = forward.iter().map(|half| half / 3).collect();
        let mut area = 0.0;
        while let Some(face) = queue.pop() {
            if !seen.insert(face) {
                continue;
            }
            region.push(face);
            area += self.surface.area(face);
            if area > limit {
                return Err(self.no_region(triangle));
            }
            let halves = (3 * face..3 * face + 3).filter(|half| !walls.contains(half));
            queue.extend(halves.filter_map(|half| self.surface.mate(half)).map(|mate| mate / 3));
        }
        region.sort_unstable();
        Ok(region)
    }

    fn no_region(&self, triangle: [u32; 3]) -> Error {
        let [a, b, c] = triangle;
        let middle: Vec2 =
            std::array::from_fn(|axis| triangle.iter().map(|pin| self.places[*pin as usize][axis]).sum::<f64>() / 3.0);
        Error::invalid(
            "the paths between the three pins enclose no part of the surface on their left: the pins run around it the \
             other way than in the image, or a hole lies between them",
        )
        .at(format!("pins {a}, {b} and {c}"))
        .advise(format!(
            "exchange two of the pins, fill the hole, or add a pin for the point ({:.6}, {:.6}) of the image between them",
            middle[0], middle[1]
        ))
    }
}

/// Makes a seed of one face at the pin nearest to the middle, turned so that the geodesic to another pin has the direction
/// it has in the image.
///
/// # Errors
/// Pins lie on different components.
pub fn at_pin(surface: &Arc<Surface>, vertices: &[u32], places: &[Vec2], graph: &Graph) -> Result<Seed> {
    let count = places.len() as f64;
    let middle: Vec2 = std::array::from_fn(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count);
    let nearest =
        (0..places.len()).min_by(|a, b| distance(places[*a], middle).total_cmp(&distance(places[*b], middle)));
    let start = nearest.unwrap_or_default();
    let (mut on_surface, mut in_image) = (0.0, 0.0);
    let mut first = None;
    for edge in graph.edges.iter().filter(|edge| edge.contains(&(start as u32))) {
        let end = (edge[0] + edge[1]) as usize - start;
        let path = joined(surface, vertices, start, end)?;
        on_surface += path.length(surface);
        in_image += distance(places[start], places[end]);
        first.get_or_insert((path, end));
    }
    let Some((path, end)) = first else {
        return Err(Error::internal("a pin has no neighbour in the graph").at(name(start)));
    };
    let scale = in_image / on_surface;
    let face = path.spans[0].first().map(|crossing| crossing.half / 3);
    let along = || {
        let half = surface.fan(vertices[start]).find(|half| surface.target(*half) == path.vertices[1]);
        half.or_else(|| surface.fan(vertices[start]).find(|half| surface.origin(previous(*half)) == path.vertices[1]))
    };
    let Some(face) = face.or_else(|| along().map(|half| half / 3)) else {
        return Err(Error::internal("a path has no face").at(name(start)));
    };
    let target = path.points(surface)[1];
    let direction = [places[end][0] - places[start][0], places[end][1] - places[start][1]];
    let patch = single(surface, face, vertices[start], places[start], target, direction, scale)?;
    let at = patch.vertices.iter().position(|vertex| *vertex == vertices[start]).unwrap_or_default();
    Ok(Seed { surface: Arc::clone(surface), patch, pins: vec![(start, at as u32)], scale })
}

/// The geodesic between two pins.
fn joined(surface: &Surface, vertices: &[u32], a: usize, b: usize) -> Result<Path> {
    geodesic(surface, vertices[a], vertices[b])?.ok_or_else(|| {
        Error::invalid("no path on the surface joins the pins: they are on different components")
            .at(format!("pins {a} and {b}"))
            .advise("move one of them onto the component of the other, or join the components")
    })
}

/// A patch of one face with its vertex at a place and the way to a point of the face in a direction.
pub fn single(
    surface: &Surface,
    face: u32,
    vertex: u32,
    place: Vec2,
    target: [f64; 3],
    direction: Vec2,
    scale: f64,
) -> Result<Patch> {
    let triangle = surface.triangles[face as usize];
    let Some(corner) = triangle.iter().position(|other| *other == vertex) else {
        return Err(Error::internal("a face does not have the vertex of its pin"));
    };
    let order = [corner, (corner + 1) % 3, (corner + 2) % 3];
    let points = order.map(|corner| surface.points[triangle[corner] as usize]);
    let (edge, other, way) = (minus(points[1], points[0]), minus(points[2], points[0]), minus(target, points[0]));
    let base = length(edge).max(f64::MIN_POSITIVE.sqrt());
    // Coordinates along the first edge and across it, towards the third corner.
    let along: [f64; 3] = std::array::from_fn(|axis| edge[axis] / base);
    let flat = |vector: [f64; 3]| {
        let height: [f64; 3] = std::array::from_fn(|axis| other[axis] - dot(other, along) * along[axis]);
        [dot(vector, along), dot(vector, height) / length(height).max(f64::MIN_POSITIVE.sqrt())]
    };
    let way = flat(way);
    let norm = way[0].hypot(way[1]) * direction[0].hypot(direction[1]);
    let (cos, sin) = if norm > 0.0 {
        ((way[0] * direction[0] + way[1] * direction[1]) / norm, (way[0] * direction[1] - way[1] * direction[0]) / norm)
    } else {
        (1.0, 0.0)
    };
    let mut positions = vec![[0.0; 2]; 3];
    for (index, corner) in order.into_iter().enumerate() {
        let [x, y] = flat(minus(points[index], points[0]));
        positions[corner] = [place[0] + scale * (cos * x - sin * y), place[1] + scale * (sin * x + cos * y)];
    }
    Patch::new(triangle.to_vec(), positions, vec![[0, 1, 2]], vec![face])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane of 12 by 12 squares, and the vertex at a point of whole coordinates.
    fn plane() -> Arc<Surface> {
        let at = |x: u32, y: u32| 13 * y + x;
        let points = (0..169).map(|vertex| [f64::from(vertex % 13), f64::from(vertex / 13), 0.0]).collect();
        let squares = (0..144).map(|square| (square % 12, square / 12));
        let triangles = squares.flat_map(|(x, y)| {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            [[a, b, c], [a, c, d]]
        });
        let triangles: Vec<[u32; 3]> = triangles.collect();
        let sources = (0..triangles.len() as u32).collect();
        Arc::new(Surface::from_triangles(points, triangles, sources, Vec::new()))
    }

    #[test]
    fn paths_of_no_region_cross_others_and_those_of_regions_do_not() {
        // Pins 3 and 4 are joined by bridges, whose paths cross each other and a side of the triangle.
        let vertices = [[2, 2], [10, 3], [3, 10], [9, 9], [5, 11]].map(|[x, y]: [u32; 2]| 13 * y + x);
        let places = [[0.0, 0.0], [8.0, 1.0], [1.0, 8.0], [-5.0, 9.0], [12.0, 7.0]];
        let edges = vec![[0, 1], [0, 2], [0, 3], [1, 2], [1, 4]];
        let graph = Graph { edges: edges.clone(), triangles: vec![[0, 1, 2]] };
        let seed = between_pins(&plane(), &vertices, &places, &graph).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(seed.pins.iter().map(|(pin, _)| *pin).collect::<Vec<_>>(), [0, 1, 2]);
        for (pin, vertex) in &seed.pins {
            assert_eq!(seed.patch.positions[*vertex as usize], places[*pin]);
        }
        // The same paths as sides of a second triangle are refused, with the four pins and a proposal.
        let graph = Graph { edges: [edges, vec![[3, 4]]].concat(), triangles: vec![[0, 1, 2], [0, 3, 4]] };
        let error = between_pins(&plane(), &vertices, &places, &graph).expect_err("they cross").to_string();
        for part in ["meet on the surface near", "pins 0, 3, 1 and 2", "add a pin for the point"] {
            assert!(error.contains(part), "{error}");
        }
    }
}
