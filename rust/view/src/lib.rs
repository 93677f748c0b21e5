//! Windows: one in which shaders are explored by examples (Mindek et al. 2013, Sections 4.2 and 4.3), one in which a mesh or a
//! document is looked at, painted and sculpted (Schäfer et al. 2015), and one in which something is played.
//!
//! What a window is about is a session that knows no window, in [`shader`] and in [`model`], or a subject of the program that
//! opens it, in [`show`]; panels show it and change it by clicks and keys. A [`Script`] sends the same events as a mouse and a keyboard, so that a demonstration or a test plays a
//! session without a person.

mod drawing;
pub mod model;
mod pen;
mod player;
mod preferences;
mod script;
pub mod shader;
pub mod show;
mod window;

pub use script::Script;
