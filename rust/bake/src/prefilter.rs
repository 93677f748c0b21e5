//! Between the coefficients of a displacement and its values at the centres of texels, which is what other programs
//! take texels for.
//!
//! A biquadratic B-spline has at the centre of a texel ⅛, ¾ and ⅛ of three coefficients along u and along v (Nießner and
//! Loop 2013, Section 3). Going back is a tridiagonal system along columns, then along rows, whose ends are the ring's
//! coefficients: the prefilter of Unser, Aldroubi and Eden 1991, exact for a tile whose ring is known. Units: object
//! units.

use half::f16;
use half::slice::HalfFloatSliceExt;

/// The weight of the coefficients beside that of a texel.
const SIDE: f64 = 0.125;
/// The weight of its own.
const OWN: f64 = 0.75;

/// The values at the centres of the texels of a `block` of `size`² texels and their ring, row by row from v = 0.
///
/// # Panics
/// If the block has other than (size + 2)² coefficients.
pub fn values(block: &[f16], size: usize) -> Vec<f32> {
    let stride = size + 2;
    assert_eq!(block.len(), stride * stride, "the block has a ring");
    let block = block.to_f32_vec();
    let (own, side) = (OWN as f32, SIDE as f32);
    let mut along = Vec::with_capacity(stride * size);
    for row in block.chunks_exact(stride) {
        along.extend((1..=size).map(|i| own * row[i] + side * (row[i - 1] + row[i + 1])));
    }
    let mut values = Vec::with_capacity(size * size);
    for j in 1..=size {
        let [before, row, after] = [j - 1, j, j + 1].map(|j| &along[j * size..][..size]);
        values.extend((0..size).map(|i| own * row[i] + side * (before[i] + after[i])));
    }
    values
}

/// The coefficients of the texels whose values at the centres are `values`, where `block` has the ring.
///
/// # Panics
/// If there are not size² values and (size + 2)² coefficients.
pub fn coefficients(values: &[f32], block: &[f16], size: usize) -> Vec<f32> {
    let stride = size + 2;
    assert_eq!((values.len(), block.len()), (size * size, stride * stride), "values and ring of one tile");
    let at = |j: usize, i: usize| block[j * stride + i].to_f64();
    let factors = factors(size);
    // What the rows are after the sums along them: known in the ring, solved for inside.
    let beyond = |j: usize, i: usize| OWN * at(j, i) + SIDE * (at(j, i - 1) + at(j, i + 1));
    let mut rows: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
    for i in 0..size {
        rows[i] -= SIDE * beyond(0, i + 1);
        rows[(size - 1) * size + i] -= SIDE * beyond(size + 1, i + 1);
    }
    for j in 0..size {
        for i in 0..size {
            let before = if j == 0 { 0.0 } else { rows[(j - 1) * size + i] };
            rows[j * size + i] = (rows[j * size + i] - SIDE * before) * factors[j].0;
        }
    }
    for j in (0..size - 1).rev() {
        for i in 0..size {
            rows[j * size + i] -= factors[j].1 * rows[(j + 1) * size + i];
        }
    }
    for (j, row) in rows.chunks_exact_mut(size).enumerate() {
        row[0] -= SIDE * at(j + 1, 0);
        row[size - 1] -= SIDE * at(j + 1, size + 1);
        let mut before = 0.0;
        for (value, (inverse, _)) in row.iter_mut().zip(&factors) {
            *value = (*value - SIDE * before) * inverse;
            before = *value;
        }
        for i in (0..size - 1).rev() {
            row[i] -= factors[i].1 * row[i + 1];
        }
    }
    rows.into_iter().map(|value| value as f32).collect()
}

/// Of every row of the tridiagonal system, the inverse of its pivot and what the row after it is multiplied by.
fn factors(size: usize) -> Vec<(f64, f64)> {
    let mut upper = 0.0;
    (0..size)
        .map(|_| {
            let inverse = 1.0 / (OWN - SIDE * upper);
            upper = SIDE * inverse;
            (inverse, upper)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use relievo_core::simd::Level;
    use relievo_surface::Order;
    use relievo_testing::Random;
    use relievo_tiles::spline::{self, Jets};

    use super::*;

    fn block(size: usize, seed: u64) -> Vec<f16> {
        let mut random = Random(seed);
        (0..(size + 2) * (size + 2)).map(|_| f16::from_f32(random.unit() * 2.0 - 1.0)).collect()
    }

    #[test]
    fn values_are_those_of_the_spline_at_the_centres() {
        for size in [8, 32] {
            let block = block(size, 7);
            let centres: Vec<f32> = (0..size).map(|i| (i as f32 + 0.5) / size as f32).collect();
            let mut jets = Jets::default();
            spline::grid(Level::best(), &block, size as u32, &centres, &centres, Order::Position, &mut jets);
            for (value, expected) in values(&block, size).into_iter().zip(jets.d) {
                assert!((value - expected).abs() < 1e-6, "{value} {expected}");
            }
        }
    }

    #[test]
    fn coefficients_of_values_are_the_coefficients() {
        for size in [8, 64] {
            let block = block(size, 3);
            let found = coefficients(&values(&block, size), &block, size);
            for (j, row) in found.chunks_exact(size).enumerate() {
                for (i, value) in row.iter().enumerate() {
                    let expected = block[(j + 1) * (size + 2) + i + 1].to_f32();
                    assert!((value - expected).abs() < 2e-6, "{value} {expected}");
                }
            }
        }
    }
}
