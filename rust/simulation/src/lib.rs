//! Fluids as text describes them, simulated frame by frame.
//!
//! A [`Description`] is a text in TOML: the fluid, what it begins as, and the walls, colliders, bodies, emitters, sinks and
//! forces that it meets. A [`Simulation`] goes through its frames, and goes on from any frame that was stored, to the same
//! bits as if it had never stopped. A [`Foam`] simulates a fluid together with its foam, and [`simulate_on_rank`] a fluid together
//! with other processes. `docs/fluids.md` lists the keys of a description.

mod bodies;
mod description;
mod entries;
mod files;
mod fill;
mod foam;
mod mover;
mod play;
mod rank_folder;
mod rank_report;
mod ranks;
mod shape;
mod simulation;

pub use description::Description;
pub use files::{Files, Source, in_folder};
pub use foam::{Foam, FoamDescription};
pub use play::Play;
pub use ranks::simulate_on_rank;
pub use simulation::{Making, Simulation};
