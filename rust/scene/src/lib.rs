//! Scene files, physics, frame stepping and caches.
//!
//! A file is read (`format`), becomes a world of meshes and surfaces (`state`), which goes from frame to frame (`run`) and
//! is written as meshes and pictures (`out`).

mod format;
mod out;
mod run;
mod state;

pub use format::{description, diagnostic, file, manual, schema, sequence, starter};
#[cfg(feature = "fluid")]
pub use out::df3;
#[cfg(feature = "decal")]
pub use out::overlap;
pub use out::{export, output, picture, povray, showing, stages, tessellation};
pub use run::{cache, foam, refusals, replay, simulate, stepper, trace};
pub use state::{assets, isosurface, keyframe, paths, physics, shapes, tissue, triangles, walking, world};
