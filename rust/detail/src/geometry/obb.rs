//! Oriented bounding boxes by principal component analysis (Schäfer et al. 2014, Section 5, Overlap Regions), in f64.
//!
//! The boxes of a surface are taken over its control points, whose convex hull holds the limit surface.

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Error, Result};

/// A box of any orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obb {
    /// The middle.
    pub center: DVec3,
    /// The directions of the edges, orthonormal and right-handed, as columns.
    pub axes: DMat3,
    /// Half the edge lengths, along `axes`. None is negative.
    pub half: DVec3,
}

impl Obb {
    /// The box of `points` along their principal axes, or along the coordinate axes where that is no larger.
    ///
    /// Flat, straight and single-point clouds give boxes without depth. Where principal axes are not determined, as for
    /// symmetric clouds, the coordinate axes serve.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no point, or a number is not finite.
    pub fn of_points(points: &[[f32; 3]]) -> Result<Self> {
        if points.is_empty() {
            return Err(Error::invalid("a bounding box needs at least one point"));
        }
        let mut sum = DVec3::ZERO;
        for point in points {
            sum += DVec3::from(point.map(f64::from));
        }
        if !sum.is_finite() {
            return Err(Error::invalid("a point of the bounding box is not finite"));
        }
        let mean = sum / points.len() as f64;
        // Upper triangle of the covariance: xx, yy, zz, xy, xz, yz.
        let mut covariance = [0.0; 6];
        for point in points {
            let [x, y, z] = (DVec3::from(point.map(f64::from)) - mean).to_array();
            for (sum, product) in covariance.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *sum += product;
            }
        }
        let principal = Self::along(principal_axes(covariance), points);
        let straight = Self::along(DMat3::IDENTITY, points);
        // Where numbers are too large to be squared, the principal axes are not numbers and lose.
        Ok(if principal.size_measure() < straight.size_measure() { principal } else { straight })
    }

    /// The smallest box with the given axes that holds `points`, which are not empty.
    fn along(axes: DMat3, points: &[[f32; 3]]) -> Self {
        let inverse = axes.transpose();
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for point in points {
            let place = inverse * DVec3::from(point.map(f64::from));
            low = low.min(place);
            high = high.max(place);
        }
        Self::from_interval(axes, low, high)
    }

    /// The box with the given orthonormal axes whose coordinates along them run from `low` to `high`.
    pub fn from_interval(axes: DMat3, low: DVec3, high: DVec3) -> Self {
        Self { center: axes * (0.5 * (low + high)), axes, half: (0.5 * (high - low)).max(DVec3::ZERO) }
    }

    /// What is compared between boxes: the volume, and by a little the surface, which decides between flat boxes.
    fn size_measure(&self) -> f64 {
        let [x, y, z] = self.half.to_array();
        let longest = self.half.max_element();
        x * y * z + 1e-6 * longest * (x * y + y * z + z * x)
    }

    /// The volume.
    pub fn volume(&self) -> f64 {
        8.0 * self.half.x * self.half.y * self.half.z
    }

    /// The same box moved out by `margin` on every side.
    pub fn enlarged(&self, margin: f64) -> Self {
        Self { half: self.half + DVec3::splat(margin), ..*self }
    }

    /// Returns the smallest box with the same axes that holds this one in every place on its way along `path`.
    pub fn swept(&self, path: DVec3) -> Self {
        let half = self.half + 0.5 * (self.axes.transpose() * path).abs();
        Self { center: self.center + 0.5 * path, half, ..*self }
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|index| {
            let sign = |bit: usize| if index >> bit & 1 == 0 { -1.0 } else { 1.0 };
            self.center + self.axes * (self.half * DVec3::new(sign(0), sign(1), sign(2)))
        })
    }

    /// The smallest box with the given orthonormal axes that holds this one.
    pub fn realigned(&self, axes: DMat3) -> Self {
        let turn = axes.transpose() * self.axes;
        let half = turn.x_axis.abs() * self.half.x + turn.y_axis.abs() * self.half.y + turn.z_axis.abs() * self.half.z;
        Self { center: self.center, axes, half }
    }

    /// A box that holds the image of this one; exact for rotation, translation and uniform scale.
    pub fn transformed(&self, transform: &DAffine3) -> Self {
        let edges = transform.matrix3 * self.axes * DMat3::from_diagonal(self.half);
        let axes = orthonormal(edges);
        let half = (axes.transpose() * edges).abs();
        let half = half.x_axis + half.y_axis + half.z_axis;
        Self { center: transform.transform_point3(self.center), axes, half }
    }

    /// Whether `point` is inside or on the border, with `slack` added on every side.
    pub fn contains(&self, point: DVec3, slack: f64) -> bool {
        (self.axes.transpose() * (point - self.center)).abs().cmple(self.half + DVec3::splat(slack)).all()
    }

    /// Whether the two boxes share a point, by separating axes. Boxes that barely miss each other may count as
    /// touching.
    pub fn overlaps(&self, other: &Self) -> bool {
        let turn = self.axes.transpose() * other.axes;
        let offset = self.axes.transpose() * (other.center - self.center);
        // Cross products of nearly parallel edges vanish; the slack keeps them from separating.
        let slack = DMat3::from_cols_array(&[1e-9; 9]);
        let spread = turn.abs() + slack;
        let (a, b) = (self.half.to_array(), other.half.to_array());
        let at = |matrix: &DMat3, row: usize, column: usize| matrix.col(column)[row];
        let gap = |distance: f64, reach: f64| distance.abs() > reach * (1.0 + 1e-9);
        for i in 0..3 {
            let reach = a[i] + (0..3).map(|j| b[j] * at(&spread, i, j)).sum::<f64>();
            if gap(offset[i], reach) {
                return false;
            }
        }
        for j in 0..3 {
            let reach = b[j] + (0..3).map(|i| a[i] * at(&spread, i, j)).sum::<f64>();
            if gap(turn.col(j).dot(offset), reach) {
                return false;
            }
        }
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let reach = a[i1] * at(&spread, i2, j)
                    + a[i2] * at(&spread, i1, j)
                    + b[j1] * at(&spread, i, j2)
                    + b[j2] * at(&spread, i, j1);
                if gap(offset[i2] * at(&turn, i1, j) - offset[i1] * at(&turn, i2, j), reach) {
                    return false;
                }
            }
        }
        true
    }
}

/// Orthonormal axes near the columns of `edges`: the longest keeps its direction. Missing ones are made up.
fn orthonormal(edges: DMat3) -> DMat3 {
    let columns = [edges.x_axis, edges.y_axis, edges.z_axis];
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| columns[*b].length_squared().total_cmp(&columns[*a].length_squared()));
    let first = columns[order[0]].normalize_or(DVec3::AXES[order[0]]);
    let rest = columns[order[1]] - first * first.dot(columns[order[1]]);
    let near = rest.length_squared() <= 1e-24 * columns[order[1]].length_squared() || rest.length_squared() == 0.0;
    let second = if near { first.any_orthonormal_vector() } else { rest.normalize() };
    let mut axes = [DVec3::ZERO; 3];
    axes[order[0]] = first;
    axes[order[1]] = second;
    let (i, j) = ((order[2] + 1) % 3, (order[2] + 2) % 3);
    axes[order[2]] = axes[i].cross(axes[j]);
    DMat3::from_cols_array_2d(&axes.map(|axis| axis.to_array()))
}

/// Orthonormal right-handed eigenvectors of a symmetric matrix `[xx, yy, zz, xy, xz, yz]`, by cyclic Jacobi rotations
/// that start from the coordinate axes: a matrix that is diagonal but for rounding leaves them as they are.
fn principal_axes([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> DMat3 {
    let mut a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut v = DMat3::IDENTITY.to_cols_array_2d();
    let tolerance = 1e-9 * (xx + yy + zz);
    for _ in 0..16 {
        if a[0][1].abs().max(a[0][2].abs()).max(a[1][2].abs()) <= tolerance {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q].abs() <= 1e-3 * tolerance {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = 1.0f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
            }
        }
    }
    orthonormal(DMat3::from_cols_array_2d(&v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;

    fn turned_grid(size: DVec3, turn: DQuat) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for i in 0..=4 {
            for j in 0..=4 {
                for k in 0..=4 {
                    let place = size * (DVec3::new(i as f64, j as f64, k as f64) / 4.0 - 0.5);
                    points.push((turn * place + DVec3::new(5.0, -3.0, 2.0)).as_vec3().to_array());
                }
            }
        }
        points
    }

    #[test]
    fn a_turned_box_of_points_gives_back_its_size() {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
        let obb = Obb::of_points(&turned_grid(DVec3::new(8.0, 4.0, 1.0), turn)).unwrap();
        let mut half = obb.half.to_array();
        half.sort_by(f64::total_cmp);
        for (found, expected) in half.iter().zip([0.5, 2.0, 4.0]) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        assert!((obb.axes.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn symmetric_and_degenerate_clouds_are_stable() {
        let cube = Obb::of_points(&turned_grid(DVec3::ONE, DQuat::IDENTITY)).unwrap();
        assert_eq!(cube.axes, DMat3::IDENTITY);
        let point = Obb::of_points(&[[1.0, 2.0, 3.0]; 4]).unwrap();
        assert_eq!((point.center, point.half), (DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO));
        let line = Obb::of_points(&[[0.0; 3], [1.0; 3], [3.0; 3]]).unwrap();
        let mut half = line.half.to_array();
        half.sort_by(f64::total_cmp);
        assert!(half[1] < 1e-6 && (half[2] - 1.5 * 3f64.sqrt()).abs() < 1e-6, "{half:?}");
        let flat = turned_grid(DVec3::new(3.0, 2.0, 0.0), DQuat::from_rotation_y(0.4));
        assert!(Obb::of_points(&flat).unwrap().half.min_element() < 1e-6);
        let huge = Obb::of_points(&[[-3e38; 3], [3e38, 1e38, -2e38]]).unwrap();
        assert!(huge.half.is_finite() && huge.axes.is_finite());
        assert!(Obb::of_points(&[]).is_err());
        assert!(Obb::of_points(&[[f32::NAN, 0.0, 0.0]]).is_err());
    }

    proptest! {
        #[test]
        fn a_transformed_box_holds_the_transformed_corners(numbers in prop::array::uniform12(-2.0f64..2.0)) {
            let transform = DAffine3::from_cols_array(&numbers);
            let half = DVec3::new(1.0, 2.0, 0.5);
            let obb = Obb { center: DVec3::ONE, axes: DMat3::from_rotation_z(0.4), half };
            let image = obb.transformed(&transform);
            prop_assert!((image.axes.transpose() * image.axes - DMat3::IDENTITY).abs().to_cols_array().iter().all(|v| *v < 1e-9));
            for corner in obb.corners() {
                prop_assert!(image.contains(transform.transform_point3(corner), 1e-9));
            }
        }

        #[test]
        fn separating_axes_never_part_boxes_that_share_a_point(
            a in prop::array::uniform9(0.0f64..2.0), b in prop::array::uniform9(0.0f64..2.0), at in prop::array::uniform3(-1.0f64..1.0)
        ) {
            let make = |v: [f64; 9]| Obb {
                center: DVec3::new(v[0], v[1], v[2]),
                axes: DMat3::from_euler(glam::EulerRot::XYZ, v[3], v[4], v[5]),
                half: DVec3::new(v[6], v[7], v[8]),
            };
            let (a, b) = (make(a), make(b));
            let point = a.center + a.axes * (a.half * DVec3::from(at));
            if b.contains(point, 0.0) {
                prop_assert!(a.overlaps(&b) && b.overlaps(&a));
            }
        }
    }

    #[test]
    fn boxes_apart_do_not_overlap() {
        let cube = Obb { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::ONE };
        let turned = Obb { center: DVec3::new(2.5, 0.0, 0.0), axes: DMat3::from_rotation_z(0.78), half: DVec3::ONE };
        assert!(!cube.overlaps(&turned.enlarged(-0.2)));
        // Two edges crossing at a distance: only a cross product parts them.
        let x = Obb { center: DVec3::ZERO, axes: DMat3::from_rotation_x(0.785), half: DVec3::new(9.0, 1.0, 1.0) };
        let y = Obb {
            center: DVec3::new(0.0, 0.0, 2.9),
            axes: DMat3::from_rotation_y(0.785),
            half: DVec3::new(1.0, 9.0, 1.0),
        };
        assert!(!x.overlaps(&y));
        assert!(x.overlaps(&Obb { center: DVec3::new(0.0, 0.0, 2.7), ..y }));
    }
}
