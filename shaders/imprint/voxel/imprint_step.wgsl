// The lattice of 1/256 voxel on which the corners of colliders are.

// Snapped units of a voxel, and the place of the first centre.
const SUB: i32 = 256;
const HALF: i32 = 128;

// The first row whose centre is not below; a centre on the lattice belongs to the upper one.
fn step_of(value: i32) -> i32 {
    return (value - HALF + SUB - 1) >> 8u;
}
