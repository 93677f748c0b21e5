//! Detail on surfaces. Imprints from colliding objects: Catmull-Clark surfaces with displacement tiles are pushed out
//! of whatever touches them, after Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from Object
//! Collisions. Painting and sculpting with brushes, after Schäfer et al. 2015, Local Painting and Deformation of Meshes
//! on the GPU.

mod channels;
pub mod device;
mod geometry;
mod imprint;
mod object;
mod paint;
pub mod triangle;

pub use channels::fading::{DecayingObject, LayerDecay};
pub use channels::history::{BlockState, Changed, History, LayerState, LayerStates, Recorded};
pub use channels::layer_channel::{BlockChannel, LayerChannel};
pub use channels::layered::{LayerInfo, LayeredObject, Layers};
pub use channels::layers::{Layer, Stack};
pub use channels::{fading, history, knots, layer_channel, layered, layers};
pub use geometry::dda::Exit;
pub use geometry::grid::Grid;
pub use geometry::hierarchy::{Bounds, Hierarchy, Region};
pub use geometry::lattice::Lattice;
pub use geometry::obb::Obb;
pub use geometry::voxel::{Side, Solid, Voxels};
pub use geometry::{dda, grid, hierarchy, obb, overlap, voxel, voxel_frame};
pub use imprint::collider::Collider;
pub use imprint::contact::Contact;
pub use imprint::motion::{Motion, Pose};
pub use imprint::pair::Deformable;
pub use imprint::rim::Volumes;
pub use imprint::row::{Press, Sweep};
pub use imprint::settings::{ImprintSettings, Moment, Report};
pub use imprint::{Imprintable, Imprinter};
pub use imprint::{collider, contact, cull, culled, dents, motion, pair, raycast, rim, row, tool};
pub use object::DisplacedObject;
pub use object::any::AnyObject;
pub use object::canvas::Canvas;
#[doc(hidden)]
pub use object::instances::instances;
pub use object::nearest::SurfacePoint;
pub use object::{canvas, nearest, refusal};
pub use paint::brush::Brush;
pub use paint::curve::Curve;
pub use paint::dab::{Action, Dab};
pub use paint::mode::{PaintMode, SculptMode};
pub use paint::open::OpenStroke;
pub use paint::path::{Station, StrokePoint};
pub use paint::report::DabReport;
pub use paint::stamp::{Stamp, StampChannel, StampImage, StampSettings};
pub use paint::stroke::{PressureCurves, Stroke, StrokeReport, StrokeSettings};
pub use paint::weights::{BrushParameters, Weights};
pub use paint::{brush, curve, dab, mode, path, report, stamp, stroke, weights};
pub use relievo_core::Falloff;
pub use triangle::TriangleObject;
