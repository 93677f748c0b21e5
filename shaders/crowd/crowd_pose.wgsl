// import common
// import octahedron
// import affine
// The clusters that a view draws, posed: skinning as `rust/crowd/src/skinning.rs`, by blended matrices or dual quaternions.
// Instances of a draw in one pose, a run, share its posed vertices. Corners of triangles name such a vertex and an instance. Where
// agents are culled by occlusion there are two passes: what was seen in the last frame, whose vertices the second pass finds posed.

struct Call {
    agents: u32,
    /// Draws, posed vertices and corners that there is room for.
    draws: u32,
    posed: u32,
    corners: u32,
    /// Which instances are drawn: ALL or one of the others.
    which: u32,
    /// 0 or 1.
    pass_number: u32,
}

struct Vertex {
    p: vec3<f32>,
    /// Two bones of 16 bits.
    bones: u32,
    normal: vec3<f32>,
    more_bones: u32,
    weights: vec4<f32>,
    /// The first of its offsets by morph targets, and their end.
    first_offset: u32,
    end_offset: u32,
    padding: vec2<u32>,
}

/// A vertex of a cluster: which of all vertices, and what pictures show of it.
struct ClusterVertex {
    vertex: u32,
    tag: u32,
    corner: u32,
    /// The vertex that it moves to while its cluster is on the way to a coarser one; itself if it stays.
    target_vertex: u32,
}

struct Instance {
    number: u32,
    first_matrix: u32,
    first_weight: u32,
    model: u32,
    transform: array<vec4<f32>, 3>,
}

struct Posed {
    p: vec3<f32>,
    normal: u32,
    tag: u32,
    corner: u32,
}

/// Five words a draw: indices, instances, first index, first vertex of the model, first instance.
@group(0) @binding(0) var<storage, read> draws: array<u32>;
/// Model and cluster of each draw.
@group(0) @binding(1) var<storage, read> drawn: array<vec2<u32>>;
/// Instances in one pose are one after the other.
@group(0) @binding(2) var<storage, read> instances: array<Instance>;
/// Agents in view, and draws.
@group(0) @binding(3) var<storage, read> counts: array<u32>;
/// For each model where its clusters begin in this list, then for each cluster its first vertex and how many it has.
@group(0) @binding(4) var<storage, read> clusters: array<vec2<u32>>;
/// How far the vertices of each draw are on the way to their targets, 0 to 1.
@group(0) @binding(5) var<storage, read> blends: array<f32>;
/// For each agent SEEN if it was in the last frame, and HIDDEN.
@group(0) @binding(6) var<storage, read> states: array<u32>;
/// HIDDEN or 0 for each draw.
@group(0) @binding(7) var<storage, read> draw_states: array<u32>;
/// 1 where a run begins; then how many begin before.
@group(1) @binding(0) var<storage, read_write> runs: array<u32>;
/// 1 for each instance that is drawn; then how many are before.
@group(1) @binding(1) var<storage, read_write> marks: array<u32>;
/// The first instance of each run; then the instances that are drawn; then the fresh runs.
@group(1) @binding(2) var<storage, read_write> lists: array<u32>;
/// 1 for each fresh run, which is drawn and was not in the pass before; then how many are before.
@group(1) @binding(3) var<storage, read_write> fresh: array<u32>;
/// How many vertices this pass poses for each draw, then where they begin; the last is their end.
@group(1) @binding(4) var<storage, read_write> posed_starts: array<u32>;
/// The same of corners that are drawn.
@group(1) @binding(5) var<storage, read_write> corner_starts: array<u32>;
/// The vertices of the first pass, then those of the second.
@group(1) @binding(6) var<storage, read_write> posed: array<Posed>;
@group(1) @binding(7) var<storage, read_write> corners: array<vec2<u32>>;
@group(1) @binding(8) var<storage, read_write> arguments: array<u32>;
/// How many vertices there would be to pose if all instances were drawn.
@group(1) @binding(9) var<storage, read_write> total: atomic<u32>;
@group(2) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(2) @binding(1) var<storage, read> cluster_vertices: array<ClusterVertex>;
/// Of vertices of the cluster, three a triangle.
@group(2) @binding(2) var<storage, read> indices: array<u32>;
/// For each bone of each pose the rows of its matrix; for dual quaternions the rows of its stretch, then the rotation and the
/// dual part.
@group(2) @binding(3) var<storage, read> bones: array<vec4<f32>>;
@group(2) @binding(4) var<storage, read> weights: array<f32>;
/// Offsets, and the bits of the morph target of each.
@group(2) @binding(5) var<storage, read> offsets: array<vec4<f32>>;
/// Those of the pass before; the first pass does not read them.
@group(2) @binding(6) var<storage, read> fresh_before: array<u32>;
@group(2) @binding(7) var<storage, read> posed_before: array<u32>;
var<immediate> call: Call;
/// 1 to blend bones as dual quaternions.
override DUAL: u32 = 0u;
/// Which instances are drawn, as in `crowd_cut.wgsl`, and the states of their agents.
const OCCLUDERS: u32 = 1u;
const VISIBLE: u32 = 2u;
const SEEN: u32 = 1u;
const HIDDEN: u32 = 2u;

fn is_chosen(agent: u32) -> bool {
    switch call.which {
        case OCCLUDERS: { return (states[agent] & SEEN) != 0u; }
        case VISIBLE: { return (states[agent] & HIDDEN) == 0u; }
        default: { return true; }
    }
}

@compute @workgroup_size(GROUP)
fn mark_runs(id: Invocation) {
    let at = linear_item(id);
    if at > call.agents {
        return;
    }
    var begins = false;
    var is_drawn = false;
    if at < counts[0] {
        let before = max(at, 1u) - 1u;
        let is_posed_alike = instances[at].first_matrix == instances[before].first_matrix
            && instances[at].first_weight == instances[before].first_weight;
        begins = at == 0u || !is_posed_alike;
        is_drawn = is_chosen(instances[at].number);
    }
    marks[at] = u32(is_drawn);
    // The second pass has the runs of the first.
    if call.pass_number == 0u {
        runs[at] = u32(begins);
    }
}

/// The run of an instance, after sums.
fn run_of(instance: u32) -> u32 {
    return runs[instance + 1u] - 1u;
}

fn cluster_of(draw: u32) -> vec2<u32> {
    return clusters[clusters[drawn[draw].x].x + drawn[draw].y];
}

/// Begins runs where draws do, so that a run is of one draw's instances.
@compute @workgroup_size(GROUP)
fn split_runs(id: Invocation) {
    let draw = linear_item(id);
    if draw < min(counts[1], call.draws) {
        runs[draws[5u * draw + 4u]] = 1u;
    }
}

/// Lists the first instances of runs, and the instances that are drawn.
@compute @workgroup_size(GROUP)
fn list_runs(id: Invocation) {
    let at = linear_item(id);
    if at >= counts[0] {
        return;
    }
    if runs[at + 1u] != runs[at] {
        lists[runs[at]] = at;
    }
    if marks[at + 1u] != marks[at] {
        lists[call.agents + marks[at]] = at;
    }
}

/// Whether a run has its vertices from the pass before.
fn is_known(run: u32) -> bool {
    return call.pass_number == 1u && fresh_before[run + 1u] != fresh_before[run];
}

/// Marks the runs that are drawn and have no vertices yet.
@compute @workgroup_size(GROUP)
fn mark_fresh(id: Invocation) {
    let run = linear_item(id);
    if run > call.agents {
        return;
    }
    let seen = counts[0];
    let count = runs[seen];
    var is_fresh = false;
    if run < count && !is_known(run) {
        var end = seen;
        if run + 1u < count {
            end = lists[run + 1u];
        }
        is_fresh = marks[end] != marks[lists[run]];
    }
    fresh[run] = u32(is_fresh);
}

@compute @workgroup_size(GROUP)
fn count_parts(id: Invocation) {
    let at = linear_item(id);
    if at < call.agents && fresh[at + 1u] != fresh[at] {
        lists[2u * call.agents + fresh[at]] = at;
    }
    if at > call.draws {
        return;
    }
    var parts = vec2(0u);
    if at < min(counts[1], call.draws) {
        let first = draws[5u * at + 4u];
        let end = first + draws[5u * at + 1u];
        let first_run = run_of(first);
        let end_run = run_of(end - 1u) + 1u;
        let vertices = cluster_of(at).y;
        parts = vec2((fresh[end_run] - fresh[first_run]) * vertices, (marks[end] - marks[first]) * draws[5u * at]);
        if call.pass_number == 0u {
            atomicAdd(&total, (end_run - first_run) * vertices);
        }
        if call.which == VISIBLE && draw_states[at] == HIDDEN {
            parts = vec2(0u);
        }
    }
    posed_starts[at] = parts.x;
    corner_starts[at] = parts.y;
}

/// The draw of a corner, or of a posed vertex: the last that begins there or before.
fn draw_of(is_corner: bool, at: u32) -> u32 {
    var draw = 0u;
    var end = call.draws;
    while draw + 1u < end {
        let middle = (draw + end) / 2u;
        var start = posed_starts[middle];
        if is_corner {
            start = corner_starts[middle];
        }
        if start <= at {
            draw = middle;
        } else {
            end = middle;
        }
    }
    return draw;
}

fn bones_of(vertex: Vertex) -> vec4<u32> {
    return vec4(vertex.bones & 0xffffu, vertex.bones >> 16u, vertex.more_bones & 0xffffu, vertex.more_bones >> 16u);
}

/// The weighted sum of the matrices of a vertex's bones.
fn blended_linear(vertex: Vertex, first: u32) -> Affine {
    let own = bones_of(vertex);
    var sum = Affine(vec4(0.0), vec4(0.0), vec4(0.0));
    for (var slot = 0u; slot < 4u; slot++) {
        let weight = vertex.weights[slot];
        if weight > 0.0 {
            let at = 3u * (first + own[slot]);
            sum.x += weight * bones[at];
            sum.y += weight * bones[at + 1u];
            sum.z += weight * bones[at + 2u];
        }
    }
    return sum;
}

/// The weighted sum of the dual quaternions of a vertex's bones, after that of their stretches (Kavan et al. 2008).
fn blended_dual(vertex: Vertex, first: u32) -> Affine {
    let own = bones_of(vertex);
    // Quaternions of opposite sign are one rotation: all are taken on the side of the strongest bone.
    var strongest = 0u;
    var most = 0.0;
    for (var slot = 0u; slot < 4u; slot++) {
        if vertex.weights[slot] > most {
            most = vertex.weights[slot];
            strongest = slot;
        }
    }
    let pivot = bones[5u * (first + own[strongest]) + 3u];
    var x = vec3(0.0);
    var y = vec3(0.0);
    var z = vec3(0.0);
    var real = vec4(0.0);
    var dual = vec4(0.0);
    for (var slot = 0u; slot < 4u; slot++) {
        let weight = vertex.weights[slot];
        if weight > 0.0 {
            let at = 5u * (first + own[slot]);
            let signed = select(weight, -weight, dot(pivot, bones[at + 3u]) < 0.0);
            x += weight * bones[at].xyz;
            y += weight * bones[at + 1u].xyz;
            z += weight * bones[at + 2u].xyz;
            real += signed * bones[at + 3u];
            dual += signed * bones[at + 4u];
        }
    }
    let length = max(sqrt(dot(real, real)), 1e-37);
    real /= length;
    dual /= length;
    let moved = 2.0 * (real.w * dual.xyz - dual.w * real.xyz + cross(real.xyz, dual.xyz));
    let q = real.xyz;
    let twice = 2.0 * real.w * q;
    let a = vec3(1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * q.x * q.y - twice.z, 2.0 * q.x * q.z + twice.y);
    let b = vec3(2.0 * q.x * q.y + twice.z, 1.0 - 2.0 * (q.x * q.x + q.z * q.z), 2.0 * q.y * q.z - twice.x);
    let c = vec3(2.0 * q.x * q.z - twice.y, 2.0 * q.y * q.z + twice.x, 1.0 - 2.0 * (q.x * q.x + q.y * q.y));
    return Affine(
        vec4(a.x * x + a.y * y + a.z * z, moved.x),
        vec4(b.x * x + b.y * y + b.z * z, moved.y),
        vec4(c.x * x + c.y * y + c.z * z, moved.z),
    );
}

struct Place {
    p: vec3<f32>,
    /// Of length 1, or zero where the model has no normals.
    normal: vec3<f32>,
}

/// A vertex in the pose of an instance.
fn place_of(number: u32, instance: u32) -> Place {
    let vertex = vertices[number];
    let first_weight = instances[instance].first_weight;
    var p = vertex.p;
    for (var offset = vertex.first_offset; offset < vertex.end_offset; offset++) {
        p += weights[first_weight + bitcast<u32>(offsets[offset].w)] * offsets[offset].xyz;
    }
    let first = instances[instance].first_matrix;
    var map: Affine;
    if DUAL == 1u {
        map = blended_dual(vertex, first);
    } else {
        map = blended_linear(vertex, first);
    }
    let normal = affine_normal(map, vertex.normal);
    let length = sqrt(dot(normal, normal));
    return Place(affine_point(map, p), select(vec3(0.0), normal / length, length > 0.0));
}

@compute @workgroup_size(GROUP)
fn pose_vertices(id: Invocation) {
    let at = linear_item(id);
    var before = 0u;
    if call.pass_number == 1u {
        before = min(posed_before[call.draws], call.posed);
    }
    if at >= min(posed_starts[call.draws], call.posed - before) {
        return;
    }
    let draw = draw_of(false, at);
    let cluster = cluster_of(draw);
    let own = at - posed_starts[draw];
    let run = lists[2u * call.agents + fresh[run_of(draws[5u * draw + 4u])] + own / cluster.y];
    let found = cluster_vertices[cluster.x + own % cluster.y];
    let instance = lists[run];
    var place = place_of(found.vertex, instance);
    let blend = blends[draw];
    if blend > 0.0 && found.target_vertex != found.vertex {
        let end = place_of(found.target_vertex, instance);
        place.p += blend * (end.p - place.p);
        place.normal += blend * (end.normal - place.normal);
    }
    posed[before + at] = Posed(place.p, octahedral_bits(place.normal), found.tag, found.corner);
}

@compute @workgroup_size(GROUP)
fn write_corners(id: Invocation) {
    let at = linear_item(id);
    let count = min(corner_starts[call.draws], call.corners);
    if at == 0u {
        arguments[0] = count;
        arguments[1] = 1u;
    }
    if at >= count {
        return;
    }
    let draw = draw_of(true, at);
    let own = at - corner_starts[draw];
    let first = draws[5u * draw + 4u];
    let instance = lists[call.agents + marks[first] + own / draws[5u * draw]];
    let index = own % draws[5u * draw];
    let rows = instances[instance].transform;
    // A mirror turns triangles over: two of their corners change places.
    var corner = index % 3u;
    if affine_is_mirror(Affine(rows[0], rows[1], rows[2])) {
        corner = (3u - corner) % 3u;
    }
    let vertex = indices[draws[5u * draw + 2u] + index - index % 3u + corner];
    let run = run_of(instance);
    let first_run = run_of(first);
    var start = posed_starts[draw] + (fresh[run] - fresh[first_run]) * cluster_of(draw).y;
    if is_known(run) {
        start = posed_before[draw] + (fresh_before[run] - fresh_before[first_run]) * cluster_of(draw).y;
    } else if call.pass_number == 1u {
        start += posed_before[call.draws];
    }
    corners[at] = vec2(start + vertex, instance);
}
