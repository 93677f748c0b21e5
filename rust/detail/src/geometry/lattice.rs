//! Points of colliders on the lattice of 1/256 voxel, by integers alone: the processor and graphics devices, which have
//! no f64, so put every point on the very same place, and their voxels are the same to the bit.

use glam::{DAffine3, DVec3};

use crate::geometry::grid::Grid;
use crate::geometry::obb::Obb;
use crate::geometry::scanline::SUB;

/// Snapped units beyond which points are not placed.
pub(crate) const FAR: i64 = 1 << 24;

/// Coordinates as integers at most.
const MAX: f32 = (1 << 29) as f32;

/// A map from object space to the lattice, in integers about the middle of the grid. Points are the processor's in f64
/// but for those within 2⁻⁸ units of the middle between two places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The map's rows for coordinates as integers, times 2 to the power of `shift`.
    pub(crate) rows: [[i32; 3]; 3],
    pub(crate) shift: u32,
    /// Coordinates times this are integers; a power of two.
    pub(crate) scale: f32,
    /// Subtracted from coordinates as integers.
    pub(crate) origin: [i32; 3],
    /// Where the origin is, with half a unit for rounding.
    pub(crate) offset: [i64; 3],
}

/// The power of two that a number does not exceed, 0 for 0.
fn exponent(value: f64) -> i32 {
    if value > 0.0 { value.log2().ceil() as i32 } else { 0 }
}

impl Lattice {
    /// The lattice of `grid` for a mesh whose box in object space is `obb` and whose transform to the world is given.
    /// `None` where there are not enough bits: the grid is too far away, or its voxels are too small.
    pub fn new(grid: &Grid, transform: &DAffine3, obb: &Obb) -> Option<Self> {
        let map = grid.map * *transform;
        let center = transform.inverse().transform_point3(grid.obb.center);
        let largest = obb.corners().into_iter().fold(0.0, |most: f64, corner| most.max(corner.abs().max_element()));
        let unit = SUB as f64;
        // Of coordinates 28 bits, of the map 29: logarithms are rounded, and differences have a bit more.
        let bits = (28 - exponent(largest)).clamp(-90, 90);
        let scale = 2.0_f64.powi(bits);
        let origin = (center * scale).round().clamp(DVec3::splat(-f64::from(MAX)), DVec3::splat(f64::from(MAX)));
        let linear = map.matrix3 * unit;
        let most = linear.to_cols_array().into_iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let place = map.transform_point3(origin / scale) * unit + 0.5;
        let shift = (bits + 29 - exponent(most)).min(60 - exponent(place.abs().max_element() + 1.0)).min(62);
        if shift < 1 || !place.is_finite() {
            return None;
        }
        let row = |axis: usize| (linear.row(axis) * 2.0_f64.powi(shift - bits)).round().to_array().map(|it| it as i32);
        Some(Self {
            rows: [0, 1, 2].map(row),
            shift: shift as u32,
            scale: scale as f32,
            origin: origin.to_array().map(|it| it as i32),
            offset: (place * 2.0_f64.powi(shift)).to_array().map(|it| it.round() as i64),
        })
    }

    /// A point of object space on the lattice; `None` where it is too far away. The same as `imprint_snap.wgsl`.
    #[inline(always)]
    pub fn place(&self, point: [f32; 3]) -> Option<[i64; 3]> {
        let whole = point.map(|value| (value * self.scale).round_ties_even());
        // Not a number fails this as well.
        if !whole.iter().all(|value| value.abs() <= MAX) {
            return None;
        }
        let q: [i64; 3] = std::array::from_fn(|axis| i64::from(whole[axis] as i32 - self.origin[axis]));
        let place: [i64; 3] = std::array::from_fn(|axis| {
            let row = self.rows[axis].map(i64::from);
            (row[0] * q[0] + row[1] * q[1] + row[2] * q[2] + self.offset[axis]) >> self.shift
        });
        place.iter().all(|value| value.abs() <= FAR).then_some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::scanline::snap;
    use glam::{DMat3, EulerRot};
    use relievo_testing::Random;

    #[test]
    fn places_are_those_of_f64_but_for_the_middle_between_two() {
        let mut random = Random(3);
        let mut unit = move || f64::from(random.unit()) - 0.5;
        for case in 0..40 {
            let far = DVec3::new(unit(), unit(), unit()) * 10.0_f64.powi(case % 4);
            let turn = DMat3::from_euler(EulerRot::XYZ, unit() * 6.0, unit() * 6.0, unit() * 6.0);
            let transform = DAffine3::from_mat3_translation(turn * (1.5 + unit()), far);
            let points: Vec<[f32; 3]> =
                (0..500).map(|_| [unit(), unit(), unit()].map(|value| (3.0 * value) as f32)).collect();
            let obb = Obb::of_points(&points).unwrap();
            let center = transform.transform_point3(DVec3::new(unit(), unit(), unit()) * 3.0);
            let grid = Grid::new(&Obb { center, axes: turn, half: DVec3::new(0.4, 0.3, 0.2) }, 1 << 20, None);
            let lattice = Lattice::new(&grid, &transform, &obb).unwrap();
            for point in points {
                let exact = (grid.map * transform).transform_point3(DVec3::from(point.map(f64::from)));
                let place = lattice.place(point).unwrap();
                for axis in 0..3 {
                    let fraction = exact[axis] * SUB as f64 + 0.5;
                    let near = (fraction - fraction.round()).abs() < 4e-3;
                    assert!(near || place[axis] == snap(exact[axis]), "{place:?} {exact:?}");
                }
            }
            assert_eq!(lattice.place([f32::NAN, 0.0, 0.0]), None);
            assert_eq!(lattice.place([1e9, 0.0, 0.0]), None);
        }
    }
}
