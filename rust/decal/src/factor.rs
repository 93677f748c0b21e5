//! Sparse symmetric systems over the free vertices of a patch, two unknowns each, solved by conjugate gradients.
//!
//! The preconditioner scales the matrix to a unit matrix at each vertex, and takes the mean of the couplings of both
//! coordinates: one number for each pair of neighbours. faer's Cholesky factor of that, in 32 bits, serves both coordinates and
//! has an eighth of the size of a factor of the matrix itself in 64 bits.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SymbolicSupernodalParams, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Par, Side};
use relievo_core::{Error, Result};

use crate::triangular::{Work, solve};

/// Stands for a vertex that is no unknown.
pub const PINNED: u32 = u32::MAX;

/// Attempts to factorise the preconditioner, with more on the diagonal each time.
const ATTEMPTS: i32 = 5;
/// Columns of the factor that are merged into one block, up to a share of zeros in it: fewer than faer's own shares, whose
/// zeros were a quarter of the factor.
const MERGED: [(usize, f64); 4] = [(4, 0.3), (16, 0.2), (48, 0.05), (usize::MAX, 0.02)];
/// Steps of conjugate gradients.
const STEPS: usize = 100;
/// The least determinant of the block of a vertex, as a share of the square of its trace.
const FLATTEST: f64 = 1e-12;

/// A symmetric matrix of 2x2 blocks, one block row for each free vertex, and its preconditioner.
pub struct System {
    /// The block row of each vertex, or [`PINNED`]. Rows are in an order of little fill-in.
    rows: Vec<u32>,
    /// The neighbours of each row with smaller numbers, sorted, with the blocks of their rows and its columns.
    lower: Lists,
    blocks: Vec<[f32; 4]>,
    /// The first, the mixed and the last entry of the blocks on the diagonal.
    diagonal: Vec<[f64; 3]>,
    preconditioner: Preconditioner,
}

/// The factor of the mean couplings.
struct Preconditioner {
    /// The upper half, the diagonal last in each column.
    matrix: SymbolicSparseColMat<u32>,
    values: Vec<f32>,
    /// The inverse roots of the blocks on the diagonal: their first, mixed and last entries.
    roots: Vec<[f32; 3]>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f32>,
    /// The right sides and the solutions of both coordinates.
    side: Vec<[f32; 2]>,
    work: Work,
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
        let preconditioner = Preconditioner::new(&lower)?;
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
                block[0] += matrix[low][high] as f32;
                block[1] += matrix[low][high + 1] as f32;
                block[2] += matrix[low + 1][high] as f32;
                block[3] += matrix[low + 1][high + 1] as f32;
            }
        }
    }

    /// Factorises the preconditioner. Where rounding made it indefinite, the diagonal grows until it is not.
    ///
    /// # Errors
    /// An entry is not finite, or the entries differ too much in size.
    pub fn factorise(&mut self) -> Result<()> {
        let Self { lower, blocks, diagonal, preconditioner, .. } = self;
        for (root, block) in preconditioner.roots.iter_mut().zip(diagonal.iter()) {
            *root = inverse_root(*block).ok_or_else(degenerate)?;
        }
        for attempt in 0..ATTEMPTS {
            let shift = if attempt == 0 { 0.0 } else { 1e-6 * 10.0_f32.powi(attempt) };
            preconditioner.fill(lower, blocks, 1.0 + shift);
            if preconditioner.factorise() {
                return Ok(());
            }
        }
        Err(degenerate())
    }

    /// Replaces the right side, two numbers for each block row, by the solution. Its residual is at most `tolerance`, as a
    /// share of that of zero, in the norm of the preconditioner, unless that takes too many steps; the energy of any
    /// solution is less than that of zero.
    pub fn solve(&mut self, side: &mut [f64], tolerance: f64) {
        let count = side.len();
        let (mut solution, mut ahead, mut image) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        // The right side becomes the residual.
        self.preconditioner.apply(side, &mut ahead);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut size = product(side, &ahead);
        let enough = tolerance * tolerance * size;
        for _ in 0..STEPS {
            self.multiply(&ahead, &mut image);
            let curvature = product(&ahead, &image);
            let length = size / curvature;
            if !(curvature > 0.0 && length.is_finite()) {
                break;
            }
            for index in 0..count {
                solution[index] += length * ahead[index];
                side[index] -= length * image[index];
            }
            // From here on the image is the preconditioned residual.
            self.preconditioner.apply(side, &mut image);
            let left = product(side, &image);
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
                let ([u, v], block) = (vector[*other as usize], block.map(f64::from));
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

/// The inverse of the root of a symmetric block of two rows, by its first, mixed and last entry. None of one that is not
/// finite or not positive.
fn inverse_root([first, mixed, last]: [f64; 3]) -> Option<[f32; 3]> {
    let trace = first + last;
    let root = (first * last - mixed * mixed).max(FLATTEST * trace * trace).sqrt();
    // The root is the block plus its determinant's root, over the root of its own trace.
    let scale = (root * (trace + 2.0 * root).sqrt()).recip();
    let entries = [(last + root) * scale, -mixed * scale, (first + root) * scale].map(|entry| entry as f32);
    (trace > 0.0 && entries.iter().all(|entry| entry.is_finite())).then_some(entries)
}

impl Preconditioner {
    fn new(lower: &Lists) -> Result<Self> {
        let count = lower.starts.len() - 1;
        let mut starts = Vec::with_capacity(count + 1);
        let mut indices = Vec::with_capacity(count + lower.items.len());
        starts.push(0_u32);
        for row in 0..count {
            indices.extend(&lower.items[lower.range(row)]);
            indices.push(row as u32);
            starts.push(indices.len() as u32);
        }
        let values = vec![0.0; indices.len()];
        let matrix = SymbolicSparseColMat::new_checked(count, count, starts, None, indices);
        let params = CholeskySymbolicParams {
            supernodal_params: SymbolicSupernodalParams { relax: Some(&MERGED) },
            ..CholeskySymbolicParams::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(matrix.as_ref(), Side::Upper, SymmetricOrdering::Identity, params)
                .map_err(|_| Error::memory("the factor of the decal's linear system does not fit into memory"))?;
        let factor = vec![0.0; symbolic.len_val()];
        let need = symbolic.factorize_numeric_llt_scratch::<f32>(Par::Seq, Default::default());
        let (roots, side, work) = (vec![[0.0; 3]; count], vec![[0.0; 2]; count], Work::default());
        Ok(Self { matrix, values, roots, symbolic, factor, side, work, memory: MemBuffer::new(need) })
    }

    /// Sets the matrix to the mean couplings, with `unit` on the diagonal.
    fn fill(&mut self, lower: &Lists, blocks: &[[f32; 4]], unit: f32) {
        let mut values = self.values.iter_mut();
        for row in 0..self.roots.len() {
            let range = lower.range(row);
            let [a, b, c] = self.roots[row].map(f64::from);
            for (other, block) in lower.items[range.clone()].iter().zip(&blocks[range]) {
                let ([p, q, r, s], [d, e, f]) = (block.map(f64::from), self.roots[*other as usize].map(f64::from));
                // Half the trace of the block between both roots.
                let coupling =
                    0.5 * (p * (a * d + b * e) + q * (b * d + c * e) + r * (a * e + b * f) + s * (b * e + c * f));
                if let Some(value) = values.next() {
                    *value = coupling as f32;
                }
            }
            if let Some(value) = values.next() {
                *value = unit;
            }
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
        let largest = side.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        // 32 bits hold any vector whose largest entry is 1.
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let rows = self.roots.iter().zip(side.as_chunks::<2>().0);
        for (place, ([a, b, c], [x, y])) in self.side.iter_mut().zip(rows) {
            let (x, y) = ((x / unit) as f32, (y / unit) as f32);
            *place = [a * x + b * y, b * x + c * y];
        }
        solve(&self.symbolic, &self.factor, &mut self.side, &mut self.work);
        let rows = self.roots.iter().zip(&self.side);
        for (place, ([a, b, c], [x, y])) in solution.as_chunks_mut::<2>().0.iter_mut().zip(rows) {
            *place = [a * x + b * y, b * x + c * y].map(|value| f64::from(value) * unit);
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
    let pairs = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|vertex| rows[vertex as usize]);
        let pairs = [(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b)));
        // That of a pinned vertex is the largest number.
        pairs.into_iter().filter(|(low, high)| *high != PINNED && low != high)
    };
    let mut ends = vec![0_u32; count + 1];
    for (_, high) in faces.iter().flat_map(pairs) {
        ends[high as usize + 1] += 1;
    }
    for row in 0..count {
        ends[row + 1] += ends[row];
    }
    let mut items = vec![0; ends[count] as usize];
    let mut starts = ends.clone();
    for (low, high) in faces.iter().flat_map(pairs) {
        let place = &mut starts[high as usize];
        items[*place as usize] = low;
        *place += 1;
    }
    // Pairs of two faces occur twice.
    let mut end = 0;
    for row in 0..count {
        let range = ends[row] as usize..ends[row + 1] as usize;
        items[range.clone()].sort_unstable();
        starts[row] = end as u32;
        let first = end;
        for index in range {
            if end == first || items[end - 1] != items[index] {
                items[end] = items[index];
                end += 1;
            }
        }
    }
    starts[count] = end as u32;
    items.truncate(end);
    items.shrink_to_fit();
    Lists { starts, items }
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
