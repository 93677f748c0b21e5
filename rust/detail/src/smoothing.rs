//! Smoothing of dents after an imprint, "to reflect the underlying material properties" (Schäfer et al. 2014, Section
//! 6): coefficients around those that changed move toward the mean of their four neighbours, across tile borders by
//! the ring.

use half::f16;
use relievo_core::{Context, Result};
use relievo_tiles::{Change, Displacement};

use crate::raycast::TileDents;

/// Texels around a changed one that are smoothed as well.
const REACH: u32 = 2;

/// Smooths `passes` times with `strength` 0 to 1 around the texels of `dents`, which are allocated. Returns the tiles
/// the budget refused.
pub fn smooth(
    context: &Context,
    displacement: &mut Displacement,
    dents: &[&TileDents],
    strength: f32,
    passes: u32,
) -> Result<Vec<u32>> {
    let tiles: Vec<u32> = dents.iter().map(|dents| dents.tile).collect();
    let field = displacement.field();
    let masks: Vec<Vec<bool>> = context.map(dents.len(), |index| mask(dents[index], field.size(dents[index].tile)));
    let mut refused = Vec::new();
    for _ in 0..passes {
        let changes: Vec<Change> = displacement.edit(context, &tiles, |tile, texels| {
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

/// The texels within reach of a changed one.
fn mask(dents: &TileDents, size: u32) -> Vec<bool> {
    let mut mask = vec![false; (size * size) as usize];
    for (texel, _) in &dents.texels {
        let (row, column) = (texel >> 16, texel & 0xffff);
        for j in row.saturating_sub(REACH)..(row + REACH + 1).min(size) {
            for i in column.saturating_sub(REACH)..(column + REACH + 1).min(size) {
                mask[(j * size + i) as usize] = true;
            }
        }
    }
    mask
}
