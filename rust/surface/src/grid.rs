//! Grids of a tile, the fast path of evaluation: rows of a bicubic patch are curves whose basis values are shared by all
//! rows and axes, so that a sample costs 33 multiply-adds for P, du and dv, less than its nine stores.

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

/// Columns evaluated at a time, so that the basis values stay on the stack.
const BLOCK: usize = 256;

impl Surface {
    /// Evaluates a grid of a tile, row by row: sample (i, j) has the index
    /// `(j − rows.start) · columns.len() + i − columns.start`. A hole gives zeros.
    ///
    /// # Panics
    /// If there is no such tile, or columns or rows exceed the grid.
    pub fn grid(&self, level: Level, tile: u32, grid: &Grid, order: Order, out: &mut Samples) {
        out.resize(order, grid.len());
        self.grid_into(level, tile, grid, order, &mut out.as_slices());
    }

    /// As [`Surface::grid`], into slices of at least `grid.len()` numbers each.
    pub fn grid_into(&self, level: Level, tile: u32, grid: &Grid, order: Order, out: &mut SampleSlices<'_>) {
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
                PatchForm::Bezier => bezier_grid(level, patch, data, grid, columns, rows, order, out),
                PatchForm::Gregory => gregory_grid(level, patch, data, grid, columns, rows, order, out),
            }
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
        out: &mut SampleSlices<'_>
    )
}

/// Basis values of a block of columns: B, and the bases of first and second differences.
struct Basis {
    cubic: [[f32; BLOCK]; 4],
    quadratic: [[f32; BLOCK]; 3],
    linear: [[f32; BLOCK]; 2],
}

#[inline(always)]
fn bezier_grid_body<A: Arithmetic>(
    patch: &Patch,
    data: &[f32],
    grid: &Grid,
    columns: Range<u32>,
    rows: Range<u32>,
    order: Order,
    out: &mut SampleSlices<'_>,
) {
    let scale = patch.size.map(|size| 1.0 / size);
    let step = 1.0 / f64::from(grid.size);
    let local = |index: u32, axis: usize| {
        (((f64::from(index) + grid.offset()) * step - f64::from(patch.low[axis])) * f64::from(scale[axis])) as f32
    };
    let mut basis = Basis { cubic: [[0.0; BLOCK]; 4], quadratic: [[0.0; BLOCK]; 3], linear: [[0.0; BLOCK]; 2] };
    let mut block = columns.start;
    while block < columns.end {
        let count = ((columns.end - block) as usize).min(BLOCK);
        let start = local(block, 0);
        let slope = (step * f64::from(scale[0])) as f32;
        for k in 0..count {
            let s = A::fma(k as f32, slope, start);
            let r = 1.0 - s;
            let values = cubic(s);
            for (row, value) in basis.cubic.iter_mut().zip(values) {
                row[k] = value;
            }
            (basis.quadratic[0][k], basis.quadratic[1][k], basis.quadratic[2][k]) = (r * r, 2.0 * r * s, s * s);
            (basis.linear[0][k], basis.linear[1][k]) = (r, s);
        }
        for j in rows.clone() {
            let t = local(j, 1);
            let row = (j - grid.rows.start) as usize * grid.columns.len() + (block - grid.columns.start) as usize;
            let (b_t, d_t, dd_t) = (cubic(t), cubic_first(t), cubic_second(t));
            for axis in 0..3 {
                let points = &data[ORIGIN + 16 * axis..ORIGIN + 16 * axis + 16];
                let across = |basis: &[f32; 4], scale: f32| -> [f32; 4] {
                    std::array::from_fn(|k| {
                        let column = [points[k], points[4 + k], points[8 + k], points[12 + k]];
                        scale * (0..4).map(|i| basis[i] * column[i]).sum::<f32>()
                    })
                };
                let curve = across(&b_t, 1.0);
                let [p, du, dv, duu, duv, dvv] = &mut out.values;
                combine::<A, 4>(&basis.cubic, &curve, data[axis], &mut p[axis][row..row + count]);
                if order == Order::Position {
                    continue;
                }
                let curve_v = across(&d_t, scale[1]);
                let first = 3.0 * scale[0];
                combine::<A, 3>(&basis.quadratic, &differences(&curve, first), 0.0, &mut du[axis][row..row + count]);
                combine::<A, 4>(&basis.cubic, &curve_v, 0.0, &mut dv[axis][row..row + count]);
                if order == Order::First {
                    continue;
                }
                let second: [f32; 2] = differences(&differences::<4, 3>(&curve, first), 2.0 * scale[0]);
                let curve_vv = across(&dd_t, scale[1] * scale[1]);
                combine::<A, 2>(&basis.linear, &second, 0.0, &mut duu[axis][row..row + count]);
                combine::<A, 3>(&basis.quadratic, &differences(&curve_v, first), 0.0, &mut duv[axis][row..row + count]);
                combine::<A, 4>(&basis.cubic, &curve_vv, 0.0, &mut dvv[axis][row..row + count]);
            }
        }
        block += count as u32;
    }
}

/// `offset + Σ basis[k] · weights[k]` for every column.
#[inline(always)]
fn combine<A: Arithmetic, const N: usize>(basis: &[[f32; BLOCK]; N], weights: &[f32; N], offset: f32, out: &mut [f32]) {
    let count = out.len().min(BLOCK);
    let rows: [&[f32]; N] = std::array::from_fn(|k| &basis[k][..count]);
    for (i, value) in out.iter_mut().take(count).enumerate() {
        let mut sum = rows[0][i] * weights[0];
        for k in 1..N {
            sum = A::fma(rows[k][i], weights[k], sum);
        }
        *value = sum + offset;
    }
}

#[inline(always)]
fn differences<const N: usize, const M: usize>(values: &[f32; N], scale: f32) -> [f32; M] {
    std::array::from_fn(|k| scale * (values[k + 1] - values[k]))
}
