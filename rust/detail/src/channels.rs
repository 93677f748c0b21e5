//! What an object has on its surface: layers of displacement and colour, edits that fade, and the history of all.

pub mod fading;
pub(crate) mod frame;
pub mod history;
pub mod knots;
pub mod layer_channel;
pub mod layered;
pub mod layers;
pub(crate) mod window;
