//! The voxel grid of an overlap: a fixed budget of voxels spread over an oriented box in proportion to its edges
//! (Schäfer et al. 2014, Section 5, Voxelization of Overlap).
//!
//! Voxel coordinates (x, y, z) count voxels from a corner of the box; z runs along the columns, whose bits are packed
//! into words. The centre of voxel (i, j, k) is at (i + ½, j + ½, k + ½).

use glam::{DAffine3, DMat3, DVec3};

use crate::geometry::obb::Obb;

/// Voxels along one axis at most: places in a column are kept in 15 bits.
pub const MAX_VOXELS_PER_AXIS: u32 = 32_704;

/// Bits of a word of a column.
pub const WORD: u32 = 64;

/// A voxel grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The box that is divided, at least as large as the one asked for.
    pub obb: Obb,
    /// The axis of the box that x, y and z run along.
    pub order: [usize; 3],
    /// Voxels along x, y and z.
    pub dims: [u32; 3],
    /// Edges of a voxel, along x, y and z, in world units.
    pub size: DVec3,
    /// From the world to voxel coordinates.
    pub map: DAffine3,
}

impl Grid {
    /// Divides `obb` into at most `budget` voxels, about as long as they are wide.
    ///
    /// `column` names the axis of the box that columns run along; by default it is the longest, which makes columns
    /// fewest. Columns of 16 voxels and more are cut or stretched to whole words. A flat box is given a little depth.
    pub fn new(obb: &Obb, budget: u64, column: Option<usize>) -> Self {
        let half = obb.half.max(DVec3::splat((1e-6 * obb.half.max_element()).max(1e-30)));
        let obb = Obb { half, ..*obb };
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| half[*b].total_cmp(&half[*a]));
        let column = column.unwrap_or(order[0]);
        let [x, y] = match order.iter().filter(|axis| **axis != column).copied().collect::<Vec<_>>()[..] {
            [longer, shorter, ..] => [longer, shorter],
            _ => [(column + 1) % 3, (column + 2) % 3],
        };
        let order = [x, y, column];
        let edges = DVec3::new(half[x], half[y], half[column]) * 2.0;
        let budget = budget.max(1) as f64;
        let cap = |count: f64| (count as u32).clamp(1, MAX_VOXELS_PER_AXIS);
        // Dividing by the budget first keeps the product of three small edges from underflowing.
        let cube = (edges.x / budget.cbrt()).cbrt() * (edges.y).cbrt() * (edges.z).cbrt();
        let ideal = cube / budget.powf(2.0 / 9.0);
        let mut dims = [1u32; 3];
        dims[2] = cap((edges.z / ideal + 0.5).min(budget));
        if dims[2] >= WORD / 4 && budget >= 4096.0 {
            dims[2] = ((dims[2] + WORD / 2) / WORD).max(1) * WORD;
            dims[2] = dims[2].min(MAX_VOXELS_PER_AXIS).min((budget as u64 / 64 * 64).max(64).min(1 << 30) as u32);
        }
        let area = (budget / f64::from(dims[2])).max(1.0);
        dims[1] = cap((area * edges.y / edges.x).sqrt().min(area));
        dims[0] = cap(area / f64::from(dims[1]));
        let size = edges / DVec3::new(f64::from(dims[0]), f64::from(dims[1]), f64::from(dims[2]));
        let axes = DMat3::from_cols(obb.axes.col(x), obb.axes.col(y), obb.axes.col(column));
        let matrix3 = DMat3::from_diagonal(size.recip()) * axes.transpose();
        let translation = 0.5 * edges / size - matrix3 * obb.center;
        Self { obb, order, dims, size, map: DAffine3 { matrix3, translation } }
    }

    /// The longest distance inside a voxel, in world units.
    pub fn diagonal(&self) -> f64 {
        self.size.length()
    }

    /// The centre of a voxel in the world.
    pub fn center(&self, [x, y, z]: [u32; 3]) -> DVec3 {
        let place = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5;
        let middle = 0.5 * DVec3::from(self.dims.map(f64::from));
        let local = (place - middle) * self.size;
        let axes = DMat3::from_cols(
            self.obb.axes.col(self.order[0]),
            self.obb.axes.col(self.order[1]),
            self.obb.axes.col(self.order[2]),
        );
        self.obb.center + axes * local
    }

    /// Words of a column.
    pub fn words(&self) -> u32 {
        self.dims[2].div_ceil(WORD)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_budget_is_kept_and_nearly_used(
            half in prop::array::uniform3(0.01f64..10.0), center in prop::array::uniform3(-5.0f64..5.0), log in 12u32..26
        ) {
            let obb = Obb { center: DVec3::from(center), axes: DMat3::from_rotation_x(0.7), half: DVec3::from(half) };
            let grid = Grid::new(&obb, 1 << log, None);
            let count: u64 = grid.dims.iter().map(|n| u64::from(*n)).product();
            prop_assert!(count <= 1 << log, "{:?}", grid.dims);
            prop_assert!(count * 3 >= 1 << log, "{:?}", grid.dims);
            let corner = grid.map.transform_point3(obb.corners()[0]);
            let (low, high) = (corner.min_element(), corner.max_element());
            prop_assert!(low > -1e-6 && high < f64::from(*grid.dims.iter().max().unwrap()) + 1e-6);
            let place = grid.map.transform_point3(grid.center([0, 0, 0]));
            prop_assert!((place - 0.5).length() < 1e-6);
        }
    }

    #[test]
    fn flat_needle_and_point_boxes_are_divided() {
        for half in [DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 0.0, 9.0), DVec3::ZERO, DVec3::new(1e-9, 1e6, 1.0)] {
            let grid = Grid::new(&Obb { center: DVec3::ONE, axes: DMat3::IDENTITY, half }, 1 << 24, None);
            let count: u64 = grid.dims.iter().map(|n| u64::from(*n)).product();
            assert!(count <= 1 << 24 && grid.dims.iter().all(|n| (1..=MAX_VOXELS_PER_AXIS).contains(n)), "{grid:?}");
            assert!(grid.map.is_finite());
        }
    }
}
