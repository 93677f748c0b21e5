//! Meshes, attributes, parameters, errors, executors, progress and statistics: what every other crate of Relievo
//! speaks in. No native code and no algorithms of a paper live here.

pub mod budget;
pub mod context;
pub mod error;
pub mod falloff;
pub mod file;
pub mod lanes;
pub mod marks;
pub mod memory;
pub mod mesh;
mod parallel;
pub mod parameter;
pub mod parts;
pub mod progress;
pub mod scratch;
pub mod simd;
pub mod stats;

pub use budget::Budget;
pub use context::{Context, ContextOptions};
pub use error::{Error, ErrorKind, Result};
pub use falloff::Falloff;
pub use marks::Marks;
pub use mesh::{Attribute, Crease, Domain, Mesh, Values};
pub use parallel::Scheduler;
pub use parameter::{Parameter, ParameterKind};
pub use parts::Parts;
pub use progress::Progress;
pub use scratch::{ArcPool, List};
