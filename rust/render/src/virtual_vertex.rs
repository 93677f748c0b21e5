//! Surfaces drawn from virtual vertices: a vertex stage evaluates points and normals at places that have no data of
//! their own, after Concheiro, Amor, Padrón, Gil, Martorell 2013 (*Rendering of Bézier Surfaces on Handheld Devices*).
//!
//! [`VirtualVertices`] are Bézier patches with their maps and draws on a device, [`VirtualTiles`] what is drawn of a
//! displaced Catmull-Clark surface, which [`DrawnSurface`] keeps with the rest that a device has of it,
//! [`VirtualTriangles`] displaced triangle meshes; [`Rasterizer`] draws them, and meshes beside them.

mod coat;
mod heap;
mod indices;
mod patches;
mod placed;
mod rates;
mod stage;
mod surface;
mod thinning;
mod tiles;
mod triangle_values;
mod triangles;
mod tuner;

#[cfg(not(feature = "wgpu"))]
mod absent;
#[cfg(feature = "wgpu")]
mod depth_map;
#[cfg(feature = "wgpu")]
mod pipelines;
#[cfg(feature = "wgpu")]
mod rasterizer;
#[cfg(feature = "wgpu")]
mod records;
#[cfg(feature = "wgpu")]
mod targets;
#[cfg(feature = "wgpu")]
mod view;

#[cfg(not(feature = "wgpu"))]
pub use absent::{DepthMap, Rasterizer};
pub use coat::{Coat, DeviceCoat, Tint, TriangleCoat, TriangleColors};
#[cfg(feature = "wgpu")]
pub use depth_map::DepthMap;
pub use patches::{DrawCall, Storage, UNIFORM_PATCHES, VirtualVertices};
pub use placed::{
    DeviceMesh, INSTANCE_TAG, IndirectMesh, MeshVertex, NO_TAG, PassedVertex, PassedVertices, PicturedQuads, Placed,
    PosedMesh, PosedVertex, QuadPicture, Shape,
};
#[cfg(feature = "wgpu")]
pub use rasterizer::Rasterizer;
pub use rates::{MAX_POWER, TileRates};
pub use stage::Stage;
pub use surface::DrawnSurface;
pub use tiles::{TileDraw, TilePart, VirtualTiles};
pub use triangles::{TriangleDraw, TrianglePart, TriangleRates, VirtualTriangles};
pub use tuner::{Measured, Tuned, Tuning};
