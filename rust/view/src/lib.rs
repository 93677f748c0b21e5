//! A window in which shaders are explored by examples (Mindek et al. 2013, Sections 4.2 and 4.3).
//!
//! A [`Session`] is what is explored: a shader, its inputs, its classified pixels and what follows from them. It knows no
//! window. [`Panels`] shows a session and changes it by clicks and keys; [`run`] opens the window. A [`Script`] sends the same
//! events as a mouse and a keyboard, so that a demonstration or a test plays a session without a person.

mod panels;
mod plots;
mod profiles;
mod script;
mod session;
mod window;

pub use panels::Panels;
pub use script::Script;
pub use session::{Opening, Session};
pub use window::run;
