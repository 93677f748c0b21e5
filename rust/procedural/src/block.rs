//! Blocks of a displaced surface for rays: up to 16 by 16 cells whose corners are whole numbers of 16 bits, and boxes
//! around every 4 by 4 of them.
//!
//! A corner is at (base + offset) · step from the origin. Steps are powers of two, one for all blocks, so that corners
//! come out exactly and blocks that share one have it at the same place. A ray is followed in a space in which it runs
//! along the third axis (Woop, Benthin and Wald 2013, Watertight Ray/Triangle Intersection): the edge that two triangles
//! share is then the same number with the other sign for both, so that no ray slips between them. What is stored is
//! about 10 bytes a cell, where triangles with a hierarchy take some 170. Units: object units.

use relievo_core::dispatch_simd;
use relievo_core::simd::Arithmetic;

use crate::square::Chart;

/// Cells along the side of a block at most.
pub(crate) const BLOCK: u32 = 16;
/// Cells along the side of a leaf.
pub(crate) const LEAF: u32 = 4;
/// Cells that one tile of any rate has at least along its side.
pub const MIN_RATE: u32 = LEAF;
/// The largest offset of a corner: 255 units of the boxes.
pub(crate) const MAX_OFFSET: i32 = 255 << 8;

/// A ray; its time runs from 0 to 1 over the interval of the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BlockRay {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes, of any length but zero.
    pub direction: [f32; 3],
    /// Distances from here on count, 0 or more, in multiples of the direction.
    pub near: f32,
    /// Distances up to here count.
    pub far: f32,
    /// Within the interval of the motion.
    pub time: f32,
}

/// Where a ray met a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BlockHit {
    /// In multiples of the direction.
    pub distance: f32,
    /// Parameters in the tile; of a triangle the barycentric coordinates of its second and third corner.
    pub uv: [f32; 2],
    /// Normal of the triangle, du × dv, of any length.
    pub normal: [f32; 3],
}

/// A block in one pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    /// Of the corners, in steps.
    pub base: [i32; 3],
    /// The largest offset along each axis.
    pub extent: [u16; 3],
    /// Steps of the numbers that boxes are stored in, as a power of two.
    pub shift: u8,
}

/// What a block is in all poses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Header {
    pub tile: u32,
    /// Its first cell in its square.
    pub column: u16,
    pub row: u16,
    /// Cells along the side of its square.
    pub rate: u16,
    /// Cells along its own side: 4, 8 or 16.
    pub edge: u8,
    /// Whether it lies on an edge that a coarser tile rules, where corners are on its chords but for rounding.
    pub is_seam: bool,
    /// How what is met lies in the tile.
    pub chart: Chart,
    /// Its first number among the corners of a pose, and its first number among the boxes.
    pub corners: u64,
    pub boxes: u64,
}

impl Header {
    /// Numbers of the corners, leaf by leaf: all x, all y, all z, row by row. Leaves keep their own, so that those of one
    /// are together.
    pub fn corner_numbers(edge: u32) -> usize {
        Self::leaves(edge) * LEAF_NUMBERS
    }

    /// Number of leaves.
    pub fn leaves(edge: u32) -> usize {
        ((edge / LEAF) * (edge / LEAF)) as usize
    }
}

/// What is stored of a block in one pose.
#[derive(Clone, Copy)]
pub(crate) struct Stored<'a> {
    pub pose: &'a Pose,
    /// x, y and z of the corners of every leaf, row by row, and [`LANES`] numbers more.
    pub corners: &'a [u16],
    /// The low x of the boxes of all leaves, their low y, and so on to their high z.
    pub boxes: &'a [u8],
}

/// A block at the beginning of the interval, and at its end if it moves.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub header: &'a Header,
    pub begin: Stored<'a>,
    pub end: Option<Stored<'a>>,
    pub step: f32,
}

/// Corners of a leaf along one side.
const SIDE: usize = LEAF as usize + 1;
/// Corners of a leaf.
pub(crate) const CORNERS: usize = SIDE * SIDE;
/// Numbers of the corners of a leaf.
const LEAF_NUMBERS: usize = 3 * CORNERS;
/// Numbers computed side by side: the corners of a leaf, and as many more as make vectors full.
pub(crate) const LANES: usize = 32;
/// Cells are numbered as their first corners; the last of them is 18.
const CELLS: usize = 24;
/// Which of them are cells.
const IS_CELL: u32 = 0b1111_01111_01111_01111;
/// By how much of a triangle's size rays may miss it where corners are on chords but for rounding.
const SEAM: f32 = 1.0 / 1024.0;
/// No distance; above the bits of all that are.
const MISS: u32 = u32::MAX;
/// Bits that the number of a leaf takes.
const LEAF_BITS: u32 = 15;

/// A ray and the space in which it runs along the third axis.
struct Sheared {
    origin: [f32; 3],
    /// Of the axes: x, y and z of that space.
    axes: [usize; 3],
    shear: [f32; 3],
    inverse: [f32; 3],
    near: f32,
    far: f32,
    time: f32,
}

impl Sheared {
    #[inline(always)]
    fn new(ray: &BlockRay, origin: [f32; 3], moves: bool) -> Self {
        let d = ray.direction;
        let [x, y, z] = [d[0].abs(), d[1].abs(), d[2].abs()];
        let third = if x > y && x > z {
            0
        } else if y > z {
            1
        } else {
            2
        };
        let axes = [(third + 1) % 3, (third + 2) % 3, third];
        let by = 1.0 / d[third];
        let mut inverse = [0.0; 3];
        for axis in 0..3 {
            // Never infinite, so that zero times it is zero.
            let least = if d[axis] < 0.0 { -1e-18 } else { 1e-18 };
            inverse[axis] = 1.0 / if d[axis].abs() < 1e-18 { least } else { d[axis] };
        }
        Self {
            origin: [ray.origin[0] - origin[0], ray.origin[1] - origin[1], ray.origin[2] - origin[2]],
            axes,
            shear: [d[axes[0]] * by, d[axes[1]] * by, by],
            inverse,
            near: ray.near.max(0.0),
            far: ray.far,
            time: if moves { ray.time.clamp(0.0, 1.0) } else { 0.0 },
        }
    }
}

/// One instruction each; the standard library's mind NaN, which does not occur here.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Where a ray enters the boxes of the leaves: the bits of the distance, rounded down to hold the number of the leaf in
/// the last four; [`MISS`] where it does not.
#[inline(always)]
fn enter<A: Arithmetic>(view: &View<'_>, ray: &Sheared, far: f32) -> [u32; 16] {
    let mut low = [[0.0; 16]; 3];
    let mut high = [[0.0; 16]; 3];
    unfold::<A>(&view.begin, view.step, &mut low, &mut high);
    if let Some(end) = &view.end {
        let mut next = [[[0.0; 16]; 3]; 2];
        let [next_low, next_high] = &mut next;
        unfold::<A>(end, view.step, next_low, next_high);
        for axis in 0..3 {
            for lane in 0..16 {
                low[axis][lane] += ray.time * (next_low[axis][lane] - low[axis][lane]);
                high[axis][lane] += ray.time * (next_high[axis][lane] - high[axis][lane]);
            }
        }
    }
    let mut near = [ray.near; 16];
    let mut last = [far; 16];
    for axis in 0..3 {
        let (origin, inverse) = (ray.origin[axis], ray.inverse[axis]);
        for lane in 0..16 {
            let a = (low[axis][lane] - origin) * inverse;
            let b = (high[axis][lane] - origin) * inverse;
            near[lane] = larger(near[lane], smaller(a, b));
            last[lane] = smaller(last[lane], larger(a, b));
        }
    }
    let leaves = (view.begin.boxes.len() / 6) as u32;
    let mut keys = [MISS; 16];
    for lane in 0..16 {
        // What rounding may have moved the ends by.
        let is_met = (near[lane] * (1.0 - 1e-6) <= last[lane] * (1.0 + 1e-6)) & ((lane as u32) < leaves);
        keys[lane] = near[lane].abs().to_bits() & !LEAF_BITS | lane as u32 | u32::from(is_met).wrapping_sub(1);
    }
    keys
}

/// The least of the keys that are not below `from`, [`MISS`] if there is none; by halves, as vectors are reduced.
#[inline(always)]
fn least_from(keys: &[u32; 16], from: u32) -> u32 {
    let mut left = keys.map(|key| if key < from { MISS } else { key });
    for half in [8, 4, 2, 1] {
        for lane in 0..half {
            left[lane] = left[lane].min(left[lane + half]);
        }
    }
    left[0]
}

/// The boxes of a pose; what lies beyond the last means nothing.
#[inline(always)]
fn unfold<A: Arithmetic>(stored: &Stored<'_>, step: f32, low: &mut [[f32; 16]; 3], high: &mut [[f32; 16]; 3]) {
    let unit = step * (1u32 << stored.pose.shift) as f32;
    let there = stored.boxes.len() / 6;
    let mut bytes = [[0u8; 16]; 6];
    for (row, numbers) in bytes.iter_mut().zip(stored.boxes.chunks_exact(there.max(1))) {
        match numbers.try_into() {
            Ok(full) => *row = full,
            Err(_) => row[..there].copy_from_slice(numbers),
        }
    }
    for axis in 0..3 {
        let base = stored.pose.base[axis] as f32 * step;
        for lane in 0..16 {
            low[axis][lane] = A::fma(f32::from(bytes[axis][lane]), unit, base);
            high[axis][lane] = A::fma(f32::from(bytes[axis + 3][lane]), unit, base);
        }
    }
}

/// The corners of a leaf along an axis; what lies beyond them means nothing.
#[inline(always)]
fn corners<A: Arithmetic>(stored: &Stored<'_>, axis: usize, leaf: usize, step: f32, out: &mut [f32; LANES]) {
    let first = leaf * LEAF_NUMBERS + axis * CORNERS;
    let offsets: &[u16; LANES] = match stored.corners[first..first + LANES].try_into() {
        Ok(offsets) => offsets,
        Err(_) => return,
    };
    let base = stored.pose.base[axis] as f32 * step;
    for lane in 0..LANES {
        // Exact, fused or not: whole numbers of steps below 2²⁴.
        out[lane] = A::fma(f32::from(offsets[lane]), step, base);
    }
}

/// What is nearest in a leaf so far.
#[derive(Clone, Copy)]
struct Nearest {
    distance: f32,
    leaf: usize,
    lane: usize,
    is_upper: bool,
    /// Twice those of the triangle's thirds, as the ray sees them.
    areas: [f32; 3],
}

/// Corners of a leaf in object space, from the origin.
type Points = [[f32; LANES]; 3];

#[inline(always)]
fn points<A: Arithmetic>(view: &View<'_>, leaf: usize, time: f32, out: &mut Points) {
    for axis in 0..3 {
        corners::<A>(&view.begin, axis, leaf, view.step, &mut out[axis]);
        if let Some(end) = &view.end {
            let mut next = [0.0; LANES];
            corners::<A>(end, axis, leaf, view.step, &mut next);
            for lane in 0..LANES {
                // At both ends exactly what is stored.
                out[axis][lane] = (1.0 - time) * out[axis][lane] + time * next[lane];
            }
        }
    }
}

/// Looks for a hit in a leaf that is nearer than `nearest`.
#[inline(always)]
fn meet<A: Arithmetic>(view: &View<'_>, leaf: usize, ray: &Sheared, nearest: &mut Nearest) -> bool {
    let mut p: Points = [[0.0; LANES]; 3];
    points::<A>(view, leaf, ray.time, &mut p);
    let [first, second, third] = ray.axes;
    let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let depth = p[third][lane] - ray.origin[third];
        x[lane] = A::fma(-ray.shear[0], depth, p[first][lane] - ray.origin[first]);
        y[lane] = A::fma(-ray.shear[1], depth, p[second][lane] - ray.origin[second]);
        z[lane] = ray.shear[2] * depth;
    }
    let area = |i: usize, j: usize| area(&x, &y, i, j);
    let (lower, upper) = if view.header.is_seam { inside::<true>(&x, &y) } else { inside::<false>(&x, &y) };
    let mut found = false;
    // Seldom more than one, so that what follows is not worth doing for all: those of the upper triangles after the lower.
    let mut met = u64::from(lower & IS_CELL) | u64::from(upper & IS_CELL) << 32;
    while met != 0 {
        let (lane, is_upper) = (met.trailing_zeros() as usize % 32, met.trailing_zeros() >= 32);
        met &= met - 1;
        let [i, j, k] = triangle(lane, is_upper);
        let areas = [area(j, k), area(k, i), area(i, j)];
        let whole = areas[0] + areas[1] + areas[2];
        let distance = A::fma(areas[0], z[i], A::fma(areas[1], z[j], areas[2] * z[k])) / whole;
        if whole != 0.0 && distance >= ray.near && distance < nearest.distance {
            *nearest = Nearest { distance, leaf, lane, is_upper, areas };
            found = true;
        }
    }
    found
}

/// The corners (0, 0), (1, 0), (0, 1) and (1, 1) of a cell.
#[inline(always)]
fn cell(lane: usize) -> [usize; 4] {
    [lane, lane + 1, lane + SIDE, lane + SIDE + 1]
}

/// The corners of one of the triangles of a cell.
#[inline(always)]
fn triangle(lane: usize, is_upper: bool) -> [usize; 3] {
    // Without a branch, since which it is cannot be foretold.
    let [second, third] = if is_upper { [SIDE + 1, SIDE] } else { [1, SIDE + 1] };
    [lane, lane + second, lane + third]
}

/// Twice the area of the ray with two corners; no fused arithmetic, so that edges are antisymmetric.
#[inline(always)]
fn area(x: &[f32; LANES], y: &[f32; LANES], i: usize, j: usize) -> f32 {
    x[j] * y[i] - y[j] * x[i]
}

/// The lower and the upper triangles that the ray meets, by the bits of their cells; at seams those too that it misses by
/// no more than [`SEAM`] of their size.
#[inline(always)]
fn inside<const IS_SEAM: bool>(x: &[f32; LANES], y: &[f32; LANES]) -> (u32, u32) {
    let area = |i: usize, j: usize| area(x, y, i, j);
    let is_inside = |[u, v, w]: [f32; 3]| {
        let beyond = if IS_SEAM { SEAM * (u + v + w).abs() } else { 0.0 };
        (u >= -beyond) & (v >= -beyond) & (w >= -beyond) | (u <= beyond) & (v <= beyond) & (w <= beyond)
    };
    let (mut lower, mut upper) = (0u32, 0u32);
    for lane in 0..CELLS {
        let [a, b, c, d] = cell(lane);
        let diagonal = area(d, a);
        lower |= u32::from(is_inside([area(b, d), diagonal, area(a, b)])) << lane;
        upper |= u32::from(is_inside([area(d, c), area(c, a), -diagonal])) << lane;
    }
    (lower, upper)
}

#[inline(always)]
fn intersect_body<A: Arithmetic>(
    _: A,
    view: &View<'_>,
    ray: &BlockRay,
    origin: [f32; 3],
    any: bool,
) -> Option<BlockHit> {
    let ray = Sheared::new(ray, origin, view.end.is_some());
    let keys = enter::<A>(view, &ray, ray.far);
    // Distances that equal the limit count.
    let limit = if ray.far < f32::INFINITY { ray.far.next_up() } else { ray.far };
    let mut nearest = Nearest { distance: limit, leaf: 0, lane: 0, is_upper: false, areas: [0.0; 3] };
    let mut found = false;
    // Leaves by where the ray enters them.
    let mut next = 0;
    loop {
        let least = least_from(&keys, next);
        if least == MISS || f32::from_bits(least & !LEAF_BITS) * (1.0 - 1e-6) > nearest.distance {
            break;
        }
        next = least + 1;
        found |= meet::<A>(view, (least & LEAF_BITS) as usize, &ray, &mut nearest);
        if found && any {
            return Some(BlockHit { distance: nearest.distance, ..BlockHit::default() });
        }
    }
    if found { Some(finish(view, ray.time, &nearest)) } else { None }
}

/// A corner of a leaf in object space, from the origin: the same as [`points`] has.
#[inline(always)]
fn point(view: &View<'_>, leaf: usize, time: f32, index: usize) -> [f32; 3] {
    let of = |stored: &Stored<'_>, axis: usize| {
        let offset = stored.corners[leaf * LEAF_NUMBERS + axis * CORNERS + index];
        (stored.pose.base[axis] + i32::from(offset)) as f32 * view.step
    };
    [0, 1, 2].map(|axis| {
        let begin = of(&view.begin, axis);
        view.end.as_ref().map_or(begin, |end| (1.0 - time) * begin + time * of(end, axis))
    })
}

/// Place and normal of the nearest hit.
#[inline(always)]
fn finish(view: &View<'_>, time: f32, nearest: &Nearest) -> BlockHit {
    let (header, lane) = (view.header, nearest.lane);
    let [i, j, k] = triangle(lane, nearest.is_upper).map(|index| point(view, nearest.leaf, time, index));
    let e = [0, 1, 2].map(|axis| j[axis] - i[axis]);
    let f = [0, 1, 2].map(|axis| k[axis] - i[axis]);
    let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    let whole = nearest.areas[0] + nearest.areas[1] + nearest.areas[2];
    let [second, third] = [nearest.areas[1] / whole, nearest.areas[2] / whole];
    let within = if nearest.is_upper { [second, second + third] } else { [second + third, third] };
    let leaves = usize::from(header.edge) / LEAF as usize;
    let cell = [
        usize::from(header.column) + LEAF as usize * (nearest.leaf % leaves) + lane % SIDE,
        usize::from(header.row) + LEAF as usize * (nearest.leaf / leaves) + lane / SIDE,
    ];
    let mut uv = [0.0; 2];
    for axis in 0..2 {
        uv[axis] = ((cell[axis] as f32 + within[axis]) / f32::from(header.rate)).clamp(0.0, 1.0);
    }
    BlockHit { distance: nearest.distance, uv, normal }
}

dispatch_simd! {
    /// The nearest hit of a ray, where `origin` is that of the blocks; any hit, without its place, if `any` will do.
    pub(crate) fn intersect = intersect_body(
        view: &View<'_>, ray: &BlockRay, origin: [f32; 3], any: bool
    ) -> Option<BlockHit>
}
