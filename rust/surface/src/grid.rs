//! Grids of a tile, the fast path of evaluation: rows of a bicubic patch are curves whose basis values are shared by
//! all rows and axes, so that a sample costs 33 multiply-adds for P, du and dv, and its nine stores are the floor.

use std::ops::Range;

use relievo_core::lanes::Lanes;
use relievo_core::simd::{self, Level};

use crate::Surface;
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
            simd::finish_streams();
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

type Column = [f32; LANES];

/// Basis values of columns in blocks: B, and the bases of first and second differences.
struct Basis<const BLOCKS: usize> {
    cubic: [[Column; 4]; BLOCKS],
    quadratic: [[Column; 3]; BLOCKS],
    linear: [[Column; 2]; BLOCKS],
}

/// The numbers from 0 on.
const INDICES: [f32; BAND] = {
    let mut indices = [0.0; BAND];
    let mut i = 0;
    while i < BAND {
        indices[i] = i as f32;
        i += 1;
    }
    indices
};

/// Numbers of the rows of a band, side by side.
type Rows<const N: usize, const BAND: usize> = [[f32; BAND]; N];

/// The rows of a band: basis values at their v, and of one axis the curves in u of P, ∂P/∂v and ∂²P/∂v² and their
/// differences.
struct Curves<const BAND: usize> {
    cubic: [Rows<4, BAND>; 3],
    p: Rows<4, BAND>,
    du: Rows<3, BAND>,
    dv: Rows<4, BAND>,
    duu: Rows<2, BAND>,
    duv: Rows<3, BAND>,
    dvv: Rows<4, BAND>,
}

impl<const BAND: usize> Curves<BAND> {
    fn new() -> Self {
        let zero = [0.0; BAND];
        Self {
            cubic: [[zero; 4]; 3],
            p: [zero; 4],
            du: [zero; 3],
            dv: [zero; 4],
            duu: [zero; 2],
            duv: [zero; 3],
            dvv: [zero; 4],
        }
    }

    /// Takes over the rows at `start`, `start + slope` and so on; `scale` is that of derivatives along v.
    #[inline(always)]
    fn place<A: Lanes>(&mut self, v: A, start: f32, slope: f32, scale: f32, order: Order) {
        for from in (0..BAND).step_by(A::WIDTH) {
            let t = v.fused(v.load(&INDICES[from..]), v.splat(slope), v.splat(start));
            let Bernstein { s, st, ss, tt, cubic } = Bernstein::new(v, t);
            store(v, cubic, &mut self.cubic[0], from);
            if order >= Order::First {
                let by = v.splat(3.0 * scale);
                let two = v.splat(2.0);
                let inner = [v.sub(ss, v.mul(two, st)), v.sub(v.mul(two, st), tt)];
                let values = [v.sub(v.splat(0.0), ss), inner[0], inner[1], tt];
                store(v, scaled(v, values, by), &mut self.cubic[1], from);
            }
            if order >= Order::Second {
                let by = v.splat(6.0 * scale * scale);
                let inner = [v.sub(t, v.add(s, s)), v.sub(s, v.add(t, t))];
                store(v, scaled(v, [s, inner[0], inner[1], t], by), &mut self.cubic[2], from);
            }
        }
    }

    /// Takes over the curves of an axis, whose Bézier points are given; `scale` is that of derivatives along u.
    #[inline(always)]
    fn curve<A: Lanes>(&mut self, v: A, points: &[f32], scale: f32, order: Order) {
        across(v, points, &self.cubic[0], &mut self.p);
        if order >= Order::First {
            differences(v, &self.p, 3.0 * scale, &mut self.du);
            across(v, points, &self.cubic[1], &mut self.dv);
        }
        if order >= Order::Second {
            differences(v, &self.du, 2.0 * scale, &mut self.duu);
            differences(v, &self.dv, 3.0 * scale, &mut self.duv);
            across(v, points, &self.cubic[2], &mut self.dvv);
        }
    }
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn bezier_grid_body<A: Lanes>(
    v: A,
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
        tabulated::<A, SMALL_BLOCKS, SMALL_BAND>(v, patch, data, grid, columns, rows, order, destination, out);
    } else {
        tabulated::<A, BLOCKS, BAND>(v, patch, data, grid, columns, rows, order, destination, out);
    }
}

/// Evaluates with tables of `BLOCKS` blocks of columns and `BAND` rows.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn tabulated<A: Lanes, const BLOCKS: usize, const BAND: usize>(
    v: A,
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
    let slope = scale.map(|scale| (step * f64::from(scale)) as f32);
    let mut basis = Basis {
        cubic: [[[0.0; LANES]; 4]; BLOCKS],
        quadratic: [[[0.0; LANES]; 3]; BLOCKS],
        linear: [[[0.0; LANES]; 2]; BLOCKS],
    };
    let mut curves = Curves::<BAND>::new();
    let width = grid.columns.len();
    let mut first = columns.start;
    while first < columns.end {
        let count = ((columns.end - first) as usize).min(BLOCKS * LANES);
        for block in 0..count.div_ceil(LANES) {
            let start = local(first + (block * LANES) as u32, 0);
            for from in (0..LANES).step_by(A::WIDTH) {
                let t = v.fused(v.load(&INDICES[from..]), v.splat(slope[0]), v.splat(start));
                let Bernstein { s, st, ss, tt, cubic } = Bernstein::new(v, t);
                store(v, cubic, &mut basis.cubic[block], from);
                store(v, [ss, v.add(st, st), tt], &mut basis.quadratic[block], from);
                store(v, [s, t], &mut basis.linear[block], from);
            }
        }
        let mut low = rows.start;
        while low < rows.end {
            let band = ((rows.end - low) as usize).min(BAND);
            curves.place(v, local(low, 1), slope[1], scale[1], order);
            let at = (low - grid.rows.start) as usize * width + (first - grid.columns.start) as usize;
            let area = Area { at, width, count, rows: band, destination };
            // One array after the other, so that memory sees one stream of stores at a time.
            for axis in 0..3 {
                curves.curve(v, &data[ORIGIN + 16 * axis..ORIGIN + 16 * axis + 16], scale[0], order);
                let [p, du, dv, duu, duv, dvv] = &mut out.values;
                fill(v, &basis.cubic, &curves.p, data[axis], &area, p[axis]);
                if order >= Order::First {
                    fill(v, &basis.quadratic, &curves.du, 0.0, &area, du[axis]);
                    fill(v, &basis.cubic, &curves.dv, 0.0, &area, dv[axis]);
                }
                if order >= Order::Second {
                    fill(v, &basis.linear, &curves.duu, 0.0, &area, duu[axis]);
                    fill(v, &basis.quadratic, &curves.duv, 0.0, &area, duv[axis]);
                    fill(v, &basis.cubic, &curves.dvv, 0.0, &area, dvv[axis]);
                }
            }
            low += band as u32;
        }
        first += count as u32;
    }
}

/// Bernstein polynomials at t, and what they are made of: s = 1 − t and the products of two of both.
struct Bernstein<A: Lanes> {
    s: A::F,
    ss: A::F,
    st: A::F,
    tt: A::F,
    cubic: [A::F; 4],
}

impl<A: Lanes> Bernstein<A> {
    #[inline(always)]
    fn new(v: A, t: A::F) -> Self {
        let s = v.sub(v.splat(1.0), t);
        let (tt, st, ss) = (v.mul(t, t), v.mul(s, t), v.mul(s, s));
        let three = v.splat(3.0);
        let cubic = [v.mul(ss, s), v.mul(three, v.mul(ss, t)), v.mul(three, v.mul(tt, s)), v.mul(tt, t)];
        Self { s, ss, st, tt, cubic }
    }
}

/// Writes vectors to the rows of a table from column `from` on.
#[inline(always)]
fn store<A: Lanes, const N: usize, const M: usize>(v: A, values: [A::F; N], table: &mut [[f32; M]; N], from: usize) {
    for (value, row) in values.into_iter().zip(table) {
        v.store(value, &mut row[from..]);
    }
}

#[inline(always)]
fn scaled<A: Lanes>(v: A, [a, b, c, d]: [A::F; 4], scale: A::F) -> [A::F; 4] {
    [v.mul(a, scale), v.mul(b, scale), v.mul(c, scale), v.mul(d, scale)]
}

/// The Bézier points of the curves of all rows, from their basis values.
#[inline(always)]
fn across<A: Lanes, const BAND: usize>(v: A, points: &[f32], basis: &Rows<4, BAND>, curves: &mut Rows<4, BAND>) {
    for from in (0..BAND).step_by(A::WIDTH) {
        let basis = [
            v.load(&basis[0][from..]),
            v.load(&basis[1][from..]),
            v.load(&basis[2][from..]),
            v.load(&basis[3][from..]),
        ];
        for (k, curve) in curves.iter_mut().enumerate() {
            let low = v.fused(basis[1], v.splat(points[4 + k]), v.mul(basis[0], v.splat(points[k])));
            let high = v.fused(basis[3], v.splat(points[12 + k]), v.mul(basis[2], v.splat(points[8 + k])));
            v.store(v.add(low, high), &mut curve[from..]);
        }
    }
}

/// Where in an array a rectangle of samples goes: `rows` times `count` numbers at `at`, `width` apart.
struct Area {
    at: usize,
    width: usize,
    count: usize,
    rows: usize,
    destination: Destination,
}

/// Writes `offset + Σ basis[k] · weights[k]` for every row and column.
#[inline(always)]
fn fill<A: Lanes, const N: usize, const BAND: usize>(
    v: A,
    basis: &[[Column; N]],
    curves: &Rows<N, BAND>,
    offset: f32,
    area: &Area,
    out: &mut [f32],
) {
    for (row, out) in out[area.at..].chunks_mut(area.width).take(area.rows).enumerate() {
        let mut weights = [0.0; N];
        for (weight, curve) in weights.iter_mut().zip(curves) {
            *weight = curve[row];
        }
        let mut blocks = out[..area.count].chunks_exact_mut(LANES);
        let mut bases = basis.iter();
        for (out, basis) in blocks.by_ref().zip(bases.by_ref()) {
            match area.destination {
                Destination::Cache => combine(v, basis, &weights, offset, out),
                Destination::Memory => {
                    let mut values = [0.0; LANES];
                    combine(v, basis, &weights, offset, &mut values);
                    simd::stream(out, &values);
                }
            }
        }
        let rest = blocks.into_remainder();
        if !rest.is_empty() {
            let mut values = [0.0; LANES];
            combine(v, &basis[area.count / LANES], &weights, offset, &mut values);
            rest.copy_from_slice(&values[..rest.len()]);
        }
    }
}

/// Writes `offset + Σ basis[k] · weights[k]` of a block of columns.
#[inline(always)]
fn combine<A: Lanes, const N: usize>(v: A, basis: &[Column; N], weights: &[f32; N], offset: f32, out: &mut [f32]) {
    for from in (0..LANES).step_by(A::WIDTH) {
        let mut sum = v.mul(v.load(&basis[0][from..]), v.splat(weights[0]));
        for k in 1..N {
            sum = v.fused(v.load(&basis[k][from..]), v.splat(weights[k]), sum);
        }
        v.store(v.add(sum, v.splat(offset)), &mut out[from..]);
    }
}

/// `scale` times the differences of neighbouring points of the curves of all rows.
#[inline(always)]
fn differences<A: Lanes, const N: usize, const M: usize, const BAND: usize>(
    v: A,
    curves: &Rows<N, BAND>,
    scale: f32,
    out: &mut Rows<M, BAND>,
) {
    for from in (0..BAND).step_by(A::WIDTH) {
        for k in 0..M {
            let step = v.sub(v.load(&curves[k + 1][from..]), v.load(&curves[k][from..]));
            v.store(v.mul(v.splat(scale), step), &mut out[k][from..]);
        }
    }
}
