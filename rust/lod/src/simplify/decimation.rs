//! The mesh while it is simplified: what its vertices know of their triangles, and what the collapse of its edges costs.

use std::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};

use glam::{Vec3, Vec3A, Vec3Swizzles, Vec4, Vec4Swizzles};
use relievo_core::simd::prefetch;
use relievo_core::{Context, Result};

use crate::connectivity::{BOUNDARY, CHUNK_LEN, Connectivity, FIXED, NONE, Part, SEAM, next, previous, slot};
use crate::progressive::Recording;
use crate::simplify::placement::{BATCH, Batch, Star, place, place_with};
use crate::simplify::wedges::{Quadric, Sight, Span, Wedges};

/// State of a vertex whose triangles changed in the last round.
const CHANGED: u8 = 1;
/// State of a vertex whose triangles changed since what it knows of them was found.
const STALE: u8 = 2;
/// State of a vertex that is asked for what it knows.
const WANTED: u8 = 4;
/// State of a vertex of an edge that is tried in this round, and of those around.
const TRIED: u8 = 8;

/// State of a vertex with an edge that was refused, where edges are collapsed one after the other.
const REFUSED: u8 = 16;

/// The sign of a cost: negative where the edge must not collapse before its surroundings change.
const SIGN: u32 = 1 << 31;

/// Magnitudes of costs that are distinguished: eight an octave.
const BINS: usize = (f32::INFINITY.to_bits() >> BIN) as usize;
const BIN: u32 = 20;
/// Of so many triangles, the costs of one are counted.
const SAMPLE: usize = 8;

/// A mesh that is simplified, with four numbers of attributes `Q` times.
pub struct Decimation<const Q: usize = 0> {
    pub mesh: Connectivity,
    /// Place and deviation of every vertex.
    pub points: Vec<Vec4>,
    /// Normal of every triangle, by the root of its length: its square is twice the area.
    pub normals: Vec<Vec4>,
    /// What costs are found from, of every vertex.
    stars: Vec<Star>,
    /// What costs at vertices are multiplied by, if not by 1.
    factors: Vec<f32>,
    /// Of every half-edge, three a triangle. Infinite where the mate stands for the edge, or the edge must not collapse;
    /// negative where that may change with its surroundings.
    costs: Vec<[AtomicU32; 3]>,
    /// [`CHANGED`], [`STALE`], [`WANTED`] and [`TRIED`] of every vertex.
    state: Vec<AtomicU8>,
    /// The part of every vertex, where parts are worked on at the same time.
    pub parts: Vec<Part>,
    /// Triangles that are left.
    pub live: usize,
    pub wedges: Wedges<Q>,
    /// What was done, if that is to be known.
    pub recording: Option<Recording>,
}

/// An edge that may be collapsed.
#[derive(Clone, Copy, Default)]
pub struct Edge {
    pub cost: f32,
    pub corner: u32,
    pub ends: [u32; 2],
}

/// How many edges there are of each magnitude of cost.
pub struct Magnitudes(Vec<AtomicU32>);

impl Magnitudes {
    /// The cost below which so large a share of the edges is, or a little more. `None` if there are no edges.
    pub fn below(&self, share: f32) -> Option<f32> {
        let wanted = ((self.sum(BINS) as f32 * share) as u32).max(1);
        let mut sum = 0;
        let bin = self.0.iter().position(|count| {
            sum += count.load(Relaxed);
            sum >= wanted
        })?;
        Some(f32::from_bits((bin as u32 + 1) << BIN))
    }

    /// The share of the edges that cost less than `cost`, without those of about its magnitude.
    pub fn share_below(&self, cost: f32) -> f32 {
        self.sum((cost.to_bits() >> BIN) as usize) as f32 / self.sum(BINS).max(1) as f32
    }

    fn sum(&self, bins: usize) -> u32 {
        self.0[..bins].iter().map(|count| count.load(Relaxed)).sum()
    }
}

/// The normal of a triangle between two of its sides, by the root of its length.
#[inline(always)]
pub fn normal(a: Vec3A, b: Vec3A) -> Vec3A {
    let normal = a.cross(b);
    normal / normal.length_squared().sqrt().sqrt().max(1e-18)
}

/// What a vertex knows of its triangles.
#[inline(always)]
fn look<const Q: usize>(
    mesh: &Connectivity,
    (points, normals): (&[Vec4], &[Vec4]),
    vertex: u32,
    wedges: &Sight<Q>,
) -> Star {
    let (here, flags) = (points[vertex as usize], mesh.flags[vertex as usize]);
    // Products of the same axes, and of x y, y z, z x.
    let (mut squares, mut products, mut sum) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
    mesh.clean(vertex, |corner| {
        let normal = normals[corner as usize / 4];
        squares += normal * normal;
        products += normal * normal.yzxw();
        sum += normal;
        if flags & (BOUNDARY | SEAM) != 0 {
            for (edge, end) in [(corner, next(corner)), (previous(corner), previous(corner))] {
                // A seam counts once, with the half-edge that leaves.
                if mesh.mate(edge) == NONE || (edge == corner && wedges.is_seam(mesh, edge)) {
                    let along = points[mesh.vertex(end) as usize].xyz() - here.xyz();
                    squares += (Vec3::splat(along.length_squared()) - along * along).extend(0.0);
                    products -= (along * along.yzx()).extend(0.0);
                }
            }
        }
    });
    let ([xx, yy, zz, _], [xy, yz, zx, _]) = (squares.to_array(), products.to_array());
    [xx, yy, zz, xy, zx, yz, sum.x, sum.y, sum.z]
}

impl Decimation {
    /// Of a mesh whose indices are in range, with coordinates multiplied by `scale`.
    pub fn new(context: &Context, points: &[[f32; 3]], triangles: &[[u32; 3]], scale: f32) -> Result<Self> {
        Self::with(context, points, triangles, scale, Wedges::none(points.len()))
    }

    /// Finds what a vertex knows of its triangles, if these have changed.
    pub fn renew_star(&mut self, vertex: u32) {
        let state = self.state[vertex as usize].get_mut();
        if *state & STALE != 0 {
            *state &= !STALE;
            let Self { mesh, points, normals, stars, wedges, .. } = self;
            stars[vertex as usize] = look(mesh, (points, normals), vertex, &wedges.split().2);
        }
    }
}

impl<const Q: usize> Decimation<Q> {
    /// Of a mesh whose indices are in range, with coordinates multiplied by `scale`, and its wedges.
    pub fn with(
        context: &Context,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        scale: f32,
        wedges: Wedges<Q>,
    ) -> Result<Self> {
        let points = context.map(points.len(), |index| (Vec3::from(points[index]) * scale).extend(0.0));
        Self::of(context, points, triangles, wedges)
    }

    /// Of vertices with their deviations, and triangles whose indices are in range.
    pub fn of(context: &Context, points: Vec<Vec4>, triangles: &[[u32; 3]], wedges: Wedges<Q>) -> Result<Self> {
        let face = |index: usize| {
            let [a, b, c] = triangles[index].map(|vertex| Vec3A::from_vec4(points[vertex as usize]));
            normal(b - a, c - a).extend(0.0)
        };
        let mut mesh = Connectivity::new(context, points.len(), triangles)?;
        if Q > 0 {
            wedges.mark(context, &mut mesh);
        }
        let unknown = |index: usize| {
            let [a, b, c] = triangles[index];
            let stands = |side: usize, is_lower: bool| is_lower || mesh.mate((4 * index + side) as u32) == NONE;
            let stand = [stands(0, a < b), stands(1, b < c), stands(2, c < a)];
            stand.map(|stands| AtomicU32::new(if stands { 0.0 } else { f32::INFINITY }.to_bits()))
        };
        Ok(Self {
            parts: Vec::new(),
            normals: context.map(triangles.len(), face),
            stars: context.map(points.len(), |_| Star::default()),
            factors: Vec::new(),
            costs: context.map(triangles.len(), unknown),
            state: points.iter().map(|_| AtomicU8::new(STALE)).collect(),
            live: triangles.len(),
            recording: None,
            wedges,
            mesh,
            points,
        })
    }

    /// Takes vertices to deviate already, by what `spent` returns for each.
    pub fn spend(&mut self, spent: impl Fn(usize) -> f32) {
        self.points.iter_mut().enumerate().for_each(|(vertex, point)| point.w = spent(vertex));
    }

    /// Keeps vertices where they are.
    pub fn lock(&mut self, vertices: &[u32]) {
        for vertex in vertices {
            self.mesh.flags[*vertex as usize] |= FIXED;
        }
    }

    /// Multiplies costs at vertices, by the greatest factor of each; which one a factor is for says `vertex`.
    pub fn weigh(&mut self, factors: &[f32], vertex: impl Fn(usize) -> usize) {
        if !factors.is_empty() {
            self.factors = vec![0.0; self.points.len()];
        }
        factors.iter().enumerate().for_each(|(index, factor)| {
            let known = &mut self.factors[vertex(index)];
            *known = known.max(*factor);
        });
    }

    /// Gives a vertex the greatest factor of two.
    pub fn join_factors(&mut self, kept: usize, gone: usize) {
        if !self.factors.is_empty() {
            self.factors[kept] = self.factors[kept].max(self.factors[gone]);
        }
    }

    /// What costs at a vertex are multiplied by.
    pub fn factor(&self, vertex: usize) -> f32 {
        self.factors.get(vertex).copied().unwrap_or(1.0)
    }

    /// The sums of the normals of the triangles at every vertex.
    pub fn vertex_normals(&self, context: &Context) -> Vec<Vec3> {
        let normal = |corner: u32| self.normals[corner as usize / 4].xyz();
        context.map(self.points.len(), |vertex| self.mesh.around(vertex as u32).map(normal).sum())
    }

    /// Finds what vertices know of their triangles that are asked for it.
    fn renew_stars(&mut self, context: &Context) -> Result<()> {
        let Self { mesh, points, normals, state, stars, wedges, .. } = self;
        let (sums, more, wedges) = wedges.split();
        let parts = (stars.as_mut_slice(), (state.as_slice(), (sums, more)));
        context.for_each_part(parts, CHUNK_LEN, |first, (stars, (state, (sums, more)))| {
            let list = stars.iter_mut().zip(state).zip(sums.iter_mut().zip(more));
            for (at, ((renewed, state), (sums, more))) in list.enumerate() {
                let known = state.load(Relaxed);
                if known & WANTED == 0 {
                    continue;
                }
                state.store(known & !(STALE | WANTED), Relaxed);
                let vertex = (first + at) as u32;
                *renewed = look(mesh, (points, normals), vertex, &wedges);
                if Q > 0 && mesh.flags[vertex as usize] & FIXED == 0 {
                    wedges.renew(mesh, points, vertex, [sums, more]);
                }
            }
            Ok(())
        })
    }

    /// The edges that cost less than `ahead`, in parts, and how many edges there are of each cost. Costs are found anew
    /// of edges whose surroundings have changed, and of edges that did not cost less than `known`: what changed about
    /// them was not looked at. Edges whose vertex would deviate by more than `error` must not collapse. With all edges
    /// ahead, which are most of what a simplification ever needs, parts are empty: [`Self::edges_below`] has some of them.
    pub fn renew_costs(
        &mut self,
        context: &Context,
        [known, ahead]: [f32; 2],
        error: f32,
    ) -> Result<(Vec<Vec<Edge>>, Magnitudes)> {
        let work = &*self;
        let is_all = ahead == f32::INFINITY;
        let mut found = context.map(self.costs.len().div_ceil(CHUNK_LEN), |part| {
            let found = work.edges(part, [known, ahead]);
            if is_all { Default::default() } else { found }
        });
        self.renew_stars(context)?;
        let work = &*self;
        let magnitudes: Vec<AtomicU32> = (0..BINS).map(|_| AtomicU32::new(0)).collect();
        context.for_each_mut(&mut found, |part, found| {
            let (mut edges, old) = if is_all { work.edges(part, [known, ahead]) } else { std::mem::take(found) };
            let mut batch = Batch::default();
            for old in old.chunks(BATCH) {
                for (lane, old) in old.iter().enumerate() {
                    work.gather(&edges[*old as usize], &mut batch, lane);
                }
                Self::place(context, &mut batch);
                for (old, (cost, deviation)) in old.iter().zip(batch.cost.iter().zip(&batch.deviation)) {
                    let edge = &mut edges[*old as usize];
                    edge.cost = if *deviation <= error { *cost } else { -cost };
                    work.set_cost(edge.corner, edge.cost);
                }
            }
            let costs = &work.costs[part * CHUNK_LEN..work.costs.len().min((part + 1) * CHUNK_LEN)];
            let mut counts = [0u32; BINS];
            for cost in costs.iter().step_by(SAMPLE).flatten().map(|cost| cost.load(Relaxed)) {
                if cost < f32::INFINITY.to_bits() {
                    counts[(cost >> BIN) as usize] += 1;
                }
            }
            for (sum, count) in magnitudes.iter().zip(counts).filter(|(_, count)| *count > 0) {
                sum.fetch_add(count, Relaxed);
            }
            if !is_all {
                found.0 = edges;
            }
        });
        Ok((found.into_iter().map(|(edges, _)| edges).collect(), Magnitudes(magnitudes)))
    }

    /// The edges that cost less than `limit`, in parts, by costs as they are.
    pub fn edges_below(&self, context: &Context, limit: f32) -> Vec<Vec<Edge>> {
        context.map(self.costs.len().div_ceil(CHUNK_LEN), |part| self.edges(part, [f32::INFINITY, limit]).0)
    }

    /// The edges of a part of the triangles that cost less than `ahead`, or did when they could not collapse; and which
    /// of them have costs that are to be found anew. What their vertices know is asked for.
    fn edges(&self, part: usize, [known, ahead]: [f32; 2]) -> (Vec<Edge>, Vec<u32>) {
        let costs = &self.costs[part * CHUNK_LEN..self.costs.len().min((part + 1) * CHUNK_LEN)];
        // No branch but that of the loop: what costs less is not foreseen.
        let mut corners = vec![0; 3 * costs.len() + 1];
        let mut count = 0;
        for (first, costs) in ((4 * CHUNK_LEN * part) as u32..).step_by(4).zip(costs) {
            for (corner, cost) in (first..).zip(costs) {
                corners[count] = corner;
                count += usize::from(cost.load(Relaxed) & !SIGN < ahead.to_bits());
            }
        }
        let edge = |corner: &u32| Edge {
            cost: f32::from_bits(self.cost(*corner).load(Relaxed)),
            corner: *corner,
            ends: [self.mesh.vertex(*corner), self.mesh.vertex(next(*corner))],
        };
        let edges: Vec<Edge> = corners[..count].iter().map(edge).collect();
        let mut old = Vec::with_capacity(count);
        for (index, edge) in (0..).zip(&edges) {
            let states = edge.ends.map(|end| self.state[end as usize].load(Relaxed));
            if edge.cost.abs() >= known || (states[0] | states[1]) & CHANGED != 0 {
                old.push(index);
                for (end, state) in edge.ends.into_iter().zip(states) {
                    if state & (STALE | WANTED) == STALE {
                        self.state[end as usize].fetch_or(WANTED, Relaxed);
                    }
                }
            }
        }
        (edges, old)
    }

    /// Begins a round.
    pub fn begin(&mut self) {
        self.state.iter_mut().for_each(|state| *state.get_mut() &= !(CHANGED | TRIED));
    }

    /// Whether a vertex is that of an edge that is tried in this round, or beside one.
    pub fn is_tried(&self, vertex: u32) -> bool {
        self.state[vertex as usize].load(Relaxed) & TRIED != 0
    }

    /// Notes that a vertex is that of an edge that is tried, or beside one. At any time only one thread does, for a vertex.
    pub fn set_tried(&self, vertex: u32) {
        self.add_state(vertex, TRIED);
    }

    /// Notes that triangles at a vertex change. At any time only one thread does, for a vertex.
    pub fn set_changed(&self, vertex: u32) {
        self.add_state(vertex, CHANGED | STALE);
    }

    /// Whether triangles at a vertex changed since what it knows of them was found.
    pub fn is_stale(&self, vertex: u32) -> bool {
        self.state[vertex as usize].load(Relaxed) & STALE != 0
    }

    /// Notes that triangles at a vertex change. Returns whether an edge there had been refused, which is forgotten.
    pub fn awake(&mut self, vertex: u32) -> bool {
        let state = self.state[vertex as usize].get_mut();
        let was = *state;
        *state = (was | STALE) & !REFUSED;
        was & REFUSED != 0
    }

    /// Notes that the edge of a half-edge must not collapse before its surroundings change.
    pub fn refuse(&self, edge: &Edge) {
        self.set_cost(edge.corner, -edge.cost);
        edge.ends.iter().for_each(|end| self.add_state(*end, REFUSED));
    }

    fn add_state(&self, vertex: u32, state: u8) {
        let known = &self.state[vertex as usize];
        known.store(known.load(Relaxed) | state, Relaxed);
    }

    /// Asks for what is known of a vertex to be brought near.
    #[inline(always)]
    pub fn prefetch(&self, vertex: u32) {
        prefetch(&self.stars, vertex as usize);
        prefetch(&self.points, vertex as usize);
        self.mesh.prefetch(vertex);
    }

    /// Asks for what it costs to collapse a half-edge, and for its vertex, to be brought near.
    #[inline(always)]
    pub fn prefetch_edge(&self, corner: u32) {
        prefetch(&self.costs, corner as usize / 4);
        self.mesh.prefetch_corner(corner);
    }

    /// Keeps what it costs to collapse a half-edge.
    pub fn set_cost(&self, corner: u32, cost: f32) {
        self.cost(corner).store(cost.to_bits(), Relaxed);
    }

    /// What it costs to collapse a half-edge, as it is kept.
    #[inline(always)]
    pub fn known_cost(&self, corner: u32) -> f32 {
        f32::from_bits(self.cost(corner).load(Relaxed))
    }

    #[inline(always)]
    fn cost(&self, corner: u32) -> &AtomicU32 {
        &self.costs.as_flattened()[slot(corner)]
    }

    /// Collapses a half-edge, as [`Connectivity::collapse`]. The edges of its vertex are taken to cost `guess`.
    /// With `end_stays` the values of attributes are those of its end.
    pub fn collapse(&self, corner: u32, start: usize, guess: f32, end_stays: bool) -> usize {
        let mesh = &self.mesh;
        if Q > 0 {
            self.wedges.collapse(mesh, corner, end_stays);
        }
        let kept = mesh.vertex(corner);
        for side in [corner, mesh.mate(corner)].into_iter().filter(|side| *side != NONE) {
            for gone in [side, next(side), previous(side)] {
                self.set_cost(gone, f32::INFINITY);
            }
        }
        let gone = mesh.collapse(corner, start);
        let inner = mesh.flags[kept as usize] == 0;
        for corner in mesh.around(kept) {
            let (after, before) = (mesh.vertex(next(corner)), mesh.vertex(previous(corner)));
            for (edge, is_lower) in [(corner, kept < after), (previous(corner), before < kept)] {
                // Which vertex is lower is not foreseen: a choice without a branch.
                let stands = is_lower | (!inner && mesh.mate(edge) == NONE);
                self.set_cost(edge, [f32::INFINITY, guess][usize::from(stands)]);
            }
        }
        gone
    }

    /// Places all edges of a batch.
    pub fn place(context: &Context, batch: &mut Batch) {
        if Q > 0 { place_with(context.level(), batch) } else { place(context.level(), batch) }
    }

    /// Whether a half-edge is at a boundary or a seam.
    #[inline(always)]
    pub fn is_line(&self, corner: u32) -> bool {
        self.mesh.mate(corner) == NONE || self.wedges.is_seam(&self.mesh, corner)
    }

    /// The edge of a half-edge.
    pub fn span(&self, corner: u32) -> Span {
        let ends = [corner, next(corner)].map(|at| self.mesh.vertex(at));
        let [u, v] = ends.map(|end| self.points[end as usize].xyz());
        Span { corner, ends, along: v - u }
    }

    /// Puts an edge into a lane of a batch.
    #[inline(always)]
    pub fn gather(&self, edge: &Edge, batch: &mut Batch, lane: usize) {
        let Edge { corner, ends, .. } = *edge;
        let (lane, mate) = (lane % BATCH, self.mesh.mate(corner));
        let [u, v] = ends.map(|end| self.points[end as usize]);
        let flags = ends.map(|end| self.mesh.flags[end as usize]);
        let mut pinned = 0.0;
        if flags != [0; 2] {
            let is_line = |flags: u8| flags & (BOUNDARY | SEAM) != 0;
            // What goes into a seam sideways takes the values of one of its sides only.
            let stays = |own: u8, other: u8| own & FIXED != 0 || own & SEAM > other & SEAM;
            pinned = match [stays(flags[0], flags[1]), stays(flags[1], flags[0])] {
                _ if flags.into_iter().all(is_line) && !self.is_line(corner) => f32::INFINITY,
                [false, false] => 0.0,
                [true, false] => -1.0,
                [false, true] => 1.0,
                [true, true] => f32::INFINITY,
            };
        }
        let left = &self.normals[corner as usize / 4];
        let right = if mate == NONE { &Vec4::ZERO } else { &self.normals[mate as usize / 4] };
        for axis in 0..3 {
            batch.edge[axis][lane] = v[axis] - u[axis];
            batch.side[0][axis][lane] = left[axis];
            batch.side[1][axis][lane] = right[axis];
        }
        let stars = ends.map(|end| &self.stars[end as usize]);
        for entry in 0..9 {
            batch.star[0][entry][lane] = stars[0][entry];
            batch.star[1][entry][lane] = stars[1][entry];
        }
        batch.open[lane] = f32::from(u8::from(self.is_line(corner)));
        if Q > 0 {
            let span = Span { corner, ends, along: (v - u).xyz() };
            let is_moved = pinned.is_finite();
            let added = if is_moved { self.wedges.quadric(&self.mesh, &span, pinned) } else { Quadric::default() };
            let Quadric { square, linear, constant, trace } = added;
            let linear = linear.to_array();
            for (entry, number) in square.into_iter().chain(linear).chain([constant, trace]).enumerate() {
                batch.added[entry][lane] = number;
            }
        }
        batch.pinned[lane] = pinned;
        batch.factor[lane] = 1.0;
        if !self.factors.is_empty() {
            batch.factor[lane] = self.factors[ends[0] as usize].max(self.factors[ends[1] as usize]);
        }
        batch.before[lane] = u.w.max(v.w);
    }

    /// Leaves out what is gone where that is much.
    pub fn compact(&mut self, context: &Context) -> Result<()> {
        if self.live * 10 > self.mesh.triangles() * 6 {
            return Ok(());
        }
        let all = 0..self.mesh.triangles() as u32;
        let mut kept = Vec::with_capacity(self.live);
        kept.extend(all.filter(|old| self.mesh.triangle(*old as usize)[0] != NONE));
        // What needs no more than that is smaller before there are lists of new numbers: here is the peak of a build.
        self.normals = context.map(kept.len(), |new| self.normals[kept[new] as usize]);
        let costs = |new: usize| self.costs[kept[new] as usize].each_ref().map(|cost| cost.load(Relaxed).into());
        self.costs = context.map(kept.len(), costs);
        let mut rest = Vec::with_capacity(self.live / 2);
        rest.extend((0..self.points.len() as u32).filter(|old| !self.mesh.is_gone(*old)));
        self.points = context.map(rest.len(), |new| self.points[rest[new] as usize]);
        self.stars = context.map(rest.len(), |new| self.stars[rest[new] as usize]);
        if !self.factors.is_empty() {
            self.factors = context.map(rest.len(), |new| self.factors[rest[new] as usize]);
        }
        let state = |new: usize| AtomicU8::new(self.state[rest[new] as usize].load(Relaxed));
        self.state = context.map(rest.len(), state);
        if let Some(recording) = &mut self.recording {
            recording.compact(context, &rest, &kept);
        }
        self.wedges.compact(context, &kept, &rest);
        self.mesh.compact(context, &kept, &rest)?;
        self.parts = self.mesh.parts(context);
        Ok(())
    }
}
