//! Vertices put back where a simplified mesh with borders is farthest from its input, each for one that matters less.
//!
//! Where an edge of a border cuts across a corner of an opening, no move of its ends brings it nearer and it cannot be
//! turned: the border has too few vertices there. So an edge or triangle gets a vertex more (as Douglas, Peucker 1973
//! refine lines, by the farthest place), and edges are collapsed where that leaves least. Every change is measured by the
//! largest distance between the surfaces, both ways, of what it touches: `distance.rs`.

use std::cell::Cell;
use std::collections::HashMap;

use glam::{DVec3, Vec3, Vec4};
use relievo_core::progress::Silent;
use relievo_core::{Context, Result};
use relievo_surface::triangle::closest;

use crate::connectivity::NONE;
use crate::distance::{MeasuredMesh, Near, exact, gap};
use crate::simplify::error_bound::Triangles;

/// Triangles of an input at most.
const COARSE: usize = 4096;
/// The share of the largest deviation that is sought.
const GOAL: f64 = 0.6;
/// Deviations up to this many times the root mean square of those of the vertices are no outliers.
const ORDINARY: f64 = 3.0;
/// Changes at most.
const CHANGES: usize = 24;
/// The factor by which the deviations that a change leaves have to be smaller.
const SMALLER: f64 = 0.98;
/// The factor by which the sum of squares of deviations may become larger.
const ROOM: f64 = 1.1;
/// The ratio of bounds at which a deviation is known.
const SHARP: f64 = 1.02;
/// The least cosine between the normals of a triangle before and after a change.
const TURNED: f64 = 0.3;
/// The least height of a triangle, as a share of its longest edge.
const THIN: f64 = 0.01;
/// Edges beside a far place that are tried.
const EDGES: usize = 6;
/// Triangles that a vertex takes from another at most.
const PARTED: usize = 4;
/// Changes with a vertex more for which collapses are looked for, and collapses that are tried for each.
const TRIED: [usize; 2] = [3, 12];
/// Triangles that are measured for changes, for each of the input.
const EFFORT: usize = 2;
/// A triangle that is gone: it has no area.
const GONE: [u32; 3] = [0; 3];

/// Triangles that are replaced, and a vertex that is added or moved.
#[derive(Clone, Default)]
struct Change {
    removed: Vec<u32>,
    /// New triangles, each with the one that it comes from.
    added: Vec<([u32; 3], u32)>,
    vertex: Option<(u32, [f32; 3])>,
}

/// A change that can be made.
struct Tried {
    change: Change,
    /// The largest deviation of what it touches.
    worst: f64,
    /// What is added to the squares of deviations.
    squares: f64,
    there: Vec<Deviation>,
    /// Triangles of the input that were measured, by their places in the list of those with area.
    back: Vec<(u32, Deviation)>,
    /// Triangles of the result beside triangles of the input that were measured.
    beside: Vec<(u32, u32)>,
}

/// How far a triangle is from the other surface.
#[derive(Clone, Copy)]
struct Deviation {
    /// The largest distance that was found, where, and the triangle nearest to that, by its place in the list.
    at_least: f64,
    at_most: f64,
    place: DVec3,
    near: u32,
    /// The integral of the squared distance, from corners and centre.
    square: f64,
}

/// A place that is far from the other surface: of a triangle of the result, or of the input.
#[derive(Clone, Copy)]
enum Spot {
    There(u32),
    Back(u32),
}

/// A simplified mesh and its deviations.
#[derive(Clone)]
struct State {
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// The place in order that every triangle has.
    order: Vec<u32>,
    stars: Vec<Vec<u32>>,
    count: usize,
    /// The sum of squares of deviations.
    squares: f64,
    /// Of every triangle of the result, and of every one of the input with area.
    there: Vec<Deviation>,
    back: Vec<Deviation>,
    /// Triangles of the input that are measured from every triangle of the result, and some that no longer are.
    measured: Vec<Vec<u32>>,
}

struct Exchange<'a> {
    input: MeasuredMesh<'a>,
    mesh: Triangles<'a>,
    /// Deviations up to this are left alone.
    floor: f64,
    /// What the sum of squares of deviations may be.
    room: f64,
    most: usize,
    /// Triangles that may still be measured for changes.
    effort: Cell<usize>,
}

/// Makes the largest distance between a coarse input with borders and its simplification to `faces` triangles smaller,
/// with vertices that are put back and edges that are collapsed instead. Triangles and points are those of the result, by
/// numbers of the input, the points divided by `scale`. Fails if memory does not suffice.
pub fn exchange(
    mesh: Triangles,
    faces: usize,
    scale: f32,
    triangles: &mut Vec<[u32; 3]>,
    points: &mut [Vec4],
) -> Result<()> {
    let count = triangles.len();
    if count == 0 || count == mesh.1.len() || mesh.1.len() > COARSE {
        return Ok(());
    }
    let mut numbers = HashMap::new();
    let mut names = Vec::new();
    let mut number = |vertex: u32| {
        *numbers.entry(vertex).or_insert_with(|| {
            names.push(vertex);
            names.len() as u32 - 1
        })
    };
    let compact: Vec<[u32; 3]> = triangles.iter().map(|it| it.map(&mut number)).collect();
    let places: Vec<[f32; 3]> =
        names.iter().map(|name| (points[*name as usize].truncate() * scale).to_array()).collect();
    let mut state = State::new(places, compact);
    if !state.has_border() {
        return Ok(());
    }
    let serial = Context::serial();
    let input = MeasuredMesh::new(&serial, mesh)?;
    let mut exchange = Exchange { input, mesh, floor: 0.0, room: 0.0, most: faces.max(count), effort: Cell::new(0) };
    let before = state.points.len();
    if !exchange.measure(&mut state)? {
        return Ok(());
    }
    let first = state.farthest().1;
    exchange.run(&mut state)?;
    if state.farthest().1 >= first {
        return Ok(());
    }
    // Added vertices get the numbers of vertices of the input beside them.
    for added in before..state.points.len() {
        let place = exact(state.points[added]);
        let free = (0..mesh.0.len() as u32).filter(|it| !numbers.contains_key(it));
        let near = free.min_by(|a, b| {
            let [a, b] = [a, b].map(|it| exact(mesh.0[*it as usize]).distance_squared(place));
            a.total_cmp(&b)
        });
        let Some(name) = near else { return Ok(()) };
        numbers.insert(name, added as u32);
        names.push(name);
    }
    for (name, point) in names.iter().zip(&state.points) {
        let old = &mut points[*name as usize];
        *old = (Vec3::from(*point) / scale).extend(old.w);
    }
    let mut left: Vec<u32> = (0..state.triangles.len() as u32).filter(|it| state.is_there(*it)).collect();
    left.sort_by_key(|it| state.order[*it as usize]);
    *triangles = left.iter().map(|it| state.triangles[*it as usize].map(|it| names[it as usize])).collect();
    Ok(())
}

impl State {
    fn new(points: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        let mut stars = vec![Vec::new(); points.len()];
        for (at, triangle) in (0..).zip(&triangles) {
            triangle.iter().for_each(|vertex| stars[*vertex as usize].push(at));
        }
        let count = triangles.len();
        let order = (0..count as u32).collect();
        Self {
            points,
            order,
            stars,
            count,
            squares: 0.0,
            there: Vec::new(),
            back: Vec::new(),
            measured: Vec::new(),
            triangles,
        }
    }

    fn is_there(&self, triangle: u32) -> bool {
        self.triangles[triangle as usize] != GONE
    }

    fn point(&self, vertex: u32) -> DVec3 {
        exact(self.points[vertex as usize])
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.point(vertex))
    }

    fn star(&self, vertex: u32) -> &[u32] {
        &self.stars[vertex as usize]
    }

    /// Returns the triangles at an edge.
    fn at_edge(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        self.star(a).iter().copied().filter(|it| self.triangles[*it as usize].contains(&b)).collect()
    }

    /// Whether an edge has a single triangle.
    fn has_border(&self) -> bool {
        self.triangles
            .iter()
            .any(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]].into_iter().any(|edge| self.at_edge(edge).len() == 1))
    }

    /// Returns whether the triangles at a vertex are a closed fan, and `None` if they are not a single fan.
    fn is_closed(&self, vertex: u32) -> Option<bool> {
        let sides = |it: u32| {
            let triangle = self.triangles[it as usize];
            let at = triangle.iter().position(|it| *it == vertex).unwrap_or(0);
            [triangle[(at + 1) % 3], triangle[(at + 2) % 3]]
        };
        let star: Vec<[u32; 2]> = self.star(vertex).iter().map(|it| sides(*it)).collect();
        let one = |test: &dyn Fn(&[u32; 2]) -> bool| {
            let mut all = star.iter().filter(|it| test(it));
            (all.next().copied(), all.next().is_some())
        };
        let open: Vec<&[u32; 2]> = star.iter().filter(|it| !star.iter().any(|other| other[1] == it[0])).collect();
        let first = match open[..] {
            [] => *star.first()?,
            [one] => *one,
            _ => return None,
        };
        let (mut here, mut steps) = (first, 1);
        loop {
            let (next, is_more) = one(&|it| it[0] == here[1]);
            match next {
                _ if is_more => return None,
                Some(next) if next != first => (here, steps) = (next, steps + 1),
                next => return (steps == star.len()).then_some(next.is_some()),
            }
            if steps > star.len() {
                return None;
            }
        }
    }

    /// Returns the vertices that share a triangle with one, in order.
    fn ring(&self, vertex: u32) -> Vec<u32> {
        let mut ring: Vec<u32> = self.star(vertex).iter().flat_map(|it| self.triangles[*it as usize]).collect();
        ring.sort_unstable();
        ring.dedup();
        ring.retain(|it| *it != vertex);
        ring
    }

    /// Returns the place that may be the farthest, and what its distance is at most.
    fn farthest(&self) -> (Spot, f64) {
        let there = (0..).zip(&self.there).filter(|(it, _)| self.is_there(*it)).map(|(it, far)| (Spot::There(it), far));
        let back = (0..).zip(&self.back).map(|(it, far)| (Spot::Back(it), far));
        let all = there.chain(back).map(|(spot, far)| (spot, far.at_most));
        all.fold((Spot::There(0), 0.0), |most, it| if it.1 > most.1 { it } else { most })
    }

    fn place(&self, change: &Change, vertex: u32) -> DVec3 {
        match change.vertex {
            Some((moved, place)) if moved == vertex => exact(place),
            _ => self.point(vertex),
        }
    }

    /// Whether no triangle turns over or is thin.
    fn is_sound(&self, change: &Change) -> bool {
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        change.added.iter().all(|(triangle, from)| {
            let corners = triangle.map(|vertex| self.place(change, vertex));
            let [a, b, c] = corners;
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            let [before, after] = [normal(self.corners(*from)), normal(corners)];
            after.length() > THIN * longest && after.dot(before) > TURNED * after.length() * before.length()
        })
    }

    /// Returns the change that moves a vertex.
    fn moved(&self, vertex: u32, place: [f32; 3]) -> Change {
        let removed = self.star(vertex).to_vec();
        let added = removed.iter().map(|it| (self.triangles[*it as usize], *it)).collect();
        Change { removed, added, vertex: Some((vertex, place)) }
    }

    /// Returns the change that puts a vertex on an edge, or into a triangle.
    fn split(&self, removed: Vec<u32>, replaced: &[u32], place: [f32; 3]) -> Change {
        let new = self.points.len() as u32;
        let with = |it: u32| {
            let triangle = self.triangles[it as usize];
            replaced.iter().map(move |old| (triangle.map(|it| if it == *old { new } else { it }), it))
        };
        let added = removed.iter().flat_map(|it| with(*it)).collect();
        Change { removed, added, vertex: Some((new, place)) }
    }

    /// Returns the changes that put a vertex beside one of the border, which takes the first triangles of a fan from it.
    fn parted(&self, vertex: u32, place: [f32; 3]) -> Vec<Change> {
        let new = self.points.len() as u32;
        let mut all = Vec::new();
        let across =
            |it: u32, from: u32| self.triangles[it as usize].into_iter().find(|it| *it != vertex && *it != from);
        for (first, from) in
            self.star(vertex).iter().flat_map(|it| self.triangles[*it as usize].map(|from| (*it, from)))
        {
            if from == vertex || self.at_edge([vertex, from]).len() != 1 {
                continue;
            }
            let (mut here, mut spoke, mut fan) = (first, from, Vec::new());
            while fan.len() < PARTED
                && let Some(next) = across(here, spoke)
            {
                spoke = next;
                fan.push(here);
                let beyond = self.at_edge([vertex, spoke]);
                if beyond.len() < 2 || fan.contains(beyond.iter().find(|it| **it != here).unwrap_or(&here)) {
                    break;
                }
                let triangle = self.triangles[here as usize];
                let is_after = (0..3).any(|side| triangle[side] == vertex && triangle[(side + 1) % 3] == spoke);
                let between = if is_after { [vertex, spoke, new] } else { [new, spoke, vertex] };
                let with = |it: &u32| (self.triangles[*it as usize].map(|it| if it == vertex { new } else { it }), *it);
                let added = fan.iter().map(with).chain([(between, here)]).collect();
                all.push(Change { removed: fan.clone(), added, vertex: Some((new, place)) });
                let Ok([one, other]) = <[u32; 2]>::try_from(beyond) else { break };
                here = if one == here { other } else { one };
            }
        }
        all
    }

    /// Returns the change that turns an edge of two triangles.
    fn turned(&self, [a, b]: [u32; 2]) -> Option<Change> {
        let both = <[u32; 2]>::try_from(self.at_edge([a, b])).ok()?;
        let goes = |it: u32, from: u32, to: u32| {
            let vertices = self.triangles[it as usize];
            (0..3).any(|side| vertices[side] == from && vertices[(side + 1) % 3] == to)
        };
        let [one, other] = if goes(both[0], a, b) { both } else { [both[1], both[0]] };
        let rest = |it: u32| self.triangles[it as usize].into_iter().find(|it| *it != a && *it != b);
        let (c, d) = (rest(one)?, rest(other)?);
        let is_possible = goes(one, a, b) && goes(other, b, a) && c != d && self.at_edge([c, d]).is_empty();
        let is_plain =
            [a, b].iter().all(|end| self.is_closed(*end).is_some_and(|is| self.star(*end).len() > 2 + usize::from(is)));
        (is_possible && is_plain).then(|| Change {
            removed: both.to_vec(),
            added: vec![([a, d, c], one), ([d, b, c], other)],
            vertex: None,
        })
    }

    /// Returns the change that collapses a vertex onto another, if the topology stays.
    fn collapsed(&self, gone: u32, kept: u32) -> Option<Change> {
        let at_edge = self.at_edge([gone, kept]);
        let is_closed = self.is_closed(gone)?;
        if at_edge.len() != if is_closed { 2 } else { 1 } {
            return None;
        }
        let mut across: Vec<u32> = at_edge
            .iter()
            .flat_map(|it| self.triangles[*it as usize])
            .filter(|it| *it != gone && *it != kept)
            .collect();
        across.sort_unstable();
        let around = self.ring(kept);
        let both = self.ring(gone).into_iter().filter(|it| around.binary_search(it).is_ok());
        if !both.eq(across.iter().copied()) {
            return None;
        }
        let removed = self.star(gone).to_vec();
        let left = removed.iter().filter(|it| !at_edge.contains(it));
        let added: Vec<([u32; 3], u32)> =
            left.map(|it| (self.triangles[*it as usize].map(|it| if it == gone { kept } else { it }), *it)).collect();
        let is_across = |(triangle, _): &([u32; 3], u32)| {
            triangle.iter().filter(|it| **it != kept).all(|it| across.binary_search(it).is_ok())
        };
        (!added.is_empty() && !added.iter().any(is_across)).then_some(Change { removed, added, vertex: None })
    }

    /// Returns points and triangles after a change.
    fn after(&self, change: &Change) -> (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<u32>) {
        let (mut points, mut triangles) = (self.points.clone(), self.triangles.clone());
        if let Some((vertex, place)) = change.vertex {
            points.resize(points.len().max(vertex as usize + 1), place);
            points[vertex as usize] = place;
        }
        change.removed.iter().for_each(|it| triangles[*it as usize] = GONE);
        let mut at = Vec::with_capacity(change.added.len());
        for (number, (triangle, _)) in change.added.iter().enumerate() {
            if let Some(slot) = change.removed.get(number) {
                triangles[*slot as usize] = *triangle;
                at.push(*slot);
            } else {
                at.push(triangles.len() as u32);
                triangles.push(*triangle);
            }
        }
        (points, triangles, at)
    }

    /// Makes a change.
    fn make(&mut self, tried: Tried) {
        let Tried { change, squares, there, back, beside, .. } = tried;
        self.squares += squares;
        let (points, triangles, at) = self.after(&change);
        let orders: Vec<u32> = change.added.iter().map(|(_, from)| self.order[*from as usize]).collect();
        self.count = self.count + change.added.len() - change.removed.len();
        let nowhere = Deviation { at_least: 0.0, at_most: 0.0, near: NONE, place: DVec3::ZERO, square: 0.0 };
        self.there.resize(triangles.len(), nowhere);
        self.order.resize(triangles.len(), 0);
        self.measured.resize(triangles.len(), Vec::new());
        self.stars.resize(points.len(), Vec::new());
        for it in &change.removed {
            for vertex in self.triangles[*it as usize] {
                self.stars[vertex as usize].retain(|other| other != it);
            }
            self.there[*it as usize] = nowhere;
            self.measured[*it as usize].clear();
        }
        (self.points, self.triangles) = (points, triangles);
        for ((it, far), order) in at.iter().zip(there).zip(orders) {
            self.there[*it as usize] = far;
            self.order[*it as usize] = order;
            for vertex in self.triangles[*it as usize] {
                self.stars[vertex as usize].push(*it);
            }
        }
        back.into_iter().for_each(|(it, far)| self.back[it as usize] = far);
        self.remember(beside);
    }

    fn remember(&mut self, beside: Vec<(u32, u32)>) {
        for (triangle, it) in beside {
            let list = &mut self.measured[triangle as usize];
            if list.last() != Some(&it) {
                list.push(it);
            }
        }
    }
}

impl Exchange<'_> {
    /// Measures all deviations. Returns whether there are outliers.
    fn measure(&mut self, state: &mut State) -> Result<bool> {
        let serial = Context::serial();
        let result = MeasuredMesh::new(&serial, (&state.points, &state.triangles))?;
        if result.solid.is_empty() || self.input.solid.is_empty() {
            return Ok(false);
        }
        let mut is_used = vec![false; self.mesh.0.len()];
        self.mesh.1.as_flattened().iter().for_each(|vertex| is_used[*vertex as usize] = true);
        let vertices = self.input.vertices_near(&serial, &result, &mut Silent, [0.0, 1.0])?;
        let used = || vertices.iter().zip(&is_used).filter(|(_, is)| **is).map(|(near, _)| near.distance);
        let most = used().fold(0.0, f64::max);
        let mean = (used().map(|gap| gap * gap).sum::<f64>() / used().count().max(1) as f64).sqrt();
        self.floor = (GOAL * most).max(ORDINARY * mean);
        let mut hint = NONE;
        for it in 0..state.triangles.len() as u32 {
            let corners = state.corners(it);
            let near = near(&self.input, corners, hint);
            hint = near[2].triangle;
            let found = far(&self.input, corners, near, (it, &mut Vec::new()), [self.floor, f64::INFINITY]);
            self.floor = self.floor.max(GOAL * found.at_least);
            state.there.push(found);
        }
        let mut beside = Vec::new();
        for it in 0..self.input.solid.len() as u32 {
            let near = self.mesh.1[self.input.solid[it as usize] as usize].map(|vertex| vertices[vertex as usize]);
            let corners = self.input.corners(it);
            let found = far(&result, corners, near, (it, &mut beside), [self.floor, f64::INFINITY]);
            self.floor = self.floor.max(GOAL * found.at_least);
            state.back.push(found);
        }
        state.measured = vec![Vec::new(); state.triangles.len()];
        state.remember(beside);
        state.squares = state.there.iter().chain(&state.back).map(|it| it.square).sum();
        self.room = ROOM * state.squares;
        let first = state.farthest().1;
        self.effort.set(EFFORT * self.input.solid.len());
        Ok(first > self.floor && first > self.input.rounding())
    }

    /// Makes changes until there is none left to make.
    fn run(&self, state: &mut State) -> Result<()> {
        let mut changes = 0;
        while changes < CHANGES && self.effort.get() > 0 {
            let (spot, far) = state.farthest();
            if far <= self.floor {
                break;
            }
            if self.sharpen(state, spot)? {
                continue;
            }
            changes += 1;
            let limit = SMALLER * far;
            let (free, more) = self.candidates(state, spot)?;
            let mut best: Option<Tried> = None;
            for change in free {
                let limit = best.as_ref().map_or(limit, |best| SMALLER * best.worst);
                best = self.attempt(state, change, spot, limit)?.or(best);
            }
            let mut made = None;
            if best.as_ref().is_none_or(|best| best.worst > self.floor) {
                let mut limit = best.as_ref().map_or(limit, |best| SMALLER * best.worst);
                let mut all = Vec::new();
                for change in more {
                    all.extend(self.attempt(state, change, spot, limit)?);
                }
                all.sort_by(|one, other| one.worst.total_cmp(&other.worst));
                for tried in all.into_iter().take(TRIED[0]) {
                    if let Some((worst, other)) = self.with_collapses(state, tried, limit)? {
                        (limit, made) = (SMALLER * worst, Some(other));
                    }
                }
            }
            match (made, best) {
                (Some(made), _) => *state = made,
                (None, Some(best)) => state.make(best),
                (None, None) => break,
            }
        }
        Ok(())
    }

    /// Measures a place that was only known to be near enough. Returns whether it was one.
    fn sharpen(&self, state: &mut State, spot: Spot) -> Result<bool> {
        let limits = [self.floor, f64::INFINITY];
        let is_sharp = |far: &Deviation| far.at_most <= SHARP * far.at_least;
        match spot {
            Spot::There(it) => {
                let old = state.there[it as usize];
                let corners = state.corners(it);
                if is_sharp(&old) {
                    return Ok(false);
                }
                let near = near(&self.input, corners, old.near);
                state.there[it as usize] = far(&self.input, corners, near, (it, &mut Vec::new()), limits);
            }
            Spot::Back(it) => {
                if is_sharp(&state.back[it as usize]) {
                    return Ok(false);
                }
                let result = MeasuredMesh::new(&Context::serial(), (&state.points, &state.triangles))?;
                let corners = self.input.corners(it);
                let mut beside = Vec::new();
                state.back[it as usize] =
                    far(&result, corners, near(&result, corners, NONE), (it, &mut beside), limits);
                state.remember(beside);
            }
        }
        Ok(true)
    }

    /// Makes a change of a copy, and as many collapses as it takes. Returns it with the largest deviation of what was
    /// touched; `None` if that is `limit` or more.
    fn with_collapses(&self, state: &State, tried: Tried, limit: f64) -> Result<Option<(f64, State)>> {
        let mut worst = tried.worst;
        if worst >= limit {
            return Ok(None);
        }
        let mut made = state.clone();
        let kept: Vec<u32> = tried.change.vertex.iter().map(|(vertex, _)| *vertex).collect();
        made.make(tried);
        while made.count > self.most {
            let mut best: Option<Tried> = None;
            for change in self.cheapest(&made, &kept, limit) {
                let limit = best.as_ref().map_or(limit, |best| best.worst);
                best = self.attempt(&made, change, Spot::There(NONE), limit)?.or(best);
                if best.as_ref().is_some_and(|best| best.worst <= self.floor) {
                    break;
                }
            }
            let Some(best) = best else { return Ok(None) };
            worst = worst.max(best.worst);
            made.make(best);
        }
        Ok(Some((worst, made)))
    }

    /// Finds the collapses that move the surface least.
    fn cheapest(&self, state: &State, stay: &[u32], limit: f64) -> Vec<Change> {
        let mut all: Vec<(f64, u32, u32)> = Vec::new();
        for gone in (0..state.points.len() as u32).filter(|it| !state.star(*it).is_empty() && !stay.contains(it)) {
            for kept in state.ring(gone) {
                let Some(change) = state.collapsed(gone, kept) else { continue };
                if state.count + change.added.len() + 1 < self.most + change.removed.len() || !state.is_sound(&change) {
                    continue;
                }
                let place = state.point(gone);
                let near = |triangle: &[u32; 3]| gap(place, triangle.map(|it| state.point(it)));
                let mut cost = change.added.iter().map(|(it, _)| near(it)).fold(f64::INFINITY, f64::min);
                for (triangle, _) in &change.added {
                    let centre = triangle.iter().map(|it| state.point(*it)).sum::<DVec3>() / 3.0;
                    let before = change.removed.iter().map(|it| gap(centre, state.corners(*it)));
                    cost = cost.max(before.fold(f64::INFINITY, f64::min));
                }
                if cost < limit {
                    all.push((cost, gone, kept));
                }
            }
        }
        all.sort_by(|one, other| one.0.total_cmp(&other.0));
        all.iter().take(TRIED[1]).filter_map(|(_, gone, kept)| state.collapsed(*gone, *kept)).collect()
    }

    /// Returns changes that may bring a far place nearer: first those for as many triangles, then those with a vertex more.
    fn candidates(&self, state: &State, spot: Spot) -> Result<(Vec<Change>, Vec<Change>)> {
        let serial = Context::serial();
        let on = |place: DVec3, corners: [DVec3; 3]| -> DVec3 {
            corners.into_iter().zip(closest(place, corners)).map(|(corner, share)| corner * share).sum()
        };
        let (triangle, under, target) = match spot {
            Spot::There(it) => {
                let Deviation { near, place, .. } = state.there[it as usize];
                (it, near, on(place, self.input.corners(near)))
            }
            Spot::Back(it) => {
                let result = MeasuredMesh::new(&serial, (&state.points, &state.triangles))?;
                let place = state.back[it as usize].place;
                (result.solid[result.nearest(place, NONE).triangle as usize], it, place)
            }
        };
        let mut places = vec![target.as_vec3().to_array()];
        places.extend(self.input.corners(under).map(|corner| corner.as_vec3().to_array()));
        let [a, b, c] = state.triangles[triangle as usize];
        let mut free: Vec<Change> =
            [[a, b], [b, c], [c, a]].into_iter().filter_map(|edge| state.turned(edge)).collect();
        for vertex in [a, b, c].into_iter().filter(|it| state.is_closed(*it).is_some()) {
            free.extend(places.iter().map(|place| state.moved(vertex, *place)));
            let from = state.point(vertex);
            let way = match spot {
                Spot::There(it) => target - state.there[it as usize].place,
                Spot::Back(_) => target - on(target, state.corners(triangle)),
            };
            free.extend([0.3, 0.6, 1.0].map(|step| state.moved(vertex, (from + way * step).as_vec3().to_array())));
        }
        let mut edges: Vec<(f64, [u32; 2])> = Vec::new();
        for it in [a, b, c].iter().flat_map(|vertex| state.star(*vertex)) {
            let [a, b, c] = state.triangles[*it as usize];
            for [a, b] in [[a, b], [b, c], [c, a]] {
                let [from, to] = [a.min(b), a.max(b)].map(|end| state.point(end));
                edges.push((gap(target, [from, to, to]), [a.min(b), a.max(b)]));
            }
        }
        edges.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        edges.dedup_by(|one, other| one.1 == other.1);
        let mut more = Vec::new();
        for place in &places {
            more.push(state.split(vec![triangle], &[a, b, c], *place));
            more.extend([a, b, c].into_iter().flat_map(|vertex| state.parted(vertex, *place)));
            more.extend(edges.iter().take(EDGES).map(|(_, edge)| state.split(state.at_edge(*edge), edge, *place)));
        }
        Ok((free, more))
    }

    /// Measures what a change touches. `None` if a triangle turns over, or a deviation is `limit` or more.
    fn attempt(&self, state: &State, change: Change, spot: Spot, limit: f64) -> Result<Option<Tried>> {
        let is_elsewhere = matches!(spot, Spot::There(it) if it != NONE && !change.removed.contains(&it));
        if is_elsewhere || !state.is_sound(&change) {
            return Ok(None);
        }
        if let Spot::Back(it) = spot {
            let place = state.back[it as usize].place;
            let near = |triangle: &[u32; 3]| gap(place, triangle.map(|vertex| state.place(&change, vertex)));
            if change.added.iter().all(|(triangle, _)| near(triangle) >= limit) {
                return Ok(None);
            }
        }
        if self.effort.get() == 0 {
            return Ok(None);
        }
        let spend = || self.effort.set(self.effort.get().saturating_sub(1));
        let (mut worst, mut there) = (0.0f64, Vec::new());
        let mut squares = -change.removed.iter().map(|it| state.there[*it as usize].square).sum::<f64>();
        // What was as far before is another place's matter.
        let is_worse = |found: &Deviation, old: &Deviation, is_spot: bool| is_spot || found.at_least > old.at_least;
        for (triangle, from) in &change.added {
            let corners = triangle.map(|vertex| state.place(&change, vertex));
            let old = &state.there[*from as usize];
            let is_spot = matches!(spot, Spot::There(it) if it == *from);
            let stop = if is_spot { limit } else { limit.max(old.at_least) };
            spend();
            let found =
                far(&self.input, corners, near(&self.input, corners, old.near), (0, &mut Vec::new()), [limit, stop]);
            if is_worse(&found, old, is_spot) {
                if found.at_least >= limit {
                    return Ok(None);
                }
                worst = worst.max(found.at_least);
            }
            squares += found.square;
            there.push(found);
        }
        let (points, triangles, _) = state.after(&change);
        let serial = Context::serial();
        let result = MeasuredMesh::new(&serial, (&points, &triangles))?;
        let mut again: Vec<u32> = change.removed.iter().flat_map(|it| &state.measured[*it as usize]).copied().collect();
        again.sort_unstable();
        again.dedup();
        if let Spot::Back(it) = spot {
            again.retain(|other| *other != it);
            again.insert(0, it);
        }
        let (mut back, mut beside) = (Vec::new(), Vec::new());
        let mut hint = NONE;
        for it in again {
            let old = &state.back[it as usize];
            let corners = self.input.corners(it);
            let is_spot = matches!(spot, Spot::Back(spot) if spot == it);
            let stop = if is_spot { limit } else { limit.max(old.at_least) };
            spend();
            let near = near(&result, corners, hint);
            hint = near[2].triangle;
            let found = far(&result, corners, near, (it, &mut beside), [limit, stop]);
            if is_worse(&found, old, is_spot) {
                if found.at_least >= limit {
                    return Ok(None);
                }
                worst = worst.max(found.at_least);
            }
            squares += found.square - old.square;
            back.push((it, found));
        }
        if state.squares + squares > self.room {
            return Ok(None);
        }
        Ok(Some(Tried { change, worst, squares, there, back, beside }))
    }
}

/// Finds what is near the corners of a triangle; `hint` is a triangle that may be.
fn near(to: &MeasuredMesh, corners: [DVec3; 3], mut hint: u32) -> [Near; 3] {
    corners.map(|corner| {
        let near = to.nearest(corner, hint);
        hint = near.triangle;
        near
    })
}

/// Bounds the distance of a triangle from a surface. Adds the triangles by which it was bounded to `beside`, each with the
/// number of the triangle.
fn far(
    to: &MeasuredMesh,
    corners: [DVec3; 3],
    near: [Near; 3],
    (it, beside): (u32, &mut Vec<(u32, u32)>),
    limits: [f64; 2],
) -> Deviation {
    let found = to.farthest(corners, near, limits, &mut Vec::new(), |piece| {
        beside.push((to.solid[piece.near as usize], it));
    });
    beside.push((to.solid[found.near as usize], it));
    let [a, b, c] = corners;
    let area = 0.5 * (b - a).cross(c - a).length();
    let centre = to.nearest((a + b + c) / 3.0, found.near).distance;
    // The rule that is exact for what is quadratic.
    let square = area * (near.iter().map(|near| near.distance.powi(2)).sum::<f64>() + 9.0 * centre.powi(2)) / 12.0;
    Deviation { at_least: found.at_least, at_most: found.at_most, place: found.place, near: found.near, square }
}
