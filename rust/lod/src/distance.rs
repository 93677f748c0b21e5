//! The largest distance between the surfaces of two triangle meshes, both ways (the Hausdorff distance), with a bound
//! that the true distance never exceeds.
//!
//! The distance to one triangle is a convex function, so over a piece of the other surface it is largest at a corner of
//! the piece. A piece near one triangle is bounded by that triangle alone; any other piece is cut along the sides of the
//! triangle nearest to its middle, and its parts are looked at in turn (after Guthe, Borodin, Klein 2005). Pieces whose
//! bound is below a distance that was already found are dropped.

pub(crate) mod posed_distance;

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, Progress, Result};
use relievo_detail::hierarchy::Target;
use relievo_detail::{Bounds, Hierarchy};
use relievo_surface::triangle::closest;

use crate::connectivity::NONE;

/// The relative difference between the bounds at which a triangle is done.
const TOLERANCE: f64 = 0.01;
/// The rounding of coordinates, as a share of the largest: smaller distances are not told apart.
const ROUNDING: f64 = 1e-7;
/// Pieces of a triangle at most, and for each triangle of the other surface if that is more; the bound of the last ones is
/// then taken. A triangle over a grid, all of one plane, is cut into 2.6 pieces for each triangle of the grid.
const PIECES: [usize; 2] = [1 << 14, 8];
/// A cut that leaves less of a piece beyond it, as a share of the piece's longest edge, is not made.
const SLIVER: f64 = 1e-3;
/// Points or triangles of one task.
const CHUNK_LEN: usize = 256;
/// Barycentric coordinates of the corners of a whole triangle.
pub(crate) const WHOLE: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];
/// Bytes of the structures for a triangle.
const BYTES: u64 = 64;

/// Bounds of the largest distance between two surfaces, in the units of their points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// The distance that some point has.
    pub at_least: f32,
    /// The distance that no point exceeds, at most 1 % or 10⁻⁷ of the largest coordinate above the true one.
    pub at_most: f32,
}

/// Measures the largest distance between the surfaces of two meshes, both ways. Triangles without area do not count.
/// Results do not depend on the number of threads.
///
/// # Errors
/// Fails if a coordinate is not finite, an index is too large, only one of the meshes has area, memory does not
/// suffice, or `progress` asks to stop.
pub fn distance(
    context: &Context,
    [first, second]: [(&[[f32; 3]], &[[u32; 3]]); 2],
    progress: &mut dyn Progress,
) -> Result<Distance> {
    let [first, second] = [MeasuredMesh::new(context, first)?, MeasuredMesh::new(context, second)?];
    first.distance(context, &second, progress)
}

/// A mesh that distances are measured from and to.
pub struct MeasuredMesh<'a> {
    points: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    /// Triangles that have area, in order.
    pub(crate) solid: Vec<u32>,
    /// Boxes of these.
    hierarchy: Hierarchy,
    /// The largest coordinate.
    extent: f64,
}

/// A triangle that is near a point, by its place in [`MeasuredMesh::solid`], and its distance.
#[derive(Clone, Copy)]
pub(crate) struct Near {
    pub triangle: u32,
    pub distance: f64,
}

/// A part of a triangle, and a triangle of the other surface near it, by its place in [`MeasuredMesh::solid`].
#[derive(Clone, Copy)]
pub(crate) struct Piece {
    pub corners: [DVec3; 3],
    /// Barycentric coordinates of the corners in the triangle.
    pub weights: [DVec3; 3],
    pub near: u32,
}

/// Bounds of the largest distance of a triangle, its farthest known point, and the triangle nearest to that.
#[derive(Clone, Copy)]
pub(crate) struct Farthest {
    pub at_least: f64,
    pub at_most: f64,
    pub near: u32,
    pub place: DVec3,
}

/// A triangle that is too far from the other surface, and the other surface's triangle nearest to a point of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beyond {
    pub triangle: u32,
    pub nearest: u32,
}

impl<'a> MeasuredMesh<'a> {
    /// Prepares a mesh.
    ///
    /// # Errors
    /// Fails with `Invalid` if a coordinate is not finite or an index is too large, and with `Memory` if memory does not
    /// suffice.
    pub fn new(context: &Context, (points, triangles): (&'a [[f32; 3]], &'a [[u32; 3]])) -> Result<Self> {
        let bytes = BYTES * triangles.len() as u64;
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!("measuring distances needs {bytes} bytes, more than the memory limit"))
                .advise("raise the memory limit, or use the estimate"));
        }
        if let Some(index) = points.iter().position(|point| point.iter().any(|value| !value.is_finite())) {
            return Err(Error::invalid(format!("point {index} is not finite")).at("points"));
        }
        if let Some(index) = triangles.iter().position(|it| it.iter().any(|vertex| *vertex as usize >= points.len())) {
            return Err(Error::invalid(format!("triangle {index} has a point that is not there")).at("triangles"));
        }
        let corners = |triangle: u32| triangles[triangle as usize].map(|vertex| points[vertex as usize]);
        let solid: Vec<u32> = (0..triangles.len() as u32).filter(|it| has_area(corners(*it).map(exact))).collect();
        let bounds = |index: u32| Bounds::of_points(&corners(solid[index as usize]));
        let hierarchy = Hierarchy::build(context, solid.len(), bounds)?;
        let extent = points.iter().flatten().fold(0.0f32, |most, value| most.max(value.abs()));
        Ok(Self { points, triangles, solid, hierarchy, extent: f64::from(extent) })
    }

    /// Returns the rounding of coordinates, in their unit.
    pub fn rounding(&self) -> f64 {
        ROUNDING * self.extent
    }

    /// Returns the rounding of coordinates of which `extent` is the largest.
    pub(crate) fn rounding_of(extent: f32) -> f64 {
        ROUNDING * f64::from(extent)
    }

    /// Measures the largest distance to and from another surface, as [`distance`] does.
    ///
    /// # Errors
    /// Fails as [`distance`].
    pub fn distance(&self, context: &Context, other: &MeasuredMesh, progress: &mut dyn Progress) -> Result<Distance> {
        if self.solid.is_empty() && other.solid.is_empty() {
            return Ok(Distance::default());
        }
        self.check(other)?;
        let rounding = self.rounding().max(other.rounding());
        let own = self.vertices_near(context, other, progress, [0.0, 0.25])?;
        let back = other.vertices_near(context, self, progress, [0.25, 0.5])?;
        let known = own.iter().chain(&back).fold(0.0, |most: f64, near| most.max(near.distance));
        let floor = known * (1.0 + TOLERANCE) + rounding;
        let there = self.sweep(context, (other, &own), [floor, f64::INFINITY], progress, [0.5, 0.75])?;
        let here = other.sweep(context, (self, &back), [floor, f64::INFINITY], progress, [0.75, 1.0])?;
        let all = || there.iter().chain(&here);
        let at_least = all().fold(known, |most, found| most.max(found.at_least));
        // Corners of pieces are rounded too.
        let at_most = all().fold(known, |most, found| most.max(found.at_most)) * (1.0 + 1e-9) + 1e-6 * rounding;
        progress.step(1.0, "measure")?;
        Ok(Distance { at_least: at_least as f32, at_most: (at_most as f32).next_up() })
    }

    /// Finds the triangles of this surface that are somewhere farther than `most` from another, and also those of which
    /// that cannot be ruled out. Numbers are those of the two meshes.
    pub(crate) fn beyond(
        &self,
        context: &Context,
        other: &MeasuredMesh,
        most: f64,
        (progress, [start, end]): (&mut dyn Progress, [f32; 2]),
    ) -> Result<Vec<Beyond>> {
        if self.solid.is_empty() && other.solid.is_empty() {
            return Ok(Vec::new());
        }
        self.check(other)?;
        let middle = 0.5 * (start + end);
        let near = self.vertices_near(context, other, progress, [start, middle])?;
        let found = self.sweep(context, (other, &near), [most, most], progress, [middle, end])?;
        let is_beyond = |(_, found): &(&u32, &Farthest)| found.at_most > most;
        let beyond = |(triangle, found): (&u32, &Farthest)| Beyond {
            triangle: *triangle,
            nearest: other.solid[found.near as usize],
        };
        Ok(self.solid.iter().zip(&found).filter(is_beyond).map(beyond).collect())
    }

    /// Finds the triangle nearest to each of some points, and its distance: `u32::MAX` and infinity where no triangle has area.
    pub fn nearest_triangles(&self, context: &Context, points: &[[f32; 3]]) -> Vec<(u32, f64)> {
        if self.solid.is_empty() {
            return vec![(NONE, f64::INFINITY); points.len()];
        }
        let parts = context.map(points.len().div_ceil(CHUNK_LEN), |part| {
            let mut hint = NONE;
            let points = &points[part * CHUNK_LEN..points.len().min((part + 1) * CHUNK_LEN)];
            let nearest = points.iter().map(|point| {
                let near = self.nearest(exact(*point), hint);
                hint = near.triangle;
                (self.solid[hint as usize], near.distance)
            });
            nearest.collect::<Vec<_>>()
        });
        parts.concat()
    }

    /// Fails if only one of two surfaces has area.
    pub(crate) fn check(&self, other: &MeasuredMesh) -> Result<()> {
        if self.solid.is_empty() != other.solid.is_empty() {
            return Err(Error::invalid("one of the meshes has no triangle with area, and no distance from the other"));
        }
        Ok(())
    }

    pub(crate) fn corners(&self, index: u32) -> [DVec3; 3] {
        self.triangles[self.solid[index as usize] as usize].map(|vertex| exact(self.points[vertex as usize]))
    }

    /// Returns the distance of a point from one triangle.
    fn distance_to(&self, index: u32, point: DVec3) -> f64 {
        gap(point, self.corners(index))
    }

    /// Finds the triangle nearest to a point; `hint` is one that may be near, or [`NONE`].
    pub(crate) fn nearest(&self, point: DVec3, hint: u32) -> Near {
        let distance = if hint == NONE { f64::INFINITY } else { self.distance_to(hint, point) };
        let mut near = Near { triangle: hint, distance };
        let Some(target) = Target::new(&DAffine3::IDENTITY, point, 0.0) else { return near };
        let within = if hint == NONE { f64::MAX.sqrt() } else { distance };
        let found = self.hierarchy.approach(&target, within, |triangle| {
            let distance = self.distance_to(triangle, point);
            if distance < near.distance {
                near = Near { triangle, distance };
            }
            Ok(near.distance)
        });
        debug_assert!(found.is_ok(), "no visit fails");
        near
    }

    /// Finds for every point of this mesh the nearest triangle of another; points of no triangle have the distance 0.
    pub(crate) fn vertices_near(
        &self,
        context: &Context,
        other: &MeasuredMesh,
        progress: &mut dyn Progress,
        span: [f32; 2],
    ) -> Result<Vec<Near>> {
        let mut is_used = vec![false; self.points.len()];
        self.solid.iter().flat_map(|it| self.triangles[*it as usize]).for_each(|it| is_used[it as usize] = true);
        let parts = self.points.len().div_ceil(CHUNK_LEN);
        let found = context.map_watched(parts, progress, ("measure", span), |part| {
            let mut hint = NONE;
            let range = part * CHUNK_LEN..self.points.len().min((part + 1) * CHUNK_LEN);
            let near = range.map(|index| {
                if !is_used[index] {
                    return Near { triangle: NONE, distance: 0.0 };
                }
                let near = other.nearest(exact(self.points[index]), hint);
                hint = near.triangle;
                near
            });
            near.collect::<Vec<_>>()
        })?;
        Ok(found.concat())
    }

    /// Bounds the distance of every triangle from another surface, whose triangles near the vertices are given. Bounds
    /// below `floor` are not improved, and a triangle found to be farther than `stop` is not looked at any longer.
    fn sweep(
        &self,
        context: &Context,
        (other, near): (&MeasuredMesh, &[Near]),
        limits: [f64; 2],
        progress: &mut dyn Progress,
        span: [f32; 2],
    ) -> Result<Vec<Farthest>> {
        let parts = self.solid.len().div_ceil(CHUNK_LEN);
        let found = context.map_watched(parts, progress, ("measure", span), |part| {
            let mut waiting = Vec::new();
            let range = part * CHUNK_LEN..self.solid.len().min((part + 1) * CHUNK_LEN);
            let found = range.map(|index| {
                let corners = self.corners(index as u32);
                let near = self.triangles[self.solid[index] as usize].map(|vertex| near[vertex as usize]);
                other.farthest(corners, near, limits, &mut waiting, |_| ())
            });
            found.collect::<Vec<_>>()
        })?;
        Ok(found.concat())
    }

    /// Bounds the distance of a triangle, whose corners have triangles of this surface near them, as [`Self::sweep`].
    /// `finished` gets the pieces that the triangle was cut into, each with the triangle that bounds it.
    pub(crate) fn farthest(
        &self,
        corners: [DVec3; 3],
        near: [Near; 3],
        [floor, stop]: [f64; 2],
        waiting: &mut Vec<Piece>,
        finished: impl FnMut(Piece),
    ) -> Farthest {
        let most =
            [1, 2].into_iter().fold(0, |most, at| if near[at].distance > near[most].distance { at } else { most });
        let Near { triangle, distance } = near[most];
        let found = Farthest { at_least: distance, at_most: distance, near: triangle, place: corners[most] };
        if found.at_least > stop {
            return Farthest { at_most: f64::INFINITY, ..found };
        }
        let bounds = near.map(|near| self.bound(near.triangle, corners));
        let best = if bounds[0] <= bounds[1].min(bounds[2]) { 0 } else { 1 + usize::from(bounds[2] < bounds[1]) };
        waiting.clear();
        waiting.push(Piece { corners, weights: WHOLE, near: near[best].triangle });
        self.refine(found, [floor, stop], waiting, finished)
    }

    /// Bounds the distance of the pieces that wait, beside what was found already, as [`Self::farthest`].
    pub(crate) fn refine(
        &self,
        mut found: Farthest,
        [floor, stop]: [f64; 2],
        waiting: &mut Vec<Piece>,
        mut finished: impl FnMut(Piece),
    ) -> Farthest {
        let most_pieces = PIECES[0].max(PIECES[1].saturating_mul(self.solid.len()));
        let mut pieces = 0;
        while let Some(piece) = waiting.pop() {
            let Piece { corners, near, .. } = piece;
            let known = self.bound(near, corners);
            if known <= floor.max(found.at_least * (1.0 + TOLERANCE)) {
                found.at_most = found.at_most.max(known);
                finished(piece);
                continue;
            }
            let middle = corners.into_iter().sum::<DVec3>() / 3.0;
            let there = self.nearest(middle, near);
            if there.distance > found.at_least {
                (found.at_least, found.near, found.place) = (there.distance, there.triangle, middle);
                if there.distance > stop {
                    return Farthest { at_most: f64::INFINITY, ..found };
                }
            }
            let radius = corners.into_iter().fold(0.0, |most: f64, corner| most.max(corner.distance(middle)));
            let bound = known.min(self.bound(there.triangle, corners)).min(there.distance + radius);
            pieces += 1;
            if bound <= floor.max(found.at_least * (1.0 + TOLERANCE)) || pieces > most_pieces {
                found.at_most = found.at_most.max(bound);
                finished(Piece { near: there.triangle, ..piece });
            } else {
                self.cut(piece, there.triangle, waiting);
            }
        }
        found.at_most = found.at_most.max(found.at_least);
        found
    }

    /// Returns what the distance of a piece from this surface is at most: that of its corners from one triangle.
    fn bound(&self, near: u32, corners: [DVec3; 3]) -> f64 {
        corners.into_iter().fold(0.0, |most, corner| most.max(self.distance_to(near, corner)))
    }

    /// Cuts a piece along the side of a triangle that parts it most evenly, or halves its longest edge if none does.
    fn cut(&self, Piece { corners, weights, .. }: Piece, near: u32, waiting: &mut Vec<Piece>) {
        let [a, b, c] = self.corners(near);
        let normal = (b - a).cross(c - a);
        let edges = [0, 1, 2].map(|side| corners[side].distance(corners[(side + 1) % 3]));
        let longest = if edges[0] >= edges[1].max(edges[2]) { 0 } else { 1 + usize::from(edges[2] > edges[1]) };
        let (mut most, mut heights) = (SLIVER * edges[longest], None);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let Some(inward) = normal.cross(to - from).try_normalize() else { continue };
            let signed = corners.map(|corner| inward.dot(corner - from));
            let [x, y, z] = signed;
            let evenness = x.max(y).max(z).min(-x.min(y).min(z));
            if evenness > most {
                (most, heights) = (evenness, Some(signed));
            }
        }
        let corner = |at: usize| (corners[at], weights[at]);
        let between = |from: usize, to: usize, share: f64| {
            (
                corners[from] + share * (corners[to] - corners[from]),
                weights[from] + share * (weights[to] - weights[from]),
            )
        };
        let mut add = |places: [(DVec3, DVec3); 3]| {
            let corners = places.map(|place| place.0);
            if has_area(corners) {
                waiting.push(Piece { corners, weights: places.map(|place| place.1), near });
            }
        };
        let Some(heights) = heights else {
            let [start, end, opposite] = [0, 1, 2].map(|step| (longest + step) % 3);
            let middle = between(start, end, 0.5);
            add([corner(start), middle, corner(opposite)]);
            return add([middle, corner(end), corner(opposite)]);
        };
        // The corner that is alone on its side.
        let above = heights.map(|height| height > 0.0);
        let alone = (0..3).find(|at| above[(at + 1) % 3] == above[(at + 2) % 3]).unwrap_or(0);
        let [tip, left, right] = [0, 1, 2].map(|step| (alone + step) % 3);
        let cross = |end: usize| between(tip, end, (heights[tip] / (heights[tip] - heights[end])).clamp(0.0, 1.0));
        let [from, to] = [cross(left), cross(right)];
        add([corner(tip), from, to]);
        add([from, corner(left), corner(right)]);
        add([from, corner(right), to]);
    }
}

/// Returns the distance of a point from a triangle.
pub(crate) fn gap(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let [s, t, u] = closest(point, [a, b, c]);
    (a * s + b * t + c * u).distance(point)
}

pub(crate) fn exact(point: [f32; 3]) -> DVec3 {
    DVec3::from(point.map(f64::from))
}

fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).cross(c - a) != DVec3::ZERO
}

#[cfg(test)]
mod tests {
    use relievo_core::ContextOptions;
    use relievo_core::progress::Silent;
    use relievo_testing::Random;

    use super::*;

    type Triangles = (Vec<[f32; 3]>, Vec<[u32; 3]>);

    /// A grid of n × n squares over a square of a side, lifted by a function.
    fn lifted(n: u32, side: f32, height: impl Fn(f32, f32) -> f32) -> Triangles {
        let at = |step: u32| side * step as f32 / n as f32;
        let points = (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y)]));
        let points = points.map(|[x, y]| [x, y, height(x, y)]).collect();
        let squares = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
        (points, squares.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect())
    }

    fn measured(context: &Context, first: &Triangles, second: &Triangles) -> Distance {
        distance(context, [first, second].map(|(points, triangles)| (&points[..], &triangles[..])), &mut Silent)
            .unwrap()
    }

    fn near(found: Distance, expected: f32) {
        let Distance { at_least, at_most } = found;
        assert!(at_least <= expected * 1.000_001 + 1e-9 && at_most >= expected, "{found:?}, not {expected}");
        assert!(at_most <= expected * 1.0101 + 1e-6, "{found:?}, not {expected}");
    }

    #[test]
    fn distances_between_planes_are_exact_whatever_their_triangles() {
        let context = Context::serial();
        let plane = |n, side, height| lifted(n, side, |_, _| height);
        near(measured(&context, &plane(1, 1.0, 0.0), &plane(37, 1.0, 0.0)), 0.0);
        near(measured(&context, &plane(5, 1.0, 0.0), &plane(7, 1.0, 0.125)), 0.125);
        // The corner of the larger square is as far as two sides: one way only there is something far.
        near(measured(&context, &plane(3, 2.0, 0.0), &plane(2, 1.0, 0.0)), 2.0f32.sqrt());
        near(measured(&context, &plane(2, 1.0, 0.0), &plane(3, 2.0, 0.0)), 2.0f32.sqrt());
    }

    #[test]
    fn the_middle_of_a_hole_is_the_farthest() {
        let whole = lifted(1, 3.0, |_, _| 0.0);
        let mut holed = lifted(3, 3.0, |_, _| 0.0);
        holed.1.drain(8..10);
        near(measured(&Context::serial(), &whole, &holed), 0.5);
    }

    #[test]
    fn no_sample_is_farther_than_the_bound() {
        let context = Context::serial();
        let mut random = Random(7);
        let waves = |n: u32, steep: f32| lifted(n, 1.0, move |x, y| steep * (9.0 * x).sin() * (7.0 * y).cos());
        for (first, second) in [(waves(40, 0.1), waves(7, 0.1)), (waves(23, 0.05), waves(31, 0.06))] {
            let found = measured(&context, &first, &second);
            let mut farthest = 0.0f64;
            for (from, to) in [(&first, &second), (&second, &first)] {
                let to = MeasuredMesh::new(&context, (&to.0, &to.1)).unwrap();
                for sample in 0..20_000 {
                    let triangle = from.1[(random.unit() * from.1.len() as f32) as usize % from.1.len()];
                    let [a, b, c] = triangle.map(|vertex| exact(from.0[vertex as usize]));
                    let (root, across) = (f64::from(random.unit().sqrt()), f64::from(random.unit()));
                    let point = a * (1.0 - root) + b * root * (1.0 - across) + c * root * across;
                    let near = to.nearest(point, NONE).distance;
                    if sample < 100 {
                        let all = (0..to.solid.len() as u32).map(|it| to.distance_to(it, point));
                        assert_eq!(near, all.fold(f64::MAX, f64::min));
                    }
                    farthest = farthest.max(near);
                }
            }
            assert!(farthest <= f64::from(found.at_most) && farthest >= 0.9 * f64::from(found.at_least), "{found:?}");
            assert!(found.at_most <= 1.0102 * found.at_least, "{found:?}");
        }
    }

    #[test]
    fn triangles_beyond_a_distance_are_those_that_reach_it() {
        let context = Context::serial();
        let flat = lifted(8, 1.0, |_, _| 0.0);
        let peak = lifted(8, 1.0, |x, y| if x == 0.5 && y == 0.5 { 0.25 } else { 0.0 });
        let [flat, peak] = [&flat, &peak].map(|mesh| MeasuredMesh::new(&context, (&mesh.0, &mesh.1)).unwrap());
        let found = peak.beyond(&context, &flat, 0.2, (&mut Silent, [0.0, 1.0])).unwrap();
        assert_eq!(found.len(), 6, "the triangles around the peak");
        assert!(peak.beyond(&context, &flat, 0.25, (&mut Silent, [0.0, 1.0])).unwrap().is_empty());
    }

    #[test]
    fn results_do_not_depend_on_threads_and_bad_meshes_are_refused() {
        let [first, second] = [60, 13].map(|n| lifted(n, 1.0, |x, y| 0.2 * (5.0 * x * y).sin()));
        let expected = measured(&Context::serial(), &first, &second);
        let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
        assert_eq!(measured(&context, &first, &second), expected);
        assert_eq!(measured(&context, &second, &first), expected);
        let fails = |first: &Triangles, second: &Triangles| {
            let both = [first, second].map(|(points, triangles)| (&points[..], &triangles[..]));
            distance(&context, both, &mut Silent).unwrap_err().to_string()
        };
        let none = (first.0.clone(), vec![[0, 0, 1]]);
        assert!(fails(&first, &none).contains("no triangle with area"));
        assert!(fails(&(vec![[f32::NAN; 3]], vec![]), &first).contains("point 0"));
        assert!(fails(&(vec![[0.0; 3]], vec![[0, 0, 1]]), &first).contains("triangle 0"));
        assert_eq!(measured(&context, &none, &none), Distance::default());
    }
}
