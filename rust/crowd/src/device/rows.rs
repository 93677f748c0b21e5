//! Rows of buffers, as the kernels of `shaders/crowd` have them.

use relievo_gpu::wgsl::crowd_agents::Agent;

use crate::crowd::Reach;
use crate::hierarchy::NONE;

/// Options of a call: vertices move, agents of a few pixels are impostors.
pub(super) const GEOMORPH: u32 = 1;
pub(super) const IMPOSTORS: u32 = 2;
/// The state of an agent that was seen in the last frame, and of one that others hid.
pub(super) const SEEN: u32 = 1;
pub(super) const HIDDEN: u32 = 2;

/// Makes the row of an agent of a model. `own` has where the limits of its groups begin, and how far its vertices may be
/// outside their boxes, if it has weights of its own.
pub(super) fn agent_row(reach: &Reach, model: u32, own: Option<(u32, f32)>) -> Agent {
    let last = [reach.shrink, reach.evenness, f32::from_bits(model)];
    let inverse = std::array::from_fn(|axis| {
        let [x, y, z] = reach.inverse[axis];
        [x, y, z, last[axis]]
    });
    let (own, moved) = own.unwrap_or((NONE, 0.0));
    Agent {
        center: reach.center.to_array(),
        radius: reach.radius,
        inverse,
        transform: reach.transform,
        own,
        moved,
        padding: [0; 2],
    }
}
