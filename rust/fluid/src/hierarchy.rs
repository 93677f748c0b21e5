//! A hierarchy of boxes: which of them a ray meets, and where it enters and leaves them.

use glam::Vec3;

/// A box by its smallest and largest coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
}

impl Bounds {
    /// Of no points.
    pub const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// The box around this and another.
    pub fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The stretch of a ray in the box, in lengths of its direction. It is empty where the first exceeds the second.
    #[inline]
    fn stretch(&self, origin: Vec3, inverse: Vec3) -> [f32; 2] {
        let (to_low, to_high) = ((self.low - origin) * inverse, (self.high - origin) * inverse);
        let mut stretch = [f32::NEG_INFINITY, f32::INFINITY];
        for (a, b) in to_low.to_array().into_iter().zip(to_high.to_array()) {
            // On a side that the ray runs along one of them is no number, which min and max pass over.
            stretch = [stretch[0].max(a.min(b)), stretch[1].min(a.max(b))];
        }
        stretch
    }
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

/// Where a ray is in a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
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

    /// Lists the boxes that a ray meets between two distances, by where it enters them. Distances are in lengths of the
    /// direction.
    pub fn meet(&self, origin: Vec3, direction: Vec3, [near, far]: [f32; 2], met: &mut Vec<Stretch>) {
        met.clear();
        let inverse = direction.recip();
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
                met.push(Stretch { enter, exit, leaf: node.link });
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
            let vector = |numbers: [i8; 3]| Vec3::from(numbers.map(f32::from));
            let (origin, direction) = (vector(origin) + Vec3::splat(0.01), vector(direction));
            prop_assume!(direction != Vec3::ZERO);
            let boxes: Vec<Bounds> =
                corners.iter().map(|(low, size)| Bounds { low: vector(*low), high: vector(*low) + vector(*size) }).collect();
            let mut met = Vec::new();
            Hierarchy::new(&boxes).meet(origin, direction, [0.0, 10.0], &mut met);
            prop_assert!(met.windows(2).all(|pair| pair[0].enter <= pair[1].enter));
            let mut found: Vec<u32> = met.iter().map(|stretch| stretch.leaf).collect();
            found.sort_unstable();
            let expected: Vec<u32> = (0..boxes.len() as u32).filter(|at| {
                let [enter, exit] = boxes[*at as usize].stretch(origin, direction.recip());
                enter.max(0.0) <= exit.min(10.0)
            }).collect();
            prop_assert_eq!(found, expected);
        }
    }
}
