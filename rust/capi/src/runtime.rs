//! Nouns of the library itself: contexts, jobs, errors, devices and what they share with a host.

pub mod adapter;
pub mod allocator;
pub mod buffer;
pub mod bytes;
pub mod capability;
pub mod context;
pub mod error;
pub mod job;
pub mod parameter;
pub mod stream;
pub mod version;
pub mod vulkan;
