//! Which collapses are made together (Grund, Derzapf, Guthe 2011; Derzapf, Grund, Guthe 2014, Section 3).
//!
//! Two collapses go together if no vertex of one shares an edge with a vertex of the other, so that every triangle has
//! one moving corner at most. Edges are taken in the order of their keys: the magnitude of the cost, in quarters of an
//! octave, and a number mixed from the corner, which lets neighbours of nearly the same cost go in any order. Parts of
//! the mesh do that at the same time for edges whose surroundings are theirs alone; the others come thereafter.

use std::sync::atomic::Ordering::Relaxed;

use glam::{Vec4, Vec4Swizzles};
use relievo_core::Context;

use crate::connectivity::{Fan, NONE, next, previous};
use crate::decimation::{CHANGED, Decimation, Edge, normal};
use crate::placement::{BATCH, Batch, place};
use crate::progressive::Made;

/// Bits of a cost that are its magnitude: all but these.
const FINE: u32 = 21;
/// The squared cosine of the angle that a triangle may turn by.
const TURN: f32 = 0.04;

/// A collapse, where its vertex goes and how it deviates, and of how many triangles it changes the normals.
struct Collapse {
    corner: u32,
    key: u64,
    point: Vec4,
    changed: usize,
}

/// Collapses that go together, and the new normals of triangles.
#[derive(Default)]
pub struct Collapses {
    collapses: Vec<Collapse>,
    normals: Vec<(u32, Vec4)>,
}

impl Collapses {
    /// The collapses, as a recording takes them.
    fn made(&self) -> Vec<Made> {
        let mut normals = self.normals.iter();
        let made = |collapse: &Collapse| {
            let sum = normals.by_ref().take(collapse.changed).map(|(_, normal)| normal).sum::<Vec4>();
            (collapse.corner, collapse.point, sum.xyz())
        };
        self.collapses.iter().map(made).collect()
    }

    /// Leaves out those of greater keys.
    fn keep_to(&mut self, last: u64) {
        let mut normals = std::mem::take(&mut self.normals).into_iter();
        let kept = &mut self.normals;
        self.collapses.retain(|collapse| {
            let stays = collapse.key <= last;
            let changed = normals.by_ref().take(collapse.changed);
            if stays {
                kept.extend(changed)
            } else {
                changed.for_each(drop)
            }
            stays
        });
    }
}

/// The selection in a part of the mesh, or of what the parts leave.
struct Selection<'a> {
    work: &'a Decimation,
    context: &'a Context,
    part: Option<u32>,
    batch: Batch,
    fans: Vec<[Fan; 2]>,
    taken: Vec<Edge>,
    found: Collapses,
    rest: Vec<Edge>,
}

/// Another number for each number, with no pattern (a bijection of xors, shifts and odd factors).
fn mixed(number: u32) -> u32 {
    let number = (number ^ number >> 16).wrapping_mul(0x7feb_352d);
    let number = (number ^ number >> 15).wrapping_mul(0x846c_a68b);
    number ^ number >> 16
}

/// Tells the order of edges, none of two the same.
fn key(edge: &Edge) -> u64 {
    u64::from(edge.cost.to_bits() >> FINE) << 53 | u64::from(mixed(edge.corner)) << 21
}

impl Decimation {
    /// The collapses that are made together, of those of `edges`, in parts, that cost less than `limit`. Triangles are
    /// taken to be unchanged from here on.
    pub fn select(&mut self, context: &Context, edges: &[Vec<Edge>], limit: f32) -> Vec<Collapses> {
        self.state.iter_mut().for_each(|state| *state.get_mut() = 0);
        let work = &*self;
        let (rest, mut found): (Vec<_>, Vec<_>) = context
            .map(edges.len(), |part| {
                let is_cheap = |edge: &&Edge| edge.cost.to_bits() < limit.to_bits();
                let edges: Vec<Edge> = edges[part].iter().filter(is_cheap).copied().collect();
                Selection::new(context, work, Some(part)).run(&edges)
            })
            .into_iter()
            .unzip();
        found.push(Selection::new(context, work, None).run(&rest.concat()).1);
        found
    }

    /// Makes collapses, no more than it takes to be rid of `surplus` triangles: those of the lowest keys. Returns
    /// whether there were any.
    pub fn apply(&mut self, context: &Context, mut accepted: Vec<Collapses>, surplus: usize) -> bool {
        let mut keys: Vec<u64> = accepted.iter().flat_map(|found| &found.collapses).map(|one| one.key).collect();
        let most = surplus.div_ceil(2);
        if keys.len() > most {
            let (_, last, _) = keys.select_nth_unstable(most - 1);
            accepted.iter_mut().for_each(|found| found.keep_to(*last));
        }
        if let Some(recording) = &mut self.recording {
            recording.add(context, &self.mesh, &accepted.iter().map(Collapses::made).collect::<Vec<_>>());
        }
        for found in &accepted {
            for collapse in &found.collapses {
                let [kept, gone] = [collapse.corner, next(collapse.corner)].map(|at| self.mesh.vertex(at) as usize);
                self.points[kept] = collapse.point;
                self.mesh.flags[kept] |= self.mesh.flags[gone];
            }
            for (triangle, normal) in &found.normals {
                self.normals[*triangle as usize] = *normal;
            }
        }
        let mut end = self.mesh.grow(accepted.iter().map(|found| found.normals.len()).sum());
        let ends = accepted.iter().map(|found| {
            end += found.normals.len();
            end
        });
        let ends: Vec<usize> = ends.collect();
        let work = &*self;
        let gone = context.map(accepted.len(), |part| {
            let mut start = ends[part] - accepted[part].normals.len();
            let gone = accepted[part].collapses.iter().map(|collapse| {
                start += collapse.changed;
                work.collapse(collapse.corner, start - collapse.changed)
            });
            gone.sum::<usize>()
        });
        self.live -= gone.into_iter().sum::<usize>();
        !keys.is_empty()
    }
}

impl<'a> Selection<'a> {
    fn new(context: &'a Context, work: &'a Decimation, part: Option<usize>) -> Self {
        Self {
            work,
            context,
            part: part.map(|part| part as u32),
            batch: Batch::default(),
            fans: (0..BATCH).map(|_| <[Fan; 2]>::default()).collect(),
            taken: Vec::with_capacity(BATCH),
            found: Collapses::default(),
            rest: Vec::new(),
        }
    }

    /// The edges that are not of the part alone, and the collapses.
    fn run(mut self, edges: &[Edge]) -> (Vec<Edge>, Collapses) {
        let (work, part) = (self.work, self.part);
        let is_mine = |vertex: u32| part.is_none_or(|part| work.parts[vertex as usize] == part);
        let mut order: Vec<u64> = (0..).zip(edges).map(|(index, edge)| key(edge) & !0xffff_ffff | index).collect();
        order.sort_unstable();
        for edge in order.into_iter().map(|index| edges[index as u32 as usize]) {
            if !edge.ends.iter().all(|end| is_mine(*end)) {
                self.rest.push(edge);
                continue;
            }
            if edge.ends.iter().any(|end| work.is_changed(*end)) {
                continue;
            }
            let fans = &mut self.fans[self.taken.len()];
            for (end, fan) in edge.ends.into_iter().zip(&mut *fans) {
                work.mesh.fan(end, fan);
            }
            if !fans.iter().flat_map(Fan::ring).all(is_mine) {
                self.rest.push(edge);
            } else if !work.keeps_surface(edge.corner, fans) {
                work.set_cost(edge.corner, -edge.cost);
            } else {
                for vertex in edge.ends.into_iter().chain(fans.iter().flat_map(Fan::ring)) {
                    work.state[vertex as usize].store(CHANGED, Relaxed);
                }
                work.gather(&edge, &mut self.batch, self.taken.len());
                self.taken.push(edge);
                if self.taken.len() == BATCH {
                    self.decide();
                }
            }
        }
        self.decide();
        (self.rest, self.found)
    }

    /// Accepts or refuses the edges of the batch.
    fn decide(&mut self) {
        let Self { work, context, batch, fans, taken, found, .. } = self;
        place(context.level(), batch);
        for (lane, (edge, fans)) in taken.drain(..).zip(fans).enumerate() {
            let [start, end] = edge.ends.map(|end| work.points[end as usize]);
            let mut point = match batch.pinned[lane] {
                pinned if pinned < 0.0 => start,
                pinned if pinned > 0.0 => end,
                _ => {
                    let [x, y, z] = batch.place;
                    0.5 * (start + end) + Vec4::new(x[lane], y[lane], z[lane], 0.0)
                }
            };
            point.w = batch.deviation[lane];
            let before = found.normals.len();
            if work.keeps_sides(edge.corner, fans, point, &mut found.normals) {
                let changed = found.normals.len() - before;
                found.collapses.push(Collapse { corner: edge.corner, key: key(&edge), point, changed });
            } else {
                found.normals.truncate(before);
                work.set_cost(edge.corner, -edge.cost);
            }
        }
    }
}

impl Decimation {
    /// Whether the surface stays what it is (link condition: Dey, Edelsbrunner, Guha, Nekhayev 1999), and its vertices
    /// keep the triangles they need.
    fn keeps_surface(&self, corner: u32, fans: &[Fan; 2]) -> bool {
        let mesh = &self.mesh;
        if fans.iter().any(Fan::is_full) {
            return false;
        }
        let sides = [corner, mesh.mate(corner)];
        let in_both = |vertex: u32| fans[0].ring().filter(|other| *other == vertex).count();
        let common: usize = fans[1].ring().map(in_both).sum();
        if common != 1 + usize::from(sides[1] != NONE) {
            return false;
        }
        for side in sides.into_iter().filter(|side| *side != NONE) {
            // Without another triangle the opposite vertex would have no edge to the one that is left.
            if mesh.mate(next(side)) == NONE && mesh.mate(previous(side)) == NONE {
                return false;
            }
            let opposite = mesh.vertex(previous(side));
            let least = if mesh.flags[opposite as usize] != 0 { 1 } else { 3 };
            if mesh.around(opposite).len() <= least {
                return false;
            }
        }
        true
    }

    /// Whether no triangle turns too far or vanishes. Puts the new normals of triangles into a list.
    fn keeps_sides(&self, corner: u32, fans: &[Fan; 2], point: Vec4, normals: &mut Vec<(u32, Vec4)>) -> bool {
        let gone = [corner, self.mesh.mate(corner)].map(|side| side / 4);
        for spoke in fans.iter().flat_map(Fan::spokes) {
            let triangle = spoke.corner / 4;
            if triangle == gone[0] || triangle == gone[1] {
                continue;
            }
            let [a, b] = [spoke.to, spoke.from].map(|vertex| self.points[vertex as usize].xyz() - point.xyz());
            let (new, old) = (normal(a, b), self.normals[triangle as usize]);
            let agreement = new.dot(old);
            let sizes = new.length_squared() * old.length_squared();
            if agreement * agreement.abs() < TURN * sizes || new == Vec4::ZERO {
                return false;
            }
            normals.push((triangle, new));
        }
        true
    }
}
