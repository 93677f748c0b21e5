//! Bézier curves and surfaces: basis functions and conversions , surfaces of bicubic patches with optional
//! weights ([`BezierSurface`]), and their tessellation from parametric maps ([`ParametricMap`]) after Concheiro, Amor,
//! Padrón, Gil, Martorell 2013 (*Rendering of Bézier Surfaces on Handheld Devices*).

mod curve;
mod edge;
mod evaluate;
mod levels;
mod map;
mod mesh;
mod patches;
mod stitch;
mod tessellate;

pub use curve::{Conversion, SMOOTH, crease_pieces, cubic, cubic_first, cubic_second, restrict};
pub use edge::{EdgeSense, EdgeTable};
pub use levels::{Levels, Viewpoint};
pub use map::{MAX_LEVEL, ParametricMap, STITCH, VirtualVertex, draw_calls};
pub use patches::{BezierSurface, CONTROLS, MAX_COORDINATE, MAX_SURFACES, WEIGHTS};
pub use stitch::{Stitch, stitches};
pub use tessellate::BezierTessellation;
