//! Graphics devices through wgpu: explicit choice of an adapter, typed buffers, kernels written in WGSL, frames that are
//! submitted once and timed per pass, and the parallel primitives that the systems share: prefix sums ([`Scan`]),
//! multi-compaction ([`Compaction`]) and a radix sort ([`Sort`]).
//!
//! Nothing here knows a surface. What goes wrong on a device (no memory, a lost device, a faulty command) comes back as
//! an error of the call that meets it; wgpu's own panics stay inside.

mod adapter;
mod buffer;
mod compaction;
mod device;
mod frame;
mod kernel;
pub mod module;
mod readback;
mod scan;
mod sort;
mod timing;

pub use adapter::{AdapterChoice, AdapterKind, AdapterSummary, adapters};
pub use buffer::Buffer;
pub use compaction::{Compaction, MAX_CLASSES};
pub use device::{Charge, Device, DeviceOptions};
pub use frame::{Frame, Pass, Submission};
pub use kernel::{Access, Bindings, Kernel, KernelSpec};
pub use readback::Readback;
pub use scan::Scan;
pub use sort::Sort;
pub use timing::PassTime;
pub use wgpu;

/// Invocations of a workgroup of the shared kernels.
pub const GROUP: u32 = 256;

/// Workgroups in x and y for `count` groups, whose number in a kernel is `linear_group` of `common.wgsl`. One dimension
/// holds 65,535 on every device; the few groups too many are the kernel's to skip.
pub fn groups(count: u32) -> [u32; 3] {
    const ROW: u32 = 32_768;
    if count <= ROW { [count, 1, 1] } else { [ROW, count.div_ceil(ROW), 1] }
}
