//! Surfaces: Catmull-Clark limit surfaces with tiles, patches, evaluation and bounds, Bézier patches ([`bezier`]), and
//! triangle meshes ([`triangle`]). Cages of any scheme with their attributes are in [`subdivision`].
//!
//! A surface is refined once per topology by OpenSubdiv into regular, single-crease and Gregory patches. Every regular
//! and single-crease patch is kept in Bézier form, so that its control points bound it and one kernel evaluates all.

pub mod bezier;
mod catmull_clark;
mod cone;
mod device;
mod evaluate;
mod face_varying;
mod grid;
mod patch;
mod place;
pub mod subdivision;
pub mod topology;
pub mod triangle;

pub use catmull_clark::{PatchView, Surface, SurfaceOptions};
pub use cone::Cone;
pub use device::{DeviceSurface, Evaluation, SURFACE_GROUP};
pub use evaluate::{Order, Sample, SampleSlices, Samples};
pub use grid::{Destination, Grid, Placement};
pub use patch::{Patch, PatchForm};
pub use place::Place;
pub use relievo_opensubdiv::{BoundaryRule, version as opensubdiv_version};
pub use topology::{Incidence, Link, RingClass, Segment, Side, TileTopology};
pub use triangle::{DeviceMesh, MESH_GROUP, TriangleSide, TriangleSurface, TriangleTopology};
