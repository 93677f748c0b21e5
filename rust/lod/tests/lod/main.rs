//! Levels of detail, by closed forms, invariants and models.

mod buffers;
mod device;
mod editing;
mod progressive;
mod shapes;
mod simplify;
mod views;
