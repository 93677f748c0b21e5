//! Shortest paths on a surface by unfolding (Xin and Wang 2007).
//!
//! A path of edges (Dijkstra 1959, guided by the straight distance) is shortened until it is straight everywhere. Where
//! it passes a vertex with an angle below π on one side, it is led around that vertex on that side; the faces it then
//! crosses are unfolded into the plane, where the shortest path is found by a funnel (Lee and Preparata 1984). Each step
//! shortens the path, so that the end is a path that no small change shortens. It need not be the shortest of all.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use relievo_core::{Error, Mesh, Result};

use crate::map::energy::Vec2;
use crate::pins::{Place, insert};
use crate::surface::{NONE, Surface, Vec3, between, dot, length, minus, previous};

/// Angles this much below π count as straight.
const STRAIGHT: f64 = 1e-9;

/// An edge that a path crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The half-edge by which the path leaves a face.
    pub half: u32,
    /// Where: 0 at its origin, 1 at its target.
    pub share: f64,
}

/// A path through vertices, straight between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// The vertices that the path runs through, from the first to the last.
    pub vertices: Vec<u32>,
    /// The edges crossed between one vertex and the next; none where the path follows an edge.
    pub spans: Vec<Vec<Crossing>>,
}

impl Path {
    /// Returns the points of the path.
    pub fn points(&self, surface: &Surface) -> Vec<Vec3> {
        let mut points = vec![surface.points[self.vertices[0] as usize]];
        for (span, vertex) in self.spans.iter().zip(&self.vertices[1..]) {
            points.extend(span.iter().map(|crossing| crossing.point(surface)));
            points.push(surface.points[*vertex as usize]);
        }
        points
    }

    /// Returns the length of the path.
    pub fn length(&self, surface: &Surface) -> f64 {
        self.points(surface).windows(2).map(|pair| length(minus(pair[1], pair[0]))).sum()
    }
}

impl Crossing {
    /// Returns the point of the crossing.
    pub fn point(&self, surface: &Surface) -> Vec3 {
        let (from, to) = (surface.origin(self.half), surface.target(self.half));
        between(surface.points[from as usize], surface.points[to as usize], self.share)
    }
}

/// Returns the points of a geodesic between two places of a mesh of triangles: both places, and between them the points where
/// it crosses edges. No small change shortens it; a way around another side of the mesh may be shorter.
///
/// # Errors
/// The mesh is unusable, a place does not exist, no path joins the places, or as [`geodesic`].
pub fn shortest_path(mesh: &Mesh, places: [Place; 2]) -> Result<Vec<Vec3>> {
    let (surface, vertices) = insert(Surface::new(mesh)?, &places)?;
    let path = geodesic(&surface, vertices[0], vertices[1])?.ok_or_else(|| {
        Error::invalid("no path joins the places").at("geodesic").advise("give places on one component of the mesh")
    })?;
    Ok(path.points(&surface))
}

/// Returns a geodesic between two vertices, or `None` where no path joins them.
///
/// # Errors
/// Shortening does not come to an end, which points to faces with lengths that contradict each other.
pub fn geodesic(surface: &Surface, from: u32, to: u32) -> Result<Option<Path>> {
    let Some(vertices) = edge_path(surface, from, to) else {
        return Ok(None);
    };
    let spans = vec![Vec::new(); vertices.len() - 1];
    let mut path = Path { vertices, spans };
    let limit = 1000 + 100 * path.vertices.len();
    let mut steps = 0;
    let mut at = 1;
    while at + 1 < path.vertices.len() {
        let Some(fan) = detour(surface, &path, at) else {
            at += 1;
            continue;
        };
        steps += 1;
        if steps > limit {
            return Err(
                Error::invalid("a shortest path on the mesh does not come to an end").advise("repair the mesh first")
            );
        }
        let mut sleeve: Vec<u32> = path.spans[at - 1].iter().map(|crossing| crossing.half).collect();
        for half in fan.into_iter().chain(path.spans[at].iter().map(|crossing| crossing.half)) {
            // Leaving a face by the edge it was entered by is no way on.
            if sleeve.last().is_some_and(|last| surface.mates[*last as usize] == half) {
                sleeve.pop();
            } else {
                sleeve.push(half);
            }
        }
        let straight = unfolded(surface, path.vertices[at - 1], &sleeve, path.vertices[at + 1]);
        let inner = straight.vertices.len() - 2;
        path.vertices.splice(at..=at, straight.vertices[1..=inner].iter().copied());
        path.spans.splice(at - 1..=at, straight.spans);
        at = at.saturating_sub(1).max(1);
    }
    Ok(Some(path))
}

/// A shortest path along edges.
fn edge_path(surface: &Surface, from: u32, to: u32) -> Option<Vec<u32>> {
    let mut distance = vec![f64::INFINITY; surface.points.len()];
    let mut before = vec![NONE; surface.points.len()];
    let mut is_done = vec![false; surface.points.len()];
    let mut queue = BinaryHeap::new();
    distance[from as usize] = 0.0;
    // Distances are positive: their bits sort as they do.
    queue.push(Reverse((surface.distance(from, to).to_bits(), from)));
    while let Some(Reverse((_, vertex))) = queue.pop() {
        if vertex == to {
            break;
        }
        if std::mem::replace(&mut is_done[vertex as usize], true) {
            continue;
        }
        let mut visit = |other: u32| {
            let way = distance[vertex as usize] + surface.distance(vertex, other);
            if way < distance[other as usize] {
                distance[other as usize] = way;
                before[other as usize] = vertex;
                queue.push(Reverse(((way + surface.distance(other, to)).to_bits(), other)));
            }
        };
        for half in surface.fan(vertex) {
            visit(surface.target(half));
            if surface.mates[previous(half) as usize] == NONE {
                visit(surface.origin(previous(half)));
            }
        }
    }
    if from != to && before[to as usize] == NONE {
        return None;
    }
    let mut path = vec![to];
    while path[path.len() - 1] != from {
        path.push(before[path[path.len() - 1] as usize]);
    }
    path.reverse();
    Some(path)
}

/// The directions of a path at a vertex: twice the number of the neighbour it comes from or leads to, or twice the number
/// of the face plus one, with the angle.
struct Direction {
    place: usize,
    angle: f64,
}

/// The half-edges to cross around the vertex `at` of the path, where that shortens it.
fn detour(surface: &Surface, path: &Path, at: usize) -> Option<Vec<u32>> {
    let vertex = path.vertices[at];
    let center = surface.points[vertex as usize];
    let fan: Vec<u32> = surface.fan(vertex).collect();
    let is_open = surface.is_boundary(vertex);
    // The angle at which each neighbour lies, and the sum.
    let mut angles = vec![0.0];
    for half in &fan {
        let (a, b) = (surface.target(*half), surface.origin(previous(*half)));
        let sum = angles[angles.len() - 1];
        angles.push(sum + angle(center, surface.points[a as usize], surface.points[b as usize]));
    }
    let total = angles[fan.len()];

    let direction = |neighbour: u32, crossing: Option<(u32, Vec3)>| -> Option<Direction> {
        if let Some((face, point)) = crossing {
            let place = fan.iter().position(|half| half / 3 == face)?;
            let first = surface.points[surface.target(fan[place]) as usize];
            return Some(Direction { place: 2 * place + 1, angle: angles[place] + angle(center, first, point) });
        }
        let last = fan.last().map(|half| surface.origin(previous(*half)));
        let place = fan.iter().position(|half| surface.target(*half) == neighbour);
        let place = place.or_else(|| (is_open && last == Some(neighbour)).then_some(fan.len()))?;
        Some(Direction { place: 2 * place, angle: angles[place] })
    };
    let entered = path.spans[at - 1].last().map(|last| (surface.mates[last.half as usize] / 3, last.point(surface)));
    let left = path.spans[at].first().map(|first| (first.half / 3, first.point(surface)));
    let from = direction(path.vertices[at - 1], entered)?;
    let to = direction(path.vertices[at + 1], left)?;

    let mut ahead = to.angle - from.angle;
    let mut behind = -ahead;
    if !is_open {
        ahead = if ahead < 0.0 { ahead + total } else { ahead };
        behind = total - ahead;
    }
    let count = fan.len();
    let can_go = |angle: f64| (0.0..std::f64::consts::PI - STRAIGHT).contains(&angle);
    // The neighbours strictly between the two directions.
    if can_go(ahead) && (behind < 0.0 || ahead <= behind) {
        let end = if to.angle < from.angle { to.place + 2 * count } else { to.place };
        let passed = (from.place / 2 + 1..).take_while(|place| 2 * place < end);
        return Some(passed.map(|place| previous(fan[(place - 1) % count])).collect());
    }
    if can_go(behind) {
        let start = if from.angle < to.angle { from.place + 2 * count } else { from.place };
        let passed = (to.place / 2 + 1..).take_while(|place| 2 * place < start);
        let mut passed: Vec<u32> = passed.map(|place| fan[place % count]).collect();
        passed.reverse();
        return Some(passed);
    }
    None
}

fn angle(center: Vec3, a: Vec3, b: Vec3) -> f64 {
    let (u, v) = (minus(a, center), minus(b, center));
    let lengths = length(u) * length(v);
    if lengths > 0.0 { length(crate::surface::cross(u, v)).atan2(dot(u, v)) } else { 0.0 }
}

/// An edge of the unfolded faces: its vertices left and right of the path, with their places in the plane.
struct Portal {
    half: u32,
    left: (u32, Vec2),
    right: (u32, Vec2),
}

/// Unfolds the faces before, between and after the crossed half-edges, and returns the shortest path in them.
fn unfolded(surface: &Surface, from: u32, sleeve: &[u32], to: u32) -> Path {
    let Some(first) = sleeve.first() else {
        return Path { vertices: vec![from, to], spans: vec![Vec::new()] };
    };
    let place = |a: (u32, Vec2), b: (u32, Vec2), apex: u32, side: f64| -> Vec2 {
        let base = (b.1[0] - a.1[0]).hypot(b.1[1] - a.1[1]).max(f64::MIN_POSITIVE);
        let axis = [(b.1[0] - a.1[0]) / base, (b.1[1] - a.1[1]) / base];
        let (origin, end) = (surface.points[a.0 as usize], surface.points[b.0 as usize]);
        let (way, edge) = (minus(surface.points[apex as usize], origin), minus(end, origin));
        let along = dot(way, edge) / base;
        let height = side * (dot(way, way) - along * along).max(0.0).sqrt();
        [a.1[0] + along * axis[0] - height * axis[1], a.1[1] + along * axis[1] + height * axis[0]]
    };
    let start = (from, [0.0; 2]);
    let right = surface.origin(*first);
    let right = (right, [surface.distance(from, right), 0.0]);
    let left = surface.target(*first);
    let left = (left, place(start, right, left, 1.0));
    let mut portals = vec![Portal { half: *first, left, right }];
    for (half, following) in sleeve.iter().zip(sleeve[1..].iter().map(Some).chain([None])) {
        let Portal { left, right, .. } = portals[portals.len() - 1];
        let apex = surface.origin(previous(surface.mates[*half as usize]));
        let apex = (apex, place(left, right, apex, 1.0));
        match following {
            Some(half) if surface.target(*half) == left.0 => portals.push(Portal { half: *half, left, right: apex }),
            Some(half) => portals.push(Portal { half: *half, left: apex, right }),
            None => portals.push(Portal { half: NONE, left: (to, apex.1), right: (to, apex.1) }),
        }
    }
    funnel(start, &portals)
}

/// The shortest path through portals; the last portal is the goal.
fn funnel(start: (u32, Vec2), portals: &[Portal]) -> Path {
    let side = |a: Vec2, b: Vec2, c: Vec2| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let goal = portals.len() - 1;
    // Corners of the path with the portal they lie at; the start lies before all portals.
    let mut corners: Vec<((u32, Vec2), isize)> = vec![(start, -1)];
    let (mut apex, mut left, mut right) = (start, start, start);
    let (mut left_at, mut right_at) = (-1_isize, -1_isize);
    let mut index = 0;
    while index <= goal {
        let portal = &portals[index];
        if side(apex.1, right.1, portal.right.1) >= 0.0 {
            if right.0 == apex.0 || left.0 == apex.0 || side(apex.1, left.1, portal.right.1) < 0.0 {
                (right, right_at) = (portal.right, index as isize);
            } else {
                corners.push((left, left_at));
                (apex, right, right_at) = (left, left, left_at);
                index = (left_at + 1) as usize;
                continue;
            }
        }
        if side(apex.1, left.1, portal.left.1) <= 0.0 {
            if left.0 == apex.0 || right.0 == apex.0 || side(apex.1, right.1, portal.left.1) > 0.0 {
                (left, left_at) = (portal.left, index as isize);
            } else {
                corners.push((right, right_at));
                (apex, left, left_at) = (right, right, right_at);
                index = (right_at + 1) as usize;
                continue;
            }
        }
        index += 1;
    }
    if corners[corners.len() - 1].0.0 != portals[goal].left.0 {
        corners.push((portals[goal].left, goal as isize));
    }
    let mut path = Path { vertices: vec![start.0], spans: Vec::new() };
    for pair in corners.windows(2) {
        let ((a, from), (b, until)) = (pair[0], pair[1]);
        let passed = portals[(from + 1) as usize..until as usize].iter();
        let passed =
            passed.filter(|portal| [portal.left.0, portal.right.0].iter().all(|end| *end != a.0 && *end != b.0));
        let span = passed.map(|portal| {
            let (below, above) = (side(a.1, b.1, portal.right.1), side(a.1, b.1, portal.left.1));
            let share = if above == below { 0.5 } else { below / (below - above) };
            Crossing { half: portal.half, share: share.clamp(0.0, 1.0) }
        });
        path.spans.push(span.collect());
        path.vertices.push(b.0);
    }
    path
}
