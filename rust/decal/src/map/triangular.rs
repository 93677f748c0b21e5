//! Solves with faer's Cholesky factors of 32 bits, for two right sides at once.
//!
//! A factor of a patch consists of many small dense blocks. Calls of a library for each of them take longer than the
//! arithmetic, so the columns of each block are read here, once for both sides.

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

/// Partial sums of a scalar product.
const LANES: usize = 8;

/// The rows of a block for both right sides, kept from call to call.
#[derive(Debug, Default)]
pub struct Work {
    first: Vec<f32>,
    second: Vec<f32>,
}

/// Replaces right sides by solutions. The rows of the factor are in the order of the sides. A block of the factor has the rows
/// of its own columns and after them those of its pattern, column by column.
pub fn solve(symbolic: &SymbolicSupernodalCholesky<u32>, factor: &[f32], sides: &mut [[f32; 2]], work: &mut Work) {
    let (starts, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
    let (rows, patterns) = (symbolic.row_idx(), symbolic.col_ptr_for_row_idx());
    let places = symbolic.col_ptr_for_val();
    let block = |at: usize| {
        let pattern = &rows[patterns[at] as usize..patterns[at + 1] as usize];
        (starts[at] as usize..ends[at] as usize, pattern, &factor[places[at] as usize..places[at + 1] as usize])
    };
    let Work { first, second } = work;
    for at in 0..starts.len() {
        let (own, pattern, values) = block(at);
        let (columns, height) = (own.len(), own.len() + pattern.len());
        first.clear();
        second.clear();
        first.extend(sides[own.clone()].iter().map(|side| side[0]));
        second.extend(sides[own.clone()].iter().map(|side| side[1]));
        first.resize(height, 0.0);
        second.resize(height, 0.0);
        for column in 0..columns {
            let values = &values[column * height + column..(column + 1) * height];
            let (x, y) = (first[column] / values[0], second[column] / values[0]);
            (first[column], second[column]) = (x, y);
            let below = first[column + 1..].iter_mut().zip(&mut second[column + 1..]);
            for ((first, second), value) in below.zip(&values[1..]) {
                *first -= value * x;
                *second -= value * y;
            }
        }
        for (side, (x, y)) in sides[own].iter_mut().zip(first.iter().zip(second.iter())) {
            *side = [*x, *y];
        }
        for (row, (x, y)) in pattern.iter().zip(first[columns..].iter().zip(&second[columns..])) {
            let side = &mut sides[*row as usize];
            side[0] += x;
            side[1] += y;
        }
    }
    for at in (0..starts.len()).rev() {
        let (own, pattern, values) = block(at);
        let (columns, height) = (own.len(), own.len() + pattern.len());
        first.clear();
        second.clear();
        let all = sides[own.clone()].iter().chain(pattern.iter().map(|row| &sides[*row as usize]));
        all.for_each(|[x, y]| {
            first.push(*x);
            second.push(*y);
        });
        for column in (0..columns).rev() {
            let values = &values[column * height + column..(column + 1) * height];
            let [x, y] = products(&values[1..], &first[column + 1..], &second[column + 1..]);
            first[column] = (first[column] - x) / values[0];
            second[column] = (second[column] - y) / values[0];
        }
        for (side, (x, y)) in sides[own].iter_mut().zip(first.iter().zip(second.iter())) {
            *side = [*x, *y];
        }
    }
}

/// The scalar products of a column with two others of its length.
fn products(column: &[f32], first: &[f32], second: &[f32]) -> [f32; 2] {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    let (whole, rest) = column.as_chunks::<LANES>();
    let (firsts, first) = first.as_chunks::<LANES>();
    let (seconds, second) = second.as_chunks::<LANES>();
    for (column, (first, second)) in whole.iter().zip(firsts.iter().zip(seconds)) {
        for lane in 0..LANES {
            x[lane] += column[lane] * first[lane];
            y[lane] += column[lane] * second[lane];
        }
    }
    for (lane, (column, (first, second))) in rest.iter().zip(first.iter().zip(second)).enumerate() {
        x[lane] += column * first;
        y[lane] += column * second;
    }
    [x.iter().sum(), y.iter().sum()]
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
        let mut factor = vec![0.0; symbolic.len_val()];
        let mut memory = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f32>(Par::Seq, Default::default()));
        let made = symbolic.factorize_numeric_llt(
            &mut factor,
            SparseColMatRef::new(matrix.as_ref(), &values),
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        assert!(made.is_ok());
        let SymbolicCholeskyRaw::Supernodal(blocks) = symbolic.raw() else { panic!("no blocks") };
        solve(blocks, &factor, &mut sides, &mut Work::default());
        for (row, found) in sides.iter().enumerate() {
            let expected = expected(row);
            assert!((0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-5), "{row}: {found:?} {expected:?}");
        }
    }
}
