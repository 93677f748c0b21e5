//! Nouns of details on surfaces: their layers, edits, files and colours.

pub mod bake;
pub mod brush;
pub mod collider;
pub mod color_buffer;
pub mod decal;
pub mod detail;
pub mod document;
pub mod imprint;
pub mod layer;
pub mod object;
pub mod stroke;
pub mod view;
