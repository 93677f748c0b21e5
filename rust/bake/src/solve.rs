//! The displacement whose values at the centres of texels are given.
//!
//! Within a tile whose ring is known that is [`crate::prefilter`]. Rings follow from the border rows of the neighbours
//! by the rules of [`relievo_tiles::ring`], so tiles are solved again with the rings of the last pass. A coefficient of
//! the ring moves the border by a fifth of itself at most, and by a third at a corner that is averaged, so that every
//! pass brings the values nearer by that much; what remains after the last is the rounding of coefficients to half
//! floats. Units: object units.

use std::collections::BTreeMap;

use relievo_core::{Context, Result};
use relievo_surface::{Link, Side};
use relievo_tiles::{Change, Channel, Field, Sets};

use crate::prefilter::{self, SplineTexel};
use crate::restored::refused;

/// The values wanted, by tile; tiles that are not named are to be zero.
pub(crate) struct Target {
    /// The numbers of size² values of each tile.
    pub values: BTreeMap<u32, Vec<f32>>,
    /// How far off a value may be for the rounding of the numbers it came from, besides that of half floats.
    pub step: f32,
}

/// Passes after which values are as near as they come.
const PASSES: usize = 24;
/// Of the largest value around, what rounding to half floats may leave of a coefficient that was zero: half a unit in
/// the last place of each value, fourfold by the prefilter, and twice for good measure.
const ROUNDING: f32 = 8.0 / 2048.0;
/// Half of what the least half floats are apart.
const MIN: f32 = 1.0 / (1 << 25) as f32;

/// Gives the named tiles, which are allocated, and the tiles that turn out to be needed beside them, the wanted values.
/// Returns the largest deviation from them, relative to the largest value.
///
/// Fails if the budget refuses a tile.
pub(crate) fn solve<T: SplineTexel>(
    context: &Context,
    displacement: &mut Channel<T>,
    mut target: Target,
) -> Result<f32> {
    loop {
        let tiles: Vec<u32> = target.values.keys().copied().collect();
        for _ in 0..PASSES {
            let changes = displacement.edit(context, &tiles, |tile, texels| {
                let Some(values) = target.values.get(&tile) else { return };
                let size = texels.size();
                let found = prefilter::coefficients(values, texels.block(), size);
                for (j, row) in found.chunks_exact(size).enumerate() {
                    texels.row_mut(j).copy_from_slice(row);
                }
            })?;
            // Without settling: borders towards tiles that are to be zero are held there.
            if displacement.update_rings(context, &changes)?.is_empty() && changes.is_empty() {
                break;
            }
        }
        let needed = context.map(tiles.len(), |index| needed(displacement.field(), tiles[index], &target));
        let mut needed: Vec<u32> = needed.into_iter().flatten().collect();
        needed.sort_unstable();
        needed.dedup();
        if needed.is_empty() {
            return Ok(deviation(context, displacement.field(), &target));
        }
        let applied = displacement.apply(&Sets { allocate: needed.clone(), ..Sets::default() })?;
        refused(&applied.refused)?;
        displacement.update_rings(context, &applied.changes.iter().map(|c| Change::all(c.tile)).collect::<Vec<_>>())?;
        for tile in needed {
            let size = displacement.field().size(tile) as usize;
            target.values.insert(tile, vec![0.0; size * size * T::NUMBERS]);
        }
    }
}

/// The tiles without a block that `tile` needs to have its values: those beside a border row that is held at zero,
/// where the values say otherwise by more than their rounding.
fn needed<T: SplineTexel>(field: &Field<T>, tile: u32, target: &Target) -> Vec<u32> {
    let (Some(block), Some(wanted)) = (field.block(tile), target.values.get(&tile)) else { return Vec::new() };
    let size = field.size(tile) as usize;
    let topology = field.topology();
    let found = prefilter::values(block, size);
    let differs = |edge: u8, k: usize| {
        let (i, j) = match edge {
            0 => (k, 0),
            1 => (size - 1, k),
            2 => (size - 1 - k, size - 1),
            _ => (0, size - 1 - k),
        };
        let around = |t: usize| t.saturating_sub(1)..(t + 2).min(size);
        let rows = around(j).flat_map(|j| around(i).map(move |i| j * size + i));
        let numbers = |index: usize| index * T::NUMBERS..(index + 1) * T::NUMBERS;
        let largest = rows.flat_map(numbers).map(|at| wanted[at].abs()).fold(0.0, f32::max);
        numbers(j * size + i).any(|at| (found[at] - wanted[at]).abs() > ROUNDING * largest + 8.0 * (target.step + MIN))
    };
    let mut tiles = Vec::new();
    for edge in 0..4u8 {
        let beside: Vec<Side> = match topology.link(tile, edge) {
            Link::Boundary | Link::Pinned { .. } => Vec::new(),
            Link::Whole { side, .. } | Link::Half { side, .. } => vec![side],
            Link::Halves { first, second, .. } => vec![first, second],
        };
        let share = size / beside.len().max(1);
        for (part, side) in beside.into_iter().enumerate() {
            let mut texels = part * share..(part + 1) * share;
            if !field.is_allocated(side.tile) && texels.any(|k| differs(edge, k)) {
                tiles.push(side.tile);
            }
        }
        if differs(edge, 0) {
            let ring = topology.ring(topology.rings(tile)[usize::from(edge)]);
            tiles.extend(ring.iter().map(|entry| entry.tile).filter(|other| !field.is_allocated(*other)));
        }
    }
    tiles
}

/// The largest difference from what is wanted, relative to the largest value wanted.
fn deviation<T: SplineTexel>(context: &Context, field: &Field<T>, target: &Target) -> f32 {
    let tiles: Vec<(&u32, &Vec<f32>)> = target.values.iter().collect();
    let both = context.map(tiles.len(), |index| {
        let (tile, wanted) = tiles[index];
        let found = prefilter::values(field.block(*tile).unwrap_or(&[]), field.size(*tile) as usize);
        let far = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        (far, wanted.iter().map(|value| value.abs()).fold(0.0, f32::max))
    });
    let (far, largest) = both.into_iter().fold((0.0f32, 0.0f32), |(a, b), (c, d)| (a.max(c), b.max(d)));
    if largest > 0.0 { far / largest } else { 0.0 }
}
