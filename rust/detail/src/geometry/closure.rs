//! The closure of a collider's mesh: what makes triangles with open edges the boundary of a solid.
//!
//! Points that coincide when the mesh is made are one point for voxels, and stay one while they move together, so that a
//! mesh split along seams of texture coordinates or normals is closed in every pose. The edges that are still open bound
//! holes, which are covered: every open edge is joined to the middle of its hole. Directed open edges form closed loops
//! in any mesh, so that with these cones every edge is met as often in one direction as in the other, and the winding
//! number that decides what is solid is defined everywhere. Covers lie between the points of the mesh: nothing outside of
//! its box becomes solid.
//!
//! A sheet, whose faces mostly point one way, has no inside to cover. It is solid behind its front.
//!
//! Rims that are near each other are joined to one middle. The cracks and T-junctions between the pieces of a mesh then
//! close onto each other, where a middle for each piece would leave the inside of the mesh empty.

use std::sync::Arc;

use glam::DVec3;

/// The distance up to which points coincide, in shares of the largest coordinate: a few roundings of skinned points.
const WELD: f64 = 4e-6;

/// The distance up to which rims are joined to one middle, in shares of the longest edge of the mesh's box.
const CRACK: f64 = 1e-3;

/// The share of its area by which the faces of a sheet point one way at least.
const SHEET: f64 = 0.5;

/// Places of points that coincided among which a point that moved is looked for.
const PLACES: usize = 8;

/// The closure of a mesh. The middles of holes follow the points of the mesh, and covers follow its triangles.
#[derive(Clone, Debug)]
pub(crate) struct Closure {
    /// Number of points and triangles of the mesh.
    given: [usize; 2],
    /// Points that coincided with one of another number when the mesh was made, and that one; ascending by the latter.
    coincident: Vec<[u32; 2]>,
    /// The point that each of them coincides with now, itself if there is none.
    joined: Vec<u32>,
    open_edges: usize,
    is_sheet: bool,
    /// The points on the rims of holes, and where the list ends for each hole.
    rims: Vec<u32>,
    ends: Vec<usize>,
}

impl Closure {
    /// Analyses a mesh, of which every index must exist, and appends the middles of its holes and their covers.
    ///
    /// Points that coincide within rounding are moved onto each other.
    pub fn new(points: &mut Vec<[f32; 3]>, triangles: &mut Vec<[u32; 3]>) -> Self {
        let given = [points.len(), triangles.len()];
        let mut same = equal_points(points);
        let mut open = open_edges(triangles, &same);
        if !open.is_empty() {
            weld(points, &open, &mut same);
            open = open_edges(triangles, &same);
        }
        let moved = (0..).zip(&same).filter(|(point, same)| point != *same);
        let mut coincident: Vec<[u32; 2]> = moved.map(|(point, same)| [point, *same]).collect();
        coincident.sort_unstable_by_key(|[point, same]| (*same, *point));
        let joined = coincident.iter().map(|[_, same]| *same).collect();
        let (facing, area) = facing(points, triangles);
        let is_sheet = !open.is_empty() && facing.length() > SHEET * area;
        let mut closure =
            Self { given, coincident, joined, open_edges: 0, is_sheet, rims: Vec::new(), ends: Vec::new() };
        closure.join(points);
        closure.cover(&open, points, triangles);
        closure
    }

    /// Returns the number of points and triangles of the mesh itself.
    pub fn given(&self) -> [usize; 2] {
        self.given
    }

    /// Returns the number of edges that no edge in the opposite direction meets.
    pub fn open_edges(&self) -> usize {
        self.open_edges
    }

    /// Returns whether the mesh is solid behind its front rather than inside: open, with faces that mostly point one way.
    pub fn is_sheet(&self) -> bool {
        self.is_sheet
    }

    /// Returns the direction in which the front of a sheet looks on average, of any length; zero for other meshes.
    pub fn facing(&self, points: &[[f32; 3]], triangles: &[[u32; 3]]) -> DVec3 {
        if self.is_sheet { facing(points, triangles).0 } else { DVec3::ZERO }
    }

    /// Follows the mesh's points, which have moved: points that coincide within rounding are moved onto each other, and
    /// middles go along.
    ///
    /// Returns true if points that coincided have come apart, or together again, and middles and covers are others.
    pub fn follow(&mut self, points: &mut Vec<[f32; 3]>, triangles: &mut Arc<[[u32; 3]]>) -> bool {
        let [count, faces] = self.given;
        let joined = self.joined_in(&points[..count]);
        let is_other = joined != self.joined;
        self.joined = joined;
        self.join(points);
        if is_other {
            let mut same: Vec<u32> = (0..count as u32).collect();
            self.coincident.iter().zip(&self.joined).for_each(|([point, _], other)| same[*point as usize] = *other);
            let mut all = triangles[..faces].to_vec();
            points.truncate(count);
            let open = open_edges(&all, &same);
            self.cover(&open, points, &mut all);
            *triangles = all.into();
        } else {
            let middles = self.middles(points);
            points[count..].copy_from_slice(&middles);
        }
        is_other
    }

    /// Returns the point that each of the coincident ones coincides with where they are now.
    fn joined_in(&self, points: &[[f32; 3]]) -> Vec<u32> {
        let tolerance = WELD * largest(points);
        let is_near = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|point| points[point as usize]);
            (0..3).all(|axis| (f64::from(a[axis]) - f64::from(b[axis])).abs() <= tolerance)
        };
        let mut joined = Vec::with_capacity(self.coincident.len());
        let mut places = Vec::with_capacity(PLACES);
        for group in self.coincident.chunk_by(|a, b| a[1] == b[1]) {
            places.clear();
            places.push(group[0][1]);
            for [point, _] in group {
                let place = places.iter().copied().find(|place| is_near(*place, *point));
                if place.is_none() && places.len() < PLACES {
                    places.push(*point);
                }
                joined.push(place.unwrap_or(*point));
            }
        }
        joined
    }

    /// Moves each point to the place of the first point that it coincides with.
    fn join(&self, points: &mut [[f32; 3]]) {
        for ([point, _], other) in self.coincident.iter().zip(&self.joined) {
            points[*point as usize] = points[*other as usize];
        }
    }

    /// Covers the holes that `open` edges bound, unless the mesh is a sheet.
    fn cover(&mut self, open: &[[u32; 2]], points: &mut Vec<[f32; 3]>, triangles: &mut Vec<[u32; 3]>) {
        self.open_edges = open.len();
        self.rims.clear();
        self.ends.clear();
        if self.is_sheet || open.is_empty() {
            return;
        }
        let rim = ends_of(open);
        let at = |point: u32| rim.binary_search(&point).unwrap_or_default();
        let mut sets = Sets::new(rim.len());
        open.iter().for_each(|[a, b]| sets.join(at(*a), at(*b)));
        sets.join_near(points, &rim, CRACK * longest_edge(points));
        let roots: Vec<usize> = (0..rim.len()).map(|index| sets.root(index)).collect();
        let mut order: Vec<usize> = (0..rim.len()).collect();
        order.sort_unstable_by_key(|index| (roots[*index], *index));
        let mut middle_of = vec![0; rim.len()];
        for hole in order.chunk_by(|a, b| roots[*a] == roots[*b]) {
            hole.iter().for_each(|index| middle_of[*index] = (self.given[0] + self.ends.len()) as u32);
            self.rims.extend(hole.iter().map(|index| rim[*index]));
            self.ends.push(self.rims.len());
        }
        triangles.extend(open.iter().map(|[a, b]| [*b, *a, middle_of[at(*a)]]));
        let middles = self.middles(points);
        points.extend(middles);
    }

    /// Returns the middle of every hole.
    fn middles(&self, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut first = 0;
        let middle = |end: &usize| {
            let rim = &self.rims[std::mem::replace(&mut first, *end)..*end];
            let sum: DVec3 = rim.iter().map(|point| DVec3::from(points[*point as usize].map(f64::from))).sum();
            (sum / rim.len() as f64).to_array().map(|value| value as f32)
        };
        self.ends.iter().map(middle).collect()
    }
}

/// Returns, for every point, the lowest one at exactly the same place.
fn equal_points(points: &[[f32; 3]]) -> Vec<u32> {
    let key = |point: u32| points[point as usize].map(|value| (value + 0.0).to_bits());
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by_key(|point| (key(*point), *point));
    let mut same = vec![0; points.len()];
    for group in order.chunk_by(|a, b| key(*a) == key(*b)) {
        group.iter().for_each(|point| same[*point as usize] = group[0]);
    }
    same
}

/// Makes points on open edges that are within rounding of each other the same.
fn weld(points: &[[f32; 3]], open: &[[u32; 2]], same: &mut [u32]) {
    let rim = ends_of(open);
    let mut sets = Sets::new(rim.len());
    sets.join_near(points, &rim, WELD * largest(points));
    for point in same {
        if let Ok(index) = rim.binary_search(point) {
            *point = rim[sets.root(index)];
        }
    }
}

/// Returns the edges that are not met by as many in the opposite direction, in the direction of the triangles and as often
/// as they are open.
fn open_edges(triangles: &[[u32; 3]], same: &[u32]) -> Vec<[u32; 2]> {
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * triangles.len());
    for corners in triangles {
        for k in 0..3 {
            let (a, b) = (same[corners[k] as usize], same[corners[(k + 1) % 3] as usize]);
            if a != b {
                edges.push((a.min(b), a.max(b), a < b));
            }
        }
    }
    edges.sort_unstable();
    let mut open = Vec::new();
    for uses in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let up = uses.iter().filter(|edge| edge.2).count();
        let down = uses.len() - up;
        let edge = if up > down { [uses[0].0, uses[0].1] } else { [uses[0].1, uses[0].0] };
        open.extend(std::iter::repeat_n(edge, up.abs_diff(down)));
    }
    open
}

/// Returns the points of edges, ascending.
fn ends_of(edges: &[[u32; 2]]) -> Vec<u32> {
    let mut points = edges.as_flattened().to_vec();
    points.sort_unstable();
    points.dedup();
    points
}

/// Returns twice the sum of the triangles' areas as vectors along their normals, and of the areas alone.
fn facing(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> (DVec3, f64) {
    triangles.iter().fold((DVec3::ZERO, 0.0), |(sum, area), corners| {
        let [a, b, c] = corners.map(|point| DVec3::from(points[point as usize].map(f64::from)));
        let normal = (b - a).cross(c - a);
        (sum + normal, area + normal.length())
    })
}

/// Returns the largest coordinate.
fn largest(points: &[[f32; 3]]) -> f64 {
    f64::from(points.as_flattened().iter().fold(0.0, |most: f32, value| most.max(value.abs())))
}

/// Returns the longest edge of the box around the points along the coordinate axes.
fn longest_edge(points: &[[f32; 3]]) -> f64 {
    let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
        let point = DVec3::from(point.map(f64::from));
        (low.min(point), high.max(point))
    });
    (high - low).max_element().max(0.0)
}

/// Disjoint sets of numbers, each with its lowest number as the root.
struct Sets {
    parents: Vec<usize>,
}

impl Sets {
    /// Makes a set of each number below `count`.
    fn new(count: usize) -> Self {
        Self { parents: (0..count).collect() }
    }

    fn root(&mut self, mut index: usize) -> usize {
        while self.parents[index] != index {
            self.parents[index] = self.parents[self.parents[index]];
            index = self.parents[index];
        }
        index
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b);
    }

    /// Joins the numbers in `list` of points that are within `distance` of each other along every axis, and some that are
    /// within twice that.
    fn join_near(&mut self, points: &[[f32; 3]], list: &[u32], distance: f64) {
        if distance <= 0.0 {
            return;
        }
        let mut cells: Vec<([i64; 3], usize)> = Vec::with_capacity(list.len());
        // Two points that near share a cell in at least one of eight lattices, shifted by half a cell.
        for shift in 0..8 {
            let cell = |point: &u32| {
                let place = |axis: usize| {
                    let half = f64::from(points[*point as usize][axis]) / distance;
                    (0.5 * (half + f64::from(shift >> axis & 1))).floor() as i64
                };
                [0, 1, 2].map(place)
            };
            cells.clear();
            cells.extend(list.iter().enumerate().map(|(index, point)| (cell(point), index)));
            cells.sort_unstable();
            for group in cells.chunk_by(|a, b| a.0 == b.0) {
                group.iter().for_each(|(_, index)| self.join(group[0].1, *index));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::shapes::{self, Soup};

    fn closed((mut points, mut triangles): Soup) -> (Soup, Closure) {
        let closure = Closure::new(&mut points, &mut triangles);
        ((points, triangles), closure)
    }

    /// Every triangle with points of its own, each shaken by its number.
    fn split((points, triangles): &Soup, shake: f32) -> Soup {
        let corners = triangles.iter().flatten().enumerate();
        let points = corners.map(|(k, point)| points[*point as usize].map(|value| value + shake * (k % 3) as f32));
        (points.collect(), (0..triangles.len() as u32).map(|index| [0, 1, 2].map(|k| 3 * index + k)).collect())
    }

    fn volume((points, triangles): &Soup) -> f64 {
        let sixfold = triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|point| DVec3::from(points[point as usize].map(f64::from)));
            a.dot(b.cross(c))
        });
        sixfold.sum::<f64>() / 6.0
    }

    fn is_closed((points, triangles): &Soup) -> bool {
        open_edges(triangles, &equal_points(points)).is_empty()
    }

    #[test]
    fn split_points_are_one_also_after_rounding() {
        let ball = shapes::sphere(1.0, 30, 20, 0.1);
        for shake in [0.0, 1e-6] {
            let (all, closure) = closed(split(&ball, shake));
            assert_eq!((closure.open_edges(), all.1.len()), (0, ball.1.len()));
            assert!(is_closed(&all));
        }
        let (_, apart) = closed(split(&ball, 1e-4));
        assert_eq!(apart.open_edges(), 3 * ball.1.len());
    }

    #[test]
    fn holes_are_covered_and_the_volume_is_that_of_the_whole() {
        // A box without one side, without two that meet, and with one side turned over.
        let whole = shapes::cube(0.5);
        for gone in [0..2, 2..4, 2..6] {
            let (points, mut triangles) = whole.clone();
            triangles.drain(gone.clone());
            let (all, closure) = closed((points, triangles));
            assert!(is_closed(&all) && !closure.is_sheet() && closure.open_edges() >= 4, "{gone:?}");
            if gone.len() == 2 {
                assert!((volume(&all) - 1.0).abs() < 1e-6 && closure.open_edges() == 4, "{}", volume(&all));
            }
            let most = all.0.iter().flatten().fold(0.0, |most: f32, value| most.max(value.abs()));
            assert!(most <= 0.5);
        }
        let (points, mut triangles) = whole;
        triangles[..2].iter_mut().for_each(|triangle| triangle.swap(1, 2));
        let (all, closure) = closed((points, triangles));
        assert!(is_closed(&all) && closure.open_edges() == 8 && (volume(&all) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn pieces_with_cracks_between_them_close_onto_each_other() {
        // Each side with points of its own, a hair apart, one of them cut finer so that a point lies on an edge.
        let (points, triangles) = shapes::cube(0.5);
        let (mut all, mut faces) = (Vec::new(), Vec::new());
        for (side, pair) in triangles.chunks(2).enumerate() {
            for triangle in pair {
                let first = all.len() as u32;
                all.extend(triangle.map(|point| points[point as usize].map(|value| value + 2e-5 * side as f32)));
                if side == 3 {
                    let middle: [f32; 3] =
                        std::array::from_fn(|k| 0.5 * (all[first as usize][k] + all[first as usize + 1][k]));
                    all.push(middle);
                    faces.extend([[first, first + 3, first + 2], [first + 3, first + 1, first + 2]]);
                } else {
                    faces.push([first, first + 1, first + 2]);
                }
            }
        }
        let (all, closure) = closed((all, faces));
        assert!(is_closed(&all) && closure.open_edges() > 20 && closure.ends.len() == 1);
        assert!((volume(&all) - 1.0).abs() < 1e-3, "{}", volume(&all));
    }

    #[test]
    fn sheets_are_left_open() {
        let points = (0..9).map(|i| [(i % 3) as f32, (i / 3) as f32, 0.1 * (i % 2) as f32]).collect();
        let quads = [0u32, 1, 3, 4].map(|a| [[a, a + 1, a + 4], [a, a + 4, a + 3]]);
        let (all, closure) = closed((points, quads.concat()));
        assert!(closure.is_sheet() && closure.open_edges() == 8 && all.1.len() == 8);
    }

    #[test]
    fn points_that_come_apart_open_the_mesh_and_close_it_again() {
        let (points, triangles) = shapes::joined(
            shapes::moved(shapes::cube(0.5), [-0.5, 0.0, 0.0]),
            shapes::inverted(shapes::moved(shapes::cube(0.5), [0.5, 0.0, 0.0])),
        );
        let rest = split(&(points, triangles), 0.0);
        let (mut all, mut closure) = closed(rest.clone());
        assert_eq!((closure.open_edges(), all.1.len()), (0, 24));
        let mut triangles: Arc<[[u32; 3]]> = all.1.clone().into();
        // The roundings of skinned points leave it closed.
        all.0.iter_mut().enumerate().for_each(|(k, point)| point[1] += 1e-7 * (k % 5) as f32);
        assert!(!closure.follow(&mut all.0, &mut triangles));
        assert!(is_closed(&(all.0.clone(), triangles.to_vec())));
        // One triangle goes away by itself.
        all.0[..72].copy_from_slice(&rest.0);
        all.0[..3].iter_mut().for_each(|point| point[2] += 3.0);
        assert!(closure.follow(&mut all.0, &mut triangles));
        assert_eq!((closure.open_edges(), all.0.len() - 72), (6, triangles.len() / 15));
        assert!(is_closed(&(all.0.clone(), triangles.to_vec())));
        all.0[..72].copy_from_slice(&rest.0);
        assert!(closure.follow(&mut all.0, &mut triangles));
        assert_eq!((closure.open_edges(), all.0.len(), triangles.len()), (0, 72, 24));
    }
}
