//! Smoothing of dents after an imprint, "to reflect the underlying material properties" (Schäfer et al. 2014, Section
//! 6): coefficients around changed ones move toward the mean of their four neighbours, across tile borders by
//! the ring.

use half::f16;
use relievo_core::{Context, Result};
use relievo_tiles::{Change, Displacement, Field};

use crate::channels::knots::block_edge;
use crate::imprint::dents::TileDents;

/// Texels around a changed one that are smoothed as well.
const REACH: u32 = 2;

/// Smooths `passes` times with `strength` 0 to 1 the texels of `tiles`, ascending and allocated, that `masks` name.
/// Returns the tiles the budget refused.
pub fn smooth(
    context: &Context,
    displacement: &mut Displacement,
    tiles: &[u32],
    masks: &[Vec<bool>],
    strength: f32,
    passes: u32,
) -> Result<Vec<u32>> {
    let mut refused = Vec::new();
    for _ in 0..passes {
        let changes: Vec<Change> = displacement.edit(context, tiles, |tile, texels| {
            let Ok(index) = tiles.binary_search(&tile) else { return };
            let size = texels.size();
            let stride = size + 2;
            let old = texels.block().to_vec();
            for j in 0..size {
                let row = texels.row_mut(j);
                for (i, value) in row.iter_mut().enumerate().filter(|(i, _)| masks[index][j * size + i]) {
                    let at = (j + 1) * stride + i + 1;
                    let around = [at - stride, at - 1, at + 1, at + stride].map(|at| old[at].to_f32());
                    let mean = 0.25 * ((around[0] + around[3]) + (around[1] + around[2]));
                    let here = old[at].to_f32();
                    *value = f16::from_f32(here + strength * (mean - here));
                }
            }
        })?;
        refused.extend(displacement.settle(context, &changes)?);
    }
    Ok(refused)
}

/// The texels of each of `dents` that `order` names within reach of one that will change, row by row. To be asked before
/// they do.
pub fn masks(context: &Context, field: &Field, dents: &[TileDents], order: &[usize]) -> Vec<Vec<bool>> {
    context.map(order.len(), |index| mask(field, &dents[order[index]]))
}

fn mask(field: &Field, dents: &TileDents) -> Vec<bool> {
    let size = field.size(dents.tile);
    let edge = block_edge(size);
    let old = field.block(dents.tile);
    let mut mask = vec![false; (size * size) as usize];
    for block in &dents.blocks {
        for k in 0..edge * edge {
            let (row, column) =
                (block.index / (size / edge) * edge + k / edge, block.index % (size / edge) * edge + k % edge);
            let before = old.map_or(f16::ZERO, |old| old[((row + 1) * (size + 2) + column + 1) as usize]);
            if block.values[k as usize] == before {
                continue;
            }
            for j in row.saturating_sub(REACH)..(row + REACH + 1).min(size) {
                for i in column.saturating_sub(REACH)..(column + REACH + 1).min(size) {
                    mask[(j * size + i) as usize] = true;
                }
            }
        }
    }
    mask
}
