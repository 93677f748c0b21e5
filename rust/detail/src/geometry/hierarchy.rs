//! A bounding volume hierarchy over the triangles of a collider or the tiles of a surface, so that culling costs what
//! the overlap holds and not what the scene holds.
//!
//! Boxes are sorted along a Morton curve and grouped by eights, level upon level, so that the tree needs no pointers:
//! group `g` of a level bounds box `g % 8` of group `g / 8` above it. Refitting keeps the order and renews the boxes.

use std::cell::Cell;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::simd::Arithmetic;
use relievo_core::{Context, Error, Result, dispatch_simd};

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub low: [f32; 3],
    /// Largest coordinates.
    pub high: [f32; 3],
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// The box of some points.
    pub fn of_points<'a>(points: impl IntoIterator<Item = &'a [f32; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.with(&Self { low: *point, high: *point }))
    }

    /// The box of both.
    pub fn with(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|axis| self.low[axis].min(other.low[axis])),
            high: std::array::from_fn(|axis| self.high[axis].max(other.high[axis])),
        }
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.low[axis] > self.high[axis])
    }
}

/// Boxes per group.
const WIDTH: usize = 8;

/// Eight boxes side by side. Lanes without a box are empty.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Group {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
}

impl Group {
    const EMPTY: Self = Self { low: [[f32::INFINITY; WIDTH]; 3], high: [[f32::NEG_INFINITY; WIDTH]; 3] };

    fn set(&mut self, lane: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.low[axis][lane] = bounds.low[axis];
            self.high[axis][lane] = bounds.high[axis];
        }
    }

    fn bounds(&self) -> Bounds {
        Bounds {
            low: self.low.map(|lanes| lanes.into_iter().fold(f32::INFINITY, f32::min)),
            high: self.high.map(|lanes| lanes.into_iter().fold(f32::NEG_INFINITY, f32::max)),
        }
    }
}

/// A bounding volume hierarchy.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The boxes in the order of the curve.
    order: Vec<u32>,
    /// Where each box is in that order.
    slots: Vec<u32>,
    /// Groups, the boxes themselves first, one group last.
    levels: Vec<Vec<Group>>,
    bounds: Bounds,
}

/// What is asked of a hierarchy: the boxes that may reach into a slab-bounded region, an oriented box or, where a
/// bound is infinite, a prism.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    map: DAffine3,
    low: DVec3,
    high: DVec3,
    /// The region's own axis-aligned box, infinite for a prism.
    around: Bounds,
}

impl Region {
    /// The points whose image under `map` has coordinates from `low` to `high`, which may be infinite.
    pub fn new(map: DAffine3, low: DVec3, high: DVec3) -> Self {
        let mut around = Bounds { low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY; 3] };
        let inverse = map.inverse();
        if low.is_finite() && high.is_finite() && inverse.is_finite() {
            let center = inverse.transform_point3(0.5 * (low + high));
            let half = inverse.matrix3.abs() * (0.5 * (high - low));
            let slack = 1e-6 * (center.abs() + half);
            around.low = (center - half - slack).as_vec3().to_array();
            around.high = (center + half + slack).as_vec3().to_array();
        }
        Self { map, low, high, around }
    }
}

/// What boxes are approached: a point of the world, in the space of the boxes.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    point: DVec3,
    /// What a square of a distance along each axis counts for in the world.
    weights: DVec3,
    /// By how much boxes are larger than they say.
    margin: f64,
}

impl Target {
    /// `point` of the world, where `transform` leads from the space of the boxes to the world, and what is bounded may
    /// be up to `margin` beyond its box. `None` if the transform cannot be undone.
    pub fn new(transform: &DAffine3, point: DVec3, margin: f64) -> Option<Self> {
        let inverse = transform.inverse();
        if !inverse.is_finite() || !point.is_finite() {
            return None;
        }
        let rows = |matrix: DMat3| [0, 1, 2].map(|axis| matrix.row(axis));
        // With G = MᵀM a displacement d has the squared length dᵀGd, and G without what its other columns add at most
        // (Gershgorin) is a diagonal below it: exact for rotations and for scales along the axes before them.
        let gram = transform.matrix3.transpose() * transform.matrix3;
        let rest = rows(gram).map(|row| row.abs().element_sum());
        let weights = DVec3::from([0, 1, 2].map(|axis: usize| 2.0 * gram.col(axis)[axis] - rest[axis]));
        if weights.cmpgt(DVec3::splat(0.1 * gram.x_axis.x.min(gram.y_axis.y).min(gram.z_axis.z))).all() {
            return Some(Self { point: inverse.transform_point3(point), weights: weights * (1.0 - 1e-9), margin });
        }
        // Else the square of the least factor by which a length can shrink.
        let least = rows(inverse.matrix3 * inverse.matrix3.transpose()).map(|row| row.abs().element_sum());
        let least = (1.0 - 1e-9) / least.into_iter().fold(0.0, f64::max);
        Some(Self { point: inverse.transform_point3(point), weights: DVec3::splat(least), margin })
    }

    /// Squared distances in the world that no point of a group's boxes falls below; infinite or not a number for lanes
    /// without a box.
    fn distances(&self, group: &Group) -> [f64; WIDTH] {
        let mut sums = [0.0; WIDTH];
        for axis in 0..3 {
            let (at, weight) = (self.point[axis], self.weights[axis]);
            for (lane, sum) in sums.iter_mut().enumerate() {
                let below = f64::from(group.low[axis][lane]) - at;
                let above = at - f64::from(group.high[axis][lane]);
                let gap = (below.max(above) - self.margin).max(0.0);
                *sum += weight * gap * gap;
            }
        }
        sums
    }
}

/// A region in the numbers the kernel needs: image of the centre, image of the half extent, bounds with slack.
#[derive(Clone, Copy, Debug)]
struct Slabs {
    rows: [[f32; 4]; 3],
    low: [f32; 3],
    high: [f32; 3],
    around: Bounds,
}

impl Hierarchy {
    /// Sorts and groups `count` boxes, given by their index. Empty boxes are never found.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are 2³² boxes or more.
    pub fn build(context: &Context, count: usize, bounds: impl Fn(u32) -> Bounds + Sync) -> Result<Self> {
        if u32::try_from(count).is_err() {
            return Err(
                Error::invalid(format!("{count} boxes are too many for one hierarchy")).advise("split the mesh")
            );
        }
        let boxes = context.map(count.div_ceil(CHUNK), |chunk| {
            chunk_range(chunk, count).map(|index| bounds(index as u32)).collect::<Vec<_>>()
        });
        let boxes = boxes.concat();
        let whole = boxes.iter().fold(Bounds::EMPTY, |sum, bounds| sum.with(bounds));
        let scale: [f32; 3] = std::array::from_fn(|axis| 1023.0 / (whole.high[axis] - whole.low[axis]).max(1e-30));
        let mut keys: Vec<u64> = boxes
            .iter()
            .enumerate()
            .map(|(index, bounds)| {
                let code = (0..3).fold(0, |code, axis| {
                    let middle = 0.5 * bounds.low[axis] + 0.5 * bounds.high[axis];
                    // An empty box has no middle; the cast makes it 0.
                    code | spread(((middle - whole.low[axis]) * scale[axis]) as u32) << axis
                });
                u64::from(code) << 32 | index as u64
            })
            .collect();
        keys.sort_unstable();
        let order: Vec<u32> = keys.into_iter().map(|key| key as u32).collect();
        let mut levels = vec![vec![Group::EMPTY; count.div_ceil(WIDTH).max(1)]];
        while levels[levels.len() - 1].len() > 1 {
            let above = levels[levels.len() - 1].len().div_ceil(WIDTH);
            levels.push(vec![Group::EMPTY; above]);
        }
        let mut slots = vec![0; count];
        (0..).zip(&order).for_each(|(slot, item)| slots[*item as usize] = slot);
        let mut hierarchy = Self { order, slots, levels, bounds: Bounds::EMPTY };
        hierarchy.refit(context, |index| boxes[index as usize]);
        Ok(hierarchy)
    }

    /// Renews the boxes and keeps their grouping.
    pub fn refit(&mut self, context: &Context, bounds: impl Fn(u32) -> Bounds + Sync) {
        let order = &self.order;
        context.for_each_mut(&mut self.levels[0], |index, group| {
            for (lane, item) in order.iter().skip(index * WIDTH).take(WIDTH).enumerate() {
                group.set(lane, &bounds(*item));
            }
        });
        for level in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(level);
            let below = &below[level - 1];
            for (index, group) in above[0].iter_mut().enumerate() {
                for (lane, child) in below.iter().skip(index * WIDTH).take(WIDTH).enumerate() {
                    group.set(lane, &child.bounds());
                }
            }
        }
        self.bounds = self.levels[self.levels.len() - 1][0].bounds();
    }

    /// Takes the boxes of `other` in the place of its own.
    pub fn copy_from(&mut self, other: &Self) {
        self.order.clone_from(&other.order);
        self.slots.clone_from(&other.slots);
        self.levels.clone_from(&other.levels);
        self.bounds = other.bounds;
    }

    /// Renews some boxes and the boxes that hold them. Boxes that do not exist are left out.
    pub fn update(&mut self, context: &Context, boxes: &[(u32, Bounds)]) {
        let mut groups = context.scratch().lend::<Vec<usize>>();
        groups.clear();
        for (item, bounds) in boxes {
            let Some(slot) = self.slots.get(*item as usize).map(|slot| *slot as usize) else { continue };
            self.levels[0][slot / WIDTH].set(slot % WIDTH, bounds);
            groups.push(slot / WIDTH);
        }
        for level in 1..self.levels.len() {
            groups.sort_unstable();
            groups.dedup();
            let (below, above) = self.levels.split_at_mut(level);
            let below = &below[level - 1];
            for group in groups.iter_mut() {
                above[0][*group / WIDTH].set(*group % WIDTH, &below[*group].bounds());
                *group /= WIDTH;
            }
        }
        self.bounds = self.levels[self.levels.len() - 1][0].bounds();
    }

    /// The box of everything.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// How many boxes there are.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Bytes it occupies.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(level.as_slice())).sum::<usize>() + 2 * size_of_val(&self.order[..])
    }

    /// Appends the boxes that may reach into `region`, in the order of the curve. Boxes beyond a corner of the region
    /// may be among them; none that shares a point with it is missed.
    pub fn query(&self, context: &Context, region: &Region, found: &mut Vec<u32>) {
        if self.bounds.is_empty() {
            return;
        }
        let slabs = self.slabs(region);
        walk(context.level(), &self.levels, &self.order, &slabs, found);
    }

    /// Calls `visit` with the boxes that may come within a distance of `target`, the nearest box first. The distance is
    /// `within` at first, and then what the last visit returned: how near something was found.
    ///
    /// # Errors
    /// Fails with the first error of `visit`.
    pub fn approach(&self, target: &Target, within: f64, mut visit: impl FnMut(u32) -> Result<f64>) -> Result<()> {
        // Distances are not negative, so their bits are in their order. Level 0 are boxes, level k groups of k − 1.
        let mut waiting = BinaryHeap::from(WAITING.take());
        waiting.push(Reverse((0u64, self.levels.len(), 0usize)));
        let mut within = within * within;
        let mut done = Ok(());
        while let Some(Reverse((distance, level, index))) = waiting.pop() {
            if f64::from_bits(distance) > within {
                break;
            }
            if level == 0 {
                match visit(self.order[index]) {
                    Ok(found) => within = within.min(found * found),
                    Err(error) => {
                        done = Err(error);
                        break;
                    }
                }
                continue;
            }
            let distances = target.distances(&self.levels[level - 1][index]);
            for (lane, distance) in distances.into_iter().enumerate().filter(|(_, distance)| *distance <= within) {
                waiting.push(Reverse((distance.to_bits(), level - 1, index * WIDTH + lane)));
            }
        }
        waiting.clear();
        WAITING.set(waiting.into_vec());
        done
    }

    fn slabs(&self, region: &Region) -> Slabs {
        let matrix = region.map.matrix3.transpose();
        let mut slabs = Slabs { rows: [[0.0; 4]; 3], low: [0.0; 3], high: [0.0; 3], around: region.around };
        let reach = DVec3::from_array(std::array::from_fn(|axis| {
            f64::from(self.bounds.low[axis].abs().max(self.bounds.high[axis].abs()))
        }));
        for axis in 0..3 {
            let row = matrix.col(axis);
            let shift = region.map.translation[axis];
            slabs.rows[axis] = [row.x as f32, row.y as f32, row.z as f32, shift as f32];
            // Bounds the rounding of the kernel, so that nothing is missed.
            let slack = 16.0 * f64::from(f32::EPSILON) * (row.abs().dot(reach) + shift.abs());
            slabs.low[axis] = (region.low[axis] - slack) as f32;
            slabs.high[axis] = (region.high[axis] + slack) as f32;
        }
        slabs
    }
}

/// What waits to be looked at: the square of a distance as bits, a level, and an index there.
type Waiting = Vec<Reverse<(u64, usize, usize)>>;

thread_local! {
    /// Room for what waits.
    static WAITING: Cell<Waiting> = const { Cell::new(Vec::new()) };
}

/// Boxes made at a time by one thread.
const CHUNK: usize = 1024;

fn chunk_range(chunk: usize, count: usize) -> std::ops::Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(count)
}

/// The low ten bits, two zeros between any two.
fn spread(value: u32) -> u32 {
    let value = value.min(1023);
    let value = (value | value << 16) & 0x0300_00ff;
    let value = (value | value << 8) & 0x0300_f00f;
    let value = (value | value << 4) & 0x030c_30c3;
    (value | value << 2) & 0x0924_9249
}

dispatch_simd! {
    fn walk = walk_body(levels: &[Vec<Group>], order: &[u32], slabs: &Slabs, found: &mut Vec<u32>)
}

#[inline(always)]
fn walk_body<A: Arithmetic>(_: A, levels: &[Vec<Group>], order: &[u32], slabs: &Slabs, found: &mut Vec<u32>) {
    // Groups of 2³² boxes have eleven levels, each of which leaves at most seven groups waiting.
    let mut stack = [(0usize, 0usize); 11 * WIDTH];
    stack[0].0 = levels.len() - 1;
    let mut waiting = 1;
    while waiting > 0 {
        waiting -= 1;
        let (level, index) = stack[waiting];
        let mut hits = hits::<A>(&levels[level][index], slabs);
        if level == 0 {
            while hits != 0 {
                found.push(order[index * WIDTH + hits.trailing_zeros() as usize]);
                hits &= hits - 1;
            }
        } else {
            // The last child goes on the stack first, so that the first is visited first.
            while hits != 0 {
                let lane = 31 - hits.leading_zeros();
                stack[waiting] = (level - 1, index * WIDTH + lane as usize);
                waiting += 1;
                hits ^= 1 << lane;
            }
        }
    }
}

/// The lanes of `group` that may reach into the region, as bits.
#[inline(always)]
fn hits<A: Arithmetic>(group: &Group, slabs: &Slabs) -> u32 {
    let mut hit = [1u32; WIDTH];
    for axis in 0..3 {
        for lane in 0..WIDTH {
            let apart =
                group.low[axis][lane] > slabs.around.high[axis] || group.high[axis][lane] < slabs.around.low[axis];
            hit[lane] &= u32::from(!apart);
        }
    }
    for axis in 0..3 {
        let row = slabs.rows[axis];
        for lane in 0..WIDTH {
            let (mut middle, mut reach) = (row[3], 0.0);
            for (column, scale) in row[..3].iter().enumerate() {
                let (low, high) = (group.low[column][lane], group.high[column][lane]);
                middle = A::fma(*scale, 0.5 * low + 0.5 * high, middle);
                reach = A::fma(scale.abs(), 0.5 * high - 0.5 * low, reach);
            }
            // Lanes without a box are not a number here and compare as apart.
            hit[lane] &= u32::from(middle + reach >= slabs.low[axis] && middle - reach <= slabs.high[axis]);
        }
    }
    (0..WIDTH).fold(0, |bits, lane| bits | hit[lane] << lane)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;
    use proptest::prelude::*;

    fn random_boxes(count: usize, seed: u64) -> Vec<Bounds> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        (0..count)
            .map(|_| {
                let low = [next() * 10.0, next() * 10.0, next() * 2.0];
                Bounds { low, high: low.map(|value| value + 0.3 * next()) }
            })
            .collect()
    }

    /// Whether a point of `bounds`, tried on a lattice, is in the region.
    fn meets(bounds: &Bounds, map: &DAffine3, low: DVec3, high: DVec3) -> bool {
        (0..27).any(|index| {
            let place: [f64; 3] = std::array::from_fn(|axis| {
                let t = f64::from(index / 3i32.pow(axis as u32) % 3) / 2.0;
                f64::from(bounds.low[axis]) * (1.0 - t) + f64::from(bounds.high[axis]) * t
            });
            let image = map.transform_point3(DVec3::from(place));
            image.cmpge(low).all() && image.cmple(high).all()
        })
    }

    proptest! {
        #[test]
        fn nothing_in_the_region_is_missed_and_little_else_is_found(
            count in 0usize..700, seed in 0u64..1000, angle in prop::array::uniform3(-3.0f64..3.0),
            center in prop::array::uniform3(0.0f64..8.0), open in 0usize..3
        ) {
            let boxes = random_boxes(count, seed);
            let context = Context::serial();
            let hierarchy = Hierarchy::build(&context, count, |index| boxes[index as usize]).unwrap();
            let axes = DMat3::from_euler(glam::EulerRot::XYZ, angle[0], angle[1], angle[2]);
            let inverse = axes.transpose();
            let map = DAffine3 { matrix3: inverse, translation: -(inverse * DVec3::from(center)) };
            let low = DVec3::new(-1.0, -2.0, -0.5);
            let high = if open == 0 { DVec3::new(1.0, 2.0, f64::INFINITY) } else { DVec3::new(1.0, 2.0, 0.5) };
            let mut found = Vec::new();
            hierarchy.query(&context, &Region::new(map, low, high), &mut found);
            found.sort_unstable();
            let mut unique = found.clone();
            unique.dedup();
            prop_assert_eq!(&unique, &found);
            for (index, bounds) in boxes.iter().enumerate() {
                let listed = found.binary_search(&(index as u32)).is_ok();
                prop_assert!(listed || !meets(bounds, &map, low, high));
                let image = map.transform_point3(DVec3::from(bounds.low.map(f64::from)));
                let far = image.cmplt(low - 1.0).any() || image.cmpgt(high + 1.0).any();
                prop_assert!(!(listed && far));
            }
        }
    }

    #[test]
    fn refitting_finds_moved_boxes() {
        let mut boxes = random_boxes(1000, 3);
        let context = Context::serial();
        let mut hierarchy = Hierarchy::build(&context, boxes.len(), |index| boxes[index as usize]).unwrap();
        for bounds in &mut boxes {
            bounds.low[0] += 100.0;
            bounds.high[0] += 100.0;
        }
        hierarchy.refit(&context, |index| boxes[index as usize]);
        let mut found = Vec::new();
        let old = Region::new(DAffine3::IDENTITY, DVec3::ZERO, DVec3::splat(20.0));
        hierarchy.query(&context, &old, &mut found);
        assert!(found.is_empty());
        let new = Region::new(DAffine3::IDENTITY, DVec3::new(100.0, 0.0, 0.0), DVec3::new(120.0, 20.0, 20.0));
        hierarchy.query(&context, &new, &mut found);
        assert_eq!(found.len(), 1000);
    }

    #[test]
    fn updating_some_boxes_is_refitting_all() {
        let context = Context::serial();
        for count in [1usize, 8, 9, 500, 5000] {
            let mut boxes = random_boxes(count, 5);
            let mut hierarchy = Hierarchy::build(&context, count, |index| boxes[index as usize]).unwrap();
            for round in 0..10u32 {
                let some = (0..count as u32).filter(|item| item.wrapping_mul(2_654_435_761) >> 28 == round);
                let mut changed: Vec<(u32, Bounds)> = some.map(|item| (item, boxes[item as usize])).collect();
                for (item, bounds) in &mut changed {
                    bounds.high[round as usize % 3] += 2.0 * (*item % 5) as f32;
                    boxes[*item as usize] = *bounds;
                }
                changed.push((count as u32, Bounds::EMPTY));
                hierarchy.update(&context, &changed);
                let mut whole = hierarchy.clone();
                whole.refit(&context, |index| boxes[index as usize]);
                assert_eq!(hierarchy.bounds(), whole.bounds());
                for (a, b) in hierarchy.levels.iter().zip(&whole.levels) {
                    assert!(a.iter().zip(b).all(|(a, b)| (a.low, a.high) == (b.low, b.high)), "{count} {round}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn boxes_are_approached_in_the_order_of_distances_that_none_of_their_points_falls_below(
            count in 1usize..700, seed in 0u64..1000, angle in prop::array::uniform3(-3.0f64..3.0),
            scale in prop::array::uniform3(0.2f64..3.0), shear in -1.5f64..1.5, point in prop::array::uniform3(-20.0f64..20.0),
            near in 0usize..20
        ) {
            let boxes = random_boxes(count, seed);
            let context = Context::serial();
            let hierarchy = Hierarchy::build(&context, count, |index| boxes[index as usize]).unwrap();
            let turn = DMat3::from_euler(glam::EulerRot::XYZ, angle[0], angle[1], angle[2]);
            let mut matrix = turn * DMat3::from_diagonal(DVec3::from(scale));
            // Half of them are sheared, which no weights along the axes are exact for.
            matrix.x_axis += if seed % 2 == 0 { 0.0 } else { shear } * matrix.y_axis;
            let transform = DAffine3 { matrix3: matrix, translation: DVec3::new(1.0, 2.0, 3.0) };
            let (point, margin) = (DVec3::from(point), 0.25);
            let target = Target::new(&transform, point, margin).unwrap();
            // The least distance to a lattice of points of the box, and how far a box has been approached.
            let distance = |bounds: &Bounds| (0..27).map(|index| {
                let place: [f64; 3] = std::array::from_fn(|axis| {
                    let t = f64::from(index / 3i32.pow(axis as u32) % 3) / 2.0;
                    let (low, high) = (f64::from(bounds.low[axis]) - margin, f64::from(bounds.high[axis]) + margin);
                    low * (1.0 - t) + high * t
                });
                transform.transform_point3(DVec3::from(place)).distance(point)
            }).fold(f64::INFINITY, f64::min);
            let mut ordered: Vec<(f64, u32)> = boxes.iter().map(distance).zip(0..).collect();
            ordered.sort_by(|a, b| a.0.total_cmp(&b.0));
            // What is found at a distance stops the search there, and misses nothing before it.
            let limit = ordered[near.min(count - 1)].0;
            let mut visited = Vec::new();
            hierarchy.approach(&target, 1e9, |item| {
                visited.push(item);
                Ok(limit)
            }).unwrap();
            visited.sort_unstable();
            for (distance, item) in &ordered {
                prop_assert!(*distance > limit || visited.binary_search(item).is_ok());
            }
            visited.dedup();
            // Rotations and scales along the axes leave no more to look at than the boxes themselves ask for.
            if seed % 2 == 0 {
                let far = |item: &u32| {
                    let local = target.point;
                    let gaps = [0, 1, 2].map(|axis| {
                        let Bounds { low, high } = boxes[*item as usize];
                        let gap = (f64::from(low[axis]) - local[axis]).max(local[axis] - f64::from(high[axis])) - margin;
                        scale[axis] * gap.max(0.0)
                    });
                    DVec3::from(gaps).length() > 1.001 * limit + 1e-6
                };
                prop_assert!(visited.len() <= 1 || !visited.iter().any(far));
            }
        }
    }

    #[test]
    fn no_boxes_and_empty_boxes_are_never_found() {
        let context = Context::serial();
        let all = Region::new(DAffine3::IDENTITY, DVec3::NEG_INFINITY, DVec3::INFINITY);
        let mut found = Vec::new();
        Hierarchy::build(&context, 0, |_| Bounds::EMPTY).unwrap().query(&context, &all, &mut found);
        assert!(found.is_empty());
        let point = Bounds { low: [1.0; 3], high: [1.0; 3] };
        let some = Hierarchy::build(&context, 9, |index| if index % 2 == 0 { point } else { Bounds::EMPTY }).unwrap();
        some.query(&context, &all, &mut found);
        found.sort_unstable();
        assert_eq!(found, [0, 2, 4, 6, 8]);
    }
}
