//! Taking channels along: as Ptex and back, as pictures of tiles, as maps on the mesh's own texture coordinates, as
//! meshes.
//!
//! - Files with a texture for every face: [`ptex`], with [`prefilter`] for what a displacement's numbers mean there.

pub mod prefilter;
pub mod ptex;
mod resample;
mod solve;
