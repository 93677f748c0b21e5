//! Layers over a channel: what they make together, edits that fade, and traces of contact.

pub mod composite;
pub mod decay;
pub(crate) mod fade;
pub mod trace;
