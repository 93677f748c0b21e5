//! Rays through the solid voxels (Schäfer et al. 2014, Section 6), with the traversal of Amanatides and Woo 1987, A Fast
//! Voxel Traversal Algorithm for Ray Tracing. Places are in voxel coordinates.

use crate::voxel::Voxels;

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
    pub fn exit(&self, origin: [f32; 3], direction: [f32; 3], limit: f32) -> Exit {
        if !self.contains(origin) {
            return Exit::Outside;
        }
        let grid = self.grid();
        let words = self.words();
        let nx = grid.dims[0] as usize;
        let row = nx * grid.words() as usize;
        let start = origin.map(|value| value as u32);
        let forward = direction.map(|value| value > 0.0);
        // Distance to the next face along each axis, and between faces. Without motion there is none.
        let mut next = [f32::INFINITY; 3];
        let mut delta = [f32::INFINITY; 3];
        for axis in 0..3 {
            if direction[axis] != 0.0 {
                let face = (start[axis] + u32::from(forward[axis])) as f32;
                next[axis] = (face - origin[axis]) / direction[axis];
                delta[axis] = 1.0 / direction[axis].abs();
            }
        }
        // Steps that are left on each axis before the grid ends.
        let mut left: [u32; 3] = std::array::from_fn(|axis| match forward[axis] {
            true => grid.dims[axis] - 1 - start[axis],
            false => start[axis],
        });
        let mut z = start[2];
        let mut column = start[1] as usize * row + start[0] as usize;
        let mut first = true;
        loop {
            let axis = if next[0] < next[1] {
                if next[0] < next[2] { 0 } else { 2 }
            } else if next[1] < next[2] {
                1
            } else {
                2
            };
            let distance = next[axis];
            // Not a number ends here as well.
            if !(distance < limit) {
                return Exit::Limit;
            }
            if left[axis] == 0 {
                return if first { Exit::Border } else { Exit::Grid(distance) };
            }
            left[axis] -= 1;
            next[axis] += delta[axis];
            match (axis, forward[axis]) {
                (0, true) => column += 1,
                (0, false) => column -= 1,
                (1, true) => column += row,
                (1, false) => column -= row,
                (_, true) => z += 1,
                (_, false) => z -= 1,
            }
            if words[column + (z / 64) as usize * nx] >> (z % 64) & 1 == 0 {
                return if first { Exit::Border } else { Exit::Clear(distance) };
            }
            first = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::obb::Obb;
    use crate::shapes;
    use crate::voxel::{Side, Solid};
    use glam::{DAffine3, DMat3, DVec3, Vec3};
    use proptest::prelude::*;
    use relievo_core::Context;

    fn blob() -> Voxels {
        let (points, triangles) = shapes::torus(1.0, 0.4, 48, 24);
        let obb = Obb {
            center: DVec3::new(0.3, 0.0, 0.0),
            axes: DMat3::from_rotation_x(0.3),
            half: DVec3::new(1.2, 0.9, 0.4),
        };
        let solid = Solid { points: &points, triangles: &triangles, transform: DAffine3::IDENTITY, closed: true };
        let mut voxels = Voxels::default();
        voxels.fill(&Context::serial(), &Grid::new(&obb, 1 << 16, None), &solid, None, Side::Forward).unwrap();
        voxels
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
            let voxels = blob();
            let dims = Vec3::from(voxels.grid().dims.map(|n| n as f32));
            let origin = Vec3::from(place) * dims;
            let mut direction = Vec3::from(direction);
            if flat < 3 {
                direction[flat] = 0.0;
            }
            prop_assume!(direction.length() > 0.1);
            let step = 2e-3 / direction.length();
            let (low, high) = march(&voxels, origin, direction, step);
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
        let (points, triangles) = shapes::cube(10.0);
        let obb = Obb { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::ONE };
        let solid = Solid { points: &points, triangles: &triangles, transform: DAffine3::IDENTITY, closed: true };
        let mut voxels = Voxels::default();
        let grid = Grid { dims: [16, 8, 128], ..Grid::new(&obb, 1 << 14, None) };
        voxels.fill(&Context::serial(), &grid, &solid, None, Side::Forward).unwrap();
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
