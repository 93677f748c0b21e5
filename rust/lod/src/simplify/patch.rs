//! A part of a mesh whose edges are collapsed one after the other, in the order of the magnitudes of their costs.
//!
//! A patch has a copy of its triangles. Vertices of triangles that are elsewhere too stay where they are, and so do those
//! ends of edges that lead to them: what is around all others is known here, and nobody else changes it.
//!
//! Costs are found when a patch is made, and again when their edges' turn has come (lazily: Cohen, Manocha, Olano 1997);
//! edges whose costs have risen wait for another turn.

use glam::{Vec3, Vec4};
use relievo_core::{Context, Result};

use crate::connectivity::{FIXED, Fan, NONE, OUTSIDE, next, previous};
use crate::numbers::{Claims, Numbers};
use crate::simplify::decimation::{Decimation, Edge};
use crate::simplify::offset::Around;
use crate::simplify::placement::{BATCH, Batch};
use crate::simplify::queue::{Queue, magnitude};
use crate::simplify::wedges::Wedges;

/// How much care is taken that edges collapse in the order of their costs.
#[derive(Clone, Copy)]
pub enum Care {
    /// For a mesh as it was given: later cuts know nothing of it.
    Little,
    Much,
}

impl Care {
    /// Magnitudes by which a cost may have risen for its edge to collapse all the same.
    fn rise(self) -> usize {
        [8, 2][self as usize]
    }

    /// What the edges of a vertex that moved are taken to cost, as a factor of what its collapse did.
    fn dearer(self) -> f32 {
        [3.0, 2.0][self as usize]
    }
}

/// The share of the distance that a collapse moves the surface by, which counts as one from all of its planes.
const OFFSET: f32 = 0.7;
/// Magnitudes by which a cost may have risen with that distance for its edge to collapse all the same.
const RISE: usize = 1;
/// Turns ahead of which a half-edge is looked for.
const AHEAD: usize = 8;

/// A mesh in pieces: triangles with their numbers in the input, and what is known of all vertices of the input.
pub struct Pieces<'a> {
    pub input: &'a [[u32; 3]],
    /// Vertices and numbers of the triangles that are left; none while all of the input are.
    pub left: Option<Vec<[u32; 4]>>,
    /// Place and deviation of every vertex.
    pub points: Vec<Vec4>,
    /// What costs at vertices are multiplied by, if not by 1.
    pub factors: Vec<f32>,
    pub is_locked: Vec<bool>,
    /// Corners at every vertex.
    pub valences: Vec<u32>,
    /// The vertex that each was collapsed into, or itself.
    pub joined: Vec<u32>,
}

/// A patch.
pub struct Patch {
    work: Decimation,
    /// Numbers of vertices and triangles in the input.
    vertices: Vec<u32>,
    triangles: Vec<u32>,
    queue: Queue,
    /// The largest deviation.
    error: f32,
    care: Care,
    batch: Batch,
    taken: Vec<Edge>,
    fans: [Fan; 2],
    around: Around,
    normals: Vec<(u32, Vec3)>,
    /// Vertices that are gone, and what they were collapsed into.
    joined: Vec<[u32; 2]>,
}

impl Pieces<'_> {
    /// The vertices and the number of a triangle.
    #[inline(always)]
    pub fn triangle(&self, at: usize) -> [u32; 4] {
        match &self.left {
            Some(left) => left[at],
            None => {
                let [a, b, c] = self.input[at];
                [a, b, c, at as u32]
            }
        }
    }
}

impl Patch {
    /// Of those of the triangles that are in a list, with its number in this cut, for vertices that deviate by at most
    /// `error`.
    pub fn new(
        context: &Context,
        (pieces, claims): (&Pieces, &Claims),
        (list, number): (&[u32], u32),
        error: f32,
        care: Care,
    ) -> Result<Self> {
        let mut numbers = Numbers::new(claims, number, list.len() / 2);
        let triangle = |at: &u32| pieces.triangle(*at as usize);
        let own: Vec<[u32; 3]> =
            list.iter().map(triangle).map(|[a, b, c, _]| [a, b, c].map(|it| numbers.number(it))).collect();
        let vertices = numbers.met;
        let points = vertices.iter().map(|vertex| pieces.points[*vertex as usize]).collect();
        let mut work = Decimation::of(context, points, &own, Wedges::none(vertices.len()))?;
        let is_locked = (0..).zip(&vertices).filter(|(_, vertex)| pieces.is_locked[**vertex as usize]);
        work.lock(&is_locked.map(|(own, _)| own).collect::<Vec<_>>());
        let factors: Vec<f32> =
            vertices.iter().filter_map(|vertex| pieces.factors.get(*vertex as usize)).copied().collect();
        work.weigh(&factors, |own| own);
        for (own, vertex) in (0..).zip(&vertices) {
            if work.mesh.valence(own) as u32 != pieces.valences[*vertex as usize] {
                work.mesh.flags[own as usize] |= OUTSIDE;
            }
        }
        let mut made = Self {
            work,
            vertices,
            triangles: list.iter().map(triangle).map(|[.., number]| number).collect(),
            queue: Queue::default(),
            error,
            care,
            batch: Batch::default(),
            taken: Vec::with_capacity(BATCH),
            fans: Default::default(),
            around: Around::default(),
            normals: Vec::new(),
            joined: Vec::new(),
        };
        made.find_costs(context);
        Ok(made)
    }

    /// How many half-edges wait, of each magnitude.
    pub fn waiting(&self) -> impl Iterator<Item = usize> {
        self.queue.counts()
    }

    /// Finds all costs.
    fn find_costs(&mut self, context: &Context) {
        let is_inner = |work: &Decimation, vertex: u32| work.mesh.flags[vertex as usize] & OUTSIDE == 0;
        for vertex in 0..self.vertices.len() as u32 {
            if is_inner(&self.work, vertex) {
                self.work.renew_star(vertex);
            }
        }
        for triangle in 0..self.triangles.len() as u32 {
            for corner in 4 * triangle..4 * triangle + 3 {
                if self.work.known_cost(corner) == f32::INFINITY {
                    continue;
                }
                let ends = [corner, next(corner)].map(|at| self.work.mesh.vertex(at));
                if ends.iter().all(|end| is_inner(&self.work, *end)) {
                    self.work.gather(&Edge { cost: 0.0, corner, ends }, &mut self.batch, self.taken.len());
                    self.taken.push(Edge { cost: 0.0, corner, ends });
                } else {
                    self.work.set_cost(corner, f32::INFINITY);
                }
                if self.taken.len() == BATCH {
                    self.add(context);
                }
            }
        }
        self.add(context);
    }

    /// Finds the costs of the edges of the batch.
    fn add(&mut self, context: &Context) {
        let Self { work, batch, queue, .. } = self;
        Decimation::<0>::place(context, batch);
        for (lane, edge) in self.taken.drain(..).enumerate() {
            let cost = batch.cost[lane];
            if batch.deviation[lane] <= self.error && cost < f32::INFINITY {
                work.set_cost(edge.corner, cost);
                queue.push(edge.corner, cost);
            } else {
                work.refuse(&edge);
            }
        }
    }

    /// Collapses edges of magnitudes up to `most`, until so many triangles are gone. One more may go if it `may_exceed`.
    /// Returns how many did.
    pub fn run(&mut self, context: &Context, most: usize, quota: usize, may_exceed: bool) -> usize {
        let mut removed = 0;
        while removed < quota {
            while self.taken.len() < BATCH
                && let Some((corner, turn)) = self.queue.pop(most)
            {
                if let Some(corner) = self.queue.ahead(AHEAD) {
                    self.work.prefetch_edge(corner);
                }
                let cost = self.work.known_cost(corner);
                // Whose triangle is gone, and what is refused, waits no more.
                if cost.is_sign_positive() && cost < f32::INFINITY {
                    if magnitude(cost) > turn {
                        self.queue.push(corner, cost);
                    } else {
                        let ends = [corner, next(corner)].map(|at| self.work.mesh.vertex(at));
                        ends.iter().for_each(|end| self.work.prefetch(*end));
                        self.taken.push(Edge { cost, corner, ends });
                    }
                }
            }
            if self.taken.is_empty() {
                break;
            }
            for (lane, edge) in self.taken.iter().enumerate() {
                edge.ends.iter().for_each(|end| self.work.renew_star(*end));
                self.work.gather(edge, &mut self.batch, lane);
            }
            Decimation::<0>::place(context, &mut self.batch);
            let mut is_over = false;
            for lane in 0..self.taken.len() {
                let edge = self.taken[lane];
                let known = self.work.known_cost(edge.corner);
                if known.to_bits() != edge.cost.to_bits() {
                    // A collapse of the batch made it dearer: it waits again.
                    if known.is_sign_positive() && known < f32::INFINITY {
                        self.queue.push(edge.corner, known);
                    }
                    continue;
                }
                let going = 1 + usize::from(self.work.mesh.mate(edge.corner) != NONE);
                let is_more = removed + going > quota && !(may_exceed && removed < quota);
                if is_more || edge.ends.iter().any(|end| self.work.is_stale(*end)) {
                    is_over |= is_more;
                    self.queue.push(edge.corner, edge.cost);
                } else if self.decide(context, &edge, lane) {
                    removed += going;
                }
            }
            self.taken.clear();
            if is_over {
                break;
            }
        }
        self.work.live -= removed;
        removed
    }

    /// Collapses an edge of the batch, or has it wait. Returns whether it is gone.
    fn decide(&mut self, context: &Context, edge: &Edge, lane: usize) -> bool {
        let Self { work, queue, care, batch, fans, around, normals, .. } = self;
        let cost = batch.cost[lane];
        if !(batch.deviation[lane] <= self.error && cost < f32::INFINITY) {
            work.refuse(edge);
            return false;
        }
        if magnitude(cost) > magnitude(edge.cost) + care.rise() {
            work.set_cost(edge.corner, cost);
            queue.push(edge.corner, cost);
            return false;
        }
        for (end, fan) in edge.ends.into_iter().zip(&mut *fans) {
            work.mesh.fan(end, fan);
        }
        let mut point = batch.point(lane, edge.ends.map(|end| work.points[end as usize]));
        normals.clear();
        if !work.keeps_surface(edge.corner, fans) || !work.keeps_sides(edge.corner, fans, point, normals) {
            work.refuse(edge);
            return false;
        }
        let mut cost = cost;
        if matches!(care, Care::Much) || self.error < f32::INFINITY {
            let moved = work.offset(context.level(), edge, fans, point, around);
            point.w = point.w.max(batch.before[lane] + moved);
            if point.w > self.error {
                work.refuse(edge);
                return false;
            }
            let offset = OFFSET * moved;
            cost = cost.max(batch.factor[lane] * batch.trace[lane] * offset * offset);
            if magnitude(cost) > magnitude(edge.cost) + RISE {
                work.set_cost(edge.corner, cost);
                queue.push(edge.corner, cost);
                return false;
            }
        }
        self.collapse(edge, point, cost);
        true
    }

    /// Collapses an edge; what is around it is in the fans, and normals of triangles are found.
    fn collapse(&mut self, edge: &Edge, point: Vec4, cost: f32) {
        let Self { work, queue, care, fans, normals, joined, .. } = self;
        joined.push([edge.ends[1], edge.ends[0]]);
        let [kept, gone] = edge.ends.map(|end| end as usize);
        work.points[kept] = point;
        work.join_factors(kept, gone);
        work.mesh.flags[kept] |= work.mesh.flags[gone];
        normals.iter().for_each(|(triangle, normal)| work.normals[*triangle as usize] = normal.extend(0.0));
        let mut merged = [(NONE, f32::INFINITY); 2];
        let sides = [edge.corner, work.mesh.mate(edge.corner)];
        for (side, merged) in sides.into_iter().zip(&mut merged).filter(|(side, _)| *side != NONE) {
            let inner = [next(side), previous(side)];
            // Of two edges that become one a half-edge is left that may not have stood for either.
            let outer = inner.map(|inner| work.mesh.mate(inner)).into_iter().find(|outer| *outer != NONE);
            let least = inner.iter().map(|inner| work.known_cost(*inner).abs()).fold(f32::INFINITY, f32::min);
            *merged = (outer.unwrap_or(NONE), least);
            for gone in inner.into_iter().chain([side]) {
                work.set_cost(gone, f32::INFINITY);
            }
        }
        let start = work.mesh.grow_alone(normals.len() + 1);
        work.mesh.collapse(edge.corner, start);
        for (outer, least) in merged {
            if outer != NONE && least < f32::INFINITY && work.known_cost(outer) == f32::INFINITY {
                work.set_cost(outer, least);
                queue.push(outer, least);
            }
        }
        let mut retry = |work: &Decimation, vertex: u32, least: f32| {
            for corner in work.mesh.around(vertex).flat_map(|corner| [corner, previous(corner)]) {
                let known = work.known_cost(corner);
                if known.is_sign_negative() {
                    work.set_cost(corner, least.max(-known));
                    queue.push(corner, least.max(-known));
                } else {
                    // It stays in its place, and is moved on when its turn has come there.
                    work.set_cost(corner, known.max(least));
                }
            }
        };
        for vertex in fans.iter().flat_map(Fan::ring) {
            if work.awake(vertex) {
                retry(work, vertex, 0.0);
            }
        }
        edge.ends.iter().for_each(|end| {
            work.awake(*end);
        });
        retry(work, edge.ends[0], cost * care.dearer());
    }

    /// Vertices and numbers of the triangles that are left.
    pub fn left(&self) -> Vec<[u32; 4]> {
        let mut left = Vec::with_capacity(self.work.live);
        for (own, number) in self.triangles.iter().enumerate() {
            let triangle = self.work.mesh.triangle(own);
            if triangle[0] != NONE {
                let [a, b, c] = triangle.map(|vertex| self.vertices[vertex as usize]);
                left.push([a, b, c, *number]);
            }
        }
        left
    }

    /// Gives what is known of vertices back to the whole.
    pub fn give_back(&self, pieces: &mut Pieces) {
        let mesh = &self.work.mesh;
        for [gone, kept] in self.joined.iter().map(|both| both.map(|own| self.vertices[own as usize])) {
            pieces.joined[gone as usize] = kept;
        }
        for (own, vertex) in self.vertices.iter().enumerate() {
            if mesh.flags[own] & OUTSIDE == 0 && !mesh.is_gone(own as u32) {
                pieces.points[*vertex as usize] = self.work.points[own];
                pieces.is_locked[*vertex as usize] = mesh.flags[own] & FIXED != 0;
                if let Some(factor) = pieces.factors.get_mut(*vertex as usize) {
                    *factor = self.work.factor(own);
                }
            }
        }
    }
}
