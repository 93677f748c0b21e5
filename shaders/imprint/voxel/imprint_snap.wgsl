// import common
// import imprint_link
// import wide
// Points of colliders on the lattice of 1/256 voxel. Devices have no f64: coordinates and the rows of the map are
// integers of up to 30 bits, and sums of 64 are exact, so that places are the processor's but for what 30 bits leave out.
// Workgroups of a row take an imprint. The box of the points, along the axes of the overlap, is reduced as well: voxels
// beyond it are not solid (Schäfer et al. 2014, Section 5, Overlap Regions).

// Coordinates beyond which triangles cannot be placed exactly.
const FAR: i32 = 16777216;
// Coordinates as integers at most.
const MAX: f32 = 536870912.0;

@group(0) @binding(1) var<storage, read> points: array<f32>;
@group(0) @binding(2) var<storage, read_write> corners: array<vec4<i32>>;
@group(0) @binding(3) var<storage, read_write> counters: AllCounters;
// See `imprint_box`.
@group(0) @binding(4) var<storage, read_write> boxes: array<atomic<u32>>;

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

var<workgroup> most: array<atomic<u32>, 6>;

@compute @workgroup_size(GROUP)
fn snap(id: Invocation) {
    let link = step.link + id.group.y;
    work = links[link];
    let index = id.group.x * GROUP + id.local;
    if id.local < 6u {
        atomicStore(&most[id.local], 0u);
    }
    workgroupBarrier();
    if index < work.points {
        snap_point(link, index);
    }
    workgroupBarrier();
    // Extrema of whole numbers do not depend on the order that they are met in.
    if id.local < 6u {
        atomicMax(&boxes[6u * link + id.local], atomicLoad(&most[id.local]));
    }
}

fn snap_point(link: u32, index: u32) {
    let first = 3u * (work.first_point + index);
    let point = vec3(points[first], points[first + 1u], points[first + 2u]);
    let whole = round(point * work.scale);
    // Not a number fails this as well.
    let there = all(abs(whole) <= vec3(MAX));
    let q = select(vec3(0), vec3<i32>(whole) - work.lattice_origin, there);
    let x = place(work.lattice_x, work.lattice_low.x, work.lattice_high.x, q);
    let y = place(work.lattice_y, work.lattice_low.y, work.lattice_high.y, q);
    let z = place(work.lattice_z, work.lattice_low.z, work.lattice_high.z, q);
    if !there || x.y * y.y * z.y == 0 {
        atomicOr(&counters.links[link].faults, TOO_FAR);
    }
    let corner = vec3(x.x, y.x, z.x);
    corners[work.first_corner + index] = vec4(corner, 0);
    for (var axis = 0u; axis < 3u; axis++) {
        atomicMax(&most[axis], u32(corner[axis]) ^ 0x80000000u);
        atomicMax(&most[axis + 3u], u32(-corner[axis]) ^ 0x80000000u);
    }
}
