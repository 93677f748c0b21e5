//! Grids of a tile, the fast path of evaluation: rows of a bicubic patch are curves whose basis values are shared by all
//! rows and axes, so that a sample costs 33 multiply-adds for P, du and dv, and its nine stores are the floor.

use std::ops::Range;

use relievo_core::simd::{Arithmetic, Level};

use crate::Surface;
use crate::bezier::{cubic, cubic_first, cubic_second};
use crate::evaluate::{Order, SampleSlices, Samples, evaluate};
use crate::patch::{ORIGIN, Patch, PatchForm};

/// Where the samples of a grid sit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// At the centres of `size` × `size` cells: u = (i + ½)/size. Texels, knots of displacement.
    Centred,
    /// At the corners of the cells: u = i/size, i from 0 to `size`.
    Lattice,
}

/// A rectangle of a grid of a tile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Cells along an edge.
    pub size: u32,
    /// Where in its cell a sample sits.
    pub placement: Placement,
    /// Columns (along u) to evaluate.
    pub columns: Range<u32>,
    /// Rows (along v) to evaluate.
    pub rows: Range<u32>,
}

impl Grid {
    /// All samples of a grid.
    pub fn whole(size: u32, placement: Placement) -> Self {
        let count = if placement == Placement::Centred { size } else { size + 1 };
        Self { size, placement, columns: 0..count, rows: 0..count }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Whether it has no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The parameter of column or row `index`.
    pub fn parameter(&self, index: u32) -> f32 {
        ((f64::from(index) + self.offset()) / f64::from(self.size)) as f32
    }

    fn offset(&self) -> f64 {
        if self.placement == Placement::Centred { 0.5 } else { 0.0 }
    }

    /// The indices of `range` whose parameters lie in `[low, low + size)`, or up to the end if that is the tile's.
    fn inside(&self, range: &Range<u32>, low: f32, size: f32) -> Range<u32> {
        let index =
            |parameter: f32| (f64::from(parameter) * f64::from(self.size) - self.offset()).ceil().max(0.0) as u32;
        let high = low + size;
        let end = if high >= 1.0 { range.end } else { index(high).min(range.end) };
        index(low).max(range.start).min(end)..end
    }
}

impl Surface {
    /// Evaluates a grid of a tile, row by row: sample (i, j) has the index
    /// `(j − rows.start) · columns.len() + i − columns.start`. A hole gives zeros.
    ///
    /// # Panics
    /// If there is no such tile, or columns or rows exceed the grid.
    pub fn grid(&self, level: Level, tile: u32, grid: &Grid, order: Order, out: &mut Samples) {
        out.resize(order, grid.len());
        self.grid_into(level, tile, grid, order, Destination::Cache, &mut out.as_slices());
    }

    /// As [`Surface::grid`], into slices of at least `grid.len()` numbers each.
    pub fn grid_into(
        &self,
        level: Level,
        tile: u32,
        grid: &Grid,
        order: Order,
        destination: Destination,
        out: &mut SampleSlices<'_>,
    ) {
        let limit = Grid::whole(grid.size, grid.placement).columns.end;
        assert!(grid.columns.end <= limit && grid.rows.end <= limit, "columns and rows lie in the grid");
        let patches = self.tile_patches(tile);
        if patches.is_empty() {
            for values in out.values.iter_mut().take(order.quantities()).flatten() {
                values.fill(0.0);
            }
        }
        for patch in patches {
            let columns = grid.inside(&grid.columns, patch.low[0], patch.size[0]);
            let rows = grid.inside(&grid.rows, patch.low[1], patch.size[1]);
            if columns.is_empty() || rows.is_empty() {
                continue;
            }
            let data = self.data_of(patch);
            match patch.form {
                PatchForm::Bezier => bezier_grid(level, patch, data, grid, columns, rows, order, destination, out),
                PatchForm::Gregory => gregory_grid(level, patch, data, grid, columns, rows, order, out),
            }
        }
        if destination == Destination::Memory {
            finish_streams();
        }
    }
}

#[allow(clippy::too_many_arguments)]
fn gregory_grid(
    level: Level,
    patch: &Patch,
    data: &[f32],
    grid: &Grid,
    columns: Range<u32>,
    rows: Range<u32>,
    order: Order,
    out: &mut SampleSlices<'_>,
) {
    let quantities = order.quantities();
    for j in rows {
        let v = grid.parameter(j);
        let row = (j - grid.rows.start) as usize * grid.columns.len();
        for i in columns.clone() {
            let mut sample = [[0.0; 3]; 6];
            evaluate(level, patch, data, [grid.parameter(i), v], quantities, &mut sample);
            let index = row + (i - grid.columns.start) as usize;
            for (values, quantity) in out.values.iter_mut().zip(&sample).take(quantities) {
                for (values, value) in values.iter_mut().zip(quantity) {
                    values[index] = *value;
                }
            }
        }
    }
}

relievo_core::dispatch_simd! {
    fn bezier_grid = bezier_grid_body(
        patch: &Patch, data: &[f32], grid: &Grid, columns: Range<u32>, rows: Range<u32>, order: Order,
        destination: Destination, out: &mut SampleSlices<'_>
    )
}

/// Columns evaluated together.
const LANES: usize = 16;

/// Blocks of columns whose basis values are kept on the stack.
const BLOCKS: usize = 16;

/// Where samples go, which decides how they are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Destination {
    /// They are read again soon: ordinary stores.
    Cache,
    /// They fill a buffer larger than the caches: stores that do not read the lines they overwrite.
    Memory,
}

/// Rows whose curves are kept on the stack.
const BAND: usize = 128;

/// As `BLOCKS`, for small rectangles.
const SMALL_BLOCKS: usize = 1;

/// As `BAND`, for small rectangles.
const SMALL_BAND: usize = 16;

type Lanes = [f32; LANES];

/// Basis values of columns in blocks: B, and the bases of first and second differences.
struct Basis<const BLOCKS: usize> {
    cubic: [[Lanes; 4]; BLOCKS],
    quadratic: [[Lanes; 3]; BLOCKS],
    linear: [[Lanes; 2]; BLOCKS],
}

/// A row of the patch at one v: the curves in u of P, ∂P/∂v and ∂²P/∂v², and their differences, of one axis.
#[derive(Clone, Copy, Default)]
struct Row {
    origin: f32,
    p: [f32; 4],
    du: [f32; 3],
    dv: [f32; 4],
    duu: [f32; 2],
    duv: [f32; 3],
    dvv: [f32; 4],
}

impl Row {
    #[inline(always)]
    fn new(points: &[f32], origin: f32, t: f32, scale: [f32; 2], order: Order) -> Self {
        let mut row = Row { origin, p: across(points, cubic(t), 1.0), ..Row::default() };
        if order >= Order::First {
            row.du = differences(&row.p, 3.0 * scale[0]);
            row.dv = across(points, cubic_first(t), scale[1]);
        }
        if order >= Order::Second {
            row.duu = differences(&row.du, 2.0 * scale[0]);
            row.duv = differences(&row.dv, 3.0 * scale[0]);
            row.dvv = across(points, cubic_second(t), scale[1] * scale[1]);
        }
        row
    }
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn bezier_grid_body<A: Arithmetic>(
    patch: &Patch,
    data: &[f32],
    grid: &Grid,
    columns: Range<u32>,
    rows: Range<u32>,
    order: Order,
    destination: Destination,
    out: &mut SampleSlices<'_>,
) {
    // Short rows leave lines half written, which stores past the caches would write twice.
    let destination = if columns.len() < 4 * LANES { Destination::Cache } else { destination };
    // Small rectangles do not pay for clearing the tables of large ones.
    if columns.len() <= SMALL_BLOCKS * LANES && rows.len() <= SMALL_BAND {
        tabulated::<A, SMALL_BLOCKS, SMALL_BAND>(patch, data, grid, columns, rows, order, destination, out);
    } else {
        tabulated::<A, BLOCKS, BAND>(patch, data, grid, columns, rows, order, destination, out);
    }
}

/// Evaluates with tables of `BLOCKS` blocks of columns and `BAND` rows.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn tabulated<A: Arithmetic, const BLOCKS: usize, const BAND: usize>(
    patch: &Patch,
    data: &[f32],
    grid: &Grid,
    columns: Range<u32>,
    rows: Range<u32>,
    order: Order,
    destination: Destination,
    out: &mut SampleSlices<'_>,
) {
    let scale = patch.size.map(|size| 1.0 / size);
    let step = 1.0 / f64::from(grid.size);
    let local = |index: u32, axis: usize| {
        (((f64::from(index) + grid.offset()) * step - f64::from(patch.low[axis])) * f64::from(scale[axis])) as f32
    };
    let slope = (step * f64::from(scale[0])) as f32;
    let mut basis = Basis {
        cubic: [[[0.0; LANES]; 4]; BLOCKS],
        quadratic: [[[0.0; LANES]; 3]; BLOCKS],
        linear: [[[0.0; LANES]; 2]; BLOCKS],
    };
    let mut curves = [Row::default(); BAND];
    let width = grid.columns.len();
    let mut first = columns.start;
    while first < columns.end {
        let count = ((columns.end - first) as usize).min(BLOCKS * LANES);
        for block in 0..count.div_ceil(LANES) {
            let start = local(first + (block * LANES) as u32, 0);
            for k in 0..LANES {
                let s = A::fma(k as f32, slope, start);
                let r = 1.0 - s;
                for (row, value) in basis.cubic[block].iter_mut().zip(cubic(s)) {
                    row[k] = value;
                }
                for (row, value) in basis.quadratic[block].iter_mut().zip([r * r, 2.0 * r * s, s * s]) {
                    row[k] = value;
                }
                for (row, value) in basis.linear[block].iter_mut().zip([r, s]) {
                    row[k] = value;
                }
            }
        }
        // One array after the other, so that memory sees one stream of stores at a time.
        for axis in 0..3 {
            let points = &data[ORIGIN + 16 * axis..ORIGIN + 16 * axis + 16];
            let mut low = rows.start;
            while low < rows.end {
                let band = low..rows.end.min(low + BAND as u32);
                for (row, j) in curves.iter_mut().zip(band.clone()) {
                    *row = Row::new(points, data[axis], local(j, 1), scale, order);
                }
                let curves = &curves[..band.len()];
                let at = (low - grid.rows.start) as usize * width + (first - grid.columns.start) as usize;
                let area = Area { at, width, count, destination };
                let [p, du, dv, duu, duv, dvv] = &mut out.values;
                fill::<A, 4>(&basis.cubic, curves, |row| (&row.p, row.origin), &area, p[axis]);
                if order >= Order::First {
                    fill::<A, 3>(&basis.quadratic, curves, |row| (&row.du, 0.0), &area, du[axis]);
                    fill::<A, 4>(&basis.cubic, curves, |row| (&row.dv, 0.0), &area, dv[axis]);
                }
                if order >= Order::Second {
                    fill::<A, 2>(&basis.linear, curves, |row| (&row.duu, 0.0), &area, duu[axis]);
                    fill::<A, 3>(&basis.quadratic, curves, |row| (&row.duv, 0.0), &area, duv[axis]);
                    fill::<A, 4>(&basis.cubic, curves, |row| (&row.dvv, 0.0), &area, dvv[axis]);
                }
                low = band.end;
            }
        }
        first += count as u32;
    }
}

/// The Bézier points of the curve at one v, from the basis values there.
#[inline(always)]
fn across(points: &[f32], basis: [f32; 4], scale: f32) -> [f32; 4] {
    let mut curve = [0.0; 4];
    for k in 0..4 {
        for i in 0..4 {
            curve[k] += basis[i] * points[4 * i + k];
        }
        curve[k] *= scale;
    }
    curve
}

/// Where in an array a rectangle of samples goes: `count` numbers at `at`, and every `width` numbers again.
struct Area {
    at: usize,
    width: usize,
    count: usize,
    destination: Destination,
}

/// Writes `offset + Σ basis[k] · weights[k]` for every row and column.
#[inline(always)]
fn fill<A: Arithmetic, const N: usize>(
    basis: &[[Lanes; N]],
    rows: &[Row],
    weights: impl Fn(&Row) -> (&[f32; N], f32),
    area: &Area,
    out: &mut [f32],
) {
    for (row, out) in rows.iter().zip(out[area.at..].chunks_mut(area.width)) {
        let (weights, offset) = weights(row);
        let mut blocks = out[..area.count].chunks_exact_mut(LANES);
        let mut bases = basis.iter();
        for (out, basis) in blocks.by_ref().zip(bases.by_ref()) {
            let values = combine::<A, N>(basis, weights, offset);
            match area.destination {
                Destination::Cache => out.copy_from_slice(&values),
                Destination::Memory => stream(out, &values),
            }
        }
        let rest = blocks.into_remainder();
        if !rest.is_empty() {
            let basis = &basis[area.count / LANES];
            rest.copy_from_slice(&combine::<A, N>(basis, weights, offset)[..rest.len()]);
        }
    }
}

/// Stores a block past the caches.
#[inline(always)]
fn stream(out: &mut [f32], values: &Lanes) {
    #[cfg(target_arch = "x86_64")]
    if out.len() == LANES && out.as_ptr().addr().is_multiple_of(16) {
        use std::arch::x86_64::{_mm_loadu_ps, _mm_stream_ps};
        for quarter in (0..LANES).step_by(4) {
            // SAFETY: SSE is part of x86-64; `out` has LANES numbers and starts at a multiple of 16 bytes.
            #[allow(unsafe_code)]
            unsafe {
                _mm_stream_ps(out.as_mut_ptr().add(quarter), _mm_loadu_ps(values.as_ptr().add(quarter)));
            }
        }
        return;
    }
    out.copy_from_slice(values);
}

/// Makes streamed stores visible to other threads.
fn finish_streams() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: SSE is part of x86-64.
    #[allow(unsafe_code)]
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}

#[inline(always)]
fn combine<A: Arithmetic, const N: usize>(basis: &[Lanes; N], weights: &[f32; N], offset: f32) -> Lanes {
    let mut sums = [0.0; LANES];
    for i in 0..LANES {
        sums[i] = basis[0][i] * weights[0];
    }
    for k in 1..N {
        for i in 0..LANES {
            sums[i] = A::fma(basis[k][i], weights[k], sums[i]);
        }
    }
    for sum in &mut sums {
        *sum += offset;
    }
    sums
}

#[inline(always)]
fn differences<const N: usize, const M: usize>(values: &[f32; N], scale: f32) -> [f32; M] {
    let mut out = [0.0; M];
    for k in 0..M {
        out[k] = scale * (values[k + 1] - values[k]);
    }
    out
}
