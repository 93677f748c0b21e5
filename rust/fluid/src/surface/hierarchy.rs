//! A hierarchy of boxes: which of them a ray meets, and where it enters them. A node has up to sixteen boxes, which are
//! looked at a vector at a time; with no fused operations the answers are the same at every instruction level.

use glam::{Vec3, Vec3A};
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

/// Boxes of a node.
const WIDTH: usize = 16;
/// Set in links to leaves.
const LEAF: u32 = 1 << 31;
/// Nodes that wait at most: links have 31 bits, of which each level takes four.
const WAITING: usize = 8 * (WIDTH - 1) + 1;

/// A box by its smallest and largest coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub low: Vec3A,
    pub high: Vec3A,
}

impl Bounds {
    /// Of no points.
    pub const NONE: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    /// The box around this and another.
    pub fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The stretch of a ray in the box, in lengths of its direction. It is empty where the first exceeds the second.
    #[inline(always)]
    fn stretch(&self, origin: Vec3A, inverse: Vec3A) -> [f32; 2] {
        let (to_low, to_high) = ((self.low - origin) * inverse, (self.high - origin) * inverse);
        [to_low.min(to_high).max_element(), to_low.max(to_high).min_element()]
    }
}

/// The inverse of a direction, finite where that is 0, so that a side that the ray runs along is no special case.
fn inverse(direction: Vec3) -> Vec3A {
    Vec3A::from(direction.to_array().map(|d| if d.abs() < 1e-20 { 1e20f32.copysign(d) } else { 1.0 / d }))
}

/// Some boxes, as columns by axis. Of those beyond the last the numbers are any.
#[derive(Clone, Debug)]
struct Node {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
    /// The number of a box with [`LEAF`], or the place of the node of boxes in it.
    links: [u32; WIDTH],
    count: u32,
}

/// A hierarchy over numbered boxes, split at the middle one along the longest side.
#[derive(Clone, Debug)]
pub(crate) struct Hierarchy {
    nodes: Vec<Node>,
    around: Bounds,
    level: Level,
}

/// Where a ray enters and leaves a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub enter: f32,
    pub exit: f32,
    pub leaf: u32,
}

impl Default for Hierarchy {
    fn default() -> Self {
        Self::new(&[])
    }
}

impl Hierarchy {
    /// Of boxes, of which there are less than 2³¹.
    pub fn new(boxes: &[Bounds]) -> Self {
        let around = boxes.iter().fold(Bounds::NONE, |all, other| all.with(*other));
        let mut hierarchy = Self { nodes: Vec::new(), around, level: Level::best() };
        let mut leaves: Vec<u32> = (0..boxes.len() as u32).collect();
        if !leaves.is_empty() {
            hierarchy.divide(boxes, &mut leaves);
        }
        hierarchy
    }

    /// Makes the node of some boxes and those below it, and returns its place.
    fn divide(&mut self, boxes: &[Bounds], leaves: &mut [u32]) -> u32 {
        let mut groups = vec![leaves];
        while groups.len() < WIDTH && groups.iter().any(|group| group.len() > 1) {
            groups = groups.into_iter().flat_map(|group| split(boxes, group)).flatten().collect();
        }
        let at = self.nodes.len();
        let blank = [[0.0; WIDTH]; 3];
        self.nodes.push(Node { low: blank, high: blank, links: [0; WIDTH], count: groups.len() as u32 });
        for (place, group) in groups.into_iter().enumerate() {
            let around = group.iter().fold(Bounds::NONE, |all, leaf| all.with(boxes[*leaf as usize]));
            let link = if let [leaf] = *group { leaf | LEAF } else { self.divide(boxes, group) };
            let node = &mut self.nodes[at];
            node.links[place] = link;
            for axis in 0..3 {
                (node.low[axis][place], node.high[axis][place]) = (around.low[axis], around.high[axis]);
            }
        }
        at as u32
    }

    /// The box around all; none without boxes.
    pub fn bounds(&self) -> Option<Bounds> {
        (!self.nodes.is_empty()).then_some(self.around)
    }

    /// The stretch of a ray between two distances in the box around all; none if it misses that.
    pub fn extent(&self, origin: Vec3, direction: Vec3, [near, far]: [f32; 2]) -> Option<[f32; 2]> {
        let [enter, exit] = self.bounds()?.stretch(Vec3A::from(origin), inverse(direction));
        let (enter, exit) = (enter.max(near), exit.min(far));
        (enter <= exit).then_some([enter, exit])
    }

    /// Lists the boxes that have a place in common with one.
    pub fn overlap(&self, bounds: &Bounds, found: &mut Vec<u32>) {
        found.clear();
        overlap(self.level, &self.nodes, bounds, found);
    }

    /// Lists the boxes that a ray meets between two distances, by where it enters them. Distances are in lengths of the
    /// direction.
    pub fn meet(&self, origin: Vec3, direction: Vec3, reach: [f32; 2], met: &mut Vec<Entry>) {
        met.clear();
        meet(self.level, &self.nodes, [origin, inverse(direction).into()], reach, met);
        met.sort_unstable_by(|a, b| a.enter.total_cmp(&b.enter).then(a.leaf.cmp(&b.leaf)));
    }
}

/// The halves of some boxes along the longest side of the box around their centres; of a single one that alone.
fn split<'a>(boxes: &[Bounds], leaves: &'a mut [u32]) -> [Option<&'a mut [u32]>; 2] {
    if leaves.len() < 2 {
        return [Some(leaves), None];
    }
    let centre = |leaf: u32| boxes[leaf as usize].low + boxes[leaf as usize].high;
    let spread = leaves.iter().fold(Bounds::NONE, |spread, leaf| {
        let centre = centre(*leaf);
        spread.with(Bounds { low: centre, high: centre })
    });
    let axis = (spread.high - spread.low).max_position();
    let half = leaves.len() / 2;
    leaves.select_nth_unstable_by(half, |a, b| centre(*a)[axis].total_cmp(&centre(*b)[axis]).then(a.cmp(b)));
    let (low, high) = leaves.split_at_mut(half);
    [Some(low), Some(high)]
}

/// Two numbers of each box of a node.
type Ends = [[f32; WIDTH]; 2];

/// Goes through the nodes below the first whose boxes `look` says to be wanted, as bits; calls `found` with the numbers that it
/// has of each box that is numbered, and that number.
#[inline(always)]
fn descend(nodes: &[Node], mut look: impl FnMut(&Node, &mut Ends) -> u32, mut found: impl FnMut([f32; 2], u32)) {
    let (mut open, mut ends) = ([0u32; WAITING], [[0.0; WIDTH]; 2]);
    let mut waiting = usize::from(!nodes.is_empty());
    while waiting > 0 {
        waiting -= 1;
        let node = &nodes[open[waiting] as usize];
        let mut wanted = look(node, &mut ends) & ((1 << node.count) - 1);
        while wanted != 0 {
            let place = wanted.trailing_zeros() as usize;
            wanted &= wanted - 1;
            let link = node.links[place];
            if link & LEAF != 0 {
                found(ends.map(|ends| ends[place]), link & !LEAF);
            } else {
                open[waiting] = link;
                waiting += 1;
            }
        }
    }
}

dispatch_simd! {
    fn overlap = overlap_body(nodes: &[Node], bounds: &Bounds, found: &mut Vec<u32>)
}

#[inline(always)]
fn overlap_body<A: Lanes>(v: A, nodes: &[Node], bounds: &Bounds, found: &mut Vec<u32>) {
    let look = |node: &Node, _: &mut Ends| {
        let mut wanted = 0;
        for first in (0..WIDTH).step_by(A::WIDTH) {
            let mut common = v.le(v.splat(0.0), v.splat(0.0));
            for axis in 0..3 {
                let (low, high) = (v.load(&node.low[axis][first..]), v.load(&node.high[axis][first..]));
                common = v.both(common, v.le(low, v.splat(bounds.high[axis])));
                common = v.both(common, v.le(v.splat(bounds.low[axis]), high));
            }
            wanted |= v.mask(common) << first;
        }
        wanted
    };
    descend(nodes, look, |_, leaf| found.push(leaf));
}

dispatch_simd! {
    fn meet = meet_body(nodes: &[Node], ray: [Vec3; 2], reach: [f32; 2], met: &mut Vec<Entry>)
}

/// A ray is its origin and the inverse of its direction.
#[inline(always)]
fn meet_body<A: Lanes>(
    v: A,
    nodes: &[Node],
    [origin, inverse]: [Vec3; 2],
    [near, far]: [f32; 2],
    met: &mut Vec<Entry>,
) {
    let look = |node: &Node, ends: &mut Ends| {
        let mut wanted = 0;
        for first in (0..WIDTH).step_by(A::WIDTH) {
            let (mut enter, mut exit) = (v.splat(near), v.splat(far));
            for axis in 0..3 {
                let (origin, inverse) = (v.splat(origin[axis]), v.splat(inverse[axis]));
                let to = |side: &[f32; WIDTH]| v.mul(v.sub(v.load(&side[first..]), origin), inverse);
                let (low, high) = (to(&node.low[axis]), to(&node.high[axis]));
                enter = v.max(enter, v.min(low, high));
                exit = v.min(exit, v.max(low, high));
            }
            v.store(enter, &mut ends[0][first..]);
            v.store(exit, &mut ends[1][first..]);
            wanted |= v.mask(v.le(enter, exit)) << first;
        }
        wanted
    };
    descend(nodes, look, |[enter, exit], leaf| met.push(Entry { enter, exit, leaf }));
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn rays_meet_the_boxes_that_each_test_alone_says(
            corners in prop::collection::vec((prop::array::uniform3(-4i8..4), prop::array::uniform3(0i8..3)), 0..40),
            origin in prop::array::uniform3(-6i8..6), direction in prop::array::uniform3(-3i8..3),
        ) {
            let vector = |numbers: [i8; 3]| Vec3A::from(numbers.map(f32::from));
            let (origin, direction) = (Vec3::from(vector(origin)) + 0.01, Vec3::from(vector(direction)));
            prop_assume!(direction != Vec3::ZERO);
            let boxes: Vec<Bounds> =
                corners.iter().map(|(low, size)| Bounds { low: vector(*low), high: vector(*low) + vector(*size) }).collect();
            let mut met = Vec::new();
            Hierarchy::new(&boxes).meet(origin, direction, [0.0, 10.0], &mut met);
            prop_assert!(met.windows(2).all(|pair| pair[0].enter <= pair[1].enter));
            let mut found: Vec<u32> = met.iter().map(|entry| entry.leaf).collect();
            found.sort_unstable();
            let around = Bounds { low: origin.into(), high: (origin + direction.abs()).into() };
            let mut overlapped = Vec::new();
            Hierarchy::new(&boxes).overlap(&around, &mut overlapped);
            overlapped.sort_unstable();
            let is_common = |other: &Bounds| other.low.cmple(around.high).all() && other.high.cmpge(around.low).all();
            let common: Vec<u32> = (0..boxes.len() as u32).filter(|at| is_common(&boxes[*at as usize])).collect();
            prop_assert_eq!(overlapped, common);
            let expected: Vec<u32> = (0..boxes.len() as u32).filter(|at| {
                // By the definition: for each axis the stretch between the sides.
                let mut stretch = [0.0f32, 10.0];
                for axis in 0..3 {
                    let ends = [boxes[*at as usize].low, boxes[*at as usize].high].map(|end| end[axis] - origin[axis]);
                    if direction[axis] != 0.0 {
                        let ends = ends.map(|end| end / direction[axis]);
                        stretch = [stretch[0].max(ends[0].min(ends[1])), stretch[1].min(ends[0].max(ends[1]))];
                    } else if ends[0] > 0.0 || ends[1] < 0.0 {
                        return false;
                    }
                }
                stretch[0] <= stretch[1]
            }).collect();
            prop_assert_eq!(found, expected);
        }
    }
}
