//! Channels as Ptex files and back (Burley and Lacewell 2008): one face per tile, numbered alike.
//!
//! A texel of a file is a value at the centre of a texel. Colours are kept so, and go into a file as they are; a
//! displacement is kept as B-spline coefficients, so its values are evaluated on the way out and solved for on the way
//! in, see [`crate::prefilter`]. A tile without a block is a constant face. What the numbers are stands in the meta
//! data:
//!
//! | key | value |
//! |---|---|
//! | `RelievoKind` | `displacement`, `vector displacement` or `color` |
//! | `RelievoUnits` | `object units` or `none` |
//! | `RelievoColorSpace` | `sRGB`, `linear Rec.709` or `none` |
//! | `RelievoDefault` | the texel that tiles without a block read as |
//!
//! A vector displacement is along the tangent by u, across it and along the normal of its own face, and files of it ask
//! readers to filter across edges accordingly. The mesh is there too, by the keys that the format's own list has for
//! it.

mod adjacency;
mod export;
mod import;

pub use export::{PtexTexel, to_ptex, to_ptex_watched};
pub use import::{Imported, PtexImport, PtexKind, PtexReport, from_ptex, from_ptex_watched};

/// Meta data: what the texels are.
const KIND: &str = "RelievoKind";
/// Meta data: the units of the numbers.
const UNITS: &str = "RelievoUnits";
/// Meta data: how colours are encoded.
const COLOR_SPACE: &str = "RelievoColorSpace";
/// Meta data: the texel of tiles without a block, in the numbers of the file.
const DEFAULT: &str = "RelievoDefault";
/// Values of [`KIND`].
const DISPLACEMENT: &str = "displacement";
const VECTOR: &str = "vector displacement";
const COLOR: &str = "color";
