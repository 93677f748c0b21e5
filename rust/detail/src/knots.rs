//! The places where displacement coefficients act: limit points and unit normals at the knots of the tiles, in blocks
//! of 16 × 16, kept for tiles that are touched again until the surface moves.

use std::collections::BTreeMap;

use relievo_core::dispatch_simd;
use relievo_core::simd::{Arithmetic, Level};
use relievo_surface::{Destination, Grid, Order, Placement, SampleSlices, Surface};

/// Texels along a block at most.
pub const BLOCK: usize = 16;

/// Knots of a block at most.
pub const BLOCK_KNOTS: usize = BLOCK * BLOCK;

/// Texels along a block of a tile of `size` texels.
pub fn block_edge(size: u32) -> u32 {
    size.min(BLOCK as u32)
}

/// The knots of one block, row by row: x, y and z of the points and of the normals, in object space.
#[derive(Clone, Debug)]
pub struct KnotBlock {
    /// Points of the limit surface.
    pub p: [[f32; BLOCK_KNOTS]; 3],
    /// Unit normals.
    pub n: [[f32; BLOCK_KNOTS]; 3],
}

impl KnotBlock {
    /// Evaluates block `index` of `tile`, whose tiles have `size` texels a side.
    pub fn evaluate(&mut self, level: Level, surface: &Surface, tile: u32, size: u32, index: u32) {
        let edge = block_edge(size);
        let blocks = size / edge;
        let (column, row) = (index % blocks * edge, index / blocks * edge);
        let grid = Grid { size, placement: Placement::Centred, columns: column..column + edge, rows: row..row + edge };
        let count = grid.len();
        let mut dv = [[0.0; BLOCK_KNOTS]; 3];
        let mut slices = SampleSlices::default();
        // The first derivative by u is written where the normal goes.
        for (slices, values) in slices.values.iter_mut().zip([&mut self.p, &mut self.n, &mut dv]) {
            for (slice, values) in slices.iter_mut().zip(values) {
                *slice = &mut values[..count];
            }
        }
        surface.grid_into(level, tile, &grid, Order::First, Destination::Cache, &mut slices);
        normals(level, &mut self.n, &dv);
    }
}

dispatch_simd! {
    /// Replaces the derivative by u by the unit normal; zero where the derivatives are parallel.
    fn normals = normals_body(du: &mut [[f32; BLOCK_KNOTS]; 3], dv: &[[f32; BLOCK_KNOTS]; 3])
}

#[inline(always)]
fn normals_body<A: Arithmetic>(du: &mut [[f32; BLOCK_KNOTS]; 3], dv: &[[f32; BLOCK_KNOTS]; 3]) {
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

/// The blocks of one tile that were evaluated.
#[derive(Debug, Default)]
pub struct TileKnots {
    blocks: Vec<Option<Box<KnotBlock>>>,
    used: u64,
}

impl TileKnots {
    /// Block `index`, evaluated if it is not there yet.
    pub fn block(&mut self, level: Level, surface: &Surface, tile: u32, size: u32, index: u32) -> &KnotBlock {
        let count = (size / block_edge(size)).pow(2) as usize;
        if self.blocks.len() != count {
            self.blocks.clear();
            self.blocks.resize_with(count, || None);
        }
        self.blocks[index as usize].get_or_insert_with(|| {
            let mut block = Box::new(KnotBlock { p: [[0.0; BLOCK_KNOTS]; 3], n: [[0.0; BLOCK_KNOTS]; 3] });
            block.evaluate(level, surface, tile, size, index);
            block
        })
    }

    fn count(&self) -> usize {
        self.blocks.iter().flatten().count()
    }
}

/// The evaluated knots of an object's tiles.
#[derive(Debug, Default)]
pub struct Knots {
    tiles: BTreeMap<u32, TileKnots>,
    clock: u64,
}

/// Bytes of knots an object keeps between imprints.
const CAPACITY: usize = 64 << 20;

impl Knots {
    /// Forgets everything, because the surface moved.
    pub fn forget(&mut self) {
        self.tiles.clear();
    }

    /// Takes out what there is for `tile`.
    pub fn take(&mut self, tile: u32) -> TileKnots {
        self.tiles.remove(&tile).unwrap_or_default()
    }

    /// Puts tiles back and forgets those unused for longest where there is too much.
    pub fn put(&mut self, tiles: impl IntoIterator<Item = (u32, TileKnots)>) {
        self.clock += 1;
        for (tile, mut knots) in tiles {
            knots.used = self.clock;
            self.tiles.insert(tile, knots);
        }
        let mut bytes = self.bytes();
        while bytes > CAPACITY && self.tiles.len() > 1 {
            let oldest = self.tiles.iter().min_by_key(|(tile, knots)| (knots.used, **tile)).map(|(tile, _)| *tile);
            let Some(dropped) = oldest.and_then(|tile| self.tiles.remove(&tile)) else { break };
            bytes -= dropped.count() * size_of::<KnotBlock>();
        }
    }

    /// Bytes of the evaluated blocks.
    pub fn bytes(&self) -> usize {
        self.tiles.values().map(|knots| knots.count() * size_of::<KnotBlock>()).sum()
    }
}
