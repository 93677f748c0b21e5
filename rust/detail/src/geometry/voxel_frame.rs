//! The voxel coordinates of an overlap, as places and directions of an object have them.

use glam::{DAffine3, DVec3};

use crate::geometry::grid::Grid;

/// From object space to voxel coordinates in f32, by way of a place near the middle of the grid so that little is lost.
#[derive(Clone, Copy, Debug)]
pub struct VoxelFrame {
    /// The linear part, row by row.
    pub rows: [[f32; 3]; 3],
    /// The place in object space that is subtracted first.
    pub origin: [f32; 3],
    /// Where that place is, in voxels.
    pub shift: [f32; 3],
    /// The size of the grid, in voxels.
    pub dims: [f32; 3],
}

impl VoxelFrame {
    /// The frame for an object with the given transform to the world.
    pub fn new(grid: &Grid, transform: &DAffine3) -> Self {
        let center = transform.inverse().transform_point3(grid.obb.center);
        Self::of_map(&(grid.map * *transform), center, grid.dims.map(|count| count as f32))
    }

    /// The frame in which `map`, from object space, gives coordinates from 0 to `dims`; `center` is the middle of those
    /// in object space.
    pub fn of_map(map: &DAffine3, center: DVec3, dims: [f32; 3]) -> Self {
        let origin = center.as_vec3();
        let matrix = map.matrix3.transpose();
        let shift = map.transform_point3(origin.as_dvec3());
        Self {
            rows: [0, 1, 2].map(|row| matrix.col(row).as_vec3().to_array()),
            origin: origin.to_array(),
            shift: shift.as_vec3().to_array(),
            dims,
        }
    }

    /// The place of a point, in voxels.
    #[inline(always)]
    pub fn place(&self, p: [f32; 3]) -> [f32; 3] {
        let q = [p[0] - self.origin[0], p[1] - self.origin[1], p[2] - self.origin[2]];
        let turned = self.turn(q);
        [turned[0] + self.shift[0], turned[1] + self.shift[1], turned[2] + self.shift[2]]
    }

    /// A direction of object space, in voxels.
    #[inline(always)]
    pub fn turn(&self, d: [f32; 3]) -> [f32; 3] {
        self.rows.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
    }

    /// Whether intervals of voxel coordinates reach into the grid.
    pub(crate) fn meets(&self, low: [f32; 3], high: [f32; 3]) -> bool {
        (0..3).all(|axis| low[axis] <= self.dims[axis] + SLACK && high[axis] >= -SLACK)
    }
}

/// Voxels by which bounds are widened against rounding.
pub(crate) const SLACK: f32 = 0.05;
