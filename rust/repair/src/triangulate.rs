//! Triangulates closed polygons in space by dynamic programming (Barequet and Sharir 1995) with the weights of Liepa
//! 2003, Section 3: the largest dihedral angle first, then the area.

use glam::DVec3;

/// The longest polygon that is triangulated at once, in time of the cube of its length. Longer ones are first divided by
/// short diagonals.
const LONGEST: usize = 256;

/// Places that are tried for each end of a diagonal that divides a long polygon.
const TRIED: usize = 1000;

/// Angles are compared in steps of this part of the range of the cosine, so that rounding does not outweigh area.
const STEPS: f64 = (1u32 << 20) as f64;

/// A closed polygon to be triangulated.
pub struct Polygon<'a> {
    /// Positions of the vertices.
    pub places: &'a [DVec3],
    /// Normals of the faces beside the edges; zero where it is unknown.
    pub normals: &'a [DVec3],
    /// Whether a diagonal between two vertices must not be used, because it is an edge of the mesh.
    pub is_taken: &'a dyn Fn(u32, u32) -> bool,
}

impl Polygon<'_> {
    /// Returns triangles of the vertices in the direction of the polygon, or `None` if none avoid the taken diagonals.
    pub fn triangulate(&self) -> Option<Vec<[u32; 3]>> {
        let mut triangles = Vec::with_capacity(self.places.len());
        let mut open = vec![((0..self.places.len() as u32).collect::<Vec<u32>>(), self.normals.to_vec())];
        while let Some((vertices, normals)) = open.pop() {
            match self.divide(&vertices) {
                Some([from, to]) => {
                    let inner = vertices[from..=to].to_vec();
                    let mut inner_normals = normals[from..to].to_vec();
                    inner_normals.push(DVec3::ZERO);
                    let outer = [&vertices[..=from], &vertices[to..]].concat();
                    let outer_normals = [&normals[..from], &[DVec3::ZERO], &normals[to..]].concat();
                    open.push((outer, outer_normals));
                    open.push((inner, inner_normals));
                }
                None => self.triangulate_at_once(&vertices, &normals, &mut triangles)?,
            }
        }
        Some(triangles)
    }

    /// Returns the shortest of the tried diagonals that leave at least a quarter of a long polygon on both sides.
    fn divide(&self, vertices: &[u32]) -> Option<[usize; 2]> {
        let count = vertices.len();
        if count <= LONGEST {
            return None;
        }
        let step = count.div_ceil(TRIED);
        let mut best: Option<(f64, [usize; 2])> = None;
        for from in (0..count * 3 / 4).step_by(step) {
            for to in (from + count / 4..count.min(from + count * 3 / 4)).step_by(step) {
                let [a, b] = [vertices[from], vertices[to]];
                let length = self.places[a as usize].distance_squared(self.places[b as usize]);
                if best.is_none_or(|(shortest, _)| length < shortest) && !(self.is_taken)(a, b) {
                    best = Some((length, [from, to]));
                }
            }
        }
        best.map(|(_, ends)| ends)
    }

    /// Adds the best triangles of a polygon of some of the vertices.
    fn triangulate_at_once(&self, vertices: &[u32], normals: &[DVec3], out: &mut Vec<[u32; 3]>) -> Option<()> {
        let count = vertices.len();
        let place = |vertex: usize| self.places[vertices[vertex] as usize];
        let mut table = vec![Entry::IMPOSSIBLE; count * count];
        for from in 0..count - 1 {
            table[from * count + from + 1] = Entry { angle: 0, area: 0.0, apex: 0, normal: normals[from] };
        }
        for length in 2..count {
            for from in 0..count - length {
                let to = from + length;
                // The last diagonal is the edge that closes the polygon.
                let closes = length == count - 1;
                if !closes && (self.is_taken)(vertices[from], vertices[to]) {
                    continue;
                }
                let beside = if closes { normals[to] } else { DVec3::ZERO };
                let mut best = Entry::IMPOSSIBLE;
                for apex in from + 1..to {
                    let (left, right) = (&table[from * count + apex], &table[apex * count + to]);
                    let angle = left.angle.max(right.angle);
                    if angle > best.angle || left.area + right.area == f64::INFINITY {
                        continue;
                    }
                    let vector = (place(apex) - place(from)).cross(place(to) - place(from));
                    let length = vector.length();
                    let normal = if length > 0.0 { vector / length } else { DVec3::ZERO };
                    let bend = |other: DVec3| match other == DVec3::ZERO {
                        true => 0,
                        false => ((1.0 - normal.dot(other)) * STEPS) as u32,
                    };
                    let angle = angle.max(bend(left.normal)).max(bend(right.normal)).max(bend(beside));
                    let area = left.area + right.area + 0.5 * length;
                    if (angle, area) < (best.angle, best.area) {
                        best = Entry { angle, area, apex: apex as u32, normal };
                    }
                }
                table[from * count + to] = best;
            }
        }
        if table[count - 1].area == f64::INFINITY {
            return None;
        }
        let mut open = vec![[0, count - 1]];
        while let Some([from, to]) = open.pop() {
            if to - from >= 2 {
                let apex = table[from * count + to].apex as usize;
                out.push([vertices[from], vertices[apex], vertices[to]]);
                open.push([from, apex]);
                open.push([apex, to]);
            }
        }
        Some(())
    }
}

/// The best triangulation of the part of a polygon behind a diagonal.
#[derive(Clone, Copy)]
struct Entry {
    /// The largest dihedral angle, as one less its cosine.
    angle: u32,
    area: f64,
    /// The third vertex of the triangle at the diagonal.
    apex: u32,
    /// The normal of that triangle.
    normal: DVec3,
}

impl Entry {
    const IMPOSSIBLE: Self = Self { angle: u32::MAX, area: f64::INFINITY, apex: 0, normal: DVec3::ZERO };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(count: usize, radius: impl Fn(f64) -> f64) -> Vec<DVec3> {
        (0..count)
            .map(|index| {
                let angle = index as f64 / count as f64 * std::f64::consts::TAU;
                DVec3::new(angle.cos(), angle.sin(), 0.0) * radius(angle)
            })
            .collect()
    }

    fn area(places: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let vector = |[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|vertex| places[*vertex as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        triangles.iter().map(vector).sum()
    }

    /// A star is not convex: its area is met only by triangles within it.
    #[test]
    fn a_flat_star_is_triangulated_within_its_border() {
        for count in [10, 100, 1200] {
            let places = ring(count, |angle| 1.0 + 0.4 * (5.0 * angle).cos());
            let normals = vec![DVec3::Z; count];
            let polygon = Polygon { places: &places, normals: &normals, is_taken: &|_, _| false };
            let triangles = polygon.triangulate().unwrap();
            assert_eq!(triangles.len(), count - 2);
            let shoelace: f64 =
                (0..count).map(|at| 0.5 * places[at].truncate().perp_dot(places[(at + 1) % count].truncate())).sum();
            let excess = area(&places, &triangles) / shoelace - 1.0;
            assert!(excess.abs() < if count <= LONGEST { 1e-9 } else { 0.05 }, "{count}: {excess}");
        }
    }

    #[test]
    fn diagonals_that_are_taken_are_avoided() {
        let places = ring(4, |_| 1.0);
        let normals = vec![DVec3::ZERO; 4];
        let one = Polygon { places: &places, normals: &normals, is_taken: &|a, b| a.min(b) == 0 && a.max(b) == 2 };
        assert!(one.triangulate().unwrap().iter().all(|triangle| triangle.contains(&1) && triangle.contains(&3)));
        let both = Polygon { places: &places, normals: &normals, is_taken: &|_, _| true };
        assert!(both.triangulate().is_none());
    }
}
