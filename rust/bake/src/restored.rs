//! Channels that are made of texels from a file: their tiles, within a budget, and how they meet.

use relievo_core::{Context, Error, Result};
use relievo_tiles::{Change, Channel, ChannelOptions, Sets, Texel};

/// Options of a channel with these texels along the edges of each face.
pub(crate) fn options(face_sizes: Vec<u32>, budget: u64) -> ChannelOptions {
    ChannelOptions { face_sizes: (0..).zip(face_sizes).collect(), budget, ..ChannelOptions::default() }
}

/// Allocates `tiles`. Fails if the budget refuses one.
pub(crate) fn allocate<T: Texel>(channel: &mut Channel<T>, tiles: &[u32]) -> Result<()> {
    let needed: u64 = tiles.iter().map(|tile| channel.field().tile_bytes(*tile)).sum();
    if needed > channel.budget() {
        return Err(Error::memory(format!("the tiles take {needed} bytes and their budget is {}", channel.budget()))
            .advise(format!("allow at least {needed} bytes")));
    }
    let applied = channel.apply(&Sets { allocate: tiles.to_vec(), ..Sets::default() })?;
    refused(&applied.refused)
}

/// Gives `tiles`, which are allocated and ascend, these texels each.
pub(crate) fn fill<T: Texel>(
    context: &Context,
    channel: &mut Channel<T>,
    tiles: &[u32],
    texels: &[Vec<T>],
) -> Result<()> {
    channel.edit(context, tiles, |tile, block| {
        let Ok(index) = tiles.binary_search(&tile) else { return };
        let size = block.size();
        for (j, row) in texels[index].chunks_exact(size).enumerate() {
            block.row_mut(j).copy_from_slice(row);
        }
    })?;
    Ok(())
}

/// Brings the rings of `tiles` up to date. Fails if the budget refuses a tile that they reach.
pub(crate) fn settle<T: Texel>(context: &Context, channel: &mut Channel<T>, tiles: &[u32]) -> Result<()> {
    let changes: Vec<Change> = tiles.iter().map(|tile| Change::all(*tile)).collect();
    refused(&channel.settle(context, &changes)?)
}

/// Fails if the budget refused a tile.
pub(crate) fn refused(tiles: &[u32]) -> Result<()> {
    match tiles.first() {
        None => Ok(()),
        Some(first) => Err(Error::memory(format!("the budget refused {} tiles", tiles.len()))
            .at(format!("tile {first}"))
            .advise("allow more bytes")),
    }
}
