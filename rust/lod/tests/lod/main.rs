//! Levels of detail, by closed forms, invariants and models.

mod simplify;
