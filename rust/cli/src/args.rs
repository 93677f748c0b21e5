//! Options that several commands have.

pub mod device;
pub mod limits;
pub mod numbers;
pub mod viewpoint;
