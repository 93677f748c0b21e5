//! Decals: stickers cut out of an image that lie on a surface exactly at given points, without folds, with little stretch.
//!
//! [`lay`] takes a triangle mesh, a [`Sticker`] and [`Pin`]s, and returns a [`Decal`]: triangles with their places in the
//! image, and their [`Quality`]. The method is that of multiple-constrained decaling (Journal of WSCG 21, 2013):
//!
//! 1. Pins become vertices of the surface. Their Delaunay triangulation within the outline is the feature graph
//!    (Section 4.1).
//! 2. Geodesics for the edges of the graph enclose the seed; mean-value coordinates map it into the image (Sections 4.2
//!    and 4.3).
//! 3. The patch grows until it covers the sticker, and faces outside are removed. It stays a topological disk (Section 5).
//! 4. Projected Newton steps lower the symmetric Dirichlet energy. Pins are no unknowns, and no step flips a triangle.
//!
//! A [`Placement`] keeps what a decal was made of and follows: pins that are dragged and surfaces that are posed.
//!
//! A [`Print`] writes a decal into the colours, the displacement and the vector displacement of a surface, through the
//! texels that [`draw`] finds (Section 6), a [`TrianglePrint`] into those of a triangle mesh. A [`Ground`] does it in a layer for
//! each decal, and keeps its [`Recipe`] in the document, from which the decal is taken up again.
//!
//! [`paint_texture`] paints it into the texture of a mesh with texture coordinates, for which [`charts`] says where its faces
//! lie.
//!
//! [`Sticker::of_alpha`] cuts a sticker out of an image along its alpha; [`strip`] places one along a curve, and
//! [`shortest_path`] joins two places as the paths between pins do.
//!
//! [`exponential`] lays a sticker around one point in a fraction of the time, [`scatter`] many of them, and [`project`]
//! projects one; all give the same kind of decal without the promises of exact pins and of no flips.
//!
//! Step 4 replaces the paper's conformal map and its warp of the image region, so that the pins stay exact and the region
//! keeps its shape. Lengths are units of the mesh; places in the image are pixels from its lower left corner. Results do
//! not depend on the number of threads.

mod artwork;
mod decal;
mod edges;
mod exponential;
mod map;
mod nearest;
mod paths;
mod pins;
mod placement;
mod print;
mod projected;
mod scatter;
mod surface;

pub use artwork::Artwork;
pub use artwork::contour::Contour;
pub use artwork::outline::Outline;
pub use decal::{Decal, DecalSettings, Growing, Pose, Sticker, lay, lay_watched};
pub use exponential::exponential;
pub use map::quality::{Quality, stretch};
pub use nearest::nearest;
pub use paths::geodesic::shortest_path;
pub use paths::strip::{Strip, strip};
pub use pins::{Pin, Place};
pub use placement::Placement;
pub use print::applied::{Applied, Ground, next_recipe, recipes};
pub use print::printable::Printable;
pub use print::recipe::{Ink, Recipe, hash};
pub use print::texels::{Chart, Window, draw};
pub use print::texture::{Pixels, charts, paint_texture, triangulated};
pub use print::triangle_print::TrianglePrint;
pub use print::{Print, Printed, emboss, paint};
pub use projected::{Projection, project};
pub use scatter::{Scatter, scatter};
