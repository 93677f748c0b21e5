//! Detail on surfaces. Imprints from colliding objects: Catmull-Clark surfaces with displacement tiles are pushed out of
//! whatever touches them, after Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from Object
//! Collisions. Painting and sculpting with brushes, after Schäfer et al. 2015, Local Painting and Deformation of Meshes
//! on the GPU.

pub mod brush;
pub mod canvas;
pub mod collider;
pub mod contact;
pub mod cull;
pub mod curve;
pub mod dab;
pub mod dda;
mod edit;
pub mod fading;
pub mod falloff;
mod fit;
pub mod grid;
pub mod hierarchy;
pub mod history;
pub mod imprint;
pub mod knots;
pub mod layered;
pub mod layers;
mod level;
pub mod mode;
pub mod motion;
pub mod nearest;
pub mod obb;
pub mod object;
mod open;
pub mod overlap;
pub mod pair;
pub mod path;
pub mod raycast;
mod rays;
pub mod rim;
mod scanline;
#[cfg(test)]
mod shapes;
mod smoothing;
mod spot;
pub mod stamp;
pub mod stroke;
pub mod tool;
mod traces;
pub mod triangle;
pub mod voxel;
pub mod weights;

pub use brush::Brush;
pub use canvas::Canvas;
pub use collider::Collider;
pub use contact::Contact;
pub use curve::Curve;
pub use dab::{Action, Dab, DabReport};
pub use dda::Exit;
pub use fading::Fading;
pub use falloff::Falloff;
pub use grid::Grid;
pub use hierarchy::{Bounds, Hierarchy, Region};
pub use history::{BlockState, Changed, History, LayerState, LayerStates, Recorded};
pub use imprint::{ImprintSettings, Imprinter, Moment, Report};
pub use layered::{LayerInfo, Layers};
pub use layers::{Layer, Stack};
pub use mode::{PaintMode, SculptMode};
pub use motion::{Motion, Pose};
pub use nearest::SurfacePoint;
pub use obb::Obb;
pub use object::DisplacedObject;
pub use open::OpenStroke;
pub use pair::Deformable;
pub use path::{Station, StrokePoint};
pub use rim::Volumes;
pub use stamp::{Stamp, StampChannel, StampImage, StampSettings};
pub use stroke::{PressureCurves, Stroke, StrokeReport, StrokeSettings};
pub use triangle::TriangleObject;
pub use voxel::{Side, Solid, Voxels};
pub use weights::{BrushParameters, Weights};
