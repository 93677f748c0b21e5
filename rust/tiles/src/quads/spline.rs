//! The displacement function of a tile: a uniform biquadratic B-spline over cell-centred coefficients.
//!
//! Nießner and Loop 2013, Analytic Displacement Mapping using Hardware Tessellation, Section 3. A tile of `n` × `n`
//! texels has its coefficient `(i, j)` at `((i + ½)/n, (j + ½)/n)` and a ring of one texel around; a block holds
//! `(n + 2)²` coefficients, row by row from `v < 0`, in object units as half floats. Knots are at multiples of `1/n`:
//! on the edge of a tile the spline depends on the border row and the ring row alone, half of each. Derivatives are
//! per unit of the tile's parameters.
//!
//! Single points and grids do the same operations in the same order, so that at one instruction level they agree to
//! the bit.

use std::cell::Cell;
use std::ops::{Add, Sub};

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Arithmetic;
use relievo_surface::Order;

use crate::texel::{Value, Vector};

/// The displacement at a point and its derivatives by the tile's parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// Displacement.
    pub d: f32,
    /// By u.
    pub du: f32,
    /// By v.
    pub dv: f32,
    /// Twice by u.
    pub duu: f32,
    /// By u and v.
    pub duv: f32,
    /// Twice by v.
    pub dvv: f32,
}

/// Displacements and derivatives at many points; lists that were not asked for are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Jets {
    /// Displacements.
    pub d: Vec<f32>,
    /// By u.
    pub du: Vec<f32>,
    /// By v.
    pub dv: Vec<f32>,
    /// Twice by u.
    pub duu: Vec<f32>,
    /// By u and v.
    pub duv: Vec<f32>,
    /// Twice by v.
    pub dvv: Vec<f32>,
}

impl Jets {
    /// Makes room for `count` points with the derivatives in `order`, all zero.
    pub fn reset(&mut self, count: usize, order: Order) {
        let lengths = [
            (&mut self.d, Order::Position),
            (&mut self.du, Order::First),
            (&mut self.dv, Order::First),
            (&mut self.duu, Order::Second),
            (&mut self.duv, Order::Second),
            (&mut self.dvv, Order::Second),
        ];
        for (list, needed) in lengths {
            list.clear();
            list.resize(if order >= needed { count } else { 0 }, 0.0);
        }
    }

    /// The point at `index`; what was not asked for is zero.
    pub fn get(&self, index: usize) -> Jet {
        let at = |list: &[f32]| list.get(index).copied().unwrap_or(0.0);
        Jet {
            d: at(&self.d),
            du: at(&self.du),
            dv: at(&self.dv),
            duu: at(&self.duu),
            duv: at(&self.duv),
            dvv: at(&self.dvv),
        }
    }
}

/// The knot interval of a parameter, and the weights of its three coefficients for the value and two derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weights {
    /// The first of the three coefficients, counted with the ring.
    first: usize,
    value: [f32; 3],
    first_derivative: [f32; 3],
    second_derivative: [f32; 3],
}

#[inline(always)]
fn weights(t: f32, size: u32) -> Weights {
    let x = t * size as f32;
    let cell = (x as u32).min(size - 1);
    let f = x - cell as f32;
    let (a, c) = (0.5 * (1.0 - f) * (1.0 - f), 0.5 * f * f);
    let n = size as f32;
    Weights {
        first: cell as usize,
        value: [a, 1.0 - a - c, c],
        first_derivative: [n * (f - 1.0), n * (1.0 - 2.0 * f), n * f],
        second_derivative: [n * n, -2.0 * n * n, n * n],
    }
}

#[inline(always)]
fn combine<A: Arithmetic>(weights: [f32; 3], c: [f32; 3]) -> f32 {
    A::fma(weights[0], c[0], A::fma(weights[1], c[1], weights[2] * c[2]))
}

#[inline(always)]
fn point_body<A: Arithmetic>(_: A, block: &[f16], size: u32, u: f32, v: f32) -> Jet {
    point_of::<A>(block, 1, size, u, v)
}

#[inline(always)]
fn vector_point_body<A: Arithmetic>(_: A, block: &[Vector], size: u32, u: f32, v: f32) -> [Jet; 3] {
    let halves: &[f16] = bytemuck::cast_slice(block);
    [0, 1, 2].map(|axis| point_of::<A>(&halves[axis..], 3, size, u, v))
}

/// The spline of the coefficients that are `step` numbers apart.
#[inline(always)]
fn point_of<A: Arithmetic>(block: &[f16], step: usize, size: u32, u: f32, v: f32) -> Jet {
    let (a, b) = (weights(u, size), weights(v, size));
    let stride = size as usize + 2;
    let mut columns = [[0.0; 3]; 3];
    for (i, column) in columns.iter_mut().enumerate() {
        let c = std::array::from_fn(|j| block[step * ((b.first + j) * stride + a.first + i)].to_f32());
        *column = [b.value, b.first_derivative, b.second_derivative].map(|weights| combine::<A>(weights, c));
    }
    let [value, first, second] = std::array::from_fn(|k| [columns[0][k], columns[1][k], columns[2][k]]);
    Jet {
        d: combine::<A>(a.value, value),
        du: combine::<A>(a.first_derivative, value),
        dv: combine::<A>(a.value, first),
        duu: combine::<A>(a.second_derivative, value),
        duv: combine::<A>(a.first_derivative, first),
        dvv: combine::<A>(a.value, second),
    }
}

dispatch_simd! {
    /// The spline of a `block` of `size`² texels at `(u, v)`, with all derivatives. Panics if the block is too short.
    pub fn point = point_body(block: &[f16], size: u32, u: f32, v: f32) -> Jet
}

dispatch_simd! {
    /// As [`point`], of the three components of vectors.
    pub fn vector_point = vector_point_body(block: &[Vector], size: u32, u: f32, v: f32) -> [Jet; 3]
}

/// One row of sums over the three coefficients of every column, where columns are one texel apart.
#[inline(always)]
fn sweep<A: Arithmetic>(weights: [f32; 3], row: &[f32], out: &mut [f32]) {
    let count = out.len();
    let (a, b, c) = (&row[..count], &row[1..count + 1], &row[2..count + 2]);
    for i in 0..count {
        out[i] = combine::<A>(weights, [a[i], b[i], c[i]]);
    }
}

#[inline(always)]
fn grid_body<A: Arithmetic>(_: A, block: &[f16], size: u32, us: &[f32], vs: &[f32], order: Order, out: &mut Jets) {
    grid_of::<A>(block, 1, size, us, vs, order, out);
}

#[inline(always)]
fn vector_grid_body<A: Arithmetic>(
    _: A,
    block: &[Vector],
    size: u32,
    us: &[f32],
    vs: &[f32],
    order: Order,
    out: &mut [Jets; 3],
) {
    let halves: &[f16] = bytemuck::cast_slice(block);
    for (axis, out) in out.iter_mut().enumerate() {
        grid_of::<A>(&halves[axis..], 3, size, us, vs, order, out);
    }
}

/// The spline, on a grid, of the coefficients that are `step` numbers apart.
#[inline(always)]
fn grid_of<A: Arithmetic>(block: &[f16], step: usize, size: u32, us: &[f32], vs: &[f32], order: Order, out: &mut Jets) {
    out.reset(us.len() * vs.len(), order);
    if us.is_empty() || vs.is_empty() {
        return;
    }
    let stride = size as usize + 2;
    let mut room = ROOM.take();
    let GridRoom { columns, runs, rows, sums, mixed: scratch } = &mut room;
    columns.clear();
    columns.extend(us.iter().map(|u| weights(*u, size)));
    // Runs of columns one texel apart have the same weights.
    let next = |a: &Weights, b: &Weights| *b == Weights { first: a.first + 1, ..*a };
    runs.clear();
    runs.extend(columns.chunk_by(next).map(<[Weights]>::len));
    // The columns in use, with the ring.
    let low = columns.iter().map(|column| column.first).min().unwrap_or(0);
    let high = columns.iter().map(|column| column.first + 3).max().unwrap_or(0);
    rows.iter_mut().chain(sums.iter_mut()).for_each(|list| list.resize(high - low, 0.0));
    let mut held = [usize::MAX; 3];
    let derivatives = order as usize;
    for (index, v) in vs.iter().enumerate() {
        let b = weights(*v, size);
        for j in b.first..b.first + 3 {
            if held[j % 3] != j {
                let row = &mut rows[j % 3];
                if step == 1 {
                    block[j * stride + low..j * stride + high].convert_to_f32_slice(row);
                } else {
                    let last = step * (j * stride + high - 1);
                    let mixed = &block[step * (j * stride + low)..=last];
                    scratch.resize(mixed.len(), 0.0);
                    mixed.convert_to_f32_slice(scratch);
                    row.iter_mut().zip(scratch.iter().step_by(step)).for_each(|(row, value)| *row = *value);
                }
                held[j % 3] = j;
            }
        }
        let [c0, c1, c2] = [0, 1, 2].map(|j| &rows[(b.first + j) % 3][..high - low]);
        let row_weights = [b.value, b.first_derivative, b.second_derivative];
        for (sum, weights) in sums.iter_mut().zip(row_weights).take(derivatives + 1) {
            for (i, sum) in sum.iter_mut().enumerate() {
                *sum = combine::<A>(weights, [c0[i], c1[i], c2[i]]);
            }
        }
        let span = index * us.len()..(index + 1) * us.len();
        let [value, first, second] = &*sums;
        let emit = |out: &mut [f32], row: &[f32], pick: fn(&Weights) -> [f32; 3]| {
            if 4 * runs.len() > columns.len() {
                for (out, column) in out.iter_mut().zip(&*columns) {
                    let at = column.first - low;
                    *out = combine::<A>(pick(column), [row[at], row[at + 1], row[at + 2]]);
                }
                return;
            }
            let mut start = 0;
            for run in &*runs {
                let column = &columns[start];
                let at = column.first - low;
                sweep::<A>(pick(column), &row[at..at + run + 2], &mut out[start..start + run]);
                start += run;
            }
        };
        emit(&mut out.d[span.clone()], value, |w| w.value);
        if order >= Order::First {
            emit(&mut out.du[span.clone()], value, |w| w.first_derivative);
            emit(&mut out.dv[span.clone()], first, |w| w.value);
        }
        if order >= Order::Second {
            emit(&mut out.duu[span.clone()], value, |w| w.second_derivative);
            emit(&mut out.duv[span.clone()], first, |w| w.first_derivative);
            emit(&mut out.dvv[span], second, |w| w.value);
        }
    }
    ROOM.set(room);
}

/// What [`grid_of`] needs on its way, which threads keep.
#[derive(Default)]
struct GridRoom {
    columns: Vec<Weights>,
    /// Lengths of runs of columns.
    runs: Vec<usize>,
    rows: [Vec<f32>; 3],
    sums: [Vec<f32>; 3],
    /// Numbers of a row before the requested ones are taken out.
    mixed: Vec<f32>,
}

thread_local! {
    static ROOM: Cell<GridRoom> = Cell::default();
}

dispatch_simd! {
    /// The spline of a `block` of `size`² texels at every `(u, v)` of `us` × `vs`, at index
    /// `row · us.len() + column`. Columns one texel apart are the fast path. Panics if the block is too short.
    pub fn grid = grid_body(block: &[f16], size: u32, us: &[f32], vs: &[f32], order: Order, out: &mut Jets)
}

dispatch_simd! {
    /// As [`grid`], of the three components of vectors.
    pub fn vector_grid = vector_grid_body(
        block: &[Vector], size: u32, us: &[f32], vs: &[f32], order: Order, out: &mut [Jets; 3]
    )
}

/// Coefficients along a square of [`coefficient_places`] at most.
const SQUARE: usize = 16;

#[inline(always)]
fn coefficient_places_body<A: Lanes>(
    v: A,
    block: &[f16],
    size: u32,
    [column, row]: [u32; 2],
    edge: usize,
    out: &mut [f32],
) {
    /// [`weights`] half way between two knots.
    const WEIGHTS: [f32; 3] = [0.125, 0.75, 0.125];
    let stride = size as usize + 2;
    let mut rows = [[0.0; SQUARE + 2]; SQUARE + 2];
    for (j, numbers) in rows[..edge + 2].iter_mut().enumerate() {
        let start = (row as usize + j) * stride + column as usize;
        v.widen_all(&block[start..start + edge + 2], &mut numbers[..edge + 2]);
    }
    for (j, out) in out.chunks_exact_mut(edge).take(edge).enumerate() {
        let mut columns = [0.0; SQUARE + 2];
        for (i, column) in columns.iter_mut().enumerate() {
            *column = combine::<A>(WEIGHTS, [rows[j][i], rows[j + 1][i], rows[j + 2][i]]);
        }
        // All that there may be: loops of one length are made wide.
        let mut places = [0.0; SQUARE];
        for (i, place) in places.iter_mut().enumerate() {
            *place = combine::<A>(WEIGHTS, [columns[i], columns[i + 1], columns[i + 2]]);
        }
        out.copy_from_slice(&places[..edge]);
    }
}

dispatch_simd! {
    /// The spline of a `block` of `size`² texels at the places of its own coefficients: `edge` by `edge` of them from a
    /// column and a row on, row by row. To the bit what [`grid`] gives there. Panics if `edge` is
    /// above 16 or the block is too short.
    pub fn coefficient_places = coefficient_places_body(
        block: &[f16], size: u32, first: [u32; 2], edge: usize, out: &mut [f32]
    )
}

/// The coefficients of the same curve over knots half as far apart, by the masks of Chaikin 1974. Both lists have one
/// coefficient more at each end: `m + 2` become `2m + 2`.
pub fn subdivide_curve<V: Value>(coarse: &[V]) -> Vec<V> {
    let mut fine = Vec::with_capacity((2 * coarse.len()).saturating_sub(2));
    for pair in coarse.windows(2) {
        fine.push(pair[0] * 0.75 + pair[1] * 0.25);
        fine.push(pair[0] * 0.25 + pair[1] * 0.75);
    }
    fine
}

/// The coefficients over knots `ratio` times as far apart: the mean of each group. Keeps constants and lines.
pub fn restrict_curve<V: Value>(fine: &[V], ratio: usize) -> Vec<V> {
    fine.chunks_exact(ratio).map(|group| group.iter().copied().sum::<V>() / ratio as f64).collect()
}

/// What blocks are subdivided and coarsened in: numbers, or several side by side.
pub trait Coefficient: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// Times a number.
    fn scaled(self, by: f32) -> Self;
}

impl Coefficient for f32 {
    fn scaled(self, by: f32) -> Self {
        self * by
    }
}

impl<V: Value> Coefficient for V {
    fn scaled(self, by: f32) -> Self {
        self * f64::from(by)
    }
}

/// The block of the same function at twice the texels a side: `(n + 2)²` coefficients become `(2n + 2)²`. Of colours
/// that are looked up bilinearly it is bilinear interpolation.
pub fn subdivide_block<V: Coefficient>(coarse: &[V], size: usize) -> Vec<V> {
    let (from, to) = (size + 2, 2 * size + 2);
    // Coefficient k of the fine block is ¾ of the coarse one above it and ¼ of the next.
    let parents = |k: usize| if k.is_multiple_of(2) { (k / 2, k / 2 + 1) } else { (k / 2 + 1, k / 2) };
    let mixed = |near: V, far: V| near.scaled(0.75) + far.scaled(0.25);
    let mut fine = Vec::with_capacity(to * to);
    for j in 0..to {
        let (near, far) = parents(j);
        let row = |i: usize| mixed(coarse[near * from + i], coarse[far * from + i]);
        fine.extend((0..to).map(|i| {
            let (near, far) = parents(i);
            mixed(row(near), row(far))
        }));
    }
    fine
}

/// The block at half the texels a side, `(n + 2)²` to `(n/2 + 2)²`: inside, the left inverse of [`subdivide_block`] by
/// the masks of Samavati and Bartels 1999 (−¼ ¾ ¾ −¼). What the masks need beyond the ring goes on in a straight line.
pub fn coarsen_block<V: Coefficient>(fine: &[V], size: usize) -> Vec<V> {
    let (from, to) = (size + 2, size / 2 + 2);
    let beyond = |line: &dyn Fn(usize) -> V, k: isize| {
        let last = from - 1;
        match usize::try_from(k) {
            Ok(k) if k <= last => line(k),
            Ok(k) => line(last) + (line(last) - line(last - 1)).scaled((k - last) as f32),
            Err(_) => line(0) - (line(0) - line(1)).scaled(k as f32),
        }
    };
    let masked = |line: &dyn Fn(usize) -> V, k: usize| -> V {
        let at = |offset: isize| beyond(line, 2 * k as isize - 2 + offset);
        (at(1) + at(2)).scaled(0.75) - (at(0) + at(3)).scaled(0.25)
    };
    let mut rows = Vec::with_capacity(from * to);
    for row in fine.chunks_exact(from) {
        rows.extend((0..to).map(|i| masked(&|k| row[k], i)));
    }
    (0..to * to).map(|index| masked(&|k| rows[k * to + index % to], index / to)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use relievo_core::simd::Level;

    const SIZE: u32 = 16;

    fn block(of: impl Fn(f32, f32) -> f32) -> Vec<f16> {
        let stride = SIZE as usize + 2;
        let at = |k: usize| (k as f32 - 0.5) / SIZE as f32;
        (0..stride * stride).map(|k| f16::from_f32(of(at(k % stride), at(k / stride)))).collect()
    }

    fn random_block(seed: u64) -> Vec<f16> {
        let mut state = seed;
        let stride = SIZE as usize + 2;
        let random = |_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            f16::from_f32((state >> 40) as f32 / (1 << 24) as f32 - 0.5)
        };
        (0..stride * stride).map(random).collect()
    }

    #[test]
    fn constants_lines_and_parabolas_are_reproduced() {
        let level = Level::best();
        for (u, v) in [(0.0, 0.0), (1.0, 1.0), (0.25, 1.0), (0.3, 0.7), (0.999, 0.01)] {
            let constant = point(level, &block(|_, _| 0.75), SIZE, u, v);
            assert!((constant.d - 0.75).abs() < 1e-6 && constant.du.abs() < 1e-4 && constant.dvv.abs() < 1e-3);
            // Lines over 1/64 are exact in half floats here.
            let line = point(level, &block(|u, v| 0.5 * u - 2.0 * v + 1.0), SIZE, u, v);
            assert!((line.d - (0.5 * u - 2.0 * v + 1.0)).abs() < 2e-6, "{line:?}");
            assert!((line.du - 0.5).abs() < 1e-4 && (line.dv + 2.0).abs() < 1e-4 && line.duv.abs() < 1e-2);
            // Coefficients u² make u² + 1/(4 n²).
            let parabola = point(level, &block(|u, v| u * u + u * v), SIZE, u, v);
            assert!((parabola.d - (u * u + u * v + 0.25 / 256.0)).abs() < 1e-3);
            assert!((parabola.duu - 2.0).abs() < 0.2 && (parabola.duv - 1.0).abs() < 0.2);
        }
    }

    #[test]
    fn an_edge_is_the_mean_of_border_and_ring() {
        let data = random_block(3);
        let stride = SIZE as usize + 2;
        let jet = point(Level::best(), &data, SIZE, 0.0, 0.5 / SIZE as f32);
        let mean = |i: usize| (0..3).map(|j| [0.125, 0.75, 0.125][j] * data[(j) * stride + i].to_f32()).sum::<f32>();
        assert!((jet.d - 0.5 * (mean(0) + mean(1))).abs() < 1e-6);
        assert!((jet.du - SIZE as f32 * (mean(1) - mean(0))).abs() < 1e-4);
    }

    #[test]
    fn places_of_coefficients_are_a_grid() {
        let data = random_block(7);
        let centres: Vec<f32> = (0..SIZE).map(|i| (i as f32 + 0.5) / SIZE as f32).collect();
        for (level, name) in Level::NAMES {
            for (first, edge) in [([0, 0], SIZE.min(16) as usize), ([2, 3], 5), ([SIZE - 1, SIZE - 2], 1)] {
                let part = |first: u32| &centres[first as usize..first as usize + edge];
                let mut jets = Jets::default();
                grid(level, &data, SIZE, part(first[0]), part(first[1]), Order::Position, &mut jets);
                let mut found = vec![0.0; edge * edge];
                coefficient_places(level, &data, SIZE, first, edge, &mut found);
                assert_eq!(found, jets.d, "{name} {first:?}");
            }
        }
    }

    #[test]
    fn vectors_are_three_splines() {
        let planes = [1, 2, 3].map(random_block);
        let block: Vec<Vector> = (0..planes[0].len()).map(|k| Vector([0, 1, 2].map(|axis| planes[axis][k]))).collect();
        let (us, vs) = ([0.0, 0.2, 0.2625, 0.325, 1.0], [0.0, 0.7, 0.99]);
        for level in Level::NAMES.map(|(level, _)| level) {
            let mut jets: [Jets; 3] = Default::default();
            vector_grid(level, &block, SIZE, &us, &vs, Order::Second, &mut jets);
            for (index, (v, u)) in vs.iter().flat_map(|v| us.iter().map(move |u| (v, u))).enumerate() {
                let points = vector_point(level, &block, SIZE, *u, *v);
                for axis in 0..3 {
                    assert_eq!(points[axis], point(level, &planes[axis], SIZE, *u, *v));
                    assert_eq!(points[axis], jets[axis].get(index));
                }
            }
        }
    }

    proptest! {
        #[test]
        fn grids_agree_with_points_to_the_bit(
            seed: u64, us in prop::collection::vec(0f32..=1.0, 0..9), vs in prop::collection::vec(0f32..=1.0, 0..9),
        ) {
            let data = random_block(seed);
            let mut lattices = vec![(us, vs)];
            for rate in [4, 16, 32] {
                let lattice: Vec<f32> = (0..=rate).map(|i| i as f32 / rate as f32).collect();
                let centres: Vec<f32> = (0..rate).map(|i| (i as f32 + 0.5) / rate as f32).collect();
                lattices.extend([(lattice[..rate].to_vec(), centres.clone()), (centres, lattice)]);
            }
            for (_, level) in Level::NAMES.iter().map(|(level, name)| (name, *level)) {
                for (us, vs) in &lattices {
                    let mut jets = Jets::default();
                    grid(level, &data, SIZE, us, vs, Order::Second, &mut jets);
                    for (j, v) in vs.iter().enumerate() {
                        for (i, u) in us.iter().enumerate() {
                            prop_assert_eq!(jets.get(j * us.len() + i), point(level, &data, SIZE, *u, *v));
                        }
                    }
                    let mut values = Jets::default();
                    grid(level, &data, SIZE, us, vs, Order::Position, &mut values);
                    prop_assert!(values.d == jets.d && values.du.is_empty());
                }
            }
        }

        #[test]
        fn derivatives_are_those_of_the_function(seed: u64, u in 0.01f32..0.99, v in 0.01f32..0.99) {
            let data = random_block(seed);
            let at = |u, v| point(Level::Baseline, &data, SIZE, u, v);
            let h = 1.0 / 4096.0;
            let (jet, left, right) = (at(u, v), at(u - h, v), at(u + h, v));
            let (below, above) = (at(u, v - h), at(u, v + h));
            prop_assert!(((right.d - left.d) / (2.0 * h) - jet.du).abs() < 0.2);
            prop_assert!(((above.d - below.d) / (2.0 * h) - jet.dv).abs() < 0.2);
            prop_assert!(((above.du - below.du) / (2.0 * h) - jet.duv).abs() < 20.0);
        }

        #[test]
        fn subdivision_reproduces_the_function_and_coarsening_undoes_it(
            seed: u64, places in prop::collection::vec((0f32..=1.0, 0f32..=1.0), 20),
        ) {
            // Eighths, so that every subdivided coefficient is a half float.
            let eighths = |c: f16| f16::from_f32((c.to_f32() * 64.0).round() / 8.0);
            let data: Vec<f16> = random_block(seed).into_iter().map(eighths).collect();
            let coarse: Vec<f32> = data.iter().map(|c| c.to_f32()).collect();
            let fine: Vec<f32> = subdivide_block(&coarse, SIZE as usize);
            let fine_data: Vec<f16> = fine.iter().map(|c| f16::from_f32(*c)).collect();
            for (u, v) in places {
                let a = point(Level::Baseline, &data, SIZE, u, v);
                let b = point(Level::Baseline, &fine_data, 2 * SIZE, u, v);
                prop_assert!((a.d - b.d).abs() < 1e-5 && (a.du - b.du).abs() < 1e-3, "{:?} {:?}", a, b);
            }
            let stride = SIZE as usize + 2;
            let back = coarsen_block(&fine, 2 * SIZE as usize);
            prop_assert_eq!(back.len(), coarse.len());
            for (j, (row, expected)) in back.chunks(stride).zip(coarse.chunks(stride)).enumerate() {
                if (1..=SIZE as usize).contains(&j) {
                    prop_assert_eq!(&row[1..=SIZE as usize], &expected[1..=SIZE as usize]);
                }
            }
        }

        #[test]
        fn curves_subdivide_exactly_and_restriction_keeps_lines(ends in (-8i32..8, -8i32..8)) {
            let line: Vec<f64> = (0..10).map(|k| f64::from(ends.0) + (k as f64 - 0.5) * f64::from(ends.1)).collect();
            let fine = subdivide_curve(&subdivide_curve(&line));
            prop_assert_eq!(fine.len(), 4 * 8 + 2);
            for (k, c) in fine.iter().enumerate() {
                let x = (k as f64 - 0.5) / 4.0;
                prop_assert!((c - (f64::from(ends.0) + x * f64::from(ends.1))).abs() < 1e-12);
            }
            prop_assert_eq!(restrict_curve(&fine[1..33], 4), line[1..9].to_vec());
        }
    }
}
