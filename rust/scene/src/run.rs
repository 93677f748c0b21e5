//! What a run does to the world frame after frame, and the cache that remembers it.

pub mod cache;
#[cfg_attr(not(feature = "fluid"), path = "run/foam_absent.rs")]
pub mod foam;
pub(crate) mod folds;
#[cfg_attr(not(feature = "decal"), path = "run/laying_absent.rs")]
pub(crate) mod laying;
pub mod refusals;
pub mod replay;
pub(crate) mod riders;
pub(crate) mod row;
pub mod simulate;
pub mod stepper;
pub(crate) mod strokes;
pub mod trace;
pub(crate) mod treading;
pub(crate) mod way;
