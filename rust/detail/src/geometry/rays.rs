//! The rays of several coefficients at a time: as many as a vector has lanes, each in its own column of the voxels
//! (Schäfer et al. 2014, Section 6). Where a column is solid in one piece, a step needs its two ends only; rays that
//! meet another column are followed one by one, see [`crate::geometry::dda`], with the same arithmetic. There are no closures
//! here: they would be compiled without the instructions of the level.

use relievo_core::lanes::Lanes;

use crate::geometry::dda::{APART, Ray, WHOLE};
use crate::geometry::exits::Exits;
use crate::geometry::voxel::{Columns, PIECES};
use crate::geometry::voxel_frame::VoxelFrame;
use crate::imprint::dents::Limits;

/// Lanes of the widest vector.
const WIDEST: usize = 16;

/// Rays made ready. Places and directions are in voxel coordinates, distances in multiples of the direction.
pub(crate) struct Rays<A: Lanes> {
    place: [A::F; 3],
    direction: [A::F; 3],
    /// Beyond this distance nothing would change any more.
    limit: A::F,
    voxel: [A::I; 3],
    column: A::I,
    /// The ends of the column.
    ends: [A::I; 2],
    /// Rays that start in a solid voxel and may change something.
    solid: A::M,
    /// Rays that start in a column of several pieces, solid there or not.
    pieces: A::M,
    /// Rays that start in the clear voxel next to a column's end, where the surface may be further out than voxels are
    /// solid, and which of them start at upper ends.
    beside: A::M,
    over: A::M,
}

impl<A: Lanes> Rays<A> {
    /// The rays along −N from P + height · N, where `heights` are what the displacements are and what they were when
    /// the depth limit began to count.
    #[inline(always)]
    pub fn new(
        v: A,
        frame: &VoxelFrame,
        columns: &Columns<'_>,
        limits: &Limits,
        p: [A::F; 3],
        n: [A::F; 3],
        [height, start]: [A::F; 2],
    ) -> Self {
        let zero = v.splat(0.0);
        let [ox, oy, oz] = frame.origin;
        let from = [v.sub(p[0], v.splat(ox)), v.sub(p[1], v.splat(oy)), v.sub(p[2], v.splat(oz))];
        let mut inside = v.le(zero, zero);
        let mut still = inside;
        let mut place = from;
        let mut direction = from;
        for axis in 0..3 {
            let row = frame.rows[axis];
            let [a, b, c] = [v.splat(row[0]), v.splat(row[1]), v.splat(row[2])];
            let up = v.fused(a, n[0], v.fused(b, n[1], v.mul(c, n[2])));
            let base = v.splat(frame.shift[axis]);
            let foot = v.fused(a, from[0], v.fused(b, from[1], v.fused(c, from[2], base)));
            place[axis] = v.fused(height, up, foot);
            direction[axis] = v.sub(zero, up);
            let within = v.both(v.le(zero, place[axis]), v.lt(place[axis], v.splat(frame.dims[axis])));
            inside = v.both(inside, within);
            // A degenerate place of the surface has no normal.
            still = v.both(still, v.both(v.le(up, zero), v.le(zero, up)));
        }
        let room =
            v.min(v.add(height, v.splat(limits.max_displacement)), v.sub(v.splat(limits.depth), v.sub(start, height)));
        let limit = v.mul(room, v.splat(1.0 / limits.share));
        let able = v.without(v.both(inside, v.lt(zero, limit)), still);
        let voxel = [v.trunc(place[0]), v.trunc(place[1]), v.trunc(place[2])];
        let column = v.iadd(v.imul(voxel[1], v.isplat(columns.dims[0] as i32)), voxel[0]);
        let ends = v.gather(columns.spans, column);
        let (ends, pieces) = Self::ends(v, ends);
        let solid = v.both(able, Self::holds(v, ends, voxel[2]));
        let [low, high] = ends;
        let over = v.ieq(voxel[2], high);
        let beside = v.either(over, v.ieq(v.iadd(voxel[2], v.isplat(1)), low));
        // Columns without an end have none above the lowest voxel.
        let beside = v.both(able, v.without(beside, v.ieq(high, v.isplat(0))));
        Self { place, direction, limit, voxel, column, ends, solid, pieces: v.both(able, pieces), beside, over }
    }

    /// The ends of columns, and which are solid in several pieces.
    #[inline(always)]
    fn ends(v: A, span: A::I) -> ([A::I; 2], A::M) {
        let ends = [v.iand(span, v.isplat(0xffff)), v.high(span)];
        (ends, v.ieq(span, v.isplat(PIECES as i32)))
    }

    #[inline(always)]
    fn holds(v: A, [low, high]: [A::I; 2], z: A::I) -> A::M {
        v.without(v.ilt(z, high), v.ilt(z, low))
    }

    /// How far each ray goes until it leaves the surface that was voxelised, see [`crate::geometry::exits`], or reaches its
    /// limit, 0 where it starts outside; and how many were held at the border of the grid.
    #[inline(always)]
    pub fn distances(&self, v: A, columns: &Columns<'_>) -> (A::F, u32) {
        let (zero, none, unit) = (v.splat(0.0), v.isplat(0), v.isplat(1));
        if v.mask(v.either(self.beside, v.either(self.solid, self.pieces))) == 0 {
            return (zero, 0);
        }
        let all = v.le(zero, zero);
        let one = v.splat(1.0);
        let mut inverse = [zero; 3];
        let mut next = [zero; 3];
        let mut ahead = [all; 3];
        let mut behind = [all; 3];
        for axis in 0..3 {
            let direction = self.direction[axis];
            inverse[axis] = v.div(one, direction);
            ahead[axis] = v.lt(zero, direction);
            behind[axis] = v.lt(direction, zero);
            let face = v.float(v.iadd(self.voxel[axis], v.iselect(ahead[axis], unit, none)));
            let distance = v.mul(v.sub(face, self.place[axis]), inverse[axis]);
            // Without motion there is no next face.
            next[axis] = v.select(v.either(ahead[axis], behind[axis]), distance, v.splat(f32::INFINITY));
        }
        let nearest = v.min(v.min(next[0], next[1]), next[2]);
        let [nx, ny, nz] = [columns.dims[0] as i32, columns.dims[1] as i32, columns.dims[2] as i32];
        let mut delta = [zero; 2];
        let mut steps = [none; 2];
        // Columns that are left along x and y before the grid ends.
        let mut left = [none; 2];
        for (axis, count, step) in [(0, nx, 1), (1, ny, nx)] {
            delta[axis] = v.select(ahead[axis], inverse[axis], v.sub(zero, inverse[axis]));
            steps[axis] = v.iselect(ahead[axis], v.isplat(step), v.isplat(-step));
            let rest = v.isub(v.isplat(count - 1), self.voxel[axis]);
            left[axis] = v.iselect(ahead[axis], rest, self.voxel[axis]);
        }
        let (down, up) = (behind[2], ahead[2]);
        let mut z = self.voxel[2];
        let (mut column, mut ends) = (self.column, self.ends);
        let mut active = self.solid;
        let mut pieces = self.pieces;
        let (mut far, mut grid) = (zero, v.without(all, all));
        let (mut gap, mut upper) = (zero, v.either(v.without(up, self.beside), v.both(self.beside, self.over)));
        while v.mask(active) != 0 {
            let by_y = v.le(next[1], next[0]);
            let side = v.select(by_y, next[1], next[0]);
            // The voxel in which the ray leaves the column, or reaches the limit; −1 below it and `nz` above it.
            let height = v.add(self.place[2], v.mul(v.min(side, self.limit), self.direction[2]));
            let height = v.min(v.max(height, v.splat(-1.0)), v.splat(nz as f32));
            let whole = v.bits(v.add(v.sub(height, v.splat(0.5)), v.splat(WHOLE)));
            let end = v.isub(whole, v.isplat(WHOLE.to_bits() as i32));
            z = v.iselect(down, v.imin(end, z), v.iselect(up, v.imax(end, z), z));
            let [low, high] = ends;
            let clear = v.both(active, v.either(v.both(down, v.ilt(z, low)), v.without(up, v.ilt(z, high))));
            let bound = v.float(v.iselect(down, low, high));
            far = v.select(clear, v.mul(v.sub(bound, self.place[2]), inverse[2]), far);
            let outer = v.either(v.both(down, v.ieq(low, none)), v.both(up, v.ieq(high, v.isplat(nz))));
            let outer = v.both(clear, outer);
            if v.mask(outer) != 0 {
                grid = v.either(grid, v.without(outer, Self::known(v, columns, column, [low, high], outer, up)));
            }
            active = v.without(active, clear);
            // Not a number ends here as well.
            let rest = v.iselect(by_y, left[1], left[0]);
            let border = v.either(v.without(active, v.lt(side, self.limit)), v.both(active, v.ieq(rest, none)));
            far = v.select(border, side, far);
            grid = v.either(grid, border);
            active = v.without(active, border);
            for axis in 0..2 {
                let here = if axis == 1 { by_y } else { v.without(all, by_y) };
                left[axis] = v.isub(left[axis], v.iselect(here, unit, none));
                next[axis] = v.select(here, v.add(next[axis], delta[axis]), next[axis]);
            }
            column = v.iadd(column, v.iselect(by_y, steps[1], steps[0]));
            let entered = Self::ends(v, v.gather(columns.spans, column));
            ends = entered.0;
            pieces = v.either(pieces, v.both(active, entered.1));
            active = v.without(active, entered.1);
            far = v.select(active, side, far);
            let leaves = v.without(active, Self::holds(v, ends, z));
            if v.mask(leaves) != 0 {
                let [low, high] = ends;
                let over = v.without(leaves, v.ilt(z, high));
                let end = v.float(v.iselect(over, high, low));
                let rest = v.sub(end, v.fused(side, self.direction[2], self.place[2]));
                let rest = v.max(rest, v.sub(zero, rest));
                // A column that is clear has no end.
                let rest = v.select(v.ieq(high, none), v.splat(APART), rest);
                gap = v.select(leaves, rest, gap);
                upper = v.either(v.without(upper, leaves), over);
                active = v.without(active, leaves);
            }
        }
        if v.mask(pieces) != 0 {
            (far, gap, grid, upper) = self.singly(v, columns, pieces, [far, gap], [grid, upper]);
        }
        let left = v.both(v.either(self.solid, pieces), v.lt(far, self.limit));
        // At the border of the grid, leaving in the first step changes nothing.
        let goes = v.both(v.either(self.solid, pieces), v.lt(nearest, far));
        let mut distance = v.select(goes, far, zero);
        let open = v.either(v.without(left, grid), self.beside);
        if v.mask(open) != 0 {
            let Self { place, direction, .. } = *self;
            let exact = Exits { place, direction, far, gap, upper, open }.refined(v, columns);
            distance = v.select(open, exact, distance);
        }
        let distance = v.select(v.lt(distance, self.limit), distance, self.limit);
        (distance, v.mask(v.both(v.both(goes, left), grid)).count_ones())
    }

    /// Of `lanes`, whose rays reach ends of columns at the border of the grid, those where the solid ends there. Upper ends are
    /// those of `upper`.
    #[inline(always)]
    fn known(v: A, columns: &Columns<'_>, column: A::I, [low, high]: [A::I; 2], lanes: A::M, upper: A::M) -> A::M {
        let (mut places, mut ends, mut known) = ([0; WIDEST], [0; WIDEST], [0.0; WIDEST]);
        v.istore(column, &mut places);
        v.istore(v.iselect(upper, high, low), &mut ends);
        for lane in (0..A::WIDTH).filter(|lane| v.mask(lanes) >> lane & 1 != 0) {
            let upper = v.mask(upper) >> lane & 1 != 0;
            known[lane] = f32::from(columns.knows(places[lane] as usize, ends[lane] as i32, upper));
        }
        v.both(lanes, v.lt(v.splat(0.0), v.load(&known)))
    }

    /// Follows the rays of `lanes` one by one. Returns how far they go and the gaps of their ends, and which leave the grid
    /// and which leave at upper ends.
    #[inline(always)]
    fn singly(
        &self,
        v: A,
        columns: &Columns<'_>,
        lanes: A::M,
        [far, gap]: [A::F; 2],
        [grid, upper]: [A::M; 2],
    ) -> (A::F, A::F, A::M, A::M) {
        let mut values = [[0.0; WIDEST]; 9];
        let [px, py, pz] = self.place;
        let [dx, dy, dz] = self.direction;
        for (value, to) in [px, py, pz, dx, dy, dz, self.limit, far, gap].into_iter().zip(&mut values) {
            v.store(value, to);
        }
        let [px, py, pz, dx, dy, dz, limit, mut far, mut gap] = values;
        let (mut grids, mut uppers) = ([0.0; WIDEST], [0.0; WIDEST]);
        for lane in (0..A::WIDTH).filter(|lane| v.mask(lanes) >> lane & 1 != 0) {
            let ray = Ray::new([px[lane], py[lane], pz[lane]], [dx[lane], dy[lane], dz[lane]]);
            let [x, y, z] = ray.start.map(|value| value as u32);
            far[lane] = 0.0;
            if columns.solid((y * columns.dims[0] + x) as usize, z) {
                let left = ray.traverse(columns, pz[lane], dz[lane], limit[lane]);
                (far[lane], gap[lane]) = (left.far, left.gap);
                (grids[lane], uppers[lane]) = (f32::from(left.grid), f32::from(left.upper));
            }
        }
        let zero = v.splat(0.0);
        let grids = v.both(lanes, v.lt(zero, v.load(&grids)));
        let uppers = v.both(lanes, v.lt(zero, v.load(&uppers)));
        let (grid, upper) = (v.either(v.without(grid, lanes), grids), v.either(v.without(upper, lanes), uppers));
        (v.load(&far), v.load(&gap), grid, upper)
    }
}
