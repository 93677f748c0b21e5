//! Curves along which sheets meet: edges of more than two triangles, or of two in the same direction.
//!
//! Where each sheet is simplified alone, the vertices of such curves must stay where they are, or gaps would open between
//! the sheets. With as many of them as there were, all other vertices pay for theirs. So curves are thinned out first, by
//! collapses of their edges in all sheets at once, each vertex onto one beside it. A collapse is made where the complex
//! keeps its topology (Dey, Edelsbrunner, Guha, Nekhayev 1999, Section 2) and no triangle turns over, in the order of the
//! distance of the vertices that are gone from the curve (as Douglas, Peucker 1973).

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use glam::Vec3;

/// The least cosine between the normals of a triangle before and after a collapse.
const TURNED: f32 = 0.3;
/// The least height of a triangle, as a share of its longest edge.
const THIN: f32 = 0.01;
/// Places of vertices that are gone which an edge remembers at most.
const REMEMBERED: usize = 16;

/// A mesh with curves along which sheets meet.
pub struct Sheets {
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// Triangles at the vertices of curves, some of them gone.
    stars: HashMap<u32, Vec<u32>>,
    /// Vertices beside each along a curve.
    curves: HashMap<u32, Vec<u32>>,
    /// Places of vertices that an edge of a curve has replaced.
    replaced: HashMap<[u32; 2], Vec<Vec3>>,
    is_gone: Vec<bool>,
    /// Vertices within a curve that may go.
    inner: HashSet<u32>,
    /// Deviations of vertices of curves that others were collapsed into.
    pub deviations: HashMap<u32, f32>,
}

/// The lower end of an edge first.
fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

impl Sheets {
    /// Finds the curves of a mesh, whose indices are in range, with coordinates multiplied by `scale`. Vertices that are
    /// `locked` stay. `None` if there is no curve.
    pub fn find(points: &[[f32; 3]], triangles: &[[u32; 3]], scale: f32, locked: &[u32]) -> Option<Self> {
        let mut edges = Vec::with_capacity(3 * triangles.len());
        for [a, b, c] in triangles {
            edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| (ordered(*from, *to), from < to)));
        }
        edges.sort_unstable();
        let mut curves: HashMap<u32, Vec<u32>> = HashMap::new();
        let mut ends = Vec::new();
        for edge in edges.chunk_by(|one, other| one.0 == other.0) {
            let [a, b] = edge[0].0;
            match edge {
                [one, other] if one.1 != other.1 && a != b => {}
                [_] => ends.extend([a, b]),
                _ if a != b => [[a, b], [b, a]].iter().for_each(|[a, b]| curves.entry(*a).or_default().push(*b)),
                _ => ends.push(a),
            }
        }
        if curves.is_empty() {
            return None;
        }
        let mut stars: HashMap<u32, Vec<u32>> = curves.keys().map(|vertex| (*vertex, Vec::new())).collect();
        let mut has_curve = vec![false; points.len()];
        curves.keys().for_each(|vertex| has_curve[*vertex as usize] = true);
        for (number, triangle) in (0..).zip(triangles) {
            for vertex in triangle.iter().filter(|vertex| has_curve[**vertex as usize]) {
                stars.entry(*vertex).or_default().push(number);
            }
        }
        let mut inner: HashSet<u32> =
            curves.iter().filter(|(_, beside)| beside.len() == 2).map(|(it, _)| *it).collect();
        locked.iter().chain(&ends).for_each(|vertex| {
            inner.remove(vertex);
        });
        Some(Self {
            points: points.iter().map(|point| Vec3::from(*point) * scale).collect(),
            triangles: triangles.to_vec(),
            stars,
            curves,
            replaced: HashMap::new(),
            is_gone: vec![false; triangles.len()],
            inner,
            deviations: HashMap::new(),
        })
    }

    /// Returns how many vertices of curves may go.
    pub fn inner(&self) -> usize {
        self.inner.len()
    }

    /// Returns the vertices of curves, in order.
    pub fn vertices(&self) -> Vec<u32> {
        let mut vertices: Vec<u32> = self.curves.keys().copied().collect();
        vertices.sort_unstable();
        vertices
    }

    /// Collapses edges of curves until so many vertices are left that may go, or none can.
    pub fn thin(&mut self, left: usize) {
        let mut waiting = BinaryHeap::new();
        for vertex in &self.inner {
            self.wait(*vertex, &mut waiting);
        }
        while self.inner.len() > left
            && let Some(Reverse((cost, gone, kept))) = waiting.pop()
        {
            let Some(now) = self.cost(gone, kept) else { continue };
            if now.to_bits() > cost {
                waiting.push(Reverse((now.to_bits(), gone, kept)));
            } else if self.is_possible(gone, kept) {
                let other = self.collapse(gone, kept, now);
                for vertex in [kept, other] {
                    self.wait(vertex, &mut waiting);
                }
            }
        }
    }

    /// Returns the triangles that are left, in order.
    pub fn left(&self) -> Vec<[u32; 3]> {
        self.triangles.iter().zip(&self.is_gone).filter(|(_, is_gone)| !**is_gone).map(|(it, _)| *it).collect()
    }

    /// Has the collapses of a vertex wait for their turn.
    fn wait(&self, vertex: u32, waiting: &mut BinaryHeap<Reverse<(u32, u32, u32)>>) {
        for kept in &self.curves[&vertex] {
            if let Some(cost) = self.cost(vertex, *kept) {
                waiting.push(Reverse((cost.to_bits(), vertex, *kept)));
            }
        }
    }

    /// Returns the vertex on the other side of one within a curve. `None` if it is gone, or `kept` is not beside it.
    fn other(&self, gone: u32, kept: u32) -> Option<u32> {
        if !self.inner.contains(&gone) {
            return None;
        }
        match self.curves[&gone][..] {
            [a, b] if a == kept && b != kept => Some(b),
            [a, b] if b == kept && a != kept => Some(a),
            _ => None,
        }
    }

    /// Returns the largest distance of vertices that would be gone from the edge that replaces them.
    fn cost(&self, gone: u32, kept: u32) -> Option<f32> {
        let other = self.other(gone, kept)?;
        let [from, to, at] = [other, kept, gone].map(|vertex| self.points[vertex as usize]);
        let along = to - from;
        let distance = |place: &Vec3| {
            let share = (place - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
            place.distance(from + along * share.clamp(0.0, 1.0))
        };
        let replaced = [other, kept].map(|end| self.replaced.get(&ordered(gone, end)));
        Some(replaced.into_iter().flatten().flatten().map(distance).fold(distance(&at), f32::max))
    }

    fn star(&self, vertex: u32) -> impl Iterator<Item = u32> {
        self.stars[&vertex].iter().copied().filter(|it| !self.is_gone[*it as usize])
    }

    /// Returns the vertices that share a triangle with one, in order.
    fn ring(&self, vertex: u32) -> Vec<u32> {
        let mut ring: Vec<u32> = self.star(vertex).flat_map(|it| self.triangles[it as usize]).collect();
        ring.sort_unstable();
        ring.dedup();
        ring.retain(|it| *it != vertex);
        ring
    }

    /// Whether a collapse keeps the topology, and turns no triangle over.
    fn is_possible(&self, gone: u32, kept: u32) -> bool {
        let Some(other) = self.other(gone, kept) else { return false };
        let around = self.ring(kept);
        if around.binary_search(&other).is_ok() {
            return false;
        }
        // What is beside both is opposite their edge.
        let opposite = |it: u32| self.triangles[it as usize].into_iter().find(|end| *end != gone && *end != kept);
        let shared = |it: &u32| self.triangles[*it as usize].contains(&kept);
        let mut across: Vec<u32> = self.star(gone).filter(shared).filter_map(opposite).collect();
        across.sort_unstable();
        across.dedup();
        let both = self.ring(gone).into_iter().filter(|it| around.binary_search(it).is_ok());
        if !both.eq(across.iter().copied()) {
            return false;
        }
        let to = self.points[kept as usize];
        self.star(gone).filter(|it| !shared(it)).all(|it| {
            let triangle = self.triangles[it as usize];
            let ends = triangle.iter().filter(|end| **end != gone);
            if ends.clone().all(|end| across.binary_search(end).is_ok()) {
                return false;
            }
            let corners = triangle.map(|vertex| self.points[vertex as usize]);
            let after = std::array::from_fn(|side| if triangle[side] == gone { to } else { corners[side] });
            let [a, b, c] = after;
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            let [before, after] = [normal(corners), normal(after)];
            after.length() > THIN * longest && after.dot(before) > TURNED * after.length() * before.length()
        })
    }

    /// Collapses an edge of a curve. Returns the vertex beside it.
    fn collapse(&mut self, gone: u32, kept: u32, cost: f32) -> u32 {
        let other = self.other(gone, kept).unwrap_or(kept);
        let mut star = self.stars.remove(&gone).unwrap_or_default();
        star.retain(|it| !self.is_gone[*it as usize]);
        for it in &star {
            let triangle = &mut self.triangles[*it as usize];
            if triangle.contains(&kept) {
                self.is_gone[*it as usize] = true;
            } else {
                triangle.iter_mut().filter(|vertex| **vertex == gone).for_each(|vertex| *vertex = kept);
            }
        }
        star.retain(|it| !self.is_gone[*it as usize]);
        self.stars.entry(kept).or_default().extend(star);
        let mut places: Vec<Vec3> =
            [other, kept].iter().filter_map(|end| self.replaced.remove(&ordered(gone, *end))).flatten().collect();
        if places.len() >= REMEMBERED {
            places = places.into_iter().step_by(2).collect();
        }
        places.push(self.points[gone as usize]);
        self.replaced.insert(ordered(other, kept), places);
        self.inner.remove(&gone);
        self.curves.remove(&gone);
        for (vertex, end) in [(other, kept), (kept, other)] {
            for beside in self.curves.entry(vertex).or_default().iter_mut().filter(|beside| **beside == gone) {
                *beside = end;
            }
            let deviation = self.deviations.entry(vertex).or_default();
            *deviation = deviation.max(cost);
        }
        other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pages that meet along a line of so many edges, bent by `bend`, each one edge wide.
    fn book(pages: u32, edges: u32, bend: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let along = |step: u32| bend * (step as f32).sin();
        let mut points: Vec<[f32; 3]> = (0..=edges).map(|step| [along(step), 0.0, step as f32]).collect();
        let mut triangles = Vec::new();
        for page in 0..pages {
            let (y, x) = (2.0 * std::f32::consts::PI * page as f32 / pages as f32).sin_cos();
            let first = points.len() as u32;
            points.extend((0..=edges).map(|step| [x + along(step), y, step as f32]));
            for step in 0..edges {
                let [a, b, c, d] = [step, step + 1, first + step, first + step + 1];
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
        (points, triangles)
    }

    #[test]
    fn curves_are_thinned_out_in_all_sheets_at_once() {
        let (points, triangles) = book(3, 20, 0.0);
        let mut sheets = Sheets::find(&points, &triangles, 1.0, &[]).unwrap();
        assert_eq!(sheets.inner(), 19);
        sheets.thin(5);
        assert_eq!(sheets.inner(), 5);
        let left = sheets.left();
        assert_eq!(left.len(), triangles.len() - 3 * 14);
        // Six edges along the line, each of three triangles.
        let again = Sheets::find(&points, &left, 1.0, &[]).unwrap();
        assert_eq!((again.inner(), again.curves.len()), (5, 7));
        assert!(sheets.deviations.values().all(|deviation| *deviation < 1e-5));
    }

    #[test]
    fn vertices_at_ends_and_locked_ones_stay_and_turned_triangles_are_refused() {
        let (points, triangles) = book(3, 20, 0.1);
        let mut sheets = Sheets::find(&points, &triangles, 1.0, &[7, 13]).unwrap();
        sheets.thin(0);
        let used: HashSet<u32> = sheets.left().into_iter().flatten().collect();
        assert!([0, 7, 13, 20].iter().all(|vertex| used.contains(vertex)) && sheets.inner() < 17);
        let turned =
            |triangle: &[u32; 3]| normal(triangle.map(|vertex| sheets.points[vertex as usize])).length() < 1e-3;
        assert!(!sheets.left().iter().any(turned));
        assert!(sheets.deviations.values().any(|deviation| *deviation > 0.01));
        assert!(Sheets::find(&points, &triangles[..40], 1.0, &[]).is_none());
    }
}
