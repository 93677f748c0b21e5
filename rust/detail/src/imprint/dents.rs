//! What the displacement update changes of a tile, within which limits, and half floats in their order.

use half::f16;

use crate::channels::knots::BLOCK_KNOTS;

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

/// A block of coefficients, see [`crate::channels::knots`], as they are to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DentBlock {
    /// Its number in the tile.
    pub index: u32,
    /// The coefficients row by row, unchanged ones too.
    pub values: [f16; BLOCK_KNOTS],
}

/// What changes of a tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileDents {
    /// The tile.
    pub tile: u32,
    /// The blocks in which coefficients change, ascending.
    pub blocks: Vec<DentBlock>,
    /// Coefficients that change.
    pub changed: u32,
    /// Coefficients that were looked at.
    pub tested: u32,
    /// Rays that left the grid inside the collider and were held at its border.
    pub clamped: u32,
    /// The least new value.
    pub least: f16,
    /// The greatest new value above 0.
    pub most: f16,
}

/// The largest half float that is not above `value`, of at most 65504.
pub(crate) fn rounded_down(value: f32) -> f16 {
    let value = value.clamp(-65504.0, 65504.0);
    let nearest = f16::from_f32(value);
    unkey(stepped_down(nearest, nearest.to_f32(), value))
}

/// The key of the half float `nearest` to `exact`, whose value is `rounded`, or of the next below where it is above.
#[inline(always)]
pub(crate) fn stepped_down(nearest: f16, rounded: f32, exact: f32) -> i16 {
    key(nearest) - i16::from(rounded > exact)
}

/// The [`key`] of the least coefficient within the limits.
pub(crate) fn deepest(limits: &Limits) -> i16 {
    key(lower_bound(-limits.max_displacement))
}

/// Half floats as integers of the same order.
#[inline(always)]
pub(crate) fn key(value: f16) -> i16 {
    let bits = value.to_bits();
    (bits ^ (((bits as i16) >> 15) as u16 & 0x7fff)) as i16
}

/// The half float of a [`key`].
#[inline(always)]
pub(crate) fn unkey(key: i16) -> f16 {
    f16::from_bits(key as u16 ^ ((key >> 15) as u16 & 0x7fff))
}

/// The least half float that is not below `value`.
pub(crate) fn lower_bound(value: f32) -> f16 {
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
