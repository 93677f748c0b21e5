//! Levels of detail, by closed forms, invariants and models.

mod arrival;
mod attributes;
mod bounds;
mod buffers;
mod device;
mod device_directions;
mod device_history;
mod directions;
mod editing;
mod journals;
mod keyed;
mod order;
mod posed_distance;
mod progress;
mod progressive;
mod sculpting;
mod shapes;
mod simplify;
mod views;
mod wedges;
