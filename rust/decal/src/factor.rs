//! Sparse symmetric systems over the free vertices of a patch, two unknowns each, solved by faer's Cholesky factorisation.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};
use relievo_core::{Error, Result};

/// Stands for a vertex that is no unknown.
pub const PINNED: u32 = u32::MAX;

/// Attempts to factorise a matrix, with more on the diagonal each time.
const ATTEMPTS: i32 = 5;

/// The upper half of a symmetric matrix of 2x2 blocks, one block row for each free vertex, and its factor.
pub struct System {
    /// The block row of each vertex, or [`PINNED`]. Rows are in an order of little fill-in.
    rows: Vec<u32>,
    matrix: SymbolicSparseColMat<u32>,
    values: Vec<f64>,
    /// Where the entries of each face go: for its three edges the first entries of both columns, for its corners the
    /// last entry of the first column.
    slots: Vec<FaceSlots>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

#[derive(Clone, Copy)]
struct FaceSlots {
    /// For the pairs of corners (0, 1), (1, 2), (2, 0): the corner of the lower row, and the two places.
    pairs: [Option<(bool, u32, u32)>; 3],
    diagonals: [Option<(u32, u32)>; 3],
}

impl std::fmt::Debug for System {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("System").field("unknowns", &self.unknowns()).finish_non_exhaustive()
    }
}

/// Turns a failure of faer into an error.
fn failed(what: &str) -> Error {
    Error::internal(format!("the linear system of the decal cannot be solved: {what}"))
}

impl System {
    /// Makes the system of a triangulation with `count` vertices. `is_pinned` names the vertices that are no unknowns.
    ///
    /// # Errors
    /// Memory does not suffice.
    pub fn new(count: usize, faces: &[[u32; 3]], is_pinned: &[bool]) -> Result<Self> {
        let mut free = 0;
        let numbers: Vec<u32> = (0..count)
            .map(|vertex| {
                if is_pinned[vertex] {
                    return PINNED;
                }
                free += 1;
                free - 1
            })
            .collect();
        let free = free as usize;
        let order = ordering(free, &neighbours(free, faces, &numbers))?;
        let rows: Vec<u32> =
            numbers.iter().map(|row| if *row == PINNED { PINNED } else { order[*row as usize] }).collect();
        let lower = neighbours(free, faces, &rows);

        let mut starts = Vec::with_capacity(2 * free + 1);
        let mut indices = Vec::with_capacity(2 * free + 4 * lower.items.len());
        starts.push(0_u32);
        for row in 0..free {
            for column in 0..2 {
                indices.extend(lower.of(row).iter().flat_map(|other| [2 * other, 2 * other + 1]));
                indices.extend((0..=column).map(|part| 2 * row as u32 + part));
                starts.push(indices.len() as u32);
            }
        }
        let slot = |a: u32, b: u32| {
            let place = lower.of(b as usize).binary_search(&a).unwrap_or_default() as u32;
            (starts[2 * b as usize] + 2 * place, starts[2 * b as usize + 1] + 2 * place)
        };
        let slots = faces.iter().map(|face| {
            let row = face.map(|vertex| rows[vertex as usize]);
            let pairs = std::array::from_fn(|pair| {
                let (a, b) = (row[pair], row[(pair + 1) % 3]);
                let is_usable = a != PINNED && b != PINNED;
                is_usable.then(|| {
                    let (first, second) = slot(a.min(b), a.max(b));
                    (a < b, first, second)
                })
            });
            let diagonals = row.map(|row| {
                (row != PINNED).then(|| {
                    let end = 2 * row as usize + 1;
                    (starts[end] - 1, starts[end + 1] - 2)
                })
            });
            FaceSlots { pairs, diagonals }
        });
        let slots = slots.collect();
        let values = vec![0.0; indices.len()];
        let matrix = SymbolicSparseColMat::new_checked(2 * free, 2 * free, starts, None, indices);
        let symbolic = factorize_symbolic_cholesky(
            matrix.as_ref(),
            Side::Upper,
            SymmetricOrdering::Identity,
            CholeskySymbolicParams::default(),
        )
        .map_err(|_| Error::memory("the factor of the decal's linear system does not fit into memory"))?;
        let factor = vec![0.0; symbolic.len_val()];
        let need = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let memory = MemBuffer::new(need.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq)));
        Ok(Self { rows, matrix, values, slots, symbolic, factor, memory })
    }

    /// Returns the number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.matrix.nrows()
    }

    /// Returns the block row of a vertex, or [`PINNED`].
    pub fn row(&self, vertex: usize) -> u32 {
        self.rows[vertex]
    }

    /// Sets every entry to zero, those of the diagonal to `shift`.
    pub fn clear(&mut self, shift: f64) {
        self.values.fill(0.0);
        for column in 0..self.matrix.ncols() {
            let end = self.matrix.col_ptr()[column + 1] as usize;
            self.values[end - 1] = shift;
        }
    }

    /// Adds a number to the diagonal.
    fn shift(&mut self, by: f64) {
        for column in 0..self.matrix.ncols() {
            let end = self.matrix.col_ptr()[column + 1] as usize;
            self.values[end - 1] += by;
        }
    }

    /// Adds the matrix of a face, two rows and columns for each of its corners.
    pub fn add(&mut self, face: usize, matrix: &[[f64; 6]; 6]) {
        let FaceSlots { pairs, diagonals } = self.slots[face];
        for (corner, slot) in diagonals.iter().enumerate() {
            if let Some((first, second)) = slot {
                let (first, second, at) = (*first as usize, *second as usize, 2 * corner);
                self.values[first] += matrix[at][at];
                self.values[second] += matrix[at][at + 1];
                self.values[second + 1] += matrix[at + 1][at + 1];
            }
        }
        for (pair, slot) in pairs.iter().enumerate() {
            if let Some((is_ordered, first, second)) = slot {
                let (first, second) = (*first as usize, *second as usize);
                let (here, there) = (2 * pair, 2 * ((pair + 1) % 3));
                let (low, high) = if *is_ordered { (here, there) } else { (there, here) };
                self.values[first] += matrix[low][high];
                self.values[first + 1] += matrix[low + 1][high];
                self.values[second] += matrix[low][high + 1];
                self.values[second + 1] += matrix[low + 1][high + 1];
            }
        }
    }

    /// Factorises the matrix. Where rounding made it indefinite, the diagonal grows until it is not.
    ///
    /// # Errors
    /// An entry is not finite, or the entries differ too much in size.
    pub fn factorise(&mut self) -> Result<()> {
        let ends = self.matrix.col_ptr()[1..].iter().map(|end| self.values[*end as usize - 1]);
        let largest = ends.fold(0.0, f64::max);
        for attempt in 0..ATTEMPTS {
            let matrix = SparseColMatRef::new(self.matrix.as_ref(), &self.values);
            let factor = self.symbolic.factorize_numeric_llt(
                &mut self.factor,
                matrix,
                Side::Upper,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            );
            if factor.is_ok() {
                return Ok(());
            }
            self.shift(1e-12 * 100.0_f64.powi(attempt) * largest);
        }
        Err(Error::invalid("the map of the decal degenerates")
            .at("decal")
            .advise("move the pins towards the places where the sticker lies without them, or remove some"))
    }

    /// Replaces the right side, two numbers for each block row, by the solution.
    pub fn solve(&mut self, side: &mut [f64]) {
        let factor = LltRef::new(&self.symbolic, &self.factor);
        let rows = side.len();
        let side = MatMut::from_column_major_slice_mut(side, rows, 1);
        factor.solve_in_place_with_conj(Conj::No, side, Par::Seq, MemStack::new(&mut self.memory));
    }
}

/// Lists of numbers, one after the other.
struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    fn of(&self, list: usize) -> &[u32] {
        &self.items[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}

/// The neighbours of each row with smaller numbers, sorted.
fn neighbours(count: usize, faces: &[[u32; 3]], rows: &[u32]) -> Lists {
    let mut pairs: Vec<u64> = Vec::with_capacity(3 * faces.len());
    for face in faces {
        for corner in 0..3 {
            let (a, b) = (rows[face[corner] as usize], rows[face[(corner + 1) % 3] as usize]);
            if a != PINNED && b != PINNED && a != b {
                pairs.push(u64::from(a.max(b)) << 32 | u64::from(a.min(b)));
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut starts = vec![0; count + 1];
    for pair in &pairs {
        starts[(pair >> 32) as usize + 1] += 1;
    }
    for row in 0..count {
        starts[row + 1] += starts[row];
    }
    Lists { starts, items: pairs.iter().map(|pair| *pair as u32).collect() }
}

/// The place of each row in an order of little fill-in (approximate minimum degree).
fn ordering(count: usize, lower: &Lists) -> Result<Vec<u32>> {
    let (mut order, mut places) = (vec![0_u32; count], vec![0_u32; count]);
    let matrix = SymbolicSparseColMat::new_checked(count, count, lower.starts.clone(), None, lower.items.clone());
    let need = amd::order_scratch::<u32>(count, lower.items.len());
    let mut memory = MemBuffer::new(need);
    amd::order(&mut order, &mut places, matrix.as_ref(), amd::Control::default(), MemStack::new(&mut memory))
        .map_err(|_| failed("its unknowns cannot be ordered"))?;
    Ok(places)
}
