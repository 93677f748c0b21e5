//! The format of scene files: its schema, the reader, and what a file says as plain data.

pub(crate) mod bodies;
pub(crate) mod colliders;
pub(crate) mod crowds;
pub(crate) mod decals;
pub mod description;
pub mod diagnostic;
pub(crate) mod dielectric;
pub mod file;
pub(crate) mod layers;
pub mod manual;
pub(crate) mod names;
pub(crate) mod placement;
pub mod povray_form;
pub(crate) mod reader;
pub(crate) mod riders;
pub mod schema;
pub mod sequence;
pub(crate) mod stamps;
pub mod starter;
pub(crate) mod strokes;
pub(crate) mod tissues;
pub(crate) mod views;
