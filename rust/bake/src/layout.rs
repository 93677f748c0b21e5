//! Where the tiles of a surface lie on its texture coordinates: lattices of each tile in chunks, with their bounds.
//!
//! The texture coordinates are a limit surface of their own ([`Surface::face_varying`]), whose position at (tile, u, v)
//! is (s, t, 0). Lattices are as fine as pixels demand: a cell is about four of them wide, so that between its corners
//! the limit is straight but for a fraction of a pixel. Units: texture coordinates; the picture of UDIM tile (k, l)
//! covers k ≤ s < k + 1 and l ≤ t < l + 1.

use std::collections::BTreeSet;

use relievo_core::{Context, Error, Result};
use relievo_surface::{Grid, Order, Placement, Samples, Surface};

/// A part of the lattice of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chunk {
    /// The tile.
    pub tile: u32,
    /// Cells along its sides.
    pub cells: u32,
    /// First cell along u and v; there are [`CHUNK`] of them, or as many as the tile has.
    pub first: [u32; 2],
    /// Least and largest s and t.
    pub low: [f32; 2],
    pub high: [f32; 2],
}

/// Cells along the sides of a chunk.
pub(crate) const CHUNK: u32 = 16;
/// Samples along a cell.
const CELL: f32 = 4.0;
const MAX_CELLS: u32 = 4096;
/// Chunks of a layout: what a picture of 65,536 pixels a side takes.
const MAX_CHUNKS: u64 = 1 << 23;
/// Samples that the chunks of the largest layout cover.
pub(crate) const MAX_COVERED: f64 = MAX_CHUNKS as f64 * (CHUNK as f64 * CELL as f64) * (CHUNK as f64 * CELL as f64);

/// The layout of a surface at a number of samples per unit.
#[derive(Debug)]
pub(crate) struct Layout<'a> {
    /// The texture coordinates.
    pub limit: &'a Surface,
    /// By tile.
    pub chunks: Vec<Chunk>,
    /// Samples along the sides of a picture.
    pub samples: [u32; 2],
    /// Tiles without an extent.
    pub flat: usize,
}

/// An error that faces cover `times` the square of texture coordinates, with pictures of so many samples a side.
pub(crate) fn covered_too_often(times: f64, [width, height]: [u32; 2]) -> Error {
    let what = format!("the faces cover the square of texture coordinates {times:.0} times");
    Error::invalid(format!("{what}, too often for pictures of {width} by {height} samples"))
        .advise("unwrap the mesh, or bake smaller pictures or with fewer samples")
}

impl Chunk {
    /// Cells along u and v.
    pub fn size(&self) -> u32 {
        self.cells.min(CHUNK)
    }

    /// The grid of its corners.
    pub fn grid(&self) -> Grid {
        let range = |axis: usize| self.first[axis]..self.first[axis] + self.size() + 1;
        Grid { size: self.cells, placement: Placement::Lattice, columns: range(0), rows: range(1) }
    }
}

impl<'a> Layout<'a> {
    /// The layout of the tiles that `skip` does not say to leave out.
    ///
    /// Fails if texture coordinates are so large that their numbers do not resolve pixels, or cover so many pictures
    /// one over the other that no layout was meant.
    pub fn new(
        context: &Context,
        limit: &'a Surface,
        samples: [u32; 2],
        skip: impl Fn(u32) -> bool + Sync,
    ) -> Result<Self> {
        let mut sized = Vec::new();
        let (mut flat, mut count, mut times) = (0, 0u64, 0.0);
        for tile in (0..limit.tile_count() as u32).filter(|tile| !skip(*tile)) {
            let (low, high) = limit.tile_bounds(tile);
            if (0..2).any(|axis| low[axis].abs().max(high[axis].abs()) > LARGEST) {
                return Err(Error::invalid(format!("texture coordinates go to {:?} and {:?}", low, high))
                    .at(format!("tile {tile}"))
                    .advise(format!("keep them within {LARGEST} of 0")));
            }
            let extent = (0..2).map(|axis| (high[axis] - low[axis]) * samples[axis] as f32).fold(0.0, f32::max);
            if extent < 1e-3 {
                flat += 1;
                continue;
            }
            let cells = ((extent / CELL).ceil() as u32).clamp(2, MAX_CELLS).next_power_of_two();
            sized.push((tile, cells));
            count += u64::from(cells.div_ceil(CHUNK)).pow(2);
            times += f64::from(high[0] - low[0]) * f64::from(high[1] - low[1]);
        }
        if count > MAX_CHUNKS {
            return Err(covered_too_often(times, samples));
        }
        let mut empty = Vec::new();
        for (tile, cells) in sized {
            let across = cells.div_ceil(CHUNK);
            for part in 0..across * across {
                let first = [part % across * CHUNK, part / across * CHUNK];
                empty.push(Chunk { tile, cells, first, low: [0.0; 2], high: [0.0; 2] });
            }
        }
        let mut chunks = empty;
        let level = context.level();
        let mut groups: Vec<&mut [Chunk]> = chunks.chunks_mut(64).collect();
        context.for_each_mut(&mut groups, |_, group| {
            let mut corners = Samples::default();
            for chunk in group.iter_mut() {
                limit.grid(level, chunk.tile, &chunk.grid(), Order::Position, &mut corners);
                for axis in 0..2 {
                    chunk.low[axis] = corners.p[axis].iter().copied().fold(f32::INFINITY, f32::min);
                    chunk.high[axis] = corners.p[axis].iter().copied().fold(f32::NEG_INFINITY, f32::max);
                }
            }
        });
        Ok(Self { limit, chunks, samples, flat })
    }

    /// The UDIM tiles that something lies on, by l, then k. Of a chunk that goes beyond one by less than half a sample
    /// no centre of a sample does.
    pub fn pictures(&self) -> BTreeSet<(i32, i32)> {
        let mut found = BTreeSet::new();
        for chunk in &self.chunks {
            let range = |axis: usize| {
                let half = 0.45 / self.samples[axis] as f32;
                (chunk.low[axis] + half).floor() as i32..=(chunk.high[axis] - half).floor() as i32
            };
            range(1).for_each(|l| range(0).for_each(|k| _ = found.insert((l, k))));
        }
        found
    }
}

/// The largest texture coordinate: 1,000 pictures, of whose pixels f32 still tells a fraction apart.
const LARGEST: f32 = 1000.0;
