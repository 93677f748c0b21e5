//! Strokes on a graphics device.

pub(crate) mod brush;
pub(crate) mod channels;
pub(crate) mod colors;
pub(crate) mod dabs;
pub(crate) mod events;
mod follow;
mod intersect;
mod memory;
mod smear;
mod still;
pub(crate) mod triangle_brush;
