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

pub mod active;
mod active_wedges;
pub mod arrival;
mod attributed;
mod beneath;
mod bitset;
mod blocks;
mod buffer_places;
pub mod buffers;
mod coarser;
pub mod cut;
pub mod device;
mod directions;
pub mod file;
mod format;
pub mod handle;
pub mod hierarchy;
mod history;
mod inputs;
pub mod journal;
mod jump;
pub mod keyed;
mod moves;
mod numbers;
pub mod order;
mod packing;
mod place;
mod reading;
mod recording;
pub mod sculpt;
mod settle;
mod sparse;
mod splits;
mod stars;
mod turning;
pub mod view;
mod wedge_columns;
mod wedges;
mod within;

pub use active::{ActiveMesh, Extract};
pub use arrival::Arrival;
pub use buffers::{Buffers, Update};
pub use cut::{Cut, Front, ViewSplits};
pub use device::{DeviceFront, DeviceHierarchy, DeviceLevel};
pub use handle::{Edit, Handle, Region};
pub use hierarchy::{BuildOptions, Child, Progressive};
pub use journal::{EditJournal, Input, Recovered};
pub use keyed::{HandleKey, KeyedEdit, KeyedHandle};
pub use order::Misplaced;
pub use recording::Key;
pub(crate) use recording::{Made, Recording};
pub use sculpt::Sculpted;
pub use view::{Extents, View};
