//! The mesh while it is simplified: what its vertices know of their triangles, and what the collapse of its edges costs.

use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering::Relaxed};

use glam::{Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Result};

use crate::connectivity::{BOUNDARY, Connectivity, FIXED, NONE, PART, next, previous};
use crate::placement::{BATCH, Batch, Star, place};
use crate::progressive::Recording;

/// State of a vertex whose triangles changed.
pub const CHANGED: u8 = 1;
/// State of a vertex that moved.
pub const MOVED: u8 = 2;

/// Magnitudes of costs that are told apart: eight an octave.
const BINS: usize = (f32::INFINITY.to_bits() >> BIN) as usize;
const BIN: u32 = 20;
/// Of so many triangles, the costs of one are counted.
const SAMPLE: usize = 8;

/// A mesh that is simplified.
pub struct Decimation {
    pub mesh: Connectivity,
    /// Place and deviation of every vertex.
    pub points: Vec<Vec4>,
    /// Normal of every triangle, by the root of its length: its square is twice the area.
    pub normals: Vec<Vec4>,
    /// What costs are found from.
    vertices: Vec<Vertex>,
    /// Of every half-edge, four a triangle. Infinite where the mate stands for the edge, or the edge must not collapse;
    /// negative where its surroundings have changed since.
    pub costs: Vec<[f32; 4]>,
    /// [`CHANGED`] and [`MOVED`] of every vertex, since the last round.
    pub state: Vec<AtomicU8>,
    /// The lowest key at every vertex in this pass of selection.
    pub lowest: Vec<AtomicU64>,
    /// Counts passes of selection, downwards.
    pub epoch: u64,
    /// Triangles that are left.
    pub live: usize,
    /// What was done, if that is to be known.
    pub recording: Option<Recording>,
}

/// A vertex and what it knows of its triangles, in one line of the cache.
#[repr(align(64))]
#[derive(Clone, Copy, Default)]
struct Vertex {
    star: Star,
    point: [f32; 3],
    deviation: f32,
    flags: u8,
}

/// An edge whose cost is found.
struct Edge {
    slot: u32,
    ends: [u32; 2],
    mate: u32,
}

/// How many edges there are of each magnitude of cost.
pub struct Magnitudes(Vec<AtomicU32>);

impl Magnitudes {
    /// The cost below which so large a share of the edges is, or a little more. `None` if there are no edges.
    pub fn below(self, share: f32) -> Option<f32> {
        let counts: Vec<u32> = self.0.into_iter().map(AtomicU32::into_inner).collect();
        let total: u32 = counts.iter().sum();
        let wanted = ((total as f32 * share) as u32).max(1);
        let mut sum = 0;
        let bin = counts.iter().position(|count| {
            sum += count;
            sum >= wanted
        })?;
        Some(f32::from_bits((bin as u32 + 1) << BIN))
    }
}

/// The normal of a triangle between two of its sides, by the root of its length.
#[inline(always)]
pub fn normal(a: Vec3, b: Vec3) -> Vec4 {
    let normal = a.cross(b);
    (normal / normal.length_squared().sqrt().sqrt().max(1e-18)).extend(0.0)
}

impl Decimation {
    /// Of a mesh whose indices are in range, with coordinates multiplied by `scale`.
    pub fn new(context: &Context, points: &[[f32; 3]], triangles: &[[u32; 3]], scale: f32) -> Self {
        let points: Vec<Vec4> = points.iter().map(|point| (Vec3::from(*point) * scale).extend(0.0)).collect();
        let face = |index: usize| {
            let [a, b, c] = triangles[index].map(|vertex| points[vertex as usize].xyz());
            normal(b - a, c - a)
        };
        Self {
            mesh: Connectivity::new(context, points.len(), triangles),
            normals: context.map(triangles.len(), face),
            vertices: vec![Vertex::default(); points.len()],
            costs: vec![[f32::INFINITY; 4]; triangles.len()],
            state: points.iter().map(|_| AtomicU8::new(CHANGED | MOVED)).collect(),
            lowest: points.iter().map(|_| AtomicU64::new(u64::MAX)).collect(),
            epoch: u64::MAX,
            live: triangles.len(),
            recording: None,
            points,
        }
    }

    /// Keeps vertices where they are.
    pub fn lock(&mut self, vertices: &[u32]) {
        for vertex in vertices {
            self.mesh.flags[*vertex as usize] |= FIXED;
        }
    }

    /// The sums of the normals of the triangles at every vertex.
    pub fn vertex_normals(&self, context: &Context) -> Vec<Vec3> {
        let normal = |corner: u32| self.normals[corner as usize / 4].xyz();
        context.map(self.points.len(), |vertex| self.mesh.around(vertex as u32).map(normal).sum())
    }

    /// The triangles that are left, and all points.
    pub fn left(&self) -> (Vec<[u32; 3]>, &[Vec4]) {
        let triangles = (0..self.mesh.triangles()).map(|index| self.mesh.triangle(index));
        (triangles.filter(|triangle| triangle[0] != NONE).collect(), &self.points)
    }

    /// Finds anew what vertices know whose triangles changed.
    pub fn renew_stars(&mut self, context: &Context) -> Result<()> {
        let Self { mesh, points, normals, state, vertices, .. } = self;
        let parts = ((vertices.as_mut_slice(), points.as_slice()), state.as_slice());
        context.for_each_part(parts, PART, |first, ((vertices, here), state)| {
            for (at, ((renewed, here), state)) in vertices.iter_mut().zip(here).zip(state).enumerate() {
                if state.load(Relaxed) == 0 {
                    continue;
                }
                let flags = mesh.flags[first + at];
                let (mut rows, mut sum) = ([Vec4::ZERO; 3], Vec4::ZERO);
                mesh.clean((first + at) as u32, |corner| {
                    let normal = normals[corner as usize / 4];
                    rows[0] += normal * normal.x;
                    rows[1] += normal * normal.y;
                    rows[2] += normal * normal.z;
                    sum += normal;
                    if flags & BOUNDARY != 0 {
                        for (edge, end) in [(corner, next(corner)), (previous(corner), previous(corner))] {
                            if mesh.mate(edge) == NONE {
                                let along = points[mesh.vertex(end) as usize].xyz() - here.xyz();
                                let length = along.length_squared();
                                rows[0] += (Vec3::X * length - along * along.x).extend(0.0);
                                rows[1] += (Vec3::Y * length - along * along.y).extend(0.0);
                                rows[2] += (Vec3::Z * length - along * along.z).extend(0.0);
                            }
                        }
                    }
                });
                let [x, y, z] = rows;
                *renewed = Vertex {
                    star: [x.x, y.y, z.z, x.y, x.z, y.z, sum.x, sum.y, sum.z],
                    point: here.xyz().to_array(),
                    deviation: here.w,
                    flags,
                };
            }
            Ok(())
        })
    }

    /// Finds the costs anew of edges with a vertex that moved, and of those whose surroundings changed and that cost no
    /// more than `ahead` before. Those whose vertex would deviate by more than `error` must not collapse.
    pub fn renew_costs(&mut self, context: &Context, ahead: f32, error: f32) -> Result<Magnitudes> {
        let magnitudes: Vec<AtomicU32> = (0..BINS).map(|_| AtomicU32::new(0)).collect();
        let mut costs = std::mem::take(&mut self.costs);
        let work = &*self;
        let (corners, mates) = work.mesh.sides();
        let parts = (costs.as_mut_slice(), corners, mates);
        context.for_each_part(parts, PART, |first, (costs, corners, mates)| {
            let mut edges = Vec::with_capacity(2 * costs.len());
            for (triangle, ((costs, corners), mates)) in costs.iter_mut().zip(corners).zip(mates).enumerate() {
                work.outdated((4 * triangle) as u32, costs, corners, mates, ahead, &mut edges);
            }
            let mut batch = Batch::default();
            for edges in edges.chunks(BATCH) {
                for (lane, edge) in edges.iter().enumerate() {
                    work.gather(edge.slot + 4 * first as u32, edge.ends, edge.mate, &mut batch, lane);
                }
                place(context.level(), &mut batch);
                for (edge, (cost, deviation)) in edges.iter().zip(batch.cost.iter().zip(&batch.deviation)) {
                    let cost = if *deviation <= error { *cost } else { f32::INFINITY };
                    costs[edge.slot as usize / 4][edge.slot as usize % 4] = cost;
                }
            }
            let mut counts = [0u32; BINS];
            for cost in costs.iter().step_by(SAMPLE).flatten().filter(|cost| cost.abs() < f32::INFINITY) {
                counts[(cost.abs().to_bits() >> BIN) as usize] += 1;
            }
            for (sum, count) in magnitudes.iter().zip(counts).filter(|(_, count)| *count > 0) {
                sum.fetch_add(count, Relaxed);
            }
            Ok(())
        })?;
        self.costs = costs;
        Ok(Magnitudes(magnitudes))
    }

    /// The edges of a triangle whose costs are found anew. `slot` is the number of its first half-edge in its part.
    #[inline(always)]
    fn outdated(
        &self,
        slot: u32,
        costs: &mut [f32; 4],
        corners: &[AtomicU32; 4],
        mates: &[AtomicU32; 4],
        ahead: f32,
        edges: &mut Vec<Edge>,
    ) {
        let [a, b, c] = [corners[0].load(Relaxed), corners[1].load(Relaxed), corners[2].load(Relaxed)];
        if a == NONE {
            *costs = [f32::INFINITY; 4];
            return;
        }
        let state = |vertex: u32| self.state[vertex as usize].load(Relaxed);
        let (i, j, k) = (state(a), state(b), state(c));
        if i | j | k == 0 && costs[0] >= 0.0 && costs[1] >= 0.0 && costs[2] >= 0.0 {
            return;
        }
        let (vertices, states) = ([a, b, c, a], [i, j, k, i]);
        for side in 0..3 {
            let (ends, state) = ([vertices[side], vertices[side + 1]], states[side] | states[side + 1]);
            let cost = costs[side];
            if state == 0 && cost >= 0.0 {
                continue;
            }
            let mate = mates[side].load(Relaxed);
            costs[side] = f32::INFINITY;
            if mate != NONE && ends[1] < ends[0] {
                continue;
            }
            if state & MOVED == 0 && cost.abs() > ahead && cost < f32::INFINITY {
                costs[side] = -cost.abs();
            } else {
                edges.push(Edge { slot: slot + side as u32, ends, mate });
            }
        }
    }

    /// Puts an edge into a lane of a batch.
    #[inline(always)]
    pub fn gather(&self, corner: u32, [u, v]: [u32; 2], mate: u32, batch: &mut Batch, lane: usize) {
        let lane = lane % BATCH;
        let (u, v) = (&self.vertices[u as usize], &self.vertices[v as usize]);
        let mut pinned = 0.0;
        if u.flags | v.flags != 0 {
            pinned = match [u.flags & FIXED != 0, v.flags & FIXED != 0] {
                _ if mate != NONE && u.flags & v.flags & BOUNDARY != 0 => f32::INFINITY,
                [false, false] => 0.0,
                [true, false] => -1.0,
                [false, true] => 1.0,
                [true, true] => f32::INFINITY,
            };
        }
        let left = &self.normals[corner as usize / 4];
        let right = if mate == NONE { &Vec4::ZERO } else { &self.normals[mate as usize / 4] };
        for axis in 0..3 {
            batch.edge[axis][lane] = v.point[axis] - u.point[axis];
            batch.side[0][axis][lane] = left[axis];
            batch.side[1][axis][lane] = right[axis];
        }
        for entry in 0..9 {
            batch.star[0][entry][lane] = u.star[entry];
            batch.star[1][entry][lane] = v.star[entry];
        }
        batch.open[lane] = f32::from(u8::from(mate == NONE));
        batch.pinned[lane] = pinned;
        batch.before[lane] = u.deviation.max(v.deviation);
    }

    /// Leaves out what is gone where that is much. Lists of corners are clean, as after [`Self::renew_stars`].
    pub fn compact(&mut self, context: &Context) -> Result<()> {
        if self.live * 10 > self.mesh.triangles() * 6 {
            return Ok(());
        }
        let mut triangles = vec![NONE; self.normals.len()];
        let mut kept = Vec::with_capacity(self.live);
        for (old, (new, corners)) in triangles.iter_mut().zip(self.mesh.sides().0).enumerate() {
            if corners[0].load(Relaxed) != NONE {
                *new = kept.len() as u32;
                kept.push(old as u32);
            }
        }
        let mut vertices = vec![NONE; self.points.len()];
        let mut rest = Vec::with_capacity(self.live / 2);
        for (old, new) in vertices.iter_mut().enumerate() {
            if !self.mesh.is_gone(old as u32) {
                *new = rest.len() as u32;
                rest.push(old as u32);
            }
        }
        self.mesh.compact(context, (&triangles, &kept), (&vertices, &rest))?;
        if let Some(recording) = &mut self.recording {
            recording.compact(&rest, &kept);
        }
        self.points = rest.iter().map(|old| self.points[*old as usize]).collect();
        self.vertices = rest.iter().map(|old| self.vertices[*old as usize]).collect();
        self.state = rest.iter().map(|old| AtomicU8::new(self.state[*old as usize].load(Relaxed))).collect();
        self.normals = kept.iter().map(|old| self.normals[*old as usize]).collect();
        self.costs = kept.iter().map(|old| self.costs[*old as usize]).collect();
        self.lowest.truncate(rest.len());
        self.lowest.iter_mut().for_each(|lowest| *lowest.get_mut() = u64::MAX);
        Ok(())
    }
}
