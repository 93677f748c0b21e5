//! Places of a surface: a tile and parameters in it. Corners and edges of a tile are numbered as in
//! [`crate::TileTopology`].

use std::mem::offset_of;

use relievo_gpu::wgsl::surface::Place as OnDevice;

/// A point of a surface: a tile and parameters in 0 to 1.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Place {
    /// The tile.
    pub tile: u32,
    /// First parameter, 0 to 1.
    pub u: f32,
    /// Second parameter, 0 to 1.
    pub v: f32,
}

// A twin by hand, for the functions below.
const _: () = assert!(
    size_of::<Place>() == size_of::<OnDevice>()
        && offset_of!(Place, tile) == offset_of!(OnDevice, tile)
        && offset_of!(Place, u) == offset_of!(OnDevice, u)
        && offset_of!(Place, v) == offset_of!(OnDevice, v)
);

impl Place {
    /// The place at `(u, v)` of `tile`.
    pub const fn new(tile: u32, u: f32, v: f32) -> Self {
        Self { tile, u, v }
    }

    /// Corner `corner` (0 to 3) of `tile`.
    pub fn corner(tile: u32, corner: u8) -> Self {
        Self::on_edge(tile, corner, 0.0)
    }

    /// The point at parameter `t` along edge `edge` (0 to 3) of `tile`, counted from corner `edge`.
    pub fn on_edge(tile: u32, edge: u8, t: f32) -> Self {
        let (u, v) = match edge & 3 {
            0 => (t, 0.0),
            1 => (1.0, t),
            2 => (1.0 - t, 1.0),
            _ => (0.0, 1.0 - t),
        };
        Self { tile, u, v }
    }

    /// The edge this place is on and the parameter along it, in multiples of 2⁻²⁴; `None` inside the tile. A corner
    /// is at parameter 0 of its own edge.
    pub fn edge(&self) -> Option<(u8, f32)> {
        let (edge, t) = if self.v == 0.0 && self.u < 1.0 {
            (0, snap(self.u))
        } else if self.u == 1.0 && self.v < 1.0 {
            (1, snap(self.v))
        } else if self.v == 1.0 && self.u > 0.0 {
            (2, 1.0 - self.u)
        } else if self.u == 0.0 {
            (3, 1.0 - self.v)
        } else {
            return None;
        };
        Some(if t == 1.0 { ((edge + 1) & 3, 0.0) } else { (edge, t) })
    }
}

/// `t` rounded to a multiple of 2⁻²⁴, so that `1 − t` is exact.
fn snap(t: f32) -> f32 {
    1.0 - (1.0 - t)
}

/// `t` rounded to a multiple of 2⁻²³, so that `(1 + t) / 2` is exact.
pub(crate) fn snap_half(t: f32) -> f32 {
    (1.0 + t) - 1.0
}
