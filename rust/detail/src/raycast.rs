//! The displacement update: every coefficient's point that lies in the voxels is moved along −N until it leaves them
//! (Schäfer et al. 2014, Section 6). Coefficients are constrained, not fitted.
//!
//! Distances are measured along the image of the object's own normal, so they are in object units whatever the
//! object's scale. Results are rounded to half floats away from the collider.

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;
use relievo_core::{Context, dispatch_simd};
use relievo_surface::Surface;
use relievo_tiles::Field;

use crate::cull::{CulledTile, VoxelFrame};
use crate::knots::{BLOCK_KNOTS, KnotBlock, block_edge};
use crate::rays::Rays;
use crate::voxel::{Columns, Voxels};

/// What limits the displacement update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Share of the distance that is applied, 0 to 1.
    pub share: f32,
    /// Object units that a coefficient may be displaced inwards.
    pub max_displacement: f32,
    /// Object units that a coefficient may move, counted from what it was in `start`.
    pub depth: f32,
}

/// What changes of a tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileDents {
    /// The tile.
    pub tile: u32,
    /// Place (row · 65536 + column, without the ring) and new value of each coefficient that changes.
    pub texels: Vec<(u32, f16)>,
    /// Coefficients that were looked at.
    pub tested: u32,
    /// Rays that left the grid inside the collider and were held at its border.
    pub clamped: u32,
    /// The least new value.
    pub least: f16,
}

/// Casts the rays of all coefficients in `tiles`. What is returned is in their order.
///
/// `start` are the displacements from which the depth limit counts, those of `field` where it is `None`.
#[allow(clippy::too_many_arguments)]
pub fn cast(
    context: &Context,
    surface: &Surface,
    field: &Field,
    start: Option<&Field>,
    tiles: &[CulledTile],
    frame: &VoxelFrame,
    voxels: &Voxels,
    limits: &Limits,
) -> Vec<TileDents> {
    if limits.share <= 0.0 {
        return Vec::new();
    }
    let level = context.level();
    context.map(tiles.len(), |index| cast_tile(level, surface, field, start, &tiles[index], frame, voxels, limits))
}

#[allow(clippy::too_many_arguments)]
fn cast_tile(
    level: Level,
    surface: &Surface,
    field: &Field,
    start: Option<&Field>,
    culled: &CulledTile,
    frame: &VoxelFrame,
    voxels: &Voxels,
    limits: &Limits,
) -> TileDents {
    let tile = culled.tile;
    let size = field.size(tile);
    let edge = block_edge(size);
    let count = (edge * edge) as usize;
    let columns = voxels.columns();
    let mut dents = TileDents { tile, ..TileDents::default() };
    // What the coefficients are and what they were; unallocated ones are zero.
    let sources = [field.block(tile), start.map_or_else(|| field.block(tile), |start| start.block(tile))];
    let mut values = [[f16::ZERO; BLOCK_KNOTS]; 2];
    let mut knots = KnotBlock::ZERO;
    let mut scratch = Scratch::default();
    for block in culled.blocks.iter().filter(|block| voxels.may_meet(block.low, block.high)) {
        let (column, row) = (block.index % (size / edge) * edge, block.index / (size / edge) * edge);
        for (source, values) in sources.iter().zip(&mut values) {
            let Some(source) = source else { continue };
            for (j, values) in values.chunks_mut(edge as usize).take(edge as usize).enumerate() {
                let first = ((row + 1) as usize + j) * (size as usize + 2) + column as usize + 1;
                values.copy_from_slice(&source[first..first + edge as usize]);
            }
        }
        knots.evaluate(level, surface, tile, size, block.index);
        let found = dents.texels.len();
        cast_block(level, frame, &knots, &values[0][..count], &values[1], &columns, limits, &mut scratch, &mut dents);
        for (k, _) in &mut dents.texels[found..] {
            *k = texel(row + *k / edge, column + *k % edge);
        }
        dents.tested += count as u32;
    }
    dents
}

/// Where a texel is in its tile, as [`TileDents::texels`] says.
pub(crate) fn texel(row: u32, column: u32) -> u32 {
    row << 16 | column
}

dispatch_simd! {
    /// Appends the coefficients of a block that change, by their index in the block.
    fn cast_block = cast_block_body(
        frame: &VoxelFrame, knots: &KnotBlock, values: &[f16], start: &[f16; BLOCK_KNOTS], columns: &Columns<'_>,
        limits: &Limits, scratch: &mut Scratch, dents: &mut TileDents
    )
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn cast_block_body<A: Lanes>(
    frame: &VoxelFrame,
    knots: &KnotBlock,
    values: &[f16],
    start: &[f16; BLOCK_KNOTS],
    columns: &Columns<'_>,
    limits: &Limits,
    scratch: &mut Scratch,
    dents: &mut TileDents,
) {
    // SAFETY: called by `dispatch_simd!` only.
    #[allow(unsafe_code)]
    let v = unsafe { A::assume() };
    let count = values.len();
    let Scratch { heights, starts, distance, new, changed } = scratch;
    values.convert_to_f32_slice(&mut heights[..count]);
    start[..count].convert_to_f32_slice(&mut starts[..count]);
    let mut any = false;
    for at in (0..count).step_by(A::WIDTH) {
        let p = [v.load(&knots.p[0][at..]), v.load(&knots.p[1][at..]), v.load(&knots.p[2][at..])];
        let n = [v.load(&knots.n[0][at..]), v.load(&knots.n[1][at..]), v.load(&knots.n[2][at..])];
        let height = [v.load(&heights[at..]), v.load(&starts[at..])];
        let ready = Rays::new(v, frame, columns, limits, p, n, height);
        let (distances, clamped) = ready.distances(v, columns);
        any |= v.mask(v.lt(v.splat(0.0), distances)) != 0;
        dents.clamped += clamped;
        v.store(distances, &mut distance[at..]);
    }
    if !any {
        return;
    }
    let deepest = key(lower_bound(-limits.max_displacement));
    for k in 0..BLOCK_KNOTS {
        new[k] = key(rounded_down(heights[k] - limits.share * distance[k])).max(deepest);
    }
    // Listed without a branch.
    let mut found = 0;
    for (k, (new, value)) in new.iter().zip(values).enumerate() {
        changed[found] = k as u16;
        found += usize::from(*new < key(*value));
    }
    dents.texels.extend(changed[..found].iter().map(|k| (u32::from(*k), unkey(new[usize::from(*k)]))));
    let least = changed[..found].iter().map(|k| new[usize::from(*k)]).min().unwrap_or(0);
    dents.least = dents.least.min(unkey(least));
}

/// What is computed of a block side by side; kept between blocks so that it need not be cleared.
struct Scratch {
    heights: [f32; BLOCK_KNOTS],
    starts: [f32; BLOCK_KNOTS],
    distance: [f32; BLOCK_KNOTS],
    new: [i16; BLOCK_KNOTS],
    changed: [u16; BLOCK_KNOTS],
}

impl Default for Scratch {
    fn default() -> Self {
        let zero = [0.0; BLOCK_KNOTS];
        Self { heights: zero, starts: zero, distance: zero, new: [0; BLOCK_KNOTS], changed: [0; BLOCK_KNOTS] }
    }
}

/// The largest half float that is not above `value`; the least finite one for what is below all.
#[inline(always)]
fn rounded_down(value: f32) -> f16 {
    let negative = value < 0.0;
    let magnitude = value.abs().min(65504.0);
    // Away from zero below it, toward zero above it.
    let bits = if magnitude < 6.103_515_6e-5 {
        // Denormal half floats are multiples of 2^−24.
        let steps = magnitude * 16_777_216.0;
        (if negative { steps.ceil() } else { steps.floor() }) as u32
    } else {
        (magnitude.to_bits() - (112 << 23) + if negative { 0x1fff } else { 0 }) >> 13
    };
    f16::from_bits(bits as u16 | u16::from(negative && bits != 0) << 15)
}

/// Half floats as integers of the same order.
#[inline(always)]
fn key(value: f16) -> i16 {
    let bits = value.to_bits();
    (bits ^ (((bits as i16) >> 15) as u16 & 0x7fff)) as i16
}

/// The half float of a [`key`].
#[inline(always)]
fn unkey(key: i16) -> f16 {
    f16::from_bits(key as u16 ^ ((key >> 15) as u16 & 0x7fff))
}

/// The least half float that is not below `value`.
fn lower_bound(value: f32) -> f16 {
    -rounded_down(-value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rounding_goes_down_and_by_less_than_one_step(value in prop_oneof![-70000.0f32..70000.0, -1e-6f32..1e-6, -1.0f32..1.0]) {
            let down = rounded_down(value);
            let clamped = value.clamp(-65504.0, 65504.0);
            prop_assert!(down.is_finite() && down.to_f32() <= value.max(-65504.0));
            let up = f16::from_bits(if down.to_bits() == 0x8000 || down.to_bits() == 0 { 1 } else if down.is_sign_negative() { down.to_bits() - 1 } else { down.to_bits() + 1 });
            prop_assert!(up.to_f32() > clamped || up.to_f32().is_infinite() || down.to_f32() == clamped, "{value} {down} {up}");
            prop_assert!(lower_bound(value.clamp(-60000.0, 60000.0)).to_f32() >= value.clamp(-60000.0, 60000.0));
        }
    }
}
