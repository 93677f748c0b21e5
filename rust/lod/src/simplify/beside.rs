//! A simplified mesh beside its input: which vertices of the input each vertex was made of, and how far both surfaces are
//! apart, looked at in samples.
//!
//! What a vertex of the input is near is known from the collapses: the triangles around the vertex that it has become.

use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::{DVec3, Vec3, Vec4};
use relievo_core::Context;
use relievo_core::simd::{Arithmetic, Level};
use relievo_surface::triangle::closest;

use crate::connectivity::NONE;
use crate::simplify::error_bound::Triangles;
use crate::simplify::offset::{LANES, distance_squared, lesser};
use crate::simplify::patches::Reduced;

/// Vertices of one task.
const CHUNK_LEN: usize = 256;
/// Triangles of the input of one task.
const MANY: usize = 16 * CHUNK_LEN;

/// Corners of [`LANES`] triangles by axis.
pub type Group = [[[f32; LANES]; 3]; 3];

/// Puts triangles into groups; the last one is repeated.
pub fn grouped(triangles: impl Iterator<Item = [Vec3; 3]>, groups: &mut Vec<Group>) {
    groups.clear();
    let mut lane = LANES;
    for corners in triangles {
        if lane == LANES {
            groups.push(corners.map(|corner| corner.to_array().map(|value| [value; LANES])));
            lane = 0;
        } else if let Some(group) = groups.last_mut() {
            for (room, corner) in group.iter_mut().zip(corners) {
                for (room, value) in room.iter_mut().zip(corner.to_array()) {
                    room[lane..].fill(value);
                }
            }
        }
        lane += 1;
    }
}

relievo_core::dispatch_simd! {
    /// Finds the squares of the distances of points from the nearest of some triangles.
    pub fn gaps = gaps_body(groups: &[Group], points: &[[f32; 3]], found: &mut Vec<f32>)
}

#[inline(always)]
fn gaps_body<A: Arithmetic>(_: A, groups: &[Group], points: &[[f32; 3]], found: &mut Vec<f32>) {
    found.clear();
    for point in points {
        let mut least = [f32::INFINITY; LANES];
        for group in groups {
            let squares = squares(group, *point);
            for lane in 0..LANES {
                least[lane] = lesser(least[lane], squares[lane]);
            }
        }
        found.push(least.into_iter().fold(f32::INFINITY, lesser));
    }
}

relievo_core::dispatch_simd! {
    /// Finds which points have no triangle within the root of `near`.
    fn beyond = beyond_body(groups: &[Group], points: &[[f32; 3]], near: f32, found: &mut Vec<usize>)
}

#[inline(always)]
fn beyond_body<A: Arithmetic>(_: A, groups: &[Group], points: &[[f32; 3]], near: f32, found: &mut Vec<usize>) {
    found.clear();
    for (at, point) in points.iter().enumerate() {
        let is_near = |group: &Group| squares(group, *point).into_iter().fold(f32::INFINITY, lesser) <= near;
        if !groups.iter().any(is_near) {
            found.push(at);
        }
    }
}

/// Returns the squares of the distances of a point from the triangles of a group.
#[inline(always)]
fn squares([a, b, c]: &Group, point: [f32; 3]) -> [f32; LANES] {
    let mut squares = [0.0; LANES];
    for i in 0..LANES {
        let corners = [[a[0][i], a[1][i], a[2][i]], [b[0][i], b[1][i], b[2][i]], [c[0][i], c[1][i], c[2][i]]];
        squares[i] = distance_squared(point, corners);
    }
    squares
}

/// Lists of numbers, one after the other.
#[derive(Default)]
pub struct Lists {
    starts: Vec<u32>,
    pub numbers: Vec<u32>,
}

impl Lists {
    /// Sorts pairs of a list and a number into so many lists.
    fn new(count: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0u32; count + 2];
        pairs.clone().for_each(|(list, _)| starts[list as usize + 2] += 1);
        for list in 2..starts.len() {
            starts[list] += starts[list - 1];
        }
        let mut numbers = vec![0; starts[count + 1] as usize];
        for (list, number) in pairs {
            let end = &mut starts[list as usize + 1];
            numbers[*end as usize] = number;
            *end += 1;
        }
        Self { starts, numbers }
    }

    pub fn range(&self, list: u32) -> std::ops::Range<usize> {
        self.starts[list as usize] as usize..self.starts[list as usize + 1] as usize
    }

    pub fn list(&self, list: u32) -> &[u32] {
        &self.numbers[self.range(list)]
    }
}

/// A place whose deviation counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Spot {
    /// A vertex of the input, by its place in the list of members.
    Member(u32),
    /// The centre of a triangle of the input.
    Inner(u32),
    Corner(u32),
    /// The middle of an edge.
    Middle(u32, u32),
    /// The centre of a triangle.
    Centre(u32),
}

/// The place of a surface that is nearest to a point: its triangle, the shares of the triangle's corners, and the way from
/// there to the point.
#[derive(Clone, Copy)]
pub struct Nearest {
    pub triangle: u32,
    pub shares: [f32; 3],
    pub way: Vec3,
}

impl Nearest {
    const NOWHERE: Self = Self { triangle: NONE, shares: [0.0; 3], way: Vec3::INFINITY };

    fn nearer(self, other: Self) -> Self {
        if other.way.length_squared() < self.way.length_squared() { other } else { self }
    }
}

/// A simplified mesh beside the input, both with coordinates multiplied by `scale`.
pub struct Beside<'a> {
    pub level: Level,
    input: Triangles<'a>,
    scale: f32,
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    stars: Lists,
    /// Triangles at vertices of edges that were turned.
    pub turned: HashMap<u32, Vec<u32>>,
    /// Vertices of the input that every vertex was made of.
    pub members: Lists,
    /// Of every vertex of the input, the one that it has become.
    pub becomes: Vec<u32>,
    /// Distances of members, in the order of their list, or more than that.
    pub far: Vec<f32>,
    /// What every vertex is estimated to deviate by.
    estimates: Vec<f32>,
    /// Triangles of the input at the members of vertices for which they were collected, and their groups once needed.
    owned: Lists,
    beneath: Vec<OnceLock<Vec<Group>>>,
}

impl<'a> Beside<'a> {
    /// Of a mesh whose vertices are those of `names` in the numbers of the input, with `numbers` the other way.
    pub fn new(
        context: &Context,
        (input, scale): (Triangles<'a>, f32),
        (names, numbers): (&[u32], &[u32]),
        triangles: Vec<[u32; 3]>,
        reduced: &Reduced,
    ) -> Self {
        let count = names.len();
        // Ways are halved as they are gone, whichever thread goes first: long ones would be gone again and again.
        let joined = context.map(reduced.joined.len(), |vertex| AtomicU32::new(reduced.joined[vertex]));
        let becomes = context.map(joined.len(), |vertex| {
            let next = |at: usize| joined[at].load(Relaxed) as usize;
            let mut at = vertex;
            while next(at) != at {
                let after = next(next(at));
                joined[at].store(after as u32, Relaxed);
                at = after;
            }
            numbers[at]
        });
        let corners = (0..).zip(&triangles).flat_map(|(at, triangle)| triangle.map(|vertex| (vertex, at)));
        let (members, stars) = context.join(
            || Lists::new(count, becomes.iter().copied().zip(0..).filter(|(now, _)| *now != NONE)),
            || Lists::new(count, corners),
        );
        let places = || names.iter().map(|name| reduced.points[*name as usize]);
        let points: Vec<Vec3> = places().map(Vec4::truncate).collect();
        let mut made = Self {
            level: context.level(),
            input,
            scale,
            points,
            triangles,
            stars,
            turned: HashMap::new(),
            members,
            becomes,
            far: Vec::new(),
            estimates: places().map(|place| place.w).collect(),
            owned: Lists::default(),
            beneath: Vec::new(),
        };
        let found = context.map(count.div_ceil(CHUNK_LEN), |part| {
            let (mut groups, mut places, mut found, mut all) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            for vertex in (part * CHUNK_LEN) as u32..count.min((part + 1) * CHUNK_LEN) as u32 {
                grouped(made.star(vertex).iter().map(|it| made.corners(*it)), &mut groups);
                places.clear();
                places.extend(made.members.list(vertex).iter().map(|member| made.place(*member).to_array()));
                gaps(made.level, &groups, &places, &mut found);
                all.extend(found.iter().map(|square| square.sqrt()));
            }
            all
        });
        made.far = found.concat();
        made
    }

    /// Returns the place of a vertex of the input.
    pub fn place(&self, member: u32) -> Vec3 {
        Vec3::from(self.input.0[member as usize]) * self.scale
    }

    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.points[vertex as usize])
    }

    /// Returns the triangles of the input.
    pub fn input_triangles(&self) -> &'a [[u32; 3]] {
        self.input.1
    }

    /// Returns the corners of a triangle of the input.
    pub fn beneath_corners(&self, triangle: u32) -> [Vec3; 3] {
        self.input.1[triangle as usize].map(|member| self.place(member))
    }

    /// Returns the triangles at a vertex.
    pub fn star(&self, vertex: u32) -> &[u32] {
        self.turned.get(&vertex).map_or_else(|| self.stars.list(vertex), Vec::as_slice)
    }

    /// Returns `vertices` and all vertices that share a triangle with one of them, ascending.
    pub fn grown(&self, vertices: &[u32]) -> Vec<u32> {
        let around = vertices.iter().flat_map(|vertex| self.star(*vertex));
        let mut grown: Vec<u32> = around.flat_map(|triangle| self.triangles[*triangle as usize]).collect();
        grown.sort_unstable();
        grown.dedup();
        grown
    }

    /// Adds the vertices that are within so many edges of some vertices to these.
    pub fn widen(&self, vertices: &mut Vec<u32>, edges: usize) {
        let mut is_in = vec![false; self.points.len()];
        vertices.iter().for_each(|vertex| is_in[*vertex as usize] = true);
        let mut from = 0;
        for _ in 0..edges {
            for at in std::mem::replace(&mut from, vertices.len())..vertices.len() {
                for triangle in self.star(vertices[at]) {
                    for vertex in self.triangles[*triangle as usize] {
                        if !std::mem::replace(&mut is_in[vertex as usize], true) {
                            vertices.push(vertex);
                        }
                    }
                }
            }
        }
    }

    /// Returns the triangles at some vertices, in order.
    pub fn at(&self, vertices: &[u32]) -> Vec<u32> {
        let mut triangles: Vec<u32> = vertices.iter().flat_map(|vertex| self.star(*vertex)).copied().collect();
        triangles.sort_unstable();
        triangles.dedup();
        triangles
    }

    /// Returns the area of the simplified mesh.
    pub fn area(&self) -> f64 {
        let area = |at: u32| {
            let [a, b, c] = self.corners(at).map(Vec3::as_dvec3);
            0.5 * (b - a).cross(c - a).length()
        };
        (0..self.triangles.len() as u32).map(area).sum()
    }

    /// Finds the nearest triangle of a place, from the ones at a vertex to those around them as long as they are nearer.
    fn nearest(&self, place: Vec3, vertex: u32) -> Nearest {
        let square =
            |triangle: u32| distance_squared(place.to_array(), self.corners(triangle).map(|corner| corner.to_array()));
        let mut best = (NONE, f32::INFINITY);
        let mut around = self.star(vertex).to_vec();
        loop {
            let before = best.0;
            for triangle in around {
                let square = square(triangle);
                if square < best.1 {
                    best = (triangle, square);
                }
            }
            if best.0 == before {
                break;
            }
            around = self.at(&self.triangles[best.0 as usize]);
        }
        if best.0 == NONE {
            return Nearest::NOWHERE;
        }
        let corners = self.corners(best.0);
        let shares = closest(place.as_dvec3(), corners.map(|corner| corner.as_dvec3())).map(|share| share as f32);
        let there: Vec3 = corners.into_iter().zip(shares).map(|(corner, share)| corner * share).sum();
        Nearest { triangle: best.0, shares, way: place - there }
    }

    /// Finds the nearest triangle of a member.
    pub fn nearest_to_member(&self, at: u32) -> Nearest {
        let member = self.members.numbers[at as usize];
        self.nearest(self.place(member), self.becomes[member as usize])
    }

    /// Finds the nearest triangle of a place of the input.
    pub fn nearest_to(&self, spot: Spot) -> Nearest {
        match spot {
            Spot::Member(at) => self.nearest_to_member(at),
            Spot::Inner(triangle) => {
                let centre = self.beneath_corners(triangle).into_iter().sum::<Vec3>() / 3.0;
                let members = self.input.1[triangle as usize];
                let found = members.map(|member| self.nearest(centre, self.becomes[member as usize]));
                found.into_iter().fold(Nearest::NOWHERE, Nearest::nearer)
            }
            _ => Nearest::NOWHERE,
        }
    }

    /// Returns the vertices that are estimated to deviate by more than `floor`.
    pub fn doubtful(&self, floor: f32) -> impl Iterator<Item = u32> {
        (0..).zip(&self.estimates).filter(move |(_, estimate)| **estimate > floor).map(|(vertex, _)| vertex)
    }

    /// Collects the triangles of the input at the members of some vertices.
    pub fn collect(&mut self, context: &Context, vertices: &[u32]) {
        let mut is_in = vec![false; self.points.len()];
        vertices.iter().for_each(|vertex| is_in[*vertex as usize] = true);
        let triangles = self.input.1;
        let pairs = context.map(triangles.len().div_ceil(MANY), |part| {
            let mut pairs = Vec::new();
            for at in part * MANY..triangles.len().min((part + 1) * MANY) {
                let [a, b, c] = triangles[at].map(|member| self.becomes[member as usize]);
                let all = [a, if b == a { NONE } else { b }, if c == a || c == b { NONE } else { c }];
                let is_asked = |owner: &u32| *owner != NONE && is_in[*owner as usize];
                pairs.extend(all.into_iter().filter(is_asked).map(|owner| (owner, at as u32)));
            }
            pairs
        });
        self.owned = Lists::new(self.points.len(), pairs.iter().flatten().copied());
        self.beneath = vec![OnceLock::new(); self.points.len()];
    }

    /// Whether the triangles of the input at the members of a vertex were collected.
    pub fn is_collected(&self, vertex: u32) -> bool {
        !self.owned.range(vertex).is_empty()
    }

    /// Returns the triangles of the input at the members of a vertex, if they were collected.
    pub fn beneath(&self, vertex: u32) -> &[Group] {
        self.beneath[vertex as usize].get_or_init(|| {
            let mut groups = Vec::new();
            grouped(self.owned.list(vertex).iter().map(|it| self.beneath_corners(*it)), &mut groups);
            groups
        })
    }

    /// Returns the vertices around a spot.
    pub fn vertices(&self, spot: Spot) -> Vec<u32> {
        match spot {
            Spot::Member(at) => {
                let mut vertices = self.triangles[self.nearest_to_member(at).triangle as usize].to_vec();
                vertices.push(self.becomes[self.members.numbers[at as usize] as usize]);
                vertices
            }
            Spot::Inner(triangle) => {
                let mut vertices = self.triangles[self.nearest_to(spot).triangle as usize].to_vec();
                vertices.extend(self.input.1[triangle as usize].map(|member| self.becomes[member as usize]));
                vertices
            }
            Spot::Corner(vertex) => vec![vertex],
            Spot::Middle(a, b) => vec![a, b],
            Spot::Centre(triangle) => self.triangles[triangle as usize].to_vec(),
        }
    }

    /// Returns the mean of the places of vertices.
    fn middle_of(&self, vertices: &[u32]) -> Vec3 {
        vertices.iter().map(|vertex| self.points[*vertex as usize]).sum::<Vec3>() / vertices.len() as f32
    }

    /// Finds the centres of triangles of the input that are farther than `floor` from the result.
    pub fn far_inner(&self, context: &Context, floor: f32) -> Vec<(f32, Spot)> {
        let mut far_of = vec![f32::INFINITY; self.becomes.len()];
        self.members.numbers.iter().zip(&self.far).for_each(|(member, far)| far_of[*member as usize] = *far);
        let stars = context.map(self.points.len(), |vertex| {
            let mut groups = Vec::new();
            grouped(self.star(vertex as u32).iter().map(|it| self.corners(*it)), &mut groups);
            groups
        });
        let triangles = self.input.1;
        let found = context.map(triangles.len().div_ceil(MANY), |part| {
            let (mut all, mut found) = (Vec::new(), Vec::new());
            for at in part * MANY..triangles.len().min((part + 1) * MANY) {
                if triangles[at].iter().any(|member| self.becomes[*member as usize] == NONE) {
                    continue;
                }
                let corners = self.beneath_corners(at as u32);
                let centre = corners.into_iter().sum::<Vec3>() / 3.0;
                let is_near =
                    |(corner, member): (&Vec3, u32)| corner.distance(centre) + far_of[member as usize] <= floor;
                if corners.iter().zip(triangles[at]).any(is_near) {
                    continue;
                }
                let is_near = |member: u32| {
                    let groups = &stars[self.becomes[member as usize] as usize];
                    beyond(self.level, groups, &[centre.to_array()], floor * floor, &mut found);
                    found.is_empty()
                };
                if triangles[at].into_iter().any(is_near) {
                    continue;
                }
                let spot = Spot::Inner(at as u32);
                let found = self.nearest_to(spot).way.length();
                if found > floor {
                    all.push((found, spot));
                }
            }
            all
        });
        found.concat()
    }

    /// Finds corners, middles of edges and centres of triangles at some vertices that are farther than `floor` from the
    /// input. What is beneath these vertices and those two edges around has to be collected.
    pub fn far_samples(&self, context: &Context, vertices: &[u32], floor: f32) -> Vec<(f32, Spot)> {
        let mut is_in = vec![false; self.points.len()];
        vertices.iter().for_each(|vertex| is_in[*vertex as usize] = true);
        let near = floor * floor;
        let found = context.map(vertices.len().div_ceil(CHUNK_LEN), |part| {
            let mut all = Vec::new();
            let (mut spots, mut places, mut found) = (Vec::new(), Vec::<[f32; 3]>::new(), Vec::new());
            let (mut others, mut squares) = (Vec::new(), Vec::new());
            for vertex in &vertices[part * CHUNK_LEN..vertices.len().min((part + 1) * CHUNK_LEN)] {
                // The lowest vertex of a spot is the first to look at it.
                let is_first = |other: &u32| other >= vertex || !is_in[*other as usize];
                spots.clear();
                spots.push(Spot::Corner(*vertex));
                for it in self.star(*vertex) {
                    let triangle = self.triangles[*it as usize];
                    if triangle.iter().all(is_first) {
                        spots.push(Spot::Centre(*it));
                    }
                    for other in triangle.into_iter().filter(|other| other != vertex && is_first(other)) {
                        let middle = Spot::Middle(*vertex.min(&other), *vertex.max(&other));
                        if !spots.contains(&middle) {
                            spots.push(middle);
                        }
                    }
                }
                places.clear();
                places.extend(spots.iter().map(|spot| self.middle_of(&self.vertices(*spot)).to_array()));
                beyond(self.level, self.beneath(*vertex), &places, near, &mut found);
                for at in &found {
                    let (around, place) = (self.vertices(spots[*at]), [places[*at]]);
                    let is_near = around.iter().filter(|other| *other != vertex).any(|other| {
                        beyond(self.level, self.beneath(*other), &place, near, &mut others);
                        others.is_empty()
                    });
                    if is_near {
                        continue;
                    }
                    let mut least = f32::INFINITY;
                    for other in self.grown(&around) {
                        gaps(self.level, self.beneath(other), &place, &mut squares);
                        least = squares.iter().copied().fold(least, f32::min);
                    }
                    if least > near {
                        all.push((least.sqrt(), spots[*at]));
                    }
                }
            }
            all
        });
        found.concat()
    }

    /// Returns the vertices that move a spot, with their shares, and the way that it should go. `None` if it is there no
    /// more.
    pub fn way(&self, spot: Spot) -> Option<(Vec<(u32, f32)>, Vec3)> {
        if let Spot::Member(_) | Spot::Inner(_) = spot {
            let Nearest { triangle, shares, way } = self.nearest_to(spot);
            return Some((self.triangles[triangle as usize].into_iter().zip(shares).collect(), way));
        }
        let vertices = self.vertices(spot);
        if let Spot::Middle(a, b) = spot
            && !self.star(a).iter().any(|it| self.triangles[*it as usize].contains(&b))
        {
            return None;
        }
        let place = self.middle_of(&vertices);
        let mut best = Vec3::INFINITY;
        for group in self.grown(&vertices).iter().flat_map(|vertex| self.beneath(*vertex)) {
            for lane in 0..LANES {
                let corners = group.map(|corner| Vec3::from_array(corner.map(|values| values[lane])));
                let shares = closest(place.as_dvec3(), corners.map(|corner| corner.as_dvec3()));
                let there: Vec3 = corners.into_iter().zip(shares).map(|(corner, share)| corner * share as f32).sum();
                if (there - place).length_squared() < best.length_squared() {
                    best = there - place;
                }
            }
        }
        let share = 1.0 / vertices.len() as f32;
        best.is_finite().then(|| (vertices.into_iter().map(|vertex| (vertex, share)).collect(), best))
    }

    /// Whether the triangles of a vertex are closed fans.
    pub fn is_closed(&self, vertex: u32) -> bool {
        let mut sides = [0i64; 2];
        for triangle in self.star(vertex) {
            let triangle = self.triangles[*triangle as usize];
            let Some(side) = triangle.iter().position(|it| *it == vertex) else { return false };
            let [to, from] = [triangle[(side + 1) % 3], triangle[(side + 2) % 3]].map(i64::from);
            sides[0] += to - from;
            sides[1] += to * to - from * from;
        }
        sides == [0; 2]
    }
}

/// Returns six times the volume of a tetrahedron from the origin.
pub fn sixfold([a, b, c]: [DVec3; 3]) -> f64 {
    a.dot(b.cross(c))
}
