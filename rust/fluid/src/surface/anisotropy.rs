//! Anisotropic kernels (Yu, Turk 2013, Section 4): the covariance of the neighbours of a particle says along which axes
//! its kernel is stretched, so that kernels are flat at the surface.

use crate::surface::Surface;

/// The largest ratio of the axes of a kernel (Yu, Turk 2013, Equation 15).
const RATIO: f64 = 4.0;
/// The size of a kernel with few neighbours, and how many are few, with the particle itself. Yu and Turk say 25 within
/// two support radii; here it is one support radius, in which there are an eighth as many, and three are always in a
/// plane.
const ALONE: f64 = 0.5;
const ROUND_NEIGHBORS: usize = 6;
/// What makes the kernel within a fluid that fills space a sphere of the support radius: the variance along an axis of
/// the weights 1 − (r / support)³ is 0.15 of its square.
const SCALE: f64 = 1.0 / 0.15;

/// The kernel of a particle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kernel {
    pub centre: [f32; 3],
    /// The longest axis, in support radii.
    pub widest: f32,
    /// The matrix M of s = dᵀ M d, as [xx, xy, xz, yy, yz, zz].
    pub matrix: [f32; 6],
    /// What keeps the kernel's integral: the inverse of its volume, that of the sphere being 1.
    pub amplitude: f32,
}

impl Kernel {
    /// Of axes and their lengths in support radii; `sphere` is the inverse of the squared support radius.
    fn new(centre: [f32; 3], axes: [[f64; 3]; 3], lengths: [f64; 3], sphere: f32) -> Self {
        let matrix = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(row, column)| {
            let entry = |axis: usize| axes[axis][row] * axes[axis][column] / (lengths[axis] * lengths[axis]);
            ((entry(0) + entry(1) + entry(2)) * f64::from(sphere)) as f32
        });
        let widest = lengths.iter().copied().fold(0.0, f64::max) as f32;
        Self { centre, widest, matrix, amplitude: (1.0 / (lengths[0] * lengths[1] * lengths[2])) as f32 }
    }
}

/// The kernel of the particle at this place of the order of a surface of spheres, its centre moved by the share
/// `centring` to the mean of its neighbours.
pub(crate) fn kernel(surface: &Surface, at: usize, centring: f32, ranges: &[std::ops::Range<usize>]) -> Kernel {
    let own = surface.centre(at);
    let (mut count, mut weights, mut first, mut second) = (0, 0.0, [0.0; 3], [0.0; 6]);
    for other in ranges.iter().cloned().flatten() {
        let centre = surface.centre(other);
        let d: [f64; 3] = std::array::from_fn(|axis| f64::from(centre[axis]) - f64::from(own[axis]));
        let s = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * f64::from(surface.sphere);
        if s < 1.0 {
            let weight = 1.0 - s * s.sqrt();
            count += 1;
            weights += weight;
            (0..3).for_each(|axis| first[axis] += weight * d[axis]);
            let products = [d[0] * d[0], d[0] * d[1], d[0] * d[2], d[1] * d[1], d[1] * d[2], d[2] * d[2]];
            second.iter_mut().zip(products).for_each(|(sum, product)| *sum += weight * product);
        }
    }
    let mean = first.map(|sum| sum / weights);
    let centre = std::array::from_fn(|axis| (f64::from(own[axis]) + f64::from(centring) * mean[axis]) as f32);
    if count <= ROUND_NEIGHBORS {
        return Kernel::new(centre, IDENTITY, [ALONE; 3], surface.sphere);
    }
    let scale = SCALE * f64::from(surface.sphere);
    let products = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(row, column)| mean[row] * mean[column]);
    let covariance = std::array::from_fn(|at| (second[at] / weights - products[at]) * scale);
    let (mut lengths, axes) = eigen(covariance);
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    if longest < 1e-3 {
        // All neighbours are at one point.
        return Kernel::new(centre, IDENTITY, [ALONE; 3], surface.sphere);
    }
    lengths.iter_mut().for_each(|length| *length = length.max(longest / RATIO));
    Kernel::new(centre, axes, lengths, surface.sphere)
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Eigenvalues and eigenvectors of a symmetric matrix [xx, xy, xz, yy, yz, zz] by Jacobi rotations.
fn eigen([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut matrix = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut axes = IDENTITY;
    // Each sweep squares what is beside the diagonal.
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if matrix[p][q] == 0.0 {
                continue;
            }
            let ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
            let tangent = 1.0f64.copysign(ratio) / (ratio.abs() + ratio.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            let sine = tangent * cosine;
            for row in &mut matrix {
                (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
            }
            for column in 0..3 {
                let (a, b) = (matrix[p][column], matrix[q][column]);
                (matrix[p][column], matrix[q][column]) = (cosine * a - sine * b, sine * a + cosine * b);
                let (a, b) = (axes[p][column], axes[q][column]);
                (axes[p][column], axes[q][column]) = (cosine * a - sine * b, sine * a + cosine * b);
            }
        }
    }
    ([matrix[0][0], matrix[1][1], matrix[2][2]], axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_those_of_the_matrix() {
        for matrix in [[2.0, 0.3, -0.7, 1.0, 0.2, 3.0], [1.0, 0.0, 0.0, 1.0, 0.0, 1.0], [0.0, 1e-9, 0.0, 0.0, 4.0, 0.0]]
        {
            let [xx, xy, xz, yy, yz, zz] = matrix;
            let (values, axes) = eigen(matrix);
            for (value, [x, y, z]) in values.iter().zip(axes) {
                let image = [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z];
                for (found, expected) in image.iter().zip([x, y, z]) {
                    assert!((found - value * expected).abs() < 1e-12);
                }
                assert!((x * x + y * y + z * z - 1.0).abs() < 1e-12);
            }
        }
    }
}
