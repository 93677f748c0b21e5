//! Levels of detail, by closed forms, invariants and models.

mod progressive;
mod shapes;
mod simplify;
