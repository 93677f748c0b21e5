//! Checks and repairs polygon meshes as users import them: soups, torn scans, models with doubled, twisted or missing
//! faces.
//!
//! [`check`] reports what is wrong with a mesh, [`repair`] also mends it and returns an oriented manifold. The steps run
//! in this order, each can be switched off in [`RepairSettings`], and each adds to the [`Report`]:
//!
//! 1. Faces that use missing points or coordinates that are not finite are dropped.
//! 2. Points at the same place, or within a tolerance, are welded. Values that differ there stay with the corners of
//!    the faces, so that seams of texture coordinates and normals survive.
//! 3. Faces with fewer than three different corners, and faces that occur twice, are dropped.
//! 4. Faces are turned over until neighbours agree. Where that is impossible, as on a Möbius strip, the mesh is cut.
//! 5. Edges of more than two faces and vertices of more than one fan are split. Faces around an edge that enclose
//!    material stay together.
//! 6. Closed components face outwards.
//! 7. Holes are filled by the triangulation of least dihedral angle and area (Barequet and Sharir 1995, Liepa 2003,
//!    Section 3), refined to the density of the surroundings (Liepa 2003, Section 4) on OpenMesh's half-edges, and
//!    faired (Liepa 2003, Section 5).
//!
//! Polygons stay polygons. Results do not depend on the number of threads.

mod attributes;
mod corners;
mod edges;
mod equal;
mod fair;
mod fans;
mod holes;
mod loops;
mod nesting;
mod orient;
mod pairs;
mod refine;
mod repair;
mod report;
mod sets;
mod settings;
mod sift;
mod topology;
mod triangulate;
mod weld;

pub use repair::{Repaired, check, repair};
pub use report::{Element, Finding, Report};
pub use settings::RepairSettings;
pub use topology::Topology;
