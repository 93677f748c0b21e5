// import common
// Points of a collider on the lattice of 1/256 voxel.

const SUB: f32 = 256.0;
// Coordinates beyond which triangles cannot be placed exactly.
const FAR: f32 = 16777216.0;
const TOO_FAR: u32 = 1u;

struct Snap {
    // From object space to voxels: three numbers of the linear part, and where the origin is.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    // What is subtracted from points first.
    origin: vec3<f32>,
    count: u32,
}

@group(0) @binding(0) var<storage, read> points: array<f32>;
@group(0) @binding(1) var<storage, read_write> corners: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read_write> state: array<atomic<u32>>;
var<immediate> work: Snap;

@compute @workgroup_size(GROUP)
fn snap(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_group(group, groups) * GROUP + local;
    if index >= work.count {
        return;
    }
    let point = vec3(points[3u * index], points[3u * index + 1u], points[3u * index + 2u]);
    let q = vec4(point - work.origin, 1.0);
    let place = floor(vec3(dot(work.x, q), dot(work.y, q), dot(work.z, q)) * SUB + 0.5);
    // Not a number fails this as well.
    if !all(abs(place) <= vec3(FAR)) {
        atomicOr(&state[0], TOO_FAR);
    }
    corners[index] = vec4(vec3<i32>(clamp(place, vec3(-FAR), vec3(FAR))), 0);
}
