//! Which collapses are made together (Grund, Derzapf, Guthe 2011; Derzapf, Grund, Guthe 2014, Section 3).
//!
//! Two collapses go together if no vertex of one shares an edge with a vertex of the other, so that every triangle has
//! one moving corner at most. Each edge has a key of its own: the magnitude of its cost, in quarters of an octave, and a
//! number mixed from its corner, which lets neighbours of nearly the same cost go in any order. An edge is taken if its
//! key is the lowest at its ends and all their neighbours. What that leaves free is taken in further passes.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering::Relaxed};

use glam::{Vec4, Vec4Swizzles};
use relievo_core::Context;

use crate::connectivity::{Fan, NONE, PART, next, previous};
use crate::decimation::{CHANGED, Decimation, MOVED, normal};
use crate::placement::{BATCH, Batch, place};
use crate::progressive::Made;

/// Bits of a cost that are its magnitude: all but these.
const FINE: u32 = 21;
/// Bits of a key; the pass of selection stands above them.
const KEY: u32 = 44;
/// The squared cosine of the angle that a triangle may turn by.
const TURN: f32 = 0.04;

/// An edge that may collapse.
#[derive(Clone, Copy)]
pub struct Candidate {
    corner: u32,
    ends: [u32; 2],
    key: u64,
}

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

/// The selection in a part of the candidates.
struct Selection<'a> {
    work: &'a Decimation,
    list: &'a [Candidate],
    context: &'a Context,
    batch: Batch,
    fans: Vec<[Fan; 2]>,
    slots: Vec<usize>,
    found: Collapses,
    refused: Vec<usize>,
}

/// Another number for each number, with no pattern (a bijection of xors, shifts and odd factors).
fn mixed(number: u32) -> u32 {
    let number = (number ^ number >> 16).wrapping_mul(0x7feb_352d);
    let number = (number ^ number >> 15).wrapping_mul(0x846c_a68b);
    number ^ number >> 16
}

/// Whether no triangle at these vertices changes yet in this round.
fn are_free(state: &[AtomicU8], ends: [u32; 2]) -> bool {
    ends.iter().all(|end| state[*end as usize].load(Relaxed) == 0)
}

impl Decimation {
    /// The edges that cost less than `limit`; all triangles are taken to be unchanged from here on.
    pub fn candidates(&mut self, context: &Context, limit: f32) -> Vec<Vec<Candidate>> {
        self.state.iter_mut().for_each(|state| *state.get_mut() = 0);
        let (costs, mesh, size) = (&self.costs, &self.mesh, 4 * PART);
        context.map(costs.len().div_ceil(size), |part| {
            let first = part * size;
            let mut list = Vec::with_capacity(size / 2);
            for (triangle, costs) in (first as u32..).zip(&costs[first..costs.len().min(first + size)]) {
                for (side, cost) in costs.iter().enumerate().take(3).filter(|(_, cost)| **cost >= 0.0 && **cost < limit)
                {
                    let corner = 4 * triangle + side as u32;
                    let ends = [mesh.vertex(corner), mesh.vertex(next(corner))];
                    let key = u64::from(cost.to_bits() >> FINE) << 32 | u64::from(mixed(corner));
                    list.push(Candidate { corner, ends, key });
                }
            }
            list
        })
    }

    /// A pass of selection. Returns whether there was an edge to look at.
    pub fn select(
        &mut self,
        context: &Context,
        candidates: &mut [Vec<Candidate>],
        collapses: &mut Vec<Collapses>,
    ) -> bool {
        // Keys of later passes are below those of earlier ones, which so need not be wiped out.
        self.epoch = if self.epoch >> KEY == 0 { u64::MAX } else { self.epoch - (1 << KEY) };
        if self.epoch == u64::MAX {
            self.lowest.iter_mut().for_each(|lowest| *lowest.get_mut() = u64::MAX);
        }
        let epoch = self.epoch & !((1 << KEY) - 1);
        let (state, lowest) = (&self.state, &self.lowest);
        context.for_each_mut(candidates, |_, list| {
            list.retain(|candidate| candidate.key != u64::MAX && are_free(state, candidate.ends));
            for candidate in list {
                let key = epoch | candidate.key;
                for end in candidate.ends {
                    let lowest = &lowest[end as usize];
                    if key < lowest.load(Relaxed) {
                        lowest.fetch_min(key, Relaxed);
                    }
                }
            }
        });
        let work = &*self;
        let found = context.map(candidates.len(), |part| Selection::new(context, work, &candidates[part]).run(epoch));
        let before = collapses.len();
        let mut refusals = false;
        for ((found, refused), list) in found.into_iter().zip(candidates) {
            refusals |= !refused.is_empty();
            for slot in refused {
                let corner = list[slot].corner as usize;
                self.costs[corner / 4][corner % 4] = f32::INFINITY;
                list[slot].key = u64::MAX;
            }
            if !found.collapses.is_empty() {
                collapses.push(found);
            }
        }
        refusals || collapses.len() > before
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
                *self.state[kept].get_mut() |= MOVED;
            }
            for (triangle, normal) in &found.normals {
                self.normals[*triangle as usize] = *normal;
            }
        }
        let mesh = &self.mesh;
        let gone = context.map(accepted.len(), |part| {
            accepted[part].collapses.iter().map(|collapse| mesh.collapse(collapse.corner)).sum::<usize>()
        });
        self.live -= gone.into_iter().sum::<usize>();
        !keys.is_empty()
    }
}

impl<'a> Selection<'a> {
    fn new(context: &'a Context, work: &'a Decimation, list: &'a [Candidate]) -> Self {
        Self {
            work,
            list,
            context,
            batch: Batch::default(),
            fans: (0..BATCH).map(|_| <[Fan; 2]>::default()).collect(),
            slots: Vec::with_capacity(BATCH),
            found: Collapses::default(),
            refused: Vec::new(),
        }
    }

    /// The collapses of the lowest keys in this pass, and the candidates that must not collapse.
    fn run(mut self, epoch: u64) -> (Collapses, Vec<usize>) {
        let (work, lowest) = (self.work, &self.work.lowest);
        let lowest_at = |vertex: u32| -> &AtomicU64 { &lowest[vertex as usize] };
        for (slot, Candidate { corner, ends, key }) in self.list.iter().enumerate() {
            let key = epoch | key;
            if ends.iter().any(|end| lowest_at(*end).load(Relaxed) != key) {
                continue;
            }
            let is_lowest = ends.iter().zip(&mut self.fans[self.slots.len()]).all(|(end, fan)| {
                work.mesh.fan(*end, fan);
                fan.ring().all(|vertex| lowest_at(vertex).load(Relaxed) >= key)
            });
            if is_lowest {
                work.gather(*corner, *ends, work.mesh.mate(*corner), &mut self.batch, self.slots.len());
                self.slots.push(slot);
                if self.slots.len() == BATCH {
                    self.decide();
                }
            }
        }
        self.decide();
        (self.found, self.refused)
    }

    /// Accepts or refuses the edges of the batch.
    fn decide(&mut self) {
        place(self.context.level(), &mut self.batch);
        for (lane, (slot, fans)) in self.slots.iter().zip(&self.fans).enumerate() {
            let Candidate { corner, ends, key } = self.list[*slot];
            let [start, end] = ends.map(|end| self.work.points[end as usize]);
            let batch = &self.batch;
            let mut point = match batch.pinned[lane] {
                pinned if pinned < 0.0 => start,
                pinned if pinned > 0.0 => end,
                _ => {
                    let [x, y, z] = batch.place;
                    0.5 * (start + end) + Vec4::new(x[lane], y[lane], z[lane], 0.0)
                }
            };
            point.w = batch.deviation[lane];
            let before = self.found.normals.len();
            if self.work.is_legal(corner, fans, point, &mut self.found.normals) {
                for (end, fan) in ends.into_iter().zip(fans) {
                    self.work.state[end as usize].store(CHANGED, Relaxed);
                    fan.ring().for_each(|vertex| self.work.state[vertex as usize].store(CHANGED, Relaxed));
                }
                let changed = self.found.normals.len() - before;
                self.found.collapses.push(Collapse { corner, key, point, changed });
            } else {
                self.found.normals.truncate(before);
                self.refused.push(*slot);
            }
        }
        self.slots.clear();
    }
}

impl Decimation {
    /// Whether the surface stays what it is (link condition: Dey, Edelsbrunner, Guha, Nekhayev 1999), its vertices keep
    /// the triangles they need, and no triangle turns too far or vanishes. Puts the new normals of triangles into a list.
    fn is_legal(&self, corner: u32, fans: &[Fan; 2], point: Vec4, normals: &mut Vec<(u32, Vec4)>) -> bool {
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
            if mesh.around(opposite).take(least + 1).count() <= least {
                return false;
            }
        }
        let gone = sides.map(|side| side / 4);
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
