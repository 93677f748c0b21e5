// import common
// The triangles of the clusters that a view draws, posed and placed in the world: skinning as `rust/crowd/src/skinning.rs`, by
// blended matrices. Each draw of `crowd_cut.wgsl` is a workgroup, which writes three corners for every triangle of every
// instance.

struct Call {
    /// Draws that there is room for, and corners.
    draws: u32,
    corners: u32,
    /// 1 if corners have the number of their agent, 0 if they have that of their triangle.
    by_agent: u32,
    padding: u32,
    color: vec3<f32>,
    more_padding: u32,
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

struct Instance {
    agent: u32,
    first_matrix: u32,
    first_weight: u32,
    model: u32,
    transform: array<vec4<f32>, 3>,
}

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
/// A number for each triangle, which false colours show.
@group(0) @binding(2) var<storage, read> tags: array<u32>;
@group(0) @binding(3) var<storage, read> matrices: array<array<vec4<f32>, 3>>;
@group(0) @binding(4) var<storage, read> weights: array<f32>;
/// Offsets, and the bits of the morph target of each.
@group(0) @binding(5) var<storage, read> offsets: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> draws: array<u32>;
@group(0) @binding(7) var<storage, read> instances: array<Instance>;
/// Agents in view, and draws.
@group(0) @binding(8) var<storage, read> counts: array<u32>;
/// Corners of each draw, then where they begin, and the end of the last.
@group(1) @binding(0) var<storage, read_write> starts: array<u32>;
/// Thirteen words a corner: place, normal, colour, lines, number.
@group(1) @binding(1) var<storage, read_write> corners: array<u32>;
@group(1) @binding(2) var<storage, read_write> arguments: array<u32>;
var<immediate> call: Call;

@compute @workgroup_size(GROUP)
fn count_corners(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_item(group, groups, local);
    if at < min(counts[1], call.draws) {
        starts[at] = draws[5u * at] * draws[5u * at + 1u];
    }
}

/// A map by rows.
struct Map {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
}

fn mapped(map: Map, p: vec3<f32>) -> vec3<f32> {
    let at = vec4(p, 1.0);
    return vec3(dot(map.x, at), dot(map.y, at), dot(map.z, at));
}

/// A normal by the inverse transpose up to a factor above 0; cross products exist where the inverse does not.
fn turned(map: Map, normal: vec3<f32>) -> vec3<f32> {
    let x = vec3(map.x.x, map.y.x, map.z.x);
    let y = vec3(map.x.y, map.y.y, map.z.y);
    let z = vec3(map.x.z, map.y.z, map.z.z);
    let made = cross(y, z) * normal.x + cross(z, x) * normal.y + cross(x, y) * normal.z;
    return select(made, -made, dot(x, cross(y, z)) < 0.0);
}

fn is_mirror(map: Map) -> bool {
    return dot(map.x.xyz, cross(map.y.xyz, map.z.xyz)) < 0.0;
}

/// The blended map of the bones of a vertex.
fn blended(vertex: Vertex, first: u32) -> Map {
    let bones = array(vertex.bones & 0xffffu, vertex.bones >> 16u, vertex.more_bones & 0xffffu, vertex.more_bones >> 16u);
    var sum = Map(vec4(0.0), vec4(0.0), vec4(0.0));
    for (var slot = 0u; slot < 4u; slot++) {
        let weight = vertex.weights[slot];
        if weight > 0.0 {
            let rows = matrices[first + bones[slot]];
            sum.x += weight * rows[0];
            sum.y += weight * rows[1];
            sum.z += weight * rows[2];
        }
    }
    return sum;
}

fn write(place: u32, value: vec3<f32>) {
    corners[place] = bitcast<u32>(value.x);
    corners[place + 1u] = bitcast<u32>(value.y);
    corners[place + 2u] = bitcast<u32>(value.z);
}

@compute @workgroup_size(GROUP)
fn pose_corners(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let draw = linear_group(group, groups);
    if draw == 0u && local == 0u {
        arguments[0] = min(starts[call.draws], call.corners);
        arguments[1] = 1u;
    }
    if draw >= min(counts[1], call.draws) {
        return;
    }
    let count = draws[5u * draw];
    let first_index = draws[5u * draw + 2u];
    let base_vertex = draws[5u * draw + 3u];
    let all = count * draws[5u * draw + 1u];
    for (var it = local; it < all; it += GROUP) {
        let place = starts[draw] + it;
        if place >= call.corners {
            return;
        }
        let instance = instances[draws[5u * draw + 4u] + it / count];
        let placed = Map(instance.transform[0], instance.transform[1], instance.transform[2]);
        let own = it % count;
        // A mirror turns triangles over: two of their corners change places.
        var corner = own % 3u;
        if is_mirror(placed) {
            corner = (3u - corner) % 3u;
        }
        let vertex = vertices[base_vertex + indices[first_index + own - own % 3u + corner]];
        var p = vertex.p;
        for (var offset = vertex.first_offset; offset < vertex.end_offset; offset++) {
            let found = offsets[offset];
            p += weights[instance.first_weight + bitcast<u32>(found.w)] * found.xyz;
        }
        let posed = blended(vertex, instance.first_matrix);
        var normal = turned(posed, vertex.normal);
        normal = turned(placed, select(vec3(0.0), normalize(normal), any(normal != vec3(0.0))));
        normal = select(vec3(0.0), normalize(normal), any(normal != vec3(0.0)));
        write(13u * place, mapped(placed, mapped(posed, p)));
        write(13u * place + 3u, normal);
        write(13u * place + 6u, call.color);
        // The line of an edge goes where its coordinate is 0; it is 1/2 at the corner that the edge does not have.
        let away = (own % 3u + 1u) % 3u;
        write(13u * place + 9u, vec3(select(0.0, 0.5, away == 0u), select(0.0, 0.5, away == 1u), select(0.0, 0.5, away == 2u)));
        corners[13u * place + 12u] = select(tags[(first_index + own) / 3u], instance.agent, call.by_agent == 1u);
    }
}
