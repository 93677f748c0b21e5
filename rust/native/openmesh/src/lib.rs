//! Surgery on triangle patches by OpenMesh 9.0: splits, flips, collapses, removal of faces, boundary loops.
//!
//! Use it for small parts of a mesh: the surroundings of a hole or of a decal. A [`Patch`] holds an oriented manifold
//! with or without boundary; anything else is refused with the numbers of the faces at fault. Every method works on a
//! batch, because a call for a single half-edge costs more than the step itself.
//!
//! OpenMesh's namespace has no version, so a host with another OpenMesh loaded for all names would answer for ours. Hence
//! the headers are compiled into a namespace of our own, and the fourteen functions that are not inline are looked up in
//! Debian's library, which is opened at run time with its names kept apart. The first patch opens it; without it,
//! [`Patch::new`] fails and says what to install.

mod bridge;
mod library;
mod manifold;
mod patch;

pub use patch::{Compact, NONE, Patch, PatchEdge};
