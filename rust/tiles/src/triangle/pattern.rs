//! The tessellation pattern of a triangle: where the values of a triangle with T segments a side are, and how they are
//! counted.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6, after
//! Schäfer, Prus, Meyer, Süßmuth and Stamminger 2012, Multiresolution Attributes for Tessellated Meshes. The pattern is
//! made of nested rings: ring k has T − 2k segments a side and its least barycentric coordinate is 2k / 3T, so that the
//! last one, k = T/2, is the centroid. All coordinates are whole multiples of 1 / 3T, and the patterns of T/2 and T/4
//! are subsets. Between two rings run strips of quads whose diagonals lean toward the middle of the side, as the
//! tessellator of graphics hardware has them, which gives every inner vertex six neighbours. The inside of a face is
//! counted from the centroid outwards, so that the number of a vertex does not depend on T.

use std::sync::OnceLock;

use relievo_core::{Error, Result};

/// A tessellation pattern: the number of segments along a side of the triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pattern(u32);

/// A vertex of a pattern. Ring 0 is the triangle itself. Side `s` goes from corner `s` to corner `s + 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node {
    /// The ring it is on.
    pub ring: u32,
    /// The side of the ring, 0 to 2.
    pub side: u32,
    /// Segments from the start of the side; less than the side has. 0 at the centroid, whose side is 0.
    pub step: u32,
}

/// Where the value of a vertex of a pattern is kept: at a corner of the triangle, on a side or inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Slot {
    /// At corner 0 to 2.
    Corner(u32),
    /// On side 0 to 2, as many segments from its start as the second number says, 1 to T − 1.
    Side(u32, u32),
    /// Inside, with this index, below [`Pattern::face_values`].
    Inside(u32),
}

/// The neighbours of a vertex of a pattern in one triangle, counter-clockwise. Those of a vertex on the border of the
/// triangle are a fan that starts with the next vertex along the border and ends with the previous one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OneRing {
    nodes: [Node; 6],
    count: usize,
    closed: bool,
}

impl OneRing {
    fn fan(fan: &[Node]) -> Self {
        let mut nodes = [Node { ring: 0, side: 0, step: 0 }; 6];
        nodes[..fan.len()].copy_from_slice(fan);
        Self { nodes, count: fan.len(), closed: false }
    }

    fn all(nodes: [Node; 6]) -> Self {
        Self { nodes, count: 6, closed: true }
    }

    /// The neighbours.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes[..self.count]
    }

    /// Neighbours that make a triangle with the vertex, pair by pair.
    pub fn pairs(&self) -> impl Iterator<Item = [Node; 2]> + '_ {
        let count = if self.closed { self.count } else { self.count - 1 };
        (0..count).map(|at| [self.nodes[at], self.nodes[(at + 1) % self.count]])
    }
}

impl Pattern {
    /// The numbers of segments a channel can have at its finest.
    pub const SIZES: [u32; 4] = [8, 16, 32, 64];

    /// The pattern of two segments a side.
    pub const COARSEST: Self = Self(2);

    /// The pattern of a power of two of segments, 2 to 64.
    pub(crate) fn of_power(segments: u32) -> Self {
        Self(segments.clamp(2, 64))
    }

    /// The pattern of `segments` a side.
    ///
    /// # Errors
    /// Fails unless the number of segments is even and from 2 to 64.
    pub fn new(segments: u32) -> Result<Self> {
        if segments.is_multiple_of(2) && (2..=64).contains(&segments) {
            return Ok(Self(segments));
        }
        Err(Error::invalid(format!("a triangle cannot have {segments} segments a side")).advise("use 8, 16, 32 or 64"))
    }

    /// The pattern with half the segments, `levels` times over, but no coarser than two segments.
    pub fn coarser(self, levels: u32) -> Self {
        Self((self.0 >> levels.min(31)).max(2))
    }

    /// The pattern with twice the segments.
    pub(crate) fn finer(self) -> Self {
        Self(2 * self.0)
    }

    /// Segments along a side: T.
    pub fn segments(self) -> u32 {
        self.0
    }

    /// Values on a side without its ends: T − 1.
    pub fn edge_values(self) -> usize {
        self.0 as usize - 1
    }

    /// Values inside: ⌊(3T/2)(T/2 − 1) + 1⌋.
    pub fn face_values(self) -> usize {
        let t = self.0 as usize;
        3 * t / 2 * (t / 2 - 1) + 1
    }

    /// The ring that is the centroid.
    pub fn center(self) -> u32 {
        self.0 / 2
    }

    /// Segments along a side of a ring.
    pub fn ring_segments(self, ring: u32) -> u32 {
        self.0 - 2 * ring
    }

    /// The vertex `step` segments along a side of a ring, from 0 to as many as the side has.
    pub fn node(self, ring: u32, side: u32, step: u32) -> Node {
        let segments = self.ring_segments(ring);
        match step {
            _ if segments == 0 => Node { ring, side: 0, step: 0 },
            step if step == segments => Node { ring, side: (side + 1) % 3, step: 0 },
            step => Node { ring, side, step },
        }
    }

    /// Barycentric coordinates in multiples of 1 / 3T.
    pub fn weights(self, node: Node) -> [u32; 3] {
        let Node { ring, side, step } = node;
        let mut weights = [2 * ring; 3];
        weights[side as usize % 3] = 3 * self.0 - 4 * ring - 3 * step;
        weights[(side as usize + 1) % 3] = 2 * ring + 3 * step;
        weights
    }

    /// The vertex with these barycentric coordinates in multiples of 1 / 3T, if there is one.
    pub fn at_weights(self, weights: [u32; 3]) -> Option<Node> {
        let least = weights[0].min(weights[1]).min(weights[2]);
        let sum = weights.iter().try_fold(0u32, |sum, weight| sum.checked_add(*weight))?;
        if sum != 3 * self.0 || !least.is_multiple_of(2) {
            return None;
        }
        // The side whose opposite weight is the least; at a corner of the ring the one that starts there.
        let side = (0..3).find(|side| weights[(side + 2) % 3] == least && weights[*side] != least).unwrap_or(0);
        let along = weights[(side + 1) % 3] - least;
        along.is_multiple_of(3).then(|| self.node(least / 2, side as u32, along / 3))
    }

    /// Where the value of a vertex is kept.
    pub fn slot(self, node: Node) -> Slot {
        match node {
            Node { ring: 0, side, step: 0 } => Slot::Corner(side),
            Node { ring: 0, side, step } => Slot::Side(side, step),
            Node { ring, side, step } => {
                // Half the segments of a side of the ring; rings further in have 6 values each for 1, 2, …
                let half = self.center() - ring;
                Slot::Inside(if half == 0 { 0 } else { 1 + 3 * half * (half - 1) + 2 * half * side + step })
            }
        }
    }

    /// The vertex whose value is kept there. The inverse of [`Self::slot`].
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn at_slot(self, slot: Slot) -> Node {
        match slot {
            Slot::Corner(side) => self.node(0, side, 0),
            Slot::Side(side, step) => self.node(0, side, step),
            Slot::Inside(0) => self.node(self.center(), 0, 0),
            Slot::Inside(index) => {
                assert!((index as usize) < self.face_values(), "value {index} does not exist");
                // The largest half with 3 · half · (half − 1) ≤ index − 1.
                let half = (1 + 4 * ((index - 1) / 3)).isqrt().div_ceil(2);
                let rest = index - 1 - 3 * half * (half - 1);
                self.node(self.center() - half, rest / (2 * half), rest % (2 * half))
            }
        }
    }

    /// Barycentric coordinates of the values inside, in the order of [`Slot::Inside`], if the number of segments is a
    /// power of two; else nothing.
    pub fn places(self) -> &'static [[f32; 3]] {
        static TABLES: [OnceLock<Vec<[f32; 3]>>; 6] = [const { OnceLock::new() }; 6];
        if !self.0.is_power_of_two() {
            return &[];
        }
        TABLES[self.0.ilog2() as usize - 1].get_or_init(|| {
            let unit = 1.0 / (3.0 * f64::from(self.0));
            let weights = (0..self.face_values() as u32).map(|index| self.weights(self.at_slot(Slot::Inside(index))));
            weights.map(|weights| weights.map(|weight| (f64::from(weight) * unit) as f32)).collect()
        })
    }

    /// The vertex of the pattern with twice the segments at the same place.
    pub fn refined(self, node: Node) -> Node {
        Node { ring: 2 * node.ring, side: node.side, step: 2 * node.step }
    }

    /// The neighbours of a vertex: eight cases and, at corners of the triangle, what this triangle has of them.
    pub fn one_ring(self, node: Node) -> OneRing {
        let Node { ring: k, side: s, step: j } = node;
        let n = self.ring_segments(k);
        let before = (s + 2) % 3;
        if n == 0 {
            let around = |corner: u32, step: u32| self.node(k - 1, corner, step);
            return OneRing::all([around(0, 0), around(0, 1), around(1, 0), around(1, 1), around(2, 0), around(2, 1)]);
        }
        let next = self.node(k, s, j + 1);
        let inner = |step: u32| self.node(k + 1, s, step);
        if j == 0 {
            let previous = self.node(k, before, n - 1);
            if k == 0 {
                return OneRing::fan(&[next, inner(0), previous]);
            }
            let outside = [self.node(k - 1, before, n + 1), self.node(k - 1, s, 0), self.node(k - 1, s, 1)];
            return OneRing::all([next, inner(0), previous, outside[0], outside[1], outside[2]]);
        }
        let previous = self.node(k, s, j - 1);
        let outer = |step: u32| self.node(k - 1, s, step);
        match (k == 0, (2 * j).cmp(&n)) {
            (true, std::cmp::Ordering::Less) => OneRing::fan(&[next, inner(j), inner(j - 1), previous]),
            (true, std::cmp::Ordering::Equal) => OneRing::fan(&[next, inner(j - 1), previous]),
            (true, std::cmp::Ordering::Greater) => OneRing::fan(&[next, inner(j - 1), inner(j - 2), previous]),
            (false, std::cmp::Ordering::Less) => {
                OneRing::all([next, inner(j), inner(j - 1), previous, outer(j), outer(j + 1)])
            }
            (false, std::cmp::Ordering::Equal) => {
                OneRing::all([next, inner(j - 1), previous, outer(j), outer(j + 1), outer(j + 2)])
            }
            (false, std::cmp::Ordering::Greater) => {
                OneRing::all([next, inner(j - 1), inner(j - 2), previous, outer(j + 1), outer(j + 2)])
            }
        }
    }

    /// The triangles between a ring and the next along one side, counter-clockwise.
    pub fn strip(self, ring: u32, side: u32) -> impl Iterator<Item = [Node; 3]> {
        let n = self.ring_segments(ring);
        (0..n).flat_map(move |q| {
            let outer = |step: u32| self.node(ring, side, step);
            let inner = |step: u32| self.node(ring + 1, side, step);
            let left = 2 * q < n;
            let tip = if left { inner(q.min(n - 2)) } else { inner(q - 1) };
            let other = match (q > 0 && q + 1 < n, left) {
                (false, _) => None,
                (true, true) => Some([outer(q), inner(q), inner(q - 1)]),
                (true, false) => Some([outer(q + 1), inner(q), inner(q - 1)]),
            };
            [Some([outer(q), outer(q + 1), tip]), other].into_iter().flatten()
        })
    }

    /// All triangles, counter-clockwise, from the outermost strip inwards: 3T²/2 of them.
    pub fn triangles(self) -> impl Iterator<Item = [Node; 3]> {
        (0..self.center()).flat_map(move |ring| (0..3).flat_map(move |side| self.strip(ring, side)))
    }

    /// The triangle of the pattern that holds the place with barycentric coordinates `at`, and the shares of its
    /// corners there, which are not negative and add up to 1. Places outside are moved inside; on a side only vertices
    /// of the side have a share.
    pub fn locate(self, at: [f32; 3]) -> ([Node; 3], [f32; 3]) {
        let at = at.map(|b| if b > 0.0 { b.min(1.0) } else { 0.0 });
        let least = at[0].min(at[1]).min(at[2]);
        let side = (0..3).find(|side| at[(side + 2) % 3] == least).unwrap_or(0);
        let segments = self.0 as f32;
        let depth = least * segments * 1.5;
        let ring = (depth as u32).min(self.center() - 1);
        let t = (depth - ring as f32).clamp(0.0, 1.0);
        let n = self.ring_segments(ring);
        let along = (at[(side + 1) % 3] + 0.5 * least) * segments - ring as f32;
        let q = (along.max(0.0) as u32).min(n - 1);
        // The corners of the strip's triangle at its ends are reached at their rims only.
        let f = (along - q as f32).clamp(0.0, 1.0);
        let f = if q == 0 { f.max(t) } else { f };
        let f = if q == n - 1 { f.min(1.0 - t) } else { f };
        let side = side as u32;
        let outer = |step: u32| self.node(ring, side, step);
        let inner = |step: u32| self.node(ring + 1, side, step);
        if 2 * q < n {
            if f >= t {
                ([outer(q), outer(q + 1), inner(q.min(n - 2))], [1.0 - f, f - t, t])
            } else {
                ([outer(q), inner(q), inner(q - 1)], [1.0 - t, f, t - f])
            }
        } else if f + t <= 1.0 {
            ([outer(q), outer(q + 1), inner(q - 1)], [1.0 - f - t, f, t])
        } else {
            ([outer(q + 1), inner(q), inner(q - 1)], [1.0 - t, f + t - 1.0, 1.0 - f])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    fn all() -> impl Iterator<Item = Pattern> {
        [2, 4, 6, 8, 10, 12, 16, 32, 64].into_iter().map(|t| Pattern::new(t).unwrap())
    }

    fn slots(pattern: Pattern) -> Vec<Slot> {
        let sides = (0..3).flat_map(|side| (1..pattern.segments()).map(move |step| Slot::Side(side, step)));
        let inside = (0..pattern.face_values() as u32).map(Slot::Inside);
        (0..3).map(Slot::Corner).chain(sides).chain(inside).collect()
    }

    #[test]
    fn counts_are_those_of_the_paper() {
        let pattern = Pattern::new(16).unwrap();
        assert_eq!((pattern.edge_values(), pattern.face_values()), (15, 169));
        for (t, inside) in [(2, 1), (4, 7), (8, 37), (32, 721), (64, 2977)] {
            assert_eq!(Pattern::new(t).unwrap().face_values(), inside);
        }
        assert!([0, 1, 3, 17, 66, u32::MAX].iter().all(|t| Pattern::new(*t).is_err()));
    }

    #[test]
    fn slots_vertices_and_weights_are_one_to_one() {
        for pattern in all() {
            let t = pattern.segments();
            let mut seen = BTreeSet::new();
            for slot in slots(pattern) {
                let node = pattern.at_slot(slot);
                let weights = pattern.weights(node);
                assert_eq!(weights.iter().sum::<u32>(), 3 * t);
                assert_eq!(*weights.iter().min().unwrap(), 2 * node.ring);
                assert_eq!((pattern.slot(node), pattern.at_weights(weights)), (slot, Some(node)));
                assert!(seen.insert(weights));
            }
            // Ring k has T − 2k segments a side.
            for ring in 0..t / 2 {
                let count = seen.iter().filter(|weights| weights.iter().min() == Some(&(2 * ring))).count() as u32;
                assert_eq!((count, pattern.ring_segments(ring)), (3 * (t - 2 * ring), t - 2 * ring));
            }
            // Nothing else has a vertex.
            let every = (0..=3 * t).flat_map(|a| (0..=3 * t - a).map(move |b| [a, b, 3 * t - a - b]));
            assert!(every.into_iter().all(|w| seen.contains(&w) == pattern.at_weights(w).is_some()));
            assert_eq!(pattern.at_weights([1, 0, 0]), None);
            assert_eq!(pattern.at_weights([u32::MAX; 3]), None);
        }
    }

    #[test]
    fn coarser_patterns_are_subsets() {
        for fine in [4, 8, 16, 32, 64].map(|t| Pattern::new(t).unwrap()) {
            let coarse = Pattern::new(fine.segments() / 2).unwrap();
            for slot in slots(coarse) {
                let node = coarse.at_slot(slot);
                let refined = coarse.refined(node);
                assert_eq!(fine.weights(refined), coarse.weights(node).map(|w| 2 * w));
                assert_eq!(fine.at_weights(fine.weights(refined)), Some(refined));
            }
        }
    }

    #[test]
    fn triangles_cover_the_face_exactly_once() {
        for pattern in all() {
            let t = u64::from(pattern.segments());
            let mut area = 0;
            let mut edges = BTreeMap::new();
            let mut count = 0;
            for triangle in pattern.triangles() {
                let [a, b, c] = triangle.map(|node| pattern.weights(node).map(i64::from));
                let twice = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
                assert!(twice > 0, "{triangle:?} of {t} is not counter-clockwise");
                area += twice as u64;
                count += 1;
                for k in 0..3 {
                    let directed = (triangle[k], triangle[(k + 1) % 3]);
                    assert!(edges.insert(directed, triangle[(k + 2) % 3]).is_none(), "{directed:?} is used twice");
                }
            }
            assert_eq!((area, count), (9 * t * t, 3 * t * t / 2));
            // Every edge has two sides, but for those of the border, of which there are T a side.
            let border: Vec<_> = edges.keys().filter(|(a, b)| !edges.contains_key(&(*b, *a))).collect();
            assert_eq!(border.len() as u64, 3 * t);
            assert!(border.iter().all(|(a, b)| a.ring == 0 && *b == pattern.node(0, a.side, a.step + 1)));
        }
    }

    #[test]
    fn one_rings_are_those_of_the_triangles() {
        for pattern in all() {
            let mut fans: BTreeMap<Node, BTreeSet<[Node; 2]>> = BTreeMap::new();
            for [a, b, c] in pattern.triangles() {
                for [at, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
                    fans.entry(at).or_default().insert([from, to]);
                }
            }
            for slot in slots(pattern) {
                let node = pattern.at_slot(slot);
                let ring = pattern.one_ring(node);
                assert_eq!(ring.pairs().collect::<BTreeSet<_>>(), fans[&node], "{slot:?} of {pattern:?}");
                let neighbours: BTreeSet<_> = ring.nodes().iter().collect();
                assert_eq!(neighbours.len(), ring.nodes().len());
                assert_eq!(ring.closed, node.ring > 0);
            }
        }
    }

    #[test]
    fn places_are_found_in_their_triangle() {
        for pattern in all() {
            let triangles: BTreeSet<BTreeSet<Node>> =
                pattern.triangles().map(|triangle| triangle.into_iter().collect()).collect();
            let unit = 1.0 / (3.0 * f64::from(pattern.segments()));
            let place = |nodes: &[Node; 3], shares: &[f32; 3]| -> [f64; 3] {
                std::array::from_fn(|axis| {
                    let terms = nodes.iter().zip(shares);
                    terms.map(|(n, s)| f64::from(pattern.weights(*n)[axis]) * unit * f64::from(*s)).sum()
                })
            };
            let steps = 97u32;
            for (i, j) in (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j))) {
                let [a, b] = [i, j].map(|i| i as f32 / steps as f32);
                let at = [a, b, (steps - i - j) as f32 / steps as f32];
                let (nodes, shares) = pattern.locate(at);
                assert!(shares.iter().all(|share| *share >= -1e-6 && *share <= 1.0 + 1e-6), "{at:?} {shares:?}");
                assert!(triangles.contains(&nodes.into_iter().collect()), "{at:?} {nodes:?}");
                for (found, wanted) in place(&nodes, &shares).iter().zip(at) {
                    assert!((found - f64::from(wanted)).abs() < 1e-5, "{at:?} {nodes:?} {shares:?}");
                }
                if at.contains(&0.0) {
                    assert!(nodes.iter().zip(shares).all(|(node, share)| node.ring == 0 || share == 0.0), "{at:?}");
                }
            }
            // At a vertex the vertex has it all.
            for slot in slots(pattern) {
                let node = pattern.at_slot(slot);
                let (nodes, shares) = pattern.locate(pattern.weights(node).map(|w| (f64::from(w) * unit) as f32));
                let share: f32 = nodes.iter().zip(shares).filter(|(n, _)| **n == node).map(|(_, share)| share).sum();
                assert!(share > 1.0 - 1e-4, "{slot:?}: {nodes:?} {shares:?}");
            }
            for wild in [[f32::NAN; 3], [-1.0, 3.0, 0.5], [f32::INFINITY, 0.0, f32::NEG_INFINITY], [1.0; 3]] {
                let (nodes, shares) = pattern.locate(wild);
                assert!(shares.iter().all(|share| share.is_finite()));
                nodes.iter().for_each(|node| {
                    pattern.slot(*node);
                });
            }
        }
    }
}
