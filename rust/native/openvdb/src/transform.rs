//! The way from voxels to the world: an affine map, or a camera's frustum.

use relievo_core::{Error, Result};

/// The least volume of a voxel.
const SMALLEST: f64 = 4e-15;

/// From voxels to world units. Voxel (0, 0, 0) has its middle at the origin of an identity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Rows of a matrix for row vectors: what the axes go to, and the origin, each with a fourth number. Of a frustum it is
    /// the map that follows the pyramid.
    pub rows: [[f64; 4]; 4],
    /// Whether that is all; otherwise it is a frustum.
    pub is_linear: bool,
    /// The edges of a voxel in world units; of a frustum those in its middle.
    pub voxel_size: [f64; 3],
}

impl Transform {
    /// Returns a uniform scale: `voxel` is the edge of a voxel in world units.
    pub fn uniform(voxel: f64) -> Self {
        Self::affine([[voxel, 0.0, 0.0], [0.0, voxel, 0.0], [0.0, 0.0, voxel], [0.0; 3]])
    }

    /// Returns an affine map: what the three axes of voxels go to, and the origin.
    pub fn affine(columns: [[f64; 3]; 4]) -> Self {
        let [[a, b, c], [d, e, f], [g, h, i], [x, y, z]] = columns;
        let rows = [[a, b, c, 0.0], [d, e, f, 0.0], [g, h, i, 0.0], [x, y, z, 1.0]];
        Self { rows, is_linear: true, voxel_size: edges(&rows) }
    }

    pub(crate) fn of_rows(numbers: [f64; 16], voxel_size: [f64; 3], is_linear: bool) -> Self {
        let row = |at: usize| [0, 1, 2, 3].map(|column| numbers[4 * at + column]);
        Self { rows: [row(0), row(1), row(2), row(3)], is_linear, voxel_size }
    }

    pub(crate) fn numbers(&self) -> [f64; 16] {
        std::array::from_fn(|at| self.rows[at / 4][at % 4])
    }

    /// Returns the volume of a voxel in cubic world units; of a frustum that of one in its middle.
    pub fn voxel_volume(&self) -> f64 {
        if !self.is_linear {
            return self.voxel_size.iter().product();
        }
        self.determinant().abs()
    }

    fn determinant(&self) -> f64 {
        let [a, b, c, _] = self.rows;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    }

    /// Returns the world position of a place in voxels, if the transform is linear.
    pub fn place(&self, voxel: [f64; 3]) -> Option<[f64; 3]> {
        let along = |axis: usize| (0..3).map(|at| voxel[at] * self.rows[at][axis]).sum::<f64>() + self.rows[3][axis];
        self.is_linear.then(|| [along(0), along(1), along(2)])
    }

    /// Whether the map is finite and has an inverse, of whatever size voxels are.
    pub(crate) fn is_regular(&self) -> bool {
        self.rows.iter().flatten().all(|number| number.is_finite()) && self.determinant().is_normal()
    }

    /// Fails unless the map is finite and has an inverse.
    pub(crate) fn check(&self) -> Result<()> {
        let determinant = self.determinant();
        // OpenVDB takes an affine map with a smaller one as singular.
        if self.rows.iter().flatten().all(|number| number.is_finite()) && determinant.abs() > SMALLEST {
            return Ok(());
        }
        let error = Error::invalid("the transform is not finite, or voxels have a volume below 4e-15").at("transform");
        Err(error.advise("give voxels three independent, finite edges"))
    }
}

fn edges(rows: &[[f64; 4]; 4]) -> [f64; 3] {
    [0, 1, 2].map(|row| rows[row][..3].iter().map(|part| part * part).sum::<f64>().sqrt())
}
