//! Edits on a graphics device: the same passes as on the processor, in kernels.

mod brush;

pub use brush::DeviceBrush;
