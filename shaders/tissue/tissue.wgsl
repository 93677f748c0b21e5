// import common
// Soft tissue on a device: what a step of explicit dynamics is given (`rust/tissue/src/simulation/device.rs`).

struct Step {
    /// m/s²
    gravity: vec3<f32>,
    /// s
    step: f32,
    /// Shares by which damping changes velocities and accelerations.
    kept: f32,
    gained: f32,
    /// Slots of all blocks, and how many of them hold elements.
    slots: u32,
    elements: u32,
    nodes: u32,
    /// Muscles, sets of driven nodes, and bodies.
    muscles: u32,
    drives: u32,
    bodies: u32,
    /// Where the numbers of the step begin: an activation for each muscle, a displacement for each set, and for each body its
    /// pose and that a step earlier.
    row: u32,
    /// Whether there are loads.
    loads: u32,
    /// Whether all elements are equal boxes, and one over four times their size along each axis.
    boxes: u32,
    scale_x: f32,
    scale_y: f32,
    scale_z: f32,
}

var<immediate> call: Step;

/// Elements of a group, whose numbers lie side by side, and of a block.
const LANES: u32 = 16u;
const BLOCK: u32 = 512u;

/// Where number `which` of `width` of a slot is: groups of `width` lists of `LANES`.
fn place(slot: u32, width: u32, which: u32) -> u32 {
    return (slot / LANES * width + which) * LANES + slot % LANES;
}
