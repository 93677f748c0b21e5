//! Where rays leave the surface that was voxelised, which is within about half a voxel of where they leave the voxels:
//! between the exact heights of the columns around. Rounded ends would leave terraces, on slopes as flat as those of most
//! imprints tens of coefficients wide, which no smoothing of the coefficients takes away without softening the imprint.

use relievo_core::lanes::Lanes;

use crate::geometry::scanline::{FINE, height_stride};
use crate::geometry::voxel::Columns;

/// Squares of cosines between a ray and the surface's normal, in voxels: up to the first nothing is refined, from the second
/// on all is. Along a ray that grazes the surface the distance to it says nothing.
const GRAZING: [f32; 2] = [0.02, 0.1];

/// Voxels up to which a ray goes nowhere: objects at rest would dig into each other by what interpolation is off. Nor would
/// what is smoothed around changes be the same everywhere, if some were as small as a rounding.
const RESTING: f32 = 1.0 / 32.0;

/// Rays that leave the voxels. Places and directions are in voxel coordinates, distances in multiples of the direction.
pub(crate) struct Exits<A: Lanes> {
    /// Where the rays start, and their directions.
    pub place: [A::F; 3],
    pub direction: [A::F; 3],
    /// Distances at which they leave.
    pub far: A::F,
    /// Voxels along the column from there to the rounded end of the column that is entered; none where the ray leaves a
    /// column at its end.
    pub gap: A::F,
    /// Rays that leave at the upper ends of columns. Others leave at the lower ones.
    pub upper: A::M,
    /// Rays that leave the solid within the grid.
    pub open: A::M,
}

impl<A: Lanes> Exits<A> {
    /// The distances at which the rays leave the bilinear surface through the ends of columns. Where the surface is too
    /// steep to be followed from column to column, or the ray grazes it, they pass into those at which the voxels are left,
    /// of which a voxel's length is rounding and goes nowhere.
    #[inline(always)]
    pub fn refined(&self, v: A, columns: &Columns<'_>) -> A::F {
        let Self { place, direction, far, gap, upper, open } = *self;
        let (zero, one, half) = (v.splat(0.0), v.splat(1.0), v.splat(0.5));
        let (none, unit) = (v.isplat(0), v.isplat(1));
        let [nx, ny] = [columns.dims[0] as i32, columns.dims[1] as i32];
        let stride = height_stride(columns.dims[0] as usize) as i32;
        // The column before the place along each axis, and how far it is to the next. Beyond the last centres all stays.
        let (mut cell, mut part) = ([none; 2], [zero; 2]);
        for (axis, count) in [(0, nx), (1, ny)] {
            let at = v.sub(v.fused(far, direction[axis], place[axis]), half);
            let at = v.min(v.max(at, zero), v.splat((count - 1) as f32));
            cell[axis] = v.imin(v.trunc(at), v.isplat((count - 2).max(0)));
            part[axis] = v.sub(at, v.float(cell[axis]));
        }
        // Upper ends are lower ones of the columns turned over, and so are their heights.
        let sign = v.select(upper, v.splat(-1.0), one);
        let z = v.mul(sign, v.sub(v.fused(far, direction[2], place[2]), half));
        let level = v.trunc(v.mul(z, v.splat(FINE as f32)));
        let row = v.iadd(v.iadd(cell[1], cell[1]), v.iselect(upper, unit, none));
        let first = v.iadd(v.imul(row, v.isplat(stride)), cell[0]);
        let (right, below) = (i32::from(nx > 1), if ny > 1 { 2 * stride } else { 0 });
        let rest = [v.sub(one, part[0]), v.sub(one, part[1])];
        let shares =
            [v.mul(rest[0], rest[1]), v.mul(part[0], rest[1]), v.mul(rest[0], part[1]), v.mul(part[0], part[1])];
        // Heights above the place, and how far they count.
        let (mut above, mut count) = ([zero; 4], [zero; 4]);
        let (mut sum, mut all) = (zero, zero);
        for (k, offset) in [0, right, below, below + right].into_iter().enumerate() {
            let height = v.gather(columns.heights, v.iadd(first, v.isplat(offset)));
            above[k] = v.mul(v.float(v.isub(height, level)), v.splat(1.0 / FINE as f32));
            count[k] = fading(v, above[k], v.splat(-1.0 / columns.steep));
            let share = v.mul(shares[k], count[k]);
            all = v.add(all, share);
            sum = v.fused(share, above[k], sum);
        }
        let mean = v.div(sum, v.max(all, v.splat(1e-6)));
        let mut corner = above;
        for k in 0..4 {
            corner[k] = v.fused(count[k], v.sub(above[k], mean), mean);
        }
        let [a, b, c, d] = corner;
        let slope_x = v.fused(v.sub(d, c), part[1], v.mul(v.sub(b, a), rest[1]));
        let slope_y = v.fused(v.sub(d, b), part[0], v.mul(v.sub(c, a), rest[0]));
        let [dx, dy, dz] = direction;
        // By how much the ray falls against the surface: out of the solid where that is negative.
        let across = v.fused(slope_x, dx, v.mul(slope_y, dy));
        let rate = v.sub(v.mul(sign, dz), across);
        let leaves = v.both(open, v.lt(rate, zero));
        let rate = v.select(leaves, rate, v.splat(-1.0));
        let square = v.fused(dx, dx, v.fused(dy, dy, v.mul(dz, dz)));
        let normal = v.fused(slope_x, slope_x, v.fused(slope_y, slope_y, one));
        let facing = v.div(v.mul(rate, rate), v.mul(square, normal));
        let [least, most] = GRAZING;
        let facing = v.fused(facing, v.splat(1.0 / (most - least)), v.splat(-least / (most - least)));
        let facing = v.min(v.max(facing, zero), one);
        // The surface is as near as rounding and its slopes say, or it is another one.
        let size = v.add(one, v.add(magnitude(v, slope_x), magnitude(v, slope_y)));
        let near = fading(v, v.div(mean, size), v.splat(-1.0));
        let joined = fading(v, gap, v.splat(-1.0 / columns.steep));
        let weight = v.select(leaves, v.mul(facing, v.mul(near, joined)), zero);
        // Of voxels alone, a voxel's length is rounding, which must not come and go at once.
        let share = v.fused(v.mul(v.mul(far, far), square), v.splat(1.0 / 3.0), v.splat(-1.0 / 3.0));
        let voxels = v.mul(far, v.min(v.max(share, zero), one));
        let exact = v.sub(v.add(far, v.div(mean, rate)), voxels);
        let moved = v.max(v.fused(weight, exact, voxels), zero);
        let rests = v.lt(v.mul(v.mul(moved, moved), square), v.splat(RESTING * RESTING));
        v.select(rests, zero, moved)
    }
}

#[inline(always)]
fn magnitude<A: Lanes>(v: A, value: A::F) -> A::F {
    v.max(value, v.sub(v.splat(0.0), value))
}

/// 1 up to a size, none from its double on, and linear between. `scale` is one by the size, negated.
#[inline(always)]
fn fading<A: Lanes>(v: A, value: A::F, scale: A::F) -> A::F {
    let left = v.fused(magnitude(v, value), scale, v.splat(2.0));
    v.min(v.max(left, v.splat(0.0)), v.splat(1.0))
}
