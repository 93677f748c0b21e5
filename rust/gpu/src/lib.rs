//! Graphics devices through wgpu: explicit choice of an adapter, typed buffers, kernels written in WGSL, frames that are
//! submitted once and timed per pass, and the parallel primitives that the systems share: prefix sums ([`Scan`]),
//! multi-compaction ([`Compaction`]) and a radix sort ([`Sort`]).
//!
//! Without the feature `wgpu` the same types have no values: [`Device::open`] fails and says so, and whoever holds a
//! device compiles to nothing. Callers are the same in both builds.
//!
//! Nothing here knows a surface. What goes wrong on a device (no memory, a lost device, a faulty command) comes back as
//! an error of the call that meets it; wgpu's own panics stay inside.

mod adapter;
mod compaction;
mod environment;
mod host_device;
mod kernel_spec;
pub mod module;
mod pass_time;
mod scan;
mod sort;
pub mod wgsl;

#[cfg(not(feature = "wgpu"))]
mod absent;
#[cfg(feature = "wgpu")]
mod buffer;
#[cfg(feature = "wgpu")]
mod choice;
#[cfg(feature = "wgpu")]
mod device;
#[cfg(feature = "wgpu")]
mod frame;
#[cfg(all(feature = "wgpu", not(target_vendor = "apple")))]
mod host;
#[cfg(not(all(feature = "wgpu", not(target_vendor = "apple"))))]
mod host_absent;
#[cfg(all(feature = "wgpu", not(target_vendor = "apple")))]
mod host_queue;
#[cfg(feature = "wgpu")]
mod kernel;
#[cfg(feature = "wgpu")]
mod readback;
#[cfg(feature = "wgpu")]
mod timing;

#[cfg(not(feature = "wgpu"))]
pub use absent::{Bindings, Buffer, Charge, Device, Frame, Kernel, Pass, Readback, Submission, adapters, wgpu};
pub use adapter::{AdapterChoice, AdapterKind, AdapterSummary, DeviceOptions};
#[cfg(feature = "wgpu")]
pub use buffer::Buffer;
#[cfg(feature = "wgpu")]
pub use choice::adapters;
pub use compaction::{Compaction, MAX_CLASSES};
#[cfg(feature = "wgpu")]
pub use device::{Charge, Device};
pub use environment::quiet_drivers;
#[cfg(feature = "wgpu")]
pub use frame::{Frame, Pass, Submission};
pub use host_device::{HostDevice, HostFunction};
#[cfg(feature = "wgpu")]
pub use kernel::{Bindings, Kernel};
pub use kernel_spec::{Access, KernelSpec};
pub use pass_time::PassTime;
#[cfg(feature = "wgpu")]
pub use readback::Readback;
pub use scan::Scan;
pub use sort::Sort;
#[cfg(feature = "wgpu")]
pub use wgpu;

/// Invocations of a workgroup of the shared kernels.
pub const GROUP: u32 = 256;

/// Workgroups in x and y for `count` groups, whose number in a kernel is `linear_group` of `common.wgsl`. One dimension
/// holds 65,535 on every device; the few groups too many are the kernel's to skip.
pub fn groups(count: u32) -> [u32; 3] {
    const ROW: u32 = 32_768;
    if count <= ROW { [count, 1, 1] } else { [ROW, count.div_ceil(ROW), 1] }
}
