// What all kernels share.

/// Items of a workgroup in one dimension.
const GROUP: u32 = 256u;

/// The number of a workgroup whose dispatch is spread over x and y.
fn linear_group(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.x + group.y * groups.x;
}
