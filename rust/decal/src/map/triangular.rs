//! Solves with faer's Cholesky factors of 32 bits, for two right sides at once.
//!
//! A factor of a patch consists of many small dense blocks. Calls of a library for each of them take longer than the
//! arithmetic, so each block is read here, once for both sides, as many rows at a time as a vector has lanes.

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

/// Values after a factor, since the last rows of a column are read together with what follows: those of the widest vector.
pub const BEYOND: usize = 16;

/// The rows of a block's pattern, vector by vector, each with both right sides one after the other. It is kept from call to
/// call.
pub type Work = Vec<f32>;

/// Replaces the diagonal of a factor by its inverses, as [`solve`] takes it.
pub fn invert_diagonal(symbolic: &SymbolicSupernodalCholesky<u32>, factor: &mut [f32]) {
    let (starts, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
    let (patterns, places) = (symbolic.col_ptr_for_row_idx(), symbolic.col_ptr_for_val());
    for at in 0..starts.len() {
        let columns = (ends[at] - starts[at]) as usize;
        let height = columns + (patterns[at + 1] - patterns[at]) as usize;
        for column in 0..columns {
            let value = &mut factor[places[at] as usize + column * (height + 1)];
            *value = value.recip();
        }
    }
}

/// Replaces right sides by solutions. The rows of the factor are in the order of the sides. A block of the factor has the rows
/// of its own columns and after them those of its pattern, column by column; its diagonal is that of [`invert_diagonal`]. [`BEYOND`] finite
/// values follow the factor.
pub fn solve(symbolic: &SymbolicSupernodalCholesky<u32>, factor: &[f32], sides: &mut [[f32; 2]], work: &mut Work) {
    sweep(Level::best(), symbolic, factor, sides, work);
}

dispatch_simd! {
    fn sweep = sweep_body(
        symbolic: &SymbolicSupernodalCholesky<u32>, factor: &[f32], sides: &mut [[f32; 2]], work: &mut Work,
    )
}

#[inline(always)]
fn sweep_body<A: Lanes>(
    vectors: A,
    symbolic: &SymbolicSupernodalCholesky<u32>,
    factor: &[f32],
    sides: &mut [[f32; 2]],
    work: &mut Work,
) {
    let (starts, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
    let (rows, patterns) = (symbolic.row_idx(), symbolic.col_ptr_for_row_idx());
    let places = symbolic.col_ptr_for_val();
    let block = |at: usize| {
        let pattern = &rows[patterns[at] as usize..patterns[at + 1] as usize];
        (starts[at] as usize..ends[at] as usize, pattern, &factor[places[at] as usize..])
    };
    let mut lanes = [[0.0; BEYOND]; 2];
    for at in 0..starts.len() {
        let (own, pattern, values) = block(at);
        // Rows of a pattern follow the block's own.
        let (before, after) = sides.split_at_mut(own.end);
        let (end, height) = (own.end, own.len() + pattern.len());
        let own = &mut before[own.start..];
        for column in 0..own.len() {
            let values = &values[column * height + column..column * height + own.len()];
            let [x, y] = own[column].map(|side| side * values[0]);
            own[column] = [x, y];
            for (side, value) in own[column + 1..].iter_mut().zip(&values[1..]) {
                *side = [A::fma(-value, x, side[0]), A::fma(-value, y, side[1])];
            }
        }
        for (chunk, pattern) in pattern.chunks(A::WIDTH).enumerate() {
            let mut sums = [vectors.splat(0.0); 2];
            let mut place = own.len() + chunk * A::WIDTH;
            for [x, y] in own.iter() {
                let column = vectors.load(&values[place..]);
                sums[0] = vectors.fused(column, vectors.splat(*x), sums[0]);
                sums[1] = vectors.fused(column, vectors.splat(*y), sums[1]);
                place += height;
            }
            vectors.store(sums[0], &mut lanes[0]);
            vectors.store(sums[1], &mut lanes[1]);
            for (row, (x, y)) in pattern.iter().zip(lanes[0].iter().zip(&lanes[1])) {
                let side = &mut after[*row as usize - end];
                *side = [side[0] - x, side[1] - y];
            }
        }
    }
    for at in (0..starts.len()).rev() {
        let (own, pattern, values) = block(at);
        let (columns, height) = (own.len(), own.len() + pattern.len());
        // Rows past the pattern are zero, so that what follows a column counts nothing.
        work.clear();
        work.resize(2 * pattern.len().next_multiple_of(A::WIDTH), 0.0);
        for (pattern, both) in pattern.chunks(A::WIDTH).zip(work.chunks_exact_mut(2 * A::WIDTH)) {
            let (first, second) = both.split_at_mut(A::WIDTH);
            for (row, (x, y)) in pattern.iter().zip(first.iter_mut().zip(second)) {
                [*x, *y] = sides[*row as usize];
            }
        }
        let own = &mut sides[own];
        for column in (0..columns).rev() {
            let values = &values[column * height..];
            let mut sums = [vectors.splat(0.0); 2];
            let mut place = columns;
            for both in work.chunks_exact(2 * A::WIDTH) {
                let column = vectors.load(&values[place..]);
                sums[0] = vectors.fused(column, vectors.load(both), sums[0]);
                sums[1] = vectors.fused(column, vectors.load(&both[A::WIDTH..]), sums[1]);
                place += A::WIDTH;
            }
            vectors.store(sums[0], &mut lanes[0]);
            vectors.store(sums[1], &mut lanes[1]);
            let [mut x, mut y] = [0, 1].map(|side| lanes[side][..A::WIDTH].iter().sum::<f32>());
            for (value, side) in values[column + 1..columns].iter().zip(&own[column + 1..]) {
                (x, y) = (A::fma(*value, side[0], x), A::fma(*value, side[1], y));
            }
            own[column] = [(own[column][0] - x) * values[column], (own[column][1] - y) * values[column]];
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::linalg::cholesky::llt::factor::LltRegularization;
    use faer::sparse::linalg::SupernodalThreshold;
    use faer::sparse::linalg::cholesky::{
        CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
    };
    use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
    use faer::{Par, Side};

    use super::*;

    /// The upper half of the matrix of a square of vertices, each joined to its four neighbours.
    fn matrix(side: u32) -> (SymbolicSparseColMat<u32>, Vec<f32>) {
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for vertex in 0..side * side {
            let below = (vertex >= side).then(|| vertex - side);
            let left = (vertex % side > 0).then(|| vertex - 1);
            for other in below.into_iter().chain(left) {
                rows.push(other);
                values.push(-1.0);
            }
            rows.push(vertex);
            values.push(4.5);
            starts.push(rows.len() as u32);
        }
        let count = (side * side) as usize;
        (SymbolicSparseColMat::new_checked(count, count, starts, None, rows), values)
    }

    #[test]
    fn a_factor_solves_for_both_sides() {
        let (matrix, values) = matrix(20);
        let expected = |row: usize| [(row as f32).sin(), (0.3 * row as f32).cos()];
        let count = matrix.nrows();
        let mut sides = vec![[0.0; 2]; count];
        for column in 0..count {
            for place in matrix.col_range(column) {
                let (row, value) = (matrix.row_idx()[place] as usize, values[place]);
                for axis in 0..2 {
                    sides[row][axis] += value * expected(column)[axis];
                    sides[column][axis] += if row == column { 0.0 } else { value * expected(row)[axis] };
                }
            }
        }
        let threshold = SupernodalThreshold::FORCE_SUPERNODAL;
        let params =
            CholeskySymbolicParams { supernodal_flop_ratio_threshold: threshold, ..CholeskySymbolicParams::default() };
        let symbolic = factorize_symbolic_cholesky(matrix.as_ref(), Side::Upper, SymmetricOrdering::Identity, params)
            .expect("a factor");
        let mut factor = vec![0.0; symbolic.len_val() + BEYOND];
        let mut memory = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f32>(Par::Seq, Default::default()));
        let made = symbolic.factorize_numeric_llt(
            &mut factor[..symbolic.len_val()],
            SparseColMatRef::new(matrix.as_ref(), &values),
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        assert!(made.is_ok());
        let SymbolicCholeskyRaw::Supernodal(blocks) = symbolic.raw() else { panic!("no blocks") };
        invert_diagonal(blocks, &mut factor);
        solve(blocks, &factor, &mut sides, &mut Work::default());
        for (row, found) in sides.iter().enumerate() {
            let expected = expected(row);
            assert!((0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-5), "{row}: {found:?} {expected:?}");
        }
    }
}
