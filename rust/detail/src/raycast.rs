//! The displacement update: every coefficient's point that lies in the voxels is moved along −N until it leaves them
//! (Schäfer et al. 2014, Section 6). Coefficients are constrained, not fitted.
//!
//! Distances are measured along the image of the object's own normal, so they are in object units whatever the
//! object's scale. Results are rounded to half floats away from the collider.

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, dispatch_simd};
use relievo_surface::Surface;
use relievo_tiles::Field;

use crate::cull::{CulledTile, VoxelFrame};
use crate::dda::Exit;
use crate::knots::{BLOCK_KNOTS, KnotBlock, Knots, TileKnots, block_edge};
use crate::voxel::Voxels;

/// What limits the displacement update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Share of the distance that is applied, 0 to 1.
    pub share: f32,
    /// Object units that a coefficient may be displaced inwards.
    pub max_displacement: f32,
    /// Object units that a coefficient may move at a time.
    pub depth: f32,
}

/// What changes of a tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileDents {
    /// The tile.
    pub tile: u32,
    /// Index (row · size + column, without the ring) and new value of each coefficient that changes.
    pub texels: Vec<(u32, f16)>,
    /// Coefficients that were looked at.
    pub tested: u32,
    /// Rays that left the grid inside the collider and were held at its border.
    pub clamped: u32,
    /// The least new value.
    pub least: f32,
}

/// Casts the rays of all coefficients in `tiles`. What is returned is in their order; tiles without a change are left
/// out.
#[allow(clippy::too_many_arguments)]
pub fn cast(
    context: &Context,
    surface: &Surface,
    field: &Field,
    knots: &mut Knots,
    tiles: &[CulledTile],
    frame: &VoxelFrame,
    voxels: &Voxels,
    limits: &Limits,
) -> Vec<TileDents> {
    let mut work: Vec<(&CulledTile, TileKnots, TileDents)> =
        tiles.iter().map(|tile| (tile, knots.take(tile.tile), TileDents::default())).collect();
    let level = context.level();
    context.for_each_mut(&mut work, |_, (tile, knots, dents)| {
        *dents = cast_tile(level, surface, field, knots, tile, frame, voxels, limits);
    });
    let mut dents = Vec::with_capacity(work.len());
    knots.put(work.into_iter().map(|(tile, knots, found)| {
        dents.push(found);
        (tile.tile, knots)
    }));
    dents
}

#[allow(clippy::too_many_arguments)]
fn cast_tile(
    level: Level,
    surface: &Surface,
    field: &Field,
    knots: &mut TileKnots,
    culled: &CulledTile,
    frame: &VoxelFrame,
    voxels: &Voxels,
    limits: &Limits,
) -> TileDents {
    let tile = culled.tile;
    let size = field.size(tile);
    let edge = block_edge(size);
    let coefficients = field.block(tile);
    let mut dents = TileDents { tile, ..TileDents::default() };
    let mut values = [0.0; BLOCK_KNOTS];
    let mut probes = Probes::default();
    let deepest = key(lower_bound(-limits.max_displacement));
    let mut least = 0i16;
    for block in &culled.blocks {
        let (column, row) = (block % (size / edge) * edge, block / (size / edge) * edge);
        if let Some(coefficients) = coefficients {
            for (j, values) in values.chunks_mut(edge as usize).take(edge as usize).enumerate() {
                let start = ((row + 1) as usize + j) * (size as usize + 2) + column as usize + 1;
                coefficients[start..start + edge as usize].convert_to_f32_slice(values);
            }
        }
        let knots = knots.block(level, surface, tile, size, *block);
        let count = (edge * edge) as usize;
        probe(level, frame, knots, &values, voxels.grid().dims, voxels.grid().words(), &mut probes);
        dents.tested += count as u32;
        let words = voxels.words();
        for k in 0..count {
            let cell = probes.cell[k];
            if cell == OUTSIDE || words[cell as usize] >> probes.bit[k] & 1 == 0 {
                continue;
            }
            let value = values[k];
            // Beyond this distance nothing would change any more.
            let reach = ((value + limits.max_displacement) / limits.share).min(limits.depth / limits.share);
            // Not a number, as for a share of 0, ends here as well.
            if !(reach > 0.0) {
                continue;
            }
            let normal = [knots.n[0][k], knots.n[1][k], knots.n[2][k]];
            let direction = frame.turn(normal).map(|value| -value);
            if direction == [0.0; 3] {
                continue;
            }
            let distance = match voxels.exit([probes.q[0][k], probes.q[1][k], probes.q[2][k]], direction, reach) {
                Exit::Outside | Exit::Border => continue,
                Exit::Clear(distance) => distance,
                Exit::Grid(distance) => {
                    dents.clamped += 1;
                    distance
                }
                Exit::Limit => reach,
            };
            // Values are half floats, so rounding them down changes nothing.
            let new = key(rounded_down(value - limits.share * distance)).max(deepest);
            if new < key(rounded_down(value)) {
                let k = k as u32;
                let new_value = unkey(new);
                dents.texels.push(((row + k / edge) * size + column + k % edge, new_value));
                least = least.min(new);
            }
        }
    }
    dents.least = unkey(least).to_f32();
    dents
}

/// A place outside the grid.
const OUTSIDE: u32 = u32::MAX;

/// Where the points of a block are in the voxels: coordinates, word and bit.
struct Probes {
    q: [[f32; BLOCK_KNOTS]; 3],
    cell: [u32; BLOCK_KNOTS],
    bit: [u32; BLOCK_KNOTS],
}

impl Default for Probes {
    fn default() -> Self {
        Self { q: [[0.0; BLOCK_KNOTS]; 3], cell: [OUTSIDE; BLOCK_KNOTS], bit: [0; BLOCK_KNOTS] }
    }
}

dispatch_simd! {
    /// Places the points of a block, surface plus coefficient times normal, in the voxels.
    fn probe = probe_body(
        frame: &VoxelFrame, knots: &KnotBlock, values: &[f32; BLOCK_KNOTS], dims: [u32; 3], words: u32, probes: &mut Probes
    )
}

#[inline(always)]
fn probe_body<A: Arithmetic>(
    frame: &VoxelFrame,
    knots: &KnotBlock,
    values: &[f32; BLOCK_KNOTS],
    dims: [u32; 3],
    words: u32,
    probes: &mut Probes,
) {
    let frame = *frame;
    let nx = dims[0];
    for k in 0..BLOCK_KNOTS {
        let v: [f32; 3] =
            std::array::from_fn(|axis| A::fma(values[k], knots.n[axis][k], knots.p[axis][k] - frame.origin[axis]));
        let q = frame.rows.map(|row| A::fma(row[0], v[0], A::fma(row[1], v[1], row[2] * v[2])));
        let q: [f32; 3] = std::array::from_fn(|axis| q[axis] + frame.shift[axis]);
        let mut inside = true;
        for axis in 0..3 {
            probes.q[axis][k] = q[axis];
            inside &= q[axis] >= 0.0 && q[axis] < frame.dims[axis];
        }
        let [x, y, z] = q.map(|value| value.clamp(0.0, 65535.0) as i32 as u32);
        let cell = (y.wrapping_mul(words).wrapping_add(z >> 6)).wrapping_mul(nx).wrapping_add(x);
        probes.cell[k] = if inside { cell } else { OUTSIDE };
        probes.bit[k] = z & 63;
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
