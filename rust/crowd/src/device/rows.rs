//! Rows of buffers, as the kernels of `shaders/crowd` have them.

use bytemuck::{Pod, Zeroable};

use crate::crowd::Reach;
use crate::hierarchy::NONE;

/// As in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Call {
    pub agents: u32,
    pub planes: u32,
    pub buckets: u32,
    pub capacity: u32,
    pub options: u32,
    pub which: u32,
}

/// Options of a call: vertices move, agents of a few pixels are impostors.
pub(super) const GEOMORPH: u32 = 1;
pub(super) const IMPOSTORS: u32 = 2;
/// The state of an agent that was seen in the last frame, and of one that others hid.
pub(super) const SEEN: u32 = 1;
pub(super) const HIDDEN: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ModelRow {
    pub first_step: u32,
    pub steps: u32,
    pub first_bucket: u32,
    pub first_cluster: u32,
    pub clusters: u32,
    pub first_group: u32,
    pub base_vertex: u32,
    pub first_start: u32,
    pub low: [f32; 3],
    pub radius: f32,
    pub high: [f32; 3],
    pub padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct AgentRow {
    center: [f32; 3],
    radius: f32,
    inverse: [[f32; 4]; 3],
    transform: [[f32; 4]; 3],
    own: u32,
    moved: f32,
    padding: [u32; 2],
}

/// An agent in view, on a device.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct DeviceInstance {
    /// The agent.
    pub agent: u32,
    /// The first of the matrices of its pose in those of all poses.
    pub first_matrix: u32,
    /// The first of the weights of its morph targets in [`DeviceCrowd::weights`](crate::DeviceCrowd::weights).
    pub first_weight: u32,
    /// The model.
    pub model: u32,
    /// From the model to the world, by rows.
    pub transform: [[f32; 4]; 3],
}

const _: () = assert!(size_of::<AgentRow>() == 128 && size_of::<DeviceInstance>() == 64 && size_of::<ModelRow>() == 64);

impl AgentRow {
    /// Makes the row of an agent of a model. `own` has where the limits of its groups begin, and how far its vertices may be
    /// outside their boxes, if it has weights of its own.
    pub fn new(reach: &Reach, model: u32, own: Option<(u32, f32)>) -> Self {
        let last = [reach.shrink, reach.evenness, f32::from_bits(model)];
        let inverse = std::array::from_fn(|axis| {
            let [x, y, z] = reach.inverse[axis];
            [x, y, z, last[axis]]
        });
        let (own, moved) = own.unwrap_or((NONE, 0.0));
        Self {
            center: reach.center.to_array(),
            radius: reach.radius,
            inverse,
            transform: reach.transform,
            own,
            moved,
            padding: [0; 2],
        }
    }
}
