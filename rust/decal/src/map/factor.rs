//! Sparse symmetric systems over the free vertices of a patch, two unknowns each, solved by conjugate gradients.
//!
//! The matrix is scaled to a unit matrix at each vertex. The preconditioner takes the mean of the couplings of both
//! coordinates: one number for each pair of neighbours. faer's Cholesky factor of that, in 32 bits, serves both coordinates and
//! has an eighth of the size of a factor of the matrix itself in 64 bits. It serves the matrices of further steps too, until
//! conjugate gradients take more steps with it. Matrix and vectors have 32 bits as well; sums of products have 64.

use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::simplicial::{
    prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::cholesky::supernodal::{
    SymbolicSupernodalCholesky, factorize_supernodal_numeric_llt, factorize_supernodal_numeric_llt_scratch,
    factorize_supernodal_symbolic_cholesky, factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::{SymbolicSupernodalParams, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;
use relievo_core::{Error, Result, dispatch_simd};

use crate::map::energy::Couplings;
use crate::map::triangular::{BEYOND, Work, invert_diagonal, solve};

/// Stands for a vertex that is no unknown.
pub const PINNED: u32 = u32::MAX;

/// Attempts to factorise the preconditioner, with more on the diagonal each time.
const ATTEMPTS: i32 = 5;
/// Columns of the factor that are merged into one block, up to a share of zeros in it: fewer than faer's own shares, whose
/// zeros were a quarter of the factor.
const MERGED: [(usize, f64); 4] = [(4, 0.3), (16, 0.2), (48, 0.05), (usize::MAX, 0.02)];
/// Steps of conjugate gradients.
const STEPS: usize = 100;
/// Steps more than with a new factor that cost as much as a new factor.
const PATIENCE: usize = 4;
/// The least determinant of the block of a vertex, as a share of the square of its trace: 32 bits hold no smaller one.
const FLATTEST: f64 = 1e-6;

/// A vector with two numbers for each free vertex.
pub type Pairs = Vec<[f32; 2]>;

/// A symmetric matrix of 2x2 blocks, one block row for each free vertex, and its preconditioner.
pub struct System {
    /// The block row of each vertex, or [`PINNED`]. Rows are in an order of little fill-in.
    rows: Vec<u32>,
    /// Each row, followed by its neighbours with larger numbers.
    upper: Lists,
    /// The blocks of the neighbours: rows of the smaller number, columns of the larger one.
    blocks: Vec<[f32; 4]>,
    /// The first, the mixed and the last entry of the blocks on the diagonal, or of the inverse of their roots once the
    /// matrix is scaled.
    diagonal: Vec<[f32; 3]>,
    symbolic: SymbolicSupernodalCholesky<u32>,
    factor: Vec<f32>,
    /// Steps of conjugate gradients that a new factor takes.
    steps: Option<usize>,
    is_stale: bool,
    work: Work,
}

impl std::fmt::Debug for System {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("System").field("free", &self.free()).finish_non_exhaustive()
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
        Self::within(Vec::new(), count, faces, is_pinned)
    }

    /// As [`Self::new`], with its factor in the memory of an earlier one.
    pub fn within(mut factor: Vec<f32>, count: usize, faces: &[[u32; 3]], is_pinned: &[bool]) -> Result<Self> {
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
        let upper = lower.mirrored();
        let symbolic = structure(lower)?;
        let (blocks, diagonal) = (vec![[0.0; 4]; upper.items.len() - free], vec![[0.0; 3]; free]);
        factor.clear();
        let size = symbolic.len_val() + BEYOND;
        factor.reserve_exact(size);
        factor.resize(size, 0.0);
        let (steps, is_stale, work) = (None, true, Work::default());
        Ok(Self { rows, upper, blocks, diagonal, symbolic, factor, steps, is_stale, work })
    }

    /// Returns the memory of the factor, for another system.
    pub fn into_factor(self) -> Vec<f32> {
        self.factor
    }

    /// Has the preconditioner factorised anew for the next matrix, which differs much from this one.
    pub fn renew(&mut self) {
        self.is_stale = true;
    }

    /// Returns the number of free vertices.
    pub fn free(&self) -> usize {
        self.diagonal.len()
    }

    /// Returns the block row of a vertex, or [`PINNED`].
    pub fn row(&self, vertex: usize) -> u32 {
        self.rows[vertex]
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.blocks.fill([0.0; 4]);
        self.diagonal.fill([0.0; 3]);
    }

    /// Adds the second derivatives of the energy of a face.
    pub fn add(&mut self, face: [u32; 3], couplings: &Couplings) {
        let rows = face.map(|vertex| self.rows[vertex as usize]);
        for corner in 0..3 {
            let (row, after, before) = (rows[corner], (corner + 1) % 3, (corner + 2) % 3);
            if row == PINNED {
                continue;
            }
            // Rows of a matrix of energies that do not change when all corners move together have the sum 0. The couplings
            // of a flat triangle may be far larger than it.
            let ([p, q, _, s], [a, _, c, d]) = (couplings[corner], couplings[before]);
            let [first, mixed, last] = &mut self.diagonal[row as usize];
            *first -= (p + a) as f32;
            *mixed -= (q + c) as f32;
            *last -= (s + d) as f32;
            let other = rows[after];
            if other == PINNED || row == other {
                continue;
            }
            let [p, q, r, s] = couplings[corner].map(|entry| entry as f32);
            if let Some(block) = self.block(row.min(other), row.max(other)) {
                let (q, r) = if row < other { (q, r) } else { (r, q) };
                *block = [block[0] + p, block[1] + q, block[2] + r, block[3] + s];
            }
        }
    }

    /// The block of two rows.
    fn block(&mut self, low: u32, high: u32) -> Option<&mut [f32; 4]> {
        let range = self.upper.range(low as usize);
        let within = self.upper.items[range.clone()].iter().position(|other| *other == high)?;
        // Each row up to this one has an entry for itself, without a block.
        self.blocks.get_mut(range.start + within - low as usize - 1)
    }

    /// Scales the matrix, and factorises the preconditioner anew if that of another matrix does not serve.
    ///
    /// # Errors
    /// An entry is not finite, or the entries differ too much in size.
    pub fn prepare(&mut self) -> Result<()> {
        for block in &mut self.diagonal {
            *block = inverse_root(block.map(f64::from)).ok_or_else(degenerate)?;
        }
        for row in 0..self.diagonal.len() {
            let [a, b, c] = self.diagonal[row];
            let range = self.upper.range(row);
            let others = &self.upper.items[range.start + 1..range.end];
            for (other, block) in others.iter().zip(&mut self.blocks[range.start - row..]) {
                let ([p, q, r, s], [d, e, f]) = (*block, self.diagonal[*other as usize]);
                let (p, q, r, s) = (a * p + b * r, a * q + b * s, b * p + c * r, b * q + c * s);
                *block = [p * d + q * e, p * e + q * f, r * d + s * e, r * e + s * f];
            }
        }
        if self.is_stale { self.factorise() } else { Ok(()) }
    }

    /// Factorises the preconditioner. Where rounding made it indefinite, the diagonal grows until it is not.
    fn factorise(&mut self) -> Result<()> {
        let count = self.diagonal.len();
        let matrix = SymbolicSparseColMatRef::new_checked(count, count, &self.upper.starts, None, &self.upper.items);
        let need = factorize_supernodal_numeric_llt_scratch::<u32, f32>(&self.symbolic, Par::Seq, Default::default());
        let (mut values, mut memory) = (vec![0.0; self.upper.items.len()], MemBuffer::new(need));
        for attempt in 0..ATTEMPTS {
            let shift = if attempt == 0 { 0.0 } else { 1e-6 * 10.0_f32.powi(attempt) };
            let mut blocks = self.blocks.iter();
            for row in 0..count {
                let range = self.upper.range(row);
                values[range.start] = 1.0 + shift;
                for (value, [first, .., last]) in values[range.start + 1..range.end].iter_mut().zip(&mut blocks) {
                    *value = 0.5 * (first + last);
                }
            }
            let made = factorize_supernodal_numeric_llt(
                &mut self.factor[..self.symbolic.len_val()],
                SparseColMatRef::new(matrix, &values),
                LltRegularization::default(),
                &self.symbolic,
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            );
            if made.is_ok() && self.factor.iter().all(|value| value.is_finite()) {
                invert_diagonal(&self.symbolic, &mut self.factor);
                (self.steps, self.is_stale) = (None, false);
                return Ok(());
            }
        }
        Err(degenerate())
    }

    /// Replaces the right side, a pair for each block row, by the solution. Its residual is at most `tolerance`, as a share of
    /// that of zero, in the norm of the preconditioner, unless that takes too many steps; the energy of any solution is less
    /// than that of zero. Returns the scalar product of the right side and the solution.
    pub fn solve(&mut self, side: &mut Pairs, tolerance: f64) -> f64 {
        let count = side.len();
        let (mut solution, mut ahead, mut image) =
            (vec![[0.0; 2]; count], vec![[0.0; 2]; count], vec![[0.0; 2]; count]);
        // The scaled right side becomes the residual.
        self.scale(side);
        self.precondition(side, &mut ahead);
        let mut size = product(side, &ahead);
        let enough = tolerance * tolerance * size;
        let (mut total, mut steps) = (0.0, 0);
        while steps < STEPS {
            self.multiply(&ahead, &mut image);
            let curvature = product(&ahead, &image);
            let length = size / curvature;
            if !(curvature > 0.0 && length.is_finite()) {
                break;
            }
            steps += 1;
            total += length * size;
            let length = length as f32;
            for (((solution, side), ahead), image) in solution.iter_mut().zip(side.iter_mut()).zip(&ahead).zip(&image) {
                for axis in 0..2 {
                    solution[axis] += length * ahead[axis];
                    side[axis] -= length * image[axis];
                }
            }
            // From here on the image is the preconditioned residual.
            self.precondition(side, &mut image);
            let left = product(side, &image);
            if !(left > enough) {
                break;
            }
            let share = (left / size) as f32;
            size = left;
            for (ahead, image) in ahead.iter_mut().zip(&image) {
                *ahead = [0, 1].map(|axis| image[axis] + share * ahead[axis]);
            }
        }
        match self.steps {
            Some(few) => self.is_stale |= steps > few + PATIENCE,
            None => self.steps = Some(steps),
        }
        side.copy_from_slice(&solution);
        self.scale(side);
        total
    }

    /// Multiplies a vector by the inverse roots of the diagonal.
    fn scale(&self, vector: &mut Pairs) {
        for (pair, [a, b, c]) in vector.iter_mut().zip(&self.diagonal) {
            let [x, y] = *pair;
            *pair = [a * x + b * y, b * x + c * y];
        }
    }

    /// Solves with the factor of the preconditioner.
    fn precondition(&mut self, side: &Pairs, solution: &mut Pairs) {
        solution.copy_from_slice(side);
        solve(&self.symbolic, &self.factor, solution, &mut self.work);
    }

    /// Multiplies the scaled matrix by a vector.
    fn multiply(&self, vector: &Pairs, image: &mut Pairs) {
        image.copy_from_slice(vector);
        add_couplings(Level::best(), &self.upper, &self.blocks, vector, image);
    }
}

dispatch_simd! {
    /// Adds the products of a vector with the blocks beside the diagonal.
    fn add_couplings = add_couplings_body(upper: &Lists, blocks: &[[f32; 4]], vector: &[[f32; 2]], image: &mut [[f32; 2]])
}

#[inline(always)]
fn add_couplings_body<A: Lanes>(_: A, upper: &Lists, blocks: &[[f32; 4]], vector: &[[f32; 2]], image: &mut [[f32; 2]]) {
    let mut blocks = blocks.iter();
    for (row, [x, y]) in vector.iter().enumerate() {
        let range = upper.range(row);
        let [mut first, mut second] = [0.0; 2];
        for (other, [p, q, r, s]) in upper.items[range.start + 1..range.end].iter().zip(&mut blocks) {
            let [u, v] = vector[*other as usize];
            first = A::fma(*p, u, A::fma(*q, v, first));
            second = A::fma(*r, u, A::fma(*s, v, second));
            let above = &mut image[*other as usize];
            *above = [A::fma(*p, *x, A::fma(*r, *y, above[0])), A::fma(*q, *x, A::fma(*s, *y, above[1]))];
        }
        image[row][0] += first;
        image[row][1] += second;
    }
}

/// The scalar product of two vectors.
fn product(a: &Pairs, b: &Pairs) -> f64 {
    let (first, rest) = a.as_chunks::<4>();
    let (second, others) = b.as_chunks::<4>();
    let mut sums = [[0.0_f64; 2]; 4];
    for (a, b) in first.iter().zip(second) {
        for lane in 0..4 {
            for axis in 0..2 {
                sums[lane][axis] += f64::from(a[lane][axis]) * f64::from(b[lane][axis]);
            }
        }
    }
    let rest = rest.as_flattened().iter().zip(others.as_flattened()).map(|(a, b)| f64::from(*a) * f64::from(*b));
    sums.as_flattened().iter().sum::<f64>() + rest.sum::<f64>()
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

/// The structure of the factor of a matrix with these neighbours.
fn structure(lower: Lists) -> Result<SymbolicSupernodalCholesky<u32>> {
    let count = lower.starts.len() - 1;
    let need = StackReq::or(
        prefactorize_symbolic_cholesky_scratch::<u32>(count, lower.items.len()),
        factorize_supernodal_symbolic_cholesky_scratch::<u32>(count),
    );
    let matrix = SymbolicSparseColMat::new_checked(count, count, lower.starts, None, lower.items);
    let (mut parents, mut counts, mut memory) = (vec![0; count], vec![0; count], MemBuffer::new(need));
    let memory = MemStack::new(&mut memory);
    let parents = prefactorize_symbolic_cholesky(&mut parents, &mut counts, matrix.as_ref(), memory);
    let params = SymbolicSupernodalParams { relax: Some(&MERGED) };
    factorize_supernodal_symbolic_cholesky(matrix.as_ref(), parents, &counts, memory, params)
        .map_err(|_| Error::memory("the factor of the decal's linear system does not fit into memory"))
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

    /// The other direction: each number, followed by the numbers of the lists that it is in.
    fn mirrored(&self) -> Self {
        let count = self.starts.len() - 1;
        let mut starts = vec![0_u32; count + 1];
        for item in &self.items {
            starts[*item as usize + 1] += 1;
        }
        for list in 0..count {
            starts[list + 1] += starts[list] + 1;
        }
        let mut items = vec![0; self.items.len() + count];
        let mut ends = starts.clone();
        for list in 0..count {
            let of = self.items[self.range(list)].iter().copied().chain([list as u32]);
            for item in of {
                let end = &mut ends[item as usize];
                items[*end as usize] = list as u32;
                *end += 1;
            }
        }
        Self { starts, items }
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
