//! A hierarchy of boxes: which of them a ray meets, and where it enters them.

use glam::{Vec3, Vec3A};

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

/// A node: of a leaf its number, else the place of the second child; the first one is the next node.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    leaf: bool,
    link: u32,
}

/// A hierarchy over numbered boxes, split at the middle one along the longest side.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hierarchy {
    nodes: Vec<Node>,
}

/// Where a ray enters and leaves a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub enter: f32,
    pub exit: f32,
    pub leaf: u32,
}

impl Hierarchy {
    /// Of boxes, of which there are less than 2³¹.
    pub fn new(boxes: &[Bounds]) -> Self {
        let mut hierarchy = Self { nodes: Vec::with_capacity(2 * boxes.len()) };
        let mut leaves: Vec<u32> = (0..boxes.len() as u32).collect();
        if !leaves.is_empty() {
            hierarchy.split(boxes, &mut leaves);
        }
        hierarchy
    }

    fn split(&mut self, boxes: &[Bounds], leaves: &mut [u32]) {
        let around = |all: Bounds, leaf: &u32| all.with(boxes[*leaf as usize]);
        let bounds = leaves.iter().fold(Bounds::NONE, around);
        let at = self.nodes.len();
        self.nodes.push(Node { bounds, leaf: leaves.len() == 1, link: leaves[0] });
        if leaves.len() == 1 {
            return;
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
        self.split(boxes, low);
        self.nodes[at].link = self.nodes.len() as u32;
        self.split(boxes, high);
    }

    /// The box around all; none without boxes.
    pub fn bounds(&self) -> Option<Bounds> {
        self.nodes.first().map(|node| node.bounds)
    }

    /// The stretch of a ray between two distances in the box around all; none if it misses that.
    pub fn extent(&self, origin: Vec3, direction: Vec3, [near, far]: [f32; 2]) -> Option<[f32; 2]> {
        let [enter, exit] = self.nodes.first()?.bounds.stretch(Vec3A::from(origin), inverse(direction));
        let (enter, exit) = (enter.max(near), exit.min(far));
        (enter <= exit).then_some([enter, exit])
    }

    /// Lists the boxes that have a place in common with one.
    pub fn overlap(&self, bounds: &Bounds, found: &mut Vec<u32>) {
        found.clear();
        let mut open = [0u32; 64];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let at = open[waiting];
            let node = &self.nodes[at as usize];
            if !(node.bounds.low.cmple(bounds.high) & node.bounds.high.cmpge(bounds.low)).all() {
                continue;
            }
            if node.leaf {
                found.push(node.link);
            } else {
                // Halves are equal, so there are at most 32 levels.
                open[waiting] = node.link;
                open[waiting + 1] = at + 1;
                waiting += 2;
            }
        }
    }

    /// Lists the boxes that a ray meets between two distances, by where it enters them. Distances are in lengths of the
    /// direction.
    pub fn meet(&self, origin: Vec3, direction: Vec3, [near, far]: [f32; 2], met: &mut Vec<Entry>) {
        met.clear();
        let (origin, inverse) = (Vec3A::from(origin), inverse(direction));
        let mut open = [0u32; 64];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let at = open[waiting];
            let node = &self.nodes[at as usize];
            let [enter, exit] = node.bounds.stretch(origin, inverse);
            let (enter, exit) = (enter.max(near), exit.min(far));
            if enter > exit {
                continue;
            }
            if node.leaf {
                met.push(Entry { enter, exit, leaf: node.link });
            } else {
                // Halves are equal, so there are at most 32 levels.
                open[waiting] = node.link;
                open[waiting + 1] = at + 1;
                waiting += 2;
            }
        }
        met.sort_unstable_by(|a, b| a.enter.total_cmp(&b.enter).then(a.leaf.cmp(&b.leaf)));
    }
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
