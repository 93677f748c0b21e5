//! The displacement that a dab goes by: where its places are, and so what share of the edit they get.
//!
//! That is the displacement when the stroke began, scalar and vectors, so that dabs which overlap add up. Units: object
//! units; vectors have their components in the frames of the places.

use std::cell::Cell;

use half::slice::HalfFloatSliceExt;
use relievo_core::simd::Level;
use relievo_surface::{Order, Surface};
use relievo_tiles::spline::{self, Jets};
use relievo_tiles::{Displaced, Field, Vector};

use crate::channels::frame::{STILL, Vectors};
use crate::channels::knots::PerKnot;
use crate::channels::window::{PlaceShift, Window};
use crate::paint::vector::VectorTexel;

thread_local! {
    /// Room for the displacements of a window.
    static JETS: Cell<[Jets; 3]> = Cell::default();
}

/// Displacements that dabs go by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
    pub heights: &'a Field,
    pub vectors: Option<&'a Field<Vector>>,
}

impl<'a> Ground<'a> {
    /// The surface with these displacements. Fails never, unless they are those of another surface.
    pub fn displaced(&self, surface: &'a Surface) -> relievo_core::Result<Displaced<'a>> {
        let displaced = Displaced::new(surface, self.heights)?;
        self.vectors.map_or(Ok(displaced), |vectors| displaced.with_vectors(vectors))
    }

    /// What moves the texels of a window of any channel.
    pub fn at_texels(&self, level: Level, window: &Window, heights: &mut PerKnot, vectors: &mut Vectors) -> PlaceShift {
        let raised = self.heights(level, window, heights);
        match self.vectors(level, window, vectors) {
            true => PlaceShift::Vectors,
            false if raised => PlaceShift::Heights,
            false => PlaceShift::Still,
        }
    }

    /// What moves the coefficients of a window of the scalar displacement: no less than heights, which are its
    /// coefficients themselves.
    pub fn at_coefficients(
        &self,
        level: Level,
        window: &Window,
        heights: &mut PerKnot,
        vectors: &mut Vectors,
    ) -> PlaceShift {
        self.height_coefficients(window, heights);
        if self.vectors(level, window, vectors) { PlaceShift::Vectors } else { PlaceShift::Heights }
    }

    /// The scalar displacement at the texels of a window; false, with zeros written, if the tile has none.
    pub fn heights(&self, level: Level, window: &Window, out: &mut PerKnot) -> bool {
        let Some(block) = self.heights.block(window.tile) else {
            out.fill(0.0);
            return false;
        };
        let size = self.heights.size(window.tile);
        if size == window.size() {
            spline::coefficient_places(level, block, size, window.first(), window.edge(), out);
            return true;
        }
        let ([us, vs], edge) = (window.parameters(), window.edge());
        let mut jets = JETS.take();
        spline::grid(level, block, size, &us[..edge], &vs[..edge], Order::Position, &mut jets[0]);
        jets[0].d.iter().zip(out).for_each(|(d, out)| *out = *d);
        JETS.set(jets);
        true
    }

    /// The vectors at the texels of a window of any channel; false, with nothing written, if the tile has none.
    pub fn vectors(&self, level: Level, window: &Window, out: &mut Vectors) -> bool {
        let Some((field, block)) = self.vectors.and_then(|field| Some((field, field.block(window.tile)?))) else {
            return false;
        };
        let ([us, vs], edge, size) = (window.parameters(), window.edge(), field.size(window.tile));
        let mut jets = JETS.take();
        spline::vector_grid(level, block, size, &us[..edge], &vs[..edge], Order::Position, &mut jets);
        for (jets, out) in jets.iter().zip(out) {
            jets.d.iter().zip(out).for_each(|(d, out)| *out = *d);
        }
        JETS.set(jets);
        true
    }

    /// The coefficients of a window of the scalar displacement itself.
    pub fn height_coefficients(&self, window: &Window, out: &mut PerKnot) {
        let Some(block) = self.heights.block(window.tile) else { return out.fill(0.0) };
        for (row, out) in window.rows(0, 0).zip(out.chunks_exact_mut(window.edge())) {
            block[row].convert_to_f32_slice(out);
        }
    }

    /// The coefficients of a window of the vectors themselves; zeros if the tile has none.
    pub fn vector_coefficients(&self, window: &Window, out: &mut Vectors) {
        *out = STILL;
        let Some(block) = self.vectors.and_then(|field| field.block(window.tile)) else { return };
        for (row, start) in window.rows(0, 0).zip((0..).step_by(window.edge())) {
            Vector::read(&block[row], out, start);
        }
    }
}
