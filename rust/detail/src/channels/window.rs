//! Blocks of texels of a tile, in which brushes and imprints work, and what moves their places.

use crate::channels::knots::{BLOCK, block_edge};

/// A block of texels of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub tile: u32,
    size: u32,
    edge: u32,
    column: u32,
    row: u32,
}

impl Window {
    pub fn new(tile: u32, size: u32, index: u32) -> Self {
        let edge = block_edge(size);
        let blocks = size / edge;
        Self { tile, size, edge, column: index % blocks * edge, row: index / blocks * edge }
    }

    fn stride(&self) -> usize {
        self.size as usize + 2
    }

    /// Texels of the block.
    pub fn count(&self) -> usize {
        (self.edge * self.edge) as usize
    }

    /// Texels along the block.
    pub fn edge(&self) -> usize {
        self.edge as usize
    }

    /// Where its columns and rows of texels are in the tile, 0 to 1; as many as there are along the block.
    pub fn parameters(&self) -> [[f32; BLOCK]; 2] {
        self.first().map(|first| std::array::from_fn(|i| ((first + i as u32) as f32 + 0.5) / self.size as f32))
    }

    /// Texels along the tile's sides.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// The column and the row of its first texel.
    pub fn first(&self) -> [u32; 2] {
        [self.column, self.row]
    }

    /// Where each of its rows begins in the tile's block, moved by some columns and rows.
    pub fn rows(&self, columns: i32, rows: i32) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let (stride, edge) = (self.stride(), self.edge as usize);
        let first = (self.row as i32 + 1 + rows) as usize * stride + (self.column as i32 + 1 + columns) as usize;
        (0..edge).map(move |row| first + row * stride..first + row * stride + edge)
    }
}

/// What moves the places of a window, or asks for as much to be known of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaceShift {
    /// Nothing: points are enough.
    Still,
    /// Heights along the normals.
    Heights,
    /// Vectors in the frames, before the heights.
    Vectors,
}
