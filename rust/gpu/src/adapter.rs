//! Descriptions of adapters, and how a device is opened on one of them.

use std::fmt;

/// What an adapter is made of, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AdapterKind {
    /// A graphics card.
    Discrete,
    /// A graphics unit that shares the processor's memory.
    Integrated,
    /// A graphics device of a virtual machine, or one that does not say what it is.
    Virtual,
    /// The processor itself, as Mesa's lavapipe.
    Software,
}

/// An adapter as `relievo info --devices` lists it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterSummary {
    /// The name its driver gives.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// The interface it is reached through: `vulkan`, `metal` or `dx12`.
    pub backend: &'static str,
    /// What it is made of.
    pub kind: AdapterKind,
    /// Whether it has all that kernels need.
    pub is_usable: bool,
    /// Bytes that one buffer may have.
    pub buffer_limit: u64,
    /// Bytes of a buffer that a kernel may be bound to.
    pub binding_limit: u64,
}

impl fmt::Display for AdapterSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} ({}, {})", self.name, self.backend, self.driver)
    }
}

/// Which adapter a device is opened on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The best there is, the processor's own last.
    #[default]
    Best,
    /// The best that is not the processor itself.
    Hardware,
    /// The first whose name contains this, in any case of letters.
    Named(String),
}

/// How a device is opened.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Which adapter.
    pub adapter: AdapterChoice,
    /// Whether passes are timed by the device's own clock.
    pub timing: bool,
    /// Bytes that buffers may occupy together; 0 for what the device has.
    pub memory_limit: u64,
}
