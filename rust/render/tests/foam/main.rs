//! Screen-space foam by the processor and by graphics devices.

mod device;
mod passes;
