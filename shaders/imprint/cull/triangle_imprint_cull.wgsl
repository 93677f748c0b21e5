// import common
// import halves
// import imprint_meet
// import triangle_imprint_slot
// import triangles
// Which triangles may have points in the voxel grid of an imprint (Schäfer et al. 2014, Section 5, Culling Geometry within
// Overlap): their corners, widened by their displacement along interpolated normals. A triangle has the values of its sides
// and corners in its block too, so that all triangles that share one which the imprint may change are found.

/// Segments of a side.
override SEGMENTS: u32 = 64u;

@group(0) @binding(1) var<storage, read_write> slots: array<u32>;
@group(0) @binding(3) var<storage, read_write> arguments: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> counters: AllCounters;
// The least and the largest displacement in and around every triangle, 0 between them.
@group(2) @binding(0) var<storage, read> ranges: array<vec2<f32>>;
// Triangles that may, in any order.
@group(2) @binding(1) var<storage, read_write> listed: array<u32>;
// The longest vectors in and around every triangle, object units.
@group(2) @binding(2) var<storage, read> lengths: array<f32>;

// The share of its magnitude by which a coordinate may be rounded.
const ROUNDING: f32 = 1e-6;

// Takes on what the imprint before left of a triangle.
fn settle(face: u32) {
    let at = state_of(face);
    slots[at] = select(0u, TAKEN, slots[at] != 0u);
}

// The range of a triangle as imprints of earlier dispatches left it.
fn range_before(face: u32) -> vec2<f32> {
    var range = ranges[face];
    if (work.flags & CHAINED) != 0u {
        let lowered = slots[slot_of(face)];
        if lowered > 0u {
            range.x = min(range.x, value(half_of(-i32(lowered))));
        }
        range.y = max(range.y, value(slots[highest_of(face)]));
    }
    return range;
}

// How far the coordinates of three points, the columns, are from zero along a voxel axis before they are shifted.
fn magnitude(row: vec3<f32>, points: mat3x3<f32>) -> f32 {
    let origin = abs(work.origin);
    let far = abs(row) * mat3x3(abs(points[0]) + origin, abs(points[1]) + origin, abs(points[2]) + origin);
    return max(far.x, max(far.y, far.z));
}

// Where the points of a triangle are along a voxel axis. The mean of its corners' unit normals is nowhere shorter than
// `shortest`, and is made as long as one again. The third number of the range is the length of its vectors.
fn ends_along(row: vec4<f32>, range: vec3<f32>, points: mat3x3<f32>, normals: mat3x3<f32>, shortest: f32) -> vec2<f32> {
    let places = row.xyz * points + row.w;
    let along = row.xyz * normals;
    let far = length(row.xyz);
    let bounded = shortest > 0.3;
    let longest = 1.0 / max(shortest, 0.3);
    let up = select(far, min(max(max(along.x, along.y), max(along.z, 0.0)) * longest, far), bounded);
    let down = select(-far, max(min(min(along.x, along.y), min(along.z, 0.0)) * longest, -far), bounded);
    let reach = vec4(range.x * up, range.x * down, range.y * up, range.y * down);
    let aside = ROUNDING * magnitude(row.xyz, points) + range.z * far;
    let low = min(places.x, min(places.y, places.z)) + min(min(reach.x, reach.y), min(reach.z, reach.w));
    let high = max(places.x, max(places.y, places.z)) + max(max(reach.x, reach.y), max(reach.z, reach.w));
    return vec2(low - aside, high + aside);
}

fn list(face: u32) {
    let at = 8u * step.link + 4u;
    let place = atomicAdd(&arguments[at], 1u);
    listed[place] = face;
    atomicMax(&arguments[at + 1u], min(place + 1u, ROW));
    atomicMax(&arguments[at + 2u], place / ROW + 1u);
    atomicMax(&arguments[at + 3u], PARTS);
    atomicAdd(&counters.links[step.link].tiles, 1u);
    atomicAdd(&counters.links[step.link].tested, value_count(SEGMENTS));
}

@compute @workgroup_size(GROUP)
fn cull_faces(id: Invocation) {
    let face = linear_group(id) * GROUP + id.local;
    take(step.link);
    if face >= work.tiles {
        return;
    }
    if (work.flags & CHAINED) != 0u {
        settle(face);
    }
    let a = mesh_foot(mesh_corner(face, 0u));
    let b = mesh_foot(mesh_corner(face, 1u));
    let c = mesh_foot(mesh_corner(face, 2u));
    let points = mat3x3(a.p - work.origin, b.p - work.origin, c.p - work.origin);
    let normals = mat3x3(a.normal, b.normal, c.normal);
    let between = min(dot(a.normal, b.normal), min(dot(b.normal, c.normal), dot(c.normal, a.normal)));
    let shortest = sqrt(max((1.0 + 2.0 * between) / 3.0, 0.0));
    let range = vec3(range_before(face), lengths[face]);
    let x = ends_along(work.x, range, points, normals, shortest);
    let y = ends_along(work.y, range, points, normals, shortest);
    let z = ends_along(work.z, range, points, normals, shortest);
    if meets(Bounds(vec3(x.x, y.x, z.x), vec3(x.y, y.y, z.y))) {
        list(face);
    }
}
