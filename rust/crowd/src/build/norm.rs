//! How much matrices lengthen vectors.

use glam::DMat3;

/// Returns an upper bound of how much a matrix lengthens vectors, exact where its columns are orthogonal and equally long.
pub(crate) fn norm(matrix: &DMat3) -> f64 {
    let gram = matrix.transpose() * *matrix;
    let rows = [gram.row(0), gram.row(1), gram.row(2)];
    rows.iter().map(|row| row.abs().element_sum()).fold(0.0, f64::max).sqrt()
}
