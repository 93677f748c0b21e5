//! The places where displacement coefficients act: limit points and unit normals at the knots of the tiles, in blocks
//! of 16 × 16 that stay in the first-level cache. Evaluating a block is no slower than reading it from memory, so
//! nothing is kept.

use relievo_core::dispatch_simd;
use relievo_core::simd::{Arithmetic, Level};
use relievo_surface::{Destination, Grid, Order, Placement, SampleSlices, Surface};

use crate::channels::frame::{Frames, Vectors};

/// Texels along a block at most.
pub const BLOCK: usize = 16;

/// Knots of a block at most.
pub const BLOCK_KNOTS: usize = BLOCK * BLOCK;

/// A number for each knot of a block, or for each of up to as many places of any surface.
pub type PerKnot = [f32; BLOCK_KNOTS];

/// Texels along a block of a tile of `size` texels.
pub fn block_edge(size: u32) -> u32 {
    size.min(BLOCK as u32)
}

/// The knots of one block, row by row: x, y and z of the points and of the normals, in object space. Surfaces without
/// tiles fill it with places of theirs.
#[derive(Clone, Debug)]
pub struct KnotBlock {
    /// Points of the limit surface.
    pub p: [PerKnot; 3],
    /// Unit normals.
    pub n: [PerKnot; 3],
    /// Derivatives by v while the normals are made.
    dv: [PerKnot; 3],
}

impl KnotBlock {
    /// A block of zeros.
    pub const ZERO: Self = Self { p: [[0.0; BLOCK_KNOTS]; 3], n: [[0.0; BLOCK_KNOTS]; 3], dv: [[0.0; BLOCK_KNOTS]; 3] };

    /// Evaluates block `index` of `tile`, whose tiles have `size` texels a side.
    pub fn evaluate(&mut self, level: Level, surface: &Surface, tile: u32, size: u32, index: u32) {
        self.samples(level, surface, (tile, size, index), Order::First);
        normals(level, &mut self.n, &self.dv);
    }

    /// As [`Self::evaluate`], the points alone.
    pub(crate) fn evaluate_points(&mut self, level: Level, surface: &Surface, block: (u32, u32, u32)) {
        self.samples(level, surface, block, Order::Position);
    }

    /// As [`Self::evaluate`], and the frames there.
    pub(crate) fn evaluate_framed(
        &mut self,
        level: Level,
        surface: &Surface,
        block: (u32, u32, u32),
        frames: &mut Frames,
    ) {
        self.samples(level, surface, block, Order::First);
        frames.t = self.n;
        normals(level, &mut self.n, &self.dv);
        tangents(level, &mut frames.t, &self.n);
    }

    /// Moves the points by vectors in the frames.
    pub(crate) fn shift(&mut self, level: Level, frames: &Frames, vectors: &Vectors) {
        let mut way = *vectors;
        frames.to_object(level, &self.n, &mut way);
        self.shift_by(&way);
    }

    /// Moves the points by vectors in object space.
    pub(crate) fn shift_by(&mut self, way: &Vectors) {
        for (p, way) in self.p.iter_mut().zip(way) {
            p.iter_mut().zip(way).for_each(|(p, way)| *p += way);
        }
    }

    /// Points, and of first order, where the normals go, the derivatives by u.
    fn samples(&mut self, level: Level, surface: &Surface, (tile, size, index): (u32, u32, u32), order: Order) {
        let edge = block_edge(size);
        let blocks = size / edge;
        let (column, row) = (index % blocks * edge, index / blocks * edge);
        let grid = Grid { size, placement: Placement::Centred, columns: column..column + edge, rows: row..row + edge };
        let count = grid.len();
        let mut slices = SampleSlices::default();
        // The first derivative by u is written where the normal goes.
        for (slices, values) in slices.values.iter_mut().zip([&mut self.p, &mut self.n, &mut self.dv]) {
            for (slice, values) in slices.iter_mut().zip(values) {
                *slice = &mut values[..count];
            }
        }
        surface.grid_into(level, tile, &grid, order, Destination::Cache, &mut slices);
    }
}

dispatch_simd! {
    /// Makes derivatives by u unit vectors; zero where there is no normal.
    fn tangents = tangents_body(du: &mut Vectors, n: &Vectors)
}

#[inline(always)]
fn tangents_body<A: Arithmetic>(_: A, du: &mut Vectors, n: &Vectors) {
    for i in 0..BLOCK_KNOTS {
        let a = [du[0][i], du[1][i], du[2][i]];
        let square = A::fma(a[0], a[0], A::fma(a[1], a[1], a[2] * a[2]));
        let has_normal = n[0][i] != 0.0 || n[1][i] != 0.0 || n[2][i] != 0.0;
        let scale = if has_normal { 1.0 / square.sqrt() } else { 0.0 };
        for axis in 0..3 {
            du[axis][i] = a[axis] * scale;
        }
    }
}

dispatch_simd! {
    /// Replaces the derivative by u by the unit normal; zero where the derivatives are parallel.
    fn normals = normals_body(du: &mut [[f32; BLOCK_KNOTS]; 3], dv: &[[f32; BLOCK_KNOTS]; 3])
}

#[inline(always)]
fn normals_body<A: Arithmetic>(_: A, du: &mut [[f32; BLOCK_KNOTS]; 3], dv: &[[f32; BLOCK_KNOTS]; 3]) {
    for i in 0..BLOCK_KNOTS {
        let (a, b) = ([du[0][i], du[1][i], du[2][i]], [dv[0][i], dv[1][i], dv[2][i]]);
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let square = A::fma(n[0], n[0], A::fma(n[1], n[1], n[2] * n[2]));
        let scale = if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 };
        for axis in 0..3 {
            du[axis][i] = n[axis] * scale;
        }
    }
}
