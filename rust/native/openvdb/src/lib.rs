//! Sparse grids of OpenVDB (Museth 2013): level sets, fog volumes, masks, labels and vectors.
//!
//! OpenVDB is not linked. The first call that needs it opens the module `librelievo_openvdb.so`, whose C interface is
//! `cpp/openvdb/module.h`, with its names hidden from everything else in the process ([`Module`]). Where the module is not
//! installed the call fails and names the package; nothing else depends on it.
//!
//! A file is checked before OpenVDB reads it ([`Survey`]): OpenVDB trusts the sizes that a file states. The check walks
//! through the nodes of its trees, needs no module, and yields what [`GridInfo`] has.

#[allow(missing_docs, dead_code, clippy::all, clippy::undocumented_unsafe_blocks)]
#[rustfmt::skip]
mod abi;
mod call;
mod cursor;
mod edit;
mod file;
mod grid;
mod info;
mod module;
#[doc(hidden)]
pub mod peer;
mod settings;
mod surface;
mod survey;
mod topology;
mod transform;
mod values;

pub use edit::{Filter, Operation, Order, labels};
pub use file::{Box3, Packing, Writing, read, write};
pub use grid::{Frustum, Grid};
pub use info::{Class, Entry, GridInfo, Kind};
pub use module::{ADVICE, Module, VARIABLE};
pub use settings::{Change, GridSettings};
pub use surface::Polygons;
pub use survey::Survey;
pub use transform::Transform;
pub use values::Block;
