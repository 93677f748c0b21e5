//! Painting, sculpting and imprints on triangle meshes.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.

mod bend;
mod dab;
mod device;
mod device_imprint;
mod fading;
pub(crate) mod imprint;
mod layers;
mod level;
mod nearest;
mod object;
mod rim;
mod site;
mod smoothing;
mod traces;

pub use object::TriangleObject;
pub(crate) use object::{TriangleGround, field_length, field_range};
