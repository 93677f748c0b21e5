// import progressive_places
// import progressive_bits
// import falloff
// Handles that move and turn regions, and anchors that hold them (Derzapf, Grund, Guthe 2014, Section 4), at the vertices
// that are there.

struct RegionBlock {
    center: vec3<f32>,
    radius: f32,
    /// Of length 1.
    axis: vec3<f32>,
    angle: f32,
    translation: vec3<f32>,
    falloff: u32,
}

struct EditCall {
    vertices: u32,
    handles: u32,
    anchors: u32,
}

struct Reached {
    vertices: atomic<u32>,
    /// Vertices that would go where there is no number.
    lost: atomic<u32>,
}

@group(3) @binding(0) var<storage, read_write> reached: Reached;
/// Handles, then anchors.
@group(3) @binding(1) var<storage, read> regions: array<RegionBlock>;
/// As `progressive_record.wgsl` has them.
@group(3) @binding(2) var<storage, read_write> touched: array<u32>;
var<immediate> work: EditCall;

fn influence(region: RegionBlock, point: vec3<f32>) -> f32 {
    let r = distance(point, region.center) / region.radius;
    return select(0.0, falloff_share(region.falloff, r * r), r <= 1.0);
}

/// A vector about an axis.
fn turned(vector: vec3<f32>, axis: vec3<f32>, angle: f32) -> vec3<f32> {
    let half_sine = sin(0.5 * angle);
    let around = cross(axis, vector);
    return vector + sin(angle) * around + 2.0 * half_sine * half_sine * cross(axis, around);
}

/// Where a vertex goes, given what influences of handles sum to.
fn moved(place: Place, sum: f32) -> Place {
    var gone = place;
    var free = 1.0;
    for (var k = 0u; k < work.anchors; k++) {
        free *= 1.0 - influence(regions[work.handles + k], place.point);
    }
    let share = free / max(sum, 1.0);
    for (var k = 0u; k < work.handles; k++) {
        let region = regions[k];
        let part = influence(region, place.point) * share;
        let arm = place.point - region.center;
        gone.point += turned(arm, region.axis, region.angle * part) - arm + region.translation * part;
        gone.normal = turned(gone.normal, region.axis, region.angle * part);
    }
    gone.moved = 1u;
    return gone;
}

fn influence_sum(point: vec3<f32>) -> f32 {
    var sum = 0.0;
    for (var k = 0u; k < work.handles; k++) {
        sum += influence(regions[k], point);
    }
    return sum;
}

/// Counts vertices that are reached, and tells their nodes.
@compute @workgroup_size(GROUP)
fn reach(id: Invocation) {
    let node = linear_item(id);
    var is_reached = false;
    if is_shown(node, work.vertices) {
        let place = now(node);
        let sum = influence_sum(place.point);
        is_reached = sum > 0.0;
        // Also where it is no number.
        if is_reached && !(all(abs(moved(place, sum).point) < vec3(3e38))) {
            atomicAdd(&reached.lost, 1u);
        }
    }
    let word = gathered(id.local, is_reached);
    if id.local % 32u == 0u && node / 32u < arrayLength(&touched) / 2u {
        touched[node / 32u] = word;
        atomicAdd(&reached.vertices, countOneBits(word));
    }
}

/// Moves them.
@compute @workgroup_size(GROUP)
fn move_reached(id: Invocation) {
    let node = linear_item(id);
    if is_shown(node, work.vertices) && (touched[node / 32u] >> (node % 32u) & 1u) == 1u {
        let place = now(node);
        set_place(node, moved(place, influence_sum(place.point)));
    }
}
