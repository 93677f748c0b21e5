// import progressive_fit
// Normals and tangents among attributes: where a vertex has moved they go by the map of those around it, as `Directions` of
// rust/lod has them.

struct DirectionsCall {
    vertices: u32,
    /// Numbers of a wedge, and where among them a normal and a tangent begin; `NOTHING` if there is none.
    width: u32,
    normal: u32,
    tangent: u32,
}

@group(0) @binding(3) var<storage, read> homes: array<u32>;
/// As `progressive_write.wgsl` and `progressive_wedges.wgsl` have them.
@group(1) @binding(1) var<storage, read_write> ranks: array<u32>;
@group(1) @binding(2) var<storage, read_write> arguments: array<u32>;
@group(1) @binding(3) var<storage, read_write> indices: array<u32>;
@group(1) @binding(4) var<storage, read_write> list: array<u32>;
@group(1) @binding(5) var<storage, read_write> wedge_values: array<f32>;
/// Of vertices that are drawn, the nodes.
@group(1) @binding(6) var<storage, read_write> nodes: array<u32>;
/// Of vertices that have moved, from where to where in `ring` their corners are.
@group(1) @binding(7) var<storage, read_write> ends: array<vec2<u32>>;
/// Corners of vertices, with `AFTER`.
@group(1) @binding(8) var<storage, read_write> ring: array<u32>;
var<immediate> sizes: DirectionsCall;

/// In place of a number: there is none.
const NOTHING: u32 = 0xffffffffu;
/// How much the map wants to be a turn.
const NEARLY_FREE: f32 = 1e-3;

/// The number of the vertex that is drawn of a leaf.
fn vertex_at(leaf: u32) -> u32 {
    return ranks[leaf / 32u] + countOneBits(there[leaf / 32u] & bits_to(leaf % 32u)) - 1u;
}

/// Tells the nodes of the vertices.
@compute @workgroup_size(GROUP)
fn name_vertices(id: Invocation) {
    let node = linear_item(id);
    if is_shown(node, sizes.vertices) {
        let split = node / 2u;
        let vertex = vertex_at(select(splits[split].vertex, split, node % 2u == 1u));
        nodes[vertex] = node;
        ends[vertex] = vec2(NOTHING);
    }
}

/// The node of the vertex so many corners after one.
fn node_after(corner: u32, steps: u32) -> u32 {
    return nodes[indices[corner - corner % 3u + (corner + steps) % 3u]];
}

fn direction(at: u32) -> vec3<f32> {
    return vec3(wedge_values[at], wedge_values[at + 1u], wedge_values[at + 2u]);
}

fn set_direction(at: u32, vector: vec3<f32>) {
    wedge_values[at] = vector.x;
    wedge_values[at + 1u] = vector.y;
    wedge_values[at + 2u] = vector.z;
}

/// Turns what wedges were built with, which they have.
@compute @workgroup_size(GROUP)
fn turn(id: Invocation) {
    let item = linear_item(id);
    if item >= arguments[6] {
        return;
    }
    let vertex = vertex_at(homes[list[item]]);
    let own = nodes[vertex];
    let place = place_of(own);
    let range = ends[vertex];
    // Wedges of vertices without triangles are not drawn.
    if place.moved == 0u || range.x == NOTHING {
        return;
    }
    let was = built(own);
    var fit = fit_of(array(was, place));
    for (var k = range.x; k < range.y; k++) {
        for (var steps = 1u; steps < 3u; steps++) {
            if (ring[k] & (AFTER << (steps - 1u))) != 0u {
                let other = node_after(ring[k] & (AFTER - 1u), steps);
                meet(&fit, built(other), now(other));
            }
        }
    }
    find_middles(&fit);
    for (var k = range.x; k < range.y; k++) {
        for (var steps = 1u; steps < 3u; steps++) {
            if (ring[k] & (AFTER << (steps - 1u))) != 0u {
                let other = node_after(ring[k] & (AFTER - 1u), steps);
                weigh(&fit, built(other).point, now(other).point, 1.0);
            }
        }
    }
    let map = solved(&fit, NEARLY_FREE).map;
    var normals = array(was.normal, place.normal);
    let first = item * sizes.width;
    if sizes.normal != NOTHING {
        let given = direction(first + sizes.normal);
        let turned = unit_or(transpose(inverted(map)) * given, vec3(0.0));
        set_direction(first + sizes.normal, turned * length(given));
        normals = array(unit_or(given, vec3(0.0)), turned);
    }
    if sizes.tangent != NOTHING {
        let given = direction(first + sizes.tangent);
        let above = dot(given, normals[0]);
        let within = given - normals[0] * above;
        let along = map * within;
        let turned = unit_or(along - normals[1] * dot(along, normals[1]), vec3(0.0));
        set_direction(first + sizes.tangent, turned * length(within) + normals[1] * above);
    }
}
