//! Reader and writer of Ptex files, which hold a texture for every face of a mesh (Burley and Lacewell 2008, Ptex:
//! Per-Face Texture Mapping for Production Rendering), by the published description of file format 1.3 and 1.4.
//!
//! Faces are quads or triangles; a polygon of another number of corners is one quad per corner. A face has 2^u by 2^v
//! texels, the row v = 0 first. Files are hostile until read.

mod block;
mod face;
mod fields;
mod format;
mod header;
mod meta;
mod neighborhood;
mod reader;
mod reduction;
mod summary;
mod writer;

pub use face::{Face, Neighbor};
pub use format::{BorderMode, Borders, DataType, EdgeFilter, Format, MeshType, Resolution};
pub use meta::{MetaData, MetaValue};
pub use reader::Reader;
pub use summary::Summary;
pub use writer::Writer;
