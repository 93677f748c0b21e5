//! The 8-node hexahedron with one integration point (Flanagan and Belytschko 1981).
//!
//! Corners are numbered as VTK and Abaqus do: the four of the lower face counter-clockwise seen from above, then those
//! above them. The gradient operator is the mean over the element, which passes the patch test for any shape. Hourglass
//! modes are the four patterns of corner displacements that have no mean gradient.

use glam::{DMat3, DVec3};
use relievo_core::{Error, Result};

/// Signs of the parametric coordinates of the corners.
pub(crate) const SIGNS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Corners of the six faces, counter-clockwise seen from outside: −x, +x, −y, +y, −z, +z.
pub(crate) const FACES: [[usize; 4]; 6] =
    [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]];

/// What the forces of an element follow from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hexahedron {
    /// Volume in m³.
    pub volume: f64,
    /// Mean gradients of the shape functions of the corners, in 1/m.
    pub gradients: [DVec3; 8],
    /// Hourglass patterns, orthogonal to all linear fields: ξη, ηζ, ζξ, ξηζ.
    pub patterns: [[f64; 8]; 4],
    /// Sum of squares of the gradients, in 1/m². A cube of side h has 3/(2h²).
    pub squares: f64,
}

impl Hexahedron {
    /// Computes the shape from the corners in metres. Fails if the element is inside out or has no volume.
    pub fn new(corners: &[DVec3; 8]) -> Result<Self> {
        // Two Gauss points an axis integrate the cofactors and the determinant exactly.
        let point = 1.0 / 3f64.sqrt();
        let mut volume = 0.0;
        let mut gradients = [DVec3::ZERO; 8];
        let mut least = f64::INFINITY;
        for signs in SIGNS {
            let derivatives = derivatives(signs.map(|sign| point * sign).into());
            let jacobian = jacobian(corners, &derivatives);
            let determinant = jacobian.determinant();
            least = least.min(determinant);
            volume += determinant;
            if determinant > 0.0 {
                let cofactors = jacobian.inverse().transpose() * determinant;
                for (gradient, derivative) in gradients.iter_mut().zip(derivatives) {
                    *gradient += cofactors * derivative;
                }
            }
        }
        if !(least > 0.0 && volume.is_finite()) {
            return Err(Error::invalid("the element is inside out or has no volume").advise(
                "number its corners as VTK does: the lower face counter-clockwise seen from above, then the upper",
            ));
        }
        gradients.iter_mut().for_each(|gradient| *gradient /= volume);
        let patterns = [[0, 1], [1, 2], [2, 0], [0, 3]].map(|[a, b]| {
            let base = SIGNS.map(|signs| if b == 3 { signs[0] * signs[1] * signs[2] } else { signs[a] * signs[b] });
            let slope: DVec3 = base.iter().zip(corners).map(|(sign, corner)| *sign * *corner).sum();
            std::array::from_fn(|corner| base[corner] - slope.dot(gradients[corner]))
        });
        let squares = gradients.iter().map(|gradient| gradient.length_squared()).sum();
        Ok(Self { volume, gradients, patterns, squares })
    }
}

/// Returns the derivatives of the shape functions by the parametric coordinates, which are from −1 to 1.
fn derivatives(at: DVec3) -> [DVec3; 8] {
    SIGNS.map(|[x, y, z]| {
        let (a, b, c) = (1.0 + x * at.x, 1.0 + y * at.y, 1.0 + z * at.z);
        0.125 * DVec3::new(x * b * c, y * a * c, z * a * b)
    })
}

fn jacobian(corners: &[DVec3; 8], derivatives: &[DVec3; 8]) -> DMat3 {
    let column = |axis: usize| corners.iter().zip(derivatives).map(|(corner, by)| *corner * by[axis]).sum();
    DMat3::from_cols(column(0), column(1), column(2))
}

/// Returns the shape functions at parametric coordinates from 0 to 1; beyond, they extrapolate.
pub(crate) fn trilinear(at: [f32; 3]) -> [f32; 8] {
    SIGNS.map(|signs| {
        let factor = |axis: usize| if signs[axis] > 0.0 { at[axis] } else { 1.0 - at[axis] };
        factor(0) * factor(1) * factor(2)
    })
}

/// Finds the parametric coordinates from 0 to 1 of a place by Newton's method; outside they are beyond that range.
pub(crate) fn locate(corners: &[DVec3; 8], place: DVec3) -> DVec3 {
    let mut at = DVec3::ZERO;
    for _ in 0..20 {
        let shape = SIGNS.map(|[x, y, z]| 0.125 * (1.0 + x * at.x) * (1.0 + y * at.y) * (1.0 + z * at.z));
        let found: DVec3 = corners.iter().zip(shape).map(|(corner, share)| *corner * share).sum();
        let matrix = jacobian(corners, &derivatives(at));
        if matrix.determinant().abs() < f64::MIN_POSITIVE {
            break;
        }
        let step = matrix.inverse() * (place - found);
        // Far outside the map may fold; larger steps than that leave the element for good.
        at += step.clamp_length_max(2.0);
        if step.length_squared() < 1e-24 {
            break;
        }
    }
    0.5 * (at + DVec3::ONE)
}
