// import common
// The least and the largest coordinates of points along three axes, by which boxes are put around animated meshes (Schäfer
// et al. 2014, Section 5, Overlap Regions). Extrema of words do not depend on the order they are met in.

struct Axes {
    // The axes as rows; the fourth numbers are unused.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    // What is subtracted from points first.
    origin: vec3<f32>,
    count: u32,
}

@group(0) @binding(0) var<storage, read> points: array<f32>;
// The largest keys of the coordinates and of their negatives, zero at first.
@group(0) @binding(1) var<storage, read_write> extrema: array<atomic<u32>, 6>;
var<immediate> work: Axes;

var<workgroup> most: array<atomic<u32>, 6>;

// Floats as words of the same order, none of which is zero.
fn key(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

@compute @workgroup_size(GROUP)
fn bound(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    if local < 6u {
        atomicStore(&most[local], 0u);
    }
    workgroupBarrier();
    let index = linear_group(group, groups) * GROUP + local;
    if index < work.count {
        let q = vec3(points[3u * index], points[3u * index + 1u], points[3u * index + 2u]) - work.origin;
        let place = vec3(dot(work.x.xyz, q), dot(work.y.xyz, q), dot(work.z.xyz, q));
        for (var axis = 0u; axis < 3u; axis++) {
            atomicMax(&most[axis], key(place[axis]));
            atomicMax(&most[axis + 3u], key(-place[axis]));
        }
    }
    workgroupBarrier();
    if local < 6u {
        atomicMax(&extrema[local], atomicLoad(&most[local]));
    }
}
