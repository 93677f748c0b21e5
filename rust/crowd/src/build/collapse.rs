//! Simplification of a group of clusters over several poses (Section 4.3): edges are collapsed onto one of their ends in the
//! order of the mean distance from planes (quadrics; Garland, Heckbert 1997) in the worst pose, or of the distance of the
//! removed places from what is left there if that is larger.
//!
//! Because vertices stay vertices of the character, skin weights and attributes need no interpolation, and all levels
//! share one list of vertices. A vertex of a removed place becomes the vertex of the same chart at the other end, with the
//! nearest normal.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use glam::{DVec3, Vec3};

use crate::build::places::Places;
use crate::character::Character;

/// Weight of the planes that hold borders and seams, beside that of the triangles.
const EDGE_WEIGHT: f64 = 1.0;
/// Cost of the squared length of an edge beside the squared distance, which decides where the surface is flat.
const LENGTH: f64 = 1e-7;
/// Least cosine between the normals of a triangle before and after a collapse.
const TURN: f32 = 0.2;

/// What a group is simplified with.
pub(crate) struct Input<'a> {
    pub character: &'a Character,
    pub places: &'a Places,
    /// Positions of all vertices in every pose that counts.
    pub posed: &'a [Vec<[f32; 3]>],
    /// Whether a place must stay.
    pub is_locked: &'a (dyn Fn(u32) -> bool + Sync),
}

/// A triangle and its material.
pub(crate) type Face = ([u32; 3], u32);

/// What is left of some triangles.
pub(crate) struct Left {
    pub faces: Vec<Face>,
    /// Removed places, each with the place that it went to.
    pub places: Vec<(u32, u32)>,
    /// Vertices of removed places that the triangles had, each with the vertex in its place.
    pub vertices: Vec<(u32, u32)>,
}

/// A quadric in symmetric form: xx, yy, zz, xy, xz, yz, then the linear part, the constant and the sum of the weights.
#[derive(Clone, Copy, Default)]
struct Quadric([f64; 11]);

impl Quadric {
    /// Adds the square of the distance from a plane, times a weight.
    fn add_plane(&mut self, normal: DVec3, point: DVec3, weight: f64) {
        let [x, y, z] = normal.to_array();
        let d = -normal.dot(point);
        let parts = [x * x, y * y, z * z, x * y, x * z, y * z, x * d, y * d, z * d, d * d, 1.0];
        self.0.iter_mut().zip(parts).for_each(|(sum, part)| *sum += weight * part);
    }

    fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, part)| *sum += part);
    }

    /// Returns the sum of the weights.
    fn weight(&self) -> f64 {
        self.0[10]
    }

    /// Returns the weighted sum of the squared distances of a point.
    fn at(&self, point: DVec3) -> f64 {
        let [xx, yy, zz, xy, xz, yz, x, y, z, c, _] = self.0;
        let p = point;
        let square = xx * p.x * p.x + yy * p.y * p.y + zz * p.z * p.z;
        let mixed = xy * p.x * p.y + xz * p.x * p.z + yz * p.y * p.z;
        square + 2.0 * (mixed + x * p.x + y * p.y + z * p.z) + c
    }
}

/// Returns the squared distance of a point from a triangle (Ericson, Real-Time Collision Detection, 2005, Section 5.1.5).
fn squared(point: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.length_squared();
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.length_squared();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (ap - ab * (d1 / (d1 - d3))).length_squared();
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.length_squared();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (ap - ac * (d2 / (d2 - d6))).length_squared();
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return (bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))).length_squared();
    }
    let scale = 1.0 / (va + vb + vc);
    (ap - ab * (vb * scale) - ac * (vc * scale)).length_squared()
}

/// A collapse of one place onto a neighbour. The cheapest is the greatest, ties go to the lower places.
#[derive(Clone, Copy, PartialEq)]
struct Candidate {
    cost: f64,
    from: u32,
    to: u32,
    /// Whether the cost holds the distances of the removed places.
    is_measured: bool,
    /// Changes of both places when the cost was found.
    stamp: u32,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.from.cmp(&self.from)).then(other.to.cmp(&self.to))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A group while it is simplified. Places are numbered within the group.
pub(crate) struct Work<'a> {
    input: &'a Input<'a>,
    /// Triangles as they were.
    before: Vec<Face>,
    /// The place of the character of every place of the group.
    numbers: Vec<u32>,
    faces: Vec<Face>,
    /// Places of every triangle.
    corners: Vec<[u32; 3]>,
    is_alive: Vec<bool>,
    /// Triangles at every place, some of them no longer alive.
    around: Vec<Vec<u32>>,
    is_locked: Vec<bool>,
    /// Quadrics of every place in each pose, one place after the other.
    quadrics: Vec<Quadric>,
    /// Positions in the same order.
    points: Vec<Vec3>,
    /// Places that were removed for each place, directly or not.
    removed: Vec<Vec<u32>>,
    changes: Vec<u32>,
    queue: BinaryHeap<Candidate>,
    live: usize,
}

impl<'a> Work<'a> {
    /// Begins to simplify some triangles.
    pub fn new(input: &'a Input<'a>, faces: &[Face]) -> Self {
        let place = |vertex: u32| input.places.of[vertex as usize];
        let mut numbers: Vec<u32> = faces.iter().flat_map(|(triangle, _)| triangle.map(place)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let number = |vertex: u32| numbers.binary_search(&place(vertex)).unwrap_or_default() as u32;
        // Triangles that repeat a place have no area in any pose.
        let is_flat =
            |corners: &[u32; 3]| corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
        let (faces, corners): (Vec<Face>, Vec<[u32; 3]>) =
            faces.iter().map(|face| (*face, face.0.map(number))).filter(|(_, corners)| !is_flat(corners)).unzip();
        let mut around = vec![Vec::new(); numbers.len()];
        for (index, triangle) in corners.iter().enumerate() {
            triangle.iter().for_each(|place| around[*place as usize].push(index as u32));
        }
        let points = numbers.iter().flat_map(|place| {
            let vertex = input.places.vertices[*place as usize] as usize;
            input.posed.iter().map(move |points| Vec3::from(points[vertex]))
        });
        let poses = input.posed.len();
        let mut made = Self {
            is_locked: numbers.iter().map(|place| (input.is_locked)(*place)).collect(),
            quadrics: vec![Quadric::default(); numbers.len() * poses],
            points: points.collect(),
            removed: vec![Vec::new(); numbers.len()],
            changes: vec![0; numbers.len()],
            queue: BinaryHeap::new(),
            live: faces.len(),
            is_alive: vec![true; faces.len()],
            numbers,
            before: faces.clone(),
            faces,
            corners,
            around,
            input,
        };
        made.lock_irregular();
        made.add_quadrics();
        for place in 0..made.numbers.len() as u32 {
            made.push_from(place);
        }
        made
    }

    /// Simplifies further and returns about `target` triangles, or more where no collapse is possible. The result is that of a
    /// simplification to `target` triangles from the start.
    pub fn left(&mut self, target: usize) -> Left {
        self.run(target);
        let remaining = || (0..self.before.len()).filter(|face| self.is_alive[*face]);
        let corners = remaining().flat_map(|face| self.before[face].0.into_iter().zip(self.faces[face].0));
        let mut vertices: Vec<(u32, u32)> = corners.filter(|(from, to)| from != to).collect();
        vertices.sort_unstable();
        vertices.dedup_by_key(|(from, _)| *from);
        let number = |place: u32| self.numbers[place as usize];
        let removed = (0..).zip(&self.removed);
        let places = removed.flat_map(|(to, gone)| gone.iter().map(move |from| (number(*from), number(to)))).collect();
        Left { faces: remaining().map(|face| self.faces[face]).collect(), places, vertices }
    }

    fn poses(&self) -> usize {
        self.input.posed.len()
    }

    fn point(&self, place: u32, pose: usize) -> Vec3 {
        self.points[place as usize * self.poses() + pose]
    }

    /// Returns the edges of places with the triangles at each, in order.
    fn edges(&self) -> BTreeMap<(u32, u32), Vec<u32>> {
        let mut edges: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        for (index, corners) in self.corners.iter().enumerate() {
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (corners[from], corners[to]);
                edges.entry((a.min(b), a.max(b))).or_default().push(index as u32);
            }
        }
        edges
    }

    /// Locks places of edges with more than two triangles, or two that are wound against each other, and places where
    /// several fans of triangles meet.
    fn lock_irregular(&mut self) {
        for ((a, b), triangles) in self.edges() {
            let forward = |index: &u32| {
                let corners = self.corners[*index as usize];
                (0..3).any(|at| corners[at] == a && corners[(at + 1) % 3] == b)
            };
            let same = triangles.len() == 2 && forward(&triangles[0]) == forward(&triangles[1]);
            if triangles.len() > 2 || same {
                self.is_locked[a as usize] = true;
                self.is_locked[b as usize] = true;
            }
        }
        for place in 0..self.numbers.len() {
            if !self.is_locked[place] && !self.is_fan(place as u32) {
                self.is_locked[place] = true;
            }
        }
    }

    /// Whether the triangles at a place are one fan, open or closed.
    fn is_fan(&self, place: u32) -> bool {
        let rims: Vec<(u32, u32)> = self.around[place as usize]
            .iter()
            .map(|index| {
                let corners = self.corners[*index as usize];
                let at = corners.iter().position(|corner| *corner == place).unwrap_or_default();
                (corners[(at + 1) % 3], corners[(at + 2) % 3])
            })
            .collect();
        let Some(first) = rims.first() else { return true };
        let start = rims.iter().find(|rim| !rims.iter().any(|other| other.1 == rim.0)).unwrap_or(first);
        let (mut at, mut seen) = (start.1, 1);
        while let Some(next) = rims.iter().find(|rim| rim.0 == at) {
            if next.0 == start.0 {
                break;
            }
            (at, seen) = (next.1, seen + 1);
            if seen > rims.len() {
                return false;
            }
        }
        seen == rims.len()
    }

    fn add_quadrics(&mut self) {
        let poses = self.poses();
        for corners in &self.corners {
            for pose in 0..poses {
                let [a, b, c] = corners.map(|place| self.points[place as usize * poses + pose].as_dvec3());
                let normal = (b - a).cross(c - a);
                let length = normal.length();
                if length > 0.0 {
                    for place in corners {
                        self.quadrics[*place as usize * poses + pose].add_plane(normal / length, a, 0.5 * length);
                    }
                }
            }
        }
        // Borders and seams are held by planes across the triangles.
        for ((a, b), triangles) in self.edges() {
            if triangles.len() == 2 && !self.is_seam(a, b, [triangles[0], triangles[1]]) {
                continue;
            }
            for index in triangles {
                let corners = self.corners[index as usize];
                for pose in 0..poses {
                    let [p, q, r] = corners.map(|place| self.point(place, pose).as_dvec3());
                    let edge = self.point(b, pose).as_dvec3() - self.point(a, pose).as_dvec3();
                    let across = edge.cross((q - p).cross(r - p)).normalize_or_zero();
                    let at = self.point(a, pose).as_dvec3();
                    for place in [a, b] {
                        let weight = EDGE_WEIGHT * edge.length_squared();
                        self.quadrics[place as usize * poses + pose].add_plane(across, at, weight);
                    }
                }
            }
        }
    }

    /// Whether two triangles have different charts or materials along their common edge.
    fn is_seam(&self, a: u32, b: u32, triangles: [u32; 2]) -> bool {
        [a, b].into_iter().any(|place| self.chart(triangles[0], place) != self.chart(triangles[1], place))
    }

    /// Returns the chart and material of a triangle at one of its places.
    fn chart(&self, triangle: u32, place: u32) -> (u32, u32) {
        let (vertices, material) = self.faces[triangle as usize];
        let corners = self.corners[triangle as usize];
        let at = corners.iter().position(|corner| *corner == place).unwrap_or_default();
        (self.input.places.charts[vertices[at] as usize], material)
    }

    fn living(&self, place: u32) -> impl Iterator<Item = u32> {
        self.around[place as usize].iter().copied().filter(|index| self.is_alive[*index as usize])
    }

    fn neighbours(&self, place: u32) -> Vec<u32> {
        let mut found: Vec<u32> =
            self.living(place).flat_map(|index| self.corners[index as usize]).filter(|other| *other != place).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Queues the collapses of a place onto all its neighbours.
    fn push_from(&mut self, from: u32) {
        if self.is_locked[from as usize] {
            return;
        }
        for to in self.neighbours(from) {
            let candidate = self.candidate(from, to);
            self.queue.push(candidate);
        }
    }

    fn candidate(&self, from: u32, to: u32) -> Candidate {
        let poses = self.poses();
        let (first, second) = (from as usize * poses, to as usize * poses);
        let mut cost = 0.0f64;
        for pose in 0..poses {
            let point = self.points[second + pose].as_dvec3();
            let length = point.distance_squared(self.points[first + pose].as_dvec3());
            let (own, other) = (&self.quadrics[first + pose], &self.quadrics[second + pose]);
            let mean =
                (own.at(point) + other.at(point)).max(0.0) / (own.weight() + other.weight()).max(f64::MIN_POSITIVE);
            cost = cost.max(mean + LENGTH * length);
        }
        Candidate { cost, from, to, is_measured: false, stamp: self.changes[from as usize] + self.changes[to as usize] }
    }

    /// Returns the largest squared distance, over all poses, between the surface and what a collapse leaves of it: of the places
    /// that were removed for both ends from the triangles there, and of middles of the triangles that change, and of their edges,
    /// from the triangles before. Returns `floor` if that is larger.
    fn deviation(&self, from: u32, to: u32, floor: f32) -> f32 {
        let moved = |corners: [u32; 3]| corners.map(|corner| if corner == from { to } else { corner });
        let before: Vec<[u32; 3]> = self.living(from).map(|index| self.corners[index as usize]).collect();
        let changed: Vec<[u32; 3]> =
            before.iter().filter(|corners| !corners.contains(&to)).map(|corners| moved(*corners)).collect();
        let other = self.living(to).map(|index| self.corners[index as usize]);
        let mut after = changed.clone();
        after.extend(other.filter(|corners| !corners.contains(&from)));
        let gone = || std::iter::once(from).chain(self.removed[from as usize].iter().copied());
        let mut most = floor;
        for pose in 0..self.poses() {
            let placed = |corners: [u32; 3]| corners.map(|corner| self.point(corner, pose));
            let mut measure = |point: Vec3, triangles: &[[u32; 3]]| {
                let mut nearest = f32::INFINITY;
                for corners in triangles {
                    nearest = nearest.min(squared(point, placed(*corners)));
                    if nearest <= most {
                        return;
                    }
                }
                most = nearest;
            };
            for place in gone().chain(self.removed[to as usize].iter().copied()) {
                measure(self.point(place, pose), &after);
            }
            for corners in &changed {
                let at = corners.iter().position(|corner| *corner == to).unwrap_or_default();
                let [a, b, c] = placed(*corners);
                let next = placed(*corners)[(at + 1) % 3];
                measure((a + b + c) / 3.0, &before);
                // The other edge at this end is that of the next triangle.
                measure(0.5 * (self.point(to, pose) + next), &before);
            }
        }
        most
    }

    /// Collapses until `target` triangles are left or no collapse is possible. What a neighbour did not allow at first may be
    /// possible once it has changed, so all collapses are looked at again while some succeed.
    fn run(&mut self, target: usize) {
        loop {
            let before = self.live;
            self.round(target);
            if self.live <= target || self.live == before {
                return;
            }
            for place in 0..self.numbers.len() as u32 {
                self.push_from(place);
            }
        }
    }

    /// Collapses until `target` triangles are left or no candidate is.
    fn round(&mut self, target: usize) {
        while self.live > target {
            let Some(candidate) = self.queue.pop() else { return };
            let Candidate { from, to, stamp, .. } = candidate;
            if stamp != self.changes[from as usize] + self.changes[to as usize] || self.is_locked[from as usize] {
                continue;
            }
            let Some(charts) = self.allowed(from, to) else { continue };
            if !candidate.is_measured {
                let floor = candidate.cost as f32;
                let cost = self.deviation(from, to, floor);
                if cost > floor {
                    self.queue.push(Candidate { cost: cost.into(), is_measured: true, ..candidate });
                    continue;
                }
            }
            self.collapse(from, to, &charts);
        }
    }

    /// Returns which chart at `to` replaces each chart at `from`, or nothing if the collapse is not possible.
    fn allowed(&self, from: u32, to: u32) -> Option<Vec<[(u32, u32); 2]>> {
        let removed: Vec<u32> = self.living(from).filter(|index| self.corners[*index as usize].contains(&to)).collect();
        if removed.is_empty() || removed.len() > 2 {
            return None;
        }
        let opposite = |index: &u32| {
            let corners = self.corners[*index as usize];
            corners.into_iter().find(|corner| *corner != from && *corner != to)
        };
        // A place of a border stays on it, and no triangle is cut off.
        let near = self.neighbours(from);
        let count = |other: u32| self.living(from).filter(|it| self.corners[*it as usize].contains(&other)).count();
        let is_border = near.iter().any(|other| count(*other) == 1);
        if is_border && removed.len() == 2 {
            return None;
        }
        if removed.len() == 1 && opposite(&removed[0]).is_none_or(|other| count(other) == 1) {
            return None;
        }
        // The link condition: both ends have no other common neighbours.
        let far = self.neighbours(to);
        let common = near.iter().filter(|other| far.binary_search(other).is_ok()).count();
        if common != removed.len() {
            return None;
        }
        // Charts go along the triangles that vanish.
        let mut charts: Vec<[(u32, u32); 2]> = Vec::new();
        for index in &removed {
            let pair = [self.chart(*index, from), self.chart(*index, to)];
            match charts.iter().find(|known| known[0] == pair[0]) {
                Some(known) if *known != pair => return None,
                Some(_) => {}
                None => charts.push(pair),
            }
        }
        for index in self.living(from) {
            let chart = self.chart(index, from);
            if !charts.iter().any(|known| known[0] == chart) {
                return None;
            }
        }
        self.keeps_shape(from, to).then_some(charts)
    }

    /// Whether no triangle turns over or loses its area in any pose, or doubles another.
    fn keeps_shape(&self, from: u32, to: u32) -> bool {
        for index in self.living(from) {
            let corners = self.corners[index as usize];
            if corners.contains(&to) {
                continue;
            }
            let moved = corners.map(|corner| if corner == from { to } else { corner });
            let doubles = |other: u32| moved.iter().all(|corner| self.corners[other as usize].contains(corner));
            if self.living(to).any(doubles) {
                return false;
            }
            for pose in 0..self.poses() {
                let normal = |corners: [u32; 3]| {
                    let [a, b, c] = corners.map(|place| self.point(place, pose));
                    (b - a).cross(c - a)
                };
                let (before, after) = (normal(corners), normal(moved));
                if before != Vec3::ZERO && before.dot(after) <= TURN * before.length() * after.length() {
                    return false;
                }
            }
        }
        true
    }

    fn collapse(&mut self, from: u32, to: u32, charts: &[[(u32, u32); 2]]) {
        let places = self.input.places;
        for index in std::mem::take(&mut self.around[from as usize]) {
            if !self.is_alive[index as usize] {
                continue;
            }
            if self.corners[index as usize].contains(&to) {
                self.is_alive[index as usize] = false;
                self.live -= 1;
                continue;
            }
            let chart = self.chart(index, from);
            let replacement = charts.iter().find(|known| known[0] == chart).map_or(chart.0, |known| known[1].0);
            let at = self.corners[index as usize].iter().position(|corner| *corner == from).unwrap_or_default();
            let vertex = self.faces[index as usize].0[at];
            self.faces[index as usize].0[at] = nearest(self.input.character, vertex, places.of_chart(replacement));
            self.corners[index as usize][at] = to;
            self.around[to as usize].push(index);
        }
        let gone = std::mem::take(&mut self.removed[from as usize]);
        self.removed[to as usize].extend(std::iter::once(from).chain(gone));
        let poses = self.poses();
        for pose in 0..poses {
            let moved = self.quadrics[from as usize * poses + pose];
            self.quadrics[to as usize * poses + pose].add(&moved);
        }
        self.changes[from as usize] += 1;
        self.changes[to as usize] += 1;
        self.push_from(to);
        for other in self.neighbours(to) {
            if !self.is_locked[other as usize] {
                let candidate = self.candidate(other, to);
                self.queue.push(candidate);
            }
        }
    }
}

/// Returns the vertex among `others` whose normal is nearest to that of `vertex`.
pub(crate) fn nearest(character: &Character, vertex: u32, others: &[u32]) -> u32 {
    let first = others.first().copied().unwrap_or(vertex);
    let Some(normals) = character.values("normal") else { return first };
    let normal = |vertex: u32| Vec3::from_slice(&normals[3 * vertex as usize..][..3]);
    let own = normal(vertex);
    others.iter().fold(first, |best, it| if normal(*it).dot(own) > normal(best).dot(own) { *it } else { best })
}
