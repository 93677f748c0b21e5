//! Painting and sculpting: brushes, strokes and what a dab does.

mod bend;
pub mod brush;
pub mod curve;
pub mod dab;
pub(crate) mod edit;
pub(crate) mod ground;
mod level;
pub mod mode;
pub(crate) mod open;
pub mod path;
pub mod report;
pub(crate) mod smudge;
pub(crate) mod spot;
pub mod stamp;
pub mod stroke;
pub(crate) mod vector;
pub mod weights;
