//! Tiles that culling leaves, and which of their blocks of coefficients may be in the overlap.

use std::ops::Deref;

use relievo_core::{Context, List};

use crate::geometry::voxel_frame::SLACK;

/// A block of coefficients that may be in the overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Its number in the tile, see [`crate::channels::knots`].
    pub index: u32,
    /// Smallest voxel coordinates of its points.
    pub low: [f32; 3],
    /// Largest voxel coordinates of its points.
    pub high: [f32; 3],
}

impl Block {
    /// A block of which nothing is known.
    pub(crate) const EMPTY: Self = Self { index: 0, low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    pub(crate) fn grow(&mut self, low: [f32; 3], high: [f32; 3]) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(low[axis] - SLACK);
            self.high[axis] = self.high[axis].max(high[axis] + SLACK);
        }
    }
}

/// A tile that may have coefficients in the overlap.
#[derive(Clone, Debug, PartialEq)]
pub struct CulledTile {
    /// The tile.
    pub tile: u32,
    /// Its blocks that may, ascending.
    pub blocks: BlockList,
}

/// Blocks of a tile: of small tiles in place, since there may be thousands of them.
#[derive(Clone, Debug)]
pub enum BlockList {
    /// The first so many of these.
    Few([Block; SMALL_TILE_BLOCKS], usize),
    /// More than that.
    Many(Vec<Block>),
}

/// Blocks of a small tile.
const SMALL_TILE_BLOCKS: usize = 4;

impl BlockList {
    /// As many as `count`, one after another.
    pub(crate) fn new(context: &Context, count: u32) -> Self {
        let block = |index| Block { index, ..Block::EMPTY };
        if count as usize <= SMALL_TILE_BLOCKS {
            return Self::Few(std::array::from_fn(|index| block(index as u32)), count as usize);
        }
        let mut blocks = context.scratch().take_list();
        blocks.extend((0..count).map(block));
        Self::Many(blocks)
    }

    /// Gives its room back to the context.
    fn give_back(self, context: &Context) {
        if let Self::Many(blocks) = self {
            context.scratch().keep_list(blocks);
        }
    }

    pub(crate) fn blocks_mut(&mut self) -> &mut [Block] {
        match self {
            Self::Few(blocks, count) => &mut blocks[..*count],
            Self::Many(blocks) => blocks,
        }
    }

    pub(crate) fn retain(&mut self, keep: impl Fn(&Block) -> bool) {
        match self {
            Self::Few(blocks, count) => {
                let before = std::mem::take(count);
                for index in 0..before {
                    if keep(&blocks[index]) {
                        blocks[*count] = blocks[index];
                        *count += 1;
                    }
                }
            }
            Self::Many(blocks) => blocks.retain(keep),
        }
    }
}

impl Deref for BlockList {
    type Target = [Block];

    fn deref(&self) -> &[Block] {
        match self {
            Self::Few(blocks, count) => &blocks[..*count],
            Self::Many(blocks) => blocks,
        }
    }
}

impl PartialEq for BlockList {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

/// Gives the room of culled tiles back to the context that they were culled with.
pub fn give_back(context: &Context, mut culled: Vec<CulledTile>) {
    culled.drain(..).for_each(|tile| tile.blocks.give_back(context));
    context.scratch().keep_list(culled);
}

/// Those of `tiles` of which blocks are left.
pub(crate) fn left(context: &Context, mut tiles: List<'_, CulledTile>) -> Vec<CulledTile> {
    let mut left = context.scratch().take_list();
    for tile in tiles.drain(..) {
        if tile.blocks.is_empty() {
            tile.blocks.give_back(context);
        } else {
            left.push(tile);
        }
    }
    left
}
