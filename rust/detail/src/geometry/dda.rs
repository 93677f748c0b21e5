//! Rays through the solid voxels (Schäfer et al. 2014, Section 6), with the traversal of Amanatides and Woo 1987, A
//! Fast Voxel Traversal Algorithm for Ray Tracing. Places are in voxel coordinates.

use crate::geometry::voxel::{Columns, PIECES, Voxels};

/// How a ray that starts in the voxels leaves them. Distances are in multiples of the ray's direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exit {
    /// It does not start in a solid voxel.
    Outside,
    /// Its first step leaves the solid: the start counts as on the border.
    Border,
    /// It enters a clear voxel at this distance.
    Clear(f32),
    /// It leaves the grid at this distance and was in the solid until then.
    Grid(f32),
    /// It is still in the solid at the limit.
    Limit,
}

impl Voxels {
    /// Whether a place lies in a solid voxel.
    #[inline]
    pub fn contains(&self, place: [f32; 3]) -> bool {
        // The comparison also refuses what is not a number.
        let dims = self.grid().dims;
        let inside = (0..3).all(|axis| place[axis] >= 0.0 && place[axis] < dims[axis] as f32);
        inside && self.get(place.map(|value| value as u32))
    }

    /// Follows the ray from `origin` along `direction` until it leaves the solid, but not beyond `limit`.
    ///
    /// Within a column the run of solid bits is skipped at once, so rays along the columns are cheap.
    pub fn exit(&self, origin: [f32; 3], direction: [f32; 3], limit: f32) -> Exit {
        if !self.contains(origin) {
            return Exit::Outside;
        }
        let ray = Ray::new(origin, direction);
        match ray.traverse(&self.columns(), origin[2], direction[2], limit) {
            Left { far, .. } if !(far < limit) => Exit::Limit,
            Left { far, .. } if far <= ray.nearest => Exit::Border,
            Left { far, grid: true, .. } => Exit::Grid(far),
            Left { far, .. } => Exit::Clear(far),
        }
    }
}

/// How a ray left the solid, see [`crate::geometry::exits`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Left {
    /// The distance at which it did, or at least the limit where it did not do so before.
    pub far: f32,
    /// Whether it left the grid there.
    pub grid: bool,
    /// Voxels along the column from there to the rounded end of the column that is entered.
    pub gap: f32,
    /// Whether it left at the upper end of a column.
    pub upper: bool,
}

/// Voxels to a column that has no end there.
pub(crate) const APART: f32 = 1e9;

/// A ray made ready: its voxel, and per axis the reciprocal of its direction and the distance to the next face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub start: [i32; 3],
    pub inverse: [f32; 3],
    pub next: [f32; 3],
    /// The distance at which it leaves its first voxel.
    pub nearest: f32,
}

impl Ray {
    #[inline(always)]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let start = origin.map(|value| value as i32);
        let inverse = direction.map(|value| 1.0 / value);
        let next: [f32; 3] = std::array::from_fn(|axis| {
            let face = (start[axis] + i32::from(direction[axis] > 0.0)) as f32;
            // Without motion there is no next face.
            if direction[axis] == 0.0 { f32::INFINITY } else { (face - origin[axis]) * inverse[axis] }
        });
        Self { start, inverse, next, nearest: next[0].min(next[1]).min(next[2]) }
    }

    /// Follows the ray until it leaves the solid, or to `limit`.
    #[inline(always)]
    pub fn traverse(&self, columns: &Columns<'_>, z0: f32, dz: f32, limit: f32) -> Left {
        let dims = columns.dims.map(|count| count as i32);
        let [x, y, mut z] = self.start;
        let forward = [self.inverse[0] > 0.0, self.inverse[1] > 0.0];
        let mut next = [self.next[0], self.next[1]];
        let delta = [self.inverse[0].abs(), self.inverse[1].abs()];
        let step = [if forward[0] { 1 } else { -1 }, if forward[1] { dims[0] } else { -dims[0] }];
        // Columns that are left along x and y before the grid ends.
        let mut left = [if forward[0] { dims[0] - 1 - x } else { x }, if forward[1] { dims[1] - 1 - y } else { y }];
        let mut column = y * dims[0] + x;
        loop {
            let axis = usize::from(next[1] <= next[0]);
            let side = next[axis];
            // The voxel in which the ray leaves the column, or reaches the limit.
            let end = floor(z0 + side.min(limit) * dz, dims[2]);
            let [low, high] = columns.piece(column as usize, z as u32).map(|end| end as i32);
            if dz < 0.0 {
                z = end.min(z);
                if low > z {
                    return self.end(columns, column, low, z0, false);
                }
            } else if dz > 0.0 {
                z = end.max(z);
                if high <= z {
                    return self.end(columns, column, high, z0, true);
                }
            }
            // Not a number ends here as well.
            if !(side < limit) || left[axis] == 0 {
                return Left { far: side, grid: true, gap: APART, upper: false };
            }
            left[axis] -= 1;
            next[axis] += delta[axis];
            column += step[axis];
            if !columns.solid(column as usize, z as u32) {
                let (gap, upper) = columns.side_gap(column as usize, z, z0 + side * dz);
                return Left { far: side, grid: false, gap, upper };
            }
        }
    }
}

impl Ray {
    /// The ray, which is at `z0`, leaves a piece of a column at its end.
    #[inline(always)]
    fn end(&self, columns: &Columns<'_>, column: i32, end: i32, z0: f32, upper: bool) -> Left {
        let known = columns.knows(column as usize, end, upper);
        let border = if upper { columns.dims[2] as i32 } else { 0 };
        let gap = if !known && columns.spans[column as usize] == PIECES { APART } else { 0.0 };
        Left { far: (end as f32 - z0) * self.inverse[2], grid: end == border && !known, gap, upper }
    }
}

/// At 1.5 · 2²³ floats are whole numbers, which are in the low bits.
pub(crate) const WHOLE: f32 = 12_582_912.0;

/// The voxel of a place in a column, −1 below it and `nz` above it. A place between two voxels may count as either.
#[inline(always)]
fn floor(value: f32, nz: i32) -> i32 {
    let clamped = value.max(-1.0).min(nz as f32) - 0.5;
    ((clamped + WHOLE).to_bits() as i32).wrapping_sub(WHOLE.to_bits() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::grid::Grid;
    use crate::geometry::obb::Obb;
    use crate::geometry::voxel::{Side, Solid};
    use crate::object::shapes::{self, Soup};
    use glam::{DAffine3, DMat3, DVec3, Vec3};
    use proptest::prelude::*;
    use relievo_core::Context;

    fn blob() -> Voxels {
        let obb = Obb {
            center: DVec3::new(0.3, 0.0, 0.0),
            axes: DMat3::from_rotation_x(0.3),
            half: DVec3::new(1.2, 0.9, 0.4),
        };
        filled(&shapes::torus(1.0, 0.4, 48, 24), &Grid::new(&obb, 1 << 16, None))
    }

    fn filled((points, triangles): &Soup, grid: &Grid) -> Voxels {
        let solid = Solid { points, triangles, transform: DAffine3::IDENTITY, closed: true, lattice: None };
        let mut voxels = Voxels::default();
        voxels.fill(&Context::serial(), grid, &solid, None, Side::Forward).unwrap();
        voxels
    }

    /// The traversal as Amanatides and Woo give it, voxel by voxel, in f64.
    fn walk(voxels: &Voxels, origin: Vec3, direction: Vec3) -> (u32, f64) {
        let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
        let mut voxel = origin.floor().as_ivec3();
        let mut steps = 0;
        loop {
            let next = |axis: usize| match direction[axis] {
                d if d > 0.0 => (f64::from(voxel[axis] + 1) - origin[axis]) / d,
                d if d < 0.0 => (f64::from(voxel[axis]) - origin[axis]) / d,
                _ => f64::INFINITY,
            };
            let distances = [next(0), next(1), next(2)];
            let axis = (0..3).min_by(|a, b| distances[*a].total_cmp(&distances[*b])).unwrap();
            voxel[axis] += direction[axis].signum() as i32;
            steps += 1;
            if voxel.min_element() < 0 || !voxels.get(voxel.as_uvec3().to_array()) {
                return (steps, distances[axis]);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 1000, max_global_rejects: 20_000, ..ProptestConfig::default() })]
        #[test]
        fn skipping_runs_is_the_walk_voxel_by_voxel(
            place in prop::array::uniform3(0.0f32..1.0), direction in prop::array::uniform3(-1.0f32..1.0), flat in 0usize..5
        ) {
            let voxels = cached();
            let dims = Vec3::from(voxels.grid().dims.map(|n| n as f32));
            let origin = Vec3::from(place) * dims;
            let mut direction = Vec3::from(direction);
            if flat < 3 {
                direction[flat] *= 0.01;
            }
            prop_assume!(direction.length() > 0.1 && voxels.contains(origin.to_array()));
            let (steps, distance) = walk(voxels, origin, direction);
            match voxels.exit(origin.to_array(), direction.to_array(), f32::INFINITY) {
                Exit::Border => prop_assert_eq!(steps, 1),
                // Rounding may decide otherwise where a ray passes an edge of voxels; few do.
                Exit::Clear(t) | Exit::Grid(t) => prop_assert!((f64::from(t) - distance).abs() <= 1e-4 * distance.max(1.0), "{t} {distance}"),
                other => prop_assert!(false, "{other:?}"),
            }
        }
    }

    fn cached() -> &'static Voxels {
        static VOXELS: std::sync::OnceLock<Voxels> = std::sync::OnceLock::new();
        VOXELS.get_or_init(blob)
    }

    /// Distance at which the ray leaves the solid, by small steps: a lower and an upper bound.
    fn march(voxels: &Voxels, origin: Vec3, direction: Vec3, step: f32) -> (f32, f32) {
        let mut at = 0;
        while voxels.contains((origin + direction * (at as f32 * step)).to_array()) {
            at += 1;
        }
        ((at - 1).max(0) as f32 * step, at as f32 * step)
    }

    proptest! {
        #[test]
        fn rays_leave_where_small_steps_do(
            place in prop::array::uniform3(0.0f32..1.0), direction in prop::array::uniform3(-1.0f32..1.0), flat in 0usize..4
        ) {
            let voxels = cached();
            let dims = Vec3::from(voxels.grid().dims.map(|n| n as f32));
            let origin = Vec3::from(place) * dims;
            let mut direction = Vec3::from(direction);
            if flat < 3 {
                direction[flat] = 0.0;
            }
            prop_assume!(direction.length() > 0.1);
            let step = 2e-3 / direction.length();
            let (low, high) = march(voxels, origin, direction, step);
            match voxels.exit(origin.to_array(), direction.to_array(), f32::INFINITY) {
                Exit::Outside => prop_assert!(!voxels.contains(origin.to_array())),
                Exit::Border => prop_assert!(low <= 3f32.sqrt() / direction.abs().max_element() + step),
                // Small steps may jump over a corner that the ray cuts by less than a step.
                Exit::Clear(t) | Exit::Grid(t) => prop_assert!(t <= high + 2.0 * step, "{t} after {low}..{high}"),
                Exit::Limit => prop_assert!(false),
            }
            // The solid is never left before the exit: every place on the way is in it.
            if let Exit::Clear(t) | Exit::Grid(t) = voxels.exit(origin.to_array(), direction.to_array(), f32::INFINITY) {
                let inside = (0..50).filter(|i| voxels.contains((origin + direction * (t * *i as f32 / 50.0)).to_array())).count();
                prop_assert!(inside >= 48, "{inside}");
            }
        }
    }

    #[test]
    fn axis_rays_through_a_full_grid_end_at_its_faces() {
        let obb = Obb { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::ONE };
        let voxels = filled(&shapes::cube(10.0), &Grid { dims: [16, 8, 128], ..Grid::new(&obb, 1 << 14, None) });
        assert_eq!(voxels.count(), 1 << 14);
        assert_eq!(voxels.exit([3.5, 4.5, 100.5], [0.0, 0.0, -1.0], f32::INFINITY), Exit::Grid(100.5));
        assert_eq!(voxels.exit([3.5, 4.5, 100.5], [2.0, 0.0, 0.0], f32::INFINITY), Exit::Grid(6.25));
        assert_eq!(voxels.exit([3.5, 4.5, 100.5], [0.0, -0.5, 0.0], 3.0), Exit::Limit);
        assert_eq!(voxels.exit([15.5, 4.5, 3.5], [1.0, 0.0, 0.0], f32::INFINITY), Exit::Border);
        assert_eq!(voxels.exit([15.5, 4.5, 128.5], [1.0, 0.0, 0.0], f32::INFINITY), Exit::Outside);
        assert_eq!(voxels.exit([1.5, 4.5, 3.5], [0.0; 3], f32::INFINITY), Exit::Limit);
        assert_eq!(voxels.exit([1.5, 4.5, 3.5], [f32::NAN; 3], 9.0), Exit::Limit);
        assert_eq!(voxels.exit([f32::NAN, 4.5, 3.5], [1.0; 3], 9.0), Exit::Outside);
    }
}
