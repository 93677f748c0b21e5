//! Vertices that several fans of triangles share, as where the points of one side of a seam are among those of the other, or
//! where sheets meet along an edge. Each fan gets a vertex of its own, so that the edges of one are no obstacle to the
//! collapses of the other, and gives it back at the end. The vertices stay where they are.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// A mesh whose fans have vertices of their own.
pub struct OpenFans<'a> {
    pub points: Cow<'a, [[f32; 3]]>,
    pub triangles: Cow<'a, [[u32; 3]]>,
    /// How many points there were.
    before: usize,
    /// The vertex that every added one was.
    origins: Vec<u32>,
    /// Vertices that were shared, the added ones too.
    pub shared: Vec<u32>,
}

/// Triangles of an edge at most.
const MAX: usize = 2;

impl<'a> OpenFans<'a> {
    /// Parts the fans of a mesh whose indices are in range, also along edges of more than two triangles, or of two in the
    /// same direction. Vertices where as many triangles go one way round as the other are looked at if they are in `more`,
    /// in ascending order.
    pub fn part(points: &'a [[f32; 3]], triangles: &'a [[u32; 3]], more: &[u32]) -> Self {
        let mut made = Self {
            points: Cow::Borrowed(points),
            triangles: Cow::Borrowed(triangles),
            before: points.len(),
            origins: Vec::new(),
            shared: Vec::new(),
        };
        let mut corners = open_corners(points.len(), triangles, more);
        corners.sort_unstable();
        for corners in corners.chunk_by(|[one, _], [other, _]| one == other) {
            let vertex = corners[0][0];
            let fans = fans(vertex, corners, triangles);
            if fans.len() < 2 {
                continue;
            }
            made.shared.push(vertex);
            for fan in &fans[1..] {
                let added = made.points.len() as u32;
                made.points.to_mut().push(points[vertex as usize]);
                made.origins.push(vertex);
                made.shared.push(added);
                for triangle in fan {
                    let triangle = &mut made.triangles.to_mut()[*triangle as usize];
                    triangle.iter_mut().filter(|it| **it == vertex).for_each(|it| *it = added);
                }
            }
        }
        made
    }

    /// Returns the vertex that one was.
    pub fn origin(&self, vertex: u32) -> u32 {
        (vertex as usize).checked_sub(self.before).map_or(vertex, |added| self.origins[added])
    }

    /// Returns the factors of all points, added ones included. Empty if `factors` is.
    pub fn factors(&self, factors: &[f32]) -> Vec<f32> {
        if factors.is_empty() {
            return Vec::new();
        }
        let added = self.origins.iter().map(|origin| factors[*origin as usize]);
        factors.iter().copied().chain(added).collect()
    }

    /// Gives the vertices of triangles that are left back to what they were, but for those of edges that would then have
    /// more triangles than two, unless there were such edges at both. `joined` is the vertex that each was collapsed into,
    /// or itself.
    pub fn join(&self, triangles: &mut [[u32; 3]], joined: &[u32]) {
        if self.origins.is_empty() {
            return;
        }
        // A vertex that stays may go on under the name of one that was collapsed onto it.
        let name = |mut vertex: u32| {
            while joined[vertex as usize] != vertex {
                vertex = joined[vertex as usize];
            }
            vertex
        };
        let origins: HashMap<u32, u32> = self.shared.iter().map(|vertex| (*vertex, self.origin(*vertex))).collect();
        let now: HashMap<u32, u32> = origins.iter().map(|(vertex, origin)| (name(*vertex), *origin)).collect();
        let was_more: HashSet<u32> = crowded(&self.triangles, &origins).flatten().collect();
        let is_new = |edge: &[u32; 2]| !edge.iter().all(|end| was_more.contains(end));
        let apart: HashSet<u32> = crowded(triangles, &now).filter(is_new).flatten().collect();
        for vertex in triangles.as_flattened_mut() {
            if let Some(origin) = now.get(vertex).filter(|origin| !apart.contains(*origin)) {
                *vertex = name(*origin);
            }
        }
    }
}

/// Returns the edges that would have more triangles than two if vertices were what `origins` has.
fn crowded(triangles: &[[u32; 3]], origins: &HashMap<u32, u32>) -> impl Iterator<Item = [u32; 2]> {
    let mut counts = HashMap::new();
    for [from, to] in triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]) {
        if let (Some(from), Some(to)) = (origins.get(from), origins.get(to)) {
            *counts.entry([*from.min(to), *from.max(to)]).or_insert(0) += 1;
        }
    }
    counts.into_iter().filter(|(_, count)| *count > MAX).map(|(edge, _)| edge)
}

/// Returns the vertices whose triangles are no closed fans, and those in `more`, with each of their triangles.
fn open_corners(vertices: usize, triangles: &[[u32; 3]], more: &[u32]) -> Vec<[u32; 2]> {
    // Around a closed fan every other vertex comes once after it and once before it, so that this sum vanishes.
    let number = |vertex: u32| vertex.wrapping_add(1).wrapping_mul(0x9e37_79b1);
    let mut sums = vec![0u32; vertices];
    for [a, b, c] in triangles {
        for [vertex, after, before] in [[a, b, c], [b, c, a], [c, a, b]] {
            let sum = &mut sums[*vertex as usize];
            *sum = sum.wrapping_add(number(*after)).wrapping_sub(number(*before));
        }
    }
    // No sum that is looked at is 0.
    more.iter().for_each(|vertex| sums[*vertex as usize] |= 1);
    if sums.iter().all(|sum| *sum == 0) {
        return Vec::new();
    }
    let corners = (0..).zip(triangles).flat_map(|(number, triangle)| triangle.map(|vertex| [vertex, number]));
    corners.filter(|[vertex, _]| sums[*vertex as usize] != 0).collect()
}

/// Returns the fans of triangles at a vertex: triangles that are connected over edges of two triangles. None if a
/// triangle has the vertex twice.
fn fans(vertex: u32, corners: &[[u32; 2]], triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    // What comes after the vertex and before it, in each triangle.
    let (mut after, mut before) = (Vec::with_capacity(corners.len()), Vec::with_capacity(corners.len()));
    for (corner, [_, triangle]) in corners.iter().enumerate() {
        let at = triangles[*triangle as usize];
        if at.iter().filter(|it| **it == vertex).count() != 1 {
            return Vec::new();
        }
        let place = (0..3).find(|place| at[*place] == vertex).unwrap_or(0);
        after.push((at[(place + 1) % 3], corner));
        before.push((at[(place + 2) % 3], corner));
    }
    after.sort_unstable();
    before.sort_unstable();
    let same = |list: &[(u32, usize)], end: u32| {
        let start = list.partition_point(|(it, _)| *it < end);
        let count = list[start..].iter().take_while(|(it, _)| *it == end).count();
        (count == 1).then(|| list[start].1)
    };
    // Every corner's fan, as the lowest corner known to be in it.
    let mut lower: Vec<usize> = (0..corners.len()).collect();
    let lowest = |lower: &mut Vec<usize>, mut corner: usize| {
        while lower[corner] != corner {
            lower[corner] = lower[lower[corner]];
            corner = lower[corner];
        }
        corner
    };
    for ends in after.chunk_by(|one, other| one.0 == other.0) {
        if let (Some(one), Some(other)) = (same(ends, ends[0].0), same(&before, ends[0].0)) {
            let both = [one, other].map(|corner| lowest(&mut lower, corner));
            lower[both[0].max(both[1])] = both[0].min(both[1]);
        }
    }
    let mut fans: Vec<Vec<u32>> = Vec::new();
    let mut numbers = vec![0; corners.len()];
    for (corner, [_, triangle]) in corners.iter().enumerate() {
        let first = lowest(&mut lower, corner);
        if first == corner {
            numbers[corner] = fans.len();
            fans.push(Vec::new());
        }
        fans[numbers[first]].push(*triangle);
    }
    fans
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fans_that_share_a_vertex_are_parted_and_joined() {
        let points = [[0.0; 3]; 7];
        // A fan of two triangles, one of one, and a triangle elsewhere.
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 0], [1, 6, 2]];
        let parted = OpenFans::part(&points, &triangles, &[]);
        assert_eq!(parted.shared, [0, 7]);
        assert_eq!(parted.triangles.iter().filter(|it| it.contains(&7)).count(), 1);
        let mut back = parted.triangles.to_vec();
        let joined: Vec<u32> = (0..parted.points.len() as u32).collect();
        parted.join(&mut back, &joined);
        assert_eq!(back, triangles);
    }

    #[test]
    fn closed_fans_stay_and_pages_of_a_book_are_parted() {
        let points = [[0.0; 3]; 7];
        let tetrahedron = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        assert!(OpenFans::part(&points, &tetrahedron, &[]).shared.is_empty());
        let book = [[0, 1, 2], [0, 1, 3], [1, 0, 4], [0, 5, 6]];
        let parted = OpenFans::part(&points, &book, &[]);
        assert_eq!(parted.shared.iter().filter(|it| [0, 1].contains(*it)).count(), 2);
        assert!((0..3).all(|page| (0..page).all(|other| {
            let pages = [page, other].map(|page| parted.triangles[page]);
            pages[0].iter().filter(|it| pages[1].contains(it)).count() < 2
        })));
        let mut back = parted.triangles.to_vec();
        let joined: Vec<u32> = (0..parted.points.len() as u32).collect();
        parted.join(&mut back, &joined);
        assert_eq!(back, book);
    }

    #[test]
    fn no_edge_gets_more_than_two_triangles() {
        let points = [[0.0; 3]; 8];
        let triangles = [[0, 1, 2], [0, 3, 4], [1, 5, 6], [0, 5, 7]];
        let parted = OpenFans::part(&points, &triangles, &[]);
        let [zeros, ones] = [0, 1].map(|vertex| {
            let mut all: Vec<u32> = parted.triangles.iter().flatten().copied().collect();
            all.retain(|it| *it == vertex || parted.shared.contains(it) && *it as usize >= points.len());
            all
        });
        assert!(zeros.len() > 2 && ones.len() > 1);
        let added = parted.points.len() as u32 - 1;
        let mut left = [[0, 1, 2], [8, 1, 3], [added, 0, 4]];
        let joined: Vec<u32> = (0..parted.points.len() as u32).collect();
        parted.join(&mut left, &joined);
        let edge = |triangle: &&[u32; 3]| triangle.contains(&0) && triangle.contains(&1);
        assert!(left.iter().filter(edge).count() <= 2);
    }
}
