//! Colour on the surface: a [`Channel`] of colour texels at the centres of a tile's cells, looked up bilinearly.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 5: the
//! ring of one texel lets a look-up stay in its tile, and what is looked up on an edge is the same from both of its
//! tiles: by the rules of [`crate::quads::ring`] where their density is equal, else by those of [`crate::quads::filter`]. Colours are
//! linear Rec.709 with alpha and are interpolated in linear light, whatever the texels encode.

use std::sync::Arc;

use glam::Vec4;
use relievo_core::{Attribute, Domain, Result, Values};
use relievo_surface::{Place, TileTopology};

use crate::quads::channel::{Channel, ChannelOptions};
use crate::quads::field::Field;
use crate::quads::filter::{bilinear, inside};
use crate::quads::tessellate::Tessellation;
use crate::texel::{ColorTexel, Rgba8, Rgba16};

/// Colours that may be edited, four bytes a texel unless it says otherwise.
pub type Paint<T = Rgba8> = Channel<T>;

/// Something that holds colours, by what their texels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByFormat<B, H> {
    /// Four bytes a texel, see [`Rgba8`].
    Rgba8(B),
    /// Four half floats a texel, see [`Rgba16`].
    Rgba16(H),
}

/// Does the same with colours of either format.
#[macro_export]
macro_rules! by_format {
    ($colors:expr, $each:pat => $done:expr) => {
        match $colors {
            $crate::ByFormat::Rgba8($each) => $done,
            $crate::ByFormat::Rgba16($each) => $done,
        }
    };
}

/// The colours of a surface of either format at one moment.
pub type AnyField<'a> = ByFormat<&'a Field<Rgba8>, &'a Field<Rgba16>>;

impl<'a> AnyField<'a> {
    /// See [`Field::color`].
    pub fn color(self, place: Place) -> Vec4 {
        by_format!(self, field => field.color(place))
    }

    /// See [`Field::canonical`].
    pub fn canonical(self, place: Place) -> Place {
        by_format!(self, field => field.canonical(place))
    }

    /// See [`Field::is_allocated`].
    pub fn is_allocated(self, tile: u32) -> bool {
        by_format!(self, field => field.is_allocated(tile))
    }

    /// See [`Field::size`].
    pub fn size(self, tile: u32) -> u32 {
        by_format!(self, field => field.size(tile))
    }
}

impl<T: ColorTexel> Channel<T> {
    /// A surface that has the colour `blank` all over, rounded as texels are.
    ///
    /// # Errors
    /// Fails if a size or face does not exist.
    pub fn of_color(topology: Arc<TileTopology>, blank: Vec4, options: &ChannelOptions) -> Result<Self> {
        Self::blank(topology, T::of_color(blank), options)
    }
}

impl<T: ColorTexel> Field<T> {
    /// The colour at `place`, not filtered: the blank one if its tile is not allocated. Colours agree across seams but
    /// for rounding, at a canonical place to the bit.
    ///
    /// # Panics
    /// If there is no such tile. Parameters outside 0 to 1 are clamped.
    pub fn color(&self, place: Place) -> Vec4 {
        let place = Place { u: inside(place.u), v: inside(place.v), ..place };
        match self.entry(place.tile) {
            Some(entry) if self.uneven(place.tile) == 0 => bilinear(&entry.texels, place, entry.id.class.size()),
            _ => self.sample(place, 0.0),
        }
    }
}

impl Tessellation {
    /// Gives the mesh the colours of `paint` as the point attribute `color`, in place of one it may have: red, green
    /// and blue, linear.
    ///
    /// # Panics
    /// If the tessellation is that of another surface.
    pub fn paint<T: ColorTexel>(&mut self, paint: &Field<T>) {
        let mut values = vec![0.0; 3 * self.mesh.points.len()];
        let mut done = vec![false; self.mesh.points.len()];
        for (corner, point) in self.mesh.corners.iter().enumerate() {
            let point = *point as usize;
            if std::mem::replace(&mut done[point], true) {
                continue;
            }
            let [u, v] = self.parameters[corner];
            let color = paint.color(paint.canonical(Place::new(self.tiles[corner / 3], u, v)));
            values[3 * point..3 * point + 3].copy_from_slice(&color.truncate().to_array());
        }
        self.mesh.attributes.retain(|attribute| attribute.name != "color");
        self.mesh.attributes.push(Attribute {
            name: "color".into(),
            domain: Domain::Point,
            width: 3,
            values: Values::F32(values),
            indices: None,
        });
    }
}

/// The column of the block, counted with the ring, before a parameter, and how far it is on the way to the next.
#[inline(always)]
pub(crate) fn cell(parameter: f32, size: u32) -> (usize, f32) {
    inner_cell(inside(parameter), size)
}

/// As [`cell`], of a parameter from 0 to 1.
#[inline(always)]
pub(crate) fn inner_cell(parameter: f32, size: u32) -> (usize, f32) {
    let x = parameter * size as i32 as f32 + 0.5;
    let column = (x as i32).min(size as i32);
    (column as u32 as usize, x - column as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_run_from_the_ring_to_the_ring() {
        assert_eq!(cell(0.0, 8), (0, 0.5));
        assert_eq!(cell(1.0 / 16.0, 8), (1, 0.0));
        assert_eq!(cell(1.0, 8), (8, 0.5));
        assert_eq!(cell(7.0, 8), (8, 0.5));
        assert_eq!(cell(f32::NAN, 8), cell(0.0, 8));
    }
}
