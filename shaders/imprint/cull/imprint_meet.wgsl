// import imprint_box
// Whether bounds in voxel coordinates reach what may be solid.

// Voxels by which bounds are widened against rounding.
const SLACK: f32 = 0.05;

struct Bounds {
    low: vec3<f32>,
    high: vec3<f32>,
}

// Where voxels of the imprint that is worked on may be solid, and along columns the next ones, in which rays may start.
var<private> part: Solid;

// Works on an imprint from now on.
fn take(link: u32) {
    work = links[link];
    part = solid_part(link);
    if all(part.low < part.high) {
        part.low.z = max(part.low.z - 1, 0);
        part.high.z = min(part.high.z + 1, i32(work.dims.z));
    }
}

fn meets(bounds: Bounds) -> bool {
    let there = all(part.low < part.high);
    return there && all(bounds.low <= vec3<f32>(part.high) + SLACK) && all(bounds.high >= vec3<f32>(part.low) - SLACK);
}
