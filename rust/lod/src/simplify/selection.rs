//! Which collapses are made together (Grund, Derzapf, Guthe 2011; Derzapf, Grund, Guthe 2014, Section 3).
//!
//! Two collapses go together if no vertex of one shares an edge with a vertex of the other, so that every triangle has
//! one moving corner at most. Edges are taken in the order of the magnitudes of their costs, in quarters of an octave.
//! Parts of the mesh do that at the same time for edges whose surroundings are theirs alone, then ever larger parts for
//! the others.

use glam::{Vec3, Vec3A, Vec4, Vec4Swizzles};
use relievo_core::Context;

use crate::connectivity::{Fan, NONE, OUTSIDE, SEAM, next, previous};
use crate::progressive::Made;
use crate::simplify::decimation::{Decimation, Edge, normal};
use crate::simplify::placement::{BATCH, Batch};

/// Bits of a cost that are its magnitude: all but these.
const FINE: u32 = 21;
/// So many parts as a power of two, that follow each other, become one for the edges that they leave.
const JOINED: u32 = 2;
/// What the edges of a vertex are taken to cost beside the collapse that made it, until a round looks at them.
const DEARER: f32 = 2.0;
/// The squared cosine of the angle that a triangle may turn by.
const TURN: f32 = 0.04;

/// A collapse, where its vertex goes and how it deviates, and of how many triangles it changes the normals.
struct Collapse {
    corner: u32,
    key: u64,
    point: Vec4,
    changed: usize,
    /// As in a batch.
    pinned: f32,
}

/// Collapses that go together, and the new normals of triangles.
#[derive(Default)]
pub struct Collapses {
    collapses: Vec<Collapse>,
    normals: Vec<(u32, Vec3)>,
}

impl Collapses {
    /// The collapses, as a recording takes them.
    fn made(&self) -> Vec<Made> {
        let mut normals = self.normals.iter();
        let made = |collapse: &Collapse| {
            let sum = normals.by_ref().take(collapse.changed).map(|(_, normal)| normal).sum::<Vec3>();
            (collapse.corner, collapse.point, sum)
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

/// The selection in a part of the mesh.
struct Selection<'a, const Q: usize> {
    work: &'a Decimation<Q>,
    context: &'a Context,
    /// The number of the part, and how many bits of the numbers of parts it is that do not count.
    part: u32,
    shift: u32,
    batch: Batch,
    fans: Vec<[Fan; 2]>,
    taken: Vec<Edge>,
    found: Collapses,
    rest: Vec<Edge>,
}

/// Tells the order of edges, none of two the same.
fn key(edge: &Edge) -> u64 {
    u64::from(edge.cost.to_bits()) << 32 | u64::from(edge.corner)
}

/// Edges in the order of the magnitudes of their costs, and where these are the same, as they come.
fn by_cost(edges: &[Edge]) -> Vec<Edge> {
    let magnitude = |edge: &Edge| (edge.cost.to_bits() >> FINE) as usize;
    let mut starts = [0; 1 << (31 - FINE)];
    edges.iter().for_each(|edge| starts[magnitude(edge)] += 1);
    let mut end = 0;
    for start in &mut starts {
        end += std::mem::replace(start, end);
    }
    let mut ordered = vec![Edge::default(); edges.len()];
    for edge in edges {
        let start = &mut starts[magnitude(edge)];
        ordered[*start] = *edge;
        *start += 1;
    }
    ordered
}

impl<const Q: usize> Decimation<Q> {
    /// The collapses that are made together, of those of `edges`, in parts, that cost less than `limit`. Triangles are
    /// taken to be unchanged from here on.
    pub fn select(&mut self, context: &Context, edges: Vec<Vec<Edge>>, limit: f32) -> Vec<Collapses> {
        self.begin();
        let work = &*self;
        let mut lists = edges;
        context.for_each_mut(&mut lists, |_, list| list.retain(|edge| edge.cost.to_bits() < limit.to_bits()));
        let mut found = Vec::new();
        let mut shift = 0;
        while !lists.is_empty() {
            let run = |part: usize| Selection::new(context, work, part as u32, shift).run(&lists[part]);
            let (rest, collapses): (Vec<_>, Vec<_>) = context.map(lists.len(), run).into_iter().unzip();
            found.extend(collapses);
            lists = if rest.len() > 1 { rest.chunks(1 << JOINED).map(<[_]>::concat).collect() } else { Vec::new() };
            shift += JOINED;
        }
        found
    }

    /// Makes collapses, no more than it takes to be rid of `surplus` triangles: those of the lowest keys. Returns
    /// whether there were any. The next round takes costs below `known` to be right.
    pub fn apply(&mut self, context: &Context, mut accepted: Vec<Collapses>, surplus: usize, known: f32) -> bool {
        let mut keys: Vec<u64> = accepted.iter().flat_map(|found| &found.collapses).map(|one| one.key).collect();
        let most = surplus.div_ceil(2);
        if keys.len() > most {
            let (_, last, _) = keys.select_nth_unstable(most - 1);
            accepted.iter_mut().for_each(|found| found.keep_to(*last));
        }
        if let Some(recording) = &mut self.recording {
            recording.add(context, &self.mesh, &accepted.iter().map(Collapses::made).collect::<Vec<_>>());
        }
        if Q > 0 {
            let work = &*self;
            let merged = context.map(accepted.len(), |part| {
                let free = accepted[part].collapses.iter().filter(|collapse| collapse.pinned == 0.0);
                free.flat_map(|collapse| work.merged(collapse.corner, collapse.point)).collect::<Vec<_>>()
            });
            merged.into_iter().for_each(|merged| self.wedges.set(merged));
            if let Some(recording) = &mut self.recording {
                let end_stays = |found: &Collapses| -> Vec<_> {
                    found.collapses.iter().map(|collapse| (collapse.corner, collapse.pinned > 0.0)).collect()
                };
                let made: Vec<_> = accepted.iter().map(end_stays).collect();
                recording.add_joins(context, &self.mesh, &self.wedges, &made);
            }
        }
        for found in &accepted {
            for collapse in &found.collapses {
                let [kept, gone] = [collapse.corner, next(collapse.corner)].map(|at| self.mesh.vertex(at) as usize);
                self.points[kept] = collapse.point;
                self.join_factors(kept, gone);
                self.mesh.flags[kept] |= self.mesh.flags[gone];
            }
            for (triangle, normal) in &found.normals {
                self.normals[*triangle as usize] = normal.extend(0.0);
            }
        }
        let room = |found: &Collapses| found.normals.len() + found.collapses.len();
        let mut end = self.mesh.grow(accepted.iter().map(room).sum());
        let starts = accepted.iter().map(|found| {
            end += room(found);
            end - room(found)
        });
        let starts: Vec<usize> = starts.collect();
        let work = &*self;
        let gone = context.map(accepted.len(), |part| {
            let mut end = starts[part];
            let gone = accepted[part].collapses.iter().map(|collapse| {
                let start = end;
                end += collapse.changed + 1;
                let guess = f32::from_bits((collapse.key >> 32) as u32) * DEARER;
                work.collapse(collapse.corner, start, guess.max(known), collapse.pinned > 0.0)
            });
            gone.sum::<usize>()
        });
        self.live -= gone.into_iter().sum::<usize>();
        !keys.is_empty()
    }
}

impl<'a, const Q: usize> Selection<'a, Q> {
    fn new(context: &'a Context, work: &'a Decimation<Q>, part: u32, shift: u32) -> Self {
        Self {
            work,
            context,
            part,
            shift,
            batch: Batch::default(),
            fans: (0..BATCH).map(|_| <[Fan; 2]>::default()).collect(),
            taken: Vec::with_capacity(BATCH),
            found: Collapses::default(),
            rest: Vec::new(),
        }
    }

    /// The edges that are not of the part alone, and the collapses.
    fn run(mut self, edges: &[Edge]) -> (Vec<Edge>, Collapses) {
        let Self { work, part, shift, .. } = self;
        let is_mine = |vertex: u32| work.parts[vertex as usize].number(shift) == part;
        let is_inner = |vertex: &u32| is_mine(*vertex) && work.parts[*vertex as usize].is_inner(shift);
        for edge in by_cost(edges) {
            // Often tells without its fans what they would.
            if !edge.ends.iter().all(is_inner) {
                self.rest.push(edge);
                continue;
            }
            if edge.ends.iter().any(|end| work.is_tried(*end)) {
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
                    work.set_tried(vertex);
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
        Decimation::<Q>::place(context, batch);
        for (lane, (edge, fans)) in taken.drain(..).zip(fans).enumerate() {
            let [start, end] = edge.ends.map(|end| work.points[end as usize]);
            let point = batch.point(lane, [start, end]);
            let before = found.normals.len();
            let pinned = batch.pinned[lane];
            if work.keeps_sides(edge.corner, fans, point, &mut found.normals)
                && work.keeps_textures(edge.corner, fans, point, pinned)
            {
                // Around an edge that is refused nothing changes, so that it waits and lets others go first.
                edge.ends
                    .into_iter()
                    .chain(fans.iter().flat_map(Fan::ring))
                    .for_each(|vertex| work.set_changed(vertex));
                let changed = found.normals.len() - before;
                found.collapses.push(Collapse { corner: edge.corner, key: key(&edge), point, changed, pinned });
            } else {
                found.normals.truncate(before);
                work.set_cost(edge.corner, -edge.cost);
            }
        }
    }
}

impl<const Q: usize> Decimation<Q> {
    /// What wedges have after a collapse that moves both vertices.
    fn merged(&self, corner: u32, point: Vec4) -> impl Iterator<Item = (u32, [Vec4; Q])> {
        let span = self.span(corner);
        let [u, v] = span.ends.map(|end| self.points[end as usize].xyz());
        self.wedges.merged(&self.mesh, span, point.xyz() - 0.5 * (u + v))
    }

    /// Whether a collapse, pinned as in a batch, turns no triangle over in a texture.
    fn keeps_textures(&self, corner: u32, fans: &[Fan; 2], point: Vec4, pinned: f32) -> bool {
        if !self.wedges.has_textures() {
            return true;
        }
        let mut merged = [None; 2];
        if pinned == 0.0 {
            merged.iter_mut().zip(self.merged(corner, point)).for_each(|(one, (_, values))| *one = Some(values));
        }
        self.wedges.keeps_textures(&self.mesh, (corner, pinned > 0.0), fans, merged)
    }

    /// Whether the surface stays what it is (link condition: Dey, Edelsbrunner, Guha, Nekhayev 1999), and its vertices
    /// keep the triangles they need.
    pub fn keeps_surface(&self, corner: u32, fans: &[Fan; 2]) -> bool {
        let mesh = &self.mesh;
        if fans.iter().any(Fan::is_full) {
            return false;
        }
        let sides = [corner, mesh.mate(corner)];
        // Half-edges of a triangle that has one vertex twice can be mates.
        if sides[0] / 4 == sides[1] / 4 {
            return false;
        }
        let in_both = |vertex: u32| fans[0].ring().filter(|other| *other == vertex).count();
        let common: usize = fans[1].ring().map(in_both).sum();
        if common != 1 + usize::from(sides[1] != NONE) {
            return false;
        }
        for side in sides.into_iter().filter(|side| *side != NONE) {
            // Without another triangle the opposite vertex would have no edge to the one that is left; and where all is
            // seams, a whole island of values would go.
            if self.is_line(next(side)) && self.is_line(previous(side)) {
                return false;
            }
            let opposite = mesh.vertex(previous(side));
            let least = match mesh.flags[opposite as usize] & !SEAM {
                0 => 3,
                // With one elsewhere, and should other patches take some too, three are left.
                flags if flags & OUTSIDE != 0 => 2,
                _ => 1,
            };
            if mesh.around(opposite).take(least + 1).count() <= least {
                return false;
            }
        }
        true
    }

    /// Whether no triangle turns too far or vanishes. Puts the new normals of triangles into a list.
    pub fn keeps_sides(&self, corner: u32, fans: &[Fan; 2], point: Vec4, normals: &mut Vec<(u32, Vec3)>) -> bool {
        let point = Vec3A::from_vec4(point);
        let gone = [corner, self.mesh.mate(corner)].map(|side| side / 4);
        for spoke in fans.iter().flat_map(Fan::spokes) {
            let triangle = spoke.corner / 4;
            if triangle == gone[0] || triangle == gone[1] {
                continue;
            }
            let [a, b] = [spoke.to, spoke.from].map(|vertex| Vec3A::from_vec4(self.points[vertex as usize]) - point);
            let (new, old) = (normal(a, b), Vec3A::from_vec4(self.normals[triangle as usize]));
            let agreement = new.dot(old);
            let sizes = new.length_squared() * old.length_squared();
            if agreement * agreement.abs() < TURN * sizes || new == Vec3A::ZERO {
                return false;
            }
            normals.push((triangle, new.into()));
        }
        true
    }
}
