// A triangle mesh, and the values that its triangles have at the vertices of a tessellation (Schäfer et al. 2015, *Local
// Painting and Deformation of Meshes on the GPU*, Section 6). The same as `pattern` and `displaced` of rust/tiles, which say
// what rings, sides and steps are. What lies on an edge is computed from the edge alone, in its own direction, so that all
// faces along it come to the same bits.

// Points with their normals, six numbers each.
@group(1) @binding(0) var<storage, read> mesh_points: array<f32>;
// How many faces, edges and vertices there are, and 0; the corners of all faces; of their sides twice the edge, and 1 if it
// runs the other way; where the list of every edge begins; lists of 3 · face + side; the same of vertices and corners.
@group(1) @binding(1) var<storage, read> mesh_words: array<u32>;

const TRIANGLE_NONE: u32 = 0xffffffffu;

// A vertex of a tessellation with so many segments along a side, seen from a face.
struct Node {
    ring: u32,
    side: u32,
    step: u32,
}

// The unit normal is zero where there is none.
struct Foot {
    p: vec3<f32>,
    normal: vec3<f32>,
}

// Where numbers of faces are that have a vertex of a tessellation: 3 · face + side or corner.
struct Sharing {
    first: u32,
    count: u32,
}

fn mesh_corner(face: u32, corner: u32) -> u32 {
    return mesh_words[4u + 3u * face + corner];
}

/// Twice the edge of a side, and 1 if it runs the other way.
fn mesh_side(face: u32, side: u32) -> u32 {
    return mesh_words[4u + 3u * mesh_words[0] + 3u * face + side];
}

/// The sides along an edge.
fn mesh_along(edge: u32) -> Sharing {
    let offsets = 4u + 6u * mesh_words[0];
    let items = offsets + mesh_words[1] + 1u;
    let first = mesh_words[offsets + edge];
    return Sharing(items + first, mesh_words[offsets + edge + 1u] - first);
}

/// The corners at a vertex.
fn mesh_around(vertex: u32) -> Sharing {
    let offsets = 5u + 9u * mesh_words[0] + mesh_words[1];
    let items = offsets + mesh_words[2] + 1u;
    let first = mesh_words[offsets + vertex];
    return Sharing(items + first, mesh_words[offsets + vertex + 1u] - first);
}

fn mesh_foot(vertex: u32) -> Foot {
    let at = 6u * vertex;
    return Foot(
        vec3(mesh_points[at], mesh_points[at + 1u], mesh_points[at + 2u]),
        vec3(mesh_points[at + 3u], mesh_points[at + 4u], mesh_points[at + 5u]),
    );
}

/// Values inside a face.
fn inner_count(segments: u32) -> u32 {
    return 3u * segments / 2u * (segments / 2u - 1u) + 1u;
}

/// Values of a face's block: inside, on its three sides from the lower vertex of each edge, at its corners.
fn value_count(segments: u32) -> u32 {
    return inner_count(segments) + 3u * segments;
}

/// The vertex `step` segments along a side of a ring, from 0 to as many as the side has.
fn node_at(segments: u32, ring: u32, side: u32, step: u32) -> Node {
    let whole = segments - 2u * ring;
    if whole == 0u {
        return Node(ring, 0u, 0u);
    }
    if step == whole {
        return Node(ring, (side + 1u) % 3u, 0u);
    }
    return Node(ring, side, step);
}

/// The vertex of value `index` of a face's block.
fn node_of(face: u32, segments: u32, index: u32) -> Node {
    let inner = inner_count(segments);
    let middle = segments / 2u;
    if index == 0u {
        return Node(middle, 0u, 0u);
    }
    if index < inner {
        // The largest half with 3 · half · (half − 1) below the index.
        let square = 1u + 4u * ((index - 1u) / 3u);
        var root = u32(sqrt(f32(square)));
        root -= select(0u, 1u, root * root > square);
        root += select(0u, 1u, (root + 1u) * (root + 1u) <= square);
        let half = (1u + root) / 2u;
        let rest = index - 1u - 3u * half * (half - 1u);
        return node_at(segments, middle - half, rest / (2u * half), rest % (2u * half));
    }
    let corner = index - inner - 3u * (segments - 1u);
    if index >= inner + 3u * (segments - 1u) {
        return Node(0u, corner, 0u);
    }
    let side = (index - inner) / (segments - 1u);
    let step = (index - inner) % (segments - 1u) + 1u;
    return Node(0u, side, select(step, segments - step, (mesh_side(face, side) & 1u) == 1u));
}

/// The value of a vertex in a face's block.
fn value_of(face: u32, segments: u32, node: Node) -> u32 {
    let inner = inner_count(segments);
    if node.ring > 0u {
        let half = segments / 2u - node.ring;
        return select(1u + 3u * half * (half - 1u) + 2u * half * node.side + node.step, 0u, half == 0u);
    }
    if node.step == 0u {
        return inner + 3u * (segments - 1u) + node.side;
    }
    let reversed = (mesh_side(face, node.side) & 1u) == 1u;
    return inner + node.side * (segments - 1u) + select(node.step, segments - node.step, reversed) - 1u;
}

fn unit_or_zero(v: vec3<f32>) -> vec3<f32> {
    let square = dot(v, v);
    return v * select(0.0, 1.0 / sqrt(square), square > 0.0);
}

/// The undisplaced surface at a vertex.
fn foot_of(face: u32, segments: u32, node: Node) -> Foot {
    let whole = f32(segments);
    if node.ring == 0u && node.step == 0u {
        return mesh_foot(mesh_corner(face, node.side));
    }
    if node.ring == 0u {
        let reversed = (mesh_side(face, node.side) & 1u) == 1u;
        let start = mesh_foot(mesh_corner(face, node.side));
        let end = mesh_foot(mesh_corner(face, (node.side + 1u) % 3u));
        let part = f32(select(node.step, segments - node.step, reversed));
        let a_p = select(start.p, end.p, reversed);
        let b_p = select(end.p, start.p, reversed);
        let a_n = select(start.normal, end.normal, reversed);
        let b_n = select(end.normal, start.normal, reversed);
        let p = (a_p * (whole - part) + b_p * part) / whole;
        return Foot(p, unit_or_zero((a_n * (whole - part) + b_n * part) / whole));
    }
    var weights = vec3(f32(2u * node.ring) / (3.0 * whole));
    weights[node.side] = f32(3u * segments - 4u * node.ring - 3u * node.step) / (3.0 * whole);
    weights[(node.side + 1u) % 3u] = f32(2u * node.ring + 3u * node.step) / (3.0 * whole);
    var sum: Foot;
    for (var corner = 0u; corner < 3u; corner++) {
        let at = mesh_foot(mesh_corner(face, corner));
        sum.p += at.p * weights[corner];
        sum.normal += at.normal * weights[corner];
    }
    return Foot(sum.p, unit_or_zero(sum.normal));
}

/// The faces that have a vertex on an edge or at a corner; none of one that is inside.
fn sharing(face: u32, node: Node) -> Sharing {
    if node.ring > 0u {
        return Sharing(0u, 0u);
    }
    if node.step == 0u {
        return mesh_around(mesh_corner(face, node.side));
    }
    return mesh_along(mesh_side(face, node.side) / 2u);
}

/// The vertex as another of the faces that share it sees it, which has it at this side or corner.
fn node_from(face: u32, segments: u32, node: Node, other: u32) -> Node {
    if node.step == 0u {
        return Node(0u, other % 3u, 0u);
    }
    let same = (mesh_side(face, node.side) & 1u) == (mesh_side(other / 3u, other % 3u) & 1u);
    return Node(0u, other % 3u, select(segments - node.step, node.step, same));
}

/// Neighbours of a vertex in one face.
fn ring_count(segments: u32, node: Node) -> u32 {
    if node.ring > 0u {
        return 6u;
    }
    return select(4u, 3u, node.step == 0u || 2u * node.step == segments);
}

/// Neighbour `k` of a vertex in one face.
fn ring_node(segments: u32, node: Node, k: u32) -> Node {
    let r = node.ring;
    let s = node.side;
    let j = node.step;
    let n = segments - 2u * r;
    let previous_side = (s + 2u) % 3u;
    if n == 0u {
        return node_at(segments, r - 1u, k / 2u, k % 2u);
    }
    if k == 0u {
        return node_at(segments, r, s, j + 1u);
    }
    if j == 0u {
        switch k {
            case 1u: {
                return node_at(segments, r + 1u, s, 0u);
            }
            case 2u: {
                return node_at(segments, r, previous_side, n - 1u);
            }
            case 3u: {
                return node_at(segments, r - 1u, previous_side, n + 1u);
            }
            default: {
                return node_at(segments, r - 1u, s, k - 4u);
            }
        }
    }
    // Before, at or after the middle of the side there are two, one and two neighbours on the next ring.
    let at_middle = 2u * j == n;
    let inner = select(j - 1u, j, 2u * j < n);
    let inners = select(2u, 1u, at_middle);
    if k <= inners {
        return node_at(segments, r + 1u, s, inner + 1u - k);
    }
    if k == inners + 1u {
        return node_at(segments, r, s, j - 1u);
    }
    let outer = select(j + 1u, j, 2u * j <= n);
    return node_at(segments, r - 1u, s, outer + k - inners - 2u);
}
