//! Calls of the kernels that several parts of a mesh on a device share.

use relievo_gpu::{GROUP, groups};

/// Workgroups for so many items.
pub fn blocks(count: usize) -> [u32; 3] {
    groups((count as u32).div_ceil(GROUP))
}
