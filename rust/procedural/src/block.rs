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
const IS_CELL: [u32; CELLS] = {
    let mut lanes = [0; CELLS];
    let mut lane = 0;
    while lane < 4 * SIDE {
        lanes[lane] = if lane % SIDE < 4 { u32::MAX } else { 0 };
        lane += 1;
    }
    lanes
};
/// By how much of a triangle's size rays may miss it where corners are on chords but for rounding.
const SEAM: f32 = 1.0 / 1024.0;
/// No distance; above the bits of all that are.
const MISS: u32 = u32::MAX;

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

/// Where a ray enters the boxes of the leaves; infinity where it does not.
#[inline(always)]
fn enter<A: Arithmetic>(view: &View<'_>, ray: &Sheared, far: f32, out: &mut [f32; 16]) {
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
            near[lane] = near[lane].max(a.min(b));
            last[lane] = last[lane].min(a.max(b));
        }
    }
    for lane in 0..16 {
        // What rounding may have moved the ends by.
        let is_met = near[lane] * (1.0 - 1e-6) <= last[lane] * (1.0 + 1e-6);
        out[lane] = if is_met { near[lane] } else { f32::INFINITY };
    }
    let leaves = view.begin.boxes.len() / 6;
    out[leaves.min(16)..].fill(f32::INFINITY);
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
fn corners(stored: &Stored<'_>, axis: usize, leaf: usize, step: f32, out: &mut [f32; LANES]) {
    let first = leaf * LEAF_NUMBERS + axis * CORNERS;
    let offsets: &[u16; LANES] = match stored.corners[first..first + LANES].try_into() {
        Ok(offsets) => offsets,
        Err(_) => return,
    };
    let base = stored.pose.base[axis];
    for lane in 0..LANES {
        // Exact: both are below 2²⁴.
        out[lane] = (base + i32::from(offsets[lane])) as f32 * step;
    }
}

/// What is nearest in a leaf so far.
#[derive(Clone, Copy)]
struct Nearest {
    distance: f32,
    leaf: usize,
    lane: usize,
    upper: bool,
    weights: [f32; 3],
}

/// Corners of a leaf in object space, from the origin.
type Points = [[f32; LANES]; 3];

#[inline(always)]
fn points(view: &View<'_>, leaf: usize, time: f32, out: &mut Points) {
    for axis in 0..3 {
        corners(&view.begin, axis, leaf, view.step, &mut out[axis]);
        if let Some(end) = &view.end {
            let mut next = [0.0; LANES];
            corners(end, axis, leaf, view.step, &mut next);
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
    points(view, leaf, ray.time, &mut p);
    let [first, second, third] = ray.axes;
    let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let depth = p[third][lane] - ray.origin[third];
        x[lane] = (p[first][lane] - ray.origin[first]) - ray.shear[0] * depth;
        y[lane] = (p[second][lane] - ray.origin[second]) - ray.shear[1] * depth;
        z[lane] = ray.shear[2] * depth;
    }
    let slack = if view.header.is_seam { SEAM } else { 0.0 };
    let (mut lower, mut upper) = ([MISS; CELLS], [MISS; CELLS]);
    let (near, far) = (ray.near, nearest.distance);
    for lane in 0..CELLS {
        // The corners (0, 0), (1, 0), (0, 1) and (1, 1) of the cell.
        let [a, b, c, d] = [lane, lane + 1, lane + SIDE, lane + SIDE + 1];
        // Twice the areas with the ray; no fused arithmetic, so that edges are antisymmetric.
        let diagonal = x[a] * y[d] - y[a] * x[d];
        let (u1, v1, w1) = (x[d] * y[b] - y[d] * x[b], diagonal, x[b] * y[a] - y[b] * x[a]);
        let (u2, v2, w2) = (x[c] * y[d] - y[c] * x[d], x[a] * y[c] - y[a] * x[c], -diagonal);
        lower[lane] = IS_CELL[lane] & met::<A>([u1, v1, w1], [z[a], z[b], z[d]], slack, near, far) | !IS_CELL[lane];
        upper[lane] = IS_CELL[lane] & met::<A>([u2, v2, w2], [z[a], z[d], z[c]], slack, near, far) | !IS_CELL[lane];
    }
    let mut least = MISS;
    for lane in 0..CELLS {
        least = least.min(lower[lane]).min(upper[lane]);
    }
    if least == MISS {
        return false;
    }
    for lane in 0..CELLS {
        let is_upper = lower[lane] != least;
        if is_upper && upper[lane] != least {
            continue;
        }
        let [a, b, c, d] = [lane, lane + 1, lane + SIDE, lane + SIDE + 1];
        let [i, j, k] = if is_upper { [a, d, c] } else { [a, b, d] };
        let areas = [x[k] * y[j] - y[k] * x[j], x[i] * y[k] - y[i] * x[k], x[j] * y[i] - y[j] * x[i]];
        let whole = areas[0] + areas[1] + areas[2];
        *nearest = Nearest {
            distance: f32::from_bits(least),
            leaf,
            lane,
            upper: is_upper,
            weights: [areas[0] / whole, areas[1] / whole, areas[2] / whole],
        };
        return true;
    }
    false
}

/// The bits of the distance of a triangle, or [`MISS`].
#[inline(always)]
fn met<A: Arithmetic>([u, v, w]: [f32; 3], z: [f32; 3], slack: f32, near: f32, far: f32) -> u32 {
    let whole = u + v + w;
    let beyond = slack * whole.abs();
    let is_inside = (u >= -beyond) & (v >= -beyond) & (w >= -beyond) | (u <= beyond) & (v <= beyond) & (w <= beyond);
    let distance = A::fma(u, z[0], A::fma(v, z[1], w * z[2])) / whole;
    let is_hit = is_inside & (whole != 0.0) & (distance >= near) & (distance < far);
    if is_hit { distance.to_bits() } else { MISS }
}

#[inline(always)]
fn intersect_body<A: Arithmetic>(view: &View<'_>, ray: &BlockRay, origin: [f32; 3], any: bool) -> Option<BlockHit> {
    let ray = Sheared::new(ray, origin, view.end.is_some());
    let mut entries = [f32::INFINITY; 16];
    enter::<A>(view, &ray, ray.far, &mut entries);
    // Distances that equal the limit count.
    let limit = if ray.far < f32::INFINITY { ray.far.next_up() } else { ray.far };
    let mut nearest = Nearest { distance: limit, leaf: 0, lane: 0, upper: false, weights: [0.0; 3] };
    let mut found = false;
    loop {
        let (mut leaf, mut entry) = (16, f32::INFINITY);
        for (lane, value) in entries.iter().enumerate() {
            if *value < entry {
                (leaf, entry) = (lane, *value);
            }
        }
        if leaf == 16 || entry * (1.0 - 1e-6) > nearest.distance {
            break;
        }
        entries[leaf] = f32::INFINITY;
        found |= meet::<A>(view, leaf, &ray, &mut nearest);
        if found && any {
            return Some(BlockHit { distance: nearest.distance, ..BlockHit::default() });
        }
    }
    if !found {
        return None;
    }
    let mut p: Points = [[0.0; LANES]; 3];
    points(view, nearest.leaf, ray.time, &mut p);
    Some(finish(view.header, &nearest, &p))
}

/// Place and normal of the nearest hit.
#[inline(always)]
fn finish(header: &Header, nearest: &Nearest, p: &Points) -> BlockHit {
    let lane = nearest.lane;
    let [a, b, c, d] = [lane, lane + 1, lane + SIDE, lane + SIDE + 1];
    let [i, j, k] = if nearest.upper { [a, d, c] } else { [a, b, d] };
    let mut edges = [[0.0; 3]; 2];
    for axis in 0..3 {
        edges[0][axis] = p[axis][j] - p[axis][i];
        edges[1][axis] = p[axis][k] - p[axis][i];
    }
    let [e, f] = edges;
    let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    let [_, second, third] = nearest.weights;
    let within = if nearest.upper { [second, second + third] } else { [second + third, third] };
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
