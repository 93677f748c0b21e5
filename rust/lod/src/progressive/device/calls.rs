//! Calls of the kernels that several parts of a mesh on a device share.

use bytemuck::{Pod, Zeroable};
use relievo_gpu::{GROUP, groups};

/// As in `progressive_mark.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct CutCall {
    pub key: u32,
    pub split: u32,
    pub vertices: u32,
}

/// Workgroups for so many items.
pub fn blocks(count: usize) -> [u32; 3] {
    groups((count as u32).div_ceil(GROUP))
}
