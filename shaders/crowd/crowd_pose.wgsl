// import common
// import octahedron
// import affine
// The clusters that a view draws, posed: skinning as `rust/crowd/src/skinning.rs`, by blended matrices. Instances of a draw in
// one pose, a run, share its posed vertices. Corners of triangles name such a vertex and an instance.

struct Call {
    agents: u32,
    /// Draws, posed vertices and corners that there is room for.
    draws: u32,
    posed: u32,
    corners: u32,
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
/// 1 where a run begins; then how many begin before.
@group(1) @binding(0) var<storage, read_write> runs: array<u32>;
/// The first instance of each run.
@group(1) @binding(1) var<storage, read_write> run_firsts: array<u32>;
/// How many posed vertices each draw has, then where they begin; the last is their end.
@group(1) @binding(2) var<storage, read_write> posed_starts: array<u32>;
/// The same of corners.
@group(1) @binding(3) var<storage, read_write> corner_starts: array<u32>;
@group(1) @binding(4) var<storage, read_write> posed: array<Posed>;
@group(1) @binding(5) var<storage, read_write> corners: array<vec2<u32>>;
@group(1) @binding(6) var<storage, read_write> arguments: array<u32>;
@group(2) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(2) @binding(1) var<storage, read> cluster_vertices: array<ClusterVertex>;
/// Of vertices of the cluster, three a triangle.
@group(2) @binding(2) var<storage, read> indices: array<u32>;
@group(2) @binding(3) var<storage, read> matrices: array<array<vec4<f32>, 3>>;
@group(2) @binding(4) var<storage, read> weights: array<f32>;
/// Offsets, and the bits of the morph target of each.
@group(2) @binding(5) var<storage, read> offsets: array<vec4<f32>>;
var<immediate> call: Call;

@compute @workgroup_size(GROUP)
fn mark_runs(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_item(group, groups, local);
    if at > call.agents {
        return;
    }
    var begins = false;
    if at < counts[0] {
        begins = at == 0u || instances[at].first_matrix != instances[max(at, 1u) - 1u].first_matrix;
    }
    runs[at] = u32(begins);
}

/// The run of an instance, after sums.
fn run_of(instance: u32) -> u32 {
    return runs[instance + 1u] - 1u;
}

fn cluster_of(draw: u32) -> vec2<u32> {
    return clusters[clusters[drawn[draw].x].x + drawn[draw].y];
}

@compute @workgroup_size(GROUP)
fn count_parts(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_item(group, groups, local);
    if at < counts[0] && runs[at + 1u] != runs[at] {
        run_firsts[runs[at]] = at;
    }
    if at > call.draws {
        return;
    }
    var parts = vec2(0u);
    if at < min(counts[1], call.draws) {
        let count = draws[5u * at + 1u];
        let first = draws[5u * at + 4u];
        let own = run_of(first + count - 1u) - run_of(first) + 1u;
        parts = vec2(own * cluster_of(at).y, draws[5u * at] * count);
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

/// The blended map of the bones of a vertex.
fn blended(vertex: Vertex, first: u32) -> Affine {
    let bones = vec4(vertex.bones & 0xffffu, vertex.bones >> 16u, vertex.more_bones & 0xffffu, vertex.more_bones >> 16u);
    var sum = Affine(vec4(0.0), vec4(0.0), vec4(0.0));
    for (var slot = 0u; slot < 4u; slot++) {
        let weight = vertex.weights[slot];
        if weight > 0.0 {
            let at = first + bones[slot];
            sum.x += weight * matrices[at][0];
            sum.y += weight * matrices[at][1];
            sum.z += weight * matrices[at][2];
        }
    }
    return sum;
}

@compute @workgroup_size(GROUP)
fn pose_vertices(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_item(group, groups, local);
    if at >= min(posed_starts[call.draws], call.posed) {
        return;
    }
    let draw = draw_of(false, at);
    let cluster = cluster_of(draw);
    let own = at - posed_starts[draw];
    let run = run_of(draws[5u * draw + 4u]) + own / cluster.y;
    let found = cluster_vertices[cluster.x + own % cluster.y];
    let vertex = vertices[found.vertex];
    let instance = run_firsts[run];
    let first_weight = instances[instance].first_weight;
    var p = vertex.p;
    for (var offset = vertex.first_offset; offset < vertex.end_offset; offset++) {
        p += weights[first_weight + bitcast<u32>(offsets[offset].w)] * offsets[offset].xyz;
    }
    let map = blended(vertex, instances[instance].first_matrix);
    let normal = octahedral_bits(affine_normal(map, vertex.normal));
    posed[at] = Posed(affine_point(map, p), normal, found.tag, found.corner);
}

@compute @workgroup_size(GROUP)
fn write_corners(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_item(group, groups, local);
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
    let instance = first + own / draws[5u * draw];
    let index = own % draws[5u * draw];
    let rows = instances[instance].transform;
    // A mirror turns triangles over: two of their corners change places.
    var corner = index % 3u;
    if affine_is_mirror(Affine(rows[0], rows[1], rows[2])) {
        corner = (3u - corner) % 3u;
    }
    let vertex = indices[draws[5u * draw + 2u] + index - index % 3u + corner];
    let before = (run_of(instance) - run_of(first)) * cluster_of(draw).y;
    corners[at] = vec2(posed_starts[draw] + before + vertex, instance);
}
