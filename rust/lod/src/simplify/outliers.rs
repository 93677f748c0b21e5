//! Smaller largest deviations of a mesh that was simplified, for the same number of triangles.
//!
//! Collapses are made in the order of mean squares, so a few vertices of the input are left much farther away than all
//! others. Around each of them, the farthest first, vertices are moved or an edge is turned, whichever brings the
//! farthest vertex nearer by most, as long as nothing around it becomes as far. The moves and turns are those of mesh
//! optimization (Hoppe et al. 1993), for the largest distance instead of the sum of squares. Deviations that are not out
//! of proportion to the root mean square are left alone, and so is the volume.

use std::collections::BinaryHeap;

use glam::Vec3;
use relievo_core::Context;

use crate::connectivity::NONE;
use crate::simplify::beside::{Beside, Group, Spot, gaps, grouped, sixfold};
use crate::simplify::error_bound::Triangles;
use crate::simplify::patches::Reduced;

/// The share of the largest deviation that is sought.
const GOAL: f32 = 0.7;
/// Deviations up to this many times the root mean square are no outliers: of an input of at most [`COARSE`] triangles, and
/// of others.
const ORDINARY: [f32; 2] = [3.0, 6.0];
/// What is not farther is rounding, where the largest coordinate is 1.
const MIN: f32 = 1e-6;
/// Changes at most.
const CHANGES: usize = 20;
/// Deviations that are looked at more closely at most, and for each vertex of the input if that is less.
const LOOKS: [usize; 2] = [64, 2048];
/// Farthest vertices around which changes are prepared.
const PLACES: usize = 128;
/// Shares of the way to a far vertex by which the surface is moved.
const STEPS: [f32; 3] = [0.6, 0.35, 0.15];
/// The factor by which the deviations that a change leaves have to be smaller.
const SMALLER: f32 = 0.98;
/// The least cosine between the normals of a triangle before and after a change.
const TURNED: f32 = 0.3;
/// Triangles of an input at most whose centres are looked at too, and all samples of the result: of others they are as near
/// as what is around them, or nearly.
const COARSE: usize = 4096;
/// Distances of a point from eight triangles that may be measured for changes: at least, for each triangle of the input,
/// and at most.
const EFFORT: [usize; 3] = [6000, 3, 120_000];
/// What a change that is tried, and a way that is found, count for beside the distances that are measured.
const TRIAL: usize = 60;
/// Places that are measured before it is looked at whether one is too far.
const TOGETHER: usize = 8;
/// The share of the root mean square deviation by which the surface may be moved to one side on average.
const SHIFT: f64 = 0.1;

/// What may be done to the mesh.
enum Change {
    /// Vertices and where they go.
    Moves(Vec<(u32, Vec3)>),
    /// Two triangles, and their vertices with the edge between them turned.
    Turn([u32; 2], [[u32; 3]; 2]),
}

/// A change that can be made.
struct Tried {
    change: Change,
    /// The largest deviation around.
    worst: f32,
    /// Members that were measured anew, by their places in the list, with their squared distances.
    measured: Vec<(u32, f32)>,
    /// What is added to the deviations of other members around, and whose these are.
    moved: f32,
    around: Vec<u32>,
    /// Places on the triangles that changed, with their deviations.
    samples: Vec<(Spot, f32)>,
    /// What is added to six times the volume.
    volume: f64,
}

/// A mesh whose outliers are brought nearer.
struct Repair<'a> {
    beside: Beside<'a>,
    is_still: Vec<bool>,
    /// Six times what the changes add to the volume, and its largest magnitude.
    excess: f64,
    room: f64,
    /// What is left of the effort.
    effort: usize,
}

/// Moves vertices of a simplified mesh, but for `fixed` ones, and turns edges, so that the largest distance between the
/// surfaces is smaller. It is looked at in samples: vertices of both meshes, middles of edges and centres of triangles of
/// the result, and centres of triangles of a coarse input. `scale` is what coordinates were multiplied by. The result does
/// not depend on the number of threads.
pub fn lessen(context: &Context, input: Triangles, scale: f32, fixed: &[u32], reduced: &mut Reduced) {
    if reduced.triangles.is_empty() || reduced.triangles.len() == input.1.len() {
        return;
    }
    let mut numbers = vec![NONE; input.0.len()];
    let mut names = Vec::with_capacity(reduced.triangles.len());
    let mut number = |vertex: u32| {
        let known = &mut numbers[vertex as usize];
        if *known == NONE {
            *known = names.len() as u32;
            names.push(vertex);
        }
        *known
    };
    let triangles: Vec<[u32; 3]> = reduced.triangles.iter().map(|triangle| triangle.map(&mut number)).collect();
    let beside = Beside::new(context, (input, scale), (&names, &numbers), triangles, reduced);
    let mut is_still = vec![false; names.len()];
    for vertex in fixed {
        let now = beside.becomes[*vertex as usize];
        if now != NONE {
            is_still[now as usize] = true;
        }
    }
    let effort = (EFFORT[1] * input.1.len()).clamp(EFFORT[0], EFFORT[2]);
    let mut repair = Repair { beside, is_still, excess: 0.0, room: 0.0, effort };
    repair.run(context);
    let beside = repair.beside;
    for (name, point) in names.iter().zip(&beside.points) {
        let old = &mut reduced.points[*name as usize];
        *old = point.extend(old.w);
    }
    for (old, new) in reduced.triangles.iter_mut().zip(&beside.triangles) {
        *old = new.map(|vertex| names[vertex as usize]);
    }
}

impl Repair<'_> {
    /// Makes changes until there is none left to make.
    fn run(&mut self, context: &Context) {
        let Some((seeds, goal)) = self.seeds(context) else { return };
        let mut waiting: BinaryHeap<(u32, Spot)> = seeds.iter().map(|(found, spot)| (found.to_bits(), *spot)).collect();
        let mut changes = 0;
        while let Some((far, spot)) = waiting.pop() {
            let far = f32::from_bits(far);
            if far <= goal || changes == CHANGES || self.effort == 0 {
                break;
            }
            // Its surroundings may have changed.
            let Some((shares, way)) = self.beside.way(spot) else { continue };
            self.effort = self.effort.saturating_sub(TRIAL);
            let found = way.length();
            if let Spot::Member(at) = spot {
                self.beside.far[at as usize] = found;
            }
            if found < far * (1.0 - 1e-5) {
                if found > goal {
                    waiting.push((found.to_bits(), spot));
                }
                continue;
            }
            let Some(tried) = self.best(spot, &shares, way, found) else { break };
            self.make(tried, goal, &mut waiting);
            changes += 1;
        }
    }

    /// Finds the outliers, with their deviations, and the deviation that is sought. Prepares what is around them.
    fn seeds(&mut self, context: &Context) -> Option<(Vec<(f32, Spot)>, f32)> {
        let beside = &mut self.beside;
        let count = beside.far.len();
        let squares: f64 = beside.far.iter().map(|far| f64::from(*far).powi(2)).sum();
        let mean = (squares / count.max(1) as f64).sqrt();
        let is_coarse = beside.input_triangles().len() <= COARSE;
        let ordinary = ORDINARY[usize::from(!is_coarse)] * mean as f32;
        let mut waiting: BinaryHeap<(u32, u32)> = beside
            .far
            .iter()
            .zip(0..)
            .filter(|(far, _)| **far > ordinary)
            .map(|(far, at)| (far.to_bits(), at))
            .collect();
        // The farthest members, as they are.
        let mut most = 0.0f32;
        let mut seeds: Vec<(f32, Spot)> = Vec::new();
        for _ in 0..(count / 8).clamp(LOOKS[0], LOOKS[1]) {
            let Some((far, at)) = waiting.pop() else { break };
            if f32::from_bits(far) <= GOAL * most || seeds.len() == PLACES {
                break;
            }
            let found = beside.nearest_to_member(at).way.length();
            beside.far[at as usize] = found;
            most = most.max(found);
            if found > ordinary.max(GOAL * most) {
                seeds.push((found, Spot::Member(at)));
            }
        }
        let floor = ordinary.max(GOAL * most);
        let mut looked: Vec<u32> = seeds.iter().flat_map(|(_, spot)| beside.vertices(*spot)).collect();
        looked.extend(beside.doubtful(if is_coarse { -1.0 } else { floor }));
        if looked.is_empty() {
            return None;
        }
        looked.sort_unstable();
        looked.dedup();
        let mut near = looked.clone();
        beside.widen(&mut near, 3);
        beside.collect(context, &near);
        if is_coarse {
            seeds.extend(beside.far_inner(context, floor));
        }
        seeds.extend(beside.far_samples(context, &looked, floor));
        let most = seeds.iter().fold(0.0f32, |most, (found, _)| most.max(*found));
        let goal = ordinary.max(GOAL * most);
        seeds.retain(|(found, _)| *found > goal);
        if seeds.is_empty() || most <= MIN {
            return None;
        }
        self.room = 6.0 * SHIFT * mean * beside.area();
        Some((seeds, goal))
    }

    /// Finds the change that makes the deviation of a spot smallest.
    fn best(&mut self, spot: Spot, shares: &[(u32, f32)], way: Vec3, far: f32) -> Option<Tried> {
        let beside = &self.beside;
        let moved = |vertex: u32, by: Vec3| (vertex, beside.points[vertex as usize] + by);
        let free: Vec<(u32, f32)> =
            shares.iter().copied().filter(|(vertex, _)| !self.is_still[*vertex as usize]).collect();
        let whole: f32 = free.iter().map(|(_, share)| share * share).sum();
        let mut changes = Vec::new();
        for step in STEPS {
            if whole > 0.05 {
                let moves = free.iter().map(|(vertex, share)| (*vertex, way * (step * share / whole)));
                let moves = moves.filter(|(_, by)| by.length() > 1e-3 * far);
                changes.push(Change::Moves(moves.map(|(vertex, by)| moved(vertex, by)).collect()));
            }
            for (vertex, share) in free.iter().filter(|(_, share)| *share > 0.15) {
                changes.push(Change::Moves(vec![moved(*vertex, way * (step / share).min(1.0))]));
            }
        }
        let triangles = match spot {
            Spot::Member(_) | Spot::Inner(_) => vec![beside.nearest_to(spot).triangle],
            Spot::Centre(triangle) => vec![triangle],
            _ => beside.at(&shares.iter().map(|(vertex, _)| *vertex).collect::<Vec<_>>()),
        };
        for triangle in triangles {
            let [a, b, c] = beside.triangles[triangle as usize];
            changes.extend([[a, b], [b, c], [c, a]].into_iter().filter_map(|edge| self.turn(triangle, edge)));
        }
        let mut effort = self.effort;
        let mut best = self.least(spot, changes, far, &mut effort);
        if best.is_none() {
            // Where no step along the way is possible, one along an axis may be.
            let steps = [0.5, -0.5, 0.2, -0.2].map(|step| step * far);
            let by = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| steps.map(|step| step * axis));
            let moves = free.iter().flat_map(|(vertex, _)| by.as_flattened().iter().map(|by| moved(*vertex, *by)));
            best = self.least(spot, moves.map(|one| Change::Moves(vec![one])).collect(), far, &mut effort);
        }
        self.effort = effort;
        best
    }

    /// Finds the one of some changes that leaves the smallest deviation around a spot that is `far`.
    fn least(&self, spot: Spot, changes: Vec<Change>, far: f32, effort: &mut usize) -> Option<Tried> {
        let mut best: Option<Tried> = None;
        for change in changes {
            let limit = best.as_ref().map_or(SMALLER * far, |best| best.worst);
            best = self.attempt(spot, change, limit, effort).or(best);
        }
        best
    }

    /// Returns the change that turns an edge of a triangle, if both its triangles make a quadrangle.
    fn turn(&self, triangle: u32, [a, b]: [u32; 2]) -> Option<Change> {
        let beside = &self.beside;
        if [a, b].iter().any(|end| self.is_still[*end as usize]) {
            return None;
        }
        let others = |vertex: u32| beside.star(vertex).iter().filter(|it| beside.triangles[**it as usize].contains(&a));
        let both: Vec<u32> = others(b).copied().collect();
        let [first, second] = <[u32; 2]>::try_from(both).ok()?;
        let other = if first == triangle { second } else { first };
        let rest = |triangle: u32| beside.triangles[triangle as usize].into_iter().find(|it| *it != a && *it != b);
        let (c, d) = (rest(triangle)?, rest(other)?);
        let is_edge = beside.star(c).iter().any(|it| beside.triangles[*it as usize].contains(&d));
        let goes = |triangle: u32, from: u32, to: u32| {
            let vertices = beside.triangles[triangle as usize];
            (0..3).any(|side| vertices[side] == from && vertices[(side + 1) % 3] == to)
        };
        if c == d || is_edge || !goes(triangle, a, b) || !goes(other, b, a) {
            return None;
        }
        if [a, b].iter().any(|end| beside.star(*end).len() < 4 || !beside.is_closed(*end)) {
            return None;
        }
        Some(Change::Turn([triangle, other], [[a, d, c], [d, b, c]]))
    }

    /// Tries a change for a spot. `None` if it turns a triangle over, changes the volume too much, leaves a deviation of
    /// `limit` or more around, or there is no effort left.
    fn attempt(&self, spot: Spot, change: Change, limit: f32, effort: &mut usize) -> Option<Tried> {
        let beside = &self.beside;
        let (changed, vertices): (Vec<u32>, Vec<u32>) = match &change {
            Change::Moves(moves) => {
                let vertices: Vec<u32> = moves.iter().map(|(vertex, _)| *vertex).collect();
                (beside.at(&vertices), vertices)
            }
            Change::Turn(both, [[a, d, c], [_, b, _]]) => (both.to_vec(), vec![*a, *b, *c, *d]),
        };
        if vertices.is_empty() || *effort == 0 {
            return None;
        }
        *effort = effort.saturating_sub(TRIAL);
        let place = |vertex: u32| match &change {
            Change::Moves(moves) => {
                moves.iter().find(|(it, _)| *it == vertex).map_or(beside.points[vertex as usize], |(_, to)| *to)
            }
            Change::Turn(..) => beside.points[vertex as usize],
        };
        let triangle = |at: u32| match &change {
            Change::Turn(both, turned) if both.contains(&at) => turned[usize::from(at == both[1])],
            _ => beside.triangles[at as usize],
        };
        let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
        let old = |it: u32| normal(beside.corners(it)).normalize_or_zero();
        let sum: Vec3 = changed.iter().map(|it| old(*it)).sum();
        let from = beside.points[vertices[0] as usize];
        let mut volume = 0.0;
        for it in &changed {
            let before = if let Change::Turn(..) = change { sum.normalize_or_zero() } else { old(*it) };
            let corners = triangle(*it).map(place);
            let new = normal(corners);
            let [a, b, c] = corners;
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            if new.normalize_or_zero().dot(before) < TURNED || new.length() < 0.01 * longest {
                return None;
            }
            let around = |corners: [Vec3; 3]| sixfold(corners.map(|corner| (corner - from).as_dvec3()));
            volume += around(corners) - around(beside.corners(*it));
        }
        if (self.excess + volume).abs() > self.room {
            return None;
        }
        let around = beside.grown(&vertices);
        if !around.iter().all(|it| beside.is_collected(*it)) {
            return None;
        }
        let moved = match &change {
            Change::Moves(moves) => {
                moves.iter().fold(0.0f32, |most, (it, to)| most.max(to.distance(beside.points[*it as usize])))
            }
            Change::Turn(..) => f32::INFINITY,
        };
        let mut groups = Vec::new();
        let region = beside.at(&around);
        grouped(region.iter().map(|it| triangle(*it).map(place)), &mut groups);
        let mut measured: Vec<u32> =
            around.iter().flat_map(|it| beside.members.range(*it)).map(|it| it as u32).collect();
        measured.retain(|it| beside.far[*it as usize] + moved >= limit && spot != Spot::Member(*it));
        // What fails most often is looked at first.
        let mut places = Vec::new();
        match spot {
            Spot::Member(at) => measured.insert(0, at),
            Spot::Inner(triangle) => places.push(beside.beneath_corners(triangle).into_iter().sum::<Vec3>() / 3.0),
            _ => (),
        }
        places.extend(measured.iter().map(|at| beside.place(beside.members.numbers[*at as usize])));
        let (squares, mut worst) = measure(beside, &groups, &places, limit, effort)?;
        let first = places.len() - measured.len();
        // What moved stays as near to the input.
        let mut samples: Vec<(Spot, f32)> = Vec::new();
        let mut spots: Vec<(Spot, Vec<u32>)> = vertices.iter().map(|it| (Spot::Corner(*it), vec![*it])).collect();
        for it in &changed {
            let [a, b, c] = triangle(*it);
            spots.push((Spot::Centre(*it), vec![a, b, c]));
            for [a, b] in [[a, b], [b, c], [c, a]] {
                spots.push((Spot::Middle(a.min(b), a.max(b)), vec![a, b]));
            }
        }
        spots.sort_unstable_by_key(|one| (one.0 != spot, one.0));
        spots.dedup_by(|one, other| one.0 == other.0);
        for (spot, owners) in spots {
            let place = owners.iter().map(|vertex| place(*vertex)).sum::<Vec3>() / owners.len() as f32;
            let mut distance = self.above(place, &owners, limit, effort);
            if distance >= limit {
                distance = self.above(place, &beside.grown(&owners), limit, effort);
            }
            if distance >= limit {
                return None;
            }
            worst = worst.max(distance);
            samples.push((spot, distance));
        }
        let measured = measured.into_iter().zip(squares.into_iter().skip(first)).collect();
        Some(Tried { change, worst, measured, moved, around, samples, volume })
    }

    /// Returns the distance of a place from the triangles of the input beneath some vertices, or one below half of `limit`.
    fn above(&self, place: Vec3, owners: &[u32], limit: f32, effort: &mut usize) -> f32 {
        let mut found = Vec::new();
        let mut least = f32::INFINITY;
        for groups in owners.iter().map(|owner| self.beside.beneath(*owner)) {
            gaps(self.beside.level, groups, &[place.to_array()], &mut found);
            *effort = effort.saturating_sub(groups.len());
            least = found.iter().copied().fold(least, f32::min);
            if 4.0 * least < limit * limit {
                break;
            }
        }
        least.sqrt()
    }

    /// Makes a change, and has the spots that are farther than `goal` wait.
    fn make(&mut self, tried: Tried, goal: f32, waiting: &mut BinaryHeap<(u32, Spot)>) {
        let beside = &mut self.beside;
        let mut push = |spot: Spot, far: f32| {
            if far > goal {
                waiting.push((far.to_bits(), spot));
            }
        };
        match tried.change {
            Change::Moves(moves) => moves.into_iter().for_each(|(vertex, to)| beside.points[vertex as usize] = to),
            Change::Turn(both, turned) => {
                let [[a, d, c], [_, b, _]] = turned;
                for vertex in [a, b, c, d] {
                    let mut star = beside.star(vertex).to_vec();
                    star.retain(|it| !both.contains(it));
                    star.extend(both.into_iter().zip(turned).filter(|(_, it)| it.contains(&vertex)).map(|(it, _)| it));
                    beside.turned.insert(vertex, star);
                }
                for (it, vertices) in both.into_iter().zip(turned) {
                    beside.triangles[it as usize] = vertices;
                }
            }
        }
        self.excess += tried.volume;
        if tried.moved.is_finite() {
            for at in tried.around.iter().flat_map(|vertex| beside.members.range(*vertex)) {
                beside.far[at] += tried.moved;
                push(Spot::Member(at as u32), beside.far[at]);
            }
        }
        for (at, square) in tried.measured {
            beside.far[at as usize] = square.sqrt();
            push(Spot::Member(at), square.sqrt());
        }
        tried.samples.into_iter().for_each(|(spot, far)| push(spot, far));
    }
}

/// Measures the squares of the distances of places from triangles, and the largest distance. `None` if that is `limit` or
/// more.
fn measure(
    beside: &Beside,
    groups: &[Group],
    places: &[Vec3],
    limit: f32,
    effort: &mut usize,
) -> Option<(Vec<f32>, f32)> {
    let (mut squares, mut found) = (Vec::with_capacity(places.len()), Vec::new());
    let mut most = 0.0f32;
    // The first place alone, since it decides most often.
    let (first, rest) = places.split_at(places.len().min(1));
    for part in std::iter::once(first).chain(rest.chunks(TOGETHER)) {
        let part: Vec<[f32; 3]> = part.iter().map(Vec3::to_array).collect();
        gaps(beside.level, groups, &part, &mut found);
        *effort = effort.saturating_sub(groups.len() * part.len());
        most = found.iter().copied().fold(most, f32::max);
        if most.sqrt() >= limit {
            return None;
        }
        squares.extend_from_slice(&found);
    }
    Some((squares, most.sqrt()))
}

#[cfg(test)]
mod tests {
    use glam::Vec4;
    use relievo_core::ContextOptions;
    use relievo_core::progress::Silent;

    use super::*;
    use crate::distance::distance;

    /// Squares along a side of a coarse input, and of one with more triangles.
    const SIDES: [u32; 2] = [40, 60];

    fn squares(side: u32, step: u32) -> Vec<[u32; 3]> {
        let at = |x: u32, y: u32| y * (side + 1) + x;
        let corners = (0..side).step_by(step as usize).flat_map(|y| {
            (0..side)
                .step_by(step as usize)
                .map(move |x| [at(x, y), at(x + step, y), at(x + step, y + step), at(x, y + step)])
        });
        corners.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
    }

    /// A flat square with a peak, and one with every second vertex of it, which lost the peak.
    fn peak(side: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>, Reduced) {
        let places = || (0..=side).flat_map(|y| (0..=side).map(move |x| (x, y)));
        let height = |place| if place == (20, 19) { 0.02 } else { 0.0 };
        let points: Vec<[f32; 3]> =
            places().map(|(x, y)| [x as f32 / side as f32, y as f32 / side as f32, height((x, y))]).collect();
        let reduced = Reduced {
            triangles: squares(side, 2),
            points: points.iter().map(|[x, y, z]| Vec4::new(*x, *y, *z, 0.0)).collect(),
            joined: places().map(|(x, y)| (y & !1) * (side + 1) + (x & !1)).collect(),
            is_locked: Vec::new(),
        };
        (points, squares(side, 1), reduced)
    }

    fn far(input: Triangles, reduced: &Reduced) -> f32 {
        let points: Vec<[f32; 3]> = reduced.points.iter().map(|point| point.truncate().to_array()).collect();
        distance(&Context::serial(), [input, (&points, &reduced.triangles)], &mut Silent).unwrap().at_least
    }

    #[test]
    fn a_peak_that_was_lost_is_nearer_for_as_many_triangles() {
        for side in SIDES {
            let (points, triangles, mut reduced) = peak(side);
            let input: Triangles = (&points, &triangles);
            let before = (far(input, &reduced), reduced.triangles.len());
            assert!((before.0 - 0.02).abs() < 1e-6);
            lessen(&Context::serial(), input, 1.0, &[], &mut reduced);
            assert!(far(input, &reduced) < 0.75 * before.0, "{}", far(input, &reduced));
            assert_eq!(reduced.triangles.len(), before.1);
            // The surface stays where it was on average. One of the points is the peak itself.
            let lifted: f32 = reduced.points.iter().map(|point| point.z).sum();
            assert!(lifted < 3.0 * 0.02, "{lifted}");
            let (_, _, mut other) = peak(side);
            let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
            lessen(&context, input, 1.0, &[], &mut other);
            assert_eq!((&other.triangles, &other.points), (&reduced.triangles, &reduced.points));
        }
    }

    #[test]
    fn a_vertex_far_from_a_large_input_is_nearer() {
        let side = SIDES[1];
        let (mut points, triangles, mut reduced) = peak(side);
        points.iter_mut().for_each(|point| point[2] = 0.0);
        reduced.points.iter_mut().for_each(|point| point.z = 0.0);
        let vertex = (20 * (side + 1) + 20) as usize;
        let input: Triangles = (&points, &triangles);
        let lifted = |height: f32, estimate: f32, reduced: &mut Reduced| {
            reduced.points[vertex] = Vec4::new(points[vertex][0], points[vertex][1], height, estimate);
            lessen(&Context::serial(), input, 1.0, &[], reduced);
            reduced.points[vertex].z
        };
        // A vertex on the input stays, also where its estimated deviation is large.
        assert_eq!(lifted(0.0, 0.0, &mut reduced), 0.0);
        assert_eq!(lifted(0.0, 0.02, &mut reduced), 0.0);
        assert!(lifted(0.02, 0.02, &mut reduced) < 0.75 * 0.02);
    }

    #[test]
    fn fixed_vertices_stay_and_so_does_what_is_no_outlier() {
        let (points, triangles, mut reduced) = peak(SIDES[0]);
        let before = (reduced.triangles.clone(), reduced.points.clone());
        let all: Vec<u32> = (0..points.len() as u32).collect();
        lessen(&Context::serial(), (&points, &triangles), 1.0, &all, &mut reduced);
        assert_eq!((&reduced.triangles, &reduced.points), (&before.0, &before.1));
        // Waves that were halved everywhere alike.
        let waves: Vec<[f32; 3]> = (0..)
            .zip(&points)
            .map(|(at, [x, y, _])| [*x, *y, if (at % (SIDES[0] + 1)).is_multiple_of(2) { 0.0 } else { 0.01 }])
            .collect();
        let (_, _, mut reduced) = peak(SIDES[0]);
        reduced.points = points.iter().map(|[x, y, _]| Vec4::new(*x, *y, 0.0, 0.0)).collect();
        let before = reduced.points.clone();
        lessen(&Context::serial(), (&waves, &triangles), 1.0, &[], &mut reduced);
        assert_eq!(reduced.points, before);
    }
}
