//! Sparse symmetric systems over the free vertices of a patch, two unknowns each, solved by conjugate gradients.
//!
//! The preconditioner is faer's Cholesky factor of the matrix, scaled to a unit diagonal, in 32 bits. It has half the size of
//! a factor in 64 bits, and is so near to the inverse that few steps suffice.

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

/// Attempts to factorise the preconditioner, with more on the diagonal each time.
const ATTEMPTS: i32 = 5;
/// The residual that a solution may have, as a share of that of zero, in the norm of the preconditioner.
const TOLERANCE: f64 = 1e-8;
/// Steps of conjugate gradients.
const STEPS: usize = 100;

/// A symmetric matrix of 2x2 blocks, one block row for each free vertex, and its preconditioner.
pub struct System {
    /// The block row of each vertex, or [`PINNED`]. Rows are in an order of little fill-in.
    rows: Vec<u32>,
    /// The neighbours of each row with smaller numbers, sorted, with the blocks of their rows and its columns.
    lower: Lists,
    blocks: Vec<[f64; 4]>,
    /// The first, the mixed and the last entry of the blocks on the diagonal.
    diagonal: Vec<[f64; 3]>,
    preconditioner: Preconditioner,
}

/// The factor of the matrix.
struct Preconditioner {
    /// The upper half, the diagonal last in each column.
    matrix: SymbolicSparseColMat<u32>,
    values: Vec<f32>,
    /// Reciprocals of the roots of the diagonal.
    scales: Vec<f64>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f32>,
    /// The right side and the solution.
    side: Vec<f32>,
    memory: MemBuffer,
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
        let mut rows: Vec<u32> = (0..count)
            .map(|vertex| {
                if is_pinned[vertex] {
                    return PINNED;
                }
                free += 1;
                free - 1
            })
            .collect();
        let free = free as usize;
        let order = ordering(free, neighbours(free, faces, &rows))?;
        for row in rows.iter_mut().filter(|row| **row != PINNED) {
            *row = order[*row as usize];
        }
        drop(order);
        let lower = neighbours(free, faces, &rows);
        let preconditioner = Preconditioner::new(free, &lower)?;
        let (blocks, diagonal) = (vec![[0.0; 4]; lower.items.len()], vec![[0.0; 3]; free]);
        Ok(Self { rows, lower, blocks, diagonal, preconditioner })
    }

    /// Returns the number of unknowns.
    pub fn unknowns(&self) -> usize {
        2 * self.diagonal.len()
    }

    /// Returns the block row of a vertex, or [`PINNED`].
    pub fn row(&self, vertex: usize) -> u32 {
        self.rows[vertex]
    }

    /// Sets every entry to zero, those of the diagonal to `shift`.
    pub fn clear(&mut self, shift: f64) {
        self.blocks.fill([0.0; 4]);
        self.diagonal.fill([shift, 0.0, shift]);
    }

    /// Adds the matrix of a face, two rows and columns for each of its corners.
    pub fn add(&mut self, face: [u32; 3], matrix: &[[f64; 6]; 6]) {
        let rows = face.map(|vertex| self.rows[vertex as usize]);
        for (corner, row) in rows.into_iter().enumerate().filter(|(_, row)| *row != PINNED) {
            let at = 2 * corner;
            let entries = &mut self.diagonal[row as usize];
            entries[0] += matrix[at][at];
            entries[1] += matrix[at][at + 1];
            entries[2] += matrix[at + 1][at + 1];
            let after = (corner + 1) % 3;
            let other = rows[after];
            if other == PINNED || other == row {
                continue;
            }
            // Rows of the smaller number, columns of the larger one.
            let (low, high) = if row < other { (at, 2 * after) } else { (2 * after, at) };
            if let Some(place) = self.lower.place(row.max(other) as usize, row.min(other)) {
                let block = &mut self.blocks[place];
                block[0] += matrix[low][high];
                block[1] += matrix[low][high + 1];
                block[2] += matrix[low + 1][high];
                block[3] += matrix[low + 1][high + 1];
            }
        }
    }

    /// Factorises the preconditioner. Where rounding made it indefinite, the diagonal grows until it is not.
    ///
    /// # Errors
    /// An entry is not finite, or the entries differ too much in size.
    pub fn factorise(&mut self) -> Result<()> {
        let Self { lower, blocks, diagonal, preconditioner, .. } = self;
        for (scales, [first, _, last]) in preconditioner.scales.as_chunks_mut::<2>().0.iter_mut().zip(diagonal.iter()) {
            *scales = [first, last].map(|entry| entry.sqrt().recip());
            if !scales.iter().all(|scale| scale.is_finite()) {
                return Err(degenerate());
            }
        }
        for attempt in 0..ATTEMPTS {
            let shift = if attempt == 0 { 0.0 } else { 1e-6 * 10.0_f32.powi(attempt) };
            preconditioner.fill(lower, blocks, diagonal, 1.0 + shift);
            if preconditioner.factorise() {
                return Ok(());
            }
        }
        Err(degenerate())
    }

    /// Replaces the right side, two numbers for each block row, by the solution.
    pub fn solve(&mut self, side: &mut [f64]) {
        let count = side.len();
        let (mut solution, mut ahead, mut image) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let mut residual = side.to_vec();
        self.preconditioner.apply(&residual, &mut ahead);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut size = product(&residual, &ahead);
        let enough = TOLERANCE * TOLERANCE * size;
        for _ in 0..STEPS {
            self.multiply(&ahead, &mut image);
            let curvature = product(&ahead, &image);
            let length = size / curvature;
            if !(curvature > 0.0 && length.is_finite()) {
                break;
            }
            for index in 0..count {
                solution[index] += length * ahead[index];
                residual[index] -= length * image[index];
            }
            // From here on the image is the preconditioned residual.
            self.preconditioner.apply(&residual, &mut image);
            let left = product(&residual, &image);
            if !(left > enough) {
                break;
            }
            let share = left / size;
            size = left;
            for (ahead, other) in ahead.iter_mut().zip(&image) {
                *ahead = other + share * *ahead;
            }
        }
        side.copy_from_slice(&solution);
    }

    /// Multiplies the matrix by a vector.
    fn multiply(&self, vector: &[f64], image: &mut [f64]) {
        let (vector, image) = (vector.as_chunks::<2>().0, image.as_chunks_mut::<2>().0);
        for (row, [first, mixed, last]) in self.diagonal.iter().enumerate() {
            let [x, y] = vector[row];
            let mut sum = [first * x + mixed * y, mixed * x + last * y];
            let range = self.lower.range(row);
            for (other, block) in self.lower.items[range.clone()].iter().zip(&self.blocks[range]) {
                let [u, v] = vector[*other as usize];
                sum[0] += block[0] * u + block[2] * v;
                sum[1] += block[1] * u + block[3] * v;
                // Rows of smaller numbers have their own sums by now.
                let below = &mut image[*other as usize];
                below[0] += block[0] * x + block[1] * y;
                below[1] += block[2] * x + block[3] * y;
            }
            image[row] = sum;
        }
    }
}

fn degenerate() -> Error {
    Error::invalid("the map of the decal degenerates")
        .at("decal")
        .advise("move the pins towards the places where the sticker lies without them, or remove some")
}

impl Preconditioner {
    fn new(count: usize, lower: &Lists) -> Result<Self> {
        let mut starts = Vec::with_capacity(2 * count + 1);
        let mut indices = Vec::with_capacity(3 * count + 4 * lower.items.len());
        starts.push(0_u32);
        for row in 0..count {
            for column in 0..2 {
                indices.extend(lower.items[lower.range(row)].iter().flat_map(|other| [2 * other, 2 * other + 1]));
                indices.extend((0..=column).map(|part| 2 * row as u32 + part));
                starts.push(indices.len() as u32);
            }
        }
        let values = vec![0.0; indices.len()];
        let matrix = SymbolicSparseColMat::new_checked(2 * count, 2 * count, starts, None, indices);
        let symbolic = factorize_symbolic_cholesky(
            matrix.as_ref(),
            Side::Upper,
            SymmetricOrdering::Identity,
            CholeskySymbolicParams::default(),
        )
        .map_err(|_| Error::memory("the factor of the decal's linear system does not fit into memory"))?;
        let factor = vec![0.0; symbolic.len_val()];
        let need = symbolic.factorize_numeric_llt_scratch::<f32>(Par::Seq, Default::default());
        let memory = MemBuffer::new(need.or(symbolic.solve_in_place_scratch::<f32>(1, Par::Seq)));
        Ok(Self { matrix, values, scales: vec![1.0; 2 * count], symbolic, factor, side: vec![0.0; 2 * count], memory })
    }

    /// Sets the matrix to the scaled one, with `unit` on the diagonal.
    fn fill(&mut self, lower: &Lists, blocks: &[[f64; 4]], diagonal: &[[f64; 3]], unit: f32) {
        let mut values = self.values.iter_mut();
        let mut put = |value: f64| {
            if let Some(place) = values.next() {
                *place = value as f32;
            }
        };
        let scales = self.scales.as_chunks::<2>().0;
        for (row, [first, second]) in scales.iter().enumerate() {
            let range = lower.range(row);
            let above = || lower.items[range.clone()].iter().zip(&blocks[range.clone()]);
            for (other, block) in above() {
                let [x, y] = scales[*other as usize];
                put(block[0] * x * first);
                put(block[2] * y * first);
            }
            put(f64::from(unit));
            for (other, block) in above() {
                let [x, y] = scales[*other as usize];
                put(block[1] * x * second);
                put(block[3] * y * second);
            }
            put(diagonal[row][1] * first * second);
            put(f64::from(unit));
        }
    }

    /// Factorises the matrix. Returns whether it is positive definite.
    fn factorise(&mut self) -> bool {
        let factor = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            SparseColMatRef::new(self.matrix.as_ref(), &self.values),
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        factor.is_ok() && self.factor.iter().all(|value| value.is_finite())
    }

    /// Solves for a right side.
    fn apply(&mut self, side: &[f64], solution: &mut [f64]) {
        // 32 bits hold any vector whose largest entry is 1.
        let scaled = side.iter().zip(&self.scales).map(|(value, scale)| (value * scale).abs());
        let norm = scaled.fold(0.0, f64::max);
        let unit = if norm > 0.0 { norm } else { 1.0 };
        for ((to, value), scale) in self.side.iter_mut().zip(side).zip(&self.scales) {
            *to = (value * scale / unit) as f32;
        }
        let factor = LltRef::new(&self.symbolic, &self.factor);
        let count = self.side.len();
        let side = MatMut::from_column_major_slice_mut(&mut self.side, count, 1);
        factor.solve_in_place_with_conj(Conj::No, side, Par::Seq, MemStack::new(&mut self.memory));
        for ((to, value), scale) in solution.iter_mut().zip(&self.side).zip(&self.scales) {
            *to = f64::from(*value) * scale * unit;
        }
    }
}

/// Lists of numbers, one after the other.
struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    fn range(&self, list: usize) -> std::ops::Range<usize> {
        self.starts[list] as usize..self.starts[list + 1] as usize
    }

    /// The place of an item among all.
    fn place(&self, list: usize, item: u32) -> Option<usize> {
        let range = self.range(list);
        let within = self.items[range.clone()].iter().position(|other| *other == item)?;
        Some(range.start + within)
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
fn ordering(count: usize, lower: Lists) -> Result<Vec<u32>> {
    let (mut order, mut places) = (vec![0_u32; count], vec![0_u32; count]);
    let need = amd::order_scratch::<u32>(count, lower.items.len());
    let matrix = SymbolicSparseColMat::new_checked(count, count, lower.starts, None, lower.items);
    let mut memory = MemBuffer::new(need);
    amd::order(&mut order, &mut places, matrix.as_ref(), amd::Control::default(), MemStack::new(&mut memory))
        .map_err(|_| failed("its unknowns cannot be ordered"))?;
    Ok(places)
}
