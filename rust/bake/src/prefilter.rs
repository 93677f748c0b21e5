//! Between the coefficients of a displacement and its values at the centres of texels, which is what other programs
//! take texels for.
//!
//! A biquadratic B-spline has at the centre of a texel ⅛, ¾ and ⅛ of three coefficients along u and along v (Nießner
//! and Loop 2013, Section 3). Going back is a tridiagonal system along columns, then along rows, whose ends are the
//! ring's coefficients: the prefilter of Unser, Aldroubi and Eden 1991, exact for a tile whose ring is known. Units:
//! object units.

use half::f16;
use relievo_tiles::Texel;
use relievo_tiles::texel::Vector;

/// A texel of coefficients.
pub trait SplineTexel: Texel {
    /// How many there are.
    const NUMBERS: usize;

    /// Appends them.
    fn append(self, out: &mut Vec<f32>);

    /// The nearest texel to these numbers.
    fn of(numbers: &[f32]) -> Self;
}

/// Zeros are positive.
fn nearest(number: f32) -> f16 {
    let number = f16::from_f32(number.clamp(-65504.0, 65504.0));
    if number == f16::ZERO { f16::ZERO } else { number }
}

impl SplineTexel for f16 {
    const NUMBERS: usize = 1;

    fn append(self, out: &mut Vec<f32>) {
        out.push(self.to_f32());
    }

    fn of(numbers: &[f32]) -> Self {
        numbers.first().copied().map_or(f16::ZERO, nearest)
    }
}

impl SplineTexel for Vector {
    const NUMBERS: usize = 3;

    fn append(self, out: &mut Vec<f32>) {
        out.extend(self.0.map(f16::to_f32));
    }

    fn of(numbers: &[f32]) -> Self {
        Self(std::array::from_fn(|axis| numbers.get(axis).copied().map_or(f16::ZERO, nearest)))
    }
}

/// The weight of the coefficients beside that of a texel.
const SIDE: f64 = 0.125;
/// The weight of its own.
const OWN: f64 = 0.75;

/// The numbers of a block, texel after texel.
fn numbers<T: SplineTexel>(block: &[T]) -> Vec<f32> {
    let mut numbers = Vec::with_capacity(block.len() * T::NUMBERS);
    block.iter().for_each(|texel| texel.append(&mut numbers));
    numbers
}

/// The values at the centres of the texels of a `block` of `size`² texels and their ring, row by row from v = 0, the
/// numbers of a texel together.
///
/// # Panics
/// If the block has other than (size + 2)² coefficients.
pub fn values<T: SplineTexel>(block: &[T], size: usize) -> Vec<f32> {
    let (stride, n) = (size + 2, T::NUMBERS);
    assert_eq!(block.len(), stride * stride, "the block has a ring");
    let block = numbers(block);
    let (own, side) = (OWN as f32, SIDE as f32);
    let mut along = Vec::with_capacity(stride * size * n);
    for row in block.chunks_exact(stride * n) {
        along.extend((n..(size + 1) * n).map(|i| own * row[i] + side * (row[i - n] + row[i + n])));
    }
    let width = size * n;
    let mut values = Vec::with_capacity(size * width);
    for j in 1..=size {
        let [before, row, after] = [j - 1, j, j + 1].map(|j| &along[j * width..][..width]);
        values.extend((0..width).map(|i| own * row[i] + side * (before[i] + after[i])));
    }
    values
}

/// The texels whose values at the centres are `values`, where `block` has the ring.
///
/// # Panics
/// If there are not the numbers of size² texels and (size + 2)² coefficients.
pub fn coefficients<T: SplineTexel>(values: &[f32], block: &[T], size: usize) -> Vec<T> {
    let (stride, n) = (size + 2, T::NUMBERS);
    assert_eq!((values.len(), block.len()), (size * size * n, stride * stride), "values and ring of one tile");
    let block = numbers(block);
    let at = |j: usize, i: usize| f64::from(block[j * stride * n + i]);
    let factors = factors(size);
    // What the rows are after the sums along them: known in the ring, solved for inside.
    let beyond = |j: usize, i: usize| OWN * at(j, i) + SIDE * (at(j, i - n) + at(j, i + n));
    let width = size * n;
    let mut rows: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
    for i in 0..width {
        rows[i] -= SIDE * beyond(0, i + n);
        rows[(size - 1) * width + i] -= SIDE * beyond(size + 1, i + n);
    }
    for j in 0..size {
        for i in 0..width {
            let before = if j == 0 { 0.0 } else { rows[(j - 1) * width + i] };
            rows[j * width + i] = (rows[j * width + i] - SIDE * before) * factors[j].0;
        }
    }
    for j in (0..size - 1).rev() {
        for i in 0..width {
            rows[j * width + i] -= factors[j].1 * rows[(j + 1) * width + i];
        }
    }
    for (j, row) in rows.chunks_exact_mut(width).enumerate() {
        for i in 0..n {
            row[i] -= SIDE * at(j + 1, i);
            row[width - n + i] -= SIDE * at(j + 1, (size + 1) * n + i);
        }
        for i in 0..width {
            let before = if i < n { 0.0 } else { row[i - n] };
            row[i] = (row[i] - SIDE * before) * factors[i / n].0;
        }
        for i in (0..width - n).rev() {
            row[i] -= factors[i / n].1 * row[i + n];
        }
    }
    let rows: Vec<f32> = rows.into_iter().map(|value| value as f32).collect();
    rows.chunks_exact(n).map(T::of).collect()
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
    fn vectors_are_three_numbers_that_do_not_know_of_each_other() {
        let size = 16;
        let planes = [1, 2, 3].map(|seed| block(size, seed));
        let vectors: Vec<Vector> =
            (0..planes[0].len()).map(|k| Vector([0, 1, 2].map(|axis| planes[axis][k]))).collect();
        let made = values(&vectors, size);
        for (axis, plane) in planes.iter().enumerate() {
            assert!(values(plane, size).iter().eq(made.iter().skip(axis).step_by(3)));
        }
        let found = coefficients(&made, &vectors, size);
        for (j, row) in found.chunks_exact(size).enumerate() {
            assert_eq!(row, &vectors[(j + 1) * (size + 2) + 1..][..size]);
        }
    }

    #[test]
    fn coefficients_of_values_are_the_coefficients() {
        for size in [8, 64] {
            let block = block(size, 3);
            let found = coefficients(&values(&block, size), &block, size);
            for (j, row) in found.chunks_exact(size).enumerate() {
                // Exactly: what the arithmetic leaves is far below the rounding of half floats.
                assert_eq!(row, &block[(j + 1) * (size + 2) + 1..][..size]);
            }
        }
    }
}
