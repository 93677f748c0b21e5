// import common
// import wide
// Points of a collider on the lattice of 1/256 voxel. Devices have no f64: coordinates and the rows of the map are
// integers of up to 30 bits, and sums of 64 are exact, so that places are the processor's but for what 30 bits leave out.

// Coordinates beyond which triangles cannot be placed exactly.
const FAR: i32 = 16777216;
const TOO_FAR: u32 = 1u;
// Coordinates as integers at most.
const MOST: f32 = 536870912.0;

struct Snap {
    // The map's rows for coordinates as integers, times 2 to the power of `shift`.
    x: vec3<i32>,
    count: u32,
    y: vec3<i32>,
    shift: u32,
    z: vec3<i32>,
    // Coordinates times this are integers; a power of two.
    scale: f32,
    // Subtracted from coordinates as integers.
    origin: vec3<i32>,
    // Where the origin is, with half a unit for rounding: low words and high words.
    low: vec3<u32>,
    high: vec3<u32>,
}

@group(0) @binding(0) var<storage, read> points: array<f32>;
@group(0) @binding(1) var<storage, read_write> corners: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read_write> state: array<atomic<u32>>;
var<immediate> work: Snap;

// The place along an axis, and 1 where it is not too far.
fn place(row: vec3<i32>, low: u32, high: u32, q: vec3<i32>) -> vec2<i32> {
    let linear = wide_add(wide_add(wide_product(row.x, q.x), wide_product(row.y, q.y)), wide_product(row.z, q.z));
    let sum = wide_add(linear, vec2(low, high));
    // Divided, downwards.
    let upper = i32(sum.y);
    var whole = upper >> min(work.shift - 32u, 31u);
    var rest = upper >> 31u;
    if work.shift < 32u {
        whole = i32((sum.x >> work.shift) | (sum.y << (32u - work.shift)));
        rest = upper >> work.shift;
    }
    let near = rest == whole >> 31u && whole >= -FAR && whole <= FAR;
    return vec2(clamp(whole, -FAR, FAR), i32(near));
}

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
    let whole = round(point * work.scale);
    // Not a number fails this as well.
    let there = all(abs(whole) <= vec3(MOST));
    let q = select(vec3(0), vec3<i32>(whole) - work.origin, there);
    let x = place(work.x, work.low.x, work.high.x, q);
    let y = place(work.y, work.low.y, work.high.y, q);
    let z = place(work.z, work.low.z, work.high.z, q);
    if !there || x.y * y.y * z.y == 0 {
        atomicOr(&state[0], TOO_FAR);
    }
    corners[index] = vec4(x.x, y.x, z.x, 0);
}
