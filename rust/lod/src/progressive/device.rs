//! Progressive meshes on a graphics device: what there is of one, uploaded once, and meshes of it.
//!
//! The processor makes splits one after another in the order of their depths (Derzapf, Grund, Guthe 2014, Section 5). A
//! device need not: which splits make a mesh is known without making any, since a cut is closed, and what a view wants is
//! closed by going through the depths once. Then the vertex at a corner is the last one up to its leaf, which is a rank in
//! a set of bits. So there are no lists of corners, nothing to lock and no illegal operations to remove, and the mesh
//! before does not matter.

mod around;
mod calls;
mod directions;
mod edits;
mod extract;
mod hierarchy;
mod history;
mod level;
mod places;
mod records;
mod transfer;
mod wedges;
mod windows;

pub use self::hierarchy::{DeviceHierarchy, Vertex};
pub use self::history::DeviceFront;
pub use self::level::DeviceLevel;
