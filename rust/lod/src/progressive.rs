//! Progressive meshes (Derzapf, Grund, Guthe 2014): a triangle mesh as a coarse base and the vertex splits that make it
//! fine again, in any order that keeps neighbours in theirs.
//!
//! - Which splits there are, numbered so that what a split changes can be told by comparing numbers: [`hierarchy`].
//! - What they are found from: the collapses of a simplification, in `recording`.
//! - Which of them make a mesh with a given deviation or number of triangles: [`cut`].
//! - Files of them: [`file`](mod@file), read by `reading`, and as they arrive: [`arrival`].
//! - The mesh they make, refined and coarsened in place: [`active`], with `splits`, or far at once: `jump`; also as
//!   fine as a view needs it: [`view`]. Which vertices it has, to be found at the cost of them: `bitset`.
//! - How it is kept in its user's buffers, of which only what changes is written: [`buffers`].
//! - How regions of it are moved and turned: [`handle`], with `blocks`; how finer levels follow: `moves`, with `place`; how
//!   coarser ones do: `coarser`, with `stars`; how that is taken back: `history`; and how it becomes a mesh of its own:
//!   `settle`.
//! - What handles do over time: [`keyed`], at coarser levels than the mesh is of: `beneath`.
//! - Which level is within a measured distance of the finest: `within`.
//! - Where its order no longer fits what it has become: [`order`].
//! - What it has beside places and normals: `wedges`, and `active_wedges` of the mesh now, built of meshes as files have them in `attributed`; how
//!   normals and tangents among that turn with edits: `directions`, `turning`.
//! - How brushes sculpt it: [`sculpt`].
//! - How edits survive a killed program: [`journal`], with `inputs`.
//! - The mesh on a graphics device, refined, coarsened and drawn there: [`device`].

mod build;
pub mod device;
mod edit;
mod files;
mod mesh;

pub use build::cut::{Cut, Front, ViewSplits};
pub use build::hierarchy::{BuildOptions, Child, Progressive};
pub use build::order::Misplaced;
pub use build::recording::Key;
pub(crate) use build::recording::{Made, Recording};
pub use build::{cut, hierarchy, order};
pub use device::{DeviceFront, DeviceHierarchy, DeviceLevel};
pub use edit::handle::{Edit, Handle, Region};
pub use edit::keyed::{HandleKey, KeyedEdit, KeyedHandle};
pub use edit::sculpt::Sculpted;
pub use edit::{handle, keyed, sculpt};
pub use files::arrival::Arrival;
pub use files::journal::{EditJournal, Input, Recovered};
pub use files::{arrival, file, journal};
pub use mesh::active::{ActiveMesh, Extract};
pub use mesh::buffers::{Buffers, Update};
pub use mesh::view::{Extents, View};
pub use mesh::{active, buffers, view};
